"""Time and memory of the replay on histories of growing size: one run, and the same run many times side by side.

    python benchmarks/replay_speed.py RUN_DIR [--times 1 10 40]

Each copy has its own spheres, walls and events at the same steps, so the physics stays whole and only the numbers grow.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import resource
import shutil
import tempfile
import time
from pathlib import Path

import pandas as pd

from reference_impl.replay import io
from reference_impl.replay.replay import replay

OWN_IDS = ("spheres", "films", "trajectory", "start")
APART = 10.0
"""Distance of the copies [m], so that no sphere is near another copy's."""
OWN_TRIANGLES = ("triangles", "wall_films")
PAIRS = ("events", "contacts", "bridges")


def copy_of(name: str, table: pd.DataFrame, k: int, spheres: int, triangles: int, parts: int) -> pd.DataFrame:
    """One table with the numbers of the k-th copy."""
    table = table.copy()
    if name in OWN_IDS:
        table["id"] += k * spheres
    elif name in OWN_TRIANGLES:
        table["triangle"] += k * triangles
        if "part" in table:
            table["part"] += k * parts
    elif name == "parts":
        table["part"] += k * parts
    elif name in PAIRS:
        wall = table["partner_kind"] != 0
        table["i"] += k * spheres
        table["j"] += (wall * parts + ~wall * spheres) * k
        table["triangle"] += wall * k * triangles
    for column in ("x", "xi_x", "xj_x"):
        if column in table and name != "contacts":
            table[column] += k * APART
    return table


def side_by_side(run_dir: Path, times: int, out: Path) -> None:
    """Write the history of `times` copies of a run."""
    run, history = io.read(run_dir), out / "history"
    history.mkdir(parents=True)
    (history / "meta.json").write_text((run_dir / "history" / "meta.json").read_text())
    scene = json.loads((run_dir / "scene.json").read_text())
    scene["output"]["window_trajectories"] = False
    for wall in scene["walls"]:
        wall["triangle_part"] *= times
        wall["part_half_width_m"] *= times
    (out / "scene.json").write_text(json.dumps(scene))
    for name in ("mesh_motion", "history/energy"):
        shutil.copy(run_dir / f"{name}.parquet", out / f"{name}.parquet")
    counts = (int(run.table("spheres")["id"].max()), len(run.tables["triangles"]), len(run.tables["parts"]))
    more = {"trajectory": out / "trajectory.parquet", "start": out / scene["spheres_file"]}
    besides = {name: pd.read_parquet(run_dir / path.name) for name, path in more.items()}
    logs = {name: run.table(name) for name in io.LOGS}
    for name, table in (run.tables | logs | besides).items():
        if name == "ledger":
            amounts = [
                "films",
                "bridges",
                "walls",
                "left",
                "initial",
                "spheres",
                "bridge_count",
                "formations",
                "ruptures",
            ]
            table = table.assign(**{a: table[a] * times for a in amounts})
        elif name != "transfer":
            table = pd.concat([copy_of(name, table, k, *counts) for k in range(times)], ignore_index=True)
        order = [c for c in ("step", "kind", "partner_kind", "i", "j") if c in table]
        if name in PAIRS:
            table = table.sort_values(order, kind="stable")
        table.to_parquet(more.get(name, history / f"{name}.parquet"), index=False)


def measure(folder: Path) -> tuple[float, float, float, dict]:
    """Replay one folder: wall and processor seconds, peak memory [GB], and the result."""
    started = time.monotonic()
    result = replay(folder)
    used = resource.getrusage(resource.RUSAGE_SELF)
    return time.monotonic() - started, used.ru_utime, used.ru_maxrss / 1e6, result


def main() -> None:
    """Print one line for each size."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run_dir", type=Path)
    parser.add_argument("--times", type=int, nargs="+", default=[1, 10, 40])
    given = parser.parse_args()
    print(f"{'copies':>6s} {'events':>9s} {'contacts':>9s} {'wall s':>7s} {'cpu s':>7s} {'GB':>5s} agrees")
    for times in given.times:
        with tempfile.TemporaryDirectory() as folder:
            side_by_side(given.run_dir, times, Path(folder))
            # a process of its own, so that each peak is its own
            with multiprocessing.get_context("spawn").Pool(1) as pool:
                wall, cpu, peak, result = pool.apply(measure, (Path(folder),))
        counts = f"{times:6d} {result['events']:9d} {result['contacts']:9d}"
        print(f"{counts} {wall:7.1f} {cpu:7.1f} {peak:5.2f} {result['ok']}", flush=True)


if __name__ == "__main__":
    main()
