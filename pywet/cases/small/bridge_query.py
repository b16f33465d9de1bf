"""`pywet bridge FILE.json`: force over separation of one bridge by any laws and by the exact solution. JSON in, JSON out.

`bridge_engine.py` measures the same in an engine. No physics here: laws and the exact bridge are called.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, ValidationError, model_validator
from scipy.optimize import brentq

from pywet.config.entries import Excusable
from pywet.config.messages import mistake
from pywet.errors import PywetError, one_line
from pywet.laws import custom_laws, registry
from pywet.laws import exact_bridge as young_laplace
from pywet.laws.contact import bridge_radius, film_volume
from pywet.laws.kinds import PRESETS
from pywet.schema import LARGE_WALL, SPHERE
from pywet.strict import Strict
from pywet.util.files import read_json

EXACT = "young_laplace"
DEFAULT = {kind: PRESETS["paper"][kind] for kind in ("capillary", "viscous_normal", "rupture")}
"""Default laws of each kind if the file names none."""


OPTIONAL = ("viscous_tangential", "dynamic_rupture", "formation")
"""Kinds that are evaluated only if one of their laws is named."""

LENGTH = {"ge": 1e-9, "le": 10.0}
"""Allowed lengths [m], from the size of molecules to beyond any grain."""
Radius = Annotated[float, Field(**LENGTH)]
Volume = Annotated[float, Field(ge=1e-30, le=1e3)]
Coefficient = Annotated[float, Field(ge=0, le=1e6)]
Speed = Annotated[float, Field(ge=-1e6, le=1e6)]
Separation = Annotated[float, Field(ge=-10.0, le=10.0)]


class Body(Strict):
    """Describe a body at an end of the bridge: a sphere or a large wall."""

    radius_m: Radius | None = None
    wall: Literal["large"] | None = None
    contact_angle_deg: Annotated[float, Field(ge=0, lt=90)]

    @model_validator(mode="after")
    def _one(self) -> Body:
        if (self.radius_m is None) == (self.wall is None):
            raise ValueError('a body has either "radius_m" or "wall": "large"')
        return self

    @property
    def radius(self) -> float:
        """Radius [m], infinite for a wall."""
        return math.inf if self.radius_m is None else self.radius_m

    @property
    def angle(self) -> float:
        """Contact angle [rad]."""
        return math.radians(self.contact_angle_deg)


class Query(Excusable):
    """Query about one bridge: two bodies, the liquid between them, separations and laws."""

    bodies: Annotated[tuple[Body, ...], Field(min_length=2, max_length=2)]
    volume_m3: Volume
    surface_tension_N_per_m: Coefficient
    viscosity_Pa_s: Coefficient = 0.0
    velocity_m_per_s: Speed = 0.0
    separations_m: Annotated[tuple[Separation, ...], Field(min_length=1, max_length=100_000)]
    laws: tuple[str, ...] = ()

    @model_validator(mode="after")
    def _sphere_first(self) -> Query:
        if self.bodies[0].wall is not None:
            raise ValueError('the first body is a wall; expected the sphere first and "wall": "large" second')
        smaller = 4.0 / 3.0 * math.pi * min(body.radius for body in self.bodies) ** 3
        if self.volume_m3 > smaller:
            raise ValueError(
                f"volume_m3 at most that of the smaller sphere ({smaller:.3g} m3), which the bridge would enclose"
            )
        return self

    @property
    def pair(self) -> tuple[float, float, float, float]:
        """Return radii [m] and contact angles [rad]."""
        i, j = self.bodies
        return i.radius, j.radius, i.angle, j.angle

    def named(self, kind: str) -> list[str]:
        """Return the requested laws of a kind."""
        wanted = [
            n
            for n in self.laws
            if (custom_laws.kind_of(n) == kind if custom_laws.is_custom(n) else n in registry.names(kind))
        ]
        if wanted or kind not in DEFAULT:
            return wanted
        return [DEFAULT[kind]] if self.laws else [*registry.BUILT_IN[kind]]

    @property
    def rule(self) -> str:
        """Return the rupture law that ends the closed forms: the first one that is not also a force law here, or the paper's."""
        elsewhere = {name for kind in DEFAULT if kind != "rupture" for name in registry.names(kind)}
        return next((n for n in self.named("rupture") if n not in elsewhere), DEFAULT["rupture"])


def read(path: Path) -> Query:
    return checked(read_json(path, "see the form in docs/bridge.md"), path)


def checked(given: Any, path: Path) -> Query:
    try:
        query = Query.model_validate(given)
    except ValidationError as error:
        raise mistake(error, Query, str(path), given) from error
    query = query.model_copy(update={"laws": tuple(custom_laws.placed(name, Path(path).parent) for name in query.laws)})
    known = {name for kind in (*DEFAULT, *OPTIONAL) for name in registry.names(kind)}
    for name in query.laws:
        if custom_laws.is_custom(name) and custom_laws.kind_of(name) not in (*DEFAULT, *OPTIONAL):
            raise PywetError(
                f"{path}: {name} is a law of {custom_laws.kind_of(name)}, which a static bridge does not use; expected one of "
                f"{', '.join((*DEFAULT, *OPTIONAL))}: fix laws",
                code="bridge.law_kind", key="laws", given=name, where=path,
            )  # fmt: skip
        if name not in known and not custom_laws.is_custom(name):
            raise PywetError(
                f"{path}: there is no law named {one_line(name)}; expected names from {', '.join(sorted(known))}: fix laws",
                code="bridge.unknown_law", key="laws", given=name, expected=sorted(known), where=path,
            )  # fmt: skip
    return query


def answer(query: Query) -> dict[str, Any]:
    """Answer the query with the laws in Python and the exact solution."""
    ri, rj, ti, tj = query.pair
    volume, sigma = query.volume_m3, query.surface_tension_N_per_m
    gaps = np.array(query.separations_m)
    limit = young_laplace.rupture(volume, ri, rj, ti, tj)
    ends = dict.fromkeys([*query.named("rupture"), query.rule])
    distances = {
        name: registry.get("rupture", name).functions[0](volume, ri, rj, ti, tj) for name in ends if name != EXACT
    }
    distances[EXACT] = limit.separation
    bridges = solved(query)
    angles = [b.half_filling_angles if b else (math.nan, math.nan) for b in bridges]
    rule = query.rule
    forces = {}
    for name in query.named("capillary"):
        if name == EXACT:
            forces[name] = [None if b is None else b.force(sigma) for b in bridges]
        else:
            law = registry.get("capillary", name).functions[0]
            forces[name] = _until(distances[rule], gaps, law(gaps, volume, ri, rj, ti, tj, sigma), name)
    viscous = {}
    for name in query.named("viscous_normal"):
        law = registry.get("viscous_normal", name).functions[0]
        values = -law(gaps, volume, ri, rj, query.velocity_m_per_s, query.viscosity_Pa_s)
        viscous[name] = _until(distances[rule], gaps, values + 0.0, name)
    stretch = (query.named("dynamic_rupture") or ["pitois"])[0]
    factor = registry.get("dynamic_rupture", stretch).functions[0]
    sliding = {
        name: [[_finite(float(v), name) for v in law(gaps, ri, rj, query.viscosity_Pa_s) + 0.0 * gaps] for law in laws]
        for name in query.named("viscous_tangential")
        for laws in [registry.get("viscous_tangential", name).functions]
    }
    drawing = query.named("formation")
    return {
        "force_N": forces,
        "viscous_normal_N": viscous,
        "rupture_distance_m": distances,
        "rupture_kind": limit.kind,
        "rupture_used_m": {name: distances[EXACT if name == EXACT else rule] for name in (*forces, *viscous)},
        "dynamic_rupture_factor": _finite(
            float(factor(abs(query.velocity_m_per_s), query.viscosity_Pa_s, sigma)), stretch
        ),
        **({"viscous_tangential_kg_per_s": sliding} if sliding else {}),
        **({"film_thickness_m": {name: film(query, name) for name in drawing}} if drawing else {}),
        "transfer_ratio": {name: _share(query, name) for name in registry.TRANSFER},
        "half_filling_angle_deg": {
            "body_1": [_degrees(a) for a, _ in angles],
            "body_2": None if math.isinf(rj) else [_degrees(a) for _, a in angles],
        },
    }


def solved(query: Query) -> list[young_laplace.Bridge | None]:
    """The exact bridge at each separation; None beyond its rupture."""
    return young_laplace.solve_many(query.separations_m, query.volume_m3, *query.pair)


def exact_force(query: Query) -> list[float | None]:
    """Force of the exact bridge [N] at each separation of the query."""
    return [None if b is None else b.force(query.surface_tension_N_per_m) for b in solved(query)]


def pull_off(query: Query) -> float:
    """Return the largest force [N] over the separations by the only capillary law of the query."""
    names = query.named("capillary")
    if len(names) != 1:
        raise PywetError(
            f"a pull-off force is requested for {', '.join(names)}; expected one capillary law: fix laws",
            code="bridge.capillary_laws", key="laws", given=names,
        )  # fmt: skip
    ri, rj, ti, tj = query.pair
    if names[0] == EXACT:
        return max((force for force in exact_force(query) if force is not None), default=0.0)
    law = registry.get("capillary", names[0]).functions[0]
    gaps = np.array(query.separations_m)
    forces = law(gaps, query.volume_m3, ri, rj, ti, tj, query.surface_tension_N_per_m)
    return _finite(float(np.where(gaps <= rupture_distance(query), forces, 0.0).max()), names[0])


def rupture_distance(query: Query) -> float:
    """Rupture distance [m] by the query's rule."""
    if query.rule == EXACT:
        return young_laplace.rupture(query.volume_m3, *query.pair).separation
    return float(registry.get("rupture", query.rule).functions[0](query.volume_m3, *query.pair))


def film(query: Query, name: str) -> float:
    """Return the thickness [m] of the film on the spheres for which a formation law draws the requested volume."""
    ri, rj, *_ = query.pair
    draw = registry.get("formation", name).functions[0]

    def drawn(thickness: float) -> float:
        volume = draw(film_volume(thickness, ri), ri, rj)
        return volume if query.bodies[1].wall else volume + draw(film_volume(thickness, rj), rj, ri)

    top = ri
    while drawn(top) < query.volume_m3:
        top *= 2.0
        if top > 1e9 * ri:
            raise PywetError(
                f"law {name} draws {query.volume_m3:g} m3 from no film, however thick; fix volume_m3",
                code="bridge.no_film", key="volume_m3", given=query.volume_m3,
            )  # fmt: skip
    return float(brentq(lambda h: drawn(h) / query.volume_m3 - 1.0, 0.0, top, xtol=1e-18, rtol=1e-15))


def _until(rupture: float, gaps: np.ndarray, values: np.ndarray, name: str) -> list[float | None]:
    """Return values up to the rupture distance, None beyond."""
    pairs = zip(gaps, np.broadcast_to(values, gaps.shape), strict=True)
    return [None if s > rupture else _finite(float(v), name) for s, v in pairs]


def _finite(value: float, name: str) -> float:
    if not math.isfinite(value):
        raise PywetError(
            f"law {name} gives {value} for this bridge; expected a number: fix the bodies, or leave it out",
            code="bridge.no_number", key=name, given=value,
        )  # fmt: skip
    return value


def _degrees(angle: float) -> float | None:
    return None if math.isnan(angle) else math.degrees(angle)


def _share(query: Query, model: str) -> float | None:
    """Return the share of the liquid that remains on body 1 at rupture; None if the model has no solution."""
    ri, rj, ti, tj = query.pair
    wall = math.isinf(rj)
    reduced = np.array([query.volume_m3 / bridge_radius(ri, rj) ** 3])
    table = registry.transfer_model(model)
    try:
        return float(table(ri, ri if wall else rj, ti, tj, LARGE_WALL if wall else SPHERE, reduced)[0])
    except PywetError:
        return None
