"""The plugin's records and the schema that reads them have the same sizes."""

from __future__ import annotations

import re

import pytest

from pywet.engines.liggghts.build import SOURCES
from pywet.schema import RAW

SIZES = dict(re.findall(r"sizeof\((\w+)\) == (\d+)", (SOURCES / "records.h").read_text()))


@pytest.mark.parametrize(
    ("name", "table"),
    [
        ("Event", "events"),
        ("Contact", "contacts"),
        ("Ledger", "ledger"),
        ("BridgeSnapshot", "bridges"),
        ("Film", "films"),
        ("Film", "wall_films"),
        ("WireContact", "wire_springs"),
        ("Drop", "drops"),
    ],
)
def test_record_sizes(name: str, table: str) -> None:
    """static_assert holds the C++ side to the number in the header, this the Python side."""
    assert int(SIZES[name]) == RAW[table].itemsize
