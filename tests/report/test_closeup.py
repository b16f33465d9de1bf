"""The surface that a close-up shows is the bridge: it ends on both bodies, and what it encloses next to them is the volume."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet.laws import exact_bridge
from pywet.report import closeup
from pywet.runs.rundir import Floats, RunDir
from tests.cases.screening import synthetic
from tests.error_codes import raises_code

MM = 1e-3


def enclosed(points: Floats, axis: Floats) -> float:
    """Volume between rings of points around an axis through their middles: regular polygons, frusta between them [m3]."""
    middle = points.mean(axis=1)
    radius = np.linalg.norm(points - middle[:, None], axis=2).mean(axis=1)
    area = np.pi * radius**2
    height = np.diff(middle @ axis)
    return float((height * (area[1:] + area[:-1] + np.sqrt(area[1:] * area[:-1])) / 3).sum())


def cap(radius: float, ring: float) -> float:
    """Volume of a sphere's cap above a ring [m3]."""
    depth = radius - np.sqrt(radius**2 - ring**2)
    return float(np.pi * depth**2 * (3 * radius - depth) / 3)


@pytest.mark.parametrize(
    ("ri", "rj", "gap", "volume", "angles"), [(2.5, 4.0, 0.1, 0.3, (0.3, 0.8)), (2.5, np.inf, 0.2, 0.8, (0.5, 0.2))]
)
def test_the_surface_ends_on_both_bodies_and_encloses_the_volume(
    ri: float, rj: float, gap: float, volume: float, angles: tuple[float, float]
) -> None:
    bridge = exact_bridge.solve(gap * MM, volume * MM**3, ri * MM, rj * MM, *angles)
    assert bridge is not None
    axis, first = np.array([2.0, -1.0, 2.0]) / 3.0, np.array([1.0, -2.0, 0.5]) * MM
    wall = np.isinf(rj)
    second = first + (ri + gap + (0.0 if wall else rj)) * MM * axis
    points = closeup.revolved(bridge, first, second)
    np.testing.assert_allclose(np.linalg.norm(points[0] - first, axis=1), ri * MM, rtol=1e-9)
    caps = cap(ri * MM, bridge.contact_radii[0])
    if wall:
        np.testing.assert_allclose((points[-1] - first) @ axis, (ri + gap) * MM, rtol=1e-9)
    else:
        np.testing.assert_allclose(np.linalg.norm(points[-1] - second, axis=1), rj * MM, rtol=1e-9)
        caps += cap(rj * MM, bridge.contact_radii[1])
    # 60 frusta approximate the curve: the volume differs by a few parts per thousand
    assert enclosed(points, axis) - caps == pytest.approx(volume * MM**3, rel=5e-3)


def test_a_partner_across_a_periodic_boundary_is_at_its_end_of_the_bridge() -> None:
    """Box of 40 mm: sphere 1 at -19 mm has partners at 19 and 17 mm, as i and as j of the bridge; a wall is left as it is."""
    columns = ["partner_kind", "i", "j", *(f"{end}_{axis}" for end in ("xi", "xj") for axis in "xyz")]
    rows = [
        (0, 1, 2, -0.019, 0, 0, -0.021, 0, 0),
        (0, 0, 1, 0.017, 0, 0, 0.021, 0, 0),
        (1, 1, 2, -0.019, 0, 0, -0.019, 0, -0.001),
    ]
    centre = np.array([-0.019, 0.0, 0.0])
    moved, partners = closeup.around(pd.DataFrame(rows, columns=columns).astype(float), 1, centre)
    assert {n: at.tolist() for n, at in partners.items()} == {2: [-0.021, 0, 0], 0: [pytest.approx(-0.023), 0, 0]}
    ends = moved[columns[3:]].to_numpy()
    assert ends[1] == pytest.approx([-0.023, 0, 0, -0.019, 0, 0]) and ends[[0, 2]] == pytest.approx(
        np.array([row[3:] for row in (rows[0], rows[2])])
    )


def test_what_cannot_be_solved_stays_a_cuboid(tmp_path: Path) -> None:
    run = RunDir(synthetic.make(tmp_path / "case02"))
    bridges = run.at_step("history/bridges", 200)
    beyond = bridges.assign(separation=[1e-4, 1e-2])
    assert [bridge is None for bridge in closeup.exact(run, beyond)] == [False, True]


def test_a_sphere_without_bridges_is_refused(tmp_path: Path) -> None:
    with raises_code("closeup.no_bridge", given=2):
        closeup.write(synthetic.make(tmp_path / "case02"), tmp_path / "x.png", 2, 200)
