"""The study's page: where the defaults stand, what an accuracy costs, pictures first, every number behind them last."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from pywet.errors import PywetError
from pywet.study.accuracy import choice, cost, figures, front, runs
from pywet.study.accuracy.errors import GROUPS, QUANTITIES
from pywet.study.accuracy.knobs import KNOBS
from pywet.view.page import Card, Cell, Section, paragraph, picture
from pywet.view.page import table as html_table
from pywet.view.page import write as write_page

ACCURACIES = (0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005)
WISHES = {
    "everything": choice.WANTED,
    "fraction retained and liquid": ("fraction retained", "liquid shares"),
    "restitution": ("restitution",),
}
"""What one may want -> the groups that count."""
GRADE = {"on the front": "good", "not told apart": "fair", "beaten": "bad"}


def write(
    path: Path, table: dict[str, Any], kept: Sequence[dict[str, Any]], size: str, others: Sequence[dict[str, Any]] = ()
) -> Path:
    """Write the page and return its path; `others` are the tables of other scales, to be shown beside."""
    standings = all_standings(table)
    beaten = [s for s in standings if s.verdict == "beaten"]
    made = table["provenance"]
    cards = [
        Card(
            f"{sum(s.verdict == 'on the front' for s in standings)} of {len(standings)}",
            "times the default stands on the front of its setting",
        ),
        Card(
            str(sum(s.verdict == "not told apart" for s in standings)),
            "times a cheaper level differs by no more than chance",
        ),
        Card(str(len(beaten)), "times another level is as cheap and better", "bad" if beaten else "good"),
        *_price_cards(table),
        Card(f"{made['processor_time_s'] / 60:.0f} min", f"of processor time, {made['runs']} runs"),
    ]
    sections = [
        Section("If you can live with …", _live_with(table), "choose"),
        Section("The fronts: error against price", _fronts(table), "fronts"),
        Section("Where the defaults stand", _standing_table(table, standings, beaten), "defaults"),
        *(_knobs(table, group) for group in GROUPS),
        *([Section("At the other scale", _scales(table, others), "scales")] if others else []),
        Section("What chance alone does", _seeds(table, kept), "seeds"),
        Section("How long a run takes", _times(kept, table), "times"),
        Section("Every number", _numbers(table), "numbers"),
    ]
    lead = (
        "Each setting of a run against a finer one: how wrong it makes what you want to know, and what it costs. "
        f"{made['scale'].capitalize()} scale, size {made['size']}, {made['seeds']} seeds."
    )
    return write_page(path, "What accuracy costs", lead, sections, cards, _footer(made, size))


def all_standings(table: dict[str, Any]) -> list[front.Standing]:
    """Where the defaults stand, for every knob, kind of case and group that was measured."""
    found = [
        front.standing(table, knob, kind, group, scenes)
        for kind, scenes in figures.SCENES.items()
        for knob in KNOBS
        if not KNOBS[knob].exact_twin
        for group in GROUPS
    ]
    return [s for s in found if s is not None]


def _price_cards(table: dict[str, Any]) -> list[Card]:
    try:
        chosen = choice.choose(table, 0.02, True)
    except PywetError:
        return [Card("none", "settings are within 2 % in everything")]
    return [Card(f"{chosen.price:.2g} ×", "the default's price, for 2 % in everything, moist")]


def _live_with(table: dict[str, Any]) -> str:
    rows: list[list[Cell | str]] = []
    for kind in ("moist", "dry"):
        for wish, wanted in WISHES.items():
            groups = tuple(g for g in wanted if kind == "moist" or g in ("fraction retained", "restitution"))
            last: tuple[Any, ...] | None = None
            for accuracy in ACCURACIES:
                row = _choice_row(table, accuracy, kind, groups)
                if row is None or row[1:3] == last:
                    continue
                last = row[1:3]
                rows.append([Cell(f"{kind}: {wish}"), Cell(f"{100 * accuracy:g} %"), Cell(row[1], left=True), *row[2:]])
    text = paragraph(
        "The cheapest settings whose errors, added up over the settings, stay below what you can live with. A cheaper setting "
        "must be shown right: what chance alone may have hidden is counted against it. Rows that choose the same as the one "
        "above are left out. The same from the command line: `pywet plan 2 --accuracy 2%`."
    )
    return text + html_table(["what counts", "you can live with", "choose", "price", "error, counted"], rows)


def _choice_row(table: dict[str, Any], accuracy: float, kind: str, groups: tuple[str, ...]) -> tuple[str, ...] | None:
    try:
        chosen = choice.choose(table, accuracy, kind == "moist", groups)
    except PywetError:
        return None
    words = [f"{KNOBS[k].title} {v}" for k, v in chosen.levels.items() if v != table["default"][k]]
    return (
        kind,
        ", ".join(words) or "the defaults",
        f"{chosen.price:.2f} ×",
        f"{100 * max(chosen.error.values()):.2g} %",
    )


def _fronts(table: dict[str, Any]) -> str:
    return _picture(
        figures.fronts(table),
        "Lower left is better. Each line is the cheapest price for an error, over all combinations of time step, springs, "
        "facets, law and integration; rings: the defaults, counted the same way. What chance may hide counts in full "
        "against a cheaper setting and not at all against the default or a finer one, so that a ring at the foot says: nothing "
        "was found wrong with it. A ring to the right of its line could have had the same for less.",
    )


def _knobs(table: dict[str, Any], group: str) -> Section:
    figure = figures.knob_panels(table, group)
    names = "; ".join(q.text for q in QUANTITIES if q.group == group)
    if figure is None:
        return Section(group.capitalize(), paragraph("No setting changes it."), group)
    text = (
        "One setting changed at a time, against its finest level. Red ring: the default. Filled: resolved; hollow: within what "
        "the seeds differ by; the line upwards is how large it may be. Triangles at the foot: no error (the finest level itself)."
    )
    return Section(
        group.capitalize(), paragraph(f"{names[0].upper()}{names[1:]}. The largest of them is drawn.") + _picture(figure, text),
        group,
    )  # fmt: skip


def _standing_table(
    table: dict[str, Any], standings: Sequence[front.Standing], beaten: Sequence[front.Standing]
) -> str:
    order = {(s.kind, s.knob, s.group): s for s in standings}
    rows: list[list[Cell | str]] = []
    for kind in ("moist", "dry"):
        for knob in KNOBS:
            own = [order.get((kind, knob, group)) for group in GROUPS]
            if any(own):
                cells = [Cell("–", "none") if s is None else _standing_cell(s) for s in own]
                rows.append([Cell(f"{kind}: {KNOBS[knob].title}"), *cells])
    said = [paragraph(_objection(s)) for s in beaten] or [
        paragraph("No level of any setting is as cheap and better than the default beyond doubt.")
    ]
    said += [paragraph(text) for text in bargains(table)]
    return "".join(dict.fromkeys(said)) + html_table(["setting", *GROUPS], rows)


def _standing_cell(standing: front.Standing) -> Cell:
    grade: Any = GRADE[standing.verdict]
    by = "" if standing.by is None else f" ({figures.SHORT.get(str(standing.by), standing.by)})"
    return Cell(standing.verdict + by, grade, standing.said)


def _objection(standing: front.Standing) -> str:
    title = KNOBS[standing.knob].title.capitalize()
    return f"{title}, {standing.kind}, {standing.group}: {standing.said}."


def bargains(table: dict[str, Any]) -> list[str]:
    """What much accuracy may be had for little more, one sentence each."""
    found = []
    for kind, scenes in figures.SCENES.items():
        for knob in KNOBS:
            for group in GROUPS:
                text = front.bargain(table, knob, kind, group, scenes)
                if text:
                    found.append(f"{KNOBS[knob].title.capitalize()}, {kind}, {group}: {text}.")
    if any(text.startswith("Capillary law") for text in found):
        found.append(
            "The default law stays because the cases reproduce a paper that uses it; where the physics counts, take "
            "`preset: exact` under `laws:` in config.yaml."
        )
    return found


def _scales(table: dict[str, Any], others: Sequence[dict[str, Any]]) -> str:
    """What changes with the scale: prices and errors beside each other, then what to choose there."""
    tables, groups = (table, *others), ("fraction retained", "liquid shares")
    names = [t["provenance"]["scale"] for t in tables]
    header = ["setting"] + [f"{name}: {what}" for name in names for what in ("moist", "dry", *groups)]
    rows: list[list[Cell | str]] = []
    for knob in KNOBS:
        by_level = [{row["level"]: row for row in t["knobs"][knob]} for t in tables]
        for level in dict.fromkeys(level for rows_of in by_level for level in rows_of):
            cells = [Cell(f"{KNOBS[knob].title}: {level}")]
            for rows_of, own in zip(by_level, tables, strict=True):
                cells += _at_scale(rows_of.get(level), level == own["default"][knob], groups)
            rows.append(list(cells))
    text = "".join(
        paragraph(
            f"{t['provenance']['scale'].capitalize()} scale: stored result of {t['provenance']['date']}, size "
            f"{t['provenance']['size']}, {t['provenance']['seeds']} seeds, {t['provenance']['runs']} runs, "
            f"{t['provenance']['processor_time_s'] / 60:.0f} min of processor time; `{t['provenance']['made_by']}` makes it anew."
        )
        for t in others
    )
    text += paragraph(
        "Price in moist and in dry runs, error in fraction retained and in liquid shares. Green: the scale's default. Errors are "
        "against the finest level of the same scale; pale where chance may have made them."
    )
    return text + html_table(header, rows) + "".join(_fronts(t) + _live_with(t) for t in others)


def _at_scale(row: dict[str, Any] | None, default: bool, groups: tuple[str, ...]) -> list[Cell]:
    if row is None:
        return [Cell("–", "none")] * (2 + len(groups))
    prices = [_price(row["price"].get(kind)) for kind in ("moist", "dry")]
    if default:
        prices = [replace(cell, grade="good") if cell.text != "–" else cell for cell in prices]
    return [*prices, *(_error_cell(row["errors"], group) for group in groups)]


def _seeds(table: dict[str, Any], kept: Sequence[dict[str, Any]]) -> str:
    rows: list[list[Cell | str]] = []
    for scene, quantities in table["spread_over_seeds"].items():
        for name, values in quantities.items():
            if len(values) > 1:
                text = next((f"{q.group}, {q.text}" for q in QUANTITIES if q.name == name), name)
                middle = sum(values) / len(values)
                deviation = (sum((v - middle) ** 2 for v in values) / (len(values) - 1)) ** 0.5
                rows.append([Cell(f"{scene}: {text}"), f"{middle:.4g}", f"{deviation:.2g}", str(len(values))])
    ends = table["spread_over_seeds"].get("moist", {}).get("retained_end", [])
    passed = (
        f" By the end of these moist runs {100 * (1 - sum(ends) / len(ends)):.0f} % of the feed had passed."
        if ends
        else ""
    )
    text = paragraph(
        "The same case from another first arrangement of the spheres is another run. What two settings differ by counts "
        "only where it is more than that: a difference within the 99 % interval of the seeds is called not resolved."
        + passed
    )
    figure = _picture(
        figures.seeds(kept),
        "Grey: the default with every seed. Lines: means over the seeds of the coarsest (dashed) and finest level.",
    )
    return text + figure + html_table(["quantity", "mean of the default", "standard deviation", "seeds"], rows)


def _times(kept: Sequence[dict[str, Any]], table: dict[str, Any]) -> str:
    machine = cost.kept()
    text = paragraph(
        "Seconds = steps (c0 + c1 spheres + c2 triangles + c3 bridges) + neighbour lists (c4 spheres + c5 triangles), the six "
        "costs measured on this machine by seven short runs. `pywet plan CASE --accuracy 2%` predicts a case before it is run."
    )
    if machine is None:
        return text + paragraph("This machine has not been measured yet.", soft=True)
    pairs = predictions(kept, machine, cost.Habit(**table["habit"]))
    if not pairs:
        return text
    inside = sum(2 / 3 <= p / m <= 1.5 for _, m, p in pairs)
    caption = f"{inside} of {len(pairs)} screening runs of the study are within a factor of 1.5 of the prediction."
    return text + _picture(figures.times(pairs), caption)


def predictions(
    kept: Sequence[dict[str, Any]], machine: cost.Coefficients, habit: cost.Habit
) -> list[tuple[str, float, float]]:
    """Scene, measured and predicted processor time [s] of the time loop of every screening run on one rank."""
    found = []
    for run in kept:
        if run["scene"] in runs.SCREENING and not run["failed"] and run["setting"]["ranks"] == 1:
            duration = run["steps"] * run["time_step_s"]
            lists = min(duration * habit.speed / (0.5 * cost.SKIN * cost.SMALLEST_M), run["steps"])
            bridges = habit.bridges_per_sphere * run["spheres"] if run["scene"] == "moist" else 0.0
            load = cost.Load(run["steps"], lists, run["spheres"], run["triangles"], bridges)
            found.append((run["scene"], run["loop_cpu_s"], machine.seconds(load)))
    return found


def _numbers(table: dict[str, Any]) -> str:
    rows: list[list[Cell | str]] = []
    for knob, levels in table["knobs"].items():
        for row in levels:
            default = row["level"] == table["default"][knob]
            name = f"{KNOBS[knob].title}: {row['level']}{' (default)' if default else ''}"
            prices = [_price(row["price"].get(kind)) for kind in ("moist", "dry")]
            rows.append([Cell(name), *prices, *(_error_cell(row["errors"], group) for group in GROUPS)])
            rows += [[Cell(f"{name} failed: {why}", "bad")] for why in row["failed"]]
    text = paragraph(
        "Price: processor time of the engine's time loop over that of the default in the same round, median and range over the "
        "seeds (wall time for ranks). Error: the largest of the group in per cent, ± the 99 % interval of chance; pale where "
        "it is not resolved; the rest when pointed at."
    )
    return text + html_table(["setting", "price moist", "price dry", *GROUPS], rows)


def _price(price: dict[str, float] | None) -> Cell:
    if price is None:
        return Cell("–", "none")
    return Cell(f"{price['ratio']:.2f}", "", f"{price['low']:.2f} to {price['high']:.2f}")


def _error_cell(errors: Sequence[dict[str, Any]], group: str) -> Cell:
    own = [e for e in errors if e["group"] == group]
    if not own:
        return Cell("–", "none")
    worst = max(own, key=lambda e: (abs(e["value"]) > e["limit"], abs(e["value"])))
    value, limit = 100 * abs(worst["value"]), 100 * worst["limit"]
    hint = "; ".join(f"{e['scene']} {e['quantity']} {100 * e['value']:+.2g} ± {100 * e['limit']:.2g}" for e in own)
    if value == 0.0:
        return Cell("0", "", hint)
    return Cell(f"{value:.2g} ± {limit:.1g}" if limit else f"{value:.2g}", "" if value > limit else "none", hint)


def _picture(figure: Figure, caption: str) -> str:
    html = picture(figure, caption)
    plt.close(figure)
    return html


def _footer(made: dict[str, Any], size: str) -> str:
    return (
        f"Made on {made['date']} on {made['machine']['processor']} ({made['machine']['cores']} cores), size {size}; wall time "
        f"was {made['wall_over_processor_time']} times the processor time (1 on a quiet machine); renew the stored "
        f"table with `pywet study accuracy --size {size} --store`."
    )
