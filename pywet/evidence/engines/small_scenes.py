"""Writes tables and pictures of the small scenes of the cross-check; the order of things, no physics."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from pywet.errors import PywetError
from pywet.evidence.engines import bed, contacts, pictures, pulls
from pywet.files import read_table, write_table


def write(what: str, inputs: list[Path], outputs: list[Path], seed: int = 1) -> None:
    """Make the outputs of what is asked for; `seed` is that of a bed.

    `pulls`: table, limits, picture; `contacts`: table; `bed`: table of a seed; `beds`: table, picture; `all`: one table.
    """
    if what == "pulls":
        write_table(pd.DataFrame(pulls.rows()), outputs[0], csv=True)
        write_table(pd.DataFrame(pulls.limits()), outputs[1], csv=True)
        pictures.pulls(outputs[2])
    elif what == "bed":
        write_table(bed.settle(outputs[0].parent, bed.Bed(seed=seed)), outputs[0])
    elif what == "contacts":
        write_table(pd.DataFrame(contacts.rows(Path("config"), outputs[0].parent)), outputs[0], csv=True)
    elif what == "beds":
        tables = [read_table(path) for path in inputs]
        write_table(pd.DataFrame(bed.rows(tables)), outputs[0], csv=True)
        pictures.bed(pd.concat(tables), outputs[1])
    elif what == "all":
        write_table(pd.concat([read_table(p) for p in inputs], ignore_index=True), outputs[0], csv=True)
    else:
        raise PywetError(f"the small scene {what} was asked for; expected pulls, contacts, bed, beds or all")
