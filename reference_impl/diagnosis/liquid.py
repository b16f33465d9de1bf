"""Equations of the event log, each with the faults that would violate it (see diagnosis.py).

Each event is judged from the films, volumes and shares logged with it: effects of a wrong event on later ones do not
count.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from reference_impl.diagnosis import chain as links_chain
from reference_impl.diagnosis import formations as links_formations
from reference_impl.diagnosis.chain import Pair
from reference_impl.diagnosis.diagnosis import Link, Suspect
from reference_impl.diagnosis.suspects import Formula, factor, formulas
from reference_impl.motion import impulses
from reference_impl.replay import coverage, laws
from reference_impl.replay.arrays import Floats
from reference_impl.replay.bodies import FILMS, Bodies, bodies, film_areas, films, of_bridges, pairs
from reference_impl.replay.forces import Contacts
from reference_impl.replay.io import Run
from reference_impl.replay.liquid import late_ruptures
from reference_impl.replay.lives import FORMATION, RUPTURE, Lives, none
from reference_impl.replay.transfer import Tables


@dataclass(frozen=True)
class Events:
    """The event log as arrays; at a wall `width` is its half width and `area` that of its film."""

    table: pd.DataFrame
    pair: Contacts
    formation: Floats
    kind: Floats
    width: Floats
    area: Floats
    film_i: Floats
    film_j: Floats
    fixed: Bodies
    other_areas: dict[str, Floats]
    """Areas of the films that a wall would have if these were other parts of it."""

    def column(self, name: str) -> Floats:
        """Return a column of the event log."""
        return self.table[name].to_numpy(float)

    def marks(self) -> dict[str, Floats]:
        """Group the events by kind, partner and other properties."""
        sphere, form = self.kind == laws.SPHERE, self.formation
        groups = {
            "between spheres": sphere, "between unequal spheres": sphere & (self.pair.ri != self.pair.rj),
            "at walls": ~sphere, "at large walls": self.kind == laws.LARGE_WALL, "at wires": self.kind == laws.SMALL_WALL,
        }  # fmt: skip
        when = {"formations": form, "ruptures": ~form}
        return {
            **when, **groups, **{f"{w} {g}": a & b for w, a in when.items() for g, b in groups.items()},
        }  # fmt: skip


def events(run: Run) -> Events:
    """Read the event log; the kind of wall follows from its half width, not from the log."""
    table, fixed = run.table("events"), bodies(run)
    p = pairs(table, fixed)
    none, zero = np.zeros((len(table), 3)), np.zeros(len(table))
    pair = Contacts(
        table, p.wall, p.ri, p.rj, p.ti, p.tj, table["volume"].to_numpy(float), none, table["separation"].to_numpy(float),
        speed=table["speed"].to_numpy(float), vn=zero, sideways=none, spin=none,
    )  # fmt: skip
    area = np.where(p.wall, film_areas(table, p, fixed), 1.0)
    film_i, film_j = (table[f"film_{side}_before"].to_numpy(float) for side in "ij")
    other = {of: films(run.tables["triangles"], of)[1] for of in FILMS} if "triangles" in run.tables else {}
    areas = {of: np.where(p.wall, size[np.where(p.wall, table["triangle"], -1)], 1.0) for of, size in other.items()}
    return Events(
        table, pair, table["kind"].to_numpy() == FORMATION, p.kind, p.width, area, film_i, film_j, fixed, areas
    )


def static(run: Run, e: Events, drawn_volume: Floats) -> Link | None:
    """Return the link of the static rupture distance of each event; `drawn_volume` is its correct volume."""
    name, logged = coverage.law(run, "rupture"), e.column("rupture_distance")
    if name is None or name not in laws.RUPTURE:
        return None

    def formula(law: str) -> Formula:
        return lambda k: laws.RUPTURE[law](k.volume, k.ri, k.rj, k.wall, k.ti, k.tj)

    def suspects(rows: Floats) -> Iterator[Suspect]:
        yield from formulas(e.pair, formula(name), {n: formula(n) for n in laws.RUPTURE}, name)
        yield from factor(logged, expected, rows)

    expected = formula(name)(e.pair)
    at = links_chain.at_formation(run)
    formed = np.where(at >= 0, e.pair.volume[at], e.pair.volume)
    excuses = tuple(formula(name)(replace(e.pair, volume=v)) for v in (drawn_volume, formed))
    return Link("rupture_distance", "static rupture distance", e.table, logged, expected, expected, suspects, excuses=excuses,
                marks=e.marks())  # fmt: skip


def _limit(run: Run, e: Events) -> Floats | None:
    """Return the gap at which each bridge must rupture at its speed; None if its law is not known."""
    if not coverage.known(run, "dynamic_rupture"):
        return None
    reach = e.column("rupture_distance")
    if coverage.law(run, "dynamic_rupture") is None:
        return reach
    return reach * laws.pitois_factor(e.pair.speed, run.meta["viscosity"], run.meta["surface_tension"])


def due(run: Run, e: Events) -> Link | None:
    """Check that no bridge ruptures before both its limits are reached."""
    limit = _limit(run, e)
    if limit is None:
        return None
    reach, gap = e.column("rupture_distance"), e.pair.gap
    ruptures = e.table["kind"].to_numpy() == RUPTURE
    wrong = (ruptures & (gap < limit * (1.0 - 1e-9))).astype(float)
    expected, one = np.zeros(len(gap)), np.ones(len(gap))

    def suspects(rows: Floats) -> Iterator[Suspect]:
        yield Suspect("dynamic rupture is ignored", np.where(gap >= reach * (1.0 - 1e-9), wrong, np.nan))
        lowest = float((gap / limit)[rows].min())
        # with a limit that is too low, each separation exceeds it by less than the displacement between two checks
        first = gap - e.pair.speed * impulses.every(run) * float(run.meta["time_step"]) < lowest * limit
        words = f"it is made too early (at {lowest:.4g} of the limit)"
        yield Suspect(words, np.where(first, wrong, np.nan), lowest)
        yield Suspect("it is made too early, at no fixed part of the limit", wrong, general=True)

    def says(rows: Floats) -> str:
        return f"it is made too early, at {float(np.median((gap / limit)[rows])):.4g} of the limit in the median"

    return Link("rupture_due", "rupture", e.table, wrong, expected, one, suspects, marks=e.marks(), says=says)


def overdue(run: Run, e: Events) -> Link | None:
    """Check that no bridge is active that was due to rupture at the previous neighbour check."""
    limit = _limit(run, e)
    if limit is None:
        return None
    reach, gap = e.column("rupture_distance"), e.pair.gap
    wrong = late_ruptures(run, reach, Lives(none(), e.table, 0, -1)).astype(float)

    def suspects(_: Floats) -> Iterator[Suspect]:
        least = float((gap / limit)[~e.formation].min())
        words = f"it is made too late (at {least:.4g} of the limit at least)"
        yield Suspect(words, wrong if least > 1.0 + 1e-3 else np.nan * wrong, least)
        yield Suspect("it is made too late, at no fixed part of the limit", wrong, general=True)

    one = np.ones(len(gap))

    def says(rows: Floats) -> str:
        return f"it is made too late, at {float(np.median((gap / limit)[rows])):.4g} of the limit in the median"

    return Link("rupture_late", "rupture", e.table, wrong, 0.0 * one, one, suspects, marks=e.marks(), says=says)


def asked(e: Events, **other: Floats) -> tuple[Floats, Floats]:
    """Return the volumes that each event requests from both sides, with some inputs exchanged."""
    kind, ri, rj = other.get("kind", e.kind), other.get("ri", e.pair.ri), other.get("rj", e.pair.rj)
    film_i, film_j, width = other.get("film_i", e.film_i), other.get("film_j", e.film_j), e.width
    area = other.get("area", e.area)
    with np.errstate(all="ignore"):
        ask_i = laws.drawn_from_sphere(kind, film_i, ri, rj, width)
        of_sphere = laws.drawn_from_sphere(kind, film_j, rj, ri, width)
        ask_j = np.where(kind == laws.SPHERE, of_sphere, laws.drawn_from_wall(kind, film_j / area, ri, width))
        return ask_i, np.asarray(ask_j)


def granted(e: Events, asks: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Return the volumes drawn from each film, in proportion if more is requested in a step than it has."""
    both = links_chain.sides(
        e.table, (np.where(e.formation, asks[0], 0.0), np.where(e.formation, asks[1], 0.0)), e.fixed
    )
    want = both.groupby(["reservoir", "step"])["move"].transform("sum").to_numpy()
    with np.errstate(all="ignore"):
        part = np.where(want > both["before"], both["before"] / want, 1.0)
    n = len(e.table)
    return asks[0] * part[:n], asks[1] * part[n:]


def one_after_another(e: Events, asks: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Return the draws of one step in the order of the log, each from what the earlier ones have left."""
    both = links_chain.sides(e.table, (e.column("share_i"), e.column("share_j")), e.fixed)
    both["move"] = np.where(np.tile(e.formation, 2), both["move"], 0.0)
    taken = both.sort_values("row", kind="stable").groupby(["reservoir", "step"])["move"].cumsum().sort_index()
    left = both["before"].to_numpy() - (taken - both["move"]).to_numpy()
    with np.errstate(all="ignore"):
        part = left / both["before"].to_numpy()
    n = len(e.table)
    return asks[0] * part[:n], asks[1] * part[n:]


def draws(e: Events) -> Iterator[Link]:
    """Check the volumes that both sides give to each new bridge."""
    asks, full = asked(e), e.formation
    expected, ri, rj = granted(e, asks), e.pair.ri, e.pair.rj
    like_j = np.where(e.pair.wall, ri, rj)
    changed = {
        "draws of one step are taken one after another": one_after_another(e, asks),
        "more is granted than is there": asks,
        "the sides are exchanged": (expected[1], expected[0]),
        "the radii of the two sides are exchanged": granted(e, asked(e, ri=np.where(e.pair.wall, ri, rj), rj=ri)),
        "a wire is treated as a large wall": granted(e, asked(e, kind=np.minimum(e.kind, laws.LARGE_WALL))),
        "a large wall is treated as a wire": granted(e, asked(e, kind=np.where(e.pair.wall, laws.SMALL_WALL, e.kind))),
        "spheres are treated as equal": (granted(e, asked(e, rj=ri))[0], granted(e, asked(e, ri=like_j))[1]),
        **{
            f"a wall's film is spread over the {of}": granted(e, asked(e, area=area))
            for of, area in e.other_areas.items()
            if not np.array_equal(area, e.area)
        },
        "the film of the other side is drawn on": granted(e, asked(e, film_i=e.film_j, film_j=e.film_i)),
        "the volume is drawn twice": (2.0 * expected[0], 2.0 * expected[1]),
        "half the film is drawn": (e.film_i / 2.0, e.film_j / 2.0),
        "the whole film is drawn": (e.film_i, e.film_j),
    }
    for n, side in enumerate("ij"):
        logged = np.where(full, e.column(f"share_{side}"), 0.0)

        def suspects(rows: Floats, n: int = n, logged: Floats = logged) -> Iterator[Suspect]:
            for fault, value in changed.items():
                yield Suspect(fault, np.where(full, value[n], 0.0))
            yield from factor(logged, np.where(full, expected[n], 0.0), rows)

        mine = np.where(full, expected[n], 0.0)
        yield Link(f"share_{side}", f"liquid drawn from {side}", e.table, logged, mine, e.column("volume"), suspects,
                   marks=e.marks())  # fmt: skip


def volumes(e: Events, expected: Pair) -> Link:
    """Check that a bridge's volume equals what its sides give or receive; `expected` are the correct shares."""
    logged, i, j = e.column("volume"), e.column("share_i"), e.column("share_j")

    def suspects(rows: Floats) -> Iterator[Suspect]:
        yield Suspect("the volume is drawn twice", np.where(e.formation, 2.0 * (i + j), i + j))
        yield Suspect("the share of j is left out", i)
        yield Suspect("the share of i is left out", j)
        yield from factor(logged, i + j, rows)

    return Link("volume", "volume of a bridge against its shares", e.table, logged, i + j, i + j, suspects,
                excuses=(expected[0] + expected[1],), marks=e.marks())  # fmt: skip


def ratios(run: Run, e: Events, tables: Tables, star: Floats, turned: bool = False) -> Floats:
    """Return T_i of each event by the logged table, at V* = `star`; `turned`: of j relative to i."""
    kind, type_i, other, _ = of_bridges(e.table, e.pair.volume, run)
    if turned:
        type_i, other = np.where(e.pair.wall, type_i, other), np.where(e.pair.wall, other, type_i)
    return tables.ratios(kind, type_i, other, star)


def sharing(run: Run, e: Events, tables: Tables) -> Iterator[Link]:
    """Return the volumes that both sides receive at rupture: T V and the rest."""
    volume, back = e.column("volume"), ~e.formation
    r = laws.harmonic_radius(e.pair.ri, e.pair.rj, e.pair.wall)
    expected = ratios(run, e, tables, volume / r**3)
    changed = {
        "the transfer ratio is swapped (i gets what j should)": 1.0 - expected,
        "the transfer ratio is that of the turned pair": ratios(run, e, tables, volume / r**3, turned=True),
        "the liquid is shared half and half": np.full(len(expected), 0.5),
        "all liquid goes to i": np.ones(len(expected)),
        "all liquid goes to j": np.zeros(len(expected)),
        "the ratio is read at r_red in place of r_eff": ratios(run, e, tables, volume / (r / 2.0) ** 3),
        "the ratio is read at twice the radius": ratios(run, e, tables, volume / (r * 2.0) ** 3),
        "the ratio is read at the radius of i": ratios(run, e, tables, volume / e.pair.ri**3),
        "the ratio is read at the radius of j": ratios(run, e, tables, volume / e.pair.rj**3),
        "the ratio is read at the smallest volume of the table": ratios(run, e, tables, 0.0 * volume),
        "the ratio is that of twice the volume": ratios(run, e, tables, 2.0 * volume / r**3),
        "the liquid is shared by volume of the spheres": e.pair.ri**3 / (e.pair.ri**3 + e.pair.rj**3),
    }
    i, j = e.column("share_i"), e.column("share_j")
    for name, logged in (("share_i", i), ("share_j", j)):

        def of(t: Floats, name: str = name) -> Floats:
            return np.where(back, volume * (t if name == "share_i" else 1.0 - t), 0.0)

        def suspects(rows: Floats, name: str = name, logged: Floats = logged) -> Iterator[Suspect]:
            for fault, t in changed.items():
                yield Suspect(fault, of(t, name))
            yield Suspect(
                "it is not what i leaves of the volume",
                np.where(np.abs(i + j - volume) > 1e-9 * volume, logged, np.nan),
            )
            yield from factor(np.where(back, logged, 0.0), of(expected, name), rows)

        yield Link(name, f"liquid given back to {name[-1]}", e.table, np.where(back, logged, 0.0), of(expected), volume,
                   suspects, marks=e.marks())  # fmt: skip


def expected_shares(run: Run, e: Events, tables: Tables) -> Pair:
    """Return the shares of each event by the papers, from the films and volumes logged with it."""
    volume = e.column("volume")
    given = granted(e, asked(e)) if coverage.known(run, "formation") else (e.column("share_i"), e.column("share_j"))
    r = laws.harmonic_radius(e.pair.ri, e.pair.rj, e.pair.wall)
    back = volume * ratios(run, e, tables, volume / r**3)
    return np.where(e.formation, given[0], back), np.where(e.formation, given[1], volume - back)


def links(run: Run, e: Events, tables: Tables, expected: Pair, table_holds: bool) -> Iterator[Link]:
    """Yield all equations of the events, causes before consequences; with a wrong table no shares can be judged."""
    if len(e.table):
        yield from links_chain.life(run)
        if coverage.known(run, "formation"):
            yield from draws(e)
        yield volumes(e, expected)
        if table_holds:
            yield from sharing(run, e, tables)
        found = (
            static(run, e, expected[0] + expected[1]),
            due(run, e),
            overdue(run, e),
            links_formations.early(run, e.marks()),
        )
        yield from (link for link in found if link is not None)
        yield links_formations.late(run, e.marks())
        yield from (link for link in (links_formations.shared(run),) if link is not None)
    yield from links_formations.missed(run)
    yield from links_chain.links(run, expected)
