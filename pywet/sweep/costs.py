"""Predicted cost of a run of a sweep: for a case as in `pywet plan`, for a scene from its steps and spheres."""

from __future__ import annotations

import math
import resource
from typing import NamedTuple

import numpy as np

from pywet.cases.custom.building import Building
from pywet.cases.custom.feeding import times
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
LENGTHS = 2.0
"""Time for which a sphere stays on a deck that throws it, over the deck's length by the peak speed of its stroke: an assumption.

On the strip of docs/screens.md ("From a batch to a deck") the mean is 0.95, 0.45 s on 119 mm at 0.25 m/s; twice that, since
moist, crowded or gently shaken material is slower. A blocked deck holds spheres for longer.
"""


def of_case(config: Config, number: int, scale: str) -> Cost:
    """Return the prediction of `pywet plan` for one run."""
    need = needs.need(config, number, scale, config.settings.ranks)
    return _finished(need.seconds, need.disk_B, need.memory_B, need.load.spheres)


def of_scene(building: Building) -> Cost:
    """Estimate the cost from steps and spheres, as for a bed at rest on this machine; an invalid scene is refused.

    Time and tables are those of the spheres that are present on average, memory that of all spheres.
    """
    scene, asked = building.user_scene, building.plan.effects
    (spheres, entered), steps = present(building), scene.duration_s / building.time_step
    bridges = FILM_BRIDGES * entered if asked.bridges else 0.0
    load = Load(
        steps=steps, lists=steps / LISTS_EVERY, spheres=spheres, touches=AT_REST * entered, bridges=bridges,
        triangles=sum(len(surface.corners) for surface in building.surfaces), evaluations=bridges * steps,
        events=EVENTS * entered * scene.duration_s if bridges else 0.0,
    )  # fmt: skip
    machine = cost.measured_here() or needs.stored_machine()
    outputs = scene.duration_s / (scene.results.interval_s or building.interval)
    logged = scene.results.windows * scene.results.window_steps
    disk = needs.EVENT_B * load.events + bridges * (needs.CONTACT_B * logged + needs.SNAPSHOT_BRIDGE_B * outputs)
    disk += spheres * (needs.SNAPSHOT_SPHERE_B * outputs + needs.WINDOW_SPHERE_B * logged)
    most = sum(c.count for c in building.classes)
    memory = needs.RANK_B + needs.SPHERE_B * most
    return _finished(machine.start(load) + machine.loop(load), disk, memory, most)


def present(building: Building) -> tuple[float, float]:
    """Return the mean numbers of spheres in the engine, and of those that have entered, over the duration of a scene."""
    end, stay = building.user_scene.duration_s, _stay_s(building)
    held = entered = 0.0
    for c in building.classes:
        at = np.array(times(c) or np.zeros(c.count))
        out = np.minimum(at + (stay if c.insertion else math.inf), end)
        held += float((out - np.maximum(at - (building.ahead_s or math.inf), 0.0)).sum())
        entered += float((out - at).sum())
    return max(held / end, 1.0), entered / end


def _stay_s(building: Building) -> float:
    """Return the time [s] from the entry of a sphere to its removal at an outlet; to the end if that cannot be estimated."""
    deck = building.deck
    if deck is None or deck.acceleration_ratio <= 1.0:
        return math.inf
    speed = 2e-3 * math.pi * deck.stroke.frequency_Hz * deck.stroke.amplitude_mm
    return LENGTHS * 1e-3 * deck.length_mm / speed


def _finished(engine_s: float, tables_B: float, engine_B: float, spheres: float) -> Cost:
    """Return the cost of a run from that of its engine, the size of its tables, and the replay, which follows in one job."""
    memory = max(engine_B, needs.REPLAY_B + needs.REPLAY_SPHERE_B * spheres)
    return Cost(engine_s + FINISHING_S + FINISHING_S_PER_B * tables_B, tables_B + FILES_B, memory)


def used_s() -> float:
    """Return the processor time of this process and of its finished child processes [s]."""
    used = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(u.ru_utime + u.ru_stime for u in used)
