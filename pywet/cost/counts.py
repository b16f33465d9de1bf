"""Operation counts of a screening run: steps, neighbour lists, spheres in contact or near wires, bridges.

All counts follow from the scene before it is run, none from a fit to a case. In the feed bin and in the collecting
bin spheres rest on each other; on the screen they fly, and touch only during collisions. The number remaining follows
from the probability that a sphere passes an opening (Gaudin, Principles of Mineral Dressing, 1939: (1 - d/a)^2 times
the open area fraction), with one attempt per stroke for the lowest layer.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pywet.cases.screening import cases
from pywet.config import Config
from pywet.engines.liggghts import deck
from pywet.geometry import Apparatus, ApparatusSpec, build_apparatus
from pywet.geometry.motion import peak_speed
from pywet.planning import step_choice
from pywet.planning.surroundings import GRAVITY
from pywet.scene import EngineScene

Floats = NDArray[np.float64]
AT_REST = 2.25
"""Contacts per sphere in a heap at rest: two pairs, since the isostatic number of spheres with friction is four each, and a
quarter for those next to floor and walls (heaps of some five layers in a bin of 200 mm)."""
COLLISIONS = 4.0
"""Collisions of a sphere per stroke on the screen: 210 1/s in a full-scale run (case 1, 50.6 strokes a second)."""
SETTLING = 1.5
"""Time [s] after which a sphere in the collecting bin is no longer agitated by impacts of others (the same run)."""
DENSE = 0.4
"""Solid fraction of the feed on the vibrating screen at the start; as it empties, the bed retains its height (the same run)."""
FILM_BRIDGES = 2.6
"""Bridges per sphere: 2.5 to 2.8 in settled full-scale beds, 2.5 to 2.6 on average in whole runs of the accuracy study."""
EVENTS = 80.0
"""Formations and ruptures of bridges per second and sphere that has not passed; those in the bin are negligible."""
HOP = 3.0
"""Speed of the fastest sphere on the screen over the screen's peak speed: 0.83 m/s in that run after the last passage."""
INSTANTS = 2000


@dataclass(frozen=True)
class Load:
    """Operations of a run; counts are means over the run."""

    steps: float
    lists: float
    spheres: float
    triangles: float = 0.0
    """Triangles of wires that are meshes."""
    near: float = 0.0
    """Pairs of a sphere and a wire that is near enough to be checked in every step."""
    touches: float = 0.0
    """Contacts of spheres with each other, and with floor and walls on which they rest."""
    bridges: float = 0.0
    evaluations: float = 0.0
    """Bridges whose forces are evaluated, over the whole run."""
    events: float = 0.0
    """Formations and ruptures, over the whole run."""
    analytic_wires: bool = False


def load_of(config: Config, case: int, scale: str) -> Load:
    """Predict the operation counts of a case from its configuration alone, in a tenth of a second."""
    row, size = config.case(case), config.scale(scale)
    spec = cases.apparatus_spec(config, row, size)
    apparatus = build_apparatus(spec)
    scene = cases.assemble(config, row, size, cases.ingredients(config, case, scale), apparatus)
    steps = scene.duration_s / scene.time_step_s
    time = (np.arange(INSTANTS) + 0.5) / INSTANTS * scene.duration_s
    on_screen = staying(scene, spec, time)
    spheres = sum(c.count for c in scene.classes)
    bridges = FILM_BRIDGES * spheres if scene.effects.bridges else 0.0
    analytic_wires = any(w.analytic_wires for w in scene.walls)
    wires = next(w for w in scene.walls if w.reservoir == "wires")
    return Load(
        steps=steps,
        lists=float(scene.duration_s * np.mean(list_rate(scene, apparatus, time, on_screen.sum(axis=1)))),
        spheres=spheres,
        triangles=0.0 if analytic_wires else len(wires.triangle_part),
        near=float(np.mean(on_screen, axis=0) @ near_wires(scene, spec)),
        touches=float(np.mean(touching(scene, time, on_screen.sum(axis=1)))),
        bridges=bridges,
        evaluations=steps / scene.bridges_every * bridges,
        events=EVENTS * scene.duration_s * float(np.mean(on_screen.sum(axis=1))) if bridges else 0.0,
        analytic_wires=analytic_wires,
    )


def staying(scene: EngineScene, spec: ApparatusSpec, time: Floats) -> Floats:
    """Return the number of spheres of each class not yet passed, shape (times, classes), including those in the feed bin."""
    assert scene.slide is not None and scene.vibration is not None
    counts = np.array([float(c.count) for c in scene.classes])
    width = 2.0 * np.array([c.radius_m for c in scene.classes])
    aperture, pitch = spec.aperture_m, spec.aperture_m + spec.wire_diameter_m
    passage = np.clip(1.0 - width / aperture, 0.0, None) ** 2 * (aperture / pitch) ** 2
    left, step = [], scene.duration_s / len(time)
    for t in time:
        if t > scene.slide.opens_at_s:
            layers = max(1.0, float(counts @ width**2) / area(spec))
            counts = counts * np.exp(-scene.vibration.frequency_Hz * step / layers * passage)
        left.append(counts)
    return np.array(left)


def area(spec: ApparatusSpec) -> float:
    """Return the area [m2] of the screen."""
    return spec.width_m**2 * (1.0 if spec.shape == "square" else 0.25 * math.pi)


def touching(scene: EngineScene, time: Floats, on_screen: Floats) -> Floats:
    """Estimate the number of dry contacts at each time of a screening case."""
    assert scene.slide is not None and scene.vibration is not None
    spheres, opens = sum(c.count for c in scene.classes), scene.slide.opens_at_s
    least = min(step_choice.collision_time(p, scene.classes) for p in scene.pairs)
    hopping = min(AT_REST, COLLISIONS * scene.vibration.frequency_Hz * least)
    fall = math.sqrt(2.0 * (scene.box_high_m[2] - scene.screen_z_m) / GRAVITY)
    at_rest = np.where(time < opens, spheres, np.interp(time - SETTLING, time, spheres - on_screen))
    at_rest = np.where(time < min(fall, opens), 0.0, at_rest)
    return np.asarray(AT_REST * at_rest + hopping * (spheres - at_rest))


def list_rate(scene: EngineScene, apparatus: Apparatus, time: Floats, on_screen: Floats) -> Floats:
    """Return neighbour lists per second at each time: one when the fastest sphere, or a wall, has moved by half the skin.

    The fastest sphere falls from the slide to the screen, then hops on it, or is the falling sphere nearest to
    the bottom of the collecting bin: of m falling spheres it has m/(m + 1) of the speed there.
    """
    assert scene.slide is not None and scene.vibration is not None
    since = time - scene.slide.opens_at_s
    bottom = min(float(s.corners[..., 2].min()) for s in apparatus.surfaces)
    slide, lowest = (math.sqrt(2.0 * GRAVITY * h) for h in (apparatus.feed_region.z_low_m, -bottom))
    falling = np.clip(-np.gradient(on_screen, time), 0.0, None) * lowest / GRAVITY
    walls = peak_speed(scene.vibration)
    hopping = np.where(since > 0.0, np.minimum(GRAVITY * since, max(slide, HOP * walls)), 0.0)
    hopping = np.where(GRAVITY * since > 2.0 * slide, HOP * walls, hopping)
    below = np.minimum(GRAVITY * since - slide, lowest * falling / (falling + 1.0))
    speed = np.maximum(np.maximum(hopping, below), walls)
    steps = np.ceil(0.5 * deck.skin(scene) / (speed * scene.time_step_s))
    return np.asarray(1.0 / (steps * scene.time_step_s))


def near_wires(scene: EngineScene, spec: ApparatusSpec) -> Floats:
    """Return the wires near a sphere of each class on the screen: those whose axis is nearer than radii and 1.5 skins.

    A sphere anywhere in a bed of height H above wires of length L on an area A: L pi D^2/(2 A H).
    """
    radius = np.array([c.radius_m for c in scene.classes])
    solid = sum(c.count * 4.0 / 3.0 * math.pi * c.radius_m**3 for c in scene.classes)
    reach = 0.5 * spec.wire_diameter_m + radius + 1.5 * deck.skin(scene)
    length = 2.0 / (spec.aperture_m + spec.wire_diameter_m)
    return np.asarray(length * 0.5 * math.pi * reach**2 / np.maximum(solid / (DENSE * area(spec)), reach))
