"""Faults of the tables next to the logs: positions of walls, times, counts, ends of bridges, works (see diagnosis.py).

Each is compared with the reference's value row by row, so that the same suspects apply: axes exchanged or reversed, a
factor, a shift, another row, another time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import combinations

import numpy as np
import pandas as pd

from reference_impl.diagnosis import between, retirement
from reference_impl.diagnosis import works as links_works
from reference_impl.diagnosis.diagnosis import Link, Suspect
from reference_impl.diagnosis.suspects import factor, gaps, middle
from reference_impl.motion import budget, nearest, wet, window
from reference_impl.motion.wall_motion import Motion
from reference_impl.motion.weight import carried
from reference_impl.replay import bridge_ends, felt, io, snapshots, stored_tables, whole
from reference_impl.replay.arrays import Floats, vectors
from reference_impl.replay.io import Run
from reference_impl.replay.lives import RUPTURE, Lives, none
from reference_impl.shown import exchanged

STEPS = 400
"""Number of steps before and after within which a shifted motion is sought."""
ROUGH = 0.05
"""Share of the displacement within which a motion between two steps counts as late."""


def links(run: Run, part: Run, failed: Sequence[str]) -> Iterator[Link]:
    """Diagnose the quantities of the stored tables that are beyond their limits."""
    setup, wrong = window.read(run.folder), set(failed)
    for names, make in (
        ({"mesh_motion"}, lambda: [walls(setup)]),
        ({"trajectory"}, lambda: list(places(part))),
        ({"trajectory_velocity"}, lambda: list(speeds(setup))),
        ({"ledger_counts", "ledger_held"}, lambda: list(ledger(run))),
        ({"event_triangle", "event_part"}, lambda: [triangles(part, "event")]),
        ({"snapshot_triangle"}, lambda: [triangles(part, "snapshot")]),
        ({"snapshot_ends", "snapshot_separation", "event_separation"}, lambda: list(ends(part))),
        ({"event_speed"}, lambda: [event_speeds(run, setup)]),
        ({"snapshot_beyond_limit"}, lambda: [outlived(part)]),
        ({f"between_{n}" for n in ("capillary", "drag", "momentum")}, lambda: list(between.links(run))),
        ({"flight_place", "flight_velocity"}, lambda: list(links_works.flight(run, setup))),
        ({f"energy_{n}" for n in (*budget.LIMITS,)}, lambda: list(links_works.works(run))),
        ({"felt_force", "felt_drops"}, lambda: list(felt_films(run))),
        ({"contact_rows"}, lambda: list(rows_missing(run))),
        ({"time"}, lambda: [times(run, setup)]),
        ({*retirement.FAULTS}, lambda: list(retirement.links(part))),
    ):
        if names & wrong:
            yield from (link for link in make() if link is not None and link.quantity in wrong)


def felt_films(run: Run) -> Iterator[Link]:
    """Yield the links of the forces felt by sampled films and of their drops."""
    table = io.table(io.where(run.folder, "felt"), "felt").sort_values(["id", "step"], ignore_index=True)
    expected = felt.recomputed(run, table)
    logged, scale = vectors(table, "felt"), np.maximum(np.linalg.norm(expected, axis=1), felt.STANDARD)
    fell, due = felt.drops(run, table, expected)
    for name, what, one, two, of in (
        ("felt_force", "force felt by a sampled film", logged, expected, scale),
        ("felt_drops", "drop of a sampled sphere", fell, due, np.maximum(np.maximum(due, fell), 1e-300)),
    ):

        def suspects(rows: Floats, one: Floats = one, two: Floats = two) -> Iterator[Suspect]:
            yield from factor(one, two, rows)

        yield Link(name, what, table.rename(columns={"id": "i"}), one, two, of, suspects)


def walls(setup: window.Setup) -> Link:
    """Diagnose the positions of the meshes at the outputs."""
    table, expected = stored_tables.wall_shifts(setup)
    logged, size = table[stored_tables.SHIFT].to_numpy(float), np.full(len(table), stored_tables.reach(setup))
    motion, names = Motion(setup), table["mesh"].to_numpy()
    last, step = round(setup.scene["duration_s"] / setup.step), table["step"].to_numpy(np.int64)
    mesh = pd.Index([w.name for w in setup.walls]).get_indexer(pd.Index(names))

    def at(mesh: Floats, step: Floats) -> Floats:
        found = np.zeros_like(expected)
        for n, wall in enumerate(setup.walls):
            found[mesh == n] = motion.shift(wall, step[mesh == n])
        return found

    def suspects(rows: Floats) -> Iterator[Suspect]:
        for by in sorted(range(-STEPS, STEPS + 1), key=abs)[1:]:
            then = at(mesh, np.clip(step - by, 0, last))
            if np.abs(then - logged)[rows].max() < 1e-9 * size[0]:
                yield Suspect(f"it is {abs(by)} steps {'late' if by > 0 else 'early'}", then, float(by))
        first = at(mesh, 0 * step + 1) - at(mesh, 0 * step)  # displacement in the first step
        ends = np.clip(step - 1, 0, last), np.clip(step + 1, 0, last)
        speed = (at(mesh, ends[1]) - at(mesh, ends[0])) / (ends[1] - ends[0])[:, None] - first
        with np.errstate(all="ignore"):
            late = middle((((expected - logged) * speed).sum(axis=1) / (speed**2).sum(axis=1))[rows])
        near = np.abs(expected - late * speed - logged).max(axis=1) <= ROUGH * abs(late) * np.abs(speed).max()
        words = f"it is about {abs(late):.3g} steps {'late' if late > 0 else 'early'}"
        yield Suspect(words, np.where(near[:, None], logged, np.nan), late)
        yield from exchanged.suspects(logged, expected, rows)
        yield from _one_axis(logged, expected, rows)
        for one, two in combinations(range(len(setup.walls)), 2):
            other = np.where(mesh == one, two, np.where(mesh == two, one, mesh))
            names_of = f"{setup.walls[one].name} and {setup.walls[two].name}"
            yield Suspect(f"the motions of {names_of} are exchanged", at(other, step))

    marks = {f"of {w.name}": names == w.name for w in setup.walls}
    return Link("mesh_motion", "place of a wall in mesh_motion", table, logged, expected, size, suspects, marks=marks)


def _one_axis(logged: Floats, expected: Floats, rows: Floats) -> Iterator[Suspect]:
    """Suspect a factor on one component: an amplitude."""
    for k, axis in enumerate("xyz"):
        with np.errstate(all="ignore"):
            f = middle((logged / expected)[rows][:, k])
        if np.isfinite(f) and abs(f - 1.0) > 1e-9:
            value = expected.copy()
            value[:, k] *= f
            yield Suspect(f"component {axis} is {f:.6g} times what it should be", value, f)


def times(run: Run, setup: window.Setup) -> Link:
    """Diagnose column `time` of every table against its steps."""
    rows = stored_tables.all_times(setup, True)
    logged, expected = rows["time"].to_numpy(float), rows["step"].to_numpy(float) * setup.step

    def suspects(broken: Floats) -> Iterator[Suspect]:
        yield Suspect("it is the number of the step", rows["step"].to_numpy(float))
        by = middle((logged - expected)[broken])
        yield Suspect(
            f"it is {abs(by):.6g} s {'late' if by > 0 else 'early'} ({by / setup.step:.6g} steps)", expected + by, by
        )
        yield from factor(logged, expected, broken)

    marks = {f"of {name}": (rows["table"] == name).to_numpy() for name in rows["table"].unique()}
    return Link(
        "time", "time of a row", rows, logged, expected, np.maximum(expected, setup.step), suspects, marks=marks
    )


def places(run: Run) -> Iterator[Link]:
    """Compare the trajectory with the bridges' snapshots."""
    mine = whole.places(run).drop_duplicates(["step", "id"])
    both = run.table("trajectory")[["step", "id", *"xyz"]].merge(mine, on=["step", "id"], suffixes=("", "_own"))
    logged, expected = (both[[f"{a}{end}" for a in "xyz"]].to_numpy(float) for end in ("", "_own"))
    outputs = np.unique(run.table("trajectory")["step"].to_numpy())

    def suspects(rows: Floats) -> Iterator[Suspect]:
        yield from exchanged.suspects(logged, expected, rows)
        for by, word in ((1, "after"), (-1, "before")):
            order = np.searchsorted(outputs, both["step"].to_numpy()) + by
            then = outputs[np.clip(order, 0, len(outputs) - 1)]
            other = both[["id"]].assign(step=then).merge(mine, on=["step", "id"], how="left")[[*"xyz"]].to_numpy(float)
            yield Suspect(f"it is that of the output {word}", np.where(np.isnan(other), logged, other))

    size = np.maximum(np.abs(expected).max(axis=1, initial=0.0), 1e-3)
    yield Link("trajectory", "place in the trajectory", both, logged, expected, size, suspects)


def speeds(setup: window.Setup) -> Iterator[Link]:
    """Diagnose speeds and spins of the trajectory."""
    both, logged, expected = stored_tables.both_velocities(setup)
    for n, what in ((0, "speed"), (3, "spin")):
        columns = slice(n, n + 3)

        def suspects(rows: Floats, columns: slice = columns) -> Iterator[Suspect]:
            yield from exchanged.suspects(logged[:, columns], expected[:, columns], rows)
            yield Suspect("speed and spin are exchanged", expected[:, 3 - columns.start : 6 - columns.start])

        size = np.maximum(np.abs(expected).max(axis=1), 1e-3)
        yield Link("trajectory_velocity", f"{what} in the trajectory", both, logged[:, columns], expected[:, columns], size,
                   suspects)  # fmt: skip


def ledger(run: Run) -> Iterator[Link]:
    """Diagnose counts, and the liquid of each kind of reservoir from the films, bridges and wall films of the snapshots."""
    table, (counts, recomputed_counts), (held, recomputed_held), size = stored_tables.Count(run).values(run)
    for names, logged, expected, quantity, what, scale, limit in (
        (
            stored_tables.COUNTED,
            counts,
            recomputed_counts,
            "ledger_counts",
            "count in the ledger:",
            np.ones(len(table)),
            0.0,
        ),
        (stored_tables.HELD, held, recomputed_held, "ledger_held", "liquid in the ledger:", size, 1e-12),
    ):
        yield from links_works.columns(table, logged, expected, names, quantity, what, scale, limit)


def triangles(run: Run, of: str) -> Link | None:
    """Compare the triangle of each bridge at a wall with the closest one; None without bridges at walls."""
    found = bridge_ends.of_events(run) if of == "event" else bridge_ends.of_snapshots(run)
    at = np.flatnonzero(found.wall)
    if not len(at):
        return None
    rows = found.table.iloc[at].reset_index(drop=True)
    parts, logged = nearest.parts(run), rows["triangle"].to_numpy(np.int64)
    part = rows["j"].to_numpy(np.int64)
    near = parts.closest(rows["step"].to_numpy(np.int64), found.xi[at], part).triangle
    right = np.abs(found.off[at]) <= 1e-9 * found.radius[at]
    expected = np.where(right, logged, near).astype(float)

    def suspects(_: Floats) -> Iterator[Suspect]:
        yield Suspect("it is the first triangle of the part", parts.order[parts.first[part]].astype(float))
        yield Suspect("it is the last triangle of the part", parts.order[parts.first[part + 1] - 1].astype(float))
        yield Suspect("it is the one at which the bridge formed", _formed_at(run, rows))
        yield Suspect("it is the next triangle", expected + 1.0)
        yield Suspect("it is the triangle before", expected - 1.0)
        other = parts.setup.part[logged] != part
        yield Suspect("it is one of another part", np.where(other, logged, -1.0))
        yield Suspect("it is not the closest of the part", np.where(other, -1.0, logged), general=True)

    marks = {"ruptures": (rows["kind"] == RUPTURE).to_numpy()} if "kind" in rows else {}
    what = "triangle that takes or gives liquid" if of == "event" else "triangle in a snapshot"
    size = np.ones(len(at))
    return Link(f"{of}_triangle", what, rows, logged.astype(float), expected, size, suspects, 1e-6, marks=marks,
                says=lambda _: "it is not the closest one")  # fmt: skip


def _formed_at(run: Run, rows: pd.DataFrame) -> Floats:
    events = run.table("events")
    formed = events[events["kind"] == 0][["step", "i", "j", "triangle", "partner_kind"]]
    asked = rows[["step", "i", "j", "partner_kind"]].assign(row=np.arange(len(rows))).sort_values("step")
    last = pd.merge_asof(asked, formed, on="step", by=["i", "j", "partner_kind"])
    return last.sort_values("row")["triangle"].fillna(-1).to_numpy(float)


def ends(run: Run) -> Iterator[Link]:
    """Diagnose gaps of events and snapshots, and the ends of bridges."""
    shots, events = bridge_ends.of_snapshots(run), bridge_ends.of_events(run)
    xj, xi = vectors(shots.table, "xj"), vectors(shots.table, "xi")

    def of_ends(rows: Floats) -> Iterator[Suspect]:
        yield Suspect("both ends are that of i", xi)
        yield Suspect("it is the surface of j, not its centre",
                      shots.xj + np.where(shots.wall, 0.0, shots.rj)[:, None] * shots.normal)  # fmt: skip
        yield from exchanged.suspects(xj, shots.xj, rows)

    walls = {"between spheres": ~shots.wall, "at walls": shots.wall}
    yield Link(
        "snapshot_ends", "end of a bridge in a snapshot", shots.table, xj, shots.xj, shots.radius, of_ends, marks=walls
    )
    for name, e in (("snapshot", shots), ("event", events)):
        logged = e.table["separation"].to_numpy(float)
        of_gaps = partial(gaps, logged, e.gap, e.radius, np.where(e.wall, 0.0, e.rj))
        marks = {"between spheres": ~e.wall, "at walls": e.wall}
        yield Link(f"{name}_separation", f"gap in {'a snapshot' if name == 'snapshot' else 'an event'}", e.table, logged, e.gap,
                   e.radius, of_gaps, marks=marks)  # fmt: skip


def event_speeds(run: Run, setup: window.Setup) -> Link:
    """Diagnose the speeds of formations and ruptures in the windows that recorded motion."""
    found = [wet.event_speeds(run, setup, w) for w in window.windows(setup, carried(run).at)]
    logged, expected, size = (np.concatenate([part[n] for part in found]) for n in range(3))
    rows = pd.concat([part[3] for part in found], ignore_index=True)
    marks = {"ruptures": (rows["kind"] == RUPTURE).to_numpy(), "formations": (rows["kind"] != RUPTURE).to_numpy()}
    return Link("event_speed", "speed of an event", rows, logged, expected, size, lambda broken: factor(logged, expected, broken),
                marks=marks)  # fmt: skip


def outlived(run: Run) -> Link:
    """Diagnose bridges at the outputs that should have ruptured."""
    rows, gap, limit = snapshots.outlived(run, Lives(none(), run.table("events"), 0, -1))
    wrong, one = (gap > limit * (1.0 + 1e-9)).astype(float), np.ones(len(rows))

    def suspects(broken: Floats) -> Iterator[Suspect]:
        ratio = float((gap / limit)[broken].max())
        yield Suspect(f"it is made too late (a bridge still exists at {ratio:.4g} of its largest limit)", wrong, ratio)

    return Link("snapshot_beyond_limit", "rupture", rows, wrong, 0.0 * one, one, suspects,
                says=lambda _: "a bridge still exists beyond its limit")  # fmt: skip


def rows_missing(run: Run) -> Iterator[Link]:
    """Diagnose bridges that act in a window but have no row in the contact log, and their location in the bed."""
    recorded = io.where(run.folder, "window_states").exists()  # otherwise the location of the bed is unknown
    table = stored_tables.bridges_in_windows(run) if recorded else pd.DataFrame()
    if not len(table):
        return
    lacking = table["missing"].to_numpy(float)
    one = np.ones(len(table))

    def suspects(rows: Floats) -> Iterator[Suspect]:
        for axis in "xyz":
            at = table[axis].to_numpy(float)
            low, high = at[rows], at[~rows]
            if len(high) and (low.max() < high.min() or low.min() > high.max()):
                side = "<" if low.max() < high.min() else ">"
                cut = 0.5 * (low.max() + high.min()) if side == "<" else 0.5 * (low.min() + high.max())
                yield Suspect(f"all rows of spheres at {axis} {side} {cut:.4g} m are missing, as of one rank", lacking)
        yield Suspect("rows are missing", lacking, general=True)

    wall = (table["partner_kind"] != 0).to_numpy()
    marks = {"between spheres": ~wall, "at walls": wall}
    yield Link("contact_rows", "contact log", table, lacking, 0.0 * one, one, suspects, 0.0, marks=marks,
               says=lambda _: "rows of active bridges are missing")  # fmt: skip
