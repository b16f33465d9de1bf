"""Content of a run's logs, one output step at a time, for comparison with outputs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import pandas as pd
import scipy  # its parts are loaded where they are used

from reference_impl.motion.window import way_of
from reference_impl.replay import capillary, exact, io, plans, script
from reference_impl.replay.arrays import Columns, Floats, Table
from reference_impl.replay.coverage import EXACT
from reference_impl.replay.lives import Lives, keys, none
from reference_impl.replay.stream import Rows


@dataclass(frozen=True)
class Moment:
    """Content of one output step by the logs: spheres in the order of their ids, bridges, films of triangles."""

    ids: Floats
    place: Floats
    speed: Floats
    radius: Floats
    kind: Floats
    film: Floats
    liquid: Floats
    in_bin: Floats
    bridges: Columns
    on_walls: Floats


class Logs:
    """The logs of a run, one output step at a time; fast for steps in ascending order."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.scene, self.plan = folder, io.scene(folder), plans.plan(folder)
        self.outputs = self.plan.outputs
        """Output steps that have files; in a script's run those with at least one sphere."""
        if script.of(folder):
            self.outputs = self.outputs[script.present(folder, self.outputs) > 0]
        self.origin = io.origin(folder)
        history = folder / "history"
        names = ["id", "type", "radius", "film", *(["enters"] if script.of(folder) else [])]
        start = io.columns(history / "spheres.parquet", names).sort_values("id")
        self.ids, self.kind, self.radius, self.film = (start[n].to_numpy() for n in ("id", "type", "radius", "film"))
        self.enters = plans.entered(self.scene, start)
        self.first_below = np.full(len(self.ids), np.inf)
        self.triangles, self.rest = pd.DataFrame({"triangle": []}), np.zeros((0, 3, 3))
        self.poses: script.Poses | None = None
        if self.plan.walls:
            corners = [f"v{n}_{axis}" for n in range(3) for axis in "xyz"]
            names = ["triangle", "part", "mesh", "reservoir", *corners]
            self.triangles = io.columns(history / "triangles.parquet", names).sort_values("triangle")
            self.rest = self.triangles[corners].to_numpy(float).reshape(-1, 3, 3)
            self.meshes, self.of_mesh = np.unique(self.triangles["mesh"].to_numpy(str), return_inverse=True)
            self.poses = script.Poses(folder) if script.of(folder) else None
            motion = io.columns(folder / "mesh_motion.parquet", ["step", "mesh", "dx", "dy", "dz"])
            self.motion = {(row.step, row.mesh): [row.dx, row.dy, row.dz] for row in motion.itertuples()}
        self._active, self._booked = none(), -1
        self._streams: dict[str, tuple[Rows, int]] = {}
        self.at = lru_cache(maxsize=4)(self._at)

    def _rows(self, name: str, columns: list[str], step: int) -> Columns:
        """Return the rows of a log at one step: the next of its stream, or by a search."""
        path = io.where(self.folder, name)
        stream, taken = self._streams.get(name) or (Rows(path, name, columns), -1)
        if step > taken:
            rows = stream.columns(step)
            self._streams[name] = stream, step
            return rows.cut(int(np.searchsorted(rows["step"], step)), len(rows))
        found = io.table(path, name, [("step", "==", step)])
        return Columns({str(of): found[of].to_numpy() for of in found})

    def _at(self, step: int) -> Moment:
        rows = self._rows("trajectory", ["step", "id", "type", *"xyz", "vx", "vy", "vz"], step)
        rows = rows.take(np.argsort(rows["id"], kind="stable"))
        here = np.searchsorted(self.ids, rows["id"])
        place, low = rows.rows("xyz"), self.scene.get("bin_z_m")
        if low is not None:
            below = here[place[:, 2] < low]
            self.first_below[below] = np.minimum(self.first_below[below], step)
        film, shares = self.film.copy(), np.zeros(len(self.ids))
        bridges, on_walls = Columns({}), np.zeros(len(self.triangles))
        if self.plan.moist:
            films = self._rows("films", ["step", "id", "film"], step)
            film[np.searchsorted(self.ids, films["id"])] = films["film"]
            ends = [f"{end}_{axis}" for end in ("xi", "xj") for axis in "xyz"]
            names = ["step", "partner_kind", "i", "j", "triangle", "volume", "share_i", "separation", *ends]
            bridges = self._rows("bridges", names, step)
            shares = self._shares(bridges)
            if self.plan.walls:
                wet = self._rows("wall_films", ["step", "triangle", "film"], step)
                on_walls[wet["triangle"]] = wet["film"]
        passed = (self.first_below <= step).astype(int)
        return Moment(self.ids[here], place, rows.rows(("vx", "vy", "vz")), self.radius[here], self.kind[here], film[here],
                      (film + shares)[here], passed[here], bridges, on_walls)  # fmt: skip

    def _shares(self, bridges: Columns) -> Floats:
        """Return the liquid of active bridges assigned to each sphere [m3]."""
        pair, share = bridges["partner_kind"] == 0, bridges["share_i"]
        i, j = (np.searchsorted(self.ids, bridges[end]) for end in "ij")
        rest = (bridges["volume"] - share)[pair]
        return np.bincount(i, share, len(self.ids)) + np.bincount(j[pair], rest, len(self.ids))

    def ages(self, bridges: Table, step: int) -> Floats:
        """Return the time since the formation of bridges active at a step [s], by the event log; NaN if it is not logged."""
        if step <= self._booked:
            self._active, self._booked = none(), -1
            self._streams.pop("events", None)
        names = ["step", "kind", "partner_kind", "i", "j", "volume", "rupture_distance", "speed"]
        stream, _ = self._streams.get("events") or (Rows(io.where(self.folder, "events"), "events", names), -1)
        self._streams["events"] = stream, step
        lives = Lives(self._active, stream.until(step), 0, self._booked)
        self._active, self._booked = lives.active(), step
        formed = np.append(lives.all.step.astype(float), np.nan)
        at = lives.at(keys(bridges), np.full(len(bridges), step), strictly=False)
        return np.asarray((step - formed[at]) * self.scene["time_step_s"])

    def pairs(self, bridges: Table) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """Return whether bridges are at walls, radii (of a wall a dummy, 1) and contact angles of both bodies."""
        wall, i, j = (np.asarray(bridges[name]) for name in ("partner_kind", "i", "j"))
        wall = wall != 0
        angle = {c["type"]: c["contact_angle_rad"] for c in self.scene["classes"]}
        angles = np.array([angle[kind] for kind in self.kind])
        of_mesh = {w["name"]: w["contact_angle_rad"] for w in self.scene["walls"]}
        of_part = dict(zip(self.triangles.get("part", []), self.triangles.get("mesh", []), strict=True))
        at, other = np.searchsorted(self.ids, i), np.searchsorted(self.ids, np.where(wall, self.ids[0], j))
        theirs = [
            of_mesh[of_part[part]] if at_wall else angles[k] for part, at_wall, k in zip(j, wall, other, strict=True)
        ]
        return wall, self.radius[at], np.where(wall, 1.0, self.radius[other]), angles[at], np.array(theirs)

    def pulls(self, bridges: Table) -> Floats | None:
        """Return the capillary force of bridges [N] by the run's law; None if that is no closed form known here."""
        name = self.scene["effects"].get("capillary")
        if name is None:
            return np.zeros(len(bridges))
        if name not in capillary.LAWS:
            return None
        wall, ri, rj, ti, tj = self.pairs(bridges)
        gap, volume = (np.asarray(bridges[name], float) for name in ("separation", "volume"))
        sigma = float(self.scene["liquid"]["surface_tension_N_per_m"])
        return np.asarray(capillary.LAWS[name](gap, volume, ri, rj, wall, ti, tj, sigma))

    @property
    def exact(self) -> bool:
        """Return whether the run's capillary law is the exact bridge."""
        return bool(self.scene["effects"].get("capillary") == EXACT)

    def exact_pulls(self, bridges: Table) -> tuple[Floats, Floats]:
        """Return the force [N] of the exact bridge at the gaps of some bridges, and at touch."""
        wall, ri, rj, ti, tj = self.pairs(bridges)
        sigma = float(self.scene["liquid"]["surface_tension_N_per_m"])
        every = zip(bridges["volume"], ri, np.where(wall, np.inf, rj), ti, tj, strict=True)
        bodies = [tuple(map(float, body)) for body in every]
        gaps = bridges["separation"].tolist()
        pulls = [(exact.force(gap, body), exact.force(0.0, body)) for gap, body in zip(gaps, bodies, strict=True)]
        at_gap, touch = np.array(pulls).T
        return sigma * at_gap, sigma * touch

    def corners(self, step: int) -> Floats:
        """Return the corners (n, 3, 3) of all triangles."""
        at, none = self.rest.copy(), [0.0, 0.0, 0.0]
        if self.poses is not None:
            for number, wall in enumerate(self.scene["walls"]):
                pose, rows = self.poses.at(number, step), (self.triangles["mesh"] == wall["name"]).to_numpy()
                matrix = np.stack([pose[f"turn_{k}"][0] for k in range(3)])
                at[rows] = np.einsum("ij,tcj->tci", matrix, self.rest[rows]) + pose["shift"][0]
            return at
        shift = np.array([self.motion.get((step, mesh), none) for mesh in self.meshes])[self.of_mesh]
        for wall in self.scene["walls"]:
            if wall["motion"] != "turns":
                continue
            rows, how = (self.triangles["mesh"] == wall["name"]).to_numpy(), way_of(self.scene, wall)
            axis, origin = (np.asarray(how[name], float) for name in ("axis", "origin_m"))
            angle = 2.0 * np.pi * step * self.scene["time_step_s"] / how["period_s"]
            turn = scipy.spatial.transform.Rotation.from_rotvec(angle * axis / np.linalg.norm(axis))
            at[rows] = turn.apply((at[rows] - origin).reshape(-1, 3)).reshape(-1, 3, 3) + origin
        return np.asarray(at + shift[:, None, :])
