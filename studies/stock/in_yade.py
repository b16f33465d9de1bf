"""Script for YADE (`yade -j1 -x -n in_yade.py points.json forces.json`), not for pywet: one pair of bodies for each point.

Bodies overlap slightly in the first step, in which YADE makes the bridge; then the second one is moved to its gap and
the force of the next step is read. The contact is so soft that its force is negligible.
"""

import json
import sys

from yade import (  # type: ignore[import-not-found]
    Bo1_Facet_Aabb,
    Bo1_Sphere_Aabb,
    ForceResetter,
    Ig2_Facet_Sphere_ScGeom,
    Ig2_Sphere_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_ViscElCapMat_ViscElCapMat_ViscElCapPhys,
    Law2_ScGeom_ViscElCapPhys_Basic,
    NewtonIntegrator,
    O,
    ViscElCapMat,
    utils,
)

REACH = 5.0
OVERLAP = 1e-6


def engines() -> list:
    """Return the minimal engines for contacts and forces."""
    return [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb(aabbEnlargeFactor=REACH), Bo1_Facet_Aabb()], verletDist=0),
        InteractionLoop(
            [Ig2_Sphere_Sphere_ScGeom(interactionDetectionFactor=REACH), Ig2_Facet_Sphere_ScGeom()],
            [Ip2_ViscElCapMat_ViscElCapMat_ViscElCapPhys()],
            [Law2_ScGeom_ViscElCapPhys_Basic()],
        ),
        NewtonIntegrator(damping=0),
    ]


def material(law: str, point: dict) -> int:
    """Create a material with this law, volume and contact angle."""
    return int(
        O.materials.append(
            ViscElCapMat(
                kn=1e-12,
                ks=1e-12,
                cn=0,
                cs=0,
                frictionAngle=0,
                density=2500,
                Capillar=True,
                CapillarType=law,
                Vb=point["volume"],
                gamma=point["surface_tension"],
                theta=point["angle_deg"],
            )
        )
    )


def measure(law: str, points: list) -> list:
    """Measure the attraction [N] at each point in YADE."""
    O.engines = engines()
    O.dt = 1e-9
    bodies, x = [], 0.0
    for point in points:
        ri, rj = point["radius_i"], point["radius_j"]
        x += 4 * REACH * max(ri, rj or ri)
        kind = material(law, point)
        if rj is None:
            corners = [(x - 4 * ri, -4 * ri, 0), (x + 4 * ri, -4 * ri, 0), (x, 4 * ri, 0)]
            lower, upper, top = utils.facet(corners, material=kind, fixed=True), ri, 0.0
        else:
            lower, upper, top = utils.sphere((x, 0, 0), ri, material=kind, fixed=True), rj, ri
        a = O.bodies.append(lower)
        touch = top + upper - OVERLAP * min(ri, rj or ri)
        b = O.bodies.append(utils.sphere((x, 0, touch), upper, material=kind, fixed=True))
        bodies.append((a, b, x, top + upper + point["gap"]))
        x += 4 * REACH * max(ri, rj or ri)
    O.step()
    for _, b, place, height in bodies:
        O.bodies[b].state.pos = (place, 0, height)
    O.step()
    return [0.0 - O.forces.f(b)[2] for _, b, _, _ in bodies]


# in YADE the script's arguments begin at index 1
with open(sys.argv[1]) as given:
    task = json.load(given)
with open(sys.argv[2], "w") as result:
    json.dump(measure(task["law"], task["points"]), result)
