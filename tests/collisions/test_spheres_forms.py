"""The JSON descriptions and the command `pywet collide spheres`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from pywet.cli.app import app
from pywet.collisions.spheres.command import collide
from tests.error_codes import code_of, raises_code

EXAMPLES = Path(__file__).parent.parent.parent / "examples"
THREE = json.loads((EXAMPLES / "three_equal_spheres.json").read_text())
FOUR = json.loads((EXAMPLES / "four_spheres.json").read_text())


def test_command_prints_json() -> None:
    result = CliRunner().invoke(app, ["collide", "spheres", str(EXAMPLES / "three_equal_spheres.json")])
    assert result.exit_code == 0, result.output
    answer = json.loads(result.stdout)
    assert answer["outcome"] == "FS"
    assert answer["pairs"]["1-2"]["e_wet"] == pytest.approx(0.168, abs=5e-4)  # printed in the paper, Fig. 11
    assert answer["pairs"]["2-3"]["e_wet"] == pytest.approx(0.393, abs=5e-4)
    assert answer["pairs"]["1-3"] == {
        "overlap_times": [], "contact_times": [], "rest_times": [], "separation_times": [], "e_wet": None, "mechanism": None,
    }  # fmt: skip
    assert abs(answer["energy"]["residual"]) < 1e-8 * answer["energy"]["in"]


def test_si_form_closes_its_budget() -> None:
    answer = collide(FOUR)
    e = answer["energy"]
    assert e["in"] + e["gravity"] - e["out"] == pytest.approx(e["viscous"] + e["capillary"] + e["impact"], rel=1e-8)
    assert answer["outcome"] == "FS"


def test_both_forms_describe_the_same_collision() -> None:
    """Three equal spheres written in SI units: radius 1 mm, δ 20 µm, 0.4 m/s, St 12."""
    length, speed, mass, stokes, angle = 2e-5, 0.4, 5e-6, 12.0, 30.0
    import math

    a = 0.5e-3
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    at = 2e-3 + length
    sphere: dict[str, Any] = {"radius_m": 1e-3, "mass_kg": mass, "film_m": length / 2}
    si = {
        "form": "spheres",
        "spheres": [
            {**sphere, "position_m": [-at * c, -at * s], "velocity_m_per_s": [speed / c, 0.0]},
            {**sphere, "position_m": [0.0, 0.0]},
            {**sphere, "position_m": [at, 0.0]},
        ],
        "viscosity_Pa_s": mass / 2 * speed / (6 * math.pi * a**2 * stokes),
        "h_min_m": 0.05 * length, "t_end_s": 10 * length / speed, "rtol": 1e-10,
    }  # fmt: skip
    ours, plain = collide(si), collide({**THREE, "t_end": 10.0})
    assert ours["pairs"]["1-2"]["e_wet"] == pytest.approx(plain["pairs"]["1-2"]["e_wet"], rel=1e-7)
    assert ours["pairs"]["2-3"]["separation_times"][0] * speed / length == pytest.approx(
        plain["pairs"]["2-3"]["separation_times"][0], rel=1e-7
    )


def test_the_answer_says_which_speed_restitution_refers_to_and_the_input_can_set_it() -> None:
    """v_n0 = 1 in the dimensionless form; in SI the normal approach of the first pair. Halved, e_wet doubles, all else stays."""
    plain, halved = collide(THREE), collide({**THREE, "reference_speed": 0.5})
    assert (plain["reference_speed"], halved["reference_speed"]) == (1.0, 0.5)
    assert halved["pairs"]["1-2"]["e_wet"] == pytest.approx(2.0 * plain["pairs"]["1-2"]["e_wet"], rel=1e-14)
    assert (halved["final"], halved["work"]) == (plain["final"], plain["work"])
    # of the example's four 1 and 4 meet fastest: v = (1.1, 0.6) m/s, d = (4, 2.1) mm, films touch at 2.04 mm, so that the
    # normal speed there is v √(1 − (d × v/(2.04 v))²)
    si = collide(FOUR)
    v2, cross = 1.1**2 + 0.6**2, (4.0 * 0.6 - 2.1 * 1.1) / 2.04
    assert si["reference_speed"] == pytest.approx((v2 - cross**2) ** 0.5, rel=1e-12)
    set_ = collide({**FOUR, "reference_speed_m_per_s": 0.8})
    assert set_["reference_speed"] == 0.8 and set_["final"] == si["final"]


@pytest.mark.parametrize(
    ("given", "code", "key"),
    [
        ([], "spheres.form", "form"),
        ({"form": "cubes"}, "spheres.form", "form"),
        ({"form": "three_equal_spheres"}, "config.missing_key", "St_n"),
        ({**THREE, "St": 3}, "config.unknown_key", "St"),
        ({**THREE, "St_n": -1}, "config.value", "St_n"),
        ({**THREE, "theta12_deg": 95}, "spheres.value", "theta12_deg"),
        ({**FOUR, "spheres": FOUR["spheres"][:1]}, "config.value", "spheres"),
        (
            {**FOUR, "spheres": [{**FOUR["spheres"][0], "radius_m": 0}, FOUR["spheres"][1]]},
            "config.value",
            "spheres.0.radius_m",
        ),
        ({**FOUR, "h_min_m": 1e-3}, "spheres.thin_films", "spheres 1 and 2"),
    ],
)
def test_a_mistake_is_one_sentence(given: Any, code: str, key: str) -> None:
    with raises_code(code, key=key) as refusal:
        collide(given)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(("text", "code"), [("{", "file.not_json"), (None, "file.unread")])
def test_a_file_that_is_no_json(tmp_path: Path, text: str | None, code: str) -> None:
    path = tmp_path / "a.json"
    if text is not None:
        path.write_text(text)
    result = CliRunner(env={"COLUMNS": "200", "NO_COLOR": "1"}).invoke(app, ["collide", "spheres", str(path)])
    assert (result.exit_code, code_of(result)) == (1, code)
