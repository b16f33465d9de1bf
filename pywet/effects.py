"""Effect plan: which effects a scene calls for, decided from dimensionless numbers against a stated tolerance.

Each row holds one effect: on or off, the number behind it and why. What is on is written into `Scene.effects`; a scene
without bridges runs on the stock engine. The numbers are estimates for equal spheres: they rank effects, no more.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from pywet.config.settings import EffectSettings, LawSettings
from pywet.errors import PywetError
from pywet.laws import registry
from pywet.scene import ContactPair, Effects, Liquid, SphereClass

GRAVITY = 9.81
S_MIN = 0.001
"""Smallest gap of the viscous laws over r_eff (Elskamp & Kruggel-Emden 2018, after (25))."""
WALL_SHARE = 0.5 * (1.0 - math.sqrt(0.75))
"""Share of its film that a sphere gives to a bridge with a large wall, E (9)."""

PRESETS: dict[str, dict[str, str]] = {
    "paper": {
        "capillary": "rabinovich",
        "viscous_normal": "pitois",
        "viscous_tangential": "goldman",
        "rupture": "willett_unequal",
        "dynamic_rupture": "pitois",
        "formation": "shi_mccarthy",
        "transfer": "parabola",
    },
    "exact": {
        "capillary": "young_laplace",
        "viscous_normal": "pitois",
        "viscous_tangential": "goldman",
        "rupture": "young_laplace",
        "dynamic_rupture": "pitois",
        "formation": "shi_mccarthy",
        "transfer": "young_laplace",
    },
}
"""Name of a preset -> law of each kind."""
BRIDGE_EFFECTS = ("capillary", "viscous_normal", "viscous_tangential", "dynamic_rupture")


@dataclass(frozen=True)
class EffectRow:
    """One effect: `number` is `quantity`, negligible below `threshold`; `law` is None where no law is named."""

    effect: str
    on: bool
    why: str
    quantity: str
    number: float
    threshold: float
    law: str | None = None

    @property
    def line(self) -> str:
        """The row as one line of text."""
        state = "on " if self.on else "off"
        law = f" [{self.law}]" if self.on and self.law else ""
        number = f"{self.quantity} = {self.number:.2g} (tolerance {self.threshold:g})"
        return f"{self.effect:<19}{state}  {number}: {self.why}{law}"


@dataclass(frozen=True)
class EffectPlan:
    """The outcome: rows to show, effects for the scene."""

    rows: tuple[EffectRow, ...]
    effects: Effects

    @property
    def lines(self) -> list[str]:
        """One line per effect."""
        return [row.line for row in self.rows]

    def as_dict(self) -> dict[str, Any]:
        """Plain data, as in plan.json."""
        return {"rows": [asdict(row) for row in self.rows], "effects": self.effects.model_dump()}


def plan(
    classes: Sequence[SphereClass],
    pairs: Sequence[ContactPair],
    liquid: Liquid | None,
    speed_m_per_s: float,
    settings: EffectSettings,
    laws: LawSettings,
) -> EffectPlan:
    """Decide every effect. `speed_m_per_s` is the speed of approach that matters, the screen's peak speed in screening.

    Raises `PywetError` when what is switched on needs what is off.
    """
    moist = liquid is not None and liquid.initial_film_thickness_m > 0
    numbers = effect_numbers(classes, pairs, liquid, speed_m_per_s)
    bridges = _bridges_row(moist, numbers["bridges"], settings)
    named = _laws(laws)
    rows = [bridges]
    for effect in BRIDGE_EFFECTS:
        rows.append(_row(effect, bridges.on, numbers[effect], settings, named[effect], f"preset {laws.preset}"))
    rows.append(_follows("wall_films", bridges.on, numbers["wall_films"], settings, named["formation"]))
    rows.append(_follows("sharing_by_size", bridges.on, numbers["sharing_by_size"], settings, named["transfer"]))
    rows.append(_row("rolling", True, numbers["rolling"], settings, None, "table 3"))
    on = {row.effect: row.on for row in rows}
    effects = Effects(
        bridges=bridges.on,
        rolling=on["rolling"],
        **{effect: named[effect] if on[effect] else None for effect in BRIDGE_EFFECTS},
        **{kind: named[kind] if bridges.on else None for kind in ("rupture", "formation", "transfer")},
    )
    return EffectPlan(tuple(rows), effects)


def effect_numbers(
    classes: Sequence[SphereClass], pairs: Sequence[ContactPair], liquid: Liquid | None, speed_m_per_s: float
) -> dict[str, tuple[str, float]]:
    """Effect -> what is compared, and its largest value over the classes present; zero without liquid."""
    present = [c for c in classes if c.count > 0]
    if not present:
        raise PywetError("the scene has no spheres, expected at least one; mend the case's amounts")
    radii = [c.radius_m for c in present]
    friction = {p.a: p.friction for p in pairs if p.a == p.b}
    turning = max(p.rolling_friction_m / (p.friction * classes[p.a - 1].radius_m) for p in pairs if p.friction > 0)
    wet = [_wet_numbers(c, friction[c.type], liquid, speed_m_per_s) for c in present] if liquid else [(0.0,) * 4]
    film, capillary, normal, tangential = (max(column) for column in zip(*wet, strict=True))
    stretch = math.sqrt(_capillary_number(liquid, speed_m_per_s)) if liquid else 0.0
    return {
        "bridges": ("film / radius", film),
        "capillary": ("capillary force at touch / weight (1/Bond number)", capillary),
        "viscous_normal": ("speed lost in the films, ln(gaps)/Stokes number", normal),
        "viscous_tangential": ("tangential viscous force / friction under own weight", tangential),
        "dynamic_rupture": ("stretch of the bridge, sqrt(capillary number)", stretch),
        "wall_films": ("share of a film drawn to a wall", WALL_SHARE if liquid else 0.0),
        "sharing_by_size": (
            "difference of radii / sum of radii",
            (max(radii) - min(radii)) / (max(radii) + min(radii)) if liquid else 0.0,
        ),
        "rolling": ("rolling friction / (friction x radius)", turning),
    }


def _wet_numbers(c: SphereClass, friction: float, liquid: Liquid, speed: float) -> tuple[float, float, float, float]:
    """Film over radius, capillary over weight, speed lost over speed, tangential viscous force over friction."""
    r, m, h = c.radius_m, c.mass_kg, liquid.initial_film_thickness_m
    r_red, m_eff, gap = 0.5 * r, 0.5 * m, S_MIN * r
    capillary = 2.0 * math.pi * r * liquid.surface_tension_N_per_m * math.cos(c.contact_angle_rad)
    drag = 6.0 * math.pi * liquid.viscosity_Pa_s * r_red
    lost = drag * r_red * math.log1p(2.0 * h / gap) / (m_eff * speed) if speed > 0 else math.inf
    slip = drag * (8.0 / 15.0 * math.log(r_red / gap) + 0.9588) * speed
    grip = friction * m * GRAVITY
    return h / r, abs(capillary) / (m * GRAVITY), min(lost, 1.0), slip / grip if grip > 0 else 1.0


def _capillary_number(liquid: Liquid, speed: float) -> float:
    """Viscous over surface tension force, speed x viscosity / surface tension."""
    return speed * liquid.viscosity_Pa_s / liquid.surface_tension_N_per_m if liquid.surface_tension_N_per_m > 0 else 0.0


def _laws(laws: LawSettings) -> dict[str, str]:
    """Law of each kind: the preset's unless another is named; a name that no law has raises `PywetError`."""
    named = laws.model_dump(exclude={"preset"}, exclude_none=True)
    for kind, name in named.items():
        registry.get(kind, name)
    return {**PRESETS[laws.preset], **named}


def _bridges_row(moist: bool, number: tuple[str, float], settings: EffectSettings) -> EffectRow:
    if settings.bridges is True and not moist:
        raise PywetError("config.yaml: effects.bridges is on but the case has no liquid, expected auto or a moist case")
    on = moist if settings.bridges == "auto" else settings.bridges
    if settings.bridges != "auto":
        why = _by_hand("bridges", on)
    else:
        why = "any film gives the full force at touch" if on else "no liquid: stock engine, no plugin"
    return EffectRow("bridges", on, why, *number, 0.0)


def _row(
    effect: str, possible: bool, number: tuple[str, float], settings: EffectSettings, law: str | None, asked_by: str
) -> EffectRow:
    """A row whose effect can be switched by hand, by the preset or by its number."""
    switch, large = getattr(settings, effect), number[1] >= settings.tolerance.value
    if switch is True and not possible:
        raise PywetError(f"config.yaml: effects.{effect} is on but there are no bridges, expected auto or off")
    if switch != "auto":
        on, why = switch, _by_hand(effect, switch)
    elif not possible:
        on, why = False, "no bridges"
    elif large:
        on, why = True, f"not negligible, {asked_by}"
    elif settings.decide == "preset":
        on, why = True, f"negligible by its number but on: {asked_by} asks for it"
    else:
        on, why = False, "negligible by its number"
    return EffectRow(effect, on, why, *number, settings.tolerance.value, law)


def _follows(effect: str, bridges: bool, number: tuple[str, float], settings: EffectSettings, law: str) -> EffectRow:
    """A row of what belongs to the life of a bridge and goes with it."""
    why = "part of every bridge's life" if bridges else "no bridges"
    return EffectRow(effect, bridges, why, *number, settings.tolerance.value, law)


def _by_hand(effect: str, on: bool) -> str:
    return f"effects.{effect} is {'on' if on else 'off'} in config.yaml"
