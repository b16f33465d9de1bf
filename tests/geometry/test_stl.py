"""Binary STL keeps every bit and the order of the triangles; files that bound no solid are refused."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

from pywet.geometry import Apparatus, read_stl, write_stl
from pywet.geometry.surface import enclosed
from tests.error_codes import raises_code


def test_round_trip_is_exact(apparatus: Apparatus, tmp_path: Path) -> None:
    for surface in apparatus.surfaces:
        path = tmp_path / f"{surface.name}.stl"
        write_stl(surface, path)
        back = read_stl(path)
        np.testing.assert_array_equal(back.corners, surface.corners)
        assert back.name == surface.name
        assert path.stat().st_size == 84 + 50 * len(surface.triangles)
    assert not list(tmp_path.glob(".*"))


def test_open_stl_is_refused(apparatus: Apparatus, tmp_path: Path) -> None:
    slide = next(s for s in apparatus.surfaces if s.name == "slide")
    path = tmp_path / "open.stl"
    meshio.write(path, meshio.Mesh(slide.vertices, [("triangle", slide.triangles[1:])]), binary=True)
    with raises_code("surface.open", key="open"):
        read_stl(path)


@pytest.mark.parametrize("content", [b"", b"solid\nendsolid\n", b"\x00" * 30, b"\x00" * 80 + b"\x05\x00\x00\x00abc"])
def test_damaged_stl_is_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "bad.stl"
    path.write_bytes(content)
    with raises_code("stl.unreadable"):
        read_stl(path)


def test_missing_stl_is_named(tmp_path: Path) -> None:
    with raises_code("stl.missing"):
        read_stl(tmp_path / "nothing.stl")


@pytest.mark.filterwarnings("error")
def test_a_text_file_is_read_like_a_binary_one(tmp_path: Path) -> None:
    """Read a text file as CAD programs write it: it gives the same corners, without a message."""
    corners = 0.01 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    faces = [("triangle", np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]))]
    for name, binary in (("text", False), ("bytes", True)):
        meshio.write(tmp_path / f"{name}.stl", meshio.Mesh(corners, faces), file_format="stl", binary=binary)
    assert (tmp_path / "text.stl").read_text().startswith("solid")
    text, raw = (read_stl(tmp_path / f"{name}.stl") for name in ("text", "bytes"))
    np.testing.assert_array_equal(text.corners, raw.corners)
    assert enclosed(text.corners) == pytest.approx(1e-6 / 6)
