"""A run directory made by hand: three spheres, three walls, numbers small enough to add up on paper.

Sphere 1 (coarse, 4 mm) stays on the screen; sphere 2 (fine, 2 mm) is in the bin from the second output; sphere 3 (fine) from
the third. Liquid in units of 1e-9 m³: 10, 5 and 5 at the start. At output 2 a bridge of 2 (share of sphere 1: 1.5) joins 1
and 3, a bridge of 1 (share of sphere 1: 0.25) joins 1 and the wire, and 0.5 lies on the collecting bin.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from pywet import run_folder
from pywet.cases.small import bodies
from pywet.runs.tables import to_frame
from pywet.scene import Effects, EngineScene, Output, Slide, WallMesh
from pywet.schema import RAW, SMALL_WALL, TABLES
from pywet.util.files import write_json, write_table

UNIT = 1e-9
STEPS = (0, 100, 200)
TIME_STEP = 1e-4
RADII = {1: 4e-3, 2: 2e-3}
Z = {0: (0.01, 0.01, 0.02), 100: (0.006, -0.05, 0.02), 200: (0.006, -0.05, -0.05)}
MESHES = (("wires", 0.0), ("side_wall", 0.0), ("collecting_bin", -0.06))
"""Mesh (also its reservoir) and height of its two triangles."""


def scene(moist: bool = True, name: str = "case02", bridges: bool = True) -> EngineScene:
    """The scene of the synthetic run."""
    coarse, fine = bodies.sphere_classes(
        *RADII.values(), counts=(1, 2), density=1400, angle_rad=1.2, name="POM {mm} mm"
    )
    walls = tuple(
        WallMesh(
            name=mesh,
            reservoir=mesh,
            stl=Path(f"stl/{mesh}.stl"),
            contact_angle_rad=1.3,
            motion="fixed" if mesh == "collecting_bin" else "vibrates",
            triangle_part=(0, 0),
            part_half_width_m=(1e-3 if mesh == "wires" else None,),
        )
        for mesh, _ in MESHES
    )
    liquid = bodies.water(5e-5, tension=0.072)
    effects = Effects(
        bridges=True, capillary="rabinovich", rupture="willett_unequal", formation="shi_mccarthy", transfer="parabola"
    )
    return EngineScene(
        name=name,
        seed=10007,
        classes=(coarse.model_copy(update={"passes_aperture": False}), fine),
        pairs=bodies.contacts(2, 1e4, friction=0.3, rolling_m=5e-5),
        liquid=liquid if moist else None,
        walls=walls,
        vibration=None,
        slide=Slide(velocity_m_per_s=(0.5, 0, 0), opens_at_s=0.005, travel_s=0.1),
        effects=effects if moist and bridges else Effects(bridges=False),
        box_low_m=(-0.02, -0.02, -0.07),
        box_high_m=(0.02, 0.02, 0.05),
        spheres_file=Path("spheres.parquet"),
        time_step_s=TIME_STEP,
        duration_s=0.02,
        output=Output(interval_s=0.01),
        bin_z_m=-0.04,
    )


def make(run_dir: Path, moist: bool = True, name: str = "case02", bridges: bool = True) -> Path:
    """Write the synthetic run directory and return it; without `bridges` a moist one keeps its films as they were."""
    run_folder.claim(run_dir)
    write_json(run_dir / "scene.json", scene(moist, name, bridges).model_dump(mode="json"))
    films = (10.0, 5.0, 5.0) if moist else (0.0, 0.0, 0.0)
    spheres = pd.DataFrame(
        {"id": [1, 2, 3], "type": [1, 2, 2], "radius": [RADII[t] for t in (1, 2, 2)], "film": [f * UNIT for f in films]}
    )
    write_table(spheres, run_dir / "history" / "spheres.parquet")
    write_table(_trajectory(), run_dir / "trajectory.parquet")
    write_table(_triangles(), run_dir / "history" / "triangles.parquet")
    parts = pd.DataFrame({"part": range(len(MESHES)), "mesh": [mesh for mesh, _ in MESHES]})
    write_table(parts, run_dir / "history" / "parts.parquet")
    motion = [  # a dry run is replayed, and nothing vibrates in the scene
        (step, mesh, 0.0, 0.0, 1e-3 * (k if moist and mesh != "collecting_bin" else 0))
        for k, step in enumerate(STEPS)
        for mesh, _ in MESHES
    ]
    write_table(pd.DataFrame(motion, columns=["step", "mesh", "dx", "dy", "dz"]), run_dir / "mesh_motion.parquet")
    if moist and bridges:
        _liquid(run_dir / "history")
    run = {
        "wall_s": 2.0,
        "steps": 200,
        "spheres": 3,
        "ranks": 1,
        "engine_version": "3.8.0",
        "plugin_hash": "abc" if moist and bridges else None,
        "ledger_error": 1e-16 if moist and bridges else None,
    }
    write_json(run_dir / "engine" / "run.json", run)
    return run_dir


def _trajectory() -> pd.DataFrame:
    rows = [
        (step, step * TIME_STEP, i + 1, (1, 2, 2)[i], 0.006 * (i - 1), 0.0, Z[step][i], 0.1, 0, 0, 0, 0, 0)
        for step in STEPS
        for i in range(3)
    ]
    return pd.DataFrame(rows, columns=[*TABLES["trajectory"]])


def _triangles() -> pd.DataFrame:
    rows = []
    for m, (mesh, z) in enumerate(MESHES):
        a, b, c, d = (-0.02, -0.02, z), (0.02, -0.02, z), (0.02, 0.02, z), (-0.02, 0.02, z)
        for k, (u, v, w) in enumerate(((a, b, c), (a, c, d))):
            rows.append((2 * m + k, m, mesh, mesh, 8e-4, *u, *v, *w))
    return pd.DataFrame(rows, columns=[*TABLES["history/triangles"]])


def _liquid(history: Path) -> None:
    films = {0: (10, 5, 5), 100: (10, 5, 5), 200: (7.5, 5, 4)}
    rows = [(step, i + 1, films[step][i] * UNIT) for step in STEPS for i in range(3)]
    write_table(pd.DataFrame(rows, columns=["step", "id", "film"]), history / "films.parquet")
    still = [(step, i + 1, 0.0, 0.0, 0.0) for step in STEPS for i in range(3)]
    write_table(pd.DataFrame(still, columns=[*TABLES["history/impulses"]]), history / "impulses.parquet")
    bridges = [
        (200, 0, 1, 3, -1, 2 * UNIT, 1.5 * UNIT, 1e-4, -0.006, 0.0, 0.006, 0.006, 0.0, -0.05, 0, 0, 1e-4, 1e-4),
        (200, 2, 1, 0, 1, 1 * UNIT, 0.25 * UNIT, 1e-4, -0.006, 0.0, 0.006, -0.006, 0.0, 0.002, 0, 0, 1e-4, 1e-4),
    ]
    write_table(pd.DataFrame(bridges, columns=[*TABLES["history/bridges"]]), history / "bridges.parquet")
    write_table(
        pd.DataFrame([(200, 4, 0.5 * UNIT)], columns=["step", "triangle", "film"]), history / "wall_films.parquet"
    )
    # four formations and two ruptures after the last window of contacts; only their numbers are used
    events = np.zeros(6, dtype=RAW["events"])
    events["step"], events["kind"] = range(161, 167), (0, 0, 0, 0, 1, 1)
    events["i"], events["j"] = (1, 1, 1, 2, 1, 2), (2, 3, 0, 3, 2, 3)
    events["partner_kind"][2] = SMALL_WALL
    write_table(to_frame(events), history / "events.parquet")
    write_table(to_frame(np.zeros(0, dtype=RAW["contacts"])), history / "contacts.parquet")
    ledger = pd.DataFrame(
        [
            (0, 0.0, 20, 0, 0, 0, 0, 20, 3, 0, 0, 0),
            (100, 0.01, 20, 0, 0, 0, 0, 20, 3, 0, 0, 0),
            (200, 0.02, 16.5, 3, 0.5, 0, 0, 20, 3, 2, 4, 2),
        ],
        columns=[*TABLES["history/ledger"]],
    )
    ledger[["films", "bridges", "walls", "left", "retired", "initial"]] *= UNIT
    write_table(ledger, history / "ledger.parquet")
    energy = pd.DataFrame(0.0, index=range(len(STEPS)), columns=[*TABLES["history/energy"]])
    energy["step"], energy["time"] = STEPS, [1e-4 * step for step in STEPS]
    energy["kinetic"], energy["gravity"], energy["contact"] = [0.0, 1e-6, 2e-6], [0.0, 2e-6, 5e-6], [0.0, -1e-6, -3e-6]
    write_table(energy, history / "energy.parquet")
