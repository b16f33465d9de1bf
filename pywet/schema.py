"""Schema of what a moist run writes: event log, contact log, snapshots of the liquid, ledger.

The engine's plugin appends fixed-size little-endian records (`numpy` dtypes below, packed) to raw files; the driver turns
them into Parquet tables with the same column names (vectors become three columns: `xi` -> `xi_x, xi_y, xi_z`). SI units.

Partners: `i` is always a sphere's id. `partner_kind` 0: `j` is a sphere's id (i < j). 1: `j` is a large wall part, 2: `j` is
a small wall part (a wire); parts are numbered through all meshes in scene order; `triangle` is the closest triangle, numbered
through all meshes in scene order and file order (-1 for sphere-sphere).

n points from j to i. Forces and torques act on i (torque_j on j). Velocities are those of the force evaluation.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

FORMATION, RUPTURE, RETIREMENT = 0, 1, 2
SPHERE, LARGE_WALL, SMALL_WALL = 0, 1, 2
NOTHING = 3
CODES: dict[str, dict[int, str]] = {
    "kind": {
        FORMATION: "a bridge forms",
        RUPTURE: "a bridge breaks",
        RETIREMENT: "a bridge ends since one of its spheres is retired",
    },
    "partner_kind": {
        SPHERE: "j is a sphere",
        LARGE_WALL: "j is a part of a wall, flat or wide against spheres",
        SMALL_WALL: "j is a part of a wall thinner than the sphere, such as a wire",
        NOTHING: "of a drop that met nothing below: its liquid has left",
    },
}
"""Column -> meaning of its codes."""
RESERVOIRS = {
    "wires": "the screen's wires",
    "side_wall": "walls above the screen",
    "feed_bin": "the bin above",
    "slide": "the feed bin's floor, which is drawn away",
    "impact_plate": "the plate below the screen",
    "outlet": "the way out",
    "collecting_bin": "the bin below",
    "wall": "every wall of a custom scene: there `mesh` is the wall's name",
}
"""Value of the column `reservoir` -> where the liquid is.

Tables contain these names; walls_*.vtu have numbers, in the order of a run's walls, and list the names in their field
data `reservoir_from_0`.
"""
_STEP = "step i8 - number of the time step"
_TIME = f"""{_STEP}
time f8 s from the start of the run"""
_PARTNERS = """partner_kind i4 - see the codes of partner_kind
i i4 - sphere
j i4 - sphere or part of a wall, numbered through all walls"""
_TRIANGLE = "triangle i4 - closest triangle, numbered through all walls; -1 between spheres"
_PAD = "pad i4 - nothing"
_TEXT = {
    "events": f"""{_TIME}
kind i4 - see the codes of kind
{_PARTNERS}
{_TRIANGLE}
{_PAD}
volume f8 m3 of the bridge, after formation or before rupture
share_i f8 m3 drawn from i at formation, given to i at rupture
share_j f8 m3 the same of j
film_i_before f8 m3 liquid held as film on i at the start of the step
film_i_after f8 m3 the same after all formations and ruptures of this step
film_j_before f8 m3 on j; of a wall, all of the film there
film_j_after f8 m3 the same after all formations and ruptures of this step
separation f8 m S at the event
rupture_distance f8 m static S_rup(V)
speed f8 m/s relative velocity of the centres, or of sphere and wall""",
    "contacts": f"""{_TIME}
{_PARTNERS}
{_TRIANGLE}
xi f8x3 m centre of i
vi f8x3 m/s velocity of i
wi f8x3 1/s spin of i
xj f8x3 m centre of j; of a wall, the closest point
vj f8x3 m/s velocity of j, or of the wall there
wj f8x3 1/s spin of j; of a wall, zero
volume f8 m3 of the bridge
separation f8 m S, negative in overlap
rupture_distance f8 m with the dynamic factor when that effect is on
capillary f8 N magnitude, attraction positive
viscous_normal f8 N component along n on i, as it acts
viscous_tangential f8x3 N on i, as it acts
force_i f8x3 N sum of the above on i
torque_i f8x3 N.m on i
torque_j f8x3 N.m on j
viscous_law f8 N what the law of the normal viscous force gives at the velocities above
factor_normal f8 - 1/(1 + c dt/m), 1 with explicit integration
factor_tangential f8 - the same of the tangential force
sharing_i i4 - semi-implicit: bridges that share the mass of i; 0 for a driven sphere, and explicit
sharing_j i4 - the same of j
push f8x3 m/s semi-implicit: change of v_i - v_j in the step by all other forces
spin_push f8x3 m/s the same of r_i w_i + r_j w_j
weight f8 - steps for which these forces act, at once: 1, with bridges_every k at formation (k - 1)/2, then k""",
    "ledger": f"""{_TIME}
films f8 m3 on all spheres
bridges f8 m3 in all bridges
walls f8 m3 on all walls
left f8 m3 of drops that met nothing below them
retired f8 m3 with the spheres that were retired
initial f8 m3 what was put in
spheres i8 - spheres in the box
bridge_count i8 - active bridges
formations i8 - since the start
ruptures i8 - since the start, with the bridges that ended since a sphere was retired""",
    "bridges": f"""{_STEP}
{_PARTNERS}
{_TRIANGLE}
volume f8 m3 of the bridge
share_i f8 m3 what i would get if it ruptured now
separation f8 m S, negative in overlap
xi f8x3 m centre of i
xj f8x3 m centre of j; of a wall, the closest point
capillary_impulse f8 N.s of the capillary force since the output before, attraction positive
viscous_impulse f8 N.s of the normal viscous force, component along n on i
least_separation f8 m since the output before, at steps at which the bridge acts
largest_separation f8 m the same""",
    "impulses": f"""{_STEP}
id i4 - sphere
{_PAD}
impulse f8x3 N.s of the forces of all its bridges since the output before""",
    "films": f"""{_STEP}
id i4 - sphere
{_PAD}
film f8 m3 liquid held as film""",
    "wall_films": f"""{_STEP}
triangle i4 - wet triangle, numbered through all walls
{_PAD}
film f8 m3 liquid held as film""",
    "energy": f"""{_TIME}
kinetic f8 J of the spheres that are not driven
spin f8 J the same of their spin
capillary_stored f8 J -integral of the force from S to the static rupture distance, active bridges
formed f8 J the same at formation, summed over all formations
ruptured f8 J the same at rupture, summed over all ruptures
gravity f8 J work on the spheres since the start
contact f8 J work of dry contacts, relative motion
capillary f8 J work of the capillary forces
viscous_normal f8 J work of the normal viscous forces
viscous_tangential f8 J work of the tangential viscous forces
wall_motion f8 J given by moving walls, through contacts and bridges
drive f8 J given by driven spheres, and kinetic energy that liquid brings or takes (liquid_weight)
half_kick f8 J kinetic + spin - (the same at the start) - sum of the works, in exact arithmetic""",
    "wire_springs": f"""{_STEP}
mesh i4 - number in the scene
triangle i4 - the wire's first one, numbered within the mesh: it represents the whole wire
i i4 - sphere
{_PAD}
spring f8x3 m tangential spring, which the engine does not hold""",
    "states": f"""{_TIME}
id i4 - sphere
type i4 - class of spheres, numbered from 1
x f8x3 m centre
v f8x3 m/s velocity
w f8x3 1/s spin""",
    "poses": f"""{_STEP}
mesh i4 - number in the scene
{_PAD}
shift f8x3 m a point y at rest is at turn y + shift
turn_0 f8x3 - first row of the rotation
turn_1 f8x3 - second row
turn_2 f8x3 - third row
velocity f8x3 m/s of the point at y = 0
spin f8x3 1/s of the mesh""",
    "retired": f"""{_TIME}
id i4 - sphere
type i4 - its class
outlet i4 - number of the outlet in the scene, from 1 on; 0: the collecting bin
{_PAD}
film f8 m3 liquid with which it left: its film, and its shares of the bridges that ended with it
x f8x3 m centre
v f8x3 m/s velocity""",
    "felt": f"""{_STEP}
id i4 - one of some sampled spheres
{_PAD}
film f8 m3 liquid held as film, before drops fall
v f8x3 m/s velocity
felt f8x3 m/s2 specific force that the film feels""",
    "drops": f"""{_TIME}
partner_kind i4 - of what it lands on, see the codes of partner_kind
i i4 - the sphere it leaves
j i4 - sphere or triangle it lands on, -1: none
{_PAD}
volume f8 m3 of the drop
film_i_before f8 m3 on i before this drop is booked
film_j_before f8 m3 on j; where it met nothing, what had left before
fallen f8 m from the centre of i to where it lands
felt f8x3 m/s2 specific force that the film felt: 9.81 upwards at rest
x f8x3 m centre of i""",
}
"""Raw table -> a line for each column: name, type, unit, meaning. All definitions below are derived from it."""
_TEXT["window_energy"] = _TEXT["energy"]


def _record(text: str) -> np.dtype:
    """Return the packed record type of a raw table."""
    fields: list[Any] = []
    for line in text.splitlines():
        name, kind, _ = line.split(maxsplit=2)
        one, _, many = kind.partition("x")
        fields.append((name, f"<{one}", int(many)) if many else (name, f"<{one}"))
    return np.dtype(fields)


RAW = {name: _record(text) for name, text in _TEXT.items()}
"""Table name -> record type; raw file `engine/<name>.<rank>.bin`, table `history/<name>.parquet`."""
_OF_ENERGY = list(RAW["energy"].fields or ())
WORKS = _OF_ENERGY[_OF_ENERGY.index("gravity") : _OF_ENERGY.index("drive") + 1]
"""Columns of works among them."""

_MEANINGS = {
    **{f"history/{name}": text for name, text in _TEXT.items()},
    "trajectory": f"""{_TIME}
id i8 - sphere
type i8 - class of spheres, numbered from 1
x f8 m centre
y f8 m centre
z f8 m centre
vx f8 m/s velocity
vy f8 m/s velocity
vz f8 m/s velocity
wx f8 1/s spin
wy f8 1/s spin
wz f8 1/s spin""",
    "results/contact_statistics": f"""{_STEP}
time_s f8 s from the start of the run
contacts_per_sphere f8 - other spheres that a sphere touches, mean
mean_overlap f8 - of touching pairs, over the smaller radius
largest_overlap f8 - of touching pairs, over the smaller radius
walls_per_sphere f8 - walls that a sphere touches, mean
mean_wall_overlap f8 - of a sphere with a wall that it touches, over the radius
largest_wall_overlap f8 - of a sphere with a wall that it touches at this output, over the radius
largest_wall_penetration f8 - the same over the wall's thickness; between two outputs an impact may go deeper
bridges_per_sphere f8 - bridges that a sphere has, mean; those at walls count twice
mean_speed_m_per_s f8 m/s of all spheres
largest_speed_m_per_s f8 m/s of all spheres
centre_of_mass_height_m f8 m against gravity, from the origin""",
}
"""Table with the same columns in every run -> a line for each column: name, type, unit, meaning."""
INTEGER, NUMBER, ANY = "integer", "number", "anything"


def _columns(table: str) -> Iterator[tuple[str, str, str, str]]:
    """Yield name, type, unit and meaning of each column; a vector has three columns, padding none."""
    for line in _MEANINGS.get(table, "").splitlines():
        name, kind, unit, meaning = line.split(maxsplit=3)
        if name != "pad":
            for end in ("_x", "_y", "_z") if "x" in kind else ("",):
                yield name + end, INTEGER if kind.startswith("i") else NUMBER, unit, meaning


def _all(kind: str, *names: str) -> dict[str, str]:
    return dict.fromkeys(names, kind)


CORNERS = [f"v{k}_{axis}" for k in range(3) for axis in "xyz"]
_TIMES = ("time_s", "time_since_opening_s")
_NAMED = _all(ANY, "mesh", "reservoir")
TABLES: dict[str, dict[str, str]] = {
    **{table: {name: holds for name, holds, *_ in _columns(table)} for table in _MEANINGS},
    "history/spheres": {**_all(INTEGER, "id", "type"), **_all(NUMBER, "radius", "film")},
    "history/triangles": {**_all(INTEGER, "triangle", "part"), **_NAMED, **_all(NUMBER, "area", *CORNERS)},
    "history/parts": {
        **_all(INTEGER, "part", "part_class"),
        **_NAMED,
        "half_width": ANY,
        **_all(NUMBER, "contact_angle", "area"),
    },
    "mesh_motion": {"step": INTEGER, "mesh": ANY, **_all(NUMBER, "dx", "dy", "dz")},
    "results/fraction_retained": {"step": INTEGER, **_all(NUMBER, *_TIMES, "fraction_retained")},
    "results/liquid_by_holder": {"step": INTEGER, **_all(NUMBER, *_TIMES, "total_m3", "initial_m3")},
}
"""Table of a run directory, without its suffix -> type of each column; NaN is allowed only for ANY."""


def meanings(table: str) -> dict[str, tuple[str, str]]:
    """Return column -> (unit, meaning) of a table such as `history/events` or `trajectory`; unit - if it has none."""
    return {name: (unit, meaning) for name, _, unit, meaning in _columns(table)}


MAY_BE_EMPTY = {
    "history/drops",
    "history/felt",
    "history/retired",
    "history/energy",
    "history/impulses",
    "history/window_energy",
    "history/events",
    "history/contacts",
    "history/bridges",
    "history/films",
    "history/wall_films",
    "mesh_motion",
}
"""Tables of a complete run that may be empty."""


def column(prefix: str, class_name: str, unit: str = "") -> str:
    """Name of a column of one size class, such as `fraction_retained_pom_5_mm`."""
    slug = re.sub(r"[^a-z0-9]+", "_", class_name.lower()).strip("_")
    return f"{prefix}_{slug}{unit}"


def expected_columns(path: Path) -> Mapping[str, str]:
    """Return the columns that a table of a run directory must have; none for other files."""
    return TABLES.get(_name(path), {})


def needs_rows(path: Path) -> bool:
    """Return whether a table of a run directory cannot be empty."""
    return _name(path) in TABLES.keys() - MAY_BE_EMPTY


def _name(path: Path) -> str:
    inside = f"{path.parent.name}/{path.stem}"
    return inside if inside in TABLES else path.stem


UNIT = re.compile(r"_((?:mm|um|m3|m|g|kg|N|Pa|s|deg|rad|Hz|J)(?:_per_[a-z0-9]+|_s(?![a-z]))?2?)$")


def unit_of(key: str) -> str:
    """The unit that a key or column ends in; empty where it ends in none.

    >>> unit_of("stiffness_N_per_m"), unit_of("gravity_m_per_s2"), unit_of("viscosity_Pa_s"), unit_of("count")
    ('N/m', 'm/s2', 'Pa s', '')
    """
    named = {"percent": "%", "liquid_percent": "%", "turns_per_minute": "1/min"}
    last = key.removesuffix(".value").rpartition(".")[2]
    found = UNIT.search(last)
    return named.get(last) or (found[1].replace("_per_", "/").replace("_", " ") if found else "")
