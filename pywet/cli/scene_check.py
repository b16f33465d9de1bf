"""Print what `pywet run-scene FILE --check` would run, and the errors in the file."""

from __future__ import annotations

from pywet.cases.custom.building import Building
from pywet.cases.custom.description import Scene
from pywet.cost.command import duration
from pywet.sweep.costs import of_scene


def lines(scene: Scene) -> list[str]:
    """Return spheres, steps, predicted time, effects with reasons and warnings; a scene that `run` refuses is refused."""
    made = Building(scene)
    built = made.scene()
    spheres, seconds = sum(c.count for c in built.classes), of_scene(made).seconds
    step = f"{built.steps} steps of {built.time_step_s:.3g} s"
    return [
        f"{scene.name}: {spheres} spheres, {step}, predicted {duration(seconds)} on one core, replay included",
        *made.plan.lines,
        *made.warnings,
    ]
