"""The plugin's records are those of the schema, field by field."""

from __future__ import annotations

import re

import numpy as np
import pytest

from pywet import schema
from pywet.engines.liggghts.build import SOURCES

HEADER = (SOURCES / "records.h").read_text()
KINDS = {"int32_t": "<i4", "int64_t": "<i8", "double": "<f8"}
STRUCTS = dict(re.findall(r"struct (\w+) \{\n(.*?)\n\};", HEADER.partition("#pragma pack(push, 1)")[2], re.DOTALL))
TABLES = {
    "Event": ("events",), "Contact": ("contacts",), "Ledger": ("ledger",), "BridgeSnapshot": ("bridges",),
    "Energy": ("energy", "window_energy"), "Impulse": ("impulses",),
    "Film": ("films", "wall_films"), "Drop": ("drops",), "Felt": ("felt",), "WireContact": ("wire_springs",),
    "RetiredSphere": ("retired",), "State": ("states",), "Pose": ("poses",),
}  # fmt: skip


def record(struct: str) -> np.dtype:
    """A packed struct as numpy reads it."""
    fields: list[tuple[str, str] | tuple[str, str, int]] = []
    for kind, names in re.findall(r"^\s*(\w+) ([\w\[\], ]+);", struct, re.MULTILINE):
        for name, many in re.findall(r"(\w+)(?:\[(\d+)\])?", names):
            fields.append((name, KINDS[kind], int(many)) if many else (name, KINDS[kind]))
    return np.dtype(fields)


def test_every_record_has_a_table() -> None:
    assert set(STRUCTS) == set(TABLES)
    assert {table for tables in TABLES.values() for table in tables} == set(schema.RAW)


@pytest.mark.parametrize(("name", "table"), [(name, table) for name, tables in TABLES.items() for table in tables])
def test_fields_have_one_name_type_and_order(name: str, table: str) -> None:
    """Packed, so that offsets follow; the compiler holds the size of each struct to the number in the header."""
    struct = STRUCTS[name] if table != "wall_films" else STRUCTS[name].replace(" id,", " triangle,")
    assert record(struct) == schema.RAW[table]
    assert f"sizeof({name}) == {schema.RAW[table].itemsize}," in HEADER


def test_two_fields_that_change_places_are_found() -> None:
    """Exchange two fields of equal size, which the sizes alone do not reveal."""
    swapped = STRUCTS["Ledger"].replace("films, bridges", "bridges, films")
    assert record(swapped).itemsize == schema.RAW["ledger"].itemsize and record(swapped) != schema.RAW["ledger"]
