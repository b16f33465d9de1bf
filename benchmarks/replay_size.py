"""Time and memory of what comes after a long moist run: conversion of its logs, replay, results; and the disk they take.

    python benchmarks/replay_size.py RUN_DIR

RUN_DIR is a finished moist run, as `make full` leaves them; nothing in it changes. Its raw logs are written again from its tables
(but for the trajectory), to be converted. Each stage runs in a process of its own, so that its peak of memory is its own.
"""

from __future__ import annotations

import argparse
import multiprocessing
import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

LEFT_OUT = ("engine", "engine.partial", "results", "replay.json", "summary.json", "contributions.json")


def beside(run: Path, folder: Path) -> Path:
    """The run in another folder by links, without what follows from its logs."""
    for path in run.iterdir():
        if path.name not in LEFT_OUT:
            (folder / path.name).symlink_to(path.resolve())
    return folder


def raw(folder: Path) -> dict[str, Any]:
    """The raw logs as the engine leaves them."""
    from pyarrow import parquet

    from pywet.schema import RAW

    (folder / "engine.partial").mkdir()
    for name, record in RAW.items():
        table = folder / "history" / f"{name}.parquet"
        with open(folder / "engine.partial" / f"{name}.0.bin", "wb") as file:
            for batch in parquet.ParquetFile(table).iter_batches() if table.exists() else ():
                part = batch.to_pandas()
                rows = np.zeros(len(part), record)
                for field in record.names or ():
                    names = [f"{field}_{axis}" for axis in "xyz"] if record[field].shape else [field]
                    if set(names) <= set(part):  # padding fields of a record are not in the tables
                        rows[field] = part[names].to_numpy().reshape(rows[field].shape)
                rows.tofile(file)
    return {}


def convert(folder: Path) -> dict[str, Any]:
    """Raw logs to tables, as a finished run does."""
    from pywet.runs import tables

    for name, rows in tables.converted(folder / "engine.partial"):
        tables.write(rows, folder / "converted" / f"{name}.parquet")
    return {}


def replayed(folder: Path) -> dict[str, Any]:
    """The replay."""
    from reference_impl.replay.replay import replay

    return replay(folder)


def results(folder: Path) -> dict[str, Any]:
    """Fraction retained, liquid by reservoir, checks, summary."""
    from pywet.cases.screening.results import summarise, write_results
    from pywet.runs.rundir import RunDir

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
    """Run a stage in a separate process, print its time and peak memory, and return its result."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        found = pool.apply(measured, (stage, folder))
    print(f"{stage.__name__:10s} {found['cpu']:7.1f} s of the processor, {found['wall']:7.1f} s, peak {found['GB']:5.2f} GB",
          flush=True)  # fmt: skip
    return found


def disk(folder: Path) -> int:
    """Bytes of each log, and for each of its rows; the rows of all."""
    from pyarrow import parquet

    total, count = 0, 0
    for path in sorted([*folder.glob("*.parquet"), *folder.glob("history/*.parquet")]):
        rows, size = parquet.read_metadata(path).num_rows, path.stat().st_size
        total, count = total + size, count + rows
        if rows > 1000:
            print(f"  {path.stem:20s} {rows:10d} rows {size / 1e6:9.1f} MB {size / rows:7.1f} bytes a row")
    print(f"  in all {total / 1e9:.2f} GB")
    return count


def main() -> None:
    """Print one line for each stage."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("run_dir", type=Path)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=given.run_dir.parent) as temporary:
        folder = beside(given.run_dir, Path(temporary))
        rows = disk(folder)
        alone(raw, folder)
        logs = {path: path.stat().st_size for path in (folder / "engine.partial").iterdir()}
        print(f"raw        {sum(logs.values()) / 1e9:.2f} GB", flush=True)
        alone(convert, folder)
        found = alone(replayed, folder)
        print(f"  {found['events']} events at {found['events_per_s']:.3g} and {found['contacts']} contacts at "
              f"{found['contacts_per_s']:.3g} per processor second; {rows / found['cpu']:.3g} rows of all tables in each second "
              f"of the whole; agrees: {found['ok']}", flush=True)  # fmt: skip
        alone(results, folder)


if __name__ == "__main__":
    main()
