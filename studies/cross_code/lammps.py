"""Source `lammps`: the scenes of `forces`, `replayed` and `dry` in LAMMPS + pywet, compared with the same truths.

Laws and liquid ledger are those of LIGGGHTS + pywet; contacts, neighbour lists and integration are the program's own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from pywet.cases.small import small
from pywet.engines.lammps import build
from pywet.errors import PywetError
from studies.cross_code import dry, forces, replayed
from studies.cross_code.model import Cell, Source, impossible, not_run
from studies.cross_code.pairs import pairs
from studies.cross_code.rows import LAMMPS, LIGGGHTS, ROWS

MOVES = "it has no moving STL walls: screening is beyond its range"
ELSEWHERE = "its scene is not run there; laws and liquid ledger are those of LIGGGHTS + pywet"


def source(folder: Path) -> Source:
    """Compute all cells of the column on LAMMPS."""
    try:
        build.engine_version()
    except PywetError as error:
        return Source("lammps", [not_run(row.key, LAMMPS, str(error)) for row in ROWS])
    cells = [replace(c, column=LAMMPS, link=f"runs/lammps/{c.link.removeprefix('runs/')}" if c.link else "")
             for c in _cells(folder) if c.column == LIGGGHTS]  # fmt: skip
    filled = {c.row for c in cells}
    for row in (r for r in ROWS if r.key not in filled):
        screened = "screening" in row.key or row.key in ("retained_dry", "end_height", "end_neighbours")
        cells.append(impossible(row.key, LAMMPS, MOVES if screened else ELSEWHERE))
    return Source("lammps", cells)


def _cells(folder: Path) -> Iterator[Cell]:
    """Yield the cells that LIGGGHTS would have for these runs."""
    yield from replayed.of_engine(folder, "lammps")
    for row, angle in dry.ANGLES.items():
        small.run(folder / row, dry.prepare(folder / row, angle), engine="lammps")
        yield from dry._judged(row, LIGGGHTS, dry.exact(angle), folder / row)
    for pair in pairs():
        for preset in forces.CAPILLARY:
            yield from forces.pulled(pair, preset, folder / f"pull_{preset}_{pair.key}", "lammps")[1]
