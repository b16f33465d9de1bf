"""Numbers that the deck takes from a scene, by hand; a folder that is not to be gone on from."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from pywet.cases.small import bodies, small
from pywet.engines.liggghts import checkpoint, deck
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
    """Two hundred times a run, or in every step of a short one, unless asked otherwise."""
    for steps, reported, asked in ((4000, 20, 0), (60, 1, 0), (60, 7, 7)):
        scene = small.prepare(tmp_path, bodies.sphere_classes(1e-3), [small.Sphere(1, (0.0, 0.0, 0.01))],
                              bodies.contacts(1, 1e4), steps=steps)  # fmt: skip
        deck.write_deck(scene, tmp_path, tmp_path, thermo=asked)
        assert re.search(r"^thermo +(\d+)$", (tmp_path / "setup.liggghts").read_text(), re.M)[1] == str(reported)  # type: ignore[index]


def test_a_folder_can_be_disowned_twice(tmp_path: Path) -> None:
    """A mark that is missing already is no fault."""
    (tmp_path / checkpoint.FINGERPRINT).touch()
    for _ in range(2):
        checkpoint.disown(tmp_path)
    assert not (tmp_path / checkpoint.FINGERPRINT).exists()
