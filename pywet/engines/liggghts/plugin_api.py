"""ctypes interface of the plugin: passes liquid, laws, transfer tables, walls and films of a scene to it.

ctypes converts Python's integers and booleans to C's int; all other types are converted here.
"""

from __future__ import annotations

import ctypes as C
import math
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.engines.liggghts.border import check_tables
from pywet.engines.liggghts.build import engine_version, plugin_path
from pywet.engines.liggghts.contact_model import continues, touched
from pywet.engines.schedule import SKIPPED, checkpoint_every
from pywet.errors import EngineError, PywetError
from pywet.geometry.analytic_wires import analytic_wire_of
from pywet.geometry.initial import wall_groups
from pywet.laws import registry
from pywet.laws.batch import Batch, batch
from pywet.laws.kinds import FORCES, KINDS
from pywet.scene import WALL_FILMS, EngineScene, Vibration, WallMesh
from pywet.schema import SPHERE

SLOTS = {
    name: tuple(part.slot or name for part in kind.parts)
    for name, kind in KINDS.items()
    if kind.parts and not kind.force
}
"""Kind of law that is no force -> the plugin's slots, in the order of `Law.functions`."""

AT_REST = Vibration(amplitude_m=(0.0, 0.0, 0.0), phase_rad=(0.0, 0.0, 0.0), frequency_Hz=1.0)
"""Motion of an outlet that moves with no wall."""
NEWCOMER = np.dtype([("id", "<i4"), ("type", "<i4"), ("radius", "<f8"), ("mass", "<f8"), ("x", "<f8", 3)])
"""Record of a sphere in a script's engine: number, atom type, radius [m], mass [kg], centre [m]."""


def _doubles(values: Any) -> Any:
    return np.ascontiguousarray(values, dtype=np.float64)


def _ints(values: Any) -> Any:
    return np.ascontiguousarray(values, dtype=np.int32)


def _at(address: int, count: int, kind: np.dtype) -> np.ndarray:
    """Return a view of an array in the plugin's memory."""
    memory: Any = (C.c_char * (count * kind.itemsize)).from_address(address)
    return np.frombuffer(memory, kind)


def _pointer(array: np.ndarray) -> C.c_void_p:
    return C.c_void_p(array.ctypes.data)


class Plugin:
    """The loaded plugin for LIGGGHTS or another engine. The engine's library must already be loaded with RTLD_GLOBAL."""

    def __init__(self, path: Path | None = None, version: str | None = None) -> None:
        self._library = C.CDLL(str(path or plugin_path()), mode=C.RTLD_GLOBAL)
        for name in (
            "pywet_version",
            "pywet_set_law",
            "pywet_add_mesh",
            "pywet_attach",
            "pywet_resume",
            "pywet_resume_script",
            "pywet_create_due",
        ):
            getattr(self._library, name).restype = C.c_char_p
        built_for = self._library.pywet_version().decode()
        installed = version or engine_version()
        if built_for != installed:
            raise EngineError(
                f"the plugin was built for engine {built_for}, {installed} is installed: run `make setup`",
                code="plugin.version", given=built_for, expected=installed,
            )  # fmt: skip
        self._keep: list[Any] = []

    def _check(self, answer: bytes | None) -> None:
        if answer:
            raise PywetError(answer.decode(), code="plugin.refused")

    def configure(
        self, scene: EngineScene, spheres: pd.DataFrame, tables: pd.DataFrame, nodes: dict[str, np.ndarray]
    ) -> None:
        """Pass everything but the logs: liquid, types, laws, transfer tables, walls, films; if dry, analytic wires and feed."""
        check_tables(scene, spheres, tables, nodes)
        liquid, moist = scene.liquid, scene.effects.bridges
        sigma, eta = (liquid.surface_tension_N_per_m, liquid.viscosity_Pa_s) if liquid and moist else (0.0, 0.0)
        self._library.pywet_create(C.c_double(sigma), C.c_double(eta))
        for c in scene.classes:
            self._library.pywet_add_type(C.c_double(c.radius_m), C.c_double(c.contact_angle_rad))
        if moist:
            self._set_laws(scene)
            self._set_transfer(tables)
        films = _doubles(spheres["film"] if moist else np.zeros(len(spheres)))
        groups = wall_groups(scene) if moist and scene.effects.wall_films else {}
        faces = bool(scene.walls) and not touched(scene)
        self._library.pywet_set_wall_film(WALL_FILMS.index(scene.wall_film))
        for k, wall in enumerate(scene.walls):
            if groups or faces or wall.analytic_wires or continues(scene):
                self._add_mesh(wall, nodes[wall.name], groups)
            if wall.analytic_wires:
                self._add_analytic_wires(k, wall, nodes[wall.name])
        ids, types = _ints(spheres["id"]), _ints(spheres["type"])
        self._library.pywet_set_spheres(len(ids), _pointer(ids), _pointer(types), _pointer(films))
        if scene.has_insertion:
            in_order = spheres.sort_values("id")
            numbers, steps = _ints(in_order["id"]), np.array(scene.enters(in_order["type"].tolist()), dtype=np.int64)
            self._library.pywet_set_feed(len(numbers), _pointer(numbers), _pointer(steps))
        gravity, implicit = _doubles(scene.gravity_m_per_s2), scene.viscous_integration == "semi_implicit"
        overlap, every = C.c_double(scene.largest_overlap), C.c_int64(checkpoint_every(scene))
        batched = scene.contacts != "stock" and scene.hertz is None  # batches hold the linear spring alone
        self._library.pywet_set_rules(
            _pointer(gravity), overlap, implicit, every, moist, scene.output.energy, batched, faces
        )
        self._library.pywet_set_impulses(scene.bridges_every)
        if scene.retire:
            self._library.pywet_set_retirement(
                C.c_double(scene.retire_below_m), C.c_double(scene.retire_slower_m_per_s)
            )
        for outlet in scene.outlets:
            low, high = map(_doubles, outlet.ends)
            above = C.c_double(-math.inf if outlet.crossing_above_m is None else outlet.crossing_above_m)
            longest = C.c_double(SKIPPED * checkpoint_every(scene) * scene.time_step_s)
            moves = scene.motions.get(outlet.moves_with or "")
            sway = moves if isinstance(moves, Vibration) else AT_REST
            amplitude, phase = _doubles(sway.amplitude_m), _doubles(sway.phase_rad)
            self._library.pywet_add_outlet(
                _pointer(low), _pointer(high), above, longest,
                _pointer(amplitude), _pointer(phase), C.c_double(2.0 * math.pi * sway.frequency_Hz),
            )  # fmt: skip
        if moist and liquid and (scene.effects.liquid_weight or scene.effects.shedding):
            masses = _doubles([c.mass_kg for c in scene.classes])
            density, every = C.c_double(liquid.density_kg_per_m3), C.c_int64(scene.drop_every)
            self._library.pywet_set_liquid_mass(density, scene.effects.liquid_weight, _pointer(masses), every)

    def set_coming(self, coming: np.ndarray) -> None:
        """Pass the spheres that the engine does not hold yet, as records `COMING` of creation.py."""
        self._library.pywet_set_coming(len(coming), _pointer(coming))

    def create_due(self) -> None:
        """Create the spheres that are due at a checkpoint, before the engine's restart file is written; a collective call."""
        self._check(self._library.pywet_create_due())

    def _set_laws(self, scene: EngineScene) -> None:
        laws = {kind: registry.get(kind, name) for kind, name in scene.effects.laws.items() if KINDS[kind].parts}
        self._keep.append(laws)
        for law in laws.values():
            law.prepare(angle_pairs(scene))
        for first, loop, count in loops(laws, apart=scene.viscous_integration == "semi_implicit"):
            self._keep.append(loop)
            self._library.pywet_add_force_laws(C.c_void_p(loop.address), first, count)
        for kind in SLOTS.keys() & laws.keys():
            for slot, function in zip(SLOTS[kind], laws[kind].functions, strict=True):
                self._check(self._library.pywet_set_law(slot.encode(), C.c_void_p(function.address)))
        prepared = laws["capillary"].functions[0].prepared if "capillary" in laws else None
        if prepared:
            self._library.pywet_set_preparation(C.c_void_p(prepared.compiled.address), prepared.lines)

    def _set_transfer(self, tables: pd.DataFrame) -> None:
        columns = ["partner_kind", "type_i", "type_j", "part_class"]
        for _, rows in tables.groupby(columns):
            kind, type_i, type_j, group = (int(number) for number in rows[columns].iloc[0])
            other = type_j if kind == SPHERE else group
            rows = rows.sort_values("v_star")
            nodes, values = _doubles(rows["v_star"]), _doubles(rows["transfer_i"])
            self._library.pywet_set_transfer(kind, type_i, other, _pointer(nodes), _pointer(values), len(values))

    def _add_mesh(self, wall: WallMesh, nodes: np.ndarray, groups: dict[tuple[float, float], int]) -> None:
        """Pass a mesh to the plugin; without `groups` it has no films, and its parts are omitted."""
        corners, part = _doubles(nodes.reshape(-1, 9)), _ints(wall.triangle_part)
        if len(corners) != len(part):
            raise PywetError(
                f"{wall.stl} holds {len(corners)} triangles, the scene lists parts for {len(part)}: rebuild the scene",
                code="plugin.triangles", key=f"walls.{wall.name}", given=len(corners), expected=len(part),
            )  # fmt: skip
        widths = _doubles([math.inf if w is None else w for w in wall.part_half_width_m])
        group = _ints([groups[(w, wall.contact_angle_rad)] for w in widths] if groups else [])
        parts = len(group), _pointer(widths), _pointer(group), C.c_double(wall.contact_angle_rad)
        mesh = wall.name.encode(), len(part), _pointer(corners), _pointer(part), *parts
        self._check(self._library.pywet_add_mesh(*mesh, 1 if wall.analytic_wires else len(part)))

    def _add_analytic_wires(self, number: int, wall: WallMesh, nodes: np.ndarray) -> None:
        """Register the parts of the last added mesh as analytic wires; `number` is that of the wall in the scene."""
        corners, part = nodes.reshape(-1, 3, 3), np.asarray(wall.triangle_part)
        for p in range(len(wall.part_half_width_m)):
            of_part = np.flatnonzero(part == p)
            analytic_wire = analytic_wire_of(corners[of_part], f"part {p} of wall {wall.name}")
            section, ends = (
                _doubles(analytic_wire.section),
                (C.c_double(analytic_wire.low), C.c_double(analytic_wire.high)),
            )
            first = int(of_part[0])
            self._library.pywet_add_analytic_wire(
                number, first, analytic_wire.axis, *ends, len(section), _pointer(section)
            )

    def set_output(self, steps: Iterable[int], windows: Iterable[tuple[int, int]]) -> None:
        """Set the steps of snapshots and ledger, and half-open windows of steps for the contact log."""
        at = np.ascontiguousarray(sorted(steps), dtype=np.int64)
        first = np.ascontiguousarray([w[0] for w in windows], dtype=np.int64)
        last = np.ascontiguousarray([w[1] for w in windows], dtype=np.int64)
        self._library.pywet_set_output(len(at), _pointer(at), len(first), _pointer(first), _pointer(last))

    def attach(self, engine: C.c_void_p, folder: Path, fix: str = "pywet") -> None:
        """Attach the plugin to the deck's `fix pywet all external pf/callback 1 1`; logs go to `folder`."""
        self._check(self._library.pywet_attach(engine, fix.encode(), os.fsencode(folder)))

    def know_script(self, engine: C.c_void_p, asked: Callable[[bytes], None]) -> Any:
        """Register the fix style `pywet` in the engine; the returned object must live as long as the engine.

        `asked` is called with `line` when the engine reads the fix, `run` before every run, `begin` once the
        first one is set up.
        """
        callback = C.CFUNCTYPE(None, C.c_char_p)(asked)
        self._library.pywet_know_script(engine, callback)
        self._library.pywet_script_state.restype = C.c_char_p
        self._library.pywet_script_words.restype = C.c_char_p
        return callback

    def script_state(self) -> bytes:
        """Read the current state of a script's engine, as JSON."""
        return bytes(self._library.pywet_script_state())

    def script_words(self) -> list[str]:
        """Return the words of the line of fix pywet, after `fix`, with the engine's values of variables."""
        return str(self._library.pywet_script_words().decode(errors="replace")).split("\n")

    def script_spheres(self, count: int) -> np.ndarray:
        """Return the spheres in the engine as records `NEWCOMER`."""
        rows = np.zeros(count, NEWCOMER)
        self._library.pywet_script_spheres(_pointer(rows))
        return rows

    def script_triangles(self, mesh: str, count: int) -> np.ndarray:
        """Return the current corners of a mesh's triangles, (count, 3, 3) [m]."""
        corners = np.zeros((count, 3, 3))
        self._library.pywet_script_triangles(mesh.encode(), _pointer(corners))
        return corners

    def set_script(self, windows: int, enter: Callable[[np.ndarray, int], tuple[np.ndarray, np.ndarray]]) -> None:
        """Log contacts for a number of steps from each output on; `enter` gives types and films of inserted spheres."""

        def asked(n: int, step: int, rows: int, types: int, films: int) -> None:
            kind, film = enter(_at(rows, n, NEWCOMER), step)
            _at(types, n, np.dtype(np.int32))[:] = kind
            _at(films, n, np.dtype(np.float64))[:] = film

        callback = C.CFUNCTYPE(None, C.c_int, C.c_int64, C.c_void_p, C.c_void_p, C.c_void_p)(asked)
        self._keep.append(callback)
        self._library.pywet_set_script(C.c_int64(windows), callback)

    def resume_script(self, count: int) -> None:
        """Resume from the numbers in the engine's restart file; without any, refuse spheres whose films it restored."""
        numbers = np.zeros(count)
        if count:
            self._library.pywet_script_restored(_pointer(numbers))
        self._check(self._library.pywet_resume_script(_pointer(numbers), count))

    def add_classes(self, scene: EngineScene, known: int, tables: pd.DataFrame) -> None:
        """Register new classes of a scene, with the transfer tables of all classes."""
        for c in scene.classes[known:]:
            self._library.pywet_add_type(C.c_double(c.radius_m), C.c_double(c.contact_angle_rad))
        self._set_transfer(tables)

    def set_every(self, steps: int, begin: int, skin: float, thickest: float) -> None:
        """Set output steps of a script and the displacement [m] and film (over the radius) that its neighbour lists cover."""
        none = _pointer(np.zeros(0, dtype=np.int64))
        self._library.pywet_set_output(0, none, 0, none, none)
        self._library.pywet_set_output_every(C.c_int64(steps), C.c_int64(begin))
        self._library.pywet_set_reach(C.c_double(skin), C.c_double(thickest))

    def resume(self, state: Path) -> None:
        """Resume from a checkpoint's state file."""
        self._check(self._library.pywet_resume(os.fsencode(state)))

    def wait(self) -> None:
        """Wait until all MPI ranks have reached this call."""
        self._library.pywet_wait()

    def before_clear(self) -> None:
        """Free what the engine does not free itself when it is emptied: call this before its command `clear`."""
        self._library.pywet_before_clear()

    def held(self) -> dict[str, int]:
        """Count spheres, bridges and wall pairs of the fullest rank and whether contacts are batched; a collective call."""
        names = ("spheres_and_ghosts", "bridges", "wall_pairs", "contacts_in_batches")
        most = (C.c_int64 * len(names))()
        self._library.pywet_held(most)
        return dict(zip(names, most, strict=True))

    def finish(self) -> None:
        """Close the logs and end MPI, as the last call of a worker."""
        self._library.pywet_finish()


def loops(laws: Mapping[str, registry.Law], apart: bool = False) -> list[tuple[int, Batch, int]]:
    """Compile the forces among these laws into as few loops as possible: consecutive ones share intermediate results.

    Each loop is returned with the number of its first value in `LawValues` of the plugin, and with the number of its values.
    With `apart`, for drag that is evaluated twice, each law has a loop of its own; so has a law that cannot be inlined.
    """
    runs: list[tuple[int, list[registry.Law]]] = []
    value = end = 0
    for kind in FORCES:
        if kind in laws:
            if not runs or end != value or apart:
                runs.append((value, []))
            runs[-1][1].append(laws[kind])
            end = value + len(KINDS[kind].parts)
        value += len(KINDS[kind].parts)
    found = []
    for first, group in runs:
        joined = batch(tuple(f for law in group for f in law.functions))
        for some in [group] if joined.inlined else [[law] for law in group]:
            functions = tuple(f for law in some for f in law.functions)
            found.append((first, batch(functions), len(functions)))
            first += len(functions)
    return found


def angle_pairs(scene: EngineScene) -> set[tuple[float, float]]:
    """Return the pairs of contact angles (smaller body, larger body) of all possible bridges [rad]."""
    pairs = {(a.contact_angle_rad, wall.contact_angle_rad) for a in scene.classes for wall in scene.walls}
    for a in scene.classes:
        pairs |= {(a.contact_angle_rad, b.contact_angle_rad) for b in scene.classes if a.radius_m <= b.radius_m}
    return pairs
