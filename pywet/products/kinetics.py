"""Kinetics of a batch: laws of the fraction retained over time, fitted and ranked on seeds that were not fitted.

Every law has a delay t0, before which nothing passes. Y is the fraction of a class's spheres that is retained; tau = t - t0.

| law | Y |
|---|---|
| first order | exp(-k tau) |
| first order, residue | r + (1 - r) exp(-k tau) |
| second order | 1/(1 + k tau) |
| power of time | exp(-k tau^n) |
| two rates | s exp(-k1 tau) + (1 - s) exp(-k2 tau) |
| crowded, then first order | 1 - k tau until tau = c, then (1 - k c) exp(-k (tau - c)/(1 - k c)): the rate is continuous |
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from pywet import run_folder
from pywet.errors import PywetError, shown
from pywet.geometry.surface import Floats
from pywet.products import streams
from pywet.products.partition import mean_and_half_width
from pywet.runs.distinct_seeds import distinct_seeds
from pywet.runs.rundir import RunDir
from pywet.util.files import check_numbers, read_csv

STORED = ("fraction_retained", "spheres")
OPEN, ABOVE = "time_since_opening_s", "above_"
"""Stored tables, and the columns of times in the first and of spheres that have not passed in the second."""
CURE = "name the finished run of a screening case, or a folder of stored tables"
PASSES = 0.02
"""Total loss below which a class does not pass and has no kinetics."""
LONG_S = 1e3
"""Upper bound of times [s] and of rates [1/s]."""


@dataclass(frozen=True)
class Law:
    """A law of tau >= 0: names, initial values and upper bounds of its parameters, and its function."""

    name: str
    parameters: tuple[str, ...]
    start: tuple[float, ...]
    bounds: tuple[float, ...]
    function: Callable[..., Floats]

    def __call__(self, t: Floats, *values: float) -> Floats:
        """Return the fraction retained at times [s]; the first value is the delay."""
        return np.asarray(self.function(np.maximum(np.asarray(t, dtype=float) - values[0], 0.0), *values[1:]))


def _crowded(tau: Floats, k: float, c: float) -> Floats:
    c = min(c, 1.0 / max(k, 1.0 / LONG_S))  # all has passed after 1/k
    left = max(1.0 - k * c, 1e-9)
    return np.where(tau < c, 1.0 - k * tau, left * np.exp(-k * np.maximum(tau - c, 0.0) / left))


LAWS = (
    Law("first order", ("k",), (0.3,), (LONG_S,), lambda x, k: np.exp(-k * x)),
    Law("first order, residue", ("k", "r"), (0.3, 0.1), (LONG_S, 1.0), lambda x, k, r: r + (1.0 - r) * np.exp(-k * x)),
    Law("second order", ("k",), (0.3,), (LONG_S,), lambda x, k: 1.0 / (1.0 + k * x)),
    Law("power of time", ("k", "n"), (0.3, 1.0), (LONG_S, 5.0), lambda x, k, n: np.exp(-k * x**n)),
    Law(
        "two rates", ("s", "k1", "k2"), (0.7, 0.8, 0.1), (1.0, LONG_S, LONG_S),
        lambda x, s, k1, k2: s * np.exp(-k1 * x) + (1.0 - s) * np.exp(-k2 * x),
    ),
    Law("crowded, then first order", ("k", "c"), (0.2, 0.5), (LONG_S, LONG_S), _crowded),
)  # fmt: skip


def fit(law: Law, t: Floats, y: Floats) -> Floats:
    """Return least-squares values of t0 and the parameters.

    Their uncertainty is the scatter of several seeds: the outputs of one run are points of one cumulative curve, so that
    its residuals are not independent.
    """
    from scipy.optimize import curve_fit

    high = (float(t.max()) or 1.0, *law.bounds)
    start = (min(0.1, 0.5 * high[0]), *law.start)
    try:
        values, _ = curve_fit(law, t, y, p0=start, bounds=(np.zeros(len(start)), high), max_nfev=20_000)
    except RuntimeError as error:
        raise PywetError(
            f"kinetics: {law.name} could not be fitted ({error}); expected a decreasing curve", code="kinetics.fit"
        ) from error
    return np.asarray(values)


def points(curve: pd.DataFrame, kind: str) -> tuple[Floats, Floats]:
    """Return times and the fraction retained of a class, of a table as `curves` returns it."""
    return curve["time_s"].to_numpy(dtype=float), curve[kind].to_numpy(dtype=float)


def rms(law: Law, values: Floats, t: Floats, y: Floats) -> float:
    """Return the root mean square of the residuals."""
    return float(np.sqrt(np.mean((law(t, *values) - y) ** 2)))


def curves(run: Path) -> pd.DataFrame:
    """Return time_s since the opening and the share of each class's spheres that has not passed, from a run or stored tables."""
    if (run / f"{STORED[0]}.csv").exists():
        found = _of_tables(run)
    elif any((run / f"{name}.parquet").exists() for name in ("results/fraction_retained", "history/retired")):
        found = _of_run(RunDir(run))
    else:
        raise PywetError(
            f"{shown(run)} has no fraction_retained; expected the finished run of a screening case, or a folder of stored tables",
            code="kinetics.no_curve", where=run,
        )  # fmt: skip
    found = found[found["time_s"] >= 0.0]
    if found.empty:
        raise PywetError(
            f"{shown(run)} holds no time after the slide has opened; expected some: {CURE}",
            code="kinetics.no_time", where=run,
        )  # fmt: skip
    return found


def _of_tables(folder: Path) -> pd.DataFrame:
    """The same of stored tables: times, and numbers of spheres that have not passed."""
    paths = [folder / f"{name}.csv" for name in STORED]
    times = read_csv(paths[0], CURE)
    check_numbers(times, [OPEN], paths[0], CURE)
    above = read_csv(paths[1], CURE).filter(regex=f"^{ABOVE}").rename(columns=lambda name: name.removeprefix(ABOVE))
    table = pd.concat([times[[OPEN]], above], axis=1)
    check_numbers(table, [str(name) for name in table], paths[1], CURE)
    return above.div(above.max()).dropna(axis=1).assign(time_s=times[OPEN])


def _of_run(run: RunDir) -> pd.DataFrame:
    """The same of a case or of a batch with outlets: all spheres are there from the start, and leave with the unders alone."""
    scene, flow = run.scene, streams.read(run)
    spheres = flow.spheres
    lost = spheres.loc[spheres["left_s"].notna() & (spheres["product"] != "unders"), "id"]
    if scene.insertion_s or len(lost):
        gone = run.table("history/retired")
        outlets = sorted(gone.loc[gone["id"].isin(lost), "outlet"].unique())
        through = ", ".join(scene.outlets[k - 1].name for k in outlets)
        given = (
            "inserts spheres during the run" if scene.insertion_s else f"loses {len(lost)} spheres through {through}"
        )
        raise PywetError(
            f"{shown(run.path)} {given}; expected a batch: all spheres there from the start, walls around the screen",
            code="kinetics.no_batch", where=run.path,
        )  # fmt: skip
    times = streams.edges(scene, scene.duration_s) if scene.outlets else run.timeline.times
    found = {"time_s": times - flow.start_s}
    for kind in (kind for kind in scene.classes if kind.count):
        left = np.sort(spheres.loc[(spheres["type"] == kind.type) & (spheres["product"] == "unders"), "left_s"])
        found[kind.name] = 1.0 - np.searchsorted(left, times + 1e-9) / kind.count
    return pd.DataFrame(found)


def ranking(runs: Sequence[pd.DataFrame], kind: str) -> pd.DataFrame:
    """All laws of a class, the best on seeds that were not fitted first.

    Returns
    -------
    DataFrame
        law, parameters (a sentence: of several seeds the means of their fits with 95 % intervals, of one seed without), rms of
        the fit to all, rms_held_out: each seed against the law fitted to the others (nan of one seed, ranked by the fit then).
    """
    rows = []
    every = points(pd.concat(runs), kind)
    for law in LAWS:
        fitted, held_out = fit(law, *every), math.nan
        values = [f"{value:.4g}" for value in fitted]
        if len(runs) > 1:
            each = np.array([fit(law, *points(run, kind)) for run in runs])
            values = ["{:.4g} ± {:.2g}".format(*mean_and_half_width(column)) for column in each.T]
            held_out = math.sqrt(np.mean([_unseen(law, runs, k, kind) ** 2 for k in range(len(runs))]))
        names = ("t0", *law.parameters)
        rows.append(
            {
                "class": kind,
                "law": law.name,
                "parameters": ", ".join(f"{n} {value}" for n, value in zip(names, values, strict=True)),
                "rms": rms(law, fitted, *every),
                "rms_held_out": held_out,
            }
        )
    table = pd.DataFrame(rows)
    return table.sort_values("rms_held_out" if len(runs) > 1 else "rms", ignore_index=True)


def _unseen(law: Law, runs: Sequence[pd.DataFrame], k: int, kind: str) -> float:
    """Return the residual of one seed relative to the law fitted to the others."""
    others = pd.concat([run for n, run in enumerate(runs) if n != k])
    return rms(law, fit(law, *points(others, kind)), *points(runs[k], kind))


def kinetics(folders: Sequence[Path | str]) -> pd.DataFrame:
    """Fit laws of the fraction retained over time to seeds of one case, and rank them on the seeds that were not fitted.

    Parameters
    ----------
    folders : sequence of Path or str
        Runs, or folders of stored tables; one with the seed of an earlier one, or of another case, is left out.

    Returns
    -------
    DataFrame
        For every class that passes the laws, the best first: class, law, parameters (with 95 % intervals of several seeds), rms,
        rms_held_out.

    Raises
    ------
    PywetError
        If a folder has no fraction retained, or no class passes.
    """
    with run_folder.reading(*(Path(folder) for folder in folders)):
        runs = [curves(folder) for folder in distinct_seeds(map(Path, folders))]
    classes = [c for c in runs[0] if c != "time_s" and all(c in run for run in runs)]
    passing = [c for c in classes if min(float(run[c].iloc[-1]) for run in runs) < 1.0 - PASSES]
    if not passing:
        raise PywetError(
            f"{shown(Path(folders[0]))}: no class passes the screen; expected one that loses {100 * PASSES:g} % at least",
            code="kinetics.none_passes", where=folders[0],
        )  # fmt: skip
    return pd.concat([ranking(runs, str(kind)) for kind in passing], ignore_index=True)
