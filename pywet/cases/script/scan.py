"""What can be said of a script before the engine reads it: its commands in order, with those of included files.

Jumps are not followed and variables not filled in: what they hide is found by the engine itself, at the line or before a run.
"""

from __future__ import annotations

import re
import shlex
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from pywet.cases.script.refusals import holds_still, is_wall, refusal
from pywet.cases.script.wet import STYLE, Line, Wet, line
from pywet.errors import FileError, PywetError
from pywet.util.files import read_bytes

DEEPEST = 16
"""Files that include one another."""


@dataclass(frozen=True)
class Found:
    """A script read: its line of fix pywet and its liquid, fix styles by number, what is in the way."""

    line: Line
    wet: Wet
    styles: Counter[str]
    problems: tuple[PywetError, ...]


def commands(path: Path, depth: int = 0) -> Iterator[list[str]]:
    """Words of every command of a script and of the files that it includes."""
    if depth > DEEPEST:
        raise FileError(
            f"{path} is included by files that include one another; expected none that includes itself",
            path=path, code="wet.includes",
        )  # fmt: skip
    text = read_bytes(path, "a script of LIGGGHTS").decode(errors="replace")
    for row in re.sub(r"&[ \t]*\n", " ", text).splitlines():
        try:
            words = shlex.split(row, comments=True)
        except ValueError:  # a quote that is not closed: the engine says so
            words = row.split("#")[0].split()
        if words:
            yield words
        if words[:1] == ["include"] and len(words) == 2 and "$" not in words[1]:
            yield from commands(Path(words[1]), depth + 1)


def scan(path: Path) -> Found:
    """Read script and liquid; paths in them count from the present folder, as for the engine."""
    rows = list(commands(path))
    lines = [k for k, words in enumerate(rows) if words[0] == "fix" and words[3:4] == [STYLE]]
    if len(lines) != 1:
        raise refusal("wet.two_lines", len(lines)) if lines else refusal("wet.no_line", str(path))
    at = lines[0]
    own = line(rows[at][1:])
    wet = Wet.read(own.liquid)
    problems = [*_before(rows[:at], wet), *_after(rows[at + 1 :], own, wet)]
    if any(words[0] == "clear" for words in rows):
        problems.append(refusal("wet.clear"))
    return Found(own, wet, Counter(words[3] for words in rows if words[0] == "fix" and len(words) > 3), tuple(problems))


def _before(rows: list[list[str]], wet: Wet) -> Iterator[PywetError]:
    fixes: dict[str, str] = {}
    restarts = ""
    for words in rows:
        match words:
            case ["fix", name, _, style, *_]:
                fixes[name] = style
            case ["unfix", name, *_]:
                fixes.pop(name, None)
            case ["restart", every, *_]:
                restarts = "" if every == "0" else " ".join(words)
            case ["neigh_modify", *more]:
                yield from _excluded(more)
            case ["newton", "on", *_]:
                yield refusal("wet.newton")
            case ["boundary", *sides] if any("p" in side for side in sides):
                yield refusal("wet.periodic")
            case ["coarsegraining", *_]:
                yield refusal("wet.coarsegraining")
            case ["units", of, *_] if of != "si":
                yield refusal("wet.units", of)
            case ["pair_style", "gran", *models] if _cohesive(models):
                yield refusal("wet.cohesion")
    if restarts:
        yield refusal("wet.restart", restarts)
    for name, style in fixes.items():
        yield from _of_fix(name, style, wet)


def _after(rows: list[list[str]], own: Line, wet: Wet) -> Iterator[PywetError]:
    for words in rows:
        match words:
            case ["fix", name, _, style, *_]:
                yield from _of_fix(name, style, wet)
            case ["restart" | "write_restart" | "read_restart", *_] if words[1:2] != ["0"]:
                yield refusal("wet.restart", words[0])
            case ["neigh_modify", *more]:
                yield from _excluded(more)
            case ["unfix", name, *_] if name == own.name:
                yield refusal("wet.unfix", " ".join(words))


def _of_fix(name: str, style: str, wet: Wet) -> Iterator[PywetError]:
    named = f"fix {name} ({style})"
    if style.startswith("insert/"):
        yield refusal("wet.insertion", named)
    if holds_still(style):
        yield refusal("wet.frozen", named)
    if "multisphere" in style:
        yield refusal("wet.multisphere", named)
    if is_wall(style) and wet.walls is None:
        yield refusal("wet.walls", named)


def _excluded(more: list[str]) -> Iterator[PywetError]:
    if "exclude" in more and more[more.index("exclude") + 1 :][:1] != ["none"]:
        yield refusal("wet.exclude", " ".join(["neigh_modify", *more]))


def _cohesive(models: list[str]) -> bool:
    return any(key == "cohesion" and value != "off" for key, value in pairwise(models))
