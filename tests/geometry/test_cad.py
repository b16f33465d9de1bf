"""STL files as CAD programs and by-hand exports leave them: repaired and said, or refused with a place."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from pywet.geometry import Surface, make_surface
from pywet.geometry.cad import read_cad
from pywet.geometry.faces import BODIES_DEG, faces, half_width
from pywet.geometry.solids import bin_solid, plate, square, tube, wire
from pywet.geometry.surface import enclosed
from tests.error_codes import raises_code

CUP = np.concatenate([c for c, _ in bin_solid(15.0, 3.0, 4, 0.0, 25.0)])
"""A square cup of 30 mm with walls of 3 mm, 28 triangles [mm]."""
VOLUME = 36.0**2 * 28.0 - 30.0**2 * 25.0
CUBE = np.concatenate([c for c, _ in plate(square(10.0), 0.0, 20.0)])


def text(corners: np.ndarray) -> str:
    facets = [
        "facet normal 0 0 0\n outer loop\n"
        + "".join(f"  vertex {x:.9e} {y:.9e} {z:.9e}\n" for x, y, z in triangle)
        + " endloop\nendfacet\n"
        for triangle in corners
    ]
    return "solid part\n" + "".join(facets) + "endsolid part\n"


def binary(corners: np.ndarray) -> bytes:
    rows = np.zeros(len(corners), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    rows["corners"] = corners
    return b"solid or not".ljust(80) + len(rows).to_bytes(4, "little") + rows.tobytes()


def read(tmp_path: Path, data: bytes | str, shell_m: float | None = None) -> tuple[Surface, str]:
    path = tmp_path / "part.stl"
    path.write_bytes(data if isinstance(data, bytes) else data.encode("latin-1"))
    corners, changes = read_cad(path, 1e-3, None, shell_m)
    return make_surface("part", "wall", faces(corners)), "; ".join(changes)


def jitter(size_mm: float) -> np.ndarray:
    return CUP + np.random.default_rng(1).uniform(-size_mm, size_mm, CUP.shape)


TURNED = np.concatenate([CUP[:1, ::-1], CUP[1:]])
POINT = np.concatenate([CUP, [[CUP[0, 0]] * 3]])


def with_corners_on_an_edge(count: int) -> np.ndarray:
    """The cup with points on an edge that only one of its two facets has, and facets without area that close the surface."""
    a, b, c = CUP[0]
    on = [a + (b - a) * k / (count + 1) for k in range(count + 2)]
    parts = [[p, q, c] for p, q in pairwise(on)]
    return np.concatenate([CUP[1:], parts, [[a, on[k + 1], on[k]] for k in range(1, count + 1)]])


LINE = np.concatenate([CUP, [[CUP[0, 0], CUP[0, 1], 0.5 * (CUP[0, 0] + CUP[0, 1])]]])


@pytest.mark.parametrize(
    ("data", "message", "margin"),
    [
        (text(CUP), "", 1e-6),
        (text(CUP) + "\n", "", 1e-6),
        (text(CUP).replace("\n", "\r\n"), "", 1e-6),
        (text(CUP).upper(), "", 1e-6),
        (text(CUP).replace("solid part", "solid Gefäß vertex"), "", 1e-6),
        (text(CUP).replace(".", ","), "read commas as decimal points", 1e-6),
        (binary(CUP), "", 1e-6),
        (binary(CUP) + b"\r\n", "passed over 2 bytes after its last triangle", 1e-6),
        (text(jitter(1e-4)), "joined 68 vertices nearer than 1 um", 3e-5),
        (text(jitter(5e-6)), "joined 68 vertices nearer than 0.02 um", 3e-6),
        (text(POINT), "removed 1 facets without area", 1e-6),
        (text(LINE), "removed 1 facets without area", 1e-6),
        *((text(with_corners_on_an_edge(n)), f"divided {n} facets at the corner of a facet", 1e-6) for n in (1, 2, 3)),
        (text(np.concatenate([CUP, CUP[3:5]])), "removed 2 repeated facets", 1e-6),
        (text(TURNED), "turned 1 facets that looked the other way", 1e-6),
        (text(CUP[:, ::-1]), "turned 28 facets of a solid that was inside out", 1e-6),
    ],
)
def test_what_is_unambiguous_is_repaired_and_reported(
    data: bytes | str, message: str, margin: float, tmp_path: Path
) -> None:
    """The cup's volume, within what rounding by the export moves it, and its 11 faces."""
    surface, changes = read(tmp_path, data)
    assert message in changes and bool(message) == bool(changes)
    assert enclosed(surface.corners) == pytest.approx(1e-9 * VOLUME, rel=margin)
    assert len(surface.part_half_width) == 11


def test_bodies_that_share_an_edge_are_drawn_apart(tmp_path: Path) -> None:
    """By 2 um: two cubes, four facets at the common edge."""
    surface, changes = read(tmp_path, text(np.concatenate([CUBE, CUBE + np.array([20.0, 20.0, 0.0])])))
    assert changes == "drew bodies 2 um apart at 2 vertices that they share"
    assert surface.components()[0] == 2 and enclosed(surface.corners) == pytest.approx(2 * 8e-6, rel=1e-3)


def test_solids_that_touch_with_a_face_become_one(tmp_path: Path) -> None:
    """Their common facets lie back to back and are no wall."""
    other = CUBE * [-1.0, 1.0, 1.0] + [20.0, 0.0, 0.0]  # a mirror image, so that both divide the face alike
    surface, changes = read(tmp_path, text(np.concatenate([CUBE, other[:, ::-1]])))
    assert "removed 2 pairs of facets back to back" in changes
    assert surface.components()[0] == 1 and enclosed(surface.corners) == pytest.approx(2 * 8e-6, rel=1e-6)


def test_a_cavity_is_a_cavity(tmp_path: Path) -> None:
    surface, changes = read(tmp_path, text(np.concatenate([CUBE, 0.5 * CUBE[:, ::-1] + [0.0, 0.0, 5.0]])))
    assert not changes and enclosed(surface.corners) == pytest.approx(8e-6 - 1e-6, rel=1e-6)


def test_an_open_shell_is_refused_with_its_places_or_given_its_thickness(tmp_path: Path) -> None:
    """A channel of three sheets, 20 mm each, at right angles: walls of 1 mm, half on either side of the sheets."""
    middle = plate(square(10.0), 0.0, 20.0)
    sheet = np.concatenate([middle[1][0], middle[2][0][:4]])  # the floor and two sides
    with raises_code("stl.not_closed"):
        read(tmp_path, text(sheet))
    with raises_code("stl.closed", says="shell_thickness_mm has no effect"):
        read(tmp_path, text(CUP), shell_m=1e-3)
    surface, changes = read(tmp_path, text(sheet), shell_m=1e-3)
    assert "made its open shell a wall of 1 mm" in changes
    low, high = 1e3 * surface.vertices.min(axis=0), 1e3 * surface.vertices.max(axis=0)
    assert enclosed(surface.corners) == pytest.approx(3 * 20.0**2 * 1e-9, rel=0.06)
    assert [low[2], low[1], high[0]] == pytest.approx([-0.5, -10.5, 10.5], abs=1e-4)


def test_what_has_no_inside_is_refused(tmp_path: Path) -> None:
    """A Moebius band of 12 quadrilaterals."""
    angle = 2.0 * np.pi * np.arange(13) / 12
    across = 3.0 * np.stack(
        [np.cos(angle / 2) * np.cos(angle), np.cos(angle / 2) * np.sin(angle), np.sin(angle / 2)], axis=1
    )
    middle = 20.0 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    a, b = middle + across, middle - across
    a[-1], b[-1] = b[0], a[0]
    band = [t for k in range(12) for t in ([a[k], b[k], a[k + 1]], [b[k], b[k + 1], a[k + 1]])]
    with raises_code("stl.not_solid"):
        read(tmp_path, text(np.array(band)))


def test_faces_end_at_folds_and_bodies_are_wires() -> None:
    """A tube of 12 sides (folds of 30 deg) has 4 faces, one of 8 sides (45 deg) 18; rims have half of the wall's thickness."""
    for sides, count in ((12, 4), (8, 18)):
        found = faces(np.concatenate([c for c, _ in tube(0.015, 0.003, sides, 0.0, 0.02)]))
        assert len(found) == count
        assert sorted(h for _, h in found if h is not None)[:2] == pytest.approx([0.0015, 0.0015], rel=1e-5)
    bars = [wire(np.array([0.0, y, 0.0]), np.array([0.03, y, 0.0]), 1e-3, 8, 1.1) for y in (0.0, 0.01)]
    assert [len(c) for c, _ in faces(np.concatenate(bars), BODIES_DEG)] == [len(b) for b in bars]
    tilted = (
        plate(square(0.003) * [1.0, 4.0], 0.0, 0.001)[0][0]
        @ np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    )
    assert half_width(tilted) == pytest.approx(0.003, rel=1e-5)
