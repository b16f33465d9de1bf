"""Readings of the paper: the replay knows each by itself, and sees one that was exchanged behind its back."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import get_args

import pandas as pd
import pytest

from pywet import config, stages
from pywet.cases.screening import cases
from pywet.config import Config
from pywet.config.readings import Readings
from reference_impl.replay.replay import replay
from reference_impl.scene import check as scene
from studies.subset import with_spheres
from tests.reference_impl.injected_files import edit, put

CONFIG = config.load(Path(__file__).parents[2] / "config")
SCENES: dict[tuple[str, str], str] = {
    ("capillary_spheres", "as_printed"): "effects.capillary is rabinovich_spheres_as_printed, expected rabinovich",
    ("capillary_walls", "as_printed"): "effects.capillary is rabinovich_walls_as_printed, expected rabinovich",
    ("small_wall", "half_facet"): "walls.wires.part_half_width_m[0] is 0.0005, expected 0.001",
    ("wall_film", "part"): "wall_film is part, expected triangle",
    ("wall_film", "wall"): "wall_film is wall, expected triangle",
    ("wall_transfer", "at_fifth"): "effects.transfer is parabola_walls_at_fifth, expected parabola",
    ("wall_transfer", "at_tenth"): "effects.transfer is parabola_walls_at_tenth, expected parabola",
    ("liquid_amount", "less_residual"): "liquid.initial_film_thickness_m is 6.70466839e-05, expected 7.43253212e-05",
    ("sphere_mass", "weighed"): "classes.small.density_kg_per_m3 is 1428.57477, expected 1358",
    ("amplitude", "peak_to_peak"): "vibration.amplitude_m.z is 0.00045, expected 0.0009",
}
"""Reading -> what the replay says where a scene is built with it and its configuration claims the default."""


ALTERNATIVES = [
    (key, value)
    for key, field in Readings.model_fields.items()
    for value in get_args(field.annotation)
    if value != field.default
]


def read(readings: Mapping[str, str]) -> Config:
    """The shipped configuration with other readings."""
    readings = CONFIG.settings.readings.model_copy(update=dict(readings))
    return replace(CONFIG, settings=CONFIG.settings.model_copy(update={"readings": readings}))


def test_every_alternative_has_its_scene() -> None:
    assert list(SCENES) == ALTERNATIVES


@pytest.mark.parametrize(("key", "value"), SCENES)
def test_scene_of_a_reading_agrees_and_its_exchange_is_named(key: str, value: str, tmp_path: Path) -> None:
    cases.build(read({key: value}), 2, "smoke", tmp_path)
    assert not scene.check(tmp_path).findings
    default = getattr(CONFIG.settings.readings, key)
    put(f"settings.readings.{key}", default, "config.json")(tmp_path)
    output_text = [f["sentence"] for f in scene.check(tmp_path).findings]
    assert any(SCENES[key, value] in sentence for sentence in output_text), output_text


EXCHANGES: dict[tuple[str, str], tuple[str, object, str, str]] = {
    ("capillary_spheres", "as_printed"): (
        "effects.capillary", "rabinovich", "capillary", "the law is rabinovich_spheres_as_printed, not rabinovich",
    ),
    ("small_wall", "half_facet"): (
        "part_half_width_m", 1e-3, "share_i", "half of it counts (formations at wires",
    ),
    ("wall_film", "wall"): ("wall_film", "triangle", "share_j", "a wall's film is spread over the wall"),
    ("wall_transfer", "at_tenth"): (
        "effects.transfer", "parabola", "transfer_table", "the law is parabola_walls_at_tenth, not parabola",
    ),
}  # fmt: skip
"""Reading that a run's log shows -> what its scene claims in place of it, the quantity that disagrees, how it is named."""


def run(readings: dict[str, str], folder: Path, duration_s: float = 0.3) -> Path:
    """Sixteen spheres of case 2 on their way to the screen and off it."""
    built = cases.build(read(readings), 2, "smoke", folder)
    spheres = pd.read_parquet(folder / built.spheres_file)
    few = spheres[spheres.groupby("type").cumcount() < spheres["type"].map({1: 12, 2: 2, 3: 2})]
    with_spheres(built, folder, few, duration_s=duration_s, output=built.output.model_copy(update={"checkpoints": 0}))
    stages.simulate(folder, ranks=1, progress=False)
    return folder


@pytest.fixture(scope="module")
def read_dir(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run with all these readings together."""
    return run(dict(list(EXCHANGES)), tmp_path_factory.mktemp("readings") / "run")


@pytest.mark.engine
def test_run_with_all_readings_agrees(read_dir: Path) -> None:
    result = replay(read_dir)
    assert result["ok"], [n for n, q in result["quantities"].items() if not q["ok"]]


@pytest.mark.engine
@pytest.mark.parametrize("reading", EXCHANGES, ids="-".join)
def test_reading_that_was_exchanged_behind_the_replay_is_named(
    read_dir: Path, tmp_path: Path, reading: tuple[str, str]
) -> None:
    copy, (place, default, quantity, words) = Path(shutil.copytree(read_dir, tmp_path / "run")), EXCHANGES[reading]
    exchange(copy, place, default)
    result = replay(copy)
    output_text = [f["sentence"] for f in result["diagnosis"]["findings"] if quantity in f["quantities"]]
    assert not result["quantities"][quantity]["ok"] and any(words in sentence for sentence in output_text), result[
        "diagnosis"
    ]


@pytest.mark.slow
@pytest.mark.engine
@pytest.mark.parametrize("reading", ALTERNATIVES, ids="-".join)
def test_run_of_each_alternative_agrees(reading: tuple[str, str], tmp_path: Path) -> None:
    result = replay(run(dict([reading]), tmp_path / "run"))
    assert result["ok"], [n for n, q in result["quantities"].items() if not q["ok"]]


def exchange(folder: Path, place: str, default: object) -> None:
    """Have scene and history claim the default: of the half width of wires in all its places, else a value of the scene."""
    if place != "part_half_width_m":
        put(place, default, "scene.json")(folder)
        if place.startswith("effects."):
            put(place, default, "history/meta.json")(folder)
        return
    edit("scene.json", lambda s: s["walls"][0].update({place: [default] * len(s["walls"][0][place])}))(folder)
    parts = pd.read_parquet(folder / "history" / "parts.parquet")
    parts.loc[parts["reservoir"] == "wires", "half_width"] = default
    parts.to_parquet(folder / "history" / "parts.parquet", index=False)
