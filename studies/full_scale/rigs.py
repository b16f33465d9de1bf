"""Other dimensions of the rig that agree with the paper's text: `python -m studies.full_scale.rigs run RIG… --case N`, `page`.

The text states neither the diameter of the sieve nor whether the amplitude is the whole stroke. A rig runs cases at
the campaign's settings, with passed spheres removed, and writes the tables of a campaign with RIG as their variant;
`page` compares the statements of the paper with them. The ranges are those of `statements`.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from pywet import config as settings
from pywet.cost.command import calibrated
from pywet.errors import PywetError, border
from pywet.report.pictures import STYLE, colours, plt
from pywet.runs.summary import commit
from pywet.util.files import atomic_write
from studies.full_scale import rig_sentences, run_table, stored_runs
from studies.full_scale.campaign import SETTINGS, Campaign, prepare, write_again
from studies.full_scale.judging import FAILS, HOLDS, MISSING, OPEN, Answer, decide, each, judge, refuted
from studies.full_scale.statements import STATEMENTS
from studies.full_scale.stored_runs import ALL, CAMPAIGN, COARSE, DEFAULT, DRY_CASES, StoredRun
from studies.full_scale.stored_runs import RIGS as DATA

Table = tuple[list[str], list[list[object]]]
"""Columns and rows."""
SIGNS = {HOLDS: "✓", FAILS: "✗", OPEN: "?", MISSING: "–"}
"""Verdict -> its sign on the page."""
PAGE = Path("docs/rig.md")
ANY, OTHER_RIGS, NONE = "{any reading}", "{other rigs}", "{none}"
"""Where the page says which statements its runs confirm, what other rigs change, and what refutes the other statements."""
TIMES_S = (5.0, 10.0, 20.0)
"""Times after the opening of the slide [s]."""
HEAD = """# The unknown diameter of the sieve, and other readings

Elskamp & Kruggel-Emden (2018, "the paper") do not give the diameter of their sieve, and some passages can be interpreted in
several [ways](readings.md). **No choice confirms all statements.** All cases were run on 200 mm (`sieve200`, the default) and on
185 mm (`sieve185`; `sieve_diameter_mm` in `materials.yaml`).

{any reading}

{other rigs}

Seeds: [rig_undersize.csv](full_scale/rig_undersize.csv). Settings: [full-scale runs](full_scale.md#method).

## Statements that no run confirms

A setting refutes a statement if its mean is outside a range by more than the 95 % limit with the scatter of 200 mm. A statement
is impossible if 150, 180, 185, 190 and 200 mm and each [other reading](readings.md), alone (`wall`: two), refute it. Shared dry
runs count once. Both values are of the first range missed on 200 mm.

{none}

## Undersize on the screen

![Undersize left on the screen over time, cases 1 and 4, for sieves of 150 to 200 mm](full_scale/rig.svg)

"""
BETWEEN = """
## Statements

The signs mean: ✓ confirmed, ✗ not confirmed, ? inconclusive, – not run. Ranges are those of the
[full-scale page](full_scale.md#statements); values: [rig_statements.csv](full_scale/rig_statements.csv).

"""
PRESETS = (DEFAULT, "sieve185")
"""Rigs with which all cases were run."""


def sieve(diameter_mm: float) -> dict[str, Any]:
    """Return entries for the paper's feed on a sieve whose cloth has this diameter; a smaller sieve has a higher bed."""
    return {"materials.yaml: feed sieve_diameter_mm value": diameter_mm}


def amplitude(share: float) -> dict[str, Any]:
    """Return entries for vertical amplitudes of this share of the configured ones; 0.5: the text's amplitude is the stroke."""
    strokes = "materials.yaml: motion strokes"
    return {f"{strokes} {k} z_amplitude_mm value": round(share * z, 4) for k, z in enumerate((0.9, 0.72))}


PRINTED = {"config.yaml: readings capillary_spheres": "as_printed"}
"""Entries for equation (14) with the misprint that its validation, at 0 and 10 degrees, would not reveal."""
WALL = {f"config.yaml: readings {key}": value for key, value in (("wall_film", "wall"), ("wall_transfer", "at_tenth"))}
"""Entries for films of whole walls and the transfer ratio of section 4: the most liquid on walls of all readings."""
OTHERS = {
    "printed_walls": {"config.yaml: readings capillary_walls": "as_printed"},
    "facet": {"config.yaml: readings small_wall": "half_facet"},
    "part": {"config.yaml: readings wall_film": "part"},
    "fifth": {"config.yaml: readings wall_transfer": "at_fifth"},
    "residual": {"config.yaml: readings liquid_amount": "less_residual"},
    "weighed": {"config.yaml: readings sphere_mass": "weighed"},
    "stroke": {"config.yaml: readings amplitude": "peak_to_peak"},
}
"""Short name -> entries for each alternative of docs/readings.md that PRINTED and WALL do not contain."""
OF_BRIDGES = ("printed", "wall", "printed_walls", "facet", "part", "fifth", "residual")
"""Readings that change nothing in a dry case."""
RETIRE = "config.yaml: retire"
PAPER_STIFFNESS = {"scales.yaml: scales full stiffness_factor value": 1.0}
EVERY_THIRD = {"config.yaml: time_step bridges_every": 3, "config.yaml: time_step fraction value": 0.09}
"""Entries for bridges in every third step: at the paper's stiffness still more often than the campaign evaluates them.

The stability limit of drag over three steps asks for a slightly shorter step than the campaign's.
"""
RIGS: dict[str, dict[str, Any]] = {
    **{f"sieve{d:g}": sieve(d) for d in (180.0, 182.5, 185.0, 187.5, 190.0, 192.5, 195.0, 200.0)},
    "sieve150": sieve(150.0)
    | {"scales.yaml: apparatus feed_bin_height_mm value": 124},  # the deeper fill is below the cover
    **{f"amplitude{a:g}": amplitude(0.01 * a) for a in (60, 70, 80, 90)},
    **{f"sieve{d:g}_amplitude{a}": sieve(d) | amplitude(0.01 * a) for d in (185.0, 190.0) for a in (80, 90)},
    **{f"sieve{d:g}_stiff": sieve(d) | PAPER_STIFFNESS for d in (180.0, 182.5, 185.0, 200.0)},
    "sieve200_stiff_third": sieve(200.0) | PAPER_STIFFNESS | EVERY_THIRD,
    **{f"sieve{d:g}_printed": sieve(d) | PRINTED for d in (185.0, 190.0, 200.0)},
    **{f"sieve{d:g}_wall": sieve(d) | WALL for d in (185.0, 200.0)},
    **{f"sieve200_{name}": sieve(200.0) | entries for name, entries in OTHERS.items()},
    ALL: sieve(200.0) | {RETIRE: "off"},
}
"""Name -> entries of the configuration; `stiff`: stiffness of the paper's table 1; `printed`, `wall`: PRINTED, WALL."""
TURNED = (
    *(f"sieve{d:g}" for d in (150, 180, 185, 190)),
    *(f"sieve200_{name}" for name in ("printed", "wall", *OTHERS)),
)
"""Rigs that turn one reading each, or `wall`'s two; a statement that `sieve200` and all of them refute is impossible."""

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
    """Run cases with each rig and store their tables; stored ones are not repeated."""
    if unknown := [name for name in rigs if name not in RIGS]:
        raise PywetError(f"there is no rig {', '.join(unknown)}; expected of {', '.join(RIGS)}")
    command, failed = [sys.executable, "-P", "-m", "pywet.cli.app", "run", "--scale", "full"], []
    base, machine = settings.load(config_dir), calibrated()
    for rig in rigs:
        configs = {n: settings.load(configure(config_dir, out, rig, base.case(n).aperture_mm)) for n in case}
        jobs = prepare(configs, seed or [base.settings.seed], "full", out, rig, machine)
        for job in jobs:
            job.done = (data / job.name / "run.json").exists()
        about = {"variant": rig, "scale": "full", "commit": commit()}
        failed += Campaign(jobs, data, command, about, cores).run()
    raise typer.Exit(1 if failed else 0)


def configure(source: Path, out: Path, rig: str, aperture_mm: float) -> Path:
    """Write a copy of the configuration with a rig and the campaign's settings for this aperture, and return its folder."""
    target = out / f"settings-{rig}-{aperture_mm:g}mm"
    write_again(source, target, "full", SETTINGS[aperture_mm], {RETIRE: "on", **RIGS[rig]})
    return target


@app.command()
def page(data: Annotated[Path, typer.Option(help="Folder of the stored tables.")] = DATA) -> None:
    """Write docs/rig.md, its figure and its tables from the stored tables."""
    rigs = dict(sorted(stored_runs.variants(data).items()))
    run_table.write(data.parent / "rig_undersize.csv", *curves(rigs))
    run_table.write(data.parent / "rig_statements.csv", *values(whole(rigs)))
    draw(rigs, data.parent / "rig.svg")
    with atomic_write(PAGE) as partial:
        partial.write_text(text(rigs))
    typer.echo(f"{PAGE} is written")


def text(rigs: Mapping[str, Mapping[int, Sequence[StoredRun]]]) -> str:
    """Return the page: effect of the rigs on passage and on the statements that their runs decide."""
    runs = whole(rigs)
    answer, none = any_reading(runs)
    others = [
        rig_sentences.of_diameters(runs),
        rig_sentences.of_presets(runs, PRESETS),
        rig_sentences.of_printed_force(runs, PRESETS[1]),
        rig_sentences.of_walls(runs, PRESETS),
    ]
    head = HEAD.replace(ANY, answer).replace(OTHER_RIGS, "\n\n".join(others))
    head = head.replace(NONE, "\n".join(impossible(runs, none)))
    return head + BETWEEN + "\n".join(verdicts(runs)) + "\n"


def whole(rigs: Mapping[str, Mapping[int, Sequence[StoredRun]]]) -> dict[str, dict[int, Sequence[StoredRun]]]:
    """Return the rigs with dry cases (`with_dry`), and those runs on 200 mm by which the default is judged."""
    default = stored_runs.default(stored_runs.variants(CAMPAIGN)[""], rigs.get(DEFAULT, {}))
    return with_dry(dict(sorted({**rigs, DEFAULT: default}.items())))


def any_reading(rigs: Mapping[str, Mapping[int, Sequence[StoredRun]]]) -> tuple[str, list[int]]:
    """Return sentences on the statements that the default, some rig only, or none confirms, and the numbers of the last."""
    decided = [s for s in STATEMENTS if s.cases]
    shipped = {s.number for s in decided if judge(s, rigs[DEFAULT]).verdict == HOLDS}
    more = {
        s.number: [rig for rig, runs in rigs.items() if judge(s, runs).verdict == HOLDS]
        for s in decided
        if s.number not in shipped
    }
    gained = [str(n) for n, found in more.items() if found]
    none = [n for n, found in more.items() if not found]
    answer = (
        f"Of the paper's {len(decided)} statements on screening cases, the runs of the full-scale page confirm "
        f"{len(shipped)}; {len(gained)} "
        f"others are confirmed only with another diameter or interpretation of the paper: "
        f"{', '.join(gained)}. No run confirms {', '.join(map(str, none))}."
    )
    return answer, none


def with_dry(rigs: Mapping[str, Mapping[int, Sequence[StoredRun]]]) -> dict[str, dict[int, Sequence[StoredRun]]]:
    """Return the rigs, those with another bridge law together with the dry cases of the same sieve, which have no bridges."""
    dry = {rig: {case: found for case, found in runs.items() if case in DRY_CASES} for rig, runs in rigs.items()}
    same = re.compile(f"_({'|'.join(OF_BRIDGES)})$")
    return {rig: dry.get(same.sub("", rig), {}) | dict(runs) for rig, runs in rigs.items()}


def impossible(rigs: Mapping[str, Mapping[int, Sequence[StoredRun]]], numbers: Sequence[int]) -> list[str]:
    """Return a table in Markdown of statements that no run confirms: what refutes them, under which readings."""
    lines = [
        "| statement | range | 200 mm | closest other run | impossible (settings run that refute it) |",
        "|---|---|---|---|---|",
    ]
    default = rigs[DEFAULT]
    for statement in (s for s in STATEMENTS if s.number in numbers):
        found = {rig: refuted(statement, rigs.get(rig, {}), default) for rig in (DEFAULT, *TURNED)}
        # settings with some range's runs, by those runs, which readings of bridges share in dry cases
        tried = {
            tuple(run.folder for case in statement.cases for run in rigs[rig].get(case, ())): k is not None
            for rig, k in found.items()
            if any(each(part, rigs.get(rig, {})) for part in statement.parts)
        }
        answer = judge(statement, default)
        verdicts = [
            decide(part, sum(values) / len(values), half)
            for part, values, half in zip(statement.parts, answer.values, answer.uncertainty, strict=True)
        ]
        # 200 mm does not confirm the statement because of this part
        part = statement.parts[verdicts.index(FAILS if FAILS in verdicts else OPEN)]
        others = {rig: each(part, runs) for rig, runs in rigs.items() if rig != DEFAULT}
        means = {rig: sum(v) / len(v) for rig, v in others.items() if v}
        closest = min(means, key=lambda rig: max(part.low - means[rig], means[rig] - part.high), default="")
        open_with = [rig for rig, k in found.items() if k is None]
        verdict = f"no ({sum(tried.values())} of {len(tried)})" if open_with else f"yes ({len(found)})"
        for k in sorted({k for k in found.values() if k is not None and statement.parts[k] is not part}):
            verdict += "" if open_with else f", {[*found.values()].count(k)} of them by {statement.parts[k].range}"
        here, there = shown(each(part, default)), f"{means[closest]:.4g} (`{closest}`)" if closest else ""
        cells = (text.replace("|", "&#124;") for text in (part.range, here, there, verdict))
        lines.append(f"| {statement.number} | {' | '.join(cells)} |")
    return lines


def curves(rigs: Mapping[str, Mapping[int, Sequence[StoredRun]]]) -> Table:
    """Return undersize on the screen in per cent of that in the feed and most pegged large spheres, a row for each run."""
    rows = []
    for rig, runs in rigs.items():
        for case, seeds in sorted(runs.items()):
            for run in seeds:
                left = [f"{100 * run.at(run.undersize, t):.1f}" for t in TIMES_S]
                rows.append([rig, case, run.about["seed"], *left, f"{run.pegged(COARSE, 10.0, 20.0):.1f}"])
    times = [f"undersize_percent_{t:g}_s" for t in TIMES_S]
    return ["rig", "case", "seed", *times, "pegged_10_to_20_s"], rows


def draw(rigs: Mapping[str, Mapping[int, Sequence[StoredRun]]], path: Path) -> None:
    """Draw the undersize left on the screen over time in two dry cases, a curve for each sieve, first seed."""
    found = {rig: runs for rig, runs in rigs.items() if re.fullmatch(r"sieve[\d.]+", rig)}
    with plt.rc_context(STYLE):
        figure, panels = plt.subplots(1, 2, figsize=(7.2, 2.8), sharey=True, constrained_layout=True)
        for axes, (case, amplitude_mm) in zip(panels, ((1, 1), (4, 0.8)), strict=True):
            for (rig, runs), colour in zip(found.items(), colours(len(found)), strict=True):
                if case in runs:
                    run = runs[case][0]
                    label = f"{rig.removeprefix('sieve')} mm"
                    axes.plot(run.times, 100.0 * run.undersize, color=colour, label=label)
            axes.set(
                title=f"case {case}, amplitude {amplitude_mm:g} mm", xlabel="time after the opening [s]", xlim=(0, 20)
            )
        panels[0].set(ylabel="undersize left on the screen [%]", ylim=(0, None))
        panels[0].legend(fontsize="small", title="sieve")
        with atomic_write(path) as partial:
            figure.savefig(partial, format="svg", metadata={"Date": None})
        plt.close(figure)


def values(rigs: Mapping[str, Mapping[int, Sequence[StoredRun]]]) -> Table:
    """Return the value of each part of each statement, mean and range over seeds, and the verdict, a column for each rig."""
    rows = []
    for number, parts, answers in judged(rigs):
        for k, part in enumerate(parts):
            rows.append([number, part, *(shown(a.values[k]) if a.values else "" for a in answers)])
        rows.append([number, "verdict", *("" if a.verdict == MISSING else a.verdict for a in answers)])
    return ["statement", "range", *rigs], rows


def verdicts(rigs: Mapping[str, Mapping[int, Sequence[StoredRun]]]) -> list[str]:
    """Return a table in Markdown: a row for each statement, a column for each preset, and other rigs that confirm it."""
    lines = [f"| statement | {' | '.join(PRESETS)} | confirmed by |", "|---" * (2 + len(PRESETS)) + "|"]
    for number, _, answers in judged(rigs):
        found = dict(zip(rigs, (a.verdict for a in answers), strict=True))
        signs = [SIGNS[found.get(name, MISSING)] for name in PRESETS]
        same = {name for name, verdict in found.items() if verdict == HOLDS}
        others = [f"`{name}`" for name in same - {*PRESETS} if "_" not in name or name.partition("_")[0] not in same]
        lines.append(f"| {number} | {' | '.join(signs)} | {', '.join(sorted(others))} |")
    return lines


def judged(rigs: Mapping[str, Mapping[int, Sequence[StoredRun]]]) -> Iterator[tuple[int, list[str], list[Answer]]]:
    """Yield number, ranges and an answer for each rig, of each statement on cases that some rig decides."""
    for statement in STATEMENTS:
        answers = [judge(statement, runs) for runs in rigs.values()] if statement.cases else []
        if any(answer.verdict != MISSING for answer in answers):
            yield statement.number, [part.range for part in statement.parts], answers


def shown(values: Sequence[float]) -> str:
    """Format values of all seeds as their mean, with their spread if there are several; empty if there is none."""
    if not values:
        return ""
    mean = sum(values) / len(values)
    return f"{mean:.4g}" if len(values) == 1 else f"{mean:.4g} ({min(values):.4g} to {max(values):.4g})"


if __name__ == "__main__":
    with border():
        app()
