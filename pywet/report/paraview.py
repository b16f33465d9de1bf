"""Write `vtk/open_in_paraview.py` of a run, a script for ParaView's Python.

The script is `open_in_paraview.py` next to this file; here its first value, SHOWN, is filled in. pywet does not run
it.
"""

from __future__ import annotations

import csv
import pprint
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from pywet.report import render, vtk
from pywet.report.pictures import colours
from pywet.report.plots import CONFIGURATION, PLACES
from pywet.report.sketch import METALS, colour_limit
from pywet.runs.rundir import RunDir
from pywet.util.files import atomic_write

SCRIPT = Path(__file__).with_name("open_in_paraview.py")
CHARTS: tuple[tuple[str, str, str, Callable[[str], bool]], ...] = (
    (
        "fraction_retained",
        "fraction retained",
        "BottomLeft",
        lambda name: name.startswith("fraction_retained") and name != "fraction_retained_spheres",
    ),
    ("liquid_by_holder", "liquid in m³", "TopRight", lambda name: name.removesuffix("_m3") in PLACES),
    ("liquid_by_wall", "liquid in m³", "TopRight", lambda name: name.endswith("_m3")),
)
"""Table of results, title, position of the legend, selection of columns."""
EMPTY = "SHOWN: dict[str, Any] = {}"


def write(run_dir: Path) -> Path:
    """Write the script into the run's folder `vtk`, in which the time series are, and return it."""
    run = RunDir(Path(run_dir))
    path = run.path / "vtk" / SCRIPT.name
    reported = f"SHOWN: dict[str, Any] = {pprint.pformat(shown(run), width=110, sort_dicts=False)}"
    with atomic_write(path) as temporary:
        temporary.write_text(SCRIPT.read_text().replace(EMPTY, reported))
    return path


def shown(run: RunDir) -> dict[str, Any]:
    """Return the data of a run that the script needs: colours, walls, camera, initial time, curves."""
    step = render.telling_step(run)
    centre, away, aim, up = (v.tolist() for v in render.camera(run, *render.view(run, step)))
    reservoirs = vtk.words(run)["walls"]["reservoir_from_0"] if run.scene.walls else []
    return {
        "name": run.scene.name,
        "folder": str((run.path / "vtk").resolve()),
        "moist": run.moist,
        "thickest_um": 1e6 * colour_limit(run, step),
        "walls": {name: {"code": k, "opacity": opacity(name)} for k, name in enumerate(reservoirs)},
        "camera": {"position": away, "aim": aim, "up": up, "angle": render.ANGLE, "turn_about": centre},
        "time": float(run.timeline.times[np.searchsorted(run.timeline.steps, step)]),
        "charts": charts(run),
    }


def opacity(reservoir: str) -> float:
    """Return the initial opacity of a wall; 0 for a wall that would hide the scene."""
    if reservoir in METALS:
        return 1.0
    return 0.0 if reservoir in render.HIDDEN else 0.15


def charts(run: RunDir) -> list[dict[str, Any]]:
    """Return a run's available curves: title, relative file, column of the time, label and colour by column."""
    made = []
    for name, title, legend, chosen in CHARTS:
        path = run.path / "results" / f"{name}.csv"
        if path.exists():
            with path.open() as file:
                columns = [column for column in next(csv.reader(file)) if chosen(column)]
            names = [column.removesuffix("_m3") for column in columns]
            of = colours(len(names), CONFIGURATION)
            looks = [PLACES.get(n, (n.replace("_", " "), c)) for n, c in zip(names, of, strict=True)]
            made.append({"title": title, "file": f"../results/{path.name}", "time": "time_s", "legend": legend,
                         "curves": dict(zip(columns, looks, strict=True))})  # fmt: skip
    return made
