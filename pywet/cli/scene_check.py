"""Print what `pywet run-scene FILE --check` would run, and the errors in the file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pywet.cases.custom.building import Building, feeds
from pywet.cases.custom.description import Scene
from pywet.cost.command import duration
from pywet.engines.schedule import early_end
from pywet.scene import EngineScene, SphereClass
from pywet.sweep.costs import of_scene

MOST_BLOCKS = 10**9
"""Blocks of the longest run of a scene with `until`, whatever their length."""
NEAR = 0.8
"""Diameter over aperture of the class whose adhesion number is printed, for each deck: the near-mesh size of docs/screens.md."""


def lines(scene: Scene, reasons: bool = False) -> list[str]:
    """Return spheres, steps, predicted time, feeds, effects and warnings; a scene that `run` refuses is refused.

    `reasons`: effects with their quantities and reasons, in lines longer than 80 characters.
    """
    made = Building(scene)
    built = made.scene(MOST_BLOCKS)
    spheres, seconds = sum(c.count for c in built.classes), of_scene(made).seconds
    most = "at most " if scene.until else ""
    step = f"{most}{built.steps} steps of {built.time_step_s:.3g} s"
    return [
        f"{scene.name}: {spheres} spheres, {step}",
        f"predicted {most}{duration(seconds)} on one core, replay included",
        *feeds(scene, built.classes),
        *(made.plan.lines if reasons else [*made.plan.table, *made.plan.hint]),
        *made.warnings,
        *early_end(built),
        *_deck(scene, built),
    ]


def _deck(scene: Scene, built: EngineScene) -> Iterator[str]:
    """Yield the throw number of a deck, and for a moist feed the adhesion number of each of its decks."""
    if (deck := scene.deck) is None:
        return
    if deck.inclination_deg:
        gravity = ", ".join(f"{g:.3g}" for g in deck.gravity)
        yield f"positions are relative to the deck, gravity there is ({gravity}) m/s2"
    yield f"throw number {deck.acceleration_ratio:.3g}"
    if built.liquid is None:
        return
    for k, (level, _) in enumerate(deck.levels, start=1):
        near = _nearest(built.classes, 0.5e-3 * NEAR * level.aperture_mm)
        given = near.radius_m, near.density_kg_per_m3, near.contact_angle_rad, built.liquid.surface_tension_N_per_m
        number, of = f"{deck.adhesion_number(*given):.2g}", f"deck {k}, " if deck.beneath else ""
        page = "" if deck.beneath else " (pywet docs screens)"  # within 80 columns
        yield f"adhesion number {number} ({of}{near.name}): above 1 it may block{page}"


def _nearest(classes: Sequence[SphereClass], radius_m: float) -> SphereClass:
    """Return the class whose radius is nearest to this one."""
    return min(classes, key=lambda c: abs(c.radius_m - radius_m))
