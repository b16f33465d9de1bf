"""Commands of process engineers: what a screen did, and how fast a batch passes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from pywet.cli.showing import out, tell

app = typer.Typer()


@app.command("screen")
def screen_numbers(
    runs: Annotated[
        list[Path], typer.Argument(metavar="RUN_DIR...", help="Finished runs of cases, or of scenes with outlets.")
    ],
    aperture: Annotated[
        float | None, typer.Option("--aperture", metavar="MM", help="Size that parts undersize from oversize, in mm.")
    ] = None,
    from_s: Annotated[float | None, typer.Option("--from", metavar="S", help="Take means from this time on.")] = None,
) -> None:
    """Cut size, efficiency, throughput, moisture of the products and pegging of screens, as tables and pages.

    Example: pywet screen results/smoke/case02"""
    from pywet.products import pages, screening_report
    from pywet.products.partition import mean_and_half_width

    found = [screening_report.write(run, aperture, from_s) for run in runs]
    table = Table("run", *pages.five(found[0]))
    for numbers in found:
        table.add_row(numbers["run"], *pages.five(numbers).values())
    out.print(table)
    for key, name, factor in (("d50_mm", "cut size [mm]", 1.0), ("efficiency", "efficiency [%]", 100.0)):
        values = [factor * numbers[key] for numbers in found if numbers[key] is not None]
        if len(values) > 1:
            tell("{}: {:.4g} ± {:.2g} (mean of {} runs, 95 %)".format(name, *mean_and_half_width(values), len(values)))
    for run, numbers in zip(runs, found, strict=True):
        tell(f"page: {pages.write(run, numbers)}; tables: {run / 'results'}")
