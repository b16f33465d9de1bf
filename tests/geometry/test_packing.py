"""Spheres at the start: all there, apart, inside, reproducible, or refused."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.spatial import cKDTree

from pywet.cases.small.bodies import sphere_classes
from pywet.geometry import FeedRegion, fill, packing
from pywet.scene import SphereClass
from tests.error_codes import raises_code

FULL = FeedRegion("cylinder", 0.1994, 0.05, 0.16)
SMOKE = FeedRegion("square", 0.05, 0.05, 0.16)


FINE = sphere_classes(0.0015, 0.0025, 0.0035, counts=(13021, 2674, 1017))
COARSE = sphere_classes(0.0025, 0.0035, 0.005, counts=(200, 75, 26))


def check(table: pd.DataFrame, classes: tuple[SphereClass, ...], region: FeedRegion) -> None:
    assert list(table.columns) == ["id", "type", "x", "y", "z"]
    assert table["id"].tolist() == list(range(1, len(table) + 1))
    assert table["type"].value_counts().to_dict() == {c.type: c.count for c in classes}
    radius = table["type"].map({c.type: c.radius_m for c in classes}).to_numpy()
    xyz = table[["x", "y", "z"]].to_numpy()
    pairs = cKDTree(xyz).query_pairs(2 * radius.max(), output_type="ndarray")
    gap = np.linalg.norm(xyz[pairs[:, 0]] - xyz[pairs[:, 1]], axis=1) - radius[pairs].sum(axis=1)
    assert gap.min() > 0.0
    across = np.hypot(xyz[:, 0], xyz[:, 1]) if region.shape == "cylinder" else np.abs(xyz[:, :2]).max(axis=1)
    assert (across + radius < 0.5 * region.width_m).all()
    assert (xyz[:, 2] - radius > region.z_low_m).all()
    assert (xyz[:, 2] + radius < region.z_high_m).all()


@pytest.mark.parametrize(("classes", "region"), [(FINE, FULL), (COARSE, SMOKE)])
def test_all_spheres_are_inside_and_apart(classes: tuple[SphereClass, ...], region: FeedRegion) -> None:
    table = fill(classes, region, 11)
    check(table, classes, region)
    radius = table["type"].map({c.type: c.radius_m for c in classes})
    top = (table["z"] + radius).max() - region.z_low_m
    solid = sum(c.count * 4 / 3 * math.pi * c.radius_m**3 for c in classes)
    assert solid / (top * region.cross_section) == pytest.approx(0.28, rel=0.12)  # 0.28, or one growth step less


def test_same_seed_same_spheres() -> None:
    pd.testing.assert_frame_equal(fill(COARSE, SMOKE, 5), fill(COARSE, SMOKE, 5), check_exact=True)
    pd.testing.assert_frame_equal(fill(COARSE, SMOKE, 5), fill(COARSE, SMOKE, [5, 0]), check_exact=True)
    assert not np.allclose(fill(COARSE, SMOKE, 5)["x"], fill(COARSE, SMOKE, 6)["x"])


def test_classes_are_mixed() -> None:
    """The mean height of each class is that of all within four standard errors of a uniform draw."""
    table = fill(FINE, FULL, 2)
    spread = table["z"].std()
    for _, group in table.groupby("type"):
        assert abs(group["z"].mean() - table["z"].mean()) < 4 * spread / math.sqrt(len(group)) + 0.002


def test_no_spheres_at_all() -> None:
    assert len(fill(sphere_classes(0.002, counts=0), SMOKE, 1)) == 0


@pytest.mark.parametrize("high_m", [0.00301, 0.0031, 0.00315, 0.0033])
def test_a_region_hardly_higher_than_a_sphere_is_filled(high_m: float) -> None:
    """Five spheres of 3 mm and 20 of 2 mm; a lower one than they are is refused with a height at which they fit."""
    classes, region = sphere_classes(0.001, 0.0015, counts=(20, 5)), FeedRegion("square", 0.03, 0.0, high_m)
    check(fill(classes, region, 1), classes, region)
    with raises_code("packing.crowded", says="into 2.99 mm of .* at least about 3.15 mm"):
        fill(classes, replace(region, z_high_m=0.00299), 1)


def test_the_last_height_that_is_tried_is_that_of_the_region(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[float] = []
    monkeypatch.setattr(packing, "_place_all", lambda classes, region, height, _: tried.append(height))
    with raises_code("packing.crowded"):
        fill(COARSE, SMOKE, 1)
    assert len(tried) > 2 and tried[-1] == SMOKE.z_high_m - SMOKE.z_low_m


@pytest.mark.parametrize("classes", [sphere_classes(0.0025, counts=3000), sphere_classes(0.03)])
def test_too_many_or_too_large_are_refused(classes: tuple[SphereClass, ...]) -> None:
    with raises_code("packing.crowded") as caught:
        fill(classes, SMOKE, 1)
    assert "\n" not in str(caught.value)
