"""Makes inputs.json and answers.json of every problem from first principles and the independent reference.

    python benchmarks/wet/make.py [PROBLEM ...]

Exact answers come from `reference_impl` (tests/benchmarks/test_wet.py sets them against a second method), from series and closed
forms written here; answers of the tier `seeds` from seeds.csv, what runs of whole beds gave.
"""

from __future__ import annotations

import csv
import json
import math
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from reference_impl.bridge import bridge
from reference_impl.spheres import spheres

HERE = Path(__file__).resolve().parent
Answer = dict[str, Any]
TENSION = 0.0728
SHARES = (0.0, 0.05, 0.2, 0.5, 0.8)
"""Gaps over the rupture distance at which a force is asked."""
SOLVED = 1e-8
"""Relative uncertainty of an exact answer: ten times what two methods differ by."""
DIGITS = 10


def answer(
    case: str, quantity: str, unit: str, at: float, value: float, uncertainty: float, tier: str = "exact"
) -> Answer:
    """One number that is asked for."""
    return {
        "case": case, "quantity": quantity, "unit": unit, "at": float(f"{at:.6g}"), "value": float(f"{value:.{DIGITS}g}"),
        "uncertainty": float(f"{uncertainty:.2g}"), "tier": tier,
    }  # fmt: skip


def bridges(cases: dict[str, dict[str, Any]]) -> Iterator[Answer]:
    """Force over gap and rupture distance of each bridge; `at`: gap [m]."""
    for name, c in cases.items():
        given = _given(c)
        limit = bridge.rupture(*given).separation
        for share in SHARES:
            gap = float(f"{share * limit:.3g}")
            force = TENSION * bridge.solve(gap, *given).force
            yield answer(name, "force", "N", gap, force, SOLVED * force)
        yield answer(name, "rupture distance", "m", 0.0, limit, SOLVED * limit)


def _given(c: dict[str, Any]) -> tuple[float, float, float, float, float]:
    second = math.inf if c["radius_2_m"] is None else c["radius_2_m"]
    angles = math.radians(c["contact_angle_1_deg"]), math.radians(c["contact_angle_2_deg"])
    return c["volume_m3"], c["radius_1_m"], second, *angles


def _pair(volume: float, second: float | None, angles: tuple[float, float], first: float = 1e-3) -> dict[str, Any]:
    return {
        "radius_1_m": first, "radius_2_m": second, "volume_m3": volume,
        "contact_angle_1_deg": angles[0], "contact_angle_2_deg": angles[1],
    }  # fmt: skip


def _grid(second: float | None, volumes: tuple[float, ...], angles: tuple[tuple[float, float], ...]) -> dict[str, Any]:
    return {f"V {v:g} angle {a:g} {b:g}": _pair(v, second, (a, b)) for v in volumes for a, b in angles}


BRIDGES = {
    "pair_at_rest": _grid(1e-3, (1e-12, 1e-11, 1e-10), ((0.0, 0.0), (30.0, 30.0))),
    "unequal_pair": _grid(3e-3, (1e-12, 1e-11), ((0.0, 0.0), (20.0, 20.0), (10.0, 40.0))),
    "sphere_and_plate": _grid(None, (1e-12, 1e-11), ((0.0, 0.0), (20.0, 20.0), (10.0, 40.0))),
}
SPLIT = {
    f"radius ratio {ratio:g} angle {a:g} {b:g}": _pair(1e-11, ratio * 1e-3, (a, b))
    for ratio, a, b in ((1.0, 0.0, 0.0), (2.0, 0.0, 0.0), (5.0, 0.0, 0.0), (1.0, 10.0, 30.0), (2.0, 30.0, 10.0))
}
WIRES = {f"wire {wire * 1e3:g} mm": {"radius_m": 1e-3, "wire_radius_m": wire} for wire in (5e-4, 1e-3, 2e-3)}
WIRE_VOLUME = 1e-15


def rupture(cases: dict[str, dict[str, Any]]) -> Iterator[Answer]:
    """Rupture distance and the part of the liquid on the first body's side of the neck there; `at`: volume [m³]."""
    for name, c in cases.items():
        end = bridge.rupture(*_given(c))
        yield answer(name, "rupture distance", "m", c["volume_m3"], end.separation, SOLVED * end.separation)
        yield answer(name, "share of body 1", "1", c["volume_m3"], end.transfer_ratio_i, 1e-5)


def wires(cases: dict[str, dict[str, Any]]) -> Iterator[Answer]:
    """Force at touch over that on a plate as the volume vanishes (Derjaguin): sqrt(R/(r + R)); `at`: volume [m³].

    Known to what the ratio of a sphere of the wire's radius is off its own limit, R/(r + R), at this volume.
    """
    for name, c in cases.items():
        r, wire = c["radius_m"], c["wire_radius_m"]
        sphere, plate = (bridge.solve(0.0, WIRE_VOLUME, r, other, 0.0, 0.0).force for other in (wire, math.inf))
        off = abs(sphere / plate / (wire / (r + wire)) - 1.0)
        ratio = math.sqrt(wire / (r + wire))
        yield answer(name, "force over plate's", "1", WIRE_VOLUME, ratio, off * ratio, "limit")


def drag(towards: str, gap: float) -> float:
    """Stokes drag over 6 pi mu r U of a sphere in liquid without end that moves at U against a plate (Brenner 1961).

    `rigid`: a solid plate. `free`: one that does not hold the liquid, which is the plane between two spheres in opposite motion.
    """
    a = math.acosh(1.0 + gap)
    total, n = 0.0, 1
    while True:
        m = 2 * n + 1
        if towards == "rigid":
            term = (2 * math.sinh(m * a) + m * math.sinh(2 * a)) / (
                4 * math.sinh(m * a / 2) ** 2 - m**2 * math.sinh(a) ** 2
            ) - 1
        else:
            term = (4 * math.cosh(m * a / 2) ** 2 + m**2 * math.sinh(a) ** 2) / (
                2 * math.sinh(m * a) - m * math.sinh(2 * a)
            ) - 1
        term *= n * (n + 1) / ((2 * n - 1) * (2 * n + 3))
        total += term
        if abs(term) < 1e-16 * abs(total) or m * a > 600.0:
            return 4.0 / 3.0 * math.sinh(a) * total
        n += 1


READ = 0.05
"""Uncertainty that we give to what a source says in words without one: "like the square root", "a straight line"."""
DRAWN = {
    "radius_m": 4e-3, "contact_angle_deg": 10.0, "volume_m3": 5e-10, "surface_tension_N_per_m": 0.021, "viscosity_Pa_s": 0.1,
    "speeds_m_per_s": [1e-4, 1e-2],
}  # fmt: skip
"""Ruby spheres and oil of the experiment, as Elskamp & Kruggel-Emden (2018, section 3) give them."""
PULL = {"radius_m": 1e-3, "viscosity_Pa_s": 0.1, "speed_m_per_s": 0.01}
GAPS = (0.001, 0.003, 0.01, 0.03, 0.1)


def pulls(cases: dict[str, dict[str, Any]]) -> Iterator[Answer]:
    """Force that holds back a sphere drawn from a plate, or from its like, at constant speed; `at`: gap [m]."""
    for name in cases:
        if name == "drawn apart":
            yield answer(name, "power of the growth of the rupture distance", "1", 0.0, 0.5, READ, "measured")
            continue
        r, stokes = PULL["radius_m"], 6.0 * math.pi * PULL["viscosity_Pa_s"] * PULL["radius_m"] * PULL["speed_m_per_s"]
        for gap in GAPS:
            force = stokes * (drag("rigid", gap) if name == "plate" else 0.5 * drag("free", 0.5 * gap))
            yield answer(name, "force", "N", gap * r, force, 1e-9 * force)


REBOUND = {
    f"{kind} film {film * 1e6:g} um": {"film_m": film, "roughness_m": 1e-6, "dry_restitution": 0.9, "outward": kind}
    for kind in ("cavitates", "holds")
    for film in (1e-5, 1e-4)
} | {
    "two spheres film 100 um": {"film_m": 1e-4, "roughness_m": 5e-6, "dry_restitution": 0.9, "outward": "thinning film"}
}
STOKES = (4.0, 6.0, 10.0, 20.0, 50.0, 200.0)
MEASURED = {"film 200 um, measured": {"diameter_m": 1.74e-3, "film_m": 2e-4, "speeds_m_per_s": [0.5, 5.0]}}
"""Glass on a film of water and of thicker liquids, at ten speeds in even ratios; `at`: viscosity [Pa s]."""


def rebounds(cases: dict[str, dict[str, Any]]) -> Iterator[Answer]:
    """Wet restitution by lubrication alone; `at`: Stokes number m v / (6 pi mu a²), m and a reduced (Barnocky & Davis, Davis)."""
    for name, c in cases.items():
        if name in MEASURED:
            yield from (
                answer(name, "straightness over 1/St", "1", v, 1.0, READ, "measured") for v in (1e-3, 5e-3, 20e-3)
            )
            continue
        h, dry = c["roughness_m"] / c["film_m"], c["dry_restitution"]
        lost = -math.log(h)
        if c["outward"] == "thinning film":
            lost += 2.0 - 3.0 * math.log(2.0 - h) - 2.0 / (2.0 - h)
        for stokes in STOKES:
            out = dry * max(0.0, 1.0 - lost / stokes) - (0.0 if c["outward"] == "cavitates" else lost / stokes)
            yield answer(name, "restitution", "1", stokes, max(0.0, out), 1e-9)


THREE = {
    f"St {stokes:g} mu {friction:g}": {
        "form": "three_equal_spheres", "St_n": stokes, "h_a": 0.01, "h_min": 0.05, "theta12_deg": 45, "theta23_deg": 0,
        "h23_0": 1, "e_dry": 1, "mu_f": friction, "t_end": 4.0,
    }
    for stokes, friction in ((2.0, 0.0), (7.0, 0.0), (20.0, 0.0), (20.0, 0.1))
}  # fmt: skip


def threes(cases: dict[str, dict[str, Any]]) -> Iterator[Answer]:
    """Velocities of three equal wet spheres after an oblique collision (Davis 2023); `at`: time in gap over speed."""
    for name, c in cases.items():
        state = spheres.solve(c)["final"]
        for i in range(3):
            for axis, unit in ((0, "x"), (1, "y")):
                yield answer(name, f"v{unit} {i + 1}", "1", c["t_end"], float(state["velocity"][i, axis]), 1e-6)


GLASS: dict[str, Any] = {
    "radius_m": 1.5e-3, "density_kg_per_m3": 2500.0, "friction": 0.4, "restitution": 0.8, "rolling_friction_m": 0.0,
    "normal_stiffness_N_per_m": 500.0, "tangential_over_normal_stiffness": 2.0 / 7.0, "time_step_s": 1.6e-5,
    "gravity_m_per_s2": 9.81, "surface_tension_N_per_m": TENSION, "contact_angle_deg": 15.0, "viscosity_Pa_s": 0.0,
    "liquid_density_kg_per_m3": 1000.0,
}  # fmt: skip
"""Spheres and walls of the bed and the drum: every contact alike."""
BED = {
    **GLASS,
    "spheres": 150,
    "duration_s": 0.25,
    "box_side_m": 0.01875,
    "lattice_over_radius": 2.3,
    "shaken_over_radius": 0.1,
}
DRUM = {
    **GLASS, "spheres": 200, "duration_s": 1.5, "drum_apothem_m": 0.0197386, "drum_sides": 32, "drum_width_m": 0.012,
    "turns_per_minute": 20.0, "lattice_over_radius": 2.15, "shaken_over_radius": 0.05,
}  # fmt: skip
WETTED = {
    "moist": {"liquid_percent_of_mass": 1.0, "film_m": 1.239726e-5},
    "dry": {"liquid_percent_of_mass": 0.0, "film_m": 0.0},
}

SEEDED = "LIGGGHTS + pywet, paper"
"""Whose runs the answers of the tier `seeds` are."""


def seeds(problem: str) -> Callable[[dict[str, Any]], Iterator[Answer]]:
    """Mean over seeds of whole beds, known to two standard errors; `at`: 0."""

    def answers(cases: dict[str, Any]) -> Iterator[Answer]:
        with open(HERE / "seeds.csv", newline="", encoding="utf-8") as file:
            rows = [row for row in csv.DictReader(file) if (row["program"], row["problem"]) == (SEEDED, problem)]
        for row in rows:
            error = 2.0 * float(row["deviation"]) / math.sqrt(float(row["seeds"]))
            yield answer(row["case"], row["quantity"], row["unit"], 0.0, float(row["mean"]), error, "seeds")

    return answers


Makes = Callable[[dict[str, Any]], Iterator[Answer]]
PROBLEMS: dict[str, tuple[str, dict[str, Any], dict[str, Any], Makes]] = {
    "pair_at_rest": ("gap [m]", {"surface_tension_N_per_m": TENSION}, BRIDGES["pair_at_rest"], bridges),
    "unequal_pair": ("gap [m]", {"surface_tension_N_per_m": TENSION}, BRIDGES["unequal_pair"], bridges),
    "sphere_and_plate": ("gap [m]", {"surface_tension_N_per_m": TENSION}, BRIDGES["sphere_and_plate"], bridges),
    "wire": ("volume [m3]", {"contact_angle_deg": 0.0}, WIRES, wires),
    "rupture_and_sharing": ("volume [m3]", {}, SPLIT, rupture),
    "viscous_pull": ("gap [m]", PULL, {"plate": {}, "two spheres": {}, "drawn apart": DRAWN}, pulls),
    "wet_rebound": ("Stokes number", {}, REBOUND | MEASURED, rebounds),
    "three_spheres": ("time", {"model": "Davis 2023, see README.md"}, THREE, threes),
    "settling_bed": ("0", BED, WETTED, seeds("settling_bed")),
    "drum": ("0", DRUM, WETTED, seeds("drum")),
}
"""Name -> what `at` is, inputs of all cases, inputs of each case, its answers."""


def made(name: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Inputs and answers of a problem."""
    at, common, cases, answers = PROBLEMS[name]
    inputs = {"problem": name, "units": "SI, angles in degrees", **common, "cases": cases}
    return inputs, {"problem": name, "at": at, "answers": list(answers(cases))}


def main(names: list[str]) -> None:
    """Write the files of the problems named, of all where none is."""
    for name in names or PROBLEMS:
        (HERE / name).mkdir(exist_ok=True)
        for file, content in zip(("inputs.json", "answers.json"), made(name), strict=True):
            text = json.dumps(content, indent=1)
            if file == "answers.json":  # one answer, one line
                rows = ",\n  ".join(json.dumps(row) for row in content["answers"])
                text = json.dumps({**content, "answers": "@"}, indent=1).replace('"@"', f"[\n  {rows}\n ]")
            (HERE / name / file).write_text(text + "\n", encoding="utf-8")
        print(name, len(content["answers"]), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
