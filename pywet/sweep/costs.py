"""Predicted cost of a run of a sweep: for a case as in `pywet plan`, for a scene from its steps and spheres."""

from __future__ import annotations

import math
import resource
from typing import NamedTuple

from pywet.cases.custom.building import Building
from pywet.config import Config
from pywet.cost import cost, needs
from pywet.cost.counts import AT_REST, EVENTS, FILM_BRIDGES, Load


class Cost(NamedTuple):
    """Processor time [s], disk [bytes] and memory [bytes] of one run."""

    seconds: float
    disk_B: float
    memory_B: float = 1e9

    @property
    def known(self) -> bool:
        """Return whether the cost could be predicted."""
        return not math.isnan(self.seconds)


UNKNOWN = Cost(math.nan, math.nan)
"""Cost of a run whose size only the engine knows."""

COLLISION = Cost(2e-3, 2e3)
"""Cost of a collision of one sphere by the compiled integrator: 0.3 to 1 ms, and the file of its results."""
BRIDGE = Cost(0.1, 1e3)
"""Cost of a bridge by the exact solution; closed forms take microseconds."""
FINISHING_S, FINISHING_S_PER_B = 2.0, 3.5e-7
"""Cost of building, results and replay: for the smallest run [s], and per byte of tables [s/B] (scenes of 30 to 260 spheres)."""
FILES_B = 1.8e5
"""Size of the files of every run: log of the engine, surfaces, `replay.json`, summaries."""
LISTS_EVERY = 50
"""Steps between neighbour lists of a moving bed."""


def of_case(config: Config, number: int, scale: str) -> Cost:
    """Return the prediction of `pywet plan` for one run."""
    need = needs.need(config, number, scale, config.settings.ranks)
    return _finished(need.seconds, need.disk_B, need.memory_B, need.load.spheres)


def of_scene(building: Building) -> Cost:
    """Estimate the cost from steps and spheres, as for a bed at rest on this machine; an invalid scene is refused."""
    scene, asked = building.user_scene, building.plan.effects
    spheres, steps = sum(c.count for c in building.classes), scene.duration_s / building.time_step
    bridges = FILM_BRIDGES * spheres if asked.bridges else 0.0
    load = Load(
        steps=steps, lists=steps / LISTS_EVERY, spheres=spheres, touches=AT_REST * spheres, bridges=bridges,
        triangles=sum(len(surface.corners) for surface in building.surfaces), evaluations=bridges * steps,
        events=EVENTS * spheres * scene.duration_s if bridges else 0.0,
    )  # fmt: skip
    machine = cost.measured_here() or needs.stored_machine()
    outputs = scene.duration_s / (scene.results.interval_s or building.interval)
    logged = scene.results.windows * scene.results.window_steps
    disk = needs.EVENT_B * load.events + bridges * (needs.CONTACT_B * logged + needs.SNAPSHOT_BRIDGE_B * outputs)
    disk += spheres * (needs.SNAPSHOT_SPHERE_B * outputs + needs.WINDOW_SPHERE_B * logged)
    memory = needs.RANK_B + needs.SPHERE_B * spheres
    return _finished(machine.start(load) + machine.loop(load), disk, memory, spheres)


def _finished(engine_s: float, tables_B: float, engine_B: float, spheres: float) -> Cost:
    """Return the cost of a run from that of its engine, the size of its tables, and the replay, which follows in one job."""
    memory = max(engine_B, needs.REPLAY_B + needs.REPLAY_SPHERE_B * spheres)
    return Cost(engine_s + FINISHING_S + FINISHING_S_PER_B * tables_B, tables_B + FILES_B, memory)


def used_s() -> float:
    """Return the processor time of this process and of its finished child processes [s]."""
    used = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(u.ru_utime + u.ru_stime for u in used)
