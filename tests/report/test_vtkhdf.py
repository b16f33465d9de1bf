"""One temporal file per kind, read back by VTK's own reader: every array of every output as in the series."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import pyvista
from vtkmodules.vtkIOHDF import vtkHDFReader

from pywet import stages
from pywet.report import vtk, vtkhdf
from pywet.runs.rundir import RunDir
from reference_impl.shown import vtkhdf as read_back
from tests.cases.screening import synthetic
from tests.error_codes import raises_code


def test_each_output_is_that_of_the_series(tmp_path: Path) -> None:
    folder = synthetic.make(tmp_path / "case02")
    run = RunDir(folder)
    assert [path.name for path in vtkhdf.write(folder)] == [f"{kind}.vtkhdf" for kind in vtk.KINDS]
    for kind in vtk.KINDS:
        for k, step in enumerate(synthetic.STEPS):
            reader = vtkHDFReader()
            reader.SetFileName(str(folder / "vtk" / f"{kind}.vtkhdf"))
            reader.SetStep(k)
            reader.Update()
            theirs, ours = pyvista.wrap(reader.GetOutput()), vtk.output(run, kind, step)
            assert reader.GetNumberOfSteps() == len(synthetic.STEPS)
            assert theirs.field_data["Time"][0] == np.float32(step * synthetic.TIME_STEP)  # VTK keeps single precision
            assert theirs.n_cells == ours.n_cells and np.array_equal(theirs.points, ours.points)
            for mine, read in ((ours.point_data, theirs.point_data), (ours.cell_data, theirs.cell_data)):
                assert set(mine.keys()) <= set(read.keys())
                for name in mine:
                    np.testing.assert_array_equal(read[name], mine[name])
            assert all(list(theirs.field_data[name]) == words for name, words in vtk.words(run)[kind].items())


Change = Callable[[Any, int], None]
"""Of the grid of an output step."""


def values(group: str, name: str, change: Callable[[np.ndarray], np.ndarray]) -> Change:
    def apply(grid: Any, step: int) -> None:
        data = getattr(grid, group)
        if name in data:
            data[name] = change(np.array(data[name]))

    return apply


def places(change: Callable[[np.ndarray], np.ndarray]) -> Change:
    def apply(grid: Any, step: int) -> None:
        if grid.n_points:
            grid.points = change(np.array(grid.points))

    return apply


FAULTS: dict[str, tuple[str, Change, str]] = {
    "y mirrored": ("particles", places(lambda x: x * [1.0, -1.0, 1.0]), "vtk_sphere_position"),
    "diameters": ("particles", values("point_data", "radius", lambda r: 2.0 * r), "a diameter for a radius"),
    "places of the next sphere": ("particles", places(lambda x: np.roll(x, 1, axis=0)), "vtk_sphere_position"),
    "speeds halved": ("particles", values("point_data", "velocity", lambda v: 0.5 * v), "vtk_sphere_velocity"),
    "ends of bridges exchanged": ("bridges", places(lambda x: x[::-1]), "vtk_bridge_first_end"),
    "gaps as forces": ("bridges", values("cell_data", "capillary_force", lambda f: 1e-3 * f), "vtk_bridge_capillary_force"),
    "walls one millimetre high": ("walls", places(lambda x: x + np.array([0.0, 0.0, 1e-3])), "vtk_wall_corner"),
}  # fmt: skip


@pytest.fixture
def crooked(tmp_path: Path) -> Path:
    """A run with spheres at places that no exchange leaves alike."""
    folder = synthetic.make(tmp_path / "case02")
    table = pd.read_parquet(folder / "trajectory.parquet")
    table = table.assign(y=1e-3 * table["id"] + 2e-4, vy=0.03 * table["id"], vz=-0.07)
    table.to_parquet(folder / "trajectory.parquet")
    return folder


def test_what_is_written_agrees_with_the_logs(crooked: Path) -> None:
    assert [path.name for path in stages.vtkhdf(crooked)] == [f"{kind}.vtkhdf" for kind in vtk.KINDS]
    (crooked / "vtk" / "walls.vtkhdf").write_bytes(b"no more")
    with raises_code("shown.refused"):
        stages._read_back([], read_back.disagreement, crooked)


@pytest.mark.parametrize("fault", FAULTS)
def test_a_wrong_file_is_found(crooked: Path, monkeypatch: pytest.MonkeyPatch, fault: str) -> None:
    """By the reference, which reads the files back."""
    kind, change, words = FAULTS[fault]
    sound = vtk.output

    def output(run: RunDir, of: str, step: int) -> Any:
        grid = sound(run, of, step).copy()
        if of == kind:
            change(grid, step)
        return grid

    monkeypatch.setattr(vtk, "output", output)
    (crooked / "vtk").mkdir(exist_ok=True)
    for of in vtk.KINDS:
        vtkhdf.draw(RunDir(crooked), of, crooked / "vtk" / f"{of}.vtkhdf")
    assert words in (read_back.disagreement(crooked) or "")
