"""`make full`: screening cases at full scale that are not stored, on the available cores; unfinished runs resume.

Each case is `pywet run` in a separate process, so that a kill costs at most the time since its last checkpoint. The
small tables of a finished case are stored at once.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, BinaryIO

import typer

from pywet import config as settings
from pywet import run_folder
from pywet.config import Config
from pywet.cost import edit
from pywet.cost.command import calibrated
from pywet.cost.cost import Coefficients
from pywet.cost.edit import Level
from pywet.cost.needs import Need, need
from pywet.ending import die_with_parent
from pywet.engines.liggghts.checkpoint import last_step
from pywet.errors import PywetError, border, one_line
from pywet.runs.summary import commit
from studies.full_scale import stored_runs
from studies.full_scale.judging import fingerprint
from studies.full_scale.statements import STATEMENTS

ORDER = (2, 11, 1, 10, 3, 12, 5, 14, 4, 13, 6, 15, 7, 16, 8, 17, 9, 18)
SETTINGS: dict[float, dict[str, Level]] = {
    8.0: {"fraction": 0.1, "stiffness": 0.1},
    5.6: {"fraction": 0.1, "stiffness": 0.03},
}
"""Aperture [mm] -> settings of the campaign, unless a variant is named.

With 5.6 mm there are four times as many spheres, with lower stiffness; docs/full_scale.md gives the reasons.
"""
BELIEVED_S = 600.0
"""Predicted time [s] that must be done until measured and predicted pace have equal weight for the remaining time."""
EVERY_S = 30.0
"""Time between two progress messages [s]."""


@dataclass
class Job:
    """Run of one case with one seed, with its predicted cost."""

    number: int
    seed: int
    folder: Path
    name: str
    need: Need
    """Predicted needs on this machine."""
    config: Path
    """Folder of its configuration."""
    settings: dict[str, float]
    """Configured settings that determine cost and error."""
    ranks: int = 1
    """Configured MPI ranks."""
    process: subprocess.Popen[bytes] | None = None
    log: BinaryIO | None = None
    """Open log of the process: the run may move its folder aside, and this file with it."""
    begun: tuple[float, int] = (0.0, 0)
    """Time and step at which this process began."""
    failed: str | None = None
    done: bool = False

    @property
    def steps(self) -> int:
        """Number of time steps of the whole run."""
        return round(self.need.load.steps)

    @property
    def step(self) -> int:
        """Return the last step in the engine's messages."""
        if (self.folder / "engine.partial").exists():
            return last_step(self.folder / "engine.partial")
        return self.steps if (self.folder / "engine").exists() else 0


@dataclass
class Campaign:
    """Execution of jobs in at most `cores` processes."""

    jobs: list[Job]
    data: Path
    command: list[str]
    about: dict[str, str]
    cores: int = 1

    def run(self) -> list[Job]:
        """Run all jobs and return those that failed."""
        waiting, shown = [j for j in self.jobs if not j.done], 0.0
        running: list[Job] = []
        while waiting or running:
            while waiting and len(running) < self.cores:
                running.append(self._start(waiting.pop(0)))
            time.sleep(0.5)
            for job in [j for j in running if j.process is not None and j.process.poll() is not None]:
                running.remove(job)
                self._end(job)
            if time.monotonic() - shown > EVERY_S:
                shown = time.monotonic()
                self._say(waiting, running)
        return [j for j in self.jobs if j.failed]

    def _start(self, job: Job) -> Job:
        job.folder.mkdir(parents=True, exist_ok=True)
        job.begun = time.monotonic(), job.step
        command = [*self.command, str(job.number), "--seed", str(job.seed), "--out", str(job.folder)]
        command += ["--config", str(job.config), "--ranks", str(job.ranks)]
        run_folder.claim(job.folder)
        job.log = open(job.folder / "campaign.log", "a+b")  # noqa: SIM115  closed as the process ends
        job.process = subprocess.Popen(command, stdout=job.log, stderr=job.log, preexec_fn=die_with_parent)
        return job

    def _end(self, job: Job) -> None:
        assert job.process is not None and job.log is not None
        with job.log:
            job.log.seek(0)
            log = job.log.read().decode(errors="replace").strip().splitlines()
        if job.process.returncode != 0:
            job.failed = one_line(log[-1] if log else f"exit code {job.process.returncode}")
        else:
            try:
                stored_runs.keep(
                    job.folder,
                    self.data,
                    job.name,
                    {"case": job.number, "settings": job.settings, "statements": fingerprint(STATEMENTS), **self.about},
                )
                job.done = True
            except PywetError as error:
                job.failed = str(error)
        typer.echo(f"{job.name}: {job.failed or f'stored in {self.data / job.name}'}")

    def _say(self, waiting: Sequence[Job], running: Sequence[Job]) -> None:
        for job in running:
            typer.echo(f"{job.name}: {100.0 * job.step / job.steps:5.1f} %")
        typer.echo(f"{len(waiting)} cases wait; about {self.to_go(waiting, running) / 3600.0:.1f} h to go")

    def to_go(self, waiting: Sequence[Job], running: Sequence[Job]) -> float:
        """Return the remaining time [s]: the prediction at the pace of the work done in this call."""
        moved = sum(j.need.seconds * (j.step - j.begun[1]) / j.steps for j in running) + BELIEVED_S
        spent = sum(time.monotonic() - j.begun[0] for j in running) + BELIEVED_S
        left = [j.need.seconds for j in waiting] + [j.need.seconds * (1.0 - j.step / j.steps) for j in running]
        return max([sum(left) / self.cores, *left]) * spent / moved


def prepare(
    configs: Mapping[int, Config], seeds: Sequence[int], scale: str, out: Path, variant: str, machine: Coefficients
) -> list[Job]:
    """Return the jobs of a campaign, each case with its configuration: all with the first seed, then with the others."""
    jobs = []
    for seed in seeds:
        for number, config in configs.items():
            name = f"{config.case(number).name}{f'-{variant}' if variant else ''}-{seed}"
            step = config.settings.time_step
            chosen = {
                "fraction": step.fraction.value,
                "stiffness": config.scale(scale).stiffness_factor.value,
                "bridges_every": step.bridges_every,
            }
            needed = need(config, number, scale, machine=machine)
            jobs.append(Job(number, seed, out / name, name, needed, config.folder, chosen, config.settings.ranks))
    return jobs


def table(jobs: Sequence[Job]) -> list[str]:
    """Return the resources that each case requires as lines of a table."""
    needed = [j.need for j in jobs]
    lines = ["case    spheres    steps [1e6]    lists    bridges    processor time [h]    disk [GB]"]
    for j, n in zip(jobs, needed, strict=True):
        lines.append(f"{j.number:4d}{n.load.spheres:11.0f}{1e-6 * n.load.steps:15.2f}{n.load.lists:9.0f}{n.load.bridges:11.0f}"
                     f"{n.seconds / 3600.0:22.2f}{1e-9 * n.disk_B:13.2f}")  # fmt: skip
    total = sum(n.seconds for n in needed) / 3600.0, 1e-9 * sum(n.disk_B for n in needed)
    return [*lines, f" all{total[0]:68.1f}{total[1]:13.1f}"]


def main(
    cores: Annotated[int, typer.Option(min=1, help="Cases at a time.")] = 1,
    case: Annotated[list[int] | None, typer.Option("--case", help="Only this case; may be repeated.")] = None,
    seed: Annotated[list[int] | None, typer.Option("--seed", help="Seeds; default that of config.yaml.")] = None,
    scale: Annotated[str, typer.Option(help="Scale of scales.yaml.")] = "full",
    variant: Annotated[str, typer.Option(help="A name for the settings of --config as they are, such as paper.")] = "",
    config_dir: Annotated[Path, typer.Option("--config", help="Folder of the configuration.")] = Path("config"),
    out: Annotated[Path, typer.Option(help="Folder of the runs.")] = Path("results/full_scale"),
    data: Annotated[Path, typer.Option(help="Folder of the stored data.")] = Path("docs/full_scale/data"),
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Only say what each case will take.")] = False,
) -> None:
    """Run the screening cases at full scale, store their tables, and report time and disk space."""
    config = settings.load(config_dir)
    configs = dict.fromkeys(case or [n for n in ORDER if n in config.cases], config)
    if scale == "full" and not variant:
        configs = turned(config, configs, out)
    jobs = prepare(configs, seed or [config.settings.seed], scale, out, variant, calibrated())
    for job in jobs:
        job.done = (data / job.name / "run.json").exists()
    disk = [1e-9 * j.need.disk_B for j in jobs if not j.done]
    typer.echo(f"{len(jobs) - len(disk)} of {len(jobs)} runs are stored; the others take {sum(disk):.1f} GB "
          f"of disk, the largest {max(disk, default=0.0):.1f} GB and, while it is made, three times "
          "as much")  # fmt: skip
    if dry_run:
        typer.echo("\n".join(table(jobs)))
        return
    command = [sys.executable, "-P", "-m", "pywet.cli.app", "run", "--scale", scale]
    about = {"variant": variant, "scale": scale, "commit": commit(), "readings": "; ".join(config.readings)}
    failed = Campaign(jobs, data, command, about, cores).run()
    for job in failed:
        typer.echo(f"{job.name} failed: {job.failed}", err=True)
    raise typer.Exit(1 if failed else 0)


def write_again(
    source: Path, target: Path, scale: str, levels: edit.Levels, more: Mapping[str, Any] | None = None
) -> None:
    """Rewrite a configuration over the copies of an earlier call; a folder with any other file is refused."""
    if not target.is_dir() or {path.name for path in target.iterdir()} - set(settings.FILES):
        edit.new_folder(target)
    for name in settings.FILES:
        (target / name).unlink(missing_ok=True)
    edit.write(source, target, scale, levels)
    edit.put_into(target, more or {})


def turned(config: Config, wanted: Iterable[int], out: Path) -> dict[int, Config]:
    """Return for each case the configuration with the changes for its aperture; the copies are next to the runs."""
    made: dict[float, Config] = {}
    for aperture in {config.case(n).aperture_mm for n in wanted}:
        target = out / f"settings-{aperture:g}mm"
        write_again(config.folder, target, "full", SETTINGS.get(aperture, {}))
        made[aperture] = settings.load(target)
    return {n: made[config.case(n).aperture_mm] for n in wanted}


if __name__ == "__main__":
    with border():
        typer.run(main)
