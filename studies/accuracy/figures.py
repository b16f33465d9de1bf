"""Pictures of the accuracy study: error against cost of every setting, fronts of all combinations, seeds, predicted times."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pywet.cost import choice
from pywet.report.pictures import INK, STYLE, panels, plt
from studies.accuracy import ranking
from studies.accuracy.parameters import PARAMETERS

KIND_COLOUR = {"moist": "#0b3c78", "dry": "#b0752c"}
SETTING_COLOUR = {"fraction": "#0b3c78", "stiffness": "#d98032", "wire_sides": "#5d8a3a", "capillary": "#b3261e"}
"""Colours of the settings whose curves are drawn next to the seeds."""
FLOOR = 1e-4
"""Error share below which points are drawn at the bottom of the picture."""
SHORT = {"willett_simple": "simple", "young_laplace": "exact force", "semi_implicit": "semi-implicit"}


def setting_panels(table: dict[str, Any], group: str) -> Figure | None:
    """Draw error against cost, one panel for each setting measured in this group; moist and dry in one."""
    drawn = [
        (parameter, _kinds(table, parameter, group)) for parameter in PARAMETERS if not PARAMETERS[parameter].exact_pair
    ]
    drawn = [(parameter, kinds) for parameter, kinds in drawn if kinds]
    if not drawn:
        return None
    with plt.rc_context(STYLE):
        columns = min(3, len(drawn))
        figure, axes = panels(len(drawn), columns, (4.0, 2.9), sharey=True)
        for ax, (parameter, kinds) in zip(axes, drawn, strict=False):
            for kind, levels in kinds.items():
                _draw_levels(ax, levels, table["default"][parameter], kind)
            _dress(ax, PARAMETERS[parameter].title, kinds)
        for first in axes[::columns]:
            first.set_ylabel("error [%]")
    return figure


def _kinds(table: dict[str, Any], parameter: str, group: str) -> dict[str, list[dict[str, Any]]]:
    """Return the levels of a setting for a moist and for a dry case, if they differ."""
    by_kind = {kind: ranking.points(table, parameter, kind, group) for kind in choice.SCENES}
    return {kind: levels for kind, levels in by_kind.items() if any(p["value"] > 0.0 for p in levels)}


def _draw_levels(ax: Axes, levels: list[dict[str, Any]], base: Any, kind: str) -> None:
    colour = KIND_COLOUR[kind]
    x = [p["cost"] for p in levels]
    y = [100.0 * max(p["value"], FLOOR) for p in levels]
    ax.plot(x, y, color=colour, lw=1.0, alpha=0.5, zorder=2)
    for k, p in enumerate(levels):
        zero = p["value"] < FLOOR
        if p["limit"] > 0.0 and not zero:
            ax.plot([x[k]] * 2, [y[k], 100.0 * (p["value"] + p["limit"])], color=colour, lw=0.9, alpha=0.6, zorder=2)
        filled = colour if p["resolved"] else "white"
        ax.plot(x[k], y[k], marker="v" if zero else "o", ms=5.5, color=colour, mfc=colour if zero else filled, zorder=3)
        if p["level"] == base:
            ax.plot(x[k], y[k], marker="o", ms=12, mfc="none", mec="#b3261e", mew=1.6, zorder=4)
        text = SHORT.get(str(p["level"]), str(p["level"]))
        ax.annotate(
            text, (x[k], y[k]), xytext=(6, (5, -11)[(k + (kind == "dry")) % 2]), textcoords="offset points", fontsize=7.5,
            color=colour,
        )  # fmt: skip


def _dress(ax: Axes, title: str, kinds: dict[str, Any]) -> None:
    ax.set(xscale="log", yscale="log", title=title, xlabel="cost, default = 1")
    costs = [p["cost"] for levels in kinds.values() for p in levels]
    ax.set_xlim(min(0.7, 0.8 * min(costs)), max(1.6, 1.9 * max(costs)))
    ticks = [t for t in (0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3, 5, 10, 20) if ax.get_xlim()[0] <= t <= ax.get_xlim()[1]]
    ax.set_xticks(ticks, [f"{t:g}" for t in ticks])
    ax.minorticks_off()
    ax.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    for k, kind in enumerate(kinds):
        ax.text(
            0.98, 0.97 - 0.09 * k, kind, transform=ax.transAxes, ha="right", va="top", fontsize=8,
            color=KIND_COLOUR[kind], fontweight="bold",
        )  # fmt: skip


def fronts(table: dict[str, Any]) -> Figure:
    """Draw the lowest cost for each accuracy, over all combinations of settings; the default as a ring."""
    wanted = {
        "all of them": choice.WANTED,
        "fraction retained, liquid": ("fraction retained", "liquid shares"),
        "force": ("force",),
        "restitution": ("restitution",),
    }
    colours = (INK, "#0b3c78", "#d98032", "#5d8a3a")
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 2, figsize=(11.5, 4.4), sharey=True, layout="constrained")
        for ax, kind in zip(axes, ("moist", "dry"), strict=True):
            options = choice.options(table, kind == "moist")
            ends = []
            for (name, groups), colour in zip(wanted.items(), colours, strict=True):
                if kind == "dry" and name == "force":
                    continue
                line = _front(options, groups)
                x, y = [p for p, _ in line], [100.0 * max(e, FLOOR) for _, e in line]
                ax.step(x, y, where="post", color=colour, lw=1.8)
                ax.plot(x, y, "o", ms=3.5, color=colour)
                ends.append((x[0], y[0], name, colour))
                base = choice.of_default(table, kind == "moist", groups)
                ax.plot(1.0, 100.0 * max(max(base.error.values()), FLOOR), "o", ms=11, mfc="none", mec=colour, mew=1.8)
            _label_ends(ax, ends)
            ax.set(xscale="log", yscale="log", xlim=(0.08, 20.0), ylim=(0.7 * 100.0 * FLOOR, 150.0))
            ax.set_xticks([0.1, 0.2, 0.5, 1, 2, 5, 10], ["0.1", "0.2", "0.5", "1", "2", "5", "10"])
            ax.minorticks_off()
            ax.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
            ax.set(title=f"{kind} screening", xlabel="cost, default = 1")
        axes[0].set_ylabel("error, sum over the settings [%]")
    return figure


def _front(options: dict[str, Any], wanted: Sequence[str]) -> list[tuple[float, float]]:
    """Return costs and errors that no other combination beats, from cheap to exact."""
    pairs = sorted((c.cost, max(c.error.values())) for c in choice.combinations(options, wanted))
    line: list[tuple[float, float]] = []
    for cost, error in pairs:
        if not line or error < line[-1][1] - 1e-12:
            line.append((cost, error))
    return line


def _label_ends(ax: Axes, ends: list[tuple[float, float, str, str]]) -> None:
    """Label the cheap ends of the lines without overlaps."""
    last = np.inf
    for x, y, name, colour in sorted(ends, key=lambda e: -e[1]):
        at = min(y, last / 1.45, 100.0)
        last = at
        ax.annotate(name, (x, at), xytext=(-6, 2), textcoords="offset points", ha="right", fontsize=8, color=colour)


def seeds(runs: pd.DataFrame, size: str) -> Figure:
    """Draw the fraction retained of the default with every seed, and the mean over seeds for coarsest and finest settings."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 2, figsize=(11.5, 3.6), layout="constrained")
        for ax, scene in zip(axes, ("moist", "dry"), strict=True):
            done = runs[(runs["scene"] == scene) & runs["curve"].notna()]
            at_default = done.loc[done["parameter"] == "default", "curve"]
            for k, curve in enumerate(at_default):
                label = f"default, {len(at_default)} seeds" if k == 0 else None
                ax.plot(curve["time_s"], curve["retained"], color="#b9c4ce", lw=3.0, label=label)
            for parameter, colour in SETTING_COLOUR.items():
                levels = PARAMETERS[parameter].levels(size)
                for level, style in ((levels[0], "--"), (levels[-1], "-")):
                    curves = done.loc[(done["parameter"] == parameter) & (done["level"] == level), "curve"].tolist()
                    if curves:
                        mean = np.mean([curve["retained"] for curve in curves], axis=0)
                        text = f"{PARAMETERS[parameter].title} {SHORT.get(str(level), level)}"
                        ax.plot(curves[0]["time_s"], mean, style, color=colour, lw=1.2, label=text)
            ax.set(title=f"{scene}: the seeds alongside the settings", xlabel="time since the slide opened [s]")
            ax.set_xlim(left=0.0)
            if ax.get_legend_handles_labels()[0]:
                ax.legend(loc="lower left", fontsize=7)
        axes[0].set_ylabel("fraction retained [-]")
    return figure


def times(runs: pd.DataFrame) -> Figure:
    """Draw predicted over measured seconds of the study's runs: scene, measured, predicted."""
    with plt.rc_context(STYLE):
        figure, ax = plt.subplots(figsize=(5.6, 4.6), layout="constrained")
        seconds = runs[["measured", "predicted"]].to_numpy(float)
        top, low = 1.6 * seconds.max(), 0.6 * seconds.min()
        ax.fill_between([low, top], [low / 1.5, top / 1.5], [low * 1.5, top * 1.5], color="#e7eef5", lw=0)
        ax.plot([low, top], [low, top], color="#9fb3c8", lw=1)
        for scene in ("moist", "dry"):
            of = runs[runs["scene"] == scene]
            if len(of):
                ax.plot(of["measured"], of["predicted"], "o", ms=4.5, alpha=0.7, color=KIND_COLOUR[scene])
                ax.text(
                    0.04, 0.96 - 0.06 * (scene == "dry"), scene, transform=ax.transAxes, va="top", fontweight="bold",
                    color=KIND_COLOUR[scene],
                )  # fmt: skip
        ax.text(top / 1.1, top / 1.9, "within 1.5", ha="right", va="top", color="#5c6b79", fontsize=8)
        ax.set(xscale="log", yscale="log", xlim=(low, top), ylim=(low, top))
        ticks = [t for t in (0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500) if low < t < top]
        ax.set_xticks(ticks, [f"{t:g}" for t in ticks])
        ax.set_yticks(ticks, [f"{t:g}" for t in ticks])
        ax.minorticks_off()
        ax.set(xlabel="measured, processor time [s]", ylabel="predicted [s]")
    return figure
