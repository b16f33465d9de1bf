"""Compare the numbers of a page, which are marked with their keys, with those in report.json next to it.

Text of the page other than numbers and labels is not read.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from html.parser import HTMLParser
from itertools import combinations
from typing import Any

Numbers = Mapping[str, Mapping[str, Any]]
LABEL = "label."
"""Prefix of the keys of labels of rows and columns; the value is the common part of the keys of their cells."""
NOT_ON_THE_PAGE = ("figure.", "label.word.")
"""Prefixes of keys of labels in pictures."""


@dataclass
class Datum:
    """A number as shown on the page."""

    key: str
    value: str
    shown: str = ""


@dataclass
class Cell:
    """A cell of a table: number of columns that it spans, and its content."""

    span: int
    head: bool
    data: list[Datum] = field(default_factory=list)


class Page(HTMLParser):
    """All numbers of a page, and its tables as rows of cells."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.data: list[Datum] = []
        self.tables: list[list[list[Cell]]] = []
        self._open: Datum | None = None
        self._cell: Cell | None = None
        self.feed(re.sub(r"<(script|style|svg)\b.*?</\1>", "", text, flags=re.DOTALL))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Open a table, a row, a cell or a number."""
        of = {name: value or "" for name, value in attrs}
        if tag == "table":
            self.tables.append([])
        elif tag == "tr" and self.tables:
            self.tables[-1].append([])
        elif tag in ("td", "th") and self.tables and self.tables[-1]:
            self._cell = Cell(int(of.get("colspan") or 1), tag == "th")
            self.tables[-1][-1].append(self._cell)
        elif tag == "data":
            self._open = Datum(of.get("data-key", ""), of.get("value", ""))
            self.data.append(self._open)
            if self._cell is not None:
                self._cell.data.append(self._open)

    def handle_endtag(self, tag: str) -> None:
        """Close a cell or a number."""
        if tag == "data":
            self._open = None
        elif tag in ("td", "th"):
            self._cell = None

    def handle_data(self, data: str) -> None:
        """Read the text of a number."""
        if self._open is not None:
            self._open.shown += data


def wrong(page: Page, numbers: Numbers) -> Iterator[str]:
    """Yield sentences on numbers of the page that differ from report.json, and on those in a wrong row or column."""
    for of in page.data:
        stored = numbers.get(of.key)
        if stored is None:
            yield f"{of.key}: {of.shown!r} is shown; report.json has no such key"
        elif of.shown.split() != stored["shown"].split():
            yield f"{of.key}: {of.shown!r} is shown; report.json has {stored['shown']!r}"
        elif of.value != (stored["value"] if isinstance(stored["value"], str) else json.dumps(stored["value"])):
            yield f"{of.key}: the page has the value {of.value}; report.json has {stored['value']}"
        elif of.key.startswith(LABEL) and not of.key.endswith(stored["value"]):
            yield f"{of.key}: its value is {stored['value']!r}; expected the end of its key"
    there = {of.key for of in page.data}
    for key in numbers:
        if key not in there and not key.startswith(NOT_ON_THE_PAGE):
            yield f"{key}: it is in report.json but not on the page"
    for rows in page.tables:
        yield from _misplaced(rows)


def _misplaced(rows: list[list[Cell]]) -> Iterator[str]:
    """Yield numbers of a table whose key does not match their row and column, and labels shared by two columns or rows."""
    heads: dict[int, Datum] = {}
    labels: list[Datum] = []
    for row in rows:
        at = 0
        for k, cell in enumerate(row):
            label = next((of for of in cell.data if of.key.startswith(LABEL)), None)
            if label is not None:
                labels.append(label)
            if cell.head and label is not None:
                heads[at] = label
            first = next((of for of in row[0].data if of.key.startswith(LABEL)), None) if k else None
            for of in cell.data:
                for what, by in (("column", heads.get(at)), ("row", first)):
                    if by is not None and not of.key.startswith(LABEL) and f".{by.value}." not in f".{of.key}.":
                        yield f"{of.key}: it is in the {what} {by.shown!r}, which is for {by.value}"
            at += cell.span
    for one, two in combinations({of.key: of for of in labels}.values(), 2):
        if one.shown == two.shown:
            yield f"{one.key} and {two.key}: both are called {one.shown!r} in one table"
