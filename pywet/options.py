"""Numeric options of the command line: each with its range, refused in one sentence that names it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import typer

from pywet.ranges import LIMITS, Range

STEP = Range(0, 1e12, whole=True)


def reader(name: str, limits: Range) -> Callable[[Any], Any]:
    """Reads the text of an option."""

    def read(given: Any) -> Any:
        return limits.read(name, given)

    read.__name__ = "integer" if limits.whole else "number"
    return read


def number(flag: str, limits: Range, said: str) -> Any:
    """An option that holds a number in a range."""
    return typer.Option(flag, parser=reader(flag, limits), help=f"{said} ({limits}).")


def case_number() -> Any:
    """The argument CASE."""
    return typer.Argument(
        metavar="CASE", parser=reader("CASE", LIMITS["case"]), help="Number of the case in cases.csv."
    )
