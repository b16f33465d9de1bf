"""Runs that test a reason.

`python -m studies.full_scale.trials run NAME OUT CASE…` runs cases with the changes of `NAME`, `fig14 RUN…` stores
their results for Fig. 14; `reasons` those for statements. They are at the smoke scale for three seconds of screening,
with a time step of a tenth of a collision: a check, not a prediction.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Annotated, Any

import pandas as pd
import typer

from pywet.cost import edit
from pywet.errors import PywetError, border, shown
from pywet.runs.rundir import RunDir
from pywet.util.files import write_csv
from studies.full_scale.stored_runs import DIGITS

SCALE = "smoke"
FIG14 = {
    "feed bin, outlet, impact plate": ("feed_bin", "outlet", "impact_plate"),
    "coarse material, wires, side walls": ("coarse_material", "wires", "side_wall"),
    "fines and bin": ("fines", "collecting_bin"),
}
"""Divisions of Fig. 14c -> columns of the liquid table; the paper's slots and mixing losses are not simulated."""
FIG14_FILE = Path("docs/full_scale/reasons/fig14.csv")
LONG: dict[str, Any] = {
    "scales.yaml: scales smoke duration_s value": 3.3,
    "scales.yaml: scales smoke output_interval_s value": 0.05,
}
TRIALS: dict[str, dict[str, Any]] = {
    "as_is": {},
    "shedding": {"config.yaml: effects shedding": "on"},
    "liquid_weight": {"config.yaml: effects liquid_weight": "on"},
    "deep": {
        "materials.yaml: feed sieve_diameter_mm value": 141.42,
        "scales.yaml: apparatus side_wall_height_mm value": 80,
        "scales.yaml: apparatus slide_height_mm value": 88,
        "scales.yaml: apparatus feed_bin_height_mm value": 240,
        "scales.yaml: apparatus collecting_bin_height_mm value": 120,
    },
    "sticky": {"materials.yaml: liquid surface_tension_N_per_m value": 0.1455},
}
"""Name -> changes: a file, the key of the entry in it, its value.

`deep`: twice the feed on the same sieve; `sticky`: twice the surface tension.
"""


def configure(source: Path, target: Path, name: str) -> Path:
    """Write a copy of the configuration of a trial and return its folder."""
    if name not in TRIALS:
        raise PywetError(f"there is no trial {name}, expected one of {', '.join(TRIALS)}")
    edit.write(source, target, SCALE, {"fraction": 0.1})
    edit.put_into(target, {**LONG, **TRIALS[name]})
    return target


app = typer.Typer(add_completion=False)


@app.command()
def run(
    name: Annotated[str, typer.Argument(help=f"One of {', '.join(TRIALS)}.")],
    out: Annotated[Path, typer.Argument(help="Folder of configurations and runs.")],
    cases: Annotated[list[int], typer.Argument(help="Numbers of cases.")],
    config: Annotated[Path, typer.Option(help="Folder of the configuration.")] = Path("config"),
) -> None:
    """Run cases with a change, each with its replay, as OUT/NAME-CASE."""
    folder = out / f"settings-{name}"
    if not folder.exists():
        configure(config, folder, name)
    command = [sys.executable, "-P", "-m", "pywet.cli.app", "run", "--scale", SCALE, "--config", str(folder)]
    for case in cases:
        subprocess.run([*command, str(case), "--out", str(out / f"{name}-{case}")], check=True)


@app.command()
def fig14(runs: Annotated[list[Path], typer.Argument(help="Run directories, NAME-CASE.")]) -> None:
    """Store the divisions of Fig. 14 at the end of runs."""
    table = pd.DataFrame([divisions(RunDir(path)) for path in runs]).sort_values(["case", "trial"])
    write_csv(table, FIG14_FILE, float_format=DIGITS)


def named(run: RunDir) -> tuple[str, int]:
    """Return trial and case of a run from the name of its folder."""
    name, _, case = run.path.name.rpartition("-")
    if not (name and case.isdecimal()):
        raise PywetError(f"{shown(run.path)} is not named as a trial's run; expected NAME-CASE, such as sticky-2")
    return name, int(case)


def divisions(run: RunDir) -> dict[str, float | str]:
    """Return shares of the liquid in the divisions of Fig. 14 at the end of a run, the fraction retained then, and the time."""
    liquid, retained = (run.table(f"results/{name}").iloc[-1] for name in ("liquid_by_holder", "fraction_retained"))
    name, case = named(run)
    shares = {title: sum(liquid.get(f"{h}_m3", 0.0) for h in of) / liquid["initial_m3"] for title, of in FIG14.items()}
    about = {"time_since_opening_s": liquid["time_since_opening_s"], "fraction_retained": retained["fraction_retained"]}
    return {"case": case, "trial": name, **about, **shares}


if __name__ == "__main__":
    with border():
        app()
