"""Figures of Davis 2023: single collisions (5, 7, 8, 11, 13b, 14, 15) and families over the Stokes number.

The families are figures 6, 9, 10, 12, 13a; a map of outcomes, which the paper does not have, is added.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Patch

from pywet.collisions.spheres.equal import head_on_restitution, three_equal_spheres
from pywet.collisions.spheres.simulate import run
from pywet.report.pictures import GREEN, NAVY, ORANGE, RED, panels
from studies.davis2023.maps import WINDOW, Plane, curve, window

COLOURS = (ORANGE, NAVY, GREEN)
"""Colours of spheres 1, 2, 3."""
GREY = "#8a939c"
STOKES = np.linspace(0.5, 20.0, 118)
OUTCOMES = ("FA", "PA: 1-2 stay", "PA: 2-3 stay", "PA: 1-3 stay", "FS")
PAINT = ("#27323d", "#d98032", "#4a9bd4", "#8b5fa5", "#dfe8d8")


def shade(part: float) -> Any:
    """Return the colour of a member of a family, 0 to 1."""
    return matplotlib.colormaps["viridis"](part)


def snapshots(rows: Sequence[tuple[str, dict[str, Any], Sequence[float]]]) -> Figure:
    """Draw one row per collision: positions of the spheres at the given instants t*, in units of their diameter."""
    columns = max(len(stars) for _, _, stars in rows)
    figure, axes = panels(columns * len(rows), columns, (2.1, 2.0))
    for k, (title, given, stars) in enumerate(rows):
        line, h_a = axes[k * columns : (k + 1) * columns], given.get("h_a", 0.01)
        stops = [window(given.get("theta12_deg", 45.0), h_a, t) for t in stars]
        seen = run(three_equal_spheres(**{**given, "t_end": stops[-1] + 1e-9}), times=stops).record["position"]
        for ax, star, places in zip(line, stars, seen, strict=False):
            for n, (x, y) in enumerate(places * h_a):
                ax.add_patch(Circle((x, y), 0.5, facecolor=COLOURS[n], edgecolor="black", alpha=0.85, lw=0.6))
                ax.text(x, y, str(n + 1), ha="center", va="center", color="white", fontsize=8)
            ax.set(xlim=(-2.2, 3.4), ylim=(-2.4, 2.4), aspect="equal", xticks=[], yticks=[], title=f"t* = {star:g}")
        line[0].set_ylabel(title)
        for ax in line[len(stars) :]:
            ax.axis("off")
    return figure


def gaps(ax: Axes, pair: int, style: dict[str, Any], **given: Any) -> np.ndarray:
    """Draw the gap of a pair (0: 1-2, 1: 1-3, 2: 2-3) over t̂ while the films overlap; returns time, gap and angle."""
    problem = three_equal_spheres(**given)
    even = np.linspace(0.0, problem.t_end, 800)[1:]
    steps, smooth = run(problem, record=20000).record, run(problem, times=even).record
    order = np.argsort(np.concatenate([steps["time"], smooth["time"]]), kind="stable")
    time, gap, angle = (np.concatenate([steps[k], smooth[k]])[order] for k in ("time", "gap", "angle"))
    wet = gap[:, pair] <= 1.0 + 1e-9
    ax.plot(time[wet], gap[wet, pair], **{"lw": 1.2, **style})
    return np.stack([time[wet], gap[wet, pair], angle[wet, pair]])


def gap_axes(ax: Axes, until: float, title: str) -> None:
    """Label a panel of gaps over time, and draw the gap of contact."""
    ax.axhline(0.05, color=GREY, ls=":", lw=0.8)
    ax.set(xlabel="t̂", ylabel="ĥ", xlim=(0, until), ylim=(0, 1), title=title)


def figure_7() -> Figure:
    """Draw gap 1-2 over time for St 2, 3, 4, 7 and the angle of the pair for St 2."""
    figure, (ax,) = panels(1, 1, (6.4, 4.2))
    other = ax.twinx()
    for stokes in (2.0, 3.0, 4.0, 7.0):
        time, _, angle = gaps(ax, 0, {"color": NAVY}, St_n=stokes, t_end=250.0)
        if stokes == 2.0:
            other.plot(time, np.degrees(angle), color=RED, ls=":", lw=1.2)
    gap_axes(ax, 200.0, "St$_n$ = 2, 3, 4, 7 (right to left), pair 1-2")
    other.set_ylabel("θ$_{12}$ [°], St$_n$ = 2 (dotted)", color=RED)
    return figure


def figure_8() -> Figure:
    """Draw gap 1-2 over time at St 7 and 3.5 for several capillary numbers."""
    figure, axes = panels(2, 2, (4.8, 3.8), sharey=True)
    cases = ((7.0, (6, 7, 8, 10), 12.0), (3.5, (100, 200, 500, 1000), 140.0))
    for ax, (stokes, numbers, end) in zip(axes, cases, strict=True):
        gaps(ax, 0, {"color": "black", "label": "Ca → ∞"}, St_n=stokes, t_end=end)
        for k, ca in enumerate(numbers):
            style = {"color": shade(0.15 + 0.22 * k), "ls": "--", "label": f"Ca = {ca}"}
            gaps(ax, 0, style, St_n=stokes, Ca=float(ca), t_end=end)
        gap_axes(ax, end, f"St$_n$ = {stokes:g}, pair 1-2")
        ax.legend(fontsize=8)
    return figure


def figure_11() -> Figure:
    """Draw gaps 1-2 and 2-3 over time at 30° for St 7, 12, 20."""
    figure, (ax,) = panels(1, 1, (6.4, 4.2))
    for stokes, colour in ((7.0, RED), (12.0, NAVY), (20.0, GREEN)):
        given = {"St_n": stokes, "theta12_deg": 30.0, "t_end": 20.0}
        gaps(ax, 0, {"color": colour, "label": f"1-2, St {stokes:g}"}, **given)
        gaps(ax, 2, {"color": colour, "ls": "--"}, **given)
    gap_axes(ax, 6.0, "1-2 (solid), 2-3 (dashed), θ$_{12}$ = 30°")
    ax.legend(fontsize=8)
    return figure


def figure_13b() -> Figure:
    """Draw dimensionless rotation rates and gaps at St 8 without and with friction."""
    figure, (top, bottom) = panels(2, 1, (6.4, 3.2), sharex=True)
    slope = math.tan(math.radians(-45.0))
    for mu_f, style in ((0.0, "-"), (0.1, "--")):
        r = run(three_equal_spheres(8.0, mu_f=mu_f, t_end=4.0), record=20000).record
        for pair, colour, name in ((0, NAVY, "12"), (2, RED, "23")):
            line = -r["sideways"][:, pair] / (100.0 + r["gap"][:, pair]) * 100.0 / slope
            spin = (r["omega"][:, pair // 2] + r["omega"][:, 1 + pair // 2]) * 100.0 / slope
            top.plot(r["time"], line, color=colour, ls=style, lw=1.2, label=f"Ω$_{{{name}}}$, μ$_f$ {mu_f:g}")
            top.plot(r["time"], spin, color=colour, ls=style, lw=0.7, alpha=0.7)
            bottom.plot(r["time"], r["gap"][:, pair], color=colour, ls=style, lw=1.2)
    top.set(ylabel="Ω̂ (thick), ω̂ (thin)")
    top.legend(fontsize=7, ncol=2)
    bottom.set(xlabel="t̂", ylabel="ĥ$_{12}$ (blue), ĥ$_{23}$ (red)", xlim=(0, 4), ylim=(0, 1.1))
    return figure


def family(title: str, members: Sequence[tuple[str, dict[str, Any]]]) -> Figure:
    """Draw curves over St_n, one for each member: e12 solid, e23 dashed, broken where they jump."""
    figure, (ax,) = panels(1, 1, (6.4, 4.4))
    for k, (label, given) in enumerate(members):
        colour = shade(0.9 * k / max(len(members) - 1, 1))
        for column, values in enumerate(curve(STOKES, **{"t_end": 600.0, **given}).T):
            line = np.where(np.abs(np.diff(values, prepend=values[0])) > 0.12, np.nan, values)
            ax.plot(STOKES, line, color=colour, ls="--" if column else "-", lw=1.2, label=None if column else label)
    ax.set(xlabel="St$_n$", ylabel="e$_{12}$ (solid), e$_{23}$ (dashed)", xlim=(0, 20), ylim=(0, 1), title=title)
    ax.legend(fontsize=8)
    return figure


def figure_6() -> Figure:
    """Draw Fig. 6: conditions of Fig. 5, with two spheres head on and oblique."""
    figure = family("ĥ$_a$ = 0.01, ĥ$_m$ = 0.05, no capillary force", [("three spheres, 45°", {})])
    ax, some = figure.axes[0], np.arange(1.0, 20.5, 1.0)
    ax.plot(STOKES, [head_on_restitution(s, 0.05) for s in STOKES], color=GREY, ls=":", label="two, head on (41), (42)")
    ax.plot(some, curve(some, h23_0=None, t_end=1500.0)[:, 0], "o", mfc="none", color=RED, ms=4, label="two, 45°")
    ax.legend(fontsize=8)
    return figure


def contour(map_: Plane) -> Figure:
    """Draw Fig. 10b: contours of e12 and e23 over impact angle and St_n."""
    figure, (ax,) = panels(1, 1, (6.6, 5.0))
    for values, last, colour, style in ((map_.e12, 0.85, NAVY, "solid"), (map_.e23, 0.65, RED, "dashed")):
        levels = np.arange(0.1, last, 0.1)
        lines = ax.contour(map_.angle_deg, map_.stokes, values, levels=levels, colors=colour, linestyles=style)
        ax.clabel(lines, fontsize=7)
    ax.set(xlabel="θ$_{12,0}$ [°]", ylabel="St$_n$", title="e$_{12}$ (solid), e$_{23}$ (dashed)")
    return figure


def outcome_map(map_: Plane) -> Figure:
    """Draw which spheres cohere at the end of the time window, and where films 1-2 separate slowly."""
    figure, (ax,) = panels(1, 1, (6.8, 5.0))
    at = map_.angle_deg, map_.stokes
    norm = BoundaryNorm(np.arange(-0.5, 5.0), 5)
    ax.pcolormesh(*at, map_.outcome, cmap=ListedColormap(PAINT), norm=norm, shading="nearest", rasterized=True)
    ax.contourf(*at, map_.slow, levels=[0.5, 1.5], hatches=["///"], colors="none")
    marks = [Patch(facecolor=c, label=n) for c, n in zip(PAINT, OUTCOMES, strict=True)]
    marks.append(Patch(facecolor="none", edgecolor="black", hatch="///", label="1-2: stick-rotate-separate"))
    ax.legend(handles=marks, fontsize=7, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    title = f"outcome at t* = {WINDOW:g}, no capillary force"
    ax.set(xlabel="θ$_{12,0}$ [°]", ylabel="St$_n$", title=title, yscale="log")
    return figure
