"""Batches that tell why batch kinetics misjudge the deck: `python -m studies.batch_to_deck.variants FOLDER` writes their scenes.

Each changes batch.yaml in one of two ways, or in both. `travelling`: the deck's inclination and stroke, on a screen
that is long enough for no sphere to reach its end; `crowded`: twice as many spheres, 4 per cm2, as many as on the
first 17 mm of the deck from 0.8 to 3.3 s. A way is called the cause if with it the predicted shares to the overs of
0.7, 0.8 and 0.9 apertures lie within the intervals of the deck's; this was written before the batches were run.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import yaml

from pywet.errors import border

HERE = Path(__file__).parent
LENGTH_MM, DURATION_S = 700, 0.8
"""Length of the screen on which a batch travels, and time before which none of 282 spheres reached its end.

The deck's coarsest spheres left it after 0.45 s on average, 0.75 s at most.
"""
END_MM = (-35.0, 80.0)
"""Lower and upper edge of the end wall of a crowded batch.

With -3 and 40 mm three spheres that had passed flew out under it, and one over it.
"""
VARIANTS = ("travelling", "crowded", "travelling_crowded")


def scene(variant: str) -> dict[str, Any]:
    """Return the scene of a variant of batch.yaml."""
    batch, deck = (yaml.safe_load((HERE / name).read_text()) for name in ("batch.yaml", "deck.yaml"))
    batch["name"] = variant
    if "crowded" in variant:
        for entry in batch["spheres"]:
            entry["count"] *= 2
        for edge, z in zip(("low_mm", "high_mm"), END_MM, strict=True):
            batch["walls"][0]["block"][edge][2] = z
    if "travelling" in variant:
        batch["deck"] |= {key: deck["deck"][key] for key in ("inclination_deg", "stroke")} | {"length_mm": LENGTH_MM}
        batch["duration_s"] = DURATION_S
        del batch["walls"]
    return batch


if __name__ == "__main__":
    with border():
        for variant in VARIANTS:
            (Path(sys.argv[1]) / f"{variant}.yaml").write_text(yaml.safe_dump(scene(variant), sort_keys=False))
