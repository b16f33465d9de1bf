"""The 3-D scenes of a page agree with the logs of a real run; faults injected in what a page holds are found and named."""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pywet.report import browser
from pywet.runs.rundir import RunDir
from reference_impl.shown import scenes

pytestmark = pytest.mark.engine
Head = dict[str, Any]
Arrays = dict[str, np.ndarray[Any, Any]]


@pytest.fixture(scope="module")
def right(heap_dir: Path) -> str:
    return browser.element([(heap_dir.name, RunDir(heap_dir))])


def read(text: str, heap_dir: Path) -> list[str]:
    return scenes.check(text, heap_dir.parent)[1]


def changed(text: str, plant: Callable[[Head, Arrays], None]) -> str:
    """The page with its scene unpacked, changed and packed again."""
    data = scenes.SCENE.findall(text)[0][1]
    head = json.loads(data)
    whole = bytearray(zlib.decompress(base64.b64decode(head["data"])))
    plant(head, {n: np.frombuffer(whole, scenes.KINDS[k], size, at) for n, (k, at, size) in head["arrays"].items()})
    head["data"] = base64.b64encode(zlib.compress(bytes(whole))).decode()
    return text.replace(data, json.dumps(head).replace("<", "\\u003c"))


def test_a_scene_agrees_with_the_logs(right: str, heap_dir: Path) -> None:
    count, wrong = scenes.check(right, heap_dir.parent)
    assert wrong == [] and count > 3000
    assert read(changed(right, lambda head, arrays: None), heap_dir) == []


def _times(head: Head, arrays: Arrays) -> None:
    head["times"] = [1.02 * time for time in head["times"]]


def _next_output(head: Head, arrays: Arrays) -> None:
    place = arrays["place"].reshape(len(head["times"]), -1)
    place[1:-1] = place[2:].copy()


def _scaled(name: str, factor: float) -> Callable[[Head, Arrays], None]:
    def plant(head: Head, arrays: Arrays) -> None:
        arrays[name][:] = (factor * arrays[name]).astype(arrays[name].dtype)

    return plant


def _most(head: Head, arrays: Arrays) -> None:
    head["film_most"] *= 1e3


def _axes(head: Head, arrays: Arrays) -> None:
    place = arrays["place"].reshape(-1, 3)
    place[:] = place[:, [1, 0, 2]].copy()


def _classes(head: Head, arrays: Arrays) -> None:
    arrays["class"][:] = arrays["class"][::-1].copy()


def _ends(head: Head, arrays: Arrays) -> None:
    arrays["from"][:], arrays["to"][:] = arrays["to"].copy(), arrays["from"].copy()


def _partners(head: Head, arrays: Arrays) -> None:
    arrays["j"][:] = np.where(arrays["j"] == scenes.OTHER_WALL, scenes.WIRE, arrays["j"])


def _a_bridge_less(head: Head, arrays: Arrays) -> None:
    head["starts"][-1] -= 1


def _wall(head: Head, arrays: Arrays) -> None:
    for moved in head["meshes"][0]["moved"]:
        moved[11] += 1e-3


def _hidden(head: Head, arrays: Arrays) -> None:
    head["meshes"][0]["hidden"] = True


def _one_gone(head: Head, arrays: Arrays) -> None:
    arrays["there"][-1] = 0


def _curve(head: Head, arrays: Arrays) -> None:
    (curve,) = head["curves"]  # with neither a bin nor outlets that of the liquid alone
    curve["y"] = [1.01 * y for y in curve["y"]]


def _quantities(head: Head, arrays: Arrays) -> None:
    head["curves"][0]["quantity"] = "fraction_retained_spheres"


def _retained(head: Head, arrays: Arrays) -> None:
    flat = [1.0] * len(head["curves"][0]["x"])
    head["curves"].insert(0, {**head["curves"][0], "quantity": "fraction_retained_spheres", "y": flat})


FAULTS: dict[str, tuple[Callable[[Head, Arrays], None], str]] = {
    "times 2 % late": (_times, "times are not those of the outputs"),
    "places of the next time": (_next_output, "places are wrong: those of step"),
    "places with x and y exchanged": (_axes, "places are wrong, of"),
    "films 10 % too thin": (_scaled("film", 0.9), "film is wrong: 0.9 times what it is"),
    "films in mm for m": (_most, "film is wrong: 1000 times what it is"),
    "speeds halved": (_scaled("speed", 0.5), "speed is wrong: 0.5 times what it is"),
    "spheres 1 % too large": (_scaled("radius", 1.01), "radii are wrong"),
    "classes in reverse": (_classes, "size classes are wrong"),
    "bridges 10 % too wide": (_scaled("side", 1.1), "bridges have another volume to be seen"),
    "ends of bridges exchanged": (_ends, "bridges do not end at their bodies"),
    "walls shown as wires": (_partners, "bridges join other bodies"),
    "a bridge missing": (_a_bridge_less, "bridges are shown; expected"),
    "a wall 1 mm too high": (_wall, "walls are not where the log says"),
    "a wall hidden": (_hidden, "are drawn as others are"),
    "a sphere missing": (_one_gone, "spheres are shown that are not there, or not shown"),
    "a curve 1 % high": (_curve, "the curve liquid_in_bridges_percent is wrong"),
    "a curve taken for another": (_quantities, "curves are of"),
    "a fraction retained without a bin": (_retained, "curves are of"),
}
"""Faults of what a page holds for its scene."""


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_found_and_named(right: str, heap_dir: Path, name: str) -> None:
    plant, output_text = FAULTS[name]
    faults = read(changed(right, plant), heap_dir)
    assert any(output_text in fault for fault in faults), faults
