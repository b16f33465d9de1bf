"""Source `replayed`: small moist scenes run in LIGGGHTS + pywet and replayed by the reference, and their conserved quantities.

Source `screening`: replay results of the moist screening cases that have been run (results/<scale>/*/replay.json).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.cases.small import scenes, small
from pywet.cases.small.bodies import contacts, last, sphere_classes, water
from pywet.runs.rundir import RunDir
from pywet.runs.shapes import Replay
from pywet.scene import Effects, EngineScene, SphereClass
from pywet.schema import WORKS
from pywet.util.files import read_json, read_table
from reference_impl.replay.replay import replay
from studies.cross_code.model import Cell, Floats, Source, empty, measured, not_run, truth
from studies.cross_code.rows import (
    EASO,
    EXACT,
    LIGGGHTS,
    NO_LOG,
    NO_MIGRATION,
    QUANTITIES,
    REFERENCE,
    REPLAY_REASONS,
    STOCK_MODEL_REASONS,
    WASHINO,
    YADE,
)

R = 2.5e-3
WATER, ROUGH = water(1e-4, density=998.2), {"friction": 0.2}
OTHER_PROGRAMS = {
    EXACT: "a conserved quantity needs no solution: the deviation is what is lost",
    REFERENCE: "the reference does not integrate motion of a bed",
    YADE: "its scene is not run here; the dry impact shows what the program keeps",
    WASHINO: "its scene is not run here",
    EASO: "its scene is not run here",
}


def source(folder: Path) -> Source:
    """Return the cells of the replayed scenes and of the conserved quantities."""
    cells = [*of_engine(folder), *_split(folder / "exact_pair")]
    return Source("replayed", cells, {"bed": _places(folder / "bed")})


def of_engine(folder: Path, engine: str = "liggghts") -> Iterator[Cell]:
    """Yield the results of the same scenes in an engine that has the plugin."""
    for name, replayed in (("pair", _pair), ("wall_pull", _wall), ("bed", _bed)):
        yield from _cells(name, [replayed(folder / name, engine)], f"runs/{name}/", "")
    yield from _cluster(folder / "cluster", engine)
    yield from _energy("energy_bed", folder / "bed", "runs/bed/")


def screening(results: Path) -> Source:
    """Return the cells of the screening cases found under results/<scale>/, by preset."""
    files = sorted(results.glob("*/case*/replay.json"))
    exact = {f: EngineScene.read(f.with_name("scene.json")).effects.capillary == "young_laplace" for f in files}
    cells: list[Cell] = []
    for row, stored in (
        ("screening", [f for f in files if not exact[f]]),
        ("screening_exact", [f for f in files if exact[f]]),
    ):
        if not stored:
            how = "run `snakemake --cores 2` (or `pywet run 2`) first"
            for key in QUANTITIES:
                cells += [not_run(f"{key}_{row}", column, how) for column in (LIGGGHTS, REFERENCE)]
                cells += empty(f"{key}_{row}", {**REPLAY_REASONS, **STOCK_MODEL_REASONS.get(key, {})})
            continue
        replays = [read_json(f, shape=Replay) for f in stored]
        names = [f"{f.parent.parent.name} {f.parent.name}" for f in stored]
        contacts = sum(f.get("contacts", 0) for f in replays)
        runs_read = f"{len(replays)} case{'s' * (len(replays) > 1)}: {', '.join(names)}; {contacts} contacts"
        runs_read += "; exact laws come from tables" if row == "screening_exact" else ""
        cells += _cells(row, replays, f"../{stored[0].parent.parent.name}/report.html", runs_read, names)
    return Source("screening", cells)


def _cells(
    scene: str, replays: list[dict[str, Any]], link: str, runs_read: str, names: list[str] | None = None
) -> Iterator[Cell]:  # fmt: skip
    """Yield one row per quantity; an exact force or rupture law is compared with a sample of exact solutions."""
    for key, (*_, inside) in QUANTITIES.items():
        row = f"{key}_{scene}"
        parts = [
            (q["largest"], q["count"], q["median"], f"{names[n]}: {name}" if names else name, _place(q))
            for n, one in enumerate(replays) for name in inside if (q := one["quantities"].get(name)) and q["count"]
        ]  # fmt: skip
        yield from empty(row, {**REPLAY_REASONS, **STOCK_MODEL_REASONS.get(key, {})})
        if not parts:
            yield from empty(row, dict.fromkeys((LIGGGHTS, REFERENCE), "this does not happen in the scene"))
            continue
        largest, _, median, name, place = max(parts, key=lambda p: p[0])
        count = sum(p[1] for p in parts)
        yield truth(row, REFERENCE, "recomputed from the logs by the papers' equations", count)
        note = f"worst in {name}; {runs_read}" if runs_read else f"worst in {name}"
        yield Cell(row, LIGGGHTS, "measured", float(largest), count, float(median), place, note, link)


def _place(quantity: dict[str, Any]) -> str:
    worst = quantity.get("worst") or {}
    if "i" not in worst:
        return ""
    return f"step {worst.get('step', 0):.0f}, bridge {worst['i']:.0f}-{worst['j']:.0f}"


def _run(
    folder: Path, kinds: Sequence[SphereClass], spheres: Sequence[small.Sphere], engine: str = "liggghts", **given: Any
) -> None:
    """Run two or three wet spheres; `given`: arguments of `small.prepare`."""
    usual = {"effects": small.PAPER, "time_step_s": 2e-5, "steps": 1500}
    springs = contacts(len(kinds), given.pop("stiffness", 1e5), **ROUGH)
    small.prepare(folder, kinds, spheres, springs, liquid=WATER, **{**usual, **given})
    small.run(folder, spheres, engine=engine)


def _pair(folder: Path, engine: str) -> dict[str, Any]:
    """Run two spheres 1 : 2 drawn apart, sideways and spinning, with every step logged."""
    bodies = [
        small.Sphere(1, (0.0, 0.0, 0.0), driven=True),
        small.Sphere(2, (0.0, 0.0, 3.0 * R - 1e-6), (0.015, 0.0, 0.05), (0.0, 5.0, 2.0), driven=True),
    ]
    _run(folder, sphere_classes(R, 2.0 * R), bodies, engine)
    return replay(folder)


def _wall(folder: Path, engine: str) -> dict[str, Any]:
    """Run a sphere drawn from a plate, sideways and spinning."""
    bodies = [small.Sphere(1, (0.0, 0.0, R), (0.015, 0.0, 0.05), (0.0, 5.0, 2.0), driven=True)]
    _run(folder, sphere_classes(R), bodies, engine, walls=[small.floor()], wall_angle_rad=math.radians(45.0))
    return replay(folder)


def _bed(folder: Path, engine: str) -> dict[str, Any]:
    """Run forty moist spheres that come to rest in a box."""
    scenes.run("bed", folder, scenes.Choice(spheres=40, seconds=0.12, engine=engine))
    return replay(folder)


def _cluster(folder: Path, engine: str) -> Iterator[Cell]:
    """Yield momentum, angular momentum and energy of three free wet spheres that collide; again without tangential drag."""
    kinds, link = sphere_classes(R, 2e-3), "runs/cluster/"
    plain = folder.with_name("cluster_no_tangential")
    _collide_cluster(folder, kinds, small.PAPER, engine)
    _collide_cluster(plain, kinds, small.PAPER.model_copy(update={"viscous_tangential": None}), engine)
    note = "largest change over the run; formations, ruptures and impacts happen in it"
    arm = f"{note}; the tangential drag acts at each sphere's radius as lever arm, which leaves out the gap"
    yield from _stored("momentum_wet", folder, kinds, 0, note, link)
    yield from _stored("spin_wet", folder, kinds, 1, arm, link)
    yield from _stored("spin_plain", plain, kinds, 1, note, "runs/cluster_no_tangential/")
    yield from _energy("energy_wet", folder, link)


def _collide_cluster(folder: Path, kinds: Sequence[SphereClass], effects: Effects, engine: str) -> None:
    bodies = [
        small.Sphere(1, (0.0, 0.0, 0.0), (0.1, 0.0, 0.02)),
        small.Sphere(2, (0.0051, 0.0, 0.0), (-0.1, 0.03, 0.0), (30.0, 0.0, 10.0)),
        small.Sphere(1, (0.0, 0.0051, 0.001), (0.0, -0.1, 0.0)),
    ]
    shorter = {"time_step_s": 1e-5, "steps": 3000, "output_interval_s": 1e-3}
    _run(folder, kinds, bodies, engine, stiffness=1e4, effects=effects, **shorter)


def _stored(row: str, folder: Path, kinds: Sequence[SphereClass], which: int, note: str, link: str) -> Iterator[Cell]:
    """Yield linear (0) or angular (1) momentum over a run."""
    table = read_table(folder / "trajectory.parquet")
    *both, sizes = momenta(table, kinds)
    lost = np.linalg.norm(both[which] - both[which][0], axis=1)
    times = [f"t = {1e3 * t:.0f} ms" for t in np.unique(table["time"])]
    yield measured(row, LIGGGHTS, lost, 0.0 * lost, np.full(len(lost), sizes[which]), at=times, note=note, link=link)
    yield from empty(row, OTHER_PROGRAMS)


def momenta(table: pd.DataFrame, kinds: Sequence[SphereClass]) -> tuple[Floats, Floats, tuple[float, float]]:
    """Return linear and angular momentum at each output, and the sums of their parts' magnitudes at the start."""
    table = table.sort_values(["step", "id"])
    n = table["id"].nunique()
    mass = table["type"].map({c.type: c.mass_kg for c in kinds}).to_numpy(float)[:, None]
    inertia = 0.4 * mass * table["type"].map({c.type: c.radius_m for c in kinds}).to_numpy(float)[:, None] ** 2
    x, v, w = (table[[f"{q}{axis}" for axis in "xyz"]].to_numpy(float) for q in ("", "v", "w"))
    linear, orbit, spin = mass * v, np.cross(x, mass * v), inertia * w
    sums = [part.reshape(-1, n, 3).sum(axis=1) for part in (linear, orbit + spin)]
    sizes = [float(np.linalg.norm(part[:n], axis=1).sum()) for part in (linear, orbit, spin)]
    return sums[0], sums[1], (sizes[0], sizes[1] + sizes[2])


def _energy(row: str, folder: Path, link: str) -> Iterator[Cell]:
    """Yield the energy budget at every output: an identity of the integrator, including half kicks at both ends."""
    energy = read_table(folder / "history" / "energy.parquet")
    moving = energy["kinetic"] + energy["spin"]
    works = energy[WORKS]
    left = (moving - moving.iloc[0] - works.sum(axis=1) - energy["half_kick"]).to_numpy(float)
    turnover = np.full(len(left), float(works.abs().sum(axis=1).max()))
    times = [f"t = {1e3 * t:.0f} ms" for t in energy["time"]]
    yield measured(row, LIGGGHTS, left, 0.0 * left, turnover, at=times, note="logged works of seven effects", link=link)
    yield from empty(row, OTHER_PROGRAMS)


def _split(folder: Path) -> Iterator[Cell]:
    """Yield the exact split at rupture: nodes of the engine's table compared with both solvers of the exact bridge."""
    row = "split_exact_unequal"
    bodies = [small.Sphere(1, (0.0, 0.0, 0.0), driven=True), small.Sphere(2, (0.0, 0.0, 3.0 * R), driven=True)]
    _run(folder, sphere_classes(R, 2.0 * R), bodies, effects=small.EXACT, steps=10)
    nodes = read_table(folder / "history" / "transfer.parquet")
    nodes = nodes[(nodes["type_i"] == 1) & (nodes["type_j"] == 2) & (nodes["v_star"] > 1e-4)].iloc[::12]
    from pywet.laws import exact_bridge as young_laplace
    from reference_impl.bridge import bridge

    v = nodes["v_star"].to_numpy(float) * (4.0 / 3.0 * R) ** 3
    angle = math.radians(15.0)
    solved = np.array([young_laplace.rupture(float(x), R, 2.0 * R, angle, angle).transfer_ratio for x in v])
    other = np.array([bridge.rupture(float(x), R, 2.0 * R, angle, angle).bridge.share_i for x in v])
    names = [f"V* {x:.1e}" for x in nodes["v_star"]]
    yield truth(row, EXACT, "exact profile at its limit, split at the neck", len(v))
    one = np.ones(len(v))
    yield measured(row, REFERENCE, other, solved, one, at=names, note="collocation, shares no code")
    table = nodes["transfer_i"].to_numpy(float)
    yield measured(
        row, LIGGGHTS, table, solved, one, at=names, note="table written by the run", link="runs/exact_pair/"
    )
    yield from empty(row, {YADE: NO_MIGRATION, WASHINO: NO_LOG, EASO: NO_LOG})


def _places(folder: Path) -> dict[str, Any]:
    """Return the spheres of the settled bed for the picture."""
    table = last(folder)
    radius = RunDir(folder).scene.classes[0].radius_m
    return {"radius": radius, "at": table[["x", "y", "z"]].to_numpy(float).tolist()}
