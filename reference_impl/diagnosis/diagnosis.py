"""Name the fault behind a replay that disagrees.

Every equation of the log is a `Link`: the logged value, and the value by the papers from the *other logged values of
the same record*, so that one fault violates one link but not its consequences. For a violated link the reference's
formula is evaluated with one part changed at a time (a `Suspect`): the change that brings the records back within
tolerance is named, with its location, first step, number of records explained, and the second best. Links and
suspects: contacts.py, liquid.py …
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.diagnosis.residual import described, listed
from reference_impl.replay.arrays import Floats
from reference_impl.replay.compare import Quantity, plain

MATCH = 1e-9
"""Deviation within which values agree by default."""
BITWISE = 1e-12
"""Deviation within which a changed formula counts as the one used, for a link with zero tolerance."""
ROUNDS = 3
"""Largest number of faults sought in one link, each in the records that the earlier ones do not explain."""
LEAST = 0.5
"""Share of a link's violated records that a suspect must explain to be named; below it the link counts as not explained."""
TINY = 1e-300
NOTHING = np.zeros(0)
KINDS = ("between spheres", "at large walls", "at wires", "at walls")
"""Kinds of contact, in the order of `partner_kind`; where nothing tells walls from wires both are `at walls`."""


@dataclass(frozen=True)
class Suspect:
    """A fault, and the values that would have been logged with it."""

    fault: str
    value: Floats
    number: float | None = None
    """Factor or amount estimated from the records."""
    per: str = ""
    """Meaning of the number, printed with it."""
    general: bool = False
    """Whether it describes a deviation without its cause; named only if nothing else explains as much."""


@dataclass(frozen=True)
class Link:
    """One equation of the log; arrays run over the rows of `table`."""

    quantity: str
    what: str
    table: pd.DataFrame
    logged: Floats
    expected: Floats
    size: Floats
    suspects: Callable[[Floats], Iterator[Suspect]]
    """Function of the violated records (a mask) that yields the changed formulas, in the order in which ties are decided."""
    tolerance: float = MATCH
    excuses: tuple[Floats, ...] = ()
    """Values that are accepted too, because they follow from another violated link."""
    marks: dict[str, Floats] = field(default_factory=dict)
    """Named groups of records, for the location of a fault."""
    since: int = -1
    """Records up to this step are not judged: they are there because others follow from them."""
    terms: dict[str, Floats] = field(default_factory=dict)
    """Parts of the expected value by name: residuals may follow one of them."""
    says: Callable[[Floats], str] | None = None
    """Function that describes the residuals of violated records, if more is known than a factor between two values."""


@dataclass(frozen=True)
class Finding:
    """One named fault (or a link that nothing explains: `fault` is None)."""

    quantities: tuple[str, ...]
    what: str
    fault: str | None
    number: float | None
    where: str
    since: str
    first: dict[str, Any]
    explained: int
    broken: int
    records: int
    tried: int
    next_best: tuple[str, float] | None
    alike: tuple[str, ...] = ()
    """Other faults that explain all that this one explains: these records cannot distinguish them."""
    per: str = ""
    seen: str = ""
    """Description of the residuals themselves."""

    @property
    def known(self) -> str:
        """Describe the residuals: which force, at which kind of contact, since which step, by which factor."""
        return f"{self.what} ({self.where}, {self.since}): {self.seen}"

    @property
    def sentence(self) -> str:
        """Describe the fault: quantity, location, first step, certainty and alternatives; for an unknown fault the residuals."""
        what = f"{self.what}: {self.fault or self.seen}"
        what += f" ({self.number:+.3g} {self.per})" if self.per and self.number is not None else ""
        share = f"explains {self.explained} of {self.broken} records that disagree"
        if not self.fault:
            share = f"{self.broken} of {self.records} records disagree; cause not among the {self.tried} faults tried"
        place = f"{self.where}, {self.since}; {share}"
        if self.alike:
            return f"{what} ({place}; cannot be distinguished from: {', or '.join(self.alike)})"
        if self.next_best is None:
            return f"{what} ({place})"
        name, part = self.next_best
        return f"{what} ({place}; next best: {name}, {100.0 * part:.3g} %)"

    def as_dict(self) -> dict[str, Any]:
        """Convert the diagnosis to plain data for replay.json."""
        other = None if self.next_best is None else {"fault": self.next_best[0], "share": self.next_best[1]}
        return {
            "known": self.known, "sentence": self.sentence, "what": self.what, "quantities": list(self.quantities),
            "fault": self.fault,
            "number": self.number,
            "where": self.where, "since": self.since, "seen": self.seen, "first": self.first, "explained": self.explained,
            "disagree": self.broken, "records": self.records, "share": self.explained / max(self.broken, 1),
            "tried": self.tried, "next_best": other, "alike": list(self.alike), "consequences": [],
        }  # fmt: skip


def length(a: Floats) -> Floats:
    """Return the magnitude of each record's value, scalar or vector."""
    return np.abs(a) if a.ndim == 1 else np.sqrt((a**2).sum(axis=1))


def within(link: Link, value: Floats, tolerance: float) -> Floats:
    """Return the records in which a value agrees with the logged one."""
    with np.errstate(all="ignore"):
        difference = length(link.logged - value)
        allowed = tolerance * np.fmax(np.fmax(link.size, length(value)), TINY)
        return np.asarray((difference <= allowed) & np.isfinite(difference))


def broken(link: Link) -> Floats:
    """Return the records that disagree and do not follow from another link."""
    right = within(link, link.expected, link.tolerance)
    for value in link.excuses:
        if right.all():
            break
        right |= within(link, value, link.tolerance or BITWISE)
    return ~right & (link.table["step"].to_numpy() > link.since)


def kinds(link: Link, rows: Floats) -> dict[str, Floats]:
    """Kinds of contact that some of these records are of: name -> which of them; by the groups of the link or its columns."""
    marks, table = link.marks, link.table
    if not any(name in marks for name in KINDS):
        if "partner_kind" in table:
            marks = {name: (table["partner_kind"] == k).to_numpy() for k, name in enumerate(KINDS[:3])}
        elif "wall" in table:
            wall = table["wall"].to_numpy(bool)
            marks = {"between spheres": ~wall, "at walls": wall}
    names = KINDS[:3] if KINDS[1] in marks else KINDS
    return {name: marks[name][rows] for name in names if name in marks and (marks[name] & rows).any()}


def place(link: Link, rows: Floats) -> tuple[str, str]:
    """Return the smallest named group that contains all rows, and the first step with its bodies, as text."""
    where, group = "everywhere", np.ones(len(rows), dtype=bool)
    for name, mark in link.marks.items():
        if (mark | ~rows).all() and mark.sum() < group.sum():
            where, group = name, mark
    if not any(kind in where for kind in ("between", "at ")) and (of := kinds(link, rows)):
        where = f"{where} {listed(of)}".removeprefix("everywhere ")
    steps, first = link.table["step"].to_numpy(), int(np.argmax(rows))
    later = group & (steps >= steps[first])
    row = link.table.iloc[first]
    who = ", ".join(f"{k} {int(row[k])}" for k in ("i", "j", "reservoir") if k in row.index)
    if (rows == group).all():
        since = "in every record"
    elif rows.sum() == 1:
        since = f"in one record at step {int(steps[first])} ({who})"
    elif (rows == later).all():
        since = f"in every record since step {int(steps[first])}"
    else:
        since = f"in {int(rows.sum())} of {int(group.sum())} records, the first at step {int(steps[first])} ({who})"
        last = int(steps[rows].max())
        since += f", the last at step {last}" if last < steps[group].max() else ""
    return where, since


def judge(link: Link) -> list[Finding]:
    """Return the faults of one link, starting with those that explain most; empty if it is satisfied."""
    rest = broken(link)
    findings: list[Finding] = []
    while rest.any() and len(findings) < ROUNDS:
        # only the records that each suspect explains are stored, because its values take too much memory
        tried = [
            (within(link, s.value, link.tolerance or BITWISE) & rest, replace(s, value=NOTHING))
            for s in link.suspects(rest)
        ]
        tried.sort(key=lambda t: (int(t[0].sum()), not t[1].general), reverse=True)
        named = bool(tried) and tried[0][0].sum() >= LEAST * rest.sum()
        findings.append(_finding(link, rest, tried, named))
        if not named:
            break
        rest = rest & ~tried[0][0]
    return findings


def _finding(link: Link, rest: Floats, tried: list[tuple[Floats, Suspect]], named: bool) -> Finding:
    best, rows = (tried[0][1], tried[0][0]) if named else (Suspect("", NOTHING), rest)
    others = [(s.fault, float(ok.sum() / rest.sum())) for ok, s in tried[int(named) :] if not s.general and ok.any()]
    alike = (
        [s.fault for ok, s in tried[1:] if not s.general and (ok | ~rows).all()] if named and not best.general else []
    )
    where, since = place(link, rows)
    return Finding(
        quantities=(link.quantity,), what=link.what, fault=best.fault or None, per=best.per, number=best.number, where=where,
        since=since, first=plain(link.table.iloc[int(np.argmax(rows))]), explained=int(rows.sum()) if named else 0,
        broken=int(rest.sum()), records=len(rest), tried=len(tried), next_best=others[0] if others else None,
        alike=tuple(dict.fromkeys(name for name in alike if name != best.fault)),
        seen=link.says(rows) if link.says else described(
            link.logged[rows], link.expected[rows], link.table[rows], {n: term[rows] for n, term in link.terms.items()},
            kinds(link, rows)),
    )  # fmt: skip


def _digits(number: float | None) -> float | None:
    """Round a number to the digits that round-off leaves, so that equal ones are equal."""
    return None if number is None else float(f"{number:.9g}")


def joined(findings: list[Finding]) -> list[Finding]:
    """Join findings with the same fault in several links, led by the first."""
    found: dict[tuple[str, float | None], Finding] = {}
    for n, f in enumerate(findings):
        key = (f.fault or f"?{n}", None if f.per or f.number is None else f.number)
        if key not in found:
            found[key] = f
            continue
        a = found[key]
        found[key] = replace(
            a, quantities=(*a.quantities, *f.quantities), what=a.what if f.what in a.what else f"{a.what} and {f.what}",
            number=f.number if a.number is None else a.number, per=a.per or f.per,
            where=_both(a.where, f.where), explained=a.explained + f.explained,
            broken=a.broken + f.broken, records=a.records + f.records, tried=max(a.tried, f.tried),
            next_best=a.next_best or f.next_best, alike=tuple(n for n in a.alike if n in f.alike),
        )  # fmt: skip
    return list(found.values())


def _both(one: str, two: str) -> str:
    """Where two links are broken: at the kinds of contact of either, if both have some."""
    if one == two:
        return one
    of = [kind for kind in KINDS if kind in one or kind in two]
    return listed(of) if all(any(kind in where for kind in KINDS) for where in (one, two)) else "everywhere"


def liquid_constants(findings: list[Finding]) -> list[Finding]:
    """Join factors on several terms that one wrong viscosity or surface tension would explain."""
    factors = {q: f.number for f in findings for q in f.quantities if f.number is not None}
    viscous, pull = factors.get("viscous_law"), factors.get("capillary")
    dynamic = factors.get("rupture_limit", 1.0)
    cause, of = "", set()
    if viscous and viscous == factors.get("viscous_tangential") and np.isclose(dynamic, viscous, rtol=1e-4):
        cause, of = f"the viscosity is {viscous:.6g} times what it should be", {"viscous_law", "viscous_tangential"}
    elif pull and np.isclose(dynamic, 1.0 / pull, rtol=1e-4):
        cause, of = f"the surface tension is {pull:.6g} times what it should be", {"capillary"}
    of |= {"rupture_limit"}
    rest = [f for f in findings if not of & set(f.quantities)]
    number = viscous if "viscosity" in cause else pull
    same = [replace(f, fault=cause, number=number) for f in findings if of & set(f.quantities)]
    return [*joined(same), *rest] if cause else findings


def diagnose(links: Iterator[Link], failed: list[str]) -> dict[str, Any]:
    """Name the faults of a run; `failed`: quantities beyond their limits, with mere consequences listed separately."""
    with np.errstate(all="ignore"):
        found = [finding for link in links for finding in judge(link)]
    result = liquid_constants(joined([replace(f, number=_digits(f.number)) for f in found]))
    return _with_rest(failed, [f.as_dict() for f in result])


def _with_rest(failed: list[str], findings: list[dict[str, Any]]) -> dict[str, Any]:
    """Split the quantities that no finding contains: consequences of the findings, and what they do not explain."""
    named = {q for f in findings for q in f["quantities"]}
    rest = [name for name in failed if name not in named]
    follow = [name for name in rest if named & SHOW_AGAIN.get(name, named)]
    return {"findings": findings, "follow": follow, "not_explained": [name for name in rest if name not in follow]}


OF_FORCES = {
    "separation", "contact_volume", "capillary", "viscous_law", "viscous_normal", "factor_normal", "factor_tangential",
    "viscous_tangential", "force", "torque_i", "torque_j", "newton_force", "newton_torque", "wall_closest_point",
}  # fmt: skip
OF_EVENTS = {
    "bridge_life", "volume", "share_i", "share_j", "film_before", "film_after", "rupture_distance", "rupture_due", "rupture_late",
    "formation_due", "formation_late", "formation_missed", "formation_shared", "rupture_limit", "standing_beyond_limit",
    "transfer_table", "ledger",
}  # fmt: skip
OF_MOTION = {"newton_force", "newton_torque"}
OF_LIMITS = {"rupture_limit", "rupture_distance", "separation", "contact_volume"}
OF_BOTH = OF_FORCES | OF_EVENTS
OF_COUNTS = OF_EVENTS | {"separation"}
SHOW_AGAIN = {
    "standing_beyond_limit": OF_LIMITS, "formation_late": {"event_speed"},
    "snapshot_beyond_limit": OF_COUNTS | {"snapshot_separation", "snapshot_ends", "trajectory_velocity"},
    **{name: OF_LIMITS | {"event_speed"} for name in ("rupture_due", "rupture_late")},
    **{name: OF_BOTH for name in ("flight_place", "flight_velocity", "between_momentum")},
    "energy_windows": OF_BOTH | {"contact_spring", "contact_logged"},
    "between_capillary": OF_BOTH, "between_drag": OF_BOTH,
    **{name: OF_COUNTS for name in (
        "ledger_counts", "contact_rows", "event_triangle", "event_separation", "snapshot_triangle", "snapshot_separation")},
    **{name: OF_COUNTS | {"capillary"} for name in ("energy_formed", "energy_ruptured")},
    "energy_capillary_stored": OF_COUNTS | {"capillary", "snapshot_separation", "snapshot_volume"},
    "snapshot_ends": OF_COUNTS - {"formation_shared"},  # which tells what is one place by where these are
    "formation_shared": {"wall_closest_point", "snapshot_ends"},
    "ledger_held": OF_EVENTS | {"snapshot_films", "snapshot_wall_films", "retired_film"},
    **{name: OF_EVENTS | {"snapshot_films"} for name in ("retired_film", "retired_events", "retired_bridges")},
    "energy_budget": OF_BOTH | {"energy_windows", "energy_kinetic", "energy_gravity", "energy_spin"},
    **{name: OF_FORCES - OF_MOTION | {"contact_spring", "contact_logged", "mesh_motion"} for name in OF_MOTION},
    **{name: {"mesh_motion"} for name in ("wall_closest_point", "contact_spring", "contact_logged")},
    "energy_capillary": OF_EVENTS | {
        "capillary", "energy_windows", "energy_formed", "energy_ruptured", "energy_capillary_stored"},
}  # fmt: skip
"""Quantity of ruptures, motion, works or counts -> quantities of whose faults it is a consequence."""


def together(failed: list[str], *diagnoses: dict[str, Any]) -> dict[str, Any]:
    """Join several diagnoses of one run: every finding, those that are consequences with their cause."""
    return {**diagnoses[0], **_with_rest(failed, _grouped([f for d in diagnoses for f in d["findings"]]))}


def _grouped(findings: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Group findings by cause, each with the sentences of its consequences."""
    expected = [{*f["quantities"]} for f in findings]
    shown = [[SHOW_AGAIN.get(q, set()) for q in f["quantities"]] for f in findings]
    fits = [[all(o & names for o in of) for names in expected] for of in shown]
    causes = []
    for n, finding in enumerate(findings):
        first = n
        for _ in findings:  # follow a finding that repeats another one to its origin
            first = next((k for k, fit in enumerate(fits[first]) if fit and k != first), first)
        if first == n:
            causes.append(finding)
            continue
        cause = findings[first]
        cause["consequences"] = [*cause["consequences"], finding["sentence"]]
        cause["quantities"] = [*dict.fromkeys([*cause["quantities"], *finding["quantities"]])]
    return causes


def with_unexplained(found: dict[str, Any] | None, quantities: Sequence[Quantity]) -> dict[str, Any] | None:
    """Add findings for the quantities that no equation of the diagnosis speaks of: those that are beyond their limits first."""
    if found and (bad := [q for q in quantities if q.name in found["not_explained"]]):
        start = min((q.first for q in bad if q.first is not None), default=None)
        causes = [q for q in bad if q.first == start]
        found["findings"] += [_of_worst(q) for q in causes]
        found["follow"] = [*found["follow"], *(q.name for q in bad if q not in causes)]
        found["not_explained"] = [q.name for q in causes]
    return found


def _of_worst(q: Quantity) -> dict[str, Any]:
    """What the worst record of a quantity says."""
    row = q.worst
    kind = row.get("wall", row.get("partner_kind"))
    where = "everywhere" if kind is None else "at walls" if kind else "between spheres"
    who = "".join(f", {k} {row[k]}" for k in ("i", "j", "id", "triangle") if k in row)
    since = "in the whole run" if q.first is None else f"since step {q.first}"
    given, wanted = (
        np.array2string(np.array(row.get(n, np.nan), dtype=float), precision=4) for n in ("logged", "reference")
    )
    seen = f"it is {given} where {wanted} is expected (worst of {q.count} records: step {row.get('step')}{who})"
    finding = Finding((q.name,), q.name, None, None, where, since, row, 0, 0, q.count, 0, None, seen=seen)
    return {**finding.as_dict(), "known": "", "sentence": finding.known}


def text(diagnosis: dict[str, Any] | None) -> list[str]:
    """Return the lines to print under the table; none if all agrees."""
    if diagnosis is None:
        return []
    lines = []
    for f in diagnosis["findings"]:
        known = f.get("known")
        lines += [f"fault: {known}", f"  suspect: {f['sentence']}"] if known else [f"fault: {f['sentence']}"]
        lines += [f"  shows again: {sentence}" for sentence in f.get("consequences", [])]
    lines += [diagnosis["looked_at"]] if diagnosis.get("looked_at") else []
    if diagnosis["follow"]:
        lines.append(f"beyond their limits as well, probably as a consequence: {', '.join(diagnosis['follow'])}")
    if diagnosis["not_explained"]:
        lines.append(f"no known fault explains {', '.join(diagnosis['not_explained'])}")
    return lines
