"""The set-up of a further run, here as a wall begins and stops to slide, in which the engine resets the velocities of walls."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet.cases.small import small
from pywet.geometry.solids import plate, square
from pywet.geometry.surface import make_surface
from pywet.scene import Rotation, Slide, Vibration
from tests.engines.liggghts import beds
from tests.engines.liggghts.scenes import WATER, contacts, spheres_of
from tests.engines.liggghts.test_wires import OVERLAP, on_facet, one_wire

pytestmark = pytest.mark.engine
R, STEP, STIFFNESS, GRAVITY = 2.5e-3, 1e-5, 2e4, 9.81
BEGINS, STOPS = 500, 550
SYRUP = WATER.model_copy(update={"surface_tension_N_per_m": 1e-5, "viscosity_Pa_s": 0.1})


def states(run_dir: Path, slides: bool) -> pd.DataFrame:
    """Spheres that moving walls drag along x: on an analytic wire, on a plate that turns, and by a bridge to the wire."""
    classes = spheres_of(R)
    top, sunk = on_facet(6, 2e-3, 0.0, 0.5)[2] + OVERLAP, classes[0].mass_kg * GRAVITY / STIFFNESS
    spheres = [
        small.Sphere(1, (-0.015, 0.0, top - sunk), film=0.0),
        small.Sphere(1, (0.0, 0.035, R - sunk), film=0.0),
        small.Sphere(1, (0.015, 0.0, top + 6e-5)),
    ]
    walls = [
        one_wire(6, "vibrates"),
        make_surface("disc", "wall", plate(square(0.01) + np.array([0.0, 0.03]), -2e-3, 0.0), "turns"),
        make_surface("slider", "slide", plate(square(0.005), 0.05, 0.052), "slides" if slides else "fixed"),
    ]
    slide = Slide(velocity_m_per_s=(0.1, 0.0, 0.0), opens_at_s=BEGINS * STEP, travel_s=(STOPS - BEGINS) * STEP)
    small.prepare(
        run_dir, classes, spheres, contacts(1, stiffness=STIFFNESS), liquid=SYRUP, walls=walls, analytic_wires=["wires"],
        effects=small.PAPER.model_copy(update={"tangential_history": False}), steps=600, time_step_s=STEP,
        gravity=(0.0, 0.0, -GRAVITY), slide=slide if slides else None,
        vibration=Vibration(amplitude_m=(2e-5, 0.0, 0.0), phase_rad=(0.0, 0.0, 0.0), frequency_Hz=200.0),
        rotation=Rotation(origin_m=(0.0, 0.03, 0.0), axis=(0.0, 0.0, 1.0), period_s=0.1), window_trajectories=True,
    )  # fmt: skip
    small.run(run_dir, spheres)
    return beds.table(run_dir, "history/window_states").pivot_table(index="step", columns="id", values=["vx", "fx"])


def test_walls_move_on_in_a_set_up(tmp_path: Path) -> None:
    """Half a step of the drag acts after it: that of an uninterrupted run to 5 % of the largest, since it is taken at the
    velocities of the step itself and not of half a step before."""
    whole, divided = (states(tmp_path / str(slides), slides) for slides in (False, True))
    apart = (divided["vx"] - whole["vx"]).diff() * 2.0 * spheres_of(R)[0].mass_kg / STEP
    largest = np.abs(whole["fx"]).max()
    assert (largest > 1e-4).all()  # N
    assert (apart.loc[[BEGINS + 1, STOPS + 1]].abs() < 0.05 * largest).all(axis=None)
