"""Commands on scenes of a few bodies: pull, collision, small bed or drum, and queries on one bridge."""

from __future__ import annotations

import json
import os
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from pywet.cli import showing
from pywet.cli.showing import err, out, tell
from pywet.errors import PywetError
from pywet.shipped import place
from pywet.util.notices import notice
from pywet.util.options import SEEDS, CaseRanks, JsonFile, Ranks, Trust, Verbose, number
from pywet.util.ranges import MOST_RANKS, SCENE, Range

PROBLEMS = sorted(path.parent.name for path in place("benchmarks/wet").glob("*/answers.json"))
app = typer.Typer()
UNTIL = Range(0, 50, "%", above=True)
CORES, MORE = Range(1, MOST_RANKS, whole=True), Range(0, 1000, whole=True)
collide = typer.Typer(no_args_is_help=True, help="Collisions of a few wet bodies.")
app.add_typer(collide, name="collide")


@app.command()
def scene(
    name: Annotated[str, typer.Argument(metavar="NAME", help="pull, collision, bed or drum.")],
    out_dir: Annotated[Path | None, typer.Option("--out", help="Run directory; default results/scenes/NAME.")] = None,
    moisture: Annotated[
        float, number("--moisture", SCENE["moisture_percent"], "Liquid content by mass of the spheres")
    ] = 1.0,
    viscosity: Annotated[float, number("--viscosity", SCENE["viscosity_Pa_s"], "Viscosity of the liquid")] = 1e-3,
    spheres: Annotated[int, number("--spheres", SCENE["spheres"], "Number of spheres of bed and drum")] = 500,
    speed: Annotated[float | None, number("--speed", SCENE["speed_m_per_s"], "Speed of pull or collision")] = None,
    rpm: Annotated[float, number("--rpm", SCENE["turns_per_minute"], "Rotational speed of the drum")] = 20.0,
    seconds: Annotated[float | None, number("--seconds", SCENE["seconds"], "Simulated time")] = None,
    contact: Annotated[str, typer.Option("--contact", help="Dry contacts: linear springs, or hertz.")] = "linear",
    modulus: Annotated[
        float, number("--youngs-modulus", SCENE["youngs_modulus_Pa"], "With hertz, of spheres and walls")
    ] = 1e7,
    ranks: Ranks = 1,
    seed: Annotated[int, number("--seed", SCENE["seed"], "Seed of the initial positions in bed and drum")] = 1,
) -> None:
    """Run a small scene: two spheres pulled apart or colliding, a moist bed in a box, a rotating drum."""
    from pywet.cases.small import scenes

    choice = scenes.Choice(
        spheres=spheres,
        moisture_percent=moisture,
        viscosity_Pa_s=viscosity,
        speed_m_per_s=speed,
        turns_per_minute=rpm,
        seconds=seconds,
        ranks=ranks,
        seed=seed,
        contact=contact,
        youngs_modulus_Pa=modulus,
    )
    folder = out_dir or Path("results") / "scenes" / name
    for key, value in scenes.run(name, folder, choice).items():
        out.print(f"{key:<30}{value:.6g}", soft_wrap=True)
    tell(f"all tables are in {folder}")


@app.command("run-scene")
def run_scene(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="YAML description of a scene, see pywet docs own-scene.")
    ],
    out_dir: Annotated[Path | None, typer.Option("--out", help="Run directory; default results/scenes/FILE.")] = None,
    ranks: Ranks = 1,
    seeds: Annotated[int, number("--seeds", SEEDS, "Number of runs with consecutive seeds, in adjacent folders")] = 1,
    until: Annotated[
        float | None, number("--until", UNTIL, "End the run when the partition is known to so many percent")
    ] = None,
    check: Annotated[
        bool,
        typer.Option("--check", help="Print what would be run and the predicted time, or the mistake; run nothing."),
    ] = False,
    trust: Trust = False,
    verbose: Verbose = False,
) -> None:
    """Run a user-defined scene: build, simulate, evaluate, replay, write time series, picture and report."""
    from pywet import run_folder
    from pywet import scene_stages as commands
    from pywet.cases.custom import building
    from pywet.cli import ending
    from pywet.config.loading import placed_laws
    from pywet.planning import size_distribution

    description = commands.read_scene(file)
    if until is not None:
        asked = description.until.model_dump(exclude_unset=True) if description.until else {}
        description = description.with_(until={**asked, "partition_percent": until})
    if trust:
        placed_laws(description.laws, description.folder, trust)
    if check:
        from pywet.cli import scene_check

        for line in scene_check.lines(description, verbose):
            tell(line)
        tell("no mistake was found; nothing was run or written")
        return
    folder = out_dir or Path("results") / "scenes" / file.stem
    made = building.Building(description)
    made.scene()  # its mistakes alone
    for line in made.plan.table if verbose else size_distribution.lines(made.amounts):
        tell(line)
    for line in made.plan.hint:
        notice.warning("%s", line)
    folder = folder.resolve() if folder.name in ("", "..") else folder
    first = description.seed
    runs = {folder: description}
    for k in range(1, seeds):
        runs[folder.with_name(f"{folder.name}-{first + k}")] = description.with_(seed=first + k)
    with ExitStack() as held:  # held until the page is written: another call would move the run aside meanwhile
        for where, what in runs.items():
            held.enter_context(run_folder.hold(where))
            commands.finish(what, where, ranks, progress=True)
        commands.view(folder)
        ending.show(list(runs), verbose)


@app.command()
def bridge(
    file: JsonFile,
    engine: Annotated[str | None, typer.Option(help="Measure inside this engine: liggghts or lammps.")] = None,
    trust: Trust = False,
    as_table: Annotated[
        bool, typer.Option("--table", help="Print a table with deviations from the exact bridge instead of JSON.")
    ] = False,
    plot: Annotated[
        Path | None,
        typer.Option("--plot", metavar="OUT", help="Plot force over gap, with the exact force (.svg, .png)."),
    ] = None,
) -> None:
    """Force over separation, rupture and sharing of one bridge: chosen laws and the exact solution, as JSON."""
    from pywet.cases.small import bridge_query
    from pywet.laws import custom_laws
    from pywet.util import machine_code

    if plot is not None:
        showing.check_bridge_plot(plot)
    query = bridge_query.read(file)
    custom_laws.trust(query.laws, None if trust else file.parent)
    if engine is None:
        with machine_code.compiling("bridge"):
            answer = bridge_query.answer(query)
    elif engine in ("liggghts", "lammps"):
        from pywet.cases.small import bridge_engine

        answer = bridge_engine.measured(query, engine)
    else:
        raise PywetError(
            f"there is no engine {engine}; expected liggghts or lammps",
            code="cli.bridge_engine",
            key="--engine",
            given=engine,
            expected=("liggghts", "lammps"),
        )
    if plot is not None:
        showing.bridge_plot(query, answer, plot)
    if as_table:
        showing.bridge_table(query, answer)
    else:
        typer.echo(json.dumps(answer, indent=2, allow_nan=False))


@app.command()
def calibrate(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="YAML: targets, parameters, see pywet docs calibrate.")],
    out_dir: Annotated[Path | None, typer.Option("--out", help="Folder; default results/calibrations/FILE.")] = None,
    ranks: Ranks = 1,
) -> None:
    """Find values of surface tension, friction, film thickness … that reproduce measurements, with confidence intervals."""
    from pywet.calibration.answer import calibrate
    from pywet.util import machine_code

    folder, say = (
        out_dir or Path("results") / "calibrations" / file.stem,
        partial(err.print, soft_wrap=True, markup=False),
    )
    with machine_code.compiling("calibration"):
        answer = calibrate(file, folder, ranks, say)
    for line in answer["sentences"]:
        tell(line)
    tell(f"calibration.json and calibration.svg are in {folder}")
    if not answer["reached"]:
        raise typer.Exit(1)


@app.command()
def sweep(
    words: Annotated[
        list[str],
        typer.Argument(
            metavar="FILE | plot FILE X Y [HUE]",
            help="YAML file of the sweep (pywet docs sweep); or plot FILE X Y [HUE], columns to plot.",
        ),
    ],
    out_dir: Annotated[
        Path | None, typer.Option("--out", help="Output folder; with plot, the file of the figure.")
    ] = None,
    check: Annotated[bool, typer.Option("--check", help="Report cost and errors only; run nothing.")] = False,
    cores: Annotated[int, number("--cores", CORES, "Number of simultaneous runs")] = os.cpu_count() or 1,
    ranks: CaseRanks = None,
    more: Annotated[int, number("--more", MORE, "Number of points to add where the response is least certain")] = 0,
    trust: Annotated[
        bool, typer.Option("--trust", help="Execute the Python files named in the sweep; read them first.")
    ] = False,
) -> None:
    """Run a sweep over axes, designs and seeds, or draw columns of its table.

    Example: pywet sweep examples/sweeps/small_drum.yaml --cores 2"""
    from pywet.sweep import plan, sweep_command
    from pywet.util import machine_code

    if words[0] == "plot":
        if len(words) not in (4, 5):
            raise PywetError(
                f"plot was given {len(words) - 1} words; expected FILE X Y or FILE X Y HUE",
                code="cli.plot_words",
                given=len(words) - 1,
            )
        tell(sweep_command.plot(Path(words[1]), words[2:], out_dir))
        return
    if len(words) > 1:
        raise PywetError(
            f"{words[1]} was given after {words[0]}; expected one file, or plot FILE X Y [HUE]",
            code="cli.sweep_words",
            given=words[1],
        )
    asked = plan.read(Path(words[0]), out_dir, trust=trust)
    with machine_code.compiling("laws" if asked.kind.engine else f"sweep-{asked.sweep.base.kind}"):
        if check:
            sweep_command.check(asked, cores, ranks, tell)
            return
        made = sweep_command.carry_out(asked, cores, ranks, more, tell)
    if failed := sweep_command.failures(made):
        raise PywetError(failed, code="cli.sweep_failed")


@app.command()
def score(
    problem: Annotated[str, typer.Argument(metavar="PROBLEM", help=f"{', '.join(PROBLEMS)}, or all.")],
    file: Annotated[
        Path | None,
        typer.Argument(
            metavar="FILE.csv", help="CSV of answers: case, quantity, at, value; with PROBLEM all, a folder."
        ),
    ] = None,
    template: Annotated[
        bool, typer.Option("--template", help="Print an empty table of the questions, to be filled in.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the score as JSON.")] = False,
    within: Annotated[
        float, typer.Option("--within", help="Largest deviation at which a problem counts as solved.")
    ] = 0.1,
) -> None:
    """Score any program's answers to a wet benchmark problem; exit code 0: solved, 1: not solved, 2: cannot be scored.

    Example: pywet score viscous_pull my_answers.csv"""
    import runpy

    given = [
        problem,
        *([str(file)] if file else []),
        *["--template"] * template,
        *["--json"] * as_json,
        f"--within={within}",
    ]
    raise typer.Exit(runpy.run_path(str(place("benchmarks/wet") / "score.py"))["main"](given))


@collide.command()
def wall(
    file: JsonFile,
    table: Annotated[bool, typer.Option("--table", help="Print a sweep as a table instead of JSON.")] = False,
    csv: Annotated[Path | None, typer.Option("--csv", metavar="OUT", help="Also write the sweep as CSV.")] = None,
) -> None:
    """Compute the collision of a wet sphere with a wall; lists instead of numbers make a sweep."""
    from pywet.collisions.wall import command

    command.wall(file, table, csv)


@collide.command()
def spheres(file: JsonFile) -> None:
    """Compute collisions of wet spheres in a plane (Davis 2023)."""
    from pywet.collisions.spheres import command as module
    from pywet.util import machine_code

    problem = module.read(file)
    with machine_code.compiling("spheres"), err.status("colliding"):
        answer = module.describe(module.run(problem))
    typer.echo(json.dumps(answer, indent=2, allow_nan=False))
