"""The shipped scenes at small size: each runs, its replay agrees, and what must happen in it does."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

import pywet
from pywet.cases.small.scenes import bed_angles
from reference_impl.tables import check as results
from tests.cases.custom.conftest import example
from tests.reference_impl.injected_files import CUSTOM

pytestmark = pytest.mark.engine


def test_hopper_keeps_all_until_its_gate_is_drawn(tmp_path: Path) -> None:
    """Nothing passes before; then spheres fall into the tray, with g; all liquid is on named walls and spheres."""
    gate = {"at_s": 0.02, "towards": [1, 0, 0], "speed_m_per_s": 2.0}
    scene = example("hopper", {"cylinder": {"diameter_mm": 19, "height_mm": 24, "origin_mm": [0, 0, 0]}, "count": 25})
    walls = [w.model_copy(update={"removed": pywet.Removed(**gate)}) if w.removed else w for w in scene.walls]
    run = pywet.run(pywet.Scene(**{**dict(scene), "walls": walls, "duration_s": 0.1}), tmp_path)
    lowest = run.trajectory.groupby("time")["z"].min()
    assert lowest[lowest.index < 0.02].min() > -0.5e-3
    assert lowest.iloc[-1] < -0.02  # falling to the tray, whose floor is at -35 mm
    names = [f"wall_{name}_m3" for name in ("hopper", "bin", "gate", "tray")]
    total = run.liquid[["spheres_beads_m3", *names]].sum(axis=1)
    assert np.abs(total / total[0] - 1).max() < 1e-12
    assert run.liquid["wall_gate_m3"].iloc[-1] > 0  # the gate carries its film along


def test_drum_lifts_its_bed(tmp_path: Path) -> None:
    """It turns from +z to +x at its top, so that the bed's centre of mass goes to -x; liquid and units are there."""
    run = pywet.run(
        example("drum", {"count": 60, "box": {"low_mm": [-17, 1, -17], "high_mm": [17, 19, 0]}}, duration_s=0.12),
        tmp_path,
    )
    middle = run.trajectory.groupby("step")[["x", "z"]].mean()
    assert middle["x"].iloc[-1] < middle["x"].iloc[0] - 1e-3
    angles = bed_angles(tmp_path)
    assert angles[-1] == pytest.approx(np.degrees(np.arctan2(-middle["x"].iloc[-1], -middle["z"].iloc[-1])), rel=1e-9)
    assert run.replay["ok"]
    assert run.events.attrs["units"]["volume"] == "m3" and run.trajectory.attrs["units"]["vx"] == "m/s"
    assert run.contact_statistics["bridges_per_sphere"].iloc[-1] > 1.0
    assert run.replay["results"]["ok"] and run.replay["scene"]["ok"]
    assert run.replay["quantities"]["scene_parts"]["count"] == 3
    assert run.replay["quantities"]["scene_description"]["count"] > 40
    for name, fault in CUSTOM.items():
        copy = Path(shutil.copytree(tmp_path, tmp_path.parent / name.replace(" ", "_")))
        fault.change(copy)
        found = results.check(copy)
        assert [q.name for q in found.quantities if not q.ok] == [fault.quantity], name
        assert [f for f in found.findings if fault.words in f["sentence"]], (
            name,
            [f["sentence"] for f in found.findings],
        )


def test_migration_wets_the_dry_layer_and_nothing_is_lost(tmp_path: Path) -> None:
    """At first all liquid is on the wet class; then the dry one has some, and what it has the others have lost."""
    low, high = {"low_mm": [-9, -9, 0.5], "high_mm": [9, 9, 14]}, {"low_mm": [-9, -9, 14], "high_mm": [9, 9, 30]}
    scene = example("migration", {"count": 25}, duration_s=0.08)
    layers = [s.model_copy(update={"box": pywet.Box(**box)}) for s, box in zip(scene.spheres, (low, high), strict=True)]
    run = pywet.run(pywet.Scene(**{**dict(scene), "spheres": layers}), tmp_path)
    share = run.liquid[["spheres_dry_m3", "spheres_wet_m3", "wall_vessel_m3"]].div(run.liquid["initial_m3"], axis=0)
    assert share.iloc[0].tolist() == [0.0, 1.0, 0.0]
    assert share["spheres_dry_m3"].iloc[-1] > 1e-3
    assert np.abs(share.sum(axis=1) - 1).max() < 1e-12


def test_repose_leaves_a_heap_when_its_tube_is_lifted(tmp_path: Path) -> None:
    """The tube rises by the given distance and lifts no sphere; the beads spread."""
    scene = example("repose", {"count": 40, "cylinder": {"diameter_mm": 24, "height_mm": 40, "origin_mm": [0, 0, 0.1]}})
    lifted = pywet.Moves(velocity_m_per_s=(0, 0, 1.0), from_s=0.05, for_s=0.08)
    walls = [w.model_copy(update={"moves": lifted}) if w.moves else w for w in scene.walls]
    run = pywet.run(pywet.Scene(**{**dict(scene), "walls": walls, "duration_s": 0.16}), tmp_path)
    away = np.hypot(run.trajectory["x"], run.trajectory["y"]).groupby(run.trajectory["time"]).max()
    assert away[away.index < 0.05].max() < 0.0125 - 0.0015 + 1e-4
    assert away.iloc[-1] > 0.0112  # while closed it restricts centres to 11 mm
