"""Draw the tables of `curves`, `accuracy_cost` and `buck_impact`: model lines only, without the paper's measurements."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pywet.report.pictures import GREEN, INK, NAVY, ORANGE, RED, SKY, VIOLET, colours, panels
from studies.buck2018 import accuracy_cost
from studies.buck2018.curves import WORKS

COLOURS = (NAVY, SKY, ORANGE, GREEN, VIOLET, "#9a8f80")
WORK_COLOURS = dict(zip(WORKS, (ORANGE, SKY, NAVY, "#9a8f80"), strict=True))
LABELS = {
    "e_n": "normal coefficient $e_n$",
    "e_t": "tangential coefficient $e_t$",
    "omega_out": "spin afterwards $\\omega_R$ in rad/s",
    "e_omega": "rotational coefficient $e_\\omega$",
}
LIMITS = {"e_n": (0.0, 1.0), "e_t": (-1.5, 3.0)}
SLIDES, BOTH, ROLLS = ("#f0d9c4", "slides"), ("#e8ecef", "both"), ("#cfe3f2", "rolls")
REGIMES = (SLIDES, BOTH, ROLLS, BOTH, SLIDES)
VELOCITY, ANGLE = "impact velocity in m/s", "angle from the normal in °"


def lines(table: pd.DataFrame) -> Iterator[tuple[str, str, pd.DataFrame]]:
    """Yield colour, name and points of each line of a table."""
    found = table.groupby("line", sort=False)
    for (line, points), colour in zip(found, colours(found.ngroups, COLOURS), strict=True):
        yield colour, str(line), points


def plot(place: Axes, table: pd.DataFrame, column: str, **axes: Any) -> None:
    """Draw a coefficient over x, one line for each of the table's; results of the engine are points."""
    for colour, line, points in lines(table):
        place.plot(points["x"], points[column], "o" if line == "engine" else "-", color=colour, label=line)
    place.set(ylabel=LABELS[column], **axes)


def convergence(table: pd.DataFrame) -> Figure:
    """Draw Fig. 6: e_n and its distance from the tightest value over the tolerance."""
    figure, axes = panels(2, 2, (4.4, 3.0))
    best = table[table["line"] == "DOP853"]["e_n"].iloc[-1]
    for colour, line, points in lines(table):
        axes[0].semilogx(points["x"], points["e_n"], "o-", color=colour, label=line)
        axes[1].loglog(points["x"], (points["e_n"] - best).abs().clip(lower=1e-14), "o-", color=colour, label=line)
    axes[0].set_ylabel(LABELS["e_n"])
    axes[1].set_ylabel("distance from the tightest value")
    for place in axes:
        place.set_xlabel("relative tolerance")
        place.invert_xaxis()
        place.legend()
    return figure


def over_velocity(table: pd.DataFrame) -> Figure:
    """Draw Figs. 7 and 8: e_n over the impact velocity, one panel per letter."""
    letters = list(table.groupby("panel", sort=False))
    figure, axes = panels(len(letters), 2, (4.4, 3.0))
    for place, (letter, rows) in zip(axes, letters, strict=False):
        plot(place, rows, "e_n", title=f"({letter})", xlabel=VELOCITY, ylim=(0.0, 1.0), xlim=(0.0, 5.0))
        place.legend(loc="lower right")
    return figure


def dissipation(table: pd.DataFrame) -> Figure:
    """Draw Fig. 9: energies lost per mass, stacked over the velocity."""
    figure, axes = panels(2, 2, (4.4, 3.0))
    for place, (letter, rows) in zip(axes, table.groupby("panel", sort=False), strict=True):
        lost, colours = [rows[w] for w in WORKS], [WORK_COLOURS[w] for w in WORKS]
        place.stackplot(rows["x"], lost, labels=WORKS, colors=colours, edgecolor="white")
        title = f"({letter}) {'1.74' if letter == 'a' else '0.91'} mm, {rows['line'].iloc[0]}"
        place.set(title=title, xlabel=VELOCITY, ylabel="energy lost in J/kg")
        place.legend(loc="upper left")
    return figure


def over_angle(table: pd.DataFrame, columns: tuple[str, ...] = tuple(LABELS)) -> Figure:
    """Draw Figs. 10 to 13: coefficients over the collision angle."""
    figure, axes = panels(len(columns), 2, (4.4, 3.0))
    for place, column in zip(axes, columns, strict=False):
        limits = {"ylim": LIMITS[column]} if column in LIMITS else {}
        plot(place, table, column, xlabel=ANGLE, xlim=(0.0, 90.0), **limits)
    axes[0].legend()
    return figure


def regimes(table: pd.DataFrame) -> Figure:
    """Draw Fig. 12: the five regimes at about −960 rad/s, shaded by the slope of the spin after the collision."""
    figure, axes = panels(3, 3, (4.4, 3.0))
    rows = table[table["line"] == "-961 rad/s"].reset_index(drop=True)
    edges = [0.0, *regime_edges(rows), 90.0]
    parts = list(zip(itertools.pairwise(edges), REGIMES, strict=True))
    for place, column in zip(axes, ("e_t", "omega_out", "e_omega"), strict=True):
        plot(place, rows, column, xlabel=ANGLE, xlim=(0.0, 90.0))
        for (low, high), (shade, _) in parts:
            place.axvspan(low, high, color=shade, alpha=0.6, lw=0)
    axes[0].set_ylim(0.5, 3.0)
    for (low, high), (_, message) in parts:
        axes[0].text(0.5 * (low + high), 2.85, message, ha="center", fontsize=7.5)
    return figure


def regime_edges(rows: pd.DataFrame) -> list[float]:
    """Return the angles [deg] at which the slope of e_ω passes 0.02 per degree: ends of the five regimes."""
    use = rows[rows["x"] < 80.0]
    slope = np.diff(use["e_omega"]) / np.diff(use["x"])
    return [float(x) for x in use["x"].to_numpy()[1:-1][np.diff((slope > 0.02).astype(int)) != 0]]


def accuracy(table: pd.DataFrame) -> Figure:
    """Draw error against wall time for every integrator, with the knee of the default integrator marked."""
    figure, (place,) = panels(1, 1, (7.0, 4.4))
    for colour, (method, rows) in zip((RED, *COLOURS, INK), table.groupby("method", sort=False), strict=False):
        style = "s--" if method == "Verlet" else "o-"
        error = rows["error"].clip(lower=1e-13)
        place.loglog(1e3 * rows["seconds"], error, style, color=colour, label=str(method), markersize=3.5)
    at = accuracy_cost.knee(table, "compiled")
    knee = 1e3 * at["seconds"], max(at["error"], 1e-13)
    place.plot(*knee, "o", markersize=12, fillstyle="none", color=RED)
    place.annotate(f"  knee: rtol {at['setting']:.0e}", knee, fontsize=9)
    place.axhline(accuracy_cost.BUDGET, color="#aab3bb", linestyle=":")
    place.set(xlabel="time for the collisions in ms", ylabel="largest error of $e_n$, $e_t$, $e_\\omega$")
    place.legend(ncols=2)
    return figure


def engine(table: pd.DataFrame) -> Figure:
    """Draw e_n over the velocity: model, engine's equations, engine."""
    figure, (place,) = panels(1, 1, (6.5, 4.0))
    plot(place, table, "e_n", xlabel=VELOCITY, ylim=(0.0, 1.0))
    place.legend(loc="lower right")
    return figure
