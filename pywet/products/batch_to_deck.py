"""Passage on a continuous deck, predicted from batch kinetics and from the time that material spends on the deck.

Of a class with the fraction retained Y(t) in a batch, R = integral of E(t) Y(t) dt goes to the overs, with the density E of the
residence time t of what does not pass (Danckwerts 1953, Chem. Eng. Sci. 2, 1, for a first-order reaction). It holds if spheres
pass on the deck at the rate at which they pass in a batch of the same load, stroke, moisture and material.

Spheres that are on the deck when the run ends stay longer than observed: E is the estimate of Kaplan & Meier (1958, J. Am. Stat.
Assoc. 53, 457) from both. It holds if residence times do not depend on when a sphere enters.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
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


@dataclass(frozen=True)
class Residence:
    """Distribution of residence times; the last of them is the longest observed, at which all longer ones count."""

    time_s: Floats
    weight: Floats
    """Share of the spheres with each; the last is that of all beyond the longest observed."""
    greenwood: Floats
    """Relative variance that each adds to the share that stays longer."""
    left: int
    inside: int
    """Number of spheres that had left, and that had not."""

    @classmethod
    def of(cls, left_s: Floats, inside_s: Floats | None = None) -> Residence:
        """Estimate it from the times [s] of spheres that left, and the times so far of those that have not.

        >>> Residence.of(np.array([1.0, 3.0]), np.array([2.0])).weight.round(3).tolist()
        [0.333, 0.667, 0.0]
        """
        left, inside = (np.round(t, 9) for t in (left_s, np.zeros(0) if inside_s is None else inside_s))
        every, (times, leave) = np.sort([*left, *inside]), np.unique(left, return_counts=True)
        there = len(every) - np.searchsorted(every, times)
        stay = np.cumprod(1.0 - leave / there)
        greenwood = leave / there / np.maximum(there - leave, 1)
        return cls(
            np.append(times, every[-1]), np.diff(1.0 - stay, prepend=0.0, append=1.0), np.append(greenwood, 0.0),
            len(left), len(inside),
        )  # fmt: skip

    def mean(self, values: Floats) -> tuple[float, float]:
        """Mean of a function's values at the times, and its standard error; nan of fewer than two spheres that left."""
        if self.left < 2:
            return float(self.weight @ values), math.nan
        sums, stay = np.cumsum(self.weight * values), 1.0 - np.cumsum(self.weight)
        later = sums[-1] - sums - stay * values
        variance = float(self.greenwood @ later**2) * self.left / (self.left - 1)
        return float(sums[-1]), math.sqrt(variance)


def share_retained(law: Law, values: Floats, residence: Residence) -> tuple[float, float]:
    """Fraction retained by a law after residence times, and half of its 95 % interval from their scatter.

    >>> first_order = kinetics.LAWS[0]
    >>> f"{share_retained(first_order, np.array([0.0, 2.0]), Residence.of(np.array([0.5])))[0]:.4f}"  # plug flow: exp(-k L/v)
    '0.3679'
    """
    mean, error = residence.mean(law(residence.time_s, *values))
    return mean, NORMAL_95 * error


def plug_flow(law: Law, values: Floats, residence: Residence) -> tuple[float, float]:
    """Fraction retained by a law after the mean residence time, and half of its 95 % interval from their scatter."""
    mean, error = residence.mean(residence.time_s)
    low, middle, high = law(mean + NORMAL_95 * error * np.array([-1.0, 0.0, 1.0]), *values)
    return float(middle), 0.5 * float(low - high)


def tracer(flow: streams.Streams, end_s: float, folder: Path) -> Residence:
    """Residence times of the coarsest class, from entering to leaving with the overs, of a run that ended at a time [s]."""
    coarsest = flow.spheres[flow.spheres["diameter_m"] == flow.spheres["diameter_m"].max()]
    overs = coarsest[coarsest["product"] == "overs"]
    left = int((coarsest["product"] != "").sum())
    if not left or len(overs) < TRACER * left:
        raise PywetError(
            f"{shown(folder)}: {len(overs)} of the {left} spheres of the coarsest class that left went to the overs; expected at "
            f"least {100 * TRACER:g} %, so that their residence times are those of what does not pass",
            code="kinetics.no_tracer", where=folder,
        )  # fmt: skip
    inside = end_s - coarsest.loc[coarsest["left_s"].isna() & (coarsest["entered_s"] < end_s), "entered_s"]
    return Residence.of((overs["left_s"] - overs["entered_s"]).to_numpy(dtype=float), inside.to_numpy(dtype=float))


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
        the deck; tracers, tracers_inside (spheres with a residence time, and those of them that have not left) and
        unobserved (share of residence times beyond the longest observed, at which they count).

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
        times, curve = tracer(flow, float(run.timeline.times[-1]), folder), curve_of(run, flow)
        seen = {"tracers": times.left + times.inside, "tracers_inside": times.inside, "unobserved": times.weight[-1]}
        rows = []
        for kind in sorted(run.scene.classes, key=lambda c: c.radius_m):
            measured = curve[np.isclose(curve["diameter_mm"], 2e3 * kind.radius_m)]
            if all(kind.name in r for r in runs) and len(measured):
                found = {"class": kind.name, "diameter_mm": 2e3 * kind.radius_m, **_of_class(runs, kind.name, times)}
                rows.append(found | {c: float(measured[c].iloc[0]) for c in ("T", "T_low", "T_high")} | seen)
    if not rows:
        raise PywetError(
            f"{shown(folder)}: none of its classes, {', '.join(c.name for c in run.scene.classes)}, is in the batches; expected "
            "classes of the same names",
            code="kinetics.other_classes", where=folder,
        )  # fmt: skip
    return pd.DataFrame(rows)


def _of_class(runs: Sequence[pd.DataFrame], kind: str, times: Residence) -> dict[str, str | float]:
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
    fits = [kinetics.fit(law, *kinetics.points(run, kind)) for run in runs]
    found: dict[str, str | float] = {"law": law.name}
    for way, of in (("plug_flow", plug_flow), ("residence_times", share_retained)):
        each, halves = np.array([of(law, values, times) for values in fits]).T
        mean, half = mean_and_half_width(each.tolist())
        found |= {way: mean, f"{way}_half": math.hypot(half, float(halves.mean()))}
    return found
