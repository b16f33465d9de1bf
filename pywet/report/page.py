"""Common layout of the pages next to the screening report: cards on top, then sections with pictures and tables.

A page is one HTML file with its pictures inside. The caller provides contents and colours.
"""

from __future__ import annotations

import base64
import html
import io
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import jinja2
import numpy as np
from matplotlib.figure import Figure

from pywet.report.embedded_json import embedded
from pywet.report.pictures import DPI, inline, plt, svg
from pywet.util.files import atomic_write

TEMPLATE = Path(__file__).with_name("page.html.j2")
Grade = Literal["good", "fair", "bad", "none", ""]


@dataclass(frozen=True)
class Card:
    """One number at the top of a page."""

    value: str
    text: str
    state: Literal["good", "fair", "bad", ""] = ""


@dataclass(frozen=True)
class Section:
    """A heading with its HTML body; `short` is its name in the navigation."""

    heading: str
    body: str
    short: str = ""

    @property
    def anchor(self) -> str:
        """Return the name of the section in links."""
        return re.sub(r"[^a-z0-9]+", "-", (self.short or self.heading).lower()).strip("-")


@dataclass(frozen=True)
class Cell:
    """A table's cell: text, colour, tooltip and link."""

    text: str
    grade: Grade = ""
    hint: str = ""
    link: str = ""
    left: bool = False

    @property
    def html(self) -> str:
        names = " ".join(n for n in (self.grade, "left" if self.left else "") if n)
        text = marked(self.text)
        inner = f'<a href="{html.escape(self.link)}">{text}</a>' if self.link else text
        hint = f' title="{html.escape(self.hint)}"' if self.hint else ""
        return f'<td class="{names}"{hint}>{inner}</td>' if names else f"<td{hint}>{inner}</td>"


Rows = list[list[Cell | str]]


def left(text: object, grade: Grade = "") -> Cell:
    """Make a table cell with left-aligned text."""
    return Cell(str(text), grade, left=True)


def paragraph(text: str, soft: bool = False) -> str:
    """Return a paragraph of plain text."""
    return f'<p class="soft">{marked(text)}</p>' if soft else f"<p>{marked(text)}</p>"


def folded(summary: str, body: str) -> str:
    """HTML that is shown on a click on its summary."""
    return f"<details><summary>{marked(summary)}</summary>{body}</details>"


def marked(text: str) -> str:
    """Convert plain text to HTML; `code` between backquotes."""
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", html.escape(text))


def table(header: Sequence[str], rows: Sequence[Sequence[Cell | str]]) -> str:
    """A table; a plain string is a cell without colour. A heading is aligned as the cells below it."""
    cells = [[c if isinstance(c, Cell) else Cell(c) for c in row] for row in rows]
    at_left = [bool(cells) and all(row[k].left for row in cells) for k in range(len(header))]
    head = "".join(
        f'<th class="left">{html.escape(h)}</th>' if of_text else f"<th>{html.escape(h)}</th>"
        for h, of_text in zip(header, at_left, strict=True)
    )
    body = "".join("<tr>" + "".join(cell.html for cell in row) + "</tr>\n" for row in cells)
    return f'<div class="scroll"><table><tr>{head}</tr>\n{body}</table></div>'


def table_of(rows: Iterable[Any], columns: Mapping[str, Callable[[Any], Cell | str]]) -> str:
    """Return a table with a row for each of `rows`; `columns`: header -> function for the cell."""
    return table(list(columns), [[cell(row) for cell in columns.values()] for row in rows])


def picture(figure: Figure, caption: str, vector: bool = True) -> str:
    """Embed a matplotlib figure with its caption in the page and close it; `vector` False for many thousand points."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="svg" if vector else "png", bbox_inches="tight", dpi=DPI)
    plt.close(figure)
    return _figure(buffer.getvalue(), "svg" if vector else "png", caption)


def curves(figure: Figure, name: str, caption: str = "", drawn_only: bool = False) -> str:
    """Return a figure as SVG text with its caption, and its lines as JSON, which the page offers as CSV; it is closed.

    Lines across the axes, which mark one value, are not curves. `drawn_only`: a picture without curves, offered only as SVG.
    """
    lines = [
        {"label": str(line.get_label()).removeprefix("_"), "x": np.asarray(line.get_xdata()).tolist(),
         "y": np.asarray(line.get_ydata(), float).tolist()}
        for axes in figure.axes for line in axes.get_lines() if line.get_transform() == axes.transData and not drawn_only
    ]  # fmt: skip
    label = figure.axes[0].get_ylabel()
    with plt.rc_context({"svg.fonttype": "none"}):
        drawn = inline(svg(figure, transparent=True), name)
    message = html.escape(caption or label)
    data = embedded(lines)
    below = f"<figcaption>{message}</figcaption>" if caption else ""
    return f'<figure role="img" aria-label="{message}">{drawn}<script type="application/json">{data}</script>{below}</figure>'


def picture_file(path: Path, caption: str) -> str:
    """Embed an existing SVG or PNG file with its caption in the page."""
    return _figure(path.read_bytes(), path.suffix.removeprefix("."), caption)


def _figure(data: bytes, kind: str, caption: str) -> str:
    message = html.escape(caption)
    return f'<figure><img src="{uri(data, kind)}" alt="{message}"><figcaption>{message}</figcaption></figure>'


def uri(data: bytes, kind: str) -> str:
    """Return a picture (svg or png) as a data URI."""
    return f"data:image/{'svg+xml' if kind == 'svg' else kind};base64,{base64.b64encode(data).decode()}"


def templates(*folders: Path) -> jinja2.Environment:
    """Load the templates of these folders and the frame of all pages, `page.html.j2`."""
    return jinja2.Environment(
        loader=jinja2.FileSystemLoader([*folders, TEMPLATE.parent]), autoescape=True, undefined=jinja2.StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip


def text(title: str, lead: str, sections: Sequence[Section], cards: Sequence[Card] = (), footer: str = "") -> str:
    """Render the page as HTML."""
    frame = templates().get_template(TEMPLATE.name)
    return frame.render(title=title, lead=lead, sections=sections, cards=cards, footer=footer)


def write(
    path: Path, title: str, lead: str, sections: Sequence[Section], cards: Sequence[Card] = (), footer: str = ""
) -> Path:
    """Write the page and return its path."""
    with atomic_write(path) as temporary:
        temporary.write_text(text(title, lead, sections, cards, footer), encoding="utf-8")
    return path
