"""A run's time series in one temporal VTKHDF file per kind, `vtk/{particles,bridges,walls}.vtkhdf`, by VTK's own writer.

For programs newer than Debian's ParaView 5.11, which reads no time series of this kind. VTK keeps times in single precision.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonDataModel import vtkDataObject
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline
from vtkmodules.vtkIOHDF import vtkHDFWriter

from pywet.errors import PywetError
from pywet.report import vtk
from pywet.runs.rundir import RunDir
from pywet.util.files import atomic_write

COMPRESSION = 4


class _Series(VTKPythonAlgorithmBase):  # type: ignore[misc]
    """One kind of file as a source that says its times and makes each output when it is asked for."""

    def __init__(self, run: RunDir, kind: str) -> None:
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType="vtkUnstructuredGrid")
        self.run, self.kind = run, kind
        self.failed: PywetError | None = None
        """Why an output could not be made: VTK shows an exception and goes on."""

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
    """Write the files of a run into its folder `vtk` and return them."""
    run = RunDir(Path(run_dir))
    _ = run.timeline  # refused here, not within VTK
    files = [run.path / "vtk" / f"{kind}.vtkhdf" for kind in vtk.KINDS]
    for kind, path in zip(vtk.KINDS, files, strict=True):
        series = _Series(run, kind)
        with atomic_write(path) as temporary:
            writer = vtkHDFWriter()
            writer.SetInputConnection(series.GetOutputPort())
            writer.SetFileName(str(temporary))
            writer.SetWriteAllTimeSteps(True)
            writer.SetCompressionLevel(COMPRESSION)
            try:
                vtk.run_writer(writer, path)
            finally:
                if series.failed:
                    raise series.failed
    return files
