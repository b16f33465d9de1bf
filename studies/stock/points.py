"""Table of points at which a stock law is measured, and common functions of both programs: checks, folders, messages."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd

from pywet.ending import die_with_parent
from pywet.engines.process import last_words, surroundings
from pywet.errors import PywetError

Floats = npt.NDArray[np.float64]
COLUMNS = ("separation", "volume", "radius_i", "radius_j", "contact_angle", "surface_tension")
"""Columns of points in SI units and radians; radius_j = inf is a large wall.

Optional: `contact_angle_j`, the angle of j if it differs from that of i.
"""
TOUCH = 1e-7
"""Gap in smaller radii used for S = 0, where round-off would decide whether a program has an overlap or a gap."""

REACH_IN = 0.1
"""Largest measured overlap in smaller radii."""


def checked(points: pd.DataFrame) -> pd.DataFrame:
    """Return a copy of the table with contact_angle_j filled in, and the `gap` at which each point is measured [m].

    It is the separation, or TOUCH times the smaller radius for S = 0. PywetError if a column or a number is
    missing or impossible.
    """
    missing = [name for name in COLUMNS if name not in points.columns]
    if missing:
        raise PywetError(f"the table of points lacks {', '.join(missing)}; expected the columns {', '.join(COLUMNS)}")
    table = points.copy()
    if "contact_angle_j" not in table.columns:
        table["contact_angle_j"] = table["contact_angle"]
    numbers = table[[*COLUMNS, "contact_angle_j"]].to_numpy(float)
    finite = np.isfinite(np.delete(numbers, COLUMNS.index("radius_j"), axis=1)).all(axis=1)
    positive = (table[["volume", "radius_i", "radius_j", "surface_tension"]] > 0).all(axis=1).to_numpy()
    bad = np.flatnonzero(~(finite & positive))
    if len(bad):
        raise PywetError(
            f"row {bad[0]} of the table of points has a number that is missing or not positive; expected finite numbers,"
            " with radius_j = inf for a wall"
        )
    apart = table["separation"].to_numpy(float)
    return table.assign(gap=np.where(apart == 0.0, TOUCH * smaller_radius(table), apart))


def smaller_radius(table: pd.DataFrame) -> Floats:
    return np.minimum(table["radius_i"].to_numpy(float), table["radius_j"].to_numpy(float))


def expressible(table: pd.DataFrame, one_angle: bool = False) -> dict[int, str]:
    """Return the rows that no run can represent, with the reason."""
    overlap = -table["separation"].to_numpy(float)
    refused = {
        int(k): f"an overlap above {REACH_IN} of the smaller radius is not measured"
        for k in np.flatnonzero(overlap > REACH_IN * smaller_radius(table))
    }
    if one_angle:
        differ = table["contact_angle"].to_numpy(float) != table["contact_angle_j"].to_numpy(float)
        refused |= {int(k): "the program refuses bodies of two contact angles" for k in np.flatnonzero(differ)}
    return refused


def with_force(points: pd.DataFrame, force: Floats, program: str, refused: dict[int, str]) -> pd.DataFrame:
    """Return the points with their attraction [N], or, if nan, the reason; `refused` rows were not passed to the program."""
    result = points.copy()
    result["force"] = np.where(np.isfinite(force), force, np.nan)
    result["reason"] = [
        refused.get(k, "" if np.isfinite(value) else f"{program} gave no finite force") for k, value in enumerate(force)
    ]
    return result


def run_program(command: Sequence[str], folder: Path, package: str, timeout_s: float = 600.0) -> None:
    """Run a program in a folder. PywetError if it is missing, fails or takes too long."""
    program = command[0]
    if shutil.which(program) is None:
        raise PywetError(
            f"the program {program} was not found; expected Debian's package {package}: apt-get install {package}"
        )
    try:
        done = subprocess.run(
            list(command),
            cwd=folder,
            env=surroundings(),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=timeout_s,
            check=False,
            preexec_fn=die_with_parent,
        )
    except subprocess.TimeoutExpired as error:
        raise PywetError(
            f"{program} did not end within {timeout_s:.0f} s; expected seconds: give it fewer points"
        ) from error
    except OSError as error:
        raise PywetError(
            f"{program} could not be started ({error.strerror}); reinstall Debian's package {package}"
        ) from error
    if done.returncode != 0:
        logs = (path.read_text(errors="replace") for path in sorted(folder.glob("*.log")))
        lines = "\n".join([*logs, done.stdout, done.stderr]).splitlines()
        raise PywetError(f"{program} stopped: {last_words(lines, done.returncode)}")
