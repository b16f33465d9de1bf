"""Read a run directory: scene, tables, JSON files, and the liquid and position of every sphere at every output step.

It only reads, each file once; `cases/screening/results.py` computes from it. The liquid of a sphere is its film and
its part of every active bridge, shared as if the bridge ruptured at that time (Elskamp & Kruggel-Emden 2018, sections 4
and 5.3).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pywet import run_folder
from pywet.errors import PywetError
from pywet.runs.shapes import Plan, Replay, RunSummary
from pywet.scene import SCRIPTED, EngineScene
from pywet.schema import FORMATION, INTEGER, NUMBER, SPHERE, TABLES
from pywet.util.files import AGAIN, fit, read_if_there, read_json, read_parts, read_table

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]
READ_WHOLE_B = 16_000_000
"""Size of the file of a table up to which it is read once for all steps."""


def bridge_ends(table: pd.DataFrame) -> Ints:
    """Return one number for the ends of each row's bridge."""
    kind, i, j = (table[name].to_numpy(dtype=np.int64) for name in ("partner_kind", "i", "j"))
    return np.asarray((kind << 60) | (i << 30) | j)


def rows_at(table: pd.DataFrame, step: int) -> pd.DataFrame:
    """Return the rows of a table at one step: a slice, without a copy, if the table is sorted by step."""
    steps = table["step"].to_numpy()
    if not pd.Index(steps).is_monotonic_increasing:
        return table[steps == step]
    return table.iloc[np.searchsorted(steps, step) : np.searchsorted(steps, step, side="right")]


def placed(at: Any, origin_mm: Sequence[float]) -> str:
    """A position [m] of the engine as a message gives it: in the scene's coordinates, mm.

    >>> placed((0.0015, 0.0, 0.0123456), (0, 0, 0)), placed((0.0015, 0.0, 0.0), (1e6, 0, 0))
    ('1.5, 0, 12.35', '1000001.5, 0, 0')
    """
    return ", ".join(
        f"{round(1e3 * x + o, 3):.12g}" if o else f"{1e3 * x:.4g}" for x, o in zip(at, origin_mm, strict=True)
    )


@dataclass(frozen=True)
class RunDir:
    """One run directory `results/<scale>/<case>/`; tables are read on first use and cached."""

    path: Path

    @cached_property
    def scene(self) -> EngineScene:
        path = self.path / "scene.json"
        if not path.exists():
            raise PywetError(run_folder.no_run(self.path), code="run.no_scene", where=self.path)
        return EngineScene.read(path)

    @cached_property
    def origin_mm(self) -> tuple[float, float, float]:
        """Return the user-defined scene's `origin_mm`, to which positions of the engine and of the tables are relative."""
        x, y, z = self.description.get("origin_mm", (0.0, 0.0, 0.0))
        return x, y, z

    @property
    def origin_m(self) -> Floats:
        """Return the origin of the scene [m], to be added to the positions in tables."""
        return 1e-3 * np.array(self.origin_mm, dtype=float)

    @property
    def moist(self) -> bool:
        """Return whether bridges were simulated, so that the liquid tables exist."""
        return self.scene.effects.bridges

    def table(self, name: str) -> pd.DataFrame:
        """Return a Parquet table by its path without suffix, such as `history/films`."""
        return read_table(self._there(name))

    def _there(self, name: str) -> Path:
        path = self.path / f"{name}.parquet"
        if not path.exists():
            raise PywetError(
                f"no {name}.parquet in {self.path}; expected a finished run: run the case again",
                code="run.no_table", key=name, where=self.path,
            )  # fmt: skip
        return path

    def table_if_there(self, name: str) -> pd.DataFrame | None:
        """Return `table`, or None without such a file."""
        path = self.path / f"{name}.parquet"
        return read_table(path) if path.exists() else None

    def json(self, name: str, shape: Any, required: bool = False) -> Any:
        """Return a JSON file by its path with suffix, checked against the type `shape`; None if missing, unless `required`."""
        if self._content.get(name) is None:
            self._content[name] = (read_json if required else read_if_there)(self.path / name, AGAIN)
        if self._content[name] is not None:
            fit(shape, self._content[name], self.path / name, AGAIN)
        return self._content[name]

    @cached_property
    def _content(self) -> dict[str, Any]:
        return {}

    @property
    def summary(self) -> dict[str, Any] | None:
        """Return summary.json; None before the stage results."""
        return self.json("summary.json", RunSummary)  # type: ignore[no-any-return]

    @property
    def replay(self) -> dict[str, Any] | None:
        """Return replay.json; None if nothing was replayed."""
        return self.json("replay.json", Replay)  # type: ignore[no-any-return]

    @property
    def plan(self) -> dict[str, Any] | None:
        """Return plan.json: every effect, whether it is on, and why."""
        return self.json("plan.json", Plan)  # type: ignore[no-any-return]

    @property
    def description(self) -> dict[str, Any]:
        """Return the description of a user-defined scene; empty for any other."""
        return self.json("description.json", dict[str, Any]) or {}

    @cached_property
    def trajectory(self) -> pd.DataFrame:
        """Return trajectory.parquet, sorted by step and id."""
        return self.table("trajectory").sort_values(["step", "id"], ignore_index=True)

    @cached_property
    def spheres(self) -> pd.DataFrame:
        """Return history/spheres.parquet: id, type, radius, film at the start, sorted by id."""
        return self.table("history/spheres").sort_values("id", ignore_index=True)

    @cached_property
    def enters(self) -> Ints:
        """Return the step at which each sphere enters, in the order of ids; in a run that ended before, it has not entered."""
        scripted = self.scene.name == SCRIPTED
        steps = self.spheres["enters"] if scripted else self.scene.enters(self.spheres["type"].tolist())
        return np.asarray(steps, dtype=np.int64)

    @cached_property
    def triangles(self) -> pd.DataFrame:
        """Return history/triangles.parquet, sorted by triangle number; empty for a scene without walls and its file."""
        if not self.scene.walls:
            kinds = {INTEGER: "int64", NUMBER: "float64"}
            columns = TABLES["history/triangles"].items()
            return pd.DataFrame({name: pd.Series(dtype=kinds.get(holds, "object")) for name, holds in columns})
        table = self.table("history/triangles").sort_values("triangle", ignore_index=True)
        if unknown := sorted(map(str, set(table["mesh"]) - {w.name for w in self.scene.walls})):
            raise PywetError(
                f"{self.path}: history/triangles.parquet has triangles of {', '.join(unknown)}, expected the walls of "
                "scene.json; run the case again",
                code="run.walls", where=self.path,
            )  # fmt: skip
        return table

    @cached_property
    def mesh_motion(self) -> pd.DataFrame:
        """Return the translation of each mesh at the output steps: step, mesh, dx, dy, dz [m]."""
        table = self.table("mesh_motion")
        if table.duplicated(["step", "mesh"]).any():
            raise PywetError(
                f"{self.path}: mesh_motion.parquet holds a step of a mesh twice; run the case again",
                code="run.motion_twice", where=self.path,
            )  # fmt: skip
        return table

    @cached_property
    def poses(self) -> pd.DataFrame:
        """Return history/poses.parquet of a script's run: the position of each mesh (by number) at the logged steps."""
        return self.table("history/poses")

    def parts(self, name: str, columns: Sequence[str]) -> Iterator[pd.DataFrame]:
        """Read some columns of a table that exceeds the memory, chunk by chunk."""
        return read_parts(self._there(name), columns)

    def at_step(self, name: str, step: int) -> pd.DataFrame:
        """Return the rows of such a table at one step; a small table is read once."""
        path = self._there(name)
        if path.stat().st_size > READ_WHOLE_B:
            return read_table(path, step=step)
        if name not in self._small:
            self._small[name] = self.table(name)
        return rows_at(self._small[name], step).reset_index(drop=True)

    @cached_property
    def _small(self) -> dict[str, pd.DataFrame]:
        return {}

    @cached_property
    def reservoirs(self) -> tuple[Any, Any]:
        """Return the number of each triangle's reservoir, in order of appearance, and the reservoirs' names."""
        return pd.factorize(self.triangles["reservoir"])

    @cached_property
    def corners_at_rest(self) -> Floats:
        """Return the corners of all triangles where walls are at the start [m], shape (triangles, 3, 3)."""
        names = [f"v{n}_{axis}" for n in range(3) for axis in "xyz"]
        return self.triangles[names].to_numpy(dtype=float).reshape(-1, 3, 3)

    @cached_property
    def meshes(self) -> NDArray[np.object_]:
        """Return the mesh of each triangle."""
        return self.triangles["mesh"].to_numpy(dtype=object)

    @cached_property
    def contact_angles(self) -> tuple[Floats, Floats]:
        """Return the contact angles of all spheres, in the order of ids, and of all parts of walls, by their number [rad]."""
        of_type = {c.type: c.contact_angle_rad for c in self.scene.classes}
        of_mesh = {wall.name: wall.contact_angle_rad for wall in self.scene.walls}
        parts = self.triangles["part"].to_numpy(dtype=np.int64)
        of_parts = np.full(int(parts.max(initial=-1)) + 1, np.nan)
        of_parts[parts] = [of_mesh[mesh] for mesh in self.meshes]
        return np.array([of_type[kind] for kind in self.spheres["type"]]), of_parts

    @cached_property
    def ledger(self) -> pd.DataFrame:
        """Return history/ledger.parquet of a moist run: liquid by reservoir at each output [m3]."""
        return self.table("history/ledger")

    @cached_property
    def wall_films(self) -> pd.DataFrame:
        """Return the wet triangles at the output steps, with their reservoir."""
        films = self.table("history/wall_films")
        return films.assign(reservoir=self.reservoirs_of(films["triangle"].to_numpy()))

    def on_walls(self, names: Mapping[str, str], of: str) -> pd.DataFrame:
        """Return the liquid on walls at the output steps [m3], films and their share of active bridges.

        `names`: reservoir or mesh, according to `of` -> the column in which it is counted. A dry run has
        none.
        """
        steps, columns = pd.Index(self.timeline.steps, name="step"), list(dict.fromkeys(names.values()))
        if not self.moist or not names:
            return pd.DataFrame(0.0, index=steps, columns=columns)
        of_bridges = ["step", "partner_kind", "triangle", "volume", "share_i"]
        parts = [part[part["partner_kind"] != SPHERE] for part in self.parts("history/bridges", of_bridges)]
        bridges = pd.concat(parts) if parts else pd.DataFrame({name: np.zeros(0) for name in of_bridges})
        films = self.table("history/wall_films").rename(columns={"film": "volume"})
        held = pd.concat([films, bridges.assign(volume=bridges["volume"] - bridges["share_i"])], ignore_index=True)
        where = pd.Series(self.reservoirs_of(held["triangle"].to_numpy(), of), index=held.index).map(names)
        sums = held.assign(where=where).pivot_table(index="step", columns="where", values="volume", aggfunc="sum")
        return sums.reindex(index=steps, columns=columns).fillna(0.0)

    def ledger_at(self, name: str) -> Floats:
        """Return one column of the ledger at the output steps [m3]; zero for a dry run."""
        if not self.moist:
            return np.zeros(len(self.timeline.steps))
        ledger = self.ledger.drop_duplicates("step", keep="last").set_index("step")[name]
        return np.asarray(ledger.reindex(self.timeline.steps).fillna(0.0), dtype=float)

    @cached_property
    def formations(self) -> tuple[Ints, Ints, int]:
        """Return the sorted ends of bridges, position * span + step of every formation (sorted), and the span [steps]."""
        parts = self.parts("history/events", ["step", "kind", "partner_kind", "i", "j"])
        log = pd.concat([part[part["kind"] == FORMATION] for part in parts])
        names, place = np.unique(bridge_ends(log), return_inverse=True)
        span = self.scene.steps + 1
        return names, np.sort(place * span + log["step"].to_numpy(dtype=np.int64)), span

    def reservoirs_of(self, triangle: Ints, of: str = "reservoir") -> NDArray[np.object_]:
        """Return the reservoir, or `mesh`, of each triangle number."""
        known, wanted = np.asarray(self.triangles[of], dtype=object), np.asarray(triangle, dtype=np.int64)
        if len(wanted) and not 0 <= wanted.min() <= wanted.max() < len(known):
            raise PywetError(
                f"{self.path}: the liquid is on triangles that history/triangles.parquet does not have; run the case again",
                code="run.triangles", where=self.path,
            )  # fmt: skip
        return known[wanted]

    @cached_property
    def timeline(self) -> Timeline:
        """Return position and liquid of every sphere at every output step."""
        return Timeline.read(self)


@dataclass(frozen=True)
class Timeline:
    """Arrays over S output steps and N spheres (spheres in the order of ids)."""

    steps: Ints
    times: Floats
    """Time of each output [s], shape (S,)."""
    ids: Ints
    types: Ints
    mass: Floats
    """Dry mass of each sphere [kg], shape (N,)."""
    present: Bools
    """Whether a sphere is in the simulated box, shape (S, N)."""
    passed: Bools
    """Whether a sphere is in the collecting bin, shape (S, N).

    Its centre was below the scene's `bin_z_m` at this output or before.
    """
    came_back: int
    """Number of spheres that rose above `bin_z_m` again after they had passed (they still count as passed)."""
    film: Floats
    """Liquid in the film [m3], shape (S, N)."""
    in_bridges: Floats
    """Share of the sphere in its active bridges [m3], shape (S, N)."""
    initial_film: Floats
    """Film at the start [m3], shape (N,)."""
    entered: Bools
    """Whether a sphere has entered, shape (S, N); false only before insertion."""

    @property
    def put_in(self) -> Floats:
        """Return the liquid that has entered until each output [m3], shape (S,)."""
        return np.where(self.entered, self.initial_film, 0.0).sum(axis=1)

    @property
    def entered_by_end(self) -> Bools:
        """Return whether a sphere has entered by the last output, shape (N,); of a run that ended early not all have."""
        return np.asarray(self.entered[-1])

    @property
    def liquid(self) -> Floats:
        """Return the liquid of each sphere: film and share of active bridges [m3], shape (S, N)."""
        return self.film + self.in_bridges

    @classmethod
    def read(cls, run: RunDir) -> Timeline:
        spheres, scene = run.spheres, run.scene
        trajectory = pd.concat(list(run.parts("trajectory", ["step", "id", "z"])), ignore_index=True)
        ids = spheres["id"].to_numpy(dtype=np.int64)
        steps = np.unique(trajectory["step"].to_numpy(dtype=np.int64))
        if scene.outlets:  # of an output after which nobody is left the trajectory has no row
            steps = np.array(scene.output_steps, dtype=np.int64)
        row = np.searchsorted(steps, trajectory["step"].to_numpy())
        column = _index(ids, trajectory["id"].to_numpy(), "trajectory.parquet")
        z = np.full((len(steps), len(ids)), np.nan)
        z[row, column] = trajectory["z"].to_numpy()
        present = np.isfinite(z)
        types = spheres["type"].to_numpy(dtype=np.int64)
        if not set(types) <= {c.type for c in scene.classes}:
            raise PywetError(
                f"{run.path}: history/spheres.parquet names types of spheres that scene.json does not have; "
                "run the case again",
                code="run.types", where=run.path,
            )  # fmt: skip
        entered = steps[:, None] >= run.enters
        below = (z < scene.bin_z_m) & entered
        passed = np.logical_or.accumulate(below, axis=0)
        initial = spheres["film"].to_numpy(dtype=float) if "film" in spheres else np.zeros(len(ids))
        film, shares = _liquid(run, steps, ids, initial)
        return cls(
            steps=steps,
            times=steps * scene.time_step_s,
            ids=ids,
            types=types,
            mass=np.array([c.mass_kg for c in scene.classes])[types - 1],
            present=present,
            passed=passed,
            came_back=int((passed & ~below & present).any(axis=0).sum()),
            film=film,
            in_bridges=shares,
            initial_film=initial,
            entered=entered,
        )


def _index(ids: Ints, wanted: Ints, where: str) -> Ints:
    """Return the position of each wanted id in the sorted ids."""
    position = np.minimum(np.searchsorted(ids, wanted), len(ids) - 1)
    if not np.array_equal(ids[position], wanted):
        raise PywetError(
            f"{where} names spheres that history/spheres.parquet does not have; run the case again", code="run.spheres"
        )
    return position


def _liquid(run: RunDir, steps: Ints, ids: Ints, initial: Floats) -> tuple[Floats, Floats]:
    """Return film and bridge share of each sphere at each output; without bridges the films are constant."""
    shares = np.zeros((len(steps), len(ids)))
    if not run.moist:
        return np.tile(initial, (len(steps), 1)), shares
    film = np.zeros((len(steps), len(ids)))
    for films in run.parts("history/films", ["step", "id", "film"]):
        films = films[films["step"].isin(steps)]
        column = _index(ids, films["id"].to_numpy(), "history/films.parquet")
        film[np.searchsorted(steps, films["step"].to_numpy()), column] = films["film"]
    for bridges in run.parts("history/bridges", ["step", "partner_kind", "i", "j", "volume", "share_i"]):
        bridges = bridges[bridges["step"].isin(steps)]
        row, volume, share = (bridges[c].to_numpy() for c in ("step", "volume", "share_i"))
        row = np.searchsorted(steps, row)
        np.add.at(shares, (row, _index(ids, bridges["i"].to_numpy(), "history/bridges.parquet")), share)
        pair = bridges["partner_kind"].to_numpy() == SPHERE
        other = _index(ids, bridges["j"].to_numpy()[pair], "history/bridges.parquet")
        np.add.at(shares, (row[pair], other), (volume - share)[pair])
    return film, shares
