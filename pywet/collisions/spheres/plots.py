"""Figures of Davis 2023 that follow single collisions: snapshots (5, 14, 15), gaps over time (7, 8, 11), rotation rates (13b)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from pywet.collisions.spheres.equal import three_equal_spheres
from pywet.collisions.spheres.maps import window
from pywet.collisions.spheres.simulate import run
from pywet.files import atomic_write

COLOURS = ("#d98032", "#0b3c78", "#5d8a3a")
"""Spheres 1, 2, 3."""
BLUE, RED, GREY = "#0b3c78", "#b03a2e", "#8a939c"


def save(figure: Figure, path: Path) -> None:
    """Write a figure whole."""
    with atomic_write(path) as temporary:
        figure.savefig(temporary, dpi=110, bbox_inches="tight")
    plt.close(figure)


def snapshots(rows: Sequence[tuple[str, dict[str, Any], Sequence[float]]], path: Path) -> None:
    """One row per collision: places of the spheres at the instants t* given, in units of their diameter, orientation marked."""
    columns = max(len(times) for _, _, times in rows)
    figure, axes = plt.subplots(len(rows), columns, figsize=(2.1 * columns, 2.0 * len(rows)), squeeze=False)
    for line, (title, given, stars) in zip(axes, rows, strict=True):
        angle, h_a = given.get("theta12_deg", 45.0), given.get("h_a", 0.01)
        stops = [window(angle, h_a, t) for t in stars]
        found = run(three_equal_spheres(**{**given, "t_end": stops[-1] + 1e-9}), times=stops)
        for ax, star, places in zip(line, stars, found.record["position"], strict=False):
            for k, (x, y) in enumerate(places * h_a):
                ax.add_patch(Circle((x, y), 0.5, facecolor=COLOURS[k], edgecolor="black", alpha=0.85, lw=0.6))
                ax.text(x, y, str(k + 1), ha="center", va="center", color="white", fontsize=8)
            ax.set(xlim=(-2.2, 3.4), ylim=(-2.4, 2.4), aspect="equal", xticks=[], yticks=[], title=f"t* = {star:g}")
        line[0].set_ylabel(title)
        for ax in line[len(stars) :]:
            ax.axis("off")
    save(figure, path)


def gaps(ax: Any, pair: int, style: dict[str, Any], **given: Any) -> np.ndarray:
    """Draw the gap of a pair (0: 1-2, 1: 1-3, 2: 2-3) over t̂ while the films overlap; returns time, gap and angle."""
    problem = three_equal_spheres(**given)
    steps, smooth = (
        run(problem, record=20000).record,
        run(problem, times=np.linspace(0.0, problem.t_end, 800)[1:]).record,
    )
    order = np.argsort(np.concatenate([steps["time"], smooth["time"]]), kind="stable")
    time, gap, angle = (np.concatenate([steps[k], smooth[k]])[order] for k in ("time", "gap", "angle"))
    wet = gap[:, pair] <= 1.0 + 1e-9
    ax.plot(time[wet], gap[wet, pair], **style)
    return np.stack([time[wet], gap[wet, pair], angle[wet, pair]])


def figure_7(path: Path) -> None:
    """Gap 1-2 over time for St 2, 3, 4, 7 and the angle of the pair for St 2."""
    figure, ax = plt.subplots(figsize=(6.4, 4.2))
    other = ax.twinx()
    for stokes in (2.0, 3.0, 4.0, 7.0):
        _, _, angle = gaps(ax, 0, {"color": BLUE, "lw": 1.2}, St_n=stokes, t_end=250.0)
        if stokes == 2.0:
            time = gaps(ax, 0, {"alpha": 0.0}, St_n=stokes, t_end=250.0)[0]
            other.plot(time, np.degrees(angle), color=RED, ls=":", lw=1.2)
    ax.axhline(0.05, color=GREY, ls="--", lw=0.8)
    ax.set(xlabel="t̂", ylabel="ĥ$_{12}$", xlim=(0, 200), ylim=(0, 1), title="St$_n$ = 2, 3, 4, 7 (right to left)")
    other.set_ylabel("θ$_{12}$ [°], St$_n$ = 2 (dotted)", color=RED)
    save(figure, path)


def figure_8(path: Path) -> None:
    """Gap 1-2 over time at St 7 and 3.5 for several capillary numbers."""
    figure, panels = plt.subplots(1, 2, figsize=(9.6, 3.8), sharey=True)
    for ax, stokes, numbers, end in (
        (panels[0], 7.0, (6, 7, 8, 10), 12.0),
        (panels[1], 3.5, (100, 200, 500, 1000), 140.0),
    ):
        gaps(ax, 0, {"color": "black", "lw": 1.3, "label": "Ca → ∞"}, St_n=stokes, t_end=end)
        for k, ca in enumerate(numbers):
            colour = plt.cm.viridis(0.15 + 0.22 * k)  # type: ignore[attr-defined]
            gaps(
                ax,
                0,
                {"color": colour, "ls": "--", "lw": 1.1, "label": f"Ca = {ca}"},
                St_n=stokes,
                Ca=float(ca),
                t_end=end,
            )
        ax.axhline(0.05, color=GREY, ls=":", lw=0.8)
        ax.set(xlabel="t̂", xlim=(0, end), ylim=(0, 1), title=f"St$_n$ = {stokes:g}")
        ax.legend(fontsize=8)
    panels[0].set_ylabel("ĥ$_{12}$")
    save(figure, path)


def figure_11(path: Path) -> None:
    """Gaps 1-2 and 2-3 over time at 30° for St 7, 12, 20."""
    figure, ax = plt.subplots(figsize=(6.4, 4.2))
    for k, stokes in enumerate((7.0, 12.0, 20.0)):
        colour = (RED, BLUE, COLOURS[2])[k]
        gaps(
            ax,
            0,
            {"color": colour, "lw": 1.2, "label": f"1-2, St {stokes:g}"},
            St_n=stokes,
            theta12_deg=30.0,
            t_end=20.0,
        )
        gaps(ax, 2, {"color": colour, "ls": "--", "lw": 1.2}, St_n=stokes, theta12_deg=30.0, t_end=20.0)
    ax.axhline(0.05, color=GREY, ls=":", lw=0.8)
    ax.set(xlabel="t̂", ylabel="ĥ", xlim=(0, 6), ylim=(0, 1), title="1-2 (solid), 2-3 (dashed), θ$_{12}$ = 30°")
    ax.legend(fontsize=8)
    save(figure, path)


def figure_13b(path: Path) -> None:
    """Dimensionless rotation rates and gaps at St 8 without and with friction."""
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(6.4, 6.4), sharex=True)
    slope = math.tan(math.radians(-45.0))
    for mu_f, style in ((0.0, "-"), (0.1, "--")):
        found = run(three_equal_spheres(8.0, mu_f=mu_f, t_end=4.0), record=20000)
        r = found.record
        for pair, colour, name in ((0, BLUE, "12"), (2, RED, "23")):
            line = -r["sideways"][:, pair] / (100.0 + r["gap"][:, pair]) * 100.0 / slope
            top.plot(r["time"], line, color=colour, ls=style, lw=1.2, label=f"Ω$_{{{name}}}$, μ$_f$ {mu_f:g}")
            spin = (r["omega"][:, pair // 2] + r["omega"][:, 1 + pair // 2]) * 100.0 / slope
            top.plot(r["time"], spin, color=colour, ls=style, lw=0.7, alpha=0.7)
            bottom.plot(r["time"], r["gap"][:, pair], color=colour, ls=style, lw=1.2)
    top.set(ylabel="Ω̂ (thick), ω̂ (thin)")
    top.legend(fontsize=7, ncol=2)
    bottom.set(xlabel="t̂", ylabel="ĥ$_{12}$ (blue), ĥ$_{23}$ (red)", xlim=(0, 4), ylim=(0, 1.1))
    save(figure, path)


def single_collisions(folder: Path) -> None:
    """Figures 5, 7, 8, 11, 13b, 14, 15."""
    stars = (0.0, 0.5, 1.0, 1.5, 2.0, 2.5)
    snapshots([(f"St$_n$ = {s:g}", {"St_n": s}, stars) for s in (2.0, 5.0, 10.0)], folder / "figure_05.png")
    snapshots([("St$_n$ = 2", {"St_n": 2.0}, (0.0, 1.5, 2.59, 3.2, 4.0, 4.57, 5.2))], folder / "figure_14.png")
    fifteen = {"St_n": 2.0, "theta23_deg": -45.0, "h_min": 0.04}
    snapshots([("θ$_{23}$ = −45°", fifteen, (0.0, 0.3, 0.6, 0.7, 2.5, 4.5, 6.08, 7.0))], folder / "figure_15.png")
    figure_7(folder / "figure_07.png")
    figure_8(folder / "figure_08.png")
    figure_11(folder / "figure_11.png")
    figure_13b(folder / "figure_13b.png")
