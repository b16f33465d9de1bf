"""Solid contact, compiled: impact with restitution and friction (Davis 2023, appendix A), contacts that come to rest, overlaps.

Impacts that coincide are treated one after the other, the fastest first. A contact comes to rest when its rebound
would be slower than the rest speed of the pair and the force is compressive; the rest speed doubles after every
`BURST` impacts of a pair whose films stay in touch, so that a pair makes at most BURST·log2(speed scale/rest speed)
impacts and never bounces forever.
"""

from __future__ import annotations

import math
from typing import Any

from pywet.collisions.spheres.dynamics import derivative, pair_geometry, place, push, shared, slip
from pywet.collisions.spheres.state import COS, SIN, H, U, W, compiled

BURST = 500
"""Impacts of one pair after which its rest speed doubles."""
AT_ONCE = 200
"""Number of impacts at one instant, per overlapping pair, after which all further ones are inelastic."""
OVERLAP, SEPARATION, CONTACT, REST, RELEASE = range(5)
"""Kinds of logged events."""


@compiled
def log_event(w: Any, kind: int, p: int, u: float) -> None:
    """Log an event; events beyond the capacity of the log are only counted."""
    k = w.count.logged
    w.count.logged += 1
    if k < w.log.shape[0]:
        w.log[k, 0], w.log[k, 1], w.log[k, 2], w.log[k, 3] = w.now.time, kind, p, u


@compiled
def activate(s: Any, w: Any, p: int, gap: float) -> None:
    """Register overlapping pair p; `gap` is its gap, more accurate than from the difference of positions."""
    k = w.count.pairs
    pair_geometry(w.y, s, p, -1, w.geometry[k])
    w.act[k], w.slot[p] = p, k
    w.count.pairs += 1
    w.impacts[p] = 0
    if s.polar:
        b = w.count.size
        g = w.geometry[k]
        w.y[b], w.y[b + 1], w.y[b + 2], w.y[b + 3] = math.log(gap), math.atan2(g[SIN], g[COS]), g[U], g[W]
        w.count.size += 4


@compiled
def deactivate(s: Any, w: Any, p: int) -> None:
    """Remove pair p, which no longer overlaps; the last slot replaces it."""
    k, last = w.slot[p], w.count.pairs - 1
    if s.polar:
        for q in range(4):
            w.y[place(s, k) + q] = w.y[place(s, last) + q]
        w.count.size -= 4
    w.act[k] = w.act[last]
    w.slot[w.act[k]] = k
    w.slot[p] = -1
    w.rest[p] = False
    w.count.pairs = last


@compiled
def kinetic_energy(y: Any, s: Any) -> float:
    """Return ½ Σ (m v² + I ω²), I = (2/5) m a²."""
    total = 0.0
    for i in range(s.radius.size):
        spin = s.radius[i] * y[5 * i + 4]
        total += 0.5 * s.mass[i] * (y[5 * i + 2] ** 2 + y[5 * i + 3] ** 2 + 0.4 * spin * spin)
    return total


@compiled
def impulse(s: Any, w: Any, p: int, jn: float, jt: float) -> None:
    """Apply a normal and a tangential impulse of pair p to its spheres, and to the polar variables of all their pairs."""
    g = w.geometry[w.slot[p]]
    x, z = jn * g[COS] - jt * g[SIN], jn * g[SIN] + jt * g[COS]
    before = kinetic_energy(w.y, s)
    push(w.y, s, p, x, z, jt)
    w.now.impact_loss += before - kinetic_energy(w.y, s)
    if not s.polar:
        return
    for k in range(w.count.pairs):
        b, h, share = place(s, k), w.geometry[k], shared(s, p, w.act[k])
        if share != 0.0:
            w.y[b + 2] += share * (x * h[COS] + z * h[SIN])
            w.y[b + 3] += share * (z * h[COS] - x * h[SIN])


@compiled
def hit(s: Any, w: Any, p: int, restitution: float) -> None:
    """Apply the impact of pair p: u → −restitution·u.

    The tangential impulse is μ_f times the normal one, or, if smaller, the sticking one.
    """
    g = w.geometry[w.slot[p]]
    i, j = s.first[p], s.second[p]
    reduced = s.mass[i] * s.mass[j] / (s.mass[i] + s.mass[j])
    jn = reduced * (1.0 + restitution) * g[U]
    v = slip(w.y, s, p, g[W])
    jt = math.copysign(min(s.mu_f * abs(jn), 2.0 / 7.0 * reduced * abs(v)), v)
    u = g[U]
    impulse(s, w, p, jn, jt)
    if s.polar:
        w.y[place(s, w.slot[p]) + 2] = -restitution * u


@compiled
def geometries(s: Any, w: Any) -> None:
    """Compute the geometry of all overlapping pairs at w.y."""
    for k in range(w.count.pairs):
        pair_geometry(w.y, s, w.act[k], k, w.geometry[k])


@compiled
def fastest(s: Any, w: Any) -> int:
    """Return the touching pair with the largest approach speed, or -1; a pair at rest below its rest speed counts with its
    absolute speed.
    """
    first, most = -1, 1e-13
    for k in range(w.count.pairs):
        p, g = w.act[k], w.geometry[k]
        u = g[U]
        if w.rest[p] and abs(u) < w.rest_speed[p]:
            u = abs(u)
        if (w.rest[p] or g[H] <= s.h_min * (1.0 + 1e-9)) and u > most:
            first, most = p, u
    return first


@compiled
def resolve(s: Any, w: Any) -> None:
    """Resolve all impacts of this instant, then determine the resting contacts; leaves w.f at the new state."""
    for k in range(AT_ONCE * (w.count.pairs + 1)):
        geometries(s, w)
        p = fastest(s, w)
        if p < 0:
            break
        u = w.geometry[w.slot[p]][U]
        held = w.rest[p] and abs(u) < w.rest_speed[p]
        bounces = not held and s.e_dry * u > w.rest_speed[p] and k < AT_ONCE * w.count.pairs // 2
        if bounces:
            w.rest[p] = False
            w.impacts[p] += 1
            w.count.impacts += 1
            log_event(w, CONTACT, p, u)
            if w.impacts[p] % BURST == 0:
                w.rest_speed[p] *= 2.0
        elif not w.rest[p]:
            w.rest[p] = True
            log_event(w, REST, p, u)
        hit(s, w, p, s.e_dry if bounces else 0.0)
    geometries(s, w)
    for k in range(w.count.pairs):
        p, u = w.act[k], w.geometry[k][U]
        still = abs(u) <= 1e-12
        if w.rest[p] and not still:
            release(w, p)
        elif still and not w.rest[p] and w.lam[p] >= 0.0 and w.geometry[k][H] <= s.h_min * (1.0 + 1e-9):
            w.rest[p] = True  # touching at zero velocity: the forces decide, below
            if s.polar:
                w.y[place(s, k) + 2] = 0.0
        if not w.rest[p]:
            w.lam[p] = 0.0
    derivative(w.y, w.f, s, w, w.lam)
    drop_pulled(s, w)


@compiled
def release(w: Any, p: int) -> None:
    """Change a resting contact into an open one."""
    w.rest[p] = False
    log_event(w, RELEASE, p, 0.0)


@compiled
def drop_pulled(s: Any, w: Any) -> None:
    """Release resting contacts with a tensile force, the largest first."""
    for _ in range(w.count.pairs):
        worst, least = -1, 0.0
        for k in range(w.count.pairs):
            p = w.act[k]
            if w.rest[p] and w.lam[p] < least:
                worst, least = p, w.lam[p]
        if worst < 0:
            return
        release(w, worst)
        derivative(w.y, w.f, s, w, w.lam)
