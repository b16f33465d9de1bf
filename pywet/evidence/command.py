"""Subcommands of `pywet study`; each imports its study when it is called."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pywet.files import make_folder
from pywet.notices import bar
from pywet.options import number
from pywet.ranges import LIMITS, Range

if TYPE_CHECKING:
    from pywet.evidence.study import Study

app = typer.Typer(no_args_is_help=True, help="Studies: what accuracy costs, what stays stable, which effects count.")
CONFIG = Path("config")
ConfigDir = Annotated[Path, typer.Option("--config", help="Folder of the configuration.")]


def carried_out(study: Study, title: str) -> Path:
    """Do what is missing, with a progress bar; the page."""
    with bar(title) as move:
        return study.carry_out(lambda name, share: move(share, title=f"{title}: {name}"))


@app.command()
def effects(
    out_dir: Annotated[Path, typer.Option("--out", help="Folder of the page; the runs are below it.")] = Path(
        "results/studies"
    ),
    seeds: Annotated[int, number("--seeds", Range(2, 100, whole=True), "First arrangements per scene")] = 4,
    size: Annotated[float, number("--size", Range(0.1, 1), "1: the study; smaller: fewer spheres")] = 1.0,
    scene: Annotated[str | None, typer.Option(help="Only this scene.")] = None,
    config: ConfigDir = CONFIG,
    store: Annotated[
        str | None, typer.Option("--store", metavar="WHERE", help="Renew the costs that plans know; machine and date.")
    ] = None,
) -> None:
    """Which effects a scene calls for: the plan against everything on and against each effect left out; one page."""
    from pywet.evidence.effects.study import EffectsStudy
    from pywet.shipped import place

    make_folder(out_dir)
    folder = config if config != CONFIG or config.exists() else place("config")
    study = EffectsStudy(out_dir / "effects", seeds, size, scene, folder)
    page = carried_out(study, "effects")
    for line in [*study.lines(), f"the page is {page}"]:
        typer.echo(line)
    if store is not None:
        typer.echo(str(study.store(store)))


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
    config: ConfigDir = CONFIG,
    store: Annotated[
        bool, typer.Option("--store", help="Renew the table that `pywet plan CASE --accuracy` reads.")
    ] = False,
    anew: Annotated[bool, typer.Option("--anew", help="Forget the runs that are there.")] = False,
    show: Annotated[bool, typer.Option("--show", help="Only table and page, from the runs that are there.")] = False,
) -> None:
    """What accuracy costs: every setting against a finer one, its error, its price, and where the defaults stand."""
    from pywet.evidence.accuracy import command
    from pywet.evidence.accuracy import study as accuracy_study

    study = accuracy_study.AccuracyStudy(folder, size, config)
    make_folder(folder)
    if anew:
        study.forget()
    missing = 0 if show else len(study.missing())
    if missing:
        spent = f"about {command.duration(study.expected())} on a quiet machine (stop and go on at any time)"
        typer.echo(f"{missing} runs to do, {spent}", err=True)
    page = study.show() if show else carried_out(study, "accuracy")
    if store:
        accuracy_study.store(study.table())
    typer.echo(str(page))


@app.command()
def stability(
    cases: Annotated[int, number("--cases", Range(1, 1e6, whole=True), "Number of random hard cases")] = 2000,
    seed: Annotated[int, number("--seed", LIMITS["seed"], "Seed of the cases; the same seed gives the same cases")] = 1,
    folder: Annotated[Path, typer.Option("--out", help="Folder of the tables.")] = Path("results/studies/stability"),
) -> None:
    """Maps of where runs stay stable, hard scenes, random hard cases; one page. A study that was cut off goes on."""
    from pywet.evidence.stability.study import StabilityStudy

    make_folder(folder)
    typer.echo(str(carried_out(StabilityStudy(folder, cases, seed), "stability")))
