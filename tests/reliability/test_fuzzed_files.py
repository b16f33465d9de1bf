"""Every reader on damaged files: a sound reading or one printable sentence, never another exception, within a time limit.

Sound files are damaged by `mangled`, from a seed that a failure names; some in `make test`, ten thousand for each reader among
the slow tests: `pytest -m slow tests/reliability/test_fuzzed_files.py -s`, which prints how many were read and how many refused.
"""

from __future__ import annotations

import signal
import warnings
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from tests.reliability.mangled import mangled
from tests.reliability.readers import READERS

FEW, MANY = 100, 10_000
"""Files to each reader."""
LIMIT_S = 120
"""Within which a reader must end: some hundred times as long as the slowest sound file takes."""


class TooLong(BaseException):
    """Raised in a reader that does not end; none of its handlers catches it."""


@contextmanager
def limited(seconds: int) -> Iterator[None]:
    def stop(*_: object) -> None:
        raise TooLong

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


@contextmanager
def named(what: str, seconds: int = LIMIT_S) -> Iterator[None]:
    """Within the time limit and without warnings; what is raised names the damaged file."""
    try:
        with limited(seconds), warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            yield
    except (Exception, TooLong) as error:
        raise AssertionError(f"{what}: {type(error).__name__} {error}") from error


def tried(name: str, folder: Path, seeds: Iterable[int], file: str = "") -> Counter[str]:
    """Count the damaged files, or damages of `file`, that were read and that were refused; any other outcome names the seed."""
    reader = READERS[name]
    sound = {path: path.read_bytes() for path in reader.make(folder)}
    for path in sound:
        reader.read(path)  # undamaged first, which also compiles functions
    paths, ends = [path for path in sorted(sound) if file in ("", path.name)], Counter[str]()
    for seed in seeds:
        path = paths[seed % len(paths)]
        path.write_bytes(mangled(sound[path], seed, path.suffix))
        with named(f"{name}, seed {seed}, {path.name}"):
            try:
                reader.read(path)
                ends["read"] += 1
            except reader.refusals as error:
                output_text = str(error)  # `errors.border` shortens it and shows control characters as escapes
                assert 10 < len(output_text) < 5000
                ends["refused"] += 1
        path.write_bytes(sound[path])
    return ends


@pytest.mark.parametrize("count", [FEW, pytest.param(MANY, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", READERS)
def test_a_damaged_file_is_read_or_refused_in_a_sentence(name: str, count: int, tmp_path: Path) -> None:
    ends = tried(name, tmp_path, range(count))
    print(f"{name}: {count} damaged files, {ends['read']} read, {ends['refused']} refused")
    assert sum(ends.values()) == count
    assert ends["refused"] or not READERS[name].refusals  # otherwise nothing was damaged


@pytest.mark.parametrize(
    ("name", "file", "seeds"),
    [
        ("tables of a run", "films.parquet", (1110, 1446)),
        ("tables of a run", "wall_films.parquet", (1297,)),
        ("tables of a run", "ledger.parquet", (1476,)),
        ("YAML of a scene", "repose.yaml", (9479,)),
    ],
)
def test_files_that_once_ended_otherwise(name: str, file: str, seeds: tuple[int, ...], tmp_path: Path) -> None:
    """Films and ledgers of 1e308 m3, whose sums overflowed in the summary; a count of more digits than a float can hold."""
    assert tried(name, tmp_path, seeds, file)["refused"] == len(seeds)
