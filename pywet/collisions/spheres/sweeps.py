"""Figures of Davis 2023 over the Stokes number (6, 9, 10, 12, 13a), and the map of outcomes, which the paper does not have."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch

from pywet.collisions.spheres.equal import head_on_restitution
from pywet.collisions.spheres.maps import WINDOW, Plane, curve, plane, two_sphere_curve
from pywet.collisions.spheres.plots import BLUE, GREY, RED, save

STOKES = np.linspace(0.5, 20.0, 118)
OUTCOMES = ("FA", "PA: 1-2 stay", "PA: 2-3 stay", "PA: 1-3 stay", "FS")
PAINT = ("#27323d", "#d98032", "#4a9bd4", "#8b5fa5", "#dfe8d8")


def both(ax: Any, label: str, colour: Any, stokes: np.ndarray = STOKES, **given: Any) -> None:
    """e12 solid, e23 dashed, broken where they jump."""
    values = curve(stokes, **given)
    for k, style in ((0, "-"), (1, "--")):
        line = values[:, k].copy()
        line[1:][np.abs(np.diff(values[:, k])) > 0.12] = np.nan
        ax.plot(stokes, line, color=colour, ls=style, lw=1.2, label=label if k == 0 else None)


def axes(ax: Any, title: str) -> None:
    """Labels of a panel over St_n."""
    ax.set(xlabel="St$_n$", ylabel="e$_{12}$ (solid), e$_{23}$ (dashed)", xlim=(0, 20), ylim=(0, 1), title=title)
    ax.legend(fontsize=8)


def figure_6(path: Path) -> None:
    """Conditions of Fig. 5, with two spheres head on and oblique."""
    figure, ax = plt.subplots(figsize=(6.4, 4.4))
    both(ax, "three spheres, 45°", BLUE, t_end=600.0)
    ax.plot(STOKES, [head_on_restitution(s, 0.05) for s in STOKES], color=GREY, ls=":", label="two, head on (41), (42)")
    some = np.arange(1.0, 20.5, 1.0)
    ax.plot(some, two_sphere_curve(some, t_end=1500.0), "o", mfc="none", color=RED, ms=4, label="two, 45°")
    axes(ax, "ĥ$_a$ = 0.01, ĥ$_m$ = 0.05, no capillary force")
    save(figure, path)


def families(path: Path, title: str, members: list[tuple[str, dict[str, Any]]]) -> None:
    """A family of curves over St_n."""
    figure, ax = plt.subplots(figsize=(6.4, 4.4))
    for k, (label, given) in enumerate(members):
        both(ax, label, plt.cm.viridis(0.9 * k / max(len(members) - 1, 1)), **{"t_end": 600.0, **given})  # type: ignore[attr-defined]
    axes(ax, title)
    save(figure, path)


def contour(found: Plane, path: Path) -> None:
    """Fig. 10b: contours of e12 and e23 over impact angle and St_n."""
    figure, ax = plt.subplots(figsize=(6.6, 5.0))
    for values, levels, colour, style in (
        (found.e12, np.arange(0.1, 0.85, 0.1), BLUE, "solid"),
        (found.e23, np.arange(0.1, 0.65, 0.1), RED, "dashed"),
    ):
        lines = ax.contour(found.angle_deg, found.stokes, values, levels=levels, colors=colour, linestyles=style)
        ax.clabel(lines, fontsize=7)
    ax.set(xlabel="θ$_{12,0}$ [°]", ylabel="St$_n$", title="e$_{12}$ (solid), e$_{23}$ (dashed)")
    save(figure, path)


def outcomes(found: Plane, path: Path) -> None:
    """Who hangs together at the end of the window, and where films 1-2 part slowly."""
    figure, ax = plt.subplots(figsize=(6.8, 5.0))
    norm = BoundaryNorm(np.arange(-0.5, 5.0), 5)
    ax.pcolormesh(
        found.angle_deg, found.stokes, found.outcome, cmap=ListedColormap(PAINT), norm=norm, shading="nearest"
    )
    ax.contourf(found.angle_deg, found.stokes, found.slow, levels=[0.5, 1.5], hatches=["///"], colors="none")
    marks = [Patch(facecolor=c, label=n) for c, n in zip(PAINT, OUTCOMES, strict=True)]
    marks.append(Patch(facecolor="none", edgecolor="black", hatch="///", label="1-2: stick-rotate-separate"))
    ax.legend(handles=marks, fontsize=7, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    ax.set(
        xlabel="θ$_{12,0}$ [°]", ylabel="St$_n$", title=f"outcome at t* = {WINDOW:g}, no capillary force", yscale="log"
    )
    save(figure, path)


def sweeps(folder: Path, grid: int = 60, workers: int = 2) -> None:
    """Figures 6, 9, 10a, 10b, 12a, 12b, 13a and the maps of outcomes."""
    figure_6(folder / "figure_06.png")
    print("figure 6", flush=True)
    numbers = [
        ("Ca → ∞", {}),
        *((f"Ca = {c:g}", {"Ca": c, "t_end": 60.0 if c < 100 else 250.0}) for c in (100.0, 40.0, 10.0)),
    ]
    families(folder / "figure_09.png", "capillary number", numbers)
    print("figure 9", flush=True)
    angles = [(f"{a:g}°", {"theta12_deg": a}) for a in (15.0, 22.5, 30.0, 37.5, 45.0, 60.0)]
    families(folder / "figure_10a.png", "impact angle", angles)
    print("figure 10a", flush=True)
    thick = [(0.005, 0.1, 2000.0), (0.01, 0.05, 1000.0), (0.02, 0.025, 500.0)]
    members = [(f"ĥ$_a$ = {a:g}", {"h_a": a, "h_min": h, "Ca": c}) for a, h, c in thick]
    families(folder / "figure_12a.png", "film thickness", members)
    rough = [(f"ĥ$_m$ = {h:g}", {"h_min": h, "Ca": 1000.0}) for h in (0.02, 0.05, 0.1)]
    families(folder / "figure_12b.png", "smallest gap", rough)
    families(folder / "figure_13a.png", "friction", [(f"μ$_f$ = {m:g}", {"mu_f": m}) for m in (0.0, 0.1, 0.2)])
    print("figures 12, 13a", flush=True)
    contour(
        plane(np.linspace(1.0, 80.0, grid), np.linspace(0.5, 20.0, grid), workers=workers), folder / "figure_10b.png"
    )
    print("figure 10b", flush=True)
    outcomes(
        plane(np.linspace(0.5, 85.0, grid), np.geomspace(0.5, 40.0, grid), workers=workers), folder / "outcome_map.png"
    )
    print("outcome map", flush=True)
