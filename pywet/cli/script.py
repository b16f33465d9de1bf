"""The command on LIGGGHTS scripts of the user's own."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pywet.cli.showing import err, tell
from pywet.errors import PywetError

app = typer.Typer()


@app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})
def liggghts(
    ctx: typer.Context,
    script: Annotated[Path, typer.Option("-in", metavar="SCRIPT", help="Script with one line of fix pywet.")],
    check: Annotated[bool, typer.Option("--check", help="Only say what was found and what is not supported.")] = False,
) -> None:
    """Run a LIGGGHTS script that has one line more, `fix wet all pywet liquid wet.yaml`; other options are the engine's.

    Example: pywet liggghts -in in.drum --check"""
    from pywet.cases.script.scan import scan

    if check:
        found = scan(script)
        effects = ", ".join(f"{kind} {law}" for kind, law in found.wet.effects.laws.items())
        tell(f"{script}: fixes {', '.join(f'{n} {style}' for style, n in sorted(found.styles.items()))}")
        tell(f"{found.line.liquid}: {found.wet.viscous_integration}; laws: {effects}")
        tell(f"run: {found.line.log}, output every {found.line.every} steps")
        if found.problems:
            raise PywetError("\n".join(map(str, found.problems)), **found.problems[0].data)
        tell("nothing is in the way; spheres, time step and skin are checked when the engine comes to the line")
        return
    from pywet.cases.script.run import run

    outcome = run(script, ctx.args, lambda sentence: err.print(sentence, style="red", soft_wrap=True, markup=False))
    if outcome is None:
        return
    tell(f"{outcome.formed} bridges formed, {outcome.ruptured} ruptured; ledger closed to {outcome.ledger_error:.1e}")
    tell(f"tables are in {outcome.log}/history; to check the run: pywet replay {outcome.log}")
