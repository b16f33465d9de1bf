"""VTK files of the synthetic run, read back by VTK itself; numbers as in tests/cases/screening/synthetic.py."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import pyvista

from pywet import run_folder
from pywet.engines import run_store
from pywet.laws.contact import film_thickness
from pywet.report import vtk
from pywet.runs.walls import wall_corners
from pywet.scene import Rotation
from tests.cases.screening import synthetic
from tests.cases.screening.synthetic import UNIT
from tests.error_codes import raises_code


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    run = synthetic.make(tmp_path / "case02")
    vtk.write(run)
    return run / "vtk"


def test_series_names_every_output_with_its_time(folder: Path) -> None:
    for kind in ("particles", "bridges", "walls"):
        sets = ET.parse(folder / f"{kind}.pvd").findall("./Collection/DataSet")
        assert [float(s.attrib["timestep"]) for s in sets] == [0.0, 0.01, 0.02]
        assert all((folder / s.attrib["file"]).exists() for s in sets)


def test_a_series_takes_the_place_of_an_earlier_one(folder: Path) -> None:
    (folder / "particles_000000999.vtu").write_text("of another run")
    run_folder.record(folder.parent, ["vtk/particles_000000999.vtu"])
    vtk.write(folder.parent)
    assert sorted(p.name for p in folder.glob("particles_*")) == [f"particles_{step:09d}.vtu" for step in (0, 100, 200)]


def test_other_exports_stay_with_the_series(folder: Path) -> None:
    """Until the run is simulated again; a file of a kind that is written is replaced, and a user's file refused as before."""
    exports = ("walls.vtkhdf", "open_in_paraview.py", "cuboids.pvd", "cuboids_000000100.vtu")
    for name in (*exports, "bridges_000000999.vtu"):
        (folder / name).write_text(name)
    with raises_code("folder.stranger"):
        vtk.write(folder.parent)
    run_folder.record(folder.parent, [f"vtk/{name}" for name in (*exports, "bridges_000000999.vtu")])
    vtk.write(folder.parent)
    assert [(folder / name).read_text() for name in exports] == list(exports)
    assert not (folder / "bridges_000000999.vtu").exists() and not (folder.parent / "vtk.partial").exists()
    vtk.write(folder.parent, with_cuboids=True)
    assert sorted(p.name for p in folder.glob("cuboids*")) == [
        "cuboids.pvd", *(f"cuboids_{step:09d}.vtu" for step in (0, 100, 200))
    ]  # fmt: skip
    assert {"walls.vtkhdf", "open_in_paraview.py"} <= {p.name for p in folder.iterdir()}
    run_store.forget(folder.parent)
    assert not folder.exists()


def test_particles_carry_radius_film_and_place(folder: Path) -> None:
    mesh = pyvista.read(folder / "particles_000000200.vtu")
    assert mesh.point_data["in_bin"].tolist() == [0, 1, 1]
    assert mesh.point_data["radius"].tolist() == [4e-3, 2e-3, 2e-3]
    expected = film_thickness(np.array([7.5, 5.0, 4.0]) * UNIT, mesh.point_data["radius"])
    np.testing.assert_allclose(mesh.point_data["film_thickness"], expected, rtol=1e-15)
    np.testing.assert_allclose(mesh.point_data["liquid"], np.array([9.25, 5, 4.5]) * UNIT, rtol=1e-14)


def test_bridges_are_lines_between_their_ends(folder: Path) -> None:
    mesh = pyvista.read(folder / "bridges_000000200.vtu")
    np.testing.assert_allclose(mesh.cell_data["volume"], [2 * UNIT, UNIT])
    first = mesh.points[mesh.cell_connectivity[:2]]
    np.testing.assert_allclose(first, [[-0.006, 0, 0.006], [0.006, 0, -0.05]])


def test_bridges_carry_their_age(folder: Path) -> None:
    """Formed in steps 162 and 163. (tests/reference_impl/test_vtk.py compares their force with the reference's equation.)"""
    age = pyvista.read(folder / "bridges_000000200.vtu").cell_data["age"]
    np.testing.assert_allclose(age, [38 * synthetic.TIME_STEP, 37 * synthetic.TIME_STEP], rtol=1e-12)


def test_the_law_of_a_file_is_not_run_for_a_picture(tmp_path: Path) -> None:
    run = synthetic.make(tmp_path / "case02")
    scene = run / "scene.json"
    scene.write_text(scene.read_text().replace('"rabinovich"', '"mine.py:pull"'))
    vtk.write(run)
    assert np.isnan(pyvista.read(run / "vtk" / "bridges_000000200.vtu").cell_data["capillary_force"]).all()


def test_walls_follow_their_motion_and_show_the_film(folder: Path) -> None:
    mesh = pyvista.read(folder / "walls_000000200.vtu")
    z = mesh.points[mesh.cell_connectivity].reshape(-1, 3, 3)[:, :, 2]
    np.testing.assert_allclose(z, np.repeat([2e-3, 2e-3, -0.06], 2)[:, None] * np.ones(3))
    np.testing.assert_allclose(mesh.cell_data["film_thickness"], [0, 0, 0, 0, 0.5 * UNIT / 8e-4, 0])


def test_vtk_itself_reads_the_series_also_where_there_is_no_bridge(folder: Path) -> None:
    reader = pyvista.get_reader(str(folder / "bridges.pvd"))
    counts = []
    for time in reader.time_values:
        reader.set_active_time_value(time)
        counts.append(reader.read()[0].n_cells)
    assert counts == [0, 0, 2]


def test_a_dry_run_has_no_bridges(tmp_path: Path) -> None:
    run = synthetic.make(tmp_path / "case01", moist=False)
    vtk.write(run)
    assert len(pyvista.read(run / "vtk" / "particles_000000000.vtu").points) == 3
    assert pyvista.read(run / "vtk" / "bridges_000000000.vtu").n_cells == 0


def test_a_turning_wall_is_where_its_turn_has_brought_it() -> None:
    """A third of a turn about (1, 1, 1) carries x to y, y to z, z to x; the second wall stays."""
    turn = Rotation(origin_m=(1.0, 2.0, 3.0), axis=(2.0, 2.0, 2.0), period_s=3.0)
    corners = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]) + turn.origin_m
    run = SimpleNamespace(
        corners_at_rest=np.array([corners] * 2),
        meshes=np.array(["drum", "floor"], dtype=object),
        mesh_motion=pd.DataFrame({"step": [300], "mesh": ["floor"], "dx": 0.0, "dy": 0.0, "dz": 0.5}),
        scene=SimpleNamespace(
            name="",
            motions={"drum": turn, "floor": None},
            time_step_s=1.0 / 300.0,
        ),
    )
    turned, moved = wall_corners(run, 300)  # type: ignore[arg-type]
    np.testing.assert_allclose(turned, np.roll(np.eye(3), 1, axis=1) + turn.origin_m, atol=1e-14)
    np.testing.assert_allclose(moved, corners + np.array([0.0, 0.0, 0.5]), atol=1e-14)
