"""A screening case as the base of a sweep: keys of its configuration, its row of cases.csv, or its scale are axes."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from pywet import config as settings
from pywet import run_folder, stages
from pywet.cases.screening import verdict
from pywet.config import Case, Config, Materials
from pywet.config.dotted_keys import dotted, filled, holds
from pywet.config.loading import parse, placed_laws
from pywet.config.scales import Scales
from pywet.config.settings import Settings
from pywet.errors import ConfigError, PywetError
from pywet.runs.loaded import Run
from pywet.runs.rundir import RunDir
from pywet.sweep import costs, run_numbers
from pywet.sweep.base_kind import Built, Kind, Numbers, stored_name
from pywet.sweep.costs import Cost
from pywet.sweep.description import Point

PARTS: dict[str, type[BaseModel]] = {"config": Settings, "materials": Materials, "scales": Scales, "case": Case}
"""First word of a key -> its file; `scale` is the scale that is run."""
NOT_AXES = {
    "config.scale": "scale in base, in one file for each scale",
    "config.cases": "case in base, in one file for each case",
    "case.case": "case in base, in one file for each case",
    "config.seed": "the key seeds of the sweep",
    "config.seeds": "the key seeds of the sweep",
    "config.ranks": "the option --ranks",
    "config.both_presets": "the axis laws.preset",
}
"""Keys that choose which runs are carried out, or their seeds -> where a sweep chooses that."""


class OfCase(Kind):
    """A case at a scale, built, simulated, evaluated and replayed as by `pywet run`."""

    results = ("fraction_retained_end",)

    @cached_property
    def config(self) -> Config:
        loaded = settings.load(self.folder / self.base.config, self.trust)
        loaded.case(self.number)
        loaded.scale(self.base.scale or loaded.settings.scale)
        return loaded

    @property
    def number(self) -> int:
        return int(self.base.case or 0)

    @cached_property
    def content(self) -> dict[str, Any]:
        """Return the configuration as plain data, one group for each of its files."""
        row, loaded = self.config.case(self.number), self.config
        parts = {"config": loaded.settings, "materials": loaded.materials, "scales": loaded.scales, "case": row}
        return {name: part.model_dump(mode="json", exclude_none=True) for name, part in parts.items()}

    @property
    def scale(self) -> str:
        return self.base.scale or self.config.settings.scale

    def key(self, axis: str) -> str:
        """Return the dotted path of an axis including its file; a key that another part of the sweep sets is refused."""
        path = self._path(axis)
        cure = next((cure for key, cure in NOT_AXES.items() if f"{path}.".startswith(f"{key}.")), None)
        *scales, name = path.split(".")[:3]
        if scales == ["scales", "scales"] and name != self.scale:
            cure = f"a key of scale {self.scale}, which is run"
        if cure is not None:
            raise ConfigError(
                f"the axis {axis} cannot be varied in a sweep of case {self.number}; expected {cure}",
                code="config.inconsistent", key=f"axes.{axis}", expected=cure,
            )  # fmt: skip
        return path

    def _path(self, axis: str) -> str:
        """Return the dotted path of an axis; a key that is in one file only needs no file name."""
        path = dotted(axis)
        first, _, rest = path.partition(".")
        if first == "scale" and rest:
            return f"scales.scales.{self.scale}.{rest}"
        if first in PARTS and rest:
            return path
        parts = {**self.content, f"scales.scales.{self.scale}": self.content["scales"]["scales"][self.scale]}
        found = [name for name, part in parts.items() if holds(part, path)]
        found = found or [name for name, part in parts.items() if first in part]
        if len(found) != 1:
            where = " and ".join(found) if found else f"none of {', '.join(PARTS)}"
            raise ConfigError(
                f"the axis {axis} is in {where} of {self.config.folder}; expected a key with its file in front, such as "
                "materials.liquid.viscosity_Pa_s, case.liquid_percent or scale.width_mm",
                code="sweep.axis_file", key=f"axes.{axis}",
            )  # fmt: skip
        return f"{found[0]}.{path}"

    def built(self, values: Point, seed: int) -> Built:
        content = filled(self.content, {self.key(axis): value for axis, value in values.items()})
        where = self.config.folder
        files = {name: str(where / f"{name}.yaml") for name in PARTS} | {"case": str(where / "cases.csv")}
        parts: dict[str, Any] = {name: parse(model, content[name], files[name]) for name, model in PARTS.items()}
        chosen = parts["config"]
        laws = placed_laws(chosen.laws, where, self.trust)
        chosen = chosen.model_copy(update={"laws": laws, "seed": chosen.seed + seed})
        row = parts["case"]
        changed = replace(
            self.config, settings=chosen, materials=parts["materials"], scales=parts["scales"], cases={row.case: row}
        )
        word = stages.fingerprint(changed, row.case, self.scale)
        return Built(stored_name("case", word, run_numbers.__file__), (changed, row.case))

    def run(self, built: Built, folder: Path, ranks: int) -> Numbers:
        config, number = built.given
        with run_folder.hold(folder):
            failed = stages.carry_out(config, number, self.scale, folder, ranks=ranks)
        if failed:
            raise PywetError(
                f"stage {failed.failed_at} failed: {failed.reason}",
                code="sweep.stage_failed", given=failed.failed_at, where=folder,
            )  # fmt: skip
        if objections := verdict.objections(RunDir(folder)):
            raise PywetError("; ".join(objections), code="sweep.objections", given=tuple(objections), where=folder)
        return run_numbers.numbers(Run(folder))

    @property
    def ranks(self) -> int:
        return self.config.settings.ranks

    def cost(self, built: Built) -> Cost:
        config, number = built.given
        return costs.of_case(config, number, self.scale)

    def known(self, built: Built) -> list[str]:
        config, number = built.given
        return run_numbers.of_case(config, number, self.scale)
