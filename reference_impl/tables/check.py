"""The section `results` of a replay: every table and summary that a person reads, against the reference's own."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from reference_impl.diagnosis.held import MISSING, Held, Section
from reference_impl.replay import io
from reference_impl.tables import columns, own, summary, walls

NAME = "results"
TABLES = ("fraction_retained", "liquid_by_holder")
KINDS = ("parquet", "csv")
OWN = "description.json"
"""What a scene of a user's own is described by."""


def there(folder: Path) -> bool:
    """Whether the run has tables of results, or a summary of them."""
    return (folder / "results").is_dir() or (folder / "summary.json").exists()


def check(folder: Path) -> Section:
    """Everything compared; nothing where there are no results yet."""
    section, run = Section(NAME), Path(folder)
    if not there(run):
        section.not_checked.append("results: there are none yet in the run directory")
        return section
    scene = io.scene(run)
    if (run / OWN).exists():
        _own_scene(section, run, scene)
        return section
    try:
        mine = own.go_through(run, scene)
        if (run / "results").is_dir():
            _tables(section, run, mine)
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
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, ZeroDivisionError) as error:
        raise io.ReplayError(
            f"{run}: its results and scene.json cannot be laid beside each other ({error!r}); expected both as `pywet run` "
            "writes them: make the results again"
        ) from error
    return section


def _own_scene(section: Section, run: Path, scene: dict[str, Any]) -> None:
    """Of a scene of a user's own, where its liquid is."""
    section.not_checked.append("results: of a scene of one's own, contact_statistics and summary.json")
    path = run / "results" / "liquid_by_wall.parquet"
    if not scene["effects"]["bridges"] or not path.exists():
        return
    own_table = walls.liquid_by_wall(run, scene)
    scales = {
        "step": 1.0,
        "time": max(own_table["time_s"].iloc[-1], 1e-300),
        "_m3": own_table["initial_m3"].iloc[0] or 1.0,
    }
    given = columns.read(path)
    rows = columns.held(f"results/{path.name}", given, own_table, scales)
    section.add(
        "results_liquid_by_wall", "1, or the liquid put in", rows, f"columns of {path.stem} ({given.size} values)"
    )


def _tables(section: Section, run: Path, mine: own.Own) -> None:
    liquid = mine.initial or 1.0
    scales = {"step": 1.0, "time": max(abs(mine.retained["time_s"].iloc[-1]), 1e-300), "_m3": liquid}
    for name, table in zip(TABLES, (mine.retained, mine.liquid), strict=True):
        held, rows = [], 0
        for kind in KINDS:
            path = run / "results" / f"{name}.{kind}"
            if not path.exists():
                held.append(Held(f"results/{path.name}", MISSING, "there", "docs/results.md"))
                continue
            given = columns.read(path)
            rows += given.size
            held += columns.held(f"results/{path.name}", given, table, scales)
        section.add(f"results_{name}", "1, or the liquid put in", held, f"columns of {name} ({rows} values)")
    path = run / "results" / "checks.json"
    listed = summary.load(path) if path.exists() else None
    section.add("results_checks", "1", [*summary.checks("results/checks.json", listed, mine)], "numbers of checks.json")
