"""Solid contact, compiled: impact with restitution and friction (Davis 2023, appendix A), contacts that come to rest,
who overlaps.

Impacts that coincide are treated one after the other, the fastest first. A contact comes to rest when its rebound
would be slower than the
rest speed of the pair and the forces press it; the rest speed doubles after every `BURST` impacts of a pair whose
films stay in touch, so that
a pair makes at most BURST·log2(speed scale/rest speed) impacts, and no bouncing goes on without end.
"""

from __future__ import annotations

import math
from typing import Any

from pywet.collisions.spheres.dynamics import COS, SIN, WORKS, H, U, W, compiled, pair_geometry, slip
from pywet.collisions.spheres.steppers import IMPACT_LOSS, IMPACTS, LOGGED, PAIRS, SIZE, SPEED, TIME, derivative

BURST = 500
"""Impacts of one pair after which its rest speed doubles."""
AT_ONCE = 200
"""Impacts at one instant, per overlapping pair, after which all that is left is inelastic."""
OVERLAP, SEPARATION, CONTACT, REST, RELEASE = range(5)
"""Kinds of logged events."""


@compiled
def log_event(w: Any, kind: int, p: int, u: float) -> None:
    """Note an event; what does not fit any more is counted only."""
    k = w.number[LOGGED]
    w.number[LOGGED] += 1
    if k < w.log.shape[0]:
        w.log[k, 0], w.log[k, 1], w.log[k, 2], w.log[k, 3] = w.value[TIME], kind, p, u


@compiled
def activate(s: Any, w: Any, p: int, gap: float, polar: bool) -> None:
    """Pair p overlaps from now on; `gap` is its gap, known better than from the difference of positions."""
    k = w.number[PAIRS]
    pair_geometry(w.y, s, p, -1, polar, w.geometry[k])
    w.act[k], w.slot[p] = p, k
    w.number[PAIRS] += 1
    w.impacts[p] = 0
    if polar:
        b = w.number[SIZE]
        g = w.geometry[k]
        w.y[b], w.y[b + 1], w.y[b + 2], w.y[b + 3] = math.log(gap), math.atan2(g[SIN], g[COS]), g[U], g[W]
        w.number[SIZE] += 4


@compiled
def deactivate(s: Any, w: Any, p: int, polar: bool) -> None:
    """Pair p no longer overlaps; the last slot takes its place."""
    k, last = w.slot[p], w.number[PAIRS] - 1
    if polar:
        first = 5 * s.radius.size + WORKS
        for q in range(4):
            w.y[first + 4 * k + q] = w.y[first + 4 * last + q]
        w.number[SIZE] -= 4
    w.act[k] = w.act[last]
    w.slot[w.act[k]] = k
    w.slot[p] = -1
    w.rest[p] = False
    w.number[PAIRS] = last


@compiled
def kinetic_energy(y: Any, s: Any) -> float:
    """½ Σ (m v² + I ω²), I = (2/5) m a²."""
    total = 0.0
    for i in range(s.radius.size):
        spin = s.radius[i] * y[5 * i + 4]
        total += 0.5 * s.mass[i] * (y[5 * i + 2] ** 2 + y[5 * i + 3] ** 2 + 0.4 * spin * spin)
    return total


@compiled
def impulse(s: Any, w: Any, p: int, jn: float, jt: float, polar: bool) -> None:
    """Normal and tangential impulse of pair p on its spheres, and on the polar variables of every pair they are in."""
    g = w.geometry[w.slot[p]]
    x, z = jn * g[COS] - jt * g[SIN], jn * g[SIN] + jt * g[COS]
    i, j = s.first[p], s.second[p]
    before = kinetic_energy(w.y, s)
    w.y[5 * i + 2] -= x / s.mass[i]
    w.y[5 * i + 3] -= z / s.mass[i]
    w.y[5 * j + 2] += x / s.mass[j]
    w.y[5 * j + 3] += z / s.mass[j]
    w.y[5 * i + 4] -= 2.5 * jt / (s.mass[i] * s.radius[i])
    w.y[5 * j + 4] -= 2.5 * jt / (s.mass[j] * s.radius[j])
    w.value[IMPACT_LOSS] += before - kinetic_energy(w.y, s)
    if not polar:
        return
    for k in range(w.number[PAIRS]):
        o, b, h = w.act[k], 5 * s.radius.size + WORKS + 4 * k, w.geometry[k]
        share = 0.0
        for at, sign in ((i, -1.0), (j, 1.0)):
            if at == s.first[o]:
                share += sign / s.mass[at]
            elif at == s.second[o]:
                share -= sign / s.mass[at]
        if share != 0.0:
            w.y[b + 2] += share * (x * h[COS] + z * h[SIN])
            w.y[b + 3] += share * (z * h[COS] - x * h[SIN])


@compiled
def hit(s: Any, w: Any, p: int, restitution: float, polar: bool) -> None:
    """Impact of pair p: u → −restitution·u; tangential impulse μ_f times the normal one, or the sticking one where
    that is smaller."""
    g = w.geometry[w.slot[p]]
    i, j = s.first[p], s.second[p]
    reduced = s.mass[i] * s.mass[j] / (s.mass[i] + s.mass[j])
    jn = reduced * (1.0 + restitution) * g[U]
    v = slip(w.y, s, p, g[W])
    jt = math.copysign(min(s.mu_f * abs(jn), 2.0 / 7.0 * reduced * abs(v)), v)
    u = g[U]
    impulse(s, w, p, jn, jt, polar)
    if polar:
        w.y[5 * s.radius.size + WORKS + 4 * w.slot[p] + 2] = -restitution * u


@compiled
def geometries(s: Any, w: Any, polar: bool) -> None:
    """Geometry of all overlapping pairs at w.y."""
    for k in range(w.number[PAIRS]):
        pair_geometry(w.y, s, w.act[k], k, polar, w.geometry[k])


@compiled
def fastest(s: Any, w: Any) -> int:
    """Touching pair that approaches fastest, −1 for none; a resting one nudged by less than its rest speed, either
    way, is held."""
    found, most = -1, 1e-13 * w.value[SPEED]
    for k in range(w.number[PAIRS]):
        p, g = w.act[k], w.geometry[k]
        u = g[U]
        if w.rest[p] and abs(u) < w.rest_speed[p]:
            u = abs(u)
        if (w.rest[p] or g[H] <= s.h_min[p] * (1.0 + 1e-9)) and u > most:
            found, most = p, u
    return found


@compiled
def resolve(s: Any, w: Any, polar: bool) -> None:
    """All impacts of this instant; then which contacts rest. Leaves w.f at the new state."""
    for k in range(AT_ONCE * (w.number[PAIRS] + 1)):
        geometries(s, w, polar)
        p = fastest(s, w)
        if p < 0:
            break
        u = w.geometry[w.slot[p]][U]
        held = w.rest[p] and abs(u) < w.rest_speed[p]
        bounces = not held and s.e_dry * u > w.rest_speed[p] and k < AT_ONCE * w.number[PAIRS] // 2
        if bounces:
            w.rest[p] = False
            w.impacts[p] += 1
            w.number[IMPACTS] += 1
            log_event(w, CONTACT, p, u)
            if w.impacts[p] % BURST == 0:
                w.rest_speed[p] *= 2.0
        elif not w.rest[p]:
            w.rest[p] = True
            log_event(w, REST, p, u)
        hit(s, w, p, s.e_dry if bounces else 0.0, polar)
    geometries(s, w, polar)
    for k in range(w.number[PAIRS]):
        p, u = w.act[k], w.geometry[k][U]
        still = abs(u) <= 1e-12 * w.value[SPEED]
        if w.rest[p] and not still:
            release(w, p)
        elif still and not w.rest[p] and w.lam[p] >= 0.0 and w.geometry[k][H] <= s.h_min[p] * (1.0 + 1e-9):
            w.rest[p] = True  # touching without speed: the forces decide, below
            if polar:
                w.y[5 * s.radius.size + WORKS + 4 * k + 2] = 0.0
        if not w.rest[p]:
            w.lam[p] = 0.0
    derivative(w.y, w.f, s, w, w.lam, polar)
    drop_pulled(s, w, polar)


@compiled
def release(w: Any, p: int) -> None:
    """A resting contact opens."""
    w.rest[p] = False
    log_event(w, RELEASE, p, 0.0)


@compiled
def drop_pulled(s: Any, w: Any, polar: bool) -> None:
    """Release resting contacts that would have to pull, the worst first."""
    for _ in range(w.number[PAIRS]):
        worst, least = -1, 0.0
        for k in range(w.number[PAIRS]):
            p = w.act[k]
            if w.rest[p] and w.lam[p] < least:
                worst, least = p, w.lam[p]
        if worst < 0:
            return
        release(w, worst)
        derivative(w.y, w.f, s, w, w.lam, polar)
