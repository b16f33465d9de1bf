"""Predicted time, memory and disk of a run, for cluster jobs and for `pywet plan`.

Time is predicted by `cost.py`, with the measured costs of this machine or, without a measurement, those of the
machine described in `machine.json`. Memory and disk are counts of `counts.py` times the measured amount for each
(docs/cluster.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from pywet.cases.screening import cases
from pywet.config import Config, preset_comparisons
from pywet.cost import choice, cost
from pywet.cost.command import duration, habit
from pywet.cost.counts import Load
from pywet.cost.trial import Costs
from pywet.geometry.apparatus import build_apparatus
from pywet.planning.time_steps import advise
from pywet.util.files import read_json

ELSEWHERE = Path(__file__).with_name("machine.json")
RANK_B = 450e6
"""Memory of one rank without spheres: Python, compiled laws, the engine."""
SPHERE_B = 20e3
"""Memory of one rank per sphere that it stores, including neighbours, contacts and bridges."""
REPLAY_B = 500e6
REPLAY_SPHERE_B = 60e3
"""Memory of the replay, without spheres and per sphere."""
SNAPSHOT_SPHERE_B, SNAPSHOT_BRIDGE_B, EVENT_B = 110.0, 50.0, 105.0
"""Bytes that a finished run stores per sphere and per bridge at an output, and per event."""
WINDOW_SPHERE_B, CONTACT_B = 140.0, 240.0
"""Bytes that a finished run stores per sphere and per bridge at a step of a window."""
RAW = 3.0
"""Disk during the conversion to tables, over that of the tables: raw logs remain until all tables are complete."""
SAFE = 3.0
"""Wall time requested from a cluster over the prediction, which is for an idle machine."""
LEAST_MIN = 10


@dataclass(frozen=True)
class Need:
    """Time, memory and disk of one run; time is processor time of one core."""

    load: Load
    seconds: float
    memory_B: float
    """Memory of all ranks together."""
    disk_B: float
    replay_B: float

    def minutes(self, attempt: int = 1) -> int:
        """Return the wall time to request [min], doubled with each attempt."""
        return max(LEAST_MIN, math.ceil(SAFE * self.seconds / 60.0)) * 2 ** (attempt - 1)

    def memory_mb(self, attempt: int = 1, stage: str = "simulate") -> int:
        """Return the memory to request [MB], doubled with each attempt."""
        needed = self.replay_B if stage == "replay" else self.memory_B
        return max(1000, math.ceil(1.5 * needed / 1e6)) * 2 ** (attempt - 1)


@cache
def _machine() -> cost.Coefficients:
    return cost.measured_here() or stored_machine()


def stored_machine() -> cost.Coefficients:
    """Return the costs of the machine described in `machine.json`."""
    stored: dict[str, Any] = read_json(ELSEWHERE)
    return cost.Coefficients(Costs(**stored["few"]), Costs(**stored["many"]))


def need(config: Config, case: int, scale: str, ranks: int = 1, machine: cost.Coefficients | None = None) -> Need:
    """Predict time, memory and disk of a case; raises `PywetError` if its scene cannot be built."""
    seconds, load = cost.predict(config, case, scale, machine or _machine(), habit(choice.for_scale(scale)[0]))
    size, output = config.scale(scale), config.settings.output
    outputs = size.duration_s.value / size.output_interval_s.value
    logged = output.contact_windows * output.contact_window_steps
    tables = EVENT_B * load.events + load.bridges * (CONTACT_B * logged + SNAPSHOT_BRIDGE_B * outputs)
    tables += load.spheres * (SNAPSHOT_SPHERE_B * outputs + WINDOW_SPHERE_B * logged)
    return Need(
        load=load,
        seconds=seconds,
        memory_B=ranks * RANK_B + SPHERE_B * load.spheres,
        disk_B=tables,
        replay_B=REPLAY_B + REPLAY_SPHERE_B * load.spheres,
    )


def _short(number: float) -> str:
    """Format a number with three digits, without a power of ten for large ones."""
    return f"{number:.3g}" if number < 999.5 else f"{number:.0f}"


def campaign(config: Config, scale: str) -> list[str]:
    """Return lines on core-hours, memory and disk of all configured cases with all seeds."""
    chosen, seeds = config.settings, config.settings.seeds
    runs = {config.case(number).name: (config, number) for number in chosen.cases}
    again = preset_comparisons(config, {name: number for name, (_, number) in runs.items()}, chosen.both_presets)
    runs |= {name: (config.with_preset(preset), number) for name, (number, preset) in again.items()}
    needs = {name: need(configured, number, scale, chosen.ranks) for name, (configured, number) in runs.items()}
    rows = [f"{'':<14}{'spheres':>8}{'a run':>10}{'memory':>10}{'disk':>10}"]
    rows += [
        f"{name:<14}{n.load.spheres:>8.0f}{duration(n.seconds):>10}{n.memory_B / 1e9:>7.2f} GB{n.disk_B / 1e9:>7.2f} GB"
        for name, n in needs.items()
    ]
    memory, replays = (max(getattr(n, name) for n in needs.values()) / 1e9 for name in ("memory_B", "replay_B"))
    hours = seeds * sum(n.seconds for n in needs.values()) / 3600.0
    disk = seeds * sum(n.disk_B for n in needs.values())
    most = max(n.disk_B for n in needs.values())
    rows.append(
        f"{seeds * len(needs)} runs at scale {scale} ({seeds} of each): {_short(hours)} core-hours of the engine, up to "
        f"{_short(memory)} GB for a run and {_short(replays)} GB "
        f"for its replay, {_short(disk / 1e9)} GB of tables, {_short(RAW * most / 1e9)} GB more while the largest is made"
    )
    measured = "this machine, measured" if cost.measured_here() else str(read_json(ELSEWHERE)["provenance"])
    rows.append(f"time of the engine alone, without replay and pictures: {measured}")
    return rows


def glance(config: Config, case: int, scale: str, made: cases.Ingredients) -> list[str]:
    """Return lines of at most 80 columns on time, accuracy and stability of a case with its settings; fast, writes nothing."""
    seconds = need(config, case, scale).seconds
    errors = choice.of_default(choice.for_scale(scale)[0], config.case(case).liquid_percent > 0).error
    found = [f"{group} {100 * error:.2g} %" for group, error in errors.items() if error > 0.0]
    of = config.case(case), config.scale(scale)
    advice = advise(cases.assemble(config, *of, made, build_apparatus(cases.apparatus_spec(config, *of))))
    least = next(limit for limit in advice.limits if limit.stability)
    return [
        f"time       {duration(seconds)}, {seconds / 3600:.2g} core-hours, of the engine without replay and pictures",
        f"accuracy   errors of defaults: {', '.join(found) or 'none resolved'}",
        f"stability  time step {advice.time_step_s:.3g} s, {advice.time_step_s / least.time_step_s:.2g} of the largest "
        f"stable one ({least.effect})",
    ]


def reasons(config: Config, case: int, scale: str) -> list[str]:
    """Return lines on the meaning of the errors of `glance` and the setting with the largest one; none if none is resolved."""
    table, moist = choice.for_scale(scale)[0], config.case(case).liquid_percent > 0
    errors = choice.of_default(table, moist).error
    group = max(errors, key=lambda g: errors[g])
    if not errors[group] > 0.0:
        return []
    return [
        "           errors of defaults: largest differences from finer settings, summed over the settings",
        f"           {group}: mostly from {choice.largest_setting(table, moist, group)}; pywet plan {case} --accuracy 5% chooses "
        "settings with less",
    ]
