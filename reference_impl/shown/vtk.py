"""Compare the VTK series of a run with its raw logs, so that ParaView shows what the engine wrote.

All quantities are recomputed from the logs: film thickness from the films, liquid from films and active bridges,
positions of walls from the triangles at rest and their motion, film on walls over a recomputed area. `diagnosis`
names the kind of a deviation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.diagnosis import diagnosis
from reference_impl.diagnosis.diagnosis import Link, Suspect
from reference_impl.replay.arrays import Columns, Floats, vectors
from reference_impl.replay.compare import Quantity, compare, merged
from reference_impl.replay.exact import FORCE_TOLERANCE
from reference_impl.replay.formations import thickness
from reference_impl.scene import stl
from reference_impl.shown import vtu
from reference_impl.shown.exchanged import suspects
from reference_impl.shown.logs import Logs

LOOKED = 3
"""Number of disagreeing output steps in which the fault is sought."""
EXACT_PULLS = 8
"""Number of bridges of the last output for which the exact force is solved, a tenth of a second each."""
UNKNOWN = -1.0
"""Age in the place of NaN, that of a bridge whose formation is not logged [s]."""
Outputs = Callable[[str], Sequence[tuple[float, Path | vtu.Shown]]]
"""Kind of file -> time [s] of each output, and its file or content."""


@dataclass(frozen=True)
class Field:
    """One array of one file: its meaning, rows that identify it, shown and expected values, and their scale."""

    name: str
    what: str
    rows: Columns
    shown: Floats
    expected: Floats
    size: Floats
    limit: float = 1e-12


def there(folder: Path) -> bool:
    """Return whether the run has VTK files."""
    return (Path(folder) / "vtk").is_dir()


def check(folder: Path) -> tuple[list[Quantity], list[dict[str, Any]]]:
    """Return quantities of all files, and findings on wrong ones; empty for a run without VTK files."""
    return _judged(Path(folder), lambda kind: vtu.series(folder / "vtk" / f"{kind}.pvd")) if there(folder) else ([], [])


def _judged(folder: Path, outputs: Outputs, single: float = 0.0) -> tuple[list[Quantity], list[dict[str, Any]]]:
    """Return quantities and findings for outputs in any storage; `single`: limit of a time in single precision."""
    logs, parts, wrong = Logs(folder), dict[str, list[Quantity]](), dict[str, list[Field]]()
    for field in _fields(logs, outputs, single):
        quantity = _compared(field)
        parts.setdefault(field.name, []).append(quantity)
        if not quantity.ok and len(wrong.setdefault(field.name, [])) < LOOKED:
            wrong[field.name].append(field)
    links = (_link(logs, fields) for fields in wrong.values())
    failed = list(wrong)
    found = diagnosis.diagnose(iter(links), failed)["findings"] if failed else []
    return [merged(several) for several in parts.values()], found


def disagreement(folder: Path) -> str | None:
    """Describe in one sentence where the files disagree with the logs; None if all agree."""
    if not there(folder):
        return f"{folder / 'vtk'} is not there; expected the files that were to be written"
    wrong, findings = compared(folder, lambda kind: vtu.series(folder / "vtk" / f"{kind}.pvd"))
    return f"{folder / 'vtk'} disagrees with the logs on {wrong}: {findings}" if wrong else None


def compared(folder: Path, outputs: Outputs, single: float = 0.0) -> tuple[str, str]:
    """Return the names of wrong quantities, and sentences on them; both empty if all agree."""
    quantities, findings = _judged(folder, outputs, single)
    return ", ".join(q.name for q in quantities if not q.ok), "; ".join(f["sentence"] for f in findings)


def with_findings(
    findings: list[dict[str, Any]], failed: list[str], others: Callable[[list[str]], dict[str, Any] | None]
) -> dict[str, Any] | None:
    """Diagnose a run: wrong outputs, and the report of `others` on the other quantities that fail."""
    rest = [name for name in failed if not name.startswith("vtk_")]
    found = others(rest) if rest else None
    if not findings or not failed:
        return found
    found = found or {"findings": [], "follow": [], "not_explained": []}
    return {**found, "findings": [*found["findings"], *findings]}


def _compared(field: Field) -> Quantity:
    limit = 0.0 if field.shown.dtype.kind in "iu" else field.limit
    return compare(field.name, "itself, or the largest of the run", field.shown.astype(float), field.expected.astype(float),
                   field.size, field.rows, limit)  # fmt: skip


def _fields(logs: Logs, outputs: Outputs, single: float) -> Iterator[Field]:
    steps = logs.outputs.tolist()
    entries = {kind: outputs(kind) for kind in MAKERS}
    for kind, listed in entries.items():
        table = Columns({"step": logs.outputs, "i": np.arange(len(steps))})
        times = np.array([time for time, _ in listed])
        if len(times) != len(steps):
            count = Columns({"step": logs.outputs[-1:]})
            yield Field(f"vtk_{kind}_outputs", f"number of files of {kind}", count, np.array([len(times)]),
                        np.array([len(steps)]), np.ones(1))  # fmt: skip
            continue
        expected = np.array(steps) * logs.scene["time_step_s"]
        latest = np.full(len(expected), max(expected[-1], 1e-30))
        yield Field(f"vtk_{kind}_time", f"time stamps of {kind}", table, times, expected, latest, single or Field.limit)
    for k, step in enumerate(steps):
        for kind, shown_of in MAKERS.items():
            if len(entries[kind]) == len(steps):
                shown = entries[kind][k][1]
                yield from shown_of(logs, step, vtu.read(shown) if isinstance(shown, Path) else shown)


def expected_values(logs: Logs, step: int, kind: str) -> dict[str, Floats]:
    """Return the expected values of an output step by field, to recognise files that show another time or another field."""
    nothing = vtu.Shown(np.zeros((0, 3)), np.zeros((0, 0), int), {}, {}, {})
    makers = {"sphere": _particles, "bridge": _bridges, "wall": _walls}
    return {f.name: f.expected for f in makers[kind](logs, step, nothing, blind=True)} if kind in makers else {}


def _particles(logs: Logs, step: int, shown: vtu.Shown, blind: bool = False) -> Iterator[Field]:
    here = logs.at(step)
    rows = _rows(step, i=here.ids)
    seen = shown.of_points.get("id") if len(shown.points) else np.zeros(0, int)
    order = _order(seen, here.ids)
    if not blind:
        yield _whole("vtk_spheres", "spheres that are shown", step, order, seen)
    if (order is None or not len(order)) and not blind:
        return
    fields: list[tuple[str, str, Floats]] = [
        ("position", "place of a sphere", here.place + logs.origin), ("velocity", "velocity of a sphere", here.speed),
        ("radius", "radius of a sphere", here.radius), ("class", "class of a sphere", here.kind),
        ("film_thickness", "film thickness of a sphere", thickness(here.film, here.radius)),
        ("liquid", "liquid of a sphere", here.liquid), ("in_bin", "spheres in the bin", here.in_bin),
    ]  # fmt: skip
    every = {"position": shown.points, **shown.of_points}
    yield from _each("sphere", fields, every, order, rows)


def _bridges(logs: Logs, step: int, shown: vtu.Shown, blind: bool = False) -> Iterator[Field]:
    here = logs.at(step).bridges
    if not len(here):
        if len(shown.cells):
            yield _whole("vtk_bridges", "bridges that are shown", step, None, shown.cells[:, 0])
        return
    key = _key(*(here[name] for name in ("partner_kind", "i", "j")))
    here, key = here.take(sort := np.argsort(key, kind="stable")), key[sort]
    theirs = [shown.of_cells.get(name) for name in ("partner_kind", "i", "j")]
    seen = _key(*theirs) if all(a is not None for a in theirs) else None
    order = _order(seen, key)
    if not blind:
        yield _whole("vtk_bridges", "bridges that are shown", step, order, seen)
    if order is None and not blind:
        return
    rows = _rows(step, i=here["i"], j=here["j"])
    ends = [vectors(here, end) + logs.origin for end in ("xi", "xj")]
    every = dict(shown.of_cells)
    if "age" in every:
        every["age"] = np.nan_to_num(every["age"], nan=UNKNOWN)
    if len(shown.cells):
        every |= {"first_end": shown.points[shown.cells[:, 0]], "second_end": shown.points[shown.cells[:, -1]]}
    fields = [("first_end", "end of a bridge at i", ends[0]), ("second_end", "end of a bridge at j", ends[1]),
              ("volume", "volume of a bridge", here["volume"]),
              ("separation", "gap of a bridge", here["separation"]),
              ("age", "age of a bridge", np.nan_to_num(logs.ages(here, step), nan=UNKNOWN))]  # fmt: skip
    pulls, what = logs.pulls(here), "capillary force of a bridge"
    if pulls is not None:
        fields.append(("capillary_force", what, pulls))
    elif logs.exact and step == logs.outputs[-1] and order is not None:
        few = np.unique(np.linspace(0, len(here) - 1, EXACT_PULLS).astype(int))
        expected, touch = logs.exact_pulls(here.take(few))
        shown_here = every.get("capillary_force", np.full(len(here), np.nan))[order][few]
        yield Field("vtk_bridge_capillary_force", what, rows.take(few), shown_here, expected, touch, FORCE_TOLERANCE)
    yield from _each("bridge", fields, every, order, rows)


def _walls(logs: Logs, step: int, shown: vtu.Shown, blind: bool = False) -> Iterator[Field]:
    if not logs.plan.walls:
        return
    here, corners = logs.triangles, logs.corners(step)
    count = len(here)
    if not blind:
        yield _whole("vtk_triangles", "triangles that are shown", step, np.arange(count) if len(shown.cells) == count else None,
                     shown.cells)  # fmt: skip
        if len(shown.cells) != count:
            return
        names, codes = shown.words.get("reservoir_from_0", []), shown.of_cells["reservoir"].astype(int)
        known = np.array([*names, None], dtype=object)[np.where((codes >= 0) & (codes < len(names)), codes, len(names))]
        same = np.asarray(known == np.asarray(here["reservoir"], dtype=object))
        rows = _rows(step, triangle=here["triangle"].to_numpy())
        yield Field("vtk_wall_reservoir", "name of a triangle's reservoir", rows, same.astype(int), np.ones(count, int),
                    np.ones(count))  # fmt: skip
    area = stl.area(corners)
    fields = [(f"corner_{k}", f"corner {k + 1} of a wall's triangle", corners[:, k] + logs.origin) for k in range(3)]
    fields += [("film_thickness", "film thickness on a wall", logs.at(step).on_walls / area),
               ("part", "part of a wall", here["part"].to_numpy())]  # fmt: skip
    every = dict(shown.of_cells)
    if len(shown.cells):
        every |= {f"corner_{k}": shown.points[shown.cells[:, k]] for k in range(3)}
    yield from _each("wall", fields, every, np.arange(count), _rows(step, triangle=here["triangle"].to_numpy()))


def _each(
    kind: str, fields: list[Any], shown: dict[str, Floats], order: Floats | None, rows: Columns
) -> Iterator[Field]:
    """Yield every field in the order of the logs; a field missing from the file is empty."""
    for name, what, expected in fields:
        as_shown = shown[name][order] if name in shown and order is not None else np.full(expected.shape, np.nan)
        if expected.dtype.kind in "iu" and np.isfinite(as_shown).all():
            as_shown = np.rint(as_shown).astype(int)
        length = diagnosis.length(expected.astype(float))
        size = np.maximum(length, length.max(initial=0.0) * 1e-3) + 1e-300
        yield Field(
            f"vtk_{kind}_{name}",
            what,
            rows,
            as_shown,
            expected,
            np.ones(len(expected)) if expected.dtype.kind in "iu" else size,
        )


MAKERS = {"particles": _particles, "bridges": _bridges, "walls": _walls}


def _rows(step: int, **columns: Floats) -> Columns:
    return Columns({"step": np.full(len(next(iter(columns.values()))), step), **columns})


def _key(kind: Any, i: Any, j: Any) -> Floats:
    return np.asarray((np.asarray(kind, np.int64) << 60) | (np.asarray(i, np.int64) << 30) | np.asarray(j, np.int64))


def _order(shown: Floats | None, expected: Floats) -> Floats | None:
    """Return indices of the shown rows in the order of the logs; None if they are not the same."""
    if shown is None or len(shown) != len(expected):
        return None
    order = np.argsort(shown, kind="stable")
    return order if np.array_equal(shown[order], np.sort(expected)) else None


def _whole(name: str, what: str, step: int, order: Floats | None, shown: Floats | None) -> Field:
    """Return a field that states whether exactly the rows of the logs are shown."""
    rows = _rows(step, i=np.array([0 if shown is None else len(shown)]))
    return Field(name, what, rows, np.array([int(order is not None)]), np.ones(1, int), np.ones(1))


def _link(logs: Logs, fields: list[Field]) -> Link:
    """Return the first output steps that disagree, as a link for the diagnosis."""
    rows = pd.concat([f.rows.frame() for f in fields], ignore_index=True)
    shown, expected, size = (
        np.concatenate([getattr(f, n) for f in fields]).astype(float) for n in ("shown", "expected", "size")
    )
    name, steps = fields[0].name, logs.outputs.tolist()
    kind = name.split("_")[1] if not name.endswith("_time") else ""

    def elsewhere(field: str, output: Callable[[int], int]) -> Floats:
        """Return the values of a field at other outputs; NaN if it has none."""
        places = [output(steps.index(int(f.rows["step"][0]))) for f in fields]
        values = [expected_values(logs, steps[k], kind).get(field) if 0 <= k < len(steps) else None for k in places]
        same = [
            v if v is not None and v.shape == f.expected.shape else f.expected * np.nan
            for v, f in zip(values, fields, strict=True)
        ]
        return np.concatenate(same).astype(float)

    def others() -> Iterator[Suspect]:
        for text, output in (
            ("the output before", lambda k: k - 1), ("the output after", lambda k: k + 1), ("the start", lambda k: 0)
        ):  # fmt: skip
            yield Suspect(f"it is that of {text}", elsewhere(name, output))
        for field in expected_values(logs, steps[-1], kind):
            if field != name:
                yield Suspect(f"it is the {field.split('_', 2)[2].replace('_', ' ')}", elsewhere(field, lambda k: k))

    def tried(broken: Floats) -> Iterator[Suspect]:
        return chain(others(), suspects(shown, expected, broken))

    return Link(name, fields[0].what, rows, shown, expected, size, tried, 1e-12)
