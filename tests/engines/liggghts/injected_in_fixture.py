"""Faults injected in the plugin that runs tests/reference_impl/fixture_scene.py: formations, walls, ends, forces in flight.

Sources are patched as in injected.py, with which they share one build. `pump` is a scene of its own for films on walls: a sphere
that is moved up and down over a small plate leaves liquid there and comes back to it slowly. `grown` is one for films that
grow between two neighbour lists: a wet sphere is drawn off another and off a plate, a third rests just beyond the films of each.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from pywet.cases.small import small
from pywet.cases.small.bodies import water
from pywet.geometry.solids import bin_solid, plate
from pywet.geometry.surface import make_surface
from pywet.scene import Output
from tests.engines.liggghts.scenes import contacts, spheres_of

Scene = Callable[[Path], list[small.Sphere]]
"""Writes the inputs of a run."""
BEFORE = "WallPair &pair = wall_pairs_[c];"
PATCHES: list[tuple[str, str, str]] = [
    ("near_pairs.cpp", "if (near.distance >= films_.reach(pair.a) + w) {",
     'const double seen = injected("film of a wall left out") ? 0.0 : injected("film of a wall 5 % thin") ? 0.95 : 1.0;\n'
     "    if (near.distance >= films_.reach(pair.a) + seen * w) {"),
    ("near_pairs.cpp", BEFORE,
     BEFORE + '\n    if (injected("a wall without bridges") && pair.j == 1) continue;\n'
     '    if (injected("one bridge a mesh")) {\n'
     "      bool has = false;\n"
     "      for (size_t p = 0; p < walls.parts.size(); p++)\n"
     "        has = has || (walls.parts[p].mesh == walls.parts[pair.j].mesh\n"
     "                      && standing_.find(LARGE_WALL, pair.i, int(p)) >= 0);\n"
     "      if (has) continue;\n"
     "    }"),
    ("near_pairs.cpp", "if (given_to_neighbour(c, near)) {",
     'if (!injected("two bridges at an edge") && given_to_neighbour(c, near)) {'),
    ("step.cpp", "if (!clock.again) near.propose(ledger.events);",
     'if (!clock.again && !(injected("formations in every second step") && clock.now % 2)) near.propose(ledger.events);'),
    ("forces.cpp", "e.i = b.i; e.j = b.j; e.triangle = g.triangle;",
     "e.i = b.i; e.j = b.j; e.triangle = g.triangle;\n"
     '    if (injected("lands on the first triangle") && b.kind != SPHERE)\n'
     "      e.triangle = world_.walls.parts[b.j].triangles.front();"),
    ("forces.cpp", "laws.evaluate(t.n, block.row[0], t.prepared, t);",
     "laws.evaluate(t.n, block.row[0], t.prepared, t);\n"
     '  if (injected("drag halved outside windows") && !world_.clock.logs_contacts())\n'
     "    for (int k = 0; k < t.n; k++) t.viscous[k] *= 0.5;"),
    ("forces.cpp", "accumulate(engine.f[0] + 3 * b, (-1.0) * force);",
     'accumulate(engine.f[0] + 3 * b, (injected("acts on one side") ? 0.0 : -1.0) * force);'),
    ("films.cpp", "  thicker = std::max(",
     '  if (!injected("growth unseen") && !injected("growth unseen, on walls too")) thicker = std::max('),
    ("films.cpp", "  wall_thicker = std::max(",
     '  if (!injected("growth unseen, on walls too")) wall_thicker = std::max('),
    ("films.cpp", "part_thickness_[part] = std::max(part_thickness_[part], on_triangle(triangle));",
     'part_thickness_[part] = injected("thickest film of a wall part not raised")\n'
     "        ? std::min(part_thickness_[part], on_triangle(triangle))\n"
     "        : std::max(part_thickness_[part], on_triangle(triangle));"),
    ("energy.cpp", "power[VISCOUS_NORMAL] += n;", 'power[VISCOUS_NORMAL] += (injected("work of drag twice") ? 2 : 1) * n;'),
]  # fmt: skip
"""File, text that must be there once, text in its place."""

IN_FIXTURE: dict[str, tuple[str, str]] = {
    "a wall without bridges": ("formation_missed", "wall part 1 never gets a bridge"),
    "formations in every second step": ("formation_late", "films are looked at in every 2nd step only"),
    "lands on the first triangle": ("event_triangle", "it is the first triangle of the part"),
    "drag halved outside windows": ("flight_velocity", "the viscous normal force is 0.5 times what it should be"),
    "acts on one side": ("newton_force", "every force of bridges on their second sphere (j): it is left out"),
    "work of drag twice": ("energy_windows", "viscous_normal: it is 2 times what is expected"),
}
"""Fault -> the quantity that must break and the words by which it must be named."""
IN_PUMP: dict[str, tuple[str, str]] = {
    "film of a wall left out": ("formation_late", "the film of a wall is left out"),
    "film of a wall 5 % thin": ("formation_late", "the film of a wall is taken too thin (at most 0.9"),
}
IN_EDGE: dict[str, tuple[str, str]] = {
    "two bridges at an edge": (
        "formation_shared",
        "a sphere gets a bridge with each part of a wall that meets in one place",
    ),
}
IN_GROOVE: dict[str, tuple[str, str]] = {
    "one bridge a mesh": ("formation_missed", "a sphere has one bridge to a mesh in place of one to each part"),
}
IN_GROWN: dict[str, tuple[str, str]] = {
    "growth unseen": ("formation_late", "a film's growth is not seen at once"),
    "growth unseen, on walls too": ("formation_late", "explains 2 of 2 records"),
    "thickest film of a wall part not raised": ("formation_late", "a film's growth is not seen at once"),
}


def pump(folder: Path) -> list[small.Sphere]:
    """Two spheres that go up and down over small plates."""
    radius, swing, period = 2.5e-3, 1.4e-3, 0.1
    plates = []
    for name, x in (("left", -0.01), ("right", 0.01)):
        corners = 1.2e-3 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) + [x, 0.0]
        plates.append(make_surface(name, "wall", plate(corners, -4e-3, 0.0)))
    up = ((0.0, 0.0, swing), period)
    high, off = radius + swing + 1e-5, 4e-4  # away from the edge between the two triangles of a plate
    bodies = [small.Sphere(1, (x + off, -off, high), driven=True, wiggle=up) for x in (-0.01, 0.01)]
    small.prepare(
        folder, spheres_of(radius), bodies, contacts(1, stiffness=1e4), liquid=water(3e-5), effects=small.PAPER,
        walls=plates, wall_angle_rad=math.radians(45.0), time_step_s=2e-5, steps=15000,
        output=Output(interval_s=1e-4, contact_windows=0),  # dense enough in time to follow a sphere
    )  # fmt: skip
    return bodies


def edge(folder: Path) -> list[small.Sphere]:
    """At the convex edge of a plate: a sphere at rest and one that comes to it, seen at outputs alone."""
    radius, off, way = 2.5e-3, math.sqrt(0.5), math.sqrt(0.5) * 0.02
    corners = 5e-3 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    bodies = [
        small.Sphere(1, (5e-3 + off * (radius + gap), y, off * (radius + gap)), velocity, driven=True)
        for y, gap, velocity in ((-3e-3, 1e-6, (0.0, 0.0, 0.0)), (3e-3, 4.5e-5, (-way, 0.0, -way)))
    ]
    small.prepare(
        folder, spheres_of(radius), bodies, contacts(1, stiffness=1e4), liquid=water(3e-5), effects=small.PAPER,
        walls=[make_surface("plate", "wall", plate(corners, -4e-3, 0.0))], wall_angle_rad=math.radians(45.0),
        time_step_s=1e-5, steps=200, output=Output(interval_s=5e-4, contact_windows=0),
    )  # fmt: skip
    return bodies


def groove(folder: Path) -> list[small.Sphere]:
    """On the floor of a bin: a sphere at rest in its concave edge and one that comes to the side later."""
    radius, half = 2.5e-3, 0.02
    bodies = [
        small.Sphere(1, (half - radius - gap, y, radius + 1e-6), (speed, 0.0, 0.0), driven=True)
        for y, gap, speed in ((-4e-3, 1e-6, 0.0), (4e-3, 4.5e-5, 0.014))
    ]
    small.prepare(
        folder, spheres_of(radius), bodies, contacts(1, stiffness=1e4), liquid=water(3e-5), effects=small.PAPER,
        walls=[make_surface("bin", "wall", bin_solid(half, 4e-3, 4, 0.0, 0.03))], wall_angle_rad=math.radians(45.0),
        time_step_s=1e-5, steps=200, output=Output(interval_s=5e-4, contact_windows=0),
    )  # fmt: skip
    return bodies


def grown(folder: Path) -> list[small.Sphere]:
    """At rest but for two wet spheres that are drawn away; nothing moves so far after a rupture that lists are made again."""
    radius, thin, wet, at, beyond = 2.5e-3, 5e-6, 1e-4, 0.02, 1e-6
    film = {h: 4.0 / 3.0 * math.pi * ((radius + h) ** 3 - radius**3) for h in (thin, wet)}
    corners = 5e-3 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) + [at, 0.0]
    places = [
        (0.0, 0.0, at), (2.0 * radius + 2.0 * thin + 1.5 * beyond, 0.0, at), (at + 4e-3, 2.5e-3, radius + thin + beyond),
    ]  # fmt: skip
    bodies = [small.Sphere(1, place, driven=True, film=film[thin]) for place in places]
    for place, away in (((-2.0 * radius - beyond, 0.0, at), (-0.02, 0.0, 0.0)),
                        ((at - 1e-3, -4e-3, radius + beyond), (0.0, 0.0, 0.02))):  # fmt: skip
        bodies.append(small.Sphere(1, place, velocity=away, driven=True, film=film[wet]))
    small.prepare(
        folder, spheres_of(radius), bodies, contacts(1, stiffness=1e4), liquid=water(wet), effects=small.PAPER,
        walls=[make_surface("plate", "wall", plate(corners, -4e-3, 0.0))], wall_angle_rad=math.radians(45.0),
        time_step_s=2e-6, steps=26000, output=Output(interval_s=4e-3, contact_windows=0),
    )  # fmt: skip
    return bodies


SCENES: dict[Scene, dict[str, tuple[str, str]]] = {pump: IN_PUMP, edge: IN_EDGE, groove: IN_GROOVE, grown: IN_GROWN}
"""Further scenes, each with its faults."""
