"""The accuracy study: its rounds and their runs, its table, and the page.

A round is a scene with one seed: all its settings in turn, the default first and last, so that other load on the
machine affects all of them.
"""

from __future__ import annotations

import datetime
import json
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import pandas as pd

from pywet import config as settings
from pywet.cost import choice, command, cost
from pywet.cost.edit import Level
from pywet.cost.timing import machine
from pywet.errors import PywetError
from pywet.runs.summary import versions
from pywet.util.files import read_json, write_json
from studies import study
from studies.accuracy import errors, measure, parameters, sieve
from studies.accuracy.parameters import PARAMETERS_OF, SCALE, Setting, with_setting
from studies.accuracy.sieve import SCREENING, SEEDS

ONCE = ("pair_dry", "pair_wet", "pull", "laws")
"""Deterministic scenes, with one round."""


@dataclass(frozen=True)
class AccuracyStudy(study.Study):
    """Study of all settings in all scenes, in one of the sizes of `sieve.SIZES`."""

    folder: Path
    size: str = "quick"
    config_dir: Path = Path("config")

    def __post_init__(self) -> None:
        sieve.size_named(self.size)

    def jobs(self) -> list[str]:
        """Return the rounds, with those of one scene spread out."""
        shape = sieve.size_named(self.size)
        seeds = {"bed": shape.seeds, "moist": shape.seeds, "dry": shape.dry_seeds or shape.seeds}
        rounds = [(scene, SEEDS[0]) for scene in ONCE]
        rounds += [(scene, seed) for k, seed in enumerate(SEEDS) for scene in ("bed", *SCREENING) if k < seeds[scene]]
        return [f"{self.size}/{scene}-{seed}" for scene, seed in rounds]

    def runs(self, job: str) -> list[study.Run]:
        """Return default, every other level of every setting (with a new start for each seed), and the default again."""
        scene, _, seed = job.partition("/")[2].rpartition("-")
        base = parameters.default(self.size)
        turned: list[tuple[str, Level | None]] = [
            (parameter, level)
            for parameter in PARAMETERS_OF[scene]
            for level in parameters.PARAMETERS[parameter].levels(self.size)
            if level != getattr(base, parameter)
        ]
        shift = SEEDS.index(int(seed)) * len(turned) // len(SEEDS)
        again: list[tuple[str, Level | None]] = [("again", None)] if scene in SCREENING else []
        order = [("default", None), *turned[shift:], *turned[:shift], *again]
        return [self._run(job, scene, int(seed), parameter, level) for parameter, level in order]

    def _run(self, job: str, scene: str, seed: int, parameter: str, level: Level | None) -> study.Run:
        setting = self.setting(parameter, level)
        given = {
            "scene": scene, "seed": seed, "parameter": parameter, "setting": asdict(setting), "size": self.size,
            "configuration": self.configuration if scene in SCREENING else None,
        }  # fmt: skip
        return study.Run(
            f"{job}-{parameter}" + ("" if level is None else f"-{level}"),
            given,
            partial(measure.rows_of, scene, seed, parameter, setting, self.size, self.config_dir),
            {"scene": scene, "seed": seed, "parameter": parameter, "level": level},
        )

    def setting(self, parameter: str, level: Any) -> Setting:
        """Return the default with one setting changed; `default` and `again` change none."""
        return replace(
            parameters.default(self.size), **({parameter: level} if parameter in parameters.PARAMETERS else {})
        )

    @cached_property
    def configuration(self) -> list[dict[str, Any]]:
        """Return the parts of the configuration that affect screening and that the study does not set."""
        config = with_setting(settings.load(self.config_dir), Setting(), sieve.SIZES[self.size], seed=0)
        return [study.configured(config, number, SCALE) for number in sieve.CASE.values()]

    def table(self) -> dict[str, Any]:
        """Return costs and errors from the stored runs."""
        runs = self.gather()
        if runs.empty or not runs["scene"].isin(SCREENING).any():
            raise PywetError(
                f"no runs of size {self.size} in {self.folder}; expected some: run `pywet study accuracy --size {self.size}`"
            )
        return tabled(runs, self.size)

    def show(self) -> Path:
        """Write table.json into the folder, and the page."""
        from studies.accuracy import page

        table = self.table()
        write_json(self.folder / "table.json", rounded(table))
        others = [held for held in choice.stored()["scales"].values() if held["provenance"]["size"] != self.size]
        return page.write_page(self.page, table, self.gather(), self.size, others, self.times(command.habit(table)))

    def times(self, habit: cost.Habit) -> pd.DataFrame | None:
        """Return measured and predicted processor time [s] of every screening run on one rank; None on an unmeasured machine."""
        machine, runs = cost.measured_here(), self.gather()
        if machine is None:
            return None
        runs = runs[runs["scene"].isin(SCREENING) & runs["failed"].isna() & (runs["parameter"] != "ranks")]
        predicted = [self.predict(labels, machine, habit) for labels in runs.to_dict("records")]
        return pd.DataFrame({"scene": runs["scene"], "measured": runs["cpu_s"], "predicted": predicted})

    def predict(self, run: Any, machine: cost.Coefficients, habit: cost.Habit) -> float:
        """Return the processor time of a screening run [s] from its labels."""
        setting = self.setting(run["parameter"], run["level"])
        made = with_setting(settings.load(self.config_dir), setting, sieve.SIZES[self.size], run["seed"])
        return cost.predict(made, sieve.CASE[run["scene"]], SCALE, machine, habit)[0]

    def expected(self) -> float:
        """Return the expected time of the missing runs on this machine [s]; a few seconds are assumed for each small scene."""
        machine = command.calibrated()
        habit, total = command.habit(choice.for_scale(sieve.SIZES[self.size].scale)[0]), 0.0
        for run in self.missing():
            if run.labels["scene"] not in SCREENING:
                starts = machine.few.start_stock, machine.few.start_moist
                total += 1.0 + starts[run.labels["scene"] != "pair_dry"]
                continue
            try:
                total += self.predict(run.labels, machine, habit) + 0.5
            except PywetError:
                continue  # rejected before any computation
        return total


def tabled(runs: pd.DataFrame, size: str) -> dict[str, Any]:
    """Return the result as one small table: costs and errors by setting and level, with their sources."""
    found, costs = errors.errors(runs, size), errors.costs(runs, size)
    failed = runs[runs["failed"].notna()]
    failed = failed.assign(message=failed["scene"] + ": " + failed["failed"].astype(str))
    message = ["scene", "quantity", "group", "value", "limit", "family", "seeds"]
    rows = {
        name: [
            {
                "level": level,
                "cost": _of(costs, name, level).set_index("scene")[["ratio", "low", "high"]].to_dict("index"),
                "errors": _of(found, name, level)[message].to_dict("records"),
                "failed": sorted(_of(failed, name, level)["message"].unique()),
            }
            for level in parameter.levels(size)
        ]
        for name, parameter in parameters.PARAMETERS.items()
    }
    return {
        "provenance": provenance(runs, size),
        "default": asdict(parameters.default(size)),
        "parameters": rows,
        "habit": {"exact_start": exact_start(runs)},
        "spread_over_seeds": spread(runs),
    }


def _of(table: pd.DataFrame, parameter: str, level: Level) -> pd.DataFrame:
    return table[(table["parameter"] == parameter) & (table["level"] == level)]


def exact_start(runs: pd.DataFrame) -> float:
    """Return the start time of a moist run with the exact bridge's laws over that of the default, in the same rounds."""
    moist = runs[(runs["scene"] == "moist") & runs["failed"].isna()].set_index("seed")
    start = moist["cpu_s"] - moist["loop_cpu_s"]
    ratios = (
        start[(moist["parameter"] == "capillary") & (moist["level"] == "exact")]
        / start[moist["parameter"] == "default"]
    )
    return float(ratios.median()) if ratios.notna().any() else 1.0


def provenance(runs: pd.DataFrame, size: str) -> dict[str, Any]:
    """Describe how the table of the study was made: versions, machine, date."""
    shape, of_run = sieve.SIZES[size], runs.drop_duplicates("run")
    cpu, wall = (float(of_run[clock].sum()) for clock in ("cpu_s", "wall_s"))
    return {
        "made_by": f"pywet study accuracy --size {size} --store",
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "size": size,
        "scale": shape.scale,
        "seeds": shape.seeds,
        "dry_seeds": shape.dry_seeds or shape.seeds,
        "runs": len(of_run),
        "processor_time_s": round(cpu, 1),
        "wall_over_processor_time": round(wall / max(cpu, 1e-9), 2),
        "machine": machine(),
        "versions": versions(),
    }


def spread(runs: pd.DataFrame) -> dict[str, dict[str, list[float]]]:
    """Return scene -> quantity -> values of the default over the seeds."""
    default = runs[(runs["parameter"] == "default") & runs["failed"].isna()]
    names = [q.name for q in errors.QUANTITIES if q.name in default and q.name != "restitution"]
    values = {scene: of[names].dropna(axis="columns") for scene, of in default.groupby("scene", sort=False)}
    return {str(scene): of.to_dict("list") for scene, of in values.items() if len(of.columns)}  # type: ignore[misc]


def store(result: dict[str, Any], path: Path = choice.STORED) -> Path:
    """Store a study's table in the stored one, replacing that of its scale."""
    try:
        whole = read_json(path, shape=dict[str, dict[str, Any]])
    except PywetError:  # none yet
        whole = {"scales": {}}
    whole["scales"][result["provenance"]["scale"]] = rounded(result)
    study.write_rows(path, whole)
    choice.stored.cache_clear()
    return path


def rounded(value: Any) -> Any:
    """Round all numbers of the table to five digits."""
    return json.loads(json.dumps(value), parse_float=lambda digits: float(f"{float(digits):.5g}"))
