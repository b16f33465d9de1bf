"""Dry screening in both engines: runs of several seeds, and whether fraction retained over time differs beyond their spread.

Rolling resistance is off in both engines, because YADE's differs. A seed is that of the first arrangement of the spheres, so
both engines start from the same places; contacts make the two courses independent within a tenth of a second.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.apparatus.surface import Floats
from pywet.errors import PywetError
from pywet.evidence.compare import statistics
from pywet.evidence.compare.statistics import Sample
from pywet.evidence.engines.rows import TWO_ERRORS, row
from pywet.files import read_table, write_json, write_table
from pywet.runs.rundir import RunDir
from pywet.scene import Scene

ENGINES = ("liggghts", "yade")
FLOOR = 5e-4
"""Least standard deviation of a fraction retained: half a sphere."""
MANY = 19999
"""Splits of the runs that are tried at most; beyond, as many drawn at random."""


@dataclass(frozen=True)
class Verdict:
    """Outcome of a comparison of two groups of runs."""

    runs: int
    """In each group."""
    times: int
    largest_t: float
    """Largest |difference of means| over its standard error, over all output times."""
    at_time_s: float
    p: float
    """Share of the ways to split the runs into two groups that give as large a largest_t or a larger one."""
    largest_difference: float
    """Largest |difference of means|, an absolute fraction."""
    end_difference: float
    end_standard_error: float
    agree: bool

    @property
    def sentence(self) -> str:
        """The verdict in words."""
        what = "no difference" if self.agree else "a difference"
        return f"largest |t| {self.largest_t:.2f}, p = {self.p:.2f}: {what} beyond the seeds' spread"


def prepare(config_dir: Path, case: int, scale: str, seed: int, run_dir: Path) -> Scene:
    """The case without rolling resistance, with this seed of the first arrangement; writes the run directory."""
    from pywet import stages
    from pywet.screening import cases

    return cases.build(stages.resolved(config_dir, engine="yade", seed=seed), case, scale, run_dir)


def simulate(run_dir: Path, engine: str, progress: bool = True) -> None:
    """Run a prepared dry scene in an engine and write its tables of results."""
    from pywet import stages
    from pywet.screening.results import write_results

    stages.simulate(run_dir, 1, progress, engine)
    write_results(RunDir(run_dir))


def retained_curves(run_dirs: list[Path]) -> tuple[Floats, Floats]:
    """Times [s] since the slide opened, shape (T,), and fraction retained of each run, shape (runs, T)."""
    tables = [read_table(Path(d) / "results" / "fraction_retained.parquet") for d in run_dirs]
    times = tables[0]["time_since_opening_s"].to_numpy()
    if any(len(t) != len(times) or not np.allclose(t["time_since_opening_s"], times) for t in tables):
        raise PywetError("the runs to compare have different output times; give runs of one case and scale")
    return times, np.array([t["fraction_retained"].to_numpy() for t in tables])


def compare(times: Floats, one: Floats, two: Floats) -> tuple[pd.DataFrame, Verdict]:
    """Means, standard deviations and t of two groups of runs over time, and the verdict over all times at once.

    t(t_k) = (mean two − mean one)/√((s₁² + s₂²)/n), the pooled standard error of n runs each. Neighbouring times belong to the
    same runs, so t is not judged time by time: the largest |t| is set against the largest |t| of every other way to split the
    2n runs into two groups of n (a permutation test; exact whatever the distribution and the correlation in time).
    """
    if one.shape != two.shape or len(one) < 2:
        raise PywetError(f"{len(one)} and {len(two)} runs were given; expected the same number of each, at least two")
    # where all runs are equal, as before the slide opens, there is nothing to test
    floor = FLOOR * sqrt(2.0 / len(one))
    (finding,) = statistics.permutation([Sample(one, two)], floor, seed=0, most=MANY)
    t = statistics.pooled_t(two, one, floor)
    difference = two.mean(axis=0) - one.mean(axis=0)
    error = np.sqrt((one.var(axis=0, ddof=1) + two.var(axis=0, ddof=1)) / len(one))
    frame = pd.DataFrame(
        {
            "time_since_opening_s": times,
            "mean_one": one.mean(axis=0),
            "deviation_one": one.std(axis=0, ddof=1),
            "mean_two": two.mean(axis=0),
            "deviation_two": two.std(axis=0, ddof=1),
            "difference": difference,
            "standard_error": error,
            "t": t,
        }
    )
    verdict = Verdict(
        runs=len(one), times=len(times), largest_t=finding.t, at_time_s=float(times[finding.at]), p=finding.p,
        largest_difference=float(np.abs(difference).max()), end_difference=float(difference[-1]),
        end_standard_error=float(error[-1]), agree=finding.p > statistics.LEVEL,
    )  # fmt: skip
    return frame, verdict


def compare_engines(run_dirs: dict[str, list[Path]], folder: Path) -> Verdict:
    """Compare runs of LIGGGHTS and YADE; writes fraction_retained.parquet (and CSV), verdict.json and the picture."""
    from pywet.evidence.engines import pictures

    times, one = retained_curves(run_dirs["liggghts"])
    _, two = retained_curves(run_dirs["yade"])
    frame, verdict = compare(times, one, two)
    named = {
        f"{a}_{k}": f"{a}_{e}" for a in ("mean", "deviation") for k, e in zip(("one", "two"), ENGINES, strict=True)
    }
    write_table(frame.rename(columns=named), folder / "fraction_retained.parquet", csv=True)
    write_json(folder / "verdict.json", asdict(verdict))
    write_table(pd.DataFrame(rows(frame, verdict)), folder / "rows.parquet", csv=True)
    pictures.screening(times, one, two, frame, verdict.sentence, folder / "engines_screening.png")
    return verdict


def rows(frame: pd.DataFrame, verdict: Verdict) -> list[dict[str, Any]]:
    """Fraction retained of YADE against LIGGGHTS at quarters of the time, as rows of a table of agreement."""
    made = []
    scene = f"dry screening, {verdict.runs} seeds"
    for k in np.linspace(0, len(frame) - 1, 5).astype(int)[1:]:
        at = frame.iloc[k]
        quantity = f"fraction retained {at['time_since_opening_s']:.2f} s after opening"
        spread = 2.0 * at["standard_error"] / at["mean_one"]
        made.append(row(scene, quantity, "YADE", at["mean_two"], "LIGGGHTS", at["mean_one"], spread, TWO_ERRORS))
    return made
