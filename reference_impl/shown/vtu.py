"""Read VTK's XML files without VTK or meshio, as far as needed for time series of points, lines and triangles.

Values are encoded in the text as base64: a header (number of blocks, size of a block, of the last one, compressed
sizes), then the blocks, compressed by zlib.
"""

from __future__ import annotations

import base64
import xml.etree.ElementTree as ET
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from reference_impl.replay.arrays import Floats
from reference_impl.replay.io import ReplayError

TYPES = {
    "Float64": "<f8",
    "Float32": "<f4",
    "Int64": "<i8",
    "Int32": "<i4",
    "Int8": "<i1",
    "UInt8": "<u1",
    "UInt32": "<u4",
}
AGAIN = "write it again with pywet view"


@dataclass(frozen=True)
class Shown:
    """One file: points (n, 3), the points of each cell, and arrays by name."""

    points: Floats
    cells: Floats
    """Point numbers of each cell, shape (cells, points of a cell); (0, 0) for none."""
    of_points: dict[str, Floats]
    of_cells: dict[str, Floats]
    words: dict[str, list[str]]
    """Text fields of the whole file."""


def series(path: Path) -> list[tuple[float, Path]]:
    """Return time [s] and file of each entry of a .pvd file, in its order."""
    entries = _root(path, "Collection").findall("./Collection/DataSet")
    try:
        return [(float(entry.attrib["timestep"]), path.parent / entry.attrib["file"]) for entry in entries]
    except (KeyError, ValueError) as error:
        raise ReplayError(f"{path} has an entry without time or file ({error}); expected a series: {AGAIN}") from error


def read(path: Path) -> Shown:
    """Read the arrays of a .vtu file."""
    root = _root(path, "UnstructuredGrid")
    header = TYPES[root.attrib.get("header_type", "UInt32")]
    try:
        words = {
            a.attrib["Name"]: _bytes(a, header).decode().split("\0")[: int(a.attrib["NumberOfTuples"])]
            for a in root.findall("./UnstructuredGrid/FieldData/Array")
            if a.attrib["type"] == "String"
        }
        pieces = root.findall("./UnstructuredGrid/Piece")
        if not pieces or pieces[0].attrib["NumberOfPoints"] == "0":
            return Shown(np.zeros((0, 3)), np.zeros((0, 0), int), {}, {}, words)
        (piece,) = pieces
        arrays = {
            group: {a.attrib["Name"]: _values(a, header) for a in piece.findall(f"./{group}/DataArray")}
            for group in ("PointData", "CellData", "Cells")
        }
        (points,) = (_values(a, header) for a in piece.findall("./Points/DataArray"))
        count = int(piece.attrib["NumberOfCells"])
        cells = arrays["Cells"]["connectivity"].reshape(count, -1)
        if not np.array_equal(arrays["Cells"]["offsets"], np.arange(1, count + 1) * cells.shape[1]):
            raise ValueError("cells of different sizes")
    except (KeyError, ValueError, zlib.error, UnicodeDecodeError) as error:
        raise ReplayError(f"{path} cannot be read ({error!r}); expected a VTK file of points, lines or triangles: "
                          f"{AGAIN}") from error  # fmt: skip
    return Shown(points, cells, arrays["PointData"], arrays["CellData"], words)


def _root(path: Path, kind: str) -> ET.Element:
    try:
        root = ET.parse(path).getroot()
    except (OSError, ET.ParseError) as error:
        raise ReplayError(f"{path} cannot be read ({error}); expected a VTK file: {AGAIN}") from error
    if root.tag != "VTKFile" or root.attrib.get("type") != kind or root.attrib["byte_order"] != "LittleEndian":
        raise ReplayError(f"{path} is no little-endian VTK file of type {kind}: {AGAIN}")
    return root


def _values(array: ET.Element, header: str) -> Floats:
    values = np.frombuffer(_bytes(array, header), TYPES[array.attrib["type"]])
    parts = int(array.attrib.get("NumberOfComponents", "1"))
    return values.reshape(-1, parts) if parts > 1 else values


def _bytes(array: ET.Element, header: str) -> bytes:
    """Return the bytes of one array; header and blocks are separately encoded in base64."""
    text, wide = "".join((array.text or "").split()), np.dtype(header).itemsize
    count = int(np.frombuffer(base64.b64decode(text[: _coded(wide)])[:wide], header)[0])
    end = _coded((3 + count) * wide)
    sizes = np.frombuffer(base64.b64decode(text[:end]), header)[3 : 3 + count].astype(int)
    data, at = base64.b64decode(text[end:]), np.concatenate([[0], np.cumsum(sizes)])
    return b"".join(zlib.decompress(data[at[k] : at[k + 1]]) for k in range(count))


def _coded(size: int) -> int:
    """Return the number of base64 characters that encode this many bytes."""
    return (size + 2) // 3 * 4
