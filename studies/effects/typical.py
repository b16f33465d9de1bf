"""Effects in three typical scenes, as the table of docs/effects.md: `python -m studies.effects.typical`."""

from __future__ import annotations

from pywet.errors import border
from pywet.planning import costs
from studies.effects.scenes import CONFIG, SCENES
from studies.effects.variants import plan_of

TYPICAL = {"screening": "moist screen", "wet_drum": "wet drum", "thick_oil": "oily pile at rest"}
"""Scene of the study -> its column."""


def rows() -> list[str]:
    """Return one line per effect: on or off by its number and the study's tolerance, in each of the scenes."""
    plans = {name: plan_of(SCENES[name].setup(1, 1.0, CONFIG), decide="tolerance") for name in TYPICAL}
    first = next(iter(plans.values()))
    lines = [f"| effect | {' | '.join(TYPICAL.values())} | time it adds |", "|---" * (2 + len(TYPICAL)) + "|"]
    for row in first.rows:
        of = [plan.row(row.effect) for plan in plans.values()]
        cells = [f"{'on' if r.on else '**off**'}, {r.number:.2g}" for r in of]
        lines.append(f"| `{row.effect}` | {' | '.join(cells)} | {costs.shown(row.cost)} |")
    return lines


if __name__ == "__main__":
    with border():
        print(*rows(), sep="\n")
