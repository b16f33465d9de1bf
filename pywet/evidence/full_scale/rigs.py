"""Other dimensions that the paper's text allows its rig: `python -m pywet.evidence.full_scale.rigs run RIG… --case N`, `table`.

The text gives neither the diameter of the sieve nor says whether the amplitude is the whole stroke. A rig runs cases at the
campaign's settings, spheres that have passed taken out, and leaves the tables of a campaign with RIG as their variant; `table`
holds the statements of the paper against them. The ranges are those of `statements`, fixed before these runs.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from pywet import config as settings
from pywet.errors import PywetError, border
from pywet.evidence.accuracy import edit
from pywet.evidence.accuracy.command import calibrated
from pywet.evidence.full_scale import kept
from pywet.evidence.full_scale.campaign import SETTINGS, Campaign, prepare
from pywet.evidence.full_scale.judging import MISSING, judge
from pywet.evidence.full_scale.kept import Kept
from pywet.evidence.full_scale.statements import STATEMENTS
from pywet.runs.summary import commit

DATA = Path("docs/full_scale/rigs")
DRY_CASES = (1, 4, 10, 13, 7, 16)


def sieve(diameter_mm: float) -> dict[str, Any]:
    """The feed of the paper on a sieve whose cloth has this diameter; the bed grows higher as the sieve grows smaller."""
    return {"materials.yaml: feed sieve_diameter_mm value": diameter_mm}


def amplitude(share: float) -> dict[str, Any]:
    """Vertical amplitudes of this share of those as configured; 0.5: the amplitude of the text is the whole stroke."""
    strokes = "materials.yaml: motion strokes"
    return {f"{strokes} {k} z_amplitude_mm value": round(share * z, 4) for k, z in enumerate((0.9, 0.72))}


PAPER_STIFFNESS = {"scales.yaml: scales full stiffness_factor value": 1.0}
RIGS: dict[str, dict[str, Any]] = {
    **{f"sieve{d:g}": sieve(d) for d in (180.0, 182.5, 185.0, 187.5, 190.0, 192.5, 195.0, 200.0)},
    **{f"amplitude{a:g}": amplitude(0.01 * a) for a in (50, 60, 70, 80, 90)},
    **{f"sieve{d:g}_amplitude{a}": sieve(d) | amplitude(0.01 * a) for d in (185.0, 190.0) for a in (80, 90)},
    **{f"sieve{d:g}_stiff": sieve(d) | PAPER_STIFFNESS for d in (180.0, 182.5, 185.0)},
}
"""Name -> entries of the configuration; `stiff`: with the stiffness of the paper's table 1."""

app = typer.Typer(add_completion=False)


@app.command()
def run(
    rigs: Annotated[list[str], typer.Argument(help=f"Of {', '.join(RIGS)}.")],
    case: Annotated[list[int], typer.Option("--case", help="Number of a case; may be repeated.")] = list(DRY_CASES),  # noqa: B006
    seed: Annotated[list[int] | None, typer.Option("--seed", help="Seeds; default that of config.yaml.")] = None,
    cores: Annotated[int, typer.Option(min=1, help="Cases at a time.")] = 1,
    config_dir: Annotated[Path, typer.Option("--config", help="Folder of the configuration.")] = Path("config"),
    out: Annotated[Path, typer.Option(help="Folder of the runs.")] = Path("results/rigs"),
    data: Annotated[Path, typer.Option(help="Folder of the stored tables.")] = DATA,
) -> None:
    """Run cases with each rig and store their tables; what is stored is not run again."""
    if unknown := [name for name in rigs if name not in RIGS]:
        raise PywetError(f"there is no rig {', '.join(unknown)}; expected of {', '.join(RIGS)}")
    command, failed = [sys.executable, "-P", "-m", "pywet.cli.app", "run", "--scale", "full"], []
    base, machine = settings.load(config_dir), calibrated(config_dir)
    for rig in rigs:
        configs = {n: settings.load(configure(config_dir, out, rig, base.case(n).aperture_mm)) for n in case}
        jobs = prepare(configs, seed or [base.settings.seed], "full", out, rig, machine)
        for job in jobs:
            job.done = (data / job.name / "run.json").exists()
        about = {"variant": rig, "scale": "full", "commit": commit()}
        failed += Campaign(jobs, data, command, about, cores).run()
    raise typer.Exit(1 if failed else 0)


def configure(source: Path, out: Path, rig: str, aperture_mm: float) -> Path:
    """A copy of the configuration with a rig and the campaign's settings for this aperture; its folder."""
    target = out / f"settings-{rig}-{aperture_mm:g}mm"
    shutil.rmtree(target, ignore_errors=True)
    edit.write(source, target, "full", SETTINGS[aperture_mm], {**RIGS[rig], "config.yaml: retire": "on"})
    return target


@app.command()
def table(data: Annotated[Path, typer.Option(help="Folder of the stored tables.")] = DATA) -> None:
    """Print what each rig's runs say of the statements that they decide."""
    typer.echo("\n".join(lines(kept.variants(data))))


def lines(rigs: Mapping[str, Mapping[int, Sequence[Kept]]]) -> list[str]:
    """A table in Markdown: a row for each part of a statement that some rig decides, a column for each rig."""
    rows = []
    for statement in STATEMENTS:
        answers = {rig: judge(statement, runs) for rig, runs in rigs.items()} if statement.cases else {}
        if all(answer.verdict == MISSING for answer in answers.values()):
            continue
        for k, part in enumerate(statement.parts):
            cells = [shown(answer.values[k]) if answer.values else "–" for answer in answers.values()]
            rows.append(f"| {statement.number} | {part.range} | {' | '.join(cells)} |")
        cells = [answer.verdict for answer in answers.values()]
        rows.append(f"| {statement.number} | **verdict** | {' | '.join(cells)} |")
    names = " | ".join(rigs)
    return [f"| statement | range | {names} |", "|---" * (2 + len(rigs)) + "|", *rows]


def shown(values: Sequence[float]) -> str:
    """Values of all seeds as their mean, with their spread where there are several."""
    mean = sum(values) / len(values)
    return f"{mean:.4g}" if len(values) == 1 else f"{mean:.4g} ({min(values):.4g} to {max(values):.4g})"


if __name__ == "__main__":
    with border():
        app()
