"""docs/full_scale.md and its figures, made from the stored tables alone: `python -m studies.full_scale.page`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import typer

from pywet import config as settings
from pywet.config import Config
from pywet.errors import border
from pywet.report import plots
from pywet.report.collect import CaseResult
from pywet.report.pictures import STYLE, plt, svg
from pywet.util.files import atomic_write
from studies.full_scale import basis, headline, kept, reasons, retirement, spread, stroke, trials
from studies.full_scale.judging import FAILS, MISSING, OPEN, Answer, Statement, judge, neighbours
from studies.full_scale.kept import Kept
from studies.full_scale.spread import Runs
from studies.full_scale.statements import STATEMENTS

FOLDER = Path("docs/full_scale")
SEEDED, SEEDS = (1, 2, 10, 11), 3
"""Cases that are to have so many seeds, and a run with the paper's stiffness."""
FIGURES = {
    "fig10": ("Fig. 10: dry, fraction retained", plots.dry),
    "fig12": ("Fig. 12: fraction retained and liquid", plots.moisture),
    "fig13": ("Fig. 13: by size class", plots.classes),
    "fig15": ("Fig. 15: where the liquid is", plots.liquid),
}
FIRST = "fig12"
"""Figure that opens the page."""
PICTURES = {
    "fig11a": "Fig. 11a: case 3 three seconds after the opening; darker spheres have thicker films",
    "fig11b": "Fig. 11b: the same close by; bridges as cuboids of their volume",
}
"""Made by `pictures.py` from a run itself, which is not kept."""
METHOD = """
## Method

The 18 screening cases of Elskamp & Kruggel-Emden (2018) on their 200 mm sieve for 20 s; times count from the opening of the
slide. `make full` runs the cases and stores their tables in `docs/full_scale/data`, from which
`python -m studies.full_scale.page` makes this page. A statement of the paper is a range that its words allow
(`studies/full_scale/statements.py`). The ranges were fixed when these 18 cases were known and before any other run is
judged; their digest is stored with each later run. By an earlier, one-sided list 23 of the statements 1 to 39 were confirmed, 12
not and 4 inconclusive.
"""

COMMITS = {
    "3cef7a2": "`1d46192` with the fix of `8d56677` in `reference_impl/replay/formations.py`",
    "18fe5ad": "`16a5c35` with the walls' displacement as the engine sums it (`pywet/geometry/motion.py`)",
}
"""Commit that tables name and the history lacks -> what it is."""

BEYOND = """
## What the paper says its model lacks

In the paper fines and bin get too little water, coarse material and screen too much, for want of "vibrating dewatering". Here
liquid can be shed in free motion and can have weight ([effects](effects.md#effects-in-no-preset)).
{full}

At smoke scale, {time:.1f} s after the opening, one seed each (`python -m studies.full_scale.trials`), in % of all liquid:
"""
SWITCHED = ("shedding", "liquid_weight")
"""Names of variants that are the campaign's settings with this effect on."""


def honest(runs: Runs) -> str:
    """What the page can be trusted with."""
    seeded = [str(n) for n in sorted(runs) if len(runs[n]) > 1]
    several = f"Several seeds of cases {', '.join(seeded)}, one of each other" if seeded else "One seed of each case"
    return f"""## Limits

{several}; contact stiffness below the paper's; and dimensions of the apparatus that the paper does not give
([rig](rig.md)). Cases of one seed are given the spread of their neighbour at the same time; with 5.6 mm, where passage is four
times as slow, this is too small late in the run. A statement that is not confirmed shows first that this simulation differs from
the paper's; where no reason is given, settings, apparatus and model are all possible.
"""


def page_text(data: Path = FOLDER / "data", config: Config | None = None) -> str:
    """Write the figures beside `data` and return the page's text."""
    config = config or settings.load(Path("config"))
    variants = kept.variants(data)
    runs = variants.pop("", {})
    answers = [(s, judge(s, runs)) for s in STATEMENTS]
    failed, open_ = ([s.number for s, answer in answers if answer.verdict == of] for of in (FAILS, OPEN))
    known = reasons.lines([n for n in open_ if n in reasons.REASONS], runs)
    results = [_result(config, number, runs) for number in sorted(runs)]
    lines = [
        *headline.lines(runs, answers),
        *(_drawn(data.parent, FIRST, results) if runs else []),
        METHOD,
        "## Runs\n",
        *_runs(config, runs, variants),
        *_price(runs),
        *_lacking(runs, variants.get("paper", {})),
        *basis.lines(),
        *spread.lines(runs, variants.get("paper", {}), SEEDED),
        *retirement.lines(runs, variants.get(retirement.VARIANT, {})),
        "\n## Statements\n",
        *_statements(answers),
        *(["\n## Why a statement is not confirmed\n", *reasons.lines(failed, runs)] if failed else []),
        *(["\n## Inconclusive statements\n", *known] if known else []),
        *_beyond(runs, variants),
    ]
    if runs:
        lines += ["\n## Figures\n", *_figures(data.parent, stroke.fig9(config), results, runs, variants)]
    lines += ["\n" + honest(runs)]
    return "\n".join(lines).replace("\n\n\n", "\n\n").rstrip() + "\n"


def _runs(config: Config, runs: Runs, others: Mapping[str, Runs]) -> list[str]:
    rows = [k for group in (runs, *others.values()) for number in sorted(group) for k in group[number]]
    missing = [n for n in sorted(config.cases) if not runs.get(n)]
    said = [f"Not run yet: {', '.join(map(str, missing))}."] if missing else ["All cases are there."]
    if not rows:
        return said
    head = (
        "| run | settings | core-hours | formations | contacts replayed | ledger | replay | Y at 5, 10, 20 s "
        "| coarse, fines, walls at the end | engine, replay, disk [GB] | replay, processor time [s] |"
    )
    return [*said, "", head, "|" + "---|" * 11, *(_row(config, k) for k in rows), *_commits(rows)]


def _commits(rows: Sequence[Kept]) -> list[str]:
    named = {k.about["commit"] for k in rows}
    lost = [f"`{commit}` is {what}." for commit, what in COMMITS.items() if commit in named]
    return ["\nThe `run.json` of a run names the commit that made it; " + " ".join(lost)] if lost else []


def _price(runs: Runs) -> list[str]:
    """Processor time of moist cases over that of their dry case with the same seed, of runs that were not interrupted."""
    whole = {
        (n, int(k.about["seed"])): float(k.about["cpu_s"])
        for n, of in runs.items()
        for k in of
        if k.about["cpu_s"] is not None and k.about["resumed_at_step"] is None
    }
    ratios = [
        t / whole[dry, seed] for (n, seed), t in whole.items() if (dry := n - (n - 1) % 3) != n and (dry, seed) in whole
    ]
    if not ratios:
        return []
    return [
        f"\nA moist case takes {np.median(ratios):.2f} times the processor time of its dry one in the median, "
        f"{min(ratios):.2f} to {max(ratios):.2f} ({len(ratios)} pairs of one seed, on a loaded machine, several versions)."
    ]


def _lacking(runs: Runs, stiff: Runs) -> list[str]:
    """What the page cannot say for want of runs."""
    seeds = ", ".join(str(len(runs.get(n, ()))) for n in SEEDED)
    lines = ["", "–: not recorded, or nothing to replay.\n"]
    if any(len(runs.get(n, ())) < SEEDS for n in SEEDED):
        lines += [
            f"- **Missing: {SEEDS} seeds of cases {', '.join(map(str, SEEDED))}** (there are {seeds}). The scatter at full",
            "  scale is measured with fewer, or taken as none where there is one.",
        ]
    left = [n for n in SEEDED if not stiff.get(n)]
    if left:
        lines += [
            f"- **Missing: cases {', '.join(map(str, left))} with the paper's stiffness.** The effect of a lower one",
            "  is taken from the reduced scale (below), not measured.",
        ]
    return lines


def _row(config: Config, k: Kept) -> str:
    about = k.about
    fractions = ", ".join(f"{k.at(k.retained(), t):.3f}" if k.has(t) else "–" for t in (5.0, 10.0, 20.0))
    liquid, events, ledger = "–", "–", "–"
    if about["events"]:
        liquid = ", ".join(
            f"{100 * float(v[-1]):.1f} %" for v in (k.liquid("coarse_material"), k.liquid("fines"), k.walls)
        )
        events, ledger = f"{about['events']['formations']:,}", f"{about['ledger_error']:.0e}"
    replay = about["replay"]
    agreed = f"{len(replay)} quantities agree" if replay else "nothing to replay"
    hours = "–" if about["cpu_s"] is None else f"{about['cpu_s'] / 3600:.2f}"
    if about["resumed_at_step"] is not None:  # what was spent before a kill is not known
        hours = f"> {hours}"
    own = max(s.stiffness_sphere_sphere_N_per_m.value for s in config.materials.spheres.values())
    stiffness = f"stiffness {about['normal_stiffness_N_per_m'] / own:.2g}"
    chosen = f"{about['scale']}, {stiffness}, dt {1e6 * about['time_step_s']:.3g} µs"
    counts = f"{events} | {about['contacts']:,} | {ledger}"
    sizes = ", ".join(_size(about.get(key)) for key in ("peak_memory_B", "replay_peak_memory_B", "disk_B"))
    took = "–" if about.get("replay_cpu_s") is None else f"{about['replay_cpu_s']:.0f}"
    ends = f"{agreed} | {fractions} | {liquid} | {sizes} | {took}"
    return f"| {k.folder.name} | {chosen} | {hours} | {counts} | {ends} |"


def _size(number: float | None) -> str:
    return "–" if number is None else f"{1e-9 * number:.2f}"


def _statements(answers: Sequence[tuple[Statement, Answer]]) -> list[str]:
    return [
        "±: half the 95 % interval of the mean over seeds; where the cases of a statement have one seed in common, the scatter",
        "of their neighbour (8 mm, 1 mm, the same material, dry or with 5 %). A statement with a limit within it is",
        "inconclusive.",
        "Y: fraction retained, U: undersize on the screen over undersize fed.\n",
        "| | place | statement | numbers | answer |",
        "|" + "---|" * 5,
        *(_answer(s, a) for s, a in answers),
    ]


def _division(run: Kept, title: str) -> float:
    """Share of all liquid at the end in a division of Fig. 14; a liquid reservoir that a run's table lacks has none."""
    have = run.tables["liquid_by_holder"].columns
    return sum(float(run.liquid(h)[-1]) for h in trials.FIG14[title] if f"{h}_m3" in have)


DIVISIONS = {title: partial(_division, title=title) for title in trials.FIG14}


def _full_beyond(runs: Runs, variants: Mapping[str, Runs]) -> str:
    """What is known at full scale of effects in no preset."""
    lines = []
    for effect in SWITCHED:
        cases = sorted(variants.get(effect, {}))
        if table := spread.rows(runs, variants.get(effect, {}), cases, DIVISIONS | spread.DRY):
            said = f"At full scale, one run each of cases {', '.join(map(str, cases))} with `{effect}`; shares are of all liquid"
            lines += [f"\n{said} at 20 s:\n", *spread.head(f"with {effect}"), *table]
    left = [f"`{effect}`" for effect in SWITCHED if effect not in variants]
    return "\n".join([*lines, *([f"\nNo run at full scale has {' or '.join(left)}."] if left else [])])


def _beyond(runs: Runs, variants: Mapping[str, Runs]) -> list[str]:
    if not trials.FIG14_FILE.exists():
        return []
    table = pd.read_csv(trials.FIG14_FILE)
    rows = [
        f"| {row.case} | {row.trial.replace('_', ' ')} | "
        + " | ".join(f"{100 * share:.1f}" for share in row[list(trials.FIG14)])
        + f" | {row.fraction_retained:.3f} |"
        for _, row in table.iterrows()
    ]
    return [
        BEYOND.format(time=table["time_since_opening_s"].iloc[0], full=_full_beyond(runs, variants)),
        f"| case | switched on | {' | '.join(trials.FIG14)} | fraction retained |",
        "|" + "---|" * (len(trials.FIG14) + 3),
        *rows,
        "\n" + "; ".join(_moved(table, trial) for trial in ("shedding", "liquid_weight")) + ", of all liquid.",
        "A minus means that it has more there. With one seed the effect of weight is inconclusive, and so is how much of the",
        "difference shedding makes ([what accuracy costs](accuracy.md)).",
    ]


def _moved(table: pd.DataFrame, trial: str) -> str:
    """What a trial takes from the coarse material and the screen, of all liquid."""
    left = table.set_index(["trial", "case"])[list(trials.FIG14)[1]]
    each = [f"{100 * (left['as_is', case] - left[trial, case]):.1f} % in case {case}" for case in left[trial].index]
    return f"`{trial}` takes {' and '.join(each)} from coarse material and screen"


def _answer(statement: Statement, answer: Answer) -> str:
    parts = []
    for k, part in enumerate(statement.parts):
        values = "" if answer.verdict == MISSING else ": " + ", ".join(f"{v:.3g}" for v in answer.values[k])
        values += f" ± {answer.chance[k]:.2g}" if answer.chance and answer.chance[k] else ""
        parts.append((part.range + values).replace("|", "\\|"))
    return f"| {statement.number} | {statement.place} | {statement.says} | {'; '.join(parts)} | {answer.verdict} |"


def _drawn(folder: Path, name: str, results: Sequence[CaseResult]) -> list[str]:
    title, draw = FIGURES[name]
    return _figure(folder, name, title, plots.grid(draw(results)))


def _figures(
    folder: Path, path: str, results: Sequence[CaseResult], runs: Runs, variants: Mapping[str, Runs]
) -> list[str]:
    lines = _figure(folder, "fig09", "Fig. 9: path of the screen over one period, as configured", path)
    for name in FIGURES:
        lines += _drawn(folder, name, results) if name != FIRST else []
    lines += [
        f"![{title}](full_scale/{name}.webp)\n"
        for name, title in PICTURES.items()
        if (FOLDER / f"{name}.webp").exists()
    ]
    pair = [of[n][0] for of in (runs, *(variants.get(e, {}) for e in SWITCHED)) for n in (2, 11) if of.get(n)]
    return lines + _figure(folder, "fig14", "Fig. 14: liquid at the end, cases 2 and 11", fig14(pair))


def _figure(folder: Path, name: str, title: str, svg: str) -> list[str]:
    if not svg:
        return []
    with atomic_write(folder / f"{name}.svg") as partial:
        partial.write_text(svg)
    return [f"![{title}](full_scale/{name}.svg)\n"]


def _result(config: Config, number: int, runs: Runs) -> CaseResult:
    """A case for the figures; its band is made by its other seeds, or by those of its neighbour."""
    k, *others = runs[number]
    share = {"coarse_share": k.about["coarse_share"]}
    seeds = tuple(one.tables["fraction_retained"] for one in others or neighbours(number, runs))
    retained, liquid = k.tables["fraction_retained"], k.tables["liquid_by_holder"]
    return CaseResult(config.case(number), (), summary=share, retained=retained, liquid=liquid, seeds=seeds)


def fig14(pair: Sequence[Kept]) -> str:
    """Bars of the paper's divisions of the apparatus at the end of the runs, as they are and with effects switched on."""
    if not pair:
        return ""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(7.0, 3.2), layout="constrained")
        places, wide = np.arange(len(trials.FIG14)), 0.8 / len(pair)
        for k, run in enumerate(pair):
            heights = [100 * of(run) for of in DIVISIONS.values()]
            effect = str(run.about.get("variant", "")).replace("_", " ")
            axes.bar(places + k * wide, heights, 0.95 * wide, label=f"case {run.case}{effect and ', ' + effect}",
                     color=plots.CONFIGURATION[k % len(plots.CONFIGURATION)])  # fmt: skip
        axes.set_xticks(places + 0.5 * wide * (len(pair) - 1), list(trials.FIG14))
        axes.set_ylabel("share of the liquid in %")
        axes.legend()
        return svg(figure, transparent=True)


def main() -> None:
    """Write docs/full_scale.md."""
    text = page_text()
    with atomic_write(FOLDER.with_suffix(".md")) as partial:
        partial.write_text(text)
    typer.echo(f"{FOLDER.with_suffix('.md')} is written")


if __name__ == "__main__":
    with border():
        main()
