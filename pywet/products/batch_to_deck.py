"""Passage on a continuous deck, predicted from batch kinetics and from the time that material spends on the deck.

Of a class with the fraction retained Y(t) in a batch, R = integral of E(t) Y(t) dt goes to the overs, with the density E of the
residence time t of what does not pass (Danckwerts 1953, Chem. Eng. Sci. 2, 1, for a first-order reaction). It holds if spheres
pass on the deck at the rate at which they pass in a batch of the same load, stroke, moisture and material.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from pywet import run_folder
from pywet.errors import PywetError, shown
from pywet.geometry.surface import Floats
from pywet.products import kinetics, streams
from pywet.products.kinetics import Law
from pywet.products.partition import NORMAL_95, mean_and_half_width
from pywet.products.screening_report import curve_of
from pywet.runs.distinct_seeds import distinct_seeds
from pywet.runs.rundir import RunDir

TRACER = 0.98
"""Least share of the coarsest class that goes to the overs, so that its residence times are those of what does not pass."""


def share_retained(law: Law, values: Floats, residence_s: Floats) -> tuple[float, float]:
    """Fraction retained by a law after residence times [s] of equal weight, and half of its 95 % interval from their scatter.

    >>> first_order = kinetics.LAWS[0]
    >>> f"{share_retained(first_order, np.array([0.0, 2.0]), np.array([0.5]))[0]:.4f}"  # plug flow: exp(-k L/v)
    '0.3679'
    """
    each = law(residence_s, *values)
    scatter = float(each.std(ddof=1)) / math.sqrt(len(each)) if len(each) > 1 else 0.0
    return float(each.mean()), NORMAL_95 * scatter


def plug_flow(law: Law, values: Floats, residence_s: Floats) -> tuple[float, float]:
    """Fraction retained by a law after the mean of residence times [s], and half of its 95 % interval from their scatter."""
    mean, error = float(residence_s.mean()), 0.0
    if len(residence_s) > 1:
        error = NORMAL_95 * float(residence_s.std(ddof=1)) / math.sqrt(len(residence_s))
    low, middle, high = law(np.array([mean - error, mean, mean + error]), *values)
    return float(middle), 0.5 * float(low - high)


def tracer(flow: streams.Streams, folder: Path) -> Floats:
    """Residence times [s] of the coarsest class, from entering to leaving with the overs."""
    coarsest = flow.spheres[flow.spheres["diameter_m"] == flow.spheres["diameter_m"].max()]
    overs = coarsest[coarsest["product"] == "overs"]
    left = int((coarsest["product"] != "").sum())
    if not left or len(overs) < TRACER * left:
        raise PywetError(
            f"{shown(folder)}: {len(overs)} of the {left} spheres of the coarsest class that left went to the overs; expected at "
            f"least {100 * TRACER:g} %, so that their residence times are those of what does not pass",
            code="kinetics.no_tracer", where=folder,
        )  # fmt: skip
    return (overs["left_s"] - overs["entered_s"]).to_numpy(dtype=float)


def predict(batches: Sequence[Path | str], deck: Path | str, from_s: float | None = None) -> pd.DataFrame:
    """Predict the partition curve of a continuous deck from seeds of a batch and compare it with the simulated one.

    Parameters
    ----------
    batches : sequence of Path or str
        Seeds of a batch of the same material, aperture, stroke, moisture and load: screening cases, or scenes with outlets whose
        spheres leave as unders alone. Their classes have the names of those of the deck.
    deck : Path or str
        Run of a continuous deck whose coarsest class does not pass.
    from_s : float, optional
        Time from which T of the deck is counted, by default from where it is steady; residence times are of the whole run.

    Returns
    -------
    DataFrame
        For each class, the finest first: class, diameter_mm, law (the best on seeds that were not fitted), plug_flow and
        residence_times (share to the overs predicted with the mean and with all residence times of the coarsest class), each with
        half of its 95 % interval (…_half: seeds of the batch and scatter of the times; nan for one batch), T, T_low, T_high of
        the deck.

    Raises
    ------
    PywetError
        If the coarsest class passes, or no class of the deck is in the batches.
    """
    folder = Path(deck)
    with run_folder.reading(folder, *map(Path, batches)):
        runs, run = [kinetics.curves(b) for b in distinct_seeds(map(Path, batches))], RunDir(folder)
        flow = streams.read(run, from_s)
        if not flow.continuous:
            raise PywetError(
                f"{shown(folder)} is a batch, whose spheres do not stay for a residence time; expected a deck with insertion",
                code="kinetics.no_tracer", where=folder,
            )  # fmt: skip
        times, curve = tracer(flow, folder), curve_of(run, flow)
        rows = []
        for kind in sorted(run.scene.classes, key=lambda c: c.radius_m):
            measured = curve[np.isclose(curve["diameter_mm"], 2e3 * kind.radius_m)]
            if all(kind.name in r for r in runs) and len(measured):
                found = {"class": kind.name, "diameter_mm": 2e3 * kind.radius_m, **_of_class(runs, kind.name, times)}
                rows.append(found | {c: float(measured[c].iloc[0]) for c in ("T", "T_low", "T_high")})
    if not rows:
        raise PywetError(
            f"{shown(folder)}: none of its classes, {', '.join(c.name for c in run.scene.classes)}, is in the batches; expected "
            "classes of the same names",
            code="kinetics.other_classes", where=folder,
        )  # fmt: skip
    return pd.DataFrame(rows)


def _of_class(runs: Sequence[pd.DataFrame], kind: str, times: Floats) -> dict[str, str | float]:
    """Law of a class and both predictions with half of their intervals; a class that does not pass stays."""
    if min(float(run[kind].iloc[-1]) for run in runs) >= 1.0 - kinetics.PASSES:
        return {
            "law": "–",
            "plug_flow": 1.0,
            "plug_flow_half": 0.0,
            "residence_times": 1.0,
            "residence_times_half": 0.0,
        }
    name = kinetics.ranking(runs, kind)["law"].iloc[0]
    law = next(w for w in kinetics.LAWS if w.name == name)
    fits = [kinetics.fit(law, *kinetics.points(run, kind))[0] for run in runs]
    found: dict[str, str | float] = {"law": law.name}
    for way, of in (("plug_flow", plug_flow), ("residence_times", share_retained)):
        each, halves = np.array([of(law, values, times) for values in fits]).T
        mean, half = mean_and_half_width(each.tolist())
        found |= {way: mean, f"{way}_half": math.hypot(half, float(halves.mean()))}
    return found
