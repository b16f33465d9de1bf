"""`pywet collide wall FILE`: read the file, run one collision or a sweep, print the answer."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import pandas as pd
from rich.console import Console
from rich.table import Table

from pywet.collisions.wall import sweep
from pywet.collisions.wall.problem import Problem
from pywet.collisions.wall.wall import collide
from pywet.config.loading import parse
from pywet.errors import PywetError
from pywet.util.files import write_csv
from pywet.util.machine_code import compiling
from pywet.util.notices import bar

WIDE = 160
"""Width in characters of a table written to a file or a pipe."""
err = Console(stderr=True, highlight=False)
SHOWN = ("e_n", "e_t", "e_omega", "stuck", "omega_out", "duration_s", "refused")
"""Results in the printed table; JSON and CSV contain all."""


def wall(file: Path, as_table: bool, csv: Path | None) -> None:
    """Print one collision as JSON, and a sweep as JSON rows or a table."""
    content = sweep.read(file)
    if not sweep.swept(content):
        if as_table or csv is not None:
            raise PywetError(
                f"{file} describes one collision, expected at least one list of values for --table or --csv",
                code="wall.no_list", where=file,
            )  # fmt: skip
        problem = parse(Problem, content, str(file))
        with compiling("wall"), err.status("one collision"):
            answer = collide(problem)
        print(json.dumps(answer, indent=2, allow_nan=False))
        return
    with bar("collisions") as move:
        frame = sweep.table(content, str(file), threads=os.cpu_count() or 1, report=move)
    if csv is not None:
        write_csv(frame, csv)
    if as_table:
        out = Console(highlight=False, width=None if sys.stdout.isatty() else WIDE)
        out.print(_table(frame, len(sweep.swept(content))))
    else:
        print(json.dumps(sweep.records(frame), indent=1, allow_nan=False))


def _table(frame: pd.DataFrame, swept: int) -> Table:
    columns = [*frame.columns[:swept], *(c for c in SHOWN if c in frame and frame[c].notna().any())]
    table = Table(*columns, box=None, header_style="bold")
    for row in frame[columns].itertuples(index=False):
        table.add_row(*("-" if pd.isna(x) else f"{x:.6g}" if isinstance(x, float) else str(x) for x in row))
    return table
