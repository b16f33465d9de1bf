"""Files of sweeps for the tests: collisions and bridges, which take milliseconds."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

EXAMPLES = Path(__file__).parents[2] / "examples"
WALL: dict[str, Any] = {
    "name": "rebound",
    "base": {"wall": str(EXAMPLES / "wall_wet.json")},
    "axes": {"friction": [0.1, 0.2], "normal_velocity_m_per_s": [0.5, 1.0, 2.0]},
    "gather": ["e_n", "duration_s"],
}
BRIDGE: dict[str, Any] = {
    "name": "pull",
    "base": {"bridge": str(EXAMPLES / "bridge.json")},
    "axes": {"laws": ["willett"], "surface_tension_N_per_m": [0.03, 0.07]},
}


def write(folder: Path, content: dict[str, Any], name: str = "sweep.yaml") -> Path:
    """A file of a sweep."""
    path = folder / name
    path.write_text(yaml.safe_dump(content, sort_keys=False))
    return path
