"""Constant data of a run: radii, angles, areas, half widths, by the number of sphere, triangle or wall part."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.replay import io, laws
from reference_impl.replay.arrays import Floats, Table
from reference_impl.replay.io import ReplayError, Run, where


@dataclass(frozen=True)
class Bodies:
    """Arrays by number; missing entries are NaN, in `type_of` and `group` -1.

    They have one more element than there are numbers.
    """

    radius: Floats
    type_of: Floats
    angle: Floats
    film: Floats
    """Initial film of spheres."""
    area: Floats
    film_of: Floats
    """First of the triangles that share a film; the film has the number of this triangle."""
    film_area: Floats
    """Total area of the triangles that share a film."""
    half_width: Floats
    wall_angle: Floats
    group: Floats

    @property
    def walls_from(self) -> int:
        """Return the number of the first triangle among the reservoirs: spheres are numbered first, then triangles."""
        return len(self.radius)

    def share_of(self, triangle: Any) -> Floats:
        """Compute the share of a film's liquid that is on one of its triangles."""
        return np.asarray(self.area[triangle] / self.film_area[triangle])

    def liquid(self) -> Floats:
        """Return the initial liquid of every reservoir."""
        return np.concatenate([np.nan_to_num(self.film), np.zeros(len(self.area))])


@dataclass(frozen=True)
class Pairs:
    """Both partners of each row of a log; at a wall the radius of j is a dummy, 1, and `other` its group."""

    wall: Floats
    i: Floats
    sphere_j: Floats
    """Index of sphere j; at a wall an index that belongs to no sphere."""
    part: Floats
    ri: Floats
    rj: Floats
    ti: Floats
    tj: Floats
    width: Floats
    """Half width of the wall part, infinite for spheres and large walls."""
    kind: Floats
    """Kind of partner by the half width, not by the log."""


def _by_number(numbers: Any, values: Any, none: float = np.nan) -> Floats:
    at = np.asarray(numbers, dtype=np.int64)
    found = np.full(int(at.max(initial=-1)) + 2, none, dtype=np.asarray(values).dtype if none != none else np.int64)
    found[at] = values
    return found


def bodies(run: Run) -> Bodies:
    """Return the constant data of a run, computed once."""
    if "bodies" not in run.known:
        spheres = run.table("spheres")
        no_walls = pd.DataFrame(
            {k: np.zeros(0) for k in ("triangle", "area", "part", "mesh", "half_width", "contact_angle", "part_class")}
        )
        triangles, parts = run.tables.get("triangles", no_walls), run.tables.get("parts", no_walls)
        angle = {t["type"]: t["contact_angle"] for t in run.meta["types"]}
        number, part = spheres["id"], parts["part"]
        film_of, film_area = films(triangles, io.scene(run.folder).get("wall_film", "triangle"))
        run.known["bodies"] = Bodies(
            radius=_by_number(number, spheres["radius"].astype(float)),
            type_of=_by_number(number, spheres["type"], -1),
            angle=_by_number(number, spheres["type"].map(angle).astype(float)),
            film=_by_number(number, spheres["film"].astype(float)),
            area=_by_number(triangles["triangle"], triangles["area"].astype(float)),
            film_of=film_of,
            film_area=film_area,
            half_width=_by_number(part, parts["half_width"].fillna(np.inf).astype(float)),
            wall_angle=_by_number(part, parts["contact_angle"].astype(float)),
            group=_by_number(part, parts["part_class"], -1),
        )  # fmt: skip
    found: Bodies = run.known["bodies"]
    return found


FILMS = {"triangle": "triangle", "part": "part", "wall": "mesh"}
"""Area with a film of one thickness -> the column of the triangles that identifies it."""


def films(triangles: pd.DataFrame, of: str) -> tuple[Floats, Floats]:
    """Return for each triangle the first triangle that shares its film, and the area of the film."""
    groups = triangles.groupby(triangles[FILMS[of]].to_numpy())
    first = _by_number(triangles["triangle"], groups["triangle"].transform("min"), -1)
    return first, _by_number(triangles["triangle"], groups["area"].transform("sum").astype(float))


def pairs(table: Table, fixed: Bodies) -> Pairs:
    """Return the partners of each row of a log."""
    wall = np.asarray(table["partner_kind"]) != laws.SPHERE
    i, j = (np.asarray(table[name], dtype=np.int64) for name in "ij")
    sphere_j, part = np.where(wall, len(fixed.radius) - 1, j), np.where(wall, j, len(fixed.half_width) - 1)
    ri = fixed.radius[i]
    width = np.where(wall, fixed.half_width[part], np.inf)
    return Pairs(
        wall, i, sphere_j, part, ri, np.where(wall, 1.0, fixed.radius[sphere_j]), fixed.angle[i],
        np.where(wall, fixed.wall_angle[part], fixed.angle[sphere_j]), width,
        np.where(wall, np.where(width < ri, laws.SMALL_WALL, laws.LARGE_WALL), laws.SPHERE),
    )  # fmt: skip


def shapes(p: Pairs, volume: Floats, fixed: Bodies) -> tuple[Floats, Floats, Floats, Floats]:
    """Return kind of partner, type of i, type or group of j, and V*, as in the rows of the table of transfer ratios."""
    other = np.where(p.wall, fixed.group[p.part], fixed.type_of[p.sphere_j])
    return p.kind, fixed.type_of[p.i], other, volume / laws.harmonic_radius(p.ri, p.rj, p.wall) ** 3


def of_bridges(rows: pd.DataFrame, volume: Floats, run: Run) -> tuple[Floats, Floats, Floats, Floats]:
    """Compute the shapes of the bridges in rows of a log from bodies and volumes."""
    fixed = bodies(run)
    return shapes(pairs(rows, fixed), volume, fixed)


def reservoirs_of(table: pd.DataFrame, p: Pairs, fixed: Bodies) -> tuple[Floats, Floats]:
    """Return the numbers of the reservoirs, on i's and on j's side, that an event draws from or returns to."""
    return p.i.astype(np.int64), np.where(p.wall, fixed.walls_from + fixed.film_of[_triangles(table, p)], p.sphere_j)


def _triangles(table: pd.DataFrame, p: Pairs) -> Floats:
    """List the triangle of each bridge at a wall, and -1 for a bridge between spheres."""
    return np.where(p.wall, table["triangle"].to_numpy(), -1)


def film_areas(table: pd.DataFrame, p: Pairs, fixed: Bodies) -> Floats:
    """Return the area of the wall's film from which a bridge draws; NaN between spheres."""
    return np.asarray(fixed.film_area[_triangles(table, p)])


def within(path: Path, numbers: Floats, there: Floats, what: str, rows: Floats | bool = True) -> None:
    """Refuse identifiers that an array of `Bodies` has no value for; only the selected rows are checked."""
    refuse(path, numbers[(np.isnan(there.take(numbers, mode="clip")) | (numbers < 0)) & rows], what)


def refuse(path: Path, strange: Floats, what: str) -> None:
    """Refuse identifiers that do not exist at the start."""
    if len(strange):
        raise ReplayError(f"{path} names the {what} {strange[0]}, which the start of the run does not have; "
                          f"expected the numbers of history/: run the case again")  # fmt: skip


def known(run: Run, names: tuple[str, ...]) -> None:
    """Refuse logs that name bodies which the start does not have."""
    for name in names:
        all_known(run, name, run.table(name))


def all_known(run: Run, name: str, table: Table) -> None:
    """Check that the bodies of some rows of a log exist in the run."""
    fixed, path = bodies(run), where(run.folder, name)
    wall = np.asarray(table["partner_kind"]) != laws.SPHERE
    for column, rows, there, what in (
        ("i", True, fixed.radius, "sphere"),
        ("j", ~wall, fixed.radius, "sphere"),
        ("j", wall, fixed.half_width, "wall part"),
        ("triangle", wall, fixed.area, "triangle"),
    ):
        within(path, np.asarray(table[column]), there, what, rows)
