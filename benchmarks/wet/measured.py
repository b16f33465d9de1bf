"""What experiments say, and what pywet gives: docs/measured.md.

python benchmarks/wet/measured.py          the page's tables: measured.csv (what was read, and where), and what is computed here
python benchmarks/wet/measured.py drum     first the drum, two surface tensions, two viscosities, three seeds each: drum_trend.csv
"""

from __future__ import annotations

import math
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.cases.small import bodies, scenes
from pywet.collisions.wall import wall
from pywet.collisions.wall.problem import Problem
from pywet.compare.statistics import half_width
from pywet.config.loading import parse
from pywet.laws import exact_bridge, registry
from pywet.scene import Liquid, SphereClass
from pywet.util.files import atomic_write, read_json, write_csv
from studies.buck2018 import buck_tables

HERE = Path(__file__).resolve().parent
PAGE = HERE.parents[1] / "docs" / "measured.md"
VISCOSITIES = (1e-3, 5e-3, 20e-3)
"""Of water and of thicker liquids [Pa s]."""
SPEEDS = np.geomspace(0.5, 5.0, 10)
"""Of impact, as in the experiments [m/s]."""
TENSIONS, THICK, SEEDS = (0.02, 0.07), (0.005, 0.1), (1, 2, 3)
"""Of the drum: silicone oil and water [N/m]; 5 and 100 mPa s."""
Report = tuple[str, bool | str | None]
"""Numbers in words, and whether the statement is confirmed; None: inconclusive; a text: why the models do not test it."""


def impact(
    speed: float, particle: str = "glass_1.74mm", layer: dict[str, float] | None = None, **changes: float
) -> float:
    """Restitution in the model of Buck et al. (2018) on 200 µm of water, or on another layer, with changes of the liquid."""
    liquid = {**(layer or buck_tables.layer("glass_1.74mm", "water", 200)), **changes}
    given = read_json(HERE.parents[1] / "examples" / "wall_wet.json", "")
    given |= {"particle": buck_tables.PARTICLES[particle], "liquid": liquid, "normal_velocity_m_per_s": float(speed)}
    return float(wall.collide(parse(Problem, given, "examples/wall_wet.json"))["e_n"])


def restitution(viscosity: float) -> tuple[np.ndarray, np.ndarray]:
    """1/St and restitution of glass of 1.74 mm that rebounds from a film of 200 µm; impacts that stick are left out."""
    sphere = buck_tables.PARTICLES["glass_1.74mm"]
    mass = 4.0 / 3.0 * math.pi * sphere["radius_m"] ** 3 * sphere["density_kg_per_m3"]
    stored = np.array([impact(speed, viscosity_Pa_s=viscosity, half_filling_angle_deg=55.0) for speed in SPEEDS])
    inverse = 6.0 * math.pi * viscosity * sphere["radius_m"] ** 2 / (mass * SPEEDS)
    return inverse[stored > 0.0], stored[stored > 0.0]


def bend(inverse: np.ndarray, stored: np.ndarray) -> float:
    """Largest distance of a point from the straight line through all, over the range of restitution."""
    line = np.polyval(np.polyfit(inverse, stored, 1), inverse)
    return float(np.abs(stored - line).max() / np.ptp(stored))


def sticking(particle: str = "glass_1.74mm", layer: dict[str, float] | None = None, **changes: float) -> float:
    """Least speed [m/s] of a rebound, to a hundredth."""
    low, high = 0.02, 4.0
    while high / low > 1.01:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if impact(middle, particle, layer, **changes) > 0.0 else (middle, high)
    return high


@lru_cache
def bridge(volume: float, radius: float) -> tuple[float, float]:
    """Largest force over the gap [N], and rupture distance [m], of the exact bridge of water between two equal spheres, 15°."""
    given = volume, radius, radius, bodies.WETTED, bodies.WETTED
    end = exact_bridge.rupture(*given).separation
    states = [exact_bridge.solve(share * end, *given) for share in np.linspace(0.0, 0.9, 10)]
    return max(state.force(0.0728) for state in states if state is not None), float(end)


def of_bridges() -> Iterator[tuple[str, Report]]:
    """Bridges at rest and drawn."""
    stretch = registry.get("dynamic_rupture", "pitois").functions[0]
    slow, fast = (stretch(v, 0.1, 0.021) - 1.0 for v in (1e-4, 1e-2))
    power = math.log(fast / slow) / math.log(100.0)
    yield (
        "speed",
        (f"law `pitois`: power {power:.3f}", "by construction"),
    )
    yield "rest", ("preset `exact` is that solution ([scores](wet_benchmarks.md))", "by construction")
    (force, end), (more, longer), (_, larger) = (bridge(v, r) for v, r in ((1e-9, 2e-3), (2e-9, 2e-3), (1e-9, 4e-3)))
    law = registry.get("capillary", "rabinovich").functions[0]
    one, two = (law(0.0, v, 2e-3, 2e-3, bodies.WETTED, bodies.WETTED, 0.0728) for v in (1e-9, 2e-9))
    text = f"1 and 2 µl, spheres of 2 mm, 15°: {1e6 * force:.0f} and {1e6 * more:.0f} µN exact"
    yield "volume", (f"{text}; `rabinovich` {1e6 * one:.0f} and {1e6 * two:.0f} µN", more > force)
    yield "longer", (f"{1e6 * end:.0f} and {1e6 * longer:.0f} µm exact", longer > end)
    yield "larger", (f"1 µl, spheres of 2 and 4 mm: {1e6 * end:.0f} and {1e6 * larger:.0f} µm exact", larger < end)
    yield "tension", ("independent of the surface tension in every law (no gravity)", False)


def of_impacts() -> Iterator[tuple[str, Report]]:
    """The wall model of Buck et al. (2018)."""
    bends = [bend(*restitution(viscosity)) for viscosity in VISCOSITIES]
    yield (
        "line",
        (
            f"deviates by {100 * min(bends):.0f} to {100 * max(bends):.0f} % of its range",
            max(bends) < 0.05,
        ),
    )
    of_layer = buck_tables.layer
    thin, thick = (sticking(layer=of_layer("glass_1.74mm", "water", t)) for t in (100, 400))
    yield "thicker", (f"100 and 400 µm: {thin:.2f} and {thick:.2f} m/s", thick > thin)
    water, glycerol = (sticking(layer=of_layer("glass_1.74mm", name, 400)) for name in ("water", "glycerol50"))
    yield "viscous", (f"400 µm, 1 and 6.7 mPa s: {water:.2f} and {glycerol:.2f} m/s", glycerol > water)
    sizes = {p: sticking(p, of_layer(p, "water", 200)) for p in ("glass_1.74mm", "glass_0.91mm", "alumina_1.74mm")}
    big, small, light = sizes.values()
    text = f"glass 1.74 mm {big:.2f}, 0.91 mm {small:.2f}, γ-Al2O3 1.74 mm {light:.2f} m/s"
    yield "lighter", (text, min(small, light) > big)
    two = [(name, of_layer(name, "water", t)) for name, t in (("glass_1.74mm", 400), ("glass_0.91mm", 200))]
    pairs = [tuple(impact(v, *of) for of in two) for v in (1.0, 2.0, 3.0)]
    text = "; ".join(f"{one:.2f} and {two:.2f}" for one, two in pairs)
    yield "scaled", (f"1, 2, 3 m/s: {text}", all(0.0 < one - two < 0.15 for one, two in pairs))
    off = [
        abs(np.subtract(*(impact(v, layer=of_layer("glass_1.74mm", name, 100)) for name in ("water", "tween20"))))
        for v in (1.0, 2.0, 3.0)
    ]
    yield "surfactant", (f"1 to 3 m/s: {max(off):.3f} at most", bool(max(off) < 0.05))


def of_beds() -> Iterator[tuple[str, Report]]:
    """Bridges less contacts per sphere, of the stored moist beds; a row of three spheres."""
    stored = pd.read_csv(HERE / "seeds.csv").query("problem == 'settling_bed' and case == 'moist'")
    message, holds = [], True
    for program, short in (("LIGGGHTS + pywet, paper", "pywet"), ("YADE, Rabinovich", "YADE")):
        of = stored[stored["program"] == program].set_index("quantity")
        bridges, contacts = of.loc["bridges per sphere"], of.loc["contacts per sphere"]
        more, seeds = float(bridges["mean"] - contacts["mean"]), int(bridges["seeds"])
        limit = half_width(math.hypot(bridges["deviation"], contacts["deviation"]), seeds, seeds - 1, 0.95)
        message.append(f"{short}: {more:.2f} ± {limit:.2f} ({100 * (more / 2.0 - 1.0):+.0f} %)")
        holds = holds and abs(more - 2.0) <= limit
    yield "packing", ("; ".join(message), holds)
    yield "critical", ("independent of viscosity (hard spheres, Davis 2023, eq. 42)", False)


@dataclass(frozen=True)
class Wetted(scenes.Choice):
    """A drum with another surface tension [N/m]."""

    tension: float = 0.0728

    def liquid(self, sphere: SphereClass) -> Liquid:
        """The liquid of this tension."""
        return bodies.wetting((sphere,), self.moisture_percent, self.viscosity_Pa_s, self.tension)


def turn() -> None:
    """Run the drums that are missing."""
    store = HERE / "drum_trend.csv"
    rows: list[Any] = pd.read_csv(store).to_dict("records") if store.exists() else []
    have = {(r["tension"], r["viscosity"], r["seed"]) for r in rows}
    for seed in SEEDS:
        for tension in TENSIONS:
            for viscosity in THICK:
                if (tension, viscosity, seed) not in have:
                    choice = Wetted(spheres=200, seed=seed, viscosity_Pa_s=viscosity, tension=tension)
                    with tempfile.TemporaryDirectory(prefix="pywet-drum-") as name:
                        angle = scenes.run("drum", Path(name), choice)["dynamic_angle_deg"]
                    rows.append({"tension": tension, "viscosity": viscosity, "seed": seed, "angle": round(angle, 3)})
                    write_csv(pd.DataFrame(rows), store)
                    print(rows[-1], flush=True)


def angles() -> pd.DataFrame:
    """The drums' angles [deg], a column for each seed."""
    return pd.read_csv(HERE / "drum_trend.csv").pivot_table("angle", ["viscosity", "tension"], "seed")


def of_drums() -> Iterator[tuple[str, Report]]:
    """Yield the changes of the drum's angle: means of pairs of runs that differ in one input, with their uncertainty."""
    of, n = angles(), len(angles().columns)
    text, sign = _change(of.xs(TENSIONS[1], level="tension") - of.xs(TENSIONS[0], level="tension"))
    yield "cohesion", (f"20 to 70 mN/m, {n} seeds: {text}", sign)
    yield "stability", ("dynamic angle only (row above)", "not tested")
    text, sign = _change(of.xs(THICK[1], level="viscosity") - of.xs(THICK[0], level="viscosity"))
    yield "thick", (f"5 to 100 mPa s, {n} seeds: {text}", sign is not None or None)


def _change(of: pd.DataFrame) -> tuple[str, bool | None]:
    """Mean and 95 % limit in words, from the scatter between seeds of each row; a rise or none, None where chance may make it."""
    rows, seeds = of.shape
    deviation = math.sqrt(float(of.var(axis=1, ddof=1).mean()))
    mean, limit = float(of.to_numpy().mean()), half_width(deviation, of.size, rows * (seeds - 1), 0.95)
    return f"{mean:+.1f} ± {limit:.1f}°", None if abs(mean) <= limit else mean > 0.0


def source(row: Mapping[Any, str]) -> str:
    """The source of a statement, with how it was read unless that is an abstract, and its uncertainty if one is given."""
    usual = {"read": "abstract", "uncertainty": "not given"}
    return "; ".join([row["source"], *(row[key] for key, value in usual.items() if row[key] != value)])


def tables() -> dict[str, list[str]]:
    """Lines of the page's tables, by their names."""
    computed = dict([*of_bridges(), *of_impacts(), *of_drums(), *of_beds()])
    lines = ["| measured | source | computed | |", "|---|---|---|---|"]
    for row in pd.read_csv(HERE / "measured.csv").to_dict("records"):
        text, confirmed = computed[row["key"]]
        answers = {True: "confirmed", False: "**not confirmed**", None: "inconclusive"}
        answer = confirmed if isinstance(confirmed, str) else answers[confirmed]
        lines.append(f"| {row['measured']} | {source(row)} | {text} | {answer} |")
    return {"statements": lines}


def page() -> None:
    """Put the tables into the page and print how many statements are confirmed, and how many are not tested and why."""
    text, made = PAGE.read_text(), tables()
    for name, lines in made.items():
        head, _, rest = text.partition(f"<!-- {name} -->")
        text = (
            f"{head}<!-- {name} -->\n"
            + "\n".join(lines)
            + f"\n<!-- end of {name} -->"
            + rest.partition(f"<!-- end of {name} -->")[2]
        )
    with atomic_write(PAGE) as temporary:
        temporary.write_text(text)
    answers = Counter(line.split("|")[-2].strip(" *") for line in made["statements"][2:])
    print(f"{PAGE.name}: {', '.join(f'{n} {answer}' for answer, n in answers.items())}")


if __name__ == "__main__":
    if "drum" in sys.argv:
        turn()
    page()
