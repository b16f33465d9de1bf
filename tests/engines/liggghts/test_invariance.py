"""What must not change the physics: a moving frame, a turned frame; and what a thousand cycles must not use up."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet.cases.small import small
from pywet.geometry.screen import build_wires, wire_positions
from pywet.geometry.solids import plate
from pywet.geometry.surface import Surface, make_surface
from reference_impl.replay.replay import replay
from tests.engines.liggghts import beds
from tests.engines.liggghts.scenes import WATER, contacts, spheres_of

pytestmark = pytest.mark.engine
R = 2.5e-3
STEPS = 2000
DRIFT = (0.3, -0.2, 0.1)
TURN = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
TURN = TURN * np.sign(np.linalg.det(TURN))


def cluster(run_dir: Path, drift: tuple[float, ...] = (0, 0, 0), turn: np.ndarray | None = None) -> pd.DataFrame:
    """Nine wet spheres of two sizes thrown at each other; x, v, w per sphere at the end, and the events."""
    random = np.random.default_rng(5)
    axes = np.eye(3) if turn is None else turn
    bodies = []
    for n, cell in enumerate(np.ndindex(3, 3, 1)):
        at = (np.array(cell) - [1, 1, 0]) * 2.02 * R + random.uniform(-0.05, 0.05, 3) * R
        velocity = -8.0 * at + random.normal(0.0, 0.02, 3)
        spin = random.normal(0.0, 20.0, 3)
        bodies.append(small.Sphere(1 + n % 2, tuple(axes @ at), tuple(axes @ velocity + drift), tuple(axes @ spin)))
    small.prepare(
        run_dir, spheres_of(R, 2e-3), bodies, contacts(2, stiffness=1e4), liquid=WATER, effects=small.PAPER,
        time_step_s=1e-5, steps=STEPS, log_every_step=False, output_interval_s=STEPS * 1e-5,
    )  # fmt: skip
    small.run(run_dir, bodies)
    return beds.table(run_dir, "trajectory").query("step == @STEPS").set_index("id")


@pytest.fixture(scope="module")
def at_rest(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, pd.DataFrame]:
    """The cluster in the frame at rest."""
    folder = tmp_path_factory.mktemp("rest")
    return folder, cluster(folder)


def test_moving_frame(at_rest: tuple[Path, pd.DataFrame], tmp_path: Path) -> None:
    """Simulate a cluster in a moving frame: same events, positions shifted by v t to round-off of 20 ms (1e-9 of a radius)."""
    folder, rest = at_rest
    moving = cluster(tmp_path, drift=DRIFT)
    one, two = (beds.table(path, "history/events") for path in (folder, tmp_path))
    pd.testing.assert_frame_equal(one[beds.LOOKS], two[beds.LOOKS])
    assert len(one) >= 10
    shift = np.array(DRIFT) * STEPS * 1e-5
    assert np.abs(moving[["x", "y", "z"]] - rest[["x", "y", "z"]] - shift).to_numpy().max() < 1e-9 * R


def test_turned_frame(at_rest: tuple[Path, pd.DataFrame], tmp_path: Path) -> None:
    """Simulate a cluster turned as a whole: positions, velocities and spins turn with it."""
    rest, turned = at_rest[1], cluster(tmp_path, turn=TURN)
    assert np.abs(turned[["x", "y", "z"]].to_numpy() - rest[["x", "y", "z"]].to_numpy() @ TURN.T).max() < 1e-9 * R
    for columns, size in ((["vx", "vy", "vz"], 0.1), (["wx", "wy", "wz"], 20.0)):
        assert np.abs(turned[columns].to_numpy() - rest[columns].to_numpy() @ TURN.T).max() < 1e-8 * size


@pytest.mark.parametrize("wall", [False, True], ids=["spheres", "floor"])
def test_a_thousand_cycles_lose_nothing(tmp_path: Path, wall: bool) -> None:
    """Formed, stretched, broken and formed again 1000 times: films, bridge and wall film drift by at most 1e-12 in all."""
    cycles, steps = 1000, 60
    step = 2e-5
    away = small.Sphere(1, (0.0, 0.0, 2 * R + 1.2e-3), driven=True, wiggle=((0.0, 0.0, 1.25e-3), steps * step))
    bodies = [small.Sphere(1, (0.0, 0.0, 0.0), driven=True), away]
    walls = []
    if wall:
        bodies = [small.Sphere(1, (0.0, 0.0, R + 1.6e-3), driven=True, wiggle=((0.0, 0.0, 1.65e-3), steps * step))]
        walls = [small.floor()]
    small.prepare(
        tmp_path, spheres_of(R), bodies, contacts(1), liquid=WATER, effects=small.PAPER, walls=walls,
        wall_angle_rad=math.radians(45.0), time_step_s=step, steps=cycles * steps, log_every_step=False,
        output_interval_s=100 * steps * step,
    )  # fmt: skip
    small.run(tmp_path, bodies)
    ledger = beds.table(tmp_path, "history/ledger")
    held = ledger["films"] + ledger["bridges"] + ledger["walls"]
    assert ledger["formations"].iloc[-1] >= cycles and ledger["ruptures"].iloc[-1] >= cycles - 1
    assert (held / ledger["initial"] - 1.0).abs().max() < 1e-12
    if not wall:  # equal bodies: each gets back the liquid that it gave
        films = beds.table(tmp_path, "history/films")
        first = films.query("step == 0")["film"].iloc[0] + 0.5 * ledger["bridges"].iloc[0]
        last = films[films["step"] == films["step"].max()]["film"] + 0.5 * ledger["bridges"].iloc[-1]
        assert (last / first - 1.0).abs().max() < 1e-12


def edge_plate() -> Surface:
    """A plate whose upper face lies at z = 0 and whose edge lies along y at x = 0."""
    outline = np.array([[-0.05, -0.05], [0.0, -0.05], [0.0, 0.05], [-0.05, 0.05]])
    return make_surface("floor", "wall", plate(outline, -0.01, 0.0))


def test_bridge_goes_over_an_edge_without_a_kick(tmp_path: Path) -> None:
    """A sphere driven across the diagonal of the face and over the edge of a plate keeps one bridge per flat part at most.

    While a bridge exists, force and closest point follow the way: from step to step the closest point moves no further than the
    sphere, and the capillary force changes by no more than its steepest slope allows. What a ruptured bridge gives back and a new
    one draws is in the ledger.
    """
    speed, step = 0.2, 2e-5
    bodies = [small.Sphere(1, (-8e-3, -4e-3, R + 5e-5), (speed, 0.5 * speed, 0.0), driven=True)]
    small.prepare(
        tmp_path, spheres_of(R), bodies, contacts(1), liquid=WATER, effects=small.PAPER, walls=[edge_plate()],
        wall_angle_rad=math.radians(45.0), time_step_s=step, steps=3000, output_interval_s=1e-3,
    )  # fmt: skip
    small.run(tmp_path, bodies)
    log = beds.table(tmp_path, "history/contacts")
    # one bridge at a convex edge: none with the second face while the wall end is at the edge
    assert log.groupby("step").size().max() == 1
    past = log[log["xi_x"] > 0.0]
    assert len(past) > 500 and past["xj_x"].abs().max() < 1e-12  # the wall end of the bridge stays at the edge
    way = speed * math.hypot(1.0, 0.5) * step
    for _, one in log.groupby("j"):
        one = one.sort_values("step")
        together = one["step"].diff().iloc[1:].to_numpy() == 1
        jump = np.linalg.norm(np.diff(one[["xj_x", "xj_y", "xj_z"]].to_numpy(), axis=0), axis=1)
        assert jump[together].max() < way * (1.0 + 1e-9)
        change = np.abs(np.diff(one["capillary"].to_numpy()))[together]
        opened = np.abs(np.diff(one["separation"].to_numpy()))[together]
        steepest = one["capillary"].max() / 2e-5  # the force halves in no less than 20 um
        assert (change <= steepest * opened + 1e-12).all()
    ledger = beds.table(tmp_path, "history/ledger")
    held = ledger["films"] + ledger["bridges"] + ledger["walls"]
    assert (held / ledger["initial"] - 1.0).abs().max() < 1e-12


def test_bridge_at_a_wire_crossing(tmp_path: Path) -> None:
    """A sphere driven along a wire over two crossings keeps the bridge with that wire, with its volume, from end to end.

    Each crossing wire is a part of its own: it gets a bridge of its own and loses it again, and the ledger closes.
    """
    outline = 0.013 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    wires = build_wires(8e-3, 2e-3, 8, 0.01, outline)
    surface = Surface(**{**wires.__dict__, "motion": "fixed"})
    lines = sorted({round(float(y), 6) for y in surface.corners[..., 1].ravel()})
    along = float(wire_positions(1e-2, 1e-3, 0.01)[1])
    assert lines[0] <= along <= lines[-1]
    bodies = [small.Sphere(1, (-9e-3, along, R + 1e-3 + 2e-5), (0.3, 0.0, 0.0), driven=True)]
    small.prepare(
        tmp_path, spheres_of(R), bodies, contacts(1), liquid=WATER, effects=small.PAPER, walls=[surface],
        wall_angle_rad=math.radians(45.0), time_step_s=2e-5, steps=3000, output_interval_s=1e-3,
    )  # fmt: skip
    small.run(tmp_path, bodies)
    log = beds.table(tmp_path, "history/contacts")
    assert (log["partner_kind"] == 2).all()
    counts = log.groupby("j").size().sort_values()
    stays = log[log["j"] == counts.index[-1]].sort_values("step")
    assert (stays["step"].diff().iloc[1:] == 1).all() and stays["xi_x"].iloc[-1] - stays["xi_x"].iloc[0] > 0.015
    assert stays["volume"].min() == stays["volume"].max()
    way = 0.3 * 2e-5
    jump = np.linalg.norm(np.diff(stays[["xj_x", "xj_y", "xj_z"]].to_numpy(), axis=0), axis=1)
    assert jump.max() < way * (1.0 + 1e-9)
    assert np.abs(np.diff(stays["capillary"])).max() < 1e-3 * stays["capillary"].max()
    crossing = counts.iloc[:-1]
    assert len(crossing) >= 1 and crossing.max() < len(stays)
    ledger = beds.table(tmp_path, "history/ledger")
    held = ledger["films"] + ledger["bridges"] + ledger["walls"]
    assert (held / ledger["initial"] - 1.0).abs().max() < 1e-12
    assert replay(tmp_path)["ok"]  # forces at wires and the life of their liquid, by the independent reference


def test_bridge_comes_off_a_flat_crossing(tmp_path: Path) -> None:
    """Wires of six sides have flat tops that are one face where they cross: one bridge there, and one with the other wire as
    soon as the sphere has left that face, however near it is by then."""
    outline = 0.013 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    wires = build_wires(8e-3, 2e-3, 6, 0.01, outline)
    surface = Surface(**{**wires.__dict__, "motion": "fixed"})
    at, top = float(wire_positions(1e-2, 1e-3, 0.01)[1]), 1e-3 * math.sin(math.pi / 3)
    bodies = [small.Sphere(1, (at - 3e-4, at + 1e-4, R + top + 2e-5), (0.05, 0.0, 0.0), driven=True)]
    small.prepare(
        tmp_path, spheres_of(R), bodies, contacts(1), liquid=WATER, effects=small.PAPER, walls=[surface],
        wall_angle_rad=math.radians(45.0), time_step_s=2e-5, steps=1500, output_interval_s=1e-3,
    )  # fmt: skip
    small.run(tmp_path, bodies)
    events = beds.table(tmp_path, "history/events")
    formed = events[events["kind"] == 0]
    assert formed["step"].tolist()[0] == 0 and formed["j"].nunique() == 2
    left = 8e-4 / 0.05 / 2e-5  # from 0.3 mm before the wire's middle to half a side (0.5 mm) after it
    assert formed["step"].iloc[1] == pytest.approx(left, abs=2)
    assert replay(tmp_path)["ok"]
