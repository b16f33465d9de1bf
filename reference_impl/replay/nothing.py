"""Kinds that a scene has and of which a replay compared nothing: such a run does not agree, it agrees in part."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from reference_impl.diagnosis.held import Section
from reference_impl.replay.compare import Quantity


def compared(
    scene: Mapping[str, Any], quantities: list[Quantity], motion: Mapping[str, Any], sections: list[Section]
) -> list[str]:
    """One sentence for each kind; `motion`: the entries of Newton's law, None where no motion was recorded."""
    counts, law = {q.name: q.count for q in quantities}, motion["newton"]
    missing = [
        (bool(scene["effects"]["bridges"]) and not counts.get(name), sentence)
        for name, sentence in (
            ("film_i_before", "bridges: none formed or ruptured in the run"),
            ("separation", "forces of bridges: there is none in the sampling windows"),
        )
    ]
    missing.append(
        (bool(scene["output"].get("energy")) and counts.get("energy_budget") == 0, "energy terms: no output")
    )
    if law is not None:
        many, walls = sum(c["count"] for c in scene["classes"]) > 1, scene["walls"]
        turning = [w["name"] for w in walls if w["motion"] == "turns"]
        missing += [
            (not counts.get("newton_force"), "Newton's law: no free sphere has two consecutive recorded steps"),
            (
                many and not law.get("between_spheres"),
                "dry contacts between spheres: there is none in the sampling windows",
            ),
            (bool(walls) and not law.get("at_walls"), "dry contacts with walls: there is none in the sampling windows"),
            *(
                (
                    not law.get(f"on {name}"),
                    f"velocity of the turning wall {name}: nothing is in contact with it in the sampling windows",
                )
                for name in turning
            ),
        ]
    found = [sentence for is_missing, sentence in missing if is_missing]
    return found + [
        f"section {s.name}: no value" for s in sections if s.quantities and not any(q.count for q in s.quantities)
    ]
