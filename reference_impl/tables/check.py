"""Section `results` of a replay: every result table and summary compared with the recomputed one."""

from __future__ import annotations

from pathlib import Path

from reference_impl.diagnosis.held import MISSING, Held, Section
from reference_impl.replay import io
from reference_impl.tables import any_scene, columns, known, plant, screening, summary
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
        screens = [summary.load(run / name) for name in plant.RESULTS.values() if (run / name).exists()]
        if screens:
            compared = [row for numbers in screens for row in plant.held(run, scene, numbers)]
            section.add("results_screen", "itself", compared, "numbers of screen.json")
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


def _tables(section: Section, run: Path, mine: Recomputed) -> None:
    liquid = mine.initial or 1.0
    scales = {"step": 1.0, "time": max(abs(mine.liquid["time_s"].iloc[-1]), 1e-300), "_m3": liquid}
    for name, table in mine.tables.items():
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
    if mine.ends is not None:
        return  # a user-defined scene has its checks in summary.json only
    listed = summary.load(path) if path.exists() else None
    section.add("results_checks", "1", [*summary.checks("results/checks.json", listed, mine)], "numbers of checks.json")
