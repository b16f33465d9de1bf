"""Schema of what a moist run writes: event log, contact log, snapshots of the liquid, ledger.

The engine's plugin appends fixed-size little-endian records (`numpy` dtypes below, packed) to raw files; the driver turns
them into Parquet tables with the same column names (vectors become three columns: `xi` -> `xi_x, xi_y, xi_z`). SI units.

Partners: `i` is always a sphere's id. `partner_kind` 0: `j` is a sphere's id (i < j). 1: `j` is a large wall part, 2: `j` is
a small wall part (a wire); parts are numbered through all meshes in scene order; `triangle` is the closest triangle, numbered
through all meshes in scene order and file order (-1 for sphere-sphere).

n points from j to i. Forces and torques act on i (torque_j on j). Velocities are those of the force evaluation.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

FORMATION, RUPTURE = 0, 1
SPHERE, LARGE_WALL, SMALL_WALL = 0, 1, 2
NOTHING = 3
"""Partner of a drop that met nothing below: its liquid has left."""

EVENT = np.dtype(
    [
        ("step", "<i8"),
        ("time", "<f8"),
        ("kind", "<i4"),  # FORMATION or RUPTURE
        ("partner_kind", "<i4"),
        ("i", "<i4"),
        ("j", "<i4"),
        ("triangle", "<i4"),
        ("pad", "<i4"),
        ("volume", "<f8"),  # of the bridge, after formation / before rupture [m3]
        ("share_i", "<f8"),  # drawn from i at formation / given to i at rupture [m3]
        ("share_j", "<f8"),
        ("film_i_before", "<f8"),  # liquid held as film on i at the start of the step [m3]
        ("film_i_after", "<f8"),  # the same after all formations and ruptures of this step [m3]
        ("film_j_before", "<f8"),  # for a wall: on the triangle
        ("film_j_after", "<f8"),
        ("separation", "<f8"),  # S at the event [m]
        ("rupture_distance", "<f8"),  # static S_rup(V) [m]
        ("speed", "<f8"),  # |relative velocity of the centres| (sphere against wall velocity) [m/s]
    ]
)

CONTACT = np.dtype(
    [
        ("step", "<i8"),
        ("time", "<f8"),
        ("partner_kind", "<i4"),
        ("i", "<i4"),
        ("j", "<i4"),
        ("triangle", "<i4"),
        ("xi", "<f8", 3),
        ("vi", "<f8", 3),
        ("wi", "<f8", 3),
        ("xj", "<f8", 3),  # wall: the closest point
        ("vj", "<f8", 3),  # wall: velocity of the wall
        ("wj", "<f8", 3),  # wall: zero
        ("volume", "<f8"),
        ("separation", "<f8"),
        ("rupture_distance", "<f8"),  # with the dynamic factor when that effect is on
        ("capillary", "<f8"),  # magnitude, attraction positive [N]
        ("viscous_normal", "<f8"),  # component along n on i, as it acts [N]
        ("viscous_tangential", "<f8", 3),  # on i, as it acts [N]
        ("force_i", "<f8", 3),  # sum of the above on i [N]
        ("torque_i", "<f8", 3),
        ("torque_j", "<f8", 3),
        ("viscous_law", "<f8"),  # what the law of the normal viscous force gives at the velocities above [N]
        ("factor_normal", "<f8"),  # 1/(1 + c dt/m), 1 with explicit integration
        ("factor_tangential", "<f8"),
        ("sharing_i", "<i4"),  # semi-implicit: bridges that share the mass of i; 0 for a driven sphere, and explicit
        ("sharing_j", "<i4"),
        ("push", "<f8", 3),  # semi-implicit: change of v_i - v_j in the step by all other forces [m/s]
        ("spin_push", "<f8", 3),  # the same of r_i w_i + r_j w_j
        (
            "weight",
            "<f8",
        ),  # steps for which these forces act, at once: 1, with bridges_every k at formation (k - 1)/2, then k
    ]
)

LEDGER = np.dtype(
    [
        ("step", "<i8"),
        ("time", "<f8"),
        ("films", "<f8"),  # sum over spheres [m3]
        ("bridges", "<f8"),
        ("walls", "<f8"),
        ("left", "<f8"),  # liquid of drops that met nothing below them
        ("initial", "<f8"),
        ("spheres", "<i8"),  # number of spheres in the box
        ("bridge_count", "<i8"),
        ("formations", "<i8"),  # since the start
        ("ruptures", "<i8"),
    ]
)

BRIDGE = np.dtype(  # snapshot of standing bridges
    [
        ("step", "<i8"),
        ("partner_kind", "<i4"),
        ("i", "<i4"),
        ("j", "<i4"),
        ("triangle", "<i4"),
        ("volume", "<f8"),
        ("share_i", "<f8"),  # what i would get if it ruptured now [m3]
        ("separation", "<f8"),
        ("xi", "<f8", 3),
        ("xj", "<f8", 3),
    ]
)
ENERGY = np.dtype(  # at output steps, in joules; works are those on the spheres since the start
    [
        ("step", "<i8"),
        ("time", "<f8"),
        ("kinetic", "<f8"),  # of the spheres that are not driven
        ("spin", "<f8"),
        ("capillary_stored", "<f8"),  # -integral of the force from S to the static rupture distance, standing bridges
        ("formed", "<f8"),  # the same at formation, summed over all formations
        ("ruptured", "<f8"),  # the same at rupture, summed over all ruptures
        ("gravity", "<f8"),
        ("contact", "<f8"),  # dry contacts, relative motion
        ("capillary", "<f8"),
        ("viscous_normal", "<f8"),
        ("viscous_tangential", "<f8"),
        ("wall_motion", "<f8"),  # given by moving walls, through contacts and bridges
        ("drive", "<f8"),  # given by driven spheres, and kinetic energy that liquid brings or takes (liquid_weight)
        ("half_kick", "<f8"),  # kinetic + spin - (the same at the start) - sum of the works, in exact arithmetic
    ]
)
_OF_ENERGY = list(ENERGY.fields or ())
WORKS = _OF_ENERGY[_OF_ENERGY.index("gravity") : _OF_ENERGY.index("drive") + 1]
"""The works among them."""
FILM = np.dtype([("step", "<i8"), ("id", "<i4"), ("pad", "<i4"), ("film", "<f8")])  # snapshot; id: sphere id
WALL_FILM = np.dtype([("step", "<i8"), ("triangle", "<i4"), ("pad", "<i4"), ("film", "<f8")])  # snapshot, wet triangles
WIRE_SPRING = np.dtype(  # in windows: dry contacts with wires that are prisms, whose springs the engine does not hold
    [
        ("step", "<i8"),
        ("mesh", "<i4"),  # number in the scene
        ("triangle", "<i4"),  # the wire's first one, numbered within the mesh: it stands for the whole wire
        ("i", "<i4"),
        ("pad", "<i4"),
        ("spring", "<f8", 3),
    ]
)
DROP = np.dtype(  # booked after the formations and ruptures of its step
    [
        ("step", "<i8"),
        ("time", "<f8"),
        ("partner_kind", "<i4"),  # of what it lands on: SPHERE, LARGE_WALL, SMALL_WALL or NOTHING
        ("i", "<i4"),  # the sphere it leaves
        ("j", "<i4"),  # sphere or triangle it lands on, -1: none
        ("pad", "<i4"),
        ("volume", "<f8"),  # [m3]
        ("film_i_before", "<f8"),  # on i before this drop is booked [m3]
        ("film_j_before", "<f8"),  # on j; nothing: what had left before
        ("fallen", "<f8"),  # from the centre of i to where it lands [m]
        ("felt", "<f8", 3),  # specific force that the film felt: 9.81 upwards at rest [m/s2]
        ("x", "<f8", 3),  # centre of i [m]
    ]
)

RAW = {
    "events": EVENT,
    "contacts": CONTACT,
    "ledger": LEDGER,
    "bridges": BRIDGE,
    "films": FILM,
    "wall_films": WALL_FILM,
    "energy": ENERGY,
    "wire_springs": WIRE_SPRING,
    "drops": DROP,
}
"""Table name -> record type; raw file `engine/<name>.<rank>.bin`, table `history/<name>.parquet`."""

INTEGER, NUMBER, ANY = "integer", "number", "anything"


def _columns(record: np.dtype) -> dict[str, str]:
    """Columns of the table of a record type."""
    found = {}
    for name in record.names or ():
        field = record[name]
        kind = INTEGER if field.base.kind == "i" else NUMBER
        found.update({f"{name}_{axis}": kind for axis in "xyz"} if field.shape else {name: kind})
    found.pop("pad", None)
    return found


def _all(kind: str, *names: str) -> dict[str, str]:
    return dict.fromkeys(names, kind)


_CORNERS = [f"v{k}_{axis}" for k in range(3) for axis in "xyz"]
_TIMES = ("time_s", "time_since_opening_s")
_NAMED = _all(ANY, "mesh", "holder")
TABLES: dict[str, dict[str, str]] = {
    **{f"history/{name}": _columns(record) for name, record in RAW.items()},
    "history/spheres": {**_all(INTEGER, "id", "type"), **_all(NUMBER, "radius", "film")},
    "history/triangles": {**_all(INTEGER, "triangle", "part"), **_NAMED, **_all(NUMBER, "area", *_CORNERS)},
    "history/parts": {
        **_all(INTEGER, "part", "part_class"),
        **_NAMED,
        "half_width": ANY,
        **_all(NUMBER, "contact_angle", "area"),
    },
    "trajectory": {
        **_all(INTEGER, "step", "id", "type"),
        **_all(NUMBER, "time", *"xyz", *(f"{q}{axis}" for q in "vw" for axis in "xyz")),
    },
    "mesh_motion": {"step": INTEGER, "mesh": ANY, **_all(NUMBER, "dx", "dy", "dz")},
    "results/fraction_retained": {"step": INTEGER, **_all(NUMBER, *_TIMES, "fraction_retained")},
    "results/liquid_by_holder": {"step": INTEGER, **_all(NUMBER, *_TIMES, "total_m3", "initial_m3")},
}
"""Table of a run directory, without its suffix -> what each of its columns holds; NaN is a value only of ANY."""

MAY_BE_EMPTY = {
    "history/drops",
    "history/energy",
    "history/events",
    "history/contacts",
    "history/bridges",
    "history/films",
    "history/wall_films",
    "mesh_motion",
}
"""Tables of a whole run that may have no row."""


def expected_columns(path: Path) -> Mapping[str, str]:
    """What a table of a run directory must hold; nothing is known of other files."""
    return TABLES.get(_name(path), {})


def needs_rows(path: Path) -> bool:
    """Whether a table of a run directory cannot be empty."""
    return _name(path) in TABLES.keys() - MAY_BE_EMPTY


def _name(path: Path) -> str:
    inside = f"{path.parent.name}/{path.stem}"
    return inside if inside in TABLES else path.stem
