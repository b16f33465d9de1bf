"""Commands `pywet replay` and `python -m reference_impl`: print one run as a table, several as a line each, or JSON.

Exit status: 0 if all agree (`in part` if a kind of quantity in the scene was not compared; a dry run has nothing that
could disagree), 1 if one exceeds a tolerance, 2 if one cannot be read.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from reference_impl.faults import Refused
from reference_impl.replay import io, plans, sections, whole
from reference_impl.replay.replay import replay, table

STATUS = {"agrees": 0, "in part": 0, "dry": 0, "disagrees": 1, "unreadable": 2}


def outcome(folder: Path, out: Path | None = None, functions: Mapping[str, str] | None = None) -> dict[str, Any]:
    """Return the content of replay.json with run_dir, status, and for an unreadable history the reason in one sentence."""
    where = {"run_dir": str(folder)}
    try:
        if not folder.is_dir():
            raise io.ReplayError(f"{folder} is no folder; expected the folder of a run")
        io.refuse_special(folder)
        forget(folder, out)
        if nothing_to_replay(folder):
            reason = f"{folder} is dry: it has no bridges and recorded no motion; {whole.sentence(whole.check(folder))}"
            return {**where, "status": "dry", "reason": reason}
        result = replay(folder, out, functions)
    except Refused as error:
        return {**where, "status": "unreadable", "reason": _shown(error)}
    agrees = "in part" if result["nothing_compared"] else "agrees"
    return {**where, "status": agrees if result["ok"] else "disagrees", "reason": None, **io.finite(result)}


def _shown(error: Refused) -> str:
    """Return a sentence without control characters, which a file may contain in the name of a column."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in str(error))[:2000]


def forget(folder: Path, out: Path | None = None) -> None:
    """Remove the result of an earlier replay, so that it is not mistaken for the new one."""
    if not ((folder / "scene.json").exists() or (folder / "history").exists()):
        return  # not a run: files with these names belong to the user
    for path in (out or folder / "replay.json", folder / "contributions.json"):
        path.unlink(missing_ok=True)


def nothing_to_replay(folder: Path) -> bool:
    """Return whether there is nothing to recompute: no bridges, no recorded motion, no configuration, no results."""
    planned = plans.plan(folder)
    return not planned.moist and not planned.recorded and not sections.any_there(folder)


def line(found: dict[str, Any], width: int) -> str:
    """Summarise the replay of one run in one line."""
    start = f"{found['run_dir']:{width}s}  {found['status']:10s}"
    if found["reason"]:
        return f"{start}  {found['reason']}"
    rows = found["quantities"]
    count = f"{found['events']:8d} events {found['contacts']:8d} contacts {found['wall_s']:6.1f} s"
    if found["ok"]:
        exact = max((q["largest"] for q in rows.values() if q["sample_of"] is None), default=0.0)
        return f"{start} {count}  largest deviation {exact:.1e}{_nothing(found)}"
    named = [f.get("known") or f["sentence"] for f in found["diagnosis"]["findings"]] or [
        f"beyond: {n}" for n, q in rows.items() if not q["ok"]
    ]
    return f"{start} {count}  {'; '.join(named)}"


def _nothing(found: dict[str, Any]) -> str:
    return "".join(f"; nothing compared: {sentence}" for sentence in found["nothing_compared"])


def run(
    folders: Sequence[Path],
    as_json: bool = False,
    out: Path | None = None,
    second: Callable[[Path], Mapping[str, str]] = lambda folder: {},
    left: Callable[[Path, str | None], None] = lambda folder, refusal: None,
) -> int:
    """Replay, print, and return the exit status; `second` returns the user reference implementations for custom laws of a run.

    `left` is given each run with the sentence by which it was refused, or None.
    """
    width, all_found = max(len(str(f)) for f in folders), []
    for folder in folders:
        found = outcome(Path(folder), out, second(Path(folder)))
        all_found.append(found)
        left(Path(folder), found["reason"] if found["status"] == "unreadable" else None)
        if not as_json and len(folders) > 1:
            print(line(found, width), flush=True)
    status = max(STATUS[found["status"]] for found in all_found)
    first = all_found[0]
    if as_json:
        print(json.dumps(first if len(folders) == 1 else all_found, indent=1, allow_nan=False))
    elif len(folders) == 1 and "quantities" in first:
        print(table(first))
    elif first["status"] == "dry" and len(folders) == 1:
        print(first["reason"])
    if status and len(folders) == 1:
        print(first["reason"] or _beyond(first), file=sys.stderr)
    return status


def _beyond(found: dict[str, Any]) -> str:
    """Return the sentence for the exit status 1."""
    bad = [name for name, q in found["quantities"].items() if not q["ok"]]
    return f"the replay disagrees on {', '.join(bad)}; its worst records are in replay.json"
