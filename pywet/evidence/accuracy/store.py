"""The study's result as one small table: prices and errors of every level, with where they come from."""

from __future__ import annotations

import datetime
from collections.abc import Iterable
from pathlib import Path
from statistics import median
from typing import Any

from pywet.errors import PywetError
from pywet.evidence.accuracy import choice, errors, knobs, runs, sieve
from pywet.files import read_json, write_json
from pywet.runs.summary import versions


def table(kept: Iterable[errors.Kept], size: str) -> dict[str, Any]:
    """Prices and errors by knob and level."""
    kept = list(kept)
    found, paid = errors.errors(kept, size), errors.prices(kept, size)
    failed = {(r["scene"], r["knob"], r["level"]): r["failed"] for r in kept if r["failed"]}
    rows: dict[str, list[dict[str, Any]]] = {}
    for name, knob in knobs.KNOBS.items():
        for level in knob.levels(size):
            own = [p for p in paid if (p.knob, p.level) == (name, level)]
            rows.setdefault(name, []).append(
                {
                    "level": level,
                    "price": {p.scene: {"ratio": p.ratio, "low": p.low, "high": p.high} for p in own},
                    "errors": [
                        {
                            "scene": e.scene,
                            "quantity": e.quantity,
                            "group": e.group,
                            "value": e.value,
                            "limit": e.limit,
                            "family": e.family,
                            "seeds": e.seeds,
                        }
                        for e in found
                        if (e.knob, e.level) == (name, level)
                    ],
                    "failed": sorted({f"{s}: {why}" for (s, k, v), why in failed.items() if (k, v) == (name, level)}),
                }
            )
    return {
        "provenance": provenance(kept, size),
        "default": knobs.default(size).as_dict(),
        "knobs": rows,
        "habit": {"exact_start": exact_start(kept)},
        "spread_over_seeds": spread(kept),
    }


def exact_start(kept: list[errors.Kept]) -> float:
    """Start of a moist run with the exact bridge's laws over that of the default, in the same rounds."""
    begun = {
        (r["knob"], r["level"], r["seed"]): r["cpu_s"] - r["loop_cpu_s"]
        for r in kept
        if r["scene"] == "moist" and not r["failed"]
    }
    ratios = [
        begun["capillary", "exact", seed] / begun["default", None, seed]
        for knob, level, seed in begun
        if (knob, level) == ("capillary", "exact") and ("default", None, seed) in begun
    ]
    return median(ratios) if ratios else 1.0


def provenance(kept: list[errors.Kept], size: str) -> dict[str, Any]:
    """How the table was made."""
    shape = sieve.SIZES[size]
    timed = [r for r in kept if r.get("cpu_s")]
    return {
        "made_by": f"pywet study accuracy --size {size} --store",
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "size": size,
        "scale": shape.scale,
        "seeds": shape.seeds,
        "dry_seeds": shape.dry_seeds or shape.seeds,
        "runs": len(kept),
        "processor_time_s": round(sum(r["cpu_s"] for r in timed), 1),
        "wall_over_processor_time": round(
            sum(r["wall_s"] for r in timed) / max(sum(r["cpu_s"] for r in timed), 1e-9), 2
        ),
        "machine": runs.machine(),
        "versions": versions(),
    }


def spread(kept: list[errors.Kept]) -> dict[str, dict[str, list[float]]]:
    """Scene -> quantity -> values of the default over the seeds."""
    found: dict[str, dict[str, list[float]]] = {}
    for run in kept:
        if run["knob"] == "default" and not run["failed"]:
            for name, value in run["quantities"].items():
                if not name.startswith("check_"):
                    found.setdefault(run["scene"], {}).setdefault(name, []).append(value)
    return found


def write(result: dict[str, Any], path: Path = choice.STORED) -> Path:
    """Put a study's table into the stored one, in the place of its scale."""
    try:
        whole = read_json(path, shape=dict[str, dict[str, Any]])
    except PywetError:  # none yet
        whole = {"scales": {}}
    whole["scales"][result["provenance"]["scale"]] = rounded(result)
    write_json(path, whole)
    choice.stored.cache_clear()
    return path


def rounded(value: Any) -> Any:
    """The same with numbers of five digits."""
    if isinstance(value, float):
        return float(f"{value:.5g}")
    if isinstance(value, dict):
        return {k: rounded(v) for k, v in value.items()}
    if isinstance(value, list):
        return [rounded(v) for v in value]
    return value
