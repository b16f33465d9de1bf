"""Section `results` of a replay: every result table and summary compared with the recomputed one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.diagnosis.held import MISSING, Held, Section
from reference_impl.replay import io
from reference_impl.tables import any_scene, columns, flowsheet, known, plant, screen_wall, screening, summary
from reference_impl.tables.recomputed import Recomputed

NAME = "results"
KINDS = ("parquet", "csv")


def there(folder: Path) -> bool:
    """Return whether the run has tables of results, or a summary of them."""
    return (folder / "results").is_dir() or (folder / "summary.json").exists()


def check(folder: Path) -> Section:
    """Compare all tables of results; nothing if there are none yet."""
    section, run = Section(NAME), Path(folder)
    if not there(run):
        section.not_checked.append("results: there are none yet in the run directory")
        return section
    scene = io.scene(run)
    try:
        mine = (any_scene if any_scene.written(run) else screening).tables(run, scene)
        if (run / "results").is_dir():
            _tables(section, run, mine)
        for deck, name in plant.RESULTS.items():
            if (run / name).exists():
                _screen(section, run, scene, summary.load(run / name), deck)
        if scene.get("blocks") and (run / known.RESULT).exists():
            section.add("results_until", "itself", [*known.held(run, scene)], "numbers of until.json")
        if (run / "summary.json").exists():
            given = summary.load(run / "summary.json")
            section.add(
                "results_summary",
                "itself, or the liquid put in",
                [*summary.held(given, mine, scene, run)],
                "numbers of summary.json",
            )
            section.not_checked.append(f"results: of summary.json {', '.join(summary.NOT_COMPARED)}")
        else:
            section.not_checked.append("results: summary.json, which is not there")
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, ArithmeticError) as error:
        raise io.ReplayError(
            f"{run}: its results and scene.json cannot be compared ({error!r}); expected both as `pywet run` "
            "writes them: make the results again"
        ) from error
    return section


def _screen(section: Section, run: Path, scene: Mapping[str, Any], given: Mapping[str, Any], deck: int) -> None:
    """Compare the numbers and tables of a deck; of the given ones only the options are taken as they are."""
    of = plant.Deck.read(run, scene, {**given, "deck": deck})
    named = Held(f"{plant.RESULTS[deck]}: deck", given.get("deck", 1), deck, "name of the file")
    name = screen_wall.numbered("results_screen", deck)
    section.add(name, "itself", [named, *plant.held(run, scene, of)], f"numbers of {Path(plant.RESULTS[deck]).name}")
    mass, liquid = float(of.spheres["kg"].sum()), float(of.spheres["start_m3"].sum())
    scales = {"time": of.period["to_s"], "x_m": 1e-3, "_kg": mass, "_m3": liquid or 1.0}
    partition = plant.partition(of.counted)
    _compare(section, run, screen_wall.numbered("screen_series", deck), of.series, scales)
    _compare(section, run, screen_wall.numbered("partition", deck), partition, scales, "size")
    efficiency = flowsheet.grade_efficiency(partition)
    _compare(section, run, screen_wall.numbered("grade_efficiency", deck), efficiency, scales, "size", ("csv",))
    name = screen_wall.numbered("flowsheet", deck)
    path = run / "results" / f"{name}.csv"
    fits = flowsheet.held(f"results/{path.name}", columns.read(path) if path.exists() else None, partition)
    section.add(f"results_{name}", "itself", [*fits], f"values of {name}")


def _tables(section: Section, run: Path, mine: Recomputed) -> None:
    liquid = mine.initial or 1.0
    scales = {"step": 1.0, "time": max(abs(mine.liquid["time_s"].iloc[-1]), 1e-300), "_m3": liquid}
    for name, table in mine.tables.items():
        _compare(section, run, name, table, scales)
    path = run / "results" / "checks.json"
    if mine.ends is not None:
        return  # a user-defined scene has its checks in summary.json only
    listed = summary.load(path) if path.exists() else None
    section.add("results_checks", "1", [*summary.checks("results/checks.json", listed, mine)], "numbers of checks.json")


def _compare(
    section: Section, run: Path, name: str, table: pd.DataFrame, scales: dict[str, float],
    key: str = "step", kinds: Sequence[str] = KINDS,
) -> None:  # fmt: skip
    """Compare a table in each of its files; rows of sizes are numbered from the finest."""
    held, rows = [], 0
    for kind in kinds:
        path = run / "results" / f"{name}.{kind}"
        if not path.exists():
            held.append(Held(f"results/{path.name}", MISSING, "there", "docs/results.md"))
            continue
        given = columns.read(path)
        rows += given.size
        given, mine = (t if key in t else t.assign(**{key: np.arange(1.0, len(t) + 1)}) for t in (given, table))
        held += columns.held(f"results/{path.name}", given, mine, scales, key)
    section.add(f"results_{name}", "1, or the liquid put in", held, f"columns of {name} ({rows} values)")
