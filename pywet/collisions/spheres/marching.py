"""Integrate from the initial to the final state, compiled: steps, events, flight without contact in closed form.

`events` locates events, `contacts` applies them.
"""

from __future__ import annotations

import math
from typing import Any

from pywet.collisions.spheres import contacts
from pywet.collisions.spheres.contacts import CONTACT, OVERLAP, RELEASE, SEPARATION
from pywet.collisions.spheres.dynamics import along, derivative, pair_geometry, place
from pywet.collisions.spheres.events import first_event, locate
from pywet.collisions.spheres.state import COS, SIN, H, R, U, W, compiled
from pywet.collisions.spheres.steppers import EXPLICIT, IMPLICIT, norm, set_scale, step
from pywet.util.machine_code import njit

DONE, TOO_MANY_STEPS, STALLED, TOO_SMALL = range(4)
PATIENCE = 1000
"""Number of steps limited by stability, in one segment, after which `AUTO` switches to the implicit method.

An implicit step costs ten times as much.
"""
SHORTEST = 1e-12
"""Step length below which a contact is treated as closing at once."""
AUTO = 2
"""Method: explicit until a segment is found to be stiff, then implicit until the end of the segment."""


@compiled
def apply(kind: int, p: int, s: Any, w: Any) -> None:
    """Apply the immediate changes of an event; impacts follow in `resolve`."""
    g = w.seen[p]
    pair_geometry(w.y, s, p, w.slot[p], g)
    if kind == OVERLAP:
        contacts.log_event(w, OVERLAP, p, g[U])
        contacts.activate(s, w, p, s.film[p])
    elif kind == SEPARATION:
        contacts.log_event(w, SEPARATION, p, g[U])
        contacts.deactivate(s, w, p)
    elif kind == CONTACT and s.polar:
        w.y[place(s, w.slot[p])] = math.log(s.h_min)
    elif kind == RELEASE:
        contacts.release(w, p)
        w.lam[p] = -1.0  # and does not close again immediately, see `resolve`


@compiled
def fly(limit: float, s: Any, w: Any) -> int:
    """Move all spheres freely, without overlapping films, to the next contact of films or the limit; return the pair or −1."""
    y, best, pair = w.y, limit - w.now.time, -1
    for p in range(s.first.size):
        i, j = s.first[p], s.second[p]
        dx, dz = y[5 * j] - y[5 * i], y[5 * j + 1] - y[5 * i + 1]
        vx, vz = y[5 * j + 2] - y[5 * i + 2], y[5 * j + 3] - y[5 * i + 3]
        reach = s.radius[i] + s.radius[j] + s.film[p]
        b, v2, gap = dx * vx + dz * vz, vx * vx + vz * vz, math.hypot(dx, dz) - reach
        c = gap * (math.hypot(dx, dz) + reach)
        d = b * b - v2 * c
        if b < 0.0 and d > 0.0:
            t = max(c, 0.0) / (-b + math.sqrt(d))
            if t < best:
                best, pair = t, p
    for i in range(s.radius.size):
        k = 5 * i
        for q, g in ((0, s.gx), (1, s.gy)):
            move = best * (y[k + 2 + q] + 0.5 * best * g)
            y[k + q] += move
            y[k + 2 + q] += best * g
            y[5 * s.radius.size + 2] += s.mass[i] * g * move
    w.now.time = w.now.time + best if pair >= 0 else limit
    return pair


@compiled
def start_step(limit: float, s: Any, w: Any) -> None:
    """Choose the first step of a segment (Hairer, Nørsett & Wanner I, II.4), never longer than requested."""
    n = w.count.size
    set_scale(s, w, w.y, w.y)
    bounce = top_of_bounce(s, w)  # before the probe below changes the geometry
    slope = norm(w.f, w.scale, n)
    rate = slope * w.now.tolerance  # relative change of the variables per unit of time
    first = min(1e-3, 0.01 / rate if rate > 0.0 else 1e-3)
    w.y_trial[:n] = w.y[:n] + first * w.f[:n]
    derivative(w.y_trial, w.f_new, s, w, w.lam_new)
    curve = norm(w.f_new[:n] - w.f[:n], w.scale, n) / first
    most = max(slope, curve)
    w.now.step = min((0.01 / most) ** (1.0 / w.tableau.order) if most > 0.0 else 1.0, first, limit, bounce)
    w.count.stiff = 0


@compiled
def top_of_bounce(s: Any, w: Any) -> float:
    """Return the time to the top of the shortest bounce that begins now: a longer step could miss a whole bounce."""
    shortest = math.inf
    for k in range(w.count.pairs):
        p, g = w.act[k], w.geometry[k]
        if not w.rest[p] and g[U] < 0.0 and g[H] <= s.h_min * (1.0 + 1e-9):
            faster = along(w.f, s, p, g[COS], g[SIN]) - g[W] * g[W] / g[R]
            if faster > 0.0:
                shortest = min(shortest, -g[U] / faster)
    return shortest


@compiled
def trace(s: Any, w: Any) -> None:
    """Record one row: time, Cartesian state, then h, u, w and the angle of every pair."""
    k, n = w.count.traced, 5 * s.radius.size
    if k >= w.trace.shape[0]:
        return
    w.trace[k, 0] = w.now.time
    w.trace[k, 1 : n + 1] = w.y[:n]
    for p in range(s.first.size):
        g, b = w.seen[p], n + 1 + 4 * p
        pair_geometry(w.y, s, p, w.slot[p], g)
        w.trace[k, b], w.trace[k, b + 1], w.trace[k, b + 2] = g[H], g[U], g[W]
        w.trace[k, b + 3] = math.atan2(g[SIN], g[COS])
    w.count.traced += 1


@compiled
def next_length(error: float, dt: float, w: Any) -> float:
    """Return the length of the next step from the error of this one."""
    order = 4.0 if w.count.mode == IMPLICIT else w.tableau.order
    if not math.isfinite(error):
        return 0.25 * dt
    return dt * min(6.0, max(0.2, 0.9 * (error + 1e-30) ** (-1.0 / order)))


@compiled
def advance(limit: float, s: Any, w: Any) -> tuple[int, int]:
    """Make one accepted step, cut at `limit` or at an event.

    Returns the event's kind and pair (−1 none, −2 step too small, −3 again).
    """
    left = limit - w.now.time
    while True:
        full = w.now.step
        dt = min(full, left)
        if dt < 1e-15 * max(w.now.time, 1e-6):
            if left <= dt:
                w.now.time = limit
                return -1, -1
            return -2, -1
        error = step(dt, s, w)
        if error <= 1.0:
            break
        w.now.step = min(0.9 * dt, next_length(error, dt, w))
    stiff = w.now.stiffness
    kind, p, low, high = first_event(dt, s, w)
    if low < 0.0 and dt > SHORTEST:  # a bounce within this step that the cubic interpolant misses
        w.now.step = 0.1 * dt
        return -3, -1
    low = max(low, 0.0)
    proposal, taken = next_length(error, dt, w), dt
    if kind >= 0:
        taken, real = locate(dt, kind, p, low, high, s, w)
        kind = kind if real else -1
        for _ in range(20):  # another pair may have bounced earlier
            other, q, low, high = first_event(taken, s, w)
            if other < 0 or (other == kind and q == p):
                break
            taken, real = locate(taken, other, q, max(low, 0.0), high, s, w)
            kind, p = (other, q) if real else (-1, -1)
    if w.count.mode == EXPLICIT:
        limited = stiff > (5.0 if w.tableau.order > 6.0 else 3.0)
        w.count.stiff = w.count.stiff + 1 if limited else max(w.count.stiff - 1, 0)
    w.now.step = max(proposal, full) if dt < 0.99 * full else proposal
    n = w.count.size
    w.y[:n], w.f[:n], w.lam[:] = w.y_new[:n], w.f_new[:n], w.lam_new
    w.now.time = limit if taken >= left else w.now.time + taken
    w.count.steps += 1
    w.count.implicit_steps += 1 if w.count.mode == IMPLICIT else 0
    return kind, p


@compiled
def begin(s: Any, w: Any, gaps: Any) -> None:
    """Register pairs whose films touch at the start: those with a gap ≥ 0 in `gaps`; pairs at h_min without speed rest."""
    for p in range(gaps.size):
        if gaps[p] >= 0.0:
            g = w.seen[p]
            pair_geometry(w.y, s, p, -1, g)
            contacts.log_event(w, OVERLAP, p, g[U])
            contacts.activate(s, w, p, gaps[p])
            w.rest[p] = gaps[p] <= s.h_min * (1.0 + 1e-9) and abs(g[U]) < 1e-12
    w.now.start = contacts.kinetic_energy(w.y, s)
    w.now.energy = max(w.now.start, 1e-3)


@compiled
def segment(limit: float, s: Any, w: Any, method: int, most: int, every: bool) -> int:
    """Advance w to the time `limit`; return DONE or the reason for stopping. With `every`, each step is recorded."""
    fresh = True
    while w.now.time < limit:
        if w.count.pairs == 0:
            p = fly(limit, s, w)
            if p >= 0:
                apply(OVERLAP, p, s, w)
            fresh = True
        else:
            if fresh:
                contacts.resolve(s, w)
                w.count.mode = EXPLICIT if method == AUTO else method
                start_step(limit - w.now.time, s, w)
            if fresh and every:
                trace(s, w)
            fresh = False
            t = w.now.time
            kind, p = advance(limit, s, w)
            if kind == -3:
                continue
            if kind == -2:
                return TOO_SMALL
            if kind >= 0:
                apply(kind, p, s, w)
                fresh = True
            elif method == AUTO and w.count.stiff >= PATIENCE:
                w.count.mode, w.count.stiff = IMPLICIT, 0
            w.count.instant = w.count.instant + 1 if w.now.time - t < 1e-13 * max(t, 1e-3) else 0
        if every:
            trace(s, w)
        if w.count.instant > 300:
            return STALLED
        if w.count.steps + 9 * w.count.implicit_steps > most or w.count.logged > most:
            return TOO_MANY_STEPS
    return DONE


@njit(cache=True, nogil=True, error_model="numpy")
def march(stops: Any, gaps: Any, s: Any, w: Any, method: int, most: int, every: bool) -> int:
    """Integrate from the start to the last of `stops` with a record at each stop or step; `gaps` of the pairs, system, work."""
    begin(s, w, gaps)
    for k in range(stops.size):
        code = segment(stops[k], s, w, method, most, every)
        if code != DONE:
            return code
        if not every:
            trace(s, w)
    for p in range(gaps.size):
        pair_geometry(w.y, s, p, w.slot[p], w.seen[p])
    w.now.end = contacts.kinetic_energy(w.y, s)
    return DONE
