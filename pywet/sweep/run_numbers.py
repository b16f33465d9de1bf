"""Results of a run of the engine by name for a sweep: from its summary and from the last rows of its tables."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pywet.cases.custom import description, walls
from pywet.cases.screening import cases
from pywet.cases.screening.results import WALL_RESERVOIRS
from pywet.config import Config
from pywet.products import screening_report
from pywet.products.streams import PRODUCTS
from pywet.runs.loaded import Run
from pywet.schema import column
from pywet.sweep.base_kind import Numbers

WALL_TIME = "wall_time_s"
OF_ANY = (
    "steps", WALL_TIME, "mass_kg", "initial_liquid_m3", "formations", "ruptures", "bridges_at_end",
    "energy_kinetic_J", "energy_spin_J", "energy_gravity_J",
)  # fmt: skip
AT_END = (
    "contacts_per_sphere", "bridges_per_sphere", "walls_per_sphere", "mean_overlap", "largest_overlap",
    "mean_speed_m_per_s", "largest_speed_m_per_s", "centre_of_mass_height_m",
)  # fmt: skip
"""Results of a scene at its last output."""
ON_REQUEST: dict[str, Callable[[Run], float]] = {
    "angle_of_repose_deg": lambda run: run.angle_of_repose(),
    "drum_angle_deg": lambda run: run.drum_angle(),
}
"""Results of a scene on request only, since not every scene has a heap or a drum."""
RETAINED = ("fraction_retained_end", "coarse_share")
CUT_SIZE = "screen_d50_mm"
SCREEN: dict[str, Callable[[dict[str, Any]], float | None]] = {
    CUT_SIZE: lambda found: found["d50_mm"],
    "screen_ecart_probable_mm": lambda found: found["ecart_probable_mm"],
    "screen_efficiency": lambda found: found["efficiency"],
    "screen_throughput_t_per_h": lambda found: found["throughput_t_per_h"].get(
        "all", found["throughput_t_per_h"]["unders"]
    ),
    **{
        f"screen_{p}_moisture_percent": lambda found, p=p: found["moisture_percent_of_dry_mass"][p]  # type: ignore[misc]
        for p in PRODUCTS
    },
    "screen_pegged_share": lambda found: found.get("pegged_share"),
}
"""Results of a screen, as `pywet screen` computes them, by the content of screen.json; of several decks those of the first."""


def numbers(run: Run) -> Numbers:
    """Return all results of a finished run except those on request."""
    summary = run.summary
    events, initial = summary["events"] or {}, summary["initial_liquid_m3"]
    found: dict[str, Any] = {name: summary.get(name) for name in ("steps", "mass_kg", "initial_liquid_m3", *RETAINED)}
    whole = not summary.get("resumed_at_step")  # the time before a checkpoint is not known
    found |= {WALL_TIME: summary["wall_s"] if whole else None, "bridges_at_end": events.get("standing_bridges")}
    found |= {name: events.get(name) for name in ("formations", "ruptures")}
    found |= {f"energy_{name}_J": value for name, value in (summary.get("energy_J") or {}).items()}
    for name, volume in summary["liquid_end_m3"].items():
        found |= {f"liquid_{name}_m3": volume, f"liquid_{name}_share": volume / initial if initial else None}
    if run.has("results/contact_statistics.parquet"):
        found |= {name: run.contact_statistics[name].iloc[-1] for name in AT_END}
    if run.has("results/fraction_retained.parquet"):
        last = run.fraction_retained.iloc[-1]
        found |= {f"{c}_end": last[c] for c in last.index if str(c).startswith("fraction_retained_")}
    if evaluated := screening_report.stored(run.path):
        found |= {name: number(evaluated) for name, number in SCREEN.items()}
    return {name: None if value is None else float(value) for name, value in found.items()}


def of_scene(scene: description.Scene) -> list[str]:
    """Return the names of the results of a scene, including those of its feeds and its deck."""
    scene = scene.in_full()
    liquid = [column("spheres", s.name) for s in scene.spheres] + [f"wall_{walls.word_of(w.name)}" for w in scene.walls]
    liquid += [f"outlet_{outlet.name}" for outlet in scene.outlets]
    collected = {outlet.region().product for outlet in scene.outlets}
    screen = SCREEN if collected >= {*PRODUCTS} else ()
    return [*ON_REQUEST, *screen, *AT_END, *OF_ANY, *_of_liquid([*liquid, "left", "total"])]


def of_case(config: Config, number: int, scale: str) -> list[str]:
    """Return the names of the results of a case."""
    classes = [c.name for c in cases.ingredients(config, number, scale).classes]
    liquid = [*WALL_RESERVOIRS, "coarse_material", "fines", "left", "total"]
    liquid += [column(place, name) for place in ("coarse_material", "fines") for name in classes]
    retained = [f"{column('fraction_retained', name)}_end" for name in (*classes, "spheres")]
    return [*RETAINED, *retained, *SCREEN, *OF_ANY, *_of_liquid(liquid)]


def _of_liquid(places: list[str]) -> list[str]:
    return [f"liquid_{place}_{unit}" for place in places for unit in ("share", "m3")]
