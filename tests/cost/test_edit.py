"""A configuration with other settings is written so that it loads, equal to the one in memory."""

from __future__ import annotations

import itertools
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import get_args

import pytest

from pywet import config
from pywet.config.loading import of_run
from pywet.config.readings import Readings
from pywet.cost import choice, edit
from pywet.laws import custom_laws
from pywet.util.files import write_json

SHIPPED = Path(__file__).parents[2] / "config"
LAWS = tuple(str(row["level"]) for row in choice.stored()["scales"]["smoke"]["parameters"]["capillary"])
OTHERS: edit.Levels = {
    "fraction": 0.1, "stiffness": 0.03, "wire_sides": 8, "integration": "semi_implicit", "bridges_every": 4,
}  # fmt: skip
LEVELS: tuple[edit.Levels, ...] = ({}, OTHERS, *({**OTHERS, "capillary": law} for law in LAWS))
READINGS = [
    (key, value)
    for key, field in Readings.model_fields.items()
    for value in get_args(field.annotation)
    if value != field.default
]
CUSTOM_LAWS = """
def custom(separation, volume, radius_i, radius_j, contact_angle_i, contact_angle_j, surface_tension):
    return 0.0


def limit(volume, radius_i, radius_j, contact_angle_i, contact_angle_j):
    return volume ** (1.0 / 3.0)
"""
"""Laws that are named here, and never run."""
Change = Callable[[Path], None]


def replaced(name: str, **pairs: str) -> Change:
    """Return a change of one file: `pattern`, a regular expression, by `by`."""

    def change(folder: Path) -> None:
        text, count = re.subn(pairs["pattern"], pairs["by"], (folder / name).read_text(), flags=re.MULTILINE)
        assert count
        (folder / name).write_text(text)

    return change


def laws(text: str, *files: str) -> Change:
    """Return a change of the laws, with the user's files that they name, relative to the folder."""

    def change(folder: Path) -> None:
        replaced("config.yaml", pattern="^laws:\n  preset: paper.*", by=f"laws:\n{text}")(folder)
        for name in files:
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_text(CUSTOM_LAWS)

    return change


def shared_scales(folder: Path) -> None:
    """Make the scales `200` and `again` out of `smoke`, by its alias and by a merge key."""
    path = folder / "scales.yaml"
    text = path.read_text().replace("  smoke:\n", "  smoke: &small\n")
    path.write_text(f"{text.rstrip()}\n  200: *small\n  again:\n    <<: *small\n    wires: analytic\n")


KINDS: dict[str, tuple[str, Change]] = {
    "shipped": ("smoke", lambda folder: None),
    "another shipped scale": ("full", lambda folder: None),
    "exact preset": ("smoke", replaced("config.yaml", pattern="preset: paper", by="preset: exact")),
    **{
        f"{key}: {value}": ("smoke", replaced("config.yaml", pattern=rf"^  {key}: \w+", by=f"  {key}: {value}"))
        for key, value in READINGS
    },
    "custom law": ("smoke", laws("  capillary: custom.py:custom", "custom.py")),
    "custom law below": ("smoke", laws("  {capillary: ./laws/custom.py:custom, rupture: lian}", "laws/custom.py")),
    "custom law outside": (
        "smoke",
        laws("  preset: exact\n  formation: ../laws/custom.py:custom", "../laws/custom.py"),
    ),
    "custom references": (
        "smoke",
        laws(
            "  {capillary: a.py:custom, rupture: a.py:limit, reference: {capillary: a.py:custom, rupture: a.py:limit}}",
            "a.py",
        ),
    ),
    "a scale named by a number": ("200", shared_scales),
    "a scale that others repeat": ("smoke", shared_scales),
    "a scale that repeats another": ("again", shared_scales),
    "groups left out": ("smoke", replaced("config.yaml", pattern=r"^laws:\n.*\n|^readings:.*\n(  .*\n)*", by="")),
}
"""Kind of configuration -> scale that is changed, and how the kind differs from the shipped one."""


def made(kind: str, folder: Path) -> tuple[str, Path]:
    """Make a configuration of a kind; return the scale that is changed and its folder."""
    scale, change = KINDS[kind]
    source = folder / "source" / "config"
    shutil.copytree(SHIPPED, source)
    change(source)
    return scale, source


def parts(of: config.Config) -> tuple[object, ...]:
    """Return everything that a configuration contains, apart from its folder."""
    return of.settings, of.materials, of.scales, of.cases


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_written_loads_and_is_what_was_chosen(kind: str, tmp_path: Path) -> None:
    scale, source = made(kind, tmp_path)
    given = config.load(source)
    for number, levels in enumerate(LEVELS):
        target = tmp_path / "elsewhere" / "deep" / str(number)
        edit.write(source, target, scale, levels)
        got = config.load(target)
        assert parts(got) == parts(edit.changed(given, scale, levels)), levels
        named = got.settings.laws.model_dump(exclude={"reference"}, exclude_none=True).values()
        assert kind == "custom law outside" or all(custom_laws.may_run(n) for n in named if custom_laws.is_custom(n))
    assert parts(config.load(source)) == parts(given)


@pytest.mark.parametrize("kind", KINDS)
def test_only_what_was_chosen_is_changed(kind: str, tmp_path: Path) -> None:
    """Laws other than the capillary one's, their readings, and all else of the scales stay."""
    scale, source = made(kind, tmp_path)
    given = config.load(source)
    got = edit.changed(given, scale, OTHERS)
    assert (got.settings.laws, got.settings.readings) == (given.settings.laws, given.settings.readings)
    assert {name for name in given.scales.scales if got.scale(name) != given.scale(name)} == {scale}
    exact = edit.changed(given, scale, {"capillary": "exact"}).settings
    unchanged = {key for key, _ in READINGS} - {"capillary_spheres", "capillary_walls", "wall_transfer"}
    assert all(getattr(exact.readings, key) == getattr(given.settings.readings, key) for key in unchanged)
    assert exact.laws.formation == given.settings.laws.formation


@pytest.mark.parametrize(("reading", "preset"), [*itertools.product(READINGS, ("paper", "exact"))])
def test_a_run_with_another_preset_stores_a_configuration_that_loads(
    reading: tuple[str, str], preset: str, tmp_path: Path
) -> None:
    """`pywet run --preset exact` stored the readings of the laws that it replaced, and `pywet report` refused them."""
    source = tmp_path / "config"
    shutil.copytree(SHIPPED, source)
    replaced("config.yaml", pattern=rf"^  {reading[0]}: \w+", by=f"  {reading[0]}: {reading[1]}")(source)
    chosen = config.load(source).with_preset(preset)
    write_json(tmp_path / "config.json", chosen.resolved(2, "smoke"))
    settings = of_run(tmp_path)[0].settings
    assert (settings.laws, settings.readings) == (chosen.settings.laws, chosen.settings.readings)
