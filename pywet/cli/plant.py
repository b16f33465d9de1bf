"""Commands for process engineers: evaluation of a screen, and batch kinetics."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.markup import escape
from rich.table import Table

from pywet.cli.showing import out, refuse_option, tell
from pywet.util.options import number
from pywet.util.ranges import LIMITS, Range

app = typer.Typer()
FROM, DECK = Range(0, LIMITS["duration_s"].high, "s"), Range(1, 100, whole=True)


@app.command("screen")
def screen_numbers(
    runs: Annotated[
        list[Path], typer.Argument(metavar="RUN_DIR...", help="Finished runs of cases, or of scenes with outlets.")
    ],
    aperture: Annotated[
        float | None, number("--aperture", LIMITS["aperture_mm"], "Size that separates undersize from oversize")
    ] = None,
    from_s: Annotated[float | None, number("--from", FROM, "Average from this time on")] = None,
    deck: Annotated[int, number("--deck", DECK, "Deck to evaluate, counted from the top")] = 1,
) -> None:
    """Evaluate screens: cut size, efficiency, throughput, moisture of the products and pegging, as tables and pages.

    Example: pywet screen results/smoke/case02"""
    from pywet.compare import grouping
    from pywet.products import screening_report
    from pywet.report import screen_page
    from pywet.runs.distinct_seeds import distinct_seeds

    found = {run: screen_page.screen(run, aperture, from_s, deck) for run in runs}
    scenes = grouping.by_scene(list(found))
    names = [numbers["run"] for numbers in found.values()]
    table = Table("", *map(escape, names if len(set(names)) == len(names) else map(str, found)))
    columns = [screen_page.five(numbers) for numbers in found.values()]
    for name in dict.fromkeys(name for column in columns for name in column):
        table.add_row(name, *(column.get(name, "–") for column in columns))
    out.print(table)
    for run, numbers in found.items():
        for warning in filter(None, (screening_report.unsteady(numbers), screen_page.unlevel(numbers))):
            tell(f"{f'{run}: ' if len(found) > 1 else ''}{warning}")
    for line in dict.fromkeys(line for run in found for line in screen_page.left_out(run)):
        tell(line)
    tell("± and ( – ): 95 % intervals within a run; other seeds may scatter more")
    for scene in scenes:
        for line in _over_seeds([found[run] for run in distinct_seeds(scene)]):
            tell(f"{f'{scene[0]} and its seeds: ' if len(scenes) > 1 else ''}{line}")
    for run in found:
        tell(f"page: {screen_page.page_of(run, deck)}; tables: {run / 'results'}")


def _over_seeds(found: Sequence[dict[str, Any]]) -> Iterator[str]:
    """Yield the means over several seeds of one scene with their intervals."""
    from pywet.report import screen_page
    from pywet.runs.spread import with_interval

    lacking = screen_page.not_within(found)
    for key, name, factor in (("d50_mm", "cut size [mm]", 1.0), ("efficiency", "efficiency [%]", 100.0)):
        values = [factor * numbers[key] for numbers in found if numbers[key] is not None]
        if len(values) > 1:
            notes = f"; {lacking}" if lacking and key == "d50_mm" else ""
            yield f"{name}: {with_interval(values)} (mean of {len(values)} runs, 95 %{notes})"


@app.command()
def kinetics(
    runs: Annotated[list[Path], typer.Argument(metavar="RUN_DIR...", help="Seeds of a case: runs or stored tables.")],
    file: Annotated[Path | None, typer.Option("--out", metavar="CSV", help="Write the table to this CSV file.")] = None,
    deck: Annotated[
        Path | None,
        typer.Option("--deck", metavar="RUN_DIR", help="Predict the partition curve of this continuous deck."),
    ] = None,
    from_s: Annotated[float | None, number("--from", FROM, "Count the partition of the deck from this time on")] = None,
) -> None:
    """Fit laws of the fraction retained over time to each class, and rank them on seeds that were not fitted; or, with --deck,
    predict a continuous deck from them.

    Example: pywet kinetics docs/full_scale/data/case02-10007 docs/full_scale/data/case02-10009"""
    from pywet.products import kinetics as laws
    from pywet.util.files import write_csv

    if deck is not None:
        _predict(runs, deck, from_s, file)
        return
    if from_s is not None:
        refuse_option(
            "--from", "without --deck", f"--deck RUN_DIR --from {from_s:g}, or no --from: batches are fitted whole"
        )
    found = laws.kinetics(runs)
    single = bool(found["rms_held_out"].isna().all())
    table = Table("class", "law", f"parameters (s, 1/s{'' if single else '; ± 95 %'})", "rms", "rms, seeds not fitted")
    for row in found.itertuples():
        table.add_row(
            escape(str(row[1])),
            str(row[2]),
            escape(str(row[3])),
            f"{row[4]:.4f}",
            "–" if single else f"{row[5]:.4f}",
        )
    out.print(table)
    if single:
        tell(
            "one run: ranked by the fit itself; give several seeds for intervals and for a ranking on what was not fitted"
        )
    if file is not None:
        write_csv(found, file)


def _predict(runs: list[Path], deck: Path, from_s: float | None, file: Path | None) -> None:
    """Print the partition curve of a deck as batch kinetics predict it and as simulated."""
    from pywet.products import batch_to_deck
    from pywet.util.files import write_csv

    found = batch_to_deck.predict(runs, deck, from_s)
    table = Table("class", "size [mm]", "law", "T [%]: plug flow", "residence times", "simulated")
    for row in found.to_dict("records"):
        shares = [(row[way], row[f"{way}_half"]) for way in ("plug_flow", "residence_times")]
        ways = [f"{100 * t:.1f}" + ("" if math.isnan(half) else f" ± {100 * half:.1f}") for t, half in shares]
        simulated = f"{100 * row['T']:.1f} ({100 * row['T_low']:.1f} – {100 * row['T_high']:.1f})"
        table.add_row(escape(str(row["class"])), f"{row['diameter_mm']:g}", str(row["law"]), *ways, simulated)
    out.print(table)
    if row["tracers_inside"]:
        tell(
            f"{row['tracers_inside']} of {row['tracers']} spheres of the coarsest class are on the deck at the end and stay "
            f"longer (Kaplan–Meier); {100 * row['unobserved']:.2g} % of the residence times are beyond the longest observed, at "
            "which they count"
        )
    if file is not None:
        write_csv(found, file)
