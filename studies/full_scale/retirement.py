"""Effect of retirement of the spheres in the bin at full scale, and its saving: runs named `retire` compared with others."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from pywet.compare.statistics import half_width
from studies.full_scale.spread import DRY
from studies.full_scale.stored_runs import StoredRun

VARIANT = "retire"
Runs = Mapping[int, Sequence[StoredRun]]
AT_S = (1.0, 2.0, 5.0, 20.0)
"""Times after the opening at which Y is compared."""
OF_CURVES: dict[str, Callable[[StoredRun], float]] = {
    **{f"Y at {t:g} s": lambda k, t=t: k.at(k.retained(), t) for t in AT_S},  # type: ignore[misc]
    **DRY,
}
OF_LIQUID: dict[str, Callable[[StoredRun], float]] = {
    "liquid of the coarse material at the end": lambda k: float(k.liquid("coarse_material")[-1]),
    "liquid of the walls except the bin's at the end": lambda k: float(k.walls[-1]),
    "liquid of fines and bin together at the end": lambda k: float(k.liquid("fines", "collecting_bin")[-1]),
    "liquid of the fines at the end": lambda k: float(k.liquid("fines")[-1]),
    "liquid of the bin's walls at the end": lambda k: float(k.liquid("collecting_bin")[-1]),
}
ONE_SEED = "one seed"
"""Verdict where no scatter is known."""
COLUMNS = ("case", "quantity", "seeds", "all_spheres", "standard_deviation", "retired", "difference", "significant")
"""Columns of a row of `rows`."""


def rows(stored: Runs, retired: Runs) -> list[tuple[str, ...]]:
    """Return each quantity of each case with runs of both kinds: means, difference and whether it is significant."""
    return [row for case in sorted(set(stored) & set(retired)) for row in _compared(case, stored[case], retired[case])]


def lines(stored: Runs, retired: Runs) -> list[str]:
    """Summarise the changes and savings by retirement, one sentence each; none without such runs."""
    cases = sorted(set(stored) & set(retired))
    if not cases:
        return []
    found = [row for row in rows(stored, retired) if row[7] != ONE_SEED]
    moved = [row for row in found if row[7].startswith("yes")]
    liquid = moved and all(row[1] in OF_LIQUID for row in moved)
    most = (
        f", by up to {max(abs(float(row[6])) for row in moved):.3f} of all liquid, which is divided differently between fines "
        "and bin"
        if liquid
        else ""
    )
    costs = "; ".join(_cost(case, stored[case], retired[case]) for case in cases)
    return [
        f"- **[Retired spheres](engine.md#retired-spheres)** (runs `retire`): {len(moved)} of {len(found)} quantities differ "
        f"significantly{most} ([retirement.csv](full_scale/retirement.csv)). The engine needs {costs}.",
    ]


def _compared(case: int, stored: Sequence[StoredRun], retired: Sequence[StoredRun]) -> list[tuple[str, ...]]:
    moist = bool(stored[0].about["events"])
    found: list[tuple[str, ...]] = []
    for name, of in (OF_CURVES | (OF_LIQUID if moist else {})).items():
        one, two = (np.array([of(k) for k in runs]) for runs in (stored, retired))
        moved, spread, reported = float(two.mean() - one.mean()), "–", ONE_SEED
        if len(one) > 1:
            deviation = float(one.std(ddof=1))
            uncertainty = half_width(deviation, 1, len(one) - 1, 0.95) * np.sqrt(1.0 / len(two) + 1.0 / len(one))
            spread, reported = f"{deviation:.4f}", f"{'yes' if abs(moved) > uncertainty else 'no'}, ± {uncertainty:.4f}"
        cells = (
            case,
            name,
            f"{len(one)}, {len(two)}",
            f"{one.mean():.4f}",
            spread,
            f"{two.mean():.4f}",
            f"{moved:+.4f}",
            reported,
        )
        found.append(tuple(map(str, cells)))
    return found


def _cost(case: int, stored: Sequence[StoredRun], retired: Sequence[StoredRun]) -> str:
    """Return the least cost of both kinds of runs; that of a resumed run is unknown."""
    of_all, of_retired = (
        min(
            (
                k.about["cpu_s"] / 3600.0
                for k in runs
                if k.about.get("cpu_s") and k.about.get("resumed_at_step") is None
            ),
            default=None,
        )
        for runs in (stored, retired)
    )
    cost = "an unknown number of core-hours" if of_retired is None else f"{of_retired:.3g} core-hours"
    return f"{cost}{'' if of_all is None else f' instead of {of_all:.3g}'} in case {case}"
