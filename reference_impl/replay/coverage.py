"""Laws of a run that this reference can recompute, and the treatment of others.

There are three kinds: closed forms, recomputed for every record; the exact bridge, solved for a sample of the
records; custom laws, which are not known here: their term is taken as logged, and everything else is checked.
"""

from __future__ import annotations

from reference_impl.replay import capillary, laws
from reference_impl.replay.io import Run

EXACT = "young_laplace"
CLOSED: dict[str, set[str]] = {
    "capillary": set(capillary.LAWS),
    "viscous_normal": set(laws.VISCOUS_NORMAL),
    "viscous_tangential": set(laws.VISCOUS_TANGENTIAL),
    "rupture": set(laws.RUPTURE),
    "dynamic_rupture": {"pitois"},
    "formation": {"shi_mccarthy"},
    "transfer": {"parabola", "parabola_walls_at_fifth", "parabola_walls_at_tenth", "half"},
    "shedding": {"tate"},
}
"""Names of the laws in closed form, by effect (for the transfer ratio: the parabola, solved at nodes of the table)."""
UNNAMED = {"formation": "shi_mccarthy", "transfer": "parabola"}
"""Laws of histories that name none."""
SOLVED = {"capillary", "rupture", "transfer"}
"""Effects that also have an exact law."""
WITHOUT = {
    "capillary": "the capillary force is taken as logged",
    "viscous_normal": "the normal viscous force is taken as logged",
    "viscous_tangential": "the tangential viscous force is taken as logged",
    "rupture": "the static rupture distance is taken as logged",
    "dynamic_rupture": "the rupture limit is taken as logged, ruptures are compared with the static distance",
    "formation": "what a new bridge draws is taken as logged",
    "transfer": "the transfer table is taken as logged",
    "shedding": "the volume of a drop is taken as logged",
}
"""Treatment of an unknown law."""
SAMPLED = {
    "capillary": "capillary: the exact bridge was solved for a sample of the contacts; forces take the logged term as given",
    "rupture": "rupture: the exact limit was solved for a sample of the events; limits take the logged distance as given",
    "transfer": "transfer: the exact split was solved for a sample of the table's nodes",
}


def law(run: Run, effect: str) -> str | None:
    """Return the name of the law of an effect, None if the effect is off."""
    name = run.meta["effects"].get(effect)
    if name is None and effect in UNNAMED and effect not in run.meta["effects"]:
        return UNNAMED[effect]
    return None if name is None else str(name)


def semi_implicit(run: Run) -> bool:
    """Return whether drag is evaluated at the speed after the step (`viscous_integration`)."""
    return bool(run.meta.get("viscous_integration", "explicit") != "explicit")


def solved(run: Run, effect: str) -> bool:
    """Return whether the effect's law is the exact bridge."""
    return effect in SOLVED and law(run, effect) == EXACT


def known(run: Run, effect: str) -> bool:
    """Return whether the effect is off or its law is one that this reference recomputes."""
    name = law(run, effect)
    return name is None or name in CLOSED[effect] or solved(run, effect)


def unchecked(run: Run) -> list[dict[str, str]]:
    """Return the effects whose law is not known here, for replay.json."""
    return [
        {"effect": effect, "law": str(law(run, effect)), "instead": instead}
        for effect, instead in WITHOUT.items()
        if not known(run, effect)
    ]


def not_checked(run: Run) -> list[str]:
    """Return sentences on what was checked only on a sample, and on laws that were not checked."""
    sampled = [sentence for effect, sentence in SAMPLED.items() if solved(run, effect)]
    missing = [
        f"{m['effect']}: the law {m['law']} is not built in and was not checked; {m['instead']}" for m in unchecked(run)
    ]
    if law(run, "shedding"):
        missing.append(
            "drops: what a film felt and which drops should have fallen is recomputed of sampled spheres, where a drop lands and "
            "which bridges are missing at output steps only"
        )
    return sampled + missing
