"""Whether a rupture came late is judged by a speed that an impact between two neighbour checks may have taken."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from reference_impl.replay.io import Run
from reference_impl.replay.laws import pitois_factor
from reference_impl.replay.liquid import late_ruptures
from reference_impl.replay.lives import Lives, none


def judged(
    folder: Path,
    events: pd.DataFrame,
    time_step: float,
    viscosity: float = 1e-3,
    walls: tuple[dict[str, Any], ...] = (),
) -> list[bool]:
    """Whether each event is a late rupture, at every step; in water unless a viscosity is given."""
    meta = {
        "time_step": time_step, "bridges_every": 1, "viscosity": viscosity, "surface_tension": 0.07275,
        "effects": {"dynamic_rupture": "pitois"},
    }  # fmt: skip
    scene = {
        "output": {"interval_s": 1.0}, "effects": {"bridges": True}, "classes": [], "pairs": [], "walls": walls,
        "gravity_m_per_s2": [], "spheres_file": "", "time_step_s": time_step, "duration_s": 1.0,
    }  # fmt: skip
    (folder / "scene.json").write_text(json.dumps(scene))
    (folder / "history").mkdir()
    events.to_parquet(folder / "history" / "events.parquet")
    run = Run(folder, meta, {"events": events})
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
    tmp_path: Path, at_formation: float, at_rupture: float, gap: float, late: bool
) -> None:
    static = 5.18195e-4
    events = pd.DataFrame(
        {
            "step": [516870, 516916], "kind": [0, 1], "partner_kind": [1, 1], "i": [16699, 16699], "j": [68, 68],
            "volume": 1.0126e-10, "rupture_distance": static, "separation": [3.1e-5, gap], "speed": [at_formation, at_rupture],
        }
    )  # fmt: skip
    assert judged(tmp_path, events, 1.77e-5) == [False, late]


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
    tmp_path: Path, other: tuple[int, int, int] | None, since: int, late: bool
) -> None:
    """At 0.39 m/s the limit is 0.771 mm; the gap a step before, 0.786 mm, is below it only from 0.65 m/s on."""
    of_pair, at = (14273, 15430, 0), 42694
    rows = [(42120, 0, *of_pair, 1.14e-4, 0.401256), (at, 1, *of_pair, 7.955377532950759e-4, 0.3935349622473135)]
    if other:
        rows.insert(1, (at - since, 0, *other, 2.1e-5, 1.730143))
    events = pd.DataFrame(rows, columns=["step", "kind", "i", "j", "partner_kind", "separation", "speed"])
    events["volume"], events["rupture_distance"] = 2.27e-10, 7.179811106096124e-4
    assert judged(tmp_path, events, 2.42e-5) == [False] * (len(rows) - 1) + [late]


STATIC = 5e-4


@pytest.mark.parametrize(
    ("speed", "fastest", "of_limit", "late"),
    [
        (0.01, 0.01, 1.5, True),  # slow, and so is all else
        (0.01, 0.01, 1.2, True),
        (0.01, 0.01, 1.01, False),
        (0.01, 1.0, 1.5, False),  # where others collide at 1 m/s: before a collision the limit was higher
        (0.0, 0.04, 1.3, False),  # at a turn of a shaken pair the speed vanishes for a step
    ],
)
@pytest.mark.parametrize("viscosity", [1.0, 1.4])
def test_ruptures_of_a_viscous_liquid(
    tmp_path: Path, viscosity: float, speed: float, fastest: float, of_limit: float, late: bool
) -> None:
    """The margin is the speed that can be lost in one step, not a fixed one that exceeds all speeds."""
    gap = STATIC * of_limit * float(pitois_factor(np.array([speed]), viscosity, 0.07275)[0])
    rows = [(10, 0, 1, 2, 1e-5, speed), (20, 0, 8, 9, 1e-5, fastest), (50000, 1, 1, 2, gap, speed)]
    assert judged(tmp_path, _events(rows), 1e-5, viscosity) == [False, False, late]


@pytest.mark.parametrize(("step", "late"), [(1001, False), (1002, True)])
def test_the_wall_of_a_bridge_stops(tmp_path: Path, step: int, late: bool) -> None:
    """The speed of the wall is gone at once, and with it what the speed added to the limit."""
    slide = {"opens_at_s": 0.0, "travel_s": 0.01, "velocity_m_per_s": [0.1, 0.0, 0.0]}
    walls = ({"name": "plate", "motion": "slides", "motion_parameters": slide},)
    rows = [(10, 0, 1, 2, 1e-5, 0.0), (step, 1, 1, 2, 1.9 * STATIC, 0.0)]
    assert judged(tmp_path, _events(rows), 1e-5, 1.0, walls) == [False, late]


def _events(rows: list[tuple[float, ...]]) -> pd.DataFrame:
    events = pd.DataFrame(rows, columns=["step", "kind", "i", "j", "separation", "speed"])
    return events.assign(partner_kind=0, volume=1e-10, rupture_distance=STATIC)
