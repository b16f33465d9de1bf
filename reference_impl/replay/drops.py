"""Drops shed by spheres: their volume, where they land, and whether they are added there.

The drops of a step follow its formations and ruptures; each sphere sheds at most one, from its film before all drops.
The force felt by a film is taken as logged. Landing is recomputed at output steps, where all positions are known.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.motion import window
from reference_impl.motion.wall_motion import Motion
from reference_impl.replay import coverage, io, laws, plans
from reference_impl.replay.arrays import Floats
from reference_impl.replay.bodies import bodies, within
from reference_impl.replay.compare import Quantity, compare
from reference_impl.replay.io import Run

NOTHING = 3
LARGEST_FILM = 0.8 * 2.5
"""Largest film, in units of the initial film on the smallest spheres (in radii), up to which a drop is caught by a sphere."""
ONSET, FACTOR, POWER = (0.2, 1.2), 3.60, 2.81


def falls(film: float, radius: float, felt: float, density: float, tension: float) -> float:
    """Return the drop that falls from a film [m3].

    There is none up to Tate's weight 2 pi r sigma; beyond it the drop is Harkins and Brown's fraction of it.
    Their fraction F depends on phi, r over the cube root of the falling volume; 3.60 phi^2.81 = Bond number, phi
    from 0.2 to 1.2.
    """
    if felt * density * film <= 2.0 * np.pi * radius * tension:
        return 0.0
    phi = float(np.clip((density * felt * radius**2 / tension / FACTOR) ** (1.0 / POWER), *ONSET))
    part = FACTOR * phi ** (POWER - 3.0) / (2.0 * np.pi)
    return part * 2.0 * np.pi * radius * tension / (density * felt)


QUANTITIES = ("volume", "film_i_before", "film_j_before", "same", "fallen", "seen")


class Places:
    """Positions of spheres and walls at the output steps, and the search for what is below a point."""

    def __init__(self, run: Run) -> None:
        self._setup = window.read(run.folder)
        # without wall films drops pass through walls
        self._walls = self._setup.walls if self._setup.scene["effects"].get("wall_films", True) else ()
        self._motion = Motion(self._setup)
        self.at: dict[int, Floats] = {}
        self._enters = plans.entered(self._setup.scene, run.table("spheres").sort_values("id"))
        """Step at which each sphere enters; it waits before, and nothing falls on it."""
        self.down = self._setup.gravity / np.linalg.norm(self._setup.gravity)
        first, classes = self._setup.scene["liquid"]["initial_film_thickness_m"], self._setup.scene["classes"]
        self._margin = LARGEST_FILM * first / min(c["radius_m"] for c in classes)

    def show(self, trajectory: pd.DataFrame) -> None:
        """Add the output steps of a part of the log."""
        table = trajectory.sort_values(["step", "id"])
        steps, cuts = np.unique(table["step"].to_numpy(), return_index=True)
        self.at = dict(zip(steps.tolist(), np.split(table[[*"xyz"]].to_numpy(float), cuts)[1:], strict=True))

    def landing(self, step: int, drop: Any, film: Floats) -> tuple[int, int, float]:
        """Return kind and number of the body on which a drop lands, and how far below the centre it starts."""
        x, ids, radius = self.at[step], self._setup.ids, self._setup.radius
        start = x[np.searchsorted(ids, drop.i)]
        d = x - start
        along = d @ self.down
        beside = np.linalg.norm(d - along[:, None] * self.down, axis=1)
        held = film[ids] + drop.volume
        takes = (3.0 * held / (4.0 * np.pi) + radius**3) ** (1.0 / 3.0) - radius <= self._margin * radius
        hit = (along > 0.0) & (beside < radius) & (ids != drop.i) & takes & (self._enters <= step)
        ways = np.where(hit, along - np.sqrt(np.maximum(radius**2 - beside**2, 0.0)), np.inf)
        best = int(np.argmin(ways))
        found = (laws.SPHERE, int(ids[best]), float(ways[best])) if np.isfinite(ways[best]) else (NOTHING, -1, np.inf)
        wall = self._wall(step, start)
        if wall[1] < found[2]:
            return laws.LARGE_WALL, wall[0], wall[1]
        return found if found[0] != NOTHING else (NOTHING, -1, 0.0)

    def _wall(self, step: int, start: Floats) -> tuple[int, float]:
        """Return the first triangle below a point and its distance, from its side of the projected edges."""
        best = (-1, np.inf)
        for wall in self._walls:
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
    """Drops of a run, applied step by step to the liquid of all reservoirs, numbered as in bodies.py."""

    def __init__(self, run: Run) -> None:
        self._table, self._fixed, self._known = run.shed, bodies(run), coverage.known(run, "shedding")
        self._rows: Iterator[Any] = self._table.itertuples(index=False)
        self._all, self._next, self._checked, self.left = self._table["step"].to_numpy(), 0, 0, 0.0
        self._recomputed: dict[str, list[float]] = defaultdict(list)
        self.steps: Floats = np.zeros(0, np.int64)
        """Steps with drops in this part."""
        if len(self._table):
            self._refuse(io.where(run.folder, io.SHED))
            liquid = io.scene(run.folder)["liquid"]
            self._density, self._tension = liquid["density_kg_per_m3"], liquid["surface_tension_N_per_m"]
            self._places = Places(run)
            triangles = run.tables.get("triangles", pd.DataFrame({"triangle": [], "part": []}))
            self._part_of = np.append(triangles.sort_values("triangle")["part"].to_numpy(np.int64), -1)

    def _refuse(self, path: Path) -> None:
        """Refuse numbers that do not exist at the start."""
        kind, j = self._table["partner_kind"].to_numpy(), self._table["j"].to_numpy()
        within(path, self._table["i"].to_numpy(), self._fixed.radius, "sphere")
        within(path, j[kind == laws.SPHERE], self._fixed.radius, "sphere")
        within(path, j[(kind != laws.SPHERE) & (kind != NOTHING)], self._fixed.area, "triangle")

    def start(self, part: Run, last: int) -> None:
        """Start a part of the log, up to a step."""
        self.steps = np.unique(self._all[self._next : np.searchsorted(self._all, last, "right")])
        if len(self.steps):
            self._places.show(part.table("trajectory"))

    def book(self, step: int, held: Floats) -> None:
        """Apply all drops of a step to `held`."""
        last = int(np.searchsorted(self._all, step, "right"))
        drops = list(islice(self._rows, last - self._next))
        self._next = last
        at = held.copy() if step in self._places.at else None
        volumes = [self._volume(d, held[d.i]) for d in drops]
        for d, volume in zip(drops, volumes, strict=True):
            kind, j, way = min(d.partner_kind, 1), d.j, d.fallen
            if at is not None:
                kind, j, way = self._places.landing(step, d, at)
                if kind == laws.SPHERE:  # what later drops of the step find there
                    at[j] += d.volume
            # next to a seam the drop may hit either triangle
            near = abs(way - d.fallen) < 1e-9 * self._fixed.radius[d.i]
            wall = kind == laws.LARGE_WALL
            same = d.partner_kind == (self._kind_of_wall(j, d.i) if wall else kind) and (j == d.j or (wall and near))
            for name, value in (
                ("volume", volume),
                ("film_i_before", held[d.i]),
                ("same", float(same)),
                ("fallen", way),
                ("seen", float(at is not None)),
                ("film_j_before", self._move(d, volume, held)),
            ):
                self._recomputed[name].append(value)

    def _kind_of_wall(self, triangle: int, sphere: int) -> int:
        thin = self._fixed.half_width[self._part_of[triangle]] < self._fixed.radius[sphere]
        return laws.SMALL_WALL if thin else laws.LARGE_WALL

    def _volume(self, d: Any, film: float) -> float:
        if not self._known:
            return float(d.volume)
        felt = float(np.sqrt(d.felt_x**2 + d.felt_y**2 + d.felt_z**2))
        return falls(film, self._fixed.radius[d.i], felt, self._density, self._tension)

    def _move(self, d: Any, volume: float, held: Floats) -> float:
        """Move a drop from i to the body on which it fell; return the liquid of that body before."""
        held[d.i] -= volume
        if d.partner_kind == NOTHING:
            self.left += volume
            return self.left - volume
        j = d.j if d.partner_kind == laws.SPHERE else self._fixed.walls_from + int(self._fixed.film_of[d.j])
        before = float(held[j])
        held[j] += volume
        return before

    def check(self, mean: float) -> list[Quantity]:
        """Compare volume, film before and target of the drops since the last call; `mean` is the mean film of a sphere [m3]."""
        if not len(self._table):
            return []
        table = self._table.iloc[self._checked : self._next].reset_index(drop=True)
        mine = {name: np.array(self._recomputed.pop(name, [])) for name in QUANTITIES}
        self._checked = self._next
        typical = np.full(len(table), mean)
        found = [
            compare("drop_volume", "itself", table["volume"].to_numpy(float), mine["volume"], mine["volume"], table)
        ]
        for name in ("film_i_before", "film_j_before"):
            logged = table[name].to_numpy(float)
            found.append(compare(f"drop_{name}", "mean film of a sphere", logged, mine[name], typical, table))
        seen = mine["seen"] > 0.0
        rows = table[seen].reset_index(drop=True)
        one, radius = np.ones(len(rows)), self._fixed.radius[rows["i"].to_numpy()]
        fallen = rows["fallen"].to_numpy(float)
        found.append(compare("drop_landing", "drops that land elsewhere", mine["same"][seen], one, one, rows, 0.0))
        found.append(compare("drop_fall", "radius", fallen, mine["fallen"][seen], radius, rows))
        return found
