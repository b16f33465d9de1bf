"""The scene's dry contacts in the terms of YADE's linear spring and dashpot (`FrictViscoMat`, `…_CundallStrackVisco`).

Stiffnesses and friction are given per pair of materials. Damping is not: YADE uses 2 √(m_eff k_n) times the mean of
the two materials' fractions β of critical damping. One β per sphere class and one for the walls are fitted by least
squares so that each pair has the damping [kg/s] used in LIGGGHTS, `leapfrog_damping`; the residual is checked.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pywet.errors import PywetError
from pywet.geometry.surface import Floats
from pywet.laws.contact import leapfrog_damping, pair_mass
from pywet.scene import EngineScene

LARGEST_MISS = 0.02
"""Largest relative error of a pair's damping for which a scene is run; it changes a restitution of 0.8 by 0.004."""


def contacts(scene: EngineScene) -> dict[str, Any]:
    """Return the contact parameters for YADE; PywetError if no damping shares reproduce the scene's coefficients of restitution.

    For each of `pairs` of material numbers (0: the walls) its normal `stiffness` [N/m], the `ratio` of the
    tangential one to it and its `friction`; `damping_share`: β of the walls, then of each class; `largest_miss`:
    largest relative error of the damping.
    """
    wanted = []
    for pair in scene.pairs:
        mass = pair_mass(scene.classes, pair)
        critical = 2.0 * np.sqrt(mass * pair.normal_stiffness_N_per_m)
        wanted.append(
            leapfrog_damping(pair.restitution, mass, pair.normal_stiffness_N_per_m, scene.time_step_s) / critical
        )
    share, miss = _shares(scene, np.array(wanted))
    if miss > LARGEST_MISS or share.min() < 0:
        raise PywetError(
            f"the coefficients of restitution of scene {scene.name} cannot be represented in YADE, which has one damping per "
            f"material (the worst pair is off by {100 * miss:.0f} %); give spheres of all classes the same coefficient",
            code="yade.restitution",
        )
    return {
        "pairs": [(p.b, p.a) for p in scene.pairs],
        "stiffness": [p.normal_stiffness_N_per_m for p in scene.pairs],
        "ratio": [p.tangential_stiffness_N_per_m / p.normal_stiffness_N_per_m for p in scene.pairs],
        "friction": [p.friction for p in scene.pairs],
        "damping_share": share.tolist(),
        "largest_miss": miss,
    }


def _shares(scene: EngineScene, wanted: Floats) -> tuple[Floats, float]:
    """Return β of walls and classes with (β_a + β_b)/2 = wanted of the pair (a, b), and the largest relative error."""
    matrix = np.zeros((len(scene.pairs), len(scene.classes) + 1))
    for row, pair in enumerate(scene.pairs):
        matrix[row, pair.a] += 0.5
        matrix[row, pair.b] += 0.5
    scale = np.maximum(wanted, 1e-9)
    fitted = np.linalg.lstsq(matrix / scale[:, None], wanted / scale, rcond=None)[0]
    share: Floats = np.where(np.abs(fitted) < 1e-12, 0.0, fitted).astype(float)
    return share, float(np.max(np.abs(matrix @ share - wanted) / np.maximum(wanted, 1e-3)))
