"""Common style of all pictures, panels of a figure, and figures as SVG text."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.colors import hsv_to_rgb, to_hex
from matplotlib.figure import Figure

__all__ = ["plt"]
INK, GRID = "#27323d", "#dfe4e9"
NAVY, SKY, ORANGE, GREEN, VIOLET, RED = "#0b3c78", "#4a9bd4", "#d98032", "#5d8a3a", "#8b5fa5", "#c0392b"
COLOURS = (NAVY, ORANGE, GREEN, SKY, VIOLET, RED)
"""Colours of lines, in order of use."""
DASHES: tuple[Any, ...] = ("-", "--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)))
"""Dashes of lines: when all colours are taken, those of the next."""
DPI = 130
STYLE: Any = {
    "font.size": 9,
    "font.family": "DejaVu Sans",
    "axes.edgecolor": "#aab3bb",
    "axes.labelcolor": INK,
    "axes.grid": True,
    "axes.spines.top": False,
    "axes.prop_cycle": cycler(linestyle=DASHES) * cycler(color=COLOURS),
    "axes.spines.right": False,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "text.color": INK,
    "text.parse_math": False,  # a material's name is not a formula
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "xtick.color": INK,
    "ytick.color": INK,
    "svg.hashsalt": "pywet",
}


def colours(count: int, first: Sequence[str] = COLOURS) -> list[str]:
    """Return distinct colours: those of `first` if they are enough, otherwise from all hues, dark and bright in turn.

    >>> colours(2), len(set(colours(40)))
    (['#0b3c78', '#d98032'], 40)
    """
    if count <= len(first):
        return list(first[:count])
    return [str(to_hex(tuple(hsv_to_rgb((k / count, 0.85, (0.45, 0.8)[k % 2]))))) for k in range(count)]


def dash(k: int) -> Any:
    """Return one of arbitrarily many distinct dashes: those of `DASHES`, then one with more dots each time.

    >>> dash(0), dash(6)
    ('-', (0, (5, 1, 1, 1, 1, 1, 1, 1)))
    """
    return DASHES[k] if k < len(DASHES) else (0, (5, 1) + (1, 1) * (k - 3))


def panels(count: int, columns: int, size: tuple[float, float], **how: Any) -> tuple[Figure, list[Axes]]:
    """Make a figure of several panels of a size [inch] in rows of `columns`; `how` are options of `plt.subplots`."""
    rows = -(-count // columns)
    figure, axes = plt.subplots(
        rows, columns, figsize=(size[0] * columns, size[1] * rows), squeeze=False, layout="constrained", **how
    )
    for spare in axes.flat[count:]:
        spare.set_visible(False)
    return figure, list(axes.flat)


def legend(figure: Figure) -> None:
    """Below all panels of a figure, made higher by it, in as many columns as fit; none for a single curve without a name."""
    found = [axes.get_legend_handles_labels() for axes in figure.axes]
    named = {name: handle for handles, names in found for handle, name in zip(handles, names, strict=True)}
    for columns in (3, 2, 1) if named else ():
        below = figure.legend(list(named.values()), list(named), loc="outside lower center", ncols=columns)
        if columns == 1 or below.get_window_extent().width <= figure.bbox.width:
            figure.set_figheight(figure.get_figheight() + 0.2 * -(-len(named) // columns))
            return
        below.remove()


def svg(figure: Figure, **how: Any) -> str:
    """Return the figure as SVG text, reproducibly, and close it; `how`: options of `savefig`."""
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None}, **how)
    plt.close(figure)
    return text.getvalue()


def inline(text: str, name: str) -> str:
    """Return SVG text as part of a page: without its header, and with names that differ from those of other pictures."""
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    text = re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{name}-", text)
    return re.sub(
        r'(<svg[^>]*?) width="[^"]*"', r"\1", re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", text, count=1), count=1
    )
