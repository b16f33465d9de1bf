"""The page of a sweep: what was varied, optimum, significant and other effects, links to runs."""

from __future__ import annotations

import os
from itertools import combinations
from pathlib import Path
from typing import Any

import pandas as pd

from pywet.calibration.inference import MISFIT
from pywet.cases.custom.walls import word_of
from pywet.compare.statistics import LEVEL
from pywet.errors import PywetError
from pywet.report import page
from pywet.report.pictures import STYLE, panels, plt
from pywet.sweep import figures, significance, surface
from pywet.sweep.description import joined
from pywet.sweep.plan import Plan
from pywet.sweep.significance import Effects, Optimum
from pywet.sweep.table import DONE, FAILED
from pywet.sweep.table import NAME as TABLE

NAME = "report.html"
MOST_ROWS = 500
"""Largest number of runs on the page; the table has all."""
NO_MAP = "No map: it needs a result that varies over two independent numerical axes of at least three values each."
NOWHERE = "{}: no run has it"
SHARES = 4
"""Number of terms printed for a result without scatter."""
DETAILS = ("report.html", "summary.json", "point.json")
"""Files of a run to which its link may lead: the first that exists."""


def write(plan: Plan, made: pd.DataFrame) -> Path:
    """Write `report.html` into the folder of the sweep."""
    done = made[made["status"] == DONE]
    effects = {result: significance.effects(plan.sweep, made, result, plan.kind.seeded) for result in plan.results}
    best = [o for result in plan.results for o in optima(plan, made, result)]
    sections = [
        page.Section("What was varied", _varied(plan, made), "Axes"),
        page.Section("Where the optimum is", _optimum(best) + _compared(plan, made, best), "Optimum"),
        page.Section("What matters, and what is not significant", _effects(plan, effects), "Effects"),
        page.Section("Results over the axes", _curves(plan, done), "Curves"),
        *_maps(plan, done),
        page.Section("Runs", _runs(plan, made), "Runs"),
    ]
    cards = [
        page.Card(str(made["point"].nunique()), f"points, {len(made)} runs"),
        page.Card(str(len(done)), "runs with results", "good" if len(done) == len(made) else "fair"),
    ]
    if failed := int((made["status"] == FAILED).sum()):
        cards.append(page.Card(str(failed), "runs failed or were not done", "bad"))
    lead = f"{'. '.join(sentences(plan, made)[:2])}."
    return page.write(plan.folder / NAME, plan.sweep.name, lead, sections, cards)


def optima(plan: Plan, made: pd.DataFrame, result: str) -> list[Optimum]:
    """Return the optimum of the goal; without a goal the largest and the smallest of every result."""
    goal = plan.sweep.goal
    senses = (True, False) if goal is None else (goal.maximise is not None,) if result == goal.result else ()
    found = (significance.optimum(plan.sweep, made, result, largest) for largest in senses)
    return [o for o in found if o is not None]


def sentences(plan: Plan, made: pd.DataFrame) -> list[str]:
    """Return the sentences that a finished sweep prints: runs, optima, significant effects on each result."""
    done = int((made["status"] == DONE).sum())
    lines = [f"{done} of {len(made)} runs have results"]
    for result in plan.results:
        if made[result].isna().all():
            lines.append(NOWHERE.format(result))
        for o in optima(plan, made, result)[:1]:
            lines.append(f"{result} is {o.sense} at point {o.number} ({_values(o.values)}): {_mean(o)}{_alike(o)}")
        if found := significance.effects(plan.sweep, made, result, plan.kind.seeded):
            lines.append(f"{result}: {_matters(found)}")
    notes = made["reason"][(made["status"] == DONE) & (made["reason"] != "")].value_counts()
    return lines + [f"{note} in {count} of {done} runs" for note, count in notes.items()]


def _matters(found: Effects) -> str:
    """List the terms of a result in one line: significant ones and others, or the largest shares if nothing is tested."""
    if found.terms[0].p is None:
        largest = sorted(found.terms, key=lambda t: -t.share)[:SHARES]
        return "share of the variation " + ", ".join(f"{t.name} {100 * t.share:.2g} %" for t in largest)
    groups = [[t.name for t in found.terms if t.significant is which] for which in (True, False)]
    return "significant {}; not significant {}".format(*(", ".join(names) or "nothing" for names in groups))


def _values(values: dict[str, Any]) -> str:
    return ", ".join(f"{k} {v:.4g}" if isinstance(v, float) else f"{k} {v}" for k, v in values.items())


def _mean(o: Optimum) -> str:
    return f"{o.mean:.4g}" if o.half_width is None else f"{o.mean:.4g} ± {o.half_width:.2g} (95 %)"


def _alike(o: Optimum) -> str:
    if o.half_width is None:
        return f", from {_runs_of(o)}"
    count = len(o.alike) - 1
    return f"; {count} other {'point does' if count == 1 else 'points do'} not differ significantly from it"


def _runs_of(o: Optimum) -> str:
    return "one run" if o.runs == 1 else f"{o.runs} runs without an interval"


def _varied(plan: Plan, made: pd.DataFrame) -> str:
    rows = []
    for key, axis in plan.sweep.axes.items():
        values = made[key]
        numerical = pd.api.types.is_numeric_dtype(values) and not pd.api.types.is_bool_dtype(values)
        few = values.nunique() <= 12 or not numerical
        which = f"{values.min():.4g} to {values.max():.4g}" if not few else ", ".join(
            f"{v:.4g}" if isinstance(v, float) else str(v) for v in sorted(values.unique(), key=_order)
        )  # fmt: skip
        which += ", logarithmic" if axis.logarithmic else ""
        rows.append([page.left(key), made.attrs["units"].get(key, ""), str(values.nunique()), page.left(which)])
    sweep, how = plan.sweep, plan.sweep.design
    drawn = f"{'Sobol' if how.sobol else 'Latin hypercube'} design, seed {how.seed}; " if how else ""
    text = f"Base: {sweep.base.kind} {getattr(sweep.base, sweep.base.kind)}. {drawn}{sweep.seeds} run(s) of each point."
    lines = [text, *(f"{joined(group)} change together." for group in sweep.zips)]
    lines += [f"Constraint: `{rule}`." for rule in sweep.constraints]
    lines += [f"{len(plan.added)} points were added where the map was least known."] if plan.added else []
    return "".join(page.paragraph(line) for line in lines) + page.table(["axis", "unit", "values", "which"], rows)


def _order(value: Any) -> Any:
    return (isinstance(value, str), str(value) if isinstance(value, str) else float(value))


def _optimum(best: list[Optimum]) -> str:
    if not best:
        return page.paragraph("No run has results yet.")
    text = (
        "Among the points that were run. Interval of the mean: 95 %, for the best of all points and seeds that are common to "
        "them (scatter of the seeds' means, and of the points about them with Bonferroni). Like it: points whose mean is not "
        "significantly worse (t test with the scatter of all seeds, Bonferroni over all pairs), and the values of the axes "
        "there."
    )
    rows: page.Rows = [
        [
            page.left(f"{o.result}, {o.sense}"), _mean(o) if o.half_width is not None else f"{o.mean:.4g} ({_runs_of(o)})",
            page.left(f"point {o.number}: {_values(o.values)}"), str(len(o.alike) - 1) if o.half_width is not None else "–",
            page.left("; ".join(f"{k} {v}" for k, v in o.ranges.items())),
        ]
        for o in best
    ]  # fmt: skip
    return page.paragraph(text) + page.table(["result", "mean", "where", "points like it", "values there"], rows)


def _compared(plan: Plan, made: pd.DataFrame, best: list[Optimum]) -> str:
    """Compare the best point with the next one by the tests of `pywet compare`."""
    if not best or best[0].half_width is None or best[0].next_best is None:
        return ""
    a, b = best[0].number, best[0].next_best
    method, rows = significance.differences(made, plan.results, a, b)
    if not rows:
        return ""
    table = page.table_of(rows, {
        "result": lambda r: page.left(r.result), f"point {a}": lambda r: f"{r.a:.4g}", f"point {b}": lambda r: f"{r.b:.4g}",
        "p": lambda r: page.Cell(f"{r.p:.2g}", "good" if r.p <= LEVEL else "none"),
        "": lambda r: "significant" if r.p <= LEVEL else "not significant",
    })  # fmt: skip
    text = f"Best and next best point, {method}."
    if plan.kind.engine and plan.sweep.base.script is None:
        folders = {n: made.loc[(made["point"] == n) & (made["status"] == DONE), "run"] for n in (a, b)}
        words = " ".join(
            f"--{side} {os.path.normpath(plan.folder / folder)}"
            for side, n in (("a", a), ("b", b))
            for folder in folders[n]
        )
        text += f" All curves of both: `pywet compare {words} --force`."
    return page.paragraph(text) + table


def _effects(plan: Plan, effects: dict[str, Effects | None]) -> str:
    body = page.paragraph(
        "Share: part of the variation that the fit loses without the term. Change: largest less smallest fitted contribution. "
        "p: F test, Holm over the terms of a result."
    )
    for result, found in effects.items():
        if found is None:
            body += page.paragraph(
                f"{result}: the runs do not allow effects: it does not vary, the points are too few, or axes change together."
            )
            continue
        notes = [f"{result}. Error: {found.error}.", *([f"{found.left_out}."] if found.left_out else [])]
        body += page.paragraph(" ".join(notes)) + page.table_of(found.terms, {
            "term": lambda t: page.left(t.name),
            "share": lambda t: f"{100 * t.share:.3g} %",
            "change": lambda t: f"{t.change:.3g}",
            "p": lambda t: "–" if t.p is None else page.Cell(f"{t.p:.2g}", "good" if t.significant else "none"),
            "": lambda t: "" if t.p is None else "significant" if t.significant else "not significant",
        })  # fmt: skip
    return body


def _curves(plan: Plan, done: pd.DataFrame) -> str:
    """Draw every result over every varied axis."""
    keys = [key for key in plan.sweep.axes if len(done[key].unique()) > 1]
    if done.empty or not keys:
        return page.paragraph("Nothing to draw yet.")
    body = page.paragraph(
        "Means over seeds and all other axes; bars: 95 % interval of the mean, which the other axes widen.", soft=True
    )
    with plt.rc_context(STYLE):
        for result in plan.results:
            if done[result].isna().all():
                body += page.paragraph(NOWHERE.format(result) + ".")
                continue
            drawn = ""
            for k, key in enumerate(keys):
                figure, (axes,) = panels(1, 1, (4.2, 3.3))
                figures.curve(axes, plan.sweep, done, key, result)
                drawn += page.curves(figure, f"{word_of(result)}{k}", f"{result} over {joined(plan.sweep.factor(key))}")
            body += f'<div class="panels">{drawn}</div>'
    return body


def _maps(plan: Plan, done: pd.DataFrame) -> list[page.Section]:
    """Draw the response surface over the first two numerical axes that determine one, with its uncertainty."""
    numerical = list(significance.coordinates(plan.sweep, done)) if len(done) else []
    if len(numerical) < 2:
        return []
    body = ""
    for result in plan.results:
        pairs = ((pair, surface.through(plan.sweep, done, result, [*pair])) for pair in combinations(numerical, 2))
        (x, y), response = next(((pair, found) for pair, found in pairs if found), (("", ""), None))
        if response is None or done[result].nunique() < 2:
            continue
        over = " and ".join(joined(plan.sweep.factor(key)) for key in (x, y))
        with plt.rc_context(STYLE):
            try:
                drawn = figures.response_map(plan.sweep, done, result, x, y)
                body += page.curves(drawn, f"map{word_of(result)}", f"{result} over {over}", drawn_only=True)
            except PywetError as error:
                body += page.paragraph(str(error))
        if response.fitted.misfit < MISFIT:
            body += page.paragraph(
                f"The runs do not follow the polynomial of {result}: more points would make the map safer."
            )
    text = (
        "Polynomial of second order through all runs; its standard error holds the scatter of seeds, of axes that are not "
        "drawn, and what the polynomial does not follow."
    )
    return [page.Section("Response surface", page.paragraph(text if body else NO_MAP, soft=True) + body, "Map")]


def _runs(plan: Plan, made: pd.DataFrame) -> str:
    """Return the first rows of the table, each with a link to its run."""
    shown = made.head(MOST_ROWS)
    rows: page.Rows = []
    for row in shown.to_dict(orient="records"):
        folder = plan.folder / row["run"]
        link = next((f"{row['run']}/{name}" for name in DETAILS if (folder / name).exists()), "")
        numbers = ["–" if pd.isna(row[r]) else f"{row[r]:.5g}" for r in plan.results]
        values = [f"{row[k]:.5g}" if isinstance(row[k], float) else str(row[k]) for k in plan.sweep.axes]
        grade: page.Grade = "good" if row["status"] == DONE else "bad"
        rows.append([
            page.Cell(str(row["point"]), link=link), str(row["seed"]), *values, *numbers,
            page.Cell(row["status"], grade), page.left(str(row["reason"])[:200]),
        ])  # fmt: skip
    text = f"The first {MOST_ROWS} of {len(made)}; " if len(made) > MOST_ROWS else ""
    files = " and ".join(f'<a href="{name}">{name}</a>' for name in ("sweep.csv", TABLE))
    header = ["point", "seed", *plan.sweep.axes, *plan.results, "", "why not"]
    return f'<p class="soft">{text}all are in {files}.</p>' + page.table(header, rows)
