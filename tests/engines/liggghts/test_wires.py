"""Analytic wires: the engine's own forces on a facet, one contact next to an edge, springs handed on, Newton's law closed."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from pywet.cases.small import small
from pywet.engines.liggghts import deck, driver
from pywet.geometry.screen import build_wires
from pywet.geometry.solids import wire
from pywet.geometry.surface import Surface, make_surface
from pywet.scene import EngineScene, Output, Vibration
from reference_impl.replay.replay import replay
from tests.engines.liggghts import beds
from tests.engines.liggghts.scenes import WATER, contacts, spheres_of
from tests.engines.liggghts.test_restart import killed, same_bits
from tests.error_codes import raises_code

pytestmark = pytest.mark.engine
RADIUS, STEP, OVERLAP = 2.5e-3, 1e-5, 2e-5
WET: dict[str, Any] = {"effects": small.PAPER, "liquid": WATER}
SHAKEN = Vibration(amplitude_m=(5e-5, 0.0, 2e-5), phase_rad=(0.5, 0.0, 0.3), frequency_Hz=50.0)


def one_wire(sides: int, motion: str = "fixed", radius: float = 2e-3) -> Surface:
    """A wire along x in a dozen steps, a part of its own."""
    corners = wire(np.array([-0.03, 0.0, 0.0]), np.array([0.03, 0.0, 0.0]), radius, sides, 1.1, 10)
    return make_surface("wires", "wires", [(corners, radius)], motion)  # type: ignore[arg-type]


def on_facet(sides: int, radius: float, along: float, share: float) -> tuple[float, float, float]:
    """Centre of a sphere pressed into the facet next to the top of `one_wire`, `share` of its width from the left edge."""
    angle = 2.0 * np.pi * (np.arange(sides // 4, sides // 4 + 2)) / sides
    corner = radius * np.column_stack([-np.cos(angle), np.sin(angle)]).astype(np.float32).astype(float)
    edge = corner[1] - corner[0]
    normal = np.array([-edge[1], edge[0]]) / np.hypot(*edge)
    at = corner[0] + share * edge + (RADIUS - OVERLAP) * normal * np.sign(normal[1])
    return along, float(at[0]), float(at[1])


def run(
    folder: Path, spheres: list[small.Sphere], wires: Surface, analytic_wires: bool, steps: int, **more: Any
) -> EngineScene:
    """A run with every step recorded."""
    fields = {"effects": small.DRY, "steps": steps, "time_step_s": STEP, "window_trajectories": True, "vibration": SHAKEN,
              "output_interval_s": steps * STEP}  # fmt: skip
    pairs = more.pop("pairs", [p.model_copy(update={"rolling_friction_m": 1e-4}) for p in contacts(1, stiffness=2e4)])
    scene = small.prepare(
        folder,
        spheres_of(RADIUS),
        spheres,
        pairs,
        walls=[wires],
        analytic_wires=["wires"] if analytic_wires else [],
        **{**fields, **more},
    )
    small.run(folder, spheres)
    return scene


def states(folder: Path) -> pd.DataFrame:
    """Return the recorded states by step and sphere."""
    return pd.read_parquet(folder / "history/window_states.parquet").set_index(["step", "id"])


FORCES, TORQUES = ["fx", "fy", "fz"], ["tx", "ty", "tz"]


@pytest.mark.parametrize("history", [True, False])
def test_forces_on_a_facet_are_the_engines(tmp_path: Path, history: bool) -> None:
    """Spheres that slide, spin and sink on a facet of a vibrating wire: forces and torques of every step to 1e-12 of k r.

    Springs, friction, rolling resistance and the wall's velocity are the same; the overlap is a difference of lengths near r,
    so that its rounding is relative to r.
    """
    spheres = [
        small.Sphere(1, on_facet(6, 2e-3, x, 0.45 + 0.05 * k), (0.3, 0.0, -0.02), (40.0, -200.0 * k, 30.0), driven=True)
        for k, x in enumerate((-0.02, 0.0, 0.02))
    ]
    effects = small.DRY.model_copy(update={"tangential_history": history})
    for name in ("mesh", "analytic"):
        run(tmp_path / name, spheres, one_wire(6, "vibrates"), name == "analytic", 200, effects=effects)
    mesh, analytic_wire = states(tmp_path / "mesh"), states(tmp_path / "analytic")
    scale = 2e4 * RADIUS
    assert mesh[FORCES].abs().max().max() > 1e-2 * scale
    assert (mesh[FORCES] - analytic_wire[FORCES]).abs().max().max() < 1e-12 * scale
    assert (mesh[TORQUES] - analytic_wire[TORQUES]).abs().max().max() < 1e-12 * scale * RADIUS


def test_same_path_on_a_facet(tmp_path: Path) -> None:
    """Spheres that drop on a shaken facet, bounce, slide and roll along it over many triangles: positions to 1e-9 of a radius.

    With bridges that never form, so that the works are added up: those of the contacts and of the moving wall are the same too.
    """
    spheres = [
        small.Sphere(1, (x, y, on_facet(6, 2e-3, x, 0.5)[2] + 3e-4), (0.1, 0.0, 0.0), (0.0, -20.0 * k, 5.0))
        for k, (x, y) in enumerate(((-0.025, 1e-4), (-0.015, -1e-4), (-0.005, 0.0)))
    ]
    output = Output(interval_s=200 * STEP, contact_windows=2, contact_window_steps=400, window_trajectories=True)
    pairs = contacts(1, 0.3, stiffness=2e4)
    still = {**WET, "liquid": WATER.model_copy(update={"initial_film_thickness_m": 0.0})}
    for name in ("mesh", "analytic"):
        run(
            tmp_path / name,
            spheres,
            one_wire(6, "vibrates"),
            name == "analytic",
            6000,
            gravity=(0.0, 0.0, -9.81),
            output=output,
            pairs=pairs,
            **still,
        )
    springs = pd.read_parquet(tmp_path / "mesh/history/window_wall_springs.parquet")
    assert len(springs) > 20 and len(springs["triangle"].unique()) > 3
    assert beds.apart(tmp_path / "mesh", tmp_path / "analytic").max() < 1e-9 * RADIUS
    works = [beds.table(tmp_path / name, "history/energy")[["contact", "wall_motion"]] for name in ("mesh", "analytic")]
    assert works[0].abs().min().min() == 0.0 and works[0].iloc[-1].abs().min() > 1e-9
    assert (works[0] - works[1]).abs().max().max() < 1e-9 * works[0].abs().min(axis=1).iloc[-1]


def test_one_contact_beside_an_edge(tmp_path: Path) -> None:
    """Sinking next to an edge of the facet, the mesh's normal force rises to nearly 2 k d; the analytic wire's is k d."""
    sphere = small.Sphere(1, on_facet(6, 2e-3, 0.0, 0.02), (0.0, 0.0, -0.1), driven=True)
    ratio = {}
    for name in ("mesh", "analytic"):
        pairs = contacts(1, stiffness=2e4, restitution=1.0, friction=0.0)
        run(tmp_path / name, [sphere], one_wire(6), name == "analytic", 100, pairs=pairs)
        at = states(tmp_path / name).xs(1, level="id")
        top = np.float32(2e-3 * np.sin(np.pi / 3))
        ratio[name] = (at["fz"] / (2e4 * (RADIUS - (at["z"] - top)))).to_numpy()
    assert np.abs(ratio["analytic"] - 1.0).max() < 1e-10  # for an overlap of a hundredth of the radius
    assert ratio["mesh"].max() > 1.9


def screen() -> Surface:
    """A vibrating screen of crossing wires, seven apertures wide."""
    half = 0.02
    outline = half * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return build_wires(4e-3, 2e-3, 8, half, outline)


def on_screen(count: int = 32, seed: int = 3) -> list[small.Sphere]:
    """Spheres thrown onto `screen`, too large to pass."""
    random = np.random.default_rng(seed)
    cells = [(x, y, z) for z in range(2) for x in range(-2, 2) for y in range(-2, 2)][:count]
    at = [(5.3e-3 * x, 5.3e-3 * y, 3.3e-3 + 5.3e-3 * z) for x, y, z in cells]
    return [
        small.Sphere(
            1, tuple(p + random.uniform(-1e-4, 1e-4, 3)), tuple(random.normal(0.0, 0.05, 3)), (30.0, 0.0, 10.0)
        )
        for p in at
    ]


def bed(folder: Path, steps: int = 8000, ranks: int = 1, **more: Any) -> EngineScene:
    """A bed on a shaken screen of analytic wires, two windows recorded."""
    spheres = on_screen()
    shaken = Vibration(amplitude_m=(1e-4, 0.0, 1e-4), phase_rad=(0.5, 0.0, 0.3), frequency_Hz=50.0)
    output = Output(interval_s=steps // 4 * STEP, contact_windows=2, contact_window_steps=100, window_trajectories=True)
    fields = {"steps": steps, "time_step_s": STEP, "gravity": (0.0, 0.0, -9.81), "vibration": shaken, "output": output}
    scene = small.prepare(
        folder, spheres_of(RADIUS), spheres,
        [p.model_copy(update={"rolling_friction_m": 1e-4}) for p in contacts(1, 0.4, stiffness=2e4)],
        walls=[screen(), small.floor(0.05, -0.02)], analytic_wires=["wires"], **{**fields, **more},
    )  # fmt: skip
    small.run(folder, spheres, ranks)
    return scene


@pytest.mark.parametrize("moist", [False, True])
def test_newtons_law_closes(tmp_path: Path, moist: bool) -> None:
    """The replay finds the closest points from the triangles and closes Newton's law; a sphere has one contact with a wire."""
    bed(tmp_path, **(WET if moist else {}))
    result = replay(tmp_path)
    assert result["ok"], result["notes"]
    springs = pd.read_parquet(tmp_path / "history/window_wall_springs.parquet")
    assert (springs["mesh"] == 0).sum() > 500
    assert result["newton"]["beside_an_edge"] == 0
    assert result["quantities"]["newton_force"]["largest"] < 1e-9


@pytest.fixture(scope="module")
def unbroken(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The dry bed on one rank, in one piece."""
    run_dir = tmp_path_factory.mktemp("unbroken")
    bed(run_dir)
    return run_dir


def same(one: Path, two: Path) -> None:
    """Trajectories equal to 1e-9 of a radius; a spring lost once shifts a sphere by some 1e-6 of it.

    Spheres come in another order, so sums differ in the last digit, which 80 ms of collisions amplify.
    """
    assert beds.apart(one, two).max() < 1e-9 * RADIUS
    springs = [pd.read_parquet(p / "history/window_wall_springs.parquet") for p in (one, two)]
    keys = [s[["step", "mesh", "triangle", "i"]].sort_values(["step", "i", "triangle"]).to_numpy() for s in springs]
    assert np.array_equal(*keys)


def test_springs_are_handed_on_at_new_lists(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A quarter of the skin: candidates are found again many times as often. Moist, since a dry run's springs between spheres
    outlive their contact until the next list.
    """
    bed(tmp_path / "far", 4000, **WET)
    monkeypatch.setattr(deck, "skin", lambda scene: 0.1 * RADIUS)
    bed(tmp_path / "near", 4000, **WET)
    same(tmp_path / "far", tmp_path / "near")


def test_ranks(unbroken: Path, tmp_path: Path) -> None:
    """Spheres that cross the boundary between two ranks take their springs along."""
    bed(tmp_path, ranks=2)
    same(unbroken, tmp_path)


def test_killed_and_resumed(tmp_path: Path) -> None:
    """A dry run with analytic wires resumes from its springs and forces as a moist one does."""
    output = Output(
        interval_s=200 * STEP, contact_windows=2, contact_window_steps=100, checkpoints=79, window_trajectories=True
    )
    bed(tmp_path / "whole", output=output)
    shutil.copytree(
        tmp_path / "whole", tmp_path / "killed", ignore=shutil.ignore_patterns("engine", "trajectory.parquet")
    )
    killed(tmp_path / "killed", after=3000)  # the bed lies on the screen
    info = driver.run(tmp_path / "killed", progress=False)
    assert info.resumed_at_step is not None and 3000 <= info.resumed_at_step < 8000
    same_bits(tmp_path / "whole", tmp_path / "killed")


def test_a_centre_inside_a_wire_stops_the_run(tmp_path: Path) -> None:
    sphere = small.Sphere(1, (0.0, 0.0, 0.5e-3))
    with raises_code("engine.stopped", spheres=(1,), says="inside a wire"):
        run(tmp_path, [sphere], one_wire(8), True, 10)


def test_what_is_no_analytic_wire_is_refused(tmp_path: Path) -> None:
    sphere = small.Sphere(1, (0.0, 0.0, 3e-3))
    with raises_code("surface.not_prism"):
        small.prepare(
            tmp_path, spheres_of(RADIUS), [sphere], contacts(1), walls=[small.floor()], analytic_wires=["floor"]
        )
        small.run(tmp_path, [sphere])
