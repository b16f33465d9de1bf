"""Feeds from sieve analyses and distributions: sizes, shares and masses by hand, and one sentence for what cannot be."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pywet
from pywet.cases.custom import building
from pywet.errors import ConfigError
from pywet.laws.contact import film_volume
from pywet.products.size_classes import SizeDistribution
from tests.cases.custom.conftest import beads
from tests.error_codes import raises_code

GOOD = {
    "comma": "lower,upper,mass %\n1,2,25\n2,4,50\n4,8,25\n",
    "semicolon, decimal commas, byte-order mark": "\ufeffvon;bis;Masse %\n1,0;2,0;25,0\n2,0;4,0;50,0\n4,0;8,0;25,0\n",
    "tab, coarsest first": "4\t8\t25%\n2\t4\t50%\n1\t2\t25%\n",
    "cumulative passing": "size mm,passing %\n1,0\n2,25\n4,75\n8,100\n",
}


@pytest.mark.parametrize("kind", GOOD)
def test_sieve_analyses_of_all_kinds_are_the_same(tmp_path: Path, kind: str) -> None:
    """Geometric means of the classes, and a quarter, half and a quarter of the mass."""
    (tmp_path / "sieve.csv").write_text(GOOD[kind], encoding="utf-8")
    sizes = SizeDistribution(file=Path("sieve.csv")).sizes(tmp_path)
    assert sizes.diameter_mm == pytest.approx([math.sqrt(2), math.sqrt(8), math.sqrt(32)])
    assert sizes.share == pytest.approx([0.25, 0.5, 0.25]) and (sizes.below, sizes.above) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("1,2,25\n2,4,50\n4,8,20\n", "psd.sum"),
        ("1,0\n2,25\n4,90\n", "psd.sum"),
        ("1,2,50\n3,4,50\n", "psd.gaps"),
        ("1,0\n2,60\n4,40\n8,100\n", "psd.falls"),
        ("1,0,2,0,25,0\n", "psd.columns"),
        ("nothing here\n", "psd.no_rows"),
        ("1,2,50\n2,four,50\n", "psd.not_numbers"),
        ("0,2,50\n2,4,50\n", "psd.from_zero"),
    ],
)
def test_files_that_are_no_sieve_analysis(tmp_path: Path, text: str, code: str) -> None:
    (tmp_path / "sieve.csv").write_text(text)
    with raises_code(code):
        SizeDistribution(file=Path("sieve.csv")).sizes(tmp_path)


def test_cut_off_mass_is_reported(tmp_path: Path) -> None:
    """Expect half of the class 1 to 2 mm below its geometric mean, in the logarithm, and another quarter above 4 mm."""
    (tmp_path / "sieve.csv").write_text(GOOD["comma"])
    sizes = SizeDistribution(file=Path("sieve.csv"), smallest_mm=math.sqrt(2), largest_mm=4).sizes(tmp_path)
    assert (sizes.below, sizes.above) == pytest.approx((0.125, 0.25))
    assert sizes.share == pytest.approx([0.2, 0.8]) and sizes.diameter_mm[0] == pytest.approx(2**0.75)


@pytest.mark.parametrize("text", ["4;20\n8;60\n16;100\n", "0;4;20\n4;8;40\n8;16;40\n"], ids=["passing", "classes"])
def test_the_finest_class_of_a_file_is_cut_by_size_only(tmp_path: Path, text: str) -> None:
    """From 0 on there is no logarithm; by size half of 20 % is above 2 mm, and a limit at its sieve leaves out all of it."""
    (tmp_path / "sieve.csv").write_text(text)
    for low in (None, 2.0, 3.999):
        with raises_code("psd.from_zero", given=low or 0.0, expected=4.0):
            SizeDistribution(file=Path("sieve.csv"), smallest_mm=low).sizes(tmp_path)
    whole = SizeDistribution(file=Path("sieve.csv"), smallest_mm=4).sizes(tmp_path)
    assert whole.below == pytest.approx(0.2) and whole.share == pytest.approx([0.5, 0.5])
    cut = SizeDistribution(file=Path("sieve.csv"), smallest_mm=2, within="size").sizes(tmp_path)
    assert cut.below == pytest.approx(0.1) and cut.share == pytest.approx(np.array([1, 4, 4]) / 9)
    assert cut.diameter_mm == pytest.approx([3, 6, 12])


def test_what_passes_a_size_of_zero_is_left_out_as_finer(tmp_path: Path) -> None:
    (tmp_path / "sieve.csv").write_text("0,3\n1,40\n2,100\n")
    sizes = SizeDistribution(file=Path("sieve.csv"), smallest_mm=1).sizes(tmp_path)
    assert (sizes.below, sizes.above) == pytest.approx((0.4, 0.0)) and sizes.share == pytest.approx([1.0])


def test_limits_between_which_a_file_has_no_mass_are_refused(tmp_path: Path) -> None:
    (tmp_path / "sieve.csv").write_text("0.5,1,50\n1,2,0\n2,4,50\n")
    with raises_code("psd.empty"):
        SizeDistribution(file=Path("sieve.csv"), smallest_mm=1, largest_mm=2).sizes(tmp_path)


@pytest.mark.parametrize(
    ("given", "passing"),
    [
        ({"rosin_rammler": {"size_mm": 3, "spread": 2}}, lambda d: 1 - math.exp(-((d / 3) ** 2))),
        (
            {"log_normal": {"median_mm": 3, "sigma": 0.5}},
            lambda d: 0.5 * (1 + math.erf(math.log(d / 3) / 0.5 / math.sqrt(2))),
        ),
        ({"gaudin_schuhmann": {"largest_mm": 6, "exponent": 0.7}}, lambda d: min(1.0, (d / 6) ** 0.7)),
    ],
)
def test_distributions_by_their_formulas(given: dict[str, Any], passing: Any) -> None:
    sizes = SizeDistribution(**given, smallest_mm=1, largest_mm=5, classes=4).sizes()
    edges = 5 ** (np.arange(5) / 4)
    want = np.diff([passing(d) for d in edges])
    assert sizes.share == pytest.approx(want / want.sum()) and sizes.diameter_mm == pytest.approx(
        5 ** ((np.arange(4) + 0.5) / 4)
    )
    assert (sizes.below, sizes.above) == pytest.approx((passing(1), 1 - passing(5)))


def test_a_continuous_distribution_of_ratio_ten() -> None:
    """Three sizes stand for each of twelve classes, with equal masses within a class; the coarsest 1 % is left out."""
    sizes = SizeDistribution(
        log_normal={"median_mm": 3, "sigma": 0.5}, smallest_mm=1, classes=12, sizes_per_class=3
    ).sizes()
    assert len(sizes.share) == 36 and sizes.share.sum() == pytest.approx(1.0) and sizes.above == pytest.approx(0.01)
    assert (
        sizes.share.reshape(12, 3).std(axis=1).max() < 1e-15 and sizes.diameter_mm.max() / sizes.diameter_mm.min() > 9
    )


def feed(**changes: Any) -> dict[str, Any]:
    given = {
        "name": "ore", "material": "glass", "psd": {"gaudin_schuhmann": {"largest_mm": 4, "exponent": 1}, "smallest_mm": 2},
        "rate_t_per_h": 0.036, "box": {"low_mm": (-20, -20, 20), "high_mm": (20, 20, 40)}, "velocity_m_per_s": (0, 0, -0.5),
        "insertion": {"for_s": 0.5}, **changes,
    }  # fmt: skip
    given["psd"] = {"classes": 3, **given["psd"]}
    return beads(duration_s=1.0, spheres=[], feed=[given], liquid={"percent": 0})


@pytest.mark.parametrize(
    ("changes", "dry_g", "percent"),
    [
        ({}, 5.0, None),
        ({"moisture_percent": 25, "rate_of": "moist"}, 4.0, 25.0),
        ({"moisture_percent": 20, "moisture_of": "moist", "rate_of": "moist"}, 4.0, 25.0),
        ({"moisture_percent": 20, "moisture_of": "moist"}, 5.0, 25.0),
        ({"rate_t_per_h": None, "mass_g": 6}, 6.0, None),
    ],
)
def test_mass_and_moisture_of_a_feed(changes: dict[str, Any], dry_g: float, percent: float | None) -> None:
    """0.036 t/h are 10 g/s, in 0.5 s 5 g; 20 % of the moist mass are 25 % of the dry one, and dry is moist over 1.25."""
    scene = pywet.Scene(**feed(**changes)).in_full()
    assert sum(s.mass_g for s in scene.spheres) == pytest.approx(dry_g)
    assert all(s.percent == (percent if percent is None else pytest.approx(percent)) for s in scene.spheres)
    edges = np.geomspace(2, 4, 4)
    assert [s.mass_g / dry_g for s in scene.spheres] == pytest.approx(np.diff(edges) / 2)


def test_numbers_of_spheres_are_reported_before_a_run(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """Whole spheres of every class within 5 % of its mass; half of the mass is below 2 mm and left out."""
    made = building.Building(pywet.Scene(**feed()))
    asked = {a.name: a.asked_kg for a in made.amounts}
    for c in made.classes:
        assert c.count * c.mass_kg == pytest.approx(asked[c.name], abs=0.5 * c.mass_kg)
    with caplog.at_level("WARNING"):
        scene = building.write(pywet.Scene(**feed()), tmp_path / "run")
    assert f"feed ore: {sum(c.count for c in scene.classes)} spheres of 3 sizes" in caplog.text
    assert "50 % of its mass finer" in caplog.text


def test_moisture_of_a_feed_is_that_of_each_size_and_per_cent_of_the_liquid_one_thickness() -> None:
    """The sentence on the feed tells which, and names the other way."""
    for liquid, more in (({}, {"moisture_percent": 2}), ({"percent": 2}, {})):
        scene = pywet.Scene(**{**feed(**more), "liquid": liquid})
        made = building.Building(scene)
        film = [film_volume(h, c.radius_m) for h, c in zip(made.thickness, made.classes, strict=True)]
        percent = [100 * 1000 * v / c.mass_kg for v, c in zip(film, made.classes, strict=True)]
        same = percent if more else made.thickness
        assert same == pytest.approx([same[0]] * 3, rel=1e-6)
        sentence = "each size with 2 % of liquid (liquid.percent: one film thickness for all sizes)"
        assert (sentence in building.feeds(scene, made.classes)[0]) == bool(more)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"mass_g": 3}, "a mass_g or a rate_t_per_h, one of them"),
        ({"insertion": None}, "an insertion for rate_t_per_h"),
        ({"velocity_m_per_s": (0, 0, 0)}, "feed ore: a velocity_m_per_s together with insertion"),
        ({"moisture_percent": 60, "moisture_of": "moist"}, "a moisture of at most 100 % of the dry mass"),
        ({"moisture_percent": None, "rate_of": "moist"}, "a moisture_percent with rate_of: moist"),
        ({"psd": {"rosin_rammler": {"size_mm": 3, "spread": 2}}}, "a smallest_mm"),
        ({"psd": {"smallest_mm": 1}}, "one of file, rosin_rammler, log_normal, gaudin_schuhmann, not none"),
        ({"material": "gold"}, "feed ore to name a material"),
    ],
)
def test_feeds_that_cannot_be_are_refused(changes: dict[str, Any], words: str) -> None:
    given = feed(**changes)
    if "psd" in changes:
        given["feed"][0]["psd"] = changes["psd"]
    with pytest.raises(ConfigError, match=words):
        pywet.Scene(**given).in_full()
