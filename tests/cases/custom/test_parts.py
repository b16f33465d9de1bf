"""Walls divided into faces: as many bridges with an STL file as with the same shape built in, one at a convex edge; where a
description cannot be meant, it is asked back."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pywet
from pywet.cases.custom.building import Building, write
from pywet.cases.custom.description import Scene
from pywet.geometry import make_surface, write_stl
from pywet.geometry.solids import bin_solid, wire
from pywet.report import ovito, render, vtk
from pywet.runs.rundir import RunDir
from pywet.util.files import read_table
from reference_impl.scene import parts, walls
from reference_impl.shown import vtk as shown_logs
from tests.cases.custom.conftest import beads
from tests.error_codes import raises_code

CUP_MM = 10.0


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two STL files of one cup, 10 mm wide, in m and shifted by 1 km."""
    path = tmp_path_factory.mktemp("stl")
    cup = make_surface("cup", "wall", bin_solid(0.5e-3 * CUP_MM, 0.002, 4, 0.0, 0.010))
    write_stl(cup, path / "cup.stl")
    rows = "".join(
        "facet normal 0 0 0\nouter loop\n" + "".join("vertex {:.9f} {:.9f} {:.9f}\n".format(*(1e3 * p + [1e6, 0, 0])) for p in t)
        + "endloop\nendfacet\n" for t in cup.corners
    )  # fmt: skip
    (path / "far.stl").write_text(f"solid cup\n{rows}endsolid cup\n")
    return path


class Drawn:
    """Record the calls that would draw."""

    def __init__(self) -> None:
        self.meshes: list[Any] = []

    def add_mesh(self, mesh: Any, **_: Any) -> None:
        self.meshes.append(mesh)


def scene(folder: Path, wall: list[dict[str, Any]], at: list[tuple[float, float, float]], **more: Any) -> Scene:
    entry = {"name": "beads", "material": "glass", "diameter_mm": 3, "at_mm": at}
    given = {"spheres": [entry], "walls": wall, "liquid": {"film_um": 30}, "gravity_m_per_s2": (0, 0, 0), **more}
    return Scene(**beads(**given), folder=folder)


@pytest.mark.engine
def test_as_many_bridges_as_faces_that_are_met(folder: Path, tmp_path: Path) -> None:
    """In a cup's corner 3, in its groove 2, on its floor 1, of the STL file as of the vessel; at a block's edge 1; the replay
    derives the parts from the triangles and finds a face that was given to another part."""
    in_cup = [(3.49, 3.49, 1.51), (-3.49, 0.0, 1.51), (0.3, -0.5, 1.51)]
    in_vessel = [(x + 30.0, y, z) for x, y, z in in_cup]
    at = [*in_cup, *in_vessel, (61.0677, 0.0, 1.0677)]
    given = [
        {"name": "cup", "stl": "cup.stl", "stl_unit": "m"},
        {
            "name": "vessel",
            "vessel": {"inner_width_mm": CUP_MM, "height_mm": 10, "thickness_mm": 2, "origin_mm": (30, 0, 0)},
        },
        {"name": "step", "block": {"low_mm": (50, -5, -10), "high_mm": (60, 5, 0)}},
    ]
    run = pywet.run(scene(folder, given, at, duration_s=0.002), tmp_path)
    formed = run.events[(run.events["kind"] == 0) & (run.events["partner_kind"] != 0)]
    count = formed.drop_duplicates(["i", "j"]).groupby("i").size()
    assert [int(count[i]) for i in range(1, 8)] == [3, 2, 1, 3, 2, 1, 1]
    assert run.replay["ok"] and run.replay["quantities"]["scene_parts"]["count"] == 3

    drawn = Drawn()
    render._add_walls(drawn, RunDir(tmp_path), 0, np.full(3, -1.0))
    faces = drawn.meshes[0]
    colour = {int(part): tuple(rgb) for part, rgb in zip(faces["part"], faces["colour"], strict=True)}
    assert [colour[part] for part in (0, 1, 2, 6)] == [render.FACES[k] for k in (0, 1, 2, 0)]

    output_text = json.loads((tmp_path / "scene.json").read_text())
    meshes = walls.read(tmp_path, output_text)
    assert not any(held.wrong for held in parts.derived(output_text, meshes))
    output_text["walls"][2]["triangle_part"] = [max(p - 1, 0) for p in output_text["walls"][2]["triangle_part"]]
    wrong = [held for held in parts.derived(output_text, meshes) if held.wrong]
    assert len(wrong) == 1 and wrong[0].given == 4, wrong  # two faces of a block, two triangles each


@pytest.mark.engine
def test_a_convex_edge_gives_one_bridge_while_a_sphere_rolls_over_it(folder: Path, tmp_path: Path) -> None:
    """Along the way to the edge, over it and down the side a sphere has one bridge: with the top until that ruptures, its foot at
    the edge, then with the side. One at rest 0.2 mm from the edge is not drawn over it by a bridge with the side.

    The momentum between outputs is judged of the one that flies off, and not of those that touch the block all the time."""
    block = {"name": "step", "block": {"low_mm": (-10, -6, -10), "high_mm": (0, 6, 0)}}
    entry = {"material": "glass", "diameter_mm": 3}
    spheres = [
        {**entry, "name": "rolls", "at_mm": [(-0.5, -3, 1.501)], "velocity_m_per_s": (0.15, 0, 0)},
        {**entry, "name": "rests", "at_mm": [(-0.2, 4, 1.501)]},
        {**entry, "name": "flies", "at_mm": [(-8, 0.5, 1.501)], "velocity_m_per_s": (0.45, 0, 0)},
    ]
    given = scene(
        folder, [block], [], spheres=spheres, gravity_m_per_s2=(0, 0, -1.0), duration_s=0.038,
        materials={"glass": {"density_kg_per_m3": 2500, "rolling_friction_m": 0}}, results={"interval_s": 0.0005},
    )  # fmt: skip
    run = pywet.run(given, tmp_path)
    assert run.bridges.groupby(["step", "i"]).size().max() == 1
    events = run.events[run.events["i"] == 1]
    assert events["kind"].tolist() == [0, 1, 0] and events["j"].iloc[0] == events["j"].iloc[1] != events["j"].iloc[2]
    assert events["separation"].iloc[1] > 3e-4  # the wall end of the bridge stayed at the edge
    rests = run.trajectory[run.trajectory["id"] == 2]
    assert np.abs(rests["x"] + 2e-4).max() < 1e-6
    assert run.replay["quantities"]["formation_missed"]["count"] > 10
    assert run.replay["quantities"]["formation_shared"]["count"] > 100
    flying = run.bridges[(run.bridges["i"] == 3) & (run.bridges["separation"] > 1e-4)]
    assert len(flying) > 1 and run.replay["quantities"]["between_momentum"]["count"] > len(flying)


@pytest.mark.engine
def test_a_finer_mesh_of_the_same_cup_gives_the_same_bridges(folder: Path, tmp_path: Path) -> None:
    """Each triangle divided into four: 3, 2 and 1 bridges in corner, groove and on the floor."""
    coarse = Building(scene(folder, [{"name": "cup", "stl": "cup.stl", "stl_unit": "m"}], [(0, 0, 5)])).surfaces[0]
    a, b, c = coarse.corners.transpose(1, 0, 2)
    d, e, f = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
    fine = np.concatenate([np.stack(t, axis=1) for t in ((a, d, f), (d, b, e), (f, e, c), (d, e, f))])
    write_stl(make_surface("cup", "wall", [(fine, None)]), folder / "fine.stl")
    at = [(3.49, 3.49, 1.51), (-3.49, 0.0, 1.51), (0.3, -0.5, 1.51)]
    given = scene(folder, [{"name": "cup", "stl": "fine.stl", "stl_unit": "m"}], at, duration_s=0.002)
    run = pywet.run(given, tmp_path)
    formed = run.events[(run.events["kind"] == 0) & (run.events["partner_kind"] != 0)]
    assert formed.drop_duplicates(["i", "j"]).groupby("i").size().tolist() == [3, 2, 1]
    parts = Building(given).surfaces[0]
    assert len(parts.triangles) == 4 * len(coarse.triangles) and len(parts.part_half_width) == len(
        coarse.part_half_width
    )


def test_a_size_that_no_sphere_meets_is_asked_back(folder: Path) -> None:
    """The cup is 14 mm, its file in m; read as mm it is 0.014 mm, the other one read as m 14 m next to spheres of 3 um."""
    with raises_code("scene.stl_unit", expected="m"):
        Building(scene(folder, [{"name": "cup", "stl": "cup.stl"}], [(0, 0, 5)])).scene()
    far = {"name": "cup", "stl": "far.stl", "stl_unit": "m", "origin_mm": (1e9, 0, 0)}
    with raises_code("scene.stl_unit", expected="mm"):
        Building(scene(folder, [far], [(0, 0, 5)])).scene()


@pytest.mark.engine
def test_positions_are_moved_to_an_origin_and_back(
    folder: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """A sphere in the corner of a cup 1 km away: the engine's tables are near the origin; `pywet.load`, vtk/ and ovito/ give the
    scene's own positions to the nanometre; the replay, which reads vtk/ back, agrees, and finds files that are not moved back."""
    far = scene(
        folder, [{"name": "cup", "stl": "far.stl"}], [(1e6 + 3.49, 3.49, 1.51)], origin_mm=(1e6, 0, 0), duration_s=0.001
    )
    run = pywet.run(far, tmp_path / "far")
    assert "test: Parquet files count positions from origin_mm [1000000, 0, 0]; pywet.load, vtk/" in caplog.text
    assert read_table(tmp_path / "far" / "spheres.parquet")["x"].iloc[0] == pytest.approx(3.49e-3, abs=1e-12)
    at_start = run.trajectory.iloc[0]
    assert at_start["x"] == pytest.approx(1000.00349, abs=1e-9) and at_start["y"] == pytest.approx(3.49e-3)
    bridge = run.bridges[run.bridges["xj_z"] < 1e-4].iloc[0]  # the bridge at the floor
    assert bridge["xi_x"] == pytest.approx(1000.00349, abs=1e-6) and bridge["xj_x"] == pytest.approx(
        bridge["xi_x"], abs=1e-9
    )
    shown = vtk.output(RunDir(tmp_path / "far"), "walls", 0).points
    assert [shown[:, 0].min(), shown[:, 0].max()] == pytest.approx([999.993, 1000.007], abs=1e-9)
    vtk.write(tmp_path / "far")
    ovito.write(tmp_path / "far")
    row = (tmp_path / "far" / "ovito" / "spheres.dump").read_text().splitlines()[9].split()
    assert "1000.00349" in row
    assert pywet.replay(tmp_path / "far")["ok"] and shown_logs.disagreement(tmp_path / "far") is None
    description = tmp_path / "far" / "description.json"
    description.write_text(description.read_text().replace("1000000.0", "1000001.0"))
    assert "vtk_sphere_position" in (shown_logs.disagreement(tmp_path / "far") or "")
    caplog.clear()
    write(scene(folder, [{"name": "cup", "stl": "cup.stl", "stl_unit": "m"}], [(1, 0, 5)]), tmp_path / "near")
    assert pywet.load(tmp_path / "near").origin_mm == (0, 0, 0) and "origin" not in caplog.text


def test_plant_coordinates_are_moved_to_an_origin(folder: Path) -> None:
    """A cup 1 km away: walls, spheres and motions are as at the origin, with `origin_mm` or without; a wrong one is refused."""
    far = {
        "name": "cup",
        "stl": "far.stl",
        "turns": {"turns_per_minute": 60, "axis": (0, 0, 1), "origin_mm": (1e6, 0, 0)},
    }
    with raises_code("scene.far_away"):
        Building(scene(folder, [far], [(1e6 + 1.0, 0, 5)], origin_mm=(5e5, 0, 0))).scene()
    made = Building(scene(folder, [far], [(1e6 + 1.0, 0, 5)], origin_mm=(1e6, 0, 0)))
    by_itself = Building(scene(folder, [far], [(1e6 + 1.0, 0, 5)]))
    assert by_itself.origin_mm == (1e6, 0, 0) and by_itself.user_scene == made.user_scene
    near = Building(scene(folder, [{**far, "stl": "cup.stl", "stl_unit": "m", "turns": {**far["turns"], "origin_mm": (0, 0, 0)}}],
                          [(1.0, 0, 5)]))  # fmt: skip
    np.testing.assert_allclose(made.surfaces[0].corners, near.surfaces[0].corners, atol=1e-9)
    assert made.scene().box_low_m == pytest.approx(near.scene().box_low_m, abs=1e-9)
    assert made.scene().walls[0].motion_parameters == near.scene().walls[0].motion_parameters
    assert made.spheres["x"].tolist() == [0.001]


def test_thin_bodies_of_a_file_are_wires_when_named_so(folder: Path, caplog: pytest.LogCaptureFixture) -> None:
    """Each body is one part with the given half width; bars that are not named so are reported as faces."""
    bars = [wire(np.array([0.0, y, 0.0]), np.array([0.03, y, 0.0]), 1e-3, 8, 1.1) for y in (0.0, 0.01)]
    write_stl(make_surface("deck", "wall", [(bar, 1e-3) for bar in bars]), folder / "deck.stl")
    deck = {"name": "deck", "stl": "deck.stl", "stl_unit": "m"}
    named = Building(scene(folder, [{**deck, "half_width_mm": 1}], [(0, 0, 5)])).surfaces[0]
    assert named.part_half_width == (0.001, 0.001) and not caplog.records
    as_faces = Building(scene(folder, [deck], [(0, 0, 5)])).surfaces[0]
    assert len(as_faces.part_half_width) == 2 * (8 + 2)
    assert "wall deck: 2 of its 2 bodies are bars of about 2 mm, taken as faces" in caplog.text
    assert "half_width_mm: 1 gives each" in caplog.text
    wall = scene(folder, [{"name": "cup", "stl": "cup.stl", "stl_unit": "m", "half_width_mm": 0.5}], [(0, 0, 5)]).walls[
        0
    ]
    assert wall.surface(folder).part_half_width == (0.0005,) and wall.fold_deg == 180.0


@pytest.mark.engine
def test_a_sphere_that_leaves_at_a_checkpoint_says_so_in_words_that_the_user_has(folder: Path, tmp_path: Path) -> None:
    """The checkpoint holds no sphere, which is no full disk; the sentence names no box, which a scene has no key for."""
    entry = {"material": "glass", "diameter_mm": 3, "name": "up", "at_mm": [(0, 0, 2)], "velocity_m_per_s": (0, 0, 3)}
    given = scene(folder, [{"name": "step", "block": {"low_mm": (-5, -5, -5), "high_mm": (5, 5, 0)}}], [],
                  spheres=[entry], duration_s=0.05)  # fmt: skip
    with raises_code("engine.stopped", says="through the upper z face") as reported:
        pywet.run(given, tmp_path)
    assert "disk" not in str(reported.value) and "enlarge the box" not in str(reported.value)


@pytest.mark.engine
def test_a_rim_that_is_nearer_elsewhere_takes_no_bridge(folder: Path, tmp_path: Path) -> None:
    """Over the corner of a cup's rim a sphere is near two inner edges: a bridge with each, though the rim's own closest point is
    on the nearer one. One inside the rim's plane, next to one edge, has one."""
    given = [{"name": "cup", "stl": "cup.stl", "stl_unit": "m"}]
    run = pywet.run(scene(folder, given, [(3.544, 3.546, 10.4), (-3.544, 0.0, 10.4)], duration_s=0.002), tmp_path)
    formed = run.events[(run.events["kind"] == 0) & (run.events["partner_kind"] != 0)]
    count = formed.drop_duplicates(["i", "j"]).groupby("i").size()
    assert [int(count[i]) for i in (1, 2)] == [2, 1]
    assert run.replay["ok"] and run.replay["quantities"]["formation_missed"]["count"] > 0
