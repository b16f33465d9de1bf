"""Read and write surfaces as STL.

Triangles keep their order; an STL file has no parts.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from pywet.errors import PywetError
from pywet.geometry.surface import Floats, Surface, make_surface
from pywet.util.files import atomic_write

HEAD = 84
"""Number of bytes of a binary file before its triangles."""
RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def write_stl(surface: Surface, path: Path) -> None:
    """Write the triangles in their order; coordinates are single precision already, so nothing is lost."""
    import meshio

    mesh = meshio.Mesh(surface.vertices, [("triangle", surface.triangles)])
    with atomic_write(Path(path)) as temporary:
        meshio.write(temporary, mesh, file_format="stl", binary=True)


def write_first_triangle(stl: Path, path: Path) -> None:
    """Write a binary STL file that contains only the first triangle of another one."""
    data = Path(stl).read_bytes()
    with atomic_write(Path(path)) as temporary:
        temporary.write_bytes(data[: HEAD - 4] + (1).to_bytes(4, "little") + data[HEAD : HEAD + RECORD.itemsize])


def corners_in(path: Path) -> tuple[Floats, list[str]]:
    """Return the corners (m, 3, 3) as stored in a file, text or binary, and sentences on skipped or reinterpreted content."""
    if not path.is_file():
        sentence = f"no STL file at {path}; expected the path of a surface mesh, a regular file"
        raise PywetError(sentence, code="stl.missing", where=path)
    data, changes = path.read_bytes(), []
    count = int.from_bytes(data[HEAD - 4 : HEAD], "little") if len(data) >= HEAD else 0
    size = HEAD + RECORD.itemsize * count
    if count and size <= len(data) < size + RECORD.itemsize:
        if len(data) > size:
            changes.append(f"passed over {len(data) - size} bytes after its last triangle")
        return np.frombuffer(data, RECORD, count, HEAD)["corners"].astype(np.float64), changes
    words = re.findall(r"^\s*vertex\s+(\S+)\s+(\S+)\s+(\S+)", data.decode("latin-1"), re.IGNORECASE | re.MULTILINE)
    if any("," in word for three in words[:1] for word in three):
        words = [tuple(word.replace(",", ".") for word in three) for three in words]
        changes.append("read commas as decimal points")
    try:
        return np.array(words, dtype=np.float64).reshape(-1, 3, 3), changes
    except ValueError as error:
        raise _unreadable(path, error) from error


def _unreadable(path: Path, why: object) -> PywetError:
    sentence = f"{path} is not a readable STL file with triangles ({why}); export it again"
    return PywetError(sentence, code="stl.unreadable", where=path)


def read_stl(path: Path, name: str | None = None) -> Surface:
    """Read an STL file (text or binary) in metres as a checked wall of one part; open or damaged files raise `PywetError`."""
    corners, _ = corners_in(Path(path))
    if not len(corners):
        raise _unreadable(path, "it holds none")
    return make_surface(name or Path(path).stem, "wall", [(corners, None)])
