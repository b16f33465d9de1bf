"""A plate with round or square holes in columns along x, as a closed surface whose triangles meet at their nodes.

Holes are polygons about a circle, so that a sphere of the hole's diameter just passes. In a staggered plate every
other column is offset by half a pitch.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from pywet.geometry.solids import Part, flip, lift, polygon, square
from pywet.geometry.surface import Floats

SIDES = 24
"""Number of faces of a round hole; the polygon is 0.6 % larger than its circle."""


@dataclass(frozen=True)
class Punching:
    """Lengths [m] of a plate along x and y and of its holes; `columns` share the width evenly, with `count` holes in each."""

    length: float
    width: float
    hole: float
    pitch: float
    columns: int
    shape: Literal["round", "square"] = "round"
    staggered: bool = True

    @property
    def count(self) -> int:
        """Return the number of holes in a column."""
        return int((self.length - self._offset(1)) / self.pitch + 1e-9)

    @property
    def spacing(self) -> float:
        """Return the distance between columns [m]."""
        return self.width / self.columns

    @property
    def centres(self) -> Floats:
        """Return the centres of all holes relative to that of the plate, shape (columns * count, 2) [m]."""
        at = self._start + (np.arange(self.count) + 0.5) * self.pitch
        columns = [
            np.column_stack([at + self._offset(k), np.full(self.count, (k + 0.5) * self.spacing - 0.5 * self.width)])
            for k in range(self.columns)
        ]
        return np.concatenate(columns) - np.array([0.5 * self.length, 0.0])

    @property
    def outline(self) -> Floats:
        """Return the corners (n, 2) of a hole about its centre, counter-clockwise [m]."""
        half = 0.5 * self.hole
        return polygon(half, SIDES) if self.shape == "round" else square(half)

    @property
    def _start(self) -> float:
        """Return the solid length before the first hole of the first column [m]."""
        return 0.5 * (self.length - self.count * self.pitch - self._offset(1))

    def _offset(self, column: int) -> float:
        return 0.5 * self.pitch if self.staggered and column % 2 else 0.0

    def _nodes(self) -> Floats:
        """Return the nodes along x that all columns share [m]."""
        steps = 4 * self.count + (2 if self.staggered else 0)
        nodes = self._start + 0.25 * self.pitch * np.arange(steps + 1)
        return np.unique(np.round(np.concatenate([[0.0], nodes, [self.length]]), 12))

    def parts(self, low: float, high: float) -> list[Part]:
        """Return the triangles of the plate between two heights [m] about the origin: faces, holes and rim, in one part."""
        nodes, flat, holes, rim = self._nodes(), [], [], []
        outline = self.outline
        for k in range(self.columns):
            a, b = k * self.spacing, (k + 1) * self.spacing
            first = self._start + self._offset(k)
            last = first + self.count * self.pitch
            for start, end in ((0.0, first), (last, self.length)):
                flat += _strip(_between(nodes, start, end), a, b)
            for n in range(self.count):
                middle = np.array([first + (n + 0.5) * self.pitch, 0.5 * (a + b)])
                side = _between(nodes, first + n * self.pitch, first + (n + 1) * self.pitch)
                ring = np.concatenate([_line(side, a), _line(side[::-1], b)])
                flat += _ring(ring, outline + middle)
                holes.append(outline[::-1] + middle)
            rim += [np.array([[0.0, b], [0.0, a]]), np.array([[self.length, a], [self.length, b]])]
        rim += [_line(nodes, 0.0), _line(nodes[::-1], self.width)]
        shift = np.array([0.5 * self.length, 0.5 * self.width])
        plane = np.array(flat) - shift
        faces = [np.stack([lift(t, z) for t in plane]) for z in (low, high)]
        sides = [_wall(np.concatenate([loop, loop[:1]]) - shift, low, high) for loop in holes]
        sides += [_wall(line - shift, low, high) for line in rim]
        return [(np.concatenate([faces[1], flip(faces[0]), *sides]), None)]


def _between(nodes: Floats, start: float, end: float) -> Floats:
    return nodes[(nodes > start - 1e-9) & (nodes < end + 1e-9)]


def _line(x: Floats, y: float) -> Floats:
    return np.column_stack([x, np.full(len(x), y)])


def _strip(x: Floats, low: float, high: float) -> list[Floats]:
    """Return the triangles between two lines with the same nodes."""
    found = []
    for a, b in pairwise(x):
        found += [np.array([[a, low], [b, low], [b, high]]), np.array([[a, low], [b, high], [a, high]])]
    return found


def _ring(outer: Floats, inner: Floats) -> list[Floats]:
    """Return the triangles between two loops (n, 2), both counter-clockwise, shorter diagonals first."""
    far = np.linalg.norm(outer[:, None] - inner[None], axis=2)
    start = np.unravel_index(int(np.argmin(far)), far.shape)
    outer, inner = np.roll(outer, -int(start[0]), axis=0), np.roll(inner, -int(start[1]), axis=0)
    n, m, i, j = len(outer), len(inner), 0, 0
    found = []
    while i < n or j < m:
        a, b, c, d = outer[i % n], outer[(i + 1) % n], inner[j % m], inner[(j + 1) % m]
        if j == m or (i < n and np.linalg.norm(b - c) <= np.linalg.norm(a - d)):
            found.append(np.stack([a, b, c]))
            i += 1
        else:
            found.append(np.stack([a, d, c]))
            j += 1
    return found


def _wall(line: Floats, low: float, high: float) -> Floats:
    """Return upright triangles along a line of points (n, 2), outward to its right."""
    found = []
    for a, b in pairwise(line):
        p, q, r, s = ([*a, low], [*b, low], [*b, high], [*a, high])
        found += [[p, q, r], [p, r, s]]
    return np.array(found)
