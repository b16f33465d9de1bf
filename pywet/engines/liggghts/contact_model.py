"""Dry contact of a scene in LIGGGHTS commands: contact model, its settings, properties of types and pairs of types."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pywet.laws import contact
from pywet.scene import ContactPair, EngineScene


def words(scene: EngineScene, cohesion: str = "") -> str:
    """Return the contact model of pairs and walls; `cohesion`: arguments of a stock cohesion model."""
    normal = "hooke/stiffness" if scene.hertz is None else "hertz"
    friction = "history" if scene.effects.tangential_history else "no_history"
    rolling = " rolling_friction cdt" if scene.effects.rolling else ""
    return f"model {normal} tangential {friction}{cohesion}{rolling}"


def settings(scene: EngineScene, cohesive: bool) -> str:
    """Return the settings of the contact model; the tangential dashpot of a Hertz contact is on, the engine's default."""
    if scene.hertz is not None:
        return " tangential_damping on"
    damped = "off" if scene.effects.tangential_history else "on"
    return " absolute_damping on" + ("" if cohesive else f" tangential_damping {damped}")


def of_materials(scene: EngineScene) -> dict[str, str]:
    """Return Young's moduli and Poisson's ratios of the atom types for Hertz contacts; the last type is that of the walls."""
    if scene.hertz is None:
        return {}
    of = (*scene.hertz.spheres, scene.hertz.walls)
    return {
        "youngsModulus": " ".join(repr(e.youngs_modulus_Pa) for e in of),
        "poissonsRatio": " ".join(repr(e.poissons_ratio) for e in of),
    }


def sliding_drag(m_eff: float, time_step: float) -> float:
    """Return the drag [kg/s] of history-free friction: force min(c v, mu F_n) against the slip v.

    c = m_eff/(28 dt) is half of the stable value for a dense packing at that step, with spin (c < 2/7 m_eff/(4 dt));
    a sphere at rest on a slope then creeps at about mu g 28 dt, some tenths of a millimetre per second.
    """
    return m_eff / (28.0 * time_step)


def property_matrices(scene: EngineScene) -> dict[str, str]:
    """Return the engine's properties by pair of types; walls are the last type. Rolling friction [m] is divided by r_red."""
    n = len(scene.classes) + 1
    values: dict[str, NDArray[np.float64]] = {}
    for pair in scene.pairs:
        at = (pair.a - 1, (pair.b or n) - 1)
        r_red = contact.reduced_radius(*contact.pair_radii(scene.classes, pair))
        row = _springs(scene, pair) if scene.hertz is None else {"coefficientRestitution": pair.restitution}
        row |= {"coefficientFriction": pair.friction, "coefficientRollingFriction": pair.rolling_friction_m / r_red}
        for name, value in row.items():
            # wall against wall is never evaluated, but the engine wants positive numbers for some
            matrix = values.setdefault(name, np.full((n, n), value))
            matrix[at] = matrix[at[::-1]] = value
    if not scene.effects.rolling:
        del values["coefficientRollingFriction"]
    return {name: " ".join(repr(float(x)) for x in matrix.ravel()) for name, matrix in values.items()}


def _springs(scene: EngineScene, pair: ContactPair) -> dict[str, float]:
    """Return the linear springs and dashpots of a pair of types."""
    m_eff, k = contact.pair_mass(scene.classes, pair), pair.normal_stiffness_N_per_m
    return {
        "kn": k,
        "kt": pair.tangential_stiffness_N_per_m,
        "gamman_abs": contact.leapfrog_damping(pair.restitution, m_eff, k, scene.time_step_s),
        "gammat_abs": 0.0 if scene.effects.tangential_history else sliding_drag(m_eff, scene.time_step_s),
    }
