"""`make full`: the screening cases at full scale on the cores there are; what was begun goes on, what is kept is not run again.

Each case is `pywet run` in a process of its own, so that a kill costs at most the time since its last checkpoint. The small
tables of a finished case are stored at once.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import typer

from pywet import config as settings
from pywet.config import Config
from pywet.engines.liggghts.checkpoint import last_step
from pywet.engines.process import die_with_parent
from pywet.errors import PywetError
from pywet.evidence import kept
from pywet.files import one_line
from pywet.history.schema import CONTACT, EVENT
from pywet.screening import cases

ORDER = (2, 11, 1, 10, 3, 12, 5, 14, 4, 13, 6, 15, 7, 16, 8, 17, 9, 18)
MOIST_PRICE = 2.5
"""A moist step over a dry one, until a run of this campaign has been timed (docs/engine.md)."""
EVENTS_PER_SPHERE_S = 50.0
"""Formations and ruptures per sphere and second: 24,460 in 0.12 s of case 2."""
BRIDGES_PER_SPHERE = 2.5
ROW_B = 240.0
"""Bytes of a sphere at an output: trajectory, film, its bridges."""
EVERY_S = 30.0
"""Time between two lines of progress [s]."""


@dataclass
class Job:
    """One case with one seed."""

    number: int
    seed: int
    folder: Path
    name: str
    steps: int
    work: float
    """Sphere-steps, moist ones at MOIST_PRICE."""
    disk_B: float
    process: subprocess.Popen[bytes] | None = None
    begun: tuple[float, int] = (0.0, 0)
    """Time and step at which this process began."""
    failed: str | None = None
    done: bool = False

    @property
    def step(self) -> int:
        """Last step that the engine has shown."""
        if (self.folder / "engine.partial").exists():
            return last_step(self.folder / "engine.partial")
        return self.steps if (self.folder / "engine").exists() else 0


@dataclass
class Campaign:
    """Jobs over `cores` processes."""

    jobs: list[Job]
    data: Path
    command: list[str]
    about: dict[str, str]
    cores: int = 1
    moved: float = field(default=0.0, init=False)
    """Work done and process time taken in this call, from which the time to go follows."""
    spent: float = field(default=0.0, init=False)

    def run(self) -> list[Job]:
        """Run all jobs; returns those that failed."""
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
        with open(job.folder / "campaign.log", "ab") as log:
            job.process = subprocess.Popen(command, stdout=log, stderr=log, preexec_fn=die_with_parent)
        return job

    def _end(self, job: Job) -> None:
        assert job.process is not None
        log = (job.folder / "campaign.log").read_text(errors="replace").strip().splitlines()
        if job.process.returncode != 0:
            job.failed = one_line(log[-1] if log else f"exit code {job.process.returncode}")
        else:
            try:
                kept.keep(job.folder, self.data, job.name, {"case": job.number, **self.about})
                job.done = True
            except PywetError as error:
                job.failed = str(error)
        print(f"{job.name}: {job.failed or f'kept in {self.data / job.name}'}", flush=True)

    def _say(self, waiting: Sequence[Job], running: Sequence[Job]) -> None:
        moved, spent = 0.0, 0.0
        for job in running:
            moved += job.work * (job.step - job.begun[1]) / job.steps
            spent += time.monotonic() - job.begun[0]
        left = sum(j.work for j in waiting) + sum(j.work * (1.0 - j.step / j.steps) for j in running)
        for job in running:
            print(f"{job.name}: {100.0 * job.step / job.steps:5.1f} %", flush=True)
        if moved > 0.0:
            hours = left * spent / moved / self.cores / 3600.0
            print(f"{len(waiting)} cases wait; about {hours:.1f} h to go", flush=True)


def plan_job(config: Config, number: int, seed: int, scale: str, out: Path, name: str) -> Job:
    """What a case will ask for, from its configuration alone."""
    made = cases.ingredients(config, number, scale)
    size = config.scale(scale)
    spheres, duration = sum(c.count for c in made.classes), size.duration_s.value
    moist, windows = made.plan.effects.bridges, config.settings.output
    steps = round(duration / made.time_step_s)
    disk = spheres * ROW_B * duration / size.output_interval_s.value
    if moist:
        disk += spheres * duration * EVENTS_PER_SPHERE_S * EVENT.itemsize
        contacts = windows.contact_windows * windows.contact_window_steps * spheres * BRIDGES_PER_SPHERE
        disk += contacts * CONTACT.itemsize
    return Job(number, seed, out / name, name, steps, spheres * steps * (MOIST_PRICE if moist else 1.0), disk)


def prepare(
    config: Config, wanted: Sequence[int], seeds: Sequence[int], scale: str, out: Path, variant: str
) -> list[Job]:
    """The jobs of a campaign: all cases with the first seed, then with the others."""
    tail = f"-{variant}" if variant else ""
    name = "{case}{tail}-{seed}"
    return [
        plan_job(config, n, seed, scale, out, name.format(case=config.case(n).name, tail=tail, seed=seed))
        for seed in seeds
        for n in wanted
    ]


def main(
    cores: Annotated[int, typer.Option(min=1, help="Cases at a time.")] = 1,
    case: Annotated[list[int] | None, typer.Option("--case", help="Only this case; may be repeated.")] = None,
    seed: Annotated[list[int] | None, typer.Option("--seed", help="Seeds; default that of config.yaml.")] = None,
    scale: Annotated[str, typer.Option(help="Scale of scales.yaml.")] = "full",
    variant: Annotated[str, typer.Option(help="Name of the settings where they are not the campaign's.")] = "",
    config_dir: Annotated[Path, typer.Option("--config", help="Folder of the configuration.")] = Path("config"),
    out: Annotated[Path, typer.Option(help="Folder of the runs.")] = Path("results/full_scale"),
    data: Annotated[Path, typer.Option(help="Folder of what is kept.")] = Path("docs/full_scale/data"),
) -> None:
    """Run the screening cases at full scale, keep their tables, and say how long and how much disk it takes."""
    config = settings.load(config_dir)
    wanted = case or [n for n in ORDER if n in config.cases]
    jobs = prepare(config, wanted, seed or [config.settings.seed], scale, out, variant)
    for job in jobs:
        job.done = (data / job.name / "run.json").exists()
    todo = [j for j in jobs if not j.done]
    print(f"{len(jobs) - len(todo)} of {len(jobs)} runs are kept; the others take {sum(j.disk_B for j in todo) / 1e9:.1f} GB "
          f"of disk, the largest {max((j.disk_B for j in todo), default=0.0) / 1e9:.1f} GB", flush=True)  # fmt: skip
    command = [sys.executable, "-P", "-m", "pywet.cli", "run", "--scale", scale, "--config", str(config_dir)]
    about = {"variant": variant, "scale": scale, "commit": _commit()}
    failed = Campaign(jobs, data, command, about, cores).run()
    for job in failed:
        print(f"{job.name} failed: {job.failed}", file=sys.stderr)
    raise typer.Exit(1 if failed else 0)


def _commit() -> str:
    """State of the checkout the runs came from; empty outside one."""
    found = subprocess.run(["git", "describe", "--always", "--dirty"], capture_output=True, text=True, check=False)
    return found.stdout.strip()


if __name__ == "__main__":
    typer.run(main)
