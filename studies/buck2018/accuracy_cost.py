"""Cost of accuracy: error of the coefficients of restitution against time, for every integrator and tolerance.

Times are the best of a few repetitions on one core; the reference is the compiled integrator at its tightest
tolerance.
"""

from __future__ import annotations

import timeit
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd

from pywet.collisions.wall import compiled, wall
from pywet.collisions.wall.adaptive import Course
from pywet.collisions.wall.forces import Parameters, U, V, W
from pywet.collisions.wall.problem import Problem
from studies.buck2018 import verlet
from studies.buck2018.buck_tables import FRICTION, GLASS_WALL
from studies.buck2018.curves import problem

METHODS = {"compiled": 13, "DOP853": 13, "RK45": 12, "RK23": 8, "LSODA": 13, "Radau": 9, "BDF": 10}
"""Method -> smallest tolerance tested, as a power of ten (below it a collision takes seconds)."""
LOOSEST = 3
CONTACT_STEPS = (10, 20, 50, 100, 200, 500, 1000)
"""Numbers of fixed steps per duration of the dry contact."""
BUDGET = 1e-6
"""Required error: that of the dry coefficient of restitution; measurements scatter by 0.01 and more."""


class Start(NamedTuple):
    """Initial state of a collision; `contact_s` is the duration of its dry contact."""

    parameters: Parameters
    state: np.ndarray
    contact_s: float


def examples() -> list[Problem]:
    """Return collisions with rolling and sliding in one contact, wet and dry, and two sensitive ones.

    These are a rebound just above sticking, where e_n is most sensitive, and, of 3000 random dry collisions, the
    one with the largest error at 1e-8.
    """
    body = {"radius_m": 0.001012406603848623, "youngs_modulus_Pa": 53809944024.58572, "poisson_ratio": 0.2}
    worst = {
        "particle": {**body, "density_kg_per_m3": 2500.0, "restitution": 0.404689861066863},
        "wall": GLASS_WALL,
        "liquid": None,
        "friction": 0.2,
        "normal_velocity_m_per_s": 0.011726301615469071,
        "angle_deg": 12.270220420344527,
        "omega_rad_per_s": 87.10953770180234,
        "gravity_m_per_s2": 0.0,
    }
    rolling = {"friction": FRICTION["tween20"], "angle_deg": 35.0, "omega_rad_per_s": -960.0}
    return [
        problem("alumina_1.74mm", ("tween20", 100), **rolling),
        problem("alumina_1.74mm", None, angle_deg=20.0),
        problem("glass_1.74mm", ("water", 400), normal_velocity_m_per_s=0.65),
        Problem.model_validate(worst),
    ]


def coefficients(case: Problem, state: np.ndarray) -> np.ndarray:
    """Return (e_n, e_t, e_ω) of a final state; 0 where the initial value is zero."""
    first = wall.start(case, case.parameters())
    before = np.array([-first[U], first[V], first[W]])
    return np.divide(state[[U, V, W]], before, out=np.zeros(3), where=before != 0.0)


def prepared(case: Problem) -> Start:
    """Compute the start of a collision, outside the measured time."""
    p, dry = case.parameters(), wall.collide(case.model_copy(update={"liquid": None}))
    return Start(p, wall.start(case, p), dry["events"][-1]["t"])


def settings(methods: dict[str, int]) -> Iterator[tuple[str, float, Callable[[Start], Course]]]:
    """Yield every integrator at every tolerance, then velocity Verlet with fixed steps: name, setting, function."""
    for method, last in methods.items():
        for rtol in (10.0**-power for power in range(LOOSEST, last + 1)):
            yield method, rtol, lambda s, m=method, r=rtol: wall.integrate(s.parameters, s.state, r, m)  # type: ignore[misc]
    for steps in CONTACT_STEPS:
        yield "Verlet", 1.0 / steps, lambda s, n=steps: verlet.collide(s.parameters, s.state, s.contact_s / n)  # type: ignore[misc]


def cost(methods: dict[str, int] | None = None, repeats: int = 3) -> pd.DataFrame:
    """Return one row per method and tolerance (Verlet: steps per contact): largest error over the examples, seconds, calls."""
    cases = examples()
    starts = [prepared(case) for case in cases]
    exact = [wall.integrate(s.parameters, s.state, 1e-13, "compiled").state for s in starts]
    rows = []
    for method, setting, collide in settings(methods or METHODS):
        raws = [collide(s) for s in starts]  # compile before the measurement
        if any(raw.code != compiled.OK for raw in raws):
            continue
        seconds = min(timeit.repeat(lambda c=collide: [c(s) for s in starts], number=1, repeat=repeats))  # type: ignore[misc]
        strays = [coefficients(c, r.state) - coefficients(c, e) for c, r, e in zip(cases, raws, exact, strict=True)]
        errors = np.abs(strays).max(axis=0)
        rows.append((method, setting, errors.max(), *errors, seconds, sum(raw.calls for raw in raws)))
    columns = ["method", "setting", "error", "error_e_n", "error_e_t", "error_e_omega", "seconds", "calls"]
    return pd.DataFrame(rows, columns=columns)


def knee(table: pd.DataFrame, method: str) -> pd.Series:
    """Return the loosest setting of a method from which the error stays below BUDGET; the tightest if there is none."""
    rows = table[table["method"] == method].sort_values("setting")
    good = rows[rows["error"].cummax() <= BUDGET]
    return good.iloc[-1] if len(good) else rows.iloc[0]
