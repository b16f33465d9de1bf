"""VTK files of a run for ParaView: vtk/{particles,bridges,walls}.pvd, one time series each of VTK XML files (.vtu).

Particles are points with radius, class, film thickness, velocity and whether they are in the bin; bridges are lines
with their bodies, volume and separation; walls are triangles at their position at that time with their film
thickness. The field data explain the codes of classes, reservoirs and partners. Lengths in m, times in s.
`reference_impl/shown` reads them back.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet import run_folder
from pywet.errors import PywetError
from pywet.laws.contact import film_thickness
from pywet.report import active_bridges
from pywet.runs.rundir import Floats, RunDir, rows_at
from pywet.runs.walls import wall_corners
from pywet.schema import TABLES


def grid(shape: str, corners: int, points: Floats, of_points: Any = (), of_cells: Any = ()) -> Any:
    """Make cells of one of VTK's shapes, each of the next few points, with arrays by name for points or cells."""
    import pyvista as pv

    cells = {pv.CellType[shape]: np.arange(len(points)).reshape(-1, corners)}
    made = pv.UnstructuredGrid(cells, points) if len(points) else pv.UnstructuredGrid()
    made.points = points  # ParaView warns of files without points
    for name, values in dict(of_points).items():
        if len(values):
            made.point_data[name] = np.array(values)
        else:  # pyvista rejects empty arrays of vectors
            made.GetPointData().AddArray(pv.convert_array(values, name=name))
    made.cell_data.update(dict(of_cells))
    return made


def particles(run: RunDir, step: int) -> Any:
    """Return the spheres in the box at one output step as points."""
    line = run.timeline
    here = rows_at(run.trajectory, step)
    row = int(np.searchsorted(line.steps, step))
    index = np.searchsorted(line.ids, here["id"].to_numpy())
    radius = run.spheres["radius"].to_numpy(dtype=float)[index]
    data = {
        "id": here["id"].to_numpy(dtype=np.int32),
        "class": here["type"].to_numpy(dtype=np.int32),
        "radius": radius,
        "film_thickness": film_thickness(line.film[row, index], radius),
        "liquid": line.liquid[row, index],
        "velocity": here[["vx", "vy", "vz"]].to_numpy(dtype=float),
        "in_bin": line.passed[row, index].astype(np.int32),
    }
    return grid("VERTEX", 1, here[["x", "y", "z"]].to_numpy(dtype=float), data)


def bridges(run: RunDir, step: int) -> Any:
    """Return the active bridges at one output step as lines from centre to centre (wall: to the closest point)."""
    here = active_at(run, step)
    points = np.zeros((2 * len(here), 3))
    for k, end in enumerate(("xi", "xj")):
        points[k::2] = here[[f"{end}_{axis}" for axis in "xyz"]].to_numpy(dtype=float)
    return grid("LINE", 2, points, of_cells=of_bridges(run, step, here))


def cuboids(run: RunDir, step: int) -> Any:
    """Draw bridges as cuboids whose visible volume is that of the bridge (`cuboids.py`)."""
    here = active_at(run, step)
    return grid("HEXAHEDRON", 8, active_bridges.corners(run, here).reshape(-1, 3), of_cells=of_bridges(run, step, here))


def of_bridges(run: RunDir, step: int, here: pd.DataFrame) -> dict[str, Any]:
    """Return the fields of each bridge that is active at a step; none for a dry run."""
    if not run.moist:
        return {}
    return {
        **{name: here[name].to_numpy(dtype=float) for name in ("volume", "separation")},
        "capillary_force": active_bridges.capillary_force(run, here),
        "age": active_bridges.age(run, here, step),
        **{name: here[name].to_numpy(dtype=np.int32) for name in ("partner_kind", "i", "j")},
    }


def active_at(run: RunDir, step: int) -> pd.DataFrame:
    """Return the rows of the bridges active at one output step; none for a dry run."""
    return run.at_step("history/bridges", step) if run.moist else pd.DataFrame(columns=list(TABLES["history/bridges"]))


def wall_thickness(run: RunDir, step: int) -> Floats:
    """Return the film thickness of every triangle [m]: its film volume over its area."""
    film = np.zeros(len(run.triangles))
    if run.moist:
        wet = rows_at(run.wall_films, step)
        film[wet["triangle"].to_numpy(dtype=np.int64)] = wet["film"]
    return film / run.triangles["area"].to_numpy(dtype=float)


def walls(run: RunDir, step: int) -> Any:
    """Return all wall triangles at one output step; `reservoir` numbers the reservoirs in order of appearance."""
    corners = wall_corners(run, step)
    data = {
        "film_thickness": wall_thickness(run, step),
        "part": run.triangles["part"].to_numpy(dtype=np.int32),
        "reservoir": run.reservoirs[0].astype(np.int32),
    }
    return grid("TRIANGLE", 3, corners.reshape(-1, 3), of_cells=data)


def words(run: RunDir) -> dict[str, dict[str, list[str]]]:
    """List, for each kind of file, the names that the integer codes of its arrays stand for."""
    of_partners = {"partner_kind_from_0": ["sphere", "large wall", "wire"]}
    return {
        "particles": {
            "class_from_1": [c.name for c in run.scene.classes],
            "in_bin_from_0": ["on the screen", "in the bin"],
        },
        "bridges": of_partners,
        "cuboids": of_partners,
        "walls": {"reservoir_from_0": list(run.reservoirs[1])},
    }


SERIES = """<?xml version="1.0"?>
<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">
  <Collection>
{rows}
  </Collection>
</VTKFile>
"""
KINDS: dict[str, Callable[[RunDir, int], Any]] = {"particles": particles, "bridges": bridges, "walls": walls}


def output(run: RunDir, kind: str, step: int) -> Any:
    """Return the content of a file of one kind at one output step, at the positions of the user's scene."""
    made = {**KINDS, "cuboids": cuboids}[kind](run, step)
    made.points = made.points + run.origin_m
    for name, texts in words(run)[kind].items():
        made.field_data[name] = texts
    return made


def write(run_dir: Path, with_cuboids: bool = False) -> list[Path]:
    """Write the time series of a run again and return their .pvd files; files of other kinds in the folder are retained."""
    run = RunDir(Path(run_dir))
    folder, partial = run.path / "vtk", run.path / "vtk.partial"
    run_folder.refuse_foreign(run.path, folder.name)
    run_folder.make_folder(run.path, partial.name)
    kinds = [*KINDS, *["cuboids"] * with_cuboids]
    for kind in kinds:
        rows = []
        for step, time in zip(run.timeline.steps.tolist(), run.timeline.times.tolist(), strict=True):
            name = f"{kind}_{step:09d}.vtu"
            _save(output(run, kind, step), partial / name)
            rows.append(f'    <DataSet timestep="{time!r}" part="0" file="{name}"/>')
        (partial / f"{kind}.pvd").write_text(SERIES.format(rows="\n".join(rows)))
    run_folder.publish(run.path, partial.name, folder.name, rf"({'|'.join(kinds)})(_\d+\.vtu|\.pvd)")
    return [folder / f"{kind}.pvd" for kind in kinds]


def _save(made: Any, path: Path) -> None:
    """Write one file by VTK's own writer."""
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

    writer = vtkXMLUnstructuredGridWriter()
    writer.SetFileName(str(path))
    writer.SetInputData(made)
    writer.SetDataModeToBinary()
    writer.SetCompressionLevel(1)  # 2 % larger than by default, written in 0.6 of the time
    run_writer(writer, path)


def run_writer(writer: Any, path: Path) -> None:
    """Run a writer of VTK without the messages that it prints after a failure; `path`: the final name of the file."""
    talks = writer.GetGlobalWarningDisplay()
    writer.GlobalWarningDisplayOff()
    written = writer.Write() and not writer.GetErrorCode()
    writer.SetGlobalWarningDisplay(talks)
    if not written:
        raise unwritten(path)


def unwritten(path: Path) -> PywetError:
    """Make the error for a file that VTK could not write."""
    return PywetError(
        f"{path} cannot be written; expected free space on the disk and a folder that may be written to",
        code="vtk.unwritten", where=path,
    )  # fmt: skip
