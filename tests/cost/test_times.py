"""How long a run takes: what it asks for against a run and closed forms; the lattices that the machine is measured with."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from pywet import config
from pywet.cases.screening import cases
from pywet.cost import cost, counts, trial
from pywet.cost.counts import Load
from pywet.cost.trial import Costs, Lattice
from pywet.geometry import build_apparatus
from pywet.scene import EngineScene

ROOT = Path(__file__).parents[2]
CONFIG = config.load(ROOT / "config")


def costs_of(spheres: float, times: float = 1.0) -> Costs:
    """Costs of a made-up machine with so many spheres."""
    each = dict.fromkeys([f.name for f in dataclasses.fields(Costs)], 1e-7 * times)
    lists = {"list_stock": 4e-6 * spheres, "list_analytic": 3e-6 * spheres, "list_moist": 5e-6 * spheres}
    starts = {"start_stock": 0.2, "start_analytic": 2.0, "start_moist": 2.5}
    return Costs(**{**each, **lists, **starts, "spheres": spheres, "triangles": spheres, "step": 1e-5 + 1e-7 * spheres,
                    "step_stock": 1e-5 + 3e-7 * spheres})  # fmt: skip


def of_case(case: int) -> tuple[EngineScene, cases.ApparatusSpec, cases.Apparatus]:
    row, size = CONFIG.case(case), CONFIG.scale("full")
    spec = cases.apparatus_spec(CONFIG, row, size)
    apparatus = build_apparatus(spec)
    return cases.assemble(CONFIG, row, size, cases.ingredients(CONFIG, case, "full"), apparatus), spec, apparatus


def test_spheres_leave_the_screen_as_in_a_run() -> None:
    """Case 1 at full scale in the engine: 0.696, 0.511 and 0.330 above the screen 0.6, 1.0 and 1.6 s after the opening.

    Nothing is fitted: within 0.06 of the feed.
    """
    scene, spec, _ = of_case(1)
    time = np.arange(0.005, 20.5, 0.01)
    share = counts.staying(scene, spec, time).sum(axis=1) / sum(c.count for c in scene.classes)
    np.testing.assert_allclose(np.interp([1.1, 1.5, 2.1], time, share), [0.696, 0.511, 0.330], atol=0.06)
    assert share[time < 0.5] == pytest.approx(1.0)
    assert share[-1] == pytest.approx(356 / 4211, abs=0.01)  # spheres too large for an aperture


def test_lists_are_made_as_often_as_in_a_run() -> None:
    """Compare with a run of 301 lists in its first 0.5 s, in which walls alone move, and 3500 from 0.976 to 1.952 s.

    With softer springs it counted 1622 in 0.976 s once nothing passed any more. The fastest sphere does not always fall straight
    to the lowest corner of the bin: within 10 %.
    """
    scene, spec, apparatus = of_case(1)
    time = np.arange(0.0005, 20.5, 0.001)
    rate = counts.list_rate(scene, apparatus, time, counts.staying(scene, spec, time).sum(axis=1))
    assert 1e-3 * rate[time < 0.5].sum() == pytest.approx(301, rel=0.1)
    assert 1e-3 * rate[(time > 0.976) & (time < 1.952)].sum() == pytest.approx(3500, rel=0.1)
    none_left = counts.list_rate(scene, apparatus, time, np.full(len(time), 356.0))
    assert 0.976 * none_left[-1000:].mean() == pytest.approx(1622, rel=0.1)


def test_a_heap_at_rest_has_two_touching_pairs_a_sphere() -> None:
    """Compare with 2.06 and 2.08 pairs per sphere of a run at 0.4 and 0.5 s on the closed slide; 0.01 to 0.02 on the screen.

    A quarter of a contact with floor and walls comes in addition. Falling spheres touch nothing at first.
    """
    scene, spec, _ = of_case(1)
    time = np.array([0.05, 0.4, 0.49, 0.9, 1.1])
    found = counts.touching(scene, time, counts.staying(scene, spec, time).sum(axis=1)) / 4211
    np.testing.assert_allclose(found, [0.0, 2.31, 2.33, 0.015, 0.015], atol=0.1)
    assert 0.0 < found[-1] < 0.03


def test_wires_near_a_sphere_are_as_many_as_in_a_run() -> None:
    """0.23 to 0.33 wires near a sphere on the screen from 0.9 to 1.9 s of that run, where the small ones leave."""
    scene, spec, _ = of_case(1)
    on_screen = np.array([1500.0, 1042.0, 356.0])
    assert on_screen @ counts.near_wires(scene, spec) / on_screen.sum() == pytest.approx(0.28, rel=0.2)


def test_load_of_a_case_is_that_of_its_scene() -> None:
    """Case 2 at smoke scale: 335 spheres and 48,338 steps (summary of its run); five wires each way with six sides."""
    load = counts.load_of(CONFIG, 2, "smoke")
    assert (load.spheres, load.triangles, round(load.steps)) == (335, 240, 48338)
    assert load.evaluations == pytest.approx(load.steps * load.bridges, rel=1e-12)
    assert counts.load_of(CONFIG, 1, "smoke").bridges == 0.0
    assert counts.load_of(CONFIG, 1, "full").triangles == 0.0  # analytic wires


@pytest.mark.parametrize(("spheres", "factor"), [(300.0, 1.0), (30000.0, 3.0), (60000.0 / 101.0, 2.0)])
def test_time_is_the_sum_of_its_parts(spheres: float, factor: float) -> None:
    """Contacts and bridges are three times as dear with many spheres; halfway where 1/n is in the middle."""
    machine = cost.Coefficients(costs_of(300.0), costs_of(30000.0, 3.0))
    step, wires, contacts, bridges = (
        1e-5 + 1e-7 * spheres,
        factor * 1e-7 * 20.0,
        factor * 1e-7 * 600.0,
        factor * 1e-7 * 7e6,
    )
    analytic_wires = Load(
        1e4, 50.0, spheres, near=20.0, touches=600.0, bridges=700.0, evaluations=7e6, analytic_wires=True
    )
    assert machine.loop(analytic_wires) == pytest.approx(
        1e4 * (step + wires + contacts) + bridges + 50 * 5e-6 * spheres
    )
    assert machine.start(analytic_wires) == 2.5
    meshes = dataclasses.replace(analytic_wires, analytic_wires=False, triangles=100.0)
    assert machine.loop(meshes) - machine.loop(analytic_wires) == pytest.approx(
        1e4 * 1e-7 * 100.0 + 50 * 1e-6 * spheres
    )
    dry = dataclasses.replace(meshes, bridges=0.0, evaluations=0.0)
    step += 2e-7 * spheres + 1e-7 * (100.0 - spheres)
    assert machine.loop(dry) == pytest.approx(1e4 * (step + wires + contacts) + 50 * 4e-6 * spheres)
    assert machine.start(dry) == 0.2


def test_lattices_are_what_their_counts_say(tmp_path: Path) -> None:
    """A cubic lattice has three pairs a sphere but for its faces, half of which touch; a list is made in every tenth step."""
    scene, spheres, _ = trial._prepare(
        tmp_path, CONFIG, 50.0, Lattice(1, analytic_wires=False, pressed=True, lists=True)
    )
    pairs = len(cKDTree(spheres[["x", "y", "z"]]).query_pairs(2.0 * 2.5e-3))
    # 335 spheres of 5 mm in a sieve of 50 mm: three layers of ten by ten, and three and a half rows
    bonds = 3 * (2 * 10 * 9) + 2 * 100 + 35 + (3 * 9 + 4) + (2 * 10 + 5)
    assert pairs == pytest.approx(bonds / 2, abs=3 * bonds**0.5 / 2)  # three standard deviations
    found = trial._run(tmp_path, scene, (100,), Lattice(1, analytic_wires=False, pressed=True, lists=True))
    assert (found["builds"], found["steps"], found["spheres"]) == (10, 100, 335)
