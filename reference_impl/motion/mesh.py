"""Contacts of spheres with the triangles of a mesh by the rules of LIGGGHTS 3.8.0.

In its sources (tri_mesh_I.h, surface_mesh_I.h) every triangle has its own contact, with its face, or with an active
edge or corner. Of two triangles at an angle the later one owns their edge; edges within a plane are inactive. Next to
a convex edge the face of one and the edge of the other triangle therefore both exert a force.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from reference_impl.replay.arrays import Floats

COPLANAR = 1.0 - 1e-5
"""Cosine between normals above which the engine treats two triangles as coplanar."""
PRECISION = 1e-8
TINY = 1e-10
FACE = 7
NOTHING = 1e6
"""Distance [m] assigned if an inactive edge or corner is the closest feature."""


@dataclass(frozen=True)
class Topology:
    """Per triangle of one mesh: edges (k from corner k to k + 1), which edges and corners are active, coplanar neighbours."""

    corners: Floats
    edge: Floats
    length: Floats
    normal: Floats
    edge_active: Floats
    corner_active: Floats
    obtuse: Floats
    bound: Floats
    plane: dict[int, frozenset[int]]


def topology(corners: Floats, apart: bool = False, numbers: int | None = None) -> Topology:
    """Work out one mesh (n, 3, 3), triangles in file order; `apart`: no triangle hands its contact on to the next.

    `numbers`: after so many triangles follow their copies in the same order, which have the same numbers.
    """
    numbers = numbers or len(corners)
    edge = np.roll(corners, -1, axis=1) - corners
    length = np.linalg.norm(edge, axis=2)
    edge = edge / length[:, :, None]
    normal = np.cross(edge[:, 0], edge[:, 1])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    active = np.ones((len(corners), 3), dtype=bool)
    nodes = _nodes(corners)
    neighbours: dict[int, set[int]] = defaultdict(set)
    shared: dict[tuple[int, int], list[tuple[int, int]]] = defaultdict(list)
    for t, row in enumerate(nodes):
        for k in range(3):
            shared[min(row[k], row[(k + 1) % 3]), max(row[k], row[(k + 1) % 3])].append((t, k))
    for sides in shared.values():
        sides.sort(key=lambda side: side[0] % numbers)
        for n, (high, e) in enumerate(sides):
            for low, f in sides[:n]:
                neighbours[high].add(low)
                neighbours[low].add(high)
                flat = abs(normal[high] @ normal[low]) >= COPLANAR
                active[low, f] = False
                active[high, e] = not (flat and not _overlap(corners, edge, normal, (high, e), (low, f)))
    at_node: dict[int, list[tuple[int, int]]] = defaultdict(list)
    for t, row in enumerate(nodes):
        for k in range(3):
            at_node[row[k]].append((t, k))
    corner = np.zeros((len(corners), 3), dtype=bool)
    for meeting in at_node.values():
        for group in _connected(meeting, neighbours):
            t, k = max(group, key=lambda one: one[0] % numbers)
            if min(s for s, _ in group) < numbers:  # for other triangles some periodic copies are missing
                corner[t % numbers, k] = _corner_active(group, edge, nodes, active)
    # the engine stores only the result of the last corner
    obtuse = np.where(np.einsum("ij,ij->i", edge[:, 2], edge[:, 1]) > 0.0, 2, -1)
    bound = np.linalg.norm(corners - corners.mean(axis=1, keepdims=True), axis=2).max(axis=1)
    return Topology(
        corners, edge, length, normal, active, corner, obtuse, bound,
        _planes({} if apart else at_node, normal, len(corners)),
    )  # fmt: skip


def repeated(corners: Floats, ways: Sequence[Floats], apart: bool = False) -> Topology:
    """Compute the topology of a mesh in a periodic box: its own triangles, then those of its copies in the same order.

    The engine joins triangles to those of copies, each known by its number.
    """
    count = len(corners)
    whole = topology(np.concatenate([corners, *(corners + way for way in ways)]), apart, count)
    first = {name: getattr(whole, name)[:count] for name in ("edge_active", "corner_active")}
    tiled = {name: np.concatenate([values] * (1 + len(ways))) for name, values in first.items()}
    plane = {t: frozenset(s % count for s in whole.plane[t]) - {t} for t in range(count)}
    return replace(whole, plane=plane, **tiled)


def _nodes(corners: Floats) -> list[list[int]]:
    """Return the node of each corner; corners within the engine's precision are one node."""
    flat = np.round(corners.reshape(-1, 3) / PRECISION).astype(np.int64)
    _, number = np.unique(flat, axis=0, return_inverse=True)
    return [list(map(int, row)) for row in number.reshape(-1, 3)]


def _overlap(corners: Floats, edge: Floats, normal: Floats, one: tuple[int, int], two: tuple[int, int]) -> bool:
    """Return whether two triangles in one plane lie on the same side of their edge."""
    (i, e), (j, f) = one, two
    out = np.cross(edge[i, e], normal[i])
    base = corners[i, e]
    return bool(((corners[i, (e + 2) % 3] - base) @ out) * ((corners[j, (f + 2) % 3] - base) @ out) > 0.0)


def _connected(meeting: list[tuple[int, int]], neighbours: dict[int, set[int]]) -> list[list[tuple[int, int]]]:
    """Return the triangles at a node, in groups connected by edges."""
    left, groups = dict(meeting), []
    while left:
        start = next(iter(left))
        group, todo = [], [start]
        while todo:
            t = todo.pop()
            if t in left:
                group.append((t, left.pop(t)))
                todo += [n for n in neighbours[t] if n in left]
        groups.append(group)
    return groups


def _corner_active(group: list[tuple[int, int]], edge: Floats, nodes: list[list[int]], active: Floats) -> bool:
    """Return whether a corner is active: an active edge ends there, no two edges are collinear, the last triangle owns it."""
    arms = [(edge[t, k], nodes[t][(k + 1) % 3]) for t, k in group] + [
        (edge[t, k - 1], nodes[t][k - 1]) for t, k in group
    ]
    way, end = np.array([a[0] for a in arms]), np.array([a[1] for a in arms])
    lined = (np.abs(way @ way.T) > COPLANAR) & (end[:, None] != end[None, :])
    return bool(any(active[t, k] or active[t, k - 1] for t, k in group) and not lined.any())


def _planes(at_node: dict[int, list[tuple[int, int]]], normal: Floats, count: int) -> dict[int, frozenset[int]]:
    """Return for each triangle those in its plane that share a corner with it."""
    found: dict[int, set[int]] = {t: set() for t in range(count)}
    for meeting in at_node.values():
        for s, _ in meeting:
            found[s] |= {t for t, _ in meeting if t != s and abs(normal[s] @ normal[t]) > COPLANAR}
    return {t: frozenset(v) for t, v in found.items()}


def resolve(mesh: Topology, t: Floats, p: Floats) -> tuple[Floats, Floats, Floats]:
    """Return distance, point and kind (FACE or not) of the engine's contacts between centres p (n, 3) and triangles t (n)."""
    corners, edge, length = mesh.corners[t], mesh.edge[t], mesh.length[t]
    from_0 = p - corners[:, 0]
    a, b = (np.einsum("ij,ij->i", from_0, edge[:, k]) for k in (0, 2))
    c = np.einsum("ij,ij->i", edge[:, 0], edge[:, 2])
    bary = np.empty((len(t), 3))
    bary[:, 1] = (a - b * c) / (length[:, 0] * (1.0 - c * c))
    bary[:, 2] = (a * c - b) / (length[:, 2] * (1.0 - c * c))
    bary[:, 0] = 1.0 - bary[:, 1] - bary[:, 2]
    kind = ((bary > -PRECISION / (2.0 * mesh.bound[t])[:, None]) * np.array([1, 2, 4])).sum(axis=1)
    point, there = np.empty_like(p), np.ones(len(t), dtype=bool)
    face = kind == FACE
    lift = np.einsum("ij,ij->i", from_0, mesh.normal[t])
    point[face] = (p - lift[:, None] * mesh.normal[t])[face]
    for code, k in ((3, 0), (6, 1), (5, 2)):
        _edge(mesh, t, p, np.flatnonzero(kind == code), k, point, there)
    for code, k in ((1, 0), (2, 1), (4, 2)):
        _corner(mesh, t, p, np.flatnonzero(kind == code), k, point, there)
    distance = np.linalg.norm(point - p, axis=1)
    return np.where(there, distance, NOTHING), point, kind


def _edge(mesh: Topology, t: Floats, p: Floats, at: Floats, k: int, point: Floats, there: Floats) -> None:
    """Set the closest point beyond edge k: on the edge, or the corner at its end."""
    s, n = t[at], (k + 1) % 3
    along = np.einsum("ij,ij->i", p[at] - mesh.corners[s, k], mesh.edge[s, k])
    before, behind = along < -TINY, along > mesh.length[s, k] + TINY
    found = mesh.corners[s, k] + along[:, None] * mesh.edge[s, k]
    found = np.where(before[:, None], mesh.corners[s, k], np.where(behind[:, None], mesh.corners[s, n], found))
    point[at] = found
    there[at] = np.where(
        before, mesh.corner_active[s, k], np.where(behind, mesh.corner_active[s, n], mesh.edge_active[s, k])
    )


def _corner(mesh: Topology, t: Floats, p: Floats, at: Floats, k: int, point: Floats, there: Floats) -> None:
    """Set the closest point beyond corner k: the corner, or on one of its edges if its angle is obtuse."""
    s, n, m = t[at], (k + 1) % 3, (k + 2) % 3
    point[at], there[at] = mesh.corners[s, k], mesh.corner_active[s, k]
    from_k = p[at] - mesh.corners[s, k]
    back = np.einsum("ij,ij->i", from_k, mesh.edge[s, m])
    on = np.einsum("ij,ij->i", from_k, mesh.edge[s, k])
    wide = mesh.obtuse[s] == k
    for along, e, end, ok, full in (
        (back, m, m, wide & (back < TINY), back > -mesh.length[s, m]),
        (on, k, n, wide & (back >= TINY) & (on > -TINY), on < mesh.length[s, k]),
    ):
        for which, active, where in (
            (ok & full, mesh.edge_active[s, e], mesh.corners[s, k] + along[:, None] * mesh.edge[s, e]),
            (ok & ~full, mesh.corner_active[s, end], mesh.corners[s, end]),
        ):
            point[at[which]], there[at[which]] = where[which], active[which]
