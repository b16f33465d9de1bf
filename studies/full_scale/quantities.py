"""Quantities in statements of the paper, from the stored tables of one or several cases.

Y: fraction retained (44), Y_i of a size class (45); U: mass of undersize spheres on the screen over that at the
start; times in seconds from the opening of the slide; shares are of all liquid.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from studies.full_scale.judging import Cases
from studies.full_scale.stored_runs import COARSE, UNDERSIZE, StoredRun

SMALL, NEAR = UNDERSIZE
COARSE_MATERIAL = "coarse_material"


def gap(c: Cases, a: int, b: int, start: float, stop: float) -> float:
    """Return the mean of Y_a − Y_b over a time interval."""
    return c[a].y(start, stop) - c[b].y(start, stop)


def spread(c: Cases, cases: Sequence[int], start: float = 0.5, stop: float = 20.0) -> float:
    """Return the mean over a time interval of the largest minus the smallest Y among cases."""
    grid = np.arange(start, stop, 0.1)
    curves = np.array([np.interp(grid, c[k].times, c[k].retained()) for k in cases])
    return float((curves.max(axis=0) - curves.min(axis=0)).mean())


def lag(stored: StoredRun, start: float, stop: float) -> float:
    """Return the mean of Y_small − Y_near of one case over a time interval."""
    return stored.y(start, stop, SMALL) - stored.y(start, stop, NEAR)


def undersize(c: Cases, case: int, time: float) -> float:
    """Return the undersize left on the screen at a time."""
    return c[case].at(c[case].undersize, time)


def share(c: Cases, case: int, time: float, *reservoirs: str) -> float:
    """Return the share of the liquid in reservoirs (`walls`: the screening apparatus) at a time."""
    stored = c[case]
    return stored.at(stored.walls if reservoirs == ("walls",) else stored.liquid(*reservoirs), time)


def through(c: Cases, case: int, left: float) -> float:
    """Return the time from which less than a share `left` of the undersize is on the screen [s]; inf if never."""
    more = np.flatnonzero(c[case].undersize >= left)
    times = c[case].times
    return float(times[more[-1] + 1]) if more[-1] + 1 < len(times) else math.inf


def last_lag(stored: StoredRun) -> float:
    """Return the last time at which Y_small is above Y_near [s]; 0 if never."""
    late = np.flatnonzero((stored.retained(SMALL) > stored.retained(NEAR)) & (stored.times >= 0.5))
    return float(stored.times[late[-1]]) if len(late) else 0.0


MAJORITY = 0.1
"""Share of the undersize on the screen below which its majority has passed."""


def settled(c: Cases, case: int) -> float:
    """Return the largest change of the share of coarse material, fines or walls after the majority has passed, relative.

    It is relative to the change before; inf if the majority never passes.
    """
    since = through(c, case, MAJORITY)
    if not since < c[case].end:
        return math.inf
    changes = [
        [abs(share(c, case, b, h) - share(c, case, a, h)) for h in (COARSE_MATERIAL, "fines", "walls")]
        for a, b in ((0.0, since), (since, 20.0))
    ]
    return max(changes[1]) / max(changes[0])


def largest(c: Cases, a: int, kind_a: str | None, b: int, kind_b: str | None) -> float:
    """Return the largest excess of Y_a (of a class) over Y_b between 0.5 and 20 s."""
    grid = np.arange(0.5, 20.0, 0.1)
    one, other = c[a], c[b]
    return float(
        np.max(np.interp(grid, one.times, one.retained(kind_a)) - np.interp(grid, other.times, other.retained(kind_b)))
    )


def rise(stored: StoredRun, reservoir: str, sign: float = 1.0) -> float:
    """Return the largest rise (with −1 fall) of a reservoir's share from one output to the next after the opening."""
    values = stored.liquid(reservoir)[stored.times >= 0.0]
    return float(np.max(np.diff(sign * values), initial=0.0))


def per_sphere(stored: StoredRun, kind: str) -> float:
    """Return the liquid share that spheres of a class carried through the outlet, over the number that passed."""
    spheres = stored.count("above", kind)
    return carried(stored, kind) / max(float(spheres[0] - spheres[-1]), 1.0)


def fall(stored: StoredRun, kind: str) -> float:
    """Return the share of a class that passes from 5 to 20 s."""
    return stored.at(stored.retained(kind), 5.0) - stored.at(stored.retained(kind), 20.0)


def apart(c: Cases, time: float) -> float:
    """Return the distance of the shares of walls and coarse material in case 2."""
    return abs(share(c, 2, time, "walls") - share(c, 2, time, COARSE_MATERIAL))


def carried(stored: StoredRun, kind: str) -> float:
    """Return the liquid share of spheres of a class at the last output before they passed; nan if not recorded."""
    return float((stored.about.get("carried") or {}).get(kind, math.nan))


PITCH_MM = {1: 10.0, 7: 7.2}
"""Case -> aperture and wire diameter of its screen together [mm] (table 2)."""
ONE_SPHERE = 1.0
"""Least number of pegged spheres that a ratio divides by, and by which fewer of them are fewer."""


def pegged(c: Cases, case: int) -> float:
    """Return the largest possible number of large spheres that peg apertures, mean from 10 to 20 s."""
    return c[case].pegged(COARSE, 10.0, 20.0)


def pegged_ratio(c: Cases, a: int, b: int) -> float:
    """Return pegged large spheres per aperture of one case over those of another on a sieve of the same area."""
    return pegged(c, a) / max(pegged(c, b), ONE_SPHERE) * (PITCH_MM[a] / PITCH_MM[b]) ** 2


EARLY = 5.0
"""End of the beginning of screening, in which most of the undersize passes [s]."""


def peak(c: Cases, kind: str) -> float:
    """Return the largest relative rise of the liquid on a class on the screen since the opening within `EARLY`, case 11."""
    values, times = c[11].liquid(f"coarse_material_{kind}"), c[11].times
    start = share(c, 11, 0.0, f"coarse_material_{kind}")
    return float(values[(times >= 0.0) & (times <= EARLY)].max() / start - 1.0)


def small_at_peak(c: Cases) -> float:
    """Return the relative change of liquid on the small spheres on the screen at the maximum of the near-mesh ones, case 11."""
    near, times = c[11].liquid(f"coarse_material_{NEAR}"), c[11].times
    early = (times >= 0.0) & (times <= EARLY)
    at = float(times[early][int(np.argmax(near[early]))])
    return share(c, 11, at, f"coarse_material_{SMALL}") / share(c, 11, 0.0, f"coarse_material_{SMALL}") - 1.0


def film(c: Cases, kind: str) -> float:
    """Return the median film thickness of a class on the screen in case 3 at 3 s, over that of the coarse spheres."""
    return c[3].at(c[3].count("film_m", kind), 3.0) / c[3].at(c[3].count("film_m", COARSE), 3.0)
