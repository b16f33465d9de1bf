"""Pictures of the law comparison: errors over separation and volume, rupture, transfer, validation configurations, cost."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pywet.laws import exact_bridge as young_laplace
from pywet.laws import registry
from pywet.report.bridge import short
from pywet.report.pictures import GREEN, NAVY, ORANGE, RED, SKY, VIOLET, colours, panels
from pywet.schema import LARGE_WALL, SPHERE
from studies.law_comparison.errors import RUPTURE

SHOWN = ("rabinovich", "lambert", "willett", "willett_simple", "weigert", "soulie", "bagheri")
"""Closed forms that are drawn."""
COLOURS = dict(zip(SHOWN, ("#c0392b", "#d98032", "#0b3c78", "#4a9bd4", "#8b5fa5", "#5d8a3a", "#2aa198"), strict=True))
EXACT: Any = {"color": "#27323d", "lw": 2.2, "label": "exact (Young-Laplace)"}
CUSTOM_COLOURS = ("#000000", "#6b7680", "#b58900", "#d33682")
"""Colours of custom laws, drawn dashed."""


def error_maps(forces: pd.DataFrame, errors: pd.DataFrame, custom: Sequence[str] = ()) -> Figure:
    """Draw the error of each law in colour over S/S_rup and V*, equal spheres, contact angle 20°."""
    drawn = (*SHOWN, *custom)
    figure, axes = panels(len(drawn), 4, (2.9, 2.5))
    equal = forces[(forces["ratio"] == 1.0) & (forces["angle_i_deg"] == forces["angle_j_deg"])]
    degrees = 20.0 if (equal["angle_i_deg"] == 20.0).any() else equal["angle_i_deg"].iloc[0]
    at = equal.index[equal["angle_i_deg"] == degrees]
    image: Any = None
    for axis, law in zip(axes, drawn, strict=False):
        off = forces.loc[at].assign(error=100 * errors.loc[at, law])
        table = off.pivot_table(index="v_star", columns="share", values="error")
        look: dict[str, Any] = {"cmap": "RdBu_r", "vmin": -50, "vmax": 50, "shading": "nearest"}
        image = axis.pcolormesh(table.columns, np.log10(table.index), table.to_numpy(), **look)
        axis.set(title=short(law), xlabel="S / S_rup", ylabel="log₁₀ V*")
        axis.grid(False)
    figure.colorbar(image, ax=list(axes), label="F / F exact − 1  [%]", shrink=0.7, extend="both")
    return figure


def force_curves(custom: Sequence[str] = ()) -> Figure:
    """Draw force over separation of all laws for equal spheres at four contact angles."""
    figure, axes = panels(4, 4, (3.0, 2.8))
    for axis, degrees in zip(axes, (0.0, 20.0, 40.0, 60.0), strict=True):
        theta = math.radians(degrees)
        _curves(axis, 1e-2, (1.0, 1.0, theta, theta), 1.0, custom)
        axis.set(title=f"θ = {degrees:g}°, V* = 0.01", xlabel="S / r", ylabel="F / (σ r)", ylim=(0, 9))
    axes[0].legend(fontsize=7)
    return figure


def _curves(
    axis: Axes, volume: float, pair: tuple[float, float, float, float], sigma: float, custom: Sequence[str] = ()
) -> None:
    """Draw exact force and laws up to the exact rupture distance."""
    limit = young_laplace.rupture(volume, *pair).separation
    gaps = limit * (1.0 - (1.0 - np.linspace(0.0, 1.0, 60)) ** 2) * (1.0 - 1e-9)
    solved = [young_laplace.solve(s, volume, *pair) for s in gaps]
    looks: dict[str, Any] = {law: {"color": colour} for law, colour in COLOURS.items()}
    of_custom = zip(custom, colours(len(custom), CUSTOM_COLOURS), strict=True)
    looks |= {law: {"color": colour, "ls": (0, (4, 2))} for law, colour in of_custom}
    for law, look in looks.items():
        values = registry.get("capillary", law).functions[0](gaps, volume, *pair, sigma)
        axis.plot(gaps, values, lw=1.1, label=short(law), **look)
    axis.plot(gaps, [b.force(sigma) if b else np.nan for b in solved], **EXACT)
    axis.axvline(limit, color="#27323d", lw=0.8, ls=":")


def rupture_curves(limits: pd.DataFrame, custom: Sequence[str] = ()) -> Figure:
    """Draw rupture laws over the exact rupture distance, by volume, one panel per radius ratio."""
    laws = [name for name in registry.BUILT_IN["rupture"] if name not in ("young_laplace", "buck", "davis")] + [*custom]
    of_laws = colours(len(laws), ("#0b3c78", "#4a9bd4", "#5d8a3a", "#d98032", *CUSTOM_COLOURS))
    ratios = limits["ratio"].unique().tolist()
    figure, axes = panels(len(ratios), 4, (3.0, 2.7))
    for axis, q in zip(axes, ratios, strict=False):
        for degrees, style in ((0.0, "-"), (40.0, "--"), (60.0, ":")):
            part = limits[
                (limits["ratio"] == q) & (limits["angle_i_deg"] == degrees) & (limits["angle_j_deg"] == degrees)
            ]
            given = [part[n].to_numpy(float) for n in RUPTURE]
            for law, colour in zip(laws, of_laws, strict=True):
                values = registry.get("rupture", law).functions[0](*given) / part["rupture"].to_numpy()
                axis.plot(
                    part["v_star"], values, style, color=colour, lw=1.1, label=short(law) if style == "-" else None
                )
        name = "wall" if q == 0 else f"r_small / r_large = {q:g}"
        axis.axhline(1.0, color="#27323d", lw=2)
        axis.set(title=name, xscale="log", xlabel="V*", ylabel="S_rup / exact", ylim=(0.5, 1.7))
    axes[0].legend(fontsize=6.5, title="θ: 0° solid, 40° dashed, 60° dotted", title_fontsize=6.5)
    return figure


def fig7() -> Figure:
    """Draw Fig. 7 of Elskamp & Kruggel-Emden: transfer ratio by the parabola (solid) and by the exact profile (dashed)."""
    v = np.concatenate([np.linspace(0.002, 0.02, 6), np.linspace(0.04, 0.5, 16)])
    figure, axes = panels(4, 4, (3.0, 2.8))
    for axis, letter, degrees in zip(axes, "abcd", (10.0, 40.0, 10.0, 40.0), strict=True):
        t = math.radians(degrees)
        if letter in "ab":
            title, colours = f"spheres, θ = {degrees:g}°", [NAVY, SKY, GREEN, ORANGE]
            pairs = {f"r_i/r_j = {5 / r:.2g}": (5e-3, r * 1e-3, t, t, SPHERE) for r in (1.5, 2.5, 3.5, 5.0)}
        else:
            title, colours = f"wall, r = 1.5 mm, θ_i = {degrees:g}°", [NAVY, SKY, GREEN, VIOLET, ORANGE, RED]
            walls = range(0, 60, 10)
            pairs = {f"θ_w = {wall}°": (1.5e-3, 1.5e-3, t, math.radians(wall), LARGE_WALL) for wall in walls}
        for (name, pair), colour in zip(pairs.items(), colours, strict=True):
            for model, style, label in (("parabola", "-", name), ("young_laplace", "--", None)):
                axis.plot(v, registry.transfer_model(model)(*pair, v), style, color=colour, lw=1.2, label=label)
        axis.set(title=f"({letter}) {title}", ylabel="T_i")
    for axis in axes:
        axis.set(xlabel="V*", xlim=(0, 0.5), ylim=(0, 1))
        axis.legend(fontsize=6.5)
    return figure


def validation() -> Figure:
    """Draw the configurations of Figs. 4a, 4b, 5a of Elskamp & Kruggel-Emden with all laws and the exact force."""
    ten = math.radians(10.0)
    cases = [
        ("Fig. 4a: r = 2.381 mm, V = 13.6 µl·10⁻³, θ = 0°", 13.6e-12, (2.381e-3, 2.381e-3, 0.0, 0.0), 0.0206),
        ("Fig. 4b (caption): r = 19, 35 µm, θ = 0°", 2e-19, (19e-6, 35e-6, 0.0, 0.0), 0.0270),
        ("Fig. 4b (text): r = 19, 35 µm, θ = 10°", 2e-19, (19e-6, 35e-6, ten, ten), 0.0270),
        ("Fig. 5a: wall, r = 12 µm, θ = 0°", 7e-19, (12e-6, math.inf, 0.0, 0.0), 0.026),
        ("Fig. 5a: wall, r = 25 µm, θ = 10°", 170e-19, (25e-6, math.inf, ten, ten), 0.026),
    ]
    figure, axes = panels(len(cases) + 1, 3, (3.9, 3.0))
    for axis, (title, volume, pair, sigma) in zip(axes, cases, strict=False):
        _curves(axis, volume, pair, sigma)
        axis.set(title=title, xlabel="S [m]", ylabel="F [N]", ylim=(0, None))
        axis.ticklabel_format(scilimits=(-2, 2), axis="both")
    axes[0].legend(fontsize=7)
    _fig5b(axes[len(cases)])
    return figure


def _fig5b(axis: Axes) -> None:
    """Draw Fig. 5b: capillary and viscous force at four speeds, to the dynamic rupture distance."""
    pair, volume, sigma, eta = (4e-3, 4e-3, math.radians(10.0), math.radians(10.0)), 5e-10, 0.021, 0.1
    capillary, viscous = (
        registry.get(k, n).functions[0] for k, n in (("capillary", "rabinovich"), ("viscous_normal", "pitois"))
    )
    limit = registry.get("rupture", "willett_unequal").functions[0](volume, *pair)
    growth = registry.get("dynamic_rupture", "pitois").functions[0]
    exact_limit = young_laplace.rupture(volume, *pair).separation
    near = exact_limit * np.geomspace(1e-3, 1 - 1e-9, 60)
    solved = np.array([b.force(sigma) if (b := young_laplace.solve(s, volume, *pair)) else np.nan for s in near])
    for speed, colour in ((1e-4, "#0b3c78"), (1e-3, "#4a9bd4"), (5e-3, "#5d8a3a"), (1e-2, "#d98032")):
        gaps = np.geomspace(1e-3 * limit, limit * growth(speed, eta, sigma), 200)
        total = capillary(gaps, volume, *pair, sigma) - viscous(gaps, volume, pair[0], pair[1], speed, eta)
        axis.plot(gaps / pair[0], total / (sigma * pair[0]), color=colour, lw=1.2, label=f"{1e3 * speed:g} mm/s")
        drag = -viscous(near, volume, pair[0], pair[1], speed, eta)
        axis.plot(near / pair[0], (solved + drag) / (sigma * pair[0]), "--", color=colour, lw=1.2)
    axis.set(title="Fig. 5b: r = 4 mm, rabinovich (solid), exact (dashed) + pitois", xscale="log", yscale="log")
    axis.set(xlabel="S / r_eff", ylabel="F / (σ r_eff)")
    axis.legend(fontsize=7)


def cost_bars(cost: pd.DataFrame) -> Figure:
    """Draw the cost of each law in nanoseconds per call."""
    figure, axes = panels(1, 1, (6.0, 2.8))
    table = cost.sort_values("ns")
    colours = ["#0b3c78" if law == "young_laplace" else "#9fb3c8" for law in table["law"]]
    axes[0].barh(table["law"], table["ns"], color=colours)
    axes[0].set(xlabel="nanoseconds per call")
    axes[0].grid(axis="y", visible=False)
    return figure
