"""Contacts in batches are the engine's own, to the last bit: random pairs and beds, on one rank and on two."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pywet.cases.small import small
from pywet.scene import Contacts, EngineScene
from tests.engines.liggghts import beds
from tests.engines.liggghts.scenes import contacts, spheres_of
from tests.engines.liggghts.test_restart import same_bits
from tests.engines.liggghts.test_wires import one_wire

pytestmark = pytest.mark.engine
R = 2.5e-3
WAYS: tuple[Contacts, Contacts] = ("stock", "batched")
PAIRS = [p.model_copy(update={"rolling_friction_m": 1e-4}) for p in contacts(2, stiffness=2e4)]


def in_batches(run_dir: Path) -> bool:
    """Return whether the run says that it made its contacts in batches."""
    return bool(json.loads((run_dir / "engine" / "held.json").read_text())["contacts_in_batches"])


def random_pairs(count: int) -> list[small.Sphere]:
    """Pairs of two sizes that overlap by up to a tenth of a radius, each with speeds and spins of its own, above the wire."""
    random, spheres = np.random.default_rng(7), []
    for n in range(count):
        at = (np.array(np.unravel_index(n, (7, 7, 7))) - 3.0) * 5.0 * R + [0.0, 0.0, 0.052]
        types = random.integers(1, 3, 2)
        line = random.normal(size=3)
        line *= (
            sum(spheres_of(R, 2e-3)[k - 1].radius_m for k in types) * random.uniform(0.95, 1.0) / np.linalg.norm(line)
        )
        for kind, place in zip(types, (at, at + line), strict=True):
            speed, spin = random.normal(0.0, 0.3, 3), random.normal(0.0, 200.0, 3)
            spheres.append(small.Sphere(int(kind), tuple(place), tuple(speed), tuple(spin)))
    return spheres


def beside_wire(run_dir: Path, spheres: list[small.Sphere], steps: int, way: Contacts, **more: Any) -> EngineScene:
    """Spheres in a dry scene that loads the plugin for its wire, every step of which is recorded."""
    fields = {"effects": small.DRY, "time_step_s": 1e-5, "window_trajectories": True, **more}
    return small.prepare(
        run_dir, spheres_of(R, 2e-3), spheres, PAIRS, walls=[one_wire(8)], analytic_wires=["wires"], steps=steps,
        contacts=way, **fields
    )  # fmt: skip


def test_random_pairs(tmp_path: Path) -> None:
    """343 pairs on 40 steps: those that stick, slide, roll and part have the engine's places, speeds and springs, bit for bit."""
    spheres = random_pairs(343)
    for way in WAYS:
        beside_wire(tmp_path / way, spheres, 40, way)
        small.run(tmp_path / way, spheres)
    assert [in_batches(tmp_path / way) for way in WAYS] == [False, True]
    same_bits(tmp_path / "stock", tmp_path / "batched")
    springs = beds.table(tmp_path / "batched", "history/window_pair_springs")
    first, last = (len(springs[springs["step"] == springs["step"].agg(end)]) for end in ("min", "max"))
    assert first > 300 and last < first  # some pairs have separated


@pytest.mark.parametrize("ranks", [pytest.param(1, marks=pytest.mark.slow), 2])
def test_moist_bed(tmp_path: Path, ranks: int) -> None:
    """More than 500 spheres between moving walls on 1000 steps: every column of every table has the bits of the stock loop.

    Each operation is the engine's, in its order, and no processor's own (no fused multiply and add), so that no tolerance is
    needed. Checkpoints empty the engine twice; springs of pairs that part are forgotten in the same steps.
    """
    spheres = beds.bed((9, 9, 7))
    for way in WAYS:
        scene = beds.prepare(tmp_path / way, spheres, 1000, checkpoints=2)
        quiet = scene.output.model_copy(update={"energy": False})  # energy terms at walls are summed in another order
        written = scene.model_copy(update={"contacts": way, "output": quiet}).model_dump_json()
        (tmp_path / way / "scene.json").write_text(written)
        small.run(tmp_path / way, spheres, ranks)
    assert [in_batches(tmp_path / way) for way in WAYS] == [False, True]
    same_bits(tmp_path / "stock", tmp_path / "batched")
    assert len(beds.table(tmp_path / "batched", "history/window_pair_springs")) > 500


@pytest.mark.parametrize("effect", ["rolling", "tangential_history"])
def test_without_an_effect(tmp_path: Path, effect: str) -> None:
    """Without rolling friction batches serve too; friction without memory is left to the stock loop, and the run says so."""
    spheres, off = beds.bed((4, 4, 4)), small.DRY.model_copy(update={effect: False})
    for way in WAYS:
        beside_wire(tmp_path / way, spheres, 1500, way, effects=off, gravity=(0.0, 0.0, -9.81))
        small.run(tmp_path / way, spheres)
    assert in_batches(tmp_path / "batched") == (effect == "rolling")
    same_bits(tmp_path / "stock", tmp_path / "batched")
    last = beds.table(tmp_path / "batched", "trajectory").query("step == 1500")
    assert (last[["wx", "wy", "wz"]].abs() > 1.0).any(axis=1).sum() >= 10  # of 32 rotate because of friction


def test_a_checkpoint_of_a_dry_run_changes_nothing_but_round_off(tmp_path: Path) -> None:
    """Spheres thrown into each other above a wire: with and without checkpoints their places agree to 1e-9 of a radius.

    A checkpoint empties the engine, which loses the springs that it retained of separated pairs: 7e-3 of a radius.
    """
    random = np.random.default_rng(3)
    spheres = [
        replace(s, velocity=tuple(random.normal(0.0, 0.3, 3) - 10.0 * np.array(s.position)))
        for s in beds.bed((6, 6, 5))
    ]
    for count in (0, 7):
        more = {"gravity": (0.0, 0.0, -9.81), "output_interval_s": 4e-4, "checkpoints": count}
        beside_wire(tmp_path / str(count), spheres, 2400, "batched", **more)
        small.run(tmp_path / str(count), spheres)
    distance = beds.apart(tmp_path / "0", tmp_path / "7")
    assert len(distance) == 61 and distance.max() < 1e-9 * R
