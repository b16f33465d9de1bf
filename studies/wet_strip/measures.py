"""Numbers that wet_strip.yaml gathers from each run: spheres of each class by product, recovery.

A sphere that is neither in the unders nor in the overs at the end is on the deck.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pandas as pd

from pywet.products import streams
from pywet.runs.loaded import Run

CLASSES = ("d05", "d07", "d08", "d09", "d12")
"""Names of the classes in strip.yaml, by ten times the ratio of diameter to aperture."""
APERTURE_M = 0.005
MOST_HELD = 0.1
"""A screen is called blocked where more than this mass share of the feed is on the deck 1.8 s after the end of the feed,
2.7 to 5 times the residence time of the coarsest spheres of the dry runs, 0.66 s (1 mm) to 0.36 s (3 mm)."""


def counts(run: Run) -> pd.DataFrame:
    """Return the number of spheres of each class (rows) that left into each product (columns overs, unders)."""
    gone = run._run.table("history/retired")
    names = np.array(["", *(o.product or "" for o in run.scene.outlets)], dtype=object)
    table = pd.crosstab(gone["type"], names[gone["outlet"].to_numpy(int)])
    kinds = [c.type for c in run.scene.classes]
    return table.reindex(index=kinds, columns=["overs", "unders"], fill_value=0).set_index(pd.Index(CLASSES))


def _counted(product: str, name: str) -> Callable[[Run], float]:
    def count(run: Run) -> float:
        return float(counts(run)[product].to_numpy(float)[CLASSES.index(name)])

    return count


unders_d05, unders_d07, unders_d08, unders_d09, unders_d12 = (_counted("unders", name) for name in CLASSES)
overs_d05, overs_d07, overs_d08, overs_d09, overs_d12 = (_counted("overs", name) for name in CLASSES)


def _inserted_kg(run: Run) -> pd.Series:
    """Return the mass of the spheres inserted of each class, in the order of the classes."""
    line = run._run.timeline
    return pd.Series(
        [c.mass_kg * (line.types[line.entered_by_end] == c.type).sum() for c in run.scene.classes], CLASSES
    )


def recovery(run: Run) -> float:
    """Return the mass of undersize in the unders over that of all inserted undersize."""
    small = np.array([2.0 * c.radius_m < APERTURE_M for c in run.scene.classes])
    passed = counts(run)["unders"] * [c.mass_kg for c in run.scene.classes]
    return float(passed[small].sum() / _inserted_kg(run)[small].sum())


def held(run: Run) -> float:
    """Return the mass that is still on the deck at the end over that of all inserted spheres."""
    left = counts(run).sum(axis=1) * [c.mass_kg for c in run.scene.classes]
    return float(1.0 - left.sum() / _inserted_kg(run).sum())


def residence_d12(run: Run) -> float:
    """Return the mean time from entering to leaving of the coarsest spheres, all of which go to the overs [s]; 0 if all stay."""
    left = streams.read(run._run, from_s=0.0).counted
    left = left[left["type"] == run.scene.classes[-1].type]
    return float((left["left_s"] - left["entered_s"]).mean()) if len(left) else 0.0


def on_wires(run: Run) -> float:
    """Return the share of all liquid that is on the wires at the end; 0 for a dry run."""
    last = run.liquid.iloc[-1]
    total = float(last["initial_m3"])
    return float(last["wall_screen_m3"] + last["wall_cross_wires_m3"]) / total if total else 0.0
