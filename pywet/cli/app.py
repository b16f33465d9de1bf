"""The command `pywet`: one thin function per subcommand, here and in `cases`, `bodies` and `evidence`; other modules do the work.

A user's mistake ends with one red sentence and exit code 1, a fault of the program with one and exit code 70 (`errors.border`).
Heavy modules are imported inside the commands, so that `pywet --help` responds at once.
"""

from __future__ import annotations

import io
import shlex
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Column, Table
from typer.core import TyperGroup

from pywet.cli import bodies, cases, evidence, plant, script
from pywet.cli.groups import arrange
from pywet.cli.showing import STATUS, err, out, tell
from pywet.ending import clearing_up
from pywet.errors import border, one_line
from pywet.util.notices import shown

ENDS = (typer.Exit, typer.Abort, typer.BadParameter.__mro__[2])
"""Exceptions with which typer ends a command; the last is ClickException, which it does not export."""


class Group(TyperGroup):
    """Command group that reports every error in one red sentence and with an exit code, see `errors.border`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Refuse an empty argument: it usually comes from an unset shell variable and would mean the current folder."""
        ctx.meta["given"] = shlex.join(["pywet", *args])
        empty = next((k for k, word in enumerate(args) if not word or (word[:2] == "--" and word[-1] == "=")), None)
        if empty is not None:
            option = args[empty].rstrip("=") or (args[empty - 1] if empty else "")
            of = f" of {one_line(option)}" if option.startswith("-") else ""
            err.print(
                f"the argument{of} is empty; expected a value (is a variable of the shell not set?)",
                style="red",
                soft_wrap=True,
                markup=False,
            )
            raise typer.Exit(1)
        return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        def say(sentence: str) -> None:
            err.print(sentence, style="red", soft_wrap=True, markup=False)

        with border(ctx.meta["given"], say, passed=ENDS, status=lambda: ctx.meta.get(STATUS, 1)):
            return super().invoke(ctx)

    def main(self, *args: Any, **how: Any) -> Any:
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, io.TextIOWrapper):
                stream.reconfigure(errors="backslashreplace")  # a terminal without UTF-8 shows ± as \xb1
        with clearing_up():
            return super().main(*args, **how)


app = typer.Typer(
    cls=Group,
    no_args_is_help=True,
    add_completion=False,
    help="Screening of moist particles: simulate, cross-check, look. The documentation: pywet docs.",
)


def _version(asked: bool) -> None:
    if asked:
        import pywet

        typer.echo(f"pywet {pywet.__version__}")
        raise typer.Exit


@app.callback()
def pywet_(
    ctx: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Screening of moist particles: simulate, cross-check, look. The documentation: pywet docs."""
    ctx.with_resource(shown())


@app.command()
def init(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder to write to; created if missing.")],
    example: Annotated[
        str,
        typer.Option(
            "--example",
            help="case (a screening study), notebook; scenes: deck, drum, hopper, migration, repose; sweep, bridge, "
            "collision, calibration.",
        ),
    ] = "case",
) -> None:
    """Create a folder with a screening study or an example scene, ready to run.

    Example: pywet init mydrum --example drum"""
    from pywet import shipped

    for path in shipped.begin(folder, example):
        tell(path)
    if example == "case":
        tell(f"config is a copy of {shipped.place('config')}, with its changes if there are any")


@app.command()
def docs(
    page: Annotated[
        str, typer.Argument(metavar="[PAGE]", help="Name of a page, such as tutorial; default: list all pages.")
    ] = "README",
) -> None:
    """Print a page of the documentation, or, without PAGE, the list of pages.

    Example: pywet docs own-scene"""
    from pywet.cli import reference_pages
    from pywet.shipped import place

    if page == "README":
        tell(f"pages in {place('docs')}; pywet docs tutorial prints one\n")
    out.print(reference_pages.page(page), soft_wrap=True, markup=False, highlight=False)


@app.command()
def doctor(as_json: Annotated[bool, typer.Option("--json", help="Print the checks as JSON.")] = False) -> None:
    """Report the programs found on this machine, their versions, and what is missing."""
    from pywet.cli import doctor as module

    raise typer.Exit(module.main(as_json))


@app.command()
def laws(
    check: Annotated[
        str | None,
        typer.Option("--check", metavar="LAW", help="Check one law: its name, or FILE:NAME of a custom law."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the list, or the checks, as JSON.")] = False,
) -> None:
    """List the laws by kind, each with a one-line description, or check one law, also against the exact bridge."""
    if check is not None:
        from pywet.cli import law_check

        raise typer.Exit(law_check.run(check, as_json))
    from pywet.laws import registry

    rows = []
    for kind in registry.BUILT_IN:
        for name in registry.names(kind):
            functions = registry.get(kind, name).functions
            message = (functions[0].__doc__ or "").strip() if functions else "tabulated, see pywet.laws.transfer"
            rows.append((kind, name, message.partition("\n")[0]))
    if as_json:
        out.print_json(data=[dict(zip(("kind", "law", "gives"), row, strict=True)) for row in rows])
        return
    names = [Column(head, min_width=max(len(row[k]) for row in rows)) for k, head in enumerate(("kind", "law"))]
    table = Table(*names, "what it gives", box=None, header_style="bold")
    for row in rows:
        table.add_row(*row)
    # in a narrower terminal lines are wrapped, and no name is cut
    Console(highlight=False, width=max(out.width, 80)).print(table)


for commands in (cases.app, bodies.app, evidence.app, plant.app, script.app):
    app.add_typer(commands)
arrange(app, cases.app, bodies.app, evidence.app, plant.app, script.app)

if __name__ == "__main__":
    app()
