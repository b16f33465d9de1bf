"""Runs of a user's script, in which script.json and tables replace a scene's plan and motions.

Spheres enter (column `enters` of spheres.parquet) and leave (retired.parquet); at the step of leaving a sphere is no
longer present. poses.parquet contains the positions of meshes at every logged step.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from reference_impl.replay import io
from reference_impl.replay.arrays import Floats, vectors
from reference_impl.replay.io import ReplayError

FILE = "script.json"
OF_POSE = ("shift", "turn_0", "turn_1", "turn_2", "velocity", "spin")
NOT_CHECKED = (
    "dry contacts, insertion, motion of the meshes: the script's own, of which the logs hold the outcome",
    "first films against the liquid's file; radii, densities and triangles are taken as the engine reported them",
)

OF_BOX = "length of the periodic box, which is taken as the engine reported it"


def of(folder: Path) -> dict[str, Any] | None:
    """Return the content of script.json; None for the run of a scene."""
    path = Path(folder) / FILE
    if not path.exists():
        return None
    try:
        noted = json.loads(path.read_text())
        _ = [int(s) for s in noted["output_steps"]], int(noted["window_steps"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ReplayError(
            f"{path} cannot be read ({error!r}); expected what the run wrote: run the script again"
        ) from error
    if noted.get("restored"):
        raise ReplayError(f"{Path(folder)} resumes from a restart file, whose bridges no log of it holds; expected a run from "
                          "its first films on: replay the one before it")  # fmt: skip
    return dict(noted)


def in_the_way_of_gravity(folder: Path) -> list[str]:
    """Return the reasons why the change of momentum of a sphere that touched nothing may not be weight and bridges alone."""
    noted = of(folder) or {}
    if "dry_walls" not in noted or "other_forces" not in noted:
        return ["the run did not note what acts on spheres"]
    touched = [f"{name} is touched without a bridge" for name in map(str, noted["dry_walls"])]
    return [*touched, *map(str, noted["other_forces"])]


def not_checked(folder: Path) -> list[str]:
    """Return sentences on what a replay of the run cannot check."""
    if of(folder) is None:
        return []
    reasons = in_the_way_of_gravity(folder)
    periodic = [OF_BOX] if any((of(folder) or {}).get("periodic_m", [])) else []
    return [*NOT_CHECKED, *periodic, *([f"gravity and Newton's law: {'; '.join(reasons)}"] if reasons else [])]


def windows(noted: dict[str, Any], last: int) -> tuple[tuple[int, int], ...]:
    """Return half-open windows of the contact log: from each output on, at most to the last step."""
    return tuple((step, min(step + int(noted["window_steps"]), last + 1)) for step in map(int, noted["output_steps"]))


def present(folder: Path, steps: Floats) -> Floats:
    """Count the spheres that exist at each step."""
    come = np.sort(io.columns(folder / "history" / "spheres.parquet", ["enters"])["enters"].to_numpy())
    gone = np.sort(io.columns(folder / "history" / "retired.parquet", ["step"])["step"].to_numpy())
    return np.asarray(np.searchsorted(come, steps, "right") - np.searchsorted(gone, steps, "right"))


class Poses:
    """Poses of each mesh at the logged steps."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / "history" / "poses.parquet"
        names = [f"{name}_{axis}" for name in OF_POSE for axis in "xyz"]
        table = io.columns(self._path, ["step", "mesh", *names]).sort_values(["mesh", "step"])
        self._rows = {int(str(mesh)): rows for mesh, rows in table.groupby("mesh")}

    def at(self, mesh: int, steps: Any) -> dict[str, Floats]:
        """Return the values of OF_POSE at some steps, a row for each."""
        rows = self._rows.get(mesh)
        known = rows["step"].to_numpy() if rows is not None else np.zeros(0, int)
        wanted = np.atleast_1d(steps)
        place = np.minimum(np.searchsorted(known, wanted), max(len(known) - 1, 0))
        if rows is None or (known[place] != wanted).any():
            raise ReplayError(
                f"{self._path} lacks mesh {mesh} at a step that is logged; expected all: run the script again"
            )
        return {name: vectors(rows, name)[place] for name in OF_POSE}

    def fastest(self) -> float:
        """Return the largest spin of any mesh [rad/s]."""
        spins = [float(np.linalg.norm(vectors(r, "spin"), axis=1).max(initial=0.0)) for r in self._rows.values()]
        return max(spins, default=0.0)
