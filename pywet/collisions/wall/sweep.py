"""Input files of `pywet collide wall`: one collision, or a sweep with lists in place of numbers."""

from __future__ import annotations

import copy
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pandas as pd

from pywet.collisions.wall import wall
from pywet.collisions.wall.problem import Problem
from pywet.config.loading import parse
from pywet.errors import PywetError
from pywet.util.files import read_json

Report = Callable[[int, int], None]
"""Progress callback, called with the numbers of finished and of all collisions."""
MOST = 1_000_000
RESULTS = (
    "e_n", "e_t", "e_omega", "stuck", "v_n_out", "v_t_out", "omega_out", "rupture_length_m", "bridge_volume_m3", "duration_s",
)  # fmt: skip
ENERGIES = ("in", "out", "contact", "viscous", "capillary", "gravity", "residual")


def read(path: Path) -> dict[str, Any]:
    """The content of an input file."""
    cure = "describe particle, wall, liquid and so on as in pywet docs wall_collision"
    return read_json(path, cure, dict[str, Any])  # type: ignore[no-any-return]


def swept(content: dict[str, Any], path: tuple[str, ...] = ()) -> list[tuple[tuple[str, ...], list[Any]]]:
    """Return the lists in an input, in the order of the file: (path of keys, values)."""
    places: list[tuple[tuple[str, ...], list[Any]]] = []
    for key, value in content.items():
        if isinstance(value, dict):
            places += swept(value, (*path, key))
        elif isinstance(value, list):
            if not value:
                raise PywetError(
                    f"key {'.'.join((*path, key))} is an empty list, expected one or more numbers",
                    code="wall.empty_list", key=".".join((*path, key)),
                )  # fmt: skip
            places.append(((*path, key), value))
    return places


def combinations(content: dict[str, Any]) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
    """Yield each combination of the lists' values: (values by dotted key, the input with them)."""
    places = swept(content)
    for chosen in itertools.product(*(values for _, values in places)):
        given = copy.deepcopy(content)
        for (keys, _), value in zip(places, chosen, strict=True):
            inner = given
            for key in keys[:-1]:
                inner = inner[key]
            inner[keys[-1]] = value
        yield {".".join(keys): value for (keys, _), value in zip(places, chosen, strict=True)}, given


def table(
    content: dict[str, Any], where: str = "the input", *, threads: int = 2, report: Report = lambda done, total: None
) -> pd.DataFrame:
    """Return one row per combination: swept values, results, energies [J]; for a refused one the reason in `refused`.

    A value that is impossible by itself is refused before anything is computed, and so are values of which none fit together.
    """
    count = math.prod(len(values) for _, values in swept(content))
    if count > MOST:
        raise PywetError(
            f"{where} asks for {count} collisions, expected at most {MOST}; split the sweep",
            code="wall.many", given=count, expected=MOST, where=where,
        )  # fmt: skip
    problems: list[tuple[dict[str, Any], Problem | PywetError]] = []
    for chosen, given in combinations(content):
        message = ", ".join(f"{key} {value}" for key, value in chosen.items())
        try:
            problems.append((chosen, parse(Problem, given, f"{where} ({message})")))
        except PywetError as error:
            if error.code != "config.inconsistent":
                raise
            problems.append((chosen, error))
    refused = [problem for _, problem in problems if isinstance(problem, PywetError)]
    if refused and len(refused) == len(problems):
        raise refused[0]
    return collide_all(problems, threads=threads, report=report)


def collide_all(
    problems: Sequence[tuple[dict[str, Any], Problem | PywetError]],
    *,
    threads: int,
    report: Report = lambda done, total: None,
) -> pd.DataFrame:
    """Return the table of given problems; collisions run in parallel `threads` (compiled code releases the global lock)."""
    rows = []
    with ThreadPoolExecutor(threads) as pool:
        for row in pool.map(_row, problems, chunksize=16):
            rows.append(row)
            report(len(rows), len(problems))
    return pd.DataFrame(rows)


def _row(pair: tuple[dict[str, Any], Problem | PywetError]) -> dict[str, Any]:
    chosen, problem = pair
    try:
        if isinstance(problem, PywetError):
            raise problem
        got = wall.collide(problem)
    except PywetError as error:
        return {**chosen, "refused": str(error)}
    energies = {f"energy_{name}_J": got["energy_J"][name] for name in ENERGIES}
    return {**chosen, **{name: got[name] for name in RESULTS}, **energies, "refused": None}


def records(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the table as plain rows, with None for missing numbers."""
    return frame.astype(object).where(frame.notna(), None).to_dict(orient="records")  # type: ignore[return-value]
