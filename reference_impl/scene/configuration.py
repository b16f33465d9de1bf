"""The configuration of a run as plain values: the resolved copy in its folder, or the four files of a configuration folder.

Of an entry with a source (`{value: 40, source: paper, …}`) the value is used. Omitted entries have the default stated
in docs/configuration.md, which is repeated here.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from reference_impl.replay.io import ReplayError

FILE = "config.json"
EDITED = "edited"
"""Key of the resolved copy: fields of the scene that were set explicitly when the run was built."""
OF_TIME = {"viscous_integration": "explicit", "bridges_every": 1}
OF_OUTPUT = {
    "contact_windows": 20, "contact_window_steps": 2, "window_trajectories": True, "checkpoints": 20, "energy": False,
}  # fmt: skip


def of_run(folder: Path) -> dict[str, Any] | None:
    """Return the resolved configuration in a run directory; None if there is none."""
    path = Path(folder) / FILE
    if not path.exists():
        return None
    try:
        found = json.loads(path.read_text())
        _ = [found[name].items() for name in ("case", "scale", "apparatus", "materials", "settings")]
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise ReplayError(
            f"{path} cannot be read ({error!r}); expected the configuration of the run: build it again"
        ) from error
    return dict(found)


def reading(config: Mapping[str, Any], key: str, default: str) -> str:
    """Return the reading that the configuration selects for an ambiguity of the paper (docs/readings.md)."""
    return str((config["settings"].get("readings") or {}).get(key, default))


def number(group: Mapping[str, Any], key: str) -> float:
    """Return the value of a configured number."""
    entry = group[key]
    return float(entry["value"] if isinstance(entry, Mapping) else entry)


def near(rows: Iterable[Mapping[str, Any]], key: str, wanted: float) -> Mapping[str, Any]:
    """Return the row of a list (sizes, screens, strokes) whose entry has this value."""
    return next(row for row in rows if abs(number(row, key) - wanted) <= 1e-9 * abs(wanted))


def contact(materials: Mapping[str, Any], sphere: str, partner: str) -> Mapping[str, Any]:
    """Return the dry contact data of two materials."""
    return next(row for row in materials["contacts"] if (row["sphere"], row["partner"]) == (sphere, partner))


def pitch_m(config: Mapping[str, Any]) -> float:
    """Return the distance of neighbouring wires [m]."""
    chosen = screen(config)
    return 1e-3 * (number(chosen, "aperture_mm") + number(chosen, "wire_diameter_mm"))


def screen(config: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the screen that a case uses."""
    return near(config["materials"]["screens"], "aperture_mm", float(config["case"]["aperture_mm"]))


def width_m(config: Mapping[str, Any]) -> float:
    """Return the side or diameter of the sieve [m]; a square one has whole pitches, a round one without a width is the feed's."""
    has_width = config["scale"].get("width_mm") is not None
    wide = (
        number(config["scale"], "width_mm") if has_width else number(config["materials"]["feed"], "sieve_diameter_mm")
    )
    wished, pitch = 1e-3 * wide, pitch_m(config)
    return wished if config["scale"]["shape"] == "cylinder" else max(1, round(wished / pitch)) * pitch
