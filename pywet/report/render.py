"""One picture of a run: spheres and walls coloured by film thickness, wires and bridges visible, side walls cut away.

VTK draws without a screen through EGL or OSMesa (Debian: libosmesa6). Where neither exists VTK ends the whole process, so it
draws in a child process; when that fails, `sketch.py` draws a plainer picture with matplotlib instead.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from pywet.errors import PywetError
from pywet.files import atomic_write
from pywet.report import sketch, vtk
from pywet.report.sketch import BACKGROUND, BRIDGE_COLOUR, blues, colour_limit
from pywet.runs.rundir import Floats, RunDir
from pywet.schema import LARGE_WALL

SIZE = (1500, 1250)
METAL = "#9aa3ab"
WIDEST_BRIDGE = 0.4
"""Radius of the thickest tube over that of the smallest sphere: wide enough to show around the point of contact."""
BAR = {
    "title": "film thickness in µm\n",
    "color": "#333333",
    "n_labels": 4,
    "fmt": "%.0f",
    "vertical": True,
    "height": 0.4,
    "width": 0.05,
    "position_x": 0.86,
    "position_y": 0.3,
}
WINDOWS: tuple[dict[str, str], ...] = ({"VTK_DEFAULT_OPENGL_WINDOW": "vtkOSOpenGLRenderWindow"}, {})
"""Environments to try in turn: OSMesa, then what VTK finds by itself (a screen, EGL)."""


def write(run_dir: Path, picture: Path, step: int | None = None) -> str:
    """Draw the run at an output step (default: `telling_step`) into a PNG; returns "vtk" or "matplotlib", whichever drew it."""
    run = RunDir(Path(run_dir))
    chosen = telling_step(run) if step is None else step
    if chosen not in run.timeline.steps:
        raise PywetError(
            f"step {chosen} is not an output step of {run.path}; expected one of those in trajectory.parquet"
        )
    with atomic_write(Path(picture)) as temporary:
        for extra in WINDOWS:
            command = [sys.executable, "-P", "-m", "pywet.report.render", str(run.path), str(temporary), str(chosen)]
            environment = {**os.environ, **extra}
            drawn = subprocess.run(command, env=environment, capture_output=True, check=False)
            if drawn.returncode == 0 and temporary.exists():
                return "vtk"
        sketch.draw(run, chosen, temporary)
    return "matplotlib"


def telling_step(run: RunDir) -> int:
    """The output step at which about a third of what passes in the whole run has passed; without passage, the last."""
    line = run.timeline
    passed = line.passed.sum(axis=1)
    if not passed[-1]:
        return int(line.steps[-1])
    return int(line.steps[int(np.argmax(passed >= passed[-1] / 3.0))])


def draw(run: RunDir, step: int, picture: Path) -> None:
    """Draw with VTK in this process."""
    import pyvista as pv

    pv.OFF_SCREEN = True
    plotter: Any = pv.Plotter(off_screen=True, window_size=list(SIZE), lighting="three lights")
    plotter.set_background(BACKGROUND)
    centre, width = _view(run, step)
    limit = colour_limit(run, step)
    _add_spheres(plotter, run, step, limit)
    _add_bridges(plotter, run, step, centre)
    _add_walls(plotter, run, step, centre, limit)
    plotter.enable_ssao(radius=0.08 * width, kernel_size=64)
    plotter.enable_anti_aliasing("ssaa")
    away = np.array([0.7, -2.2, 0.85]) * width
    aim = np.array([0.04, 0.0, 0.0]) * width
    plotter.camera_position = [tuple(centre + away), tuple(centre + aim), (0.0, 0.0, 1.0)]
    plotter.camera.view_angle = 35.0
    plotter.screenshot(str(picture))
    plotter.close()


def _view(run: RunDir, step: int) -> tuple[Floats, float]:
    """Middle and size [m] of what is worth seeing: the screen, the bed on it and the impact plate below."""
    here = run.trajectory[run.trajectory["step"] == step]
    corners = vtk.wall_corners(run, step)[run.triangles["holder"].isin(["wires", "impact_plate"]).to_numpy()]
    above = here.loc[here["z"] > run.scene.screen_z_m, "z"]
    points = corners.reshape(-1, 3) if len(corners) else here[["x", "y", "z"]].to_numpy(dtype=float)
    low, high = points.min(axis=0), points.max(axis=0)
    if len(above):
        high[2] = max(high[2], float(above.quantile(0.95)))
    return np.asarray((low + high) / 2.0), float((high - low).max())


def _add_spheres(plotter: Any, run: RunDir, step: int, limit: float) -> None:
    import pyvista as pv

    mesh = vtk.particles(run, step)
    cloud = pv.PolyData(mesh.points)
    cloud["diameter"] = 2.0 * mesh.point_data["radius"]
    cloud["film thickness in µm"] = 1e6 * mesh.point_data["film_thickness"]
    ball = pv.Sphere(radius=0.5, theta_resolution=40, phi_resolution=40)
    glyphs = cloud.glyph(scale="diameter", geom=ball, orient=False)
    look: dict[str, Any] = {"smooth_shading": True, "specular": 0.35, "specular_power": 20}
    if run.moist:
        name = "film thickness in µm"
        plotter.add_mesh(glyphs, scalars=name, cmap=blues(), clim=(0.0, 1e6 * limit), scalar_bar_args=BAR, **look)
    else:
        plotter.add_mesh(glyphs, color="#d9d3c7", **look)


def _add_bridges(plotter: Any, run: RunDir, step: int, centre: Floats) -> None:
    """Bridges as straight tubes whose cross-section grows with the bridge's volume; those to cut-away walls are left out."""
    import pyvista as pv

    mesh = vtk.bridges(run, step)
    if not len(mesh.points):
        return
    volume, kind = (np.asarray(mesh.cell_data[name][0]) for name in ("volume", "partner_kind"))
    ends = mesh.points.reshape(-1, 2, 3)
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    shown = (length > 0) & ((kind != LARGE_WALL) | (ends[:, 1, 1] > centre[1]))
    widest = WIDEST_BRIDGE * float(run.spheres["radius"].min())
    radius = widest * np.clip(np.cbrt(volume / volume.max()), 0.5, 1.0)
    tubes = [
        pv.Cylinder(center=(a + b) / 2.0, direction=b - a, radius=r, height=h, resolution=14)
        for (a, b), r, h in zip(ends[shown], radius[shown], length[shown], strict=True)
    ]
    if tubes:
        plotter.add_mesh(pv.merge(tubes), color=BRIDGE_COLOUR, smooth_shading=True, split_sharp_edges=True)


def _add_walls(plotter: Any, run: RunDir, step: int, centre: Floats, limit: float) -> None:
    """Wires and impact plate solid, every other wall translucent and only its far half."""
    import pyvista as pv

    mesh = vtk.walls(run, step)
    table = run.triangles
    faces = np.insert(np.arange(len(mesh.points)).reshape(-1, 3), 0, 3, axis=1)
    whole = pv.PolyData(mesh.points, faces.ravel())
    for holder in table["holder"].unique():
        chosen = (table["holder"] == holder).to_numpy(dtype=bool)
        part = whole.extract_cells(chosen).extract_surface(algorithm="dataset_surface")
        if holder in ("wires", "impact_plate"):
            plotter.add_mesh(
                part, color=METAL, specular=0.6, specular_power=15, split_sharp_edges=True, smooth_shading=True
            )
        elif holder not in ("feed_bin", "slide"):
            far = part.clip(normal=(0.0, -1.0, 0.0), origin=tuple(centre - [0.0, 1e-4, 0.0]))
            if far.n_cells:
                plotter.add_mesh(far, color="#b9c4cf", opacity=0.35)
                plotter.add_mesh(far.extract_feature_edges(25.0), color="#7d8994", line_width=2)


if __name__ == "__main__":
    draw(RunDir(Path(sys.argv[1])), int(sys.argv[3]), Path(sys.argv[2]))
