"""The table of typical scenes that docs/effects.md opens with."""

from __future__ import annotations

from pathlib import Path

from studies.effects import typical

PAGE = (Path(__file__).parents[3] / "docs" / "effects.md").read_text()


def test_the_table_of_the_page_is_that_of_the_plans() -> None:
    rows = typical.rows()
    assert "\n".join(rows) == PAGE.split("<!-- typical -->\n")[1].split("\n<!-- end of typical -->")[0]
    (drag,) = [row for row in rows if "`viscous_normal`" in row]
    # without moving spheres
    assert [cell.strip().split(",")[0] for cell in drag.split("|")[2:5]] == ["on", "on", "**off**"]
