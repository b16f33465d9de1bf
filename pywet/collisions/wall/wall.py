"""One wet collision of a sphere with a wall (or a free sphere): coefficients of restitution, energy budget, events.

The budget is a check: kinetic energy follows from velocities, the work terms from separate quadratures along the
path. If it does not close to CLOSURE of the initial energy, the tolerance is tightened until it does. At very low
velocities gravity and capillarity exchange so much more than the initial energy that double precision is
insufficient; then closure to CLOSURE of the largest energy exchanged is required, and a collision that does not reach
it is refused.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pywet.collisions.wall import adaptive, compiled, forces
from pywet.collisions.wall.adaptive import Course
from pywet.collisions.wall.forces import BRIDGE, CONTACT, ENTRY, LEAVING, SIZE, WORK, H, Parameters, U, V, W
from pywet.collisions.wall.problem import Problem
from pywet.errors import PywetError

CLOSURE = 1e-8
"""Largest residual of the energy budget over the initial energy."""
TIGHTEST = 1e-14
KINDS = {ENTRY: "contact", CONTACT: "lift_off", LEAVING: "film_exit", BRIDGE: "rupture"}
"""Phase -> event that ends it, unless the sphere remains stuck."""


def start(problem: Problem, p: Parameters) -> np.ndarray:
    """Return the state at entry (dry: at touch)."""
    state = np.zeros(SIZE)
    state[H], state[U] = p.layer, -p.speed
    state[V] = problem.tangential_velocity
    state[W] = problem.omega_rad_per_s * p.radius
    return state


def integrate(p: Parameters, state: np.ndarray, rtol: float, integrator: str) -> Course:
    """Run the named integrator from a state."""
    if integrator != "compiled":
        return adaptive.collide(p, state, rtol, integrator)
    end, log = state.copy(), np.zeros((8, 3))
    code, rows, steps, calls = compiled.collide(p, end, float(rtol), log)
    return Course(end, code, [(float(t), int(phase), int(which)) for t, phase, which in log[:rows]], steps, calls)


def energy(state: np.ndarray) -> float:
    """Return the kinetic energy per unit of mass [J/kg]: ½ u² + ½ v² + ½ (2/5) w²."""
    return float(0.5 * (state[U] ** 2 + state[V] ** 2 + 0.4 * state[W] ** 2))


def budget(before: np.ndarray, after: np.ndarray) -> tuple[float, float]:
    """Return the residual of the energy budget over the initial energy, and over the largest energy converted."""
    first, last, works = energy(before), energy(after), after[WORK:]
    residual = abs(first - last - float(np.sum(works)))
    return residual / first, residual / max(first, last, float(np.max(np.abs(works))))


def collide(problem: Problem) -> dict[str, Any]:
    """Run a collision and return the keys listed in docs/wall_collision.md. Raises `PywetError` if it cannot be computed."""
    p = problem.parameters()
    state, rtol = start(problem, p), problem.rtol
    best: tuple[Course, float] | None = None
    while True:
        raw = integrate(p, state, rtol, problem.integrator)
        finite = raw.code == compiled.OK and bool(np.all(np.isfinite(raw.state)))
        of_initial, of_turnover = budget(state, raw.state) if finite else (math.inf, math.inf)
        if of_turnover <= CLOSURE:
            best = raw, rtol
        if of_initial <= CLOSURE or rtol <= TIGHTEST or raw.code != compiled.OK:
            break
        rtol = max(0.03 * rtol, TIGHTEST)
    if best is None:
        raise PywetError(_refusal(problem, raw.code, of_turnover), code="wall.not_finished")
    return outcome(problem, p, state, *best)


def _refusal(problem: Problem, code: int, left: float) -> str:
    why = {
        compiled.OK: f"its energy budget is open by {left:.1e}",
        compiled.TOO_MANY: "it takes too many steps: a force is very stiff",
        compiled.TOO_SMALL: "its time step falls below round-off",
    }[code]
    return (
        f"the collision at {problem.normal_velocity_m_per_s:g} m/s and {problem.angle_deg:g}° cannot be integrated by "
        f"{problem.integrator} ({why}); expected a closed budget: fix the input or name another integrator"
    )


def outcome(problem: Problem, p: Parameters, first: np.ndarray, raw: Course, rtol: float) -> dict[str, Any]:
    """Return the answer as plain data."""
    end, in_bridge = raw.state, raw.log[-1][1] == BRIDGE
    stuck = raw.log[-1][2] != 1
    volume = float(forces.bridge_volume(end[H], p)) if in_bridge else None
    length = float(end[H]) - (0.0 if p.other.rupture_from else p.layer)  # measured from the film or from the wall
    spin = problem.omega_rad_per_s + (end[W] - first[W]) * p.mass / problem.mass / p.radius
    return {
        "e_n": 0.0 if stuck else max(0.0, float(end[U])) / p.speed,
        "e_t": _ratio(end[V], first[V]),
        "e_omega": _ratio(spin, problem.omega_rad_per_s),
        "stuck": stuck,
        "v_n_out": 0.0 if stuck and abs(end[U]) < 1e-12 * p.speed else float(end[U]),
        "v_t_out": float(end[V]),
        "omega_out": float(spin),
        "energy_J": _energies(p.mass, first, end),
        "rupture_length_m": None if stuck or volume is None else length,
        "bridge_volume_m3": volume,
        "duration_s": raw.log[-1][0],
        "events": _events(p, raw.log),
        "rtol_used": rtol,
        "steps": raw.steps,
    }


def _energies(mass: float, first: np.ndarray, end: np.ndarray) -> dict[str, float]:
    works = dict(zip(("contact", "viscous", "capillary", "gravity"), end[WORK:], strict=True))
    terms = {"in": energy(first), "out": energy(end), **works}
    residual = terms["in"] - terms["out"] - sum(works.values())
    return {name: mass * float(value) for name, value in {**terms, "residual": residual}.items()}


def _ratio(after: float, before: float) -> float | None:
    """Return a coefficient of restitution; None if the initial velocity is zero or negligible."""
    with np.errstate(all="ignore"):
        ratio = np.divide(after, before)
    return float(ratio) if np.isfinite(ratio) else None


def _events(p: Parameters, log: list[tuple[float, int, int]]) -> list[dict[str, Any]]:
    entry = [{"t": 0.0, "kind": "entry" if p.wet else "contact"}]
    return entry + [{"t": t, "kind": KINDS[phase] if which == 1 else "stick"} for t, phase, which in log]
