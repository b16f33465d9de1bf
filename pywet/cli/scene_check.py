"""Print what `pywet run-scene FILE --check` would run, and the errors in the file."""

from __future__ import annotations

from pywet.cases.custom.building import Building, feeds
from pywet.cases.custom.description import Scene
from pywet.cost.command import duration
from pywet.sweep.costs import of_scene


def lines(scene: Scene, reasons: bool = False) -> list[str]:
    """Return spheres, steps, predicted time, feeds, effects and warnings; a scene that `run` refuses is refused.

    `reasons`: effects with their quantities and reasons, in lines longer than 80 characters.
    """
    made = Building(scene)
    built = made.scene()
    spheres, seconds = sum(c.count for c in built.classes), of_scene(made).seconds
    step = f"{built.steps} steps of {built.time_step_s:.3g} s"
    return [
        f"{scene.name}: {spheres} spheres, {step}",
        f"predicted {duration(seconds)} on one core, replay included",
        *feeds(scene, built.classes),
        *(made.plan.lines if reasons else [*made.plan.table, *made.plan.hint]),
        *made.warnings,
    ]
