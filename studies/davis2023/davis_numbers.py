"""Every number printed in the text of Davis 2023, compared with a converged solution of the same equations."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

from pywet.collisions.spheres.equal import stokes_to_rebound, three_equal_spheres
from pywet.collisions.spheres.outcome import times, wet_restitution
from pywet.collisions.spheres.simulate import Run, run

PAIRS = {"12": (0, 1), "13": (0, 2), "23": (1, 2)}


@dataclass(frozen=True)
class Number:
    """A printed number: its position, meaning, value, and function to compute it at a relative tolerance."""

    where: str
    what: str
    printed: float
    compute: Callable[[float], float]
    note: str = ""


@cache
def case(rtol: float, **given: float) -> Run:
    """Run the three equal spheres."""
    return run(three_equal_spheres(**given, rtol=rtol))


def event(kind: str, pair: str, **given: float) -> Callable[[float], float]:
    """Return a function for the time t̂ of the first event of a kind."""
    return lambda rtol: times(case(rtol, **given), PAIRS[pair], kind)[0]


def star(kind: str, pair: str, **given: float) -> Callable[[float], float]:
    """Convert a time to t* = v_10 t/4a = t̂ ĥ_a/cos β."""
    return lambda rtol: event(kind, pair, **given)(rtol) * 0.01 / math.cos(math.radians(45.0))


def restitution(pair: str, **given: float) -> Callable[[float], float]:
    """Return a function for the wet coefficient of restitution."""
    return lambda rtol: wet_restitution(case(rtol, **given), PAIRS[pair]) or 0.0


def occurred(kind: str, pair: str) -> Callable[[Run], bool]:
    """Return a function that tests whether an event of a kind happened to a pair."""
    return lambda made: bool(times(made, PAIRS[pair], kind))


def onset(
    rtol: float, low: float, high: float, happened: Callable[[Run], bool], varied: str = "St_n", **given: Any
) -> float:
    """Return the value of a number, between low and high, above which something happens, by bisection to 1e-4."""
    while high - low > 1e-4 * high:
        middle = 0.5 * (low + high)
        above = happened(run(three_equal_spheres(**{varied: middle, "rtol": rtol, **given})))
        low, high = (low, middle) if above else (middle, high)
    return 0.5 * (low + high)


def first_contact(rtol: float, **given: Any) -> float:
    """Return the smallest St_n at which spheres 1 and 2 touch, conditions of Fig. 5."""
    return onset(rtol, 1.0, 6.0, occurred("contact", "12"), t_end=20.0, **given)


def collinear(rtol: float, **given: Any) -> float:
    """Return the smallest St_n at which sphere 3 leaves in a collinear collision."""
    return onset(rtol, 3.0, 8.0, occurred("separation", "23"), theta12_deg=0.0, t_end=3000.0, **given)


def jump(rtol: float, theta12_deg: float, low: float, high: float) -> float:
    """Return the St_n above which films 1-2 separate before spheres 2 and 3 touch."""

    def parted_first(made: Run) -> bool:
        parted, touched = times(made, (0, 1), "separation"), times(made, (1, 2), "contact")
        return bool(parted) and (not touched or parted[0] < touched[0])

    return onset(rtol, low, high, parted_first, theta12_deg=theta12_deg, t_end=30.0)


def arrest(rtol: float, stokes: float, low: float, high: float, t_end: float) -> float:
    """Return the Ca above which films 1-2 separate before t_end, conditions of Fig. 8."""
    return onset(rtol, low, high, occurred("separation", "12"), "Ca", St_n=stokes, t_end=t_end)


FIG5 = {"St_n": 2.0, "t_end": 600.0}
FIG15 = {"St_n": 2.0, "theta23_deg": -45.0, "h_min": 0.04, "t_end": 800.0}
FIG11 = {"theta12_deg": 30.0}
FRICTION = {"St_n": 8.0, "mu_f": 0.1}
EIGHT = {"St_n": 8.0}

NUMBERS = [
    Number("IV A, Fig. 7", "St 2: films 1-2 part, t̂", 183.0, event("separation", "12", **FIG5), "183: overlap 1-3"),
    Number("IV A, V, Fig. 14", "St 2: films 1-3 touch, t*", 2.59, star("overlap", "13", **FIG5)),
    Number("V, Fig. 14", "St 2: films 1-2 part, t*", 2.60, star("separation", "12", **FIG5)),
    Number("V, Fig. 14", "St 2: films 1-3 part, t*", 4.57, star("separation", "13", **FIG5)),
    Number("V, Fig. 15", "films 1-3 touch, t̂", 42.7, event("overlap", "13", **FIG15)),
    Number("V, Fig. 15", "films 1-3 touch, t*", 0.60, star("overlap", "13", **FIG15), "two digits printed"),
    Number("V, Fig. 15", "films 2-3 part, t̂", 49.5, event("separation", "23", **FIG15)),
    Number("V, Fig. 15", "films 2-3 part, t*", 0.70, star("separation", "23", **FIG15), "two digits printed"),
    Number("V, Fig. 15", "films 1-2 part, t̂", 430.0, event("separation", "12", **FIG15)),
    Number("V, Fig. 15", "films 1-2 part, t*", 6.08, star("separation", "12", **FIG15)),
    Number("IV C, Fig. 11", "St 7: contact 1-2, t̂", 1.00, event("contact", "12", St_n=7.0, **FIG11)),
    Number("IV C, Fig. 11", "St 7: contact 2-3, t̂", 2.60, event("contact", "23", St_n=7.0, **FIG11)),
    Number("IV C, Fig. 11", "St 12: e12", 0.168, restitution("12", St_n=12.0, **FIG11)),
    Number("IV C, Fig. 11", "St 12: e23", 0.393, restitution("23", St_n=12.0, **FIG11)),
    Number("IV C, Fig. 11", "St 20: contact 2-3, t̂", 2.20, event("contact", "23", St_n=20.0, **FIG11)),
    Number("IV C, Fig. 11", "St 20: films 1-2 part, t̂", 2.14, event("separation", "12", St_n=20.0, **FIG11)),
    Number("IV C, Fig. 11", "St 20: e12", 0.773, restitution("12", St_n=20.0, **FIG11)),
    Number("IV C, Fig. 11", "St 20: e23", 0.579, restitution("23", St_n=20.0, **FIG11)),
    Number("IV E, Fig. 13b", "contact 1-2, t̂", 0.999, event("contact", "12", **EIGHT)),
    Number("IV E, Fig. 13b", "contact 2-3, μ_f 0, t̂", 2.943, event("contact", "23", **EIGHT)),
    Number("IV E, Fig. 13b", "contact 2-3, μ_f 0.1, t̂", 2.740, event("contact", "23", **FRICTION)),
    Number("IV E, Fig. 13b", "films 1-2 part, μ_f 0, t̂", 2.795, event("separation", "12", **EIGHT)),
    Number("IV E, Fig. 13b", "films 1-2 part, μ_f 0.1, t̂", 2.936, event("separation", "12", **FRICTION)),
    Number("IV E, Fig. 13b", "e12, μ_f 0", 0.457, restitution("12", **EIGHT)),
    Number("IV E, Fig. 13b", "e12, μ_f 0.1", 0.211, restitution("12", **FRICTION)),
    Number("IV C, Fig. 10", "30°: St of the jump of e12", 14.1, lambda rtol: jump(rtol, 30.0, 8.0, 20.0)),
    Number("IV C, Fig. 10", "45°: St of the jump of e12", 7.0, lambda rtol: jump(rtol, 45.0, 5.5, 10.0)),
]
"""Numbers that a converged solution reproduces."""

NOT_REPRODUCED = [
    Number("IV A, Fig. 7", "no contact 1-2 below St", 2.4, first_contact, "see docs/sphere_collisions.md"),
    Number("IV C", "collinear: sphere 3 leaves above St", 4.8, collinear, "see docs/sphere_collisions.md"),
]
"""Statements that the model with the stated parameters does not confirm."""

APPROXIMATE = [
    Number("IV B, Fig. 8", "St 7: rebound 1-2 arrested up to Ca", 6.0, lambda rtol: arrest(rtol, 7.0, 3.0, 30.0, 60.0)),
    Number(
        "IV B, Fig. 8", "St 3.5: separation arrested up to Ca", 100.0, lambda rtol: arrest(rtol, 3.5, 50.0, 1e3, 400.0)
    ),
    Number(
        "IV A, Fig. 6", "two spheres head on: St_s at ĥ_m 0.05", 4.0, lambda rtol: stokes_to_rebound(0.05), "about 4"
    ),
]
"""Rounded or one-sided statements: the paper shows curves for a few values only."""
