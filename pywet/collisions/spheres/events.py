"""Locate events, compiled: films that touch or separate, solid contacts, resting contacts that would pull.

An event is suspected where the cubic through the ends of a step crosses its level, including the start of a bounce
within one step. It is located by repeating the step with other lengths, so that its position is as accurate as a
step.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pywet.collisions.runge_kutta import HIGH, LOW, narrow, trial
from pywet.collisions.spheres.contacts import CONTACT, OVERLAP, RELEASE, SEPARATION
from pywet.collisions.spheres.dynamics import pair_geometry, place
from pywet.collisions.spheres.state import H, U, compiled
from pywet.collisions.spheres.steppers import step

SAMPLES = 8
"""Number of points of a step at which the cubic is evaluated."""


@compiled
def gap_of(y: Any, s: Any, w: Any, p: int) -> tuple[float, float]:
    """Return the monitored gap of a pair and its rate: ln h of a pair in polar variables, else h."""
    k, g = w.slot[p], w.seen[p]
    pair_geometry(y, s, p, k, g)
    return (y[place(s, k)], -g[U] / g[H]) if s.polar and k >= 0 else (g[H], -g[U])


@compiled
def level_of(s: Any, w: Any, p: int, kind: int) -> float:
    """Return the level of the monitored gap at which an event of that kind occurs."""
    level = s.h_min if kind == CONTACT else s.film[p]
    return math.log(level) if s.polar and w.slot[p] >= 0 else level


@compiled
def cubic(a: float, da: float, b: float, db: float, x: float) -> float:
    """Evaluate Hermite's cubic on 0..1 with end values a, b and slopes da, db."""
    z = 1.0 - x
    return a * z * z * (1.0 + 2.0 * x) + b * x * x * (3.0 - 2.0 * x) + da * x * z * z - db * x * x * z


@compiled
def crossing(a: float, da: float, b: float, db: float, slack: float) -> tuple[float, float]:
    """Return the part (lo, hi) of the step in which the cubic rises through 0 to above `slack`, or rises above it.

    hi < 0 for none. lo < 0: it first leaves the level and exceeds it soon after, and the cubic does not resolve the
    turning point.
    """
    if max(a, b) + 0.3 * (abs(da) + abs(db)) < 0.0:
        return 0.0, -1.0
    before, x0 = a, 0.0
    for k in range(1, SAMPLES + 1):
        x = k / SAMPLES
        v = cubic(a, da, b, db, x)
        if v > slack and (before <= slack or v > before):
            if k == 1 and a > -slack:  # starts at the threshold: begin at the minimum below it
                best = 0.0
                for o in range(1, 16):
                    if cubic(a, da, b, db, o / (16.0 * SAMPLES)) < min(best, 0.0):
                        best, x0 = cubic(a, da, b, db, o / (16.0 * SAMPLES)), o / (16.0 * SAMPLES)
                if best == 0.0 and da <= 0.0:
                    return -1.0, x
            return x0, x
        before, x0 = v, x
    return 0.0, -1.0


@compiled
def value_at(kind: int, p: int, s: Any, w: Any) -> float:
    """Return the quantity that rises through 0 at the event, at w.y_new."""
    if kind == RELEASE:
        return -w.lam_new[p]
    sign = 1.0 if kind == SEPARATION else -1.0
    return sign * (gap_of(w.y_new, s, w, p)[0] - level_of(s, w, p, kind))


@compiled
def first_event(dt: float, s: Any, w: Any) -> tuple[int, int, float, float]:
    """Return the earliest suspected event of the last step: kind (−1 none), pair, and the part of the step that contains it."""
    kind, pair, low, high = -1, -1, 0.0, 2.0
    for p in range(s.first.size):
        active = w.slot[p] >= 0
        if active and w.rest[p]:
            if w.lam_new[p] < 0.0 and high > 1.0:
                kind, pair, low, high = RELEASE, p, 0.0, 1.0
            continue
        a, da = gap_of(w.y, s, w, p)
        b, db = gap_of(w.y_new, s, w, p)
        slack = 1e-11 if s.polar and active else 2e-11
        for one in (CONTACT, SEPARATION, OVERLAP):
            if active == (one == OVERLAP):
                continue
            sign, level = (1.0 if one == SEPARATION else -1.0), level_of(s, w, p, one)
            lo, hi = crossing(sign * (a - level), sign * da * dt, sign * (b - level), sign * db * dt, slack)
            if hi > 0.0 and (hi < high or (hi == high and lo < low)):
                kind, pair, low, high = one, p, lo, hi
    return kind, pair, low, high


@compiled
def locate(dt: float, kind: int, p: int, low: float, high: float, s: Any, w: Any) -> tuple[float, bool]:
    """Repeat the step with other lengths until the event is at its end; returns the length and whether there is an event."""
    x1 = high * dt
    step(x1, s, w)
    g1 = value_at(kind, p, s, w)
    if g1 <= 0.0:
        return x1, False
    x0 = low * dt
    if low > 0.0:
        step(x0, s, w)
    else:
        w.y_new[: w.count.size] = w.y[: w.count.size]
        w.lam_new[p] = w.lam[p]
    bracket = np.array([x0, min(value_at(kind, p, s, w), -1e-300), x1, g1, 0.0])
    x, enough = x1, 1e-13 if s.polar and w.slot[p] >= 0 else 1e-12
    for number in range(80):
        x, x0, x1 = trial(bracket, number), bracket[LOW], bracket[HIGH]
        if x1 - x0 < 4e-16 * max(w.now.time, 1e-3 * dt) or not x0 < x < x1:
            x = x1
        step(x, s, w)
        g = value_at(kind, p, s, w)
        if abs(g) < enough or x == x1:
            break
        narrow(bracket, x, g)
    return x, True
