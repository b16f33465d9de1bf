"""Many separations of one bridge are those of each by itself, from a branch followed once."""

from __future__ import annotations

import pytest

from pywet.laws import exact_bridge
from pywet.laws.exact_bridge import branch


@pytest.mark.parametrize("pair", [(2e-3, 2e-3, 0.35, 0.35), (2e-3, 1e-3, 0.2, 0.6), (2e-3, float("inf"), 0.35, 0.1)])
def test_many_separations(monkeypatch: pytest.MonkeyPatch, pair: tuple[float, float, float, float]) -> None:
    """Forces to 1e-12, None beyond rupture; a hundred thousand separations take one trace, not as many."""
    end = exact_bridge.rupture(1e-10, *pair).separation
    gaps = [-1e-6, 0.0, *(end * k / 37 for k in range(1, 38)), 1.01 * end]
    single = [exact_bridge.solve(gap, 1e-10, *pair) for gap in gaps]
    traces, follow = [], branch.follow
    monkeypatch.setattr(branch, "follow", lambda case, stop: traces.append(stop) or follow(case, stop))
    many = exact_bridge.solve_many(gaps, 1e-10, *pair)
    assert len(traces) == 1
    assert many[-1] is None and single[-1] is None and many[1] is not None
    for one, other in zip(single[:-1], many[:-1], strict=True):
        assert (one is None) == (other is None)
        assert one is None or one.force(0.07) == pytest.approx(other.force(0.07), rel=1e-12)
