"""The comparison of two groups of runs: what it must call a difference, and what not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pywet.errors import PywetError
from pywet.evidence.engines import screening

CONFIG = Path(__file__).parents[3] / "config"
TIMES = np.linspace(0.0, 1.4, 41)


def runs(count: int, seed: int, shift: float = 0.0) -> np.ndarray:
    """Curves that fall from 1 with a random walk of their own, which is what neighbouring times have in common."""
    random = np.random.default_rng(seed)
    walk = np.cumsum(random.normal(0.0, 0.004, (count, len(TIMES))), axis=1)
    walk[:, 0] = 0.0
    return 1.0 - 0.4 * TIMES / TIMES[-1] + walk - shift * TIMES / TIMES[-1]


def test_false_alarms_are_as_rare_as_the_level() -> None:
    """Forty pairs of groups of the same kind: 2 calls are expected, 8 or more have a probability of 0.001."""
    calls = sum(not screening.compare(TIMES, runs(5, 2 * k), runs(5, 2 * k + 1))[1].agree for k in range(40))
    assert calls < 8


def test_a_difference_beyond_the_spread_is_called() -> None:
    """0.15 at the end against a standard deviation of 0.026: at least ten standard errors."""
    frame, verdict = screening.compare(TIMES, runs(6, 1), runs(6, 2, shift=0.15))
    assert not verdict.agree
    # the smallest share there is: this split and its mirror image of all 924
    assert verdict.p == pytest.approx(2 / 924)
    assert frame["difference"].iloc[-1] == pytest.approx(-0.15, abs=3 * frame["standard_error"].iloc[-1])


def test_t_is_welchs(seed: int = 4) -> None:
    """Against scipy where the spread is far above the floor of the standard error."""
    from scipy.stats import ttest_ind

    one, two = 100 * runs(7, seed), 100 * runs(7, seed + 1)
    frame, _ = screening.compare(TIMES, one, two)
    exact = ttest_ind(two[:, 1:], one[:, 1:], equal_var=False).statistic
    # the floor adds 0.0005² to a variance of at least 0.1²
    assert frame["t"].to_numpy()[1:] == pytest.approx(exact, rel=1e-4)


def test_equal_runs_do_not_divide_by_zero() -> None:
    """Before the slide opens all runs are equal."""
    flat = np.ones((5, len(TIMES)))
    frame, verdict = screening.compare(TIMES, flat, flat)
    assert verdict.agree and verdict.p == 1.0 and (frame["t"] == 0).all()


def test_unequal_groups_are_refused() -> None:
    """The test of splits is for groups of one size."""
    with pytest.raises(PywetError, match="5 and 4 runs were given; expected the same number of each"):
        screening.compare(TIMES, runs(5, 1), runs(4, 2))


def test_seeds_give_different_arrangements_and_the_same_seed_the_same(tmp_path: Path) -> None:
    """Both engines start from the same places; another seed from others."""
    import pandas as pd

    tables = []
    for name, seed in (("a", 10007), ("b", 10007), ("c", 10009)):
        assert screening.prepare(CONFIG, 1, "smoke", seed, tmp_path / name).effects.rolling is False
        tables.append(pd.read_parquet(tmp_path / name / "spheres.parquet"))
    assert tables[0].equals(tables[1])
    assert (tables[0][["x", "y", "z"]] - tables[2][["x", "y", "z"]]).abs().median().min() > 1e-3
