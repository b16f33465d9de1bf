"""Compare the VTKHDF files of a run, read by VTK's own reader, with the raw logs, like the series (vtk.py)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from reference_impl.replay.arrays import Floats
from reference_impl.replay.io import ReplayError
from reference_impl.shown import vtk, vtu

AGAIN = "write it again: pywet view --vtkhdf"
SINGLE = 1e-7
"""Limit of a time: the files have times in single precision."""


def disagreement(folder: Path) -> str | None:
    """Describe in one sentence where the files disagree with the logs; None if all agree."""
    wrong, findings = vtk.compared(Path(folder), lambda kind: outputs(Path(folder) / "vtk" / f"{kind}.vtkhdf"), SINGLE)
    return f"{folder / 'vtk'}/*.vtkhdf disagrees with the logs on {wrong}: {findings}" if wrong else None


def outputs(path: Path) -> Sequence[tuple[float, vtu.Shown]]:
    """Return time [s] and content of each output of a file."""
    from vtkmodules.vtkIOHDF import vtkHDFReader

    reader = vtkHDFReader()
    if not path.is_file() or not reader.CanReadFile(str(path)):
        raise ReplayError(f"{path} is no VTKHDF file; {AGAIN}")
    reader.SetFileName(str(path))
    found = []
    for k in range(_updated(reader).GetNumberOfSteps()):
        reader.SetStep(k)
        grid = _updated(reader).GetOutput()
        if not grid.GetFieldData().HasArray("Time"):
            raise ReplayError(f"{path} has no time at output {k}; {AGAIN}")
        found.append((float(grid.GetFieldData().GetArray("Time").GetValue(0)), _shown(grid)))
    return found


def _updated(reader: Any) -> Any:
    reader.Update()
    return reader


def _shown(grid: Any) -> vtu.Shown:
    fields, count = grid.GetFieldData(), grid.GetNumberOfCells()
    words = {}
    for n in range(fields.GetNumberOfArrays()):
        texts = fields.GetAbstractArray(n)
        if texts.IsA("vtkStringArray"):
            words[texts.GetName()] = [str(texts.GetValue(k)) for k in range(texts.GetNumberOfValues())]
    if not count:
        return vtu.Shown(np.zeros((0, 3)), np.zeros((0, 0), int), {}, {}, words)
    cells = _numbers(grid.GetCells().GetConnectivityArray())
    return vtu.Shown(
        _numbers(grid.GetPoints().GetData()), cells.reshape(count, -1), _arrays(grid.GetPointData()),
        _arrays(grid.GetCellData()), words,
    )  # fmt: skip


def _arrays(data: Any) -> dict[str, Floats]:
    several = (data.GetArray(n) for n in range(data.GetNumberOfArrays()))
    return {array.GetName(): _numbers(array) for array in several if array is not None}


def _numbers(array: Any) -> Floats:
    from vtkmodules.util.numpy_support import vtk_to_numpy

    return np.asarray(vtk_to_numpy(array))
