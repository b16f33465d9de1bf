"""`pywet plan CASE --accuracy`: settings for an accuracy, and the run time of a case on this machine."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pywet.cases.screening import cases
from pywet.config import Config
from pywet.cost import choice, cost, edit
from pywet.errors import PywetError
from pywet.planning import time_steps
from pywet.util.notices import bar


def habit(table: dict[str, Any]) -> cost.Habit:
    """Read the relative costs of screening from the table of the study."""
    laws, integrations = (
        {
            str(row["level"]): row["cost"]["moist"]["ratio"]
            for row in table["parameters"][parameter]
            if "moist" in row["cost"]
        }
        for parameter in ("capillary", "integration")
    )
    return cost.Habit(laws, integrations, table["habit"]["exact_start"])


def calibrated() -> cost.Coefficients:
    """Return the cost model of this machine; at the first call it is measured, with a progress bar."""
    with bar("measuring this machine (once, a minute)") as move:
        return cost.of_this_machine(move)


def plan(config: Config, case: int, scale: str, accuracy: str, wanted: list[str], write: Path | None) -> list[str]:
    """Return settings for an accuracy and the time they take, as lines; `write`: folder for a configuration with them."""
    share, groups = choice.parse(accuracy), tuple(wanted) or choice.WANTED
    unknown = [g for g in groups if g not in choice.GROUPS]
    if unknown:
        raise PywetError(
            f"--of {unknown[0]} given, expected one or more of {', '.join(choice.GROUPS)}",
            code="cost.quantity", key="--of", given=unknown[0], expected=tuple(choice.GROUPS),
        )  # fmt: skip
    if write is not None:
        edit.new_folder(write)
    table, turned = choice.for_scale(scale)
    moist = config.case(case).liquid_percent > 0
    longer = cases.longer_by(edit.changed(config, scale, {"integration": "explicit"}), case, scale)

    def runs(levels: dict[str, edit.Level]) -> bool:
        made = cases.ingredients(
            edit.changed(config, scale, {k: v for k, v in levels.items() if k in turned}), case, scale
        )
        return made.time_step_s * int(levels.get("bridges_every", 1)) <= time_steps.packed_step(
            made.classes, made.pairs
        )

    chosen = choice.choose(table, share, moist, groups, turned, longer, runs)
    changed = {parameter: level for parameter, level in chosen.levels.items() if parameter in turned}
    machine, known = calibrated(), habit(table)
    seconds, load = cost.predict(edit.changed(config, scale, changed), case, scale, machine, known)
    before, _ = cost.predict(config, case, scale, machine, known)
    lines = _shown(share, chosen, moist)
    lines += [
        f"  {edit.CONFIGURABLE[parameter].title:<23} {edit.shown(parameter, level)}"
        for parameter, level in changed.items()
    ]
    counted = (f"{g} {100 * e:.2g} %" if e > 0.0 else f"{g} none resolved" for g, e in chosen.error.items())
    lines += [f"  errors counted: {', '.join(counted)}"]
    if longer >= cases.WORTH_SAYING and changed["integration"] == "explicit":
        other = edit.changed(config, scale, {**changed, "integration": "semi_implicit"})
        lines.append(_semi_implicit(cost.predict(other, case, scale, machine, known)[0], seconds, table, groups))
    lines += [
        f"time of the engine's run, 1 rank, quiet machine: {duration(seconds)} (as configured now: {duration(before)})",
        f"  {load.steps:.0f} steps, {load.lists:.0f} neighbour lists, {load.spheres:.0f} spheres, "
        f"about {load.bridges:.0f} bridges",
    ]
    if write is not None:
        edit.write(config.folder, write, scale, changed)
        lines.append(f"written to {write}: pywet run {case} --scale {scale} --config {write}")
    return lines


def _shown(share: float, chosen: choice.Chosen, moist: bool) -> list[str]:
    """State the accuracy of the settings: the requested one, or the upper bounds of the study where they exceed it."""
    kind = "moist" if moist else "dry"
    wide = {group: bound for group, bound in chosen.bound.items() if bound > share}
    if not wide:
        return [f"settings for {100 * share:g} % in {', '.join(chosen.bound)} ({kind}):"]
    bounds = ", ".join(f"{group} {100 * bound:.2g} %" for group, bound in wide.items())
    return [
        f"{100 * share:g} % is not confirmed by the study: upper bounds of the errors, summed over the settings: {bounds}",
        f"cheapest settings with resolved errors below {100 * share:g} % ({kind}):",
    ]


def _semi_implicit(cost_s: float, chosen_s: float, table: dict[str, Any], groups: tuple[str, ...]) -> str:
    """Report the saving by the other viscous integration, and why it was not chosen."""
    charge = next(
        o.charge for o in choice.options(table, True, longer_by=2.0)["integration"] if o.level == "semi_implicit"
    )
    worst = max(groups, key=lambda group: charge[group])
    return (
        f"  the viscous force governs the step: semi_implicit takes {duration(cost_s)}, {chosen_s / cost_s:.1f} times less; "
        f"the study shows no more than an error below {100 * charge[worst]:.2g} % in {worst}, with water"
    )


def predicted(config: Config, case: int, scale: str) -> str:
    """Return the predicted time of a case as text; empty if this machine has not been measured yet."""
    machine = cost.measured_here()
    if machine is None:
        return ""
    seconds, _ = cost.predict(config, case, scale, machine, habit(choice.for_scale(scale)[0]))
    return f"about {duration(seconds)} on a quiet machine"


def duration(seconds: float) -> str:
    """Write a time in seconds, minutes or hours as words.

    >>> duration(75), duration(12.3), duration(9000)
    ('1.2 min', '12 s', '2.5 h')
    """
    if seconds < 60:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.2g} min" if seconds < 5400 else f"{seconds / 3600:.2g} h"
