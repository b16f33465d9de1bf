"""Quantities of interest of the scenes: numbers from a finished run, and the definition of a change of each."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from pywet.cases.small.bodies import coordination, last
from pywet.cases.small.scenes import bed_angles
from pywet.runs.rundir import RunDir
from pywet.util.files import read_table

ABSOLUTE = {
    "liquid_in_bridges": "liquid in bridges, of all liquid",
    "liquid_on_walls": "liquid on walls, of all liquid",
    "liquid_on_small": "liquid as film on the small spheres, of all liquid",
    "fraction_retained": "fraction retained, by mass",
}
"""Quantities that are shares of a whole: an error is the difference itself."""
RELATIVE = {
    "mean_height": "mean height of the spheres",
    "contacts_per_sphere": "spheres in touch with a sphere",
    "bridges_per_sphere": "bridges per sphere",
    "dynamic_angle": "angle of the turning bed",
    "kinetic_energy_left": "kinetic energy left, of that at the start",
    "scattered_speed": "mean speed across the jets",
    "rebound_speed": "speed of rebound along the line of impact",
    "sideways_speed": "speed of rebound across it",
    "spin": "spin after the impact",
    "half_way_time": "time until half of the undersize has passed",
}
"""Quantities whose error is relative to the run with everything on."""
WORDS = {**ABSOLUTE, **RELATIVE}
TOUCH = 0.02
"""Gap over the mean radius up to which two spheres count as touching."""


def liquid(run_dir: Path, names: Iterable[str]) -> dict[str, float]:
    """Return the distribution of the liquid at the end; all of it is on the spheres if nothing moves it."""
    scene = RunDir(run_dir).scene
    spheres = read_table(run_dir / "history" / "spheres.parquet")
    shares = {"liquid_in_bridges": 0.0, "liquid_on_walls": 0.0, "bridges_per_sphere": 0.0}
    total = float(spheres["film"].sum())
    small = spheres.loc[spheres["type"] == 1, "id"]
    shares["liquid_on_small"] = float(spheres.loc[spheres["type"] == 1, "film"].sum()) / total if total else 0.0
    if scene.effects.bridges and total:
        ledger = read_table(run_dir / "history" / "ledger.parquet").iloc[-1]
        films = read_table(run_dir / "history" / "films.parquet")
        films = films[films["step"] == films["step"].max()]
        shares["liquid_in_bridges"] = float(ledger["bridges"]) / total
        shares["liquid_on_walls"] = float(ledger["walls"]) / total
        shares["bridges_per_sphere"] = 2.0 * float(ledger["bridge_count"]) / len(spheres)
        shares["liquid_on_small"] = float(films.loc[films["id"].isin(small), "film"].sum()) / total
    return {name: shares[name] for name in names}


def settled(run_dir: Path) -> dict[str, float]:
    """Return mean height and number of touching spheres, over the last three outputs."""
    scene, table = RunDir(run_dir).scene, read_table(run_dir / "trajectory.parquet")
    radius = {c.type: c.radius_m for c in scene.classes}
    heights, touching = [], []
    for step in sorted(table["step"].unique())[-3:]:
        now = table[table["step"] == step]
        r, at = now["type"].map(radius).to_numpy(), now[["x", "y", "z"]].to_numpy()
        heights.append(float(at[:, 2].mean()))
        touching.append(coordination(at, r, TOUCH * r.mean()))
    return {"mean_height": float(np.mean(heights)), "contacts_per_sphere": float(np.mean(touching))}


def cooled(run_dir: Path) -> dict[str, float]:
    """Return the remaining kinetic energy and speed across x of two clouds that flew through each other."""
    table = read_table(run_dir / "trajectory.parquet")
    energy = (table[["vx", "vy", "vz"]] ** 2).sum(axis=1).groupby(table["step"]).sum().to_numpy()
    end = last(run_dir)
    return {
        "kinetic_energy_left": float(energy[-1] / energy[0]),
        "scattered_speed": float(np.hypot(end["vy"], end["vz"]).mean()),
    }


def rebound(run_dir: Path) -> dict[str, float]:
    """Return speeds of two spheres after their impact, relative, along and across the line of impact at touch (x), and spin."""
    end = last(run_dir)
    v = end[["vx", "vy", "vz"]].to_numpy()
    return {
        "rebound_speed": float(abs(v[1, 0] - v[0, 0])),
        "sideways_speed": float(abs(v[1, 1] - v[0, 1])),
        "spin": float(np.abs(end["wz"]).mean()),
    }


def turning(run_dir: Path) -> dict[str, float]:
    """Return the angle of the bed in a drum about z over the second half: that of its centre of mass against gravity [deg]."""
    return {"dynamic_angle": float(bed_angles(run_dir).mean())}


def sieved(run_dir: Path) -> dict[str, float]:
    """Return the fraction retained at the end, and the time until half of the undersize has passed (at most the run's end)."""
    scene, table = RunDir(run_dir).scene, read_table(run_dir / "trajectory.parquet")
    mass = table["type"].map({c.type: c.mass_kg for c in scene.classes})
    under = table["type"].map({c.type: c.passes_aperture for c in scene.classes})
    through = table["z"] < scene.screen_z_m - max(c.radius_m for c in scene.classes)
    total = float(mass[table["step"] == 0].sum())
    passed = (mass * through).groupby(table["time"]).sum()
    half = 0.5 * float((mass * under)[table["step"] == 0].sum())
    reached = passed.index[passed.to_numpy() >= half]
    return {
        "fraction_retained": 1.0 - float(passed.iloc[-1]) / total,
        "half_way_time": float(reached[0]) if len(reached) else scene.duration_s,
    }
