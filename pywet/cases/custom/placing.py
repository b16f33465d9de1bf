"""Refuse implausible sizes and positions of a description, and shift a scene to an origin near its walls."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from pywet.cases.custom.description import Scene
from pywet.cases.custom.spheres import Spheres
from pywet.cases.custom.walls import Wall
from pywet.errors import ConfigError
from pywet.geometry.crossing import crossing
from pywet.geometry.surface import LARGE_HALF_WIDTH_M, Floats, Surface
from pywet.scene import Vector
from pywet.util.notices import notice

SMALL, LARGE = 1.0, 3000.0
"""Longest side of an STL file over the spheres' diameter below and above which its unit is questioned."""
THIN = 0.2
"""Width over length below which a body is a bar."""
COUNT_FROM = (
    "Parquet files count positions from origin_mm [{:.10g}, {:.10g}, {:.10g}]; "
    "pywet.load, vtk/ and ovito/ give the scene's own"
)
FAR = 20.0
"""Distance of a scene from its origin, over its size, beyond which positions lose digits that the walls need."""
LEAST_SIZE_M = 0.01
"""Smallest size [m] assumed for a scene."""


def from_origin(scene: Scene) -> Scene:
    """Return a copy of the scene with all positions counted from its `origin_mm`."""
    origin = scene.origin_mm
    if not any(origin):
        return scene
    spheres = tuple(_moved(s, origin) for s in scene.spheres)
    walls = tuple(_moved(w, origin) for w in scene.walls)
    outlets = tuple(outlet.moved(origin) for outlet in scene.outlets)
    changes: dict[str, Any] = {"spheres": spheres, "walls": walls, "outlets": outlets, "origin_mm": (0.0, 0.0, 0.0)}
    if periodic := scene.periodic:
        off = origin["xy".index(periodic.axis)]
        changes["periodic"] = periodic.model_copy(
            update={"low_mm": periodic.low_mm - off, "high_mm": periodic.high_mm - off}
        )
    return scene.model_copy(update=changes)


def _moved(entry: Any, origin: Vector) -> Any:
    """Return part of a description, recursively, with the origin subtracted from `origin_mm`, `low_mm`, `high_mm` and `at_mm`."""
    changes: dict[str, Any] = {}
    for key in type(entry).model_fields:
        value = getattr(entry, key)
        if key in ("low_mm", "high_mm"):
            changes[key] = _less(value, origin)
        elif key == "origin_mm" and isinstance(entry, Wall) and entry.stl is None:
            continue
        elif key == "origin_mm":  # subtracted from the coordinates of a wall's STL file
            sign = -1.0 if isinstance(entry, Wall) else 1.0
            changes[key] = _less(value, tuple(sign * x for x in origin))
        elif key == "at_mm" and value is not None:
            changes[key] = tuple(_less(v, origin) for v in value)
        elif hasattr(type(value), "model_fields"):
            changes[key] = _moved(value, origin)
    return entry.model_copy(update=changes)


def _less(point: Vector, origin: Sequence[float]) -> Vector:
    x, y, z = (a - b for a, b in zip(point, origin, strict=True))
    return x, y, z


def ask_unit(wall: Wall, surface: Surface, spheres: Sequence[float]) -> None:
    """Refuse an STL file whose size is implausible for the spheres' diameters [m]."""
    if wall.stl is None:
        return
    longest = float(np.ptp(surface.vertices, axis=0).max())
    small, large = longest < SMALL * min(spheres), longest > LARGE * max(spheres)
    if small or large:
        other = "m" if wall.stl_unit == "mm" else "mm"
        factor = 1e3 if other == "m" else 1e-3
        sizes = " to ".join(dict.fromkeys(f"{1e3 * d:.4g}" for d in (min(spheres), max(spheres))))
        raise ConfigError(
            f"wall {wall.name}: {wall.stl.name} in {wall.stl_unit} is {1e3 * longest:.4g} mm long, compared with spheres of "
            f"{sizes} mm; expected a size that they meet: in {other} it is "
            f"{1e3 * longest * factor:.4g} mm (stl_unit: {other})",
            code="scene.stl_unit",
            key=f"walls.{wall.name}.stl_unit",
            given=wall.stl_unit,
            expected=other,
        )


def mention_crossing(wall: Wall, surface: Surface) -> None:
    """Report where a body of an STL file intersects itself; bodies may overlap each other."""
    if wall.stl is None:
        return
    count, body = surface.components()
    for k in range(count):
        at = crossing(surface.vertices, surface.triangles[body == k])
        if at is not None:
            place = ", ".join(f"{1e3 * x:.4g}" for x in at)
            notice.warning(
                f"wall {wall.name}: {wall.stl.name} cuts through itself at ({place}) mm, so that it has no clear inside; "
                "expected the surface of a solid: unite its parts in the CAD program"
            )
            return


def mention_bars(wall: Wall, surface: Surface) -> None:
    """Report bodies of an STL file that look like wires or bars but are treated as faces."""
    if wall.stl is None or wall.half_width_mm is not None:
        return
    count, body = surface.components()
    across = []
    for k in range(count):
        points = surface.corners[body == k].reshape(-1, 3)
        sides = np.sort(np.ptp(points @ np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2].T, axis=0))
        if sides[1] < 2.0 * LARGE_HALF_WIDTH_M and sides[1] < THIN * sides[2] and sides[1] < 2.0 * sides[0]:
            across.append(1e3 * float(sides[1]))
    if across:
        half = 0.5 * np.median(across)
        notice.warning(
            f"wall {wall.name}: {len(across)} of its {count} bodies are bars of about {2.0 * half:.3g} mm, taken as "
            f"faces, whose bridges and films are not a wire's; half_width_mm: {half:.3g} gives each those of a wire"
        )


def origin_of(scene: Scene) -> Vector:
    """Return the origin [mm] of a scene: the given one, or its middle if it is so far from 0 that positions would lose digits."""
    spheres = [np.array(place) for s in scene.in_full().spheres for place in _places(s)]
    if any(scene.origin_mm) or not spheres or max(np.abs(place).max() for place in spheres) < 1e3 * FAR * LEAST_SIZE_M:
        return scene.origin_mm
    found = _far([1e-3 * np.array(spheres), *(w.points(scene.folder) for w in scene.walls)])
    return scene.origin_mm if found is None else found[2]


def _places(spheres: Spheres) -> list[Vector]:
    """Return points [mm] that bound the region in which spheres are placed."""
    if spheres.box is not None:
        return [spheres.box.low_mm, spheres.box.high_mm]
    return [spheres.cylinder.origin_mm] if spheres.cylinder is not None else list(spheres.at_mm or ())


def _far(corners: Sequence[Floats]) -> tuple[float, float, Vector] | None:
    """Return distance from 0 [m], size [m] and middle [mm] of points so far away that they would lose digits, or None."""
    points = np.concatenate(corners)
    middle, size = 0.5 * (points.min(axis=0) + points.max(axis=0)), float(np.linalg.norm(np.ptp(points, axis=0)))
    away = float(np.linalg.norm(middle))
    if len(points) < 2 or not FAR * max(size, LEAST_SIZE_M) < away < math.inf:
        return None
    digits = 10.0 ** math.floor(math.log10(1e3 * max(size, LEAST_SIZE_M)))
    x, y, z = (digits * round(1e3 * m / digits) for m in middle)
    return away, size, (x, y, z)


def refuse_far(scene: Scene, corners: Sequence[Floats]) -> None:
    """Refuse a scene so far from its origin that positions would lose digits; the message names a suitable origin."""
    if (found := _far(corners)) is not None:
        away, size, (x, y, z) = found
        raise ConfigError(
            f"scene {scene.name}: all lies about {away:.4g} m from its origin_mm and is {size:.3g} m large; expected positions "
            f"near it, which keep their digits: it is [{x:.10g}, {y:.10g}, {z:.10g}] off",
            code="scene.far_away",
            key="origin_mm",
            given=away,
        )
