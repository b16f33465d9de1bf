"""What several programs answer to the wet benchmark problems, and their scores: scores.csv and docs/wet_benchmarks.md.

python benchmarks/wet/programs.py measure [PROGRAM ...]    answers into results/wet/, minutes for each engine
python benchmarks/wet/programs.py seeds [PROBLEM ...]      beds and drums in LIGGGHTS and YADE into seeds.csv, an hour
python benchmarks/wet/programs.py page                     scores.csv and the page from the answers there are

Any program can have its answers in results/wet/PROGRAM/PROBLEM.csv: `page` puts their scores in place of the stored ones, and
leaves those of programs without new answers. Results of beds and drums are in seeds.csv.
"""

from __future__ import annotations

import csv
import math
import runpy
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import chain, product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.colors import LogNorm

from pywet.cases.small import bodies, bridge_engine, bridge_query, small
from pywet.collisions.spheres import command as davis
from pywet.geometry.solids import wire
from pywet.geometry.surface import make_surface
from pywet.laws import registry
from pywet.laws.kinds import SWITCHED
from pywet.report.pictures import STYLE, plt, svg
from pywet.util.files import atomic_write, read_json, read_table, write_csv

HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parents[1]))
from studies.davis2023 import engine as spheres_engine  # noqa: E402
from studies.engines import bed as settling  # noqa: E402
from studies.pair import Pair  # noqa: E402
from studies.stock.liggghts import liggghts_force  # noqa: E402
from studies.stock.yade import yade_force  # noqa: E402

ANSWERS = Path("results") / "wet"
SCORE, MAKE = (runpy.run_path(str(HERE / name)) for name in ("score.py", "make.py"))
BRIDGES = ("pair_at_rest", "unequal_pair", "sphere_and_plate")
STOKES_FORCE = "adams_perchard"
BEGIN, END = "<!-- scores -->", "<!-- end of scores -->"
Row = dict[str, Any]


def asked(problem: str) -> Iterator[tuple[str, dict[str, Any], list[dict[str, Any]]]]:
    """Each case: its name, its inputs (those of all cases among them), what is asked."""
    inputs, answers = read_json(HERE / problem / "inputs.json", ""), SCORE["load"](problem)["answers"]
    common = {key: value for key, value in inputs.items() if key != "cases"}
    for case, given in inputs["cases"].items():
        yield case, {**common, **given}, [a for a in answers if a["case"] == case]


def pair(given: dict[str, Any]) -> Pair:
    """A case's bodies and bridge."""
    angles = math.radians(given["contact_angle_1_deg"]), math.radians(given["contact_angle_2_deg"])
    second = given["radius_2_m"] or math.inf
    tension = given.get("surface_tension_N_per_m", 0.0728)
    return Pair("wet", given["radius_1_m"], second, given["volume_m3"], angles, tension)


def bridges(forces: Callable[[Pair, list[float]], dict[str, Any]]) -> Iterator[Row]:
    """Answers to the three problems of a bridge at rest from `forces`: a list `force` and a number `rupture`."""
    for problem in BRIDGES:
        for case, given, wanted in asked(problem):
            gaps = [a["at"] for a in wanted if a["quantity"] == "force"]
            found = forces(pair(given), gaps)
            for gap, force in zip(gaps, found["force"], strict=True):
                yield row(problem, case, "force", gap, force)
            yield row(problem, case, "rupture distance", 0.0, found["rupture"])


def row(problem: str, case: str, quantity: str, at: float, value: float | None) -> Row:
    """One answer; none where the program has no value."""
    none = value is None or not math.isfinite(value)
    return {"problem": problem, "case": case, "quantity": quantity, "at": at, "value": None if none else value}


def by_law(capillary: str, rupture: str, engine: str | None = None) -> Callable[[], Iterator[Row]]:
    """pywet's laws, called from Python, or measured in an engine."""

    def ask(query: bridge_query.Query) -> dict[str, Any]:
        return bridge_engine.measured(query, engine) if engine else bridge_query.answer(query)

    def forces(two: Pair, gaps: list[float]) -> dict[str, Any]:
        answer = ask(two.query(gaps, laws=list(dict.fromkeys((capillary, rupture)))))
        return {"force": answer["force_N"][capillary], "rupture": answer["rupture_distance_m"][rupture]}

    def answers() -> Iterator[Row]:
        yield from bridges(forces)
        yield from pulls(capillary, rupture, engine) if engine else drags()
        yield from splits(capillary, rupture, ask)
        yield from wires(capillary, rupture, engine)

    return answers


def splits(capillary: str, rupture: str, ask: Callable[[bridge_query.Query], dict[str, Any]]) -> Iterator[Row]:
    """Rupture distance and sharing by pywet's laws."""
    model = "young_laplace" if capillary == "young_laplace" else "parabola"
    for case, given, wanted in asked("rupture_and_sharing"):
        answer = ask(pair(given).query([0.0], laws=list(dict.fromkeys((capillary, rupture)))))
        values = {
            "rupture distance": answer["rupture_distance_m"][rupture],
            "share of body 1": answer["transfer_ratio"][model],
        }
        for a in wanted:
            yield row("rupture_and_sharing", case, a["quantity"], a["at"], values[a["quantity"]])


def wires(capillary: str, rupture: str, engine: str | None) -> Iterator[Row]:
    """Sphere and wire over sphere and plate at touch; pywet's laws take no wire, it counts as a plane in every preset."""
    for case, given, wanted in asked("wire"):
        ratio = 1.0
        if engine:
            r, angle = given["wire_radius_m"], math.radians(given["contact_angle_deg"])
            ends = (np.array((side * 10.0 * given["radius_m"], 0.0, -r)) for side in (-1.0, 1.0))
            round_ = make_surface("wire", "wall", [(wire(*ends, r, 32, 10.0), r)])
            touch = Pair("wet", given["radius_m"], math.inf, wanted[0]["at"], (angle, angle), 0.0728)
            query = touch.query([0.0], laws=list(dict.fromkeys((capillary, rupture))))
            forces = [bridge_engine.measured(query, engine, wall=w)["force_N"][capillary][0] for w in (round_, None)]
            ratio = forces[0] / forces[1]
        yield from (row("wire", case, a["quantity"], a["at"], ratio) for a in wanted)


def pulls(capillary: str, rupture: str, engine: str) -> Iterator[Row]:
    """Yield the forces of the viscous pull measured in an engine, in a bridge that reaches beyond the largest gap."""
    for case, given, wanted in asked("viscous_pull"):
        common = {
            "viscosity_Pa_s": given["viscosity_Pa_s"],
            "laws": list(dict.fromkeys((capillary, rupture, STOKES_FORCE))),
        }
        if case == "drawn apart":
            angle, tension = math.radians(given["contact_angle_deg"]), given["surface_tension_N_per_m"]
            drop = Pair("wet", given["radius_m"], given["radius_m"], given["volume_m3"], (angle, angle), tension)
            still, slow, fast = (
                bridge_engine.measured(drop.query([0.0], velocity_m_per_s=v, **common), engine, stretch)[
                    "rupture_distance_m"
                ][rupture]
                for v, stretch in ((1e-3, None), *((v, "pitois") for v in given["speeds_m_per_s"]))
            )
            power = math.log((fast / still - 1.0) / (slow / still - 1.0)) / math.log(
                given["speeds_m_per_s"][1] / given["speeds_m_per_s"][0]
            )
            yield row("viscous_pull", case, wanted[0]["quantity"], wanted[0]["at"], power)
            continue
        r, gaps = given["radius_m"], [a["at"] for a in wanted]
        two = Pair("wet", r, math.inf if case == "plate" else r, 1e-10, (0.0, 0.0), 0.0728)
        found = bridge_engine.measured(two.query(gaps, velocity_m_per_s=given["speed_m_per_s"], **common), engine)
        for a, force in zip(wanted, found["viscous_normal_N"][STOKES_FORCE], strict=True):
            yield row("viscous_pull", case, "force", a["at"], force)


def drags() -> Iterator[Row]:
    """Lubrication by the law for full immersion, with the least gap that all viscous laws add."""
    law = registry.get("viscous_normal", STOKES_FORCE).functions[0]
    stretch = registry.get("dynamic_rupture", "pitois").functions[0]
    for case, given, wanted in asked("viscous_pull"):
        if case == "drawn apart":
            slow, fast = (
                stretch(v, given["viscosity_Pa_s"], given["surface_tension_N_per_m"]) - 1.0
                for v in given["speeds_m_per_s"]
            )
            power = math.log(fast / slow) / math.log(given["speeds_m_per_s"][1] / given["speeds_m_per_s"][0])
            yield row("viscous_pull", case, wanted[0]["quantity"], wanted[0]["at"], power)
            continue
        r, second = given["radius_m"], math.inf if case == "plate" else given["radius_m"]
        for a in wanted:
            force = -law(a["at"], 1e-9, r, second, given["speed_m_per_s"], given["viscosity_Pa_s"])
            yield row("viscous_pull", case, "force", a["at"], force)


def stock(force: Callable[[Any], Any]) -> Callable[[], Iterator[Row]]:
    """A program's own bridge model: its force, and where it ends."""

    def forces(two: Pair, gaps: list[float]) -> dict[str, Any]:
        values = force(two.points(np.array(gaps)))["force"].tolist()
        fine = np.linspace(0.3, 2.0, 300) * two.limit("exact")
        pulls = np.abs(force(two.points(fine))["force"].to_numpy(float)) > 0.0
        ends = bool(pulls.any()) and not pulls[-1]
        last = int(np.flatnonzero(pulls)[-1]) if ends else 0
        return {"force": values, "rupture": float(fine[last : last + 2].mean()) if ends else None}

    return lambda: (
        r for r in bridges(lambda two, gaps: forces(two, gaps) if two.angles[0] == two.angles[1] else _none(gaps))
    )


def _none(gaps: list[float]) -> dict[str, Any]:
    """Two contact angles in one bridge are more than stock models know."""
    return {"force": [None] * len(gaps), "rupture": None}


def collisions() -> Iterator[Row]:
    """`pywet collide spheres`: three spheres, and two head on."""
    for case, given, wanted in asked("three_spheres"):
        problem = {key: value for key, value in given.items() if key not in ("problem", "units", "model")}
        state = davis.collide(problem)["final"]["velocity"]
        for a in wanted:
            axis, sphere = a["quantity"].split()
            yield row("three_spheres", case, a["quantity"], a["at"], state[int(sphere) - 1]["xy".index(axis[1])])

    for case, given, wanted in asked("wet_rebound"):
        if case.startswith("two spheres"):
            yield from (row("wet_rebound", case, a["quantity"], a["at"], rebound(given, a["at"])) for a in wanted)


def three_in_the_engine(engine: str) -> Iterator[Row]:
    """Yield the three-sphere results of an engine with the laws of `pywet.laws.davis` and contacts of 1e9 N/m."""
    for case, given, wanted in asked("three_spheres"):
        if (given["h_a"], given["h_min"], given["e_dry"]) != (spheres_engine.H_A, spheres_engine.H_MIN, 1):
            continue
        with tempfile.TemporaryDirectory(prefix="pywet-wet-") as folder:
            found = spheres_engine.in_engine(
                Path(folder), given["St_n"], given["theta12_deg"], None, given["t_end"], 1e9, given["mu_f"], engine
            )
        for a in wanted:
            axis, sphere = a["quantity"].split()
            yield row(
                "three_spheres", case, a["quantity"], a["at"], found.velocity[-1, int(sphere) - 1, "xy".index(axis[1])]
            )


def rebound(given: dict[str, Any], stokes: float) -> float:
    """Restitution of two equal spheres head on, from their velocities when the films have parted; 0 where they stick."""
    radius, mass, viscosity = 1e-3, 1e-5, 0.1
    speed = stokes * 6.0 * math.pi * viscosity * (0.5 * radius) ** 2 / (0.5 * mass)
    apart = 2.0 * radius + given["film_m"]
    spheres = [
        {
            "radius_m": radius,
            "mass_kg": mass,
            "position_m": [x, 0.0],
            "velocity_m_per_s": [v, 0.0],
            "film_m": 0.5 * given["film_m"],
        }
        for x, v in ((0.0, speed), (apart, 0.0))
    ]
    answer = davis.collide(
        {
            "form": "spheres", "spheres": spheres, "viscosity_Pa_s": viscosity, "h_min_m": given["roughness_m"],
            "e_dry": given["dry_restitution"], "mu_f": 0.0, "t_end_s": 100.0 * given["film_m"] / speed,
        }
    )  # fmt: skip
    (one, _), (two, _) = answer["final"]["velocity"]
    return 0.0 if answer["stuck_pairs"] else (two - one) / speed


def walls() -> Iterator[Row]:
    """`pywet collide wall`, the model of Buck et al. (2018): how straight restitution is over 1/St."""
    model = runpy.run_path(str(HERE / "measured.py"))
    for case, _, wanted in asked("wet_rebound"):
        for a in (a for a in wanted if a["quantity"] == "straightness over 1/St"):
            yield row("wet_rebound", case, a["quantity"], a["at"], 1.0 - model["bend"](*model["restitution"](a["at"])))


DRAGS = ("holds", "cavitates", "thinning film")
"""How a film is read while the spheres leave it: `outward` of the cases, and their law in rebound_laws.py by its first word."""
RADIUS, SPEED, STIFFNESS, LONG = 1e-3, 0.01, 1e5, 60.0
"""Of the spheres that rebound in the engine [m, m/s, N/m], and how many passages of the film are waited for."""


def rebounds(engine: str) -> Iterator[Row]:
    """Restitution in an engine with a drag for each way to read the film, one run a case."""
    laws = {way: f"{HERE / 'rebound_laws.py'}:{way.partition(' ')[0]}" for way in DRAGS}
    for case, given, wanted in asked("wet_rebound"):
        if given.get("outward") in laws:
            values = engine_rebounds(given, [a["at"] for a in wanted], laws[given["outward"]], engine)
            yield from (
                row("wet_rebound", case, a["quantity"], a["at"], v) for a, v in zip(wanted, values, strict=True)
            )


def engine_rebounds(given: dict[str, Any], stokes: list[float], law: str, engine: str) -> list[float]:
    """Spheres side by side, as heavy as their Stokes number wants, thrown at a plate or at their like at rest; no capillarity.

    In lubrication the speed is a straight line over ln h, by which it is read where the sphere leaves the film.
    """
    pairs, rough, film = given["outward"] == "thinning film", given["roughness_m"], given["film_m"]
    classes = bodies.sphere_classes(*[RADIUS] * len(stokes), counts=1 + pairs, density=[50.0 * st for st in stokes])
    reduced, mass = RADIUS * (0.5 if pairs else 1.0), classes[0].mass_kg * (0.5 if pairs else 1.0)
    viscosity = mass * SPEED / (6.0 * math.pi * reduced**2 * stokes[0])
    touch, gap = (2.0 if pairs else 1.0) * RADIUS, film - rough
    thrown = []
    for k in range(len(stokes)):
        x = 6.0 * RADIUS * (k - 0.5 * len(stokes))
        thrown += [small.Sphere(k + 1, (x, 0.0, 0.0))] if pairs else []
        thrown.append(small.Sphere(k + 1, (x, 0.0, touch + 1.001 * gap), (0.0, 0.0, -SPEED)))
    step = 0.04 * math.pi * math.sqrt(mass / STIFFNESS)
    steps = round(LONG * film / SPEED / step)
    drag = small.PAPER.model_copy(update={**dict.fromkeys(SWITCHED), "viscous_normal": law, "rolling": False})
    with tempfile.TemporaryDirectory(prefix="pywet-wet-") as name:
        folder = Path(name)
        small.prepare(
            folder, classes, thrown, bodies.contacts(len(stokes), STIFFNESS, friction=0.0, restitution=given["dry_restitution"]),
            liquid=bodies.water((0.5 if pairs else 1.0) * gap, viscosity), effects=drag, time_step_s=step, steps=steps,
            walls=() if pairs else (small.floor(),), log_every_step=False, output_interval_s=max(1, steps // 4000) * step,
        )  # fmt: skip
        small.run(folder, thrown, engine=engine)
        way = read_table(folder / "trajectory.parquet")
    return [left(way[way["type"] == k + 1], touch - rough, film) for k in range(len(stokes))]


def left(way: pd.DataFrame, apart: float, film: float) -> float:
    """Speed where the film is left over the first, of the way of a sphere (or two); 0 where it is not left."""
    z, v = (way.pivot_table(name, "step", "id").to_numpy() for name in ("z", "vz"))
    h, speed = (c[:, -1] - (c[:, 0] if c.shape[1] > 1 else 0.0) for c in (z - [0.0, apart][-z.shape[1] :], v))
    out = np.flatnonzero((h[1:] >= film) & (speed[1:] > 0.0))
    if len(out) == 0:
        return 0.0
    two = slice(out[0], out[0] + 2)
    return float(np.interp(math.log(film), np.log(h[two]), speed[two])) / SPEED


def beds(engine: str) -> Iterator[Row]:
    """Means over the same first arrangements of spheres as in seeds.csv: five of the bed, three of the drum."""
    for problem, case, wanted in ((p, case, wanted) for p in BEDS for case, _, wanted in asked(p)):
        with tempfile.TemporaryDirectory(prefix="pywet-wet-") as name:
            folders = [Path(name) / str(seed) for seed in SEEDS[problem]]
            for seed, folder in zip(SEEDS[problem], folders, strict=True):
                settling.prepare(folder, replace(BEDS[problem], seed=seed), wet=case == "moist")
                small.run(folder, [], engine=engine)
            ends = pd.DataFrame([settling.measure(folder) for folder in folders])
        for a in wanted:
            yield row(problem, case, a["quantity"], a["at"], ends[ENDS[a["quantity"]]].mean())


def by_seed(names: list[str]) -> None:
    """Run the beds of the problems named, of both where none is, from each first arrangement: means into seeds.csv."""
    for problem in names or BEDS:
        runs = []
        for seed in SEEDS[problem]:
            with tempfile.TemporaryDirectory(prefix="pywet-wet-") as name:
                runs.append(settling.settle(Path(name), replace(BEDS[problem], seed=seed)))
            print(runs[-1].to_string(), flush=True)
        of = pd.concat(runs).groupby("engine")
        rows = []
        for (engine, (program, case)), (quantity, unit) in product(ENGINES.items(), ASKED[problem].items()):
            values = of.get_group(engine)[ENDS[quantity]]
            if values.notna().all():
                means = {"mean": f"{values.mean():.2f}", "deviation": f"{values.std():.2f}"}
                rows.append({"program": program, "problem": problem, "case": case, "quantity": quantity, "unit": unit,
                             "seeds": len(values), **means})  # fmt: skip
        stored = pd.read_csv(HERE / "seeds.csv", dtype=str)
        write_csv(pd.concat([stored[stored["problem"] != problem], pd.DataFrame(rows)]), HERE / "seeds.csv")


ENDS = {
    "mean height": "mean_height_over_radius",
    "contacts per sphere": "contacts_per_sphere",
    "bridges per sphere": "bridges_per_sphere",
    "dynamic angle": "dynamic_angle_deg",
}
"""Quantity of the problem -> of `studies.engines.bed`."""
SEEDS = {"settling_bed": range(1, 6), "drum": range(1, 4)}
BEDS = {"settling_bed": settling.Bed(), "drum": settling.Bed(spheres=200, seconds=1.5, drum=True)}
ASKED = {
    "settling_bed": {"mean height": "radii", "contacts per sphere": "1", "bridges per sphere": "1"},
    "drum": {"dynamic angle": "degree"},
}
"""Quantities of each problem and their units."""
ENGINES = {
    settling.OURS: (MAKE["SEEDED"], "moist"),
    settling.DRY: (MAKE["SEEDED"], "dry"),
    "YADE": ("YADE, Rabinovich", "moist"),
    "YADE, dry": ("YADE, Rabinovich", "dry"),
    "washino": ("LIGGGHTS, washino", "moist"),
    "easo": ("LIGGGHTS, easo", "moist"),
}
"""Name in a bed's table -> program and case."""

PROGRAMS: dict[str, Callable[[], Iterator[Row]]] = {
    "pywet laws, preset exact": by_law("young_laplace", "young_laplace"),
    "pywet laws, preset paper": by_law("rabinovich", "willett_unequal"),
    "pywet laws, Willett": by_law("willett", "willett"),
    "LIGGGHTS + pywet, exact": by_law("young_laplace", "young_laplace", "liggghts"),
    "LIGGGHTS + pywet, paper": by_law("rabinovich", "willett_unequal", "liggghts"),
    "LAMMPS + pywet, exact": by_law("young_laplace", "young_laplace", "lammps"),
    "LAMMPS + pywet, paper": lambda: chain(by_law("rabinovich", "willett_unequal", "lammps")(), beds("lammps")),
    "LIGGGHTS, washino": stock(lambda points: liggghts_force(points, "washino")),
    "LIGGGHTS, easo": stock(lambda points: liggghts_force(points, "easo")),
    "YADE, Rabinovich": stock(lambda points: yade_force(points, "Rabinovich")),
    "YADE, Willett": stock(lambda points: yade_force(points, "Willett_numeric")),
    "pywet collide spheres": collisions,
    "pywet collide wall": walls,
    "LIGGGHTS + pywet, laws of Davis": lambda: three_in_the_engine("liggghts"),
    "LAMMPS + pywet, laws of Davis": lambda: three_in_the_engine("lammps"),
    "LIGGGHTS + pywet, custom laws": lambda: rebounds("liggghts"),
    "LAMMPS + pywet, custom laws": lambda: rebounds("lammps"),
}


def measure(names: list[str]) -> None:
    """Write the answers of programs, a CSV for each problem."""
    for name in names or PROGRAMS:
        by_problem: dict[str, list[Row]] = {}
        for answer in PROGRAMS[name]():
            by_problem.setdefault(answer.pop("problem"), []).append(answer)
        folder = ANSWERS / name
        folder.mkdir(parents=True, exist_ok=True)
        for problem, rows in by_problem.items():
            with open(folder / f"{problem}.csv", "w", newline="", encoding="utf-8") as file:
                table = csv.DictWriter(file, SCORE["COLUMNS"])
                table.writeheader()
                table.writerows(rows)
        print(name, {problem: len(rows) for problem, rows in by_problem.items()}, flush=True)


def scores() -> Iterator[Row]:
    """A row for each quantity of each case that a program answered, by runs of whole beds in seeds.csv too."""
    for path in sorted(ANSWERS.glob("*/*.csv")):
        for line in SCORE["scored"](path.stem, SCORE["read"](path)):
            yield {"program": path.parent.name, "problem": path.stem, **line}
    runs = pd.read_csv(HERE / "seeds.csv")
    for (name, problem), of in runs[runs["program"] != MAKE["SEEDED"]].groupby(["program", "problem"], sort=False):
        given = of.rename(columns={"mean": "value"}).assign(at=0.0).to_dict("records")
        for line in SCORE["scored"](problem, given):
            yield {"program": name, "problem": problem, **line}


def page() -> None:
    """Write scores.csv, new scores in place of stored ones, and the page's tables."""
    new, stored = pd.DataFrame(scores()), pd.read_csv(HERE / "scores.csv")
    again = pd.MultiIndex.from_frame(stored[["program", "problem"]]).isin(
        pd.MultiIndex.from_frame(new[["program", "problem"]])
    )
    table = pd.concat([stored[~again], new], ignore_index=True)
    order = {name: k for k, name in enumerate(PROGRAMS)}
    table = table.sort_values("program", key=lambda names: names.map(order).fillna(len(order)), kind="stable")
    for column in ("largest", "rms", "uncertainty"):
        table[column] = [float(f"{value:.3g}") for value in table[column]]
    write_csv(table, HERE / "scores.csv")
    with atomic_write(HERE.parents[1] / "docs" / "pictures" / "wet_scores.svg") as temporary:
        temporary.write_text(picture(table))
    path = HERE.parents[1] / "docs" / "wet_benchmarks.md"
    head, _, rest = path.read_text().partition(BEGIN)
    with atomic_write(path) as temporary:
        temporary.write_text(head + BEGIN + "\n" + "\n".join(tables(table)) + "\n" + END + rest.partition(END)[2])
    print(f"replaced: {HERE / 'scores.csv'}, docs/pictures/wet_scores.svg and the tables of docs/wet_benchmarks.md")


def worst(table: pd.DataFrame) -> pd.DataFrame:
    """The largest deviation over all cases and quantities, by program and problem; NaN where nothing is answered."""
    found = table.pivot_table("largest", "program", "problem", aggfunc="max", sort=False)
    return found.reindex(index=list(dict.fromkeys(table["program"])), columns=SCORE["problems"]())


def tables(table: pd.DataFrame) -> Iterator[str]:
    """One row for each program, one column for each problem; what is answered in part has a star."""
    shown = worst(table)
    counts = table.groupby(["program", "problem"])[["asked", "answered"]].sum()
    yield "| program | " + " | ".join(f"`{problem}`" for problem in shown.columns) + " |"
    yield "|---" * (1 + len(shown.columns)) + "|"
    for program, row in shown.iterrows():
        cells = []
        for problem, deviation in row.items():
            if np.isnan(deviation):
                cells.append("–")
                continue
            asked_, answered = counts.loc[(program, problem)]
            percent = f"{100.0 * deviation:.0f}" if deviation > 0.1 else f"{100.0 * deviation:.2g}"
            cells.append(percent + ("*" if answered < asked_ else ""))
        yield f"| {program} | " + " | ".join(cells) + " |"


def picture(table: pd.DataFrame) -> str:
    """The table of deviations as a map, logarithmic from 1e-6 to 1."""
    shown = 100.0 * worst(table)
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(7.5, 0.3 * len(shown) + 1.6), layout="constrained")
        image = axes.imshow(
            np.clip(shown.to_numpy(float), 1e-4, 100.0), norm=LogNorm(1e-4, 100.0), cmap="viridis_r", aspect="auto"
        )
        axes.set_xticks(
            range(len(shown.columns)), [name.replace("_", " ") for name in shown.columns], rotation=40, ha="right"
        )
        axes.set_yticks(range(len(shown)), list(shown.index))
        axes.grid(False)
        bar = figure.colorbar(image, label="largest deviation in %", ticks=[1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0])
        bar.ax.set_yticklabels(["0.0001 or less", "0.001", "0.01", "0.1", "1", "10", "100 or more"])
        return svg(figure)


if __name__ == "__main__":
    what, *names = sys.argv[1:]
    {"measure": measure, "seeds": by_seed, "page": lambda _: page()}[what](names)
