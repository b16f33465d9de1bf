"""Subcommands of `pywet study`; each imports its study when it is called."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(no_args_is_help=True, help="Studies: what accuracy costs, what stays stable, which effects count.")


@app.command()
def effects(
    out_dir: Annotated[Path, typer.Option("--out", help="Folder of the page and its runs.")] = Path("results/studies"),
    seeds: Annotated[int, typer.Option(min=2, help="First arrangements per scene.")] = 3,
    size: Annotated[float, typer.Option(min=0.1, max=1.0, help="1: the study; smaller: fewer spheres.")] = 1.0,
    scene: Annotated[str | None, typer.Option(help="Only this scene.")] = None,
) -> None:
    """Which effects a scene calls for: the plan against everything on and against each effect left out; one page."""
    from pywet.study.effects import study

    for line in study.run(out_dir, seeds, size, scene):
        typer.echo(line)
