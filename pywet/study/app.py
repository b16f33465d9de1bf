"""Subcommands of `pywet study`; each imports its study when it is called."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(no_args_is_help=True, help="Studies: what accuracy costs, what stays stable, which effects count.")


@app.command()
def stability(
    cases: Annotated[int, typer.Option(min=1, help="Number of random hard cases.")] = 2000,
    seed: Annotated[int, typer.Option(help="Seed of the cases; the same seed gives the same cases.")] = 1,
    folder: Annotated[Path, typer.Option("--out", help="Folder of the tables.")] = Path("results/studies/stability"),
) -> None:
    """Maps of where runs stay stable, hard scenes, random hard cases; one page. A study that was cut off goes on."""
    from rich.console import Console

    from pywet.study.stability import command

    typer.echo(str(command.study(cases, seed, folder, Console(stderr=True))))
