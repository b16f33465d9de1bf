"""Effect plan: which effects a scene calls for, decided from dimensionless numbers against a stated tolerance.

Each row describes one effect: on or off, the number that decides it and the reason, its predicted share of impulse
and its cost. Effects that are on are written into `Scene.effects`; a scene without bridges runs on the stock engine.
The numbers (numbers.py) are estimates for equal spheres in stated surroundings; docs/effects.md documents formulas
and tests.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from pywet.config.settings import EffectSettings, LawSettings
from pywet.errors import PywetError
from pywet.laws import custom_laws, registry
from pywet.laws.kinds import NEEDED, OPT_IN, PRESETS, SWITCHED
from pywet.planning import costs
from pywet.planning.numbers import Number, class_groups, effect_numbers
from pywet.planning.shares import WITHIN, predicted_shares
from pywet.planning.size_distribution import Amount, lines
from pywet.planning.surroundings import Surroundings
from pywet.scene import ContactPair, Effects, Liquid, SphereClass

DRIPPING = "tate"
"""Default law of shedding."""
NEGLIGIBLE, NOT_NEGLIGIBLE = "negligible by its number", "not negligible"
HALVES = "half"
"""Transfer law used when sharing by size is off."""


@dataclass(frozen=True)
class EffectRow:
    """One effect: `number` is the value of `quantity`, negligible below `threshold`; `law` is None if no law is named.

    `predicted_share`: its share of the impulses of weight, capillary and viscous forces, within a factor of
    `predicted_within`; None if an effect is not a force. `cost`: additional processor time over that of the same
    run without the effect (0.1: a tenth more), None if not measured.
    """

    effect: str
    on: bool
    why: str
    quantity: str
    number: float
    threshold: float
    law: str | None = None
    predicted_share: float | None = None
    predicted_within: float = 3.0
    cost: float | None = None

    @property
    def short(self) -> str:
        """Format the row in 80 columns: on or off, number and tolerance, share, cost, law; without quantity and reason."""
        share = "-" if self.predicted_share is None else _percent(self.predicted_share).strip()
        state, law = ("on", (self.law or "").rpartition("/")[2]) if self.on else ("off", "")
        number = f"{self.number:.2g}"
        return f"{self.effect:<19}{state:<5}{number:>9}{self.threshold:>11g}{share:>8}{costs.shown(self.cost):>8}  {law}".rstrip()

    @property
    def line(self) -> str:
        state = "on " if self.on else "off"
        law = f" [{self.law}]" if self.on and self.law else ""
        share = "    -" if self.predicted_share is None else _percent(self.predicted_share)
        number = f"{self.quantity} = {self.number:.2g} (tolerance {self.threshold:g})"
        return f"{self.effect:<19}{state}  share {share}  cost {costs.shown(self.cost):>6}  {number}: {self.why}{law}"


@dataclass(frozen=True)
class EffectPlan:
    """Effect plan: printed rows, effects for the scene, and requested and simulated amounts of sizes given by mass."""

    rows: tuple[EffectRow, ...]
    effects: Effects
    amounts: tuple[Amount, ...] = ()
    contact: tuple[str, ...] = ()
    """Notes on dry contacts: values of materials, and a stiffness that depends on the impact speed."""

    @property
    def lines(self) -> list[str]:
        return [*(row.line for row in self.rows), *lines(self.amounts), *self.contact]

    @property
    def table(self) -> list[str]:
        """Format a header, one line per effect and the amounts, in 80 columns."""
        head = f"{'effect':<24}{'number':>9}{'tolerance':>11}{'share':>8}{'cost':>8}  law"
        return [head, *(row.short for row in self.rows), *lines(self.amounts), *self.contact]

    @property
    def hint(self) -> list[str]:
        """Name what is off though not negligible and the key that switches it on, in one line; none without such an effect."""
        left_out = [r.effect for r in self.rows if r.effect in OPT_IN and not r.on and NOT_NEGLIGIBLE in r.why]
        return [f"off, though {NOT_NEGLIGIBLE} (effects.NAME: on): {', '.join(left_out)}"] if left_out else []

    def row(self, effect: str) -> EffectRow:
        return next(row for row in self.rows if row.effect == effect)

    def as_dict(self) -> dict[str, Any]:
        """Convert the plan to plain data, as in plan.json."""
        amounts = [{**asdict(a), "made_kg": a.made_kg} for a in self.amounts]
        return {"rows": [asdict(row) for row in self.rows], "effects": self.effects.model_dump(), "amounts": amounts}


def plan(
    classes: Sequence[SphereClass],
    pairs: Sequence[ContactPair],
    liquid: Liquid | None,
    speed_m_per_s: float,
    settings: EffectSettings,
    laws: LawSettings,
    surroundings: Surroundings | None = None,
) -> EffectPlan:
    """Decide every effect.

    `speed_m_per_s` is the typical speed of approach, the screen's peak speed in screening. Raises `PywetError` if
    an effect that is switched on requires one that is off.
    """
    s = surroundings or Surroundings()
    moist = liquid is not None and liquid.initial_film_thickness_m > 0
    numbers = effect_numbers(classes, pairs, liquid, speed_m_per_s, s)
    bridges = _bridges_row(moist, numbers["bridges"], settings, s)
    named = _laws(laws)
    asked = f"preset {laws.preset}"
    formed = "part of every bridge's life" if bridges.on else "no bridges"
    falls = s.gravity_m_per_s2 > 0
    rows = [
        bridges,
        *(_row(effect, bridges.on, numbers[effect], settings, named[effect], asked) for effect in SWITCHED),
        EffectRow("formation", bridges.on, formed, *numbers["formation"], settings.tolerance.value, named["formation"]),
        _row("wall_films", bridges.on, numbers["wall_films"], settings, named["formation"], asked),
        _row("sharing_by_size", bridges.on, numbers["sharing_by_size"], settings, named["transfer"], asked),
        _row("rolling", True, numbers["rolling"], settings, None, "the materials"),
        _row("tangential_history", True, numbers["tangential_history"], settings, None, "the contact model"),
        _row("gravity", falls, numbers["gravity"], settings, None, "the scene"),
        _row("liquid_weight", bridges.on, numbers["liquid_weight"], settings),
        _row("shedding", bridges.on and falls, numbers["shedding"], settings, named["shedding"]),
    ]
    counts, added = [c.count for c in classes if c.count > 0], costs.measured_costs()
    alike = [p for p in pairs if p.a == p.b]
    shares = predicted_shares(class_groups(classes, alike, liquid, speed_m_per_s, s), counts, s)
    rows = [
        replace(
            row,
            predicted_share=shares.get(row.effect),
            predicted_within=WITHIN.get(row.effect, 3.0),
            cost=added.get(row.effect),
        )
        for row in _together(rows, settings)
    ]
    return EffectPlan(tuple(rows), _effects(rows, named, s))


def _together(rows: list[EffectRow], settings: EffectSettings) -> list[EffectRow]:
    """Leave out negligible effects, the smallest first, as long as their sum stays below the tolerance."""
    left, stored = settings.tolerance.value, set()
    for row in sorted((row for row in rows if row.why == NEGLIGIBLE), key=lambda row: row.number):
        if row.number < left:
            left -= row.number
        else:
            stored.add(row.effect)
    why = "negligible alone, not together with what is left out"
    return [replace(row, on=True, why=why) if row.effect in stored else row for row in rows]


def _effects(rows: Sequence[EffectRow], named: dict[str, str], s: Surroundings) -> Effects:
    on = {row.effect: row.on for row in rows}
    bridges = on["bridges"]
    transfer = named["transfer"] if on["sharing_by_size"] else HALVES
    return Effects(
        bridges=bridges,
        rolling=on["rolling"],
        tangential_history=on["tangential_history"],
        gravity=on["gravity"] or s.gravity_m_per_s2 == 0,
        wall_films=on["wall_films"] or not bridges,
        liquid_weight=on["liquid_weight"],
        shedding=named["shedding"] if on["shedding"] else None,
        **{kind: named[kind] if on[kind] else None for kind in SWITCHED},
        **{kind: (transfer if kind == "transfer" else named[kind]) if bridges else None for kind in NEEDED},
    )


def _percent(share: float) -> str:
    return f"{100 * share:3.0f} %" if share >= 0.01 or share == 0 else f"{100 * share:3.1g} %"


def _laws(laws: LawSettings) -> dict[str, str]:
    """Return the law of each kind: the preset's unless another is named; an unknown name raises `PywetError`."""
    named = laws.model_dump(exclude={"preset", "reference"}, exclude_none=True)
    for kind, name in named.items():
        registry.get(kind, name)
        if custom_laws.is_custom(name):
            from pywet.laws import checks  # it imports the exact bridge

            checks.warn(kind, name)
    return {"shedding": DRIPPING, **PRESETS[laws.preset], **named}


def _bridges_row(moist: bool, number: Number, settings: EffectSettings, s: Surroundings) -> EffectRow:
    if settings.bridges is True and not moist:
        raise PywetError(
            "config.yaml: effects.bridges is on but the case has no liquid, expected auto or a moist case",
            code="effect.dry", key="effects.bridges", given="on", where="config.yaml",
        )  # fmt: skip
    needed = s.liquid_wanted or number[1] >= settings.tolerance.value
    if settings.bridges != "auto":
        on, why = settings.bridges, _by_hand("bridges", settings.bridges)
    elif not moist:
        on, why = False, "no liquid"
    elif not needed and settings.decide == "tolerance":
        on, why = False, "its forces are negligible and where the liquid goes is not asked"
    else:
        on, why = True, "any film gives the full force at touch" if s.liquid_wanted else "its forces are not negligible"
    return EffectRow("bridges", on, why, *number, 0.0 if s.liquid_wanted else settings.tolerance.value)


def _row(
    effect: str, possible: bool, number: Number, settings: EffectSettings, law: str | None = None, asked_by: str = ""
) -> EffectRow:
    """Return the row of an effect that can be switched explicitly and, except for OPT_IN, by the preset or by its number."""
    switch, large = getattr(settings, effect), number[1] >= settings.tolerance.value
    if switch is True and not possible:
        lack = "there is no gravity," if effect == "gravity" else "there are no bridges,"
        if effect in OPT_IN:
            lack = "there are no bridges, or no gravity for drops to fall;"
        raise PywetError(
            f"config.yaml: effects.{effect} is on but {lack} expected auto or off",
            code="effect.lacking", key=f"effects.{effect}", given="on", where="config.yaml",
        )  # fmt: skip
    if switch != "auto":
        on, why = switch, _by_hand(effect, switch)
    elif not possible:
        lacks = {"gravity": "no gravity in the scene", "shedding": "no bridges, or no gravity"}
        on, why = False, lacks.get(effect, "no bridges")
    elif effect in OPT_IN:
        on, why = (
            False,
            f"in no preset, {f'though not negligible: effects.{effect}: on' if large else 'and negligible'}",
        )
    elif large:
        on, why = True, f"not negligible, {asked_by}"
    elif settings.decide == "preset":
        on, why = True, f"negligible by its number but on: {asked_by} asks for it"
    else:
        on, why = False, NEGLIGIBLE
    return EffectRow(effect, on, why, *number, settings.tolerance.value, law)


def _by_hand(effect: str, on: bool) -> str:
    return f"effects.{effect} is {'on' if on else 'off'} in config.yaml"
