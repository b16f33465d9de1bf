"""Newton's law closes for every sphere of real runs, and a fault injected in the reference's inputs or walls opens it.

Tolerance of force and torque: 1e-9 of the forces' sizes (at least the weight). What rounding allows: springs of 2e3 N/m on places
known to 1e-17 m give 2e-14 N, against weights of 1e-3 N; walls whose steps are added up lose another two digits.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from pywet.cases.small import small
from pywet.cases.small.bodies import water
from pywet.engines.liggghts import deck
from reference_impl.diagnosis import diagnosis, motion
from reference_impl.motion import mesh, newton, pushes, wall_motion, window
from reference_impl.motion.touching import near_pairs
from reference_impl.replay.replay import replay
from tests.reference_impl import newton_scenes as scenes

pytestmark = pytest.mark.engine
FORCE = 1e-9


def assert_closed(folder: Path, contacts: int = 1) -> None:
    """Everything within its limit, force and torque within the one stated here."""
    quantities, found = scenes.closed(folder)
    assert {n: q.largest for n, q in quantities.items() if not q.ok} == {}
    assert max(quantities["newton_force"].largest, quantities["newton_torque"].largest) <= FORCE
    assert sum(len(f.touches) for f in found) >= contacts


@pytest.mark.parametrize(
    ("velocity", "spin", "offset"),
    [
        ((-0.2, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0),
        ((-0.2, 0.05, 0.02), (0.0, 0.0, 0.0), 1e-3),
        ((-0.2, 0.1, -0.1), (150.0, -80.0, 200.0), 5e-4),
    ],
    ids=["normal", "oblique", "with spin"],
)
def test_two_spheres(
    tmp_path: Path, velocity: tuple[float, float, float], spin: tuple[float, float, float], offset: float
) -> None:
    """One collision, 300 steps: some 60 to 100 in contact."""
    assert_closed(scenes.pair(tmp_path, velocity, spin, offset), contacts=30)


WALLS = {
    "floor": lambda: small.floor(),
    "vibrating floor": lambda: scenes.moving(small.floor(), "vibrates"),
    "drawn floor": lambda: scenes.moving(small.floor(), "slides"),
    "turning block": lambda: scenes.moving(scenes.block(), "turns"),
    "sharp block": scenes.block,
    "crossing wires": scenes.wires,
}


@pytest.mark.parametrize("name", WALLS)
def test_walls(tmp_path: Path, name: str) -> None:
    """Eight spheres thrown onto one wall, spinning: faces, edges and corners of triangles, at rest and moving."""
    spheres = scenes.thrown(8, 0.0038, wide=4.6e-3, down=0.3)
    assert_closed(scenes.on_walls(tmp_path, WALLS[name](), spheres), contacts=100)


def test_driven_sphere_is_left_out(tmp_path: Path) -> None:
    """A sphere held at its speed obeys no law; the free one that it pushes does."""
    spheres = [
        small.Sphere(1, (0.0, 0.0, 0.0), (0.1, 0.0, 0.0), driven=True),
        small.Sphere(1, (5.05e-3, 2e-4, 0.0)),
    ]
    small.prepare(
        tmp_path,
        scenes.spheres_of(scenes.R),
        spheres,
        scenes.contacts(1),
        time_step_s=1e-5,
        steps=200,
        window_trajectories=True,
    )
    small.run(tmp_path, spheres)
    quantities, found = scenes.closed(tmp_path)
    assert quantities["newton_force"].ok and quantities["newton_force"].count == 200
    assert len(found[0].touches) > 20
    assert list(window.read(tmp_path).free) == [False, True]


@pytest.fixture(scope="module")
def moist(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The moist bed."""
    return scenes.moist_bed(tmp_path_factory.mktemp("moist"))


@pytest.fixture(scope="module")
def dry(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Dry spheres on a shaken floor."""
    spheres = scenes.thrown(12, 0.003, down=0.2)
    folder = tmp_path_factory.mktemp("dry")
    return scenes.on_walls(folder, scenes.moving(small.floor(), "vibrates"), spheres, steps=900)


def test_moist_bed(moist: Path) -> None:
    """Weight, dry contacts and bridges together; closest points and motion of the walls are the reference's own."""
    assert_closed(moist, contacts=400)
    result = replay(moist)
    assert result["ok"], {n: q["largest"] for n, q in result["quantities"].items() if not q["ok"]}
    for name in ("newton_force", "newton_torque", "wall_closest_point", "wall_velocity", "transfer_interpolation"):
        assert result["quantities"][name]["count"] > 0
    assert result["newton"]["windows"] == [[163, 237], [563, 637], [963, 1037], [1363, 1437]]


@pytest.fixture(scope="module")
def semi_implicit(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The moist bed with semi-implicit drag."""
    return scenes.moist_bed(tmp_path_factory.mktemp("implicit"), viscous_integration="semi_implicit")


def test_semi_implicit_drag(semi_implicit: Path) -> None:
    """The drag that acts is the weakened one; the law closes with it, and it starts from what all other forces change."""
    assert_closed(semi_implicit, contacts=400)
    quantities = replay(semi_implicit)["quantities"]
    assert all(quantities[name]["ok"] and quantities[name]["count"] > 400 for name in pushes.SCALES)


@pytest.mark.parametrize(
    ("name", "wrong", "message"),
    [
        ("window_push", lambda expected, second: 1.01 * expected, "it is 1.01 times what it should be"),
        ("window_push", lambda expected, second: expected - second, "that of the second sphere is left out"),
        (
            "window_spin_push",
            lambda expected, second: expected - 2 * second,
            "that of the second sphere has the other sign",
        ),
        ("window_sharing", lambda expected, second: expected - second, "that of the second sphere is left out"),
    ],
)
def test_a_wrong_start_of_semi_implicit_drag_is_found_and_named(
    semi_implicit: Path, name: str, wrong: Callable[[Any, Any], Any], message: str
) -> None:
    """As an engine would log it that starts its drag from something else."""
    _, found = scenes.closed(semi_implicit)
    injected = []
    for f in found:
        _, expected, size, rows, second = f.checks[name]
        injected.append(replace(f, checks={**f.checks, name: (wrong(expected, second), expected, size, rows, second)}))
    setup = window.read(semi_implicit)
    failed = [q.name for q in newton.check(setup, injected) if not q.ok]
    assert failed == [name]
    sentences = [f["sentence"] for f in diagnosis.diagnose(motion.links(setup, injected, failed), failed)["findings"]]
    assert any(message in sentence and motion.PUSHES[name] in sentence for sentence in sentences), sentences


def test_dry_replay(dry: Path) -> None:
    """A dry run is replayed too; its table holds Newton's law."""
    result = replay(dry)
    assert result["ok"] and result["quantities"]["newton_force"]["count"] == 12 * 900
    assert json.loads((dry / "replay.json").read_text())["newton"]["dry_contacts"] > 300


def test_recording_changes_nothing(tmp_path: Path) -> None:
    """With and without the recording the trajectory is the same, bit for bit; without, the deck holds no trace of it."""
    ends = {}
    for name in (True, False):
        folder = tmp_path / str(name)
        spheres = scenes.thrown(8, 0.003)
        small.prepare(
            folder, scenes.spheres_of(scenes.R, 2e-3), spheres, scenes.contacts(2),
            walls=[scenes.wires(), small.floor(top=-2e-3)], time_step_s=1e-5, steps=800, gravity=scenes.DOWN,
            window_trajectories=name, output_interval_s=1e-3,
        )  # fmt: skip
        small.run(folder, spheres)
        ends[name] = pd.read_parquet(folder / "trajectory.parquet")
    pd.testing.assert_frame_equal(ends[True], ends[False], check_exact=True)
    assert "window" not in (tmp_path / "False" / "engine" / "setup.liggghts").read_text()


# ---- faults ---------------------------------------------------------------------------------------------------------------


def _pairs(key: str, change: Callable[[float], float]) -> Callable[[dict[str, Any]], None]:
    def fault(scene: dict[str, Any]) -> None:
        for row in scene["pairs"]:
            row[key] = change(row[key])

    return fault


def _tilt(scene: dict[str, Any]) -> None:
    scene["gravity_m_per_s2"] = [0.01 * 9.81, 0.0, -9.81]


def _heavier(scene: dict[str, Any]) -> None:
    scene["classes"][0]["density_kg_per_m3"] *= 1.001


def _late(scene: dict[str, Any]) -> None:
    scene["vibration"]["phase_rad"] = [p - 0.01 for p in scene["vibration"]["phase_rad"]]


FAULTS = {
    "stiffness 1 % off": _pairs("normal_stiffness_N_per_m", lambda k: 1.01 * k),
    "tangential stiffness 1 % off": _pairs("tangential_stiffness_N_per_m", lambda k: 1.01 * k),
    "friction off": _pairs("friction", lambda _: 0.0),
    "damping off": _pairs("restitution", lambda _: 1.0),
    "rolling off": _pairs("rolling_friction_m", lambda _: 0.0),
    "gravity tilted": _tilt,
    "mass 0.1 % off": _heavier,
    "wall 0.01 rad late": _late,
}
SEEN_IN = dict.fromkeys(FAULTS, "newton_force") | {"rolling off": "newton_torque"}
NAMED_DRY = {
    "stiffness 1 % off": "the normal stiffness of the dry contacts (with the dashpot that follows from it) is 0.990099 times",
    "tangential stiffness 1 % off": "the tangential stiffness of the dry contacts is 0.990099 times",
    "friction off": "the friction of the dry contacts is 0.3 where there should be none",
    "damping off": "the restitution of the dry contacts is 0.7 times",
    "rolling off": "the rolling friction is 5e-05 where there should be none",
    "gravity tilted": "an acceleration of (-0.0981, ",
    "wall 0.01 rad late": "place of a wall in mesh_motion: it is about 3.18 steps early",
}
"""How they are named in a dry run; in a collision the wrong mass of one class is no factor on a force."""


@pytest.mark.parametrize("kind", ["dry", "moist"])
@pytest.mark.parametrize("name", FAULTS)
def test_faults_are_found(tmp_path: Path, request: pytest.FixtureRequest, name: str, kind: str) -> None:
    """The reference gets another value than the engine: far beyond the limit, and in the dry run named."""
    folder = tmp_path / "run"
    shutil.copytree(request.getfixturevalue(kind), folder)
    scene = json.loads((folder / "scene.json").read_text())
    FAULTS[name](scene)
    (folder / "scene.json").write_text(json.dumps(scene))
    if kind == "moist":  # as in a replay, without its other checks
        quantities, _ = scenes.closed(folder)
        assert not quantities[SEEN_IN[name]].ok
        assert quantities[SEEN_IN[name]].largest > 1e3 * FORCE
        return
    result = replay(folder)
    assert not result["quantities"][SEEN_IN[name]]["ok"]
    assert result["quantities"][SEEN_IN[name]]["largest"] > 1e3 * FORCE
    sentences = [s for f in result["diagnosis"]["findings"] for s in (f["known"], f["sentence"], *f["consequences"])]
    assert any(NAMED_DRY.get(name, "dry contacts") in sentence for sentence in sentences), sentences


NAMED = {
    "tangential stiffness 1 % off": (
        _pairs("tangential_stiffness_N_per_m", lambda k: 1.01 * k),
        "the friction of the dry contacts is 0.990099",
    ),
    "rolling twice": (_pairs("rolling_friction_m", lambda m: 2.0 * m), "the rolling resistance: half of it counts"),
    "gravity tilted": (_tilt, "an acceleration of (-0.0981, "),
    "mass 0.1 % off": (_heavier, "as if the mass were 0.999"),
}
"""Fault in a value passed to the reference, and the words by which the replay names it."""


@pytest.mark.parametrize("name", NAMED)
def test_faults_are_named(tmp_path: Path, moist: Path, name: str) -> None:
    """The log holds, the motion does not: the first finding is the injected fault."""
    folder, (fault, words) = tmp_path / "run", NAMED[name]
    shutil.copytree(moist, folder)
    scene = json.loads((folder / "scene.json").read_text())
    fault(scene)
    (folder / "scene.json").write_text(json.dumps(scene))
    result = replay(folder)
    assert not result["ok"]
    assert words in result["diagnosis"]["findings"][0]["sentence"], result["diagnosis"]


def test_still_walls_are_found(dry: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A reference that forgets the walls' velocity does not close; one that forgets their place does not either."""
    monkeypatch.setattr(wall_motion.Motion, "velocity", lambda self, wall, step, points: np.zeros_like(points))
    quantities, _ = scenes.closed(dry)
    assert not quantities["newton_force"].ok
    monkeypatch.undo()
    monkeypatch.setattr(wall_motion.Motion, "shift", lambda self, wall, step: np.zeros(3))
    quantities, _ = scenes.closed(dry)
    assert not quantities["newton_force"].ok


def test_wrong_closest_point_is_found(tmp_path: Path, moist: Path) -> None:
    """A closest point on a wall logged a thousandth of a radius aside."""
    folder = tmp_path / "run"
    shutil.copytree(moist, folder)
    path = folder / "history" / "contacts.parquet"
    table = pd.read_parquet(path)
    table.loc[table.index[table["partner_kind"] > 0][5], "xj_x"] += 1e-3 * scenes.R
    table.to_parquet(path)
    quantities, _ = scenes.closed(folder)
    assert [n for n, q in quantities.items() if not q.ok] == ["wall_closest_point"]
    assert quantities["wall_closest_point"].largest == pytest.approx(1e-3, rel=0.3)  # the deviation is one of two radii


# ---- the pieces -----------------------------------------------------------------------------------------------------------


def test_each_edge_and_corner_of_a_block_has_one_owner() -> None:
    """Twelve edges and eight corners of a box are active once; the diagonals of its faces never."""
    box = mesh.topology(scenes.block().corners)
    assert box.edge_active.sum() == 12
    assert box.corner_active.sum() == 8


def test_near_pairs_are_all_found() -> None:
    """Against all pairs one by one."""
    random = np.random.default_rng(1)
    x, reach = random.uniform(0, 1, (300, 3)), random.uniform(0.02, 0.06, 300)
    apart = np.linalg.norm(x[:, None] - x[None], axis=2)
    a, b = np.nonzero(np.triu(apart < reach[:, None] + reach[None], 1))
    assert set(zip(*near_pairs(x, reach), strict=True)) == set(zip(a, b, strict=True))


def rubbing(folder: Path, spin: float, aside: float, **settings: Any) -> tuple[dict[str, Any], dict[str, int], int]:
    """A sphere that turns at a wiggled place and touches another three times in a list; what closes, counts, meetings."""
    spheres = [
        small.Sphere(1, (0.0, 0.0, 0.0), driven=True),
        small.Sphere(
            1, (2 * scenes.R, 0.0, 0.0), spin=(0.0, 0.0, spin), driven=True, wiggle=((2e-5, 0.0, aside), 1e-3)
        ),
    ]
    small.prepare(
        folder, scenes.spheres_of(scenes.R), spheres, scenes.contacts(1), time_step_s=1e-5, steps=320,
        window_trajectories=True, **settings,
    )  # fmt: skip
    small.run(folder, spheres)
    quantities, found = scenes.closed(folder)
    return quantities, found[0].counts, int((np.diff(np.unique(found[0].touches.k)) > 1).sum())


@pytest.mark.parametrize("spin", [50.0, 2000.0])
@pytest.mark.parametrize("way", ["dry", "moist"])
def test_springs_begin_anew(tmp_path: Path, way: str, spin: float) -> None:
    """Spheres that separate and meet again before the neighbour list is rebuilt begin without a spring; those of 2000/s slide."""
    moist = {"liquid": water(1e-5), "effects": small.PAPER} if way == "moist" else {}
    quantities, _, meetings = rubbing(tmp_path, spin, 1e-8, **moist)
    assert meetings == 2
    assert quantities["contact_spring"].ok


def test_a_retained_spring_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The engine alone retains the spring of a separated pair that it still lists, and the next contact begins with it."""
    monkeypatch.setattr(deck, "contact_distance_factor", lambda scene: 1.0)
    quantities, _, meetings = rubbing(tmp_path, 50.0, 0.0)
    assert meetings == 2
    assert not quantities["contact_spring"].ok


def test_ranks(tmp_path: Path) -> None:
    """A pair that lies on both sides of a border between two ranks is recorded once and closes."""
    spheres = scenes.thrown(8, 0.0028, wide=5.05e-3, down=0.2)
    small.prepare(
        tmp_path, scenes.spheres_of(scenes.R, 2e-3), spheres, scenes.contacts(2), walls=[small.floor()], time_step_s=1e-5,
        steps=500, gravity=scenes.DOWN, window_trajectories=True, output_interval_s=1e-3,
    )  # fmt: skip
    small.run(tmp_path, spheres, ranks=2)
    assert_closed(tmp_path, contacts=100)


@pytest.mark.parametrize("spin", [1e-17, 3e-16, 1e-12, 1e-3])
def test_a_sphere_that_hardly_turns_has_no_rolling_direction(tmp_path: Path, spin: float) -> None:
    """The whole rolling resistance acts along a spin that is lost in the rounding of the step's kick (1e-3 rad/s)."""
    falling = small.Sphere(1, (0.0, 0.0, scenes.R + 1e-7), (0.0, 0.0, -0.05), (spin, 0.0, 0.0))
    folder = scenes.on_walls(tmp_path, small.floor(), [falling], steps=60)
    assert_closed(folder, contacts=30)
    reported = scenes.closed(folder)[1][0].counts["no_rolling_direction"]
    assert (reported > 0) == (spin < 1e-6), reported
