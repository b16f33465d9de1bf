"""Atomic writing: every file is written under a temporary name in the same folder and renamed when complete.

A file in a run directory is registered in its list first (`file_list.py`).

All files are read by `read_json`, `read_model` and `read_table`, which report an invalid one in a sentence without
traceback. Tables contain check sums, so that a flipped bit is detected. pandas and pydantic are imported where they
are used, because every command imports this module, and `pywet --help` must respond at once.
"""

from __future__ import annotations

import itertools
import json
import math
import os
import secrets
import shutil
import stat
import tempfile
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from pywet.errors import FileError, one_line, shown
from pywet.util.file_list import root, write_here

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd

Model = TypeVar("Model")
AGAIN = "the run is not whole or was changed: run it again"
"""Hint on how to fix a file that a run has written."""


@contextmanager
def _writing(path: Path) -> Iterator[None]:
    """Raise one sentence for a path that cannot be written."""
    try:
        yield
    except OSError as error:
        raise FileError(
            f"{shown(path)} could not be written ({error.strerror or one_line(error)}); "
            "expected a writable folder with free space",
            path=path, code="file.unwritten",
        ) from error  # fmt: skip
    except ValueError as error:
        if "\0" not in str(path):
            raise
        raise FileError(
            f"{shown(path)} is not a path ({error}); expected one without a zero byte",
            path=path, code="file.zero_byte",
        ) from error  # fmt: skip


@contextmanager
def atomic_write(path: Path) -> Iterator[Path]:
    """Yield a temporary path next to `path`; rename it to `path` on success, remove it on failure.

    A symbolic link is preserved and its target is written; a character device or a pipe is written to. In a run
    directory only files of its run are overwritten, and no link is followed.
    """
    path, temporary, folder = Path(path), None, None
    try:
        with _writing(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            stream = _stream(path)
            if stream:
                folder = Path(tempfile.mkdtemp())
            elif path.is_symlink() and root(path) is None:
                path = Path(os.path.realpath(path))
            name = f".{path.stem}.{os.getpid()}.{secrets.token_hex(4)}.partial{path.suffix}"
            temporary = (folder or path.parent) / name
            yield temporary
            if stream:
                with open(temporary, "rb") as made, open(path, "wb") as out:
                    shutil.copyfileobj(made, out)
            else:
                write_here(path)
                temporary.replace(path)
    finally:
        with suppress(OSError, ValueError):
            if temporary:
                temporary.unlink(missing_ok=True)
            if folder:
                folder.rmdir()


def _stream(path: Path) -> bool:
    """Return whether a path is a character device or a pipe, such as /dev/stdout; raise FileError if it is no file either."""
    if not os.path.lexists(path):
        return False
    try:
        kind = os.stat(path).st_mode
    except FileNotFoundError:  # a link to a file that will be created
        return False
    if (
        stat.S_ISCHR(kind)
        or stat.S_ISFIFO(kind)
        or os.path.abspath(path).startswith(("/dev/fd/", "/dev/std", "/proc/"))
    ):
        return True
    if not stat.S_ISREG(kind) and not stat.S_ISDIR(kind):
        raise FileError(
            f"{shown(path)} is a block device or a socket; expected a file, a pipe or a terminal",
            path=path, code="file.device",
        )  # fmt: skip
    return False


def make_folder(path: Path) -> None:
    """Make a folder before the work whose results go there; raises one sentence if it is not writable."""
    with _writing(Path(path)):
        Path(path).mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            pass


def write_json(path: Path, value: Any) -> None:
    """Write a JSON file (two-space indent, NaN refused)."""
    text = json.dumps(value, indent=2, allow_nan=False)
    with atomic_write(path) as temporary:
        temporary.write_text(text + "\n")


def finite(value: Any) -> Any:
    """Return plain data with None in place of each number that is not finite."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: finite(entry) for key, entry in value.items()}
    return [finite(entry) for entry in value] if isinstance(value, list | tuple) else value


def write_table(table: pd.DataFrame, path: Path, csv: bool = False) -> None:
    """Write a table as Parquet and, on request, next to it as CSV."""
    with atomic_write(path) as temporary:
        table.to_parquet(temporary, index=False, write_page_checksum=True)
    if csv:
        write_csv(table, path.with_suffix(".csv"))


def write_parts(parts: Iterable[pd.DataFrame | Mapping[str, np.ndarray]], path: Path, quick: bool = False) -> None:
    """Write a long table, each part (at least one) as a group of rows, so that only one part is in memory.

    `quick`: by lz4 and without dictionaries, otherwise by zstd. Floating-point columns rarely repeat values: they
    have no dictionary, and no smallest and largest value of a group.
    """
    import pyarrow as pa
    from pyarrow import parquet

    with atomic_write(path) as temporary, ExitStack() as whole:
        writer = None
        for part in parts:
            rows = pa.table(part) if isinstance(part, Mapping) else pa.Table.from_pandas(part, preserve_index=False)
            if writer is None:
                repeat = [f.name for f in rows.schema if f.type != pa.float64()]
                how: dict[str, Any] = {"write_page_checksum": True, "write_statistics": repeat}
                how |= {"use_dictionary": False if quick else repeat, "compression": "lz4" if quick else "zstd"}
                writer = whole.enter_context(parquet.ParquetWriter(temporary, rows.schema, **how))
            writer.write_table(rows)


MOST_B = 200_000_000
"""Largest JSON, YAML or CSV file, and largest Python file of a law, that is read [bytes]."""
MAX_DEPTH = 100
"""Deepest nesting of a JSON file that is read; this package writes four levels."""


def write_csv(table: pd.DataFrame, path: Path, **how: Any) -> None:
    """Write a table for other programs; `how`: options of `DataFrame.to_csv`."""
    with atomic_write(path) as temporary:
        table.to_csv(temporary, index=False, **how)


def parse_json(text: str | bytes, path: Path, cure: str) -> Any:
    """Parse JSON to Python values; `path` is where it was read, `cure` how to fix it.

    Refused in one sentence: text that is not UTF-8, broken or nested deeper than `MAX_DEPTH`, a key given twice,
    NaN and infinities, numbers beyond double precision.
    """

    def no_twins(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        seen: dict[str, Any] = {}
        for key, value in pairs:
            if key in seen:
                raise ValueError(f"the key {key!r} is given twice")
            seen[key] = value
        return seen

    def number(digits: str) -> int | float:
        value = float(digits)
        if abs(value) == float("inf"):
            raise ValueError(f"the number {digits[:20]}… is too large")
        return int(digits) if digits.lstrip("-").isdigit() else value

    def constant(word: str) -> float:
        raise ValueError(f"{word} is not a finite number")

    try:
        content = text.decode("utf-8-sig") if isinstance(text, bytes) else text
        deepest = max(itertools.accumulate((c in "[{") - (c in "]}") for c in content), default=0)
        if deepest > MAX_DEPTH:
            raise ValueError(f"it is nested {deepest} levels deep")
        value = json.loads(
            content, object_pairs_hook=no_twins, parse_int=number, parse_float=number, parse_constant=constant
        )
        json.dumps(value, ensure_ascii=False).encode("utf-8")  # half a surrogate pair is not text
        return value
    except UnicodeDecodeError as error:
        raise FileError(
            f"{shown(path)} is not text (byte {error.start}); expected JSON in UTF-8: {cure}",
            path=path, code="file.not_text",
        ) from error  # fmt: skip
    except (ValueError, RecursionError) as error:
        raise FileError(
            f"{shown(path)} is not the JSON that was expected ({one_line(error)}): {cure}",
            path=path,
            code="file.not_json",
        ) from error


def read_bytes(path: Path, cure: str) -> bytes:
    """Return the bytes of a file; raises one sentence if it is missing, a folder or not readable."""
    try:
        with open(regular(path, cure), "rb") as file:
            content = file.read(MOST_B + 1)
    except OSError as error:
        raise FileError(
            f"{shown(path)} could not be read ({error.strerror}); expected a file: {cure}",
            path=path, code="file.unread",
        ) from error  # fmt: skip
    except ValueError as error:  # a path with a zero byte
        raise FileError(
            f"{shown(path)} is not a path ({error}); expected a file: {cure}", path=path, code="file.not_a_path"
        ) from error
    if len(content) > MOST_B:
        raise FileError(
            f"{shown(path)} is larger than {MOST_B / 1e6:g} MB; expected a file of that size: {cure}",
            path=path, code="file.large", expected=MOST_B,
        )  # fmt: skip
    return content


def regular(path: Path, cure: str) -> Path:
    """Return the path unless it is a pipe, a socket or a device, reading which may never end.

    A missing file is left to the caller.
    """
    with suppress(OSError, ValueError):
        kind = os.stat(path).st_mode
        if not (stat.S_ISREG(kind) or stat.S_ISDIR(kind)):
            raise FileError(
                f"{shown(Path(path))} is a pipe or a device; expected a regular file: {cure}",
                path=path, code="file.irregular",
            )  # fmt: skip
    return path


def read_json(path: Path, cure: str = AGAIN, shape: Any = Any) -> Any:
    """Read a JSON file as Python values of the type `shape`; see `parse_json`."""
    value = parse_json(read_bytes(path, cure), path, cure)
    fit(shape, value, path, cure)
    return value


def read_if_there(path: Path, cure: str = AGAIN, shape: Any = Any) -> Any:
    """Return `read_json`, or None without such a file."""
    return read_json(path, cure, shape) if os.path.lexists(path) else None


def read_model(path: Path, model: type[Model], cure: str = AGAIN) -> Model:
    """Read a JSON file as a pydantic model or a dataclass; the message names the first wrong field."""
    content: Model = fit(model, read_json(path, cure), path, cure)
    return content


def fit(shape: Any, value: Any, path: Path, cure: str) -> Any:
    """Return the value of a JSON file as the type `shape`; the message names the first wrong field."""
    if shape is Any:
        return value
    from pydantic import TypeAdapter, ValidationError

    try:
        return TypeAdapter(shape).validate_json(json.dumps(value))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"]) or "the file"
        message = first["msg"].removeprefix("Value error, ")
        raise FileError(
            f"{shown(path)}: {one_line(where)}: {one_line(message)}: {cure}", path=path, code="file.shape", key=where
        ) from error


def read_table(path: Path, cure: str = AGAIN, columns: Collection[str] = (), step: int | None = None) -> pd.DataFrame:
    """Read a Parquet table with at least `columns`, and, for one of a run, those of `expected_columns`.

    `step`: only the rows of this step. Raises one sentence if it is missing, damaged, lacks a column, or if a
    column contains anything but finite numbers (integers).
    """
    from pyarrow import parquet

    path = Path(path)
    with _readable(path, cure):
        regular(path, AGAIN)
        if step is None:
            _bounded(path)
        filters = None if step is None else [("step", "==", step)]
        table = parquet.read_table(path, page_checksum_verification=True, filters=filters)
        table = table.to_pandas(ignore_metadata=True)  # an index that pandas has recorded is an ordinary column
    _check_table(table, path, cure, columns, empty=None if step is None else False)
    return table


def read_parts(path: Path, columns: Sequence[str], rows: int = 1 << 18) -> Iterator[pd.DataFrame]:
    """Yield some columns of a run's long table, some rows at a time, at least one part; refused as by `read_table`."""
    import pyarrow as pa
    from pyarrow import parquet

    path = Path(path)
    with _readable(path, AGAIN):
        regular(path, AGAIN)
        file = parquet.ParquetFile(path, page_checksum_verification=True)
        none = file.schema_arrow.empty_table().to_pandas(ignore_metadata=True)
    _check_table(none, path, AGAIN, columns, empty=file.metadata.num_rows == 0)
    with _readable(path, AGAIN):
        for group in range(file.num_row_groups):  # a reader caches the row groups it has read
            for batch in file.iter_batches(rows, row_groups=[group], columns=list(columns)):
                part = pa.Table.from_batches([batch]).to_pandas(ignore_metadata=True)
                _check_values(part, path, AGAIN)
                yield part
    if not file.metadata.num_rows:
        yield none[list(columns)]


def _bounded(path: Path) -> None:
    """Refuse a table whose values would not fit into memory, before they are decompressed."""
    from pyarrow import parquet

    about = parquet.ParquetFile(regular(path, AGAIN)).metadata
    there = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    asked = 8 * about.num_rows * about.num_columns
    if asked > there:
        raise ValueError(f"{about.num_rows} rows take {asked / 1e9:.3g} GB, this machine has {there / 1e9:.3g} GB")


@contextmanager
def _readable(path: Path, cure: str) -> Iterator[None]:
    from pyarrow.lib import ArrowException

    try:
        yield
    except (OSError, ValueError, KeyError, TypeError, OverflowError, ArrowException) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else one_line(error)
        raise FileError(
            f"{shown(path)} could not be read as a table ({reason}): {cure}", path=path, code="file.no_table"
        ) from error


def _check_table(
    table: pd.DataFrame, path: Path, cure: str, columns: Collection[str], empty: bool | None = None
) -> None:
    from pywet.schema import expected_columns, needs_rows

    missing = [name for name in (*expected_columns(path), *columns) if name not in table.columns]
    if missing:
        raise FileError(
            f"{shown(path)} has no column {', '.join(missing)}: {cure}",
            path=path, code="file.no_column", key=missing[0], expected=missing,
        )  # fmt: skip
    if (table.empty if empty is None else empty) and needs_rows(path):
        raise FileError(f"{shown(path)} holds no row: {cure}", path=path, code="file.no_row")
    _check_values(table, path, cure)


def _check_values(table: pd.DataFrame, path: Path, cure: str) -> None:
    from pywet.schema import NUMBER, expected_columns

    kinds = expected_columns(path)
    if path.parent.name == "results" and kinds:  # one additional column for each size class and reservoir
        kinds = {**{str(name): NUMBER for name in table.columns}, **kinds}
    for name, kind in kinds.items():
        if name in table:
            _check_column(table[name], kind, path, cure)


def read_csv(path: Path, cure: str = AGAIN, **how: Any) -> pd.DataFrame:
    """Read a CSV table with pandas' options; raises one sentence if it is missing, empty or damaged."""
    import pandas as pd

    with _readable(path, cure):
        regular(path, cure)
        table: pd.DataFrame = pd.read_csv(path, **how)
    return table


def check_numbers(table: pd.DataFrame, names: Sequence[str], path: Path, cure: str = AGAIN) -> None:
    """Raise one sentence if a column is missing or contains anything but finite numbers."""
    from pywet.schema import NUMBER

    for name in names:
        if name not in table:
            raise FileError(
                f"{shown(path)} has no column {name}; expected {', '.join(names)}: {cure}",
                path=path, code="file.no_column", key=name, expected=tuple(names),
            )  # fmt: skip
        _check_column(table[name], NUMBER, path, cure)


LARGEST = 1e100
"""Upper bound of all quantities of a run in SI units, for which sums and ratios do not overflow."""


def _check_column(values: pd.Series, kind: str, path: Path, cure: str) -> None:
    """Refuse text in place of numbers, fractions in place of integers, NaN and infinities."""
    import numpy as np

    from pywet.schema import INTEGER, NUMBER

    dtypes = {INTEGER: "iu", NUMBER: "iuf"}
    if not len(values) or kind not in dtypes:
        return
    what, data = f"{shown(path)}: column {values.name}", dict[str, Any](path=path, key=str(values.name))
    if values.dtype.kind not in dtypes[kind]:
        raise FileError(f"{what} holds {values.dtype}, expected {kind}s: {cure}", code="file.kind", **data)
    if kind == NUMBER and not (np.abs(values.to_numpy(dtype=float)) < LARGEST).all():  # nor NaN
        sentence = f"{what} holds a value that is not finite or beyond {LARGEST:g}, expected numbers: {cure}"
        raise FileError(sentence, code="file.not_finite", **data)
