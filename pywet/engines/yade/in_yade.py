"""Create the bodies and engines of a scene in YADE from plain numbers. Imported by the worker if YADE is installed."""

from __future__ import annotations

import math
from typing import Any

from yade import (  # type: ignore[import-not-found]
    Bo1_Polyhedra_Aabb,
    Bo1_Sphere_Aabb,
    ForceResetter,
    FrictViscoMat,
    HarmonicMotionEngine,
    Ig2_Sphere_Polyhedra_ScGeom,
    Ig2_Sphere_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_FrictViscoMat_FrictViscoMat_FrictViscoPhys,
    Law2_ScGeom_FrictViscoPhys_CundallStrackVisco,
    MatchMaker,
    NewtonIntegrator,
    O,
    PyRunner,
    RotationEngine,
    Vector3,
    polyhedra_utils,
    utils,
)

Task = dict[str, Any]
"""Task as made by driver.build_task."""


def materials(task: Task) -> list[int]:
    """Return the numbers of YADE's materials: that of the walls, then of each class."""
    shares = zip([1000.0, *task["density"]], task["contacts"]["damping_share"], strict=True)
    return [O.materials.append(FrictViscoMat(density=rho, betan=share, frictionAngle=0.0)) for rho, share in shares]


def matches(task: Task, kinds: list[int], values: list[float]) -> Any:
    """Return a table of values per pair of materials."""
    rows = [(kinds[a], kinds[b], float(v)) for (a, b), v in zip(task["contacts"]["pairs"], values, strict=True)]
    return MatchMaker(matches=rows, val=float("nan"), algo="val")


Contacts = tuple[list[int], list[Any], list[Any], float]
"""Materials, functors for the parameters of a contact and for its law, and the distance over touch at which it begins."""


def contacts(task: Task) -> Contacts:
    """Return the dry contacts of a task."""
    dry, kinds = task["contacts"], materials(task)
    numbers = Ip2_FrictViscoMat_FrictViscoMat_FrictViscoPhys(
        kn=matches(task, kinds, dry["stiffness"]),
        kRatio=matches(task, kinds, dry["ratio"]),
        frictAngle=matches(task, kinds, [math.atan(mu) for mu in dry["friction"]]),
    )
    return kinds, [numbers], [Law2_ScGeom_FrictViscoPhys_CundallStrackVisco()], 1.0


def bodies(task: Task, kinds: list[int]) -> tuple[list[int], dict[str, list[int]]]:
    """Create the bodies and return YADE's ids of the spheres, in order, and of the walls by name."""
    spheres = []
    for row in task["spheres"]:
        kind = int(row[1])
        body = utils.sphere(Vector3(*row[2:5]), task["radius"][kind - 1], material=kinds[kind])
        body.state.vel, body.state.angVel = Vector3(*row[5:8]), Vector3(*row[8:11])
        if row[0] in task["driven"]:
            body.state.blockedDOFs = "xyzXYZ"
        spheres.append(O.bodies.append(body))
    walls = {}
    for name, pieces in task["walls"].items():
        walls[name] = [
            O.bodies.append(
                polyhedra_utils.polyhedra(O.materials[kinds[0]], v=[Vector3(*p) for p in piece], fixed=True)
            )
            for piece in pieces
        ]
    return spheres, walls


def movers(task: Task, walls: dict[str, list[int]]) -> list[Any]:
    """Return engines that set the walls' velocities."""
    found = []
    for name, v in task["vibrates"].items():
        # the velocity a cos is the engine's -A sin with the phase less a quarter; it moves the walls to the end of the step
        ahead = 2.0 * math.pi * v["frequency"] * task["time_step"]
        phase = Vector3(*[p - 0.5 * math.pi + ahead for p in v["phase"]])
        f = Vector3(1, 1, 1) * v["frequency"]
        found.append(HarmonicMotionEngine(A=Vector3(*v["amplitude"]), f=f, fi=phase, ids=walls[name]))
    for name, r in task["turns"].items():
        found.append(
            RotationEngine(
                rotateAroundZero=True,
                zeroPoint=Vector3(*r["origin"]),
                rotationAxis=Vector3(*r["axis"]).normalized(),
                angularVelocity=2.0 * math.pi / r["period"],
                ids=walls[name],
            )
        )
    return found


def build(task: Task, command: str, given: Contacts) -> tuple[list[int], dict[str, list[int]], Any]:
    """Make bodies and engines of a step, with `command` between contacts and integration; return spheres, walls and the
    collider.
    """
    kinds, numbers, law, reach = given
    spheres, walls = bodies(task, kinds)
    O.dt = task["time_step"]
    collider = InsertionSortCollider(
        [Bo1_Sphere_Aabb(aabbEnlargeFactor=task["reach"]), Bo1_Polyhedra_Aabb()],
        verletDist=task["skin"],
        allowBiggerThanPeriod=True,
    )
    pairs = [
        Ig2_Sphere_Sphere_ScGeom(interactionDetectionFactor=reach, avoidGranularRatcheting=False),
        Ig2_Sphere_Polyhedra_ScGeom(),
    ]
    O.engines = [
        ForceResetter(),
        collider,
        InteractionLoop(pairs, numbers, law),
        PyRunner(command=command, iterPeriod=1, initRun=True),
        *movers(task, walls),
        NewtonIntegrator(damping=0),  # the weight is a force of the plugin's host
    ]
    return spheres, walls, collider
