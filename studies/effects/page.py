"""The page of the effects study: pictures first (the matrix of scenes and effects above all), then the comparisons."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from pywet.report import page
from pywet.report.pictures import plt
from studies.effects.measures import ABSOLUTE, WORDS
from studies.effects.scenes import SCENES
from studies.effects.variants import EVERYTHING, IDLE, OF_THE_CONTACT, PLANNED, SWITCHED, TOLERANCE
from studies.effects.verdict import SHORTEST, Choice, costs, left_out, planned, step_time

Runs = dict[str, pd.DataFrame]
Judged = dict[str, list[Choice]]
NAMES = {EVERYTHING: EVERYTHING, PLANNED: "the plan's choice", "no bridges": "no liquid", IDLE: "plugin without work"}
LABELS = {
    "capillary": "capillary\nforce", "viscous_normal": "squeeze\ndrag", "viscous_tangential": "shear\ndrag",
    "dynamic_rupture": "bridges stretch\nwith speed", "wall_films": "bridges\nto walls", "sharing_by_size": "sharing\nby size",
    "rolling": "rolling\nresistance", "tangential_history": "static\nfriction", "gravity": "gravity",
    "bridges": "the whole\nliquid",
}  # fmt: skip
"""Effect -> its name for a process engineer."""
NEEDED, SPARE, SAFE, WRONG = "#2f6f9f", "#b9d3e6", "#bfe3c8", "#d9534f"
FACES = {(True, False): NEEDED, (True, True): SPARE, (False, True): SAFE, (False, False): WRONG}
"""Whether the plan keeps an effect, whether it may be left out -> colour."""
ABSENT = "#f1f3f5"


def percent(value: float) -> str:
    """Format a change in per cent."""
    size = abs(100 * value)
    return f"{size:.0f} %" if size >= 9.5 else f"{size:.1f} %" if size >= 0.05 else "< 0.1 %"


def matrix(runs: dict[str, pd.DataFrame], judged: dict[str, list[Choice]]) -> Figure:
    """Draw scenes by effects: largest change when leaving the effect out, and the plan's decision."""
    names = list(judged)
    figure, axes = plt.subplots(figsize=(13.2, 0.86 * len(names) + 1.5))
    for row, name in enumerate(names):
        out = left_out(runs[name])
        by_effect = {c.variant.removeprefix("no "): c for c in judged[name]}
        for column, effect in enumerate(SWITCHED):
            choice = by_effect.get(effect)
            if choice is None:
                face, ink, text = ABSENT, "#9aa5b1", "–"
            else:
                stored = effect not in out and (effect in OF_THE_CONTACT or "bridges" not in out)
                face = FACES[stored, choice.harmless]
                ink = "white" if face in (NEEDED, WRONG) else "#1e2a36"
                resolved = choice.worst.sure > 0
                shown = choice.worst if resolved else max(choice.changes, key=lambda c: abs(c.change))
                least = f"< {percent(max(abs(shown.change), shown.spread, 0.001))}"
                text = percent(shown.change) if resolved else least
                if math.isfinite(choice.saving):
                    text += f"\ntime {-100 * choice.saving:+.0f} %"
            axes.add_patch(Rectangle((column, row), 0.96, 0.92, facecolor=face))
            look: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 9.5, "color": ink, "linespacing": 1.35}
            axes.text(column + 0.48, row + 0.46, text, **look)
    axes.set(xlim=(0, len(SWITCHED)), ylim=(len(names), 0))
    axes.set_xticks(np.arange(len(SWITCHED)) + 0.48, [LABELS[e] for e in SWITCHED], fontsize=9.5)
    axes.set_yticks(np.arange(len(names)) + 0.46, [SCENES[n].title for n in names], fontsize=11)
    axes.xaxis.tick_top()
    axes.tick_params(length=0)
    for side in axes.spines.values():
        side.set_visible(False)
    keys = [
        (NEEDED, "needed, and the plan keeps it"), (SPARE, "stays on; no harm seen without it"), (SAFE, "left out, rightly"),
        (WRONG, "left out, wrongly"), (ABSENT, "not in this scene"),
    ]  # fmt: skip
    handles = [Rectangle((0, 0), 1, 1, facecolor=c) for c, _ in keys]
    place: dict[str, Any] = {"loc": "upper center", "bbox_to_anchor": (0.46, -0.01), "ncol": 5}
    axes.legend(handles, [t for _, t in keys], frameon=False, fontsize=9.5, **place)
    return figure


def plan_against_all(judged: dict[str, list[Choice]]) -> Figure:
    """Draw, for each scene, the largest change by the plan's choice, and the time of a run with and without omitted effects."""
    names = list(judged)
    plans = [planned(judged[n]) for n in names]
    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 0.5 * len(names) + 1.4), sharey=True)
    at = np.arange(len(names))
    changes = [100 * abs(p.worst.change) for p in plans]
    left.barh(at, changes, color=["#2f7d4f" if p.harmless else WRONG for p in plans], height=0.55)
    spreads = [0.0 if p.same_as_everything else 100 * p.worst.spread for p in plans]
    left.errorbar(changes, at, xerr=spreads, fmt="none", ecolor="#5c6b79", capsize=3)
    left.axvline(100 * TOLERANCE, color="#b3261e", lw=1.2, ls="--")
    left.text(100 * TOLERANCE, -0.75, " tolerance", color="#b3261e", fontsize=9)
    left.set_xlim(0, max(2.6 * 100 * TOLERANCE, 1.1 * max(changes)))
    left.set_yticks(at, [SCENES[n].title for n in names])
    left.invert_yaxis()
    left.set_xlabel("largest change of a wanted quantity [%]\n(whisker: scatter of the seeds)")
    for shift, which, tint, message in ((-0.19, 0, SPARE, "everything on"), (0.19, 1, NEEDED, "the plan's choice")):
        right.barh(at + shift, [p.cpu_s[which] for p in plans], color=tint, height=0.36, label=message)
    right.set_xlabel("processor time of the whole run [s]")
    right.legend(frameon=False, fontsize=9, loc="lower right")
    for axes in (left, right):
        axes.spines[["top", "right"]].set_visible(False)
        axes.tick_params(axis="y", length=0)
    figure.tight_layout()
    return figure


def shares(runs: dict[str, pd.DataFrame]) -> Figure:
    """Draw predicted against measured shares of impulse, with the accuracy factor of each prediction."""
    marks = {"gravity": "s", "capillary": "o", "viscous_normal": "^", "viscous_tangential": "v"}
    figure, axes = plt.subplots(figsize=(6.6, 5.4))
    colours = dict(zip(runs, plt.get_cmap("tab10")(range(10)), strict=False))
    measured = {name: of.loc[of["variant"] == EVERYTHING, "shares"].dropna() for name, of in runs.items()}
    measured = {name: of for name, of in measured.items() if len(of)}
    for name, of in measured.items():
        predicted = {row["effect"]: row["predicted_share"] for row in runs[name]["plan"].iloc[0]}
        for effect, mark in marks.items():
            x, y = predicted[effect], of.iloc[0][effect]
            if x and y:
                axes.loglog(x, y, mark, color=colours[name], ms=8, alpha=0.85)
    line = np.array([3e-6, 1.0])
    axes.loglog(line, line, color="#5c6b79", lw=1)
    for factor, style in ((3.0, "--"), (15.0, ":")):
        for f in (factor, 1 / factor):
            axes.loglog(line, line * f, color="#9aa5b1", lw=0.9, ls=style)
    for effect, mark in marks.items():
        axes.plot([], [], mark, color="#5c6b79", label=LABELS[effect].replace("\n", " "))
    for name in measured:
        axes.plot([], [], "o", color=colours[name], label=SCENES[name].title)
    axes.set(xlim=(3e-5, 1.5), ylim=(3e-6, 1.5))
    axes.set(xlabel="predicted share of impulse", ylabel="share in the log of all bridges")
    axes.legend(fontsize=8.5, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    axes.spines[["top", "right"]].set_visible(False)
    return figure


def unused(runs: dict[str, pd.DataFrame]) -> pd.DataFrame:
    """Tabulate for each choice and scene: ms per step, time relative to all effects, memory [MB], arrays [B] of the plugin."""
    rows = []
    for name, of in runs.items():
        timed = of.assign(time=step_time(of)).set_index("seed")
        full = timed.loc[timed["variant"] == EVERYTHING, "time"]
        for variant in (EVERYTHING, PLANNED, "no bridges", IDLE):
            of_variant = timed[timed["variant"] == variant]
            if len(of_variant):
                ratio = (of_variant["time"] / full).median() if full.min() >= SHORTEST else math.nan
                rows.append({
                    "scene": name, "variant": variant,
                    "step_ms": 1e3 * (of_variant["time"] / of_variant["steps"]).median(), "ratio": ratio,
                    "memory_MB": of_variant["peak_memory_B"].astype(float).median() / 1e6,
                    "arrays_B": int(of_variant["plugin_arrays_B"].median()), "loaded": bool(of_variant["plugin"].iloc[0]),
                })  # fmt: skip
    return pd.DataFrame(rows)


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
        matrix(runs, judged),
        "Each field: the largest change of a wanted quantity when this effect alone is left out (“<”: within what the "
        "first arrangements scatter), and the change of processor time. A dash: the scene does not have the effect.",
    )


def _plan(runs: Runs, judged: Judged) -> str:
    rows: page.Rows = []
    for name, choices in judged.items():
        plan = planned(choices)
        out = ", ".join(LABELS[e].replace("\n", " ") for e in left_out(runs[name])) or "nothing"
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
            plan_against_all(judged),
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
    ) + page.table_of(unused(runs).itertuples(), {
        "scene": lambda r: page.left(SCENES[r.scene].title),
        "effects": lambda r: page.left(NAMES[r.variant]),
        "ms a step": lambda r: f"{r.step_ms:.3f}",
        "time / everything on": lambda r: "–" if math.isnan(r.ratio) else f"{r.ratio:.2f}",
        "memory of the engine [MB]": lambda r: f"{r.memory_MB:.0f}",
        "plugin's arrays [kB]": lambda r: f"{r.arrays_B / 1e3:.0f}" if r.loaded else page.Cell("not loaded", "good"),
    })  # fmt: skip


def _shares(runs: Runs) -> str:
    return page.picture(
        shares(runs),
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
    cost = ", ".join(f"{LABELS[e].replace(chr(10), ' ')} {100 * v:+.0f} %" for e, v in added.items())
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
