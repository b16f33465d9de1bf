"""Bridges that act every few steps: the same physics with fewer evaluations, checked by the replay as any other run.

What is exact: nothing happens to bridges between the steps at which they act, Newton's law holds with impulses in every step,
works add up, ranks agree. What is of first order in the time step stays as large as with an evaluation in every step.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from pydantic import ValidationError

from pywet import config
from pywet.cases.small import small
from pywet.config.settings import Settings
from pywet.engines import schedule
from pywet.engines.liggghts import driver
from pywet.planning import time_steps
from pywet.scene import EngineScene
from pywet.schema import WORKS
from reference_impl.motion import impulses
from reference_impl.replay import spans
from reference_impl.replay.io import ReplayError
from reference_impl.replay.replay import replay
from tests.engines.liggghts import beds, stability, test_energy
from tests.engines.liggghts.scenes import WATER, contacts, spheres_of
from tests.error_codes import raises_code
from tests.reference_impl.test_stream import at_size

pytestmark = pytest.mark.engine
EVERY = 4


def bed(run_dir: Path, ranks: int = 1, **changes: object) -> EngineScene:
    """Some 170 spheres between moving walls for 24 ms; outputs and checkpoints are asked for at steps that are no multiples."""
    made = beds.prepare(run_dir, beds.bed((6, 6, 6)), 1198, 3, 11)
    scene = EngineScene(**{**made.model_dump(), "bridges_every": EVERY, **changes})
    (run_dir / "scene.json").write_text(scene.model_dump_json())
    driver.run(run_dir, ranks, progress=False)
    return scene


@pytest.mark.parametrize("how", ["explicit", "semi_implicit"])
def test_replay_and_budget(tmp_path: Path, how: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """All that the reference knows, Newton's law in steps with and without impulses; works close to round-off of 1200 steps.

    In parts of 50 events it is the same.
    """
    scene = bed(tmp_path, viscous_integration=how)
    result = at_size(tmp_path, 50, monkeypatch)
    assert result["ok"], result["diagnosis"]
    assert result == at_size(tmp_path, spans.SIZE, monkeypatch)
    counts = {
        name: result["quantities"][name]["count"] for name in ("newton_force", "contact_weight", "formation_missed")
    }
    assert counts["newton_force"] > 6000 and counts["contact_weight"] > 600 and counts["formation_missed"] > 1000
    assert scene.output_steps[1] == 108 and schedule.checkpoint_every(scene) == 300
    events, log = (beds.table(tmp_path, f"history/{name}") for name in ("events", "contacts"))
    assert len(events) > 100 and not (events["step"] % EVERY).any() and set(events["kind"]) == {0, 1}
    windows = np.concatenate([np.arange(*window) for window in result["compared"]["windows"]])
    assert sorted(set(log["step"])) == [s for s in windows if s % EVERY == 0]
    energy = beds.table(tmp_path, "history/energy")
    turnover = energy[WORKS].abs().sum(axis=1).iloc[-1]
    assert (test_energy.gap_of(energy) - energy["half_kick"]).abs().max() < 1e-12 * turnover


def test_a_bridge_that_forms_acts_at_once(tmp_path: Path) -> None:
    """Two wet spheres meet: at formation the force acts for (4 - 1)/2 steps, then for 4; its impulse is that of every step.

    A formation is up to 3 of the 400 steps late in which the bridge acts: speeds are those of every step within a hundredth.
    """
    speeds = []
    for every in (1, EVERY):
        bodies = [small.Sphere(1, (-2.65e-3, 0, 0), (0.05, 0, 0)), small.Sphere(1, (2.65e-3, 0, 0), (-0.05, 0, 0))]
        small.prepare(tmp_path / str(every), spheres_of(2.5e-3), bodies, contacts(1, stiffness=1e3), liquid=WATER,
                      effects=small.PAPER, time_step_s=5e-6, steps=600, output_interval_s=3e-3, window_trajectories=True,
                      bridges_every=every)  # fmt: skip
        small.run(tmp_path / str(every), bodies)
        assert replay(tmp_path / str(every))["ok"]
        log, events = (beds.table(tmp_path / str(every), f"history/{name}") for name in ("contacts", "events"))
        formed, after = int(events["step"].iloc[0]), [1.0, 1.0] if every == 1 else [1.5, 4.0]
        assert formed > 0 and log["weight"].tolist()[:2] == after
        assert log["step"].iloc[0] == (formed if every > 1 else formed + 1)
        speeds.append(beds.table(tmp_path / str(every), "history/window_states")["vx"].to_numpy())
    assert np.abs(speeds[0] - speeds[1])[-2:].max() < 1e-2 * 0.1


def test_capillary_energy_is_as_with_every_step(tmp_path: Path) -> None:
    """Formed - ruptured - stored is the capillary work to first order of the time step: the half step that a new bridge is late.

    With impulses no more than that is missing: within a tenth, and a factor of 2 for a halving.
    """
    left = {}
    for every, step in ((1, 2e-5), (EVERY, 2e-5), (EVERY, 1e-5)):
        end = test_energy.held_together(tmp_path / f"{every}-{step}", step, bridges_every=every).iloc[-1]
        left[every, step] = float(end["capillary"] - (end["formed"] - end["ruptured"] - end["capillary_stored"]))
    assert left[EVERY, 2e-5] == pytest.approx(left[1, 2e-5], rel=0.1), left
    assert 1.5 < left[EVERY, 2e-5] / left[EVERY, 1e-5] < 2.6, left


def test_two_ranks(tmp_path: Path) -> None:
    """Expect the same events in the same steps; positions differ by the growth of round-off in 24 ms."""
    for ranks in (1, 2):
        bed(tmp_path / str(ranks), ranks)
    one, two = (beds.table(tmp_path / str(ranks), "history/events") for ranks in (1, 2))
    assert len(one) > 100
    pd.testing.assert_frame_equal(one[beds.LOOKS], two[beds.LOOKS])
    assert beds.apart(tmp_path / "1", tmp_path / "2").max() < 1e-9 * beds.RADIUS


def test_the_replay_knows_when_bridges_must_act_and_for_how_long(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run of k = 4 that says k = 2 lacks steps of the contact log, one that says k = 8 has too many.

    Forces that act for one step where four are meant break Newton's law by that factor, which is named.
    """
    bed(tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(impulses, "weights", lambda run, table: np.ones(len(table)))
        result = replay(tmp_path)
        assert not result["quantities"]["newton_force"]["ok"] and not result["quantities"]["contact_weight"]["ok"]
        sentences = [f["sentence"] for f in result["diagnosis"]["findings"]]
        assert any("every force of bridges is 4 times what it should be" in s for s in sentences), sentences
    scene, meta = (json.loads((tmp_path / name).read_text()) for name in ("scene.json", "history/meta.json"))
    for every in (2, 8):
        (tmp_path / "scene.json").write_text(json.dumps({**scene, "bridges_every": every}))
        (tmp_path / "history" / "meta.json").write_text(json.dumps({**meta, "bridges_every": every}))
        with pytest.raises(ReplayError):
            replay(tmp_path)


def test_limits_of_the_time_step(tmp_path: Path) -> None:
    """Drag alone is stable to c k dt/m = 2: the advised limit is a quarter for k = 4 and true within 3 % in the engine."""
    limit, effect = stability.advised(tmp_path / "advised", 1.0, "explicit", bridges_every=EVERY)
    single, _ = stability.advised(tmp_path / "single", 1.0, "explicit")
    assert effect == "viscous normal" and limit == pytest.approx(single / EVERY, rel=1e-12)
    assert stability.is_stable(tmp_path / "below", 1.0, 0.97 * limit, "explicit", bridges_every=EVERY)
    assert not stability.is_stable(tmp_path / "above", 1.0, 1.03 * limit, "explicit", bridges_every=EVERY)


def test_too_many_steps_are_refused(tmp_path: Path) -> None:
    """In one sentence that names the setting, for drag and for the swing of a contact; scenes that make no sense as well."""
    thick, _ = stability.pressed_pair(tmp_path, 1.0, 5e-6, "explicit", bridges_every=EVERY)
    with raises_code("step.unstable", says="or bridges_every, which is 4"):
        time_steps.refuse_unstable(thick)
    thin, _ = stability.pressed_pair(tmp_path, 1e-4, 6e-5, "semi_implicit", bridges_every=EVERY)
    with raises_code("step.unstable", says="or bridges_every, which is 4"):
        time_steps.refuse_unstable(thin)
    time_steps.refuse_unstable(thin.model_copy(update={"bridges_every": 1}))
    for change, words in (({"bridges_every": 17}, "less than or equal to 16"),
                          ({"bridges_every": 4, "effects": small.DRY}, "without bridges; expected 1"),
                          ({"bridges_every": 8, "output": {"interval_s": 1.0, "contact_window_steps": 6}},
                           "expected windows in which bridges act")):  # fmt: skip
        with pytest.raises(ValidationError, match=words):
            EngineScene(**{**thin.model_dump(), **change})
    given = config.load(Path(__file__).parents[3] / "config").settings.model_dump()
    given["time_step"]["bridges_every"], given["output"]["contact_window_steps"] = 8, 6
    with pytest.raises(ValidationError, match="6 is less than 8"):
        Settings(**given)


@pytest.mark.parametrize("steps", [1, 3])
def test_bridges_act_in_windows_shorter_than_their_interval(tmp_path: Path, steps: int) -> None:
    """Windows at random places begin where bridges act, also next to outputs and checkpoints; so they are not refused."""
    pair, _ = stability.pressed_pair(tmp_path, 1.0, 5e-6, "explicit", bridges_every=EVERY)
    output = {"interval_s": 1e-3, "contact_windows": 20, "contact_window_steps": steps, "checkpoints": 7}
    scene = EngineScene(**{**pair.model_dump(), "duration_s": 0.02, "output": output})
    windows = schedule.windows(scene)
    assert len(windows) == 20 and all(any(s % EVERY == 0 for s in range(*window)) for window in windows)
    given = config.load(Path(__file__).parents[3] / "config").settings.model_dump()
    given["time_step"]["bridges_every"], given["output"]["contact_window_steps"] = EVERY, steps
    Settings(**given)
