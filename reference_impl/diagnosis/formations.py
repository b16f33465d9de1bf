"""Formations too early, too late or missing: what the engine must have checked, or when (see diagnosis.py)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from reference_impl.diagnosis.diagnosis import Link, Suspect
from reference_impl.motion import impulses, nearest
from reference_impl.replay import formations, laws, missing, one_place
from reference_impl.replay.arrays import Floats
from reference_impl.replay.bodies import Bodies, bodies, film_areas, pairs
from reference_impl.replay.io import Run
from reference_impl.replay.lives import FORMATION, Lives, keys, none

MOST_LOOKS = 50
"""Steps between two neighbour checks that can be distinguished from no check at all."""


def early(run: Run, marks: dict[str, Floats]) -> Link:
    """Check that a bridge forms only if the films touch, S < h_i + h_j, with the films at the start of the step."""
    wrong, films, gap = formations.early(run)
    one = np.ones(len(gap))

    def suspects(rows: Floats) -> Iterator[Suspect]:
        far = float((gap / films)[rows].max())
        words = f"it is made too early (at up to {far:.4g} times the films' thickness)"
        yield Suspect(words, np.where(gap <= far * films * (1 + 1e-12), wrong, np.nan), far)

    def says(rows: Floats) -> str:
        far = float(np.median((gap / films)[rows]))
        return f"it is made too early, at {far:.4g} times the films' thickness in the median"

    return Link(
        "formation_due", "formation", run.table("events"), wrong, 0.0 * one, one, suspects, marks=marks, says=says
    )


def late(run: Run, marks: dict[str, Floats]) -> Link:
    """Check that a bridge forms at the first neighbour check at which the films touch."""
    held, table = formations.Held(run), run.table("events")
    excess, way = formations.lateness(run, held, Lives(none(), table, 0, -1))
    expected, other, gap, ri = formations.films_at_events(run)
    step, every = table["step"].to_numpy(np.int64), impulses.every(run)
    formed = (table["kind"] == FORMATION).to_numpy() & (step > 0)
    wall = table["partner_kind"].to_numpy() != laws.SPHERE

    def suspects(rows: Floats) -> Iterator[Suspect]:
        looks = [k for k in range(2, MOST_LOOKS) if len(np.unique(step[formed] % (k * every))) == 1]
        if looks and formed.sum() > 3:
            yield Suspect(
                f"films are looked at in every {looks[-1]}th step only".replace("2th", "2nd"), excess, looks[-1]
            )
        yield from _of_walls(excess, wall, expected, other, gap, formed)
        if (gap[formed] <= 0.0).all():
            yield Suspect("it is made too late (only when the bodies touch)", excess)
        yield Suspect("a film's growth is not seen at once (it was looked at when it was thinner)",
                      np.where(_grown(run, held, gap, way), excess, np.nan))  # fmt: skip
        reach = float((gap / (expected + other))[formed].max(initial=0.0))
        yield Suspect(f"it is made too late (at {max(reach, 0.0):.3g} of the films' thickness at most)",
                      np.where(formed, excess, np.nan) if reach < 1.0 - 1e-3 else 0.0 * excess + np.nan, reach)  # fmt: skip
        yield Suspect("it is made too late", excess, general=True)

    zero = np.zeros(len(excess))

    def says(rows: Floats) -> str:
        return f"it is made too late, by {float(np.median(excess[rows])):.3g} m of the gap in the median"

    return Link("formation_late", "formation", table, excess, zero, ri, suspects, marks=marks, says=says)


def _grown(run: Run, held: formations.Held, gap: Floats, way: Floats) -> Floats:
    """Return formations that are not late with the films before the last growth of either side."""
    table, fixed = run.table("events"), bodies(run)
    p = pairs(table, fixed)
    thinner = []
    for side, radius in (("i", p.ri), ("j", p.rj)):
        number = np.where(p.wall & (side == "j"), -1 - fixed.film_of[table["triangle"]], table[side])
        before = _before_last(table, number, fixed)
        film = np.where(np.isfinite(before), before, table[f"film_{side}_before"].to_numpy(float))
        area = film_areas(table, p, fixed)
        layer = formations.thickness(np.maximum(film, 0.0), radius)
        thinner.append(np.where(p.wall & (side == "j"), film / area, layer))
    return np.asarray(thinner[0] + thinner[1] - gap - way <= 0.0)


def _before_last(table: pd.DataFrame, number: Floats, fixed: Bodies) -> Floats:
    """Return the liquid of each side before the event that last changed it; NaN without such an event."""
    wall = table["partner_kind"].to_numpy() != laws.SPHERE
    j = np.where(wall, -1 - fixed.film_of[table["triangle"]], table["j"])
    both = pd.DataFrame({
        "reservoir": np.concatenate([table["i"], j]), "step": np.tile(table["step"], 2),
        "film": np.concatenate([table["film_i_before"], table["film_j_before"]]),
    }).drop_duplicates(["reservoir", "step"]).sort_values("step", kind="stable")  # fmt: skip
    asked = pd.DataFrame({"reservoir": number, "step": table["step"].to_numpy(), "row": np.arange(len(table))})
    asked["reservoir"], both["reservoir"] = asked["reservoir"].astype(np.int64), both["reservoir"].astype(np.int64)
    found = pd.merge_asof(asked.sort_values("step"), both, on="step", by="reservoir", allow_exact_matches=False)
    return found.sort_values("row")["film"].to_numpy(float)


def _of_walls(
    logged: Floats, wall: Floats, expected: Floats, other: Floats, gap: Floats, formed: Floats
) -> Iterator[Suspect]:
    """Suspect that the film of a wall is omitted, or too thin; only if a wall has a film."""
    wet = wall & (other > 0.0)
    with np.errstate(all="ignore"):
        part = (gap - expected) / other
    most = float(part[formed & wet].max(initial=0.0))
    at_wet = np.where(wet, logged, np.nan)
    if most <= 0.0:
        yield Suspect("the film of a wall is left out", at_wet)
    elif most < 1.0:
        yield Suspect(f"the film of a wall is taken too thin (at most {most:.4g} of it)", at_wet, most)


def shared(run: Run) -> Link | None:
    """Check that a sphere at a convex edge has one bridge: it forms with only one of the parts that meet there."""
    lives = Lives(none(), run.table("events"), 0, -1)
    table = one_place.judged(run, lives)
    if not len(table):
        return None
    wrong = table["wrong"].to_numpy(float)

    def suspects(rows: Floats) -> Iterator[Suspect]:
        yield Suspect("a sphere gets a bridge with each part of a wall that meets in one place", wrong)

    one = np.ones(len(wrong))
    words = "a sphere has more than one bridge where parts of a wall meet"
    return Link("formation_shared", "formation", table, wrong, 0.0 * one, one, suspects, says=lambda _: words)


def missed(run: Run) -> Iterator[Link]:
    """Check bridges that must exist because films touch, at outputs and in windows; yield links of missing ones."""
    events = run.table("events")
    lives = Lives(none(), events, 0, -1)
    table = missing.touching(run, lives, formations.Held(run))
    if not len(table):
        return
    logged, wall = table["missed"].to_numpy(float), table["partner_kind"].to_numpy() != laws.SPHERE
    expected, other, gap, _ = formations.films_at_events(run)
    formed = (events["kind"] == FORMATION).to_numpy()
    between = formed & (events["partner_kind"] == laws.SPHERE).to_numpy()
    reach = float((gap / (expected + other))[between].max()) if between.any() else 0.0
    apart, films, layer = (table[n].to_numpy(float) for n in ("separation", "films", "own_film"))
    at_wall = formed & (events["partner_kind"] != laws.SPHERE).to_numpy()

    def suspects(rows: Floats) -> Iterator[Suspect]:
        if not formed.any():
            yield Suspect("no bridge forms at all", logged)
            return
        if (wall[rows]).all():
            bridged = set(events["j"][at_wall])
            never = sorted(set(table["j"][rows]) - bridged)
            if never:
                names = ", ".join(map(str, never))
                yield Suspect(
                    f"wall part {names} never gets a bridge", np.where(table["j"].isin(never), logged, np.nan)
                )
            yield Suspect("a sphere has one bridge to a mesh in place of one to each part",
                          np.where(_beside(run, table, lives), logged, np.nan))  # fmt: skip
            if (apart[rows] >= layer[rows]).all():
                yield from _of_walls_missed(logged, apart, films, layer, expected, other, gap, at_wall)
        if not wall[rows].any():
            if reach <= 0.0:
                yield Suspect("it is made too late (only when the bodies touch)", np.where(apart > 0.0, logged, np.nan))
            words = f"it is made too late (at {max(reach, 0.0):.3g} of the films' thickness at most)"
            yield Suspect(words, np.where(apart / films >= reach, logged, np.nan), reach)
        yield Suspect("it is left out", logged, general=True)

    one = np.ones(len(logged))
    kinds = {
        "between spheres": ~wall,
        "at walls": wall,
        "at large walls": (table["partner_kind"] == laws.LARGE_WALL).to_numpy(),
        "at wires": (table["partner_kind"] == laws.SMALL_WALL).to_numpy(),
    }
    yield Link("formation_missed", "formation", table, logged, 0.0 * one, one, suspects, marks=kinds,
               says=lambda _: "there is no bridge though the films touch")  # fmt: skip


def _of_walls_missed(
    logged: Floats,
    apart: Floats,
    films: Floats,
    layer: Floats,
    expected: Floats,
    other: Floats,
    gap: Floats,
    formed: Floats,
) -> Iterator[Suspect]:
    with np.errstate(all="ignore"):
        most = float(((gap - expected) / other)[formed & (other > 0.0)].max(initial=0.0))
        part = (apart - layer) / (films - layer)
    words = "the film of a wall is left out" if most <= 0.0 else "the film of a wall is taken too thin"
    words += "" if most <= 0.0 else f" (at most {most:.4g} of it)"
    yield Suspect(words, np.where(part >= most, logged, np.nan), most)


def _beside(run: Run, table: pd.DataFrame, lives: Lives) -> Floats:
    """Return whether the sphere has a bridge to another part of the same mesh in that step."""
    parts = nearest.parts(run)
    found, step = np.zeros(len(table), dtype=bool), table["step"].to_numpy(np.int64)
    j = np.where(table["partner_kind"] != laws.SPHERE, table["j"], 0).astype(np.int64)
    for part in range(len(parts)):
        other = table.assign(j=part)
        there = lives.at(keys(other), step, strictly=False) >= 0
        found |= there & (part != j) & (parts.wall[part] == parts.wall[j])
    return found
