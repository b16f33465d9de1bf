"""Choose time steps before a scene exists; `time_steps` then checks the step against every limit.

There are two rules, with the same drag: screening cases use a fraction of the shortest collision (as the paper does)
or damping time, all other scenes a share of the stable step of a dense packing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from pywet.laws.contact import S_MIN, bridge_radius, damping, pair_mass, pair_radii, reduced_radius
from pywet.laws.hertz import STIFFEST, Hertz, rayleigh_time
from pywet.planning import time_steps
from pywet.scene import ContactPair, SphereClass


def collision_time(pair: ContactPair, classes: Sequence[SphereClass]) -> float:
    """Return half the period [s] of the damped contact spring, the shorter of normal and tangential; E after (5).

    t_c = pi sqrt(m_eff/k)/sqrt(1 - zeta^2), zeta = -ln e/sqrt(pi^2 + ln^2 e). The tangential spring moves 2/7 of m_eff.
    """
    m_eff, log_e = pair_mass(classes, pair), math.log(pair.restitution)
    normal = math.sqrt(m_eff / pair.normal_stiffness_N_per_m) * math.hypot(math.pi, log_e)
    tangential = math.pi * math.sqrt(2.0 / 7.0 * m_eff / pair.tangential_stiffness_N_per_m)
    return min(normal, tangential)


def lubrication_drag(radius_i: float, radius_j: float, viscosity_Pa_s: float) -> float:
    """Return the drag coefficient [kg/s] of lubrication at the smallest gap: 6 pi eta r_red^2/S_min."""
    gap = S_MIN * bridge_radius(radius_i, radius_j)
    return 6.0 * math.pi * viscosity_Pa_s * reduced_radius(radius_i, radius_j) ** 2 / gap


def damping_time(pair: ContactPair, classes: Sequence[SphereClass], viscosity_Pa_s: float) -> float:
    """Return the shortest time m_eff/c [s] in which lubrication at the smallest gap stops a pair."""
    return pair_mass(classes, pair) / lubrication_drag(*pair_radii(classes, pair), viscosity_Pa_s)


def of_collisions(
    pairs: Sequence[ContactPair], classes: Sequence[SphereClass], fraction: float, viscosity_Pa_s: float = 0.0
) -> float:
    """Return a fraction of the shortest collision or damping time [s], truncated to three digits.

    A viscosity of zero omits the damping time (dry scenes, or the normal viscous force switched off).
    """
    used = [p for p in pairs if classes[p.a - 1].count and (p.b == 0 or classes[p.b - 1].count)]
    shortest = min(collision_time(p, classes) for p in used)
    if viscosity_Pa_s > 0:
        shortest = min(shortest, *(damping_time(p, classes, viscosity_Pa_s) for p in used))
    return float(f"{cut(fraction * shortest, 3):.3g}")


def of_packing(
    classes: Sequence[SphereClass], pairs: Sequence[ContactPair], share: float, viscosity_Pa_s: float = 0.0,
    hertz: Hertz | None = None,
) -> float:  # fmt: skip
    """Return a share of the stable step of a dense packing [s], truncated to two digits.

    Give `viscosity_Pa_s` if the drag is explicit. With `hertz` it is at most a fifth of the shortest Rayleigh
    time.
    """
    steps, stiffer = [], 1.0 if hertz is None else STIFFEST
    for pair in pairs:
        m, k = pair_mass(classes, pair), stiffer * pair.normal_stiffness_N_per_m
        drag = lubrication_drag(*pair_radii(classes, pair), viscosity_Pa_s)
        steps.append(time_steps.largest_step(m, k, damping(pair.restitution, m, k), drag, False, time_steps.PACKED))
        if hertz:
            steps.append(time_steps.hertz_step(m, pair, time_steps.PACKED))
    waves = zip(classes, hertz.spheres if hertz else (), strict=False)
    most = [time_steps.OF_RAYLEIGH * rayleigh_time(c.radius_m, c.density_kg_per_m3, e) for c, e in waves]
    return cut(min([share * min(steps), *most]), 2)


def cut(value: float, digits: int) -> float:
    """Truncate a number to the given number of digits.

    >>> cut(1.279e-5, 2)
    1.2e-05
    """
    unit = 10.0 ** (math.floor(math.log10(value)) - digits + 1)
    return math.floor(value / unit) * unit
