"""The engines that a scene can be run in, by name: what each can do, and how it is started."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from pywet.errors import PywetError, one_line


@dataclass(frozen=True)
class Engine:
    """A program that runs prepared scenes. `start` is given run directory, ranks, and whether to show progress."""

    name: str
    start: Callable[[Path, int, bool], object]
    rolling: bool = True
    """Whether it has rolling resistance as the scene means it."""
    parallel: bool = True
    """Whether it runs in more than one process."""


def _liggghts(run_dir: Path, ranks: int, progress: bool) -> None:
    from pywet.engines.liggghts import driver

    driver.run(run_dir, ranks, progress, keep=True)


def _yade(run_dir: Path, ranks: int, progress: bool) -> None:
    from pywet.engines.yade import driver

    driver.run(run_dir, progress)


ENGINES = {
    engine.name: engine
    for engine in (Engine("liggghts", _liggghts), Engine("yade", _yade, rolling=False, parallel=False))
}


def chosen(name: str, ranks: int = 1) -> Engine:
    """The engine of that name; PywetError where there is none, or more ranks are asked for than it can have."""
    if name not in ENGINES:
        raise PywetError(f"there is no engine {one_line(name) if name else '(empty)'}; expected {' or '.join(ENGINES)}")
    if ranks > 1 and not ENGINES[name].parallel:
        raise PywetError(f"{ranks} ranks were asked for; expected 1, as the engine {name} runs in one process")
    return ENGINES[name]
