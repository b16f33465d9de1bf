"""Pictures of the stability study: the maps with the advisor's line, and the field that the cases cover."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import NullFormatter
from numpy.typing import NDArray

from pywet.evidence.stability.maps import Map
from pywet.report.pictures import panels, plt

Floats = NDArray[np.float64]
STATES = ("stable", "energy", "ledger", "not finite", "speed", "overlap", "box", "other")
COLOURS = ("#bfe3c8", "#f6c667", "#7b5ea7", "#222222", "#e07a5f", "#c8553d", "#8f2d20", "#999999")
NAMES = (
    "stable", "makes more than 1 % of the energy in play", "ledger lost", "not finite", "stopped: too fast for the step",
    "stopped: overlap above half a radius", "stopped: left the box", "stopped: other",
)  # fmt: skip


def kind_of(state: str, said: str) -> str:
    """Which guard stopped a point."""
    if state != "stopped":
        return state
    for words, name in (("moves at", "speed"), ("overlaps", "overlap"), ("left the simulated box", "box")):
        if words in said:
            return name
    return "other"


def edges(centres: Floats, log: bool) -> Floats:
    """Borders between the points of an axis."""
    at = np.log(centres) if log else centres
    middle = 0.5 * (at[1:] + at[:-1])
    ends = np.concatenate([[2.0 * at[0] - middle[0]], middle, [2.0 * at[-1] - middle[-1]]])
    return np.exp(ends) if log else ends


def draw(axes: Axes, chart: Map, table: pd.DataFrame) -> set[str]:
    """One map; returns the kinds of points that are on it."""
    x, y = chart.x[1], chart.y[1]
    kinds = [kind_of(str(s), str(t)) for s, t in zip(table["state"], table["said"], strict=True)]
    grid = np.array([STATES.index(k) for k in kinds]).reshape(len(y), len(x))
    colours = ListedColormap(COLOURS)
    axes.pcolormesh(
        edges(x, chart.x_log), edges(y, chart.y_log), grid, cmap=colours, vmin=-0.5, vmax=len(STATES) - 0.5,
        edgecolors="white", linewidth=0.6,
    )  # fmt: skip
    limit = table["limit"].to_numpy(float).reshape(len(y), len(x))
    for level, style in ((1.0, "-"), (10.0, "--")):
        if level == 10.0 and chart.name not in ("step_explicit", "step_semi_implicit", "stiffness"):
            continue
        if limit.min() < level < limit.max():
            look: dict[str, Any] = {"colors": "#0b3c78", "linewidths": 2.2, "linestyles": style}
            axes.contour(x, y, np.log(limit), levels=[np.log(level)], **look)
    scales: dict[str, Any] = {
        "xscale": "log" if chart.x_log else "linear",
        "yscale": "log" if chart.y_log else "linear",
    }
    axes.set(xlabel=chart.x[0], ylabel=chart.y[0], **scales)
    axes.set_title(chart.title, fontsize=10.5, loc="left", fontweight="bold")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_formatter(NullFormatter())
    axes.tick_params(labelsize=8.5)
    return set(kinds)


def maps_figure(charts: list[tuple[Map, pd.DataFrame]], columns: int = 2) -> Figure:
    """Maps side by side with one legend."""
    figure, axes = panels(len(charts), columns, (11.5 / columns, 4.1))
    seen: set[str] = set()
    for panel, (chart, table) in zip(axes, charts, strict=False):
        seen |= draw(panel, chart, table)
    shown: list[Patch | Line2D] = [
        Patch(color=c, label=n) for s, c, n in zip(STATES, COLOURS, NAMES, strict=True) if s in seen
    ]
    shown.append(Line2D([], [], color="#0b3c78", lw=2.2, label="advisor's limit"))
    if any(chart.name.startswith(("step", "stiff")) for chart, _ in charts):
        shown.append(Line2D([], [], color="#0b3c78", lw=2.2, ls="--", label="a tenth of it (energy to 1 %)"))
    figure.legend(handles=shown, loc="outside lower center", ncols=3, fontsize=9, frameon=False)
    return figure


def field(cases: pd.DataFrame) -> Figure:
    """Where the cases lie: viscosity and smallest radius; films and speeds."""
    colour = {"stable": "#2f7d4f", "law": "#e0a030", "stopped": "#8f2d20"}
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(12.0, 3.9), layout="constrained")
    tint = [colour.get(str(s), "#000000") for s in cases["state"]]
    pairs = (
        (left, "smallest_m", "viscosity_Pa_s", "smallest sphere [m]", "viscosity [Pa s] (0 at the bottom)"),
        (middle, "film_over_r3_high", "fastest_m_per_s", "largest film over r³ (0 at the left)", "fastest sphere [m/s]"),
        (right, "of_advised", "time_step_s", "time step over the advisor's limit", "time step [s]"),
    )  # fmt: skip
    for panel, x, y, x_said, y_said in pairs:
        across, up = cases[x].to_numpy(float), cases[y].to_numpy(float)
        low_x, low_y = (v[v > 0].min() / 4.0 if (v > 0).any() else 1.0 for v in (across, up))
        panel.scatter(np.maximum(across, low_x), np.maximum(up, low_y), c=tint, s=7, alpha=0.7, linewidths=0)
        panel.set(xscale="log", yscale="log", xlabel=x_said, ylabel=y_said)
        panel.tick_params(labelsize=8.5)
    names = {"stable": "stable", "law": "energy made by the tangential law", "stopped": "stopped by a guard"}
    present = [s for s in names if (cases["state"] == s).any()]
    figure.legend(
        handles=[Line2D([], [], marker="o", ls="", color=colour[s], label=names[s]) for s in present],
        loc="outside lower center", ncols=3, frameon=False,
    )  # fmt: skip
    return figure
