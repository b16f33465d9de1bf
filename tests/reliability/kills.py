"""What two runs of one scene are compared by after a kill."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from pywet.history import tables
from tests.engine import beds

EXACT = True
"""Whether a run that goes on from a checkpoint is the unbroken one bit for bit."""
LOOKS = ("step", "kind", "partner_kind", "i", "j", "id", "type", "mesh")


class Stopped(BaseException):
    """Ends a run from within, as Ctrl-C does."""


def tables_of(run_dir: Path) -> dict[str, pd.DataFrame]:
    """All tables of a finished run that the engine gave."""
    paths = [path for name in tables.OUTPUT if name.endswith(".parquet") for path in sorted(run_dir.glob(name))]
    return {path.stem: pd.read_parquet(path) for path in paths}


def assert_same(
    wanted: dict[str, pd.DataFrame], found: dict[str, pd.DataFrame], exact: bool = False, resumed_at: int | None = None
) -> None:
    """The same tables: to the last bit, or after a resumption as far as docs/engine.md promises.

    Until the checkpoint a dry run is the same to the last bit, and to 1e-3 of a radius at the first output after it.
    A moist one has the same events and positions within 1e-9 of a radius.
    """
    assert wanted.keys() == found.keys()
    if exact or EXACT or resumed_at is None:
        for name, table in wanted.items():
            pd.testing.assert_frame_equal(table, found[name], check_exact=True, obj=name)
        return
    one, two = wanted["trajectory"], found["trajectory"]
    assert one[["step", "id", "type"]].equals(two[["step", "id", "type"]])
    apart = pd.Series(np.linalg.norm(one[["x", "y", "z"]] - two[["x", "y", "z"]], axis=1)).groupby(one["step"]).max()
    assert (apart[apart.index <= resumed_at] == 0.0).all()
    if "events" not in wanted:
        assert apart[apart.index > resumed_at].iloc[0] < 1e-3 * beds.RADIUS
        return
    assert apart.max() < 1e-9 * beds.RADIUS
    for name in ("events", "bridges", "ledger"):
        columns = [column for column in LOOKS if column in wanted[name]]
        pd.testing.assert_frame_equal(wanted[name][columns], found[name][columns])
