"""Scatter of seeds and effect of a lower contact stiffness at full scale: seeds of a case compared with its run `paper`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from pywet.compare.statistics import half_width
from studies.full_scale.quantities import lag
from studies.full_scale.stored_runs import StoredRun

Runs = Mapping[int, Sequence[StoredRun]]
Quantities = Mapping[str, Callable[[StoredRun], float]]
BEGIN, END = 0.5, 5.0
"""Seconds after the opening between which most of the undersize passes with 8 mm."""


def half_through(run: StoredRun) -> float:
    """Return the time after the opening at which half of the undersize has passed [s]."""
    return float(np.interp(-0.5, -run.undersize, run.times))


DRY: dict[str, Callable[[StoredRun], float]] = {
    f"mean Y, {BEGIN:g} to {END:g} s": lambda k: k.y(BEGIN, END),
    f"mean Y_small − Y_near, {BEGIN:g} to {END:g} s": lambda k: lag(k, BEGIN, END),
    "half of the undersize through [s]": half_through,
}
MOIST: dict[str, Callable[[StoredRun], float]] = {
    "liquid of the coarse material at the end": lambda k: float(k.liquid("coarse_material")[-1]),
    "liquid of the fines at the end": lambda k: float(k.liquid("fines")[-1]),
    "liquid of the walls at the end": lambda k: float(k.walls[-1]),
    "formations, in millions": lambda k: 1e-6 * float(k.about["events"]["formations"]),
}


Row = tuple[str, str, str, str, str, str, str]
COLUMNS = ("case", "quantity", "seeds", "mean", "standard_deviation", "difference", "significant")
"""Columns of a `Row`; the last cell is `yes` or `no` with half the 95 % interval of the difference."""


def rows(
    runs: Runs, other: Runs, cases: Sequence[int], asked: Quantities | None = None, alike: Runs | None = None
) -> list[Row]:
    """Return each quantity's mean and standard deviation for each case with seeds, and the deviation of another run.

    `alike`: seeds of the cases in another version of the program; they add to the scatter about their own mean only.
    """
    found: list[Row] = []
    for case in cases:
        seeds = runs.get(case, ())
        if len(seeds) < 2:
            continue
        for name, of in (asked or DRY | (MOIST if seeds[0].about["events"] else {})).items():
            groups = [np.array([of(k) for k in group]) for group in (seeds, (alike or {}).get(case, ())) if group]
            values, freedom = groups[0], sum(len(group) - 1 for group in groups)
            mean = float(values.mean())
            deviation = float(np.sqrt(sum(((v - v.mean()) ** 2).sum() for v in groups) / freedom))
            moved, reported = "–", "–"
            if other.get(case):
                difference = of(other[case][0]) - mean
                uncertainty = half_width(deviation, 1, freedom, 0.95) * np.sqrt(1.0 + 1.0 / len(values))
                moved = f"{difference:+.4f}"
                reported = f"{'yes' if abs(difference) > uncertainty else 'no'}, ± {uncertainty:.4f}"
            found.append((str(case), name, str(len(values)), f"{mean:.4f}", f"{deviation:.4f}", moved, reported))
    return found


def lines(found: Sequence[Row], third: Iterable[int] = ()) -> list[str]:
    """Sentences on the differences between the seeds and the runs with the paper's stiffness; none without seeds.

    `third`: cases whose run with that stiffness has bridges in every third step.
    """
    if not found:
        return []
    compared = [row for row in found if row[5] != "–"]
    moved = [r for r in compared if r[6].startswith("yes")]
    of_case = {n: [r for r in moved if r[0] == n] for n in dict.fromkeys(r[0] for r in moved)}
    first = [rows[0][1] for rows in of_case.values()]
    changes = [
        f"{len(rows)} of case {n}{f', as {name}' if name != before else ''}: {rows[0][5]}"
        for (n, rows), name, before in zip(of_case.items(), first, ["", *first], strict=False)
    ]
    every = "".join(f"; case {n} with bridges in every third step" for n in sorted(third))
    return [
        f"- **Paper's contact stiffness** (cases {', '.join(dict.fromkeys(r[0] for r in compared))}, one seed each{every}): "
        f"{len(moved)} of {len(compared)} quantities differ significantly (5 %, Student; {len(compared) / 20:.0f} expected by "
        f"chance) from the runs with lower stiffness{'; ' if moved else ''}{'; '.join(changes)} "
        "([seeds.csv](full_scale/seeds.csv)).",
    ]
