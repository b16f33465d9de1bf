"""Compare the files for OVITO with the raw logs: every column of spheres and of bonds at every output step."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from reference_impl.diagnosis import diagnosis
from reference_impl.diagnosis.diagnosis import Link, Suspect
from reference_impl.replay.arrays import Floats
from reference_impl.replay.compare import compare
from reference_impl.replay.io import ReplayError
from reference_impl.shown import vtk
from reference_impl.shown.exchanged import suspects
from reference_impl.shown.logs import Logs

DIGITS = 1e-11
"""Limit of a relative deviation: the files have twelve digits."""
SPHERES = {
    "type": "class",
    "radius": "radius",
    "film_thickness": "film_thickness",
    "liquid": "liquid",
    "in_bin": "in_bin",
}
"""Column of spheres -> expected quantity."""
BONDS = ("volume", "separation", "capillary_force", "age")
FILES = {"ATOMS": "spheres.dump", "ENTRIES": "bridges.dump"}
Columns = dict[str, tuple[Floats, Floats]]
"""Values by column: shown, expected."""


def disagreement(folder: Path) -> str | None:
    """Describe in one sentence where the files disagree with the logs; None if all agree."""
    logs, found = Logs(Path(folder)), list[str]()
    for kind, name in FILES.items():
        if kind == "ENTRIES" and not logs.plan.moist:
            continue
        outputs = list(dumped(logs.folder / "ovito" / name, kind))
        if [step for step, _ in outputs] != logs.outputs.tolist():
            found.append(f"{name} holds {len(outputs)} outputs, expected the {len(logs.outputs)} of the run")
            continue
        found += _wrong(name, {step: _columns(logs, kind, step, table) for step, table in outputs})
    return f"{logs.folder / 'ovito'} disagrees with the logs: {'; '.join(found)}" if found else None


def dumped(path: Path, kind: str) -> Iterator[tuple[int, pd.DataFrame]]:
    """Yield step and table of each output of a text dump of LAMMPS."""
    lines = iter(path.read_text(encoding="utf-8").splitlines())
    try:
        for line in lines:
            step, _, count = int(next(lines)), next(lines), int(next(lines))
            _ = [next(lines) for _ in range(4)]
            words = next(lines).split()
            if line != "ITEM: TIMESTEP" or words[:2] != ["ITEM:", kind]:
                raise ValueError(line)
            rows = [[float(word) for word in next(lines).split()] for _ in range(count)]
            yield step, pd.DataFrame(rows, columns=words[2:], dtype=float)
    except (ValueError, StopIteration) as error:
        raise ReplayError(f"{path} is not a text dump of LAMMPS; write it again: pywet view --ovito") from error


def _columns(logs: Logs, kind: str, step: int, table: pd.DataFrame) -> Columns | None:
    """Return each column of one output in the order of the logs; None if other spheres or bonds are shown."""
    if kind == "ATOMS":
        values = vtk.expected_values(logs, step, "sphere")
        table, ids = table.sort_values("id"), logs.at(step).ids
        if not np.array_equal(table["id"], ids):
            return None
        expected = {column: values[f"vtk_sphere_{field}"] for column, field in SPHERES.items()}
        for names, field in (("xyz", "position"), (("vx", "vy", "vz"), "velocity")):
            expected |= dict(zip(names, values[f"vtk_sphere_{field}"].T, strict=True))
        return {name: (_column(table, name), np.asarray(column, float)) for name, column in expected.items()}
    here = logs.at(step).bridges.frame()
    if not len(here):
        return None if len(table) else {}
    here = here.sort_values(["partner_kind", "i", "j"])
    pairs = (here["partner_kind"] == 0).to_numpy()
    table, values = table.sort_values(["id1", "id2"]), vtk.expected_values(logs, step, "bridge")
    if not np.array_equal(table[["id1", "id2"]], here.loc[pairs, ["i", "j"]]):
        return None
    known = {name: values[f"vtk_bridge_{name}"][pairs] for name in BONDS if f"vtk_bridge_{name}" in values}
    if "age" in table:
        table["age"] = table["age"].fillna(vtk.UNKNOWN)
    return {name: (_column(table, name), column.astype(float)) for name, column in known.items()}


def _column(table: pd.DataFrame, name: str) -> Floats:
    return np.asarray(table[name], float) if name in table else np.full(len(table), np.nan)


def _wrong(file: str, outputs: dict[int, Columns | None]) -> Iterator[str]:
    """Yield one sentence for each column with a deviation."""
    if any(columns is None for columns in outputs.values()):
        yield f"{file} shows other {'spheres' if file == FILES['ATOMS'] else 'bonds'} than the logs"
        return
    names = list(dict.fromkeys(name for columns in outputs.values() for name in columns or ()))
    every = {
        name: tuple(np.concatenate([c[name][n] for c in outputs.values() if c and name in c]) for n in (0, 1))
        for name in names
    }
    for name, (shown, expected) in every.items():
        size = np.maximum(np.abs(expected), 1e-3 * np.abs(expected).max(initial=0.0)) + 1e-300
        steps = [np.full(len(c[name][0]), step) for step, c in outputs.items() if c and name in c]
        rows = pd.DataFrame({"step": np.concatenate(steps), "i": np.concatenate([np.arange(len(k)) for k in steps])})
        if compare(name, "itself, or the largest of the run", shown, expected, size, rows, DIGITS).ok:
            continue

        def tried(
            broken: Floats, shown: Floats = shown, expected: Floats = expected, name: str = name
        ) -> Iterator[Suspect]:
            yield from (Suspect(f"it is the {other}", of[1]) for other, of in every.items() if other != name)
            yield from suspects(shown, expected, broken)

        link = Link(name, f"{name} in {file}", rows, shown, expected, size, tried, DIGITS)
        message = diagnosis.diagnose(iter([link]), [name])["findings"]
        yield "; ".join(f["sentence"] for f in message) or f"{name} in {file}"
