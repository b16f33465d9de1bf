"""Read and write surfaces as binary STL, by meshio, which is imported when needed.

Triangles keep their order; an STL file has no parts.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pywet.errors import PywetError
from pywet.geometry.surface import Surface, make_surface
from pywet.util.files import atomic_write


def write_stl(surface: Surface, path: Path) -> None:
    """Write the triangles in their order; coordinates are single precision already, so nothing is lost."""
    import meshio

    mesh = meshio.Mesh(surface.vertices, [("triangle", surface.triangles)])
    with atomic_write(Path(path)) as temporary:
        meshio.write(temporary, mesh, file_format="stl", binary=True)


def write_first_triangle(stl: Path, path: Path) -> None:
    """Write a binary STL file that contains only the first triangle of another one."""
    head, count, record = 80, 4, 50  # bytes: text, number of triangles, one triangle
    data = Path(stl).read_bytes()
    with atomic_write(Path(path)) as temporary:
        temporary.write_bytes(data[:head] + (1).to_bytes(count, "little") + data[head + count : head + count + record])


def missing(path: Path) -> PywetError:
    """Return the error of an STL file that does not exist."""
    sentence = f"no STL file at {path}; expected the path of a surface mesh, a regular file"
    return PywetError(sentence, code="stl.missing", where=path)


def unreadable(path: Path, error: BaseException) -> PywetError:
    """Return the error of a file that is no STL file."""
    sentence = f"{path} is not a readable STL file with triangles ({error}); export it again"
    return PywetError(sentence, code="stl.unreadable", where=path)


def read_stl(path: Path, name: str | None = None) -> Surface:
    """Read an STL file (text or binary) in metres as a checked wall of one part; open or damaged files raise `PywetError`."""
    import meshio

    path = Path(path)
    if not path.is_file():
        raise missing(path)
    try:
        # meshio reads the text of an ASCII file as a number of triangles before it checks
        with np.errstate(over="ignore"):
            mesh = meshio.read(path, file_format="stl")
        triangles = np.concatenate([c.data for c in mesh.cells if c.type == "triangle"])
        corners = np.asarray(mesh.points, dtype=np.float64)[triangles]
    except (meshio.ReadError, ValueError, IndexError, UnicodeDecodeError, SystemExit) as error:
        raise unreadable(path, error) from error
    return make_surface(name or path.stem, "wall", [(corners, None)])
