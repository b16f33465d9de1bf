"""What accuracy costs: error of the coefficients of restitution against time, for every integrator and tolerance.

Times are the best of a few repetitions on one core; the reference is the compiled integrator at its tightest tolerance.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pandas as pd

from pywet.collisions.wall import verlet, wall
from pywet.collisions.wall.curves import problem
from pywet.collisions.wall.data import FRICTION, GLASS_WALL
from pywet.collisions.wall.model import U, V, W
from pywet.collisions.wall.problem import Problem

METHODS = {"compiled": 13, "DOP853": 13, "RK45": 12, "RK23": 8, "LSODA": 13, "Radau": 9, "BDF": 10}
"""Method -> smallest tolerance tried, as a power of ten (beyond it takes seconds for one collision)."""
LOOSEST = 3
CONTACT_STEPS = (10, 20, 50, 100, 200, 500, 1000)
"""Fixed steps per duration of the dry contact."""
BUDGET = 1e-6
"""The error asked for: that of the dry coefficient of restitution; measurements scatter by 0.01 and more."""


def examples() -> list[Problem]:
    """Rolling and sliding in one contact, wet and dry; a rebound just above sticking, where e_n is most sensitive; and of 3000
    random dry collisions the one that strays furthest at 1e-8.
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
    return [
        problem(
            "alumina_1.74mm", ("tween20", 100), friction=FRICTION["tween20"], angle_deg=35.0, omega_rad_per_s=-960.0
        ),
        problem("alumina_1.74mm", None, angle_deg=20.0),
        problem("glass_1.74mm", ("water", 400), normal_velocity_m_per_s=0.65),
        Problem.model_validate(worst),
    ]


def coefficients(case: Problem, state: np.ndarray) -> np.ndarray:
    """(e_n, e_t, e_ω) of a state at the end; 0 where there was nothing before."""
    first = wall.start(case, case.parameters())
    before = np.array([-first[U], first[V], first[W]])
    return np.divide(state[[U, V, W]], before, out=np.zeros(3), where=before != 0.0)


def cost(
    cases: Sequence[Problem] | None = None,
    methods: dict[str, int] | None = None,
    repeats: int = 3,
    report: Callable[[str], None] | None = None,
) -> pd.DataFrame:
    """One row per method and tolerance (Verlet: steps per contact): largest error over the cases, seconds, calls."""
    cases = cases or examples()
    starts = [(case.parameters(), wall.start(case, case.parameters())) for case in cases]
    exact = [
        coefficients(c, wall.integrate(p, s, 1e-13, "compiled").state) for c, (p, s) in zip(cases, starts, strict=True)
    ]
    rows = []
    for method, last in (methods or METHODS).items():
        for power in range(LOOSEST, last + 1):
            if report is not None:
                report(f"{method} at 1e-{power}")
            rows.append(_adaptive(method, 10.0**-power, cases, starts, exact, repeats))
    contact = [_contact_time(case) for case in cases]
    for n in CONTACT_STEPS:
        if report is not None:
            report(f"Verlet, {n} steps per contact")
        rows.append(_fixed(n, cases, starts, exact, contact, repeats))
    return pd.DataFrame([row for row in rows if row is not None])


Start = tuple[Any, np.ndarray]


def _adaptive(
    method: str,
    rtol: float,
    cases: Sequence[Problem],
    starts: Sequence[Start],
    exact: Sequence[np.ndarray],
    repeats: int,
) -> dict[str, object] | None:
    for p, s in starts:
        wall.integrate(p, s, rtol, method)  # machine code is made before the clock starts
    seconds, raws = _timed(lambda: [wall.integrate(p, s, rtol, method) for p, s in starts], repeats)
    if any(raw.code != 0 for raw in raws):
        return None
    errors = [coefficients(c, raw.state) - e for c, raw, e in zip(cases, raws, exact, strict=True)]
    return _row(method, rtol, errors, seconds, sum(raw.calls for raw in raws))


def _fixed(
    n: int,
    cases: Sequence[Problem],
    starts: Sequence[Start],
    exact: Sequence[np.ndarray],
    contact: list[float],
    repeats: int,
) -> dict[str, object]:
    verlet.collide(*starts[0], contact[0] / CONTACT_STEPS[0])
    jobs = list(zip(starts, contact, strict=True))
    seconds, found = _timed(lambda: [verlet.collide(p, s, t / n) for (p, s), t in jobs], repeats)
    errors = [coefficients(c, state) - e for c, (state, _), e in zip(cases, found, exact, strict=True)]
    return _row("Verlet", 1.0 / n, errors, seconds, sum(steps for _, steps in found))


def _timed(work: Callable[[], Any], repeats: int) -> tuple[float, Any]:
    best, result = np.inf, None
    for _ in range(repeats):
        started = time.perf_counter()
        result = work()
        best = min(best, time.perf_counter() - started)
    return best, result


def _contact_time(case: Problem) -> float:
    """Duration of the dry contact [s]."""
    return float(wall.collide(case.model_copy(update={"liquid": None}))["events"][-1]["t"])


def _row(method: str, setting: float, errors: Sequence[np.ndarray], seconds: float, calls: int) -> dict[str, object]:
    normal, along, spin = (float(x) for x in np.abs(np.array(errors)).max(axis=0))
    return {
        "method": method,
        "setting": setting,
        "error": max(normal, along, spin),
        "error_e_n": normal,
        "error_e_t": along,
        "error_e_omega": spin,
        "seconds": seconds,
        "calls": calls,
    }


def knee(table: pd.DataFrame, method: str, error: float = BUDGET) -> pd.Series:
    """The loosest setting of a method from which on the error stays below `error`; the tightest where there is none."""
    rows = table[table["method"] == method].sort_values("setting")
    good = rows[rows["error"].cummax() <= error]
    return good.iloc[-1] if len(good) else rows.iloc[0]
