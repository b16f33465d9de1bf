"""Draws the tables of `curves` (and of `study`): model lines only, the paper's measurements are not in the project."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pywet.collisions.wall import study
from pywet.collisions.wall.curves import WORKS
from pywet.files import atomic_write
from pywet.report.pictures import STYLE

COLOURS = ("#0b3c78", "#4a9bd4", "#d98032", "#5d8a3a", "#8b5fa5", "#9a8f80")
WORK_COLOURS = dict(zip(WORKS, ("#d98032", "#4a9bd4", "#0b3c78", "#9a8f80"), strict=True))
LABELS = {
    "e_n": "normal coefficient $e_n$",
    "e_t": "tangential coefficient $e_t$",
    "e_omega": "rotational coefficient $e_\\omega$",
    "omega_out": "spin afterwards $\\omega_R$ in rad/s",
}
VELOCITY, ANGLE = "impact velocity in m/s", "angle from the normal in °"


def grid(rows: int, columns: int, height: float = 3.0) -> tuple[Figure, list[Axes]]:
    """A figure in the project's look, and its axes."""
    figure, axes = plt.subplots(
        rows, columns, figsize=(4.4 * columns, height * rows), squeeze=False, layout="constrained"
    )
    return figure, list(axes.flat)


def convergence(table: pd.DataFrame) -> Figure:
    """Fig. 6: e_n and its distance from the tightest value over the tolerance."""
    figure, axes = grid(1, 2)
    best = table[table["line"] == "DOP853"]["e_n"].iloc[-1]
    for colour, (line, rows) in zip(COLOURS, table.groupby("line", sort=False), strict=False):
        axes[0].semilogx(rows["x"], rows["e_n"], "o-", color=colour, label=line)
        axes[1].loglog(rows["x"], np.maximum((rows["e_n"] - best).abs(), 1e-14), "o-", color=colour, label=line)
    axes[0].set_ylabel(LABELS["e_n"])
    axes[1].set_ylabel("distance from the tightest value")
    for place in axes:
        place.set_xlabel("relative tolerance")
        place.invert_xaxis()
        place.legend()
    return figure


def over_velocity(table: pd.DataFrame) -> Figure:
    """Figs. 7 and 8: e_n over the impact velocity, one panel per letter."""
    panels = list(table.groupby("panel", sort=False))
    figure, axes = grid(-(-len(panels) // 2), 2)
    for place, (panel, rows) in zip(axes, panels, strict=True):
        for colour, (line, points) in zip(COLOURS, rows.groupby("line", sort=False), strict=False):
            place.plot(points["x"], points["e_n"], color=colour, label=line)
        place.set_title(f"({panel})")
        place.set(xlabel=VELOCITY, ylabel=LABELS["e_n"], ylim=(0.0, 1.0), xlim=(0.0, 5.0))
        place.legend(loc="lower right")
    return figure


def dissipation(table: pd.DataFrame) -> Figure:
    """Fig. 9: energies lost per mass, stacked over the velocity."""
    figure, axes = grid(1, 2)
    for place, (panel, rows) in zip(axes, table.groupby("panel", sort=False), strict=True):
        place.stackplot(
            rows["x"],
            [rows[w] for w in WORKS],
            labels=WORKS,
            colors=[WORK_COLOURS[w] for w in WORKS],
            edgecolor="white",
        )
        place.set_title(f"({panel}) {'1.74' if panel == 'a' else '0.91'} mm, {rows['line'].iloc[0]}")
        place.set(xlabel=VELOCITY, ylabel="energy lost in J/kg")
        place.legend(loc="upper left")
    return figure


def over_angle(table: pd.DataFrame, columns: tuple[str, ...]) -> Figure:
    """Figs. 10 to 13: coefficients over the collision angle."""
    figure, axes = grid(-(-len(columns) // 2), 2)
    for place, column in zip(axes, columns, strict=False):
        for n, (line, rows) in enumerate(table.groupby("line", sort=False)):
            place.plot(rows["x"], rows[column], color=COLOURS[n % len(COLOURS)], label=line)
        place.set(xlabel=ANGLE, ylabel=LABELS[column], xlim=(0.0, 90.0))
        if column == "e_n":
            place.set_ylim(0.0, 1.0)
        if column == "e_t":
            place.set_ylim(-1.5, 3.0)
    axes[0].legend()
    for place in axes[len(columns) :]:
        place.set_axis_off()
    return figure


def regimes(table: pd.DataFrame) -> Figure:
    """Fig. 12: the five regimes at about −960 rad/s, shaded by the slope of the spin after the collision."""
    figure, axes = grid(1, 3)
    rows = table[table["line"] == "-961 rad/s"].reset_index(drop=True)
    edges = regime_edges(rows)
    for place, column in zip(axes, ("e_t", "omega_out", "e_omega"), strict=True):
        place.plot(rows["x"], rows[column], color=COLOURS[0])
        for k, (low, high) in enumerate(zip([0.0, *edges], [*edges, 90.0], strict=True)):
            place.axvspan(low, high, color=("#f0d9c4", "#e8ecef", "#cfe3f2")[min(k, 4 - k)], alpha=0.6, lw=0)
        place.set(xlabel=ANGLE, ylabel=LABELS[column], xlim=(0.0, 90.0))
    axes[0].set_ylim(0.5, 3.0)
    for k, said in enumerate(("slides", "both", "rolls", "both", "slides")):
        at = 0.5 * ([0.0, *edges][k] + [*edges, 90.0][k])
        axes[0].text(at, 2.85, said, ha="center", fontsize=7.5)
    return figure


def regime_edges(rows: pd.DataFrame, steep: float = 0.02) -> list[float]:
    """Angles [deg] at which the slope of e_ω passes `steep` per degree: ends of the five regimes."""
    use = rows[rows["x"] < 80.0]
    slope = np.diff(use["e_omega"]) / np.diff(use["x"])
    return [float(x) for x in use["x"].to_numpy()[1:-1][np.diff((slope > steep).astype(int)) != 0]]


def accuracy(table: pd.DataFrame) -> Figure:
    """Error against wall time for every integrator; the knee of the default integrator is marked."""
    figure, (place,) = grid(1, 1, height=4.4)
    figure.set_figwidth(7.0)
    for n, (method, rows) in enumerate(table.groupby("method", sort=False)):
        style = "s--" if method == "Verlet" else "o-"
        colour = ("#b3261e", *COLOURS, "#27323d")[n]
        place.loglog(
            1e3 * rows["seconds"],
            np.maximum(rows["error"], 1e-13),
            style,
            color=colour,
            label=str(method),
            markersize=3.5,
        )
    at = study.knee(table, "compiled")
    place.plot(1e3 * at["seconds"], max(at["error"], 1e-13), "o", markersize=12, fillstyle="none", color="#b3261e")
    place.annotate(f"  knee: rtol {at['setting']:.0e}", (1e3 * at["seconds"], max(at["error"], 1e-13)), fontsize=9)
    place.axhline(study.BUDGET, color="#aab3bb", linestyle=":")
    place.set(xlabel="time for the collisions in ms", ylabel="largest error of $e_n$, $e_t$, $e_\\omega$")
    place.legend(ncols=2)
    return figure


def engine(table: pd.DataFrame) -> Figure:
    """e_n over the velocity: model, engine's equations, engine."""
    figure, (place,) = grid(1, 1, height=4.0)
    figure.set_figwidth(6.5)
    for colour, (line, rows) in zip(COLOURS, table.groupby("line", sort=False), strict=False):
        place.plot(rows["x"], rows["e_n"], "o" if line == "engine" else "-", color=colour, label=str(line))
    place.set(xlabel=VELOCITY, ylabel=LABELS["e_n"], ylim=(0.0, 1.0))
    place.legend(loc="lower right")
    return figure


DRAW: dict[str, Callable[[pd.DataFrame], Figure]] = {
    "fig06": convergence,
    "fig07": over_velocity,
    "fig08": over_velocity,
    "fig09": dissipation,
    "fig10": lambda table: over_angle(table, ("e_n", "e_t", "omega_out")),
    "fig11": lambda table: over_angle(table, ("e_n", "e_t", "omega_out", "e_omega")),
    "fig12": regimes,
    "fig13": lambda table: over_angle(table, ("e_n", "e_t", "omega_out", "e_omega")),
    "accuracy": accuracy,
    "engine": engine,
}


def save(figure_name: str, table: pd.DataFrame, path: Path) -> None:
    """Draw a table into a file, SVG or PNG by its ending."""
    with matplotlib.rc_context(STYLE):  # type: ignore[arg-type]
        figure = DRAW[figure_name](table)
        with atomic_write(path) as temporary:
            metadata = {"Date": None} if path.suffix == ".svg" else None
            figure.savefig(temporary, dpi=90, metadata=metadata)
        plt.close(figure)
