"""Arguments and options shared by commands; numbers have ranges and are refused in one sentence that names the range."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from pywet.errors import PywetError
from pywet.util.ranges import LIMITS, Range

STEP = Range(0, 1e12, whole=True)
PORT = Range(0, 65535, whole=True)
SEEDS = Range(1, 1000, whole=True)
SPHERE = Range(1, 1e9, whole=True)


def reader(name: str, limits: Range) -> Callable[[Any], Any]:

    def read(given: Any) -> Any:
        return limits.read(name, given)

    read.__name__ = "integer" if limits.whole else "number"
    return read


def _case(given: Any) -> Any:
    """Read the number of a case; a file of a scene is answered with the commands for scenes."""
    if str(given).endswith((".yaml", ".yml")):
        raise PywetError(
            f"CASE is {given}; expected the number of a case: for a scene use pywet run-scene {given}, with --check to print its "
            "plan and run nothing",
            key="CASE", given=given, code="option.case",
        )  # fmt: skip
    return LIMITS["case"].read("CASE", given)


_case.__name__ = "integer"


def number(flag: str, limits: Range, text: str) -> Any:
    return typer.Option(flag, parser=reader(flag, limits), help=f"{text} ({limits}).")


CaseNumber = Annotated[int, typer.Argument(metavar="CASE", parser=_case, help="Number of the case in cases.csv.")]
AnyCase = Annotated[
    int | None,
    typer.Argument(metavar="[CASE]", parser=_case, help="Number of a case; default: all cases."),
]
Ranks = Annotated[int, number("--ranks", LIMITS["ranks"], "MPI ranks of the engine")]
CaseRanks = Annotated[
    int | None, number("--ranks", LIMITS["ranks"], "MPI ranks of the engine; default: for a case those of config.yaml")
]
ScaleName = Annotated[str | None, typer.Option("--scale", help="smoke, reduced or full; default: that of config.yaml.")]
ConfigDir = Annotated[Path, typer.Option("--config", help="Folder of the configuration.")]
RunFolder = Annotated[Path, typer.Argument(metavar="RUN_DIR", help="Run directory, such as results/smoke/case02.")]
JsonFile = Annotated[Path, typer.Argument(metavar="FILE", help="JSON description; the answer is also JSON.")]
Trust = Annotated[bool, typer.Option("--trust", help="Execute the Python files of custom laws; read them first.")]
Verbose = Annotated[bool, typer.Option("--verbose", help="Print everything that is in details.txt of the run.")]
