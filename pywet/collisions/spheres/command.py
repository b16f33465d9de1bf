"""Public interface to collisions of N wet spheres in a plane (Davis 2023).

Model, contact law, accuracy and limits: docs/sphere_collisions.md. Unlike a discrete element engine, it has hard
contacts, locates every event, and takes adaptive steps for a few spheres.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pywet.collisions.spheres.equal import head_on_restitution, stokes_to_rebound, three_equal_spheres
from pywet.collisions.spheres.forms import parse
from pywet.collisions.spheres.outcome import describe, mechanism, outcome, wet_restitution
from pywet.collisions.spheres.problem import Problem
from pywet.collisions.spheres.simulate import METHODS, Run, run
from pywet.errors import shown
from pywet.util.files import read_json

__all__ = [
    "METHODS", "Problem", "Run", "collide", "describe", "head_on_restitution", "mechanism", "outcome", "parse",
    "read", "run", "stokes_to_rebound", "three_equal_spheres", "wet_restitution",
]  # fmt: skip


def collide(description: dict[str, Any], where: str = "the description") -> dict[str, Any]:
    """Run a description in either form; see `forms` for its keys and `outcome.describe` for those of the answer.

    >>> answer = collide({"form": "three_equal_spheres", "St_n": 12, "theta12_deg": 30, "t_end": 40})
    >>> answer["outcome"], round(answer["pairs"]["1-2"]["e_wet"], 4)
    ('FS', 0.1678)
    """
    return describe(run(parse(description, where)))


def read(path: Path) -> Problem:
    """Read the problem that a JSON file describes."""
    return parse(read_json(path, "see the forms in pywet docs sphere_collisions"), shown(path))
