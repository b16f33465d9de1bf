"""Surfaces to and from binary STL, by meshio. The order of the triangles is kept; parts are not part of an STL file."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np

from pywet.errors import PywetError
from pywet.files import atomic_write
from pywet.geometry.surface import Motion, Surface, make_surface
from pywet.scene import Holder


def write_stl(surface: Surface, path: Path) -> None:
    """Write the triangles in their order; coordinates are single precision already, so nothing is lost."""
    mesh = meshio.Mesh(surface.vertices, [("triangle", surface.triangles)])
    with atomic_write(Path(path)) as temporary:
        meshio.write(temporary, mesh, file_format="stl", binary=True)


def read_stl(
    path: Path,
    holder: Holder = "wall",
    name: str | None = None,
    motion: Motion = "fixed",
    half_width: float | None = None,
) -> Surface:
    """Read an STL file (text or binary) as a checked surface of one part; open or damaged files raise `PywetError`."""
    path = Path(path)
    if not path.is_file():
        raise PywetError(f"no STL file at {path}; give the path of a surface mesh")
    try:
        mesh = meshio.read(path, file_format="stl")
        triangles = np.concatenate([c.data for c in mesh.cells if c.type == "triangle"])
        corners = np.asarray(mesh.points, dtype=np.float64)[triangles]
    except (meshio.ReadError, ValueError, IndexError, UnicodeDecodeError, SystemExit) as error:
        raise PywetError(f"{path} is not a readable STL file with triangles ({error}); export it again") from error
    return make_surface(name or path.stem, holder, [(corners, half_width)], motion)
