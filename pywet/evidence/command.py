"""Subcommands of `pywet study`; each imports its study when it is called."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pywet.files import make_folder
from pywet.options import number
from pywet.ranges import LIMITS, Range

app = typer.Typer(no_args_is_help=True, help="Studies: what accuracy costs, what stays stable, which effects count.")


@app.command()
def effects(
    out_dir: Annotated[Path, typer.Option("--out", help="Folder of the page and its runs.")] = Path("results/studies"),
    seeds: Annotated[int, number("--seeds", Range(2, 100, whole=True), "First arrangements per scene")] = 4,
    size: Annotated[float, number("--size", Range(0.1, 1), "1: the study; smaller: fewer spheres")] = 1.0,
    scene: Annotated[str | None, typer.Option(help="Only this scene.")] = None,
) -> None:
    """Which effects a scene calls for: the plan against everything on and against each effect left out; one page."""
    from pywet.evidence.effects import study

    make_folder(out_dir)
    for line in study.whole_study(out_dir, seeds, size, scene):
        typer.echo(line)


@app.command()
def accuracy(
    size: Annotated[
        str,
        typer.Option(
            "--size",
            help="quick (minutes), standard (half an hour), whole (an hour); reduced scale: reduced (two hours), reduced_whole.",
        ),
    ] = "standard",
    folder: Annotated[Path, typer.Option("--out", help="Folder of runs and table; the page is beside it.")] = Path(
        "results/studies/accuracy"
    ),
    config: Annotated[Path, typer.Option("--config", help="Folder of the configuration.")] = Path("config"),
    store: Annotated[
        bool, typer.Option("--store", help="Renew the table that `pywet plan CASE --accuracy` reads.")
    ] = False,
    anew: Annotated[bool, typer.Option("--anew", help="Forget the runs that are there.")] = False,
    show: Annotated[bool, typer.Option("--show", help="Only table and page, from the runs that are there.")] = False,
) -> None:
    """What accuracy costs: every setting against a finer one, its error, its price, and where the defaults stand."""
    from pywet.evidence.accuracy import command, runs

    make_folder(folder)
    if anew:
        runs.forget(folder, size)
    page = command.show(folder, size, config, store) if show else command.study(folder, size, config, store)
    typer.echo(str(page))


@app.command()
def stability(
    cases: Annotated[int, number("--cases", Range(1, 1e6, whole=True), "Number of random hard cases")] = 2000,
    seed: Annotated[int, number("--seed", LIMITS["seed"], "Seed of the cases; the same seed gives the same cases")] = 1,
    folder: Annotated[Path, typer.Option("--out", help="Folder of the tables.")] = Path("results/studies/stability"),
) -> None:
    """Maps of where runs stay stable, hard scenes, random hard cases; one page. A study that was cut off goes on."""
    from rich.console import Console

    from pywet.evidence.stability import command

    make_folder(folder)
    typer.echo(str(command.study(cases, seed, folder, Console(stderr=True))))
