"""Writes the raw logs of a long moist run that no engine ran: bridges form and rupture between the spheres of a lattice.

Liquid goes where the papers' equations send it, so that a replay agrees. Scene, walls, laws and classes are those of a small run
given as a template; the numbers of spheres, bridges, events and outputs are those asked for.
"""

from __future__ import annotations

import json
import shutil
from dataclasses import dataclass, replace
from pathlib import Path
from typing import BinaryIO

import numpy as np
import pandas as pd

from pywet import schema
from pywet.runs.tables import RAW, to_frame
from reference_impl.replay import booking, coverage, forces, io, laws, lives, plans, transfer
from reference_impl.replay.bodies import bodies, pairs, shapes
from reference_impl.replay.formations import thickness

STEP_S, DURATION_S, INTERVAL_S = 1.53e-6, 20.5, 0.1
"""Of case 8 at full scale."""
BRIDGES_PER_SPHERE = 2.76
AT_WALLS = 0.1
"""Part of the bridges that are at walls."""


@dataclass
class Places:
    """Pairs that may have a bridge, and which stand."""

    kind: np.ndarray
    i: np.ndarray
    j: np.ndarray
    triangle: np.ndarray
    stands: np.ndarray
    centre: np.ndarray
    """Where each sphere is, by its number."""


def template(source: Path, out: Path, spheres: int) -> io.Run:
    """The start of the long run."""
    history = out / "history"
    history.mkdir(parents=True)
    scene = json.loads((source / "scene.json").read_text())
    scene |= {"time_step_s": STEP_S, "duration_s": DURATION_S}
    scene["output"] |= {"interval_s": INTERVAL_S, "window_trajectories": False, "energy": False}
    (out / "scene.json").write_text(json.dumps(scene))
    meta = json.loads((source / "history" / "meta.json").read_text())
    planned = plans.plan(out)
    (history / "meta.json").write_text(
        json.dumps(meta | {"time_step": STEP_S, "output_steps": planned.outputs.tolist()})
    )
    for name in ("transfer", "triangles", "parts"):
        shutil.copy(source / "history" / f"{name}.parquet", history / f"{name}.parquet")
    few = pd.read_parquet(source / "history" / "spheres.parquet")
    many = few.iloc[np.arange(spheres) % len(few)].reset_index(drop=True).assign(id=np.arange(1, spheres + 1))
    many.to_parquet(history / "spheres.parquet")
    rows = pd.DataFrame([(s, w["name"]) for s in planned.outputs for w in scene["walls"]], columns=["step", "mesh"])
    rows.assign(dx=0.0, dy=0.0, dz=0.0).to_parquet(out / "mesh_motion.parquet")
    tables = {n: pd.read_parquet(history / f"{n}.parquet") for n in ("spheres", "transfer", "triangles", "parts")}
    return io.Run(out, json.loads((history / "meta.json").read_text()), tables)


def places(run: io.Run, random: np.random.Generator) -> Places:
    """Neighbours on a lattice wide enough that no films touch, and some spheres at some triangle."""
    spheres, triangles = run.table("spheres"), run.table("triangles")
    n, radius = len(spheres), spheres["radius"].max()
    side = int(np.ceil(n ** (1 / 3)))
    pitch = 2.02 * (radius + thickness(spheres["film"].to_numpy(), spheres["radius"].to_numpy()).max())
    index = np.arange(n)
    grid = np.stack([index % side, index // side % side, index // side**2], axis=1)
    at = np.concatenate([np.zeros((1, 3)), grid * pitch])
    offsets = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (0, 1, 1)]
    near = [
        np.stack([index, index + np.dot(d, (1, side, side**2))], axis=1)[(grid + d < side).all(axis=1)] for d in offsets
    ]
    both = np.concatenate(near)
    both = both[both[:, 1] < n]
    both = both[random.permutation(len(both))[: int(2 * (1 - AT_WALLS) * BRIDGES_PER_SPHERE * n)]] + 1
    walls = int(2 * AT_WALLS * BRIDGES_PER_SPHERE * n)
    i, of = random.integers(1, n + 1, walls), random.integers(0, len(triangles), walls)
    part = triangles["part"].to_numpy()[of]
    _, once = np.unique(i.astype(np.int64) * 100_000 + part, return_index=True)
    width = run.table("parts")["half_width"].fillna(np.inf).to_numpy()[part[once]]
    kind = np.where(width < spheres["radius"].to_numpy()[i[once] - 1], laws.SMALL_WALL, laws.LARGE_WALL)
    return Places(
        np.concatenate([np.zeros(len(both), int), kind]), np.concatenate([both[:, 0], i[once]]),
        np.concatenate([both[:, 1], part[once]]), np.concatenate([-np.ones(len(both), int), of[once]]),
        np.zeros(len(both) + len(once), dtype=bool), at,
    )  # fmt: skip


def some_events(where: Places, first: int, last: int, count: int, random: np.random.Generator) -> np.ndarray:
    """Events without volumes in steps first to last: half of the pairs that change form a bridge, so far as they stand apart."""
    chosen = random.permutation(len(where.kind))[:count]
    where.stands[chosen] ^= True
    made = np.zeros(len(chosen), schema.RAW["events"])
    made["step"] = random.integers(first, last + 1, len(chosen))
    made["time"] = made["step"] * STEP_S
    made["kind"] = np.where(where.stands[chosen], schema.FORMATION, schema.RUPTURE)
    for field, values in (("partner_kind", where.kind), ("i", where.i), ("j", where.j), ("triangle", where.triangle)):
        made[field] = values[chosen]
    made["speed"] = random.uniform(0.01, 0.3, len(chosen))
    return made[np.lexsort((made["j"], made["i"], made["partner_kind"], made["kind"], made["step"]))]


def booked(run: io.Run, tables: transfer.Tables, made: np.ndarray, alive: lives.Lives, held: np.ndarray) -> None:
    """Give events their volumes, and where liquid goes; films just touch, and each rupture is just beyond its limit."""
    table, fixed, law = to_frame(made), bodies(run), laws.RUPTURE[str(coverage.law(run, "rupture"))]
    p = pairs(table, fixed)
    own, _ = booking.book(table, p, fixed, tables, alive, held, True, np.zeros(0, np.int64))
    for name, values in own._asdict().items():
        made[name] = values
    made["rupture_distance"] = law(own.volume, p.ri, p.rj, p.wall, p.ti, p.tj)
    factor = laws.pitois_factor(made["speed"], run.meta["viscosity"], run.meta["surface_tension"])
    beyond = 1.01 * made["rupture_distance"] * factor
    area = np.where(p.wall, fixed.area[np.where(p.wall, made["triangle"], -1)], 1.0)
    of_wall = own.film_j_before / area
    films = thickness(own.film_i_before, p.ri) + np.where(p.wall, of_wall, thickness(own.film_j_before, p.rj))
    touch = films - 0.5 * STEP_S * made["speed"]
    made["separation"] = np.where(made["kind"] == schema.RUPTURE, beyond, touch)
    alive.all.volume[-len(made) :], alive.all.rupture_distance[-len(made) :] = own.volume, made["rupture_distance"]


def contact_rows(
    run: io.Run, where: Places, step: int, stand: lives.Standing, random: np.random.Generator
) -> np.ndarray:
    """The contact log of one step: every standing bridge somewhere within its limit, forces as they should be."""
    wall = (stand.key >> 62).astype(bool)
    made = np.zeros(len(stand), schema.RAW["contacts"])
    made["step"], made["time"] = step, step * STEP_S
    made["i"], made["j"] = (stand.key >> 31) & 0x7FFFFFFF, stand.key & 0x7FFFFFFF
    made["partner_kind"], made["triangle"] = wall, np.where(wall, 0, -1)
    fixed = bodies(run)
    p = pairs(to_frame(made), fixed)
    made["partner_kind"] = p.kind
    gap = random.uniform(-0.01, 0.9, len(made)) * stand.rupture_distance
    made["xi"] = where.centre[made["i"]]
    n = random.normal(size=(len(made), 3))
    n /= np.sqrt((n**2).sum(axis=1))[:, None]
    made["xj"] = made["xi"] - n * (p.ri + np.where(p.wall, 0.0, p.rj) + gap)[:, None]
    made["vi"], made["wi"] = random.normal(0, 0.05, (2, len(made), 3))
    made["volume"], made["weight"], made["factor_normal"], made["factor_tangential"] = stand.volume, 1.0, 1.0, 1.0
    part = replace(run, tables={**run.tables, "contacts": to_frame(made)})
    c = forces.contacts(part)
    pull, drag, side = forces.capillary_term(part, c), forces.normal_term(part, c), forces.tangential_term(part, c)
    factor = laws.pitois_factor(c.speed, run.meta["viscosity"], run.meta["surface_tension"])
    made["separation"], made["rupture_distance"] = c.gap, stand.rupture_distance * factor
    made["capillary"], made["viscous_normal"], made["viscous_law"] = pull.value, drag.value, drag.value
    made["viscous_tangential"] = side.value
    made["force_i"] = (drag.value - pull.value)[:, None] * c.n + side.value
    turn = np.cross(c.n, side.value)
    made["torque_i"], made["torque_j"] = -p.ri[:, None] * turn, -np.where(p.wall, 0.0, p.rj)[:, None] * turn
    return made[np.lexsort((made["j"], made["i"], made["partner_kind"], made["step"]))]


def snapshot(files: dict[str, BinaryIO], run: io.Run, where: Places, step: int, held: np.ndarray,
             stand: lives.Standing, counts: tuple[int, int], tables: transfer.Tables) -> None:  # fmt: skip
    """Films, bridges and the ledger of an output, and its frame of the trajectory."""
    fixed, spheres = bodies(run), run.table("spheres")
    ids, walls = spheres["id"].to_numpy(), held[fixed.walls_from : -1]
    wet = np.flatnonzero(walls > 0.0)
    for name, number, which, film in (
        ("films", "id", ids, held[ids]), ("wall_films", "triangle", wet, walls[wet]),
    ):  # fmt: skip
        rows = np.zeros(len(which), schema.RAW[name])
        rows["step"], rows[number], rows["film"] = step, which, film
        rows.tofile(files[name])
    rows = np.zeros(len(stand), schema.RAW["bridges"])
    rows["step"], rows["volume"], rows["partner_kind"] = step, stand.volume, stand.key >> 62
    rows["i"], rows["j"] = (stand.key >> 31) & 0x7FFFFFFF, stand.key & 0x7FFFFFFF
    p = pairs(to_frame(rows), fixed)
    rows["partner_kind"], rows["xi"] = p.kind, where.centre[rows["i"]]
    rows["share_i"] = stand.volume * tables.ratios(*shapes(p, stand.volume, fixed))
    rows[np.lexsort((rows["j"], rows["i"], rows["partner_kind"]))].tofile(files["bridges"])
    row = np.zeros(1, schema.RAW["ledger"])
    row["step"], row["time"], row["films"] = step, step * STEP_S, held[ids].sum()
    row["bridges"], row["walls"], row["initial"] = stand.volume.sum(), walls.sum(), spheres["film"].sum()
    row["spheres"], row["bridge_count"], row["formations"], row["ruptures"] = len(ids), len(stand), *counts
    row.tofile(files["ledger"])
    frame = np.column_stack([ids, spheres["type"], where.centre[ids], np.zeros((len(ids), 6))])
    head = f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{len(ids)}\nITEM: BOX BOUNDS ff ff ff\n" + "0 1\n" * 3
    files["trajectory"].write(f"{head}ITEM: ATOMS id\n".encode())
    np.savetxt(files["trajectory"], frame, fmt="%d %d " + " ".join(["%.17g"] * 9))


def write(source: Path, out: Path, spheres: int, events: int, seed: int = 1) -> io.Run:
    """A run directory whose `engine.partial` holds the raw logs; returns its start."""
    random = np.random.default_rng(seed)
    run = template(source, out, spheres)
    planned, tables, where = plans.plan(out), transfer.Tables(run.table("transfer")), places(run, random)
    held = bodies(run).liquid()
    marks = np.unique(np.concatenate([planned.outputs, planned.window_steps]))
    before, done, formed, start = lives.none(), 0, 0, 0
    folder = out / "engine.partial"
    folder.mkdir()
    names = {n: f"{n}.0.bin" for n in RAW if n != "wire_springs"} | {"trajectory": "trajectory.txt"}
    files = {name: open(folder / path, "wb") for name, path in names.items()}  # noqa: SIM115
    for mark in marks:
        want = int(events * (mark / planned.steps)) - done
        while want > 0:
            count = min(want, 100_000, len(where.kind) // 2)
            last = start + max(1, int((mark - start) * count / want))
            made = some_events(where, start + 1, int(mark) if count == want else last, count, random)
            alive = lives.Lives(before, to_frame(made), done, start)
            booked(run, tables, made, alive, held)
            made.tofile(files["events"])
            broke = made["kind"] == schema.RUPTURE
            before, start, done = alive.standing(), int(made["step"][-1]), done + len(made)
            formed, want = formed + int((~broke).sum()), want - count
        start = int(mark)
        if mark in planned.window_steps:
            acting = before.of(before.step < mark)
            contact_rows(run, where, int(mark), acting, random).tofile(files["contacts"])
        if mark in planned.outputs:
            snapshot(files, run, where, int(mark), held, before, (formed, done - formed), tables)
    for file in files.values():
        file.close()
    start_places = pd.DataFrame(where.centre[1:], columns=list("xyz")).assign(id=run.table("spheres")["id"])
    start_places.to_parquet(out / json.loads((out / "scene.json").read_text())["spheres_file"])
    return run
