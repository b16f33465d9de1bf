"""Predicted shares of impulse: sum of |F| dt of one force over that of weight, capillary and viscous forces together.

Each class is treated as monodisperse, and a bridge counts once. They predict, within a stated factor, what a log of
all contacts would give; they do not decide anything (a small force can matter, a large one be balanced).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from pywet.planning.surroundings import Groups, Surroundings, collisions

BRIDGES_PER_SPHERE = 3.0
"""Half the number of partners of a sphere in a dense bed, including those at a small distance."""
MEAN_FORCE = 0.75
"""Mean capillary force over that at touch, in a bed: half the bridges are at touch, half stretched."""
RELATIVE_SPEED = 0.1
"""Normal relative speed of neighbours in a moving bed over the driving speed."""
SHEAR = 0.4
"""Slip over the speed of approach, reduced by rolling of spheres on each other; fitted to the scenes of the effects study."""
WITHIN = {"gravity": 3.0, "capillary": 3.0, "viscous_normal": 15.0, "viscous_tangential": 15.0}
"""Factor by which a measured share may differ from the predicted one, by effect."""


def predicted_shares(of: Sequence[Groups], counts: Sequence[int], s: Surroundings) -> dict[str, float]:
    """Return effect -> share over classes with these numbers of spheres; empty without weight or liquid."""
    total = dict.fromkeys(WITHIN, 0.0)
    for g, count in zip(of, counts, strict=True):
        for effect, impulse in _impulses(g, s).items():
            total[effect] += count * impulse
    everything = sum(total.values())
    return {effect: value / everything for effect, value in total.items()} if everything > 0 else {}


def _impulses(g: Groups, s: Surroundings) -> dict[str, float]:
    """Return the impulses on one sphere during the run [N s]."""
    weight = g.weight * s.duration_s
    if g.film == 0.0:
        return {"gravity": weight}
    if s.state == "dilute":
        pairs = 0.5 * collisions(g, s)
        in_and_out = g.slip_time + 0.5 * g.rupture / g.speed if g.speed > 0 else s.duration_s
        return {
            "gravity": weight,
            "capillary": pairs * g.surface_force * in_and_out,
            "viscous_normal": pairs * 2.0 * g.pass_impulse,
            "viscous_tangential": SHEAR * pairs * g.tangential_drag * 0.5 * g.speed * in_and_out,
        }
    gap = math.sqrt(g.smallest_gap * max(g.rupture, g.smallest_gap))  # between touch and rupture, mean of the logarithm
    moves = RELATIVE_SPEED * g.speed
    if s.state == "at_rest":
        moves = (g.weight + g.surface_force) / g.stiffness / s.duration_s
    active = BRIDGES_PER_SPHERE * s.duration_s
    return {
        "gravity": weight,
        "capillary": active * MEAN_FORCE * g.surface_force,
        "viscous_normal": active * g.normal_drag_gap / gap * moves,
        "viscous_tangential": SHEAR * active * g.tangential_drag * moves,
    }
