"""Whole numbers of spheres of a size distribution: what was asked for is made, or refused with what would do."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

import pywet
from pywet import config, scene_stages
from pywet.cases.custom.building import Building
from pywet.cases.screening import cases
from pywet.cli.app import app
from pywet.errors import ConfigError
from pywet.planning.size_distribution import OFF, UNNOTICED, amounts, whole_counts
from reference_impl.scene.amounts import whole
from tests.cases.custom.conftest import beads
from tests.error_codes import raises_code

SIZES_MM = (9.5, 7.3, 5.6, 4.7, 4.0, 3.35, 2.8, 2.36, 2.0, 1.7, 1.4, 1.18)
SHARES = (0.02, 0.04, 0.08, 0.12, 0.15, 0.15, 0.14, 0.12, 0.08, 0.05, 0.03, 0.02)
"""A sieve analysis of twelve sizes."""


def twelve(total_g: float) -> pywet.Scene:
    """A scene of so much of the sieve analysis, at 2700 kg/m3."""
    box = {"low_mm": (0, 0, 0), "high_mm": (60, 60, 90)}
    spheres = [
        {"name": f"b{k:02d}", "material": "ore", "diameter_mm": d, "mass_g": total_g * share, "box": box}
        for k, (d, share) in enumerate(zip(SIZES_MM, SHARES, strict=True), start=1)
    ]
    return pywet.Scene(**beads(materials={"ore": {"density_kg_per_m3": 2700}}, spheres=spheres))


def test_a_run_says_what_is_asked_and_made_before_it_starts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def start(*_: object, **__: object) -> None:
        raise pywet.PywetError("the run starts here")

    sphere = {"name": "glass", "material": "g", "diameter_mm": 3, "mass_g": 1}
    scene = {"name": "two", "duration_s": 0.01, "materials": {"g": {"density_kg_per_m3": 2500}}}
    boxed = sphere | {"box": {"low_mm": [0, 0, 0], "high_mm": [60, 60, 90]}}
    (tmp_path / "two.yaml").write_text(
        json.dumps(scene | {"spheres": [boxed, boxed | {"name": "fine", "diameter_mm": 1}]})
    )
    monkeypatch.setattr(scene_stages, "finish", start)
    done = CliRunner().invoke(app, ["run-scene", str(tmp_path / "two.yaml"), "--out", str(tmp_path / "run")])
    output_text = done.stdout + done.stderr
    assert done.exit_code and all(
        output_text.index(name) < output_text.index("starts here") for name in ("asked", "made", "fine", "all")
    )


def test_a_size_of_less_than_half_a_sphere_is_refused_with_the_least_mass_that_would_do() -> None:
    """3 g would be 4.51 g with 26.9 % of the coarsest size for 2 %; half a sphere of it, 1.212 g, needs 30.3 g."""
    with raises_code("psd.few_spheres", given=pytest.approx(0.003), expected=pytest.approx(0.0304, rel=2e-3)):
        _ = Building(twelve(3.0)).classes
    assert Building(twelve(30.4)).amounts[0].count == 1


@pytest.mark.parametrize("total_g", [30.4, 61.0, 200.0])
def test_the_curve_of_sizes_and_the_total_are_those_asked_for(total_g: float) -> None:
    """Each size within half of one of its spheres and 5 %, all together within half of the finest or the limit."""
    made = Building(twelve(total_g)).amounts
    for a in made:
        assert abs(a.made_kg - a.asked_kg) <= 0.5 * a.sphere_kg * (1 + 1e-9) + OFF * a.asked_kg
    total = sum(a.made_kg for a in made)
    assert total == pytest.approx(1e-3 * total_g, rel=UNNOTICED)


@settings(max_examples=300, deadline=None)
@given(st.lists(st.tuples(st.floats(1e-3, 1.0), st.floats(1e-6, 0.1)), min_size=1, max_size=12))
def test_what_is_not_refused_is_within_the_stated_share_and_the_reference_counts_the_same(
    rows: list[tuple[float, float]],
) -> None:
    """Any masses of any sizes; the least mass of a refusal is not refused."""
    asked, one = (np.array(column) for column in zip(*rows, strict=True))
    names = [f"size {k}" for k in range(len(rows))]
    try:
        made = amounts(names, asked.tolist(), one.tolist(), "scene")
    except ConfigError as error:
        least = 1e-3 * float(str(error).split("in all in place")[0].split()[-2])
        assert least >= asked.sum() * (1 - 1e-9)
        made = amounts(names, (asked * least / asked.sum()).tolist(), one.tolist(), "scene")
        asked = asked * least / asked.sum()
    total = sum(a.made_kg for a in made)
    assert abs(total / asked.sum() - 1) <= OFF * (1 + 1e-12)
    assert [a.count for a in made] == whole(asked.tolist(), one.tolist())


def test_one_size_of_few_spheres_is_refused_where_its_mass_is_off() -> None:
    """1.4 spheres: 29 % of the mass would be missing; 2 spheres less 5 % are the least that will do."""
    with raises_code("psd.few_spheres", given=0.014, expected=pytest.approx(0.0191, rel=5e-3)):
        amounts(["ball"], [0.014], [0.01], "scene")


def test_asked_and_made_stand_side_by_side_in_the_plan() -> None:
    entry: dict[str, Any] = {**beads()["spheres"][0], "mass_g": 0.70, "name": "glass beads"}
    del entry["count"]
    made = pywet.plan(pywet.Scene(**beads(spheres=[entry])))
    grams = 20 * 2500 * math.pi / 6 * 0.003**3 * 1e3
    assert made.lines[-1].split() == ["glass", "beads", "20", "0.7", "g", f"{grams:.4g}", "g", "+1.0", "%"]
    assert made.as_dict()["amounts"][0]["made_kg"] == pytest.approx(1e-3 * grams)


def test_counts_of_the_screening_cases_are_the_nearest_numbers() -> None:
    """Each class to its nearest number is within 0.5 % in total at every scale, so that stored runs stay what they are."""
    loaded = config.load(Path("config"))
    want = {"smoke": (224, 83, 28), "reduced": (895, 332, 113), "full": (2813, 1042, 356)}
    for scale, counts in want.items():
        made = cases.ingredients(loaded, 2, scale)
        assert tuple(c.count for c in made.classes) == counts == tuple(a.count for a in made.plan.amounts)
        total = sum(a.made_kg for a in made.plan.amounts) / sum(a.asked_kg for a in made.plan.amounts)
        assert abs(total - 1) <= UNNOTICED


def test_a_screening_class_of_less_than_half_a_sphere_is_refused() -> None:
    loaded = config.load(Path("config"))
    case = loaded.case(2).model_copy(update={"class_mass_g": 1.0})
    with raises_code("psd.few_spheres"):
        cases.amounts.amounts_of(loaded, case, loaded.scale("smoke"))


def test_a_total_within_the_limit_keeps_the_nearest_numbers() -> None:
    """7.4 coarse and 1000.4 fine spheres of a hundredth: 0.3 % too little in all, nothing is moved."""
    assert whole_counts([7.03, 10.004], [1.0, 0.01]) == (7, 1000)
    assert whole_counts([7.4, 10.0], [1.0, 0.01]) == (7, 1040)
