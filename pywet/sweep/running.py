"""Run the missing points of a sweep on several cores; after a kill the next call completes the rest."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from pathlib import Path

from pywet import run_folder
from pywet.ending import die_with_parent
from pywet.errors import PywetError, one_line, refused
from pywet.sweep import costs
from pywet.sweep.base_kind import Kind
from pywet.sweep.plan import Plan, Run, at_a_time
from pywet.sweep.store import Store
from pywet.util.notices import notice

Report = Callable[..., None]


def do(kind: Kind, run: Run, store: Store, ranks: int | None = None) -> bool:
    """Run a point unless it is in the store, and return whether it has results; the reason for a failure is in its folder.

    A folder in use by another call is skipped with a notice. `ranks`: MPI ranks, if not those of the base.
    """
    name, folder = run.built.name, store.place(run.built.name)
    if store.numbers(name, kind.engine) is not None:
        return True
    if not kind.engine:
        return _attempt(kind, run, store, folder, ranks)
    with ExitStack() as held:
        try:
            held.enter_context(run_folder.hold(folder))
        except PywetError as busy:
            notice.warning(str(busy))
            return False
        return _attempt(kind, run, store, folder, ranks)


def _attempt(kind: Kind, run: Run, store: Store, folder: Path, ranks: int | None) -> bool:
    before, resumed = costs.used_s(), (folder / "scene.json").exists()
    try:
        numbers = kind.run(run.built, folder, kind.ranks if ranks is None else ranks)
    except PywetError as error:
        store.fail(run.built.name, str(error))
    except OSError as error:
        store.fail(run.built.name, refused(error))
    except Exception as error:  # an internal error at one point does not stop the others
        store.fail(run.built.name, f"fault in the program, {type(error).__name__}: {one_line(error)}")
    else:
        if kind.engine and not resumed:  # the time of an earlier call is not known
            store.note(run.built.name, costs.used_s() - before)
        store.leave(run.built.name, numbers)
        return True
    return False


def carry_out(
    plan: Plan, runs: Sequence[Run], cores: int = 1, ranks: int | None = None, report: Report = lambda done, of: None
) -> None:
    """Execute runs, on several cores in child processes that end with this one; a failed point does not stop others."""
    together, _ = at_a_time(plan.kind, len(runs), cores, ranks)
    if together == 1:
        for k, run in enumerate(runs):
            report(k, len(runs))
            do(plan.kind, run, plan.store, ranks)
        return
    spawning = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(together, spawning, _begin, (os.getpid(),)) as pool:
        jobs = [pool.submit(do, plan.kind, run, plan.store, ranks) for run in runs]
        try:
            for k, job in enumerate(as_completed(jobs)):
                job.result()
                report(k + 1, len(runs))
        except BrokenProcessPool as error:
            raise PywetError(
                "a process of the sweep was killed from outside, perhaps for lack of memory; call again, with fewer --cores",
                code="sweep.killed",
            ) from error
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for child in multiprocessing.active_children():
                child.terminate()
            raise


def _begin(parent: int) -> None:
    """Make a worker process end, with its engines, when its parent process ends."""
    die_with_parent()
    if os.getppid() != parent:
        os._exit(1)
