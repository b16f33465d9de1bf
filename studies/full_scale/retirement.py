"""Effect of retirement of the spheres in the bin at full scale, and its saving: runs with it compared with those without."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from pywet.compare.statistics import half_width
from studies.full_scale.spread import DRY
from studies.full_scale.stored_runs import StoredRun

Runs = Mapping[int, Sequence[StoredRun]]
AT_S = (1.0, 2.0, 5.0, 20.0)
"""Times after the opening at which Y is compared."""
OF_CURVES: dict[str, Callable[[StoredRun], float]] = {
    **{f"Y at {t:g} s": lambda k, t=t: k.at(k.retained(), t) for t in AT_S},  # type: ignore[misc]
    **DRY,
}
DIVIDED: dict[str, Callable[[StoredRun], float]] = {
    "liquid of the fines at the end": lambda k: float(k.liquid("fines")[-1]),
    "liquid of the bin's walls at the end": lambda k: float(k.liquid("collecting_bin")[-1]),
}
"""Quantities that retirement changes by design: liquid exchanged between the fines and the bin after they came to rest."""
OF_LIQUID: dict[str, Callable[[StoredRun], float]] = {
    "liquid of the coarse material at the end": lambda k: float(k.liquid("coarse_material")[-1]),
    "liquid of the walls except the bin's at the end": lambda k: float(k.walls[-1]),
    "liquid of fines and bin together at the end": lambda k: float(k.liquid("fines", "collecting_bin")[-1]),
    **DIVIDED,
}
MEAN_Y = next(iter(DRY))
"""Name of the quantity by which a change of the whole passage is shown."""
HEAP = (
    8,
    " In case 8 the bin's heap rises above the plane of passage: of 13, 54 and 45 near-mesh spheres retained at 20 s if all "
    "stay (seeds 10007, 10009, 10012), 11, 53 and 42 lie on it.",
)
"""Case whose late passage changes, and why: heights of the spheres in the last output of those runs, which is not stored."""
ONE_SEED = "one seed"
"""Verdict where both have one seed, so that no scatter is known."""
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
    divided = [row for row in moved if row[1] in DIVIDED]
    most = max((abs(float(row[6])) for row in divided), default=0.0)
    others = len(found) - sum(row[1] in DIVIDED for row in found)
    return [
        f"- **[Retired spheres](engine.md#retired-spheres)** (cases {', '.join(map(str, cases))} with and without): retirement "
        f"divides the liquid differently between fines and bin, by up to {most:.3f} of all liquid. Significant "
        f"among {others} other differences: {len(moved) - len(divided)} ({others / 20:.0f} expected by chance; "
        f"[retirement.csv](full_scale/retirement.csv)){_later(moved)}.{HEAP[1] * (HEAP[0] in cases)} {_saving(stored, retired)}",
    ]


def _later(moved: Sequence[tuple[str, ...]]) -> str:
    """Name the cases whose passage as a whole changes significantly, with the change of their mean Y."""
    changes = [f"case {row[0]}: {row[6]} {row[7].partition(', ')[2]}" for row in moved if row[1] == MEAN_Y]
    return f"; {MEAN_Y}, changes in {', '.join(changes)}" if changes else ""


def _compared(case: int, stored: Sequence[StoredRun], retired: Sequence[StoredRun]) -> list[tuple[str, ...]]:
    moist = bool(stored[0].about["events"])
    found: list[tuple[str, ...]] = []
    for name, of in (OF_CURVES | (OF_LIQUID if moist else {})).items():
        one, two = (np.array([of(k) for k in runs]) for runs in (stored, retired))
        moved, spread, reported = float(two.mean() - one.mean()), "–", ONE_SEED
        freedom = len(one) + len(two) - 2
        if freedom:
            deviation = float(np.sqrt(sum(((v - v.mean()) ** 2).sum() for v in (one, two)) / freedom))
            uncertainty = half_width(deviation, 1, freedom, 0.95) * np.sqrt(1.0 / len(two) + 1.0 / len(one))
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


def _saving(stored: Runs, retired: Runs) -> str:
    """Return the processor time of retired runs over that of runs with all spheres, least of each; resumed runs are left out."""
    ratios = []
    for case in sorted(set(stored) & set(retired)):
        every, fewer = (
            [k.about["cpu_s"] for k in runs[case] if k.about.get("cpu_s") and k.about.get("resumed_at_step") is None]
            for runs in (stored, retired)
        )
        ratios += [min(fewer) / min(every)] if every and fewer else []
    if not ratios:
        return ""
    return (
        f"The engine needs {np.median(ratios):.2f} of the processor time in the median ({min(ratios):.2f} to {max(ratios):.2f}, "
        f"{len(ratios)} cases on a loaded machine)."
    )
