"""Commands that hold runs and laws against each other and against the best truth there is."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pywet.cli.showing import err, out, tell
from pywet.files import make_folder

app = typer.Typer()


@app.command()
def compare(
    runs: Annotated[list[Path] | None, typer.Argument(metavar="RUN_A RUN_B", help="Runs, or folders of seeds.")] = None,
    a: Annotated[list[Path] | None, typer.Option("--a", help="A run, or a folder of runs, of group A.")] = None,
    b: Annotated[list[Path] | None, typer.Option("--b", help="The same of group B.")] = None,
    json_file: Annotated[Path | None, typer.Option("--json", metavar="OUT", help="Write the comparison.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Compare different cases as well.")] = False,
    digest: Annotated[Path | None, typer.Option(help="Compare the runs with this stored digest.")] = None,
    across: Annotated[
        list[str] | None,
        typer.Option("--across", metavar="SETTING", help="May differ: liquid, duration …; repeatable."),
    ] = None,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="OUT", help="Draw both with intervals (.pdf, .svg, .png).")
    ] = None,
) -> None:
    """Compare two runs or two groups of seeds; exit code 0 no difference, 1 difference, 2 not comparable.

    Example: pywet compare results/seeds/5 results/seeds/7 --across liquid --plot moisture.pdf"""
    from pywet.evidence.compare import command

    raise typer.Exit(command.compare(runs or [], a or [], b or [], json_file, force, digest, across or [], plot))


@app.command()
def digest(
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="[RUN_DIR]...", help="Runs of one scene, or folders of seeds; else reference scenes."),
    ] = None,
    to: Annotated[
        Path | None, typer.Option("--out", help="File of the digest of runs; else folder of the reference digests.")
    ] = None,
) -> None:
    """Store a digest of your runs; without runs, run the reference scenes over their seeds and store theirs."""
    from pywet.evidence.compare import command, references

    if names and not set(names) <= set(references.SCENES):
        raise typer.Exit(command.of_runs([Path(name) for name in names], to))
    folder = to or references.STORE
    make_folder(folder)
    command.renew(names or [], folder)


@app.command()
def agreement(
    folder: Annotated[Path, typer.Option("--out", help="Folder of the page.")] = Path("results/agreement"),
    only: Annotated[list[str] | None, typer.Option("--only", metavar="SOURCE", help="Run only these sources.")] = None,
) -> None:
    """Make the table of agreement: every quantity by every program against the best truth, on one page."""
    from pywet.evidence.agreement import page, sources

    make_folder(folder)
    for name in only or sources.SOURCES:
        with err.status(f"agreement: {name}"):
            made = sources.run_source(name, folder)
        out.print(f"{name:<12}{made.failed or f'{len(made.cells)} cells, {made.wall_s:.0f} s'}", soft_wrap=True)
    tell(page.write_page(folder))
