"""Replays a run directory and says how far the engine and the papers' equations are apart.

`python -m reference_impl RUN_DIR` prints the table, writes replay.json and exits with 1 when a tolerance is exceeded.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from reference_impl.diagnosis import diagnosis, faults, kept, looked
from reference_impl.motion import dynamics, window
from reference_impl.replay import coverage, io, liquid, second, sections, spans, transfer, whole
from reference_impl.replay.compare import Quantity
from reference_impl.shown import vtk


def replay(run_dir: Path, out: Path | None = None, functions: Mapping[str, str] | None = None) -> dict[str, Any]:
    """Recompute everything; returns and writes {ok, compared, quantities: {name: {count, largest, …}}, not_checked, notes, …}.

    `functions`: the user's second functions for laws of the user's own, `path/to/file.py:function` by kind (`second.py`).
    Raises `io.ReplayError` where the run is not whole.
    """
    if window.is_dry(Path(run_dir)):
        return dynamics.replay_dry(Path(run_dir), out)
    with second.known(Path(run_dir), functions or {}):
        return _replay(run_dir, out, functions or {})


def _replay(run_dir: Path, out: Path | None, functions: Mapping[str, str]) -> dict[str, Any]:
    """The replay of a moist run, with all laws known that can be."""
    started, cpu = time.monotonic(), time.process_time()
    run = io.read(Path(run_dir))
    held = whole.check(Path(run_dir))
    whole.inputs(run)
    tables = transfer.Tables(run.table("transfer"))
    looked = time.process_time() - cpu
    beside = sections.check(Path(run_dir))
    found = spans.go_through(run, tables)
    io.note("transfer ratios and motion")
    moved, more = dynamics.check(Path(run_dir), run, found.moved, found.of("between"))
    seen, misshown = vtk.check(Path(run_dir))
    quantities = [
        *found.of("liquid"), *found.of("end"), liquid.ledger(run), *found.of("drops"), *_with_rows(run, found),
        *found.of("forces"), *transfer.check(run), *moved, *whole.counted(run),
        *(q for group in ("trajectory", "tables", "energy") for q in found.of(group)), *seen,
    ]  # fmt: skip
    failed = [q.name for q in quantities if not q.ok]
    result = {
        "ok": not failed,
        "events": found.events,
        "contacts": found.contacts,
        "compared": held,
        "unchecked": coverage.unchecked(run),
        "second": dict(functions),
        "not_checked": [*coverage.not_checked(run), *dynamics.not_checked(more, held), *vtk.not_checked(Path(run_dir))],
        "notes": dynamics.notes(more),
        **more,
        "diagnosis": vtk.with_findings(misshown, failed, lambda rest: _named(Path(run_dir), run, tables, found, rest)),
        "wall_s": time.monotonic() - started,
        "cpu_s": time.process_time() - cpu,
        "peak_memory_B": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
        "events_per_s": found.events / max(looked + found.seconds["events"], 1e-9),
        "contacts_per_s": found.contacts / max(found.seconds["contacts"], 1e-9),
        "quantities": {q.name: q.as_dict() for q in quantities},
    }
    sections.add(result, beside)
    io.clear()
    io.write_json(out or Path(run_dir) / "replay.json", result)
    return result


def _with_rows(run: io.Run, found: spans.Found) -> list[Quantity]:
    """What the snapshots say against the logs: nothing without events or drops, nor where there is nothing to compare."""
    optional, moved = ("formation_missed", "snapshot_volume", "snapshot_share"), found.events or len(run.shed)
    return [q for q in found.of("snapshots") if moved and (q.count or q.name not in optional)]


def _named(run_dir: Path, run: io.Run, tables: transfer.Tables, gone: spans.Found, failed: list[str]) -> dict[str, Any]:
    """The faults in the log; where it holds, those in the motion."""
    io.note("which fault it is")
    events, contacts, where = looked.parts(run, gone)
    found = {**faults.find(events, contacts, tables, failed), "looked_at": where}
    beside = diagnosis.diagnose(kept.links(run, failed), failed)
    if not found["findings"]:
        found = dynamics.named(run_dir, run, failed) or found
    return diagnosis.together(failed, found, beside)


def table(result: dict[str, Any]) -> str:
    """The result as text."""
    lines = [f"{'quantity':24s} {'count':>9s} {'largest':>9s} {'median':>9s} {'limit':>8s}"]
    for name, q in result["quantities"].items():
        marks = f"  sample of {q['sample_of']}" if q["sample_of"] is not None else ""
        marks += "" if q["ok"] else "  <-- beyond its limit"
        lines.append(f"{name:24s} {q['count']:9d} {q['largest']:9.1e} {q['median']:9.1e} {q['tolerance']:8.0e}{marks}")
    speed = (
        f"{result['wall_s']:.1f} s, {result['cpu_s']:.1f} s of the processor: {result['events']} events at "
        f"{result['events_per_s']:.3g} and {result['contacts']} contacts at {result['contacts_per_s']:.3g} per processor second"
    )
    missing = [f"not checked: {sentence}" for sentence in result["not_checked"]]
    held = whole.said(result["compared"])
    return "\n".join([*lines, held, *missing, speed, *result["notes"], *diagnosis.text(result["diagnosis"])])
