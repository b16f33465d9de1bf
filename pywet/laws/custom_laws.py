"""Custom laws in a user's file, `path/to/file.py:function`: whether they are trusted, and whether they terminate.

A file may come from somebody else and name any other, so a law's file is run only if it is in or below the folder of
the configuration, scene or query that the user gave, if the user's own Python code uses it, or if `--trust` was
given; a file named in a run directory always needs `--trust`. `trust` stores path and content. The law is then tested
once in a child process, because it may loop forever or end the program. `registry.py` defines the requirements on
laws.
"""

from __future__ import annotations

import ast
import hashlib
import itertools
import os
import signal
import subprocess
import sys
import types
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any, Literal

from pywet.ending import die_with_parent
from pywet.errors import LawError, one_line
from pywet.laws.kinds import KINDS
from pywet.util import caches
from pywet.util.files import read_bytes, read_json
from pywet.util.notices import bar

TRIAL_S = 60
"""Longest time for a file and its law on the probe grid, compilation included: processor time [s], ten times that in total."""
CURE = "fix the law's name, path/to/file.py:function"


def is_custom(name: str) -> bool:
    """Return whether a law's name is that of a file and a function in it."""
    return ".py:" in name


def _followed(path: Path | str) -> Path:
    """Resolve the links of a path; circular links are left, to be refused when the file is read."""
    return Path(os.path.realpath(path))


def digest(name: str) -> str:
    """Return the digest of a custom law's file; empty for another name, and for a missing file, which `functions` refuses."""
    path = _path(name)
    return hashlib.sha256(read_bytes(path, CURE)).hexdigest() if is_custom(name) and path.is_file() else ""


def trust(names: Iterable[str | None], below: Path | None = None) -> None:
    """Trust the law files named here with their present content; other names and missing files are ignored.

    `below`: only files in or below this folder, that of the file which names them, after links are resolved.
    """
    for name in names:
        inside = below is None or (name and _followed(_path(name)).is_relative_to(_followed(below)))
        if name and inside and is_custom(name) and _path(name).is_file():
            _mark(_path(name), read_bytes(_path(name), CURE)).touch()


def placed(name: str, folder: Path = Path()) -> str:
    """Return the name with the absolute path of its file; `folder` is that of the file that names the law."""
    path, _, attribute = name.rpartition(":")
    return f"{os.path.abspath(Path(folder) / path)}:{attribute}" if is_custom(name) else name


def kind_of(name: str) -> str:
    """Return the kind of law whose arguments match those of the file's function best.

    The file is read, not run, unless it is trusted and the law is not written there as a function.
    """
    if not _path(name).is_file():
        return next(iter(KINDS))  # it is rejected when it is used
    source = read_bytes(_path(name), CURE)
    given = _arguments(source, name.rpartition(":")[2])
    if not given and may_run(name):
        with suppress(LawError):  # it is rejected when it is used
            made = execute(name, source)
            given = [tuple(getattr(law, "arguments", ())) for law in (made if isinstance(made, tuple) else (made,))]
    if not given:
        return next(iter(KINDS))

    def alike(kind: str) -> tuple[bool, float]:
        wanted = [part.arguments for part in KINDS[kind].parts]
        same, every = (len(set(sum(given, ())) & set(sum(wanted, ()))), len(set(sum(given, ())) | set(sum(wanted, ()))))
        return given == wanted, same / max(every, 1)

    return max(KINDS, key=alike)


def _arguments(source: bytes, attribute: str) -> list[tuple[str, ...]]:
    """Return the arguments of a function of a file, or of those of a tuple of functions, from its text."""
    try:
        body = ast.parse(source).body
    except (SyntaxError, ValueError):
        return []
    known = {n.name: tuple(a.arg for a in n.args.args) for n in body if isinstance(n, ast.FunctionDef)}
    for node in body:
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Tuple):
            together = [known.get(e.id, ()) for e in node.value.elts if isinstance(e, ast.Name)]
            if any(isinstance(target, ast.Name) and target.id == attribute for target in node.targets):
                return together
    return [known[attribute]] if attribute in known else []


def check_second(kind: str, name: str) -> None:
    """Refuse a user reference implementation that does not exist or has the wrong arguments; it is not executed."""
    path, wanted = _path(name), KINDS[kind].parts[0].arguments
    if not path.is_file():
        raise LawError(
            f"reference {name}: the file {path} does not exist; expected path/to/file.py:function",
            law=name, code="law.no_reference", where=path,
        )  # fmt: skip
    given = _arguments(read_bytes(path, CURE), name.rpartition(":")[2])
    if given != [wanted]:
        has = f"({', '.join(given[0])})" if given else "no such function"
        raise LawError(
            f"reference {name}: {path} has {has}; expected one of ({', '.join(wanted)})",
            law=name, code="law.reference_arguments", expected=tuple(wanted), where=path,
        )  # fmt: skip


def may_run(name: str) -> bool:
    """Return whether the user has named the file of a law or user reference implementation with its present content."""
    return _path(name).is_file() and _mark(_path(name), read_bytes(_path(name), CURE)).exists()


def functions(kind: str, name: str) -> Any:
    """Return the law of this name from its file, after checking that the file is trusted and its execution ends."""
    path = _path(name)
    if not path.is_file():
        raise LawError(
            f"law {name}: the file {path} does not exist; expected path/to/file.py:function",
            law=name, code="law.no_file", where=path,
        )  # fmt: skip
    source = read_bytes(path, CURE)
    if not _mark(path, source).exists():
        raise LawError(
            f"law {name} was not run: {path} is not in or below the folder of a file that you passed, or has changed "
            "since; read the file, then move it below the file that names it, or give --trust",
            law=name, code="law.untrusted", where=path,
        )  # fmt: skip
    _try(kind, name, path, source)
    return execute(name, source)


def execute(name: str, source: bytes) -> Any:
    """Run a file's text and return the object with the law's name; exceptions and `sys.exit` become one sentence."""
    path, _, attribute = name.rpartition(":")
    module = types.ModuleType(path)
    module.__file__ = path
    try:
        exec(compile(source, path, "exec", dont_inherit=True), vars(module))
    except (Exception, SystemExit) as error:
        raise LawError(
            f"law {name}: its file raises {type(error).__name__}: {one_line(error)}; fix {path}",
            law=name, code="law.raises", where=path,
        ) from error  # fmt: skip
    if not hasattr(module, attribute):
        raise LawError(
            f"law {name}: {path} has no {attribute}; expected the name of a function decorated with @force_law",
            law=name, code="law.no_function", where=path,
        )  # fmt: skip
    return getattr(module, attribute)


def _path(name: str) -> Path:
    return Path(name.rpartition(":")[0]).absolute()


def _mark(path: Path, source: bytes) -> Path:
    """Return the path of the empty file that records that this file may run."""
    return caches.folder("trusted") / hashlib.sha256(os.fsencode(path) + b"\0" + source).hexdigest()


def _try(kind: str, name: str, path: Path, source: bytes) -> None:
    """Run the text and evaluate the law on the probe grid in a child process, once for each text."""
    word = hashlib.sha256(f"{_mark(path, source).name} {kind} {name}".encode(errors="surrogateescape")).hexdigest()
    answer = caches.folder("tried") / f"{word}.json"
    if not answer.exists():
        if b"young_laplace" in source:  # its tables would exceed the time of the trial
            from pywet.laws import force_law, young_laplace

            first, second = (force_law.PROBE[f"contact_angle_{body}"] for body in "ij")
            with bar("exact bridge tables (stored for later runs)") as move:
                young_laplace.prepare(itertools.product(first, second), move)
        command = [sys.executable, "-P", "-m", "pywet.laws.trial", kind, name, str(answer), str(TRIAL_S)]
        how: Any = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "preexec_fn": die_with_parent}
        try:
            code = subprocess.run(command, input=source, timeout=10 * TRIAL_S, check=False, **how).returncode
        except subprocess.TimeoutExpired:
            code = -signal.SIGXCPU
        if code == -signal.SIGXCPU:
            raise LawError(
                f"law {name} does not finish within {TRIAL_S} s on the probe grid; fix {path}",
                law=name, code="law.endless", where=path,
            )  # fmt: skip
        if not answer.exists():
            raise LawError(
                f"law {name} ends the program (exit code {code}); fix {path}",
                law=name, code="law.ends_program", where=path,
            )  # fmt: skip
    refused = read_json(answer, "remove the file", dict[str, Any] | Literal[""])
    if refused:
        answer.unlink(missing_ok=True)
        raise LawError(**refused, law=name)
