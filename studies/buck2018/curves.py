"""Lines of Figs. 6 to 13 of Buck et al. (2018), as tables: one row per point; `panel` and `line` identify the line."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from pywet.collisions.wall import wall
from pywet.collisions.wall.problem import Problem
from studies.buck2018 import buck_tables

LARGE, SMALL, ALUMINA = "glass_1.74mm", "glass_0.91mm", "alumina_1.74mm"
VELOCITIES = np.concatenate([np.arange(0.02, 1.5, 0.02), np.arange(1.5, 5.01, 0.1)])
ANGLES = np.concatenate([np.arange(0.5, 89.0, 0.5), np.arange(89.0, 89.95, 0.1)])
Layer = tuple[str, int] | None
LABELS = {"water": "water", "tween20": "Tween 20", "glycerol35": "35 % glycerol", "glycerol50": "51 % glycerol"}
WORKS = ("contact", "viscous", "capillary", "gravity")


def problem(particle: str = LARGE, layer: Layer = None, **given: Any) -> Problem:
    """Return the problem of a particle of table 1 on glass, dry or on a layer of table 5."""
    content = {
        "particle": buck_tables.PARTICLES[particle],
        "wall": buck_tables.GLASS_WALL,
        "liquid": buck_tables.layer(particle, *layer) if layer else None,
        "friction": buck_tables.FRICTION["dry"],
        "normal_velocity_m_per_s": 1.0,
        **given,
    }
    return Problem.model_validate(content)


def name(layer: Layer) -> str:
    """Name a liquid layer by its liquid and thickness."""
    return f"{layer[1]} µm {LABELS[layer[0]]}" if layer else "dry"


def over_velocity(particle: str, layer: Layer) -> list[dict[str, Any]]:
    """Compute e_n over the impact velocity."""
    cases = ((float(v), problem(particle, layer, normal_velocity_m_per_s=float(v))) for v in VELOCITIES)
    return [{"x": v, "e_n": wall.collide(case)["e_n"]} for v, case in cases]


def over_angle(
    layer: Layer, friction: float, spin: float, angles: Sequence[float] = tuple(ANGLES)
) -> list[dict[str, Any]]:
    """Return coefficients and spin after a collision of γ-Al2O3 at 1 m/s over the angle from the normal."""
    rows = []
    for angle in angles:
        got = wall.collide(problem(ALUMINA, layer, friction=friction, angle_deg=float(angle), omega_rad_per_s=spin))
        rows.append({"x": float(angle), **{k: got[k] for k in ("e_n", "e_t", "e_omega", "omega_out")}})
    return rows


def _table(parts: Sequence[tuple[str, str, list[dict[str, Any]]]]) -> pd.DataFrame:
    """Concatenate the rows of several lines: (panel, line, rows)."""
    return pd.DataFrame([{"panel": panel, "line": line, **row} for panel, line, rows in parts for row in rows])


def convergence() -> pd.DataFrame:
    """Compute Fig. 6: e_n of 1.74 mm glass at 1 m/s on 400 µm of water over the relative tolerance, by two methods of scipy."""
    case = problem(LARGE, ("water", 400))
    p = case.parameters()
    first = wall.start(case, p)
    parts = []
    for method in ("RK45", "DOP853"):
        states = [(10.0**-k, wall.integrate(p, first, 10.0**-k, method).state) for k in range(3, 14)]
        parts.append(("a", method, [{"x": r, "e_n": float(s[1])} for r, s in states]))
    return _table(parts)


def normal_glass() -> pd.DataFrame:
    """Compute Fig. 7: glass on glass; layer of water for two sizes, viscosity (400 µm as in table 5), surface tension."""
    panels: dict[str, tuple[str, Sequence[Layer]]] = {
        "a": (LARGE, [None, ("water", 100), ("water", 200), ("water", 400)]),
        "b": (SMALL, [("water", 100), ("water", 200)]),
        "c": (LARGE, [("water", 400), ("glycerol35", 400), ("glycerol50", 400)]),
        "d": (LARGE, [("water", 100), ("tween20", 100)]),
    }
    return _table(
        [(p, name(layer), over_velocity(particle, layer)) for p, (particle, ls) in panels.items() for layer in ls]
    )


def normal_alumina() -> pd.DataFrame:
    """Compute Fig. 8: γ-Al2O3 on glass; layer of water, viscosity at 200 µm."""
    panels: dict[str, Sequence[Layer]] = {
        "a": [("water", 100), ("water", 200), ("water", 400)],
        "b": [("water", 200), ("glycerol35", 200), ("glycerol50", 200)],
    }
    return _table([(p, name(layer), over_velocity(ALUMINA, layer)) for p, layers in panels.items() for layer in layers])


def dissipation() -> pd.DataFrame:
    """Compute Fig. 9: energies lost per mass [J/kg] over the velocity, 1.74 mm on 400 µm and 0.91 mm on 200 µm of water."""
    parts = []
    for panel, particle, layer in (("a", LARGE, ("water", 400)), ("b", SMALL, ("water", 200))):
        rows = []
        for v in np.arange(0.8, 3.01, 0.2):
            case = problem(particle, layer, normal_velocity_m_per_s=float(v))
            energies = wall.collide(case)["energy_J"]
            rows.append({"x": float(v), **{k: energies[k] / case.mass for k in WORKS}})
        parts.append((panel, name(layer), rows))
    return _table(parts)


def oblique() -> pd.DataFrame:
    """Compute Fig. 10: γ-Al2O3 on dry glass and on 100 µm Tween 20, spins of 200, 0 and −300 rad/s."""
    lines: list[tuple[Layer, str]] = [(None, "dry"), (("tween20", 100), "tween20")]
    return _table(
        [
            ("", f"{name(layer)}, {spin:g} rad/s", over_angle(layer, buck_tables.FRICTION[key], spin))
            for layer, key in lines
            for spin in (200.0, 0.0, -300.0)
        ]
    )


def spinning() -> pd.DataFrame:
    """Compute Figs. 11 and 12: γ-Al2O3 on 100 µm Tween 20 with the mean spins of table 4 (in the text −600 to −1800 rad/s)."""
    friction, spins = buck_tables.FRICTION["tween20"], [mean for mean, _ in buck_tables.SPINS["tween20_100um"].values()]
    return _table([("", f"{w:g} rad/s", over_angle(("tween20", 100), friction, w)) for w in spins])


def liquids() -> pd.DataFrame:
    """Compute Fig. 13: γ-Al2O3 with −500 rad/s: dry, two layers of Tween 20, a more viscous liquid; friction of table 3."""
    layers: tuple[Layer, ...] = (None, ("tween20", 100), ("tween20", 150), ("glycerol35", 100))
    frictions = [buck_tables.FRICTION[layer[0] if layer else "dry"] for layer in layers]
    return _table([("", name(k), over_angle(k, mu, -500.0)) for k, mu in zip(layers, frictions, strict=True)])
