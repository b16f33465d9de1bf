"""Time and memory of what comes after a long moist run: conversion of the logs, replay, results; and the disk they take.

    python benchmarks/replay_size.py RUN_DIR [--spheres 16887] [--events 15000000] [--folder DIR]

RUN_DIR is a small moist run that gives scene, walls and laws (long_history.py). Each stage runs in a process of its own, so that
its peak of memory is its own. The folder is kept where one is given; what was made or converted there is not again.
"""

from __future__ import annotations

import argparse
import multiprocessing
import resource
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))


def convert(folder: Path) -> dict[str, Any]:
    """Raw logs to tables, as a finished run does."""
    from pywet.engines.liggghts import collecting, logs
    from pywet.runs import tables

    collecting.convert_trajectory(folder / "engine.partial" / logs.TRAJECTORY, folder / "trajectory.parquet", 1.53e-6)
    tables.convert(folder / "engine.partial", folder / "history")
    return {}


def replayed(folder: Path) -> dict[str, Any]:
    """The replay."""
    from reference_impl.replay.replay import replay

    return replay(folder)


def results(folder: Path) -> dict[str, Any]:
    """Fraction retained, liquid by holder, checks, summary."""
    from pywet.runs.rundir import RunDir
    from pywet.screening.results import summarise, write_results

    run = RunDir(folder)
    return summarise(run, write_results(run))


def measured(stage: Callable[[Path], dict[str, Any]], folder: Path) -> dict[str, Any]:
    """Processor and wall seconds and peak memory of a stage, with its result."""
    started = time.monotonic()
    found = stage(folder)
    used = resource.getrusage(resource.RUSAGE_SELF)
    return found | {
        "wall": time.monotonic() - started,
        "cpu": used.ru_utime + used.ru_stime,
        "GB": used.ru_maxrss / 1e6,
    }


def alone(stage: Callable[[Path], dict[str, Any]], folder: Path) -> dict[str, Any]:
    """The same in a process of its own."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        found = pool.apply(measured, (stage, folder))
    print(f"{stage.__name__:10s} {found['cpu']:7.1f} s of the processor, {found['wall']:7.1f} s, peak {found['GB']:5.2f} GB",
          flush=True)  # fmt: skip
    return found


def disk(folder: Path) -> None:
    """Bytes of each log, and for each of its rows."""
    from pyarrow import parquet

    total = 0
    for path in sorted([*folder.glob("*.parquet"), *(folder / "history").glob("*.parquet")]):
        rows, size = parquet.read_metadata(path).num_rows, path.stat().st_size
        total += size
        if rows > 1000:
            print(f"  {path.stem:12s} {rows:10d} rows {size / 1e6:9.1f} MB {size / rows:7.1f} bytes a row")
    print(f"  in all {total / 1e9:.2f} GB")


def main() -> None:
    """Print one line for each stage."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("run_dir", type=Path)
    parser.add_argument("--spheres", type=int, default=16_887)
    parser.add_argument("--events", type=int, default=15_000_000)
    parser.add_argument("--folder", type=Path)
    given = parser.parse_args()
    import long_history

    with tempfile.TemporaryDirectory() as temporary:
        folder = given.folder or Path(temporary)
        raw = folder / "engine.partial"
        if not (folder / "made").exists():
            long_history.write(given.run_dir, folder, given.spheres, given.events)
            (folder / "made").touch()
        if not (folder / "history" / "events.parquet").exists():
            print(f"raw        {sum(p.stat().st_size for p in raw.iterdir()) / 1e9:.2f} GB", flush=True)
            alone(convert, folder)
        disk(folder)
        found = alone(replayed, folder)
        print(f"  {found['events']} events at {found['events_per_s']:.3g} and {found['contacts']} contacts at "
              f"{found['contacts_per_s']:.3g} per processor second; agrees: {found['ok']}", flush=True)  # fmt: skip
        alone(results, folder)


if __name__ == "__main__":
    main()
