"""Draw one sphere and its bridges twice: as cuboids as in the paper's Fig. 11, and with the exact bridge's meridian.

The exact bridge (`laws/exact_bridge`) is a surface of revolution between two contact lines. A bridge that it cannot resolve (a
contact angle of 90° or more, a gap beyond its rupture distance) remains a cuboid, and the caption states their number.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.errors import PywetError, arguments, border
from pywet.geometry import periodic
from pywet.laws import exact_bridge
from pywet.laws.exact_bridge.bridge import Bridge
from pywet.report import active_bridges, caption, render, vtk
from pywet.report.sketch import BRIDGE_COLOUR, METAL, blues, colour_limit, solid
from pywet.runs.rundir import Floats, RunDir
from pywet.runs.walls import wall_corners
from pywet.util.files import atomic_write

SIZE = (700, 700)
AROUND, ALONG = 48, 61
"""Number of points around the axis, and along the meridian."""


def write(run_dir: Path, picture: Path, sphere: int, step: int | None = None) -> Path:
    """Draw a sphere's bridges at an output step (default: the one with the most) into a PNG, and return its path."""
    run = RunDir(Path(run_dir))
    chosen = _fullest(run, sphere) if step is None else render.output_step(run, step)
    if not len(_bridges(run, sphere, chosen)):
        raise PywetError(
            f"sphere {sphere} of {run.path} has no bridge at step {chosen}; expected another sphere, or --step",
            code="closeup.no_bridge", given=sphere, where=run.path,
        )  # fmt: skip
    with atomic_write(Path(picture)) as temporary:
        list(render.in_child("pywet.report.closeup", str(run.path), str(temporary), str(chosen), str(sphere)))
    return Path(picture)


def _fullest(run: RunDir, sphere: int) -> int:
    counts = np.zeros(int(run.timeline.steps[-1]) + 1, dtype=int)
    for part in run.parts("history/bridges", ["step", "partner_kind", "i", "j"]) if run.moist else ():
        counts += np.bincount(part.loc[_has(part, sphere), "step"], minlength=len(counts))
    return int(counts.argmax())


def _has(bridges: pd.DataFrame, sphere: int) -> Any:
    return (bridges["i"] == sphere) | ((bridges["j"] == sphere) & (bridges["partner_kind"] == 0))


def _bridges(run: RunDir, sphere: int, step: int) -> pd.DataFrame:
    here = vtk.active_at(run, step)
    return here[_has(here, sphere)]


def exact(run: RunDir, bridges: pd.DataFrame) -> list[Bridge | None]:
    """Return the exact bridge of each row, or None."""
    b = active_bridges.bodies(run, bridges)
    rows = zip(bridges["separation"], bridges["volume"], b.radius_i, b.radius_j, b.angle_i, b.angle_j, strict=True)
    return [_solved(*map(float, row)) for row in rows]


def _solved(gap: float, volume: float, ri: float, rj: float, ti: float, tj: float) -> Bridge | None:
    try:
        return exact_bridge.solve(gap, volume, ri, rj, ti, tj)
    except PywetError:
        return None


def revolved(bridge: Bridge, first: Floats, second: Floats) -> Floats:
    """Return points (ALONG, AROUND, 3) [m] of the bridge's surface; `first` is i's centre, `second` j's or a wall's point."""
    z, r, _ = bridge.meridian(ALONG)
    along = (second - first) / np.linalg.norm(second - first)
    u = np.cross(along, np.eye(3)[np.abs(along).argmin()])
    u /= np.linalg.norm(u)
    angle = np.linspace(0.0, 2.0 * np.pi, AROUND, endpoint=False)
    around = np.cos(angle)[:, None] * u + np.sin(angle)[:, None] * np.cross(along, u)
    height = z + bridge.bodies.radius_i * np.cos(bridge.half_filling_angles[0])
    return np.asarray(first + height[:, None, None] * along + r[:, None, None] * around)


def draw(run: RunDir, step: int, sphere: int, picture: Path) -> None:
    """Draw with VTK in this process."""
    here = _bridges(run, sphere, step)
    solved = exact(run, here)
    none: list[Bridge | None] = [None] * len(here)
    (image, mm), (true, _) = (scene(run, step, sphere, here, shapes) for shapes in (none, solved))
    lost = sum(bridge is None for bridge in solved)
    time = step * run.scene.time_step_s
    text = (f"{run.scene.name}   t = {time:.3f} s   sphere {sphere}, {len(here)} bridges: as cuboids, and the exact bridge"
            + (f" ({lost} not resolved: cuboids)" if lost else ""))  # fmt: skip
    caption.save(caption.below(np.concatenate([image, true], axis=1), caption.entries(run), text, mm), picture)


def around(bridges: pd.DataFrame, sphere: int, centre: Floats) -> tuple[pd.DataFrame, dict[int, Floats]]:
    """Return a sphere's bridges moved to its centre, and the centres of its partners by their numbers [m].

    Across a periodic boundary a bridge and its partner are at the image that is nearest to the sphere.
    """
    pairs = (bridges["partner_kind"] == 0).to_numpy()
    second = pairs & (bridges["j"] == sphere).to_numpy()  # the sphere is at the bridge's end j
    columns = [[f"{end}_{axis}" for axis in "xyz"] for end in ("xi", "xj")]
    first, last = (bridges[names].to_numpy(dtype=float) for names in columns)
    shift = centre - np.where(second[:, None], last, first)
    moved = bridges.copy()
    moved[[*columns[0], *columns[1]]] = np.hstack([first + shift, last + shift])
    numbers = np.where(second, bridges["i"], bridges["j"])[pairs].tolist()
    return moved, dict(zip(numbers, (np.where(second[:, None], first, last) + shift)[pairs], strict=True))


def scene(run: RunDir, step: int, sphere: int, bridges: pd.DataFrame, shapes: list[Bridge | None]) -> tuple[Any, float]:
    """Return the pixels and their number per millimetre at the sphere; a bridge without a shape is a cuboid."""
    import pyvista as pv

    plotter = render.plotter(SIZE)
    mesh, limit = vtk.particles(run, step), colour_limit(run, step)
    rows = {int(n): k for k, n in enumerate(mesh.point_data["id"])}
    centre = mesh.points[rows[sphere]]
    bridges, partners = around(bridges, sphere, centre)
    for number, place in ((sphere, centre), *sorted(partners.items())):
        radius = mesh.point_data["radius"][rows[number]]
        colour = blues()(mesh.point_data["film_thickness"][rows[number]] / limit)[:3]
        ball = pv.Sphere(radius=radius, center=place, theta_resolution=60, phi_resolution=60)
        plotter.add_mesh(
            ball, color=colour, opacity=1.0 if number == sphere else 0.45, smooth_shading=True, specular=0.3
        )
    radius = mesh.point_data["radius"][rows[sphere]]
    width = 2.4 * (radius + max((mesh.point_data["radius"][rows[n]] for n in partners), default=radius))
    plates = wall_corners(run, step)[solid(run)].reshape(-1, 3)
    corners = periodic.copies(plates, run.scene.periods_m).reshape(-1, 3, 3)
    near = np.linalg.norm(corners.mean(axis=1) - centre, axis=1) < width
    if near.any():
        plotter.add_mesh(vtk.grid("TRIANGLE", 3, corners[near].reshape(-1, 3)), color=METAL)
    boxes = active_bridges.corners(run, bridges)
    ends = (bridges[[f"{end}_{axis}" for axis in "xyz"]].to_numpy(dtype=float) for end in ("xi", "xj"))
    for shape, box, first, second in zip(shapes, boxes, *ends, strict=True):
        if shape is None:
            body = vtk.grid("HEXAHEDRON", 8, box)
        else:
            points = revolved(shape, first, second)
            body = pv.StructuredGrid(*np.moveaxis(np.concatenate([points, points[:, :1]], axis=1), 2, 0))
        plotter.add_mesh(body, color=BRIDGE_COLOUR, smooth_shading=shape is not None, specular=0.4)
    return render.pixels(plotter, run, centre, 0.75 * width, SIZE)


if __name__ == "__main__":
    with border():
        run_dir, out, step, sphere = arguments(RUN_DIR=Path, OUT=Path, STEP=int, SPHERE=int)
        draw(RunDir(run_dir), step, sphere, out)
