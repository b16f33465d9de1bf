"""Write a run for OVITO: `ovito/spheres.dump` (LAMMPS' text dump) and `ovito/bridges.dump` (dump local).

Each file contains all outputs. In OVITO load spheres.dump and add the modification "Load trajectory" with
bridges.dump, whose columns become bonds. Only bridges between spheres are included, because a bond of OVITO has a
particle at both ends. Lengths in m, speeds in m/s, volumes in m³, forces in N, ages in s; nan: not known.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from pywet.report import vtk
from pywet.runs.rundir import RunDir
from pywet.schema import SPHERE
from pywet.util.files import atomic_write

SPHERES = {"id": "id", "class": "type", "radius": "radius", "film_thickness": "film_thickness", "liquid": "liquid",
           "in_bin": "in_bin"}  # fmt: skip
"""Field of the VTK file -> column of the dump, in addition to position and velocity."""
BRIDGES = ["volume", "separation", "capillary_force", "age"]


def write(run_dir: Path) -> list[Path]:
    """Write both files into the run's folder `ovito` and return them."""
    run = RunDir(Path(run_dir))
    folder, corners = run.path / "ovito", np.array([run.scene.box_low_m, run.scene.box_high_m]) + run.origin_m
    box = "ITEM: BOX BOUNDS ff ff ff\n" + "".join(f"{low:.12g} {high:.12g}\n" for low, high in corners.T)
    folder.mkdir(exist_ok=True)
    made = {folder / "spheres.dump": (spheres, "ATOMS")}
    if run.moist:
        made[folder / "bridges.dump"] = (bridges, "ENTRIES")
    for path, (maker, rows) in made.items():
        with atomic_write(path) as temporary, temporary.open("w") as file:
            for step in run.timeline.steps.tolist():
                table = maker(run, step)
                file.write(f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF {rows}\n{len(table)}\n{box}")
                file.write(f"ITEM: {rows} {' '.join(table.columns)}\n")
                table.to_csv(file, sep=" ", header=False, index=False, float_format="%.12g", na_rep="nan")
    return list(made)


def spheres(run: RunDir, step: int) -> pd.DataFrame:
    """Return the spheres in the box at one output step, a column for each quantity."""
    mesh = vtk.particles(run, step)
    table = pd.DataFrame({column: mesh.point_data[field] for field, column in SPHERES.items()})
    return table.assign(**dict(zip("xyz", (mesh.points + run.origin_m).T, strict=True)),
                        **dict(zip(("vx", "vy", "vz"), mesh.point_data["velocity"].T, strict=True)))  # fmt: skip


def bridges(run: RunDir, step: int) -> pd.DataFrame:
    """Return the bridges between spheres at one output step."""
    data = vtk.bridges(run, step).cell_data
    pairs = data["partner_kind"] == SPHERE
    columns = {"id1": data["i"], "id2": data["j"], **{name: data[name] for name in BRIDGES}}
    return pd.DataFrame({name: values[pairs] for name, values in columns.items()})
