"""The study's result as one small table: prices and errors of every level, with where they come from."""

from __future__ import annotations

import datetime
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pandas as pd

from pywet.errors import PywetError
from pywet.evidence.accuracy import choice, knobs, sieve
from pywet.evidence.accuracy import errors as of_runs
from pywet.evidence.accuracy.measure import machine
from pywet.evidence.study import write_rows
from pywet.files import read_json
from pywet.runs.summary import versions


def table(runs: pd.DataFrame, size: str) -> dict[str, Any]:
    """Prices and errors by knob and level."""
    errors, prices = of_runs.errors(runs, size), of_runs.prices(runs, size)
    failed = runs[runs["failed"].notna()]
    failed = failed.assign(said=failed["scene"] + ": " + failed["failed"].astype(str))
    said = ["scene", "quantity", "group", "value", "limit", "family", "seeds"]
    rows = {
        name: [
            {
                "level": level,
                "price": _of(prices, name, level).set_index("scene")[["ratio", "low", "high"]].to_dict("index"),
                "errors": _of(errors, name, level)[said].to_dict("records"),
                "failed": sorted(_of(failed, name, level)["said"].unique()),
            }
            for level in knob.levels(size)
        ]
        for name, knob in knobs.KNOBS.items()
    }
    return {
        "provenance": provenance(runs, size),
        "default": asdict(knobs.default(size)),
        "knobs": rows,
        "habit": {"exact_start": exact_start(runs)},
        "spread_over_seeds": spread(runs),
    }


def _of(table: pd.DataFrame, knob: str, level: knobs.Level) -> pd.DataFrame:
    return table[(table["knob"] == knob) & (table["level"] == level)]


def exact_start(runs: pd.DataFrame) -> float:
    """Start of a moist run with the exact bridge's laws over that of the default, in the same rounds."""
    moist = runs[(runs["scene"] == "moist") & runs["failed"].isna()].set_index("seed")
    start = moist["cpu_s"] - moist["loop_cpu_s"]
    ratios = start[(moist["knob"] == "capillary") & (moist["level"] == "exact")] / start[moist["knob"] == "default"]
    return float(ratios.median()) if ratios.notna().any() else 1.0


def provenance(runs: pd.DataFrame, size: str) -> dict[str, Any]:
    """How the table was made."""
    shape, of_run = sieve.SIZES[size], runs.drop_duplicates("run")
    cpu, wall = (float(of_run[clock].sum()) for clock in ("cpu_s", "wall_s"))
    return {
        "made_by": f"pywet study accuracy --size {size} --store",
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "size": size,
        "scale": shape.scale,
        "seeds": shape.seeds,
        "dry_seeds": shape.dry_seeds or shape.seeds,
        "runs": len(of_run),
        "processor_time_s": round(cpu, 1),
        "wall_over_processor_time": round(wall / max(cpu, 1e-9), 2),
        "machine": machine(),
        "versions": versions(),
    }


def spread(runs: pd.DataFrame) -> dict[str, dict[str, list[float]]]:
    """Scene -> quantity -> values of the default over the seeds."""
    default = runs[(runs["knob"] == "default") & runs["failed"].isna()]
    names = [q.name for q in of_runs.QUANTITIES if q.name in default and q.name != "restitution"]
    values = {scene: of[names].dropna(axis="columns") for scene, of in default.groupby("scene", sort=False)}
    return {str(scene): of.to_dict("list") for scene, of in values.items() if len(of.columns)}  # type: ignore[misc]


def store(result: dict[str, Any], path: Path = choice.STORED) -> Path:
    """Put a study's table into the stored one, in the place of its scale."""
    try:
        whole = read_json(path, shape=dict[str, dict[str, Any]])
    except PywetError:  # none yet
        whole = {"scales": {}}
    whole["scales"][result["provenance"]["scale"]] = rounded(result)
    write_rows(path, whole)
    choice.stored.cache_clear()
    return path


def rounded(value: Any) -> Any:
    """The same with numbers of five digits."""
    return json.loads(json.dumps(value), parse_float=lambda digits: float(f"{float(digits):.5g}"))
