"""Drops that let go of spheres: how much falls, where it lands, and that it is booked there.

The drops of a step come after its formations and ruptures; each sphere sheds one at most, from its film before any of them.
What a film felt is taken as logged. Where a drop lands is found anew at output steps, where all places are known.
"""

from __future__ import annotations

from collections import defaultdict
from typing import Any

import numpy as np
import pandas as pd

from reference_impl import coverage, io, laws, window
from reference_impl.compare import Floats, Quantity, compare
from reference_impl.io import Run
from reference_impl.wall_motion import Motion

NOTHING = 3
ROOM = 0.8 * 2.5
"""A sphere whose film would be thicker than this many times the first film on the smallest spheres (in radii) is passed."""
ONSET, FACTOR, POWER = (0.2, 1.2), 3.60, 2.81


def falls(film: float, radius: float, felt: float, density: float, tension: float) -> float:
    """Drop that falls from a film [m3]: none up to Tate's weight 2 pi r sigma, then Harkins and Brown's part of that.

    Their part F is that of r over the cube root of what falls, phi; as 3.60 phi^2.81 = Bond number, phi from 0.2 to 1.2.
    """
    if felt * density * film <= 2.0 * np.pi * radius * tension:
        return 0.0
    phi = float(np.clip((density * felt * radius**2 / tension / FACTOR) ** (1.0 / POWER), *ONSET))
    part = FACTOR * phi ** (POWER - 3.0) / (2.0 * np.pi)
    return part * 2.0 * np.pi * radius * tension / (density * felt)


class Places:
    """Where spheres and walls are at the output steps, and what is below a point."""

    def __init__(self, run: Run) -> None:
        self._setup = window.read(run.folder)
        self._motion = Motion(self._setup)
        table = io.columns(run.folder / "trajectory.parquet", ["step", "id", *"xyz"]).sort_values(["step", "id"])
        steps, cuts = np.unique(table["step"].to_numpy(), return_index=True)
        self.at = dict(zip(steps.tolist(), np.split(table[[*"xyz"]].to_numpy(float), cuts[1:]), strict=True))
        self.down = self._setup.gravity / np.linalg.norm(self._setup.gravity)
        first, classes = self._setup.scene["liquid"]["initial_film_thickness_m"], self._setup.scene["classes"]
        self._room = ROOM * first / min(c["radius_m"] for c in classes)

    def landing(self, step: int, drop: Any, film: dict[int, float]) -> tuple[int, int, float]:
        """Kind and number of what a drop lands on, and how far below the centre it leaves from."""
        x, ids, radius = self.at[step], self._setup.ids, self._setup.radius
        start = x[np.searchsorted(ids, drop.i)]
        d = x - start
        along = d @ self.down
        beside = np.linalg.norm(d - along[:, None] * self.down, axis=1)
        held = np.array([film[k] for k in ids]) + drop.volume
        takes = (3.0 * held / (4.0 * np.pi) + radius**3) ** (1.0 / 3.0) - radius <= self._room * radius
        hit = (along > 0.0) & (beside < radius) & (ids != drop.i) & takes
        ways = np.where(hit, along - np.sqrt(np.maximum(radius**2 - beside**2, 0.0)), np.inf)
        best = int(np.argmin(ways))
        found = (laws.SPHERE, int(ids[best]), float(ways[best])) if np.isfinite(ways[best]) else (NOTHING, -1, np.inf)
        wall = self._wall(step, start)
        if wall[1] < found[2]:
            return laws.LARGE_WALL, wall[0], wall[1]
        return found if found[0] != NOTHING else (NOTHING, -1, 0.0)

    def _wall(self, step: int, start: Floats) -> tuple[int, float]:
        """The first triangle below a point and how far: the point's shadow lies on one side of all its edges' shadows."""
        best = (-1, np.inf)
        for wall in self._setup.walls:
            corners = self._motion.to_world(wall, step, self._setup.corners[wall.first : wall.last].reshape(-1, 3))
            t = corners.reshape(-1, 3, 3) - start
            turns = [np.cross(t[:, k], t[:, (k + 1) % 3]) @ self.down for k in range(3)]
            area = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
            slope = area @ self.down
            with np.errstate(all="ignore"):
                way = (t[:, 0] * area).sum(axis=1) / slope
            inside = np.logical_and.reduce([turn * np.sign(slope) >= 0.0 for turn in turns])
            way = np.where(inside & (slope != 0.0) & (way > 0.0), way, np.inf)
            k = int(np.argmin(way))
            if way[k] < best[1]:
                best = (wall.first + k, float(way[k]))
        return best


class Falling:
    """The drops of a run in order, booked step by step in a state of films (`film` by sphere, `wall` by triangle)."""

    def __init__(self, run: Run, radius: dict[int, float]) -> None:
        self.table = run.tables.get("drops", pd.DataFrame())
        self._rows: list[Any] = list(self.table.itertuples(index=False))
        self._next, self._radius, self.left = 0, radius, 0.0
        self._known = coverage.known(run, "shedding")
        self.own: dict[str, list[float]] = defaultdict(list)
        self.films: list[tuple[int, int, float]] = []
        """Step, holder (a triangle k is -1 - k) and film after each change."""
        if self._rows:
            liquid = io.scene(run.folder)["liquid"]
            self._density, self._tension = liquid["density_kg_per_m3"], liquid["surface_tension_N_per_m"]
            self._places = Places(run)

    def before(self, step: float, film: dict[int, float], wall: dict[int, float]) -> None:
        """Book all drops of the steps before this one."""
        while self._next < len(self._rows) and self._rows[self._next].step < step:
            last = self._next
            while last < len(self._rows) and self._rows[last].step == self._rows[self._next].step:
                last += 1
            self._of_step(self._rows[self._next : last], film, wall)
            self._next = last

    def _of_step(self, drops: list[Any], film: dict[int, float], wall: dict[int, float]) -> None:
        """All drops of one step."""
        at = dict(film) if drops[0].step in self._places.at else {}
        volumes = [self._volume(d, film[d.i]) for d in drops]
        for d, volume in zip(drops, volumes, strict=True):
            kind, j, way = self._places.landing(d.step, d, at) if at else (min(d.partner_kind, 1), d.j, d.fallen)
            near = abs(way - d.fallen) < 1e-9 * self._radius[d.i]  # beside a seam either triangle may be met
            same = kind == min(d.partner_kind, 1) if d.partner_kind != NOTHING else kind == NOTHING
            same = same and (j == d.j or (kind == laws.LARGE_WALL and near))
            for name, value in (
                ("volume", volume),
                ("film_i_before", film[d.i]),
                ("same", float(same)),
                ("fallen", way),
            ):
                self.own[name].append(value)
            self.own["seen"].append(float(bool(at)))
            self.own["film_j_before"].append(self._move(d, volume, film, wall))

    def _volume(self, d: Any, film: float) -> float:
        if not self._known:
            return float(d.volume)
        felt = float(np.sqrt(d.felt_x**2 + d.felt_y**2 + d.felt_z**2))
        return falls(film, self._radius[d.i], felt, self._density, self._tension)

    def _move(self, d: Any, volume: float, film: dict[int, float], wall: dict[int, float]) -> float:
        """Take a drop from i and give it to what it fell on; what that held before."""
        film[d.i] -= volume
        self.films.append((d.step, d.i, film[d.i]))
        if d.partner_kind == NOTHING:
            self.left += volume
            return self.left - volume
        holders = film if d.partner_kind == laws.SPHERE else wall
        before = holders.get(d.j, 0.0)
        holders[d.j] = before + volume
        self.films.append((d.step, d.j if d.partner_kind == laws.SPHERE else -1 - d.j, holders[d.j]))
        return before

    def check(self, mean: float) -> list[Quantity]:
        """Volumes, films before, where drops landed; `mean` film of a sphere [m3]."""
        table = self.table
        if not len(table):
            return []
        mine = {name: np.array(values) for name, values in self.own.items()}
        typical = np.full(len(table), mean)
        found = [
            compare("drop_volume", "itself", table["volume"].to_numpy(float), mine["volume"], mine["volume"], table)
        ]
        for name in ("film_i_before", "film_j_before"):
            logged = table[name].to_numpy(float)
            found.append(compare(f"drop_{name}", "mean film of a sphere", logged, mine[name], typical, table))
        seen = mine["seen"] > 0.0
        rows = table[seen].reset_index(drop=True)
        one, radius = np.ones(len(rows)), rows["i"].map(self._radius).to_numpy(float)
        fallen = rows["fallen"].to_numpy(float)
        found.append(compare("drop_landing", "drops that land elsewhere", mine["same"][seen], one, one, rows, 0.0))
        found.append(compare("drop_fall", "radius", fallen, mine["fallen"][seen], radius, rows))
        return found
