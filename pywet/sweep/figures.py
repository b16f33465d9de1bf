"""Figures of a sweep: a result over an axis with 95 % intervals, and a map over two axes with its standard error."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatter, NullFormatter

from pywet.errors import PywetError
from pywet.report.pictures import INK, STYLE, colours, panels, plt
from pywet.runs.spread import half_width
from pywet.sweep import surface
from pywet.sweep.description import Sweep
from pywet.sweep.table import DONE

GRID = 41
"""Number of values of each axis of a map."""
MOST_LINES = 12


def label(made: pd.DataFrame, name: str) -> str:
    """Return the label of a column on an axis of a figure."""
    unit = made.attrs.get("units", {}).get(name, "")
    return f"{name} [{unit}]" if unit and unit != "1" else name


def drawn(sweep: Sweep, made: pd.DataFrame, results: list[str], x: str, y: str, hue: str | None = None) -> Figure:
    """Draw the figure of `pywet sweep plot`: y over x, a line for each value of hue; for two axes a map of the result hue."""
    columns = [*sweep.axes, *results]
    for name in (x, y, *([hue] if hue else [])):
        if name not in columns:
            raise PywetError(
                f"{name} is not a column of the sweep; expected one of {', '.join(columns)}",
                code="sweep.no_column", given=name, expected=columns,
            )  # fmt: skip
    rows = made[made["status"] == DONE]
    if rows.empty:
        raise PywetError(
            "no run of the sweep has results yet; expected some: run `pywet sweep FILE`", code="sweep.no_results"
        )
    for name in (x, y, *([hue] if hue else [])):
        if rows[name].isna().all():
            raise PywetError(
                f"no run has {name}; expected a result that some have: {', '.join(results)}",
                code="sweep.no_values", given=name, expected=results,
            )  # fmt: skip
    with plt.rc_context(STYLE):
        if x in sweep.axes and y in sweep.axes:
            if hue not in results:
                raise PywetError(
                    f"{x} and {y} are axes; expected a result as the third: {', '.join(results)}",
                    code="sweep.two_axes", given=(x, y), expected=results,
                )  # fmt: skip
            return response_map(sweep, rows, hue, x, y)
        if y not in results:
            raise PywetError(
                f"{y} is an axis; expected a result as y: {', '.join(results)}",
                code="sweep.axis_as_y", given=y, expected=results,
            )  # fmt: skip
        figure, (axes,) = panels(1, 1, (5.2, 3.6))
        curve(axes, sweep, rows, x, y, hue)
        return figure


def curve(axes: Axes, sweep: Sweep, rows: pd.DataFrame, x: str, y: str, hue: str | None = None) -> None:
    """Draw the mean of y at each x with its 95 % interval over seeds and all other axes; a scatter plot if x is a result."""
    rows = rows[rows[y].notna()]
    groups = [(v, rows[rows[hue] == v]) for v in sorted(rows[hue].unique())] if hue else [(None, rows)]
    if len(groups) > MOST_LINES:
        raise PywetError(
            f"{hue} has {len(groups)} values, expected at most {MOST_LINES} lines: take another column",
            code="sweep.many_lines", key=str(hue), given=len(groups), expected=MOST_LINES,
        )  # fmt: skip
    text = not pd.api.types.is_numeric_dtype(rows[x]) or pd.api.types.is_bool_dtype(rows[x])
    for (value, every), colour in zip(groups, colours(len(groups)), strict=True):
        part = every.drop_duplicates([x, "run"])  # points with the same inputs share a run
        name = "" if value is None else f"{hue} {value}"
        spread = part.groupby(x)[y].apply(list) if x in sweep.axes else None
        if spread is None or (len(spread) > GRID and not text):
            axes.plot(part[x], part[y], ".", color=colour, label=name or "_runs")
            continue
        at = [str(v) for v in spread.index] if text else list(spread.index)
        halves: Any = [half_width(v) or 0.0 for v in spread]
        means: Any = [float(np.mean(v)) for v in spread]
        drawn = axes.errorbar(
            at,
            means,
            yerr=halves,
            color=colour,
            marker="o",
            ms=4,
            capsize=2,
            lw=0 if text else 1.4,
            elinewidth=1,
            label=name,
        )
        for part, word in zip((drawn.lines[0], *drawn.lines[1]), ("mean", "95 % low", "95 % high"), strict=True):
            part.set_label(f"_{name} {word}".replace("_ ", "_"))  # named in a CSV file instead of the legend
    axes.set(xlabel=label(rows, x), ylabel=label(rows, y))
    if x in sweep.axes and sweep.axes[x].logarithmic:
        _scale(axes, "x", True)
    if hue:
        axes.legend()


def response_map(sweep: Sweep, rows: pd.DataFrame, result: str, x: str, y: str) -> Figure:
    """Draw the mean of a result over two numerical axes, and its standard error, with the points that were run."""
    for key in (x, y):
        if not pd.api.types.is_numeric_dtype(rows[key]):
            raise PywetError(
                f"{key} holds no numbers; expected two numerical axes for a map", code="sweep.map_axis", key=key
            )
    response = surface.through(sweep, rows, result, [x, y])
    if response is None:
        raise PywetError(
            f"{len(rows)} runs do not determine a surface of second order over {x} and {y}; expected at least 7 points, "
            "and axes that change independently",
            code="sweep.map_points", given=len(rows), expected=7,
        )  # fmt: skip
    lines = [_spaced(rows[key].to_numpy(float), sweep.axes[key].logarithmic) for key in (x, y)]
    mesh = np.meshgrid(*lines)
    mean, error = response.at(np.column_stack([m.ravel() for m in mesh]))
    figure, parts = panels(2, 2, (4.4, 3.5))
    for axes, values, title in zip(parts, (mean, error), (f"{result}: mean", "standard error of it"), strict=True):
        filled = axes.contourf(*mesh, values.reshape(GRID, GRID), levels=12, cmap="viridis")
        figure.colorbar(filled, ax=axes)
        axes.plot(rows[x], rows[y], "o", ms=3, color="white", mec=INK, mew=0.6)
        axes.set(xlabel=label(rows, x), ylabel=label(rows, y), title=title)
        _scale(axes, "x", sweep.axes[x].logarithmic)
        _scale(axes, "y", sweep.axes[y].logarithmic)
        axes.grid(False)
    return figure


def _scale(axes: Axes, which: str, logarithmic: bool) -> None:
    """Set a logarithmic scale with plain numbers at powers of ten, since text with $ is not typeset as formula here."""
    if logarithmic:
        axes.set(**{f"{which}scale": "log"})
        axis = getattr(axes, f"{which}axis")
        axis.set_major_formatter(LogFormatter())
        axis.set_minor_formatter(NullFormatter())


def _spaced(values: np.ndarray, logarithmic: bool) -> np.ndarray:
    return (np.geomspace if logarithmic else np.linspace)(values.min(), values.max(), GRID)
