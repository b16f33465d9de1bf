"""Settings of moist scenes in YADE and LAMMPS one by one: the end is that in LIGGGHTS, and the reference replays the run.

Contacts without friction and dashpot are the same in all engines, and so is all else. Each run takes some four seconds of
processor time, most of it the start of Python, the engine and the laws.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from pywet.cases.small import small
from pywet.cases.small.bodies import contacts, last, sphere_classes, water
from pywet.engines.lammps import build
from pywet.laws import capillary
from pywet.scene import SphereClass
from pywet.util.files import read_table
from tests.engines.test_yade_moist import R, agrees

pytestmark = pytest.mark.engine
ENGINES = [
    pytest.param(
        "yade", marks=pytest.mark.skipif(shutil.which("yade") is None, reason="YADE is not installed: make peers")
    ),
    pytest.param(
        "lammps",
        marks=pytest.mark.skipif(not build.libraries()[1].exists(), reason="LAMMPS is not installed: make peers"),
    ),
]
G, STEP, STEPS, SMALL = 9.81, 1e-5, 2500, 2e-3
SPHERES = [
    small.Sphere(1, (0.0, 0.0, R + 2e-5)),
    small.Sphere(2, (0.0051, 0.0, SMALL + 5e-4), (-0.1, 0.03, 0.0), (30.0, 0.0, 10.0)),
    small.Sphere(1, (0.0, 0.0051, 0.008), (0.0, -0.1, -0.1)),
    small.Sphere(1, (0.02, 0.0, 0.03), driven=True),
]
"""On a wet floor, thrown at each other, and one held above."""


def custom_law(folder: Path) -> dict[str, Any]:
    """A user's file with the equation of the preset."""
    path = folder / "custom.py"
    path.write_text(Path(capillary.__file__).read_text())
    return {"effects": small.PAPER.model_copy(update={"capillary": f"{path}:rabinovich"})}


def dripping(_: Path) -> dict[str, Any]:
    """A film that is a third more than hangs at rest, looked at in every millisecond; bridges act at even steps."""
    return {
        "effects": small.PAPER.model_copy(update={"shedding": "tate"}), "liquid": water(4.5e-4, tension=0.02),
        "bridges_every": 2,
    }  # fmt: skip


def inserted(_: Path) -> dict[str, Any]:
    """The spheres of the second class have weight from the middle of the run on."""
    large, little = sphere_classes(R, SMALL, counts=(3, 1))
    inserted_class = SphereClass.model_validate(
        {**little.model_dump(), "insertion": {"from_s": 0.0, "for_s": STEPS * STEP}}
    )
    return {"classes": (large, inserted_class)}


SETTINGS: dict[str, tuple[Callable[[Path], dict[str, Any]], str]] = {
    "semi-implicit drag": (
        lambda _: {"viscous_integration": "semi_implicit", "liquid": water(1e-4, viscosity=0.02)},
        "factor_normal",
    ),
    "bridges at every fourth step": (lambda _: {"bridges_every": 4}, "contact_weight"),
    "a custom law": (custom_law, "force"),
    "drops": (dripping, "drop_volume"),
    "inserted spheres": (inserted, "ledger"),
}
"""Setting, the fields that it changes, and a quantity in which the replay compares it."""


End = tuple[pd.DataFrame, list[pd.DataFrame]]


def ran(folder: Path, engine: str, changes: dict[str, Any]) -> End:
    """Return the positions of the spheres at the end, the events and the drops."""
    fields: dict[str, Any] = {
        "classes": sphere_classes(R, SMALL), "liquid": water(1e-4), "effects": small.PAPER, **changes,
    }  # fmt: skip
    small.prepare(
        folder, fields.pop("classes"), SPHERES, contacts(2, 1e3, friction=0.0, restitution=1.0), walls=(small.floor(),),
        wall_angle_rad=0.5, gravity=(0.0, 0.0, -G), time_step_s=STEP, steps=STEPS, output_interval_s=1e-3, **fields,
    )  # fmt: skip
    small.run(folder, SPHERES, engine=engine)
    tables = [folder / "history" / f"{name}.parquet" for name in ("events", "drops")]
    return last(folder), [read_table(path)[["step", "i", "j"]] for path in tables if path.exists()]


@pytest.fixture(scope="module")
def in_liggghts(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], End]:
    """The run of a setting in LIGGGHTS, once for all engines."""

    @cache
    def of(setting: str) -> End:
        folder = tmp_path_factory.mktemp("liggghts")
        return ran(folder / "run", "liggghts", SETTINGS[setting][0](folder))

    return of


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("setting", SETTINGS)
def test_it_ends_as_in_liggghts(tmp_path: Path, in_liggghts: Callable[[str], End], setting: str, engine: str) -> None:
    """Places within 1e-6 of a radius after 25 ms with contacts; the same events and drops at the same steps."""
    make, quantity = SETTINGS[setting]
    there, expected = in_liggghts(setting)
    end, events = ran(tmp_path / "run", engine, make(tmp_path))
    assert agrees(tmp_path / "run")["quantities"][quantity]["count"] > 0
    assert len(expected[0]) > 2 and len(expected) == len(events)
    for one, two in zip(events, expected, strict=True):
        pd.testing.assert_frame_equal(one, two)
    assert end[[*"xyz"]].to_numpy() == pytest.approx(there[[*"xyz"]].to_numpy(), abs=1e-6 * R, rel=0.0)
