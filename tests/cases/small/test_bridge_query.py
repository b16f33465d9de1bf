"""`pywet bridge`: what goes in, what comes out, against the laws and the exact bridge; the same measured inside the engine."""

from __future__ import annotations

import copy
import json
import math
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from pywet.cases.small import bridge_engine
from pywet.cases.small.bridge_query import EXACT, answer, checked, read
from pywet.cli.app import app
from pywet.errors import PywetError
from pywet.laws import exact_bridge as young_laplace
from pywet.laws import registry
from pywet.schema import LARGE_WALL, SPHERE

EXAMPLES = Path(__file__).parents[3] / "examples"
SIGMA, ETA, SPEED, VOLUME = 0.0728, 1e-3, 0.01, 1e-10
SPHERES: dict[str, Any] = json.loads((EXAMPLES / "bridge.json").read_text())
WALL: dict[str, Any] = json.loads((EXAMPLES / "bridge_wall.json").read_text())
SMALLEST: dict[str, Any] = {
    "bodies": [{"radius_m": 1e-3, "contact_angle_deg": 10}, {"radius_m": 2e-3, "contact_angle_deg": 30}],
    "volume_m3": 1e-12,
    "surface_tension_N_per_m": SIGMA,
    "separations_m": [0.0, 5e-5],
}


@pytest.fixture
def runner() -> CliRunner:
    return CliRunner(env={"COLUMNS": "200", "NO_COLOR": "1"})


def ask(folder: Path, query: Any) -> dict[str, Any]:
    file = folder / "query.json"
    file.write_text(query if isinstance(query, str) else json.dumps(query))
    return answer(read(file))


def function(kind: str, name: str) -> Any:
    return registry.get(kind, name).functions[0]


def test_command_answers_in_json(runner: CliRunner) -> None:
    shown = runner.invoke(app, ["bridge", str(EXAMPLES / "bridge.json")])
    assert shown.exit_code == 0, shown.output
    found = json.loads(shown.stdout)
    assert found == json.loads(json.dumps(answer(read(EXAMPLES / "bridge.json"))))
    assert {"force_N", "viscous_normal_N", "rupture_distance_m", "transfer_ratio", "half_filling_angle_deg"} <= set(
        found
    )


@pytest.mark.parametrize("query", [SPHERES, WALL], ids=["spheres", "wall"])
def test_values_are_those_of_the_laws_and_null_beyond_rupture(query: dict[str, Any], tmp_path: Path) -> None:
    found = ask(tmp_path, query)
    wall = "wall" in query["bodies"][1]
    ri = query["bodies"][0]["radius_m"]
    rj = math.inf if wall else query["bodies"][1]["radius_m"]
    ti, tj = (math.radians(b["contact_angle_deg"]) for b in query["bodies"])
    rule = "willett_unequal"  # `willett` is a force too, so that naming it does not choose the rupture law
    limit = function("rupture", rule)(VOLUME, ri, rj, ti, tj)
    exact_limit = young_laplace.rupture(VOLUME, ri, rj, ti, tj)
    assert found["rupture_distance_m"][rule] == pytest.approx(limit, rel=1e-12)
    assert found["rupture_distance_m"]["young_laplace"] == pytest.approx(exact_limit.separation, rel=1e-12)
    assert found["rupture_kind"] == exact_limit.kind == "fold"
    nulls = 0
    for k, gap in enumerate(query["separations_m"]):
        bridge = young_laplace.solve(gap, VOLUME, ri, rj, ti, tj)
        for name, values in found["force_N"].items():
            if name == "young_laplace":
                want = bridge.force(SIGMA) if bridge else None
            else:
                want = function("capillary", name)(gap, VOLUME, ri, rj, ti, tj, SIGMA) if gap <= limit else None
            assert values[k] == (want if want is None else pytest.approx(want, rel=1e-12))
            nulls += want is None
        for name, values in found["viscous_normal_N"].items():
            # the force on separating bodies is attractive: positive here, negative along n in the law
            want = -function("viscous_normal", name)(gap, VOLUME, ri, rj, SPEED, ETA) if gap <= limit else None
            assert values[k] == (want if want is None else pytest.approx(want, rel=1e-12))
            assert want is None or want > 0.0
        for name, place in (("body_1", 0), ("body_2", 1)):
            given = found["half_filling_angle_deg"][name]
            if wall and name == "body_2":
                assert given is None
            elif bridge:
                assert given[k] == pytest.approx(math.degrees(bridge.half_filling_angles[place]), rel=1e-12)
            else:
                assert given[k] is None
    assert nulls == len(found["force_N"])  # one separation of each example lies beyond rupture
    factor = function("dynamic_rupture", "pitois")(SPEED, ETA, SIGMA)
    assert found["dynamic_rupture_factor"] == pytest.approx(factor, rel=1e-12)


@pytest.mark.parametrize("wall", [False, True])
def test_transfer_ratio_of_body_1(wall: bool, tmp_path: Path) -> None:
    query = copy.deepcopy(SMALLEST)
    ri, rj, ti, tj = 1e-3, 2e-3, math.radians(10), math.radians(30)
    if wall:
        query["bodies"][1] = {"wall": "large", "contact_angle_deg": 30}
        rj = math.inf
    found = ask(tmp_path, query)["transfer_ratio"]
    exact = young_laplace.rupture(1e-12, ri, rj, ti, tj).transfer_ratio
    assert found["young_laplace"] == pytest.approx(exact, rel=1e-9)
    reduced = 1e-12 / (ri if wall else 2 * ri * rj / (ri + rj)) ** 3
    table = registry.transfer_model("parabola")
    value = table(ri, ri if wall else rj, ti, tj, LARGE_WALL if wall else SPHERE, [reduced])[0]
    assert found["parabola"] == pytest.approx(value, rel=1e-9)


def test_without_laws_all_of_them_answer_and_what_is_left_out_is_zero(tmp_path: Path) -> None:
    found = ask(tmp_path, SMALLEST)
    assert set(found["force_N"]) == set(registry.BUILT_IN["capillary"])
    assert set(found["viscous_normal_N"]) == set(registry.BUILT_IN["viscous_normal"])
    assert set(found["rupture_distance_m"]) == set(registry.BUILT_IN["rupture"])
    assert all(v == 0.0 for values in found["viscous_normal_N"].values() for v in values)
    assert found["dynamic_rupture_factor"] == 1.0


def test_kinds_without_a_named_law_take_the_papers(tmp_path: Path) -> None:
    found = ask(tmp_path, {**SMALLEST, "laws": ["lambert"]})
    assert list(found["force_N"]) == ["lambert"]
    assert list(found["viscous_normal_N"]) == ["pitois"]
    assert list(found["rupture_distance_m"]) == ["willett_unequal", "young_laplace"]


def test_a_rupture_law_that_is_named_ends_the_closed_forms(tmp_path: Path) -> None:
    """`lian` is a rupture law among others; `young_laplace` is a force too, and ends only its own force."""
    found = ask(tmp_path, {**SMALLEST, "laws": ["rabinovich", "young_laplace", "lian"]})
    distances, used = found["rupture_distance_m"], found["rupture_used_m"]
    assert used["rabinovich"] == used["pitois"] == distances["lian"]
    assert used["young_laplace"] == distances["young_laplace"] != distances["lian"]
    found = ask(tmp_path, {**SMALLEST, "laws": ["rabinovich", "young_laplace"]})
    assert found["rupture_used_m"]["rabinovich"] == found["rupture_distance_m"]["willett_unequal"]


@pytest.mark.parametrize(("velocity", "tables"), [(0.0, 2), (SPEED, 3)])
def test_viscous_forces_are_printed_of_a_bridge_that_moves(
    velocity: float, tables: int, tmp_path: Path, runner: CliRunner
) -> None:
    """Forces and rupture distances always; a table of zeros says nothing."""
    file = tmp_path / "query.json"
    file.write_text(json.dumps({**SMALLEST, "viscosity_Pa_s": ETA, "velocity_m_per_s": velocity, "laws": ["willett"]}))
    done = runner.invoke(app, ["bridge", str(file), "--table"])
    assert done.exit_code == 0, done.output
    assert sum(" law " in line or line.startswith(" law") for line in done.output.splitlines()) == tables, done.output


def test_overlap_counts_as_touching(tmp_path: Path) -> None:
    found = ask(tmp_path, {**SMALLEST, "separations_m": [-1e-6, 0.0], "laws": ["rabinovich", "young_laplace"]})
    for overlapping, touching in found["force_N"].values():
        assert overlapping == touching


def changed(**keys: Any) -> dict[str, Any]:
    return {**copy.deepcopy(SMALLEST), **keys}


def with_body(number: int, body: dict[str, Any]) -> dict[str, Any]:
    query = copy.deepcopy(SMALLEST)
    query["bodies"][number] = body
    return query


A_WALL = {"wall": "large", "contact_angle_deg": 30}


@pytest.mark.parametrize(
    ("query", "words"),
    [
        ({k: v for k, v in SMALLEST.items() if k != "volume_m3"}, ["volume_m3", "missing"]),
        (with_body(0, {"radius_m": -1e-3, "contact_angle_deg": 10}), ["radius_m", "-0.001", "greater than"]),
        (with_body(1, {"radius_m": 1e-3, "contact_angle_deg": 90}), ["contact_angle_deg", "90", "less than 90"]),
        (with_body(1, {"radius_m": 1e-3, **A_WALL}), ['either "radius_m" or "wall"']),
        (with_body(0, A_WALL), ["the first body is a wall", "expected the sphere first"]),
        (changed(bodies=[A_WALL, A_WALL]), ["the first body is a wall"]),
        (changed(bodies=[SMALLEST["bodies"][0]]), ["bodies", "2"]),
        (changed(volume_m3=0.0), ["volume_m3", "greater than"]),
        (changed(separations_m=[]), ["separations_m", "1"]),
        (changed(laws=["rabinowitsch"]), ["no law named rabinowitsch", "rabinovich", "fix laws"]),
        (changed(viscosity_mPas=1.0), ["viscosity_mPas", "not known", "viscosity_Pa_s"]),
        ("{bodies: 2}", ["is not the JSON", "line 1", "docs/bridge.md"]),
        ("[]", ["content"]),
    ],
)
def test_a_mistake_is_refused_in_one_sentence(query: Any, words: list[str], tmp_path: Path, runner: CliRunner) -> None:
    with pytest.raises(PywetError) as caught:
        ask(tmp_path, query)
    sentence = str(caught.value)
    assert "query.json" in sentence and "\n" not in sentence
    for word in words:
        assert word in sentence


def test_the_command_shows_the_sentence_and_exits_1(tmp_path: Path, runner: CliRunner) -> None:
    missing = runner.invoke(app, ["bridge", str(tmp_path / "none.json")])
    (tmp_path / "query.json").write_text(json.dumps(SMALLEST))
    engine = runner.invoke(app, ["bridge", str(tmp_path / "query.json"), "--engine", "yade"])
    for shown, word in ((missing, "could not be read"), (engine, "there is no engine yade; expected liggghts")):
        assert shown.exit_code == 1
        assert word in shown.stderr and "Traceback" not in shown.stderr


@pytest.mark.engine
def test_engine_gives_what_python_gives(runner: CliRunner) -> None:
    """A cubic spline through the log of 4000 steps: 1e-6 is its error; `young_laplace` is a table in the engine."""
    file = EXAMPLES / "bridge_wall.json"
    shown = runner.invoke(app, ["bridge", str(file), "--engine", "liggghts"])
    assert shown.exit_code == 0, shown.output
    measured, python = json.loads(shown.stdout), answer(read(file))
    assert measured["measured_in"] == "liggghts"
    assert measured["volume_m3"] == pytest.approx(VOLUME, rel=1e-9)
    for name, tolerance in (("rabinovich", 1e-6), ("young_laplace", 1e-3)):
        assert measured["force_N"][name][-1] is None
        assert measured["force_N"][name][:-1] == pytest.approx(python["force_N"][name][:-1], rel=tolerance)
    for name in ("pitois", "adams_perchard"):
        assert measured["viscous_normal_N"][name][:-1] == pytest.approx(python["viscous_normal_N"][name][:-1], rel=1e-5)
    for name, distance in measured["rupture_distance_m"].items():
        # detected at the first step beyond the distance
        step = 1.1 * max(*WALL["separations_m"], python["rupture_distance_m"][name]) / 4000
        assert 0.0 <= distance - python["rupture_distance_m"][name] < step


@pytest.mark.engine
@pytest.mark.parametrize("rupture", ["willett_unequal", "young_laplace"])
def test_engine_breaks_and_shares_as_the_laws_say(rupture: str) -> None:
    """Unequal spheres and angles: the transferred share is the model's; drawn apart fast, Pitois' factor stretches."""
    capillary, transfer = {"willett_unequal": ("rabinovich", "parabola"), EXACT: (EXACT, EXACT)}[rupture]
    bodies = [{"radius_m": r, "contact_angle_deg": a} for r, a in ((1e-3, 30.0), (2e-3, 10.0))]
    asked = {"bodies": bodies, "volume_m3": 1e-11, "surface_tension_N_per_m": 0.0728, "viscosity_Pa_s": 0.1,
             "velocity_m_per_s": 0.01, "separations_m": [1e-5], "laws": [capillary, rupture]}  # fmt: skip
    query = checked(asked, Path("q.json"))
    python = answer(query)
    still, fast = (bridge_engine.measured(query, stretch=stretch) for stretch in (None, "pitois"))
    assert list(still["transfer_ratio"]) == [transfer]
    assert still["transfer_ratio"][transfer] == pytest.approx(python["transfer_ratio"][transfer], rel=1e-3)
    for one, end in ((still, 1.0), (fast, 1.0 + math.sqrt(0.1 * 0.01 / 0.0728))):
        assert 0.0 <= one["rupture_distance_m"][rupture] / (end * python["rupture_distance_m"][rupture]) - 1.0 < 3e-4


@pytest.mark.engine
@pytest.mark.parametrize("laws", [[EXACT, "rabinovich"], [EXACT]])
def test_viscous_forces_in_the_engine_end_by_the_rule_of_the_query(laws: list[str]) -> None:
    """Whichever capillary law comes first: at a gap between the rupture distances of the exact bridge and of the rule, too."""
    query = checked({**SPHERES, "laws": [*laws, "pitois"], "separations_m": [1e-4, 5.5e-4, 6e-4]}, Path("q.json"))
    python, measured = answer(query), bridge_engine.measured(query)
    assert python["rupture_distance_m"][EXACT] < 5.5e-4 < python["rupture_used_m"]["pitois"] < 6e-4
    assert list(measured["force_N"]) == laws
    wanted, found = (of["viscous_normal_N"]["pitois"] for of in (python, measured))
    assert found[2] is wanted[2] is None and found[:2] == pytest.approx(wanted[:2], rel=1e-5)
