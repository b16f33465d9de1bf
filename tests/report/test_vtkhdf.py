"""One temporal file per kind, read back by VTK's own reader: every array of every output as in the series."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyvista
from vtkmodules.vtkIOHDF import vtkHDFReader

from pywet.report import vtk, vtkhdf
from pywet.runs.rundir import RunDir
from tests.cases.screening import synthetic


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
