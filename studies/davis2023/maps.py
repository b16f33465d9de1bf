"""Many collisions of three equal spheres: coefficients of restitution along a curve or over a plane, outcomes over a plane."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from pywet.collisions.spheres.equal import three_equal_spheres
from pywet.collisions.spheres.outcome import mechanism, outcome, wet_restitution
from pywet.collisions.spheres.simulate import Run, run

WINDOW = 6.0
"""Time window t* = v_10 t/4a for which outcomes are stated."""


def window(theta12_deg: float, h_a: float = 0.01, t_star: float = WINDOW) -> float:
    """Return t̂ at t*: t̂ = t* cos β/ĥ_a."""
    return t_star * math.cos(math.radians(theta12_deg)) / h_a


def many(jobs: Iterable[dict[str, Any]], then: Callable[[Run], Any]) -> list[Any]:
    """Run all jobs (arguments of `three_equal_spheres`) in threads, the compiled part without the interpreter's lock."""

    def one(given: dict[str, Any]) -> Any:
        return then(run(three_equal_spheres(**given)))

    jobs = list(jobs)
    first = [one(jobs[0])] if jobs else []  # compiles in one thread if necessary
    with ThreadPoolExecutor() as pool:
        return first + list(pool.map(one, jobs[1:]))


def restitutions(made: Run) -> tuple[float, float]:
    """Return e12 and e23, 0 if the films did not separate."""
    return wet_restitution(made, (0, 1)) or 0.0, wet_restitution(made, (1, 2)) or 0.0


def curve(stokes: np.ndarray, **given: Any) -> np.ndarray:
    """Return e12 and e23 over St_n, shape (n, 2); e23 is 0 without a third sphere."""
    return np.array(many(({"St_n": float(s), **given} for s in stokes), restitutions))


@dataclass(frozen=True)
class Plane:
    """Values over impact angle (columns) and St_n (rows)."""

    angle_deg: np.ndarray
    stokes: np.ndarray
    e12: np.ndarray
    e23: np.ndarray
    outcome: np.ndarray
    """Outcome: 0 FA; 1, 2, 3 PA with 1-2, 2-3, 1-3 remaining joined; 4 FS."""
    slow: np.ndarray
    """Whether films 1-2 separate by stick-rotate-separate."""


def code(made: Run) -> int:
    """Return the number of an outcome, see `Plane.outcome`."""
    kind = outcome(made)
    if kind != "PA":
        return {"FA": 0, "FS": 4}[kind]
    return {(0, 1): 1, (1, 2): 2, (0, 2): 3}[made.overlapping[0]]


def plane(angle_deg: np.ndarray, stokes: np.ndarray) -> Plane:
    """Compute collisions over a grid of angles and Stokes numbers, conditions of the paper's Fig. 5."""

    def then(made: Run) -> tuple[float, float, int, bool]:
        return *restitutions(made), code(made), mechanism(made, (0, 1)) == "stick-rotate-separate"

    jobs = [{"St_n": float(s), "theta12_deg": float(a), "t_end": window(float(a))} for s in stokes for a in angle_deg]
    rows = many(jobs, then)
    shape = (len(stokes), len(angle_deg))
    e12, e23, kinds, slow = (np.array([row[k] for row in rows]).reshape(shape) for k in range(4))
    return Plane(angle_deg, stokes, e12, e23, kinds, slow)
