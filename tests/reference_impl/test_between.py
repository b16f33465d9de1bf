"""Impulses between the sampling windows, of spheres that hardly move."""

from __future__ import annotations

from pathlib import Path

import pytest

from pywet.cases.small import small
from pywet.scene import Output
from reference_impl.motion.between import FEWEST
from reference_impl.replay.replay import replay
from tests.engines.liggghts.scenes import WATER, spheres_of
from tests.reference_impl import newton_scenes as scenes

EVERY = 1000
DRIFT = (1e-8, 2e-8, 1e-8)


@pytest.mark.engine
def test_drag_of_spheres_at_rest_is_not_judged_by_round_off(tmp_path: Path) -> None:
    """Sixteen drifting pairs come to rest in the pull of their bridges.

    After that their separations change by the last digits of their coordinates only, which says nothing about the drag, neither
    in full groups nor in the one left over at the end.
    """
    r = scenes.R
    places = [(0.05 + 3.0 * r * (k % 4), 0.05 + 3.0 * r * (k // 4), z) for k in range(16) for z in (0.0, 2.0 * r)]
    spheres = [small.Sphere(1, at, DRIFT) for at in places]
    small.prepare(
        tmp_path, spheres_of(r), spheres, scenes.contacts(1), liquid=WATER, effects=small.PAPER, time_step_s=scenes.STEP,
        steps=12 * EVERY, box=0.2,
        output=Output(interval_s=EVERY * scenes.STEP, contact_windows=1, contact_window_steps=20),
    )  # fmt: skip
    small.run(tmp_path, spheres)
    drag = replay(tmp_path)["quantities"]["between_drag"]
    assert drag["ok"] and drag["largest"] < 1e-3
    assert drag["count"] >= 2 and drag["worst"]["size"] >= FEWEST
