"""Statements of Elskamp & Kruggel-Emden (2018) on forces and transfer ratios in sections 3 and 4 (Figs.

4, 5, 7), on laws alone. Measured points of Figs. 4 and 5 are not printed as numbers; the exact bridge (Young-Laplace)
replaces them, because static measurements of a weightless bridge follow it. "Fits" is a force within 15 % of it over
the stated part of the separations up to rupture; "small separations" are those below a twentieth of the rupture
distance.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pywet.laws.capillary import rabinovich
from pywet.laws.capillary_fits import weigert, willett
from pywet.laws.exact_bridge import bridge
from pywet.laws.transfer import transfer_table
from pywet.laws.viscous import pitois
from pywet.schema import LARGE_WALL, SPHERE
from studies.full_scale.judging import Statement, above, below

Floats = NDArray[np.float64]
Bridge = tuple[float, float, float, float, float, float]
"""V [m3], r_i [m], r_j [m], θ_i [rad], θ_j [rad], σ [N/m]."""
TEN = math.radians(10.0)
FIG_4A: Bridge = (13.6e-12, 2.381e-3, 2.381e-3, 0.0, 0.0, 20.6e-3)
FIG_4B: Bridge = (2e-19, 19e-6, 35e-6, 0.0, 0.0, 26e-3)
FIG_5A: tuple[Bridge, ...] = (
    (7e-19, 12e-6, math.inf, 0.0, 0.0, 26e-3),
    (170e-19, 25e-6, math.inf, TEN, TEN, 26e-3),
)
FIG_5B: Bridge = (5e-10, 4e-3, 4e-3, TEN, TEN, 21e-3)
FIG_5B_VISCOSITY = 0.1
SMALL = 0.05
"""Share of the rupture distance below which separations are small."""
FITS = 0.15
VOLUMES = np.linspace(0.05, 0.4, 8)
"""V* at which transfer ratios are compared."""
RADIUS = 1.5e-3


def shares(start: float, stop: float) -> Floats:
    """Return separations as shares of the rupture distance."""
    return np.linspace(start, stop, 12)


def deviation(law: Callable[..., float], of: Bridge, start: float, stop: float) -> float:
    """Return the largest relative deviation of a capillary law from the exact bridge over a range of separations."""
    volume, ri, rj, ti, tj, tension = of
    rupture = bridge.rupture(volume, ri, rj, ti, tj).separation
    worst = 0.0
    for s in rupture * shares(start, stop):
        exact = bridge.solve(s, volume, ri, rj, ti, tj)
        if exact is not None:
            worst = max(worst, abs(law(s, *of) / exact.force(tension) - 1.0))
    return worst


def viscous_share(velocity: float, share: float) -> float:
    """Return the share of the viscous force in the sum of both in Fig. 5b at a share of the rupture distance."""
    volume, ri, rj, ti, tj, _ = FIG_5B
    s = share * bridge.rupture(volume, ri, rj, ti, tj).separation
    viscous = abs(pitois(s, volume, ri, rj, velocity, FIG_5B_VISCOSITY))
    return viscous / (viscous + rabinovich(s, *FIG_5B))


def of_pair(ratio: float, contact_angle_deg: float) -> Floats:
    """Return the share of the larger of two spheres over `VOLUMES`."""
    angle = math.radians(contact_angle_deg)
    return transfer_table(ratio * RADIUS, RADIUS, angle, angle, SPHERE, VOLUMES)


def of_wall(sphere_deg: float, wall_deg: float) -> Floats:
    """Return the share of a sphere that separates from a large wall, over `VOLUMES`."""
    return transfer_table(RADIUS, 0.0, math.radians(sphere_deg), math.radians(wall_deg), LARGE_WALL, VOLUMES)


def larger_gets(contact_angle_deg: float) -> float:
    """Return the mean share of the larger of spheres of 3.5 and 5 mm radius over V* from 0.05 to 0.4, by preset `paper`."""
    angle = math.radians(contact_angle_deg)
    return float(np.mean(transfer_table(5e-3, 3.5e-3, angle, angle, SPHERE, VOLUMES)))


def wall_gets(contact_angle_deg: float) -> float:
    """Return the mean share of a large steel wall (45°) in bridges to a sphere over V* from 0.05 to 0.4, by preset `paper`."""
    sphere = transfer_table(5e-3, 0.0, math.radians(contact_angle_deg), math.radians(45.0), LARGE_WALL, VOLUMES)
    return float(1.0 - np.mean(sphere))


def least_step(rows: list[Floats]) -> float:
    """Return the smallest difference between successive rows."""
    return float(min(np.min(b - a) for a, b in itertools.pairwise(rows)))


WALL_ANGLES = (0.0, 10.0, 20.0, 30.0, 40.0, 50.0)

# fmt: off
LAW_STATEMENTS: tuple[Statement, ...] = (
    Statement(40, "3, Fig. 4a", "Willett and Rabinovich fit over the whole distance and deviate only at very small ones.", (), (
        below("Willett, beyond small separations", FITS, lambda c: deviation(willett, FIG_4A, SMALL, 0.95)),
        below("Rabinovich, beyond small separations", FITS, lambda c: deviation(rabinovich, FIG_4A, SMALL, 0.95)),
    )),
    Statement(41, "3, Fig. 4a", "Weigert is best at a very small distance and has large discrepancies at larger ones.", (), (
        below("Weigert − the better of the others, at a hundredth of the rupture distance", 0.0,
              lambda c: deviation(weigert, FIG_4A, 0.01, 0.01)
              - min(deviation(law, FIG_4A, 0.01, 0.01) for law in (willett, rabinovich))),
        above("Weigert beyond small separations", 2 * FITS, lambda c: deviation(weigert, FIG_4A, SMALL, 0.95)),
    )),
    Statement(42, "3, Fig. 4b", "Between small spheres of two sizes the results are similar.", (), (
        below("Willett, beyond small separations", FITS, lambda c: deviation(willett, FIG_4B, SMALL, 0.95)),
        below("Rabinovich, beyond small separations", FITS, lambda c: deviation(rabinovich, FIG_4B, SMALL, 0.95)),
    )),
    Statement(43, "3, Fig. 5a", "At a wall Rabinovich fits very well but for very small distances.", (), tuple(
        below(f"{name} configuration", FITS, lambda c, of=of: deviation(rabinovich, of, SMALL, 0.95))  # type: ignore[misc]
        for name, of in zip(("first", "second"), FIG_5A, strict=True)
    )),
    Statement(44, "3, Fig. 5b", "At 0.1 mm/s the force is nearly all capillary.", (), (
        below("viscous share at a twentieth of the rupture distance", 0.1, lambda c: viscous_share(1e-4, SMALL)),
    )),
    Statement(45, "3, Fig. 5b", "At larger speeds the viscous force gains at short distances.", (), (
        above("viscous share at 10 mm/s − that at 0.1 mm/s, at a twentieth of the rupture distance", 0.1,
              lambda c: viscous_share(1e-2, SMALL) - viscous_share(1e-4, SMALL)),
        above("at 10 mm/s, a twentieth − half of the rupture distance", 0.1,
              lambda c: viscous_share(1e-2, SMALL) - viscous_share(1e-2, 0.5)),
    )),
    Statement(46, "4, Fig. 7a, b", "The transfer ratio rises with the ratio of sizes and with V*, steeper at a larger angle.",
              (), (
        above("least step from ratio to ratio (1, 1.5, 2, 3), 10° and 40°", 0.0,
              lambda c: min(least_step([of_pair(r, a) for r in (1.0, 1.5, 2.0, 3.0)]) for a in (10.0, 40.0))),
        above("least rise from V* to V*, ratio 2, 10° and 40°", 0.0,
              lambda c: min(float(np.diff(of_pair(2.0, a)).min()) for a in (10.0, 40.0))),
        above("rise over V* at 40° − at 10°, ratio 2", 0.0,
              lambda c: float(np.ptp(of_pair(2.0, 40.0)) - np.ptp(of_pair(2.0, 10.0)))),
    )),
    Statement(47, "4, Fig. 7a, b", "Up to V* = 0.4 the transfer ratio at 10° is lower than at 40°.", (), (
        above("least T(40°) − T(10°), ratio 2", 0.0, lambda c: float((of_pair(2.0, 40.0) - of_pair(2.0, 10.0)).min())),
    )),
    Statement(48, "4, Fig. 7c, d", "At a wall the sphere's ratio rises with the wall's angle and falls with its own; it "
              "rises with V* where its angle is the smaller, and falls where it is the larger.", (), (
        above("least step from wall to wall, sphere of 10° and 40°", 0.0,
              lambda c: min(least_step([of_wall(a, w) for w in WALL_ANGLES]) for a in (10.0, 40.0))),
        above("least T(10°) − T(40°) over walls", 0.0,
              lambda c: min(float((of_wall(10.0, w) - of_wall(40.0, w)).min()) for w in WALL_ANGLES)),
        above("least rise from V* to V* where θ_i < θ_w", 0.0,
              lambda c: min(float(np.diff(of_wall(i, w)).min()) for i in (10.0, 40.0) for w in WALL_ANGLES if i < w)),
        below("largest rise where θ_i > θ_w", 0.0,
              lambda c: max(float(np.diff(of_wall(i, w)).max()) for i in (10.0, 40.0) for w in WALL_ANGLES if i > w)),
    )),
)
# fmt: on
