"""What retirement of the spheres in the bin changes at full scale, and what it saves: runs named `retire` against the others."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from pywet.compare.statistics import half_width
from studies.full_scale.kept import Kept
from studies.full_scale.spread import DRY

VARIANT = "retire"
Runs = Mapping[int, Sequence[Kept]]
AT_S = (1.0, 2.0, 5.0, 20.0)
"""Times after the opening at which Y is compared."""
OF_CURVES: dict[str, Callable[[Kept], float]] = {
    **{f"Y at {t:g} s": lambda k, t=t: k.at(k.retained(), t) for t in AT_S},  # type: ignore[misc]
    **DRY,
}
OF_LIQUID: dict[str, Callable[[Kept], float]] = {
    "liquid of the coarse material at the end": lambda k: float(k.liquid("coarse_material")[-1]),
    "of the walls but the bin's": lambda k: float(k.walls[-1]),
    "of fines and bin together": lambda k: float(k.liquid("fines", "collecting_bin")[-1]),
    "of the fines": lambda k: float(k.liquid("fines")[-1]),
    "of the bin's walls": lambda k: float(k.liquid("collecting_bin")[-1]),
}
COSTS = (("cpu_s", 3600.0), ("replay_cpu_s", 1.0), ("disk_B", 1e9))
"""Entry of run.json and its unit in the table."""
TEXT = """
## Retirement

Runs named `retire` take spheres that lie in the collecting bin [out of the run](engine.md#retired-spheres) four times a second.
Passage and liquid are compared with runs that retain all spheres; significant: seeds alone make as large a difference of the
means in less than one of twenty cases (Student). Fines and the bin's walls share the liquid differently, since each sphere that
comes to rest wets the floor; their sum is compared as well.
"""


def lines(kept: Runs, retired: Runs) -> list[str]:
    """The section of the page; none without such runs."""
    cases = sorted(set(kept) & set(retired))
    if not cases:
        return []
    head = (
        "| case | quantity | seeds | all spheres | standard deviation | retired | difference | significant |",
        "|" + "---|" * 8,
    )
    rows = [row for case in cases for row in _compared(case, kept[case], retired[case])]
    asked = "engine [core-hours]", "replay [s]", "disk [GB]"
    head_of_costs = f"| case | {' | '.join(f'{name}: all spheres | retired' for name in asked)} |"
    costs = [_cost(case, kept[case], retired[case]) for case in cases]
    note = "\nLeast time of each case's runs, made on different days on a loaded machine."
    return [TEXT, *head, *rows, "", head_of_costs, "|" + "---|" * 7, *costs, note]


def _compared(case: int, kept: Sequence[Kept], retired: Sequence[Kept]) -> list[str]:
    moist = bool(kept[0].about["events"])
    found = []
    for name, of in (OF_CURVES | (OF_LIQUID if moist else {})).items():
        one, two = (np.array([of(k) for k in runs]) for runs in (kept, retired))
        moved, spread, told = float(two.mean() - one.mean()), "–", "one seed"
        if len(one) > 1:
            deviation = float(one.std(ddof=1))
            chance = half_width(deviation, 1, len(one) - 1, 0.95) * np.sqrt(1.0 / len(two) + 1.0 / len(one))
            spread, told = f"{deviation:.4f}", f"{'yes' if abs(moved) > chance else 'no'}, ± {chance:.4f}"
        cells = (
            case,
            name,
            f"{len(one)}, {len(two)}",
            f"{one.mean():.4f}",
            spread,
            f"{two.mean():.4f}",
            f"{moved:+.4f}",
            told,
        )
        found.append(f"| {' | '.join(map(str, cells))} |")
    return found


def _cost(case: int, kept: Sequence[Kept], retired: Sequence[Kept]) -> str:
    cells = [str(case)]
    for key, unit in COSTS:
        for runs in (kept, retired):
            values = [k.about[key] / unit for k in runs if k.about.get(key) and k.about.get("resumed_at_step") is None]
            cells.append(f"{min(values):.3g}" if values else "–")
    return f"| {' | '.join(cells)} |"
