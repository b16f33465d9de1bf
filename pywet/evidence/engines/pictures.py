"""Pictures of the cross-check: fraction retained of both engines over time, and bridges drawn apart in all engines."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.apparatus.surface import Floats
from pywet.report.pictures import plt, save_png

PLAIN: Any = {"font.size": 10, "axes.spines.top": False, "axes.spines.right": False}
COLOURS = {"LIGGGHTS": "#1f5fa8", "YADE": "#d9661f", "washino": "#7a5195", "easo": "#3a9e6f", "exact": "#222222"}


def screening(times: Floats, one: Floats, two: Floats, frame: pd.DataFrame, said: str, path: Path) -> None:
    """Each run as a thin line, the band of one standard deviation about the mean; below, the difference of the means
    with what is `said` of it."""
    with plt.rc_context(PLAIN):
        figure, (top, low) = plt.subplots(
            2, 1, figsize=(7.5, 6.2), sharex=True, height_ratios=(3, 1.3), layout="constrained"
        )
        for name, runs in (("LIGGGHTS", one), ("YADE", two)):
            mean, deviation = runs.mean(axis=0), runs.std(axis=0, ddof=1)
            top.plot(times, runs.T, color=COLOURS[name], lw=0.5, alpha=0.35)
            top.fill_between(times, mean - deviation, mean + deviation, color=COLOURS[name], alpha=0.2, lw=0)
            top.plot(times, mean, color=COLOURS[name], lw=2, label=f"{name}, mean of {len(runs)} seeds")
        top.set(ylabel="fraction retained", ylim=(None, 1.02))
        top.legend(frameon=False, title="band: one standard deviation; thin lines: runs", title_fontsize=9)
        top.set_title("Dry screening in two engines: same spheres, same walls, same contacts", loc="left", fontsize=11)
        error = frame["standard_error"].to_numpy()
        low.axhline(0, color="#888888", lw=0.8)
        low.fill_between(times, -2 * error, 2 * error, color="#bbbbbb", alpha=0.5, lw=0, label="± 2 standard errors")
        low.plot(times, frame["difference"], color="#222222", lw=1.5, label="YADE − LIGGGHTS")
        low.set(xlabel="time since the slide opened [s]", ylabel="difference")
        low.legend(frameon=False, ncols=2, fontsize=9, loc="upper left")
        low.set_title(said, loc="right", fontsize=9)
        save_png(figure, path)


def pulls(path: Path) -> None:
    """Force over gap: exact bridge, and what each engine gives, for spheres and at a wall."""
    from pywet.evidence.engines import pulls as scenes

    chosen = {name: scenes.PAIRS[name] for name in ("two equal spheres", "sphere and wall")}
    with plt.rc_context(PLAIN):
        figure, axes = plt.subplots(1, 2, figsize=(9, 4), sharey=True, layout="constrained")
        for ax, (title, pair) in zip(axes, chosen.items(), strict=True):
            limit = pair.limit("exact")
            gaps = np.linspace(0.005, 1.25, 40) * limit
            exact = pair.exact(gaps[gaps < limit])
            ax.plot(1e6 * gaps[gaps < limit], 1e3 * exact, color=COLOURS["exact"], lw=3, alpha=0.35, label="exact")
            closed = scenes.engine_forces(pair, gaps)
            styles = {scenes.OURS: (COLOURS["LIGGGHTS"], "-", 1.6), "YADE": (COLOURS["YADE"], "--", 1.8)}
            for engine, values in closed.items():
                colour, style, width = styles.get(engine, (COLOURS.get(engine, "#888888"), ":", 1.8))
                shown = np.where(np.nan_to_num(values) > 1e-12, values, np.nan)
                ax.plot(1e6 * gaps, 1e3 * shown, color=colour, ls=style, lw=width, label=engine)
            ax.set(title=title, xlabel="gap [µm]")
            ax.title.set_fontsize(11)
        axes[0].set_ylabel("attraction [mN]")
        axes[0].legend(frameon=False)
        save_png(figure, path)


def bed(table: pd.DataFrame, path: Path) -> None:
    """Settled beds: mean height of the centres and contacts per sphere, each seed a point."""
    labels = {"mean_height_over_radius": "mean height / radius", "contacts_per_sphere": "contacts per sphere"}
    names = list(table["engine"].unique())
    with plt.rc_context(PLAIN):
        figure, axes = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
        for ax, (column, label) in zip(axes, labels.items(), strict=True):
            ax.axhline(sum("dry" not in name for name in names) - 0.5, color="#bbbbbb", lw=0.8)
            for k, name in enumerate(names):
                values = table.loc[table["engine"] == name, column].to_numpy(float)
                ax.plot(values, np.full(len(values), k), "o", ms=5, alpha=0.6, color=_colour(name))
                ax.plot(values.mean(), k, "|", ms=22, mew=2, color=_colour(name))
            ax.set(xlabel=label, yticks=range(len(names)), yticklabels=names, ylim=(len(names) - 0.5, -0.5))
        save_png(figure, path)


def _colour(name: str) -> str:
    return (
        next((c for key, c in COLOURS.items() if name.startswith(key)), "#888888") if "dry" not in name else "#888888"
    )
