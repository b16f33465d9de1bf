"""Subcommands of `pywet study`; each imports its study when it is called."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from pywet.util.files import make_folder
from pywet.util.notices import bar
from pywet.util.options import number
from pywet.util.ranges import LIMITS, Range

if TYPE_CHECKING:
    from studies.study import Study

HELP = """Run a study (only in a checkout): accuracy, stability, effects, laws, cross-code, digests, search.

Example: pywet study stability --cases 20"""
app = typer.Typer(
    no_args_is_help=True,
    help=HELP,
)
CONFIG = Path("config")
err = Console(stderr=True, highlight=False)
ConfigDir = Annotated[Path, typer.Option("--config", help="Folder of the configuration.")]


def carried_out(study: Study, title: str) -> Path:
    """Execute missing runs with a progress bar and return the page."""
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
    from pywet.shipped import place
    from studies.effects.study import EffectsStudy

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
    folder: Annotated[Path, typer.Option("--out", help="Folder of runs and table; the page is next to it.")] = Path(
        "results/studies/accuracy"
    ),
    config: ConfigDir = CONFIG,
    store: Annotated[
        bool, typer.Option("--store", help="Renew the table that `pywet plan CASE --accuracy` reads.")
    ] = False,
    again: Annotated[bool, typer.Option("--again", help="Delete the stored runs of this size first.")] = False,
    show: Annotated[bool, typer.Option("--show", help="Only table and page, from the runs that are there.")] = False,
) -> None:
    """What accuracy costs: every setting compared with a finer one, its error, its cost, and the position of the defaults."""
    from pywet.cost import command
    from studies.accuracy import study as accuracy_study

    study = accuracy_study.AccuracyStudy(folder, size, config)
    make_folder(folder)
    if again:
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
    """Maps of stable runs, stress tests, random extreme cases; one page. An interrupted study resumes."""
    from studies.stability.study import StabilityStudy

    make_folder(folder)
    typer.echo(str(carried_out(StabilityStudy(folder, cases, seed), "stability")))


@app.command("cross-code")
def cross_code(
    folder: Annotated[Path, typer.Option("--out", help="Folder of the page.")] = Path("results/agreement"),
    only: Annotated[list[str] | None, typer.Option("--only", metavar="SOURCE", help="Run only these sources.")] = None,
) -> None:
    """Compare every quantity of every program with the best known value, on one page."""
    from studies.cross_code import page, sources

    make_folder(folder)
    for name in only or sources.SOURCES:
        with err.status(f"cross-code: {name}"):
            made = sources.run_source(name, folder)
        typer.echo(f"{name:<12}{made.failed or f'{len(made.cells)} cells, {made.wall_s:.0f} s'}")
    typer.echo(str(page.write_page(folder)))


@app.command()
def laws(
    folder: Annotated[Path, typer.Option("--out", help="Folder of the page.")] = Path("results/atlas"),
    stock: Annotated[bool, typer.Option(help="Measure stock LIGGGHTS and YADE as well.")] = True,
    law: Annotated[
        list[str] | None,
        typer.Option("--law", metavar="FILE:NAME", help="A law of yours in addition; may be repeated."),
    ] = None,
) -> None:
    """Compare every law with the exact bridge; one page."""
    from pywet.laws import custom_laws
    from studies.law_comparison import page

    mine = [custom_laws.placed(name) for name in law or []]
    custom_laws.trust(mine)
    make_folder(folder)
    with bar("laws") as move:
        written = page.write_page(folder, lambda what, share: move(share, title=what), with_stock=stock, custom=mine)
    typer.echo(str(written))


@app.command()
def digests(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[SCENE]...", help="Reference scenes; default all.")
    ] = None,
    folder: Annotated[Path, typer.Option("--out", help="Folder of the digests.")] = Path("tests/data/digests"),
) -> None:
    """Run the reference scenes over their seeds and store their digests."""
    from studies import references

    make_folder(folder)
    for name in names or references.SCENES:
        with err.status(f"digest {name}: running its seeds"):
            path = references.renew(name, folder)
        typer.echo(str(path))


@app.command()
def search(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="YAML: statements, entries to vary, see docs/search-readings.md.")
    ],
    out_dir: Annotated[Path | None, typer.Option("--out", help="Folder; default results/calibrations/FILE.")] = None,
) -> None:
    """Search for the readings and dimensions under which statements of the paper are confirmed."""
    from pywet.util import machine_code
    from studies.search import statement_search

    folder = out_dir or Path("results") / "calibrations" / file.stem
    with machine_code.compiling("search"):
        answer = statement_search.calibrate(file, folder, lambda line: err.print(line, soft_wrap=True, markup=False))
    for line in [*answer["sentences"], f"calibration.json is in {folder}"]:
        typer.echo(line)
    if not answer["reached"]:
        raise typer.Exit(1)
