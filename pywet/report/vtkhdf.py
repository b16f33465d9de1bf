"""A run's time series in one temporal VTKHDF file per kind, `vtk/{particles,bridges,walls}.vtkhdf`, by VTK's own writer.

They are for programs newer than Debian's ParaView 5.11, which does not read such time series. VTK stores times in
single precision.
"""

from __future__ import annotations

import os
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonDataModel import vtkDataObject
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline
from vtkmodules.vtkIOHDF import vtkHDFWriter

from pywet.errors import PywetError, arguments, border
from pywet.report import render, vtk
from pywet.runs.rundir import RunDir
from pywet.util.files import atomic_write

COMPRESSION = 4


class _Series(VTKPythonAlgorithmBase):  # type: ignore[misc]
    """One kind of file as a source that reports its times and makes each output on request."""

    def __init__(self, run: RunDir, kind: str) -> None:
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType="vtkUnstructuredGrid")
        self.run, self.kind = run, kind
        self.failed: PywetError | None = None
        """Error of an output, stored because VTK prints an exception and continues."""

    def RequestInformation(self, request: Any, inputs: Any, outputs: Any) -> int:
        times = self.run.timeline.times.tolist()
        outputs.GetInformationObject(0).Set(Pipeline.TIME_STEPS(), times, len(times))
        outputs.GetInformationObject(0).Set(Pipeline.TIME_RANGE(), [times[0], times[-1]], 2)
        return 1

    def RequestData(self, request: Any, inputs: Any, outputs: Any) -> int:
        asked, line = outputs.GetInformationObject(0), self.run.timeline
        time = asked.Get(Pipeline.UPDATE_TIME_STEP()) if asked.Has(Pipeline.UPDATE_TIME_STEP()) else 0.0
        step = int(line.steps[np.abs(line.times - time).argmin()])
        try:
            asked.Get(vtkDataObject.DATA_OBJECT()).ShallowCopy(vtk.output(self.run, self.kind, step))
        except PywetError as error:
            self.failed = error
        return int(self.failed is None)


def write(run_dir: Path) -> list[Path]:
    """Write the files of a run into its folder `vtk` and return them.

    On a full disk VTK retries forever and prints many messages: it therefore writes in a child process, which is
    ended at its first message.
    """
    run = RunDir(Path(run_dir))
    _ = run.timeline  # checked here, not within VTK
    files = [run.path / "vtk" / f"{kind}.vtkhdf" for kind in vtk.KINDS]
    for kind, path in zip(vtk.KINDS, files, strict=True):
        with atomic_write(path) as temporary:
            message = render.in_child("pywet.report.vtkhdf", str(run.path), kind, str(temporary))
            with closing(message):
                for line in message:
                    raise (
                        vtk.unwritten(path)
                        if line.startswith("HDF5")
                        else PywetError(line.strip(), code="vtkhdf.refused", where=path)
                    )
    return files


def draw(run: RunDir, kind: str, path: Path) -> None:
    """Write one of the files in this process."""
    series, writer = _Series(run, kind), vtkHDFWriter()
    writer.SetInputConnection(series.GetOutputPort())
    writer.SetFileName(str(path))
    writer.SetWriteAllTimeSteps(True)
    writer.SetCompressionLevel(COMPRESSION)
    try:
        vtk.run_writer(writer, path)
    finally:
        if series.failed:
            raise series.failed


if __name__ == "__main__":
    os.dup2(1, 2)  # HDF5 prints its own error
    with border():
        run_dir, kind, out = arguments(RUN_DIR=Path, KIND=str, OUT=Path)
        draw(RunDir(run_dir), kind, out)
