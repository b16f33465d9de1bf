"""Figures and tables of a page: each computed, drawn and shown; NAME.csv and NAME.svg are written next to the page."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
from matplotlib.figure import Figure

from pywet.report import page
from pywet.report.pictures import STYLE, plt, svg
from pywet.util.files import atomic_write, write_csv


class Item(NamedTuple):
    """Figure or table of a page: title, caption, table, and a function that draws it from the table or the model."""

    title: str
    caption: str = ""
    table: Callable[[], pd.DataFrame] | None = None
    draw: Callable[..., Figure] | None = None


def sections(folder: Path, items: Mapping[str, Item]) -> list[page.Section]:
    """Make all items, their files in `folder`; a section of the page for each."""
    made = []
    for name, item in items.items():
        print(item.title, flush=True)
        body, given = "", []
        if item.table is not None:
            given = [item.table()]
            write_csv(given[0], folder / f"{name}.csv")
        if item.draw is None:
            shown = given[0].map(_shown)
            body = page.paragraph(item.caption) + page.table([str(c) for c in shown], shown.to_numpy().tolist())
        else:
            with plt.rc_context({**STYLE, "text.parse_math": True}), atomic_write(folder / f"{name}.svg") as temporary:
                temporary.write_text(svg(item.draw(*given)), encoding="utf-8")
            body = page.picture_file(folder / f"{name}.svg", item.caption)
        if given:
            body += f'<p class="soft"><a href="{name}.csv">values</a></p>'
        made.append(page.Section(item.title, body, item.title.split(":")[0]))
    return made


def _shown(value: Any) -> str:
    return "not defined" if pd.isna(value) else f"{value:.4g}" if isinstance(value, float) else str(value)
