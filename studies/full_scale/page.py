"""Make docs/full_scale.md and its figures from the stored tables alone: `python -m studies.full_scale.page`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np
import typer

from pywet import config as settings
from pywet.config import Config
from pywet.errors import border
from pywet.report import plots
from pywet.report.collect import CaseResult
from pywet.report.pictures import STYLE, colours, plt, svg
from pywet.util.files import atomic_write
from studies.full_scale import headline, reasons, retirement, run_table, spread, stored_runs, stroke, trials
from studies.full_scale.campaign import SETTINGS
from studies.full_scale.judging import FAILS, OPEN, Answer, Statement, judge, neighbours, redecided
from studies.full_scale.spread import Runs
from studies.full_scale.statements import STATEMENTS
from studies.full_scale.stored_runs import ALL, DEFAULT, SEEDS, StoredRun, mean

Answers = Sequence[tuple[Statement, Answer]]
FOLDER = Path("docs/full_scale")
STIFF, STIFF_RETIRED = "paper", f"{DEFAULT}_stiff"
"""Names of runs with the paper's stiffness: with all spheres, and with passed spheres retired.

Of them only moist ones are compared: the dry ones precede a correction that changed dry runs.
"""
THIRD = f"{STIFF_RETIRED}_third"
"""Such a rig with bridges in every third step."""
FIGURES = {
    "fig10": ("Fig. 10: dry, fraction retained", plots.dry),
    "fig12": ("Fig. 12: fraction retained and liquid", plots.moisture),
    "fig13": ("Fig. 13: by size class", plots.classes),
    "fig15": ("Fig. 15: where the liquid is", plots.liquid),
}
SAYS = {s.number: s.says for s in STATEMENTS}
FIRST = "fig12"
"""Figure that opens the page."""
PICTURES = {
    "fig11a": "Fig. 11a: case 3 three seconds after the opening; darker spheres have thicker films",
    "fig11b": "Fig. 11b: the same close by; bridges as cuboids of their volume",
}
"""Pictures made by `pictures.py` from a run itself, which is not stored."""
METHOD = """
## Method

The time step
is a tenth of the shortest collision time, and the contact stiffness is {stiffness}
([errors of these settings](accuracy.md)). {retired}
"""

AGAIN = f"`python -m studies.full_scale.rigs run {DEFAULT} --case N --seed S --data FOLDER`"
"""Command that repeats a stored run; without `--data` it finds the run stored."""
COMMITS = {
    "3cef7a2": "`1d46192` with the fix of `8d56677` in `reference_impl/replay/formations.py`",
    "18fe5ad": "`16a5c35` with the walls' displacement as the engine sums it (`pywet/geometry/motion.py`)",
    "785bb1f": "`d30a103a` with the replay of `9a54170c` (`reference_impl/motion/between.py`)",
}
"""Commits named in tables but missing from the history -> description."""

BEYOND = """
## What the paper says its model lacks

According to the paper, its model leaves too little water on fines and bin and too much on coarse material and screen, because
it has no "vibrating dewatering". Two [optional effects](effects.md#effects-in-no-preset) change this distribution:
`shedding` and `liquid_weight`.
{full}
"""
SWITCHED = ("shedding", "liquid_weight")
"""Variants that are the campaign's settings with this effect on."""
COARSE_LOOKS = "\nIn case 11 films were checked for drops every 7.7 ms only (today: every millisecond)."
"""3497 steps between outputs, divided by 13, of 2.86e-5 s each."""


def _seeds(runs: Runs) -> list[str]:
    """Write how many seeds the cases have, and how one with a single seed is judged."""
    single = [str(n) for n in sorted(runs) if len(runs[n]) == 1]
    if not single:
        return []
    return [
        f"- {'Case' if len(single) == 1 else 'Cases'} {', '.join(single)} with one seed only, judged by the scatter of the",
        "  most similar case with several seeds, which underestimates the scatter with apertures of 5.6 mm late in the run.",
    ]


def honest(runs: Runs, older: Runs) -> str:
    """Write the limits of the page; `older`: runs of an earlier version with which other runs of that version are compared."""
    lines = "\n".join(["## Limits", "", *_seeds(runs)])
    return f"""{lines}
- The paper does not give all dimensions of the apparatus ([sieve diameter](rig.md)).
  A statement that is not confirmed shows first that this simulation differs from the paper's.
- Most dry runs with [another sieve or reading](rig.md) and those with the paper's stiffness precede a correction: they keep
  [tangential displacements](engine.md#conventions) of separated spheres.
{_earlier(runs, older)}"""


def _earlier(runs: Runs, older: Runs) -> str:
    """Say which rows are of an earlier version, and how the liquid of the walls in case 2 differs; empty without such runs."""
    if 2 not in older or older[2] is runs[2]:
        return ""
    then, now = (mean(of[2], lambda k: float(k.walls[-1])) for of in (older, runs))
    return (
        "- Cases 2 and 11 in seeds.csv, stiffness.csv, switched.csv and Fig. 14, and case 2 in retirement.csv, are of an earlier "
        f"version: the walls of case 2 hold {then:.3f} of the liquid instead of {now:.3f}.\n"
    )


def page_text(data: Path = FOLDER / "data", config: Config | None = None) -> str:
    """Write the figures next to `data` and return the page's text."""
    config = config or settings.load(Path("config"))
    variants, rigs = stored_runs.variants(data), stored_runs.variants(data.parent / stored_runs.RIGS.name)
    campaign, third = variants.pop("", {}), rigs.get(THIRD, {})
    runs = stored_runs.default(campaign, rigs.get(DEFAULT, {}))
    old, stays = variants.get("retire", {}), rigs.get(ALL, {})
    # each case by runs of one version
    both = {n: campaign[n] for n in old if n in campaign} | stays, {**old, **{n: runs[n] for n in stays}}
    answers = [(s, judge(s, runs)) for s in STATEMENTS]
    failed, open_ = ([s.number for s, answer in answers if answer.verdict == of] for of in (FAILS, OPEN))
    known = {n: reasons.reason(n, runs) for n in sorted([*failed, *open_]) if n in reasons.REASONS or n in failed}
    results = [_result(config, number, runs) for number in sorted(runs)]
    stiff, retired = (
        {n: of for n, of in found.items() if of[0].about["events"]}
        for found in (variants.get(STIFF, {}), {**rigs.get(STIFF_RETIRED, {}), **third})
    )
    seeds = spread.rows(campaign, stiff, sorted(stiff), alike=runs) + spread.rows(runs, retired, sorted(retired))
    every = {
        "": campaign,
        **variants,
        **{name: rigs[name] for name in (DEFAULT, ALL, STIFF_RETIRED, THIRD) if name in rigs},
    }
    stiffer = _redecided_rows(runs, {**stiff, **retired})
    shed = [row for effect in SWITCHED for row in _switched(campaign, variants, effect)]
    for name, columns, rows in (
        ("runs", run_table.RUN_COLUMNS, run_table.run_rows(config, every)),
        ("statements", run_table.STATEMENT_COLUMNS, run_table.statement_rows(answers)),
        ("seeds", spread.COLUMNS, seeds),
        ("retirement", retirement.COLUMNS, retirement.rows(*both)),
        ("switched", ("effect", *spread.COLUMNS), shed),
        ("stiffness", ("statement", "range", "lower_stiffness", "value", "paper_stiffness"), stiffer),
    ):
        run_table.write(data.parent / f"{name}.csv", columns, rows)
    run_table.write(data.parent / "reasons.csv", ("statement", "reason"), known.items())
    lines = [
        *headline.lines(runs, answers),
        *(_drawn(data.parent, FIRST, results) if runs else []),
        "\n## Statements\n",
        *_statements(answers),
        *(["\n## Why statements are not confirmed\n", *reasons.grouped(known, SAYS)] if known else []),
        METHOD.format(
            stiffness=" and ".join(f"{of['stiffness']:g} of the paper's at {mm:g} mm" for mm, of in SETTINGS.items()),
            retired=_which(runs, rigs.get(DEFAULT, {})),
        ),
        *_runs(config, runs, every),
        *_cost(runs),
        *spread.lines(seeds, third),
        *_decided_again(stiffer),
        *retirement.lines(*both),
        BEYOND.format(full=_full_beyond(campaign, variants)),
    ]
    if runs:
        lines += ["\n## Figures\n", *_figures(data.parent, stroke.fig9(config), results, campaign, variants)]
    lines += ["\n" + honest(runs, campaign)]
    return "\n".join(lines).replace("\n\n\n", "\n\n").rstrip() + "\n"


def _which(runs: Runs, retired: Runs) -> str:
    """Say which cases are judged by how many runs, and in which of them passed spheres are retired."""
    whole = [n for n, of in runs.items() if of is retired.get(n)]
    few = [str(n) for n in sorted(runs) if n not in whole]
    if not whole:
        return ""
    rest = (
        f"; {'case' if len(few) == 1 else 'cases'} {', '.join(few)} with the runs in which all spheres stay"
        if few
        else ""
    )
    return f"Statements are judged with at least {len(SEEDS)} seeds of each case, passed spheres retired{rest}."


def _runs(config: Config, runs: Runs, every: Mapping[str, Runs]) -> list[str]:
    missing = [n for n in sorted(config.cases) if not runs.get(n)]
    rows = [k for group in every.values() for of in group.values() for k in of]
    message = f"Not run yet: {', '.join(map(str, missing))}." if missing else "All 18 cases have run."
    hours, once = (sum(k.about["cpu_s"] or 0.0 for k in of) / 3600.0 for of in (rows, [of[0] for of in runs.values()]))
    if not rows:
        return [message]
    return [
        f"- **Runs**: {len(rows)} runs took {hours:.0f} core-hours of the engine ([runs.csv](full_scale/runs.csv)), "
        f"all cases with one seed {once:.1f}. {AGAIN} repeats a run; `make full` skips those stored. {message}"
    ]


def _cost(runs: Runs) -> list[str]:
    """Return the processor time of moist cases over that of their dry case with the same seed, for uninterrupted runs."""
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
        f"- **Cost**: A moist case takes {np.median(ratios):.2f} times the processor time of the dry one (median; "
        f"{min(ratios):.2f} to {max(ratios):.2f}, {len(ratios)} pairs, loaded machine)."
    ]


def _decided_again(rows: Sequence[tuple[str, ...]]) -> list[str]:
    """Say which ranges of statements the runs with the paper's stiffness decide differently; none without such runs."""
    if not rows:
        return []
    other = [number for number, _, was, _, now in rows if now != was]
    return [
        f"  Of {len(rows)} ranges of statements that these runs decide {len(rows) - len(other)} have the same verdict"
        f"{'; others by statement: ' if other else ''}{', '.join(other)} ([stiffness.csv](full_scale/stiffness.csv)).",
    ]


def _redecided_rows(runs: Runs, stiff: Runs) -> list[tuple[str, ...]]:
    """Return the ranges that runs with the paper's stiffness decide: verdict of the seeds, value and verdict of those runs."""
    return [
        (str(of.number), part.range, was, f"{value:.4g} ± {half:.2g}" if math.isfinite(value) else "not reached", now)
        for of, part, was, value, half, now in redecided(STATEMENTS, stiff, runs)
    ]


def _statements(answers: Answers) -> list[str]:
    open_ = ", ".join(str(s.number) for s, a in answers if a.verdict == OPEN)
    return [
        "A statement of the paper is translated into a range of a quantity. It is confirmed if the 95 % interval of the mean",
        "over seeds is within the range, and inconclusive if a limit of the range is within the interval. A statement with",
        "several ranges is confirmed if all are, and not confirmed if one is missed. The ranges were fixed",
        "before these runs, after one run of each case had been evaluated; those of pegging (4, 15) were changed afterwards.",
        *([f"Statements {open_} are inconclusive."] if open_ else []),
        "The table [statements.csv](full_scale/statements.csv) gives text, range, values and verdict of each statement. Y is "
        "the fraction retained, Y2 that of case 2, U the undersize on the screen.",
    ]


def _division(run: StoredRun, title: str) -> float:
    """Return the share of all liquid at the end in a division of Fig. 14; 0 for a reservoir missing from the table."""
    have = run.tables["liquid_by_holder"].columns
    return sum(float(run.liquid(h)[-1]) for h in trials.FIG14[title] if f"{h}_m3" in have)


DIVISIONS = {title: partial(_division, title=title) for title in trials.FIG14}


def _switched(runs: Runs, variants: Mapping[str, Runs], effect: str) -> list[tuple[str, ...]]:
    """Compare seeds of the campaign with the run with an effect on: divisions of Fig. 14 and passage."""
    other = variants.get(effect, {})
    return [(effect, *row) for row in spread.rows(runs, other, sorted(other), DIVISIONS | spread.DRY)]


def _change(row: tuple[str, ...]) -> str:
    """Write two cells: the share in the campaign, and its change with the limit, bold where it is significant."""
    change = f"{row[6]} {row[7].partition(', ')[2]}".rstrip()
    return f"{row[4]} | **{change}**" if row[7].startswith("yes") else f"{row[4]} | {change}"


def _full_beyond(runs: Runs, variants: Mapping[str, Runs]) -> str:
    """Summarise the full-scale results on effects that are in no preset."""
    lines = []
    for effect in SWITCHED:
        shown = [row for row in _switched(runs, variants, effect) if row[2] in DIVISIONS]
        if shown:
            cases = list(dict.fromkeys(row[1] for row in shown))
            heads = [f"case {n}, {next(row[3] for row in shown if row[1] == n)} seeds | change" for n in cases]
            lines += [
                f"\nCases {', '.join(cases)} were run once at full scale with `{effect}`. The table gives the change of the "
                "shares of all liquid",
                "at 20 s with 95 % limits; significant changes are bold ([switched.csv](full_scale/switched.csv)).\n",
                f"| share of the liquid on | {' | '.join(heads)} |",
                "|" + "---|" * (1 + 2 * len(cases)),
                *(f"| {of} | {' | '.join(_change(row) for row in shown if row[2] == of)} |" for of in DIVISIONS),
            ]
    if "shedding" in variants:
        lines.append(COARSE_LOOKS)
    left = [f"`{effect}`" for effect in SWITCHED if effect not in variants]
    return "\n".join([*lines, *([f"\nThere is no run at full scale with {' or '.join(left)}."] if left else [])])


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
    """Return a case for the figures, with a band from its other seeds, or from those of its neighbour."""
    k, *others = runs[number]
    share = {"coarse_share": k.about["coarse_share"]}
    seeds = tuple(one.tables["fraction_retained"] for one in others or neighbours(number, runs))
    retained, liquid = k.tables["fraction_retained"], k.tables["liquid_by_holder"]
    return CaseResult(config.case(number), (), summary=share, retained=retained, liquid=liquid, seeds=seeds)


def fig14(pair: Sequence[StoredRun]) -> str:
    """Draw bars of the paper's divisions of the apparatus at the end of the runs, without and with effects switched on."""
    if not pair:
        return ""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(7.0, 3.2), layout="constrained")
        places, wide = np.arange(len(trials.FIG14)), 0.8 / len(pair)
        for k, (run, colour) in enumerate(zip(pair, colours(len(pair), plots.CONFIGURATION), strict=True)):
            heights = [100 * of(run) for of in DIVISIONS.values()]
            effect = str(run.about.get("variant", "")).replace("_", " ")
            axes.bar(places + k * wide, heights, 0.95 * wide, label=f"case {run.case}{effect and ', ' + effect}",
                     color=colour)  # fmt: skip
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
