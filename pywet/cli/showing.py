"""Printed output of run commands, and the few steps that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from rich.console import Console

from pywet import run_folder
from pywet.errors import PywetError
from pywet.util.notices import bar

if TYPE_CHECKING:
    import typer

    from pywet.cases.small.bridge_query import Query

STATUS = "status"
"""Key under which the context of a command has the exit code of its errors, see `errors_end_with_2`."""
out = Console(highlight=False)
err = Console(stderr=True, highlight=False)


def tell(line: object, style: str | None = None) -> None:
    """Print a line of the answer, without markup: on a terminal wrapped between words, elsewhere in one piece."""
    out.print(str(line), style=style, soft_wrap=not out.is_terminal, overflow="ignore", markup=False)


def errors_end_with_2(context: typer.Context) -> None:
    """Let errors end this command with exit code 2, because 1 is one of its results."""
    context.meta[STATUS] = 2


def bridge_table(query: Query, answer: dict[str, Any]) -> None:
    """Print the answer of `pywet bridge` as tables, with the deviation of each law from the exact bridge."""
    from pywet.cases.small import bridge_query
    from pywet.report import bridge

    for table in bridge.table(query.separations_m, answer, bridge_query.exact_force(query)):
        if table.row_count:
            out.print(table)


def check_bridge_plot(path: Path) -> None:
    """Refuse a figure of `pywet bridge` in a format that it is not drawn in."""
    from pywet.report import bands, bridge

    bands.check_name(path, bridge.FORMATS)


def bridge_plot(query: Query, answer: dict[str, Any], path: Path) -> None:
    """Draw force over gap up to the longest bridge; measurements in an engine are drawn as points."""
    from pywet.cases.small import bridge_query
    from pywet.report import bridge

    longest = max(d for d in answer["rupture_distance_m"].values() if d is not None)
    gaps = tuple(longest * (k / 80.0) ** 2 for k in range(81))
    dense = query.model_copy(update={"separations_m": gaps})
    inside = (query.separations_m, answer) if "measured_in" in answer else None
    bridge.draw(path, bridge.figure(gaps, bridge_query.answer(dense), bridge_query.exact_force(dense), inside))


def movie(run_dir: Path) -> list[Path]:
    from pywet.report import movie as drawing

    with bar("movie") as move:
        return drawing.write(run_dir, progress=move)


def serve(server: Any) -> None:
    tell(f"{server.address} (Ctrl-C ends it)")
    with server:
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            out.print("ended")


def refuse_option(option: str, when: str, expected: str) -> NoReturn:
    """Refuse an option that would have no effect."""
    raise PywetError(
        f"{option} was given {when}; expected {expected}", code="cli.unused_option", key=option, expected=expected
    )


def need_run(run_dir: Path) -> None:
    """Refuse a folder that holds no run; where a run is being prepared in it, say that instead."""
    if not (run_dir / "scene.json").exists():
        with run_folder.reading(run_dir):
            pass
        raise PywetError(run_folder.no_run(run_dir), code="cli.no_run", where=run_dir)


def show_audit(run_dir: Path, to: Console = out) -> None:
    """Print each effect's contribution, compared with the effect plan, if the run has both."""
    from pywet.planning import audit

    if rows := audit.read(run_dir):
        to.print("effects, plan against replay:")
        for line in audit.lines(rows):
            to.print(line, soft_wrap=True, highlight=False)
