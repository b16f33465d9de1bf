"""Commands that compare runs, and the one that runs a study of a checkout."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Annotated

import typer

from pywet import shipped
from pywet.cli import showing
from pywet.errors import PywetError

app = typer.Typer()


@app.command()
def compare(
    context: typer.Context,
    runs: Annotated[list[Path] | None, typer.Argument(metavar="RUN_A RUN_B", help="Runs, or folders of seeds.")] = None,
    a: Annotated[list[Path] | None, typer.Option("--a", help="A run, or a folder of runs, of group A.")] = None,
    b: Annotated[list[Path] | None, typer.Option("--b", help="A run, or a folder of runs, of group B.")] = None,
    json_file: Annotated[
        Path | None, typer.Option("--json", metavar="OUT", help="Write the comparison to this JSON file.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Also compare different cases.")] = False,
    digest: Annotated[Path | None, typer.Option(help="Compare the runs with this stored digest.")] = None,
    across: Annotated[
        list[str] | None,
        typer.Option("--across", metavar="SETTING", help="Setting that may differ: liquid, duration …; repeatable."),
    ] = None,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="OUT", help="Plot both groups with intervals (.pdf, .svg, .png).")
    ] = None,
) -> None:
    """Compare two runs or two groups of seeds; exit code 0: no difference, 1: difference, 2: not comparable, or not written.

    Example: pywet compare results/seeds/5 results/seeds/7 --across liquid --plot moisture.pdf"""
    from pywet.compare import command

    showing.errors_end_with_2(context)
    raise typer.Exit(command.compare(runs or [], a or [], b or [], json_file, force, digest, across or [], plot))


@app.command()
def digest(
    context: typer.Context,
    run_dirs: Annotated[
        list[Path], typer.Argument(metavar="RUN_DIR …", help="Runs of one scene, or folders of seeds.")
    ],
    to: Annotated[Path | None, typer.Option("--out", help="File to write the digest to.")] = None,
) -> None:
    """Store a digest of runs, for `pywet compare --digest`.

    Example: pywet digest results/smoke/case02 --out case02.json"""
    from pywet.compare import command

    showing.errors_end_with_2(context)
    command.of_runs(run_dirs, to)


@app.command(add_help_option=False, context_settings={"ignore_unknown_options": True, "allow_extra_args": True})
def study(context: typer.Context) -> None:
    """Run a study (only in a checkout): accuracy, stability, effects, laws, cross-code, digests, search.

    Example: pywet study stability --cases 20"""
    if not shipped.open_studies():
        raise PywetError(
            "the studies are not in an installed pywet; expected a checkout of the project: run `pywet study` there",
            code="cli.no_studies",
        )
    studies = import_module("studies.command").app
    raise typer.Exit(studies(context.args, prog_name="pywet study", standalone_mode=False) or 0)
