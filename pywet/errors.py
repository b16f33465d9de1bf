"""Exceptions for users' mistakes and missing resources: one sentence with what was given, expected, and where to fix it.

The classes below allow callers to distinguish kinds, the codes are for programs; all data are attributes, so that no
program has to parse a sentence. All data have defaults, because an exception from another process is first created
from its sentence alone.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from pywet import ending


class PywetError(Exception):
    """A mistake the user can fix; its text is one sentence, shown without a traceback.

    Attributes
    ----------
    code : str
        Identifier of the mistake that is stable across versions, such as `config.unknown_key`; by default that of the class.
    key : str
        Wrong entry: a dotted key of a file, or an option; empty for a whole file.
    given, expected : object
        The value found, and the expected one: a value in SI units, or the allowed names; None: not known.
    where : str
        The file or folder to fix; empty if there is none.
    """

    code = "error"

    def __init__(
        self, sentence: str, *, code: str = "", key: str = "", given: Any = None, expected: Any = None,
        where: str | Path = "",
    ) -> None:  # fmt: skip
        super().__init__(sentence)
        self.code, self.key, self.where = code or type(self).code, key, str(where)
        self.given, self.expected = given, expected

    @property
    def data(self) -> dict[str, Any]:
        """Return code, key, given, expected and where, as arguments of the constructor of another error of this class."""
        return {name: getattr(self, name) for name in ("code", "key", "given", "expected", "where")}


class ConfigError(PywetError):
    """A configuration or a JSON query is not as expected; `key` is dotted, empty if it is the whole file."""

    code = "config"

    def __init__(self, sentence: str, *, file: str | Path = "", **data: Any) -> None:
        super().__init__(sentence, **{"where": file, **data})

    @property
    def file(self) -> str:
        return self.where


class FileError(PywetError):
    """A file is missing, damaged or cannot be read or written."""

    code = "file"

    def __init__(self, sentence: str, *, path: str | Path | None = None, **data: Any) -> None:
        super().__init__(sentence, **{"where": path or "", **data})
        self.path = None if path is None else Path(path)


class NotWhole(PywetError):
    """The raw output of a run is incomplete and cannot be evaluated; the run must be repeated."""

    code = "run.not_whole"


class LawError(PywetError):
    """A law does not exist, does not match its kind, does not compile or gives invalid values."""

    code = "law"

    def __init__(self, sentence: str, *, law: str = "", **data: Any) -> None:
        super().__init__(sentence, **{"given": law or None, **data})
        self.law = law


class UnstableStep(PywetError):
    """The time step exceeds a stability limit of the scene."""

    code = "step.unstable"

    def __init__(self, sentence: str, *, step_s: float = 0.0, largest_s: float = 0.0, **data: Any) -> None:
        super().__init__(sentence, **{"key": "time_step_s", "given": step_s, "expected": largest_s, **data})
        self.step_s, self.largest_s = step_s, largest_s


class EngineError(PywetError):
    """The engine or a requirement of its plugin is missing or of another version, does not start, or stopped."""

    code = "engine"


class StoppedRun(EngineError):
    """The engine stopped a run; the attributes are the reason, the spheres (numbered from 1) and the step."""

    code = "engine.stopped"

    def __init__(
        self, sentence: str, *, reason: str = "", spheres: tuple[int, ...] = (), step: int | None = None, **data: Any
    ) -> None:
        super().__init__(sentence, **data)
        self.reason, self.spheres, self.step = reason, spheres, step


def one_line(error: object, most: int = 300) -> str:
    """Shorten an exception's text to one line of at most `most` characters."""
    text = _printable(" ".join(str(error).split())) or type(error).__name__
    return text if len(text) <= most else text[: most - 1] + "…"


def _printable(text: str) -> str:
    """Replace control characters and lone surrogates by their escapes, so that a terminal does not execute them."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def shown(path: Path) -> str:
    """Format a path for a message: one line of at most 200 characters."""
    text = _printable(str(path))
    return text if len(text) <= 200 else f"{text[:80]}…{text[-80:]}"


def refused(error: OSError) -> str:
    """Describe an error of the operating system in one sentence: full disk, no permission, a name that is too long."""
    where = shown(Path(os.fsdecode(error.filename))) if isinstance(error.filename, str | bytes) else "a file"
    return f"{where}: {error.strerror or one_line(error)}; expected a path that can be read or written, and free space there"


LONG_WORD = re.compile(r"(\S{80})\S{140,}(\S{80})")
"""What a sentence shows of a word without end, such as an argument that is a file's content: its start and end."""
DATA_FILE = "PYWET_ERROR_DATA"
"""Environment variable: the file into which `border` writes code and data of an error for the process that started this one."""
FAULT = 70
"""Exit code of a command that ended in an unexpected exception (EX_SOFTWARE of sysexits.h)."""


def _to_stderr(sentence: str) -> None:
    print(sentence, file=sys.stderr, flush=True)


@contextmanager
def border(
    given: str | None = None,
    say: Callable[[str], None] = _to_stderr,
    passed: tuple[type[BaseException], ...] = (),
    status: Callable[[], int] = lambda: 1,
) -> Iterator[None]:
    """Run a command so that any exception ends in one sentence and an exit code; `given`: its arguments if not `sys.argv`.

    The exit code is `status`, 1, for errors that the user can fix: a `PywetError`, a refusal by the operating system,
    insufficient memory; for a signal it is 128 plus its number. Every other exception except those `passed` is a
    fault of pywet: the exit code is `FAULT`, and the traceback is in a file that the message names.
    """
    given = given or shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]])
    quiet: tuple[type[BaseException], ...] = (BrokenPipeError, *passed)
    try:
        yield
    except quiet:
        raise  # the reader of a pipe has closed it: the caller ends without a message
    except (PywetError, OSError, MemoryError) as error:
        lines = _lines(given, error)
        if isinstance(error, PywetError) and os.environ.get(DATA_FILE):
            with suppress(OSError):
                Path(os.environ[DATA_FILE]).write_text(json.dumps(error.data, default=str))
        say("\n".join(one_line(LONG_WORD.sub(r"\1…\2", line), 2000) for line in lines))
        raise SystemExit(status()) from None
    except KeyboardInterrupt as stop:
        sentence, code = ending.message(one_line(given), stop)
        say(sentence)
        raise SystemExit(code) from None
    except Exception as error:
        say(fault(given, error))
        raise SystemExit(FAULT) from None


@contextmanager
def child_data() -> Iterator[tuple[dict[str, str], Callable[[], dict[str, Any]]]]:
    """Give the environment for a process with `border`, and a function that returns the data of the error in which it ended."""
    with tempfile.NamedTemporaryFile("r") as file:

        def data() -> dict[str, Any]:
            with suppress(ValueError):  # no step, or several ranks at once
                return dict(json.loads(file.read()))
            return {}

        yield {DATA_FILE: file.name}, data


def arguments(**kinds: Callable[[str], Any]) -> list[Any]:
    """Parse the arguments of a program started by `python -m`; raise `PywetError` if their number or kind is wrong.

    `run_dir, step = arguments(RUN_DIR=Path, STEP=int)`.
    """
    given, name = sys.argv[1:], Path(sys.argv[0]).name
    if len(given) != len(kinds):
        raise PywetError(
            f"{name} was given {len(given)} arguments{f' ({one_line(shlex.join(given))})' if given else ''}; expected "
            f"{' '.join(kinds)}",
            code="program.arguments", given=given, expected=tuple(kinds),
        )  # fmt: skip
    found = []
    for word, (key, kind) in zip(given, kinds.items(), strict=True):
        try:
            found.append(kind(word))
        except ValueError as error:
            what = "a whole number" if kind is int else kind.__name__
            raise PywetError(
                f"{name}: {key} is {one_line(word) if word else 'empty'}; expected {what}",
                code="program.argument", key=key, given=word, expected=what,
            ) from error  # fmt: skip
    return found


def _lines(given: str, error: Exception) -> list[str]:
    if isinstance(error, MemoryError):
        return [f"{given}: this needs more memory than there is ({one_line(error)}); expected a smaller input"]
    return [refused(error)] if isinstance(error, OSError) else str(error).splitlines()


def fault(given: str, error: Exception) -> str:
    """Describe an unexpected exception in one sentence and write its traceback to a file."""
    text = f"{given}\npython {sys.version}\n\n{''.join(traceback.format_exception(error))}"
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="pywet-fault-", suffix=".txt", delete=False, errors="replace"
        ) as file:
            file.write(text)
        where = f"the traceback is in {file.name}: please report it, with that file and the input"
    except OSError:  # the disk is full
        where = f"no file could be written for the traceback: please report it, with the input: {text}"
    return f"{one_line(given)}: a fault in pywet, not in what was given ({type(error).__name__}: {one_line(error)}); {where}"
