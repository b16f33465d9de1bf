"""What several programs answer to the wet benchmark problems, and their scores: scores.csv and docs/wet_benchmarks.md.

python benchmarks/wet/programs.py measure [PROGRAM ...]    answers into results/wet/, minutes for each engine
python benchmarks/wet/programs.py page                     scores.csv and the page from all answers there are
"""

from __future__ import annotations

import csv
import math
import runpy
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.bench import bridge_engine, bridge_query
from pywet.bench.pair import Pair
from pywet.collisions.spheres import command as davis
from pywet.engines.stock.liggghts import liggghts_force
from pywet.engines.stock.yade import yade_force
from pywet.files import atomic_write, read_json, write_csv
from pywet.laws import registry

HERE = Path(__file__).resolve().parent
ANSWERS = Path("results") / "wet"
SCORE = runpy.run_path(str(HERE / "score.py"))
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
        if engine is None:
            yield from drags()
            yield from splits(capillary, rupture)

    return answers


def splits(capillary: str, rupture: str) -> Iterator[Row]:
    """Rupture distance and sharing by pywet's laws; a wire counts as a plane in every preset."""
    model = "young_laplace" if capillary == "young_laplace" else "parabola"
    for case, given, wanted in asked("rupture_and_sharing"):
        answer = bridge_query.answer(pair(given).query([0.0], laws=list(dict.fromkeys((capillary, rupture)))))
        values = {
            "rupture distance": answer["rupture_distance_m"][rupture],
            "share of body 1": answer["transfer_ratio"][model],
        }
        for a in wanted:
            yield row("rupture_and_sharing", case, a["quantity"], a["at"], values[a["quantity"]])
    for case, _, wanted in asked("wire"):
        yield from (row("wire", case, a["quantity"], a["at"], 1.0) for a in wanted)


def drags() -> Iterator[Row]:
    """Lubrication by the law for full immersion, with the least gap that all viscous laws add."""
    law = registry.get("viscous_normal", STOKES_FORCE).functions[0]
    for case, given, wanted in asked("viscous_pull"):
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


PROGRAMS: dict[str, Callable[[], Iterator[Row]]] = {
    "pywet laws, preset exact": by_law("young_laplace", "young_laplace"),
    "pywet laws, preset paper": by_law("rabinovich", "willett_unequal"),
    "pywet laws, Willett": by_law("willett", "willett"),
    "LIGGGHTS + pywet, exact": by_law("young_laplace", "young_laplace", "liggghts"),
    "LIGGGHTS + pywet, paper": by_law("rabinovich", "willett_unequal", "liggghts"),
    "LAMMPS + pywet, exact": by_law("young_laplace", "young_laplace", "lammps"),
    "LAMMPS + pywet, paper": by_law("rabinovich", "willett_unequal", "lammps"),
    "LIGGGHTS, washino": stock(lambda points: liggghts_force(points, "washino")),
    "LIGGGHTS, easo": stock(lambda points: liggghts_force(points, "easo")),
    "YADE, Rabinovich": stock(lambda points: yade_force(points, "Rabinovich")),
    "YADE, Willett": stock(lambda points: yade_force(points, "Willett_numeric")),
    "pywet collide spheres": collisions,
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
    """A row for each quantity of each case that a program answered."""
    for name in PROGRAMS:
        for path in sorted((ANSWERS / name).glob("*.csv")):
            for line in SCORE["scored"](path.stem, SCORE["read"](path)):
                yield {"program": name, "problem": path.stem, **line}


def page() -> None:
    """Write scores.csv and the page's tables; a program without answers here keeps the scores it has."""
    fresh, before = pd.DataFrame(scores()), pd.read_csv(HERE / "scores.csv")
    table = pd.concat([fresh, before[~before["program"].isin(fresh["program"])]], ignore_index=True)
    table = table.sort_values("program", key=lambda names: names.map(list(PROGRAMS).index), kind="stable")
    table["asked"] = table["asked"].astype(int)
    write_csv(table.round({"largest": 6, "rms": 6}), HERE / "scores.csv")
    path = HERE.parents[1] / "docs" / "wet_benchmarks.md"
    head, _, rest = path.read_text().partition(BEGIN)
    with atomic_write(path) as temporary:
        temporary.write_text(head + BEGIN + "\n" + "\n".join(tables(table)) + "\n" + END + rest.partition(END)[2])


def tables(table: pd.DataFrame) -> Iterator[str]:
    """For each problem a table of programs: the largest deviation of each quantity over all cases, and how much was answered."""
    for problem in SCORE["problems"]():
        of = table[table["problem"] == problem]
        yield f"\n## {problem}\n"
        if of.empty:
            yield "No program of this page answers it."
            continue
        quantities = list(dict.fromkeys(of["quantity"]))
        yield "| program | " + " | ".join(quantities) + " | answered |"
        yield "|---" * (len(quantities) + 2) + "|"
        for name in dict.fromkeys(of["program"]):
            mine = of[of["program"] == name]
            worst = [mine.loc[mine["quantity"] == q, "largest"].max() for q in quantities]
            cells = ["–" if np.isnan(w) else (f"{100.0 * w:.0f} %" if w > 0.1 else f"{100.0 * w:.2g} %") for w in worst]
            yield f"| {name} | " + " | ".join(cells) + f" | {mine['answered'].sum()} of {mine['asked'].sum()} |"


if __name__ == "__main__":
    what, *names = sys.argv[1:]
    measure(names) if what == "measure" else page()
