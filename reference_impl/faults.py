"""End a command of the reference with one sentence, also after an unexpected exception."""

from __future__ import annotations

import sys
import tempfile
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

READING = (
    ValueError,
    KeyError,
    IndexError,
    TypeError,
    AttributeError,
    StopIteration,
    ArithmeticError,
    RecursionError,
    SyntaxError,
)
"""Exceptions raised by reading something else than expected."""


class Refused(Exception):
    """Raised for unusable input, with one sentence."""


@contextmanager
def reading(what: str, expected: str) -> Iterator[None]:
    """Convert a failure of reading `what` into a sentence that names what was expected."""
    try:
        yield
    except READING as error:
        message = "".join(c if c.isprintable() else repr(c)[1:-1] for c in " ".join(str(error).split()))[:200]
        raise Refused(f"{what} cannot be read ({type(error).__name__}: {message}); expected {expected}") from error


def regular(path: Path) -> Path:
    """Return the path, unless it is a pipe or a device, reading which may never end."""
    if path.exists() and not path.is_file():
        raise Refused(f"{path} is no regular file; expected one")
    return path


STATUS = 70
"""Exit status of a command that ended with an unexpected exception (EX_SOFTWARE of sysexits.h)."""


@contextmanager
def border(refused: int) -> Iterator[None]:
    """Print exceptions of a command as one sentence; exit status `refused` for files that the system does not provide."""
    try:
        yield
    except BrokenPipeError:
        raise
    except (Refused, MemoryError) as error:
        sys.stderr.write(f"{error or 'this needs more memory than there is; expected a smaller input'}\n")
        raise SystemExit(refused) from None
    except OSError as error:
        sys.stderr.write(
            f"{error.filename or 'a file'}: {error.strerror}; expected a file that can be read and written\n"
        )
        raise SystemExit(refused) from None
    except Exception as error:
        sys.stderr.write(f"{_sentence(' '.join(sys.argv[1:]), error)}\n")
        raise SystemExit(STATUS) from None


def _sentence(given: str, error: Exception) -> str:
    """Return one sentence that names the arguments and the file with the traceback, and write that file."""
    text = "".join(traceback.format_exception(error))
    try:
        with tempfile.NamedTemporaryFile("w", prefix="reference-fault-", suffix=".txt", delete=False) as file:
            file.write(text)
        where = f"the traceback is in {file.name}: please report it, with that file and the input"
    except (OSError, ValueError):
        where = f"no file could be written for the traceback: please report it, with the input: {text}"
    message = " ".join(str(error).split())[:300]
    return f"{given}: a fault in the reference, not in what was given ({type(error).__name__}: {message}); {where}"
