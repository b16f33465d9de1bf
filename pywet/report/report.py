"""The report: one HTML file with everything in it, from the run directories of all cases at one scale.

Collects the data for the template `workflow/report/report.html.j2` and writes its numbers to report.json; reads only
the results of the stages and recomputes nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import jinja2

import pywet
from pywet.config import Config, of_run
from pywet.errors import PywetError
from pywet.report import answer, browser, contributed, page, plots, presets
from pywet.report.collect import CaseResult, collect, collect_run
from pywet.report.report_numbers import CASES, LEDGER, SCREEN, Numbers, collected
from pywet.runs.rundir import RunDir
from pywet.util.files import atomic_write, write_json

TEMPLATE = "report.html.j2"
SCENES = 60_000_000
"""Size of the 3-D scenes of all cases together [bytes]."""
TABLE = "../agreement/index.html"
"""Path of the table of agreement, next to the report's folder if it exists."""
PAPER_SECONDS = 20.0
"""Duration of the paper's runs, section 5.2."""


def write(
    config: Config,
    scale: str,
    cases: Sequence[int],
    folder: Path,
    template_dir: Path,
    picture: Path | None,
    out: Path,
    comparisons: Mapping[str, tuple[int, str]] | None = None,
) -> None:
    """Write the report on `cases` run in `folder`/<case name>; `picture` is a PNG of one moist case, if there is one.

    `comparisons`: folder name of a run with another preset -> number of its case and that preset.
    """
    results = collect(folder, [config.case(number) for number in cases])
    usual = {r.case.case: r for r in results}
    numbers = collected(results, config, scale)
    pairs = [
        presets.shown(usual[number], collect_run(folder / name, config.case(number)), preset, numbers)
        for name, (number, preset) in (comparisons or {}).items()
    ]
    _render(scale, results, numbers, template_dir, picture, out, pairs)


def write_run(run_dir: Path, template_dir: Path, picture: Path | None) -> Path:
    """Write the report on one run of a case into its own folder, from the configuration that was stored with it."""
    config, number, scale = of_run(run_dir)
    out, results = run_dir / "report.html", [collect_run(run_dir, config.case(number), alone=True)]
    _render(scale, results, collected(results, config, scale), template_dir, picture, out)
    return out


def _render(
    scale: str,
    results: Sequence[CaseResult],
    numbers: Numbers,
    template_dir: Path,
    picture: Path | None,
    out: Path,
    pairs: Sequence[dict[str, Any]] = (),
) -> None:
    """Write the numbers as JSON and the page that is rendered from them."""
    environment, figures = page.templates(template_dir), _figures(results)
    for panel in (panel for panels in (*figures.values(), *(pair["figure"] for pair in pairs)) for panel in panels):
        for of in panel["meanings"]:
            numbers.put(of.key, of.value, of.shown)
    try:
        text = environment.get_template(TEMPLATE).render(
            {
                **context(scale, results, numbers, picture),
                "figures": figures,
                "files": _files(out, results),
                "presets": pairs,
                "table_of_agreement": TABLE if (out.parent / TABLE).exists() else None,
                "pages": _pages(out),
            }
        )
    except jinja2.TemplateNotFound as error:
        raise PywetError(
            f"no {TEMPLATE} in {template_dir}; expected the repository's workflow/report folder",
            code="report.no_template", where=template_dir,
        ) from error  # fmt: skip
    write_json(out.with_suffix(".json"), numbers)
    with atomic_write(out) as temporary:
        temporary.write_text(text, encoding="utf-8")


PAGES = {
    "studies/accuracy.html": "what accuracy costs",
    "studies/stability.html": "what stays stable",
    "studies/effects.html": "which effects count",
    "atlas/atlas.html": "which capillary law to take",
    "wall_collision/index.html": "wet collisions with a wall",
    "sphere_collisions/index.html": "collisions of wet spheres",
}
"""Page under results/ and its subject."""


def _pages(report: Path) -> list[tuple[str, str]]:
    """Return links to the existing pages, with their titles."""
    folder = report.parent.parent
    return [(f"../{name}", title) for name, title in PAGES.items() if (folder / name).exists()]


FILES = {
    "results/fraction_retained.csv": "fraction retained",
    "results/liquid_by_holder.csv": "liquid",
    "summary.json": "summary",
    "replay.json": "cross-check",
    "vtk/particles.pvd": "VTK",
    "engine/output.log": "log",
}
"""File of a run directory and its title."""


def _files(report: Path, results: Sequence[CaseResult]) -> list[tuple[int, list[tuple[str, str]]]]:
    """List the existing files of each case as links relative to the report's folder."""
    below = report.parent.resolve()
    return [
        (
            r.case.case,
            [
                ((r.folder / name).resolve().relative_to(below).as_posix(), text)
                for name, text in FILES.items()
                if (r.folder / name).exists()
            ],
        )
        for r in results
        if r.folder is not None and r.folder.resolve().is_relative_to(below)
    ]


def context(scale: str, results: Sequence[CaseResult], numbers: Numbers, picture: Path | None) -> dict[str, Any]:
    """Collect what the report's template needs; `n` renders a number by its key, `numbers` has its value and text."""
    replayed = [r for r in results if r.agreement]
    return {
        "scale": scale,
        "full_scale": scale == "full",
        "n": numbers.html,
        "numbers": numbers,
        "results": results,
        "passed": answer.rows(results),
        "agrees": answer.agrees(results),
        "laws": [key for key in numbers if key.startswith("law.")],
        "unchecked": answer.unchecked(results),
        "seeds": any(r.seeds for r in results),
        "moist": [r for r in results if r.bridged],
        "replay_ok": all(a.ok for r in replayed for a in r.agreement),
        "replayed": replayed,
        "quantities": list({a.quantity: a for r in replayed for a in r.agreement}.values()),
        "contributed": contributed.rows(results),
        "wrong_plans": contributed.wrong(results),
        "effects": _effects(results),
        "paper_seconds": PAPER_SECONDS,
        "assumptions": [k for k in numbers if k.startswith("assumption.") and f"{k}.reason" in numbers],
        "screens": [r for r in results if r.screens],
        "screen_columns": SCREEN,
        "case_columns": CASES,
        "reservoirs": LEDGER,
        **_seen(results, picture),
        "scenes": _scenes(results),
        "versions": next((r.summary["versions"] for r in results if r.summary), {}),
        "version": pywet.__version__,
    }


def _effects(results: Sequence[CaseResult]) -> list[dict[str, Any]]:
    """Return one row per effect: compared quantity, threshold, and per case the plan's row (None without a plan)."""
    plans = [{row["effect"]: row for row in r.plan["rows"]} if r.plan else {} for r in results]
    names = list(dict.fromkeys(name for plan in plans for name in plan))
    first = {name: next(plan[name] for plan in plans if name in plan) for name in names}
    return [{**first[name], "effect": name, "cells": [plan.get(name) for plan in plans]} for name in names]


def _figures(results: Sequence[CaseResult]) -> dict[str, list[dict[str, Any]]]:
    sheets = {"moisture": plots.moisture, "dry": plots.dry, "classes": plots.classes, "liquid": plots.liquid}
    drawn = {name: plots.apart(sheet(results), name) for name, sheet in sheets.items()}
    return {name: panels for name, panels in drawn.items() if panels}


def _seen(results: Sequence[CaseResult], picture: Path | None) -> dict[str, Any]:
    """Return loop and picture of a moist case, otherwise of a dry one, and which it is; `picture` is of a moist one if any is."""
    loops = {moist: _embedded([r.folder / "movie.webp" for r in results if r.folder and r.bridged == moist])
             for moist in (True, False)}  # fmt: skip
    still, moist = _embedded([picture]), any(r.bridged for r in results)
    moist = moist and bool(loops[True] or still)
    return {"movie": loops[moist], "picture": still, "moist_picture": moist}


def _embedded(files: Sequence[Path | None]) -> str | None:
    """Return the first existing picture of these as a data address."""
    for file in files:
        if file is not None and file.exists() and file.stat().st_size:
            return page.uri(file.read_bytes(), file.suffix.removeprefix("."))
    return None


def _scenes(results: Sequence[CaseResult]) -> str:
    """Return the moist cases as 3-D scenes; empty if none has results."""
    runs = [(r.case.name, RunDir(r.folder)) for r in results if r.bridged and r.summary and r.folder]
    return browser.element(runs, most=min(browser.MOST, SCENES // len(runs))) if runs else ""
