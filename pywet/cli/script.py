"""Commands for the user's LIGGGHTS and LAMMPS scripts."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pywet.cli.showing import err, tell
from pywet.errors import PywetError

app = typer.Typer()


SCRIPT = typer.Option("-in", metavar="SCRIPT", help="Script with one `fix pywet` line.")
CHECK = typer.Option(
    "--check", help="Print what was found, the stable time step and what is not supported; nothing runs."
)
OTHERS = {"allow_extra_args": True, "ignore_unknown_options": True}


@app.command(context_settings=OTHERS)
def liggghts(ctx: typer.Context, script: Annotated[Path, SCRIPT], check: Annotated[bool, CHECK] = False) -> None:
    """Run a LIGGGHTS script with one additional line, `fix wet all pywet liquid wet.yaml`; other options go to the engine.

    Example: pywet liggghts -in in.drum --check"""
    _script("liggghts", script, ctx.args, check)


@app.command(context_settings=OTHERS)
def lammps(ctx: typer.Context, script: Annotated[Path, SCRIPT], check: Annotated[bool, CHECK] = False) -> None:
    """Run a LAMMPS script with one additional line, `fix wet all pywet liquid wet.yaml`; its walls stay dry, one process.

    Example: pywet lammps -in in.packing"""
    _script("lammps", script, ctx.args, check)


def _script(engine: str, script: Path, words: list[str], check: bool) -> None:
    if check:
        from pywet.cases.script.check import check as checked

        lines, problems = checked(script, words, engine)
        for line in lines:
            tell(line)
        if problems:
            raise PywetError("\n".join(map(str, problems)), **problems[0].data)
        tell("nothing is in the way; spheres, time step and skin are checked again when the engine comes to the line")
        return
    from pywet.cases.script.run import run

    outcome = run(
        script, words, lambda sentence: err.print(sentence, style="red", soft_wrap=True, markup=False), engine
    )
    if outcome is None:
        return
    closed = f"ledger closed to {outcome.ledger_error:.1e} up to the output at step {outcome.last_output}"
    tell(f"{outcome.formed} bridges formed, {outcome.ruptured} ruptured; {closed}")
    tell(f"tables are in {outcome.log}/history; to check the run: pywet replay {outcome.log}")
