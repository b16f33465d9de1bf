"""Half of the 95 % intervals within a run, which deck_numbers.yaml gathers in addition to the numbers of a screen.

An interval without an end (of d50, where the limits of T do not cross 0.5) makes a run fail; none is left out of a mean.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pywet.products import screening_report
from pywet.runs.loaded import Run


def _half(of: Callable[[dict[str, Any]], float]) -> Callable[[Run], float]:
    def half(run: Run) -> float:
        found = screening_report.stored(run.path)
        assert found is not None  # every run of this study has a deck
        return float(of(found))

    return half


d50_half = _half(lambda found: 0.5 * (found["d50_high_mm"] - found["d50_low_mm"]))
efficiency_half = _half(lambda found: 0.5 * (found["efficiency_high"] - found["efficiency_low"]))
throughput_half = _half(lambda found: found["throughput_half_width_t_per_h"]["all"])
overs_moisture_half = _half(lambda found: found["moisture_half_width_percent"]["overs"])
unders_moisture_half = _half(lambda found: found["moisture_half_width_percent"]["unders"])
pegged_half = _half(lambda found: found["pegged_share_half_width"])
