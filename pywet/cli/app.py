"""The command `pywet`: one thin function per subcommand; what they do is in the modules they call.

A user's mistake ends with one red sentence and exit code 1.
Heavy modules are imported inside the commands, so that `pywet --help` answers at once.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table
from typer.core import TyperGroup

from pywet.cli import showing
from pywet.cli.showing import err, out
from pywet.errors import PywetError
from pywet.evidence.command import app as study
from pywet.files import make_folder, one_line, refused
from pywet.options import STEP, case_number, number
from pywet.ranges import LIMITS, SCENE


class Group(TyperGroup):
    """Turns a `PywetError` of any command, and what the operating system refuses, into red sentences and exit code 1."""

    def invoke(self, ctx: Any) -> Any:
        """Run the chosen command."""
        try:
            return super().invoke(ctx)
        except BrokenPipeError:
            raise  # the reader of a pipe has gone: typer ends quietly
        except (PywetError, OSError) as error:
            lines = [refused(error)] if isinstance(error, OSError) else str(error).splitlines()
            said = "\n".join(one_line(line, 2000) for line in lines)
            err.print(said, style="red", soft_wrap=True, markup=False)
            raise typer.Exit(1) from None


app = typer.Typer(
    cls=Group,
    no_args_is_help=True,
    add_completion=False,
    help="Screening of moist particles: simulate, cross-check, look.",
)
collide = typer.Typer(cls=Group, no_args_is_help=True, help="Collisions of a few wet bodies.")
app.add_typer(collide, name="collide")
app.add_typer(study, name="study")

CaseNumber = Annotated[int, case_number()]
Ranks = Annotated[int, number("--ranks", LIMITS["ranks"], "MPI ranks of the engine")]
ScaleName = Annotated[str | None, typer.Option("--scale", help="smoke, reduced or full; default: that of config.yaml.")]
ConfigDir = Annotated[Path, typer.Option("--config", help="Folder of the configuration.")]
RunFolder = Annotated[Path, typer.Argument(metavar="RUN_DIR", help="Run directory, such as results/smoke/case02.")]
JsonFile = Annotated[Path, typer.Argument(metavar="FILE", help="JSON description; the answer is JSON as well.")]
Trust = Annotated[bool, typer.Option("--trust", help="Run the Python files of laws that it names; read them first.")]
CONFIG = Path("config")


def _version(asked: bool) -> None:
    if asked:
        import pywet

        typer.echo(f"pywet {pywet.__version__}")
        raise typer.Exit


@app.callback()
def pywet_(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Say the version and end.")
    ] = False,
) -> None:
    """Screening of moist particles: simulate, cross-check, look."""


@app.command()
def init(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder without configuration; made where missing.")],
) -> None:
    """Write a folder with the default configuration, a Snakefile and a README, ready to run."""
    from pywet import shipped

    for path in shipped.begin(folder):
        out.print(str(path), soft_wrap=True, markup=False)


@app.command()
def doctor() -> None:
    """Say what was found on this machine, in which version, and what is missing."""
    from pywet.cli import doctor as module

    code = module.main()
    raise typer.Exit(int(code or 0))


@app.command()
def laws(
    atlas: Annotated[bool, typer.Option("--atlas", help="Judge every law against the exact bridge; one page.")] = False,
    folder: Annotated[Path, typer.Option("--out", help="Folder of the atlas.")] = Path("results/atlas"),
    stock: Annotated[bool, typer.Option(help="Measure stock LIGGGHTS and YADE as well.")] = True,
) -> None:
    """List the laws by kind, with the first line of what each says of itself; or make the law atlas."""
    if atlas:
        make_folder(folder)
        out.print(str(showing.atlas(folder, stock)), soft_wrap=True, markup=False)
        return
    from pywet.laws import registry

    table = Table("kind", "law", "what it gives", box=None, header_style="bold")
    for kind in registry.BUILT_IN:
        for name in registry.names(kind):
            functions = registry.get(kind, name).functions
            said = (functions[0].__doc__ or "").strip() if functions else "tabulated, see pywet.laws.transfer"
            table.add_row(kind, name, said.partition("\n")[0])
    out.print(table)


@app.command()
def plan(
    case: CaseNumber,
    scale: ScaleName = None,
    config: ConfigDir = CONFIG,
    accuracy: Annotated[str | None, typer.Option("--accuracy", help="Choose settings for it, such as 2%.")] = None,
    of: Annotated[list[str] | None, typer.Option("--of", help="Quantity that counts; may be repeated.")] = None,
    write: Annotated[Path | None, typer.Option("--write", metavar="DIR", help="Copy the config with them.")] = None,
) -> None:
    """Say which effects a case calls for, and why; with --accuracy which settings it needs and how long it takes."""
    from pywet import config as settings
    from pywet.screening import cases

    loaded = settings.load(config)
    name = loaded.settings.scale if scale is None else scale
    lines = cases.effect_plan(loaded, case, name).lines
    if accuracy is not None:
        from pywet.evidence.accuracy import command

        lines = command.plan(loaded, case, name, accuracy, of or [], write)
    for line in lines:
        out.print(line, soft_wrap=True, markup=False)


@app.command()
def run(
    case: CaseNumber,
    scale: ScaleName = None,
    ranks: Ranks = 1,
    out_dir: Annotated[Path | None, typer.Option("--out", help="Run directory; default results/SCALE/caseNN.")] = None,
    engine: Annotated[str, typer.Option(help="liggghts, or yade: dry cases, no rolling resistance.")] = "liggghts",
    config: ConfigDir = CONFIG,
    seed: Annotated[
        int | None, number("--seed", LIMITS["seed"], "Of the first arrangement; default: that of config.yaml")
    ] = None,
) -> None:
    """Run one case: build, simulate, replay, results."""
    from pywet import config as settings
    from pywet import stages

    stages.check_engine(engine, ranks)
    loaded = settings.load(config)
    name = loaded.settings.scale if scale is None else scale
    loaded.scale(name)
    suffix = "" if engine == "liggghts" else f"_{engine}"
    folder = out_dir or Path("results") / name / f"{loaded.case(case).name}{suffix}"
    showing.stage(folder, "scene", lambda: stages.build(config, case, name, folder, engine=engine, seed=seed))
    if engine == "liggghts":
        showing.say_time(loaded, case, name)
    showing.stage(folder, "simulate", lambda: stages.simulate(folder, ranks, progress=True, engine=engine))
    showing.stage(folder, "replay", lambda: stages.replay(folder))
    showing.stage(folder, "results", lambda: stages.results(folder))
    showing.show_summary(folder)


@app.command()
def replay(
    run_dirs: Annotated[list[Path], typer.Argument(metavar="RUN_DIR …", help="One: a table; several: a line each.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON (of several runs a list).")] = False,
) -> None:
    """Recompute runs by the independent reference and show how well they agree; 0 agree, 1 beyond a limit, 2 unreadable."""
    from pywet.plan import audit
    from reference_impl.replay import command

    status = command.run(run_dirs, as_json)
    for folder in run_dirs:
        audit.write(folder)
        if not as_json and len(run_dirs) == 1:
            showing.show_audit(folder)
    raise typer.Exit(status)


@app.command()
def view(
    run_dir: RunFolder, step: Annotated[int | None, number("--step", STEP, "Output step of the picture")] = None
) -> None:
    """Write the VTK time series of a run and a picture of it."""
    from pywet.report import render, vtk

    showing.need_run(run_dir)
    for path in vtk.write(run_dir):
        out.print(str(path), soft_wrap=True, markup=False)
    picture = run_dir / "picture.png"
    how = render.write(run_dir, picture, step)
    out.print(f"{picture} (drawn by {how})", soft_wrap=True, markup=False)


@app.command()
def timestep(run_dir: RunFolder, trust: Trust = False) -> None:
    """Say which time steps contact, capillary and viscous forces of a prepared run allow, and which of them governs."""
    from pywet.laws import own
    from pywet.plan import time_steps as advisor
    from pywet.scene import Scene

    showing.need_run(run_dir)
    prepared = Scene.read(run_dir / "scene.json")
    own.trust(prepared.effects.laws.values() if trust else ())
    for line in advisor.advise(prepared).lines:
        out.print(line, soft_wrap=True, markup=False)


@app.command()
def scene(
    name: Annotated[str, typer.Argument(metavar="NAME", help="pull, collision, bed or drum.")],
    out_dir: Annotated[Path | None, typer.Option("--out", help="Run directory; default results/scenes/NAME.")] = None,
    moisture: Annotated[
        float, number("--moisture", SCENE["moisture_percent"], "Liquid over the mass of the spheres")
    ] = 1.0,
    viscosity: Annotated[float, number("--viscosity", SCENE["viscosity_Pa_s"], "Viscosity of the liquid")] = 1e-3,
    spheres: Annotated[int, number("--spheres", SCENE["spheres"], "Number of spheres of bed and drum")] = 500,
    speed: Annotated[float | None, number("--speed", SCENE["speed_m_per_s"], "Speed of pull or collision")] = None,
    rpm: Annotated[float, number("--rpm", SCENE["turns_per_minute"], "Turns of the drum")] = 20.0,
    seconds: Annotated[float | None, number("--seconds", SCENE["seconds"], "Simulated time")] = None,
    ranks: Ranks = 1,
    seed: Annotated[int, number("--seed", SCENE["seed"], "Of the first places of the spheres of bed and drum")] = 1,
) -> None:
    """Run a small scene: two spheres pulled apart or colliding, a moist bed in a box, a rotating drum."""
    from pywet.bench import scenes

    choice = scenes.Choice(
        spheres=spheres,
        moisture_percent=moisture,
        viscosity_Pa_s=viscosity,
        speed_m_per_s=speed,
        turns_per_minute=rpm,
        seconds=seconds,
        ranks=ranks,
        seed=seed,
    )
    folder = out_dir or Path("results") / "scenes" / name
    for key, value in scenes.run(name, folder, choice).items():
        out.print(f"{key:<30}{value:.6g}", soft_wrap=True)
    out.print(f"all tables are in {folder}", soft_wrap=True, markup=False)


@app.command("run-scene")
def run_scene(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="YAML description of a scene, see docs/own-scene.md.")],
    out_dir: Annotated[Path | None, typer.Option("--out", help="Run directory; default results/scenes/NAME.")] = None,
    ranks: Ranks = 1,
) -> None:
    """Run a scene of your own: build, simulate, replay, results, time series, picture."""
    from pywet.own_scene import commands

    description = commands.read_scene(file)
    folder = out_dir or Path("results") / "scenes" / file.stem
    for line in commands.plan(description).lines:
        out.print(line, soft_wrap=True, markup=False)
    commands.run(description, folder, ranks, progress=True)
    picture = commands.view(folder)
    showing.show_run(folder)
    out.print(f"tables, time series for ParaView and {picture.name} are in {folder}", soft_wrap=True, markup=False)


@app.command()
def compare(
    runs: Annotated[list[Path] | None, typer.Argument(metavar="RUN_A RUN_B", help="Runs, or folders of seeds.")] = None,
    a: Annotated[list[Path] | None, typer.Option("--a", help="A run, or a folder of runs, of group A.")] = None,
    b: Annotated[list[Path] | None, typer.Option("--b", help="The same of group B.")] = None,
    json_file: Annotated[Path | None, typer.Option("--json", metavar="OUT", help="Write the comparison.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Compare different cases as well.")] = False,
    digest: Annotated[Path | None, typer.Option(help="Hold the runs against this stored digest.")] = None,
) -> None:
    """Compare two runs or two groups of seeds; exit code 0 no difference, 1 difference, 2 not comparable."""
    from pywet.evidence.compare import command

    raise typer.Exit(command.compare(runs or [], a or [], b or [], json_file, force, digest))


@app.command()
def digest(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME]...", help="Reference scenes; default all.")
    ] = None,
    folder: Annotated[Path, typer.Option("--out", help="Folder of the digests.")] = Path("tests/data/digests"),
) -> None:
    """Run reference scenes over their seeds and store their digests; refused when a replay disagrees."""
    from pywet.evidence.compare import command

    make_folder(folder)
    command.renew(names or [], folder)


@app.command()
def agreement(
    folder: Annotated[Path, typer.Option("--out", help="Folder of the page.")] = Path("results/agreement"),
    only: Annotated[list[str] | None, typer.Option("--only", metavar="SOURCE", help="Run only these sources.")] = None,
) -> None:
    """Make the table of agreement: every quantity by every program against the best truth, on one page."""
    from pywet.evidence.agreement import page, sources

    make_folder(folder)
    for name in only or sources.SOURCES:
        with err.status(f"agreement: {name}"):
            found = sources.run(name, folder)
        out.print(f"{name:<12}{found.failed or f'{len(found.cells)} cells, {found.wall_s:.0f} s'}", soft_wrap=True)
    out.print(str(page.make(folder)), soft_wrap=True, markup=False)


@app.command()
def bridge(
    file: JsonFile,
    engine: Annotated[str | None, typer.Option(help="Measure inside this engine: liggghts.")] = None,
    trust: Trust = False,
) -> None:
    """Force over separation, rupture and sharing of one bridge: chosen laws and the exact solution, as JSON."""
    import json

    from pywet import machine_code
    from pywet.bench import bridge_query
    from pywet.laws import own

    query = bridge_query.read(file)
    own.trust(query.laws if trust else ())
    machine_code.say_wait()
    if engine is None:
        found = bridge_query.answer(query)
    elif engine == "liggghts":
        from pywet.bench import bridge_engine

        found = bridge_engine.measured(query)
    else:
        raise PywetError(f"there is no engine {engine}; expected liggghts")
    typer.echo(json.dumps(found, indent=2, allow_nan=False))


@collide.command()
def wall(
    file: JsonFile,
    table: Annotated[bool, typer.Option("--table", help="A sweep as a table to read, not as JSON.")] = False,
    csv: Annotated[Path | None, typer.Option("--csv", metavar="OUT", help="Write a sweep as CSV as well.")] = None,
) -> None:
    """A wet sphere against a wall; lists in place of numbers make a sweep."""
    from pywet.collisions.wall import command

    command.wall(file, table, csv)


@collide.command()
def spheres(file: JsonFile) -> None:
    """Wet spheres in a plane (Davis 2023)."""
    import json

    from pywet import machine_code
    from pywet.collisions.spheres import command as module

    problem = module.read(file)
    machine_code.say_wait()
    with err.status("colliding"):
        answer = module.describe(module.run(problem))
    typer.echo(json.dumps(answer, indent=2, allow_nan=False))


if __name__ == "__main__":
    app()
