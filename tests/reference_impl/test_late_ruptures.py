"""Whether a rupture came late is judged by a speed that an impact between two neighbour checks may have taken."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pandas as pd
import pytest

from reference_impl.replay.liquid import late_ruptures
from reference_impl.replay.lives import Lives, none


def judged(events: pd.DataFrame, time_step: float) -> list[bool]:
    """Whether each event is a late rupture, in water at every step."""
    meta = {
        "time_step": time_step, "bridges_every": 1, "viscosity": 1e-3, "surface_tension": 0.07275,
        "effects": {"dynamic_rupture": "pitois"},
    }  # fmt: skip
    run: Any = SimpleNamespace(table=lambda name: events, meta=meta)
    late = late_ruptures(run, events["rupture_distance"].to_numpy(), Lives(none(), events, 0, -1))
    return list(late.tolist())


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
    assert judged(events, 1.77e-5) == [False, late]


@pytest.mark.parametrize(
    ("other", "since", "late"),
    [
        ((15430, 72, 1), 3, False),  # from a run at full scale: the pair's second sphere hit a wall at 1.73 m/s
        ((14273, 99, 0), 3, False),
        ((99, 14273, 0), 3, False),
        ((72, 15431, 0), 3, True),  # spheres of other numbers
        ((15431, 15430, 1), 3, True),  # a part of a wall, not the sphere of that number
        ((15430, 72, 1), 18, True),  # too long ago: 1.73 m/s has covered 0.75 mm since
        (None, 3, True),
    ],
)
def test_a_pair_of_which_one_sphere_hit_a_third_body(
    other: tuple[int, int, int] | None, since: int, late: bool
) -> None:
    """At 0.39 m/s the limit is 0.771 mm; the gap a step before, 0.786 mm, is below it only from 0.65 m/s on."""
    of_pair, at = (14273, 15430, 0), 42694
    rows = [(42120, 0, *of_pair, 1.14e-4, 0.401256), (at, 1, *of_pair, 7.955377532950759e-4, 0.3935349622473135)]
    if other:
        rows.insert(1, (at - since, 0, *other, 2.1e-5, 1.730143))
    events = pd.DataFrame(rows, columns=["step", "kind", "i", "j", "partner_kind", "separation", "speed"])
    events["volume"], events["rupture_distance"] = 2.27e-10, 7.179811106096124e-4
    assert judged(events, 2.42e-5) == [False] * (len(rows) - 1) + [late]
