"""Input files: what is accepted, what is refused and how it is said; sweeps; the data of tables 1 to 5."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from pywet.cli.app import app
from pywet.collisions.wall import sweep, wall
from pywet.collisions.wall.problem import VARIANTS, Problem
from pywet.config.loading import parse
from pywet.errors import PywetError
from studies.buck2018 import buck_tables
from tests.collisions.cases import problem
from tests.error_codes import code_of, error_of, raises_code

EXAMPLES = Path(__file__).parents[2] / "examples"
OUTPUT = {
    "e_n", "e_t", "e_omega", "stuck", "v_n_out", "v_t_out", "omega_out", "energy_J", "rupture_length_m", "bridge_volume_m3",
    "duration_s", "events",
}  # fmt: skip


def content(**changed: Any) -> dict[str, Any]:
    """An input file's content."""
    base = json.loads((EXAMPLES / "wall_wet.json").read_text())
    return {**base, **changed}


@pytest.fixture
def runner() -> CliRunner:
    return CliRunner(env={"COLUMNS": "200", "NO_COLOR": "1"})


def test_example_gives_what_outsiders_rely_on(runner: CliRunner) -> None:
    result = runner.invoke(app, ["collide", "wall", str(EXAMPLES / "wall_wet.json")])
    assert result.exit_code == 0, result.output
    answer = json.loads(result.stdout)
    assert set(answer) >= OUTPUT
    energies = answer["energy_J"]
    assert set(energies) == {"in", "out", "contact", "viscous", "capillary", "gravity", "residual"}
    mass = 4 / 3 * np.pi * 2500 * 0.87e-3**3
    assert energies["in"] == pytest.approx(0.5 * mass, rel=1e-12)
    assert energies["out"] == pytest.approx(0.5 * mass * answer["e_n"] ** 2, rel=1e-12)
    assert answer["rupture_length_m"] == pytest.approx(
        (1 + np.radians(15) / 2)
        * (1 + np.sqrt(1e-3 * answer["v_n_out"] / 0.0728))
        * answer["bridge_volume_m3"] ** (1 / 3),
        rel=1e-9,
    )
    assert answer["e_t"] is None and answer["e_omega"] is None


def test_a_sweep_is_a_table_whose_rows_are_single_collisions(runner: CliRunner, tmp_path: Path) -> None:
    file, csv = EXAMPLES / "wall_sweep.json", tmp_path / "out.csv"
    result = runner.invoke(app, ["collide", "wall", str(file), "--csv", str(csv)])
    rows = json.loads(result.stdout)
    assert len(rows) == 16
    row = next(r for r in rows if r["normal_velocity_m_per_s"] == 1.0 and r["liquid.layer_thickness_m"] == 400e-6)
    alone = wall.collide(parse(Problem, content(), "example"))
    assert row["e_n"] == alone["e_n"] and row["energy_viscous_J"] == alone["energy_J"]["viscous"]
    assert pd.read_csv(csv)["e_n"].to_list() == pytest.approx([r["e_n"] for r in rows], rel=1e-12)
    shown = runner.invoke(app, ["collide", "wall", str(file), "--table"]).stdout.splitlines()
    assert len(shown) == 17 and shown[0].split()[:2] == ["liquid.layer_thickness_m", "normal_velocity_m_per_s"]


@pytest.mark.parametrize("file", sorted(EXAMPLES.glob("wall_*.json")), ids=lambda f: f.name)
def test_examples_run(runner: CliRunner, file: Path) -> None:
    result = runner.invoke(app, ["collide", "wall", str(file)])
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)


def changed(path: str, value: Any) -> dict[str, Any]:
    """The example with one value replaced (None: removed)."""
    whole = content()
    inner = whole
    *keys, last = path.split(".")
    for key in keys:
        inner = inner[key]
    if value is None:
        del inner[last]
    else:
        inner[last] = value
    return whole


@pytest.mark.parametrize(
    ("path", "value", "code", "key", "says"),
    [
        ("angle_deg", 90, "config.value", "angle_deg", ""),
        ("normal_velocity_m_per_s", 0, "config.value", "normal_velocity_m_per_s", ""),
        ("particle.restitution", 1.1, "config.value", "particle.restitution", ""),
        ("particle.radius", 1e-3, "config.unknown_key", "particle.radius", ""),
        ("liquid.half_filling_angle_deg", 0, "config.value", "liquid.half_filling_angle_deg", ""),
        ("liquid.contact_angle_deg", 170, "config.value", "liquid.contact_angle_deg", ""),
        ("liquid.viscosity_Pa_s", None, "config.missing_key", "liquid.viscosity_Pa_s", ""),
        ("wall", None, "config.inconsistent", "", "either wall or partner"),
        ("variant", "printed", "config.value", "variant", ""),
        ("readings", {"gapp": "mended"}, "config.unknown_key", "readings.gapp", ""),
        ("readings", {"gap": "other"}, "config.value", "readings.gap", ""),
        ("rtol", 1.0, "config.value", "rtol", ""),
        ("readings", {"capillary": "film_and_bridge"}, "config.inconsistent", "", "a layer thinner than"),
        ("friction", [], "wall.empty_list", "friction", ""),
        ("omega_rad_per_s", [0, "x"], "config.value", "omega_rad_per_s", ""),
    ],
)
def test_a_mistake_is_one_sentence(
    runner: CliRunner, tmp_path: Path, path: str, value: Any, code: str, key: str, says: str
) -> None:
    file = tmp_path / "case.json"
    file.write_text(json.dumps(changed(path, value)))
    result = runner.invoke(app, ["collide", "wall", str(file)])
    assert result.exit_code == 1, result.output
    assert says in result.stderr and len(result.stderr.strip().splitlines()) == 1
    error = error_of(result)
    assert error and (error.code, error.key) == (code, key)


@pytest.mark.parametrize(("text", "code"), [("{", "file.not_json"), ("[1]", "file.shape"), (None, "file.unread")])
def test_a_file_that_is_no_input(runner: CliRunner, tmp_path: Path, text: str | None, code: str) -> None:
    file = tmp_path / "case.json"
    if text is not None:
        file.write_text(text)
    result = runner.invoke(app, ["collide", "wall", str(file)])
    assert (result.exit_code, code_of(result)) == (1, code)


def test_table_and_csv_are_for_sweeps(runner: CliRunner) -> None:
    result = runner.invoke(app, ["collide", "wall", str(EXAMPLES / "wall_wet.json"), "--table"])
    assert (result.exit_code, code_of(result)) == (1, "wall.no_list")


def test_a_sweep_of_a_million_and_more_is_refused() -> None:
    many = content(angle_deg=[0.0] * 1001, omega_rad_per_s=[0.0] * 1001)
    with raises_code("wall.many", given=1002001):
        sweep.table(many)


def test_a_refused_collision_does_not_stop_a_sweep(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its row has the sentence and no numbers."""
    whole = wall.collide

    def sometimes(case: Problem) -> dict[str, Any]:
        if case.angle_deg > 20:
            raise PywetError("too steep")
        return whole(case)

    monkeypatch.setattr(wall, "collide", sometimes)
    rows = sweep.records(sweep.table(content(angle_deg=[10, 30])))
    assert rows[0]["refused"] is None and rows[0]["e_n"] > 0
    assert rows[1] == {**dict.fromkeys(rows[0]), "angle_deg": 30, "refused": "too steep"}


def test_values_that_do_not_fit_together_do_not_stop_a_sweep() -> None:
    """Both angles of one of four combinations are too large together; where none fit, there is no table."""
    both = content(angle_deg=10)
    both["liquid"] |= {"contact_angle_deg": [15, 90], "half_filling_angle_deg": [55, 85]}
    rows = sweep.table(both)
    assert rows["refused"].notna().tolist() == [False, False, False, True] and "at most 170" in rows["refused"].iloc[3]
    assert rows["e_n"].notna().tolist() == [True, True, True, False]
    both["liquid"] |= {"contact_angle_deg": [89, 90], "half_filling_angle_deg": 85}
    with raises_code("config.inconsistent"):
        sweep.table(both)


def test_variant_as_printed_is_all_printed_readings() -> None:
    case = problem("glass_1.74mm", ("water", 400), variant="as_printed")
    assert case.chosen() == VARIANTS["as_printed"]
    assert case.chosen().bridge_volume == "follows"
    mixed = problem("glass_1.74mm", ("water", 400), variant="as_printed", readings={"gap": "mended"})
    assert mixed.chosen() == VARIANTS["as_printed"].model_copy(update={"gap": "mended"})
    assert problem("glass_1.74mm").chosen() == VARIANTS["mended"]


def test_two_spheres_by_reduced_mass_and_radius() -> None:
    """A partner as heavy as the sphere: dry restitution is the input; a very large partner is a wall."""
    dry = content(liquid=None, gravity_m_per_s2=0.0, wall=None, angle_deg=30.0)
    equal = {"radius_m": 0.87e-3, "density_kg_per_m3": 2500, **buck_tables.GLASS_WALL}
    del dry["wall"]
    assert wall.collide(parse(Problem, {**dry, "partner": equal}, "x"))["e_n"] == pytest.approx(0.96, abs=1e-6)
    with raises_code("config.inconsistent", says="no gravity_m_per_s2 with partner"):
        parse(Problem, {**dry, "partner": equal, "gravity_m_per_s2": 9.81}, "x")
    huge = {**equal, "radius_m": 1.0}
    at_sphere = wall.collide(parse(Problem, {**content(gravity_m_per_s2=0.0), "partner": huge, "wall": None}, "x"))
    at_wall = wall.collide(parse(Problem, content(gravity_m_per_s2=0.0), "x"))
    assert at_sphere["e_n"] == pytest.approx(at_wall["e_n"], abs=1e-2 * 0.87)  # R* differs from R by 0.09 %


def test_spin_of_the_striker_alone() -> None:
    """Equal spheres share the torque's impulse: the striker's spin changes by half of the pair's, total spin by F t R/I each."""
    equal = {"radius_m": 0.87e-3, "density_kg_per_m3": 2500, **buck_tables.GLASS_WALL}
    case = content(liquid=None, wall=None, partner=equal, angle_deg=60.0)
    got = wall.collide(parse(Problem, case, "x"))
    mass = 4 / 3 * np.pi * 2500 * 0.87e-3**3
    impulse = 0.5 * mass * (got["v_t_out"] - np.tan(np.pi / 3))
    assert got["omega_out"] == pytest.approx(impulse * 0.87e-3 / (0.4 * mass * 0.87e-3**2), rel=1e-9)


def test_tables_of_the_paper() -> None:
    """Counts and a few entries of tables 1 to 5, and the message for a pair without a half-filling angle."""
    assert {k: v["radius_m"] for k, v in buck_tables.PARTICLES.items()} == pytest.approx(
        {"glass_0.91mm": 0.455e-3, "glass_1.74mm": 0.87e-3, "alumina_1.74mm": 0.87e-3}
    )
    assert [round(1e3 * x["viscosity_Pa_s"], 6) for x in buck_tables.LIQUIDS.values()] == [1.0, 1.0, 3.0, 6.7]
    assert [len(x) for x in buck_tables.HALF_FILLING_DEG.values()] == [6, 2, 8]
    assert buck_tables.HALF_FILLING_DEG["alumina_1.74mm"]["glycerol50", 200] == 43
    assert buck_tables.FRICTION == {"dry": 0.195, "tween20": 0.160, "glycerol35": 0.140}
    assert [x[50][0] for x in buck_tables.SPINS.values()] == [-2171, -1777, -2035, -2181]
    with pytest.raises(PywetError, match=r"table 5 has no half-filling angle for glass_0\.91mm on 400 µm of water"):
        buck_tables.layer("glass_0.91mm", "water", 400)
