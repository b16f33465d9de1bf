"""Reasons why statements are not confirmed, with the runs that test them.

The numbers are in docs/full_scale/reasons/<statement>.csv. They are made from run directories by
`python -m studies.full_scale.reasons STATEMENT RUN…`: 7 (and 2, 17, 21), 6 (and 20, 32) and 12 take runs of `trials.py`,
26 runs that differ in the side wall's height.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
import typer

from pywet.errors import PywetError, border
from pywet.runs.rundir import RunDir
from pywet.schema import column
from pywet.util.files import read_json, write_csv
from studies.full_scale.judging import each
from studies.full_scale.quantities import MAJORITY, through
from studies.full_scale.statements import STATEMENTS
from studies.full_scale.stored_runs import COARSE, DIGITS, UNDERSIZE, WALLS, StoredRun, mean
from studies.full_scale.trials import named

FOLDER = Path("docs/full_scale/reasons")
SMALL, NEAR = UNDERSIZE
Runs = Mapping[int, Sequence[StoredRun]]


def side_walls(runs: Sequence[RunDir]) -> pd.DataFrame:
    """Return per run the height of the side wall [mm] and the liquid of the walls over that of the coarse material at the end."""
    rows = []
    for run in runs:
        liquid = run.table("results/liquid_by_holder").iloc[-1]
        file = run.path / "config.json"
        try:
            height = float(read_json(file, "run the case again")["apparatus"]["side_wall_height_mm"]["value"])
        except (KeyError, TypeError, ValueError) as error:
            raise PywetError(
                f"{file} has no number apparatus.side_wall_height_mm.value; expected that of a screening case"
            ) from error
        ratio = sum(liquid[f"{w}_m3"] for w in WALLS) / liquid["coarse_material_m3"]
        rows.append((height, liquid["time_since_opening_s"], ratio))
    return pd.DataFrame(sorted(rows), columns=["side_wall_height_mm", "time_since_opening_s", "walls_over_coarse"])


def curves(runs: Sequence[RunDir]) -> pd.DataFrame:
    """Return Y, Y_small and Y_near of trials after the opening, by trial and case, from run directories NAME-CASE."""
    parts = []
    for run in runs:
        trial, case = named(run)
        table = run.table("results/fraction_retained")
        names = {"fraction_retained": "all", **{column("fraction_retained", kind): kind for kind in UNDERSIZE}}
        part = table[["time_since_opening_s", *names]].rename(columns=names)[table["time_since_opening_s"] >= 0.0]
        parts.append(part.assign(case=case, trial=trial))
    return pd.concat(parts).sort_values(["case", "trial", "time_since_opening_s"])


def _side_wall(runs: Runs, folder: Path) -> str:
    table = pd.read_csv(folder / "26.csv")
    ratios = ", ".join(f"{r.walls_over_coarse:.2f}" for r in table.itertuples())
    heights = ", ".join(f"{r.side_wall_height_mm:.0f}" for r in table.itertuples())
    return (
        "at smoke scale, where the side wall is four times as large in relation to the sieve's area, the ratio is "
        f"{ratios} after {table.time_since_opening_s.iloc[0]:.1f} s with side walls {heights} mm high. With [films of whole "
        "walls](rig.md) it is 0.79 in one run at full scale and the statement is confirmed."
    )


def _trials(folder: Path, statement: int = 7) -> Callable[[str, int, str], float]:
    """Return a function for the mean from 0.5 s on of a curve of a trial, by its name, case and class."""
    table = pd.read_csv(folder / f"{statement}.csv")
    late = table[table["time_since_opening_s"] >= 0.5].groupby(["trial", "case"])[["all", *UNDERSIZE]].mean()
    return lambda trial, case, of: float(late[of].to_dict()[trial, case])


def _left(runs: Sequence[StoredRun], time: float) -> float:
    """Return the undersize left on the screen at a time [%], mean over seeds."""
    return 100.0 * mean(runs, lambda run: run.at(run.undersize, time))


def _slower(runs: Runs, folder: Path) -> str:
    left = [_left(runs[n], 5.0) for n in (1, 4)]
    return (
        f"passage ends sooner than in the paper: at 5 s {left[0]:.0f} % of the undersize is left with 1 mm, {left[1]:.0f} % "
        "with 0.8 mm. The reason is the same as for statement 7."
    )


def _wider(runs: Runs, folder: Path) -> str:
    of = _trials(folder, 6)
    means = [f"{of('deep', n, 'all'):.2f} instead of {of('as_is', n, 'all'):.2f}" for n in (7, 8)]
    return (
        "passage of POM with 5.6 mm ends sooner than in the paper, with "
        f"{_left(runs[7], 20.0):.1f} % of the undersize left at 20 s. Passage depends on the depth of the "
        "bed: in "
        f"trials a bed twice as deep retains {means[0]} of the dry feed, {means[1]} with 5 % of liquid."
    )


def _early(runs: Runs, folder: Path) -> str:
    of = _trials(folder)
    left = [_left(runs[n], 3.0) for n in (1, 2, 3)]
    deep = [f"{of('deep', n, 'all'):.2f} instead of {of('as_is', n, 'all'):.2f}" for n in (1, 3)]
    return (
        f"at 3 s {left[0]:.0f} % of the dry undersize has not yet passed, {left[1]:.0f} % with 5 % and "
        f"{left[2]:.0f} % with 10 % of liquid. "
        f"A bed twice as deep retains {deep[0]} of the dry feed, and {deep[1]} with 10 % of liquid. Passage therefore depends "
        "on the "
        "depth of the bed, which follows from the [diameter of the sieve](rig.md). Why 10 % of liquid delays passage further "
        "is unknown."
    )


def _small_first(runs: Runs, folder: Path) -> str:
    of = _trials(folder)
    lags = [of(trial, 3, SMALL) - of(trial, 3, NEAR) for trial in ("as_is", "sticky", "deep")]
    return (
        "the reason is unknown. Neither twice the surface tension nor a bed twice as deep reverses the order: in trials "
        f"Y_small − Y_near is {lags[0]:+.3f}, {lags[1]:+.3f} and {lags[2]:+.3f}."
    )


def _dry_near(runs: Runs, folder: Path) -> str:
    of = _trials(folder)
    dry = runs[10][0]
    while_passing = (dry.times >= 0.5) & (dry.times <= 3.0)
    near, small = (np.mean([k.retained(of) for k in runs[n]], axis=0) for n, of in ((10, NEAR), (12, SMALL)))
    least = (near - small)[while_passing].min()
    glass = of("sticky", 12, SMALL) - of("as_is", 10, NEAR)
    return (
        f"from 0.5 to 3 s Y of the moist small spheres (case 12) is at least {least:.3f} below Y of the dry near-mesh spheres "
        "(case 10). "
        f"With twice the surface tension the mean difference of these two Y is {glass:+.3f}."
    )


def _within_scatter(cases: Sequence[int], end: float, seeded: int) -> Callable[[Runs, Path], str]:
    """Describe the differences of Y from 2 s to `end` over the liquid content, and the scatter of the seeds of a case."""

    def sentence(runs: Runs, folder: Path) -> str:
        y = [mean(runs[n], lambda k: k.y(2.0, end)) for n in cases]
        seeds = [k.y(2.0, end) for k in runs[seeded]]
        return (
            f"from case {cases[0]} to {cases[1]} the mean Y changes by {y[1] - y[0]:+.4f} and from {cases[1]} to {cases[2]} by "
            f"{y[2] - y[1]:+.4f}, while "
            f"the seeds of case {seeded} differ by up to {max(seeds) - min(seeds):.4f}."
        )

    return sentence


def _spreads(runs: Runs, groups: Sequence[Sequence[int]], *spans: tuple[float, float]) -> list[float]:
    """Return the largest minus the smallest mean Y of each group of cases in each time interval."""
    means = [[[mean(runs[n], lambda k, span=span: k.y(*span)) for n in cases] for cases in groups] for span in spans]  # type: ignore[misc]
    return [max(each) - min(each) for of in means for each in of]


def _closer(runs: Runs, folder: Path) -> str:
    groups = (10, 11, 12), (13, 14, 15)
    late, later = _spreads(runs, groups, (2.0, 10.0))
    of = _trials(folder, 12)
    tried = [[of("as_is", n, "all") for n in cases] for cases in groups]
    spreads = [max(each) - min(each) for each in tried]
    return (
        f"passage with 1 mm ends sooner than in the paper: from 2 to 10 s the mean Y of cases 10 to 12 "
        f"differs by {late:.4f}, that of cases 13 to 15 by {later:.4f}. In trials, while most of the bed is on the screen, "
        "mean Y differs "
        f"by {spreads[0]:.3f} with 1 mm and by {spreads[1]:.3f} with 0.8 mm, as in the paper."
    )


def _nothing_left(runs: Runs, folder: Path) -> str:
    dry, moist = (_left(runs[n], 20.0) for n in (7, 8))
    return (
        f"its first half is confirmed. But only {dry:.2f} % of the dry undersize is left at 20 s, so that less cannot be left "
        "with liquid "
        f"({moist:.1f} %). The reason is the same as for statement 6."
    )


def _still_changing(runs: Runs, folder: Path) -> str:
    since = mean(runs[11], lambda run: through({11: run}, 11, MAJORITY))
    moved = {
        h: 100.0 * mean(runs[11], lambda run, h=h: run.at(run.liquid(h), 20.0) - run.at(run.liquid(h), since))  # type: ignore[misc]
        for h in ("coarse_material", "fines")
    }
    return (
        "three of its four parts are confirmed. In case 11 the last tenth of the undersize carries its liquid away: after "
        f"{since:.1f} s the shares of coarse material and fines change by {moved['coarse_material']:+.1f} and "
        f"{moved['fines']:+.1f} % of all liquid."
    )


def _too_little_left(runs: Runs, folder: Path) -> str:
    lines_of = []
    for number in (8, 17):
        held = [
            100.0 * mean(runs[number], lambda run, h=h: run.at(run.liquid(h), 20.0))  # type: ignore[misc]
            for h in ("coarse_material", "fines")
        ]
        lines_of.append(f"case {number}: {held[0]:.1f} % on the coarse material, {held[1]:.1f} % on the fines")
    return (
        "its first half is confirmed. But at 20 s most of the undersize has passed and carried its liquid away "
        f"({'; '.join(lines_of)}). The reason is the same as for statement 6."
    )


def _at_once(runs: Runs, folder: Path) -> str:
    shares = ", ".join(f"{_left(runs[1], t):.1f} % at {t:g} s" for t in (2.0, 5.0, 10.0))
    return f"passage ends sooner than in the paper: {shares} of the undersize is left. The reason is the same as for statement 7."


def _pegged(runs: Sequence[StoredRun], kind: str = COARSE) -> float:
    """Return how many spheres of a class peg at most from 10 to 20 s, mean over seeds."""
    return mean(runs, lambda run: run.pegged(kind, 10.0, 20.0))


def _glass_stays(runs: Runs, folder: Path) -> str:
    ends = [mean(runs[n], lambda k: k.at(k.retained(), 20.0)) for n in (7, 16)]
    large = [f"{_pegged(runs[n]):.1f}" for n in (16, 17, 18)]
    left = mean(runs[16], lambda k: sum(k.at(k.count("above", kind), 20.0) for kind in UNDERSIZE))
    return (
        f"with apertures of 5.6 mm Y at 20 s is {ends[1]:.3f} for glass and {ends[0]:.3f} for POM. The reason is unknown. It is "
        f"not pegging: at most {large[0]} large and {_pegged(runs[16], NEAR):.1f} near-mesh spheres of dry glass peg (moist: "
        f"{large[1]} and {large[2]} large ones, against statement 14), while {left:.0f} undersize spheres are left."
    )


def _none_pegs(runs: Runs, folder: Path) -> str:
    seconds = runs[7][0].beat * float(np.median(np.diff(runs[7][0].times)))
    return (
        f"on average at most {_pegged(runs[7]):.1f} large spheres peg in case 7 and {_pegged(runs[1]):.1f} in case 1 from 10 to "
        f"20 s: so few move with the screen at all outputs within {seconds:.1f} s, which meet all phases of its vibration."
    )


def _by_seed(number: int, form: str, sentence: str, at: int = 0) -> Callable[[Runs, Path], str]:
    """Describe one number of a statement, the first by default, by its values for each seed."""
    part = next(s for s in STATEMENTS if s.number == number).parts[at]
    return lambda runs, folder: sentence.format(", ".join(format(value, form) for value in each(part, runs)))


def _of_laws(sentence: str) -> Callable[[Runs, Path], str]:
    """Return a reason that follows from the laws and the equations of the paper alone."""
    return lambda runs, folder: sentence


REASONS: dict[int, Callable[[Runs, Path], str]] = {
    1: _at_once, 2: _slower, 4: _none_pegs, 5: _glass_stays, 6: _wider, 7: _early, 8: _within_scatter((4, 5, 6), 15.0, 2),
    9: _by_seed(9, "+.4f", "from 10 to 19 s Y with 5 % of liquid differs from Y without by {} (by seed).", at=1),
    11: _within_scatter((10, 11, 12), 10.0, 11), 12: _closer, 17: _small_first, 20: _nothing_left, 21: _dry_near,
    15: _by_seed(15, ".0f", "its first half is confirmed. In {} (by seed) of 12 moist cases a large sphere less pegs.", at=1),
    19: _by_seed(19, "+.3f", "with 5 % of liquid Y of the small spheres falls from 5 to 20 s by {} (by seed) more than without."),
    26: _side_wall, 28: _still_changing,
    30: _by_seed(30, ".4f", "small spheres carry {} times (by seed) as much liquid through the outlet as near-mesh ones."),
    32: _too_little_left,
    40: _of_laws("Rabinovich deviates from the exact bridge by up to 18 % at 0.7 to 0.9 of the rupture distance, where the force "
                 "is small."),
    41: _of_laws("its second half is confirmed. At a hundredth of the rupture distance Willett deviates by 0.8 % from the exact "
                 "bridge, Weigert by 2.4 %; the paper compares with measured points."),
    42: _of_laws("V* is 1.3e-5, below the range of Willett's fit (1e-3). Willett's force deviates from the exact one by 15 % "
                 "beyond a "
                 "third of the rupture distance, Rabinovich's by up to 24 % beyond half of it."),
    43: _of_laws("in the first configuration Rabinovich deviates from the exact bridge by 20 % at 0.7 of the rupture distance."),
    47: _of_laws("in the parabola model (equations 35 to 43) the larger sphere gets more liquid at 10° than at 40°. Statement "
                 "33 of "
                 "the same paper contradicts statement 47 and is confirmed."),
    48: _of_laws("the steps over angles are confirmed. Over V* the parabola model at the rupture distance gives the opposite "
                 "trend."),
}  # fmt: skip
TESTS: dict[int, Callable[[Sequence[RunDir]], pd.DataFrame]] = {
    6: curves,
    7: curves,
    12: curves,
    26: side_walls,
}


GROUPS: dict[str, tuple[int, ...]] = {
    "Passage ends sooner than in the paper": (7, 1, 2, 6, 12, 20, 28, 32),
    "Hardly any sphere pegs": (4, 15),
    "Dry glass passes small apertures slowly": (5,),
    "Liquid slows small spheres too little": (21, 17),
    "The height of the side wall is not known": (26,),
    "Differences are within the scatter of the seeds": (11, 8, 9, 19, 30),
    "Closed forms deviate from the exact bridge": (42, 40, 41, 43),
    "The transfer model gives the opposite trend": (47, 48),
}
"""Common reason -> numbers of its statements, starting with the one whose reason the page shows."""


def reason(number: int, runs: Runs, folder: Path = FOLDER) -> str:
    """Give the reason why a statement is not confirmed."""
    return REASONS[number](runs, folder) if number in REASONS else "not looked for yet."


def grouped(known: Mapping[int, str], says: Mapping[int, str] | None = None) -> list[str]:
    """Write one line for each group of reasons, quoting its first statement, and one for each statement outside them."""
    quoted = {n: f' ("{text.rstrip(".")}")' for n, text in (says or {}).items()}
    lines = []
    for title, numbers in GROUPS.items():
        if of := [n for n in numbers if n in known]:
            numbered = ", ".join(map(str, sorted(of)))
            listed = f" (statements {numbered})" if len(of) > 1 else ""
            lines.append(f"- **{title}**{listed}. Statement {of[0]}{quoted.get(of[0], '')}: {known[of[0]]}")
    others = set(known) - {n for numbers in GROUPS.values() for n in numbers}
    lines += [f"- Statement {n}: {known[n]}" for n in sorted(others)]
    return [
        *lines,
        "\nDeeper beds and larger surface tensions were simulated at smoke scale with one seed (means from 0.5 to 3 s).",
        "Reasons: [reasons.csv](full_scale/reasons.csv).",
    ]


def main(
    statement: Annotated[int, typer.Argument(help="Number of the statement.")],
    run_dirs: Annotated[list[Path], typer.Argument(help="Run directories.")],
) -> None:
    """Store the table that a reason rests on."""
    if statement not in TESTS:
        raise PywetError(f"statement {statement} has no reason that runs test; expected one of {sorted(TESTS)}")
    write_csv(TESTS[statement]([RunDir(d) for d in run_dirs]), FOLDER / f"{statement}.csv", float_format=DIGITS)
    typer.echo(f"{FOLDER / f'{statement}.csv'} is written")


if __name__ == "__main__":
    with border():
        typer.run(main)
