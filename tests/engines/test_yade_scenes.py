"""Whole scenes in YADE: a short dry screening in both engines, a moist bed, walls as convex solids, and what is refused."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet import config, stages
from pywet.cases.screening import cases
from pywet.cases.screening.results import write_results
from pywet.cases.small import small
from pywet.cases.small.bodies import water
from pywet.engines import process
from pywet.engines.yade import contacts, driver, solids
from pywet.errors import PywetError
from pywet.geometry import build_apparatus
from pywet.geometry.solids import bin_solid, plate, tube
from pywet.geometry.surface import Surface, make_surface
from pywet.runs.rundir import RunDir
from pywet.scene import EngineScene, Slide
from studies.engines import bed, screening
from studies.stock import moist
from studies.stock.yade import yade_force
from tests.engines.test_yade import CLASSES, DRY, PAIRS, RADII
from tests.error_codes import raises_code

CONFIG = Path(__file__).parents[2] / "config"
needs_yade = pytest.mark.skipif(shutil.which("yade") is None, reason="YADE cannot be installed on this machine")
needs_liggghts = pytest.mark.skipif(shutil.which("liggghts") is None, reason="LIGGGHTS is not installed")


def volume(surface: Surface) -> float:
    """Volume inside a closed surface by the divergence theorem [m3]."""
    p = surface.vertices[surface.triangles].astype(float)
    return float(np.einsum("ij,ij->i", p[:, 0], np.cross(p[:, 1], p[:, 2])).sum() / 6.0)


def inside_or_on(points: np.ndarray, piece: np.ndarray, tolerance: float) -> np.ndarray:
    """Return which points are within or on a convex solid."""
    from scipy.spatial import ConvexHull

    planes = ConvexHull(piece).equations
    return np.asarray((points @ planes[:, :3].T + planes[:, 3] <= tolerance).all(axis=1))


@pytest.mark.parametrize("scale", ["smoke", "full"])
def test_walls_of_the_apparatus_are_cut_into_convex_solids(scale: str) -> None:
    """The pieces have the volume of the surface and every corner of it is on one of them; 1e-4: single precision in STL."""
    from scipy.spatial import ConvexHull

    loaded = config.load(CONFIG)
    for surface in build_apparatus(cases.apparatus_spec(loaded, loaded.case(1), loaded.scale(scale))).surfaces:
        pieces = solids.convex_pieces(surface)
        assert sum(ConvexHull(p).volume for p in pieces) == pytest.approx(volume(surface), rel=1e-4)
        corners = np.unique(surface.vertices[surface.triangles].reshape(-1, 3), axis=0).astype(float)
        assert np.any([inside_or_on(corners, p, 1e-7) for p in pieces], axis=0).all()


@pytest.mark.parametrize(
    ("parts", "count"),
    [
        (plate(0.01 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]), 0.0, 0.002), 1),
        (tube(0.02, 0.003, 4, 0.0, 0.05), 4),
        (tube(0.02, 0.003, 24, 0.0, 0.05), 24),
        (bin_solid(0.02, 0.003, 4, 0.0, 0.05), 5),
    ],
)
def test_number_of_convex_solids(parts: list, count: int) -> None:
    """A plate is one, a tube one per side, a bin one per side and its floor."""
    assert len(solids.convex_pieces(make_surface("part", "wall", parts))) == count


def test_a_solid_that_cannot_be_cut_is_refused() -> None:
    """A cube with a pyramid pressed into its top has slanted faces without counterpart."""
    a, tip = 0.01, np.array([0.0, 0.0, 0.0])
    square = a * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    box = plate(square, -a, a)
    top = box[0][0].reshape(-1, 3)
    rim = np.column_stack([square, np.full(4, float(top[0, 2]))])
    dent = np.array([[rim[k], rim[(k + 1) % 4], tip] for k in range(4)])
    with raises_code("yade.wall"):
        solids.convex_pieces(make_surface("dent", "wall", [(dent, None), *box[1:]]))


def test_damping_of_every_pair_of_case_one() -> None:
    """Four numbers give the damping of nine pairs to 0.03 %, which is 0.0001 of a restitution."""
    loaded = config.load(CONFIG).without_rolling()
    made = cases.ingredients(loaded, 1, "smoke")
    apparatus = build_apparatus(cases.apparatus_spec(loaded, loaded.case(1), loaded.scale("smoke")))
    found = contacts.contacts(cases.assemble(loaded, loaded.case(1), loaded.scale("smoke"), made, apparatus))
    assert found["largest_miss"] < 1e-3
    assert len(found["pairs"]) == 9 and len(found["damping_share"]) == 4


def short_case(path: Path) -> EngineScene:
    """Case 1 at smoke scale for an eighth of a second, the slide drawn at once."""
    scene = screening.prepare(CONFIG, 1, "smoke", 10007, path)
    assert scene.slide is not None
    slide = Slide(velocity_m_per_s=scene.slide.velocity_m_per_s, opens_at_s=0.0, travel_s=scene.slide.travel_s)
    short = scene.model_copy(update={"duration_s": 0.2, "slide": slide})
    (path / "scene.json").write_text(short.model_dump_json())
    return short


@needs_yade
@needs_liggghts
def test_short_dry_screening_in_both_engines(tmp_path: Path) -> None:
    """Expect the same tables, no loss and the same fall of the feed; after 0.1 s single trajectories differ, means do not."""
    tables = {}
    for engine in ("liggghts", "yade"):
        path = tmp_path / engine
        short_case(path)
        stages.simulate(path, 1, False, engine)
        assert all(check.ok for check in write_results(RunDir(path)).checks)
        tables[engine] = pd.read_parquet(path / "trajectory.parquet")
    one, two = tables["liggghts"], tables["yade"]
    assert list(one.columns) == list(two.columns) and (one.dtypes == two.dtypes).all()
    assert one[["step", "id", "type"]].equals(two[["step", "id", "type"]])
    motion = [pd.read_parquet(tmp_path / e / "mesh_motion.parquet") for e in tables]
    assert motion[0][["step", "mesh"]].equals(motion[1][["step", "mesh"]])
    # wires are at the positions of LIGGGHTS; the start of the slide is rounded to a step
    wires = motion[0]["mesh"] != "slide"
    columns = ["dx", "dy", "dz"]
    assert motion[1].loc[wires, columns].to_numpy() == pytest.approx(
        motion[0].loc[wires, columns].to_numpy(), abs=1e-11
    )
    assert motion[1][columns].to_numpy() == pytest.approx(motion[0][columns].to_numpy(), abs=1e-4)
    height = [t.groupby("step")["z"].mean().to_numpy() for t in (one, two)]
    # Mean height of 335 spheres. After the first collisions it scatters by 0.5 mm (standard deviation) in each engine if initial
    # positions change by 1e-9 m: the limit is five standard deviations of the difference, 0.7 mm each. Before, the difference
    # follows from wires and contacts only.
    falling = height[0] > 0.05
    assert falling.sum() >= 3
    assert height[1][falling] == pytest.approx(height[0][falling], abs=3e-4)
    assert height[1] == pytest.approx(height[0], abs=3.5e-3)
    info = json.loads((tmp_path / "yade" / "engine" / "run.json").read_text())
    assert info["engine"] == "YADE" and info["engine_version"].startswith("2023") and info["wall_s"] > 0
    assert not (tmp_path / "yade" / "engine.partial").exists()


@needs_yade
@needs_liggghts
def test_rebound_from_the_vibrating_screen_sphere_by_sphere(tmp_path: Path) -> None:
    """Twenty-five single spheres on edges, faces and crossings of the wires: the same rebounds in both engines.

    A rebound of 0.5 m/s that differs by 0.002 (YADE's damping at an overlap) is 30 µm away after 15 ms. A wire whose edges
    counted twice would throw a sphere elsewhere: 2 mm.
    """
    random = np.random.default_rng(3)
    grid = 0.009 * np.arange(-2, 3)
    places = np.array([(x, y) for x in grid for y in grid]) + random.uniform(-0.0015, 0.0015, (25, 2))
    spheres = pd.DataFrame({"id": np.arange(1, 26), "type": 1, "x": places[:, 0], "y": places[:, 1]})
    spheres["z"] = random.uniform(0.0045, 0.006, 25)
    for name, value in (("vx", 0.1), ("vy", -0.05), ("vz", -0.3), ("wx", 0.0), ("wy", 0.0), ("wz", 0.0)):
        spheres[name] = value
    frames = []
    for engine in ("liggghts", "yade"):
        scene = screening.prepare(CONFIG, 1, "smoke", 10007, tmp_path / engine)
        short = scene.model_copy(
            update={"duration_s": 0.02, "output": scene.output.model_copy(update={"interval_s": 0.001})}
        )
        spheres.to_parquet(tmp_path / engine / scene.spheres_file)
        (tmp_path / engine / "scene.json").write_text(short.model_dump_json())
        stages.simulate(tmp_path / engine, 1, False, engine)
        table = pd.read_parquet(tmp_path / engine / "trajectory.parquet").set_index(["step", "id"])
        frames.append(table[["x", "y", "z"]])
    apart = np.sqrt(((frames[0] - frames[1]) ** 2).sum(axis=1)).groupby("id").last()
    moved = np.sqrt(((frames[0].loc[0] - frames[0].groupby("id").last()) ** 2).sum(axis=1))
    assert moved.median() > 3e-3
    # a few touch two wires at once, where a micrometre determines the direction
    assert apart.quantile(0.8) < 1e-4
    assert apart.median() < 3e-5


@needs_yade
def test_bridges_of_a_moist_bed_are_made_of_nothing(tmp_path: Path) -> None:
    """The stated limits: every bridge has the given volume, so liquid is not conserved; bridges to walls are drawn alike."""
    given = bed.Bed(spheres=32, seconds=0.06)
    scene = bed.prepare(tmp_path, given, wet=False)
    liquid = moist.Bridges("Rabinovich", 2e-11, 0.0728, scene.classes[0].contact_angle_rad)
    found = moist.run(tmp_path, liquid, progress=False)
    r = scene.classes[0].radius_m
    reduced = liquid.volume_m3 / r**3
    rupture = r * (1 + liquid.contact_angle_rad / 2) * (reduced ** (1 / 3) + 0.1 * reduced ** (2 / 3))
    assert len(found) > 20 and found["wall"].any()
    assert (found["volume"] == liquid.volume_m3).all()
    # the rule uses the sphere's radius at walls, as between spheres; 1e-12: the same formula
    assert found["rupture"].to_numpy() == pytest.approx(rupture, rel=1e-12)
    assert (found["gap"] <= rupture).all()


@needs_yade
def test_force_over_gap_and_its_limits() -> None:
    """Rabinovich's form between spheres to round-off; half of it at a wall near touch; nothing while bodies overlap."""
    r, v, theta, sigma = 1e-3, 1e-11, 0.35, 0.07275
    gaps = np.array([1e-6, 5e-5, 1.5e-4, -1e-6])
    points = pd.DataFrame({"separation": gaps, "volume": v, "radius_i": r, "radius_j": r, "contact_angle": theta})
    force = yade_force(points.assign(surface_tension=sigma), "Rabinovich")["force"].to_numpy()
    s = gaps[:3]
    d = 0.5 * s * (np.sqrt(1 + 2 * v / (math.pi * r * s**2)) - 1)
    alpha = np.sqrt(2 * d / r)
    exact = 2 * math.pi * r * sigma * (math.cos(theta) / (1 + s / (2 * d)) + np.sin(alpha) * np.sin(theta + alpha))
    assert force[:3] == pytest.approx(exact, rel=1e-9)
    assert abs(force[3]) < 1e-15
    wall = yade_force(points.assign(surface_tension=sigma, radius_j=math.inf), "Rabinovich")["force"].to_numpy()
    assert wall[:3] == pytest.approx(force[:3], rel=1e-9)


def tiny(path: Path, **more: object) -> None:
    """One sphere above a floor."""
    fields = {"effects": DRY, "time_step_s": 1e-6, "steps": 1000, **more}
    small.prepare(path, CLASSES, [small.Sphere(1, (0.0, 0.0, 0.01))], PAIRS, walls=(small.floor(),), **fields)


def test_missing_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The sentence names the package and the command that installs it."""
    tiny(tmp_path)
    monkeypatch.setenv("PATH", str(tmp_path))
    with raises_code("engine.no_program", expected="yade"):
        driver.run(tmp_path, progress=False)


@needs_yade
def test_another_version(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another year's YADE is refused."""
    tiny(tmp_path)
    monkeypatch.setattr(process, "package_version", lambda name: "2018.02b-1")
    with raises_code("engine.program_version", given="2018.02b-1"):
        driver.run(tmp_path, progress=False)


def test_what_yade_lacks_is_refused(tmp_path: Path) -> None:
    """Expect a message that names what YADE lacks; ranks and unknown engines are refused before anything runs."""
    weighing = small.PAPER.model_copy(update={"liquid_weight": True})
    tiny(tmp_path / "weight", effects=weighing, liquid=water(1e-4))
    with raises_code("yade.scene", says="it lacks spheres whose mass changes"):
        driver.run(tmp_path / "weight", progress=False)
    tiny(tmp_path / "friction", effects=DRY.model_copy(update={"tangential_history": False}))
    with raises_code("yade.scene", says="it lacks friction without memory"):
        driver.run(tmp_path / "friction", progress=False)
    with raises_code("engine.one_process", given=2):
        stages.simulate(tmp_path / "friction", 2, False, "yade")
    with raises_code("engine.unknown", given="mfix"):
        stages.simulate(tmp_path / "friction", 1, False, "mfix")


def test_restitution_beyond_one_damping_per_material(tmp_path: Path) -> None:
    """Coefficients that differ between pairs of spheres as no two materials' mean can."""
    pairs = [p.model_copy(update={"restitution": 0.3 if (p.a, p.b) == (1, 2) else 0.95}) for p in PAIRS]
    scene = small.prepare(tmp_path, CLASSES, [small.Sphere(1, (0.0, 0.0, 0.01))], pairs, effects=DRY, time_step_s=1e-6)
    with raises_code("yade.restitution"):
        contacts.contacts(scene)


def test_moist_run_wants_one_class_and_a_known_law(tmp_path: Path) -> None:
    """Both in one sentence, before YADE is started."""
    tiny(tmp_path)
    with pytest.raises(PywetError, match="has 2 classes of spheres, rolling off and bridges off; expected one class"):
        moist.run(tmp_path, moist.Bridges("Rabinovich", 1e-11, 0.07, 0.2))
    with pytest.raises(PywetError, match="the law rabinovitch was asked for; expected one of Willett_numeric"):
        moist.run(tmp_path, moist.Bridges("rabinovitch", 1e-11, 0.07, 0.2))


@needs_yade
def test_sphere_that_leaves_the_box(tmp_path: Path) -> None:
    """As in LIGGGHTS, a lost sphere ends the run with the reason, and no engine/ is left."""
    tiny(tmp_path, gravity=(0.0, 0.0, 200.0), time_step_s=1e-4, output_interval_s=1e-2)
    with raises_code("yade.stopped", says="sphere 1 left the simulated box"):
        driver.run(tmp_path, progress=False)
    assert not (tmp_path / "engine").exists()
    assert RADII[0] < 0.01
