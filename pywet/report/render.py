"""One picture of a run: spheres and walls coloured by film thickness, wires and bridges visible, side walls cut away.

VTK draws without a screen through EGL or OSMesa (Debian: libosmesa6). Without either, VTK ends the whole process; it
therefore draws in a child process, and if that fails, `sketch.py` draws a simpler picture with matplotlib.
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Generator
from pathlib import Path
from typing import Any

import numpy as np

from pywet.ending import die_with_parent
from pywet.errors import PywetError, arguments, border
from pywet.report import active_bridges, caption, sketch, vtk
from pywet.report.sketch import BACKGROUND, BRIDGE_COLOUR, METAL, blues, colour_limit, colour_ticks, frame
from pywet.runs.rundir import Floats, RunDir
from pywet.runs.walls import wall_corners
from pywet.schema import LARGE_WALL
from pywet.util.files import atomic_write

SIZE = (1500, 1250)
ANGLE = 35.0
"""View angle of the camera [deg], from top to bottom."""
VIEWED_FROM, AIM = np.array([0.7, -2.2, 0.85]), np.array([0.04, 0.0, 0.0])
"""Camera position and focal point, from the middle of the scene in units of its width: right, away, up."""
SOLID, HIDDEN = ("wires", "impact_plate"), ("feed_bin", "slide")
"""Reservoirs that are drawn solid and those that would hide the scene; the others are translucent."""
BAR = {
    "title": "film thickness in µm\n",
    "color": "#333333",
    "vertical": True,
    "height": 0.4,
    "width": 0.05,
    "position_x": 0.86,
    "position_y": 0.3,
}
LINE = 400.0
"""Width of a picture over the line width of the edges of bridges."""
WINDOWS: tuple[dict[str, str], ...] = ({"VTK_DEFAULT_OPENGL_WINDOW": "vtkOSOpenGLRenderWindow"}, {})
"""Environments to try in order: OSMesa, then VTK's default (a screen, EGL)."""

FACES = ((185, 196, 207), (214, 190, 150), (160, 200, 165), (212, 165, 180), (165, 165, 215), (205, 205, 140))
"""Colours of the faces of a wall of a user-defined scene, in order."""


def write(run_dir: Path, picture: Path, step: int | None = None) -> str:
    """Draw the run at an output step (default: `telling_step`) into a PNG; returns "vtk" or "matplotlib", whichever drew it."""
    run = RunDir(Path(run_dir))
    chosen = output_step(run, step)
    with atomic_write(Path(picture)) as temporary:
        try:
            list(in_child("pywet.report.render", str(run.path), str(temporary), str(chosen)))
        except PywetError:
            sketch.draw(run, chosen, temporary)
            return "matplotlib"
    return "vtk"


def output_step(run: RunDir, step: int | None) -> int:
    """Return the requested output step; None: the one with the most to show."""
    chosen = telling_step(run) if step is None else step
    if chosen not in run.timeline.steps:
        raise PywetError(
            f"step {chosen} is not an output step of {run.path}; expected one of those in trajectory.parquet"
        )
    return chosen


def in_child(module: str, *arguments: str) -> Generator[str, None, None]:
    """Draw with VTK in a child process, by a module called with these arguments; yields the lines that it prints.

    Raises `PywetError` with its final message, or if VTK cannot draw.
    """
    command, message = [sys.executable, "-P", "-m", module, *arguments], ""
    for extra in WINDOWS:
        environment = {**os.environ, **extra}
        with (
            tempfile.TemporaryFile("w+") as messages,
            subprocess.Popen(
                command,
                env=environment,
                stdout=subprocess.PIPE,
                stderr=messages,
                text=True,
                preexec_fn=die_with_parent,
            ) as child,
        ):
            assert child.stdout is not None
            try:
                yield from child.stdout
                child.wait()
            except BaseException:
                child.kill()
                raise
            messages.seek(0)
            message = messages.read()
        if child.returncode == 0:
            return
        if child.returncode == 1:  # a sentence of `border`: no other way of drawing would do
            raise PywetError(message.strip().splitlines()[-1] if message.strip() else f"{module} ended without a word")
    raise PywetError(f"VTK cannot draw on this machine ({message.strip()[-200:]}); install libosmesa6")


def telling_step(run: RunDir) -> int:
    """Return the output step at which a third of all passing spheres has passed; without passage, the last with spheres."""
    line = run.timeline
    passed = line.passed.sum(axis=1)
    if not passed[-1]:
        return int(line.steps[max(np.flatnonzero(line.present.any(axis=1)), default=-1)])
    return int(line.steps[int(np.argmax(passed >= passed[-1] / 3.0))])


def draw(run: RunDir, step: int, picture: Path) -> None:
    """Draw with VTK in this process: the scene, with a caption below it."""
    image, mm = scene(run, step, view(run, step), colour_limit(run, step), SIZE)
    caption.save(caption.below(image, caption.entries(run), caption.sentence(run, step), mm), picture)


def scene(
    run: RunDir, step: int, seen: tuple[Floats, float], limit: float, size: tuple[int, int], fine: bool = True
) -> tuple[Any, float]:
    """Return the scene as pixels (rows, columns, 3), and their number per millimetre at its middle; `seen`: middle, width [m]."""
    drawn = plotter(size)
    centre, width = seen
    _add_spheres(drawn, run, step, limit, 40 if fine else 16, size[0] // 56)
    _add_bridges(drawn, run, step, centre, max(2.0, size[0] / LINE))
    _add_walls(drawn, run, step, centre)
    if fine:
        drawn.enable_ssao(radius=0.08 * width, kernel_size=64)
        drawn.enable_anti_aliasing("ssaa")
    return pixels(drawn, run, centre, width, size)


def plotter(size: tuple[int, int]) -> Any:
    """Return the plotter to which bodies are added."""
    import pyvista as pv

    pv.OFF_SCREEN = True
    made: Any = pv.Plotter(off_screen=True, window_size=list(size), lighting="three lights")
    made.set_background(BACKGROUND)
    return made


def pixels(plotter: Any, run: RunDir, centre: Floats, width: float, size: tuple[int, int]) -> tuple[Any, float]:
    """Return the plotter's picture from the usual direction, and the number of pixels per millimetre in the middle."""
    _, place, aim, up = camera(run, centre, width)
    plotter.camera_position = [tuple(place), tuple(aim), tuple(up)]
    plotter.camera.view_angle = ANGLE
    image = plotter.screenshot(return_img=True)
    plotter.close()
    per_metre = size[1] / 2.0 / np.tan(np.radians(ANGLE / 2.0)) / float(np.linalg.norm(place - centre))
    return image, 1e-3 * per_metre


def camera(run: RunDir, centre: Floats, width: float) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the middle of the scene, the camera's position, its focal point, and the upward direction [m]."""
    turned = frame(run).T
    return centre, centre + width * turned @ VIEWED_FROM, centre + width * turned @ AIM, turned @ [0.0, 0.0, 1.0]


def view(run: RunDir, step: int) -> tuple[Floats, float]:
    """Return middle and size [m] of the region of interest: screen, bed, impact plate and fines, or a whole drum."""
    turning = [wall.name for wall in run.scene.walls if wall.motion == "turns"]
    here = run.trajectory[run.trajectory["step"] == step]
    shown = (run.triangles["holder"].isin(SOLID) | run.triangles["mesh"].isin(turning)).to_numpy()
    corners = wall_corners(run, step)[shown]
    points = corners.reshape(-1, 3) if len(corners) else here[["x", "y", "z"]].to_numpy(dtype=float)
    low, high = points.min(axis=0), points.max(axis=0)
    if len(here):
        few, most = here["z"].quantile([0.02, 0.98])
        low[2], high[2] = min(low[2], few), max(high[2], most)
    return np.asarray((low + high) / 2.0), float((high - low).max())


def _add_spheres(plotter: Any, run: RunDir, step: int, limit: float, facets: int, letters: int) -> None:
    import pyvista as pv

    mesh = vtk.particles(run, step)
    if not mesh.n_points:
        return
    cloud = pv.PolyData(mesh.points)
    cloud["diameter"] = 2.0 * mesh.point_data["radius"]
    cloud["film thickness in µm"] = 1e6 * mesh.point_data["film_thickness"]
    ball = pv.Sphere(radius=0.5, theta_resolution=facets, phi_resolution=facets)
    glyphs = cloud.glyph(scale="diameter", geom=ball, orient=False)
    look: dict[str, Any] = {"smooth_shading": True, "specular": 0.35, "specular_power": 20}
    if run.moist:
        name = "film thickness in µm"
        ticks = colour_ticks(1e6 * limit)
        bar = {**BAR, "n_labels": len(ticks), "fmt": f"%.{places(ticks[1])}f"}
        bar |= {"title_font_size": letters, "label_font_size": letters, "unconstrained_font_size": True}
        plotter.add_mesh(glyphs, scalars=name, cmap=blues(), clim=(0.0, 1e6 * limit), scalar_bar_args=bar, **look)
    else:
        plotter.add_mesh(glyphs, color="#d9d3c7", **look)


def places(step: float) -> int:
    """Decimal places of ticks that are so far apart.

    >>> places(20.0), places(0.5)
    (0, 1)
    """
    return max(0, -math.floor(math.log10(step) + 1e-9))


def _add_bridges(plotter: Any, run: RunDir, step: int, centre: Floats, line: float) -> None:
    """Draw bridges as cuboids whose visible volume is the bridge's.

    Their edges have a fixed width in pixels, so that a bridge is visible in a large bed too. Bridges to cut-away
    walls are omitted.
    """
    here = vtk.active_at(run, step)
    place = here[["xj_x", "xj_y", "xj_z"]].to_numpy(dtype=float) - centre
    here = here[(here["partner_kind"] != LARGE_WALL) | (place @ frame(run)[1] > 0.0)]
    if len(here):
        boxes = vtk.grid("HEXAHEDRON", 8, active_bridges.corners(run, here).reshape(-1, 3))
        plotter.add_mesh(boxes, color=BRIDGE_COLOUR, ambient=0.5)
        plotter.add_mesh(boxes.extract_all_edges(), color=BRIDGE_COLOUR, line_width=line, lighting=False)


def _add_walls(plotter: Any, run: RunDir, step: int, centre: Floats) -> None:
    """Draw wires and impact plate solid, every other wall translucent and only its far half."""
    reservoirs = run.triangles["holder"]
    whole = vtk.walls(run, step)
    for reservoir in reservoirs.unique():
        chosen = (reservoirs == reservoir).to_numpy(dtype=bool)
        part = whole.extract_cells(chosen).extract_surface(algorithm="dataset_surface")
        if reservoir in SOLID:
            plotter.add_mesh(
                part, color=METAL, specular=0.6, specular_power=15, split_sharp_edges=True, smooth_shading=True
            )
        elif reservoir not in HIDDEN:
            away = frame(run)[1]
            far = part.clip(normal=tuple(-away), origin=tuple(centre - 1e-4 * away))
            if far.n_cells:
                far.cell_data["colour"] = np.array(FACES, dtype=np.uint8)[far.cell_data["part"] % len(FACES)]
                look: dict[str, Any] = (
                    {"scalars": "colour", "rgb": True} if reservoir == "wall" else {"color": "#b9c4cf"}
                )
                plotter.add_mesh(far, opacity=0.35, **look)
                plotter.add_mesh(far.extract_feature_edges(25.0), color="#7d8994", line_width=2)


if __name__ == "__main__":
    with border():
        run_dir, out, step = arguments(RUN_DIR=Path, OUT=Path, STEP=int)
        draw(RunDir(run_dir), step, out)
