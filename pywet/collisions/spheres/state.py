"""Working data of the integration, compiled: constants, state, counters, recorded events. Units: those of `System`.

The state holds, for each sphere, x, y, vx, vy, ω; then four accumulated works (viscous, capillary, gravity, friction
of resting contacts); then, for each pair whose films overlap, four polar variables: q = ln h, θ, u = −dh/dt and w =
(v_i − v_j)·t = −r dθ/dt.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from pywet.collisions.runge_kutta import Tableau

WORKS = 4
"""Number of accumulated works after the spheres: viscous, capillary, gravity, friction of resting contacts."""
compiled = njit(error_model="numpy")
"""Compile without caching, since the compiled functions are part of `marching.march`."""
H, COS, SIN, U, W, R = range(6)
"""Columns of the geometry of a pair: gap, direction from i to j, u, w, distance of the centres."""
COUNTS = (
    "pairs", "size", "steps", "implicit_steps", "evaluations", "impacts", "logged", "traced", "stiff", "instant", "mode",
)  # fmt: skip
"""Whole numbers of a march: overlapping pairs, size of the state; `stiff` and `instant` count steps that stability limits
and that take no time."""
AMOUNTS = ("time", "step", "stiffness", "impact_loss", "tolerance", "energy", "start", "end")
"""Other variables; `stiffness` is dt·|λ| of the last step, `energy` a scale, `start` and `end` are kinetic energies."""


class System(NamedTuple):
    """Constants of a problem; arrays over spheres (n) or over pairs (first < second)."""

    radius: np.ndarray
    mass: np.ndarray
    first: np.ndarray
    second: np.ndarray
    film: np.ndarray
    """Gap at which the films touch, δ_i + δ_j."""
    normal: np.ndarray
    """Normal lubrication coefficient 6π μ a², a the reduced radius a_i a_j/(a_i + a_j)."""
    tangential: np.ndarray
    """Tangential lubrication coefficient 2π μ a."""
    capillary: np.ndarray
    """Capillary coefficient 8π a σ."""
    h_min: float
    """Gap of solid contact."""
    e_dry: float
    mu_f: float
    slip_scale: float
    """Slip speed over which the friction of a resting contact builds up."""
    gx: float
    gy: float
    polar: bool
    """Whether pairs have polar variables; otherwise their geometry is computed from the spheres' (for comparison)."""


class Work(NamedTuple):
    """Work arrays of an integration, made by `workspace`."""

    y: np.ndarray
    f: np.ndarray
    y_new: np.ndarray
    f_new: np.ndarray
    y_trial: np.ndarray
    scale: np.ndarray
    stages: np.ndarray
    act: np.ndarray
    """Indices of the overlapping pairs, in the order of their slots in the state."""
    slot: np.ndarray
    """Slot of a pair, −1 without overlap."""
    rest: np.ndarray
    """Whether the contact of a pair rests."""
    lam: np.ndarray
    """Normal force of a resting contact, by pair."""
    lam_new: np.ndarray
    geometry: np.ndarray
    """Geometry of the overlapping pairs, by slot."""
    seen: np.ndarray
    """Last computed geometry of each pair."""
    impacts: np.ndarray
    """Number of impacts of a pair since its films touched."""
    rest_speed: np.ndarray
    """Rebound speed below which a compressed contact rests, by pair."""
    log: np.ndarray
    """Logged events: time, kind, pair, u before."""
    trace: np.ndarray
    """Recorded states, one row per instant."""
    tableau: Tableau
    count: Any
    """Integer variables named in `COUNTS`."""
    now: Any
    """Real variables named in `AMOUNTS`."""


def _record(names: Sequence[str], kind: type) -> Any:
    """Make a record of named numbers, initially zero."""
    return np.zeros(1, [(name, kind) for name in names]).view(np.recarray)[0]


def workspace(s: System, first: np.ndarray, tableau: Tableau, log_rows: int, trace_rows: int) -> Work:
    """Make the arrays for an integration that starts from the spheres' variables `first`, shape (n, 5)."""
    pairs, spheres = len(s.first), first.size
    size = spheres + WORKS + (4 * pairs if s.polar else 0)
    y = np.zeros(size)
    y[:spheres] = first.ravel()
    w = Work(
        y=y,
        **{name: np.zeros(size) for name in ("f", "y_new", "f_new", "y_trial", "scale")},
        stages=np.zeros((13, size)),
        act=np.zeros(pairs, dtype=np.int64),
        slot=np.full(pairs, -1, dtype=np.int64),
        rest=np.zeros(pairs, dtype=np.bool_),
        **{name: np.zeros(pairs) for name in ("lam", "lam_new", "rest_speed")},
        **{name: np.zeros((pairs, 6)) for name in ("geometry", "seen")},
        impacts=np.zeros(pairs, dtype=np.int64),
        log=np.zeros((log_rows, 4)),
        trace=np.zeros((trace_rows, 1 + spheres + 4 * pairs)),
        tableau=tableau,
        count=_record(COUNTS, np.int64),
        now=_record(AMOUNTS, np.float64),
    )
    w.count.size = spheres + WORKS
    return w
