"""Commands on a screening case and on its run directory."""

from __future__ import annotations

import json
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pywet import run_folder
from pywet.cli import showing
from pywet.cli.showing import tell
from pywet.errors import PywetError
from pywet.util.options import (
    PORT,
    SEEDS,
    SPHERE,
    STEP,
    AnyCase,
    CaseNumber,
    CaseRanks,
    ConfigDir,
    RunFolder,
    ScaleName,
    Trust,
    Verbose,
    number,
)
from pywet.util.ranges import LIMITS, Range

if TYPE_CHECKING:
    from pywet.config import Config

app = typer.Typer()
WIDTH_MM = Range(40, 500)
CONFIG = Path("config")


@app.command()
def plan(
    case: AnyCase = None,
    scale: ScaleName = None,
    config: ConfigDir = CONFIG,
    accuracy: Annotated[
        str | None, typer.Option("--accuracy", help="Choose settings for this accuracy, such as 2%.")
    ] = None,
    of: Annotated[
        list[str] | None, typer.Option("--of", help="Quantity to which the accuracy applies; repeatable.")
    ] = None,
    write: Annotated[
        Path | None,
        typer.Option("--write", metavar="DIR", help="Write a copy of the configuration with these settings."),
    ] = None,
    why: Annotated[bool, typer.Option("--why", help="Print the meaning of each number and the reason.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the plan as JSON.")] = False,
    trust: Trust = False,
) -> None:
    """Print the effects that a case calls for (--why: with reasons); with --accuracy, the settings needed and their run time.
    Without CASE: core-hours, memory and disk of all configured cases and seeds."""
    from pywet import config as settings
    from pywet.cases.screening import cases

    given = {"--accuracy": accuracy is not None, "--of": bool(of), "--write": write is not None}
    _refuse_unused(case, {**given, "--why": why, "--json": as_json})
    loaded = settings.load(config, trust)
    name = loaded.settings.scale if scale is None else scale
    if case is None:
        from pywet.cost.needs import campaign

        for line in campaign(loaded, name):
            tell(line)
        return
    from pywet.cost import command, needs

    made = cases.ingredients(loaded, case, name)
    table = made.plan.lines if why else made.plan.table
    if accuracy is not None:
        lines = command.plan(loaded, case, name, accuracy, of or [], write)
    elif as_json:
        lines = [json.dumps({**cases.planned(made), "readings": loaded.readings}, indent=1)]
    else:
        explained = needs.reasons(loaded, case, name) if why else []
        lines = [*table, *needs.glance(loaded, case, name, made), *explained, *made.retirement.lines, *loaded.readings]
    for line in lines:
        tell(line)


def _refuse_unused(case: int | None, given: dict[str, bool]) -> None:
    """Refuse options of `pywet plan` that would have no effect: without a case, without or with another one."""
    named = [option for option, there in given.items() if there]
    values = {"--accuracy": " 2%", "--of": " force", "--write": " DIR"}
    if named and case is None:
        raise PywetError(
            f"{named[0]} was given without a case; expected pywet plan CASE {named[0]}{values.get(named[0], '')}",
            code="cli.no_case", key=named[0],
        )  # fmt: skip
    for option in [o for o in ("--of", "--write") if given[o] and not given["--accuracy"]]:
        raise PywetError(
            f"{option} was given without --accuracy; expected pywet plan {case} --accuracy 2% {option}{values[option]}",
            code="cli.plan_options", key=option,
        )  # fmt: skip
    if len(alone := [o for o in ("--accuracy", "--why", "--json") if given[o]]) > 1:
        raise PywetError(
            f"{alone[1]} was given with {alone[0]}; expected one of them: they print different answers",
            code="cli.plan_options", key=alone[1], given=tuple(alone),
        )  # fmt: skip


@app.command()
def run(
    case: CaseNumber,
    scale: ScaleName = None,
    ranks: CaseRanks = None,
    out_dir: Annotated[Path | None, typer.Option("--out", help="Run directory; default results/SCALE/caseNN.")] = None,
    engine: Annotated[str, typer.Option(help="liggghts or yade.")] = "liggghts",
    config: ConfigDir = CONFIG,
    seed: Annotated[
        int | None, number("--seed", LIMITS["seed"], "Seed of the initial arrangement; default: that of config.yaml")
    ] = None,
    seeds: Annotated[int, number("--seeds", SEEDS, "Number of runs with consecutive seeds, in adjacent folders")] = 1,
    preset: Annotated[
        str | None, typer.Option("--preset", help="paper or exact, instead of the laws in config.yaml.")
    ] = None,
    trust: Trust = False,
    verbose: Verbose = False,
) -> None:
    """Run one case: build, simulate, results, replay, report; with --seeds several times, for the scatter."""
    from pywet import stages
    from pywet.cli import ending
    from pywet.engines.choice import chosen

    loaded = stages.resolved(config, preset, engine=engine, seed=seed, trust=trust)
    ranks = loaded.settings.ranks if ranks is None else ranks
    chosen(engine, ranks)
    name = loaded.settings.scale if scale is None else scale
    loaded.scale(name)
    suffix = ("" if engine == "liggghts" else f"_{engine}") + (f"_{preset}" if preset else "")
    folder = out_dir or Path("results") / name / f"{loaded.case(case).name}{suffix}"
    folder = folder.resolve() if folder.name in ("", "..") else folder
    first, folders = loaded.settings.seed, []
    with ExitStack() as held:  # held until the last page is written: another call would move the run aside meanwhile
        for k in range(seeds):
            folders.append(folder if k == 0 else folder.with_name(f"{folder.name}-{first + k}"))
            seeded = loaded.with_seed(first + k)
            stages.fingerprint(seeded, case, name, engine)  # a mistake is refused before the folder is made
            held.enter_context(run_folder.hold(folders[-1]))
            _run(seeded, case, name, folders[-1], engine, ranks)
        ending.show(folders, verbose)


def _run(loaded: Config, case: int, name: str, folder: Path, engine: str, ranks: int) -> None:
    """Run what a locked folder lacks of a case; raise an error if a stage fails."""
    from pywet import stages

    say = partial(showing.err.print, soft_wrap=True)
    if failed := stages.carry_out(loaded, case, name, folder, engine, ranks, say):
        raise PywetError(
            f"stage {failed.failed_at} failed: {failed.reason}", code="cli.stage_failed", given=failed.failed_at
        )


@app.command()
def replay(
    context: typer.Context,
    run_dirs: Annotated[
        list[Path],
        typer.Argument(metavar="RUN_DIR …", help="Run directories; one gives a table, several one line each."),
    ],
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON (a list for several runs).")] = False,
    trust: Annotated[
        bool,
        typer.Option("--trust", help="Execute the user's reference implementations of custom laws; read them first."),
    ] = False,
) -> None:
    """Recompute runs with the independent reference; exit code 0: agreement, 1: a deviation exceeds its limit, 2: not checked."""
    from pywet.planning import audit
    from pywet.runs import record
    from reference_impl.replay import command

    showing.errors_end_with_2(context)
    for folder in run_dirs if trust else ():
        record.trust_reference(folder)
    with run_folder.reading(*run_dirs):
        status = command.run(run_dirs, as_json, second=record.reference, left=record.leave_replay)
        for folder in run_dirs:
            audit.write(folder)
    for folder in run_dirs:
        if not as_json and len(run_dirs) == 1:
            showing.show_audit(folder)
    raise typer.Exit(status)


@app.command()
def view(
    run_dir: RunFolder,
    step: Annotated[
        int | None, number("--step", STEP, "Output step of the picture, picture_STEP.png, or close-up")
    ] = None,
    movie: Annotated[bool, typer.Option("--movie", help="Draw movie.mp4 and the loop movie.webp.")] = False,
    paraview: Annotated[
        bool, typer.Option("--paraview", help="Write vtk/open_in_paraview.py, which displays all time series.")
    ] = False,
    vtkhdf: Annotated[bool, typer.Option("--vtkhdf", help="Write one temporal VTKHDF file per kind.")] = False,
    ovito: Annotated[bool, typer.Option("--ovito", help="Write spheres and bonds for OVITO.")] = False,
    close_up: Annotated[
        int | None, number("--close-up", SPHERE, "Draw this sphere's bridges, as cuboids and as exact meridians")
    ] = None,
) -> None:
    """Write the VTK time series of a run, compare them with its logs, and draw a picture; with options, only what they name."""
    whole = {"--movie": movie, "--paraview": paraview, "--vtkhdf": vtkhdf, "--ovito": ovito}
    if step is not None and close_up is None and any(whole.values()):
        first = next(option for option, given in whole.items() if given)
        showing.refuse_option(
            "--step", f"with {first}", f"it with --close-up SPHERE, or for the picture without {first}"
        )
    showing.need_run(run_dir)
    with run_folder.reading(run_dir):
        _view(run_dir, step, movie, paraview, vtkhdf, ovito, close_up)


def _view(
    run_dir: Path, step: int | None, movie: bool, paraview: bool, vtkhdf: bool, ovito: bool, close_up: int | None
) -> None:
    from pywet import stages
    from pywet.report import vtk

    paths: list[Path] = []
    if movie:
        paths += showing.movie(run_dir)
    if paraview:
        stages.vtk(run_dir, paraview=True)
        paths.append(run_dir / "vtk" / "open_in_paraview.py")
    if vtkhdf:
        paths += stages.vtkhdf(run_dir)
    if ovito:
        paths += stages.ovito(run_dir)
    if close_up is not None:
        from pywet.report import closeup

        paths.append(closeup.write(run_dir, run_dir / f"close_up_{close_up}.png", close_up, step))
    for path in paths:
        tell(path)
    if paths:
        return
    from pywet.report import render

    stages.vtk(run_dir)
    for kind in vtk.KINDS:
        tell(f"{run_dir / 'vtk' / kind}.pvd (read back: as the logs say)")
    picture = run_dir / render.name(step)
    how = render.write(run_dir, picture, step)
    tell(f"{picture} (drawn by {how})")


@app.command()
def report(run_dir: RunFolder) -> None:
    """Write RUN_DIR/report.html of a finished run; for a case, with the seeds in the folders next to it.

    Example: pywet report results/smoke/case02"""
    from pywet.report import scene_page as page

    showing.need_run(run_dir)
    with run_folder.reading(run_dir):
        tell(page.of_run(run_dir))


@app.command("app")
def side_by_side(
    run_dirs: Annotated[
        list[Path], typer.Argument(metavar="RUN_DIR …", help="Finished runs, displayed two at a time.")
    ],
    port: Annotated[int, number("--port", PORT, "Port on 127.0.0.1; 0 takes a free one")] = 0,
    to: Annotated[
        Path | None, typer.Option("--to", metavar="FILE", help="Write the page to this file instead of serving it.")
    ] = None,
) -> None:
    """Show runs side by side in the browser: 3-D scenes with a common time and camera, and their curves."""
    from pywet.report import app as viewer
    from pywet.util.files import atomic_write

    for folder in run_dirs:
        showing.need_run(folder)
    with run_folder.reading(*run_dirs):
        page = viewer.html(run_dirs)
        if to is not None:
            with atomic_write(to) as temporary:
                temporary.write_text(page, encoding="utf-8")
            tell(f"{to} ({to.stat().st_size / 1e6:.1f} MB)")
            return
    showing.serve(viewer.Server(page, port))


@app.command()
def plot(
    run_dirs: Annotated[
        list[Path],
        typer.Argument(metavar="RUN_DIR …", help="Run directories; CASE and CASE-SEED give one curve with a band."),
    ],
    to: Annotated[Path, typer.Option("--out", metavar="FILE", help="Figure: .pdf, .svg or .png.")] = Path("curves.pdf"),
    width: Annotated[
        float, number("--width", WIDTH_MM, "Width in print in mm: 84 a journal's column, 150 A4 text")
    ] = 150.0,
) -> None:
    """Plot fraction retained, partition and liquid of runs, where available.

    Example: pywet plot results/smoke/case02* --out fig.pdf --width 84"""
    from pywet.compare import grouping
    from pywet.report import bands

    for folder in run_dirs:
        showing.need_run(folder)
    with run_folder.reading(*run_dirs):
        tell(bands.write(to, bands.grouped(run_dirs, grouping.same_scene), width))


@app.command()
def timestep(run_dir: RunFolder, trust: Trust = False) -> None:
    """Print the largest time steps that contact, capillary and viscous forces allow in a prepared run, and which governs."""
    from pywet.laws import custom_laws
    from pywet.planning import time_steps
    from pywet.runs.rundir import RunDir

    showing.need_run(run_dir)
    run = RunDir(run_dir)
    prepared = run.scene
    custom_laws.trust(prepared.effects.laws.values() if trust else ())
    turning = [wall.name for wall in prepared.walls if wall.motion == "turns"]
    for line in time_steps.advise(prepared, {name: run.corners_at_rest[run.meshes == name] for name in turning}).lines:
        tell(line)
