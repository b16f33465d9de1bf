"""A mesh in a periodic box: what counts at its seam is what counts in the middle of a mesh that is as long as its copies."""

from __future__ import annotations

import numpy as np

from reference_impl.motion import mesh

LENGTH, SIDES = 0.02, 6


def rod(parts: int) -> np.ndarray:
    """Triangles of a six-sided rod along y without ends, `parts` lengths long, a ring of nodes at each half length."""
    angle = 2.0 * np.pi * np.arange(SIDES) / SIDES
    ring = np.stack([np.cos(angle), np.zeros(SIDES), np.sin(angle)], axis=1) * 1e-3
    found = []
    for n in range(2 * parts):
        one, two = (ring + np.array([0.0, 0.5 * LENGTH * k, 0.0]) for k in (n, n + 1))
        for k in range(SIDES):
            m = (k + 1) % SIDES
            found += [(one[k], two[k], two[m]), (one[k], two[m], one[m])]
    return np.array(found)


def test_the_seam_of_a_rod_is_its_middle() -> None:
    """Without copies the end of a rod has active edges; with them its ridges alone count, and no corner."""
    one, long = rod(1), mesh.topology(rod(3))
    ways = [np.array([0.0, sign * LENGTH, 0.0]) for sign in (-1.0, 1.0)]
    joined, middle = mesh.repeated(one, ways), slice(len(one), 2 * len(one))
    assert (joined.edge_active[: len(one)] == long.edge_active[middle]).all()
    assert (joined.corner_active[: len(one)] == long.corner_active[middle]).all() and not joined.corner_active.any()
    assert {t: {s % len(one) for s in long.plane[len(one) + t]} - {t} for t in range(len(one))} == joined.plane
    assert (mesh.topology(one).edge_active != joined.edge_active[: len(one)]).sum() == 2 * SIDES
