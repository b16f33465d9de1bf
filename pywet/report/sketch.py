"""Draw a picture without VTK, by matplotlib: shaded discs and wires in an oblique parallel projection."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from pywet.laws.contact import film_thickness
from pywet.products.apertures import CROSS, SCREENS
from pywet.report import vtk
from pywet.runs.rundir import Bools, Floats, RunDir
from pywet.runs.walls import wall_corners
from pywet.scene import Rotation

BACKGROUND = "#f4f6f8"
METAL = "#9aa3ab"
BRIDGE_COLOUR = "#e4572e"
METALS = ("wires", "impact_plate")
"""Reservoirs of the screening rig that are drawn solid; of a user-defined scene its screens are."""
UPRIGHT = np.eye(3)
TURN, TILT = np.radians(18.0), np.radians(24.0)
"""Angles by which the view is turned about the vertical and tilted downwards."""


def frame(run: RunDir) -> Floats:
    """Return right, away and up of a picture, as rows: up against gravity, away along the axis of turning walls, else along y."""
    pull, ways = np.array(run.scene.gravity_m_per_s2), run.scene.motions.values()
    turning = next((way for way in ways if isinstance(way, Rotation)), None)
    up = -pull / np.linalg.norm(pull) if pull.any() else np.array([0.0, 0.0, 1.0])
    for axis in ([0.0, 1.0, 0.0] if turning is None else turning.axis, [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]):
        away = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
        away -= away @ up * up
        if np.linalg.norm(away) > 0.5:
            break
    away /= np.linalg.norm(away)
    right = np.cross(away, up)
    if right[np.abs(right).argmax()] < 0.0:
        right, away = -right, -away
    return np.stack([right, away, up])


def solid(run: RunDir) -> Bools:
    """Return whether each triangle is drawn solid: of wires, of a screen's plate, of the impact plate."""
    names = [w.name for w in run.scene.walls if w.name.rstrip("_0123456789") in (*SCREENS, CROSS)]
    return np.asarray(run.triangles["reservoir"].isin(METALS) | run.triangles["mesh"].isin(names), dtype=bool)


def project(points: Floats, seen: Floats = UPRIGHT) -> Floats:
    """Project points (…, 3) [m] to right, up and depth (larger is nearer) in the same unit; `seen` as returned by `frame`."""
    x, y, z = np.moveaxis(np.asarray(points, dtype=float) @ seen.T, -1, 0)
    right = np.cos(TURN) * x + np.sin(TURN) * y
    back = -np.sin(TURN) * x + np.cos(TURN) * y
    return np.stack([right, np.cos(TILT) * z + np.sin(TILT) * back, np.sin(TILT) * z - np.cos(TILT) * back], axis=-1)


def colour_limit(run: RunDir, step: int) -> float:
    """Return the upper end of the colours [m]: the largest film on a sphere, now or initially, rounded up to a tick."""
    line = run.timeline
    radius = run.spheres["radius"].to_numpy(dtype=float)
    films = (line.initial_film, line.film[int(np.searchsorted(line.steps, step))])
    thickest = max(float(film_thickness(film, radius).max()) for film in films)
    return float(1e-6 * colour_ticks(1e6 * thickest)[-1]) if thickest > 0 else 1.0


def colour_ticks(largest: float) -> Floats:
    """Ticks of a colour bar from 0: at most five equal steps of 1, 2 or 5 times a power of ten, the last tick at or above it.

    >>> colour_ticks(79.0).tolist(), colour_ticks(7.1).tolist()
    ([0.0, 20.0, 40.0, 60.0, 80.0], [0.0, 2.0, 4.0, 6.0, 8.0])
    """
    power = 10.0 ** np.floor(np.log10(largest / 5.0))
    step = power * next(unit for unit in (1, 2, 5, 10) if largest <= 5.0 * unit * power * (1.0 + 1e-9))
    return np.asarray(np.round(step * np.arange(np.ceil(largest / step - 1e-9) + 1), 12))


def blues() -> Any:
    """Return a colour map from nearly white (dry) to deep blue (thick film)."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("film", ["#f3f7fb", "#b5d3ea", "#5b9fd0", "#1d66ac", "#08306b"])


def draw(run: RunDir, step: int, picture: Path) -> None:
    """Draw the run at an output step into a PNG file."""
    from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection

    from pywet.report.pictures import plt

    spheres, bridges = vtk.particles(run, step), vtk.bridges(run, step)
    figure, axes = plt.subplots(figsize=(10, 7), dpi=150, facecolor=BACKGROUND)
    corners = wall_corners(run, step)[solid(run)]
    seen = frame(run)
    faces = project(corners, seen)
    axes.add_collection(
        PolyCollection(list(faces[..., :2]), facecolors="#aab3bb", edgecolors="#8b959e", linewidths=0.2)
    )
    place, diameter = project(spheres.points, seen), 2.0 * spheres.point_data["radius"]
    order = np.argsort(place[:, 2])
    colours = blues()(spheres.point_data["film_thickness"][order] / colour_limit(run, step))
    # Three discs per sphere, drawn from back to front: rim, body, highlight.
    for scale, shift, tint in ((1.0, 0.0, 0.75), (0.93, 0.02, 1.0), (0.35, 0.18, 1.25)):
        size = scale * diameter[order]
        shade = np.clip(colours * [tint, tint, tint, 1.0], 0.0, 1.0)
        offsets = place[order, :2] + shift * diameter[order, None] * np.array([-0.7, 0.7])
        zeros = np.zeros_like(size)
        discs = EllipseCollection(
            size, size, zeros, units="xy", offsets=offsets, offset_transform=axes.transData, facecolors=shade
        )
        axes.add_collection(discs)
    if len(bridges.points):
        lines = project(bridges.points.reshape(-1, 2, 3), seen)[..., :2]
        axes.add_collection(LineCollection(list(lines), colors=BRIDGE_COLOUR, linewidths=1.0))
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_axis_off()
    figure.savefig(picture, format="png", bbox_inches="tight", facecolor=BACKGROUND)
    plt.close(figure)
