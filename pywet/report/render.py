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
from pywet.errors import PywetError, arguments, border, child_data
from pywet.report import active_bridges, caption, sketch, vtk
from pywet.report.sketch import BACKGROUND, BRIDGE_COLOUR, METAL, blues, colour_limit, colour_ticks, frame, solid
from pywet.runs.rundir import Floats, RunDir
from pywet.runs.walls import wall_corners
from pywet.schema import LARGE_WALL
from pywet.util.files import atomic_write

SIZE = (1500, 1250)
ANGLE = 35.0
"""View angle of the camera [deg], from top to bottom."""
VIEWED_FROM, AIM = np.array([0.7, -2.2, 0.85]), np.array([0.04, 0.0, 0.0])
"""Of the camera, from the middle of the scene in widths of it: right, away, up."""
HIDDEN = ("feed_bin", "slide")
"""Reservoirs that would hide the scene and are left out."""
BAR = {
    "title": "film in µm\n",
    "color": "#333333",
    "vertical": True,
    "height": 0.4,
    "width": 0.05,
    "position_x": 0.9,
    "position_y": 0.3,
}
MARGIN, BESIDE_BAR = 0.03, 0.87
"""Shares of a picture: empty at its edges, and of the width up to which bodies are drawn where there is a colour bar."""
CORE = (0.03, 0.97)
"""Quantiles of the positions along each direction between which a sphere counts for what is framed."""
AROUND = 1.0
"""Distance from the screen, over its width, up to which a sphere is framed."""
NEAR = 1.6
"""Size of all that is framed over that of the spheres, up to which a translucent wall of a user-defined scene is framed too."""
FITTED, SLOWLY, CLOSEST = 60, 0.8, 0.05
"""Steps in which the camera is moved until all that is framed fits, least factor of a step, and least depth over the width."""
LINE = 400.0
"""Width of a picture over the line width of the edges of bridges."""
WINDOWS: tuple[dict[str, str], ...] = ({"VTK_DEFAULT_OPENGL_WINDOW": "vtkOSOpenGLRenderWindow"}, {})
"""Environments to try in order: OSMesa, then VTK's default (a screen, EGL)."""

FACES = ((185, 196, 207), (214, 190, 150), (160, 200, 165), (212, 165, 180), (165, 165, 215), (205, 205, 140))
"""Colours of the faces of a wall of a user-defined scene, in order."""


def name(step: int | None = None) -> str:
    """Return the name of the picture of a run, which its pages show, or of the one at a requested step."""
    return "picture.png" if step is None else f"picture_{step}.png"


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
            f"step {chosen} is not an output step of {run.path}; expected one of those in trajectory.parquet",
            code="render.step", given=chosen, where=run.path,
        )  # fmt: skip
    return chosen


def in_child(module: str, *arguments: str) -> Generator[str, None, None]:
    """Draw with VTK in a child process, by a module called with these arguments; yields the lines that it prints.

    Raises `PywetError` with its final message, or if VTK cannot draw.
    """
    command, message = [sys.executable, "-P", "-m", module, *arguments], ""
    for extra in WINDOWS:
        with (
            tempfile.TemporaryFile("w+") as messages,
            child_data() as (named, data_of),
            subprocess.Popen(
                command,
                env={**os.environ, **extra, **named},
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
            message, data = messages.read(), data_of() or {"code": "render.ended"}
        if child.returncode == 0:
            return
        if child.returncode == 1:  # a message of `border`: another renderer would not help
            sentence = message.strip().splitlines()[-1] if message.strip() else f"{module} ended without a word"
            raise PywetError(sentence, **data)
    raise PywetError(
        f"VTK cannot draw on this machine ({message.strip()[-200:]}); install libosmesa6", code="render.vtk"
    )


def telling_step(run: RunDir) -> int:
    """The output step at which a third of what passes or leaves has done so; if nothing does, the last with spheres."""
    line = run.timeline
    passed = (line.passed | (line.entered & ~line.present)).sum(axis=1)
    last = int(max(np.flatnonzero(line.present.any(axis=1)), default=len(passed) - 1))
    if not passed[-1]:
        return int(line.steps[last])
    return int(line.steps[min(int(np.argmax(passed >= passed[-1] / 3.0)), last)])


def draw(run: RunDir, step: int, picture: Path) -> None:
    """Draw with VTK in this process: the scene, with a caption below it."""
    image, mm = scene(run, step, view(run, step), colour_limit(run, step), SIZE)
    caption.save(caption.below(trimmed(image), caption.entries(run), caption.sentence(run, step), mm), picture)


def trimmed(image: Any) -> Any:
    """Return the picture without its empty rows above and below, but for a margin."""
    rows = np.flatnonzero((np.abs(image[..., :3].astype(int) - image[0, 0, :3]) > 8).any(axis=(1, 2)))
    edge = round(MARGIN * len(image))
    return image[max(0, rows[0] - edge) : rows[-1] + edge + 1] if len(rows) else image


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


def view(run: RunDir, step: int, size: tuple[int, int] = SIZE) -> tuple[Floats, float]:
    """Middle and width [m] of what is worth seeing, such that it fills a picture of a size [pixels] but for a margin."""
    axes = frame(run)
    points = _worth_seeing(run, step) @ axes.T
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    width = max(float(np.ptp(points, axis=0).max()), 1e-9)
    half = math.tan(math.radians(ANGLE / 2.0)) * np.array([size[0] / size[1], 1.0])
    look = (AIM - VIEWED_FROM) / np.linalg.norm(AIM - VIEWED_FROM)
    right = np.cross(look, [0.0, 0.0, 1.0]) / np.hypot(*look[:2])
    onto = np.stack([right, np.cross(right, look)])
    target = np.array([[MARGIN, BESIDE_BAR if run.moist else 1.0 - MARGIN], [MARGIN, 1.0 - MARGIN]])
    for _ in range(FITTED):
        seen = points - middle - width * VIEWED_FROM
        depth = seen @ look
        if depth.min() < CLOSEST * width:
            width /= SLOWLY
            continue
        on_picture = 0.5 + 0.5 * (seen @ onto.T) / depth[:, None] / half
        low, high = on_picture.min(axis=0), on_picture.max(axis=0)
        off = 2.0 * half * ((low + high) / 2.0 - target.mean(axis=1)) * width * np.linalg.norm(AIM - VIEWED_FROM)
        middle[[0, 2]] += off / (onto[0, 0], onto[1, 2])
        width *= max(SLOWLY, float(((high - low) / np.ptp(target, axis=1)).max()))
    return middle @ axes, width


def _worth_seeing(run: RunDir, step: int) -> Floats:
    """Return corners of the screen or drum and the spheres around it; without these of all spheres and the walls around them."""
    axes, table = frame(run), run.triangles
    turning = [wall.name for wall in run.scene.walls if wall.motion == "turns"]
    corners, framed = wall_corners(run, step), solid(run) | table["mesh"].isin(turning).to_numpy()
    points = corners[framed].reshape(-1, 3)
    spheres = run.trajectory[run.trajectory["step"] == step][["x", "y", "z"]].to_numpy(dtype=float)
    if len(spheres):
        turned = spheres @ axes.T
        low, high = np.quantile(turned, CORE, axis=0)
        if len(points):
            reach = AROUND * np.ptp(points @ axes.T, axis=0)[:2].min()
            low = np.maximum(low, (points @ axes.T).min(axis=0) - reach)
            high = np.minimum(high, (points @ axes.T).max(axis=0) + reach)
        spheres = spheres[((turned >= low) & (turned <= high)).all(axis=1)]
        radius = float(run.spheres["radius"].max())
        points = np.concatenate([points, spheres - radius, spheres + radius])
    if not framed.any():
        size = np.ptp(points, axis=0).max() if len(points) else np.inf
        for mesh in table["mesh"][table["reservoir"] == "wall"].unique():
            more = np.concatenate([points, corners[(table["mesh"] == mesh).to_numpy()].reshape(-1, 3)])
            if np.ptp(more, axis=0).max() <= NEAR * size:
                points = more
    return points if len(points) else np.array([[-1e-3] * 3, [1e-3] * 3])


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
    """Draw wires, plates of screens and the impact plate solid, of every other wall the far half, translucent."""
    massive, reservoirs = solid(run), run.triangles["reservoir"]
    whole = vtk.walls(run, step)
    if massive.any():
        part = whole.extract_cells(massive).extract_surface(algorithm="dataset_surface")
        plotter.add_mesh(
            part, color=METAL, specular=0.6, specular_power=15, split_sharp_edges=True, smooth_shading=True
        )
    for reservoir in set(reservoirs.unique()) - set(HIDDEN):
        chosen = (reservoirs == reservoir).to_numpy(dtype=bool) & ~massive
        if not chosen.any():
            continue
        part = whole.extract_cells(chosen).extract_surface(algorithm="dataset_surface")
        away = frame(run)[1]
        far = part.clip(normal=tuple(-away), origin=tuple(centre - 1e-4 * away))
        if far.n_cells:
            far.cell_data["colour"] = np.array(FACES, dtype=np.uint8)[far.cell_data["part"] % len(FACES)]
            look: dict[str, Any] = {"scalars": "colour", "rgb": True} if reservoir == "wall" else {"color": "#b9c4cf"}
            plotter.add_mesh(far, opacity=0.35, **look)
            plotter.add_mesh(far.extract_feature_edges(25.0), color="#7d8994", line_width=2)


if __name__ == "__main__":
    with border():
        run_dir, out, step = arguments(RUN_DIR=Path, OUT=Path, STEP=int)
        draw(RunDir(run_dir), step, out)
