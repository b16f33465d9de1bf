"""The report: one HTML file with everything in it, from the run directories of all cases at one scale.

Gathers what the template `workflow/report/report.html.j2` shows; reads only what the stages wrote and computes nothing again.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import jinja2

import pywet
from pywet.cases.screening.verdict import LEDGER_TOLERANCE, REPLAY_TOLERANCE
from pywet.config import Config, of_run
from pywet.errors import PywetError
from pywet.report import answer, browser, contributed, page, plots, presets
from pywet.report.collect import CaseResult, collect, collect_run
from pywet.runs.rundir import RunDir
from pywet.runs.spread import with_interval
from pywet.util.files import atomic_write

TEMPLATE = "report.html.j2"
SCENES = 60_000_000
"""Size of the 3-D scenes of all cases together [bytes]."""
TABLE = "../agreement/index.html"
"""The table of agreement, next to the report's folder where it has been made."""
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
    twins: Mapping[str, tuple[int, str]] | None = None,
) -> None:
    """Write the report on `cases` run in `folder`/<case name>; `picture` is a PNG of one moist case, where there is one.

    `twins`: folder name of a run with another preset -> number of its case and that preset.
    """
    results = collect(folder, [config.case(number) for number in cases])
    usual = {r.case.case: r for r in results}
    pairs = [
        presets.shown(usual[number], collect_run(folder / name, config.case(number)), preset)
        for name, (number, preset) in (twins or {}).items()
    ]
    _render(config, scale, results, template_dir, picture, out, pairs)


def write_run(run_dir: Path, template_dir: Path, picture: Path | None) -> Path:
    """Write the report on one run of a case into its own folder, from the configuration that was stored with it."""
    config, number, scale = of_run(run_dir)
    out = run_dir / "report.html"
    _render(config, scale, [collect_run(run_dir, config.case(number), alone=True)], template_dir, picture, out)
    return out


def _render(
    config: Config,
    scale: str,
    results: Sequence[CaseResult],
    template_dir: Path,
    picture: Path | None,
    out: Path,
    pairs: Sequence[dict[str, Any]] = (),
) -> None:
    environment = page.templates(template_dir)
    environment.filters.update({"sig": _significant, "power": _power, "interval": with_interval})
    try:
        text = environment.get_template(TEMPLATE).render(
            {
                **context(config, scale, results, picture),
                "files": _files(out, results),
                "presets": pairs,
                "table_of_agreement": TABLE if (out.parent / TABLE).exists() else None,
                "pages": _pages(out),
            }
        )
    except jinja2.TemplateNotFound as error:
        raise PywetError(
            f"no {TEMPLATE} in {template_dir}; expected the repository's workflow/report folder"
        ) from error
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
"""Page under results/ and what it is about."""


def _pages(report: Path) -> list[tuple[str, str]]:
    """Links to the pages that were made, with their titles."""
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
"""File of a run directory and what it is called."""


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


def context(config: Config, scale: str, results: Sequence[CaseResult], picture: Path | None) -> dict[str, Any]:
    """Collect the values that the report's template needs."""
    moist = [r for r in results if r.bridged]
    passed, proof = answer.rows(results), answer.proof(results)
    replayed = [r for r in results if r.agreement]
    return {
        "scale": scale,
        "passed": passed,
        "answer": answer.sentence(passed),
        "proof": proof[0],
        "agrees": proof[1],
        "laws": answer.laws(results),
        "unchecked": answer.unchecked(results),
        "own": sum(bool(r.unchecked) for r in moist),
        "seeds": any(r.seeds for r in results),
        "results": results,
        "moist": moist,
        "done": sum(r.done for r in results),
        "checked": sum(r.cross_checked for r in moist),
        "worst_replay": max(
            (a.largest for r in replayed for a in r.agreement if a.limit <= REPLAY_TOLERANCE), default=None
        ),
        "replay_ok": all(a.ok for r in replayed for a in r.agreement),
        "replayed": replayed,
        "worst_ledger": max((e for r in moist if (e := r.ledger_error) is not None), default=None),
        "wall_s": sum(r.summary["wall_s"] for r in results if r.summary),
        "sphere_steps": sum(r.summary["steps"] * sum(r.summary["spheres"].values()) for r in results if r.summary),
        "ledger_tolerance": LEDGER_TOLERANCE,
        "replay_tolerance": REPLAY_TOLERANCE,
        "quantities": list({a.quantity: a for r in replayed for a in r.agreement}.values()),
        "contributed": contributed.rows(results),
        "wrong_plans": contributed.wrong(results),
        "effects": _effects(results),
        "statement": scale_statement(config, scale),
        "assumptions": list(assumptions(config, scale)),
        "figures": _figures(results),
        "picture": _embedded([picture]),
        "movie": _embedded([r.folder / "movie.webp" for r in results if r.folder]),
        "scenes": _scenes(results),
        "versions": next((r.summary["versions"] for r in results if r.summary), {}),
        "version": pywet.__version__,
    }


def scale_statement(config: Config, name: str) -> list[str]:
    """In sentences, how the scale departs from the paper's experiment."""
    scale = config.scale(name)
    factor, width = scale.stiffness_factor.value, scale.asked_width_mm
    sieve = "round sieve" if scale.shape == "cylinder" else "square sieve, its side rounded to whole screen pitches"
    whole = config.materials.feed.sieve_diameter_mm.value
    found = [
        f"The screen is a {width:g} mm {sieve}; the feed goes with its area, so the bed is as deep as the paper's feed "
        f"on a {whole:g} mm sieve."
    ]
    if factor < 1:
        found.append(
            f"Contact springs are softened to {factor:g} of table 1's stiffness, so collisions take "
            f"{factor**-0.5:.3g} times as long and overlaps are larger; "
            "restitution, friction and all liquid forces are unchanged."
        )
    else:
        found.append("Contact springs have the stiffness of table 1.")
    length, opening = scale.duration_s.value, scale.slide_opens_at_s.value
    text = f"Each run lasts {length:g} s, of which {opening:g} s pass before the slide opens"
    found.append(
        text
        + ("." if length >= PAPER_SECONDS else f"; the paper screens for {PAPER_SECONDS:g} s, so curves end early.")
    )
    if name != "full":
        found.append(
            "This scale shows that the whole line works and that it is right; the curves of the paper are for the full scale."
        )
    return found


def assumptions(config: Config, scale: str) -> Iterator[tuple[str, str, str]]:
    """Name, value and reason of every number of the configuration that is not from the paper; a measured one says so."""
    parts = {
        "apparatus": config.apparatus.model_dump(exclude_none=True),
        f"scale {scale}": config.scale(scale).model_dump(exclude_none=True),
        "materials": config.materials.model_dump(exclude_none=True),
        "settings": config.settings.model_dump(exclude_none=True),
    }
    for name, data in parts.items():
        yield from _assumed(name, data)


def _assumed(name: str, data: Any) -> Iterator[tuple[str, str, str]]:
    if isinstance(data, dict):
        if data.get("source") in ("assumption", "measured") and ("value" in data or "material" in data):
            value = data.get("value", data.get("material", ""))
            why = data.get("reason", {"measured": "measured", "assumption": "no reason is given"}[data["source"]])
            yield name, f"{value:g}" if isinstance(value, float) else str(value), why
            return
        for key, value in data.items():
            yield from _assumed(f"{name} · {key}", value)
    elif isinstance(data, list | tuple):
        for k, value in enumerate(data):
            yield from _assumed(f"{name} {k + 1}", value)


def _effects(results: Sequence[CaseResult]) -> list[dict[str, Any]]:
    """One row per effect: what is compared, threshold, and per case the plan's row (None where there is no plan)."""
    plans = [{row["effect"]: row for row in r.plan["rows"]} if r.plan else {} for r in results]
    names = list(dict.fromkeys(name for plan in plans for name in plan))
    first = {name: next(plan[name] for plan in plans if name in plan) for name in names}
    return [{**first[name], "effect": name, "cells": [plan.get(name) for plan in plans]} for name in names]


def _figures(results: Sequence[CaseResult]) -> dict[str, list[dict[str, Any]]]:
    sheets = {"moisture": plots.moisture, "dry": plots.dry, "classes": plots.classes, "liquid": plots.liquid}
    drawn = {name: plots.apart(sheet(results), name) for name, sheet in sheets.items()}
    return {name: panels for name, panels in drawn.items() if panels}


def _embedded(files: Sequence[Path | None]) -> str | None:
    """The first of these pictures that is there, as the address of itself."""
    for file in files:
        if file is not None and file.exists() and file.stat().st_size:
            return page.uri(file.read_bytes(), file.suffix.removeprefix("."))
    return None


def _significant(value: float | None, digits: int = 3) -> str:
    """A number with some significant digits; a dash for None."""
    return "–" if value is None else f"{value:.{digits}g}"


def _power(value: float | None) -> str:
    """A small number as 3.2e−16; zero as 0; a dash for None."""
    if value is None:
        return "–"
    return "0" if value == 0 else f"{value:.1e}".replace("e-0", "e-").replace("-", "−")


def _scenes(results: Sequence[CaseResult]) -> str:
    """The moist cases as 3-D scenes; nothing where none has results."""
    runs = [(r.case.name, RunDir(r.folder)) for r in results if r.bridged and r.summary and r.folder]
    return browser.element(runs, most=min(browser.MOST, SCENES // len(runs))) if runs else ""
