"""Custom scenes for tests: the shipped examples, made small."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pywet.cases.custom.description import Scene
from pywet.config.loading import read_yaml

EXAMPLES = Path(__file__).parents[3] / "examples" / "scenes"


def example(name: str, spheres: dict[str, Any] | None = None, folder: Path = EXAMPLES, **changes: Any) -> Scene:
    """An example with other `spheres` entries (of all classes) and other keys."""
    given = read_yaml(folder / f"{name}.yaml", Scene)
    if "spheres" in given:
        given["spheres"] = [{**s, **(spheres or {})} for s in given["spheres"]]
    return Scene(**{"folder": EXAMPLES, **given, **changes})


def beads(**changes: Any) -> dict[str, Any]:
    """Describe a small scene: 20 beads in a box, without walls."""
    box = {"low_mm": (0, 0, 0), "high_mm": (20, 20, 20)}
    entry = {"name": "beads", "material": "glass", "diameter_mm": 3, "count": 20, "box": box}
    return {
        "name": "test",
        "duration_s": 0.01,
        "materials": {"glass": {"density_kg_per_m3": 2500}},
        "spheres": [entry],
        **changes,
    }
