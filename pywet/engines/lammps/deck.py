"""The script of LAMMPS for a scene: the same spheres, contacts, step, gravity and outputs as the deck of LIGGGHTS.

Walls are plates, square tubs, round wires and tubes with flat faces, all along the axes, fixed or turning; LAMMPS
represents them as regions, and the plugin stores their liquid on triangles.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from pywet.engines.liggghts import deck
from pywet.errors import PywetError
from pywet.geometry.stl import read_stl
from pywet.geometry.surface import Floats, Surface, enclosed
from pywet.laws import contact
from pywet.scene import ContactPair, EngineScene, Rotation, WallMesh
from pywet.util.files import atomic_write, read_table

SCRIPT, DATA = "in.lammps", "particles.data"
STATE = "id type x y z vx vy vz omegax omegay omegaz"
NUMBERS = 8
"""Number of values that each sphere carries for the plugin (engine.h: NUMBERS_TAKEN)."""
SAME = 1e-6
"""Distance over a mesh's extent below which points coincide; an STL file's numbers are rounded to 6e-8 of themselves."""
SAME_ANGLE = 1e-5
"""Angle [rad] within which corners seen along a tube coincide."""
SAME_VOLUME = 1e-3
"""Relative difference of the volumes of a mesh and of its regions; it is larger for another solid with the same corners."""
WIDEST = 1.01 * 2.0 * math.pi / 32
"""Largest angle of a facet of a round wire [rad], with faces within 0.5 % of the radius; a hundredth for rounding."""


def refuse(scene: EngineScene, ranks: int = 1) -> None:
    """Raise a PywetError in one sentence for what LAMMPS does not support in this scene."""
    reasons = ["more than one process"] if ranks > 1 else []
    if any(w.motion not in ("fixed", "turns") for w in scene.walls):
        reasons.append("walls that vibrate or slide")
    if any(w.motion == "turns" for w in scene.walls) and scene.effects.bridges and scene.output.energy:
        reasons.append("the power of walls that turn (of output, energy is true)")
    if any(w.analytic_wires for w in scene.walls):
        reasons.append("analytic wires")
    if scene.removes:
        reasons.append("taking spheres out of a run (`retire`, outlets)")
    if scene.periodic is not None:
        reasons.append("walls in a box that is periodic")
    if scene.effects.rolling and any(p.rolling_friction_m for p in scene.pairs):
        reasons.append("rolling resistance with a constant torque (its own is a spring with a slider)")
    if not scene.effects.tangential_history:
        reasons.append("friction without memory")
    if scene.hertz is not None:
        reasons.append("Hertz contacts as LIGGGHTS has them")
    if reasons:
        raise PywetError(
            f"the engine lammps cannot run the scene {scene.name}: it lacks {' and '.join(reasons)}; expected spheres, "
            "plates, tubs, wires or tubes, fixed or turning, without rolling resistance: use the engine liggghts",
            code="lammps.scene", given=tuple(reasons),
        )  # fmt: skip


def regions(surface: Surface) -> list[str]:
    """Return a wall as arguments of regions.

    A cuboid or a wire is seen from outside, a tub open to the top from inside; of a tube each inner face is a
    region, because a union of regions cannot turn in LAMMPS.
    """
    volume = enclosed(surface.corners)
    for words, of_solid in _solids(surface.vertices):
        if abs(volume - of_solid) < SAME_VOLUME * of_solid:
            return words
    raise PywetError(
        f"the engine lammps does not support the wall {surface.name}; expected a plate, a square tub, a round wire or "
        "a tube along the axes: use the engine liggghts",
        code="lammps.wall", key=f"walls.{surface.name}",
    )  # fmt: skip


def _solids(vertices: Floats) -> Iterator[tuple[list[str], float]]:
    """Yield the regions and the volume [m3] of each solid along the axes whose corners (n, 3) [m] these may be."""
    same, levels = SAME * float(np.ptp(vertices)), []
    for axis in vertices.T:
        places = np.unique(axis)
        levels.append(places[np.concatenate([[True], np.diff(places) > same])])
    counts = [len(places) for places in levels]
    whole = math.prod(float(np.ptp(places)) for places in levels)
    if counts == [2, 2, 2]:
        yield [_block(levels, 0, "side out")], whole
    elif counts == [4, 4, 3]:  # outer and inner faces; the floor's two and the rim
        inside = math.prod(float(places[2] - places[1]) for places in levels)
        yield [_block(levels, 1, "side in open 6")], whole - inside
    for solid in (_wire, _tube):
        for k in range(3):
            yield from solid(vertices, k, same)


def _block(levels: Sequence[Floats], first: int, words: str) -> str:
    return f"block {' '.join(f'{float(at)!r}' for places in levels for at in places[first : first + 2])} {words}"


def _wire(vertices: Floats, k: int, same: float) -> Iterator[tuple[list[str], float]]:
    """Yield the region and volume of a wire along axis k if all corners lie on a cylinder."""
    ends, across = vertices[:, k], np.delete(vertices, k, axis=1)
    middle = 0.5 * (across.min(axis=0) + across.max(axis=0))
    x, y = (across - middle).T
    radii, angles = np.hypot(x, y), np.sort(np.arctan2(y, x))
    facets = np.diff(angles, append=angles[0] + 2.0 * math.pi)
    if np.ptp(radii) <= same and facets.max() <= WIDEST:
        numbers = (*middle, radii.max(), ends.min(), ends.max())
        words = f"cylinder {'xyz'[k]} {' '.join(f'{float(at)!r}' for at in numbers)} side out"
        yield [words], float(0.5 * np.sin(facets).sum() * (radii**2).mean() * np.ptp(ends))


def _tube(vertices: Floats, k: int, same: float) -> Iterator[tuple[list[str], float]]:
    """Yield the inner faces, each as a point and its inward normal, and the volume of a tube along axis k.

    Only if the corners form two regular rings, one behind the other, at two positions along the axis.
    """
    across = np.delete(vertices, k, axis=1)
    middle = 0.5 * (across.min(axis=0) + across.max(axis=0))
    x, y = (across - middle).T
    radii, angles, ends = np.hypot(x, y), np.arctan2(y, x), vertices[:, k]
    if np.ptp(radii) <= same:
        return
    inner, low = radii < 0.5 * (radii.min() + radii.max()), ends < 0.5 * (ends.min() + ends.max())
    around = np.sort(angles)
    sides = int((np.diff(around, append=around[0] + 2.0 * math.pi) > SAME_ANGLE).sum())
    facet = 2.0 * math.pi / sides
    off = (angles - angles[0] + 0.5 * facet) % facet - 0.5 * facet
    rings = max(
        float(np.ptp(values[side])) for values, side in ((radii, inner), (radii, ~inner), (ends, low), (ends, ~low))
    )
    if sides < 3 or rings > same or np.ptp(off) > SAME_ANGLE:
        return
    apothem, faces = radii[inner].mean() * math.cos(0.5 * facet), []
    for angle in angles[0] + off.mean() + facet * (np.arange(sides) + 0.5):
        outward = np.array([math.cos(angle), math.sin(angle)])
        point, normal = (np.insert(v, k, 0.0) for v in (middle + apothem * outward, -outward))
        faces.append("plane " + " ".join(f"{float(at)!r}" for at in (*point, *normal)))
    area = 0.5 * sides * math.sin(facet) * ((radii[~inner] ** 2).mean() - (radii[inner] ** 2).mean())
    yield faces, float(area * np.ptp(ends))


def law(scene: EngineScene, pair: ContactPair) -> str:
    """Return the dry contact: spring and absolute dashpot, tangential spring with a slider and no dashpot."""
    mass = contact.pair_mass(scene.classes, pair)
    damping = contact.leapfrog_damping(pair.restitution, mass, pair.normal_stiffness_N_per_m, scene.time_step_s)
    normal, tangential = pair.normal_stiffness_N_per_m, pair.tangential_stiffness_N_per_m
    return f"hooke {normal!r} {float(damping)!r} tangential linear_history {tangential!r} 0.0 {pair.friction!r} damping velocity"


def lines(scene: EngineScene, run_dir: Path, extra: Sequence[str], integrate: str) -> Iterator[str]:
    """Yield the whole script; `extra` lines and the group `integrate` are used by driven small scenes."""
    film = deck.film_factor(scene) - 1.0
    skin, listed = deck.skin(scene), deck.listed(scene)
    yield from (
        "atom_style sphere", "atom_modify map array", "boundary f f f", "newton off", "comm_modify vel yes", "units si",
    )  # fmt: skip
    yield from (f"read_data {DATA}", f"neighbor {listed!r} bin", "neigh_modify delay 0 every 1 check yes")
    yield from (f"variable skin equal {skin!r}", f"variable thickest_film equal {film!r}")
    yield f"fix p_liquid all property/atom d2_liquid {NUMBERS}"
    yield from (
        "pair_style granular",
        "pair_coeff * * hooke 1.0 0.0 tangential linear_history 1.0 0.0 0.0 damping velocity",
    )
    yield from (f"pair_coeff {p.a} {p.b} {law(scene, p)}" for p in scene.pairs if p.b)
    yield f"timestep {scene.time_step_s!r}"
    size = float(np.linalg.norm(scene.gravity_m_per_s2))
    if size:
        yield f"fix gravity all gravity {size!r} vector " + " ".join(repr(g / size) for g in scene.gravity_m_per_s2)
    yield from (f"group type_{c.type} type {c.type}" for c in scene.classes)
    for wall in scene.walls:
        yield from _wall(scene, wall, run_dir)
    yield from extra
    yield f"fix integrate {integrate} nve/sphere"
    yield "fix pywet all external pf/callback 1 1"
    yield from ("thermo_style custom step atoms ke cpu", f"thermo {max(1, scene.steps // 200)}")
    yield "thermo_modify norm no lost error flush yes"
    yield f"dump trajectory all custom {scene.output_every} trajectory.txt {STATE}"
    yield 'dump_modify trajectory sort id format line "%d %d' + 9 * " %.17g" + '"'


def _wall(scene: EngineScene, wall: WallMesh, run_dir: Path) -> Iterator[str]:
    motion, turning = scene.motions[wall.name], ""
    if isinstance(motion, Rotation):
        yield f"variable move_{wall.name} equal 2.0*PI*step*dt/{motion.period_s!r}"
        turning = f" rotate v_move_{wall.name} " + " ".join(repr(float(at)) for at in (*motion.origin_m, *motion.axis))
    for k, words in enumerate(regions(read_stl(run_dir / wall.stl, name=wall.name))):
        yield f"region p_{wall.name}_{k} {words}{turning}"
        for pair in (p for p in scene.pairs if p.b == 0):
            name = f"wall_{wall.name}_{k}_{pair.a}"
            yield f"fix {name} type_{pair.a} wall/gran/region granular {law(scene, pair)} region p_{wall.name}_{k}"


def write(scene: EngineScene, run_dir: Path, folder: Path, extra: Sequence[str], integrate: str) -> None:
    deck.write_data(scene, read_table(run_dir / scene.spheres_file), folder / DATA)
    with atomic_write(folder / SCRIPT) as temporary:
        temporary.write_text("\n".join(lines(scene, run_dir, extra, integrate)) + "\n")
