"""Whole files or none: everything is written under a temporary name in the same folder and renamed at the end."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pandas as pd

from pywet.errors import PywetError


@contextmanager
def atomic_write(path: Path) -> Iterator[Path]:
    """Yield a temporary path beside `path`; rename it to `path` on success, remove it on failure."""
    path = Path(path)
    temporary = path.with_name(f".{path.stem}.{os.getpid()}.partial{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        temporary.replace(path)
    except OSError as error:
        raise PywetError(
            f"{path} could not be written ({error.strerror}); expected a writable folder with free space"
        ) from error
    finally:
        with suppress(NotADirectoryError):
            temporary.unlink(missing_ok=True)


def write_json(path: Path, value: Any) -> None:
    """Write a JSON file (two-space indent, NaN refused)."""
    text = json.dumps(value, indent=2, allow_nan=False)
    with atomic_write(path) as temporary:
        temporary.write_text(text + "\n")


def write_table(table: pd.DataFrame, path: Path, csv: bool = False) -> None:
    """Write a table as Parquet, and beside it as CSV where asked for."""
    with atomic_write(path) as temporary:
        table.to_parquet(temporary, index=False)
    if csv:
        with atomic_write(path.with_suffix(".csv")) as temporary:
            table.to_csv(temporary, index=False)
