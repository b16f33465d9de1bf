"""Table of docs/screens.md on the accuracy of a deck's numbers: `python -m studies.deck_numbers.page [SWEEP.csv]`.

With the table of the sweep its rows are stored in docs/deck_numbers.csv first.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import pandas as pd
from scipy import stats

from pywet.errors import border
from pywet.products.partition import NORMAL_95, mean_and_half_width
from pywet.products.steady import BLOCKS

ROOT = Path(__file__).resolve().parents[2]
STORED = ROOT / "docs" / "deck_numbers.csv"
AXES = {"duration_s": "feed_s", "materials.ore.stiffness_N_per_m": "stiffness_N_per_m", "time_step.share": "step_share"}
"""Axis of the sweep and its column in the stored table."""
DEFAULT = {"feed_s": 2.5, "stiffness_N_per_m": 12000.0, "step_share": 0.2}
CHANGES = {"feed of 10 s": ("feed_s", 10.0), "10 times as stiff": ("stiffness_N_per_m", 120000.0),
           "half the time step": ("step_share", 0.1)}  # fmt: skip
"""What is changed, and the one value in which its runs differ from the default."""
SHOWN = [*CHANGES][:2]
"""Changes with a column on the page."""
OF_TRIALS, OF_BLOCKS = NORMAL_95, float(stats.t.ppf(0.975, BLOCKS - 1))
"""Quantile in half of an interval within a run: spheres as independent trials, or blocks of the run."""
NUMBERS: dict[str, tuple[str, str | None, float, float]] = {
    "cut size d50, mm": ("screen_d50_mm", "d50_half", OF_TRIALS, 1.0),
    "ecart probable, mm": ("screen_ecart_probable_mm", None, OF_TRIALS, 1.0),
    "efficiency, %": ("screen_efficiency", "efficiency_half", OF_TRIALS, 100.0),
    "throughput, kg/h": ("screen_throughput_t_per_h", "throughput_half", OF_BLOCKS, 1000.0),
    "moisture of the overs, %": ("screen_overs_moisture_percent", "overs_moisture_half", OF_BLOCKS, 1.0),
    "moisture of the unders, %": ("screen_unders_moisture_percent", "unders_moisture_half", OF_BLOCKS, 1.0),
    "apertures pegged, %": ("screen_pegged_share", "pegged_half", OF_BLOCKS, 100.0),
}
"""Row of the page: result of the sweep, half of its interval within a run and its quantile, factor to the unit of the row."""
LEVEL = 0.05
"""A change is significant by Welch's t at this level for all numbers and changes together (Bonferroni). An interval within a run
is too narrow where the variance between seeds exceeds that of the interval significantly (chi-square, this level for all
numbers together)."""


def store(sweep: Path) -> None:
    """Store the finished runs of the table of a sweep."""
    table = pd.read_csv(sweep).rename(columns=AXES)
    results = [name for number, half, *_ in NUMBERS.values() for name in (number, half) if name]
    done = table[table["status"] == "done"][[*DEFAULT, "seed", *results]]
    done.sort_values([*DEFAULT, "seed"]).to_csv(STORED, index=False, float_format="%.6g", lineterminator="\n")


def rows_of(table: pd.DataFrame, **changes: float) -> pd.DataFrame:
    """Return the runs with the default values except those given."""
    return table[(table[[*DEFAULT]] == pd.Series({**DEFAULT, **changes})).all(axis=1)]


def too_narrow(values: pd.Series, half: pd.Series, quantile: float) -> bool:
    """Whether the variance between seeds exceeds the mean variance within runs, (half / quantile)², significantly."""
    within = float(((half / quantile) ** 2).mean())
    free = len(values) - 1
    return within > 0.0 and bool(stats.chi2.sf(free * float(values.var()) / within, free) < LEVEL / len(NUMBERS))


def significant(a: pd.Series, b: pd.Series) -> bool:
    """Whether the means of two groups of seeds differ significantly."""
    return bool(stats.ttest_ind(a, b, equal_var=False).pvalue < LEVEL / (len(NUMBERS) * len(CHANGES)))


def _cell(value: float, half: float, marked: bool) -> str:
    """Value with two digits of its uncertainty; a value without scatter alone."""
    if not half > 0:
        return f"{value:g}"
    digits = max(0, 1 - math.floor(math.log10(half)))
    text = f"{value:+.{digits}f} ± {half:.{digits}f}"
    return f"**{text}**" if marked else text


def change(table: pd.DataFrame, number: str, column: str, value: float) -> tuple[float, float, bool]:
    """Return what a change of one value adds to a number of the sweep, half of its 95 % interval (Welch), its significance."""
    other, base = rows_of(table, **{column: value})[number], rows_of(table)[number]
    wide = stats.ttest_ind(other, base, equal_var=False).confidence_interval(0.95)
    return float(other.mean() - base.mean()), 0.5 * float(wide.high - wide.low), significant(other, base)


def page_rows(table: pd.DataFrame) -> list[str]:
    """Return the table of docs/screens.md: means over seeds, intervals within and between runs, changes (bold: significant)."""
    base = rows_of(table)
    lines = [f"| | mean of {len(base)} runs | within a run | between runs | {' | '.join(SHOWN)} |"]
    lines.append("|---|" + "---|" * (3 + len(SHOWN)))
    for name, (number, half, quantile, factor) in NUMBERS.items():
        values = factor * base[number]
        between = float(stats.t.ppf(0.975, len(values) - 1) * values.std())  # of one run by the scatter of all
        mean = _cell(*mean_and_half_width(values.tolist()), marked=False).removeprefix("+")
        cells = [mean, "", f"± {between:.2g}" if between else ""]
        if half and base[half].any():
            within = f"± {factor * float(base[half].mean()):.2g}"
            cells[1] = f"**{within}**" if too_narrow(base[number], base[half], quantile) else within
        for column, value in map(CHANGES.__getitem__, SHOWN):
            found, wide, marked = change(table, number, column, value)
            cells.append(_cell(factor * found, factor * wide, marked))
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return lines


if __name__ == "__main__":
    with border():
        if len(sys.argv) > 1:
            store(Path(sys.argv[1]))
        print("\n".join(page_rows(pd.read_csv(STORED))))
