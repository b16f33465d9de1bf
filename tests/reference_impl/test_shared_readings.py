"""Numbers of docs/shared_readings.md that follow from a closed form."""

from __future__ import annotations

import math
from pathlib import Path

PAGE = (Path(__file__).parents[2] / "docs" / "shared_readings.md").read_text()


def too_strong(sphere: float, wire: float) -> float:
    """Pull of a plane over that of a crossed cylinder at touch, for little liquid.

    Derjaguin: F is 4 pi sigma cos(theta) times the geometric mean of the two radii of relative curvature, r and r R/(r + R); a
    plane has R infinite.
    """
    mean = math.sqrt(sphere * (sphere * wire / (sphere + wire)))
    return sphere / mean


def test_wire_as_plane() -> None:
    """The two ranges of the first row, for the wires and spheres of the paper's screens."""
    for wire in (1e-3, 0.8e-3):
        low, high = (too_strong(r, wire) for r in (1.5e-3, 5e-3))
        assert f"{low:.2f} to {high:.2f}" in PAGE
    assert math.isclose(too_strong(1e-3, 1e6), 1.0, rel_tol=1e-6)
