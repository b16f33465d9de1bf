"""Runs a script with liquid in this process: the engine reads it by itself, at the line of fix pywet the plugin is set up.

An error of the engine ends the process, as it ends the stock program.
"""

from __future__ import annotations

import ctypes as C
import json
import math
import os
import signal
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.cases.script.refusals import of_state, refusal
from pywet.cases.script.scan import Found, scan
from pywet.cases.script.wet import Wet
from pywet.engines.liggghts.deck import FILM_GROWTH
from pywet.engines.liggghts.inputs import prepare_laws, transfer_tables
from pywet.engines.liggghts.plugin_api import Plugin
from pywet.engines.liggghts.worker import LIBRARY, LINE_BUFFERED
from pywet.errors import border
from pywet.laws.contact import film_thickness
from pywet.runs import tables
from pywet.scene import Liquid, Output, Scene, SphereClass
from pywet.util.files import read_table

KINDS = 32
"""Kinds of spheres: each pair of them has a table."""
LEAST_SKIN = 0.1
"""Way of a sphere, over the least radius, that the neighbour list has to leave in addition to films."""


@dataclass(frozen=True)
class Outcome:
    """Result of a script: folder of its tables, bridges formed and ruptured, error of its ledger."""

    log: Path
    formed: int
    ruptured: int
    ledger_error: float


def run(path: Path, words: list[str], say: Callable[[str], None]) -> Outcome:
    """Run the script; `words` for the engine's command line, such as -var and -log."""
    found = scan(path)
    if found.problems:
        raise found.problems[0]
    for stop in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(stop, signal.SIG_DFL)  # in the engine no Python answers
    library = C.CDLL(LIBRARY, mode=C.RTLD_GLOBAL)
    libc = C.CDLL(None)
    libc.setvbuf(C.c_void_p.in_dll(libc, "stdout"), None, LINE_BUFFERED, 0)
    engine, given = C.c_void_p(), [b"pywet", *(word.encode() for word in words)]
    plugin = Plugin()
    library.lammps_open_no_mpi(len(given), (C.c_char_p * len(given))(*given), C.byref(engine))
    script = _Script(found, plugin, engine)

    def asked(what: bytes) -> None:
        """Called by the engine, through which no exception can pass: a refusal ends the process, its tables written."""
        try:
            with border(say=say):
                script.begin() if what else script.check()
        except SystemExit as end:
            try:
                plugin.finish()
                if script.time_step:
                    collect(found.line.log)
            finally:
                libc.fflush(None)
                os._exit(int(end.code or 0))

    asked_by_engine = plugin.know_script(engine, asked)
    library.lammps_file(engine, str(path).encode())
    library.lammps_close(engine)
    plugin.finish()
    del asked_by_engine
    if not script.time_step:
        raise refusal("wet.no_line", str(path))
    return collect(found.line.log)


def collect(log: Path) -> Outcome:
    """Turn the raw logs into tables; the raw ones go."""
    tables.convert(log, log)
    for raw in log.glob("*.bin"):
        raw.unlink()
    last = read_table(log / "ledger.parquet")
    formed, ruptured = (int(last[name].max()) if len(last) else 0 for name in ("formations", "ruptures"))
    return Outcome(log, formed, ruptured, tables.ledger_error(last) if len(last) else math.nan)


class _Script:
    """State of a LIGGGHTS script while its lines are executed."""

    def __init__(self, found: Found, plugin: Plugin, engine: C.c_void_p) -> None:
        self.wet, self.line = found.wet, found.line
        self._plugin, self._engine = plugin, engine
        self.time_step = 0.0

    def _refuse(self, state: dict[str, Any]) -> None:
        for problem in of_state(state, self.wet.walls == "dry"):
            raise problem

    def begin(self) -> None:
        """The engine has come to the line."""
        state = json.loads(self._plugin.script_state())
        self._refuse(state)
        scene, spheres = scene_of(self.wet, state, self._plugin.script_spheres(int(state["spheres"])))
        skin, thickest = reach(scene, spheres, float(state["skin"]))
        log = self.line.log.resolve()
        if log.exists() and any(log.iterdir()):
            raise refusal("wet.log", str(self.line.log))
        log.mkdir(parents=True, exist_ok=True)
        prepare_laws(scene)
        self._plugin.configure(scene, spheres, transfer_tables(scene), {})
        self._plugin.set_every(self.line.every, int(state["step"]), skin, thickest)
        self._plugin.attach(self._engine, log, self.line.name)
        self.time_step = scene.time_step_s

    def check(self) -> None:
        """Check at the start of a `run` that the script still fits the liquid's settings."""
        state = json.loads(self._plugin.script_state())
        self._refuse(state)
        if state["time_step"] != self.time_step:
            raise refusal("wet.time_step", state["time_step"], self.time_step)
        if state["last"] not in (-1, state["step"]):
            raise refusal("wet.step", state["step"], state["last"])


def scene_of(wet: Wet, state: dict[str, Any], spheres: pd.DataFrame) -> tuple[Scene, pd.DataFrame]:
    """Scene and spheres as the plugin wants them; a class for each type, radius and density that there are.

    Dry contacts, walls and motion stay the script's own: the scene has none, and is not checked as a whole.
    """
    ids = np.sort(spheres["id"].to_numpy())
    if not np.array_equal(ids, np.arange(1, len(ids) + 1)):
        raise refusal("wet.ids")
    density = spheres["mass"] / (4.0 / 3.0 * math.pi * spheres["radius"] ** 3)
    kinds = spheres.assign(density=[float(f"{d:.9g}") for d in density]).groupby(["type", "radius", "density"])
    if kinds.ngroups > KINDS:
        raise refusal("wet.sizes", kinds.ngroups)
    classes = []
    for k, (_, rows) in enumerate(kinds):
        atom_type, radius, of_volume = (rows[name].iloc[0] for name in ("type", "radius", "density"))
        angle = wet.angle_deg(int(atom_type))
        if angle is None:
            raise refusal("wet.angle", int(atom_type))
        classes.append(
            SphereClass(
                name=f"type {atom_type}, {2e3 * radius:.6g} mm", type=k + 1, radius_m=radius, count=len(rows),
                density_kg_per_m3=of_volume, contact_angle_rad=math.radians(angle),
            )
        )  # fmt: skip
    films = [wet.film_m3(mass, radius) for mass, radius in zip(spheres["mass"], spheres["radius"], strict=True)]
    liquid = wet.liquid
    scene = Scene.model_construct(
        name="script", seed=0, classes=tuple(classes), pairs=(), walls=(), vibration=None, slide=None, effects=wet.effects,
        liquid=Liquid(
            surface_tension_N_per_m=liquid.surface_tension_N_per_m, viscosity_Pa_s=liquid.viscosity_Pa_s,
            density_kg_per_m3=liquid.density_kg_per_m3, initial_film_thickness_m=0.0,
        ),
        viscous_integration=wet.viscous_integration, contacts="stock", time_step_s=float(state["time_step"]), duration_s=1.0,
        gravity_m_per_s2=(0.0, 0.0, 0.0),
        output=Output(interval_s=1.0, contact_windows=0, energy=False),
    )  # fmt: skip
    return scene, pd.DataFrame(
        {"id": spheres["id"], "type": kinds.ngroup() + 1, "radius": spheres["radius"], "film": films}
    )


def reach(scene: Scene, spheres: pd.DataFrame, skin: float) -> tuple[float, float]:
    """How the skin of the script is shared: what is left for the ways of spheres [m], films that it sees, over the radius.

    Films may grow as in a scene; where the skin has more to give they get half of it. Without liquid all is left for ways.
    """
    radius = spheres["radius"].to_numpy()
    first = float((film_thickness(spheres["film"].to_numpy(), radius) / radius).max())
    if first == 0.0:
        return skin, 0.0
    most, least = 2.0 * float(radius.max()), LEAST_SKIN * float(radius.min())
    needed = FILM_GROWTH * first * most + least
    if skin < needed:
        raise refusal("wet.skin", skin, f"{math.ceil(1e6 * needed) / 1e6:g}")
    films = min(max(needed - least, 0.5 * skin), skin - least)
    return skin - films, films / most
