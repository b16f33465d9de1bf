"""Replay a run directory and report the deviations of the engine from the papers' equations.

`python -m reference_impl RUN_DIR` prints the table, writes replay.json and exits with 1 if a tolerance is exceeded.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from reference_impl.diagnosis import diagnosis, faults, looked
from reference_impl.diagnosis import tables as of_tables
from reference_impl.motion import dynamics, window
from reference_impl.replay import (
    coverage,
    felt,
    io,
    liquid,
    nothing,
    retired,
    script,
    second,
    sections,
    spans,
    transfer,
    whole,
)
from reference_impl.replay.compare import Quantity
from reference_impl.shown import vtk


class Logged(NamedTuple):
    """Results from the logs of a run, and the diagnosis that names their faults."""

    quantities: list[Quantity]
    motion: dict[str, Any]
    """Entries returned by `dynamics.check`."""
    entries: dict[str, Any]
    named: Callable[[list[str]], dict[str, Any] | None]
    not_checked: Sequence[str] = ()


def replay(run_dir: Path, out: Path | None = None, functions: Mapping[str, str] | None = None) -> dict[str, Any]:
    """Recompute everything; returns and writes {ok, compared, quantities: {name: {count, largest, …}}, not_checked, notes, …}.

    `functions`: user reference implementations of custom laws, `path/to/file.py:function` by kind (`second.py`).
    For a dry run there are only Newton's law and contributions. Raises `io.ReplayError` if the run is incomplete.
    """
    started, cpu, folder = time.monotonic(), time.process_time(), Path(run_dir)
    with second.known(folder, functions or {}):
        run = None if _dry(folder) else io.read(folder)
        held = whole.check(folder)
        if run is not None:
            whole.inputs(run)
        looked = time.process_time() - cpu
        beside = sections.check(folder)
        logs = _of_dry(folder) if run is None else _of_moist(run, looked)
        seen, misshown = vtk.check(folder)
        quantities = [*logs.quantities, *seen]
        failed = [q.name for q in quantities if not q.ok]
        shares = dynamics.seen(run, held)
        result = {
            "ok": not failed,
            **logs.entries,
            "compared": held,
            "nothing_compared": nothing.compared(io.scene(folder), quantities, logs.motion, beside),
            "second": {} if run is None else dict(functions or {}),
            "not_checked": [
                *logs.not_checked,
                *dynamics.not_checked(logs.motion, held),
                *dynamics.beyond(shares),
                *nothing.without_record(quantities),
            ],
            "seen": shares,
            "notes": dynamics.notes(logs.motion),
            **logs.motion,
            "diagnosis": diagnosis.with_unexplained(vtk.with_findings(misshown, failed, logs.named), quantities),
            "wall_s": time.monotonic() - started,
            "cpu_s": time.process_time() - cpu,
            "peak_memory_B": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
            "quantities": {q.name: q.as_dict() for q in quantities},
        }
    sections.add(result, beside)
    io.clear()
    io.write_json(out or folder / "replay.json", result)
    return result


def _dry(folder: Path) -> bool:
    """Return whether a run is without bridges; raises for one of which nothing can be checked."""
    dry = not io.scene(folder)["effects"]["bridges"]
    if dry and not window.recorded(folder) and not sections.any_there(folder):
        raise io.ReplayError(
            f"{folder} is a dry run without history/window_states.parquet; expected a run with output.window_trajectories: "
            "run the case again"
        )
    return dry


def _of_dry(folder: Path) -> Logged:
    """Check Newton's law and the contributions of a dry run."""
    quantities, motion = dynamics.check(folder, None)
    quantities += retired.of_dry(folder)
    none = {"events": 0, "contacts": 0, "unchecked": [], "events_per_s": 0.0, "contacts_per_s": 0.0}

    def named(failed: list[str]) -> dict[str, Any]:
        links = [of_tables.walls(window.read(folder))] if "mesh_motion" in failed else []
        found = diagnosis.diagnose(iter(links), failed)
        motion = dynamics.named(folder, None, failed)
        return diagnosis.together(failed, motion, found) if motion else found

    return Logged(quantities, motion, none, named)


def _of_moist(run: io.Run, looked: float) -> Logged:
    """Replay liquid and forces as well; `looked`: processor time [s] of reading."""
    tables = transfer.Tables(run.table("transfer"))
    found = spans.go_through(run, tables)
    io.note("transfer ratios and motion")
    moved, motion = dynamics.check(run.folder, run, found.moved, found.of("between"))
    quantities = [
        *found.of("liquid"), *found.of("end"), liquid.ledger(run), *found.of("drops"), *felt.check(run), *_with_rows(run, found),
        *found.of("forces"), *transfer.check(run), *moved, *whole.counted(run),
        *(q for group in ("trajectory", "tables", "energy") for q in found.of(group)),
    ]  # fmt: skip
    entries = {
        "events": found.events,
        "contacts": found.contacts,
        "unchecked": coverage.unchecked(run),
        "events_per_s": found.events / max(looked + found.seconds["events"], 1e-9),
        "contacts_per_s": found.contacts / max(found.seconds["contacts"], 1e-9),
    }

    def named(failed: list[str]) -> dict[str, Any]:
        return _named(run.folder, run, tables, found, failed)

    left = found.events - sum(q.count for q in moved if q.name == "event_speed")
    logged = [f"event_speed: of {left} of {found.events} events it is taken as logged, without recorded motion"] * (
        left > 0
    )
    return Logged(
        quantities, motion, entries, named, [*coverage.not_checked(run), *logged, *script.not_checked(run.folder)]
    )


def _with_rows(run: io.Run, found: spans.Found) -> list[Quantity]:
    """Return the comparisons of snapshots with logs; of those without a record only some, and none without events or drops."""
    optional, moved = ("formation_missed", "snapshot_volume", "snapshot_share"), found.events or len(run.shed)
    return [q for q in found.of("snapshots") if q.count or (moved and q.name not in optional)]


def _named(run_dir: Path, run: io.Run, tables: transfer.Tables, gone: spans.Found, failed: list[str]) -> dict[str, Any]:
    """Return the faults in the log, and those in the motion that do not follow from them."""
    io.note("which fault it is")
    events, contacts, where = looked.parts(run, gone)
    found = {**faults.find(events, contacts, tables, failed), "looked_at": where}
    beside = diagnosis.diagnose(of_tables.links(run, events, failed), failed)
    # bridges that share a position at an edge are a consequence of the closest points
    of_edges = "wall_closest_point" in failed and all(
        f["quantities"] == ["formation_shared"] for f in found["findings"]
    )
    first = of_edges or not found["findings"]
    of_motion = first or set(found["not_explained"]) & dynamics.MOTION
    motion = dynamics.named(run_dir, run, failed) if of_motion else None
    in_turn = (motion, found, beside) if first else (found, motion, beside)
    return diagnosis.together(failed, *(d for d in in_turn if d))


def table(result: dict[str, Any]) -> str:
    """Print the quantities of a replay as a table."""
    lines = [f"{'quantity':24s} {'count':>9s} {'largest':>9s} {'median':>9s} {'limit':>8s}"]
    for name, q in result["quantities"].items():
        marks = f"  sample of {q['sample_of']}" if q["sample_of"] is not None else ""
        marks += "" if q["ok"] else "  <-- beyond its limit"
        lines.append(f"{name:24s} {q['count']:9d} {q['largest']:9.1e} {q['median']:9.1e} {q['tolerance']:8.0e}{marks}")
    speed = (
        f"{result['wall_s']:.1f} s, {result['cpu_s']:.1f} s of the processor: {result['events']} events at "
        f"{result['events_per_s']:.3g} and {result['contacts']} contacts at {result['contacts_per_s']:.3g} per processor second"
    )
    missing = [f"nothing compared: {sentence}" for sentence in result["nothing_compared"]]
    missing += [f"not checked: {sentence}" for sentence in result["not_checked"]]
    held = whole.sentence(result["compared"])
    return "\n".join([*lines, held, *missing, speed, *result["notes"], *diagnosis.text(result["diagnosis"])])
