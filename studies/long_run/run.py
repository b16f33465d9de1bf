"""Run long_deck.yaml whole and killed twice, and compare: `python -m studies.long_run.run FOLDER`.

The second run is ended with SIGKILL, with all its processes, when a third and two thirds of its steps are done, and resumed.
Memory of the engine is sampled each minute into FOLDER/memory.csv. About half an hour on one core.
"""

from __future__ import annotations

import csv
import hashlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd

from pywet.errors import border
from pywet.runs.tables import ledger_error
from pywet.scene import EngineScene

SCENE = Path(__file__).with_name("long_deck.yaml")
EVERY_S = 60.0
"""Between two samples of memory."""
KILLS = (1 / 3, 2 / 3)
"""Shares of the steps at which the second run is killed."""


def engine_memory_kB(run_dir: Path) -> int:
    """Resident memory of the engine of a run; 0 if there is none."""
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if f"pywet.engines.liggghts.worker\0{run_dir}\0" in (folder / "cmdline").read_text():
                return int((folder / "statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1024
        except OSError:  # the process has ended
            continue
    return 0


def done(run_dir: Path) -> int:
    """Last step with a checkpoint."""
    return max((int(p.name.split(".")[1]) for p in run_dir.glob("engine.partial/checkpoint/sums.*.json")), default=0)


RUN_SCENE = "from pywet.cli.app import app; app()", "run-scene", str(SCENE), "--out"
RESUME = ("import sys; from pywet.engines.liggghts import driver; driver.run(sys.argv[1], progress=False)",)
"""Arguments of Python before the run directory: the command, and its engine alone, which does not place the spheres again."""


def call(run_dir: Path, code: tuple[str, ...], until: float, memory: Path) -> int:
    """Start a run or go on with it until a checkpoint beyond this step, where it is killed, or to its end; return its status."""
    child = subprocess.Popen([sys.executable, "-c", *code, str(run_dir)], start_new_session=True)
    began = next_sample = time.monotonic()
    while child.poll() is None:
        if time.monotonic() >= next_sample:
            next_sample += EVERY_S
            row = [run_dir.name, round(time.monotonic() - began), done(run_dir), engine_memory_kB(run_dir)]
            with memory.open("a", newline="") as file:
                csv.writer(file).writerow(row)
        if done(run_dir) >= until:
            os.killpg(child.pid, signal.SIGKILL)
        time.sleep(0.5)
    return child.returncode


def digests(run_dir: Path) -> dict[str, str]:
    """SHA-256 of the columns of every table that the engine's run makes."""
    found = {}
    for path in sorted([*run_dir.glob("*.parquet"), *run_dir.glob("history/*.parquet")]):
        table, digest = pd.read_parquet(path), hashlib.sha256()
        for column in table:
            values = table[column]
            digest.update(
                str(column).encode()
                + (values.to_numpy().tobytes() if values.dtype.kind in "fiub" else values.to_csv().encode())
            )
        found[str(path.relative_to(run_dir))] = digest.hexdigest()
    return found


def main(folder: Path) -> int:
    """Run, kill, resume, compare; 1 if something differs."""
    folder.mkdir(parents=True, exist_ok=True)
    memory, status = folder / "memory.csv", []
    status.append(call(folder / "whole", RUN_SCENE, float("inf"), memory))
    steps = EngineScene.read(folder / "whole" / "scene.json").steps
    for code, until in zip(
        (RUN_SCENE, RESUME, RESUME), (*(share * steps for share in KILLS), float("inf")), strict=True
    ):
        status.append(call(folder / "killed", code, until, memory))
    one, two = (digests(folder / name) for name in ("whole", "killed"))
    gone = pd.read_parquet(folder / "whole" / "history" / "retired.parquet")
    error = ledger_error(pd.read_parquet(folder / "whole" / "history" / "ledger.parquet"))
    print(f"{len(gone)} spheres left through the outlets; {len(one)} tables; exit status {status}")
    print(f"largest relative error of the ledger {error:.2g}")
    print(f"tables that differ: {[name for name in one.keys() | two.keys() if one.get(name) != two.get(name)]}")
    return int(one != two)


if __name__ == "__main__":
    with border():
        sys.exit(main(Path(sys.argv[1]).resolve()))
