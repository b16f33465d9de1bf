"""Compared quantities of a run: curves over time and single numbers, from the tables in its run directory.

Reads only the tables that every engine writes (results, history, trajectory, summary.json, replay.json); a run with
less data than its scene planned is refused. Each quantity has a scale, in its unit, to which deviations are relative.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.cases.screening.verdict import LEDGER_TOLERANCE
from pywet.cases.small.bodies import coordination
from pywet.compare import common_end
from pywet.errors import PywetError
from pywet.laws.contact import film_thickness
from pywet.products import screening_report, streams
from pywet.products.partition import WITHIN
from pywet.runs.rundir import Floats, RunDir
from pywet.runs.tables import ledger_error
from pywet.scene import EngineScene
from reference_impl.replay import whole
from reference_impl.replay.io import ReplayError

Ends = tuple[float | None, float | None] | None
RESULTS = ("results/fraction_retained", "results/liquid_by_holder")
CASE = "case"
"""Key of the name among the `facts`: it may differ for user-defined scenes, and wherever another setting may."""
PROPERTIES = "liquid properties"
"""Key of surface tension, viscosity and density, which a dry scene has not."""
FILMS = "initial films"
"""Key of the thicknesses of the first films by class, of which the key `liquid` has the largest."""
EXTENTS = "wall extents"
"""Key of the corners of a box around each wall, which are read from the run directory."""
DECIMALS = 9
"""Decimal places [m] to which the extents of walls agree."""
HASHED = ("trajectory", "history/events", "history/contacts", "history/films", "results/fraction_retained")


@dataclass(frozen=True)
class Quantity:
    """A number or a curve; `times` [s] is empty for a number. `scale` is the size that deviations are relative to."""

    name: str
    unit: str
    values: Floats
    times: Floats
    scale: float
    interval: Ends = None
    """Ends of the 95 % interval of a number within the run; None if the run provides none."""
    of_screen: bool = False
    """Whether it is a result of `pywet screen`."""

    def at(self, times: Floats) -> Floats:
        """Return the values at other times, interpolated linearly between outputs; a number is constant."""
        return self.values if len(self.times) == 0 else np.interp(times, self.times, self.values)


@dataclass(frozen=True)
class RunData:
    """One run: its folder, the simulated case, its quantities and the results of its own checks."""

    path: Path
    scene: EngineScene
    quantities: dict[str, Quantity]
    checks: dict[str, tuple[bool, float]]
    """Name -> (passed, value); not part of the statistics."""
    held: dict[str, Any]
    """Amount of data in the run, all that its scene planned: steps, outputs, windows, rows of each table."""
    notes: list[str] = field(default_factory=list)
    """Decks whose cut size sizes on both sides do not enclose or that are not steady; the end of a part."""

    def fingerprint(self) -> dict[str, str]:
        """Digest of the content of each table (not of its file)."""
        hashes = {}
        for name in HASHED:
            table = RunDir(self.path).table_if_there(name)
            if table is not None:
                rows = pd.util.hash_pandas_object(table, index=False).to_numpy()
                hashes[name] = hashlib.sha256(rows.tobytes()).hexdigest()[:16]
        return hashes


def facts(scene: EngineScene, folder: Path | None = None) -> dict[str, Any]:
    """Return what defines the case of a scene as plain data; laws, time step, engine and seed are not part of it.

    `folder`: the run directory, for the initial films and the extents of the walls. The duration of a run with `until`
    is that of a block, since their number depends on the seed.
    """
    motions = (scene.slide, scene.rotation, *(w.motion_parameters for w in scene.walls))
    message = {
        CASE: scene.name,
        "sphere classes": [[c.radius_m, c.density_kg_per_m3, c.count, c.passes_aperture] for c in scene.classes],
        "liquid": None if scene.liquid is None else scene.liquid.initial_film_thickness_m,
        PROPERTIES: None if scene.liquid is None else scene.liquid.model_dump(exclude={"initial_film_thickness_m"}),
        "materials": [[p.friction, p.rolling_friction_m, p.restitution] for p in scene.pairs],
        "contact angles": [c.contact_angle_rad for c in scene.classes] + [w.contact_angle_rad for w in scene.walls],
        "duration": scene.block_s if scene.blocks else scene.duration_s,
        "walls": [[w.name, w.reservoir, w.motion, len(w.triangle_part)] for w in scene.walls],
        "hertz": None if scene.hertz is None else scene.hertz.model_dump(mode="json"),
        "vibration": None if scene.vibration is None else scene.vibration.model_dump(mode="json"),
        "gravity": scene.gravity_m_per_s2,
        "stiffness": [p.normal_stiffness_N_per_m for p in scene.pairs],
        "motions": [None if m is None else m.model_dump(mode="json") for m in motions],
        "half widths": [sorted({h for h in w.part_half_width_m if h is not None}) for w in scene.walls],
        "periodic": [scene.periodic, scene.periods_m],
        "outlets": [outlet.model_dump(mode="json") for outlet in scene.outlets],
        "insertion": [None if c.insertion is None else c.insertion.model_dump(mode="json") for c in scene.classes],
        FILMS: None if folder is None else _films(RunDir(folder)),
        EXTENTS: None if folder is None else _extents(RunDir(folder)),
    }
    return dict(json.loads(json.dumps(message)))


def _films(run: RunDir) -> list[list[float]] | None:
    """Return the different thicknesses of the first films on the spheres of each class [m]; None for a dry scene."""
    spheres = run.table_if_there("history/spheres")
    if run.scene.liquid is None or spheres is None:
        return None
    thickness = film_thickness(spheres["film"], spheres["radius"]).groupby(spheres["type"]).unique()
    return [sorted({float(f"{value:.6g}") for value in of}) for of in thickness]


def _extents(run: RunDir) -> list[list[float]] | None:
    """Return the smallest and the largest coordinates of each wall at the start [m]; None without walls."""
    if not (run.path / "history" / "triangles.parquet").exists():
        return None
    corners = [run.corners_at_rest[run.meshes == wall.name].reshape(-1, 3) + run.origin_m for wall in run.scene.walls]
    return [np.concatenate([at.min(axis=0), at.max(axis=0)]).round(DECIMALS).tolist() for at in corners if len(at)]


def beyond_seed(one: EngineScene, other: EngineScene) -> list[str]:
    """Name the settings in which two scenes differ, without the seed and what depends on it."""
    less = {"seed", "spheres_file", "box_low_m", "box_high_m", "bin_z_m"}
    differs = [name for name, value in one if name not in less and value != getattr(other, name)]
    return differs or ["their descriptions"]


def unlike(
    wanted: dict[str, Any], scene: EngineScene, across: Sequence[str] = (), folder: Path | None = None
) -> list[str]:
    """Name the `facts` in which two scenes differ; settings in `across` may differ, and then the name too.

    `folder`: the run directory of the scene.
    """
    there, free = facts(scene, folder), {*across, *([CASE] if across else [])}
    if unknown := [name for name in across if name not in wanted]:
        known = ", ".join(name for name in wanted if name != CASE)
        raise PywetError(
            f"--across {unknown[0]} was given; expected a setting that may differ: {known}",
            code="compare.across", key="--across", given=unknown[0], expected=known,
        )  # fmt: skip
    free |= {name for name in (PROPERTIES, FILMS, EXTENTS) if None in (wanted.get(name), there[name])}
    if "liquid" in free or wanted.get("liquid") != there["liquid"]:
        free.add(FILMS)
    return [name for name in wanted if name not in free and wanted[name] != there.get(name)]


def read_run(run_dir: Path, end_s: float | None = None) -> RunData:
    """Read all quantities of a complete run that are compared; those of its screen are means, all others end at `end_s` [s]."""
    run = RunDir(Path(run_dir))
    scene, held, screens = run.scene, _whole(run), _evaluated(run)
    part = common_end.beginning(run, end_s)
    quantities = [*_screen(screens), *_retained(part), *_liquid(part), *_counts(part), *_energies(part), *_bed(part)]
    if not quantities:
        raise PywetError(
            f"{run.path} has no results; expected a finished run: run it again",
            code="compare.no_results", where=run.path,
        )  # fmt: skip
    where = {of: screening_report.cut_position(numbers) for of, numbers in screens.items()}
    notes = [f"{of}cut size: {position}" for of, position in where.items() if position != WITHIN]
    notes += [f"{of}{warning}" for of, n in screens.items() if (warning := screening_report.unsteady(n))]
    if part is not run:
        notes.append(f"all but the screen: of the first {end_s:.4g} s, which all runs reach,")
    return RunData(run.path, scene, {q.name: q for q in quantities}, dict(_checks(run)), held, notes)


def _whole(run: RunDir) -> dict[str, Any]:
    """Return the extent of a complete run; refuse a run with fewer outputs or rows of results than its scene plans."""
    try:
        held = whole.check(run.path)
    except ReplayError as error:
        raise PywetError(str(error), code="compare.not_whole", where=run.path) from error
    for name in RESULTS:
        table = run.table_if_there(name)
        if table is not None:
            held["rows"][name] = len(table)
            if len(table) != held["outputs"]:
                raise PywetError(
                    f"{run.path / name}.parquet holds {len(table)} rows; expected one for each of the {held['outputs']} output "
                    "steps: run the case again",
                    code="compare.rows", given=len(table), expected=held["outputs"], where=run.path / f"{name}.parquet",
                )  # fmt: skip
    return held


def _curve(name: str, unit: str, times: Any, values: Any, scale: float) -> Quantity:
    return Quantity(name, unit, np.asarray(values, float), np.asarray(times, float), max(abs(scale), 1e-300))


def _number(name: str, unit: str, value: float, scale: float) -> Quantity:
    return _curve(name, unit, [], [value], scale)


def _evaluated(run: RunDir) -> dict[str, dict[str, Any]]:
    """Return the evaluations of the decks of a scene with outlets, by the beginning of the names of their numbers."""
    decks = range(1, streams.decks(run.scene) + 1) if run.scene.outlets else ()
    every = {f"deck {deck}, " if deck > 1 else "": screening_report.stored(run.path, deck) for deck in decks}
    return {of: numbers for of, numbers in every.items() if numbers}


def _screen(screens: dict[str, dict[str, Any]]) -> Iterator[Quantity]:
    """Yield the results of decks, each with its interval within the run."""
    for of, numbers in screens.items():
        for name, unit, value, ends, scale in _of_screen(numbers):
            if value is not None:
                yield replace(_number(f"{of}{name}", unit, value, scale or abs(value)), interval=ends, of_screen=True)


def _of_screen(numbers: dict[str, Any]) -> Iterator[tuple[str, str, float | None, Ends, float]]:
    """Yield name, unit, value, ends of the interval and scale (0: the value) of each compared number of screen.json."""

    def around(value: float | None, half: float | None) -> Ends:
        return None if value is None or half is None else (value - half, value + half)

    def ends(key: str, unit: str = "") -> Ends:
        return numbers.get(f"{key}_low{unit}"), numbers.get(f"{key}_high{unit}")

    rates, moist = numbers["throughput_t_per_h"], numbers["moisture_percent_of_dry_mass"]
    scatter = numbers.get("moisture_half_width_percent") or {}
    share = numbers.get("pegged_share")
    yield "cut size", "mm", numbers["d50_mm"], ends("d50", "_mm"), 0.0
    yield "efficiency", "1", numbers["efficiency"], ends("efficiency"), 1.0
    rate = rates.get("all")
    yield "throughput", "t/h", rate, around(rate, numbers["throughput_half_width_t_per_h"].get("all")), 0.0
    for product in streams.PRODUCTS:
        value = moist[product]
        yield f"moisture of the {product}", "%", value, around(value, scatter.get(product)), 0.0
    yield "apertures pegged", "1", share, around(share, numbers.get("pegged_share_half_width")), 1.0


def _retained(run: RunDir) -> Iterator[Quantity]:
    """Yield the fraction retained over time, in total and per class."""
    table = run.table_if_there("results/fraction_retained")
    if table is None:
        return
    for column in table.columns:
        if column.startswith("fraction_retained"):
            yield _curve(column.replace("_", " "), "1", table["time_s"], table[column], 1.0)


def _liquid(run: RunDir) -> Iterator[Quantity]:
    """Yield liquid by reservoir over time, over the initial liquid; for a small scene films, bridges and walls of the ledger."""
    table, ledger = run.table_if_there("results/liquid_by_holder"), run.table_if_there("history/ledger")
    if not run.moist:
        return
    if table is not None:
        for column in table.columns:
            if column.endswith("_m3") and column not in ("initial_m3", "total_m3"):
                name = column.removesuffix("_m3").replace("_", " ")
                yield _curve(
                    f"liquid {name}", "of all", table["time_s"], table[column] / table["initial_m3"].max(), 1.0
                )
    elif ledger is not None:
        put_in = ledger["initial"].max()  # with inserted spheres: the total at the end
        for column in ("films", "bridges", "walls"):
            yield _curve(f"liquid {column}", "of all", ledger["time"], ledger[column] / (put_in or 1.0), 1.0)


def _counts(run: RunDir) -> Iterator[Quantity]:
    """Yield the total numbers of formations and ruptures, and the active bridges over time."""
    ledger = run.table_if_there("history/ledger")
    if ledger is None:
        return
    end = ledger.sort_values("step").iloc[-1]
    for name in ("formations", "ruptures"):
        yield _number(name, "events", end[name], max(float(end["formations"]), 1.0))
    count = ledger["bridge_count"]
    yield _curve("active bridges", "bridges", ledger["time"], count, max(count.max(), 1.0))


def _energies(run: RunDir) -> Iterator[Quantity]:
    """Yield energies and works at the end, over the largest of them."""
    table, summary = run.table_if_there("history/energy"), run.summary
    if table is not None and not table.empty:
        end = table.sort_values("step").iloc[-1].drop(["step", "time"])
        values = {str(k): float(v) for k, v in end.items() if k != "half_kick"}
    elif summary is not None:
        values = {k: float(v) for k, v in (summary.get("energy_J") or {}).items() if v is not None}
    else:
        return
    scale = max([abs(v) for v in values.values()], default=0.0)
    for name, value in values.items():
        yield _number(f"energy {name.replace('_', ' ')}", "J", value, scale)


def _bed(run: RunDir) -> Iterator[Quantity]:
    """Yield the state of the bed at the end: mean height, height of the upper tenth, touching neighbours per sphere."""
    places = run.table_if_there("trajectory")
    if places is None or places.empty:
        return
    end = places[places["step"] == places["step"].max()].sort_values("id")
    radius = end["type"].map({c.type: c.radius_m for c in run.scene.classes}).to_numpy(float)
    up = -np.asarray(run.scene.gravity_m_per_s2)
    up = up / np.linalg.norm(up) if up.any() else np.array([0.0, 0.0, 1.0])
    at = end[["x", "y", "z"]].to_numpy(float)
    height = at @ up
    yield _number("mean height at the end", "m", height.mean(), float(radius.max()))
    yield _number("upper tenth at the end", "m", np.quantile(height + radius, 0.9), float(radius.max()))
    yield _number("neighbours per sphere at the end", "1", coordination(at, radius), 1.0)


def _checks(run: RunDir) -> Iterator[tuple[str, tuple[bool, float]]]:
    """Yield liquid ledger and replay: each run passes or fails independently of the other."""
    ledger = run.table_if_there("history/ledger")
    if ledger is not None:
        error = ledger_error(ledger)
        yield "liquid ledger", (error <= LEDGER_TOLERANCE, error)
    replay = run.replay
    if replay is not None:
        worst = max((q["largest"] for q in replay["quantities"].values()), default=0.0)
        yield "replay", (bool(replay.get("ok")), float(worst))
    for check in run.summary["checks"] if run.summary else ():
        yield str(check["name"]).replace("_", " "), (bool(check["ok"]), float(check["value"]))
