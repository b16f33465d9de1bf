"""Copies of a periodic box in the replay: what is near does not change with a shift of everything along the box."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from reference_impl.motion.touching import near_copies
from reference_impl.replay import images
from reference_impl.replay.io import ReplayError

BOX = images.Images(np.array([0.04, 0.0, 0.03]))


def test_the_shortest_way_is_the_least_of_all_copies() -> None:
    way = np.random.default_rng(1).uniform(-0.1, 0.1, (200, 3))
    copies = [way + np.array((a * 0.04, 0.0, b * 0.03)) for a in range(-5, 6) for b in range(-5, 6)]
    least = np.min([np.linalg.norm(c, axis=1) for c in copies], axis=0)
    assert np.linalg.norm(BOX.nearest(way), axis=1) == pytest.approx(least, rel=1e-12)
    assert len(BOX.others()) == 8 and images.Images(np.zeros(3)).nearest(way) is way


@pytest.mark.parametrize("shift", [0.0, 0.011, 0.02, 0.037])
def test_pairs_that_are_near_are_those_of_all_copies(shift: float) -> None:
    draw = np.random.default_rng(2)
    x = draw.uniform(0.0, 1.0, (150, 3)) * (0.04, 0.05, 0.03)
    x[:, 0] = (x[:, 0] + shift) % 0.04
    reach = draw.uniform(0.001, 0.003, 150)
    d = np.linalg.norm(BOX.nearest(x[:, None] - x[None]), axis=2)
    a, b = np.nonzero(np.triu(d < reach[:, None] + reach[None], 1))
    found = near_copies(x, reach, BOX)
    assert len(a) > 40 and np.stack(found).tolist() == np.stack([a, b]).tolist()


@pytest.mark.parametrize("wrong", [[0.04], "0.04", [0.04, -1.0, 0.0], [0.04, None, 0.0]])
def test_a_box_that_is_none_is_refused(tmp_path: Path, wrong: object) -> None:
    (tmp_path / "script.json").write_text(json.dumps({"output_steps": [0], "window_steps": 1, images.KEY: wrong}))
    with pytest.raises(ReplayError, match="three lengths"):
        images.of(tmp_path)
