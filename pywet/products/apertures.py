"""Identify the screen of a run, its area and apertures, and the spheres that peg them."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy

from pywet.geometry.motion import peak_speed, velocity
from pywet.runs.rundir import Bools, Floats, Ints, RunDir
from pywet.scene import Vibration, WallMesh

SCREENS = ("wires", "screen", "deck")
"""Names of walls that are screens: wires in a case, screen or deck in a user-defined scene."""
CROSS = "cross_wires"
"""Name of the wall with the cross wires of a deck."""
DECKS = ("overs", "middlings", "lower_middlings")
"""Product at the end of each deck, from the top."""
WEDGED_SPEED = 0.5
"""Speed relative to the screen, over the screen's peak speed, below which a sphere is wedged.

Its centre must also be within its radius of the screen's plane.
"""


def of_deck(name: str, deck: int) -> str:
    """Name of an item of a deck, numbered from the top; that of the top deck has no number.

    >>> of_deck("screen", 1), of_deck("screen", 2)
    ('screen', 'screen_2')
    """
    return name if deck == 1 else f"{name}_{deck}"


def screen_of(run: RunDir, deck: int = 1) -> WallMesh | None:
    """Return the wall that is the screen of a deck, counted from the top: the first with a name in `SCREENS`."""
    names = [of_deck(name, deck) for name in SCREENS]
    return next((wall for wall in run.scene.walls if wall.name in names), None)


def extents(run: RunDir, wall: WallMesh) -> tuple[Floats, Floats]:
    """Return the lower and upper corner of each part of a wall in its file [m], each of shape (parts, 3)."""
    corners, part = _corners(run, wall), np.array(wall.triangle_part)
    low, high = (np.full((part.max() + 1, 3), fill) for fill in (np.inf, -np.inf))
    np.minimum.at(low, part, corners.min(axis=1))
    np.maximum.at(high, part, corners.max(axis=1))
    return low, high


def _corners(run: RunDir, wall: WallMesh) -> Floats:
    """Return the corners of the triangles of a wall in its file, shape (m, 3, 3) [m]."""
    rows = run.triangles[run.triangles["mesh"] == wall.name]
    corners = rows[[f"v{k}_{axis}" for k in range(3) for axis in "xyz"]].to_numpy(dtype=float)
    return np.asarray(corners.reshape(-1, 3, 3))


def holes(corners: Floats) -> int:
    """Count the holes through bodies by Euler's characteristic; each open end, as at a periodic face, closes with a lid.

    Parameters
    ----------
    corners : array (m, 3, 3)
        Corners of triangles that meet at their nodes [m].
    """
    nodes, index = np.unique(np.round(corners.reshape(-1, 3), 8), axis=0, return_inverse=True)
    triangles = index.reshape(-1, 3)
    edges = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    edges, count = np.unique(edges, axis=0, return_counts=True)
    lone = edges[count == 1]
    ends = _groups(np.searchsorted(np.unique(lone), lone), len(np.unique(lone)))
    characteristic = len(nodes) - len(edges) + len(triangles) + ends
    return (2 * _groups(edges, len(nodes)) - characteristic) // 2


def _groups(links: Ints, count: int) -> int:
    """Count the connected groups of `count` nodes with links (n, 2)."""
    graph = scipy.sparse.coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(count, count))
    return int(scipy.sparse.csgraph.connected_components(graph, directed=False)[0])


def deck_of(run: RunDir) -> dict[str, Any] | None:
    """Return the `deck` of a user-defined scene's description; None if its walls were given individually."""
    return run.description.get("deck")


def area(run: RunDir, wall: WallMesh) -> float:
    """Return the plan area of the screen [m2]: length times width of a deck, otherwise of the rectangle around the screen."""
    if deck := deck_of(run):
        return 1e-6 * float(deck["length_mm"]) * float(deck["width_mm"])
    low, high = extents(run, wall)
    x, y, _ = high.max(axis=0) - low.min(axis=0)
    return float(x * y)


def count(run: RunDir, wall: WallMesh, deck: int = 1) -> int:
    """Return the number of apertures: holes of a plate; gaps along x times gaps along y for wires; slots for bars."""
    if pierced := holes(_corners(run, wall)):
        return pierced
    nets = [w for w in run.scene.walls if w.name in (wall.name, of_deck(CROSS, deck))]
    low, high = (np.concatenate(ends) for ends in zip(*(extents(run, w) for w in nets), strict=True))
    along_x = (high - low)[:, 0] > (high - low)[:, 1]
    # gaps across the deck are between wires along it, and vice versa
    across, along = int(along_x.sum()), int((~along_x).sum())
    periodic = run.scene.periodic
    return max(1, across - (periodic != "y")) * max(1, along - (periodic != "x"))


def wedged(run: RunDir, wall: WallMesh) -> Bools:
    """Return which spheres are in an aperture and move with the screen, shape (outputs, spheres); see `WEDGED_SPEED`."""
    scene, line, table = run.scene, run.timeline, run.trajectory
    place = np.searchsorted(line.steps, table["step"]), np.searchsorted(line.ids, table["id"])
    z, speed = np.full(line.present.shape, np.nan), np.full((*line.present.shape, 3), np.nan)
    z[place], speed[place] = table["z"], table[["vx", "vy", "vz"]].to_numpy()
    motion = run.mesh_motion
    shift = motion[motion["mesh"] == wall.name].set_index("step")["dz"].reindex(line.steps).to_numpy()
    screen, slow, moves = np.zeros((len(line.steps), 3)), 0.0, scene.motions[wall.name]
    if isinstance(moves, Vibration):
        screen, slow = velocity(moves, line.times), WEDGED_SPEED * peak_speed(moves)
    plane = scene.screen_z_m
    if wall.name != "wires":
        low, high = extents(run, wall)
        plane = 0.5 * float(low[:, 2].min() + high[:, 2].max())
    radius = np.array([c.radius_m for c in scene.classes])[line.types - 1]
    near = np.abs(z - plane - shift[:, None]) < radius
    return np.asarray(near & (np.linalg.norm(speed - screen[:, None, :], axis=2) <= slow))
