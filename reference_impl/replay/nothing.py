"""Features of a scene for which a replay compared nothing: such a run agrees only in part."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from reference_impl.diagnosis.held import Section
from reference_impl.replay.compare import Quantity


class Kind(NamedTuple):
    """A feature that a scene may have: its condition, the quantity that records it, and the sentence without it."""

    there: Callable[[Mapping[str, Any]], Any]
    quantity: str
    sentence: str
    recorded: bool = False
    """Whether it is checked only if motion was recorded."""

    def missing(self, recorded: bool) -> str:
        """Return the sentence for a run that recorded its motion or did not."""
        return self.sentence if recorded or not self.recorded else f"{self.sentence.partition(':')[0]}: {NOT_RECORDED}"


NOT_RECORDED = "the run recorded no motion in windows"
IN_WINDOWS = "there is none in the sampling windows"
FOREIGN = "they follow the engine's own law"
IN_CONTACT = "nothing is in contact with it in the sampling windows"
KINDS = (
    Kind(lambda s: s["effects"]["bridges"], "film_i_before", "bridges: none formed or ruptured in the run"),
    Kind(lambda s: s["effects"]["bridges"], "separation", f"forces of bridges: {IN_WINDOWS}"),
    Kind(lambda s: s["output"].get("energy"), "energy_budget", "energy terms: no output"),
    Kind(lambda s: s["output"].get("energy"), "energy_windows", f"power of each effect: {IN_WINDOWS}", True),
    Kind(lambda s: s["effects"].get("shedding"), "felt_force", "drops: no force felt by a film was logged"),
    Kind(lambda s: s.get("retire"), "retired_who", "retired spheres: none was retired"),
    Kind(lambda s: s["effects"]["bridges"] and s.get("viscous_integration", "explicit") != "explicit",
         "window_push", f"semi-implicit drag: {IN_WINDOWS}", True),
    Kind(lambda _: True, "newton_force", "Newton's law: no free sphere has two consecutive recorded steps", True),
)  # fmt: skip


def compared(
    scene: Mapping[str, Any], quantities: list[Quantity], motion: Mapping[str, Any], sections: list[Section]
) -> list[str]:
    """Return one sentence for each kind; `motion`: the entries of Newton's law, None if no motion was recorded."""
    counts, law = {q.name: q.count for q in quantities}, motion["newton"]
    judged = {"energy_budget": "energy_budget" in counts, "energy_windows": "energy_budget" in counts}
    found = [
        kind.missing(law is not None)
        for kind in KINDS
        if kind.there(scene) and judged.get(kind.quantity, True) and not counts.get(kind.quantity)
    ]
    several, counted = sum(c["count"] for c in scene["classes"]) > 1, law or {}
    of_contacts = {"between_spheres": ("between spheres", several), "at_walls": ("with walls", scene["walls"])}
    why = NOT_RECORDED if law is None else FOREIGN if "foreign" in law else IN_WINDOWS
    found += [
        f"dry contacts {where}: {why}"
        for name, (where, there) in of_contacts.items()
        if there and not counted.get(name)
    ]
    found += [
        f"wall {name.removeprefix('on ')}, which moves or is of analytic wires: {IN_CONTACT}"
        for name in counted
        if name.startswith("on ") and not counted[name]
    ]
    return found + [
        f"section {s.name}: no value" for s in sections if s.quantities and not any(q.count for q in s.quantities)
    ]


def without_record(quantities: list[Quantity]) -> list[str]:
    """Return a sentence on the quantities without any record."""
    names = [q.name for q in quantities if not q.count]
    return [f"no record of: {', '.join(names)}"] if names else []
