"""Numbers that statements of the paper are about, from the kept tables of one or several cases.

Y: fraction retained (44), Y_i of a size class (45); U: mass of undersize spheres on the screen over that at the start; times in
seconds from the opening of the slide; shares are of all liquid.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pywet.evidence.full_scale.judging import Cases
from pywet.evidence.full_scale.kept import COARSE, UNDERSIZE, Kept
from pywet.laws.transfer import transfer_table
from pywet.schema import LARGE_WALL, SPHERE

SMALL, NEAR = UNDERSIZE
COARSE_MATERIAL = "coarse_material"


def gap(c: Cases, a: int, b: int, start: float, stop: float) -> float:
    """Mean of Y_a − Y_b over a span of time."""
    return c[a].y(start, stop) - c[b].y(start, stop)


def spread(c: Cases, cases: Sequence[int]) -> float:
    """Mean over 0.5 to 20 s of the largest Y less the smallest among cases."""
    grid = np.arange(0.5, 20.0, 0.1)
    curves = np.array([np.interp(grid, c[k].times, c[k].retained()) for k in cases])
    return float((curves.max(axis=0) - curves.min(axis=0)).mean())


def lag(kept: Kept, start: float, stop: float) -> float:
    """Mean of Y_small − Y_near of one case over a span of time."""
    return kept.y(start, stop, SMALL) - kept.y(start, stop, NEAR)


def undersize(c: Cases, case: int, time: float) -> float:
    """U at a time."""
    return c[case].at(c[case].undersize, time)


def share(c: Cases, case: int, time: float, *holders: str) -> float:
    """Share of the liquid with holders (`walls`: the screening apparatus) at a time."""
    kept = c[case]
    return kept.at(kept.walls if holders == ("walls",) else kept.liquid(*holders), time)


def drift(c: Cases, case: int) -> float:
    """Largest change of the share of coarse material, fines or walls from 15 to 20 s."""
    return max(abs(share(c, case, 20.0, h) - share(c, case, 15.0, h)) for h in (COARSE_MATERIAL, "fines", "walls"))


def largest(c: Cases, a: int, kind_a: str | None, b: int, kind_b: str | None) -> float:
    """Largest excess of Y_a (of a class) over Y_b between 0.5 and 20 s."""
    grid = np.arange(0.5, 20.0, 0.1)
    one, other = c[a], c[b]
    return float(
        np.max(np.interp(grid, one.times, one.retained(kind_a)) - np.interp(grid, other.times, other.retained(kind_b)))
    )


def rise(kept: Kept, holder: str, sign: float = 1.0) -> float:
    """Largest step up (down with −1) of a holder's share from one output to the next after the opening."""
    values = kept.liquid(holder)[kept.times >= 0.0]
    return float(np.max(np.diff(sign * values), initial=0.0))


def per_sphere(kept: Kept, kind: str) -> float:
    """Liquid share that has left with a class, over the number of its spheres that passed."""
    spheres = kept.count("above", kind)
    return out(kept, kind) / max(float(spheres[0] - spheres[-1]), 1.0)


def larger_gets(contact_angle_deg: float) -> float:
    """Mean share of the larger of spheres of 3.5 and 5 mm radius over V* from 0.05 to 0.4, by the law of preset `paper`."""
    angle, volumes = math.radians(contact_angle_deg), np.linspace(0.05, 0.4, 8)
    return float(np.mean(transfer_table(5e-3, 3.5e-3, angle, angle, SPHERE, volumes)))


def wall_gets(contact_angle_deg: float) -> float:
    """Mean share of a large steel wall (45°) in bridges to a sphere over V* from 0.05 to 0.4, by the law of preset `paper`."""
    volumes = np.linspace(0.05, 0.4, 8)
    sphere = transfer_table(5e-3, 0.0, math.radians(contact_angle_deg), math.radians(45.0), LARGE_WALL, volumes)
    return float(1.0 - np.mean(sphere))


def fall(c: Cases, case: int) -> float:
    """Undersize that passes from 5 to 20 s."""
    return undersize(c, case, 5.0) - undersize(c, case, 20.0)


def apart(c: Cases, time: float) -> float:
    """Distance of the shares of walls and coarse material in case 2."""
    return abs(share(c, 2, time, "walls") - share(c, 2, time, COARSE_MATERIAL))


def out(kept: Kept, kind: str) -> float:
    """Share of the liquid that has left with a class at the end."""
    return float(kept.liquid(f"fines_{kind}")[-1])


def wedged(c: Cases, case: int, kind: str) -> float:
    """Mean number of wedged spheres of a class from 10 to 20 s."""
    return c[case].mean(c[case].count("wedged", kind), 10.0, 20.0)


def first(c: Cases, kind: str) -> float:
    """Relative change of the liquid on a class on the screen in the first second, case 11."""
    return share(c, 11, 1.0, f"coarse_material_{kind}") / share(c, 11, 0.0, f"coarse_material_{kind}") - 1.0


def film(c: Cases, kind: str) -> float:
    """Median film thickness of a class on the screen in case 3 at 3 s, over that of the coarse spheres."""
    return c[3].at(c[3].count("film_m", kind), 3.0) / c[3].at(c[3].count("film_m", COARSE), 3.0)
