"""Whether a rupture came late is judged by a speed that an impact between two neighbour checks may have taken."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pandas as pd
import pytest

from reference_impl.replay.liquid import late_ruptures
from reference_impl.replay.lives import Lives, none


@pytest.mark.parametrize(
    ("at_formation", "at_rupture", "gap", "late"),
    [
        # from a run at full scale: an impact on a third sphere, after which the limit is 5.5e-4
        (1.6007, 0.2178, 5.66280e-4, False),
        (0.2000, 0.2178, 5.66280e-4, True),  # always slower than the rupture requires
        (1.6007, 0.2178, 6.30000e-4, True),  # above the limit also at the speed of formation
        (1.6007, 1.6007, 5.90000e-4, False),
    ],
)
def test_a_bridge_that_lost_its_speed_in_one_step(
    at_formation: float, at_rupture: float, gap: float, late: bool
) -> None:
    static = 5.18195e-4
    events = pd.DataFrame(
        {
            "step": [516870, 516916], "kind": [0, 1], "partner_kind": [1, 1], "i": [16699, 16699], "j": [68, 68],
            "volume": 1.0126e-10, "rupture_distance": static, "separation": [3.1e-5, gap], "speed": [at_formation, at_rupture],
        }
    )  # fmt: skip
    meta = {
        "time_step": 1.77e-5, "bridges_every": 1, "viscosity": 1e-3, "surface_tension": 0.07275,
        "effects": {"dynamic_rupture": "pitois"},
    }  # fmt: skip
    run: Any = SimpleNamespace(table=lambda name: events, meta=meta)
    found = late_ruptures(run, events["rupture_distance"].to_numpy(), Lives(none(), events, 0, -1))
    assert found.tolist() == [False, late]
