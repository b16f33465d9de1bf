"""Numbers that the deck takes from a scene, by hand; a folder that is not to be gone on from."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from pywet.cases.small import bodies, small
from pywet.engines import schedule
from pywet.engines.liggghts import contact_model, deck, state_file
from pywet.engines.run_store import FINGERPRINT, RunStore
from pywet.scene import EngineScene, Rotation
from tests.cases.screening import synthetic


def test_lists_see_the_films_of_every_size() -> None:
    """The common film is the widest part of the smallest sphere: radii of 2 and 4 mm."""
    scene = synthetic.scene()
    assert scene.liquid is not None
    film = scene.liquid.initial_film_thickness_m
    grown = deck.FILM_GROWTH * film
    seen = deck.film_factor(scene) - 1.0
    assert seen * 2e-3 == pytest.approx(grown, rel=1e-12)
    assert all(seen * c.radius_m >= grown * (1 - 1e-12) for c in scene.classes)
    assert deck.listed(scene) - deck.skin(scene) == pytest.approx(2.0 * seen * 4e-3, rel=1e-12)


def test_a_deck_says_its_step_often_enough_for_a_progress_bar(tmp_path: Path) -> None:
    """Two hundred times a run, or in every step of a short one."""
    for steps, reported in ((4000, 20), (60, 1)):
        scene = small.prepare(tmp_path, bodies.sphere_classes(1e-3), [small.Sphere(1, (0.0, 0.0, 0.01))],
                              bodies.contacts(1, 1e4), steps=steps)  # fmt: skip
        deck.write_deck(scene, tmp_path, tmp_path)
        assert re.search(r"^thermo +(\d+)$", (tmp_path / "setup.liggghts").read_text(), re.M)[1] == str(reported)  # type: ignore[index]


def test_a_folder_can_be_disowned_twice(tmp_path: Path) -> None:
    """A mark that is missing already is no fault."""
    store = RunStore(tmp_path, "")
    store.partial.mkdir()
    (store.partial / FINGERPRINT).touch()
    for _ in range(2):
        store.disown()
    assert not (store.partial / FINGERPRINT).exists()


@pytest.mark.parametrize(("step", "skin"), [(1e-9, 0.8e-3), (1e-5, 3.6 * (8e-3 * 2e-5) ** 0.5), (1e-3, 2.4e-3)])
def test_skin_is_between_fractions_of_the_smallest_radius(step: float, skin: float) -> None:
    """Radii of 2 and 4 mm: 0.4 to 1.2 times the smallest; between, by the largest diameter and a way at 2 m/s."""
    assert deck.skin(synthetic.scene().model_copy(update={"time_step_s": step})) == pytest.approx(skin, rel=1e-12)


def test_a_turning_wall_has_its_origin_and_axis_in_the_deck() -> None:
    way = Rotation(origin_m=(0.01, 0.02, 0.03), axis=(0.0, 1.0, 0.5), period_s=2.0)
    scene = SimpleNamespace(motions={"drum": way})
    words = deck.movers(scene)[0]["words"]  # type: ignore[arg-type]
    assert words == "rotate origin 0.01 0.02 0.03 axis 0.0 1.0 0.5 period 2.0"


def test_checkpoints_wait_for_the_end_of_a_recorded_window() -> None:
    """One in its first step is moved to its last; one just behind it stays."""
    scene = synthetic.scene()
    scene = scene.model_copy(update={"output": scene.output.model_copy(update={"checkpoints": 3})})
    every = schedule.checkpoint_every(scene)
    windows = [(every, every + 5), (2 * every - 5, 2 * every)]
    assert schedule.checkpoints(scene, windows)[:2] == [every + 4, 2 * every]


def test_retired_spheres_of_a_checkpoint(tmp_path: Path) -> None:
    path = tmp_path / "state.0"
    path.write_bytes(bytes(state_file.HEAD_B) + np.array([0, 2, 7, 9], "<i8").tobytes())
    assert state_file.retired(path).tolist() == [7, 9]


@pytest.mark.parametrize(("periodic", "walls"), [(None, ("pan",)), ("y", ()), (None, ()), ("y", ("pan",))])
def test_only_walls_in_a_periodic_box_may_continue(periodic: str | None, walls: tuple[str, ...]) -> None:
    """Else a dry scene needs no plugin."""
    scene = EngineScene.model_construct(periodic=periodic, walls=walls)  # type: ignore[arg-type]
    assert contact_model.continues(scene) == bool(periodic and walls)
