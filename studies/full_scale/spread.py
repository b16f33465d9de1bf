"""Scatter of seeds and effect of a lower contact stiffness at full scale: seeds of a case against its run `paper`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from pywet.compare.statistics import half_width
from studies.full_scale.kept import Kept
from studies.full_scale.quantities import lag

Runs = Mapping[int, Sequence[Kept]]
Quantities = Mapping[str, Callable[[Kept], float]]
BEGIN, END = 0.5, 5.0
"""Seconds after the opening between which most of the undersize passes with 8 mm."""


def half_through(run: Kept) -> float:
    """Time after the opening at which half of the undersize has passed [s]."""
    return float(np.interp(-0.5, -run.undersize, run.times))


DRY: dict[str, Callable[[Kept], float]] = {
    f"mean Y, {BEGIN:g} to {END:g} s": lambda k: k.y(BEGIN, END),
    f"mean Y_small − Y_near, {BEGIN:g} to {END:g} s": lambda k: lag(k, BEGIN, END),
    "half of the undersize is through [s]": half_through,
}
MOIST: dict[str, Callable[[Kept], float]] = {
    "liquid of the coarse material at the end": lambda k: float(k.liquid("coarse_material")[-1]),
    "of the fines": lambda k: float(k.liquid("fines")[-1]),
    "of the walls": lambda k: float(k.walls[-1]),
    "formations, in millions": lambda k: 1e-6 * float(k.about["events"]["formations"]),
}


def rows(runs: Runs, other: Runs, cases: Sequence[int], asked: Quantities | None = None) -> list[str]:
    """For each case with seeds each quantity's mean and standard deviation, and how a run with other settings differs."""
    lines = []
    for case in cases:
        seeds = runs.get(case, ())
        if len(seeds) < 2:
            continue
        for name, of in (asked or DRY | (MOIST if seeds[0].about["events"] else {})).items():
            values = np.array([of(k) for k in seeds])
            mean, deviation = float(values.mean()), float(values.std(ddof=1))
            told = "– | –"
            if other.get(case):
                moved = of(other[case][0]) - mean
                chance = half_width(deviation, 1, len(values) - 1, 0.95) * np.sqrt(1.0 + 1.0 / len(values))
                told = f"{moved:+.4f} | {'yes' if abs(moved) > chance else 'no'}, ± {chance:.4f}"
            lines.append(f"| {case} | {name} | {len(values)} | {mean:.4f} | {deviation:.4f} | {told} |")
    return lines


def lines(runs: Runs, stiff: Runs, cases: Sequence[int]) -> list[str]:
    """The section of the page; none without seeds."""
    table = rows(runs, stiff, cases)
    if not table:
        return []
    return [
        "\n## Seeds, and the paper's contact stiffness\n",
        "Seeds differ in where the spheres fall into the feed bin. Of the runs named `paper`, with the paper's stiffness, there",
        "is one each. Significant: farther off than another seed would be in one of twenty cases (Student).\n",
        *head("with the paper's stiffness"),
        *table,
    ]


def head(other: str) -> tuple[str, str]:
    """Of the table of `rows`."""
    return f"| case | quantity | seeds | mean | standard deviation | {other} | significant |", "|" + "---|" * 7
