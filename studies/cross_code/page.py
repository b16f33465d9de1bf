"""The page of the table of agreement, from the sources' JSON files: only counts are computed here."""

from __future__ import annotations

import html
from dataclasses import dataclass
from pathlib import Path

from pywet.report.page import Card, Rows, Section, left, paragraph, table, table_of, write
from pywet.report.page import Cell as Td
from pywet.util.files import write_json
from studies.cross_code import pictures
from studies.cross_code.model import Cell, Source, deviation_text
from studies.cross_code.rows import BY_KEY, COLUMNS, GROUPS, LIGGGHTS, ROWS, Row
from studies.cross_code.sources import SOURCES, data_file

BINS = (
    (1e-12, "#b5dfc4", "to 1e-12"),
    (1e-9, "#d0ecd9", "to 1e-9"),
    (1e-6, "#e6f4dd", "to 1e-6"),
    (1e-3, "#f5f5cd", "to 0.1 %"),
    (1e-2, "#fde8ad", "to 1 %"),
    (1e-1, "#fbcf9f", "to 10 %"),
    (float("inf"), "#f2ab9b", "beyond"),
)
"""Upper end of the deviation, colour, name: a logarithmic scale."""
WITHIN = "#d9ebf0"
"""Colour of a difference within the seeds' spread, regardless of its size."""
ROUND_OFF = 1e-9
STYLE = Path(__file__).with_name("agreement.css")
LEAD = (
    "Why believe the numbers? Every quantity the simulation rests on is computed by several independent programs and held"
    " against the best truth there is: an exact solution, an independent second program, or a quantity that nature conserves."
    " Green cells agree to round-off; red cells are another model. Point at a cell for what was compared, click it for the run."
)


@dataclass(frozen=True)
class Table:
    """All cells by row and column, and their sources."""

    cells: dict[tuple[str, str], Cell]
    sources: dict[str, Source]

    @property
    def ours(self) -> list[Cell]:
        """Return the measured cells of LIGGGHTS + pywet, in the order of the rows."""
        ours = [self.cells.get((row.key, LIGGGHTS)) for row in ROWS]
        return [c for c in ours if c is not None and c.state == "measured"]


def read_sources(folder: Path) -> Table:
    """Read the sources' files; one that is missing counts as failed."""
    sources = {}
    for name in SOURCES:
        path = data_file(folder, name)
        sources[name] = Source.read(path) if path.exists() else Source(name, failed="it has not been run")
    cells = {(c.row, c.column): c for s in sources.values() for c in s.cells}
    return Table(cells, sources)


def write_page(folder: Path) -> Path:
    """Write index.html and table.json into the folder; the page."""
    results = read_sources(folder)
    write_json(folder / "table.json", [c.__dict__ for c in results.cells.values()])
    sections = [
        Section("The table", f"<style>{STYLE.read_text()}</style>{legend()}{big_table(results)}", "Table"),
        Section("What the deviations mean", meanings(results), "Meaning"),
        Section("Pictures", pictures.all_of(results.sources), "Pictures"),
        Section("What cannot be compared, and why", limits(results), "Limits"),
        Section("Where the numbers come from", provenance(results), "Sources"),
    ]
    return write(folder / "index.html", "Table of agreement", LEAD, sections, cards(results), "snakemake agreement")


def colour(deviation: float) -> str:
    """Background colour of a cell by its deviation.

    >>> colour(3e-16), colour(0.5)
    ('#b5dfc4', '#f2ab9b')
    """
    return next(shade for top, shade, _ in BINS if deviation <= top)


def cards(results: Table) -> list[Card]:
    """Make the cards with counts at the top of the page."""
    ours = results.ours
    tight = [c for c in ours if (c.deviation or 0.0) <= ROUND_OFF]
    comparisons = sum(c.count for c in results.cells.values() if c.state == "measured")
    failed = [s.name for s in results.sources.values() if s.failed]
    shown = [
        Card(str(len(ROWS)), "quantities × scenes"),
        Card(f"{comparisons:,}".replace(",", " "), "single comparisons behind the table"),
        Card(f"{len(tight)} of {len(ours)}", "rows in which LIGGGHTS + pywet is within 1e-9 of the truth", "good"),
    ]
    if ours:
        worst = max(ours, key=lambda c: c.deviation or 0.0)
        name = BY_KEY[worst.row]
        shown.append(Card(deviation_text(worst.deviation), f"its worst row: {name.quantity}, {name.scene}"))
    if failed:
        shown.append(Card(str(len(failed)), f"sources without result: {', '.join(failed)}", "bad"))
    return shown


def legend() -> str:
    """Make the legend of the colour scale."""
    spans = "".join(f'<span style="background:{shade}">{name}</span>' for _, shade, name in BINS)
    marks = (
        '<span class="mark" style="background:#e7eff9;color:#0b3c78;font-weight:600">truth</span>'
        '<span class="mark" style="background:#eef1f4;color:#46535f;font-weight:600">basis (truth unknown)</span>'
        f'<span class="mark" style="background:{WITHIN}">within the spread of seeds</span>'
        '<span class="mark" style="color:#b3bcc5">— cannot be</span>'
        '<span class="mark" style="color:#7d8894;font-style:italic">not run</span>'
    )
    return paragraph("Largest relative deviation in the row, on a logarithmic scale:") + (
        f'<div class="legend">{spans}{marks}</div>'
    )


def big_table(results: Table) -> str:
    """Return the rows by group, one column for each program."""
    head = "".join(f"<th>{html.escape(h)}</th>" for h in ("quantity", "scene", *COLUMNS.values()))
    body = []
    for group in GROUPS:
        body.append(f'<tr class="group"><td colspan="{2 + len(COLUMNS)}">{html.escape(group)}</td></tr>')
        before = ""
        for row in (r for r in ROWS if r.group == group):
            cells = "".join(_td(row, results.cells.get((row.key, column)), results) for column in COLUMNS)
            name = '<tr class="again"><td>' if row.quantity == before else "<tr><td>"
            body.append(f"{name}{html.escape(row.quantity)}</td><td>{html.escape(row.scene)}</td>{cells}</tr>")
            before = row.quantity
    return f'<table class="agreement"><thead><tr>{head}</tr></thead><tbody>\n' + "\n".join(body) + "\n</tbody></table>"


def _td(row: Row, cell: Cell | None, results: Table) -> str:
    if cell is None:
        failed = [f"{s.name}: {s.failed}" for s in results.sources.values() if s.failed]
        why = f"no result; {'; '.join(failed)}" if failed else "not part of this row's comparison"
        return f'<td class="{"failed" if failed else "none"}" title="{html.escape(why)}">{"?" if failed else "—"}</td>'
    hint = html.escape(_hint(row, cell))
    style, name, text = "", "", deviation_text(cell.deviation)
    if cell.within is not None:
        style = f' style="background:{WITHIN if cell.within else BINS[-1][1]}"'
        text += "<br><small>within spread</small>" if cell.within else "<br><small>beyond spread</small>"
    elif cell.state == "measured" and cell.deviation is not None:
        style = f' style="background:{colour(cell.deviation)}"'
    else:
        name = {"impossible": "none", "not run": "norun"}.get(cell.state, cell.state)
        text = "—" if cell.state == "impossible" else cell.state
    inner = f'<a href="{html.escape(cell.link)}">{text}</a>' if cell.link else text
    return f'<td class="{name}"{style} title="{hint}">{inner}</td>'


def _hint(row: Row, cell: Cell) -> str:
    """Return the text of a cell's tooltip."""
    if cell.state != "measured" or cell.deviation is None:
        return cell.note
    parts = [f"largest {cell.deviation:.2g}"]
    if cell.median is not None and cell.count > 1:
        parts.append(f"median {cell.median:.2g}")
    parts.append(f"over {cell.count} comparisons, relative to {row.scale}")
    if cell.worst_at:
        parts.append(f"worst at {cell.worst_at}")
    return "; ".join(parts) + (f". {cell.note}" if cell.note else "")


def meanings(results: Table) -> str:
    """Explain the colours, and list every row in which LIGGGHTS + pywet is not at round-off, with the reason."""
    loose = sorted((c for c in results.ours if (c.deviation or 0.0) > ROUND_OFF), key=lambda c: -(c.deviation or 0.0))
    listed = paragraph("All rows in which LIGGGHTS + pywet is farther than `1e-9` from the truth, and why:")
    return "".join(paragraph(t) for t in MEANINGS) + listed + table_of(loose, {
        "quantity": lambda c: BY_KEY[c.row].quantity,
        "scene": lambda c: left(BY_KEY[c.row].scene),
        "deviation": lambda c: deviation_text(c.deviation),
        "why": lambda c: left(c.note),
    })  # fmt: skip


MEANINGS = (
    "Up to about `1e-12`: two programs evaluate the same equation in double precision. This says that the code does what"
    " the papers write, not that the papers describe nature.",
    "Angular momentum of wet spheres is lost because the tangential drag acts at the radius of each sphere, as in the paper,"
    " and the gap between the two is on neither lever arm.",
    "Red cells of the stock models are no faults of their programming. `washino` uses half of Rabinovich's radius and the"
    " product of the contact angles, `easo` is Soulié's fit; both take a wall for a sphere, and the liquid's lubrication for"
    " that of an unbounded one. YADE evaluates its laws to round-off between spheres; at walls it takes the sphere's radius,"
    " and in overlap its bridges carry no force.",
    "Against the exact bridge even a correct closed form is off. That is the error of the law: see the rows `exact bridge`"
    " here, and the law atlas for all laws.",
    "Where nobody knows the truth (beds, screening), a program is set against LIGGGHTS + pywet as the basis, seeds against"
    " seeds; the cell says whether the difference is beyond their spread. Dry beds and moist beds start from the same places:"
    " where the dry ones agree and the moist ones do not, the bridges make the difference (overlap, walls, volumes: above).",
)


def limits(results: Table) -> str:
    """List the reasons of the empty cells, by column, most frequent first."""
    reasons: dict[str, dict[str, list[str]]] = {column: {} for column in COLUMNS}
    for (key, column), cell in results.cells.items():
        if cell.state in ("impossible", "not run", "failed"):
            why = cell.note if cell.state == "impossible" else f"{cell.state}: {cell.note}"
            reasons[column].setdefault(why, []).append(BY_KEY[key].quantity)
    rows: Rows = []
    for column, of in reasons.items():
        for k, (why, quantities) in enumerate(sorted(of.items(), key=lambda item: -len(item[1]))):
            kinds = ", ".join(dict.fromkeys(quantities))
            short = kinds if len(kinds) < 110 else kinds[:107] + "…"
            name = COLUMNS[column] if k == 0 else ""
            rows.append([name, left(why), str(len(quantities)), Td(short, hint=kinds, left=True)])
    return table(["program", "reason", "cells", "quantities"], rows)


def provenance(results: Table) -> str:
    """List the sources with state and time."""
    message_how = paragraph(
        "`snakemake --cores 2 agreement` (or `pywet study cross-code`) runs the sources and writes this page; `data/*.json` hold"
        " the cells, `runs/` the run directories that cells link to. A source that fails blanks its own cells only."
    )
    return message_how + table_of(results.sources.values(), {
        "source": lambda s: s.name,
        "cells": lambda s: str(len(s.cells)),
        "time": lambda s: f"{s.wall_s:.0f} s",
        "state": lambda s: left(s.failed, "bad") if s.failed else Td("run", "good"),
    })  # fmt: skip
