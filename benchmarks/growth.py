"""How cost grows with the number of spheres, and what two ranks save: a moist bed of ten layers on a floor, made wider.

    python benchmarks/growth.py [--sizes 4 16 64] [--ranks 1 2 4] [--bare]

Spheres stand on a shaken lattice whose films meet, three bridges each, are numbered by chance, as a fill has them, and drift at
1 m/s, so that the engine makes its lists again. Per size and number of ranks, each
run in processes of its own: one of `--steps`, one three times as long (their difference is the cost of a step: set-up and first
formations cancel), and one of that length with more outputs; at one rank its replay. All is processor time; that of a step is
of the first rank, without what it spends within MPI, where it mostly waits. mpi_account.c counts that, and the messages.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import os
import subprocess
import sys
import tempfile
import threading
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from glass import STEP, WATER, lattice, spent
from glass import prepare as prepare_bed

from pywet.cases.small import small
from pywet.cases.small.bodies import at_places
from pywet.scene import Output

LAYERS, OUTPUTS = 10, 5
DRIFT = 1.0, 0.0, 0.0
SIDES = {4: 20, 16: 40, 64: 80, 256: 160, 1024: 320}
"""Thousands of spheres -> spheres along each side of the bed."""


@dataclass(frozen=True)
class Taken:
    """Resources of one run: processor times of the first rank [s], its messages [bytes], memory of the ranks."""

    loop_s: float
    mpi_s: float
    start_s: float
    wall_s: float
    memory_B: list[int]
    near_B: float
    all_B: float
    disk_B: int


def prepare(folder: Path, side: int, steps: int, outputs: int) -> list[small.Sphere]:
    """The bed."""
    places = np.random.default_rng(2).permutation(lattice(side, LAYERS, 2.01, 0.002))
    spheres = [dataclasses.replace(sphere, velocity=DRIFT) for sphere in at_places(places)]
    prepare_bed(
        folder, spheres, steps, liquid=WATER, effects=small.PAPER,
        output=Output(interval_s=steps // outputs * STEP, contact_windows=0, energy=False),
    )  # fmt: skip
    return spheres


def workers(folder: Path) -> dict[int, int]:
    """Largest memory [B] so far of the engine's processes that work on a run."""
    found = {}
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            words = (entry / "cmdline").read_bytes().decode(errors="replace").split("\0")
            if "pywet.engines.liggghts.worker" not in words or str(folder) not in words or "python" not in words[0]:
                continue
            lines = (entry / "status").read_text().splitlines()
        except OSError:
            continue
        for line in lines:
            if line.startswith("VmHWM:"):
                found[int(entry.name)] = 1024 * int(line.split()[1])
    return found


def one(side: int, steps: int, outputs: int, ranks: int, folder: Path) -> Taken:
    """A run, watched."""
    spheres = prepare(folder, side, steps, outputs)
    seen: dict[int, int] = {}
    over = threading.Event()

    def watch() -> None:
        while not over.wait(0.3):
            seen.update(workers(folder))

    watcher = threading.Thread(target=watch)
    watcher.start()
    try:
        info = small.run(folder, spheres, ranks)
    finally:
        over.set()
        watcher.join()
    account = json.loads((folder / "mpi.0").read_text())
    disk = sum(path.stat().st_size for path in folder.rglob("*.parquet"))
    return Taken(
        loop_s=info.loop_cpu_s or 0.0,
        mpi_s=account["mpi_s"],
        start_s=info.cpu_s / ranks - (info.loop_cpu_s or 0.0),
        wall_s=info.wall_s,
        memory_B=sorted(seen.values()),
        near_B=account["near_B"],
        all_B=account["all_B"],
        disk_B=disk,
    )


def by_itself(
    side: int, steps: int, outputs: int, ranks: int, account: Path, replay: bool = False
) -> tuple[Taken, float]:
    """A run in a process of its own, and the processor time of its replay where that is asked for."""
    with tempfile.TemporaryDirectory() as name:
        run = Path(name) / "run"
        environment = {**os.environ, "LD_PRELOAD": str(account), "MPI_ACCOUNT": f"{run}/mpi"}
        command = [sys.executable, __file__, "--one", str(side), str(steps), str(outputs), str(ranks), str(run)]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise SystemExit(done.stderr)
        before = spent()
        if replay:
            subprocess.run([sys.executable, "-m", "pywet.cli.app", "replay", str(run)], capture_output=True, check=True)
        return Taken(**json.loads(done.stdout.splitlines()[-1])), spent() - before


def row(thousands: int, ranks: int, account: Path, rounds: int, steps: int, bare: bool) -> str:
    """Measure one size on one number of ranks; if `bare`, without outputs and replay."""
    side = SIDES[thousands]
    n = side * side * LAYERS
    step, memory = [], 0
    for _ in range(rounds):
        short, _ = by_itself(side, steps, 1, ranks, account)
        long, _ = by_itself(side, 3 * steps, 1, ranks, account)
        step.append(1e9 * ((long.loop_s - long.mpi_s) - (short.loop_s - short.mpi_s)) / (2 * steps) / n)
        memory = max(memory, *long.memory_B)
    near, everyone = (1e-3 * (getattr(long, k) - getattr(short, k)) / (2 * steps) for k in ("near_B", "all_B"))
    head = f"{n:9d}{ranks:6d}{min(step):7.0f}{max(step):7.0f}{1e-6 * memory:9.0f}{1e-3 * memory / n:9.2f}{long.start_s:9.1f}"
    if bare:
        return f"{head}{math.nan:9.0f}{math.nan:9.0f}{math.nan:9.0f}{near:9.1f}{everyone:9.1f}"
    more, replay = by_itself(side, 3 * steps, OUTPUTS + 1, ranks, account, replay=ranks == 1)
    output = 1e6 * ((more.loop_s - more.mpi_s) - (long.loop_s - long.mpi_s)) / OUTPUTS / n
    return (
        f"{head}{output:9.2f}{(more.disk_B - long.disk_B) / OUTPUTS / n:9.0f}{1e6 * replay / n if replay else math.nan:9.0f}"
        f"{near:9.1f}{everyone:9.1f}"
    )


HEAD = (
    "  spheres ranks   ns a step     MB    kB each  start s  output        B   replay  near kB   all kB\n"
    "ns a step and sphere: least and most of the rounds; memory of the largest rank; per sphere and output: us, bytes in tables; "
    "replay: us per sphere; messages of a rank and step"
)


def main() -> None:
    """Print the table, row by row."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--sizes", nargs="+", type=int, choices=SIDES, default=[4, 16, 64], help="thousands of spheres")
    parser.add_argument("--ranks", nargs="+", type=int, default=[1])
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--steps", type=int, default=100, help="of the shorter run")
    parser.add_argument("--bare", action="store_true", help="without outputs and replay")
    parser.add_argument("--one", nargs=5, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.one:
        side, steps, outputs, ranks = map(int, asked.one[:4])
        print(json.dumps(dataclasses.asdict(one(side, steps, outputs, ranks, Path(asked.one[4])))))
        return
    with tempfile.TemporaryDirectory() as name:
        account = Path(name) / "mpi_account.so"
        source = Path(__file__).with_name("mpi_account.c")
        subprocess.run(["mpicc", "-O2", "-shared", "-fPIC", "-o", str(account), str(source)], check=True)
        print(HEAD, flush=True)
        for thousands in asked.sizes:
            for ranks in asked.ranks:
                print(row(thousands, ranks, account, asked.rounds, asked.steps, asked.bare), flush=True)


if __name__ == "__main__":
    main()
