"""The effects study from runs to page; `pywet study effects` and the workflow call it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from pywet.errors import PywetError
from pywet.evidence.effects import runs, verdict
from pywet.evidence.effects.scenes import SCENES
from pywet.files import read_json, write_json

RUNS, PAGE, TABLE = "effects/runs", "effects.html", "effects/effects.json"


def record_path(out_dir: Path, scene: str, seed: int) -> Path:
    """All records of a scene with one seed."""
    return out_dir / RUNS / f"{scene}_{seed}.json"


def scene_records(out_dir: Path, scene: str, seed: int, size: float = 1.0) -> Path:
    """Run one scene with one seed and keep its records."""
    if scene not in SCENES:
        raise PywetError(f"the effects study has no scene {scene}; expected one of {', '.join(SCENES)}")
    path = record_path(out_dir, scene, seed)
    records = runs.run_all(scene, seed, size, out_dir / "effects/work", say=lambda text: print(text, flush=True))
    write_json(path, {"records": records})
    return path


def whole_study(out_dir: Path, seeds: int, size: float, only: str | None) -> list[str]:
    """The whole study on one core; returns what was found, a line for each scene."""
    names = [only] if only else list(SCENES)
    for name in names:
        for seed in range(seeds):
            if not record_path(out_dir, name, seed).exists():
                scene_records(out_dir, name, seed, size)
    return finish(out_dir, [record_path(out_dir, name, seed) for name in names for seed in range(seeds)])


def read(paths: list[Path]) -> dict[str, list[dict[str, Any]]]:
    """Scene -> its records."""
    found: dict[str, list[dict[str, Any]]] = {}
    for path in paths:
        for record in read_json(path, "remove it and run the study again", runs.Records)["records"]:
            found.setdefault(record["scene"], []).append(record)
    return {name: found[name] for name in SCENES if name in found}


def finish(out_dir: Path, paths: list[Path]) -> list[str]:
    """Judge, write the table and the page; returns one line for each scene."""
    from pywet.evidence.effects import page

    records = read(paths)
    judged = {name: verdict.choices(of) for name, of in records.items()}
    write_json(out_dir / TABLE, table(records, judged))
    page.write_page(out_dir / PAGE, records, judged)
    return [*lines(records, judged), f"the page is {out_dir / PAGE}"]


def table(records: dict[str, list[dict[str, Any]]], judged: dict[str, list[verdict.Choice]]) -> dict[str, Any]:
    """The study's result as plain data."""
    scenes = {
        name: {"left_out": verdict.left_out(records[name]), "plan_right": verdict.planned(found).harmless,
               "choices": [_plain(c) for c in found]}
        for name, found in judged.items()
    }  # fmt: skip
    return {"tolerance": runs.TOLERANCE, "scenes": scenes, "added": verdict.costs(judged)}


def _plain(c: verdict.Choice) -> dict[str, Any]:
    timed = not math.isnan(c.saving)
    return {
        "variant": c.variant, "quantity": c.worst.quantity, "change": c.worst.change, "spread": c.worst.spread,
        "harmless": c.harmless, "saving": c.saving if timed else None, "saving_spread": c.saving_spread if timed else None,
        "cpu_s_everything": c.cpu_s[0], "cpu_s": c.cpu_s[1],
    }  # fmt: skip


def lines(records: dict[str, list[dict[str, Any]]], judged: dict[str, list[verdict.Choice]]) -> list[str]:
    """One line for each scene."""
    found = []
    for name, choices in judged.items():
        plan = verdict.planned(choices)
        out, worst = ", ".join(verdict.left_out(records[name])) or "nothing", plan.worst
        found.append(
            f"{name:<14}leaves out {out}: {'right' if plan.harmless else 'WRONG'}, largest change {100 * worst.change:+.2f} % "
            f"(spread {100 * worst.spread:.2f} %) of {worst.quantity}, {plan.cpu_s[0]:.1f} -> {plan.cpu_s[1]:.1f} s"
        )
    return found
