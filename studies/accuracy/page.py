"""The study's page: positions of the defaults, cost of an accuracy, pictures first, all numbers last."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.cost import choice
from pywet.errors import PywetError
from pywet.report.page import Card, Cell, Section, paragraph, picture
from pywet.report.page import table as html_table
from pywet.report.page import write as write_frame
from studies.accuracy import blocks, figures
from studies.accuracy.errors import GROUPS, QUANTITIES
from studies.accuracy.parameters import PARAMETERS


def write_page(
    path: Path,
    table: dict[str, Any],
    runs: pd.DataFrame,
    size: str,
    others: Sequence[dict[str, Any]] = (),
    times: pd.DataFrame | None = None,
) -> Path:
    """Write the page and return its path.

    `others` are stored tables, shown for comparison; `times`: scene, measured and predicted seconds of runs.
    """
    standings = blocks.all_standings(table)
    beaten = [s for s in standings if s.verdict == "beaten"]
    made = table["provenance"]
    cards = [
        Card(
            f"{sum(s.verdict == 'on the front' for s in standings)} of {len(standings)}",
            "settings whose default is on the front",
        ),
        Card(
            str(sum(s.verdict == "not distinguished" for s in standings)),
            "times a cheaper level differs by no more than chance",
        ),
        Card(str(len(beaten)), "times another level is as cheap and better", "bad" if beaten else "good"),
        *_cost_cards(table),
        Card(f"{made['processor_time_s'] / 60:.0f} min", f"of processor time, {made['runs']} runs"),
    ]
    sections = [
        Section("If you can live with …", blocks.live_with(table), "choose"),
        Section("The fronts: error against cost", blocks.fronts(table), "fronts"),
        Section("Where the defaults stand", blocks.rank_table(table, standings), "defaults"),
        *(_parameters(table, group) for group in GROUPS),
        *([Section("Larger studies, stored", blocks.alongside(table, others), "stored")] if others else []),
        Section("What scatter of the inputs does", blocks.scattered(choice.stored()["scales"]["smoke"]), "inputs"),
        Section("What chance alone does", _seeds(table, runs, size), "seeds"),
        Section("How long a run takes", _times(times), "times"),
        Section("Every number", _numbers(table), "numbers"),
    ]
    lead = (
        "Each setting of a run against a finer one: how wrong it makes what you want to know, and what it costs. "
        f"{made['scale'].capitalize()} scale, size {made['size']}, {blocks.seeds_in_words(made)}."
    )
    return write_frame(path, "What accuracy costs", lead, sections, cards, _footer(made, size))


def _cost_cards(table: dict[str, Any]) -> list[Card]:
    try:
        chosen = choice.choose(table, 0.02, True)
    except PywetError:
        return [Card("none", "settings have errors counted below 2 % in everything")]
    return [Card(f"{chosen.cost:.2g} ×", "the default's cost, for errors counted below 2 % in everything, moist")]


def _parameters(table: dict[str, Any], group: str) -> Section:
    figure = figures.setting_panels(table, group)
    names = "; ".join(q.text for q in QUANTITIES if q.group == group)
    if figure is None:
        return Section(group.capitalize(), paragraph("No setting changes it."), group)
    text = (
        "One setting changed at a time, against its finest level. Red ring: the default. Filled: resolved; hollow: within what "
        "the seeds differ by; the line upwards is how large it may be. Triangles at the foot: no error (the finest level itself)."
    )
    message = paragraph(f"{names[0].upper()}{names[1:]}. The largest of them is drawn.")
    return Section(group.capitalize(), message + picture(figure, text), group)


def _seeds(table: dict[str, Any], runs: pd.DataFrame, size: str) -> str:
    rows: list[list[Cell | str]] = []
    for scene, quantities in table["spread_over_seeds"].items():
        for name, values in quantities.items():
            if len(values) > 1:
                text = next((f"{q.group}, {q.text}" for q in QUANTITIES if q.name == name), name)
                cells = f"{np.mean(values):.4g}", f"{np.std(values, ddof=1):.2g}", str(len(values))
                rows.append([Cell(f"{scene}: {text}"), *cells])
    ends = table["spread_over_seeds"].get("moist", {}).get("retained_end", [])
    passed = (
        f" By the end of these moist runs {100 * (1 - np.mean(ends)):.0f} % of the feed had passed." if ends else ""
    )
    text = paragraph(
        "The same case from another first arrangement of the spheres is another run. What two settings differ by counts "
        "only where it is more than that: a difference within the 99 % interval of the seeds is called not resolved."
        + passed
    )
    figure = picture(
        figures.seeds(runs, size),
        "Grey: the default with every seed. Lines: means over the seeds of the coarsest (dashed) and finest level.",
    )
    return text + figure + html_table(["quantity", "mean of the default", "standard deviation", "seeds"], rows)


def _times(times: pd.DataFrame | None) -> str:
    text = paragraph(
        "What a run asks for, from its scene, times what that costs on this machine, from short runs of spheres on a lattice. "
        "`pywet plan CASE --accuracy 2%` predicts a case before it is run."
    )
    if times is None:
        return text + paragraph("This machine has not been measured yet.", soft=True)
    if times.empty:
        return text
    inside = (times["predicted"] / times["measured"]).between(2 / 3, 1.5).sum()
    caption = f"{inside} of {len(times)} screening runs of the study are within a factor of 1.5 of the prediction."
    return text + picture(figures.times(times), caption)


def _numbers(table: dict[str, Any]) -> str:
    rows: list[list[Cell | str]] = []
    for parameter, levels in table["parameters"].items():
        for row in levels:
            default = row["level"] == table["default"][parameter]
            name = f"{PARAMETERS[parameter].title}: {row['level']}{' (default)' if default else ''}"
            costs = [blocks.cost_cell(row["cost"].get(kind)) for kind in ("moist", "dry")]
            rows.append([Cell(name), *costs, *(blocks.error_cell(row["errors"], group) for group in GROUPS)])
            rows += [[Cell(f"{name} failed: {why}", "bad")] for why in row["failed"]]
    text = paragraph(
        "Cost: processor time of the engine's time loop over that of the default in the same round, median and range over the "
        "seeds (wall time for ranks). Error: the largest of the group in per cent, ± the 99 % interval of chance; pale where "
        "it is not resolved; the rest when pointed at."
    )
    return text + html_table(["setting", "cost moist", "cost dry", *GROUPS], rows)


def _footer(made: dict[str, Any], size: str) -> str:
    return (
        f"Made on {made['date']} on {made['machine']['processor']} ({made['machine']['cores']} cores), size {size}; wall time "
        f"was {made['wall_over_processor_time']} times the processor time (1 on a quiet machine); renew the stored "
        f"table with `pywet study accuracy --size {size} --store`."
    )
