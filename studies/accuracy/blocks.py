"""Parts of the study's page that are made from a table alone, for this study and for stored ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

from pywet.cost import choice
from pywet.errors import PywetError
from pywet.report.page import Cell, paragraph, picture
from pywet.report.page import table as html_table
from studies.accuracy import figures, ranking, scatter
from studies.accuracy.errors import GROUPS
from studies.accuracy.parameters import PARAMETERS

ACCURACIES = (0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005)
WISHES = {
    "everything": choice.WANTED,
    "fraction retained and liquid": ("fraction retained", "liquid shares"),
    "restitution": ("restitution",),
}
"""Purpose -> groups of quantities that it requires."""
GRADE = {"on the front": "good", "not distinguished": "fair", "beaten": "bad"}


def _everywhere(table: dict[str, Any], asked: Callable[..., Any]) -> list[Any]:
    """Apply a function to every setting whose levels differ, kind of case and group that was measured."""
    found = [
        asked(table, parameter, kind, group)
        for kind in choice.SCENES
        for parameter in PARAMETERS
        if not PARAMETERS[parameter].exact_pair
        for group in GROUPS
    ]
    return [f for f in found if f is not None]


def all_standings(table: dict[str, Any]) -> list[ranking.Rank]:
    return _everywhere(table, ranking.rank)


def live_with(table: dict[str, Any]) -> str:
    rows: list[list[Cell | str]] = []
    for kind in ("moist", "dry"):
        for wish, wanted in WISHES.items():
            groups = tuple(g for g in wanted if kind == "moist" or g in ("fraction retained", "restitution"))
            last: list[str] = []
            for accuracy in ACCURACIES:
                with suppress(PywetError):  # no settings reach this accuracy
                    chosen = choice.choose(table, accuracy, kind == "moist", groups)
                    words = [f"{PARAMETERS[k].title} {v}" for k, v in chosen.levels.items() if v != table["default"][k]]
                    message = [", ".join(words) or "the defaults", f"{chosen.cost:.2f}\u00a0×"]
                    if message != last:
                        errors = (f"{100 * max(of.values()):.2g} %" for of in (chosen.error, chosen.bound))
                        of = Cell(f"{kind}: {wish}"), Cell(f"{100 * accuracy:g} %")
                        rows.append([*of, Cell(message[0], left=True), message[1], *errors])
                    last = message
    text = paragraph(
        "The cheapest settings whose errors, added up over the settings, stay below what you can live with. A cheaper setting "
        "must be shown right: what chance alone may have hidden is counted against it, but not against the default or a finer "
        "one; the upper bound counts it against all. Rows that choose the same as the one "
        "above are left out. The same from the command line: `pywet plan 2 --accuracy 2%`."
    )
    return text + html_table(
        ["what counts", "you can live with", "choose", "cost", "error, counted", "upper bound"], rows
    )


def fronts(table: dict[str, Any]) -> str:
    return picture(
        figures.fronts(table),
        "Lower left is better. Each line is the lowest cost for an error, over all combinations of time step, springs, "
        "facets, law, integration and impulses; rings: the defaults, counted the same way. What chance may hide counts in full "
        "against a cheaper setting and not at all against the default or a finer one, so that a ring at the foot says: nothing "
        "was found wrong with it. A ring to the right of its line could have had the same for less.",
    )


def rank_table(table: dict[str, Any], standings: Sequence[ranking.Rank]) -> str:
    order = {(s.kind, s.setting, s.group): s for s in standings}
    rows: list[list[Cell | str]] = []
    for kind in ("moist", "dry"):
        for parameter in PARAMETERS:
            ranks = [order.get((kind, parameter, group)) for group in GROUPS]
            if any(ranks):
                cells = [Cell("–", "none") if s is None else _rank_cell(s) for s in ranks]
                rows.append([Cell(f"{kind}: {PARAMETERS[parameter].title}"), *cells])
    message = [
        paragraph(f"{PARAMETERS[s.setting].title.capitalize()}, {s.kind}, {s.group}: {s.verdict_text}.")
        for s in standings
        if s.verdict == "beaten"
    ] or [paragraph("No level of any setting is as cheap and better than the default beyond doubt.")]
    message += [paragraph(text) for text in bargains(table)]
    return "".join(dict.fromkeys(message)) + html_table(["setting", *GROUPS], rows)


def _rank_cell(rank: ranking.Rank) -> Cell:
    grade: Any = GRADE[rank.verdict]
    by = "" if rank.by is None else f" ({figures.SHORT.get(str(rank.by), rank.by)})"
    return Cell(rank.verdict + by, grade, rank.verdict_text)


def bargains(table: dict[str, Any]) -> list[str]:
    """Return one sentence for each setting that gains much accuracy at little additional cost."""
    sentences = _everywhere(table, ranking.bargain)
    if any(text.startswith("Capillary law") for text in sentences):
        sentences.append(
            "The default law stays because the cases reproduce a paper that uses it; where the physics counts, take "
            "`preset: exact` under `laws:` in config.yaml."
        )
    return sentences


def alongside(table: dict[str, Any], others: Sequence[dict[str, Any]]) -> str:
    """Tabulate the costs and errors of several scales and sizes, and the settings to be chosen there."""
    tables, groups = (table, *others), ("fraction retained", "liquid shares")
    names = [_name(t) for t in tables]
    header = ["setting"] + [f"{name}: {what}" for name in names for what in ("moist", "dry", *groups)]
    rows: list[list[Cell | str]] = []
    for parameter in PARAMETERS:
        by_level = [{row["level"]: row for row in t["parameters"].get(parameter, ())} for t in tables]
        for level in dict.fromkeys(level for rows_of in by_level for level in rows_of):
            cells = [Cell(f"{PARAMETERS[parameter].title}: {level}")]
            for rows_of, study in zip(by_level, tables, strict=True):
                cells += _at_scale(rows_of.get(level), level == study["default"].get(parameter), groups)
            rows.append(list(cells))
    text = "".join(
        paragraph(
            f"{_name(t).capitalize()}: stored result of {t['provenance']['date']}, {seeds_in_words(t['provenance'])}, "
            f"{t['provenance']['runs']} runs, {t['provenance']['processor_time_s'] / 60:.0f} min of processor time; "
            f"`{t['provenance']['made_by']}` makes it again."
        )
        for t in others
    )
    text += paragraph(
        "Cost in moist and in dry runs, error in fraction retained and in liquid shares. Green: the scale's default. Errors are "
        "against the finest level of the same scale; pale where chance may have made them."
    )
    chosen = "".join(
        f"<h3>{_name(t).capitalize()}</h3>{fronts(t)}{live_with(t)}{rank_table(t, all_standings(t))}" for t in others
    )
    return text + html_table(header, rows) + chosen


BESIDE = (("fraction", 0.1), ("fraction", 0.05), ("stiffness", 0.003), ("stiffness", 0.01))
"""Settings with which the scatter of inputs is compared."""


def scatter_rows(table: dict[str, Any]) -> list[list[str]]:
    """Return the effect of the inputs' scatter on the fraction retained [% of the feed], then errors of settings of the table."""
    columns = [(scene, quantity) for scene in ("dry", "moist") for quantity in scatter.QUANTITIES]
    made = scatter.effects(scatter.stored(), table).set_index(["input", "level"])
    names = {(n, 1): f"{i.title} ± {100 * i.between:.2g} %" for n, i in scatter.INPUTS.items()}
    names |= {("bridges_every", n): f"{PARAMETERS['bridges_every'].title} {n}" for n in scatter.STEPS}
    of = {name: made.loc[[key]].to_dict("records") for key, name in names.items()}
    for parameter, level in BESIDE:
        (row,) = (r for r in table["parameters"][parameter] if r["level"] == level)
        of[f"{PARAMETERS[parameter].title} {level}"] = row["errors"]
    cells = {
        name: {(e["scene"], e["quantity"]): f"{100 * e['value']:+.2g} ± {100 * e['limit']:.2g}" for e in errors}
        for name, errors in of.items()
    }
    return [[name, *(values.get(column, "–") for column in columns)] for name, values in cells.items()]


def scattered(table: dict[str, Any]) -> str:
    """Make the part of the page on the scatter of inputs."""
    made = scatter.stored()
    text = paragraph(
        f"Each input one standard deviation up and down, half of what that changes, {made['seed'].nunique()} seeds; then "
        "settings against their finest level. In % of the feed, ± the 99 % limit of chance. Where the numbers are from: "
        + "; ".join(f"{i.title}: {i.source}" for i in scatter.INPUTS.values())
        + ". That POM scatters as glass does is an assumption."
    )
    header = ["input or setting", "dry: mean", "dry: at the end", "moist: mean", "moist: at the end"]
    return text + html_table(header, [[Cell(first), *rest] for first, *rest in scatter_rows(table)])


def seeds_in_words(made: dict[str, Any]) -> str:
    """Describe the number of seeds of a study."""
    dry = made.get("dry_seeds", made["seeds"])
    return f"{made['seeds']} seeds" + ("" if dry == made["seeds"] else f" ({dry} of dry screening)")


def _name(table: dict[str, Any]) -> str:
    made = table["provenance"]
    return f"{made['scale']} scale" + ("" if made["size"] == made["scale"] else f", {made['size']}")


def _at_scale(row: dict[str, Any] | None, default: bool, groups: tuple[str, ...]) -> list[Cell]:
    if row is None:
        return [Cell("–", "none")] * (2 + len(groups))
    costs = [cost_cell(row["cost"].get(kind)) for kind in ("moist", "dry")]
    if default:
        costs = [replace(cell, grade="good") if cell.text != "–" else cell for cell in costs]
    return [*costs, *(error_cell(row["errors"], group) for group in groups)]


def cost_cell(cost: dict[str, float] | None) -> Cell:
    if cost is None:
        return Cell("–", "none")
    return Cell(f"{cost['ratio']:.2f}", "", f"{cost['low']:.2f} to {cost['high']:.2f}")


def error_cell(errors: Sequence[dict[str, Any]], group: str) -> Cell:
    of_group = [e for e in errors if e["group"] == group]
    if not of_group:
        return Cell("–", "none")
    worst = max(of_group, key=lambda e: (abs(e["value"]) > e["limit"], abs(e["value"])))
    value, limit = 100 * abs(worst["value"]), 100 * worst["limit"]
    hint = "; ".join(f"{e['scene']} {e['quantity']} {100 * e['value']:+.2g} ± {100 * e['limit']:.2g}" for e in of_group)
    if value == 0.0:
        return Cell("0", "", hint)
    return Cell(f"{value:.2g} ± {limit:.1g}" if limit else f"{value:.2g}", "" if value > limit else "none", hint)
