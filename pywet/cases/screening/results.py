"""Results of one screening run: fraction retained, liquid by reservoir, and conservation checks.

Fraction retained is E (44), (45) of Elskamp & Kruggel-Emden (2018): the mass of spheres and liquid that is not in the
collecting bin over the mass at the start. Per size class the liquid counted is that assigned to the spheres of the class.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import pandas as pd

from pywet.errors import PywetError
from pywet.runs.rundir import Floats, RunDir
from pywet.runs.summary import general
from pywet.scene import EngineScene
from pywet.schema import column
from pywet.util.files import write_json, write_table

WALL_RESERVOIRS = {
    "wires": ("wires",),
    "side_wall": ("side_wall",),
    "feed_bin": ("feed_bin", "slide"),
    "outlet": ("outlet",),
    "impact_plate": ("impact_plate",),
    "collecting_bin": ("collecting_bin",),
    "wall": ("wall",),
}
"""Row of the liquid table -> reservoirs of the scene counted there (the slide is the feed bin's floor)."""

LIQUID_TOLERANCE = 1e-12
"""Allowed relative error between the sum of all reservoirs and the initial liquid: round-off of sums of a few thousand terms."""


@dataclass(frozen=True)
class Results:
    """The tables and checks of a run, each computed once."""

    retained: pd.DataFrame
    liquid: pd.DataFrame
    checks: list[Check]

    @classmethod
    def of(cls, run: RunDir) -> Results:
        """Compute all result tables of a run; for the columns see `fraction_retained` and `liquid_by_reservoir`."""
        walls = wall_liquid(run)
        retained, liquid = fraction_retained(run, walls), liquid_by_reservoir(run, walls)
        return cls(retained, liquid, checks(run, retained, liquid))


@dataclass(frozen=True)
class Check:
    """A condition that every run must satisfy; `value` is compared with `limit`."""

    name: str
    ok: bool
    value: float
    limit: float
    text: str


def at_most(name: str, value: float, limit: float, text: str) -> Check:
    return Check(name, value <= limit, value, limit, text)


def class_titles(scene: EngineScene) -> dict[str, str]:
    """Return the column of each class's liquid, without unit, and its title: `spheres_ore_5_4_mm`, spheres ore 5.4 mm."""
    return {column("spheres", c.name): f"spheres {c.name}" for c in scene.classes}


def fraction_retained(run: RunDir, walls: pd.DataFrame) -> pd.DataFrame:
    """Return Y(t) in total and per class, and the numbers of spheres on the screen side, in the bin and lost.

    Times in seconds from the start of the run and from the opening of the slide. `fraction_retained_spheres` is
    the ratio of dry masses. `walls`: the result of `wall_liquid`.
    """
    scene, line = run.scene, run.timeline
    density = scene.liquid.density_kg_per_m3 if scene.liquid else 0.0
    above = line.present & ~line.passed
    wet = line.mass + density * line.liquid
    wet_start = line.mass + density * line.initial_film
    on_walls = walls.drop(columns="collecting_bin").sum(axis=1).to_numpy()
    frame = _time_columns(run)
    frame["fraction_retained"] = ((wet * above).sum(axis=1) + density * on_walls) / wet_start.sum()
    frame["fraction_retained_spheres"] = (line.mass * above).sum(axis=1) / line.mass.sum()
    for kind in scene.classes:
        of = line.types == kind.type
        if of.any():
            frame[column("fraction_retained", kind.name)] = (wet * above)[:, of].sum(axis=1) / wet_start[of].sum()
    frame["spheres_on_screen"] = above.sum(axis=1)
    frame["spheres_in_bin"] = (line.present & line.passed).sum(axis=1)
    frame["spheres_lost"] = (~line.present).sum(axis=1)
    return frame


def wall_liquid(run: RunDir) -> pd.DataFrame:
    """Return the liquid on walls [m3] at each output, films and share of active bridges; a column per key of WALL_RESERVOIRS."""
    return run.on_walls(
        {reservoir: name for name, reservoirs in WALL_RESERVOIRS.items() for reservoir in reservoirs}, "reservoir"
    )


def liquid_by_reservoir(run: RunDir, walls: pd.DataFrame) -> pd.DataFrame:
    """Liquid [m3] on the coarse material (not in the bin), the fines (in the bin) and each wall, over time.

    Liquid of active bridges is included on either side by the transfer share; `standing_bridges_m3` is the part
    of the total in active bridges. `left_m3` is the liquid of drops that fell onto nothing. `walls`: the result
    of `wall_liquid`.
    """
    scene, line = run.scene, run.timeline
    passed = line.present & line.passed
    above = line.present & ~line.passed
    frame = _time_columns(run)
    for prefix, place in (("coarse_material", above), ("fines", passed)):
        frame[f"{prefix}_m3"] = (line.liquid * place).sum(axis=1)
        for kind in scene.classes:
            frame[column(prefix, kind.name, "_m3")] = (line.liquid * place)[:, line.types == kind.type].sum(axis=1)
    used = {wall.reservoir for wall in scene.walls}
    for name, reservoirs in WALL_RESERVOIRS.items():
        if used & set(reservoirs):
            frame[f"{name}_m3"] = walls[name].to_numpy()
    frame["left_m3"] = run.ledger_at("left")
    places = ["coarse_material_m3", "fines_m3", "left_m3", *(f"{n}_m3" for n in WALL_RESERVOIRS if f"{n}_m3" in frame)]
    frame["total_m3"] = frame[places].sum(axis=1)
    frame["standing_bridges_m3"] = run.ledger_at("bridges")
    frame["initial_m3"] = line.initial_film.sum()
    return frame


def checks(run: RunDir, retained: pd.DataFrame, liquid: pd.DataFrame) -> list[Check]:
    """Check that no particle is lost, that the fraction retained never rises, and that the tables account for all liquid."""
    count = len(run.timeline.ids)
    counted = (retained["spheres_on_screen"] + retained["spheres_in_bin"]).to_numpy()
    missing = int(np.abs(counted - count).max())
    rise = _largest_rise(retained["fraction_retained"].to_numpy())
    start = run.timeline
    initial = float(start.initial_film.sum())
    liquid_mass = initial * (run.scene.liquid.density_kg_per_m3 if run.scene.liquid else 0.0)
    # Between two passages Y may increase by liquid drawn back out of the bin: at most 0.1 % of the liquid is accepted.
    limit = 1e-12 + 1e-3 * liquid_mass / (float(start.mass.sum()) + liquid_mass)
    error = float((liquid["total_m3"] - initial).abs().max()) / initial if initial > 0 else 0.0
    return [
        at_most(
            "no_particle_lost", missing, 0,
            f"{count} spheres in, {int(counted[-1])} on the screen or in the bin at the end, {missing} missing at most",
        ),
        at_most(
            "fraction_retained_monotone", rise, limit,
            f"largest rise of the fraction retained from one output to the next: {rise:.3g}",
        ),
        at_most(
            "liquid_accounted_for", error, LIQUID_TOLERANCE,
            f"the sum of all liquid reservoirs differs from the total liquid by at most {error:.3g} of it",
        ),
    ]  # fmt: skip


def write_results(run: RunDir) -> Results:
    """Compute and write results/fraction_retained, results/liquid_by_holder (Parquet and CSV) and results/checks.json."""
    planned, there = run.scene.output_steps, run.timeline.steps.tolist()
    if there != planned:
        raise PywetError(
            f"{run.path / 'trajectory.parquet'} holds {len(there)} output steps; expected the {len(planned)} planned ones, "
            f"0 to {planned[-1]}: run the case again",
            code="run.output_steps", given=len(there), expected=len(planned), where=run.path / "trajectory.parquet",
        )  # fmt: skip
    made, folder = Results.of(run), run.path / "results"
    write_table(made.retained, folder / "fraction_retained.parquet", csv=True)
    write_table(made.liquid, folder / "liquid_by_holder.parquet", csv=True)
    write_json(folder / "checks.json", [asdict(c) for c in made.checks])
    return made


def summarise(run: RunDir, results: Results) -> dict[str, Any]:
    """Write and return the content of summary.json: common entries, fraction retained, liquid, checks."""
    content = {
        **general(run),
        "fraction_retained_end": float(results.retained["fraction_retained"].iloc[-1]),
        "coarse_share": coarse_share(run.scene),
        "spheres_that_came_back_from_the_bin": run.timeline.came_back,
        "liquid_end_m3": at_end(results.liquid),
        "checks": [asdict(c) for c in results.checks],
    }
    write_json(run.path / "summary.json", content)
    return content


def at_end(liquid: pd.DataFrame) -> dict[str, float]:
    """Return the volume [m3] at the end by reservoir, from columns whose names end in `_m3`."""
    named = {str(c).removesuffix("_m3"): c for c in liquid.columns if str(c).endswith("_m3") and c != "initial_m3"}
    return {name: float(liquid[column].iloc[-1]) for name, column in named.items()}


def coarse_share(scene: EngineScene) -> float:
    """Return the mass share of the classes that cannot pass the aperture, the limit of the dry fraction retained."""
    total = sum(c.mass_kg * c.count for c in scene.classes)
    return sum(c.mass_kg * c.count for c in scene.classes if not c.passes_aperture) / total


def _time_columns(run: RunDir) -> pd.DataFrame:
    line, slide = run.timeline, run.scene.slide
    opening = slide.opens_at_s if slide else 0.0
    return pd.DataFrame({"step": line.steps, "time_s": line.times, "time_since_opening_s": line.times - opening})


def _largest_rise(values: Floats) -> float:
    return max(0.0, float(np.diff(values).max(initial=0.0)))
