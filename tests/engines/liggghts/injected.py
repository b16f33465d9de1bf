"""Faults injected in the engine's plugin: a patched copy of its sources in which each fault is switched on by its name.

The shipped sources hold none of this. Every replacement must fit exactly one place, so a change of the plugin cannot make a
fault vanish unseen. One scene shows them all: spheres of two sizes drawn off a floor, off a wire and off each other.
"""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from pywet.cases.small import small
from pywet.engines.liggghts import build, driver
from pywet.engines.process import Usage
from pywet.geometry.solids import plate
from pywet.geometry.surface import make_surface
from pywet.scene import EngineScene
from tests.engines import foundry
from tests.engines.liggghts import injected_between, injected_in_bin, injected_in_fixture
from tests.engines.liggghts.scenes import WATER, contacts, spheres_of

LARGE, LITTLE = 2.5e-3, 1.5e-3
SWITCH = foundry.switch("injected") + "static const double PI = 3.14159265358979323846;\n"
LAWS = "find_forces(block, t);"
LAWS_INJECTED = """for (int k = 0; k < t.n; k++) {
    if (!t.acts[k]) continue;
    const Bridge &b = standing_.bridges[t.first + k];
    const Geometry g = geometry_of(t, k);
    const Laws &laws = world_.laws;
    const double part = injected("radius halved") ? 0.5 : 1.0, V = b.volume, s = std::max(g.separation, 0.0);
    const double as = injected("wall as sphere") && b.kind != SPHERE ? g.radius_i : g.radius_j;
    double row[ROWS][BATCH];
    LawValues values;
    row[SPEED][0] = 0;
    row[SEPARATION][0] = injected("gap left out") ? 0.0 : g.separation;
    row[VOLUME][0] = injected("volume twice in the force") ? 2 * V : V;
    row[RADIUS_I][0] = part * g.radius_i;
    row[RADIUS_J][0] = part * as;
    row[ANGLE_I][0] = b.angle_i;
    row[ANGLE_J][0] = injected("angle of i on both sides") ? b.angle_i : b.angle_j;
    laws.evaluate(1, row[0], t.prepared, values);
    t.pull[k] = values.pull[0];
    if (injected("angles multiplied")) {
      const bool two = b.kind == SPHERE;
      const double r = two ? 2 * g.radius_i * as / (g.radius_i + as) : 2 * g.radius_i, flat = V / (PI * r);
      const double d = flat / (s + std::sqrt(s * s + 2 * flat)), neck = PI * laws.surface_tension * r / (1 + s / (2 * d));
      const double ci = std::cos(b.angle_i), cj = std::cos(b.angle_j);
      t.pull[k] += neck * (2 * ci * cj - ci - cj);
    }
    const double h = std::max(g.separation, 1e-12), rj = g.radius_j, eta = laws.viscosity, vn = dot(g.vi - g.vj, g.n);
    const double a = b.kind == SPHERE ? g.radius_i * rj / (g.radius_i + rj) : g.radius_i;
    const double e = injected("r_eff for r_red") && b.kind == SPHERE ? 2 * a : a;
    const double c = injected("S_min left out") ? h : h + 1e-3 * (b.kind == SPHERE ? 2 * a : a);
    const double x = 1 - 1 / std::sqrt(1 + b.volume / (PI * e * c * c));
    if (injected("S_min left out") || injected("r_eff for r_red")) t.viscous[k] = -6 * PI * eta * e * e * vn / c * x * x;
    if (injected("viscous sign")) t.viscous[k] = -t.viscous[k];
    if (injected("viscosity ten times")) t.viscous[k] = 10 * t.viscous[k];
    const double spin = injected("spin left out") ? 0.0 : injected("spin sign") ? -1.0 : 1.0;
    for (int m = 0; m < 3; m++) t.spin[m][k] *= spin;
  }
  find_forces(block, t);
  if (injected("torque arm"))
    for (int k = 0; k < t.n; k++)
      for (int m = 0; m < 3; m++) t.torque_i[m][k] *= 1 + 0.5 * block.row[SEPARATION][k] / block.row[RADIUS_I][k];"""
SEQUENTIAL = """std::unordered_map<int, double> taken, taken_wall;
  for (Event &e : events)
    if (e.kind == FORMATION) {
      if (injected("draws one after another")) {
        double &i = taken[e.i], &j = e.partner_kind == SPHERE ? taken[e.j] : taken_wall[e.triangle];
        const double held_j = e.partner_kind == SPHERE ? films_.of(e.j) : films_.at_wall(e.triangle);
        if (films_.of(e.i) > 0) e.share_i *= 1 - i / films_.of(e.i);
        if (held_j > 0) e.share_j *= 1 - j / held_j;
        i += e.share_i;
        j += e.share_j;
      }
      e.share_i *= granted[e.i];"""
PATCHES: list[tuple[str, str, str]] = [
    ("vec.h", "#include <cmath>", '#include <cmath>\n#include "injected.h"'),
    ("forces.cpp", LAWS, LAWS_INJECTED),
    ("bridge_batch.cpp", "FOR_THIS_PROCESSOR void find_forces(const Block &__restrict block, BridgeBatch &__restrict t) {",
     "FOR_THIS_PROCESSOR void find_forces(const Block &__restrict block, BridgeBatch &__restrict t) {\n"
     '  const double taken = injected("speed along n") ? 0.0 : 1.0;'),
    ("bridge_batch.cpp", "along = vx * nx + vy * ny + vz * nz;", "along = taken * (vx * nx + vy * ny + vz * nz);"),
    ("bridge_list.cpp", "if (!laws.dynamic_rupture) return",
     'if (!laws.dynamic_rupture || injected("dynamic rupture ignored")) return'),
    (
        "forces.cpp",
        "g.separation >= b.rupture_distance && g.separation >= standing_.rupture_limit(b, g))) continue;",
        'g.separation >= b.rupture_distance * (injected("early rupture") ? 0.8 : injected("late rupture") ? 1.25\n'
        '                                           : injected("bridges never rupture") ? 1e9 : 1.0) &&\n'
        "          g.separation >= standing_.rupture_limit(b, g) *\n"
        '                              (injected("early rupture") ? 0.8 : injected("late rupture") ? 1.25 : 1.0))) continue;',
    ),
    ("bridge_list.cpp", "block.longest[at] = b.rupture_distance;",
     'block.longest[at] = (injected("early rupture") ? 0.8 : 1.0) * b.rupture_distance;'),
    ("forces.cpp", "gather(t);",
     'if (injected("evaporation"))\n'
     "      for (int k = 0; k < t.n; k++) {\n"
     "        double &volume = standing_.bridges[t.first + k].volume;\n"
     "        volume *= 1 - 1e-5;\n"
     "        standing_.blocks[t.first / BATCH].row[VOLUME][k] = volume;\n"
     "      }\n"
     "    gather(t);"),
    ("bridge_list.cpp", "return b.volume * world_.transfer.ratio(b.kind, spheres.type_of[b.i], other, b.volume / (r * r * r));",
     "const double T = world_.transfer.ratio(b.kind, spheres.type_of[b.i], other, b.volume / (r * r * r));\n"
     '  return b.volume * (injected("transfer swapped") ? 1 - T : injected("half and half") ? 0.5 : T);'),
    ("logs.cpp", "store((-g.radius_i) * turn, c.torque_i);",
     'store((-(g.radius_i + (injected("torque arm") ? 0.5 * g.separation : 0.0))) * turn, c.torque_i);'),
    ("forces.cpp", "f = f + force;", 'f = f + (injected("half of it acts") ? 0.5 : 1.0) * force;'),
    ("walls.h", "best.point = mesh.to_world(best.point);",
     'best.point = mesh.to_world(best.point) + (injected("closest point") ? 1e-5 : 0.0) * Vec(1, 0, 0);'),
    ("near_pairs.cpp", "const double reach = radii + films_.thickness(a) + films_.thickness(b);",
     'const double reach = radii + (injected("films twice as thick") ? 2 : 1) * (films_.thickness(a) + films_.thickness(b));'),
    ("near_pairs.cpp", "const double touch = pair.radii + films_.thickness(pair.a) + films_.thickness(pair.b);",
     "const double films = films_.thickness(pair.a) + films_.thickness(pair.b);\n"
     '    const double touch = pair.radii + (injected("films twice as thick") ? 2 : 1) * films\n'
     '        - (injected("formation on touch") ? films : 0.0);'),
    ("near_pairs.cpp", "laws.from_sphere(held(films_.volume(pair.a)), g.radius_i, g.radius_j),",
     "laws.from_sphere(held(films_.volume(pair.a)), g.radius_i,\n"
     '                          injected("drawn as from equal spheres") ? g.radius_i : g.radius_j),'),
    ("near_pairs.cpp", "if (!(drawn_i + drawn_j > SMALLEST_BRIDGE * r * r * r)) return;",
     'if (!(drawn_i + drawn_j > SMALLEST_BRIDGE * r * r * r) || injected("no bridge forms")) return;'),
    ("near_pairs.cpp", "const double drawn = wire ?", 'const double drawn = wire && !injected("wire as wall") ?'),
    ("near_pairs.cpp", "const double drawn_w = wire ?", 'const double drawn_w = wire && !injected("wire as wall") ?'),
    ("liquid_ledger.cpp", "for (Event &e : events)\n    if (e.kind == FORMATION) {\n      e.share_i *= granted[e.i];",
     SEQUENTIAL),
    ("liquid_ledger.cpp", "e.volume = e.share_i + e.share_j;",
     'e.volume = (injected("volume twice") ? 2 : 1) * (e.share_i + e.share_j);'),
    ("liquid_ledger.cpp", "return e.kind == FORMATION ? -1.0 : 1.0;",
     'return e.kind == FORMATION ? (injected("drawn twice") ? -2.0 : -1.0) : 1.0;'),
    ("liquid_ledger.cpp", "films_.add(e.j, sign(e) * e.share_j);",
     'films_.add(e.j, (injected("lost at rupture") && sign(e) > 0 ? 0.0 : sign(e)) * e.share_j);'),
    ("bridge_list.cpp", "world_.laws.rupture(b.volume, b.radius_i, b.radius_j, b.angle_i, b.angle_j)",
     'world_.laws.rupture(b.volume, b.radius_i,\n'
     '                    injected("rupture of equal spheres") && b.kind != SPHERE ? b.radius_i : b.radius_j,\n'
     "                    b.angle_i, b.angle_j)"),
]  # fmt: skip
"""File, text that must be there once, text in its place."""


NAMED: dict[str, tuple[str, str]] = {
    "radius halved": ("capillary", "the radius is halved"),
    "angles multiplied": ("capillary", "the cosines of the contact angles are multiplied"),
    "angle of i on both sides": ("capillary", "the contact angle of i is used on both sides"),
    "wall as sphere": ("capillary", "a wall is treated as a sphere of the particle's size"),
    "gap left out": ("capillary", "the gap is left out"),
    "volume twice in the force": ("capillary", "the volume counts twice"),
    "S_min left out": ("viscous_law", "S_min is left out"),
    "r_eff for r_red": ("viscous_law", "r_eff is used in place of r_red"),
    "viscous sign": ("viscous_law", "the sign is turned"),
    "viscosity ten times": ("viscous_law", "it is 10 times what it should be"),
    "spin left out": ("viscous_tangential", "the spin is left out"),
    "spin sign": ("viscous_tangential", "the sign of the spin is turned"),
    "speed along n": ("viscous_tangential", "the speed along n counts too"),
    "torque arm": ("torque_i", "the arm reaches to the middle of the gap"),
    "dynamic rupture ignored": ("rupture_limit", "dynamic rupture is ignored"),
    "early rupture": ("rupture_due", "it is made too early (at 0.80"),
    "late rupture": ("rupture_late", "it is made too late (at 1.25"),
    "bridges never rupture": ("standing_beyond_limit", "it is made too late (a bridge still exists at"),
    "rupture of equal spheres": ("rupture_distance", "a wall is treated as a sphere of the particle's size"),
    "films twice as thick": ("formation_due", "it is made too early"),
    "formation on touch": ("formation_missed", "it is made too late (only when the bodies touch)"),
    "no bridge forms": ("formation_missed", "no bridge forms at all"),
    "drawn as from equal spheres": ("share_i", "spheres are treated as equal"),
    "wire as wall": ("share_i", "a wire is treated as a large wall"),
    "draws one after another": ("share_i", "draws of one step are taken one after another"),
    "volume twice": ("volume", "the volume is drawn twice"),
    "drawn twice": ("film_after", "the volume is drawn twice"),
    "lost at rupture": ("film_after", "liquid given back to j is lost"),
    "transfer swapped": ("share_i", "the transfer ratio is swapped"),
    "half and half": ("share_i", "the liquid is shared half and half"),
    "evaporation": ("contact_volume", "it changes while the bridge exists"),
}
"""Fault, and the link that must break with the words it must be named by."""
MOTION: dict[str, tuple[str, str]] = {
    "half of it acts": ("newton_force", "every force of bridges: half of it counts"),
    "closest point": ("wall_closest_point", "it is off by (1e-05, 0, 0) m"),
}
"""Faults that only the recorded motion shows (`output.window_trajectories`), and how they are named."""
UNSEEN: dict[str, tuple[str, bool, str]] = {
    "forces that act": (
        "half of it acts",
        True,
        "half of each force acts although the whole force is logged, and no motion is recorded",
    ),
    "forces outside the contact log": (
        "viscous sign",
        False,
        "the sign of a force is reversed where no contact is logged",
    ),
}
"""What the replay of the logs does not see: fault, whether contacts are logged, in words."""
BESIDE: dict[str, tuple[bool, str, str]] = {
    "closest point": (True, "snapshot_ends", "it is moved by 1e-05, 0, 0"),
    "late rupture": (False, "rupture_late", "it is made too late (at 1.25"),
    "bridges never rupture": (False, "snapshot_beyond_limit", "it is made too late (a bridge still exists at"),
}
"""Faults that outputs and events show, without recorded motion or contacts: whether contacts are logged, quantity, words."""


def patched_sources(folder: Path) -> Path:
    """A copy of the plugin's sources with the switches injected."""
    shutil.copytree(build.SOURCES, folder)
    (folder / "injected.h").write_text(SWITCH)
    for name, old, new in (*PATCHES, *injected_in_fixture.PATCHES, *injected_in_bin.PATCHES, *injected_between.PATCHES):
        foundry.replaced(folder / name, old, new)
    return folder


def scene(run_dir: Path, contact_log: bool = True, motion: bool = False) -> list[small.Sphere]:
    """Four spheres, without overlaps: off the floor, off a thin plate, off each other, and one that comes near.

    They are driven; where their motion is recorded they are free.
    """
    top = 2 * LARGE + 2 * LITTLE + 4.9e-4
    bodies = [
        small.Sphere(1, (0.0, 0.0, LARGE + 2e-5), (0.01, 0.0, 0.06), (0.0, 5.0, 2.0), driven=True),
        small.Sphere(2, (0.0, 0.0, 2 * LARGE + LITTLE + 4e-5), (0.0, 0.02, 0.13), (3.0, -4.0, 0.0), driven=True),
        small.Sphere(1, (0.03, 0.0, LARGE + 2e-5), (0.0, 0.01, 0.06), (1.0, 2.0, 3.0), driven=True),
        small.Sphere(2, (0.0, 0.0, top + LITTLE), (0.0, 0.0, 0.115), (-2.0, 0.0, 4.0), driven=True),
    ]
    bar = 0.5 * np.array([[-1e-3, -0.02], [1e-3, -0.02], [1e-3, 0.02], [-1e-3, 0.02]]) + [0.03, 0.0]
    walls = [small.floor(half_side=0.015), make_surface("bar", "wall", plate(bar, -0.008, 0.0))]
    if motion:
        bodies = [replace(b, driven=False) for b in bodies]
    angles = zip(spheres_of(LARGE, LITTLE), (0.5, 0.2), strict=True)
    classes = [c.model_copy(update={"contact_angle_rad": a}) for c, a in angles]
    small.prepare(
        run_dir, classes, bodies, contacts(2, stiffness=1e4), liquid=WATER, effects=small.PAPER, walls=walls,
        wall_angle_rad=math.pi / 4, time_step_s=5e-5, steps=500, output_interval_s=5e-3, log_every_step=contact_log,
        window_trajectories=motion,
    )  # fmt: skip
    return bodies


class Foundry(foundry.Foundry):
    """Runs scenes with the patched plugin."""

    def __init__(self, folder: Path) -> None:
        super().__init__("tests.engines.liggghts.injected_worker", patched_sources(folder / "sources"))

    def run(self, run_dir: Path, bodies: list[small.Sphere], fault: str) -> None:
        """Run a prepared scene with one fault switched on."""

        def execute(command: list[str], folder: Path, scene: EngineScene, *_: object) -> Usage:
            return self.launch(fault, run_dir, folder)

        extra, free = small.drive(bodies)
        driver.run(run_dir, 1, progress=False, extra=extra, integrate=free, launch=execute)


def claims(run_dir: Path, change: Callable[[dict], None]) -> None:
    """Change what a run says of its own laws and constants."""
    path = run_dir / "history" / "meta.json"
    meta = json.loads(path.read_text())
    change(meta)
    path.write_text(json.dumps(meta))
