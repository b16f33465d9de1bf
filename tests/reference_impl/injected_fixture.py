"""Faults injected in tables of the fixture scene's sound run: input of later stages, bridge ends, works, counts, rows of a rank.

Each entry: what is changed, the quantity that must break, and the words by which the replay must name it.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from tests.reference_impl.fixture_scene import OPENS, TRAVEL, spheres
from tests.reference_impl.newton_scenes import R

RADII = np.array([0.0, *({1: R, 2: 2e-3}[sphere.kind] for sphere in spheres())])
"""By number."""
Change = Callable[[pd.DataFrame], pd.DataFrame]


@dataclass(frozen=True)
class Injected:
    """A change of one table, the quantity it shows in, and its name."""

    table: str
    change: Change
    quantity: str
    words: str


def plant(sound: Path, folder: Path, *faults: Injected) -> Path:
    """A copy of the run with some tables changed; all else is linked, not copied."""
    shutil.copytree(sound, folder, dirs_exist_ok=True, copy_function=lambda a, b: Path(b).hardlink_to(a))
    for made in ("replay.json", "contributions.json"):
        (folder / made).unlink(missing_ok=True)
    for injected in faults:
        name = injected.table
        beside = name in ("trajectory", "mesh_motion")
        path = folder / f"{name}.parquet" if beside else folder / "history" / f"{name}.parquet"
        table = injected.change(pd.read_parquet(path))
        path.unlink()
        table.to_parquet(path, index=False)
    return folder


def rounds() -> list[list[str]]:
    """Names of faults that do not touch each other's quantities, to be injected together: one replay for several."""
    alone = [[name] for name, f in FAULTS.items() if f.table in ("trajectory", "events", "contacts")]
    single = [
        n for n in FAULTS if n.startswith("works:") and FAULTS[n].quantity not in ("energy_windows", "energy_budget")
    ]
    works = [[n] for n in FAULTS if n.startswith("works:") and n not in single] + [single]
    rest = {t: [n for n, f in FAULTS.items() if f.table == t] for t in ("mesh_motion", "ledger", "bridges")}
    made = [*works, *([name] for name in rest["bridges"])]
    for table in ("mesh_motion", "ledger"):
        for k, name in enumerate(rest[table]):
            made[k].append(name)
    return [*made, *alone]


def exchanged(one: str, two: str, rows: Callable[[pd.DataFrame], pd.Series] | None = None) -> Change:
    """Two columns exchanged (in some rows)."""

    def change(table: pd.DataFrame) -> pd.DataFrame:
        at = rows(table) if rows else pd.Series(True, index=table.index)
        table.loc[at, [one, two]] = table.loc[at, [two, one]].to_numpy(copy=True)
        return table

    return change


def scaled(names: Sequence[str], by: float, rows: Callable[[pd.DataFrame], pd.Series] | None = None) -> Change:
    """Columns times a factor."""

    def change(table: pd.DataFrame) -> pd.DataFrame:
        at = rows(table) if rows else pd.Series(True, index=table.index)
        for name in names:
            table.loc[at, name] = (table.loc[at, name] * by).astype(table[name].dtype)
        return table

    return change


def of(mesh: str) -> Callable[[pd.DataFrame], pd.Series]:
    """Rows of one mesh."""
    return lambda table: table["mesh"] == mesh


def moved(names: Sequence[str], by: float) -> Change:
    """Columns plus a constant."""

    def change(table: pd.DataFrame) -> pd.DataFrame:
        for name in names:
            table[name] = table[name] + by
        return table

    return change


def later(table: pd.DataFrame) -> pd.DataFrame:
    """Places of the output before."""
    columns, spheres = ["x", "y", "z"], table["id"].nunique()
    table = table.sort_values(["step", "id"], ignore_index=True)
    # the initial positions are unchanged, because they are compared with the scene
    table.loc[spheres:, columns] = table[columns].shift(spheres).loc[spheres:].to_numpy()
    return table


def opens_late(steps: int, step_s: float, speed: float) -> Change:
    """The drawn plate starts and stops so many steps late."""

    def change(table: pd.DataFrame) -> pd.DataFrame:
        at = table["mesh"] == "drawer"
        step = table.loc[at, "step"].to_numpy() - steps
        begins, stops = round(OPENS / step_s), round((OPENS + TRAVEL) / step_s)
        table.loc[at, "dx"] = speed * step_s * (np.clip(step, begins, stops) - begins)
        return table

    return change


def first_triangle(of_kind: int | None) -> Change:
    """Replace the triangles of each wall part by the lowest one that occurs (in events of a kind)."""

    def change(table: pd.DataFrame) -> pd.DataFrame:
        rows = table["partner_kind"] > 0
        rows &= (table["kind"] == of_kind) if of_kind is not None else True
        first = table[table["partner_kind"] > 0].groupby("j")["triangle"].min()
        table.loc[rows, "triangle"] = table.loc[rows, "j"].map(first).astype(table["triangle"].dtype)
        return table

    return change


def columns_of_one_rank(table: pd.DataFrame) -> pd.DataFrame:
    """Rows of spheres on one side are not there."""
    return table[table["xi_x"] < 0.015].reset_index(drop=True)


def moving(table: pd.DataFrame) -> pd.Series:
    """Rows after the start: that with other velocities at the start is refused."""
    return table["step"] > 0


def turned(names: Sequence[str]) -> Change:
    """The other sign."""
    return scaled(names, -1.0)


FAULTS: dict[str, Injected] = {
    "mesh motion: x and z exchanged": Injected(
        "mesh_motion",
        exchanged("dx", "dz"),
        "mesh_motion",
        "components x and z are exchanged",
    ),
    "mesh motion: amplitude of the screen 2 % off": Injected(
        "mesh_motion", scaled(["dx", "dy", "dz"], 1.02, of("screen")), "mesh_motion", "it is 1.02 times"
    ),
    "mesh motion: amplitude along z alone 2 % off": Injected(
        "mesh_motion", scaled(["dz"], 0.98, of("screen")), "mesh_motion", "component z is 0.98 times"
    ),
    "mesh motion: the slide opens 25 steps late": Injected(
        "mesh_motion", opens_late(25, 2e-5, 0.25), "mesh_motion", "it is 25 steps late"
    ),
    "mesh motion: sign of x turned": Injected(
        "mesh_motion", turned(["dx"]), "mesh_motion", "component x has the other sign"
    ),
    "mesh motion in mm": Injected("mesh_motion", scaled(["dx", "dy", "dz"], 1e3), "mesh_motion", "it is 1000 times"),
    "trajectory: x and y exchanged": Injected(
        "trajectory",
        lambda t: pd.concat([t[t["step"] == 0], exchanged("x", "y")(t[t["step"] > 0])], ignore_index=True),
        "trajectory",
        "components x and y are exchanged",
    ),
    "trajectory: places of the output before": Injected(
        "trajectory", later, "trajectory", "it is that of the output before"
    ),
    "trajectory: time a step late": Injected(
        "trajectory", moved(["time"], 2e-5), "time", "it is 2e-05 s late (1 steps)"
    ),
    "trajectory: speeds along x and z exchanged": Injected(
        "trajectory", exchanged("vx", "vz", moving), "trajectory_velocity", "components x and z are exchanged"
    ),
    "trajectory: spins turned": Injected(
        "trajectory", scaled(["wx", "wy", "wz"], -1.0, moving), "trajectory_velocity", "the sign is turned"
    ),
    "ledger: time in milliseconds": Injected("ledger", scaled(["time"], 1e3), "time", "it is 1000 times too large"),
    "ledger: formations and ruptures exchanged": Injected(
        "ledger", exchanged("formations", "ruptures"), "ledger_counts", "formations and ruptures are exchanged"
    ),
    "ledger: one sphere too many": Injected(
        "ledger", moved(["spheres"], 1), "ledger_counts", "it is off by 1 throughout"
    ),
    "ledger: films and bridges exchanged": Injected(
        "ledger", exchanged("films", "bridges"), "ledger_held", "films and bridges are exchanged"
    ),
    "snapshots: gaps doubled": Injected(
        "bridges", scaled(["separation"], 2.0), "snapshot_separation", "it counts twice"
    ),
    "snapshots: radius of j left out": Injected(
        "bridges",
        lambda t: t.assign(separation=t["separation"] + np.where(t["partner_kind"] == 0, RADII[t["j"]], 0.0)),
        "snapshot_separation",
        "the radius of j is left out (between spheres",
    ),
    "snapshots: end at j is that of i": Injected(
        "bridges",
        lambda t: t.assign(**{f"xj_{a}": t[f"xi_{a}"] for a in "xyz"}),
        "snapshot_ends",
        "both ends are that of i",
    ),
    "snapshots: end at j a millimetre off": Injected(
        "bridges", moved(["xj_z"], 1e-3), "snapshot_ends", "it is moved by 0, 0, 0.001"
    ),
    "snapshots: one triangle for every bridge of a part": Injected(
        "bridges", first_triangle(None), "snapshot_triangle", "it is not the closest of the part"
    ),
    "works: capillary and normal drag exchanged": Injected(
        "window_energy",
        exchanged("capillary", "viscous_normal"),
        "energy_windows",
        "capillary and viscous_normal are exchanged",
    ),
    "works: contact halved": Injected(
        "energy", scaled(["contact"], 0.5), "energy_budget", "the work contact is 0.5 times"
    ),
    "works: tangential drag left out": Injected(
        "window_energy", scaled(["viscous_tangential"], 0.0), "energy_windows", "it is left out"
    ),
    "works: walls counted in contact as well": Injected(
        "window_energy",
        lambda t: t.assign(contact=t["contact"] + t["wall_motion"]),
        "energy_windows",
        "wall_motion is counted in as well",
    ),
    "works: gravity 1 % off": Injected("energy", scaled(["gravity"], 1.01), "energy_gravity", "1.01 times"),
    "works: kinetic energy without the half": Injected(
        "energy", scaled(["kinetic"], 2.0), "energy_kinetic", "it counts twice"
    ),
    "works: energy of formations 2 % off": Injected(
        "energy", scaled(["formed"], 1.02), "energy_formed", "it is 1.02 times"
    ),
    "works: stored energy turned": Injected(
        "energy", turned(["capillary_stored"]), "energy_capillary_stored", "the sign is turned"
    ),
    "a rank's contact rows are missing": Injected("contacts", columns_of_one_rank, "contact_rows", "as of one rank"),
    "gaps of events halved": Injected("events", scaled(["separation"], 0.5), "event_separation", "half of it counts"),
    "speeds of events halved": Injected("events", scaled(["speed"], 0.5), "event_speed", "half of it counts"),
}
"""Name -> change, quantity, words."""
