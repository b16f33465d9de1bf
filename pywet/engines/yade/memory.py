"""Memory layout of YADE's data for the plugin, since Debian's package has no headers. Runs inside YADE.

Before any run the assumed layout of this version is checked by a test scene: if its values differ from those that
YADE's Python interface returns, or cannot be read, the run is refused.
"""

from __future__ import annotations

import ctypes as C
import os
import struct
from typing import Any

import numpy as np

from pywet.errors import EngineError

DOUBLES, POINTER = "d", "Q"
LAYOUT = {
    "position": 88, "orientation": 112, "velocity": 144, "spin": 176,  # of a State
    "forces": 32, "torques": 56,  # of a Scene
    "listed": 24,  # of an InteractionContainer
    "bodies": 88, "geometry": 112, "physics": 128,  # of an Interaction
    "normal": 32, "depth": 160,  # of a ScGeom
}  # fmt: skip
"""Offsets in bytes from an object's start, in the order of the host's struct Layout."""
FIRST, SECOND = 40, 16
"""Offsets in bytes from a Python object of YADE to a pointer, and from its target to the pointer to the C++ object."""


class Layout(C.Structure):
    """Memory offsets passed to the plugin, as struct Layout in yade's host sources."""

    _fields_ = [(name, C.c_int64) for name in LAYOUT]


class Given(C.Structure):
    """Data of YADE passed to the plugin, as struct Given in plugin/host.h."""

    _fields_ = [
        *((name, C.c_int64) for name in ("spheres", "walls", "bodies", "types", "every")),
        *((name, C.c_void_p) for name in (
            "state", "tag", "kind", "wall_state", "wall_turns", "driven", "scene", "interactions", "mass", "radius",
            "rolling", "low", "high", "gravity",
        )),
        *((name, C.c_double) for name in ("dt", "skin", "thickest_film")),
        ("at", Layout), ("recorded", C.c_void_p),
    ]  # fmt: skip


def read(address: int, kind: str, count: int = 1) -> list[Any]:
    """Read numbers at an address of this process; `EngineError` if there is no memory."""
    try:
        with open("/proc/self/mem", "rb", 0) as memory:
            return list(struct.unpack(f"{count}{kind}", os.pread(memory.fileno(), 8 * count, address)))
    except (OSError, OverflowError, struct.error) as error:
        raise EngineError(
            _other(f"nothing at the address {address:#x}", "an object of YADE"), code="yade.memory"
        ) from error


def address(held: object) -> int:
    """Return the address of the C++ object behind a Python object of YADE."""
    return int(read(read(id(held) + FIRST, POINTER)[0] + SECOND, POINTER)[0])


def check() -> None:
    """Compare the memory layout with the values that YADE reports for two touching, spinning spheres; leaves an empty scene."""
    from yade import O, Vector3  # type: ignore[import-not-found]

    touch()
    compare("State", address(O.bodies[0].state), {
        "position": O.bodies[0].state.pos, "velocity": O.bodies[0].state.vel, "spin": O.bodies[0].state.angVel,
        "orientation": [O.bodies[0].state.ori[k] for k in range(4)],
    })  # fmt: skip
    scene, pushed, twisted = address(O.forces), Vector3(1.25, -2.5, 3.75), Vector3(-4.25, 5.5, 6.75)
    O.forces.reset()
    O.forces.addF(1, pushed)
    O.forces.addT(1, twisted)
    for name, given in (("forces", pushed), ("torques", twisted)):
        first, last = read(scene + LAYOUT[name], POINTER, 2)
        rows = read(first, POINTER)[0]
        _same(f"the rows of {name}", [(last - first) / 24, *read(rows + 24, DOUBLES, 3)], [1.0, *given])
    pair, container = O.interactions[0, 1], address(O.interactions)
    first, last = read(container + LAYOUT["listed"], POINTER, 2)
    every = read(first, POINTER, (last - first) // 8)[::2]
    _same("the list of interactions", sorted(every), sorted(address(i) for i in O.interactions.all(False)))
    at = address(pair)
    bodies = np.array(read(at + LAYOUT["bodies"], POINTER), np.uint64).view(np.int32)
    inside = [read(at + LAYOUT[name], POINTER)[0] for name in ("geometry", "physics")]
    _same("an Interaction", [*bodies.tolist(), *inside], [pair.id1, pair.id2, address(pair.geom), address(pair.phys)])
    for contact in (pair, O.interactions[1, 2]):
        compare(
            "ScGeom", address(contact.geom), {"normal": contact.geom.normal, "depth": [contact.geom.penetrationDepth]}
        )
    O.reset()


def touch() -> None:
    """Advance the test scene by one step."""
    import yade
    from yade import O, Vector3, polyhedra_utils, utils

    kind = O.materials.append(yade.FrictViscoMat(density=2500.0, betan=0.1, frictionAngle=0.3))
    for at in ((0.1, 0.2, 0.3099), (0.1, 0.2, 0.3)):
        body = O.bodies[O.bodies.append(utils.sphere(Vector3(*at), 0.005, material=kind))]
        body.state.vel, body.state.angVel = Vector3(0.04, 0.05, 0.06), Vector3(0.7, 0.8, 0.9)
    corners = [Vector3(x, y, z) for x in (0.0, 0.2) for y in (0.1, 0.3) for z in (0.25, 0.2951)]
    O.bodies.append(polyhedra_utils.polyhedra(O.materials[kind], v=corners, fixed=True))
    O.bodies[0].state.ori = yade.Quaternion((0.6, 0.0, 0.8), 0.5)
    O.dt = 1e-7
    O.engines = [
        yade.ForceResetter(),
        yade.InsertionSortCollider([yade.Bo1_Sphere_Aabb(), yade.Bo1_Polyhedra_Aabb()], verletDist=0.001),
        yade.InteractionLoop(
            [yade.Ig2_Sphere_Sphere_ScGeom(), yade.Ig2_Sphere_Polyhedra_ScGeom()],
            [yade.Ip2_FrictViscoMat_FrictViscoMat_FrictViscoPhys()],
            [yade.Law2_ScGeom_FrictViscoPhys_CundallStrackVisco()],
        ),
        yade.NewtonIntegrator(damping=0),
    ]
    O.step()


def compare(what: str, at: int, values: dict[str, Any]) -> None:
    """Refuse an object that does not contain these numbers at the assumed offset."""
    for name, numbers in values.items():
        _same(f"{name} of a {what}", read(at + LAYOUT[name], DOUBLES, len(numbers)), list(numbers))


def _same(what: str, found: list[Any], shown: list[Any]) -> None:
    if [float(x) for x in found] != [float(x) for x in shown]:
        raise EngineError(_other(f"{what} as {found}", str(shown)), code="yade.memory", given=found, expected=shown)


def _other(found: str, wanted: str) -> str:
    return (
        f"YADE's memory holds {found}; expected {wanted}, as in Debian 12's build of 2023.02a: install that package, or take the "
        "engine liggghts"
    )
