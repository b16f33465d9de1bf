"""Outcome of a collision: which spheres stick, when and how fast others separate, by which mechanism; plain data for JSON."""

from __future__ import annotations

from typing import Any

from pywet.collisions.spheres.simulate import Run

CRADLES = {(0, 1): "Newton's cradle", (1, 2): "reverse Newton's cradle", (0, 2): "transfer"}
"""Names of partial agglomeration of three spheres, by the pair that remains joined (Donahue et al. 2010; Liu et al. 2017)."""


def clusters(count: int, pairs: list[tuple[int, int]]) -> list[list[int]]:
    """Return the groups of spheres (from 0) joined by pairs, larger groups first."""
    group = list(range(count))
    for i, j in pairs:
        old, new = group[j], group[i]
        group = [new if g == old else g for g in group]
    groups = [[k for k in range(count) if group[k] == g] for g in set(group)]
    return sorted(groups, key=lambda c: (-len(c), c))


def outcome(run: Run) -> str:
    """Return FA if all spheres are connected at the end, FS if none are, else PA."""
    groups = clusters(len(run.omega), run.overlapping)
    if len(groups) == 1:
        return "FA"
    return "FS" if all(len(g) == 1 for g in groups) else "PA"


def times(run: Run, pair: tuple[int, int], kind: str) -> list[float]:
    """Return the times of a pair's events of one kind."""
    return [e.time for e in run.events if e.pair == pair and e.kind == kind]


def reference_speed(run: Run) -> float:
    """Return the reference speed of e_wet: the given one or the largest initial normal approach of a pair whose paths cross."""
    return run.problem.reference_speed or run.speed


def wet_restitution(run: Run, pair: tuple[int, int]) -> float | None:
    """Return the speed at the last separation of the films over the striker's normal speed (Davis 2023, 40), or None."""
    speeds = [-e.speed for e in run.events if e.pair == pair and e.kind == "separation"]
    return speeds[-1] / reference_speed(run) if speeds else None


def mechanism(run: Run, pair: tuple[int, int]) -> str | None:
    """Name the last separation of a pair: rapid bounce or stick-rotate-separate; None if it did not separate.

    A rebound driven by the impact slows down in the film, so its mean speed after the last contact exceeds that
    at separation. A pair that stuck and is pulled apart by its rotation speeds up: its mean speed is below half
    of that at separation (or there was no contact).
    """
    parted = [e for e in run.events if e.pair == pair and e.kind == "separation"]
    touched = [t for t in times(run, pair, "contact") if parted and t <= parted[-1].time]
    began = [t for t in times(run, pair, "overlap") if parted and t <= parted[-1].time]
    if not parted:
        return None
    if not touched or touched[-1] < began[-1]:
        return "stick-rotate-separate"
    path = run.problem.film[pair] - run.problem.h_min
    mean = path / max(parted[-1].time - touched[-1], 1e-300)
    return "rapid bounce" if mean >= -0.5 * parted[-1].speed else "stick-rotate-separate"


def describe(run: Run) -> dict[str, Any]:
    """Return the answer of `pywet collide spheres`, with spheres numbered from 1 and in the problem's units."""
    groups = clusters(len(run.omega), run.overlapping)
    kind = outcome(run)
    name = CRADLES.get(run.overlapping[0]) if kind == "PA" and len(run.omega) == 3 and run.overlapping else None
    pairs = {
        f"{i + 1}-{j + 1}": {
            **{f"{event}_times": times(run, (i, j), event) for event in ("overlap", "contact", "rest", "separation")},
            "e_wet": wet_restitution(run, (i, j)),
            "mechanism": mechanism(run, (i, j)),
        }
        for i, j in run.problem.pairs
    }
    e = run.energy
    return {
        "outcome": kind,
        "name": name,
        "until": run.problem.t_end,
        "stuck_pairs": [[i + 1, j + 1] for i, j in run.overlapping],
        "resting_pairs": [[i + 1, j + 1] for i, j in run.resting],
        "clusters": [[k + 1 for k in g] for g in groups if len(g) > 1],
        "reference_speed": reference_speed(run),
        "pairs": pairs,
        "final": {name: getattr(run, name).tolist() for name in ("position", "velocity", "omega")},
        "energy": {
            "in": e.start,
            "out": e.end,
            **{name: getattr(e, name) for name in ("viscous", "capillary", "impact", "gravity", "residual")},
        },
        "work": {
            **{name: getattr(run, name) for name in ("steps", "implicit_steps", "evaluations", "impacts")},
            "events_not_listed": run.events_left_out,
            "rest_speed": run.rest_speed,
        },
        "wall_s": run.wall_s,
    }
