"""VTK files of a run compared with its logs: faults injected in what writes them are found, and named."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import pyvista

from pywet.report import vtk as writer
from pywet.runs.rundir import RunDir
from pywet.util.files import write_table
from reference_impl.replay.io import ReplayError
from reference_impl.shown import vtk, vtu
from tests.cases.screening import synthetic

Change = Callable[[Any, RunDir, int], Any]


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """The synthetic run with speeds and places in all directions, and liquid on walls from the second output on."""
    folder, random = synthetic.make(tmp_path / "case02"), np.random.default_rng(7)
    table = pd.read_parquet(folder / "trajectory.parquet")
    table[["vx", "vy", "vz"]] = random.normal(size=(len(table), 3))
    table[["x", "y"]] += random.normal(size=(len(table), 2)) * 1e-3
    write_table(table, folder / "trajectory.parquet")
    wet = [(step, t, volume * synthetic.UNIT) for step, volume in ((100, 0.2), (200, 0.5)) for t in (0, 4)]
    write_table(pd.DataFrame(wet, columns=["step", "triangle", "film"]), folder / "history" / "wall_films.parquet")
    return folder


def points(change: Callable[[np.ndarray], np.ndarray]) -> Change:
    return lambda mesh, run, step: setattr(mesh, "points", change(np.array(mesh.points)))


def sphere(name: str, change: Callable[[np.ndarray], np.ndarray]) -> Change:
    return lambda mesh, run, step: mesh.point_data.update({name: change(np.array(mesh.point_data[name]))})


def cell(name: str, change: Callable[[np.ndarray], np.ndarray]) -> Change:
    def changed(mesh: Any, run: RunDir, step: int) -> None:
        if name in mesh.cell_data:
            mesh.cell_data[name] = change(np.array(mesh.cell_data[name]))

    return changed


def before(kind: str, name: str, of_points: bool = True) -> Change:
    """A field of the output before."""

    def change(mesh: Any, run: RunDir, step: int) -> None:
        other = writer.KINDS[kind](run, max(0, step - 100))
        (mesh.point_data if of_points else mesh.cell_data)[name] = (other.point_data if of_points else other.cell_data)[
            name
        ]

    return change


def places_before(kind: str) -> Change:
    return lambda mesh, run, step: setattr(mesh, "points", writer.KINDS[kind](run, max(0, step - 100)).points)


def ends_swapped(mesh: Any, run: RunDir, step: int) -> None:
    mesh.points = mesh.points.reshape(-1, 2, 3)[:, ::-1].reshape(-1, 3)


def place_for_velocity(mesh: Any, run: RunDir, step: int) -> None:
    mesh.point_data["velocity"] = mesh.points


def gap_for_volume(mesh: Any, run: RunDir, step: int) -> None:
    if mesh.cell_data:
        mesh.cell_data["volume"] = mesh.cell_data["separation"]


def at_rest(mesh: Any, run: RunDir, step: int) -> None:
    mesh.points = writer.walls(run, 0).points


def one_missing(mesh: Any, run: RunDir, step: int) -> Any:
    return writer.grid(
        "VERTEX", 1, np.array(mesh.points[:-1]), {name: mesh.point_data[name][:-1] for name in mesh.point_data}
    )


YZ, XY = [0, 2, 1], [1, 0, 2]
DOWN, NO_Y, UP = (np.array(v) for v in ([1, 1, -1], [1, 0, 1], [0, 0, 1e-4]))
BEFORE = "it is that of the output before"
FAULTS: dict[str, tuple[str, Change, str, str]] = {
    "axes exchanged": ("particles", points(lambda p: p[:, YZ]), "sphere_position", "components y and z are exchanged"),
    "x for y": ("particles", points(lambda p: p[:, XY]), "sphere_position", "components x and y are exchanged"),
    "upside down": ("particles", points(lambda p: p * DOWN), "sphere_position", "component z has the other sign"),
    "millimetres": (
        "particles",
        points(lambda p: p * 1e3),
        "sphere_position",
        "1000 times what it should be (mm for m)",
    ),
    "moved": ("particles", points(lambda p: p + UP), "sphere_position", "it is moved by 0, 0, 0.0001"),
    "places late": ("particles", places_before("particles"), "sphere_position", BEFORE),
    "velocity exchanged": (
        "particles",
        sphere("velocity", lambda v: v[:, YZ]),
        "sphere_velocity",
        "components y and z",
    ),
    "velocity without vy": (
        "particles",
        sphere("velocity", lambda v: v * NO_Y),
        "sphere_velocity",
        "component y is lost",
    ),
    "velocity turned": ("particles", sphere("velocity", lambda v: -v), "sphere_velocity", "the sign is turned"),
    "place for velocity": ("particles", place_for_velocity, "sphere_velocity", "it is the position"),
    "diameters": ("particles", sphere("radius", lambda r: 2 * r), "sphere_radius", "a diameter for a radius"),
    "radius a bit off": ("particles", sphere("radius", lambda r: 1.001 * r), "sphere_radius", "1.001 times"),
    "film late": ("particles", before("particles", "film_thickness"), "sphere_film_thickness", BEFORE),
    "film in µm": ("particles", sphere("film_thickness", lambda h: 1e6 * h), "sphere_film_thickness", "µm for m"),
    "liquid late": ("particles", before("particles", "liquid"), "sphere_liquid", BEFORE),
    "class of another": ("particles", sphere("class", lambda c: np.roll(c, 1)), "sphere_class", "the row before"),
    "screen for bin": ("particles", sphere("in_bin", lambda b: 1 - b), "sphere_in_bin", "yes and no are exchanged"),
    "numbers": ("particles", sphere("id", lambda n: n + 1), "spheres", "spheres that are shown"),
    "a sphere left out": ("particles", one_missing, "spheres", "spheres that are shown"),
    "ends swapped": ("bridges", ends_swapped, "bridge_first_end", "it is the second end"),
    "bridges upside down": (
        "bridges",
        points(lambda p: p * DOWN),
        "bridge_first_end",
        "component z has the other sign",
    ),
    "half the bridge": ("bridges", cell("volume", lambda v: v / 2), "bridge_volume", "half the value"),
    "gap for volume": ("bridges", gap_for_volume, "bridge_volume", "it is the separation"),
    "gap turned": ("bridges", cell("separation", lambda s: -s), "bridge_separation", "the sign is turned"),
    "force turned": ("bridges", cell("capillary_force", lambda f: -f), "bridge_capillary_force", "the sign is turned"),
    "force of two spheres": (
        "bridges",
        cell("capillary_force", lambda f: f / 2),
        "bridge_capillary_force",
        "half the value",
    ),
    "force for another bridge": (
        "bridges",
        cell("capillary_force", lambda f: np.roll(f, 1)),
        "bridge_capillary_force",
        "the row before",
    ),
    "age in ms": ("bridges", cell("age", lambda a: 1e3 * a), "bridge_age", "1000 times"),
    "age for the time of formation": ("bridges", cell("age", lambda a: 0.02 - a), "bridge_age", "age of a bridge"),
    "partners": ("bridges", cell("j", lambda j: j + 1), "bridges", "bridges that are shown"),
    "walls at rest": ("walls", at_rest, "wall_corner_0", "it is that of the start"),
    "walls late": ("walls", places_before("walls"), "wall_corner_0", BEFORE),
    "wall films late": ("walls", before("walls", "film_thickness", False), "wall_film_thickness", BEFORE),
    "volume for thickness": (
        "walls",
        cell("film_thickness", lambda h: 8e-4 * h),
        "wall_film_thickness",
        "0.0008 times",
    ),
    "film of another": (
        "walls",
        cell("film_thickness", lambda h: np.roll(h, 1)),
        "wall_film_thickness",
        "the row before",
    ),
    "reservoirs exchanged": (
        "walls",
        cell("reservoir", lambda h: (h + 1) % 3),
        "wall_reservoir",
        "name of a triangle's reservoir",
    ),
    "parts turned": ("walls", cell("part", lambda p: p[::-1]), "wall_part", "the order of rows is turned"),
}
"""What is injected: in which file, how, which quantity must find it, and what its sentence must say."""
"""What is injected: in which file, how, what must find it, and what its sentence must say."""


def test_what_was_written_agrees(run: Path) -> None:
    writer.write(run)
    quantities, findings = vtk.check(run)
    assert all(q.ok for q in quantities) and not findings
    counts = {q.name: q.count for q in quantities}
    # three spheres and six triangles at three outputs, two bridges at the last
    assert (counts["vtk_sphere_velocity"], counts["vtk_wall_corner_2"], counts["vtk_bridge_volume"]) == (9, 18, 2)
    assert counts["vtk_bridge_capillary_force"] == counts["vtk_bridge_age"] == 2


@pytest.mark.parametrize("name", FAULTS)
def test_faults_of_the_files_are_found_and_named(name: str, run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kind, change, quantity, message = FAULTS[name]
    quantity = f"vtk_{quantity}"
    right = writer.KINDS[kind]

    def wrong(of: RunDir, step: int) -> Any:
        mesh = right(of, step)
        monkeypatch.setitem(writer.KINDS, kind, right)
        mesh = change(mesh, of, step) or mesh
        monkeypatch.setitem(writer.KINDS, kind, wrong)
        return mesh

    monkeypatch.setitem(writer.KINDS, kind, wrong)
    writer.write(run)
    quantities, findings = vtk.check(run)
    assert quantity in [q.name for q in quantities if not q.ok]
    sentences = [f["sentence"] for f in findings if quantity in f["quantities"]]
    assert any(message in sentence for sentence in sentences), sentences


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ('timestep="0.01"', 'timestep="0.011"', "it is moved by 0.001"),
        ("particles_000000100", "particles_000000000", "the output before"),
    ],
)
def test_time_stamps_and_files_exchanged(before: str, after: str, message: str, run: Path) -> None:
    writer.write(run)
    path = run / "vtk" / "particles.pvd"
    path.write_text(path.read_text().replace(before, after))
    quantities, findings = vtk.check(run)
    assert any(not q.ok for q in quantities)
    assert any(message in f["sentence"] for f in findings), [f["sentence"] for f in findings]


def test_times_in_ms_are_named(run: Path) -> None:
    writer.write(run)
    path = run / "vtk" / "walls.pvd"
    path.write_text(path.read_text().replace('"0.01"', '"10"').replace('"0.02"', '"20"'))
    _, findings = vtk.check(run)
    assert [f["fault"] for f in findings] == ["it is 1000 times what it should be (mm for m)"]


def test_an_output_left_out_is_found(run: Path) -> None:
    writer.write(run)
    path = run / "vtk" / "bridges.pvd"
    path.write_text("\n".join(line for line in path.read_text().splitlines() if "000100" not in line))
    quantities, findings = vtk.check(run)
    assert [q.name for q in quantities if not q.ok] == ["vtk_bridges_outputs"]
    assert "number of files of bridges" in findings[0]["sentence"]


def test_the_reader_reads_what_vtk_reads(run: Path) -> None:
    writer.write(run)
    for kind in ("particles", "bridges", "walls"):
        path = run / "vtk" / f"{kind}_000000200.vtu"
        mine, theirs = vtu.read(path), pyvista.read(path)
        np.testing.assert_array_equal(mine.points, theirs.points)
        for written, other in ((mine.of_points, theirs.point_data), (mine.of_cells, theirs.cell_data)):
            assert set(written) == set(other.keys())
            for name, values in written.items():
                np.testing.assert_array_equal(values, other[name])
        assert {n: list(theirs.field_data[n]) for n in mine.words} == mine.words
    assert mine.words["reservoir_from_0"] == ["wires", "side_wall", "collecting_bin"]


def test_walls_that_turn_are_shown_turned(run: Path) -> None:
    """A quarter of a turn about z takes (x, y) to (-y, x)."""
    scene = json.loads((run / "scene.json").read_text())
    for wall in scene["walls"]:
        wall["motion"] = "turns"
    scene["rotation"] = {"origin_m": [0, 0, 0], "axis": [0, 0, 2], "period_s": 0.08}  # the last output is at 0.02 s
    (run / "scene.json").write_text(json.dumps(scene))
    writer.write(run)
    assert all(q.ok for q in vtk.check(run)[0])
    start, end = (vtu.read(run / "vtk" / f"walls_{step:09d}.vtu").points[-3:] for step in (0, 200))
    np.testing.assert_allclose(end, np.stack([-start[:, 1], start[:, 0], start[:, 2]], axis=1), atol=1e-15)


def test_a_cut_file_is_refused_in_a_sentence(run: Path) -> None:
    writer.write(run)
    path = run / "vtk" / "walls_000000100.vtu"
    path.write_text(path.read_text()[:-100])
    with pytest.raises(ReplayError, match=r"walls_000000100.vtu cannot be read.*write it again with pywet view"):
        vtk.check(run)


def test_files_that_are_not_there_yet_are_no_gap_of_the_replay(run: Path) -> None:
    """They are compared with the logs when they are written, after the replay."""
    assert vtk.check(run) == ([], [])
