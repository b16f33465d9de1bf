"""Lines that a page shows below a command, compared with what the command printed.

A line `…` on a page means any number of lines, `…` within a line, with the spaces around it, for any text.
Otherwise the lines are compared in order and to the last, words separated by one space and the rules of a table left out.
MACHINE is what differs from machine to machine.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

CUT = "…"
RULES = re.compile("[\u2500-\u257f]")
NUMBER = r"(?<![\w.])[+-]?\d[\d,]*(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.]|\d)"
NOTHING = 1e-11
"""Numbers below this are round-off, and equal."""
MACHINE = r"(?<![\w.])\d[\d.,]*(?:e-?\d+)? (?:s|min|h|core-hours|kB|MB|GB)(?!\w)|(?<!\S)/[\w./-]+"
"""Times, sizes in memory and on disk, and paths that begin with a slash."""


def lines_of(text: str) -> list[str]:
    """Lines of a text that are not empty, words separated by one space, without the rules of tables."""
    plain = (" ".join(RULES.sub(" ", line).split()) for line in text.splitlines())
    return [line for line in plain if line]


def same_line(shown: str, printed: str, tolerance: float) -> bool:
    """Compare two lines; numbers may differ by a share of the larger one, those of the machine by any."""
    pattern, numbers = "", []
    for piece in re.split(f"({MACHINE}|{NUMBER}| ?{CUT} ?)", shown):
        if piece.strip() == CUT:
            pattern += ".*?"
        elif re.fullmatch(MACHINE, piece):
            pattern += f"(?:{MACHINE})"
        elif re.fullmatch(NUMBER, piece):
            pattern += f"({NUMBER})"
            numbers.append(piece)
        else:
            pattern += re.escape(piece)
    found = re.fullmatch(pattern, printed)
    return found is not None and all(
        one == two or math.isclose(value(one), value(two), rel_tol=tolerance, abs_tol=NOTHING)
        for one, two in zip(numbers, found.groups(), strict=True)
    )


def value(number: str) -> float:
    return float(number.replace(",", ""))


def is_output(shown: Sequence[str], printed: Sequence[str], tolerance: float = 0.0) -> bool:
    """Tell whether lines of a page abridge an output; with an infinite tolerance only the text is compared."""
    if not shown:
        return not printed
    if shown[0] == CUT:
        return any(is_output(shown[1:], printed[k:], tolerance) for k in range(len(printed) + 1))
    return bool(printed) and same_line(shown[0], printed[0], tolerance) and is_output(shown[1:], printed[1:], tolerance)
