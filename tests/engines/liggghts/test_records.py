"""The plugin's records and the schema that reads them have the same sizes."""

from __future__ import annotations

import re

import pytest

from pywet.engines.liggghts.build import SOURCES
from pywet.schema import BRIDGE, CONTACT, DROP, EVENT, FILM, LEDGER, WALL_FILM, WIRE_SPRING

SIZES = dict(re.findall(r"sizeof\((\w+)\) == (\d+)", (SOURCES / "records.h").read_text()))


@pytest.mark.parametrize(
    ("name", "dtype"),
    [
        ("Event", EVENT),
        ("Contact", CONTACT),
        ("Ledger", LEDGER),
        ("BridgeSnapshot", BRIDGE),
        ("Film", FILM),
        ("Film", WALL_FILM),
        ("WireContact", WIRE_SPRING),
        ("Drop", DROP),
    ],
)
def test_record_sizes(name: str, dtype: object) -> None:
    """static_assert holds the C++ side to the number in the header, this the Python side."""
    assert int(SIZES[name]) == dtype.itemsize  # type: ignore[attr-defined]
