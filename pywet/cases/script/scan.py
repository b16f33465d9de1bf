"""Commands of a script in order, including those of included files, before the engine reads it.

Jumps are not followed, and only variables with numbers and words are substituted; the rest is checked in the engine,
at the fix or before a run.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from pywet.cases.script.refusals import holds_still, of_names, of_wall, refusal
from pywet.cases.script.variables import Variables
from pywet.cases.script.wet import STYLE, Line, Wet, line
from pywet.errors import FileError, PywetError
from pywet.util.files import read_bytes

DEEPEST = 16
"""Largest depth of files that include one another."""


@dataclass(frozen=True)
class Found:
    """Script as read: its line of fix pywet and its liquid, errors, all commands, and the variables at its end."""

    line: Line
    wet: Wet
    problems: tuple[PywetError, ...]
    rows: tuple[list[str], ...]
    variables: Variables


def content(path: Path) -> bytes:
    """Return a script."""
    return read_bytes(path, "a script of LIGGGHTS")


def commands(
    path: Path, depth: int = 0, variables: Variables | None = None, read: Callable[[Path], bytes] = content
) -> Iterator[list[str]]:
    """Yield the words of every command of a script and its included files, with the values of `variables` if given.

    `read` returns the content of each file.
    """
    if depth > DEEPEST:
        raise FileError(
            f"{path} is included by files that include one another; expected none that includes itself",
            path=path, code="wet.includes",
        )  # fmt: skip
    text = read(path).decode(errors="replace")
    for row in re.sub(r"&[ \t\r]*\n", " ", text).splitlines():
        words = _words(row)
        if variables:
            words = variables.filled(words)
            variables.learn(words)
        if words:
            yield words
        if words[:1] == ["include"] and len(words) == 2 and "$" not in words[1]:
            yield from commands(Path(words[1]), depth + 1, variables, read)
        elif words:
            for inner in filter(None, map(_words, _hidden(words))):
                if variables:
                    variables.doubt(inner)
                yield inner


def _words(row: str) -> list[str]:
    """Divide a command into words; an unclosed quote is reported by the engine."""
    try:
        return shlex.split(row, comments=True)
    except ValueError:
        return row.split("#")[0].split()


def _hidden(words: list[str]) -> list[str]:
    """Return the commands within a command: of `if` after then and else, of `run` after every N."""
    if words[0] == "if" and "then" in words:
        after = words[words.index("then") + 1 :]
        return [w for k, w in enumerate(after) if w not in ("elif", "else") and (k == 0 or after[k - 1] != "elif")]
    if words[0] == "run" and "every" in words:
        return [w for w in words[words.index("every") + 2 :] if w != "NULL"]
    return []


def meshes_of(words: list[str]) -> list[str]:
    """Return the meshes that a fix wall/gran names."""
    if "n_meshes" not in words or "meshes" not in words:
        return []
    first, number = words.index("meshes") + 1, words[words.index("n_meshes") + 1 :][:1]
    return words[first : first + int(number[0])] if number and number[0].isdigit() else []


def scan(
    path: Path, words: Sequence[str] = (), engine: str = "liggghts", read: Callable[[Path], bytes] = content
) -> Found:
    """Read script and liquid; paths are relative to the current folder, as for the engine.

    `words`: engine options; `read` returns the content of each file.
    """
    variables = Variables(words)
    rows = list(commands(path, variables=variables, read=read))
    lines = [k for k, words in enumerate(rows) if words[0] == "fix" and words[3:4] == [STYLE]]
    if len(lines) != 1:
        raise refusal("wet.two_lines", len(lines)) if lines else refusal("wet.no_line", str(path))
    at = lines[0]
    wet_line = line(rows[at][1:])
    wet = Wet.read(wet_line.liquid)
    fixes = [words for words in rows if words[0] == "fix" and len(words) > 3]
    problems = [*_before(rows[:at], wet), *_after(rows[at + 1 :], wet_line, wet)]
    problems += of_names(((words[1], words[3], meshes_of(words)) for words in fixes), wet.walls)
    if engine == "lammps":
        problems += _of_lammps(rows)
    if any(words[0] == "clear" for words in rows):
        problems.append(refusal("wet.clear"))
    return Found(wet_line, wet, tuple(problems), tuple(rows), variables)


def _before(rows: list[list[str]], wet: Wet) -> Iterator[PywetError]:
    fixes: dict[str, list[str]] = {}
    lists: dict[str, str] = {}
    for words in rows:
        match words:
            case ["fix", name, _, _, *_]:
                fixes[name] = words
            case ["unfix", name, *_]:
                fixes.pop(name, None)
            case ["neigh_modify", *more]:
                yield from _excluded(more)
                lists |= dict(zip(more[::2], more[1::2], strict=False))
            case ["newton", "on", *_]:
                yield refusal("wet.newton")
            case ["coarsegraining", *_]:
                yield refusal("wet.coarsegraining")
            case ["units", of, *_] if of != "si":
                yield refusal("wet.units", of)
            case ["pair_style", "gran", *models] if model := _cohesive(models):
                yield refusal("wet.cohesion", f"pair_style gran ({model})")
    yield from _lists(lists)
    for words in fixes.values():
        yield from _of_fix(words, wet)


def _after(rows: list[list[str]], wet_line: Line, wet: Wet) -> Iterator[PywetError]:
    for words in rows:
        match words:
            case ["fix", _, _, _, *_]:
                yield from _of_fix(words, wet)
            case ["neigh_modify", *more]:
                yield from _excluded(more)
            case ["unfix", name, *_] if name == wet_line.name:
                yield refusal("wet.unfix", " ".join(words))
            case ["unfix", name, *_] if name in wet.wet_walls:
                yield refusal("wet.lost_wall", name)
            case ["change_box", *_]:
                yield refusal("wet.deform", " ".join(words))
            case ["delete_atoms", *more] if more[-2:] != ["compress", "no"]:
                yield refusal("wet.compress", " ".join(words))


def _of_lammps(rows: list[list[str]]) -> Iterator[PywetError]:
    """Yield an error for LAMMPS commands that are not supported: cohesive contact models, given in pair_coeff and in walls."""
    for words in rows:
        if words[0] == "read_restart":
            yield refusal("wet.no_restart", " ".join(words))
        if words[0] in ("pair_coeff", "fix") and (model := next((w for w in words if w in ("jkr", "dmt")), "")):
            yield refusal("wet.cohesion", f"{' '.join(words[:4])} ({model})")


def _of_fix(words: list[str], wet: Wet) -> Iterator[PywetError]:
    name, style = words[1], words[3]
    named = f"fix {name} ({style})"
    if holds_still(style):
        yield refusal("wet.frozen", named)
    if style == "deform":
        yield refusal("wet.deform", named)
    if style == "nve/sphere" and words[2] != "all":
        yield refusal("wet.moved_group", f"{name} ({style} of the group {words[2]})")
    if "multisphere" in style:
        yield refusal("wet.multisphere", named)
    if style.startswith("wall/gran") and (model := _cohesive(words)):
        yield refusal("wet.cohesion", f"{named} ({model})")
    yield from of_wall(name, style, meshes_of(words), wet.walls)


def _lists(given: dict[str, str]) -> Iterator[PywetError]:
    """Yield an error for neighbour lists that are rebuilt too late or exclude pairs, given the arguments of neigh_modify."""
    needed = {"delay": "0", "every": "1", "check": "yes"}
    if wrong := " ".join(f"{n} {given[n]}" for n, v in needed.items() if given.get(n, v) != v and "$" not in given[n]):
        yield refusal("wet.neighbour", wrong)
    factor = given.get("contact_distance_factor", "1")
    if re.fullmatch(r"[0-9.]+", factor) and float(factor) != 1.0:
        yield refusal("wet.contact_distance", factor)


def _excluded(more: list[str]) -> Iterator[PywetError]:
    if "exclude" in more and more[more.index("exclude") + 1 :][:1] != ["none"]:
        yield refusal("wet.exclude", " ".join(["neigh_modify", *more]))


def _cohesive(models: list[str]) -> str:
    """Return the cohesion model; empty if none, or if a variable names it, which is then read from the engine at the fix."""
    return next((v for key, v in pairwise(models) if key == "cohesion" and v != "off" and "$" not in v), "")
