"""Effects and laws required by a configuration: presets, laws named individually, switches.

If effects are decided by their numbers (`decide: tolerance`), only explicitly switched or impossible ones are
expected here.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

PAPER = {
    "capillary": "rabinovich", "viscous_normal": "pitois", "viscous_tangential": "goldman", "rupture": "willett_unequal",
    "dynamic_rupture": "pitois", "formation": "shi_mccarthy", "transfer": "parabola",
}  # fmt: skip
PRESETS = {
    "paper": PAPER,
    "exact": {**PAPER, "capillary": "young_laplace", "rupture": "young_laplace", "transfer": "young_laplace"},
}
"""Laws of each preset, from docs/laws.md."""
PRINTED = {
    ("mended", "mended"): "rabinovich",
    ("as_printed", "mended"): "rabinovich_spheres_as_printed",
    ("mended", "as_printed"): "rabinovich_walls_as_printed",
    ("as_printed", "as_printed"): "rabinovich_as_printed",
}
"""Law by capillary_spheres and capillary_walls, from docs/readings.md."""
AT_WALLS = {
    "at_rupture": "parabola", "at_fifth": "parabola_walls_at_fifth", "at_tenth": "parabola_walls_at_tenth",
}  # fmt: skip
"""Law by wall_transfer, from docs/readings.md."""
SWITCHED = ("capillary", "viscous_normal", "viscous_tangential", "dynamic_rupture")
NEEDED = ("rupture", "formation", "transfer")
DRIPPING = "tate"
DECIDED = "effects.* that were decided by their numbers (effects.decide: tolerance)"


def expected(config: Mapping[str, Any]) -> dict[str, Any]:
    """Return field of the scene's effects -> expected value, without fields that the plan's numbers decide."""
    asked, chosen = config["settings"]["effects"], config["settings"].get("laws") or {}
    preset = PRESETS[chosen.get("preset", "paper")]
    laws = {
        **preset,
        **{kind: law for kind, law in chosen.items() if kind not in ("preset", "reference") and law is not None},
    }
    laws = as_read(laws, config["settings"].get("readings") or {})
    by_number = asked.get("decide", "preset") == "tolerance"
    moist = float(config["case"]["liquid_percent"]) > 0.0
    by_hand = {
        effect: switch in (True, "on") for effect, switch in asked.items() if switch in (True, False, "on", "off")
    }
    bridges = by_hand.get("bridges", moist)

    def on(effect: str, possible: bool = True) -> bool | None:
        return by_hand.get(effect, None if possible and by_number else possible)

    found: dict[str, Any] = {"bridges": bridges}
    for effect in SWITCHED:
        state = on(effect, bridges)
        # if the dimensionless number decides, the effect is off or has this law
        found[effect] = None if state is False else laws[effect] if state else (None, laws[effect])
    shared = on("sharing_by_size", bridges)
    for kind in NEEDED:
        found[kind] = laws[kind] if bridges else None
    if bridges and shared is not True:
        found["transfer"] = "half" if shared is False else ("half", laws["transfer"])
    for effect in ("rolling", "tangential_history", "gravity"):
        found[effect] = on(effect)
    walls = on("wall_films", bridges)
    found["wall_films"] = walls if bridges else True
    found["liquid_weight"] = by_hand.get("liquid_weight", False)
    found["shedding"] = laws.get("shedding", DRIPPING) if by_hand.get("shedding") else None
    return {name: value for name, value in found.items() if value is not None or name not in _TRUTHS}


def as_read(laws: Mapping[str, str], readings: Mapping[str, Any]) -> dict[str, str]:
    """Return the laws with alternative readings of the paper's equations; other laws are unchanged."""
    capillary = PRINTED[readings.get("capillary_spheres", "mended"), readings.get("capillary_walls", "mended")]
    transfer = AT_WALLS[readings.get("wall_transfer", "at_rupture")]
    read = {"capillary": capillary, "transfer": transfer}
    return {**laws, **{kind: law for kind, law in read.items() if laws[kind] == PAPER[kind]}}


_TRUTHS = ("bridges", "rolling", "tangential_history", "gravity", "wall_films", "liquid_weight")
"""Fields that are on or off; None: not known."""
