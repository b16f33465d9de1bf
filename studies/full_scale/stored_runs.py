"""Small tables of finished full-scale runs in the repository, read as curves over time.

docs/full_scale/data/<run>/ contains fraction_retained.csv, liquid_by_holder.csv, spheres.csv at every output, and run.json. Times
count from the opening of the slide, which is the paper's t = 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.cases.screening.results import LIQUID_TOLERANCE, coarse_share
from pywet.cases.screening.verdict import agreement, objections
from pywet.config.cases import CLASS_NAMES
from pywet.errors import PywetError
from pywet.laws.contact import film_thickness
from pywet.products.apertures import wedged
from pywet.runs.rundir import Floats, RunDir
from pywet.runs.shapes import EngineRun, Summary
from pywet.schema import column
from pywet.util.files import read_json, write_csv, write_json

TABLES = ("fraction_retained", "liquid_by_holder", "spheres")
DIGITS = "%.7g"
CURE = "run the case again, or fetch the tables of the repository"
CAMPAIGN, RIGS = Path("docs/full_scale/data"), Path("docs/full_scale/rigs")
"""Folders of runs with all spheres, and of runs whose passed spheres are retired, both on 200 mm and with other readings."""
DEFAULT, SEEDS = "sieve200", {10007, 10009, 10012}
"""Name of the default settings among RIGS, and the seeds with which each of their cases is run."""
ALL = f"{DEFAULT}_all"
"""Name of the default settings without retirement: all spheres stay."""
FREQUENCY_HZ = 50.6
"""Frequency of the screen in runs that were stored without it (table 2)."""
DRY_CASES = (1, 4, 10, 13, 7, 16)
UNDERSIZE, COARSE = CLASS_NAMES[:2], CLASS_NAMES[2]
WALLS = ("wires", "side_wall", "feed_bin", "outlet", "impact_plate")
"""Rows of liquid_by_holder that are the screening apparatus (all walls but the bin)."""


@dataclass(frozen=True)
class StoredRun:
    """One stored run; every method takes seconds since the opening of the slide."""

    folder: Path

    @cached_property
    def about(self) -> dict[str, Any]:
        """Return run.json: case, seed, settings, versions, times, ledger error, verdict of the replay."""
        value = read_json(self.folder / "run.json", CURE)
        if not isinstance(value, dict) or "case" not in value:
            raise PywetError(f"{self.folder / 'run.json'} names no case: {CURE}")
        return value

    @cached_property
    def tables(self) -> dict[str, pd.DataFrame]:
        try:
            return {name: pd.read_csv(self.folder / f"{name}.csv") for name in TABLES}
        except (OSError, ValueError) as error:
            raise PywetError(f"{self.folder} lacks a whole table ({error}): {CURE}") from error

    @property
    def case(self) -> int:
        return int(self.about["case"])

    @property
    def end(self) -> float:
        """Return the time of the last output [s]."""
        return float(self.times[-1])

    @cached_property
    def times(self) -> Floats:
        """Return the times of the outputs [s]."""
        return np.asarray(self.tables["fraction_retained"]["time_since_opening_s"], dtype=float)

    def series(self, table: str, name: str) -> Floats:
        """Return a column of a table at the output times."""
        found = self.tables[table]
        if name not in found or len(found) != len(self.times):
            raise PywetError(f"{self.folder / table}.csv lacks the column {name} at every output: {CURE}")
        return np.asarray(found[name], dtype=float)

    def has(self, time: float) -> bool:
        """Return whether the run lasts until a time, to within its outputs."""
        beyond = float(self.times[-1] - self.times[-2])
        return bool(self.times[0] <= time < self.times[-1] + beyond)

    def at(self, values: Floats, time: float) -> float:
        """Return a series at a time by linear interpolation, constant for up to one output interval after the end."""
        if not self.has(time):
            raise PywetError(
                f"{self.folder.name} goes from {self.times[0]:g} to {self.end:g} s, {time:g} s is not in it"
            )
        return float(np.interp(time, self.times, values))

    def mean(self, values: Floats, start: float, stop: float) -> float:
        """Return the mean over the outputs from `start` to `stop`."""
        self.at(values, start), self.at(values, stop)
        return float(values[(self.times >= start - 1e-9) & (self.times <= stop + 1e-9)].mean())

    def retained(self, kind: str | None = None) -> Floats:
        """Return Y (44), or Y_i (45) of a size class."""
        return self.series(
            "fraction_retained", "fraction_retained" if kind is None else column("fraction_retained", kind)
        )

    def y(self, start: float, stop: float, kind: str | None = None) -> float:
        """Return the mean of `retained` from `start` to `stop`."""
        return self.mean(self.retained(kind), start, stop)

    @property
    def undersize(self) -> Floats:
        """Return the mass of undersize spheres still on the screen over that at the start."""
        dry, coarse = self.series("fraction_retained", "fraction_retained_spheres"), float(self.about["coarse_share"])
        return (dry - coarse) / (1.0 - coarse)

    def liquid(self, *reservoirs: str) -> Floats:
        """Return the share of all liquid in these reservoirs, such as `fines` or `coarse_material_large`."""
        total = self.series("liquid_by_holder", "initial_m3")
        return np.asarray(sum(self.series("liquid_by_holder", f"{name}_m3") for name in reservoirs) / total)

    @property
    def walls(self) -> Floats:
        """Return the share of all liquid on the screening apparatus."""
        have = [w for w in WALLS if f"{w}_m3" in self.tables["liquid_by_holder"]]
        return self.liquid(*have)

    def count(self, what: str, kind: str) -> Floats:
        """Return `above` (on the screen side), `wedged` or `film_m` (median film thickness of those above) of a size class.

        Spheres that turn around on the screen at an output are wedged, too; see `pegged`.
        """
        return self.series("spheres", f"{what}_{kind}")

    @property
    def beat(self) -> int:
        """Return the number of outputs in a row that meet all phases of the vibration."""
        cycles = float(self.about.get("frequency_Hz", FREQUENCY_HZ)) * float(np.median(np.diff(self.times)))
        return math.ceil(1.0 / max(abs(cycles - round(cycles)), 1.0 / len(self.times)))

    def pegged(self, kind: str, start: float, stop: float) -> float:
        """Return the mean, over all beats from `start` to `stop`, of the least number of wedged spheres of a size class.

        A sphere that pegs an aperture is wedged at every output, others only at some phases of the vibration: so many peg at
        most.
        """
        counts = self.count("wedged", kind)
        self.at(counts, start), self.at(counts, stop)
        found = counts[(self.times >= start - 1e-9) & (self.times <= stop + 1e-9)]
        windows = np.lib.stride_tricks.sliding_window_view(found, min(self.beat, len(found)))
        return float(windows.min(axis=1).mean())


@dataclass(frozen=True)
class Moved(StoredRun):
    """A stored run shifted by the deviation of one seed of another case from its mean over seeds."""

    seeds: Sequence[StoredRun]
    which: int

    @cached_property
    def tables(self) -> dict[str, pd.DataFrame]:
        this = StoredRun(self.folder)
        moved = {name: this.tables[name].astype(float) for name in TABLES}
        for name, frame in moved.items():
            for key in frame.columns.difference(NOT_MOVED):
                others = [k for k in self.seeds if key in k.tables[name]]
                if len(others) == len(self.seeds):
                    each = np.array(
                        [np.interp(this.times, k.times, k.series(name, key)) / _whole(k, name, key) for k in others]
                    )
                    frame[key] += (each[self.which] - each.mean(axis=0)) * _whole(this, name, key)
        return moved


NOT_MOVED = ["step", "time_s", "time_since_opening_s", "initial_m3", "total_m3"]


def _whole(run: StoredRun, table: str, name: str) -> float:
    """Return the total that a column is a part of: all liquid, or all spheres of its class; else 1."""
    if table == "liquid_by_holder":
        return float(run.series(table, "initial_m3")[0]) or 1.0
    if name.startswith(("above_", "wedged_")):
        return float(run.series(table, f"above_{name.split('_', 1)[1]}")[0]) or 1.0
    return 1.0


def sphere_table(run: RunDir) -> pd.DataFrame:
    """Return per size class over time: spheres above the bin, wedged ones, median film thickness above [m].

    For walls it is the share of wet triangles (wires separately) whose film is thinner than that of the coarse
    spheres.
    """
    line, scene = run.timeline, run.scene
    above, stuck = line.present & ~line.passed, wedged(run, next(w for w in scene.walls if w.name == WALLS[0]))
    radius = np.array([c.radius_m for c in scene.classes])[line.types - 1]
    thickness = film_thickness(line.film, radius)
    frame = pd.DataFrame({"time_s": line.times})
    for kind in scene.classes:
        of = line.types == kind.type
        frame[f"above_{kind.name}"] = above[:, of].sum(axis=1)
        frame[f"wedged_{kind.name}"] = stuck[:, of].sum(axis=1)
        films = pd.DataFrame(np.where(above, thickness, np.nan)[:, of])
        frame[f"film_m_{kind.name}"] = films.median(axis=1).fillna(0.0)
    coarse = next(c.name for c in (*(c for c in scene.classes if not c.passes_aperture), scene.classes[-1]))
    frame["thin_walls"], frame["thin_wires"] = _thin(run, frame[f"film_m_{coarse}"].to_numpy())
    return frame


def _thin(run: RunDir, limit: Floats) -> tuple[Floats, Floats]:
    """Return the share of wet triangles of large walls and of wires with a film thinner than `limit`; 1 if none is wet."""
    if not run.moist:
        return np.ones(len(limit)), np.ones(len(limit))
    films = run.wall_films[run.wall_films["film"] > 0.0]
    thickness = films["film"].to_numpy() / run.triangles["area"].to_numpy()[films["triangle"]]
    thin = pd.Series(thickness < limit[np.searchsorted(run.timeline.steps, films["step"])], index=films.index)
    shares = thin.groupby([films["reservoir"] == WALLS[0], films["step"]]).mean()
    of = [shares.get(wires, pd.Series(dtype=float)).reindex(run.timeline.steps).fillna(1.0) for wires in (False, True)]
    return of[0].to_numpy(dtype=float), of[1].to_numpy(dtype=float)


def carried(run: RunDir) -> dict[str, float]:
    """Return the share of all liquid on spheres of each undersize class at the last output before they passed."""
    line = run.timeline
    through = np.asarray(line.passed.any(axis=0))
    before = line.liquid[np.maximum(line.passed.argmax(axis=0) - 1, 0), np.arange(len(through))]
    total = float(line.initial_film.sum())
    return {
        c.name: float(before[through & (line.types == c.type)].sum()) / total
        for c in run.scene.classes
        if c.name in UNDERSIZE
    }


def keep(run_dir: Path, data: Path, name: str, more: dict[str, Any]) -> StoredRun:
    """Store the small tables of a finished run as `data`/`name`; a run that may not be believed is refused."""
    bad = objections(RunDir(run_dir))
    if bad:
        raise PywetError(f"{run_dir} is not stored: {'; '.join(bad)}")
    run, folder = RunDir(run_dir), data / name
    summary, replay = run.json("summary.json", Summary), run.replay
    for table, frame in zip(TABLES, (*(run.table(f"results/{t}") for t in TABLES[:2]), sphere_table(run)), strict=True):
        write_csv(frame, folder / f"{table}.csv", float_format=DIGITS)
    rows, engine = agreement(replay) if replay else [], run.json("engine/run.json", EngineRun) or {}
    write_json(
        folder / "run.json",
        {
            **more,
            "seed": run.scene.seed,
            "time_step_s": run.scene.time_step_s,
            "frequency_Hz": getattr(run.scene.motions[WALLS[0]], "frequency_Hz", 0.0),
            "normal_stiffness_N_per_m": max(p.normal_stiffness_N_per_m for p in run.scene.pairs),
            "coarse_share": coarse_share(run.scene),
            "checks": [c["name"] for c in summary["checks"] if c["ok"]],
            "liquid_tolerance": LIQUID_TOLERANCE,
            "ledger_error": summary["ledger_error"],
            "events": summary["events"],
            "contacts": max((r.count for r in rows if r.quantity == "capillary"), default=0),
            "replay": {r.quantity: {"values": r.count, "largest": r.largest, "limit": r.limit} for r in rows},
            "carried": carried(run) if run.moist else None,
            "cpu_s": engine.get("cpu_s"),
            "peak_memory_B": engine.get("peak_memory_B"),
            "replay_cpu_s": replay.get("cpu_s") if replay else None,
            "replay_peak_memory_B": replay.get("peak_memory_B") if replay else None,
            "disk_B": sum(p.stat().st_size for p in run_dir.rglob("*") if p.is_file()),
            "resumed_at_step": engine.get("resumed_at_step"),
            "versions": summary["versions"],
        },
    )
    return StoredRun(folder)


def variants(data: Path) -> dict[str, dict[int, list[StoredRun]]]:
    """Return all stored runs by the name of their settings and by case, in the order of seeds."""
    found: dict[str, dict[int, list[StoredRun]]] = {}
    for one in sorted((StoredRun(p.parent) for p in data.glob("*/run.json")), key=lambda k: int(k.about["seed"])):
        found.setdefault(str(one.about.get("variant", "")), {}).setdefault(one.case, []).append(one)
    return found


def mean(runs: Sequence[StoredRun], of: Callable[[StoredRun], float]) -> float:
    """Return the mean of a quantity over the seeds of a case."""
    return float(np.mean([of(run) for run in runs]))


def default(
    campaign: Mapping[int, Sequence[StoredRun]], retired: Mapping[int, Sequence[StoredRun]]
) -> dict[int, Sequence[StoredRun]]:
    """Return the runs by which the default settings are judged: of each case those with SEEDS, else those of the campaign."""
    whole = {case: runs for case, runs in retired.items() if {run.about["seed"] for run in runs} >= SEEDS}
    return {**campaign, **whole}
