"""Small pictures of the table: force over gap of all programs, the settled bed, fraction retained of both engines."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from pywet.report.page import paragraph, picture
from studies.cross_code.model import Source
from studies.cross_code.rows import LIGGGHTS, PAIRS, YADE

STYLES: dict[str, dict[str, Any]] = {
    "exact solution": {"color": "#111111", "lw": 4.5, "alpha": 0.25},
    "LIGGGHTS + pywet, exact": {"color": "#0b3c78", "lw": 1.6},
    "LIGGGHTS + pywet, paper": {"color": "#2f7d4f", "lw": 1.6},
    "YADE Rabinovich": {"color": "#8a5aa8", "lw": 1.6, "ls": (0, (4, 2))},
    "YADE Willett_numeric": {"color": "#c88bd9", "lw": 1.6, "ls": (0, (1, 1.2))},
    "stock washino": {"color": "#d9822b", "lw": 1.4, "ls": "-."},
    "stock easo": {"color": "#b3261e", "lw": 1.4, "ls": "-."},
}
"""Line style of each program; the exact solution is the broad grey line that the others should cover."""


def all_of(sources: dict[str, Source]) -> str:
    """Return the pictures for which there are data."""
    body = ""
    for make, source, key, message in (
        (forces, "forces", "equal", FORCES),
        (bed, "replayed", "bed", BED),
        (retained, "engines", "retained", RETAINED),
    ):
        curves = sources[source].curves
        if key in curves:
            body += picture(make(curves if key == "equal" else curves[key]), message)
    if "retained" not in sources["engines"].curves:
        body += paragraph("Fraction retained in both engines: run `snakemake --cores 2 engines` first.", soft=True)
    return body


FORCES = (
    "Capillary force over gap, all programs in one picture (radius 2.5 mm, water, contact angle 15°, V* 0.01; left of zero the"
    " spheres overlap). The broad grey line is the exact bridge; a line ends where the program's bridge breaks."
)
BED = "Forty moist glass spheres at rest in a box, the bed whose every bridge was recomputed; seen from the side."
RETAINED = (
    "Fraction retained of the dry screening case in LIGGGHTS and YADE: runs, means and bands of one standard deviation."
)


def forces(curves: dict[str, Any]) -> Figure:
    """Draw force over gap for each pair of bodies."""
    figure, axes = plt.subplots(1, 3, figsize=(12.4, 4.2), layout="constrained")
    for axis, (key, name) in zip(axes, PAIRS.items(), strict=True):
        for program, style in STYLES.items():
            if program not in curves.get(key, {}):
                continue
            line = curves[key][program]
            gap = 1e3 * np.array(line["gap"], dtype=float)
            force = 1e3 * np.array([np.nan if f is None else f for f in line["force"]], dtype=float)
            positive = np.where(gap < 0, force, np.where(force > 0, force, np.nan))
            axis.plot(gap, positive, label=program, **style)
        axis.axvline(0.0, color="#9fb3c8", lw=0.8)
        axis.set(title=name, xlabel="gap [mm]", ylim=(0, None))
        axis.grid(alpha=0.25)
    axes[0].set_ylabel("attraction [mN]")
    axes[2].legend(fontsize=8, frameon=False)
    return figure


def bed(places: dict[str, Any]) -> Figure:
    """Draw the spheres of the bed from the side."""
    at, radius = 1e3 * np.array(places["at"], dtype=float), 1e3 * float(places["radius"])
    order = np.argsort(-at[:, 1])
    figure, axis = plt.subplots(figsize=(5.2, 3.0), layout="constrained")
    depth = (at[:, 1] - at[:, 1].min()) / max(float(np.ptp(at[:, 1])), 1e-9)
    patches = PatchCollection(
        [Circle((at[k, 0], at[k, 2]), radius) for k in order], edgecolor="white", linewidth=0.8,
        facecolor=plt.get_cmap("Blues_r")(0.15 + 0.6 * depth[order]),
    )  # fmt: skip
    axis.add_collection(patches)
    low, high = at[:, 0].min() - 2 * radius, at[:, 0].max() + 2 * radius
    axis.plot([low, high], [0, 0], color="#5c6b79", lw=2)
    axis.set(xlim=(low, high), ylim=(-0.3 * radius, at[:, 2].max() + 1.6 * radius), aspect="equal")
    axis.set(xlabel="x [mm]", ylabel="height [mm]")
    for side in ("top", "right"):
        axis.spines[side].set_visible(False)
    return figure


def retained(runs: dict[str, Any]) -> Figure:
    """Draw each run of both engines, means and one standard deviation about them; below, the difference of the means."""
    time, groups = np.array(runs["time"]), [np.array(runs[column], dtype=float) for column in (LIGGGHTS, YADE)]
    figure, (top, low) = plt.subplots(
        2, 1, figsize=(7.5, 6.2), sharex=True, height_ratios=(3, 1.3), layout="constrained"
    )
    for group, name, colour in zip(groups, ("LIGGGHTS", "YADE"), ("#1f5fa8", "#d9661f"), strict=True):
        mean, deviation = group.mean(axis=0), group.std(axis=0, ddof=1)
        top.plot(time, group.T, color=colour, lw=0.5, alpha=0.35)
        top.fill_between(time, mean - deviation, mean + deviation, color=colour, alpha=0.2, lw=0)
        top.plot(time, mean, color=colour, lw=2, label=f"{name}, mean of {len(group)} seeds")
    top.set(ylabel="fraction retained", ylim=(None, 1.02))
    top.legend(frameon=False)
    error = np.sqrt(sum(group.var(axis=0, ddof=1) / len(group) for group in groups))
    low.axhline(0, color="#888888", lw=0.8)
    low.fill_between(time, -2 * error, 2 * error, color="#bbbbbb", alpha=0.5, lw=0, label="± 2 standard errors")
    low.plot(time, groups[1].mean(axis=0) - groups[0].mean(axis=0), color="#222222", lw=1.5, label="YADE − LIGGGHTS")
    low.set(xlabel="time since the slide opened [s]", ylabel="difference")
    low.legend(frameon=False, ncols=2, loc="upper left")
    return figure
