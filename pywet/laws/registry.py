"""Finds laws by kind and name: built in, published through the entry-point group `pywet.laws`, or `path/to/file.py:function`."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from pywet.errors import LawError, PywetError
from pywet.laws import (
    buck,
    capillary,
    capillary_fits,
    davis,
    formation,
    own,
    rupture,
    transfer,
    transfer_exact,
    viscous,
    young_laplace,
)
from pywet.laws.force_law import ForceLaw, check

GROUP = "pywet.laws"
"""Entry-point group of published laws."""

SIGNATURES: dict[str, tuple[tuple[str, ...], ...]] = {
    "capillary": (
        ("separation", "volume", "radius_i", "radius_j", "contact_angle_i", "contact_angle_j", "surface_tension"),
    ),
    "viscous_normal": (("separation", "volume", "radius_i", "radius_j", "normal_velocity", "viscosity"),),
    "viscous_tangential": (("separation", "radius_i", "radius_j", "viscosity"),) * 2,
    "rupture": (("volume", "radius_i", "radius_j", "contact_angle_i", "contact_angle_j"),),
    "dynamic_rupture": (("speed", "viscosity", "surface_tension"),),
    "formation": (
        ("film_volume_i", "radius_i", "radius_j"),
        ("film_volume_i", "radius_i", "half_width"),
        ("film_thickness", "radius_i"),
        ("film_thickness", "radius_i", "half_width"),
    ),
    "transfer": (),
}
"""Arguments of each function of a law, by kind."""


Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Law:
    """A named law: one function, or the few that make it up."""

    name: str
    kind: str
    functions: tuple[ForceLaw, ...]

    def prepare(self, angles: Iterable[tuple[float, float]], progress: Progress | None = None) -> None:
        """Have ready what compiled code will ask for: tables for pairs of contact angles (smaller body, larger body) [rad]."""
        if any(isinstance(function, young_laplace.TableLaw) for function in self.functions):
            young_laplace.prepare(angles, progress)


BUILT_IN: dict[str, dict[str, tuple[ForceLaw, ...]]] = {
    "capillary": {
        "rabinovich": (capillary.rabinovich,),
        "rabinovich_small_gap": (capillary.rabinovich_small_gap,),
        "rabinovich_as_printed": (capillary.rabinovich_as_printed,),
        "lambert": (capillary.lambert,),
        "willett": (capillary_fits.willett,),
        "willett_simple": (capillary_fits.willett_simple,),
        "willett_simple_as_printed": (capillary_fits.willett_simple_as_printed,),
        "weigert": (capillary_fits.weigert,),
        "weigert_as_printed": (capillary_fits.weigert_as_printed,),
        "soulie": (capillary_fits.soulie,),
        "bagheri": (capillary_fits.bagheri,),
        "young_laplace": (young_laplace.young_laplace,),
        "buck": (buck.buck,),
    },
    "viscous_normal": {
        "pitois": (viscous.pitois,),
        "adams_perchard": (viscous.adams_perchard,),
        "buck_water": (buck.buck_water,),
    },
    "viscous_tangential": {
        "goldman": (viscous.goldman_translation, viscous.goldman_rotation),
        "lian": (viscous.lian_translation, viscous.lian_rotation),
        "buck": (buck.buck_translation, buck.buck_rotation),
    },
    "rupture": {
        "willett_unequal": (rupture.willett_unequal,),
        "willett_unequal_as_printed": (rupture.willett_unequal_as_printed,),
        "willett": (rupture.willett,),
        "lian": (rupture.lian,),
        "young_laplace": (young_laplace.young_laplace_rupture,),
        "buck": (buck.buck_rupture,),
    },
    "dynamic_rupture": {"pitois": (rupture.pitois_dynamic,)},
    "formation": {
        "shi_mccarthy": (
            formation.formation_sphere,
            formation.formation_sphere_wire,
            formation.formation_wall,
            formation.formation_wire,
        )
    },
    "transfer": {"parabola": (), "young_laplace": (), "half": ()},
}
BUILT_IN["capillary"]["davis"] = (davis.capillary,)
BUILT_IN["viscous_normal"]["davis"] = (davis.normal,)
BUILT_IN["viscous_tangential"]["davis"] = davis.TANGENTIAL
BUILT_IN["rupture"]["davis"] = (davis.rupture,)
BUILT_IN["formation"]["davis"] = davis.FORMATION


TRANSFER = {
    "parabola": transfer.transfer_table,
    "young_laplace": transfer_exact.exact_table,
    "half": transfer.halves,
}
"""Transfer models: functions that give a table over V*, see `transfer_table`."""


def transfer_model(name: str) -> Callable[..., transfer.Floats]:
    """The function that tabulates a transfer model."""
    get("transfer", name)
    return TRANSFER[name]


def names(kind: str) -> list[str]:
    """Names of the laws of a kind: built in, and published ones whose arguments are those of the kind."""
    _check_kind(kind)
    return sorted({*BUILT_IN[kind], *(p.name for p in entry_points(group=GROUP) if _fits(kind, p))})


@cache
def get(kind: str, name: str) -> Law:
    """The law of that kind and name; a user's own law is checked on a probe grid first."""
    _check_kind(kind)
    if name in BUILT_IN[kind]:
        return Law(name, kind, BUILT_IN[kind][name])
    published = {p.name: p for p in entry_points(group=GROUP)}
    if name in published:
        functions = _load(published[name])
    elif own.is_own(name):
        functions = own.functions(kind, name)
    else:
        raise LawError(
            f"there is no {kind} law named {name}; expected one of {', '.join(names(kind))}, or path/to/file.py:function",
            law=name,
        )
    return checked(kind, name, functions)


def checked(kind: str, name: str, functions: Any) -> Law:
    """A law made of what a file or a package gave, tried on the probe grid."""
    law = Law(name, kind, functions if isinstance(functions, tuple) else (functions,))
    _check_own(law)
    return law


def _check_kind(kind: str) -> None:
    if kind not in SIGNATURES:
        raise LawError(f"there is no kind of law named {kind}; expected one of {', '.join(SIGNATURES)}", law=kind)


def _load(point: EntryPoint) -> Any:
    try:
        return point.load()
    except (Exception, SystemExit) as error:
        raise LawError(
            f"law {point.name}: {point.value} raises {type(error).__name__}: {error}; mend or uninstall the package that "
            f"publishes it in the entry-point group {GROUP}",
            law=point.name,
        ) from error


def _fits(kind: str, point: EntryPoint) -> bool:
    try:
        found = _load(point)
    except PywetError:
        return False  # it is refused when it is asked for by name
    functions = found if isinstance(found, tuple) else (found,)
    return tuple(getattr(f, "arguments", ()) for f in functions) == SIGNATURES[kind]


def _check_own(law: Law) -> None:
    wanted = SIGNATURES[law.kind]
    if not wanted:
        raise LawError(
            f"law {law.name}: a {law.kind} law cannot be a user's own; expected {', '.join(names(law.kind))}",
            law=law.name,
        )
    if not all(isinstance(f, ForceLaw) for f in law.functions):
        raise LawError(
            f"law {law.name} is not decorated with @force_law (a tuple of such functions where a kind has many)",
            law=law.name,
        )
    if len(law.functions) != len(wanted):
        raise LawError(
            f"law {law.name} has {len(law.functions)} functions; expected {len(wanted)} for {law.kind}", law=law.name
        )
    for function, arguments in zip(law.functions, wanted, strict=True):
        turning = law.kind == "viscous_tangential" and function is not law.functions[0]
        check(function, arguments, None if turning else law.kind)  # what a turn adds to the drag may have either sign
