"""Random faults in source text: an operator, a constant, an index, a sign, a dropped line, two arguments exchanged.

Made on tokens, so that C++ and Python are treated alike; what no longer compiles is drawn again by whoever tries it.
"""

from __future__ import annotations

import random
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

OPERATORS = {
    "+": "-", "-": "+", "*": "/", "/": "*", "<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==",
    "&&": "||", "||": "&&", "+=": "-=", "-=": "+=", "and": "or", "or": "and", "min": "max", "max": "min", "sin": "cos",
    "true": "false", "false": "true", "True": "False", "False": "True", "x": "y", "y": "z", "z": "x", "i": "j", "j": "i",
}  # fmt: skip
SKIPPED = r'"""(?:.|\n)*?"""|//[^\n]*|/\*(?:.|\n)*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\''
"""Comments and texts; in Python what follows # as well."""
TOKEN = re.compile(
    rf"(?P<skip>{SKIPPED}|#[^\n]*)|(?P<number>\b\d+\.?\d*(?:[eE][+-]?\d+)?)|(?P<word>[A-Za-z_]\w*)"
    r"|(?P<sign><=|>=|==|!=|&&|\|\||\+=|-=|\*=|->|::|<<|>>|\+\+|--|\*\*|[-+*/<>])"
)
PAIR = re.compile(r"\(([A-Za-z_][\w.]*), ([A-Za-z_][\w.]*)\)")
NO_STATEMENT = (
    "import",
    "from",
    "def",
    "class",
    "return",
    "@",
    "#",
    "}",
    "using",
    "struct",
    "namespace",
    "template",
    "*",
)


CHANGES = r"[\w.\[\], ]+ [-+*/]= .*[^,({\[]|\w+[.\[].* = .*[^,({\[]|[\w.]+\(.*\)"
"""A line of Python that changes what is there; one that makes a name is not dropped, since its absence stops any program."""


@dataclass(frozen=True)
class Mutant:
    """A fault: the file, its line, what was done to it, and the new text."""

    path: Path
    line: int
    what: str
    text: str


def draw(paths: list[Path], rng: random.Random) -> Mutant:
    """One fault in one of the files, every place as likely as any other of the same file; long files are hit more often."""
    weights = [p.stat().st_size for p in paths]
    while True:
        path = rng.choices(paths, weights)[0]
        found = list(mutants(path))
        if found:
            return rng.choice(found)


def mutants(path: Path) -> Iterator[Mutant]:
    """All faults that can be made in a file, the second of a kind in a line with its number."""
    text, times = path.read_text(), Counter[tuple[int, str]]()
    for one in (*_tokens(path, text), *_exchanged(path, text), *_dropped(path, text)):
        times[one.line, one.what] += 1
        nth = times[one.line, one.what]
        yield one if nth == 1 else replace(one, what=f"{one.what} ({nth})")


def code(text: str, line: int) -> str:
    """A line by its text after the start of the function or class that it is in, which stay where lines above are edited."""
    lines = text.split("\n")[:line]
    begins = next((start for start in reversed(lines) if re.match(r"\w", start)), "")
    return f"{begins.partition('(')[0].strip(' :{')}: {lines[-1].strip()}"


def _line(text: str, place: int) -> int:
    return text.count("\n", 0, place) + 1


def _tokens(path: Path, text: str) -> Iterator[Mutant]:
    for match in TOKEN.finditer(text):
        old = match.group()
        line = text[text.rfind("\n", 0, match.start()) + 1 : match.start()].lstrip()
        if match.group("skip") or line.startswith(("import ", "from ", "#include", "def ", "class ", "@")):
            continue
        new = _number(old) if match.group("number") else OPERATORS.get(old)
        if new is not None:
            yield Mutant(path, _line(text, match.start()), f"{old} -> {new}", _replaced(text, match, new))


def _replaced(text: str, match: re.Match[str], new: str) -> str:
    return text[: match.start()] + new + text[match.end() :]


def _number(old: str) -> str:
    """A constant one per cent too large, a whole number one too large."""
    return repr(1.01 * float(old) or 1e-3) if "." in old or "e" in old.lower() else str(int(old) + 1)


def _exchanged(path: Path, text: str) -> Iterator[Mutant]:
    skipped = [m.span() for m in TOKEN.finditer(text) if m.group("skip")]
    for match in PAIR.finditer(text):
        if any(start <= match.start() < end for start, end in skipped):
            continue
        a, b = match.groups()
        new = f"({b}, {a})"
        yield Mutant(path, _line(text, match.start()), f"{match.group()} -> {new}", _replaced(text, match, new))


def _dropped(path: Path, text: str) -> Iterator[Mutant]:
    """Whole statements on one line that change something."""
    lines = text.split("\n")
    for k, line in enumerate(lines):
        output_text = line.strip()
        if path.suffix == ".py":
            whole = re.fullmatch(CHANGES, output_text) and output_text.count("(") == output_text.count(")")
            new = line[: len(line) - len(line.lstrip())] + "pass"
        else:
            whole = output_text.endswith(";") and re.match(r"[\w.>\[\]-]+ (?:[-+*/]?=) |[\w.>-]+\(", output_text)
            new = ""
        if whole and not output_text.startswith(NO_STATEMENT):
            yield Mutant(path, k + 1, f"dropped: {output_text}", "\n".join([*lines[:k], new, *lines[k + 1 :]]))
