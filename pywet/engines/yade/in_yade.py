"""Runs inside YADE (`yade -j1 -x -n in_yade.py task.json`), not in pywet: one scene from its task, which is plain numbers.

Leaves frames.bin (rows of 12 doubles: step, id, type, x, y, z, vx, vy, vz, wx, wy, wz), walls.json (how far each wall is from
its start at each frame), bridges.json for a scene with liquid, progress.txt. Velocities are half a step old, as YADE's
leapfrog has them.
"""

import json
import math
import os
import sys

import numpy as np
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
    Ip2_ViscElCapMat_ViscElCapMat_ViscElCapPhys,
    Law2_ScGeom_FrictViscoPhys_CundallStrackVisco,
    Law2_ScGeom_ViscElCapPhys_Basic,
    MatchMaker,
    NewtonIntegrator,
    O,
    RotationEngine,
    Vector3,
    ViscElCapMat,
    polyhedra_utils,
    utils,
)

with open(sys.argv[1]) as given:
    TASK = json.load(given)
DRY, LIQUID = TASK["contacts"], TASK["liquid"]


def materials() -> list:
    """Numbers of YADE's materials: the walls', then each class's."""
    found = []
    for k, density in enumerate([1000.0, *TASK["density"]]):
        if LIQUID:
            kind = ViscElCapMat(
                density=density,
                Capillar=True,
                CapillarType=LIQUID["law"],
                Vb=LIQUID["volume"],
                gamma=LIQUID["surface_tension"],
                theta=LIQUID["angle_deg"],
                **LIQUID["materials"][k],
            )
        else:
            kind = FrictViscoMat(density=density, betan=DRY["damping_share"][k], frictionAngle=0.0)
        found.append(O.materials.append(kind))
    return found


def matches(kinds: list, values: list) -> MatchMaker:
    """Make YADE's table of a contact parameter for each pair of materials."""
    rows = [(kinds[a], kinds[b], float(v)) for (a, b), v in zip(DRY["pairs"], values, strict=True)]
    return MatchMaker(matches=rows, val=float("nan"), algo="val")


def laws(kinds: list) -> tuple:
    """How a contact gets its numbers, and its law."""
    if LIQUID:
        return [Ip2_ViscElCapMat_ViscElCapMat_ViscElCapPhys()], [Law2_ScGeom_ViscElCapPhys_Basic()]
    numbers = Ip2_FrictViscoMat_FrictViscoMat_FrictViscoPhys(
        kn=matches(kinds, DRY["stiffness"]),
        kRatio=matches(kinds, DRY["ratio"]),
        frictAngle=matches(kinds, [math.atan(mu) for mu in DRY["friction"]]),
    )
    return [numbers], [Law2_ScGeom_FrictViscoPhys_CundallStrackVisco()]


def bodies(kinds: list) -> tuple:
    """Spheres, in order, and walls by name."""
    g = Vector3(*TASK["gravity"])
    spheres = []
    for row in TASK["spheres"]:
        kind = int(row[1])
        body = utils.sphere(Vector3(*row[2:5]), TASK["radius"][kind - 1], material=kinds[kind])
        # the leapfrog's velocity belongs to half a step before the start
        body.state.vel = Vector3(*row[5:8]) - 0.5 * TASK["time_step"] * g
        body.state.angVel = Vector3(*row[8:11])
        spheres.append(O.bodies.append(body))
    walls = {}
    for name, pieces in TASK["walls"].items():
        walls[name] = [
            O.bodies.append(
                polyhedra_utils.polyhedra(O.materials[kinds[0]], v=[Vector3(*p) for p in piece], fixed=True)
            )
            for piece in pieces
        ]
    return spheres, walls


def engines(kinds: list, vibrating: list, turning: list) -> list:
    """Build the list of YADE engines that make up one time step."""
    reach = TASK["reach"]
    numbers, law = laws(kinds)
    loop = [
        ForceResetter(),
        InsertionSortCollider(
            [Bo1_Sphere_Aabb(aabbEnlargeFactor=reach), Bo1_Polyhedra_Aabb()],
            verletDist=TASK["skin"],
            allowBiggerThanPeriod=True,
        ),
        InteractionLoop(
            [
                Ig2_Sphere_Sphere_ScGeom(interactionDetectionFactor=reach, avoidGranularRatcheting=False),
                Ig2_Sphere_Polyhedra_ScGeom(),
            ],
            numbers,
            law,
        ),
    ]
    if TASK["vibration"] and vibrating:
        # the velocity a cos is the engine's -A sin with the phase less a quarter; it moves the walls to the end of the step
        v = TASK["vibration"]
        ahead = 2.0 * math.pi * v["frequency"] * TASK["time_step"]
        phase = Vector3(*[p - 0.5 * math.pi + ahead for p in v["phase"]])
        f = Vector3(1, 1, 1) * v["frequency"]
        loop.append(HarmonicMotionEngine(A=Vector3(*v["amplitude"]), f=f, fi=phase, ids=vibrating))
    if turning:
        r = TASK["rotation"]
        loop.append(
            RotationEngine(
                rotateAroundZero=True,
                zeroPoint=Vector3(*r["origin"]),
                rotationAxis=Vector3(*r["axis"]).normalized(),
                angularVelocity=2.0 * math.pi / r["period"],
                ids=turning,
            )
        )
    return [*loop, NewtonIntegrator(damping=0, gravity=Vector3(*TASK["gravity"]))]


def frame(spheres: list) -> np.ndarray:
    """Collect position, velocity and spin of all spheres at the current step."""
    rows = []
    for ident, row in zip(spheres, TASK["spheres"], strict=True):
        s = O.bodies[ident].state
        rows.append((O.iter, row[0], row[1], *s.pos, *s.vel, *s.angVel))
    return np.array(rows, dtype=float)


def check_inside(table: np.ndarray) -> None:
    """A sphere that left the box would be an error in LIGGGHTS as well."""
    low, high = np.array(TASK["box_low"]), np.array(TASK["box_high"])
    out = ~((table[:, 3:6] > low) & (table[:, 3:6] < high)).all(axis=1)
    if out.any():
        where = f"sphere {int(table[out][0, 1])} left the simulated box before step {O.iter}"
        print(f"ERROR: {where}; expected walls or a tray that keep it, or a smaller time step", flush=True)
        sys.stdout.flush()
        raise SystemExit(3)


def bridges() -> list:
    """Standing liquid bridges at the end: bodies, volume, gap, whether it is to a wall."""
    found = []
    for i in O.interactions:
        if i.isReal and i.phys.liqBridgeCreated:
            other = O.bodies[i.id2].shape.__class__.__name__ + O.bodies[i.id1].shape.__class__.__name__
            found.append(
                {
                    "volume": i.phys.Vb,
                    "gap": -i.geom.penetrationDepth,
                    "wall": "Polyhedra" in other,
                    "rupture": i.phys.sCrit,
                }
            )
    return found


def main() -> None:
    """Build the scene in YADE, run it and write its tables."""
    kinds = materials()
    spheres, walls = bodies(kinds)
    O.dt = TASK["time_step"]
    O.engines = engines(kinds, *([b for name in TASK[way] for b in walls[name]] for way in ("vibrates", "turns")))
    sliding = [b for name in TASK["slides"] for b in walls[name]]
    at_start = {name: O.bodies[pieces[0]].state.pos for name, pieces in walls.items()}
    motion = []
    stops = sorted({*range(0, TASK["steps"] + 1, TASK["every"]), *TASK["slide_steps"], TASK["steps"], *TASK["marks"]})
    with open("frames.bin", "wb") as frames:
        for stop in stops:
            # O.run waits for its thread in naps of 50 ms, which short runs are full of
            for _ in range(stop - O.iter):
                O.step()
            if stop in TASK["slide_steps"]:
                moving = stop == TASK["slide_steps"][0]
                for b in sliding:
                    O.bodies[b].state.vel = Vector3(*TASK["slide_velocity"]) if moving else Vector3(0, 0, 0)
            if stop % TASK["every"] == 0:
                table = frame(spheres)
                check_inside(table)
                table.tofile(frames)
                motion += [
                    # a wall that turns has no shift
                    (
                        O.iter,
                        name,
                        *(Vector3(0, 0, 0) if name in TASK["turns"] else O.bodies[b[0]].state.pos - at_start[name]),
                    )
                    for name, b in walls.items()
                ]
            with open("progress.new", "w") as progress:
                progress.write(str(O.iter))
            os.replace("progress.new", "progress.txt")
    with open("walls.json", "w") as result:
        json.dump(motion, result)
    if LIQUID:
        with open("bridges.json", "w") as result:
            json.dump(bridges(), result)
    with open("done", "w") as mark:
        mark.write(str(O.iter))


main()
