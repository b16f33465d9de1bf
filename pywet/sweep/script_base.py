"""A LIGGGHTS script with liquid as the base of a sweep: keys of its liquid's file and variables of the script are axes.

Each point has its own folder, to which files below the script's folder that it names are copied, and in which it writes.
"""

from __future__ import annotations

import glob
import hashlib
import math
import re
import shutil
import sys
from collections.abc import Iterable, Iterator
from contextlib import chdir
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import yaml

from pywet.cases.screening import identity
from pywet.cases.script import folder as script_folder
from pywet.cases.script.scan import commands, content, scan
from pywet.cases.script.variables import NAME
from pywet.cases.script.wet import Line, Wet
from pywet.config.dotted_keys import filled
from pywet.config.loading import parse, placed_laws, read_yaml
from pywet.engines import process
from pywet.errors import ConfigError, PywetError
from pywet.sweep import costs
from pywet.sweep.base_kind import Built, Kind, Numbers, number, stored_name
from pywet.sweep.costs import Cost
from pywet.sweep.description import Point, Value
from pywet.util.files import make_folder, read_bytes, write_json

WORK = "work"
"""Folder of a point in which its script runs."""
PREFIX = "script."
VARIABLE = re.compile(r"^([ \t]*variable[ \t]+(\w+)[ \t]+(?:index|equal|string)[ \t]+)(\S.*)$", re.MULTILINE)
PLAIN = re.compile(r"[\w.+-]+")
LOGGING = ("ave/", "massflow/mesh", "print")
"""First characters of fixes that write a file."""
RESULTS = ("formations", "ruptures", "bridges_at_end", "liquid_films_share", "liquid_bridges_share", "processor_time_s")
CURE = "name a LIGGGHTS script with the line of fix pywet; its path counts from the sweep's folder"


class Given(NamedTuple):
    """A point of a script: its line of fix pywet, its liquid, the content of every copied file, the folders to be made."""

    line: Line
    wet: Wet
    files: dict[str, bytes]
    folders: set[str]


class OfScript(Kind):
    """A script run as by `pywet liggghts`."""

    results = ("formations", "ruptures")

    @property
    def seeded(self) -> bool:  # type: ignore[override]
        """Return whether a variable of the script is its seed."""
        return self.base.seed is not None

    @cached_property
    def _contents(self) -> dict[Path, bytes]:
        """Return the files that were read, so that each is read once for all points."""
        return {}

    def _content(self, path: Path) -> bytes:
        """Return a file that the script names, or the digest of one that is not copied."""
        if path not in self._contents:
            if _below(path):
                self._contents[path] = content(path)
            else:
                with open(path, "rb") as file:
                    self._contents[path] = hashlib.file_digest(file, "sha256").digest()
        return self._contents[path]

    def _script(self, values: dict[str, Value]) -> tuple[Line, dict[str, bytes], set[str]]:
        """Return the line of fix pywet, the files that the script names and the folders to which it writes.

        Its variables have these values.
        """

        def read(path: Path) -> bytes:
            return _put(self._content(path), values) if _below(path) else content(path)

        read_bytes(self.file, CURE)
        with chdir(self.file.parent):
            script = Path(self.file.name)
            found = scan(script, read=read)
            if found.problems:
                raise found.problems[0]
            # read again, because values that `next` changes are unknown the second time, also before it
            rows = [*found.rows, *commands(script, variables=found.variables, read=read)]
            self._refuse_shared(found.line, rows)
            files = {name: self._content(Path(name)) for name in sorted({script.name, *_named(self.file, rows)})}
            files = {name: _put(text, values) if _below(Path(name)) else text for name, text in files.items()}
            return found.line, files, {*_folders(rows)}

    def _refuse_shared(self, line: Line, rows: Iterable[list[str]]) -> None:
        """Refuse a path to which all points would write."""
        paths = [("liquid", line.liquid), ("tables", line.log)]
        for what, path in [*paths, *(("results", Path(word)) for row in rows for word in _written(row))]:
            if not _below(path):
                raise ConfigError(
                    f"{self.file} has its {what} in {path}; expected a path below the script's folder, of which each point "
                    "has a copy",
                    code="sweep.script_shared", file=self.file, key=what, given=str(path),
                )  # fmt: skip

    @cached_property
    def _variables(self) -> dict[str, str]:
        """Return the variables of the script and of included files, with the values in the text."""
        texts = [text.decode(errors="replace") for name, text in self._script({})[1].items() if _below(Path(name))]
        return {name: value for text in texts for _, name, value in VARIABLE.findall(text)}

    def built(self, values: Point, seed: int) -> Built:
        changed: dict[str, Value] = {k.removeprefix(PREFIX): v for k, v in values.items() if k.startswith(PREFIX)}
        there = self._variables
        if self.base.seed is not None:
            changed = {self.base.seed: _seed(self.base.seed, there.get(self.base.seed, ""), seed), **changed}
        for name, value in changed.items():
            if name not in there:
                known = ", ".join(there) or "none"
                raise ConfigError(
                    f"{self.file} has no variable {name} of style index, equal or string; expected one of {known}",
                    code="sweep.script_variable", file=self.file, key=f"axes.{name}", expected=tuple(there),
                )  # fmt: skip
            if isinstance(value, bool) or not PLAIN.fullmatch(str(value)):
                raise ConfigError(
                    f"the variable {name} of {self.file} is given {value!r}; expected a number or a word",
                    code="sweep.script_value", file=self.file, key=f"axes.{name}", given=value,
                )  # fmt: skip
        line, files, folders = self._script(changed)
        where = self.file.parent / line.liquid
        liquid = filled(read_yaml(where, Wet), {k: value for k, value in values.items() if not k.startswith(PREFIX)})
        wet = parse(Wet, liquid, str(where))
        wet = wet.model_copy(update={"laws": placed_laws(wet.laws, where.resolve().parent, self.trust)})
        texts = {name: text.decode("latin-1") for name, text in files.items() if Path(name) != line.liquid}
        laws = [law for law in wet.laws.model_dump().values() if isinstance(law, str) and ".py:" in law]
        sources = [read_bytes(Path(law.rpartition(":")[0]), CURE).decode("latin-1") for law in laws]
        script, point = identity.of(str(self.file.resolve())), identity.of(texts, wet.model_dump(mode="json"), sources)
        copied = {name: files[name] for name in texts if _below(Path(name))}
        return Built(stored_name(f"script-{script}", point, __file__), Given(line, wet, copied, folders))

    def run(self, built: Built, folder: Path, ranks: int) -> Numbers:
        if ranks > 1:
            raise PywetError(
                f"{self.file.name} was to run on {ranks} ranks; expected 1: a sweep runs its scripts on one rank",
                code="sweep.script_ranks", key="ranks", given=ranks, expected=1, where=self.file,
            )  # fmt: skip
        given, work = built.given, folder / WORK
        shutil.rmtree(work, ignore_errors=True)  # left by a call that was killed: a script has no checkpoint
        liquid = yaml.safe_dump(given.wet.model_dump(mode="json", exclude_none=True)).encode()
        for name, text in (given.files | {str(given.line.liquid): liquid}).items():
            make_folder((work / name).parent)
            (work / name).write_bytes(text)
        for name in given.folders:
            make_folder(work / name)
        command = [sys.executable, "-P", "-m", "pywet.cli.app", "liggghts", "-in", self.file.name]
        status, usage = process.attend(command, work, process.surroundings(python=True), lambda: None)
        if status:
            printed = (work / process.OUTPUT).read_text(errors="replace").splitlines()
            raise PywetError(
                f"{self.file.name}: {process.last_words(printed, status)}",
                code="sweep.script_ended", given=status, where=self.file,
            )  # fmt: skip
        log = work / given.line.log
        last = script_folder.ledger(log).iloc[-1]
        ended = script_folder.ended_at_step(log)
        if ended != last["step"]:
            raise PywetError(
                f"{self.file.name} ended {'by `quit`' if ended is None else f'at step {ended}'} and wrote its last output of the "
                f"liquid at step {last['step']:.0f}; expected its end at an output: change `every` or the steps of `run`",
                code="sweep.script_liquid", given=ended, expected=int(last["step"]), where=self.file,
            )  # fmt: skip
        initial = float(last["initial"]) or math.nan
        found: Numbers = {name: float(last[name]) for name in ("formations", "ruptures")}
        found |= {"bridges_at_end": float(last["bridge_count"]), "processor_time_s": usage.cpu_s}
        found |= {f"liquid_{name}_share": number(float(last[name]) / initial) for name in ("films", "bridges")}
        write_json(folder / "summary.json", found)
        return found

    def cost(self, built: Built) -> Cost:
        return costs.UNKNOWN

    def known(self, built: Built) -> list[str]:
        return list(RESULTS)

    def subject(self, folder: Path) -> Path:
        """Return the argument of a user's function: the folder in which the script ran."""
        return folder / WORK


def _named(script: Path, rows: Iterable[list[str]]) -> Iterator[str]:
    """Yield the files that the commands of a script name, seen from the current folder, except those of its results."""
    for row in rows:
        words = () if row[0] == "shell" or _written(row) else row[1:]
        for name in (name for word in words if "$" not in word or "." in word for name in _there(word)):
            path = Path(name)
            if path.is_file():
                if not path.is_absolute() and not _below(path):
                    raise ConfigError(
                        f"{script} names {name}; expected its files below its folder, or given by absolute paths",
                        code="sweep.script_file", file=script, given=name,
                    )  # fmt: skip
                yield name


def _there(word: str) -> list[str]:
    """Return the files and folders with this path; variables whose values only the engine knows stand for any text."""
    pattern = NAME.sub("*", glob.escape(word))
    return glob.glob(pattern) if pattern.strip("*") else []


def _written(row: list[str]) -> list[str]:
    """Return the result files that a command writes."""
    match row:
        case ["dump", _, _, _, _, file, *_] | ["write_dump", _, _, file, *_]:
            return [file]
        case ["log" | "write_data" | "write_restart", file, *_]:
            return [file]
        case ["restart", _, *files]:
            return files
        case ["print", *more] | ["fix", _, _, *more] if row[0] == "print" or "".join(more[:1]).startswith(LOGGING):
            return [file for key, file in pairwise(more) if key in ("file", "append")]
    return []


def _folders(rows: Iterable[list[str]]) -> Iterator[str]:
    """Yield the folders of the results of a script, and existing ones that it names, below the current folder."""
    for row in rows:
        yield from (folder for word in _written(row) if "$" not in (folder := str(Path(word).parent)))
        parents = [word.rpartition("/")[0] for word in row[1:]]
        there = [Path(name) for parent in parents for name in _there(parent)]
        yield from (str(path) for path in there if path.is_dir() and _below(path))


def _below(path: Path) -> bool:
    return not path.is_absolute() and ".." not in path.parts


def _put(content: bytes, values: dict[str, Value]) -> bytes:
    """Return a file with other values of its variables."""

    def line(found: re.Match[str]) -> str:
        return f"{found[1]}{values[found[2]]}" if found[2] in values else found[0]

    return VARIABLE.sub(line, content.decode("latin-1")).encode("latin-1")


def _seed(name: str, written: str, count: int) -> int:
    """The n-th prime number after the seed in the script, because LIGGGHTS requires prime seeds."""
    first = written.split("#")[0].strip()
    if not first.isdecimal():
        raise ConfigError(
            f"the seed {name} is {first or 'no variable of the script'}; expected a variable that is a number",
            code="sweep.script_seed", key=name, given=first,
        )  # fmt: skip
    seed = int(first)
    for _ in range(count):
        seed += 1
        while any(seed % k == 0 for k in range(2, math.isqrt(seed) + 1)):
            seed += 1
    return seed
