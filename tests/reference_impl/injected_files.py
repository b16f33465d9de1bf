"""Faults injected in the files of one sound screening run, before the engine (the scene) and after it (the results).

Each changes files of a copy and says in which quantity it must show and by which words it must be named.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.scene import stl

Change = Callable[[Path], None]
RADIANS = math.pi / 180.0


@dataclass(frozen=True)
class Injected:
    """A change of a run directory, the quantity it must show in, and words of the sentence that names it."""

    change: Change
    quantity: str
    words: str


def edit(file: str, change: Callable[[Any], Any]) -> Change:
    """A JSON file changed in place."""

    def apply(folder: Path) -> None:
        content = json.loads((folder / file).read_text())
        change(content)
        (folder / file).write_text(json.dumps(content))

    return apply


def times(path: str, factor: float, file: str = "scene.json") -> Change:
    """A number of a JSON file times a factor; `path` by keys, positions and names of listed groups."""

    def apply(content: Any) -> None:
        group, key = _found(content, path)
        group[key] *= factor

    return edit(file, apply)


def put(path: str, value: Any, file: str = "scene.json") -> Change:
    """A value of a JSON file replaced."""

    def apply(content: Any) -> None:
        group, key = _found(content, path)
        group[key] = value

    return edit(file, apply)


def exchange(one: str, other: str, file: str = "scene.json") -> Change:
    """Two values of a JSON file exchanged."""

    def apply(content: Any) -> None:
        (a, i), (b, j) = _found(content, one), _found(content, other)
        a[i], b[j] = b[j], a[i]

    return edit(file, apply)


def _found(content: Any, path: str) -> tuple[Any, Any]:
    """The group that holds the last key of a path, and that key; a pair of types is `1-0`."""
    keys, group = path.split("."), content
    for n, word in enumerate(keys):
        key: Any = word
        if isinstance(group, list):
            named = [
                k
                for k, g in enumerate(group)
                if isinstance(g, dict) and word in (g.get("name"), f"{g.get('a')}-{g.get('b')}")
            ]
            key = named[0] if named else int(word)
        if n == len(keys) - 1:
            return group, key
        group = group[key]
    raise AssertionError(path)


def mesh(name: str, change: Callable[[np.ndarray], np.ndarray]) -> Change:
    """The corners of an STL file changed."""

    def apply(folder: Path) -> None:
        path = folder / "stl" / f"{name}.stl"
        data = path.read_bytes()
        records = np.frombuffer(data, stl.RECORD, offset=84).copy()
        records["corners"] = change(records["corners"].astype(float))
        path.write_bytes(data[:84] + records.tobytes())

    return apply


def thinner(corners: np.ndarray) -> np.ndarray:
    """Every wire 0.2 % thinner about its axis."""
    found, body = corners.copy(), stl.bodies(corners)
    for k in range(int(body.max()) + 1):
        points = corners[body == k]
        low, high = points.min(axis=(0, 1)), points.max(axis=(0, 1))
        along = int(np.argmax((high - low)[:2]))
        shrink = np.where(np.arange(3) == along, 1.0, 0.998)
        middle = 0.5 * (low + high)
        found[body == k] = middle + (points - middle) * shrink
    return found


def scaled(factor: tuple[float, float, float]) -> Callable[[np.ndarray], np.ndarray]:
    """All corners times a factor along each axis."""
    return lambda corners: corners * np.array(factor)


def lifted(amount: float) -> Callable[[np.ndarray], np.ndarray]:
    """All corners higher by an amount [m]."""
    return lambda corners: corners + np.array([0.0, 0.0, amount])


def top_lifted(amount: float) -> Callable[[np.ndarray], np.ndarray]:
    """The highest corners higher by an amount [m]."""
    return lambda c: c + np.where(c[:, :, 2:] > c[:, :, 2].max() - 1e-6, np.array([0.0, 0.0, amount]), 0.0)


def table(name: str, change: Callable[[pd.DataFrame], pd.DataFrame | None], csv: bool = False) -> Change:
    """A Parquet table changed (and its CSV, where it has one)."""

    def apply(folder: Path) -> None:
        path = folder / f"{name}.parquet"
        frame = pd.read_parquet(path)
        changed = change(frame)
        frame = frame if changed is None else changed
        frame.to_parquet(path, index=False)
        if csv:
            frame.to_csv(path.with_suffix(".csv"), index=False)

    return apply


def text(file: str, pattern: str, replacement: Callable[[re.Match[str]], str]) -> Change:
    """A text file changed where a pattern first fits."""

    def apply(folder: Path) -> None:
        output_text, count = re.subn(pattern, replacement, (folder / file).read_text(), count=1, flags=re.MULTILINE)
        assert count == 1, pattern
        (folder / file).write_text(output_text)

    return apply


def factor_in(file: str, pattern: str, factor: float) -> Change:
    """A number of a text file times a factor; the pattern's first group is the text before it, the second the number."""
    return text(file, pattern, lambda m: f"{m[1]}{float(m[2]) * factor!r}")


def both(*changes: Change) -> Change:
    """One after the other."""

    def apply(folder: Path) -> None:
        for change in changes:
            change(folder)

    return apply


def column(frame: str, name: str, change: Callable[[pd.DataFrame], Any]) -> Change:
    """A column of a table of results (Parquet and CSV) replaced."""

    def apply(rows: pd.DataFrame) -> None:
        rows[name] = change(rows)

    return table(f"results/{frame}", apply, csv=True)


def columns_exchanged(frame: str, one: str, other: str) -> Change:
    """Two columns of a table of results exchanged."""

    def apply(rows: pd.DataFrame) -> None:
        rows[one], rows[other] = rows[other].to_numpy(copy=True), rows[one].to_numpy(copy=True)

    return table(f"results/{frame}", apply, csv=True)


def _other_part(content: Any) -> None:
    content["walls"][0]["triangle_part"][20] = 0


def _closer(rows: pd.DataFrame) -> None:
    rows.loc[1, ["x", "y", "z"]] = rows.loc[0, ["x", "y", "z"]].to_numpy() + np.array([1e-3, 0.0, 0.0])


def _node_off(rows: pd.DataFrame) -> None:
    rows.loc[3, "v0_x"] += 1e-5


def _film(rows: pd.DataFrame) -> None:
    rows.loc[rows["type"] == 3, "film"] *= 1.001


SETUP, RUN, DATA = (f"engine/{name}" for name in ("setup.liggghts", "run.liggghts", "particles.data"))
NUMBERS, WALLS, START, DECK = "scene_numbers", "scene_walls", "scene_start", "scene_deck"
SCENE: dict[str, Injected] = {
    "density 0.1 % high": Injected(times("classes.large.density_kg_per_m3", 1.001), NUMBERS,
        "classes.large.density_kg_per_m3 is 1343.8425, expected 1342.5 (materials.yaml: spheres.POM.sizes density_kg_per_m3)"),
    "densities of two classes exchanged": Injected(
        exchange("classes.small.density_kg_per_m3", "classes.large.density_kg_per_m3"), NUMBERS,
        "it is what classes.large.density_kg_per_m3 should be"),
    "radius for diameter": Injected(times("classes.small.radius_m", 2.0), NUMBERS, "classes.small.radius_m is 0.005"),
    "a class that passes is said to stay": Injected(put("classes.near_mesh.passes_aperture", False), NUMBERS,
        "classes.near_mesh.passes_aperture is false, expected true"),
    "names of two classes exchanged": Injected(exchange("classes.0.name", "classes.2.name"), NUMBERS, "classes is ['large'"),
    "angles of two walls exchanged": Injected(
        exchange("walls.wires.contact_angle_rad", "walls.feed_bin.contact_angle_rad"), NUMBERS,
        "walls.wires.contact_angle_rad is 0.872664626, expected 0.785398163 (materials.yaml: walls.steel.contact_angle_deg); "
        "it is what walls.feed_bin.contact_angle_rad should be"),
    "angle in degrees": Injected(times("classes.small.contact_angle_rad", 1.0 / RADIANS), NUMBERS,
        "degrees taken for radians"),
    "a reservoir under another name": Injected(put("walls.slide.reservoir", "side_wall"), NUMBERS,
        "walls.slide.reservoir is side_wall, expected slide"),
    "a wall that should vibrate rests": Injected(put("walls.wires.motion", "fixed"), NUMBERS,
        "walls.wires.motion is fixed, expected vibrates"),
    "surface tension 0.1 % low": Injected(times("liquid.surface_tension_N_per_m", 0.999), NUMBERS,
        "liquid.surface_tension_N_per_m is 0.07267725, expected 0.07275"),
    "viscosity in mPa s": Injected(times("liquid.viscosity_Pa_s", 1000.0), NUMBERS, "thousandths of the unit"),
    "density of the liquid 1000": Injected(put("liquid.density_kg_per_m3", 1000.0), NUMBERS,
        "liquid.density_kg_per_m3 is 1000, expected 998.2"),
    "film 0.1 % thick": Injected(times("liquid.initial_film_thickness_m", 1.001), NUMBERS, "liquid.initial_film_thickness_m"),
    "stiffness not softened": Injected(times("pairs.1-2.normal_stiffness_N_per_m", 100.0), NUMBERS,
        "pairs.1-2.normal_stiffness_N_per_m is 100000, expected 1000"),
    "tangential spring as the normal one": Injected(times("pairs.2-0.tangential_stiffness_N_per_m", 3.5), NUMBERS,
        "it is what pairs.2-0.normal_stiffness_N_per_m should be"),
    "friction of walls and spheres exchanged": Injected(exchange("pairs.1-0.friction", "pairs.1-1.friction"), NUMBERS,
        "it is what pairs.1-1.friction should be"),
    "rolling friction halved": Injected(times("pairs.3-3.rolling_friction_m", 0.5), NUMBERS, "half of it"),
    "restitution 0.1 % low": Injected(times("pairs.3-0.restitution", 0.999), NUMBERS, "pairs.3-0.restitution"),
    "amplitude 0.1 % high": Injected(times("vibration.amplitude_m.2", 1.001), NUMBERS, "vibration.amplitude_m.z"),
    "amplitudes of x and z exchanged": Injected(exchange("vibration.amplitude_m.0", "vibration.amplitude_m.2"), NUMBERS,
        "it is what vibration.amplitude_m.z should be"),
    "phases of x and y exchanged": Injected(exchange("vibration.phase_rad.0", "vibration.phase_rad.1"), NUMBERS,
        "it is what vibration.phase_rad.y should be"),
    "frequency 50 Hz": Injected(put("vibration.frequency_Hz", 50.0), NUMBERS, "vibration.frequency_Hz is 50, expected 50.6"),
    "time step 0.1 % long": Injected(times("time_step_s", 1.001), NUMBERS, "time_step_s"),
    "slide opens late": Injected(times("slide.opens_at_s", 1.001), NUMBERS, "slide.opens_at_s is 0.2002, expected 0.2"),
    "slide drawn faster": Injected(times("slide.velocity_m_per_s.0", 1.001), NUMBERS, "slide.velocity_m_per_s.x"),
    "slide drawn half way": Injected(times("slide.travel_s", 0.5), NUMBERS, "half of it"),
    "height of the bin 0.1 % off": Injected(times("bin_z_m", 1.001), NUMBERS, "bin_z_m"),
    "gravity 9.8": Injected(put("gravity_m_per_s2.2", -9.8), NUMBERS, "gravity_m_per_s2.z is -9.8, expected -9.81"),
    "an effect left out": Injected(put("effects.dynamic_rupture", None), NUMBERS,
        "effects.dynamic_rupture is none, expected pitois"),
    "a law of the other preset": Injected(put("effects.rupture", "young_laplace"), NUMBERS,
        "effects.rupture is young_laplace, expected willett_unequal"),
    "films on walls off": Injected(put("effects.wall_films", False), NUMBERS, "effects.wall_films is false, expected true"),
    "semi-implicit drag": Injected(put("viscous_integration", "semi_implicit"), NUMBERS,
        "viscous_integration is semi_implicit, expected explicit"),
    "another seed": Injected(put("seed", 10009), NUMBERS, "seed is 10009, expected 10007"),
    "apertures 0.1 % wide": Injected(mesh("wires", scaled((1.001, 1.0, 1.0))), WALLS,
        "wires along y.aperture_m (measured on the STL) is 0.008008"),
    "wires 0.2 % thin": Injected(mesh("wires", thinner), WALLS, "wires along x.diameter_m (measured on the STL) is 0.0019959"),
    "screen 0.1 mm high": Injected(mesh("wires", lifted(1e-4)), WALLS, "height of their axes"),
    "side wall 0.1 % high": Injected(mesh("side_wall", top_lifted(4e-5)), WALLS, "side_wall, upper end"),
    "sieve 0.1 % wide": Injected(mesh("side_wall", scaled((1.001, 1.001, 1.0))), WALLS, "side_wall, axis to inner face"),
    "plate steeper": Injected(mesh("impact_plate", scaled((1.0, 1.0, 1.01))), WALLS, "impact_plate, angle [rad]"),
    "bin higher": Injected(mesh("collecting_bin", lifted(1e-4)), WALLS, "collecting_bin, floor"),
    "cover lower": Injected(mesh("cover", lifted(-5e-5)), WALLS, "cover, upper face"),
    "slide lower": Injected(mesh("slide", lifted(-5e-5)), WALLS, "slide, upper face"),
    "box too small": Injected(times("box_high_m.2", 0.999), WALLS, "box_high_m.z"),
    "half width of a wire is its diameter": Injected(times("walls.wires.part_half_width_m.3", 2.0), WALLS,
        "walls.wires.part_half_width_m[3] is 0.002, expected 0.001"),
    "a triangle in another wire's part": Injected(edit("scene.json", _other_part), WALLS,
        "wires, parts that are one bar is 13"),
    "a node of the table off": Injected(table("history/triangles", _node_off), "scene_tables",
        "history/triangles.v0_x (row 3)"),
    "areas halved": Injected(table("history/triangles", lambda t: t.assign(area=0.5 * t["area"])), "scene_tables",
        "history/triangles.area"),
    "reservoirs in the table exchanged": Injected(
        table("history/triangles", lambda t: t.assign(reservoir=t["reservoir"].replace({"outlet": "slide", "slide": "outlet"}))),
        "scene_tables", "history/triangles.reservoir"),
    "angles of parts in degrees": Injected(
        table("history/parts", lambda t: t.assign(contact_angle=t["contact_angle"] / RADIANS)), "scene_tables",
        "history/parts.contact_angle"),
    "first films of one class 0.1 % thick": Injected(table("history/spheres", _film), START, "history/spheres.film of large"),
    "radii of the table": Injected(table("history/spheres", lambda t: t.assign(radius=1.001 * t["radius"])), START,
        "history/spheres.radius of small"),
    "two spheres in one place": Injected(table("spheres", _closer), START,
        "pairs of spheres that overlap at the start is 1, expected 0"),
    "spheres start in the wall": Injected(table("spheres", lambda t: t.assign(x=t["x"] + 0.02)), START, "feed bin's wall"),
    "viscosity passed to the plugin": Injected(times("viscosity", 1.001, "history/meta.json"), "scene_told", "meta.viscosity"),
    "angle passed to the plugin": Injected(times("types.1.contact_angle", 0.5, "history/meta.json"), "scene_told",
        "meta.near_mesh.contact_angle"),
    "time step of the deck": Injected(factor_in(SETUP, r"^(timestep\s+)(\S+)", 1.001), DECK, "deck: timestep"),
    "stiffness of the deck": Injected(factor_in(SETUP, r"^(fix\s+p_kn .* peratomtypepair 4 )(\S+)", 2.0), DECK,
        "deck: kn of 1-1"),
    "dashpot of the deck": Injected(factor_in(SETUP, r"^(fix\s+p_gamman_abs .* peratomtypepair 4 )(\S+)", 1.001), DECK,
        "deck: gamman_abs of 1-1"),
    "phase of the deck": Injected(text(SETUP, r"phase -1.5707\S+", lambda _: "phase 0.0"), DECK, "deck: wires.phase.z is 0"),
    "a mover missing": Injected(text(SETUP, r"^fix\s+move_outlet_1 .*$", lambda _: ""), DECK, "deck: outlet.amplitude.y is 0"),
    "slide of the deck opens late": Injected(text(RUN, r"^run\s+(\d+)", lambda m: f"run {int(m[1]) + 50}"), DECK,
        "deck: step at which the slide opens"),
    "density in the data file": Injected(text(DATA, r" 1342\.5 ", lambda _: " 1343.9 "), DECK, "deck: density of large"),
    "diameter in the data file": Injected(text(DATA, r" 3 0\.01 ", lambda _: " 3 0.005 "), DECK, "deck: diameter of large"),
}  # fmt: skip

Y, L = "fraction_retained", "liquid_by_holder"
OF_Y, OF_L, SUMMARY, CHECKS = f"results_{Y}", f"results_{L}", "results_summary", "results_checks"
SCREEN, SERIES = "results/screen.json", "screen_series"
OF_SCREEN, OF_PARTITION, OF_SERIES = "results_screen", "results_partition", f"results_{SERIES}"


def _one(rows: pd.DataFrame) -> Any:
    values = rows["wires_m3"].to_numpy(copy=True)
    values[20] *= 1.0001
    return values


RESULTS: dict[str, Injected] = {
    "classes exchanged": Injected(columns_exchanged(Y, f"{Y}_small", f"{Y}_near_mesh"), OF_Y,
        f"it holds what {Y}_near_mesh should hold"),
    "dry masses only": Injected(column(Y, Y, lambda t: t[f"{Y}_spheres"]), OF_Y, f"it holds what {Y}_spheres should hold"),
    "per cent": Injected(column(Y, Y, lambda t: 100.0 * t[Y]), OF_Y, "per cent for a share"),
    "a millionth off": Injected(column(Y, f"{Y}_large", lambda t: t[f"{Y}_large"] * (1 + 1e-6)), OF_Y, "it is 1 + 1e-06 times"),
    "one output late": Injected(column(Y, f"{Y}_small", lambda t: t[f"{Y}_small"].shift(1, fill_value=1.0)), OF_Y,
        "it is 1 output late"),
    "two outputs early": Injected(column(Y, f"{Y}_small", lambda t: t[f"{Y}_small"].shift(-2, fill_value=0.0)), OF_Y,
        "it is 2 outputs early"),
    "time from the start": Injected(column(Y, "time_since_opening_s", lambda t: t["time_s"]), OF_Y,
        "it holds what time_s should hold"),
    "opening 10 ms off": Injected(column(Y, "time_since_opening_s", lambda t: t["time_since_opening_s"] + 0.01), OF_Y,
        "it is shifted by 0.01 s"),
    "time in ms": Injected(column(L, "time_s", lambda t: 1e3 * t["time_s"]), OF_L, "thousandths of the unit"),
    "steps counted from one": Injected(column(Y, "step", lambda t: t["step"] + 1), OF_Y,
        "row of step 0 is missing, expected there"),
    "a row missing": Injected(table(f"results/{Y}", lambda t: t.drop(index=7), csv=True), OF_Y, "is missing, expected there"),
    "a row twice": Injected(table(f"results/{L}", lambda t: pd.concat([t, t.iloc[[5]]]), csv=True), OF_L, "is there twice"),
    "last row missing": Injected(table(f"results/{L}", lambda t: t.iloc[:-1], csv=True), OF_L, "is missing, expected there"),
    "rows turned round": Injected(table(f"results/{Y}", lambda t: t.iloc[::-1], csv=True), OF_Y, "rows is in another order"),
    "a column missing": Injected(table(f"results/{L}", lambda t: t.drop(columns="outlet_m3"), csv=True), OF_L,
        "column outlet_m3 is missing"),
    "a column besides": Injected(column(L, "wall_m3", lambda t: 0.0), OF_L, "column wall_m3 is there, expected none"),
    "reservoirs exchanged": Injected(columns_exchanged(L, "wires_m3", "side_wall_m3"), OF_L,
        "it holds what side_wall_m3 should hold"),
    "coarse and fines exchanged": Injected(columns_exchanged(L, "coarse_material_m3", "fines_m3"), OF_L,
        "it holds what fines_m3 should hold"),
    "the plate's liquid on the outlet": Injected(column(L, "outlet_m3", lambda t: t["outlet_m3"] + t["impact_plate_m3"]), OF_L,
        "impact_plate_m3 is in it besides"),
    "fines without their smallest": Injected(column(L, "fines_m3", lambda t: t["fines_m3"] - t["fines_small_m3"]), OF_L,
        "it holds what fines_near_mesh_m3 should hold"),
    "unit mm3": Injected(column(L, "coarse_material_m3", lambda t: 1e9 * t["coarse_material_m3"]), OF_L, "mm3 for m3"),
    "bridges counted half": Injected(column(L, "standing_bridges_m3", lambda t: 0.5 * t["standing_bridges_m3"]), OF_L,
        "half of it"),
    "a wall without its bridges": Injected(column(L, "side_wall_m3", lambda t: 0.9 * t["side_wall_m3"]), OF_L,
        "it is 0.9 times"),
    "one value of one row": Injected(column(L, "wires_m3", _one), OF_L, "in this row alone"),
    "total of the start": Injected(column(L, "total_m3", lambda t: 1.001 * t["total_m3"]), OF_L, "it is 1.001 times"),
    "not a number": Injected(column(Y, Y, lambda t: np.nan), OF_Y, f"{Y} at step 0 is nan"),
    "counts exchanged": Injected(columns_exchanged(Y, "spheres_on_screen", "spheres_in_bin"), OF_Y,
        "it holds what spheres_in_bin should hold"),
    "the CSV of another run": Injected(text(f"results/{Y}.csv", r"^(\d+,[^,]+,[^,]+),([^,]+)", lambda m: f"{m[1]},0.5"), OF_Y,
        f"results/{Y}.csv: {Y} at step 0 is 0.5, expected 1"),
    "a check turned": Injected(put("2.ok", False, "results/checks.json"), CHECKS,
        "liquid_accounted_for.ok is false, expected true"),
    "a check with a wide limit": Injected(put("2.limit", 1.0, "results/checks.json"), CHECKS,
        "liquid_accounted_for.limit is 1"),
    "spheres lost in the sentence": Injected(
        text("results/checks.json", r"(\d+)( missing at most)", lambda m: f"3{m[2]}"), CHECKS, "numbers in the sentence"),
    "summary: mass in g": Injected(times("mass_kg", 1e3, "summary.json"), SUMMARY, "summary.json: mass_kg"),
    "summary: Y at the end": Injected(times("fraction_retained_end", 1.001, "summary.json"), SUMMARY, "fraction_retained_end"),
    "summary: coarse share": Injected(put("coarse_share", 0.5, "summary.json"), SUMMARY, "summary.json: coarse_share is 0.5"),
    "summary: spheres exchanged": Injected(exchange("spheres.small", "spheres.large", "summary.json"), SUMMARY,
        "it is what summary.json: spheres.large should be"),
    "summary: liquid of two reservoirs exchanged": Injected(
        exchange("liquid_end_m3.outlet", "liquid_end_m3.wires", "summary.json"), SUMMARY,
        "it is what summary.json: liquid_end_m3.wires should be"),
    "summary: formations and ruptures exchanged": Injected(exchange("events.formations", "events.ruptures",
        "summary.json"), SUMMARY,
        "it is what summary.json: events.ruptures should be"),
    "summary: work of gravity turned": Injected(times("energy_J.gravity", -1.0, "summary.json"), SUMMARY,
        "the sign is turned"),
    "summary: kinetic energy of the start": Injected(times("energy_J.kinetic", 0.5, "summary.json"), SUMMARY, "half of it"),
    "summary: a law that did not act": Injected(put("effects.capillary", "lambert", "summary.json"), SUMMARY,
        "effects.capillary is lambert, expected rabinovich"),
    "summary: liquid put in": Injected(times("initial_liquid_m3", 1.001, "summary.json"), SUMMARY, "initial_liquid_m3"),
    "summary: another seed": Injected(put("seed", 1, "summary.json"), SUMMARY, "summary.json: seed is 1, expected 10007"),
    "summary: ledger": Injected(put("ledger_error", 1e-3, "summary.json"), SUMMARY, "ledger_error"),
    "summary: spheres that came back": Injected(put("spheres_that_came_back_from_the_bin", 7, "summary.json"), SUMMARY,
        "came_back_from_the_bin is 7"),
    "summary: speed": Injected(times("particle_steps_per_s", 1.001, "summary.json"), SUMMARY, "particle_steps_per_s"),
    "screen: area 1 % off": Injected(both(times("screen_area_m2", 1.01, SCREEN),
        times("throughput_t_per_h_m2.unders", 1 / 1.01, SCREEN)), OF_SCREEN, "screen_area_m2 is 0.002525, expected 0.0025"),
    "screen: wires counted for gaps": Injected(both(put("apertures", 36, SCREEN), times("pegged_share", 25 / 36, SCREEN),
        times("pegged_share_half_width", 25 / 36, SCREEN)), OF_SCREEN, "apertures is 36, expected 25"),
    "screen: none": Injected(put("screen", None, SCREEN), OF_SCREEN, "screen is none, expected wires"),
    "screen: aperture in m": Injected(times("reference_mm", 1e-3, SCREEN), OF_SCREEN, "reference_mm is 0.008, expected 8"),
    "screen: means from the start": Injected(put("from_s", 0.0, SCREEN), OF_SCREEN, "from_s is 0, expected 0.2"),
    "screen: feed moisture of the moist mass": Injected(times("feed_moisture_percent", 1 / 1.05, SCREEN), OF_SCREEN,
        "feed_moisture_percent"),
    "partition: T of the unders": Injected(column("partition", "T", lambda t: 1.0 - t["T"]), OF_PARTITION,
        "results/partition.parquet: T at size"),
    "partition: ends of the interval exchanged": Injected(columns_exchanged("partition", "T_low", "T_high"), OF_PARTITION,
        "it holds what T_high should hold"),
    "partition: feed in g": Injected(column("partition", "feed_kg", lambda t: 1e3 * t["feed_kg"]), OF_PARTITION,
        "thousandths of the unit"),
    "partition: coarsest size missing": Injected(table("results/partition", lambda t: t.iloc[:-1], csv=True), OF_PARTITION,
        "row of size 3 is missing, expected there"),
    "grade efficiency: size in mm": Injected(
        text("results/grade_efficiency.csv", r"^0.00", lambda _: ""), "results_grade_efficiency", "x_m at size 1"),
    "flowsheet: a reason changed": Injected(
        text("results/flowsheet.csv", r"(\d) are needed", lambda m: f"{int(m[1]) + 1} are needed"), "results_flowsheet",
        "Plitt"),
    "series: products exchanged": Injected(columns_exchanged(SERIES, "overs_kg", "unders_kg"), OF_SERIES,
        "it holds what overs_kg should hold"),
    "series: hold-up an output late": Injected(
        column(SERIES, "hold_up_kg", lambda t: t["hold_up_kg"].shift(1, fill_value=0.0)), OF_SERIES, "it is 1 output late"),
    "series: a sphere more pegs": Injected(column(SERIES, "pegged_1", lambda t: t["pegged_1"] + 1), OF_SERIES,
        "it is shifted by 1"),
    "series: liquid on the screen in mm3": Injected(
        column(SERIES, "screen_liquid_m3", lambda t: 1e9 * t["screen_liquid_m3"]), OF_SERIES, "mm3 for m3"),
}  # fmt: skip

W, C = "liquid_by_wall", "contact_statistics"
CUSTOM: dict[str, Injected] = {
    "own: liquid of two walls exchanged": Injected(columns_exchanged(W, "wall_front_m3", "wall_mantle_m3"), f"results_{W}",
        "it holds what wall_mantle_m3 should hold"),
    "own: a bridge counted once": Injected(column(C, "bridges_per_sphere", lambda t: t["bridges_per_sphere"] / 2), f"results_{C}",
        "half of it"),
    "own: overlaps over the diameter": Injected(column(C, "mean_overlap", lambda t: 0.5 * t["mean_overlap"]), f"results_{C}",
        "half of it"),
    "own: largest for mean speed": Injected(
        column(C, "mean_speed_m_per_s", lambda t: t["largest_speed_m_per_s"]), f"results_{C}",
        "it holds what largest_speed_m_per_s should hold"),
    "own: height of the centre downwards": Injected(
        column(C, "centre_of_mass_height_m", lambda t: -t["centre_of_mass_height_m"]), f"results_{C}", "the sign is turned"),
    "own: contacts one output late": Injected(
        column(C, "contacts_per_sphere", lambda t: t["contacts_per_sphere"].shift(1, fill_value=0.0)), f"results_{C}",
        "it is 1 output late"),
    "own: a row missing": Injected(table(f"results/{W}", lambda t: t.drop(index=3), csv=True), f"results_{W}", "is missing"),
    "own: a table missing": Injected(lambda f: (f / "results" / f"{C}.csv").unlink(), f"results_{C}",
        f"results/{C}.csv is missing, expected there"),
    "own: contacts at the end": Injected(times("contacts_end.contacts_per_sphere", 1.001, "summary.json"), SUMMARY,
        "contacts_end.contacts_per_sphere"),
}  # fmt: skip
"""Faults of the results of the shipped drum, a custom scene."""
