"""What an effect is said to cost."""

from __future__ import annotations

from pywet.planning import costs


def test_a_cost_within_the_scatter_is_neither_cost_nor_saving() -> None:
    """Two hundredths less with an effect than without it is chance: packings scatter by five."""
    assert [costs.shown(c) for c in (1.632, 0.14, -0.3)] == ["+163 %", "+14 %", "-30 %"]
    assert [costs.shown(c) for c in (-0.019, 0.0, 0.05)] == ["<5 %"] * 3
    assert costs.shown(None) == "-"
