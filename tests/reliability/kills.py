"""What two runs of one scene are compared by after a kill."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from pywet.engines.run_store import OUTPUT


class Stopped(BaseException):
    """Ends a run from within, as Ctrl-C does."""


def tables_of(run_dir: Path) -> dict[str, pd.DataFrame]:
    """All tables of a finished run that the engine gave."""
    paths = [path for name in OUTPUT if name.endswith(".parquet") for path in sorted(run_dir.glob(name))]
    return {path.stem: pd.read_parquet(path) for path in paths}


def assert_same(wanted: dict[str, pd.DataFrame], found: dict[str, pd.DataFrame]) -> None:
    """Expect the same tables to the last bit."""
    assert wanted.keys() == found.keys()
    for name, table in wanted.items():
        pd.testing.assert_frame_equal(table, found[name], check_exact=True, obj=name)
