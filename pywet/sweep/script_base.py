"""A LIGGGHTS script with liquid as the base of a sweep: keys of its liquid's file and variables of the script are axes.

Each point has its own folder, to which files below the script's folder that it names are copied.
"""

from __future__ import annotations

import math
import re
import shutil
import sys
from collections.abc import Iterator
from contextlib import chdir
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from pywet.cases.screening import identity
from pywet.cases.script import folder as script_folder
from pywet.cases.script.scan import commands, scan
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
WRITES = ("dump", "log", "print", "restart", "write_data", "write_restart", "shell")
"""Commands that write result files."""
RESULTS = ("formations", "ruptures", "bridges_at_end", "liquid_films_share", "liquid_bridges_share", "processor_time_s")
CURE = "name a LIGGGHTS script with the line of fix pywet; its path counts from the sweep's folder"


class Given(NamedTuple):
    """A point of a script: its liquid, and the content of every copied file."""

    wet: Wet
    files: dict[str, bytes]


class OfScript(Kind):
    """A script run as by `pywet liggghts`."""

    results = ("formations", "ruptures")

    @property
    def seeded(self) -> bool:  # type: ignore[override]
        """Return whether a variable of the script is its seed."""
        return self.base.seed is not None

    @cached_property
    def _read(self) -> tuple[Line, dict[str, bytes], dict[str, Any]]:
        """Return the line of fix pywet, the files to copy by their path from the script, and the content of the liquid's file."""
        read_bytes(self.file, CURE)
        with chdir(self.file.parent):
            found = scan(Path(self.file.name))
            if found.problems:
                raise found.problems[0]
            names = {self.file.name, *_named(Path(self.file.name))}
            files = {name: read_bytes(Path(name), CURE) for name in sorted(names)}
            liquid = read_yaml(found.line.liquid, Wet)
        self._tables(found.line)
        return found.line, files, liquid

    def _tables(self, line: Line) -> Path:
        """Return the folder of the tables, relative to the script."""
        if not _below(line.log):
            raise ConfigError(
                f"{self.file} writes its tables to {line.log}; expected a folder below the script's, one for each point",
                code="sweep.script_log", file=self.file, given=line.log,
            )  # fmt: skip
        return line.log

    def _variables(self) -> dict[str, str]:
        """Return the variables of the script and of included files, with the values in the text."""
        texts = [content.decode(errors="replace") for content in self._read[1].values()]
        return {name: value for text in texts for _, name, value in VARIABLE.findall(text)}

    def built(self, values: Point, seed: int) -> Built:
        line, files, liquid = self._read
        changed: dict[str, Value] = {k.removeprefix(PREFIX): v for k, v in values.items() if k.startswith(PREFIX)}
        there = self._variables()
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
        where = self.file.parent / line.liquid
        content = filled(liquid, {key: value for key, value in values.items() if not key.startswith(PREFIX)})
        wet = parse(Wet, content, str(where))
        wet = wet.model_copy(update={"laws": placed_laws(wet.laws, where.resolve().parent, self.trust)})
        filled_in = {name: _put(content, changed) for name, content in files.items() if Path(name) != line.liquid}
        texts = {name: content.decode("latin-1") for name, content in filled_in.items()}
        laws = [law for law in wet.laws.model_dump().values() if isinstance(law, str) and ".py:" in law]
        sources = [read_bytes(Path(law.rpartition(":")[0]), CURE).decode("latin-1") for law in laws]
        script, point = identity.of(str(self.file.resolve())), identity.of(texts, wet.model_dump(mode="json"), sources)
        return Built(stored_name(f"script-{script}", point, __file__), Given(wet, filled_in))

    def run(self, built: Built, folder: Path, ranks: int) -> Numbers:
        if ranks > 1:
            raise PywetError(
                f"{self.file.name} was to run on {ranks} ranks; expected 1: a sweep runs its scripts on one rank",
                code="sweep.script_ranks", key="ranks", given=ranks, expected=1, where=self.file,
            )  # fmt: skip
        line, work = self._read[0], folder / WORK
        shutil.rmtree(work, ignore_errors=True)  # left by a call that was killed: a script has no checkpoint
        for name, content in built.given.files.items():
            make_folder((work / name).parent)
            (work / name).write_bytes(content)
        for name in self._folders():
            make_folder(work / name)
        make_folder((work / line.liquid).parent)
        (work / line.liquid).write_text(yaml.safe_dump(built.given.wet.model_dump(mode="json", exclude_none=True)))
        with chdir(work):
            log = work / self._tables(scan(Path(self.file.name)).line)  # the point's variables may name another
        command = [sys.executable, "-P", "-m", "pywet.cli.app", "liggghts", "-in", self.file.name]
        status, usage = process.attend(command, work, process.surroundings(python=True), lambda: None)
        if status:
            printed = (work / process.OUTPUT).read_text(errors="replace").splitlines()
            raise PywetError(
                f"{self.file.name}: {process.last_words(printed, status)}",
                code="sweep.script_ended", given=status, where=self.file,
            )  # fmt: skip
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

    def _folders(self) -> set[str]:
        """Return the folders below the script's to which it writes."""
        with chdir(self.file.parent):
            words = [Path(word) for row in commands(Path(self.file.name)) for word in row[1:] if "/" in word]
            return {str(word.parent) for word in words if word.parent.is_dir() and _below(word)}

    def cost(self, built: Built) -> Cost:
        return costs.UNKNOWN

    def known(self, built: Built) -> list[str]:
        return list(RESULTS)

    def subject(self, folder: Path) -> Path:
        """Return the argument of a user's function: the folder in which the script ran."""
        return folder / WORK


def _named(script: Path) -> Iterator[str]:
    """Yield the files below the current folder that a script names, and those of files that it includes."""
    for command, *words in commands(script):
        for word in () if command in WRITES else words:
            path = Path(word)
            if not path.is_absolute() and path.is_file():
                if not _below(path):
                    raise ConfigError(
                        f"{script} names {word}; expected its files below its folder, or given by absolute paths",
                        code="sweep.script_file", file=script, given=word,
                    )  # fmt: skip
                yield word


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
