"""Analytic wires: every wire of every shipped screen is one; other shapes are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pywet import config
from pywet.cases.screening import cases
from pywet.geometry import build_apparatus
from pywet.geometry.analytic_wires import analytic_wire_of
from pywet.geometry.solids import polygon, tube
from tests.error_codes import raises_code

CONFIG = config.load(Path(__file__).parents[2] / "config")
APERTURES = {case.aperture_mm: case for case in CONFIG.cases.values()}


@pytest.mark.parametrize("aperture", sorted(APERTURES))
def test_every_wire_of_a_screen_is_an_analytic_wire(aperture: float) -> None:
    """Eight corners on the wire's circle, ends at its caps; positions to single precision of 0.1 m."""
    scale = CONFIG.scale("full")
    wires = build_apparatus(cases.apparatus_spec(CONFIG, APERTURES[aperture], scale)).surfaces[0]
    for part, radius in enumerate(wires.part_half_width):
        of_part = wires.corners[wires.part == part]
        found = analytic_wire_of(of_part, f"wire {part}")
        assert len(found.section) == scale.wire_sides.value
        middle = 0.5 * (found.section.min(axis=0) + found.section.max(axis=0))
        assert np.linalg.norm(found.section - middle, axis=1) == pytest.approx(np.full(8, radius), abs=1e-8)
        assert found.low == of_part[..., found.axis].min() and found.high == of_part[..., found.axis].max()


def test_what_is_no_analytic_wire_is_refused() -> None:
    """A flat face bounds nothing, and a tube has a hollow section."""
    hollow = np.concatenate([part for part, _ in tube(0.01, 0.002, 4, 0.0, 0.05)])
    square = np.column_stack([polygon(0.01, 4), np.zeros(4)])
    shapes = {"a face": square[[[0, 1, 2], [0, 2, 3]]], "a tube": hollow}
    for name, corners in shapes.items():
        with raises_code("surface.not_prism", key=name):
            analytic_wire_of(corners, name)
