"""Draw the figure of docs/screens.md from docs/wet_strip.csv: `python -m studies.wet_strip.figure [SWEEP.csv]`.

With a table of a sweep its rows are stored in docs/wet_strip.csv first. Runs of one moisture and stroke (seeds) are
pooled; the intervals assume independent spheres, and each seed is a dot.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pandas as pd

from pywet.errors import border
from pywet.products.partition import NORMAL_95, wilson
from pywet.report.pictures import COLOURS, STYLE, plt

ROOT = Path(__file__).resolve().parents[2]
STORED, FIGURE = ROOT / "docs" / "wet_strip.csv", ROOT / "docs" / "pictures" / "wet_strip.svg"
MOISTURE, STROKE, SEED = "moisture_percent", "amplitude_mm", "seed"
AXES = {"liquid.percent": MOISTURE, "deck.stroke.amplitude_mm": STROKE}
"""Axis of the sweep and its column in the stored table."""
INSERTED = {"d05": 80, "d07": 40, "d08": 40, "d09": 40, "d12": 20}
"""Spheres of each class in strip.yaml, by ten times the ratio of diameter to aperture."""
RATIO = {"d05": 0.5, "d07": 0.7, "d08": 0.8, "d09": 0.9, "d12": 1.2}
FREQUENCY_HZ, ANGLE_DEG, INCLINATION_DEG, G = 20.0, 45.0, 15.0, 9.81
MEASURES = ("recovery", "pegged", "on_wires")


def store(sweep: Path) -> None:
    """Store the finished rows of a sweep's table: axes, seed and results."""
    table = pd.read_csv(sweep).rename(columns=AXES)
    counts = [f"{product}_{name}" for product in ("unders", "overs") for name in INSERTED]
    done = table[table["recovery"].notna()][[MOISTURE, STROKE, SEED, *MEASURES, *counts]]
    done.sort_values([STROKE, MOISTURE, SEED]).to_csv(STORED, index=False, float_format="%.6g", lineterminator="\n")


def acceleration_ratio(amplitude_mm: float) -> float:
    """Acceleration of the deck normal to itself over that of gravity.

    >>> f"{acceleration_ratio(2.0):.2f}"
    '2.36'
    """
    normal = 1e-3 * amplitude_mm * (2.0 * math.pi * FREQUENCY_HZ) ** 2 * math.sin(math.radians(ANGLE_DEG))
    return normal / (G * math.cos(math.radians(INCLINATION_DEG)))


def passed(rows: pd.DataFrame, name: str) -> tuple[float, float, float]:
    """Return the share of the spheres of a class that passed, of all seeds together, with its 95 % interval (Wilson)."""
    number, of = float(rows[f"unders_{name}"].sum()), INSERTED[name] * len(rows)
    return (number / of, *wilson(number, of))


def recovery(rows: pd.DataFrame) -> tuple[float, float]:
    """Return the undersize recovery by mass of all seeds together, with half its 95 % interval for independent spheres."""
    top = variance = bottom = 0.0
    for name, ratio in RATIO.items():
        if ratio < 1.0:
            share, of, mass = passed(rows, name)[0], INSERTED[name] * len(rows), ratio**3
            top, bottom, variance = (
                top + mass * of * share,
                bottom + mass * of,
                variance + mass**2 * of * share * (1.0 - share),
            )
    return top / bottom, NORMAL_95 * math.sqrt(variance) / bottom


def page_rows(table: pd.DataFrame) -> list[str]:
    """Return the rows of the table of docs/screens.md: undersize recovery in per cent by moisture and stroke, with interval."""
    strokes = sorted(table[STROKE].unique())
    found = ["| moisture | " + " | ".join(f"{s:g} mm" for s in strokes) + " |", "|---|" + "---|" * len(strokes)]
    for moisture in sorted(table[MOISTURE].unique()):
        cells = []
        for stroke in strokes:
            rows = table[(table[MOISTURE] == moisture) & (table[STROKE] == stroke)]
            cells.append("{:.0f} ± {:.0f} %".format(*(100.0 * v for v in recovery(rows))) if len(rows) else "–")
        found.append(f"| {moisture:g} % | " + " | ".join(cells) + " |")
    return found


def draw(table: pd.DataFrame) -> None:
    """Draw recovery and pegged apertures over moisture for each stroke, and passage by size at the middle stroke."""
    strokes = sorted(table[STROKE].unique())
    with plt.rc_context(STYLE):
        figure, (left, middle, right) = plt.subplots(1, 3, figsize=(9.6, 3.2), constrained_layout=True)
        for k, stroke in enumerate(strokes):
            of, colour = table[table[STROKE] == stroke], COLOURS[k]
            groups = {float(m): rows for m, rows in of.groupby(MOISTURE)}
            mean, half = (100.0 * np.array(v) for v in zip(*(recovery(rows) for rows in groups.values()), strict=True))
            label = f"{stroke:g} mm, throw number {acceleration_ratio(stroke):.1f}"
            left.errorbar([*groups], mean, half, marker="o", color=colour, capsize=2, label=label)
            left.plot(of[MOISTURE], 100.0 * of["recovery"], ".", color=colour, alpha=0.5, markersize=4)
            middle.plot([*groups], [100.0 * rows["pegged"].mean() for rows in groups.values()], "o-", color=colour)
            middle.plot(of[MOISTURE], 100.0 * of["pegged"], ".", color=colour, alpha=0.5, markersize=4)
        centre = table[table[STROKE] == strokes[len(strokes) // 2]]
        for k, (moisture, rows) in enumerate(centre.groupby(MOISTURE)):
            shares = np.array([passed(rows, name) for name in RATIO]).T * 100.0
            ends = np.maximum([shares[0] - shares[1], shares[2] - shares[0]], 0.0)
            right.errorbar(
                [*RATIO.values()], shares[0], ends, marker="o", color=COLOURS[k], capsize=2, label=f"{moisture} %"
            )
        left.set(xlabel="moisture [% of dry mass]", ylabel="undersize recovered [%]", ylim=(0, 100))
        middle.set(xlabel="moisture [% of dry mass]", ylabel="apertures pegged [%]")
        middle.set_ylim(bottom=0)
        right.set(xlabel="diameter over aperture [-]", ylabel="passed [%]", ylim=(-3, 103))
        left.legend(fontsize="small")
        right.legend(title=f"amplitude {strokes[len(strokes) // 2]:g} mm", fontsize="small")
        FIGURE.parent.mkdir(exist_ok=True)
        figure.savefig(FIGURE, metadata={"Date": None})
        plt.close(figure)


if __name__ == "__main__":
    with border():
        if len(sys.argv) > 1:
            store(Path(sys.argv[1]))
        draw(pd.read_csv(STORED))
        print("\n".join(page_rows(pd.read_csv(STORED))))
        print(FIGURE.relative_to(ROOT))
