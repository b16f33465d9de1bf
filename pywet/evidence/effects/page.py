"""The page of the effects study: pictures first, then what was compared with what."""

from __future__ import annotations

import math
from pathlib import Path

import pandas as pd

from pywet.evidence.effects import figures
from pywet.evidence.effects.measures import ABSOLUTE, WORDS
from pywet.evidence.effects.scenes import SCENES
from pywet.evidence.effects.variants import EVERYTHING, IDLE, PLANNED, TOLERANCE
from pywet.evidence.effects.verdict import Choice, costs, left_out, planned
from pywet.report import page

Runs = dict[str, pd.DataFrame]
Judged = dict[str, list[Choice]]
NAMES = {EVERYTHING: EVERYTHING, PLANNED: "the plan's choice", "no bridges": "no liquid", IDLE: "plugin without work"}


def write_page(path: Path, runs: Runs, judged: Judged) -> Path:
    plans = {name: planned(choices) for name, choices in judged.items()}
    seeds = max(of["seed"].nunique() for of in runs.values())
    right = sum(p.harmless for p in plans.values())
    best = max(plans.values(), key=lambda p: 1.0 - p.cpu_s[1] / p.cpu_s[0])
    unneeded = sum(bool(left_out(of)) for of in runs.values())
    cards = [
        page.Card(f"{right} of {len(plans)}", "scenes in which the plan is right", "good" if right == len(plans) else "bad"),
        page.Card(f"{best.cpu_s[0]:.1f} → {best.cpu_s[1]:.1f} s", f"largest saving: {SCENES[best.scene].title.lower()}"),
        page.Card(f"{unneeded}", "scenes in which the plan leaves something out"),
        page.Card(f"{100 * TOLERANCE:g} %", f"change that counts as harmless; {seeds} first arrangements per scene"),
    ]  # fmt: skip
    sections = [
        page.Section("Which effects does a scene call for?", _matrix(runs, judged), "matrix"),
        page.Section("The plan against everything on", _plan(runs, judged), "plan"),
        page.Section("What a scene does not use costs nothing", _unused(runs), "cost"),
        page.Section("Shares predicted and measured", _shares(runs), "shares"),
        page.Section("The scenes", _scenes(runs), "scenes"),
        page.Section("How to read and override this", _notes(judged), "notes"),
    ]
    lead = (
        "Each effect of the moist model costs time. Before a run, a plan estimates what each one contributes and may leave out "
        "what is negligible. Here every plan is put to the test: everything on, the plan's choice, and each effect left out."
    )
    return page.write(path, "Only the effects a scene calls for", lead, sections, cards)


def _matrix(runs: Runs, judged: Judged) -> str:
    return page.picture(
        figures.matrix(runs, judged),
        "Each field: the largest change of a wanted quantity when this effect alone is left out (“<”: within what the "
        "first arrangements scatter), and the change of processor time. A dash: the scene does not have the effect.",
    )


def _plan(runs: Runs, judged: Judged) -> str:
    rows: page.Rows = []
    for name, choices in judged.items():
        plan = planned(choices)
        out = ", ".join(figures.WORDS[e].replace("\n", " ") for e in left_out(runs[name])) or "nothing"
        worst, changed = plan.worst, ["–", "same run", "–"]
        if not plan.same_as_everything:
            changed = [WORDS[worst.quantity], f"{100 * worst.change:+.2f} %", f"± {100 * worst.spread:.2f} %"]
        rows.append([
            page.left(SCENES[name].title), page.left(out), page.left(changed[0]), *changed[1:], _saved(plan),
            f"{plan.cpu_s[0]:.1f} → {plan.cpu_s[1]:.1f} s",
            page.Cell("right", "good") if plan.harmless else page.Cell("wrong", "bad"),
        ])  # fmt: skip
    header = ["scene", "the plan leaves out", "quantity that changes most", "change", "scatter", "steps' time saved",
              "whole run", "plan"]  # fmt: skip
    return (
        page.picture(
            figures.plan_against_all(judged),
            "Left: what the plan's choice changes against everything on, from the same first arrangements. Right: the whole run, "
            "start included.",
        )
        + page.table(header, rows)
        + page.paragraph(
            "A plan is right when no wanted quantity changes by more than the tolerance beyond the scatter. Where the "
            "scatter is larger than the tolerance, a bed settles differently each time and smaller changes cannot be seen.",
            soft=True,
        )
    )


def _saved(choice: Choice) -> str:
    if choice.same_as_everything:
        return "–"
    if math.isnan(choice.saving):
        return "too short to time"
    return f"{100 * choice.saving:.0f} ± {100 * choice.saving_spread:.0f} %"


def _unused(runs: Runs) -> str:
    return page.paragraph(
        "A dry scene runs on the stock program: no plugin, no film, no list of bridges. “Plugin without work” is the same "
        "dry scene with the plugin loaded and no liquid. The memory of a moist run is mostly Python, which compiles the force "
        "laws; what the plugin itself keeps is in the last column."
    ) + page.table_of(figures.unused(runs).itertuples(), {
        "scene": lambda r: page.left(SCENES[r.scene].title),
        "effects": lambda r: page.left(NAMES[r.variant]),
        "ms a step": lambda r: f"{r.step_ms:.3f}",
        "time / everything on": lambda r: "–" if math.isnan(r.ratio) else f"{r.ratio:.2f}",
        "memory of the engine [MB]": lambda r: f"{r.memory_MB:.0f}",
        "plugin's arrays [kB]": lambda r: f"{r.arrays_B / 1e3:.0f}" if r.loaded else page.Cell("not loaded", "good"),
    })  # fmt: skip


def _shares(runs: Runs) -> str:
    return page.picture(
        figures.shares(runs),
        "Share of each force in the sum over weight, capillary and viscous forces of |force| × time: predicted before the "
        "run, and taken from 200 steps at which every bridge was logged. Dashed: factor 3 (claimed for weight and capillary "
        "force); dotted: factor 15 (viscous forces).",
    ) + page.paragraph(
        "A share says how much of the pushing an effect does, not whether it matters: in a fast cloud gravity's share is "
        "large and changes little. The decision is made by the numbers of `pywet plan`.",
        soft=True,
    )


def _scenes(runs: Runs) -> str:
    full = {name: of[of["variant"] == EVERYTHING] for name, of in runs.items()}
    return page.table_of(full, {
        "scene": lambda name: page.left(SCENES[name].title),
        "what happens": lambda name: page.left(SCENES[name].story),
        "what is wanted": lambda name: page.left(", ".join(WORDS[q] for q in runs[name] if q in WORDS)),
        "spheres": lambda name: str(full[name]["spheres"].iloc[0]),
        "steps": lambda name: str(full[name]["steps"].iloc[0]),
        "processor time": lambda name: f"{full[name]['cpu_s'].mean():.1f} s",
    })  # fmt: skip


def _notes(judged: Judged) -> str:
    added = costs(judged)
    cost = ", ".join(f"{figures.WORDS[e].replace(chr(10), ' ')} {100 * v:+.0f} %" for e, v in added.items())
    parts = ", ".join(WORDS[q].split(",")[0] for q in ABSOLUTE)
    return (
        page.paragraph(
            "By default (`effects.decide: preset`) everything that the paper models is on. With `effects.decide: tolerance` the "
            "plan leaves out what is negligible, also together. Any effect can be set by hand in `config.yaml`: "
            "`effects.rolling: off`."
        )
        + page.paragraph(
            f"Changes are relative to everything on, but for parts of a whole ({parts}), where they are differences in per "
            "cent of the whole."
        )
        + page.paragraph(
            "Time is processor time of the steps, the choices run one after the other with the same seed in one process; a "
            f"difference of a few per cent is within its noise. Time added by each effect, median over the scenes: {cost}."
        )
    )
