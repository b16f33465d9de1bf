"""numba with its machine code in this package's private cache.

Modules that cache their code import `numba` from here. numba itself checks only the file of the cached function, not
those of the functions compiled into it, and loads any file that it finds. Here the folder's name depends on all
compiled sources, on their path (by which numba names its files) and on the processor, and a file with a wrong check
sum counts as missing. Closures are excluded, since one source text is many functions, see `force_law`.
"""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numba
from llvmlite import binding  # type: ignore[import-untyped]
from numba.core import caching

from pywet.util import caches, sources
from pywet.util.files import atomic_write
from pywet.util.notices import notice

__all__ = ["njit", "numba"]
EVERYTHING = "everything"
"""The mark of all kinds of questions."""
_SUM = hashlib.sha256().digest_size


def key() -> str:
    """Return a hash of the processor and of all sources that are compiled, with their paths."""
    processor = f"{binding.get_host_cpu_name()} {binding.get_host_cpu_features().flatten()}"
    return sources.digest(sources.of(sources.COMPILED), f"{sources.PACKAGE} {processor}")[:16]


class CheckedFiles(caching.IndexDataCacheFile):
    """numba's pair of files with a check sum before the content."""

    def _dump(self, obj: Any) -> bytes:
        data: bytes = super()._dump(obj)
        return hashlib.sha256(data).digest() + data

    def _load_data(self, name: str) -> Any:
        return _checked(Path(self._data_path(name)).read_bytes())

    def _save_index(self, overloads: dict[Any, str]) -> None:
        with self._open_for_write(self._index_path) as file:
            file.write(self._dump((self._version, self._source_stamp, overloads)))

    def _load_index(self) -> dict[Any, str]:
        try:
            version, stamp, overloads = _checked(Path(self._index_path).read_bytes())
        except OSError:
            return {}
        return overloads if (version, stamp) == (self._version, self._source_stamp) else {}


def _checked(content: bytes) -> Any:
    """Read a cached file; a damaged one raises OSError, which numba treats like a missing file."""
    if hashlib.sha256(content[_SUM:]).digest() != content[:_SUM]:
        raise OSError("check sum")
    return pickle.loads(content[_SUM:])


_NAME = f"machine-code-{key()}"
_settings: Any = numba.config
_GIVEN = _settings.CACHE_DIR  # the user's $NUMBA_CACHE_DIR
_settings.CACHE_DIR = str(caches.given(_GIVEN, _NAME) if _GIVEN else caches.folder(_NAME))
caching.IndexDataCacheFile = CheckedFiles  # type: ignore[misc]
njit = numba.njit


def _mark(question: str) -> Path:
    return Path(_settings.CACHE_DIR) / f"answered-{question}"


def ready(question: str = EVERYTHING) -> bool:
    """Return whether the code of a kind of question, or of all that `pywet.cli.warm` asks, is compiled."""
    return _mark(question).exists()


def mark(question: str = EVERYTHING) -> None:
    with atomic_write(_mark(question)) as temporary:
        temporary.touch()


@contextmanager
def compiling(question: str) -> Iterator[None]:
    """Print that the first answer to a question of this kind takes a while, unless one was given before."""
    if ready() or ready(question):
        yield
        return
    notice.warning("compiling for this processor, once: a minute or two (`make setup` does it ahead)")
    yield
    mark(question)
