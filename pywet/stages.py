"""The stages of one case, from configuration to results, and the status file that each writes into the run directory.

A stage that fails writes the reason into its status file and does not raise; later stages repeat it. One failed case
therefore never stops the others, and the report can name it. The command line and the workflow's scripts use these
stages.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pywet import run_folder
from pywet.cases.screening import verdict
from pywet.engines.choice import chosen
from pywet.errors import PywetError
from pywet.runs import record
from pywet.runs.record import NEEDS, Status, attempt
from pywet.util.file_list import remove
from pywet.util.notices import shown

if TYPE_CHECKING:
    from pywet.config import Config


@contextmanager
def logged(path: Path, echo: bool = False) -> Iterator[None]:
    """Send notices and other printed output to a log file; with `echo` also to standard error at the end."""
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        with open(path, "w", buffering=1) as log, redirect_stdout(log), redirect_stderr(log), shown():
            yield
    finally:
        if echo:
            sys.stderr.write(path.read_text())


def resolved(
    config_dir: Path, preset: str | None = None, engine: str = "liggghts", seed: int | None = None, trust: bool = False
) -> Config:
    """Return the configuration for a run: `preset` replaces its laws, `seed` its seed; `trust`: see `load`.

    Rolling resistance and retirement are off for an engine that does not support the scene's form of them.
    """
    from pywet import config

    loaded = config.load(config_dir, trust)
    loaded = loaded if seed is None else loaded.with_seed(seed)
    if not chosen(engine).rolling:
        loaded = loaded.without_rolling()
    if not chosen(engine).retires:
        loaded = loaded.without_retirement()
    return loaded if preset is None else loaded.with_preset(preset)


def carry_out(
    config: Config,
    case: int,
    scale: str,
    run_dir: Path,
    engine: str = "liggghts",
    ranks: int = 1,
    say: Callable[[str], object] | None = None,
) -> Status | None:
    """Run the stages of a case that its locked folder lacks; return the status of one that failed, which ends the run.

    A finished run lacks none, the replay if user reference implementations have changed, or results and replay if the code
    that evaluates it has. `say` is given sentences on what is run and how long it takes; without it the engine displays
    no progress either.
    """
    tell = say or (lambda sentence: None)
    work = {
        "scene": lambda: build(config, case, scale, run_dir, engine),
        "simulate": lambda: simulate(run_dir, ranks, say is not None, engine),
        "results": lambda: results(run_dir),
        "replay": lambda: replay(run_dir),
    }
    if same_run(config, case, scale, run_dir, engine):
        tell(f"{run_dir} holds this very run: nothing it depends on has changed")
        if not record.evaluated_by_this_code(run_dir):
            tell("except the code that evaluates it: it is evaluated and replayed again")
            work = {stage: work[stage] for stage in ("results", "replay")}
        elif not record.same_reference(run_dir, config.settings.laws.reference):
            tell("except user reference implementations: it is replayed again")
            work = {"replay": work["replay"]}
        else:
            return None
        record.leave_reference(run_dir, config.settings.laws.reference)
    for stage in work:
        if stage == "simulate" and engine == "liggghts" and say:
            _advise(config, case, scale, say)
        status = attempt(run_dir, stage, work[stage], aloud=False)
        if not status.ok:
            return status
    return None


def _advise(config: Config, case: int, scale: str, say: Callable[[str], object]) -> None:
    """Say the predicted time of a run, if this machine has been measured, and how its time step would be longer."""
    from pywet.cases.screening import cases
    from pywet.cost import command

    if time := command.predicted(config, case, scale):
        say(f"{config.case(case).name} at scale {scale}: {time}")
    if step := cases.shorter_step(config, case, scale):
        say(step)


def build(config: Config, case: int, scale: str, run_dir: Path, engine: str = "liggghts") -> None:
    """Run the stage scene: configuration -> run directory, from which another run is moved aside."""
    from pywet.cases.screening import cases

    seedless = fingerprint(config.with_seed(record.ANY_SEED), case, scale, engine)
    begin = partial(record.begin, run_dir, fingerprint(config, case, scale, engine), seedless)
    with run_folder.hold(run_dir):
        cases.build(config, case, scale, run_dir, begin)
        record.leave_reference(run_dir, config.settings.laws.reference)


def same_run(config: Config, case: int, scale: str, run_dir: Path, engine: str = "liggghts") -> bool:
    """Return whether a folder contains the finished, replayed run of this case: same scene, laws, plugin and engine."""
    return record.finished(run_dir) and record.left_identity(run_dir) == fingerprint(config, case, scale, engine)


def fingerprint(config: Config, case: int, scale: str, engine: str = "liggghts") -> str:
    """Return the content of identity.json for a run of this case."""
    from pywet.cases.screening import identity

    return f"{engine} {identity.identity(config, case, scale)}"


def simulate(
    run_dir: Path,
    ranks: int,
    progress: bool,
    engine: str = "liggghts",
    mpi: str = "",
    extend: Callable[..., object] | None = None,
) -> None:
    """Run the stage simulate, the engine; `mpi` is the command that starts its ranks in place of mpirun, `srun --mpi=pmix`.

    `extend` decides after each block of a run whether it continues.
    """
    chosen(engine, ranks).start(run_dir, ranks, progress, mpi, extend)


def replay(run_dir: Path) -> dict[str, Any] | None:
    """Run the stage replay: recompute a run by the reference, write replay.json, and compare its shares with the effect plan.

    A dry run without recorded motion in windows has nothing to replay (None); its completeness is still checked. A refusal
    is stored in the status of the stage, of which user-defined scenes have no other.
    """
    folder = Path(run_dir)
    try:
        replayed = _replayed(folder)
    except PywetError as error:
        record.leave_replay(folder, str(error))
        raise
    record.leave_replay(folder, None)
    return replayed


def _replayed(folder: Path) -> dict[str, Any] | None:
    """Replay a run; raises if it is refused."""
    from pywet.planning import audit
    from reference_impl.replay import command, whole
    from reference_impl.replay.io import ReplayError
    from reference_impl.replay.replay import replay as recompute

    command.forget(folder)
    try:
        if command.nothing_to_replay(folder):
            whole.check(folder)
            return None
        replayed: dict[str, Any] = recompute(folder, functions=record.reference(folder))
    except ReplayError as error:
        raise PywetError(str(error), code="replay.refused", where=folder) from error
    audit.write(folder)
    return replayed


def results(run_dir: Path) -> None:
    """Run the stage results: fraction retained, liquid by reservoir, checks, summary, results of the screen."""
    from pywet.cases.screening.results import summarise, write_results
    from pywet.products import screening_report
    from pywet.runs.rundir import RunDir

    run = RunDir(Path(run_dir))
    summarise(run, write_results(run))
    if run.scene.slide is not None:
        screening_report.write(run.path)


def vtk(run_dir: Path, paraview: bool = False) -> None:
    """Run the stage vtk: time series, read by the reference and compared with the logs; `paraview`: also cuboids and a script."""
    from pywet.report import vtk as series
    from reference_impl.shown import vtk as shown

    with run_folder.hold(run_dir, shared=True), run_folder.hold_part(run_dir, "vtk"):
        series.write(run_dir, with_cuboids=paraview)
        _read_back([], shown.disagreement, run_dir)
    if paraview:
        from pywet.report import paraview as opening

        opening.write(run_dir)


def ovito(run_dir: Path) -> list[Path]:
    """Write the files for OVITO, which the reference reads back and compares with the logs."""
    from pywet.report import ovito as dumps
    from reference_impl.shown import ovito as shown

    return _read_back(dumps.write(run_dir), shown.disagreement, run_dir)


def vtkhdf(run_dir: Path) -> list[Path]:
    """Write the VTKHDF files, which the reference reads back and compares with the logs."""
    from pywet.report import vtkhdf as temporal
    from reference_impl.shown import vtkhdf as shown

    return _read_back(temporal.write(run_dir), shown.disagreement, run_dir)


def _read_back(paths: list[Path], disagreement: Callable[[Path], str | None], run_dir: Path) -> list[Path]:
    from reference_impl.replay.io import ReplayError

    try:
        wrong = disagreement(Path(run_dir))
    except ReplayError as error:
        raise PywetError(str(error), code="shown.refused", where=run_dir) from error
    if wrong:
        raise PywetError(wrong, code="shown.differs", where=run_dir)
    return paths


def first_moist(run_dirs: Iterable[Path]) -> Path | None:
    """Return the first run with bridges that has results."""
    from pywet.runs.rundir import RunDir

    for run_dir in run_dirs:
        if Status.read(run_dir, "results").ok and RunDir(run_dir).moist:
            return run_dir
    return None


def judge(run_dirs: Iterable[Path]) -> list[str]:
    """Return all problems of all cases, one line each; failed stages lose their status, so that the next call repeats them."""
    lines = []
    for run_dir in run_dirs:
        lines += [f"{run_dir.name}: {text}" for text in verdict.problems(run_dir)]
        failed = [stage for stage in NEEDS if not Status.read(run_dir, stage).ok]
        remove(run_dir, *map(record.STATUS.format, failed))
    return lines
