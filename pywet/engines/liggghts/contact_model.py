"""Dry contact of a scene in LIGGGHTS: what the plugin computes; the engine's contact model and properties of types and pairs."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pywet.laws import contact
from pywet.scene import ContactPair, EngineScene, WallMesh


def attached(scene: EngineScene) -> bool:
    """Return whether the plugin is in use: for bridges, analytic wires, inserted or retired spheres, walls that may repeat."""
    return (
        scene.effects.bridges
        or scene.has_insertion
        or scene.removes
        or continues(scene)
        or any(w.analytic_wires for w in scene.walls)
    )


def continues(scene: EngineScene) -> bool:
    """Return whether walls may continue through a periodic face, where the plugin corrects the engine's corners."""
    return scene.periodic is not None and bool(scene.walls)


def touched(scene: EngineScene) -> list[str]:
    """Return the walls whose contacts the engine computes; the plugin has those with analytic wires and, with `planes`, all."""
    plugin = attached(scene) and scene.contacts == "planes"
    return [w.name for w in scene.walls if not (plugin or w.analytic_wires)]


def mesh_style(scene: EngineScene, wall: WallMesh) -> str:
    """Return the style of a wall; a moving wall of a moist scene stores the sum of contact forces, for the work of the wall."""
    moist = scene.effects.bridges and scene.effects.wall_films
    return "mesh/surface/stress" if moist and wall.motion != "fixed" and wall.name in touched(scene) else "mesh/surface"


def commands(scene: EngineScene) -> dict[str, Any]:
    """Return the values for the templates of a deck."""
    return {
        "attached": attached(scene),
        "continues": continues(scene),
        "touched": touched(scene),
        "mesh_style": {w.name: mesh_style(scene, w) for w in scene.walls},
        "style": words(scene),
        "settings": settings(scene),
        "materials": of_materials(scene),
        "properties": property_matrices(scene),
    }


def words(scene: EngineScene) -> str:
    """Return the contact model of pairs and walls."""
    normal = "hooke/stiffness" if scene.hertz is None else "hertz"
    friction = "history" if scene.effects.tangential_history else "no_history"
    rolling = " rolling_friction cdt" if scene.effects.rolling else ""
    return f"model {normal} tangential {friction}{rolling}"


def settings(scene: EngineScene) -> str:
    """Return the settings of the contact model; the tangential dashpot of a Hertz contact is on, the engine's default."""
    if scene.hertz is not None:
        return " tangential_damping on"
    damped = "off" if scene.effects.tangential_history else "on"
    return f" absolute_damping on tangential_damping {damped}"


def of_materials(scene: EngineScene) -> dict[str, str]:
    """Return Young's moduli and Poisson's ratios of the atom types for Hertz contacts; the last type is that of the walls."""
    if scene.hertz is None:
        return {}
    of = (*scene.hertz.spheres, scene.hertz.walls)
    return {
        "youngsModulus": " ".join(repr(e.youngs_modulus_Pa) for e in of),
        "poissonsRatio": " ".join(repr(e.poissons_ratio) for e in of),
    }


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
        "gammat_abs": 0.0 if scene.effects.tangential_history else contact.sliding_drag(m_eff, scene.time_step_s),
    }
