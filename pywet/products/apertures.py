"""Identify the screen of a run, its area and apertures, and the spheres that peg them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import scipy

from pywet.config.scales import Scale
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
"""Speed relative to the screen, over the screen's peak speed, below which a sphere is wedged; any for a screen at rest.

Its centre must also be within its radius of the screen's plane.
"""
STAYS = 0.25
"""Displacement relative to the screen in a period of its motion, over its radius, below which a wedged sphere pegs an aperture.

At a single output spheres are wedged that are about to turn around on the screen, even ones that fit through.
"""
SUNK = 0.9
"""Height of a centre above the upper face of a plate, over its radius, below which a sphere is in a hole.

Spheres on the land between holes are a radius above it; a sphere that sits on a round hole of its half diameter 0.87.
"""


TALL = 2.0
"""Extent of a horizontal screen along z, less the radius of the largest sphere, over its mean thickness, at most.

Round wires are 1.3 times as high as thick in the mean. A higher screen is inclined, curved or framed: whether a sphere is in
its plane does not follow from its height.
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


def not_level(run: RunDir, wall: WallMesh) -> str | None:
    """Return in a sentence why pegging and passage of a screen that is not horizontal are undefined; None if they are defined.

    The mean thickness is the volume of its bodies over their plan area; see `TALL`. The screens of a case and of a deck are
    horizontal.
    """
    if wall.name == "wires" or deck_of(run):
        return None
    corners = _corners(run, wall)
    z, largest = corners[..., 2], max(c.radius_m for c in run.scene.classes)
    plan = 0.5 * np.cross(corners[:, 1, :2] - corners[:, 0, :2], corners[:, 2, :2] - corners[:, 0, :2])
    volume, shadow = abs(float(plan @ (z.mean(axis=1) - z.mean()))), 0.5 * float(np.abs(plan).sum())
    thick, high = volume / shadow if shadow else 0.0, float(np.ptp(z))
    if high <= TALL * thick + largest:
        return None
    return (
        f"pegging and passage are undefined: screen {wall.name} extends over {1e3 * high:.3g} mm in height and is "
        f"{1e3 * thick:.2g} mm thick, so that it is not horizontal and flat"
    )


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
    _, index = np.unique(np.round(corners.reshape(-1, 3), 8), axis=0, return_inverse=True)
    triangles = index.reshape(-1, 3)
    sides = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    edges, of, count = np.unique(sides, axis=0, return_inverse=True, return_counts=True)
    lone = edges[count == 1]
    ends = _groups(np.searchsorted(np.unique(lone), lone), len(np.unique(lone)))[0]
    # bodies meet along edges; those that touch in a node have it twice
    bodies, body = _groups(np.c_[np.arange(len(sides)) // 3, len(triangles) + of.ravel()], len(triangles) + len(edges))
    nodes = np.unique(np.c_[np.repeat(body[: len(triangles)], 3), triangles.ravel()], axis=0)
    characteristic = len(nodes) - len(edges) + len(triangles) + ends
    return (2 * bodies - characteristic) // 2


def _groups(links: Ints, count: int) -> tuple[int, Ints]:
    """Return the number of connected groups of `count` nodes with links (n, 2), and the group of each."""
    graph = scipy.sparse.coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(count, count))
    number, group = scipy.sparse.csgraph.connected_components(graph, directed=False)
    return int(number), np.asarray(group)


def deck_of(run: RunDir) -> dict[str, Any] | None:
    """Return the `deck` of a user-defined scene's description; None if its walls were given individually."""
    return run.description.get("deck")


def area(run: RunDir, wall: WallMesh) -> float:
    """Return the plan area of the screen [m2]: a case's inside its side wall, of a deck length times width.

    Otherwise it is that of the rectangle around the screen.
    """
    if deck := deck_of(run):
        return 1e-6 * float(deck["length_mm"]) * float(deck["width_mm"])
    low, high = extents(run, wall)
    if (scale := _scale(run)) and (pitch := _pitch(low, high)):
        return scale.sieve_area_m2(pitch)
    x, y, _ = high.max(axis=0) - low.min(axis=0)
    return float(x * y)


def _scale(run: RunDir) -> Scale | None:
    """Return the scale of a screening case; None for a user-defined scene."""
    given = (run.json("config.json", dict[str, Any]) or {}).get("scale")
    return None if given is None else Scale.model_validate({k: v for k, v in given.items() if k != "name"})


def _pitch(low: Floats, high: Floats) -> float:
    """Return the mean distance of neighbouring wires along x [m], 0 for less than two.

    It is rounded to a nanometre, as the files of surfaces have single precision.
    """
    along_x = (high - low)[:, 0] > (high - low)[:, 1]
    axes = 0.5 * (low + high)[along_x, 1]
    return round(float(np.ptp(axes)) / (len(axes) - 1), 9) if len(axes) > 1 else 0.0


def count(run: RunDir, wall: WallMesh, deck: int = 1) -> int:
    """Return the number of apertures of a screen.

    Those of a plate are its holes, those of a case its area over that of an aperture with its wires. Otherwise they are gaps
    along x times gaps along y; at the sides of a deck those count that are wider than half an aperture.
    """
    if pierced := holes(_corners(run, wall)):
        return pierced
    low, high, along_x = _net(run, wall, deck)
    if _scale(run) and (pitch := _pitch(low, high)):
        return round(area(run, wall) / pitch**2)
    # gaps across the deck are between wires along it, and vice versa
    across, along = int(along_x.sum()), int((~along_x).sum())
    periodic, sides = run.scene.periodic, 0
    if (given := deck_of(run)) and periodic != "y":
        half, opening = (
            0.5e-3 * given["width_mm"],
            1e-3 * [given, *(given.get("beneath") or ())][deck - 1]["aperture_mm"],
        )
        gaps = half - high[along_x, 1].max(), low[along_x, 1].min() + half
        sides = sum(gap > 0.5 * opening for gap in gaps)
    return max(1, across + int(sides) - (periodic != "y")) * max(1, along - (periodic != "x"))


def slot_length(run: RunDir, wall: WallMesh, deck: int = 1) -> float | None:
    """Return the length of the slots between bars in one direction [m]; None for apertures that one sphere blocks."""
    low, high, along_x = _net(run, wall, deck)
    if along_x.any() != along_x.all() or holes(_corners(run, wall)):
        return None
    return float((high - low)[:, 0 if along_x.all() else 1].max())


def _net(run: RunDir, wall: WallMesh, deck: int) -> tuple[Floats, Floats, Bools]:
    """Return the lower and upper corners of all wires of a screen, and which of them lie along x."""
    nets = [w for w in run.scene.walls if w.name in (wall.name, of_deck(CROSS, deck))]
    low, high = (np.concatenate(ends) for ends in zip(*(extents(run, w) for w in nets), strict=True))
    return low, high, (high - low)[:, 0] > (high - low)[:, 1]


def pegged(run: RunDir, wall: WallMesh) -> Bools:
    """Return which spheres peg an aperture, shape (outputs, spheres): wedged for a period of the motion, at one place.

    The place is relative to the screen; see `STAYS`. They are wedged at all outputs from one to the first that is a period
    later, at least the next one.
    """
    place, speed = _relative(run, wall)
    caught, radius = _caught(run, wall, place, speed), _radius(run)
    later = min(_outputs_of_period(run, wall), len(place) - 1)
    if later < 1:
        return np.zeros_like(caught)
    moved, lengths = place[later:] - place[:-later], np.array(run.scene.periods_m)
    moved -= lengths * np.rint(moved / np.where(lengths > 0.0, lengths, np.inf))
    stays = np.linalg.norm(moved, axis=2) < STAYS * radius
    for k in range(later + 1):
        stays &= caught[k : len(caught) - later + k]
    found = np.zeros_like(caught)
    for k in range(later + 1):
        found[k : len(caught) - later + k] |= stays
    return found


def _outputs_of_period(run: RunDir, wall: WallMesh) -> int:
    """Return the number of outputs in a period of a wall's motion, rounded up; one for a wall at rest."""
    moves, times = run.scene.motions[wall.name], run.timeline.times
    if not isinstance(moves, Vibration) or len(times) < 2:
        return 1
    return max(1, math.ceil(1.0 / (moves.frequency_Hz * (times[1] - times[0])) - 1e-6))


def wedged(run: RunDir, wall: WallMesh) -> Bools:
    """Return which spheres are in an aperture and move with the screen, shape (outputs, spheres); see `WEDGED_SPEED`."""
    return _caught(run, wall, *_relative(run, wall))


def _radius(run: RunDir) -> Floats:
    return np.array([c.radius_m for c in run.scene.classes])[run.timeline.types - 1]


def _relative(run: RunDir, wall: WallMesh) -> tuple[Floats, Floats]:
    """Return place and velocity of spheres relative to a wall, shape (outputs, spheres, 3); NaN where they are not there."""
    line, table, moves = run.timeline, run.trajectory, run.scene.motions[wall.name]
    at = np.searchsorted(line.steps, table["step"]), np.searchsorted(line.ids, table["id"])
    place, speed = (np.full((*line.present.shape, 3), np.nan) for _ in range(2))
    place[at], speed[at] = table[["x", "y", "z"]].to_numpy(), table[["vx", "vy", "vz"]].to_numpy()
    motion = run.mesh_motion
    place -= (
        motion[motion["mesh"] == wall.name]
        .set_index("step")[["dx", "dy", "dz"]]
        .reindex(line.steps)
        .to_numpy()[:, None]
    )
    if isinstance(moves, Vibration):
        speed -= velocity(moves, line.times)[:, None]
    return place, speed


def _caught(run: RunDir, wall: WallMesh, place: Floats, speed: Floats) -> Bools:
    """Return which spheres are in the apertures of a screen and slower relative to it than `WEDGED_SPEED`."""
    moves, radius, z = run.scene.motions[wall.name], _radius(run), place[..., 2]
    low = high = run.scene.screen_z_m
    if wall.name != "wires":
        lows, highs = extents(run, wall)
        low, high = float(lows[:, 2].min()), float(highs[:, 2].max())
    if wall.name != "wires" and holes(_corners(run, wall)):
        inside = (z > low - radius) & (z < high + SUNK * radius)
    else:
        inside = np.abs(z - 0.5 * (low + high)) < radius
    slow = WEDGED_SPEED * peak_speed(moves) if isinstance(moves, Vibration) else math.inf
    return np.asarray(inside & (np.linalg.norm(speed, axis=2) <= slow))
