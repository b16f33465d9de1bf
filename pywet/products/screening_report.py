"""Results of a screen from a run: cut size, efficiency, throughput, moisture, pegging; `results/screen.json` and tables."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.products import apertures, flowsheet, intervals, streams
from pywet.products.apertures import of_deck
from pywet.products.partition import WITHIN, Separation, partition_curve, separation, size_at
from pywet.products.steady import block_mean
from pywet.products.streams import PRODUCTS, Streams
from pywet.runs.rundir import RunDir
from pywet.util.files import finite, write_csv, write_json, write_table
from pywet.util.notices import notice
from pywet.util.ranges import LIMITS

PER_HOUR = 3.6
"""Factor from kg/s to t/h."""
MOST_PASSED = 0.95
"""Share of the passing mass of a batch up to which its throughput is computed."""
PEGGED = ("pegged", "pegged_half_width", "pegged_share", "pegged_share_half_width")
"""Numbers on pegging, None for a screen that is not horizontal."""
RESULT = "screen"
"""Name of the file with the results."""


def curve_of(run: RunDir, flow: Streams) -> pd.DataFrame:
    """Return the partition curve of the counted spheres."""
    counted, classes = flow.counted, run.scene.classes
    number = {
        p: np.array([int(((counted["product"] == p) & (counted["type"] == c.type)).sum()) for c in classes])
        for p in PRODUCTS
    }
    sizes, masses = (np.array(values) for values in zip(*((2.0 * c.radius_m, c.mass_kg) for c in classes), strict=True))
    curve = partition_curve(sizes, number["overs"], number["unders"], masses)
    if curve["diameter_mm"].is_unique:
        return curve
    return pd.DataFrame([{"diameter_mm": d, **_joined(rows)} for d, rows in curve.groupby("diameter_mm")])


def _joined(rows: pd.DataFrame) -> pd.Series:
    """Combine classes of the same size into one by adding their masses."""
    sums = rows[["feed_kg", "overs_kg", "unders_kg"]].sum()
    t = sums["overs_kg"] / sums["feed_kg"]
    return pd.Series({**sums, "T": t, "T_low": rows["T_low"].min(), "T_high": rows["T_high"].max()})


def moisture_percent(spheres: pd.DataFrame, density: float) -> float:
    """Return liquid over the dry mass of spheres [%]; nan without spheres."""
    mass = spheres["mass_kg"].sum()
    return float(100.0 * density * spheres["liquid_m3"].sum() / mass) if mass > 0 else math.nan


def analyse(
    run_dir: Path, aperture_mm: float | None = None, from_s: float | None = None, deck: int = 1
) -> tuple[dict[str, Any], pd.DataFrame, pd.DataFrame]:
    """Numbers, partition curve and time series of a finished run.

    Parameters
    ----------
    run_dir : Path
        Of a screening case or of a custom scene with outlets.
    aperture_mm : float, optional
        Size that parts undersize from oversize; if not given that of the case or of the deck, else the cut size.
    from_s : float, optional
        Time from which means are taken; if not given, from where the run is steady.
    deck : int
        Of several decks the one meant, counted from above.
    """
    run = RunDir(Path(run_dir))
    flow = streams.read(run, from_s, deck)
    aperture = aperture_of(run, deck) if aperture_mm is None else LIMITS["aperture_mm"].read("aperture_mm", aperture_mm)
    curve = curve_of(run, flow)
    numbers = separation(curve, aperture)
    series = time_series(run, flow)
    cut = {"d50_low_mm": size_at(curve, 0.5, "T_high"), "d50_high_mm": size_at(curve, 0.5, "T_low")}
    ends = dict(
        zip(("efficiency_low", "efficiency_high"), intervals.of_efficiency(curve, numbers.reference_mm), strict=True)
    )
    return {**_numbers(run, flow, numbers, series), **cut, **ends}, curve, series


def aperture_of(run: RunDir, deck: int = 1) -> float | None:
    """Return the aperture of the screen of a case or of a deck [mm]; None for a deck of the user's own walls."""
    if given := apertures.deck_of(run):
        levels = [given, *(given.get("beneath") or ())]
        return float(levels[deck - 1]["aperture_mm"]) if deck <= len(levels) else None
    config: dict[str, Any] = run.json("config.json", dict[str, Any]) or {}
    value = (config.get("case") or {}).get("aperture_mm")
    return float(value) if value is not None else None


def _numbers(run: RunDir, flow: Streams, numbers: Separation, series: pd.DataFrame) -> dict[str, Any]:
    counted, scene, line = flow.counted, run.scene, run.timeline
    feed = pd.DataFrame({"mass_kg": line.mass, "liquid_m3": line.initial_film})[line.entered_by_end]
    density = scene.liquid.density_kg_per_m3 if scene.liquid else 0.0
    of = {p: counted[counted["product"] == p] for p in PRODUCTS}
    screen = apertures.screen_of(run, flow.deck)
    area = apertures.area(run, screen) if screen else None
    return {
        "run": scene.name, "deck": flow.deck,
        "kind": "continuous" if flow.continuous else "batch",
        "from_s": flow.start_s, "to_s": flow.end_s, "steady": flow.steady,
        **asdict(numbers),
        "spheres": {p: len(rows) for p, rows in of.items()},
        **_throughput(run, flow, of, area),
        "moisture_percent_of_dry_mass": {p: moisture_percent(rows, density) for p, rows in of.items()},
        "moisture_half_width_percent": {
            p: intervals.of_moisture(rows, density, flow.continuous) for p, rows in of.items()
        },
        "feed_moisture_percent": moisture_percent(feed, density),
        "spilled_share": streams.spilled_share(run),
        "residence_s": {p: _residence(rows) for p, rows in of.items()},
        **_of_screen(run, flow, series),
    }  # fmt: skip


def _residence(rows: pd.DataFrame) -> dict[str, float]:
    """Return mean, median and 90 % point of the time from entering to leaving [s]; for a batch from its opening to the bin."""
    times = (rows["left_s"] - rows["entered_s"]).dropna()
    if times.empty:
        return dict.fromkeys(("mean", "median", "p90"), math.nan)
    return {"mean": float(times.mean()), "median": float(times.median()), "p90": float(times.quantile(0.9))}


def _throughput(run: RunDir, flow: Streams, of: dict[str, pd.DataFrame], area: float | None) -> dict[str, Any]:
    """Return dry t/h of both products and in total, with block-averaged intervals; for a batch up to the passage of 95 %."""
    if flow.continuous:
        times = streams.edges(run.scene, flow.end_s)
        times = times[times >= flow.start_s - 1e-9]
        rates = {p: [PER_HOUR * v for v in block_mean(streams.flux(rows, times))] for p, rows in of.items()}
        rates["all"] = [PER_HOUR * v for v in block_mean(streams.flux(pd.concat(of.values()), times))]
    else:
        unders = of["unders"].sort_values(["left_s", "id"])
        passed = unders["mass_kg"].cumsum().to_numpy()
        rates = {"unders": [0.0, math.nan]}
        if len(passed):
            k = int(np.searchsorted(passed, (MOST_PASSED - 1e-9) * passed[-1]))
            took = float(unders["left_s"].iloc[k]) - flow.start_s
            rates = {"unders": [PER_HOUR * passed[k] / took if took > 0 else math.nan, math.nan]}
    per_area = {p: (value[0] / area if area else None) for p, value in rates.items()}
    return {"throughput_t_per_h": {p: v[0] for p, v in rates.items()},
            "throughput_half_width_t_per_h": {p: v[1] for p, v in rates.items()},
            "screen_area_m2": area, "throughput_t_per_h_m2": per_area}  # fmt: skip


def time_series(run: RunDir, flow: Streams) -> pd.DataFrame:
    """Return, by output, masses inside and of both products, their liquid, that on screen and cross wires, pegged spheres."""
    line, spheres = run.timeline, flow.spheres
    frame = pd.DataFrame({"step": line.steps, "time_s": line.times})
    frame["hold_up_kg"] = streams.hold_up(spheres, line.times)
    for product in PRODUCTS:
        rows = spheres[spheres["product"] == product]
        left = rows["left_s"].to_numpy()[None, :] <= line.times[:, None] + 1e-9
        frame[f"{product}_kg"] = (left * rows["mass_kg"].to_numpy()).sum(axis=1)
        frame[f"{product}_liquid_m3"] = (left * rows["liquid_m3"].to_numpy()).sum(axis=1)
    screen = apertures.screen_of(run, flow.deck)
    if screen:
        net = dict.fromkeys((screen.name, of_deck(apertures.CROSS, flow.deck)), "screen")
        frame["screen_liquid_m3"] = run.on_walls(net, "mesh")["screen"].to_numpy()
    if screen and not apertures.not_level(run, screen):
        stuck = apertures.pegged(run, screen) & line.entered
        for kind in run.scene.classes:
            frame[f"pegged_{kind.type}"] = stuck[:, line.types == kind.type].sum(axis=1)
    return frame


def _of_screen(run: RunDir, flow: Streams, series: pd.DataFrame) -> dict[str, Any]:
    """Return liquid on the screen and pegged apertures over the averaging period; empty if no wall is the screen.

    A sphere blocks an aperture, or its diameter of a slot.
    """
    screen = apertures.screen_of(run, flow.deck)
    if screen is None:
        return {"screen": None}
    rows = series[(series["time_s"] >= flow.start_s) & (series["time_s"] <= flow.end_s)]
    number, liquid = (
        apertures.count(run, screen, flow.deck),
        block_mean(rows["screen_liquid_m3"].to_numpy(dtype=float))[0],
    )
    found = {"screen": screen.name, "apertures": number, "screen_liquid_m3": liquid}
    if why := apertures.not_level(run, screen):
        return {**found, **dict.fromkeys(PEGGED), "pegged_undefined": why}
    pegged = rows[[f"pegged_{c.type}" for c in run.scene.classes]].to_numpy(dtype=float)
    slot = apertures.slot_length(run, screen, flow.deck)
    blocks = np.array([2.0 * c.radius_m / slot if slot else 1.0 for c in run.scene.classes])
    mean, blocked = block_mean(pegged.sum(axis=1)), block_mean(pegged @ blocks)
    values = (*mean, *(value / number for value in blocked))
    return {**found, **dict(zip(PEGGED, values, strict=True))}


def write(
    run_dir: Path, aperture_mm: float | None = None, from_s: float | None = None, deck: int = 1
) -> dict[str, Any]:
    """Write the numbers, the partition curve and the series of a screen to results/ and return the numbers.

    The files are screen.json, partition and screen_series (Parquet and CSV), and for process models grade_efficiency.csv and
    flowsheet.csv; for a deck beneath, its number is in their names.
    """
    numbers, curve, series = analyse(run_dir, aperture_mm, from_s, deck)
    numbers["options"] = {k: v for k, v in (("aperture", aperture_mm), ("from", from_s)) if v is not None}
    folder = Path(run_dir) / "results"
    write_table(curve, folder / f"{of_deck('partition', deck)}.parquet", csv=True)
    write_table(series, folder / f"{of_deck('screen_series', deck)}.parquet", csv=True)
    write_csv(flowsheet.grade_efficiency(curve), folder / f"{of_deck('grade_efficiency', deck)}.csv")
    write_csv(flowsheet.fitted(curve), folder / f"{of_deck('flowsheet', deck)}.csv")
    defined: dict[str, Any] = finite(numbers)
    write_json(folder / f"{of_deck(RESULT, deck)}.json", defined)
    return defined


def cut_position(numbers: dict[str, Any]) -> str:
    """Return where the cut size is among the sizes, or why there is none; of older results only whether there is one."""
    return str(numbers.get("d50_position") or (WITHIN if numbers["d50_mm"] is not None else "outside the sizes"))


def unsteady(numbers: dict[str, Any]) -> str | None:
    """Return a sentence if the means are not those of a steady state."""
    if numbers["steady"]:
        return None
    return f"not steady: means over the last {numbers['to_s'] - numbers['from_s']:.3g} s of the feed"


def tables(run: RunDir, deck: int = 1) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Read the partition curve and the time series of the last evaluation of a deck, whatever its options."""
    curve, series = (run.table(f"results/{of_deck(name, deck)}") for name in ("partition", "screen_series"))
    return curve, series


def stored(run_dir: Path, deck: int = 1) -> dict[str, Any] | None:
    """Return the numbers of a deck without options of `pywet screen`; those stored with options are computed again."""
    return _stored(RunDir(Path(run_dir)), deck)[0]


def stored_with_tables(run_dir: Path, deck: int = 1) -> tuple[dict[str, Any], pd.DataFrame, pd.DataFrame] | None:
    """Return the numbers of `stored` with their partition curve and time series; None for a run without them."""
    run = RunDir(Path(run_dir))
    numbers, again = _stored(run, deck)
    return None if numbers is None else (numbers, *(again or tables(run, deck)))


def _stored(run: RunDir, deck: int) -> tuple[dict[str, Any] | None, tuple[pd.DataFrame, pd.DataFrame] | None]:
    """Return the numbers of `stored` and, if they were computed again, their tables."""
    name = f"results/{of_deck(RESULT, deck)}.json"
    numbers: dict[str, Any] | None = run.json(name, dict[str, Any])
    if not numbers or not (given := numbers.get("options")):
        return numbers, None
    options = " ".join(f"--{name} {value:g}" for name, value in given.items())
    return _again(run.path, deck, options, json.dumps(numbers))


@lru_cache(maxsize=16)
def _again(
    run_dir: Path, deck: int, options: str, found_with_them: str
) -> tuple[dict[str, Any], tuple[pd.DataFrame, pd.DataFrame]]:
    """Evaluate a deck without options, once for each result that has them, so that one notice says so."""
    notice.warning("%s was last evaluated with %s: evaluated here without, as other runs", run_dir, options)
    found, curve, series = analyse(run_dir, deck=deck)
    return finite(found), (curve, series)
