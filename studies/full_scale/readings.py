"""Effect of each reading of the paper.

`python -m studies.full_scale.readings run OUT CASE…` runs cases at the smoke scale once with every reading, `store
RUN…` stores their results, `table` prints them for docs/readings.md. It estimates the size of each reading's effect
with one seed and is no judgement: statements are judged at full scale.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Annotated, Any, get_args

import pandas as pd
import typer

from pywet.config.readings import Readings
from pywet.cost import edit
from pywet.errors import border
from pywet.runs.rundir import RunDir
from pywet.util.files import write_csv
from studies.accuracy.sieve import of_curve
from studies.full_scale.stored_runs import DIGITS
from studies.full_scale.trials import LONG, SCALE

FILE = Path("docs/full_scale/reasons/readings.csv")
DEFAULT = "default"


def _turned(**readings: str) -> dict[str, Any]:
    return {f"config.yaml: readings {key}": value for key, value in readings.items()}


ALTERNATIVES: dict[str, dict[str, Any]] = {
    DEFAULT: {},
    **{
        f"{key}={value}": _turned(**{key: value})
        for key, field in Readings.model_fields.items()
        for value in get_args(field.annotation)
        if value != field.default
    },
    "capillary_spheres=as_printed,capillary_walls=as_printed": _turned(
        capillary_spheres="as_printed", capillary_walls="as_printed"
    ),
    "wall_film=wall,wall_transfer=at_tenth": _turned(wall_film="wall", wall_transfer="at_tenth"),
    **{f"sieve_diameter_mm={mm}": {"materials.yaml: feed sieve_diameter_mm value": mm} for mm in (190, 185)},
}
"""Name of a run's folder, before its case -> changes of the configuration."""

app = typer.Typer(add_completion=False)


@app.command()
def run(
    out: Annotated[Path, typer.Argument(help="Folder of configurations and runs.")],
    cases: Annotated[list[int], typer.Argument(help="Numbers of cases.")],
    only: Annotated[str, typer.Option(help="Names that have this in them.")] = "",
    long: Annotated[
        bool, typer.Option("--long", help="Three seconds of screening, with the trials' time step.")
    ] = False,
    config: Annotated[Path, typer.Option(help="Folder of the configuration.")] = Path("config"),
) -> None:
    """Run cases with each reading, as OUT/NAME-CASE."""
    for name in (n for n in ALTERNATIVES if only in n):
        folder = out / f"settings-{name}"
        if not folder.exists():
            levels, more = ({"fraction": 0.1}, LONG) if long else ({}, {})
            edit.write(config, folder, SCALE, levels)
            edit.put_into(folder, {**more, **ALTERNATIVES[name]})
        for case in cases:
            command = [sys.executable, "-P", "-m", "pywet.cli.app", "run", str(case), "--scale", SCALE]
            subprocess.run([*command, "--config", str(folder), "--out", str(out / f"{name}-{case}")], check=True)


@app.command()
def store(runs: Annotated[list[Path], typer.Argument(help="Run directories, NAME-CASE.")]) -> None:
    """Store the results of runs, in the order of the readings."""
    found = pd.DataFrame([figures(RunDir(path)) for path in runs])
    order = {name: n for n, name in enumerate(ALTERNATIVES)}
    write_csv(found.sort_values(["until_s", "case", "reading"], key=lambda c: c.map(order) if c.name == "reading" else c), FILE,
              float_format=DIGITS)  # fmt: skip


def figures(finished: RunDir) -> dict[str, float | str]:
    """Return the fraction retained, mean and at the end, and the share of liquid on wires and all walls at the end."""
    name, case = finished.path.name.rsplit("-", 1)
    retained, liquid = (finished.table(f"results/{t}") for t in ("fraction_retained", "liquid_by_holder"))
    since = retained["time_since_opening_s"].to_numpy()
    passed = of_curve(since, retained["fraction_retained"].to_numpy(), float(since[-1]))
    end = round(float(since[-1]), 1)
    found: dict[str, float | str] = {"case": int(case), "until_s": end, "reading": name, **passed}
    if finished.moist:
        last, initial = liquid.iloc[-1], float(liquid["initial_m3"].iloc[0])
        on_spheres = last["coarse_material_m3"] + last["fines_m3"] + last["left_m3"]
        found |= {"wires_share": last["wires_m3"] / initial, "walls_share": 1.0 - on_spheres / initial}
    return found


@app.command()
def table() -> None:
    """Print the figures as rows of the page."""
    print("\n".join(rows(pd.read_csv(FILE))))


def rows(stored: pd.DataFrame) -> list[str]:
    """Return one row for each reading: mean Y, and the liquid on all walls and on wires, of every case and duration."""
    columns = sorted({*zip(stored["until_s"], stored["case"], strict=True)})
    at = {(row["reading"], row["until_s"], row["case"]): row for _, row in stored.iterrows()}
    found = []
    for name in (n for n in ALTERNATIVES if n in set(stored["reading"])):
        cells = [_cell(at[name, *c]) if (name, *c) in at else "–" for c in columns]
        found.append(f"| {', '.join(f'`{part}`' for part in name.split(','))} | {' | '.join(cells)} |")
    return found


def _cell(row: pd.Series) -> str:
    moist = pd.notna(row.get("walls_share"))
    liquid = f"; {100 * row['walls_share']:.1f}, {100 * row['wires_share']:.2f} %" if moist else ""
    return f"{row['retained_mean']:.3f}{liquid}"


if __name__ == "__main__":
    with border():
        app()
