"""Screen of a deck as a wall: its area, its apertures and its plane, from the triangles and the description.

Apertures are the holes of a plate, otherwise the gaps between wires along x times those along y. Holes are counted by the
edges that two trees over a surface leave, gaps by the distances of neighbouring axes.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from reference_impl.replay import io
from reference_impl.replay.arrays import Floats, vectors

NAMES = ("wires", "screen", "deck")
CROSS = "cross_wires"
NODE = 1e-8
"""Distance [m] below which two corners are one node."""
ONE_AXIS = 1e-3
"""Distance of two axes over the largest gap below which they are one."""


def numbered(name: str, deck: int) -> str:
    """Return the name of an item of a deck; the top deck has no number."""
    return name + (f"_{deck}" if deck > 1 else "")


def of(scene: Mapping[str, Any], deck: int) -> dict[str, Any] | None:
    """Return the wall that is the screen of a deck."""
    names = [numbered(name, deck) for name in NAMES]
    return next((dict(w) for w in scene["walls"] if w["name"] in names), None)


def levels(folder: Path) -> list[Mapping[str, Any]]:
    """Return the decks of the description, from the top; none for a case or for walls of the user's own."""
    path = folder / "description.json"
    top = json.loads(path.read_text()).get("deck") if path.exists() else None
    return [top, *(top.get("beneath") or ())] if top else []


def aperture(folder: Path, deck: int) -> float | None:
    """Return the aperture [mm] of a deck or of a case; None for walls of the user's own."""
    if decks := levels(folder):
        return float(decks[deck - 1]["aperture_mm"]) if deck <= len(decks) else None
    path = folder / "config.json"
    case = (json.loads(path.read_text()) or {}).get("case") if path.exists() else None
    given = (case or {}).get("aperture_mm")
    return None if given is None else float(given)


def corners(folder: Path, names: list[str]) -> tuple[Floats, Floats]:
    """Return the corners of the triangles of some walls, shape (n, 3, 3) [m], and the body of each."""
    table = io.every(folder / "history" / "triangles.parquet")
    table = table[table["mesh"].isin(names)]
    return np.stack([vectors(table, f"v{k}") for k in range(3)], axis=1), table["part"].to_numpy()


def faces(folder: Path, wall: Mapping[str, Any]) -> tuple[float, float] | None:
    """Return the heights [m] of the lower and the upper face of a punched plate at rest; None for wires and bars."""
    triangles = corners(folder, [wall["name"]])[0]
    return (float(triangles[:, :, 2].min()), float(triangles[:, :, 2].max())) if holes(triangles) else None


def plane(folder: Path, scene: Mapping[str, Any], wall: Mapping[str, Any]) -> float:
    """Return the height [m] of the plane of wires or bars at rest."""
    if wall["name"] == "wires":
        return float(scene.get("screen_z_m", 0.0))
    z = corners(folder, [wall["name"]])[0][:, :, 2]
    return (float(z.min()) + float(z.max())) / 2.0


def level(folder: Path, scene: Mapping[str, Any], wall: Mapping[str, Any]) -> bool:
    """Return whether a screen is horizontal and flat: at most as high as twice its thickness and the largest radius.

    The thickness is the volume under its triangles that face up less that under those that face down, over half the plan
    area of all. Those of a case and of a deck are.
    """
    if wall["name"] == "wires" or levels(folder):
        return True
    a, b, c = np.moveaxis(corners(folder, [wall["name"]])[0], 1, 0)
    (ux, uy), (vx, vy) = (b - a)[:, :2].T, (c - a)[:, :2].T
    facing, z = (ux * vy - uy * vx) / 2.0, np.stack([a[:, 2], b[:, 2], c[:, 2]])
    under = float((facing * (z.sum(axis=0) / 3.0 - float(z.mean()))).sum())
    plan = float(np.abs(facing).sum()) / 2.0
    thick = abs(under) / plan if plan > 0.0 else 0.0
    return float(z.max() - z.min()) <= 2.0 * thick + max(float(k["radius_m"]) for k in scene["classes"])


def area(folder: Path, wall: Mapping[str, Any]) -> float:
    """Return the plan area [m2]: of a case inside its side wall, a circle or a square of whole cells; of a deck length times
    width; otherwise of the rectangle around the screen.
    """
    if decks := levels(folder):
        return float(decks[0]["length_mm"]) * float(decks[0]["width_mm"]) * 1e-6
    points, body = corners(folder, [wall["name"]])
    path = folder / "config.json"
    sieve = (json.loads(path.read_text()) or {}).get("scale") if path.exists() else None
    if sieve and (cell := cell_of(axes_of(points, body)[1])):
        width = 1e-3 * float(sieve["width_mm"]["value"])
        return math.pi * width**2 / 4.0 if sieve["shape"] == "cylinder" else (cell * max(1, round(width / cell))) ** 2
    sides = np.ptp(points.reshape(-1, 3), axis=0)
    return float(sides[0] * sides[1])


def axes_of(points: Floats, body: Floats) -> dict[int, list[float]]:
    """Return the positions of the axes of bars: along x by those of bars along y (0), along y by those of bars along x (1)."""
    axes: dict[int, list[float]] = {0: [], 1: []}
    for one in np.unique(body):
        of_body = points[body == one].reshape(-1, 3)
        low, high = of_body.min(axis=0), of_body.max(axis=0)
        across = 1 if high[0] - low[0] > high[1] - low[1] else 0
        axes[across].append(float(low[across] + high[across]) / 2.0)
    return axes


def cell_of(axes: list[float]) -> float:
    """Return the distance of neighbouring axes [m]; 0 for less than two."""
    each = np.diff(np.unique(np.round(axes, 8)))
    even = (
        len(each) > 0 and np.ptp(each) < 1e-7
    )  # coordinates have single precision, which their mean distance evens out
    return round(float(np.ptp(axes) / len(each) if even else np.median(each)), 9) if len(each) else 0.0


def count(folder: Path, scene: Mapping[str, Any], wall: Mapping[str, Any], deck: int) -> int:
    """Return the number of apertures: holes of a plate, cells of a case, otherwise gaps along x times gaps along y.

    Between the outermost wire and the side of a deck is a gap if it is wider than half an aperture.
    """
    plate, body = corners(folder, [wall["name"]])
    if pierced := holes(plate):
        return pierced
    decks, cell = levels(folder), cell_of(axes_of(plate, body)[1])
    if not decks and cell and (folder / "config.json").exists() and wall["name"] == "wires":
        return round(area(folder, wall) / cell**2)
    axes = axes_of(*corners(folder, [wall["name"], numbered(CROSS, deck)]))
    across = gaps(axes[1], scene.get("periodic") == "y")
    if decks and scene.get("periodic") != "y":
        free = float(decks[0]["width_mm"]) - float(decks[deck - 1]["wire_mm"])
        left, right = (500.0 * free + 1e6 * side for side in (min(axes[1]), -max(axes[1])))
        narrow = 500.0 * float(decks[deck - 1]["aperture_mm"])
        across += (left > narrow) + (right > narrow) - (len(axes[1]) == 1)
    return gaps(axes[0], scene.get("periodic") == "x") * max(1, across)


def slots(folder: Path, wall: Mapping[str, Any], deck: int) -> float | None:
    """Return the length [m] of the longest gap along bars that cross no others; None for other apertures."""
    points, body = corners(folder, [wall["name"], numbered(CROSS, deck)])
    axes = axes_of(points, body)
    if (axes[0] and axes[1]) or holes(corners(folder, [wall["name"]])[0]):
        return None
    along = 0 if axes[1] else 1
    return max(float(np.ptp(points[body == one][:, :, along])) for one in np.unique(body))


def gaps(axes: list[float], repeats: bool) -> int:
    """Return the number of gaps between axes, at least one; in a periodic box the last is before the copy of the first."""
    apart = np.diff(np.sort(axes))
    between = int((apart > ONE_AXIS * apart.max(initial=0.0)).sum())
    return max(1, between + (repeats and bool(axes)))


class _Groups:
    """Items joined step by step."""

    def __init__(self, count: int) -> None:
        self._above = list(range(count))

    def top(self, item: int) -> int:
        """Return the item by which a group is known."""
        while self._above[item] != item:
            self._above[item] = item = self._above[self._above[item]]
        return item

    def join(self, a: int, b: int) -> bool:
        """Join two items; False if they were in one group."""
        a, b = self.top(a), self.top(b)
        self._above[a] = b
        return a != b


def holes(triangles: Floats) -> int:
    """Return the number of holes through bodies: half the edges that neither a tree over nodes nor one over faces needs.

    The lone edges of an open end, as at a periodic face, meet in one further face.
    """
    nodes = np.unique(np.rint(triangles.reshape(-1, 3) / NODE).astype(np.int64), axis=0, return_inverse=True)[1]
    nodes, number = nodes.reshape(-1, 3), int(nodes.max(initial=-1)) + 1
    faces_at: dict[tuple[int, int], list[int]] = {}
    for face, (a, b, c) in enumerate(nodes.tolist()):
        for u, v in ((a, b), (b, c), (c, a)):
            faces_at.setdefault((min(u, v), max(u, v)), []).append(face)
    ends = _Groups(number)
    for (u, v), faces in faces_at.items():
        if len(faces) == 1:
            ends.join(u, v)
    over_nodes, over_faces, spare = _Groups(number), _Groups(len(nodes) + number), 0
    for edge in [edge for edge in faces_at if not over_nodes.join(*edge)]:
        one, other = [*faces_at[edge], len(nodes) + ends.top(edge[0])][:2]
        spare += not over_faces.join(one, other)
    return spare // 2
