"""The stages of one case, from configuration to results, and the status file that each writes into the run directory.

A stage that fails writes the reason into its status file and does not raise; later stages repeat it. One failed case
therefore never stops the others, and the report can name it. The command line and the workflow's scripts use these
stages.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pywet import run_folder
from pywet.cases.screening.status import EVALUATIONS, NEEDS, Status, missing, problems, results_made, status_path
from pywet.engines.choice import chosen
from pywet.errors import PywetError, one_line, refused
from pywet.util.files import write_json
from pywet.util.notices import notice, shown

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


def attempt(run_dir: Path, stage: str, work: Callable[[], Any], aloud: bool = True) -> Status:
    """Run a stage if the one that it requires succeeded; write and return its status.

    An unexpected exception, a fault of pywet, is in the status as well; with `aloud` its traceback and the reason
    of the failure are printed as notices, otherwise it is raised.
    """
    with run_folder.hold(run_dir, shared=stage in EVALUATIONS):
        return _attempt(run_dir, stage, work, aloud)


def _attempt(run_dir: Path, stage: str, work: Callable[[], Any], aloud: bool) -> Status:
    needed = NEEDS[stage]
    earlier = Status.read(status_path(run_dir, needed)) if needed else None
    started, fault = time.monotonic(), None
    if earlier is not None and not earlier.ok:
        status = Status(stage, False, 0.0, earlier.failed_at, earlier.reason, earlier.code)
    else:
        (reason, code), fault = _run(work)
        failed_at = None if reason is None else stage
        status = Status(stage, reason is None, time.monotonic() - started, failed_at, reason, code)
    run_folder.check_held(run_dir)
    write_json(status_path(run_dir, stage), asdict(status))
    if fault is not None and not aloud:
        raise fault
    if fault is not None:
        notice.error("a fault in the program", exc_info=fault)
    if not status.ok and aloud:
        notice.error(f"{Path(run_dir).name}: stage {status.failed_at} failed: {status.reason}")
    return status


def _run(work: Callable[[], Any]) -> tuple[tuple[str | None, str | None], Exception | None]:
    """Run the work; return the reason of a failure in one sentence with its code, and the exception if it is a fault of pywet."""
    try:
        work()
    except PywetError as error:
        return (str(error), error.code), None
    except OSError as error:
        return (refused(error), None), None
    except Exception as error:
        sentence = f"fault in the program, {type(error).__name__}: {one_line(error)} (traceback in the log)"
        return (sentence, None), error
    return (None, None), None


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


def build(config: Config, case: int, scale: str, run_dir: Path, engine: str = "liggghts") -> None:
    """Run the stage scene: configuration -> run directory."""
    from pywet.cases.screening import cases, identity
    from pywet.runs import second

    cases.build(config, case, scale, run_dir)
    second.leave(run_dir, config.settings.laws.reference)
    identity.leave(run_dir, fingerprint(config, case, scale, engine))


def same_run(config: Config, case: int, scale: str, run_dir: Path, engine: str = "liggghts") -> bool:
    """Return whether a folder contains the finished, replayed run of this case: same scene, laws, plugin and engine."""
    from pywet.cases.screening import identity

    if missing(run_dir):
        return False
    left = [status_path(run_dir, stage) for stage in ("simulate", "replay", "results")]
    if not all(path.exists() and Status.read(path).ok for path in left):
        return False
    return identity.left(run_dir) == fingerprint(config, case, scale, engine)


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

    A dry run without recorded motion in windows has nothing to replay (None); its completeness is still checked.
    """
    from pywet.planning import audit
    from pywet.runs import second
    from reference_impl.replay import command, whole
    from reference_impl.replay.io import ReplayError
    from reference_impl.replay.replay import replay as recompute

    folder = Path(run_dir)
    command.forget(folder)
    try:
        if command.nothing_to_replay(folder):
            whole.check(folder)
            return None
        replayed: dict[str, Any] = recompute(folder, functions=second.of_run(folder))
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
        if results_made(run_dir) and RunDir(run_dir).moist:
            return run_dir
    return None


def judge(run_dirs: Iterable[Path]) -> list[str]:
    """Return all problems of all cases, one line each; failed stages lose their status, so that the next call repeats them."""
    lines = []
    for run_dir in run_dirs:
        lines += [f"{run_dir.name}: {text}" for text in problems(run_dir)]
        for path in (status_path(run_dir, stage) for stage in NEEDS):
            if path.exists() and not Status.read(path).ok:
                run_folder.remove(run_dir, f"status/{path.name}")
    return lines
