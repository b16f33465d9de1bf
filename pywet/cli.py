"""The command `pywet`: one thin function per subcommand; what they do is in the modules they call.

A user's mistake ends with one red sentence and exit code 1, what is not built yet with one sentence and exit code 3.
Heavy modules are imported inside the commands, so that `pywet --help` answers at once.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer
from rich.console import Console
from rich.table import Table
from typer.core import TyperGroup

from pywet.errors import PywetError

NOT_BUILT = 3
"""Exit code of a command that exists but is not built yet."""
out = Console(highlight=False)
err = Console(stderr=True, highlight=False)


class Group(TyperGroup):
    """Turns a `PywetError` of any command into one red sentence and exit code 1."""

    def invoke(self, ctx: Any) -> Any:
        """Run the chosen command."""
        try:
            return super().invoke(ctx)
        except PywetError as error:
            err.print(f"{error}", style="red", soft_wrap=True, markup=False)
            raise typer.Exit(1) from None


app = typer.Typer(
    cls=Group,
    no_args_is_help=True,
    add_completion=False,
    help="Screening of moist particles: simulate, cross-check, look.",
)
collide = typer.Typer(cls=Group, no_args_is_help=True, help="Collisions of a few wet bodies.")
app.add_typer(collide, name="collide")

CaseNumber = Annotated[int, typer.Argument(metavar="CASE", help="Number of the case in cases.csv.")]
ScaleName = Annotated[str | None, typer.Option("--scale", help="smoke, reduced or full; default: that of config.yaml.")]
ConfigDir = Annotated[Path, typer.Option("--config", help="Folder of the configuration.")]
RunFolder = Annotated[Path, typer.Argument(metavar="RUN_DIR", help="Run directory, such as results/smoke/case02.")]
JsonFile = Annotated[Path, typer.Argument(metavar="FILE", help="JSON description; the answer is JSON as well.")]
CONFIG = Path("config")


@app.command()
def doctor() -> None:
    """Say what was found on this machine, in which version, and what is missing."""
    from pywet import doctor as module

    code = module.main()
    raise typer.Exit(int(code or 0))


@app.command()
def laws(atlas: Annotated[bool, typer.Option("--atlas", help="Draw every law over its range.")] = False) -> None:
    """List the laws by kind, with the first line of what each says of itself."""
    if atlas:
        _not_built("`pywet laws --atlas`")
    from pywet.laws import registry

    table = Table("kind", "law", "what it gives", box=None, header_style="bold")
    for kind in registry.SIGNATURES:
        for name in registry.names(kind):
            functions = registry.get(kind, name).functions
            said = (functions[0].__doc__ or "").strip() if functions else "tabulated, see pywet.laws.transfer"
            table.add_row(kind, name, said.partition("\n")[0])
    out.print(table)


@app.command()
def plan(case: CaseNumber, scale: ScaleName = None, config: ConfigDir = CONFIG) -> None:
    """Say which effects a case calls for, and why, one line each."""
    from pywet import config as settings
    from pywet.screening import cases

    loaded = settings.load(config)
    for line in cases.effect_plan(loaded, case, scale or loaded.settings.scale).lines:
        out.print(line, soft_wrap=True, markup=False)


@app.command()
def run(
    case: CaseNumber,
    scale: ScaleName = None,
    ranks: Annotated[int, typer.Option(min=1, help="MPI ranks of the engine.")] = 1,
    out_dir: Annotated[Path | None, typer.Option("--out", help="Run directory; default results/SCALE/caseNN.")] = None,
    config: ConfigDir = CONFIG,
) -> None:
    """Run one case: build, simulate, replay, results."""
    from pywet import config as settings
    from pywet import stages

    loaded = settings.load(config)
    name = scale or loaded.settings.scale
    loaded.scale(name)
    folder = out_dir or Path("results") / name / loaded.case(case).name
    _stage(folder, "scene", lambda: stages.build(config, case, name, folder))
    _stage(folder, "simulate", lambda: stages.simulate(folder, ranks, progress=True))
    _stage(folder, "replay", lambda: stages.replay(folder))
    _stage(folder, "results", lambda: stages.results(folder))
    _show_summary(folder)


@app.command()
def replay(run_dir: RunFolder) -> None:
    """Recompute a run by the independent reference and show how well it agrees."""
    from pywet import stages

    _need_run(run_dir)
    found = stages.replay(run_dir)
    if found is None:
        out.print(f"{run_dir} is dry: there are no bridges to recompute", soft_wrap=True)
        return
    _show_agreement(found)


@app.command()
def view(
    run_dir: RunFolder, step: Annotated[int | None, typer.Option(help="Output step of the picture.")] = None
) -> None:
    """Write the VTK time series of a run and a picture of it."""
    from pywet.view import render, vtk

    _need_run(run_dir)
    for path in vtk.write(run_dir):
        out.print(str(path), soft_wrap=True)
    picture = run_dir / "picture.png"
    how = render.write(run_dir, picture, step)
    out.print(f"{picture} (drawn by {how})", soft_wrap=True)


@app.command()
def bridge(file: JsonFile) -> None:
    """The exact bridge between two bodies (not built yet)."""
    _not_built("`pywet bridge`")


@collide.command()
def wall(file: JsonFile) -> None:
    """A wet sphere against a wall (not built yet)."""
    _not_built("`pywet collide wall`")


@collide.command()
def spheres(file: JsonFile) -> None:
    """Wet spheres in a plane (Davis 2023); the first call on a machine compiles for a minute."""
    import json

    from pywet.collisions import spheres as module

    with err.status("colliding (compiled at first use)"):
        answer = module.collide_file(file)
    typer.echo(json.dumps(answer, indent=2, allow_nan=False))


def _not_built(what: str) -> NoReturn:
    err.print(f"{what} is not built yet.", soft_wrap=True)
    raise typer.Exit(NOT_BUILT)


def _need_run(run_dir: Path) -> None:
    if not (run_dir / "scene.json").exists():
        raise PywetError(
            f"no scene.json in {run_dir}; expected a run directory as `pywet run CASE --out DIR` writes it"
        )


def _stage(folder: Path, stage: str, work: Any) -> None:
    """Run a stage, leave its status, stop with its reason when it failed."""
    from pywet import stages

    status = stages.attempt(folder, stage, work)
    if not status.ok:
        raise PywetError(f"stage {status.failed_at} failed: {status.reason}")


def _show_summary(folder: Path) -> None:
    """A few lines on a run; exit code 1 when its checks, ledger or replay object."""
    import json

    from pywet.screening import verdict

    summary = json.loads((folder / "summary.json").read_text())
    out.print(
        f"{folder}: {sum(summary['spheres'].values())} spheres, {summary['steps']} steps in {summary['wall_s']:.1f} s"
    )
    end, coarse = summary["fraction_retained_end"], summary["coarse_share"]
    out.print(f"fraction retained at the end {end:.3f} (share that cannot pass {coarse:.3f})")
    if summary["ledger_error"] is not None:
        out.print(f"liquid ledger off by {summary['ledger_error']:.1e} of the liquid put in")
    replayed = folder / "replay.json"
    if replayed.exists():
        _show_agreement(json.loads(replayed.read_text()))
    objections = verdict.objections(folder)
    if objections:
        raise PywetError("; ".join(objections))


def _show_agreement(replay_json: dict[str, Any]) -> None:
    """Agreement table; exit code 1 when a quantity is beyond its tolerance."""
    from pywet.screening.verdict import agreement

    table = Table("quantity", "values", "largest", "median", "", box=None, header_style="bold")
    rows = agreement(replay_json)
    for row in rows:
        verdict = "[green]agrees" if row.ok else "[red]disagrees"
        table.add_row(row.quantity, str(row.count), f"{row.largest:.1e}", f"{row.median:.1e}", verdict)
    out.print(table)
    bad = [row.quantity for row in rows if not row.ok]
    if bad:
        raise PywetError(f"the replay disagrees on {', '.join(bad)}; its worst records are in replay.json")


if __name__ == "__main__":
    app()
