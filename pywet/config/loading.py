"""Reads the configuration folder; every mistake in it becomes one sentence."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ValidationError

from pywet.config import cases as cases_module
from pywet.config import materials, scales, settings
from pywet.config.cases import Case
from pywet.config.materials import Materials
from pywet.config.messages import explain
from pywet.config.scales import Apparatus, Scale, Scales
from pywet.config.settings import LawSettings, Settings
from pywet.errors import PywetError
from pywet.laws import own

Model = TypeVar("Model", bound=BaseModel)
FILES: dict[str, type[BaseModel]] = {
    settings.FILE: Settings,
    materials.FILE: Materials,
    scales.FILE: Scales,
    cases_module.FILE: Case,
}
"""File of the configuration -> the type of its content (of each row for cases.csv)."""


@dataclass(frozen=True)
class Config:
    """Everything configured; `cases` by number."""

    folder: Path
    settings: Settings
    materials: Materials
    scales: Scales
    cases: Mapping[int, Case]

    @property
    def apparatus(self) -> Apparatus:
        """Dimensions of the tower."""
        return self.scales.apparatus

    def scale(self, name: str) -> Scale:
        """A scale by name."""
        if name not in self.scales.scales:
            have = _join(self.scales.scales)
            raise PywetError(f"there is no scale {name} in {self.folder / scales.FILE}, expected one of {have}")
        return self.scales.scales[name]

    def case(self, number: int) -> Case:
        """A case by number."""
        if number not in self.cases:
            have = _join(self.cases)
            raise PywetError(f"there is no case {number} in {self.folder / cases_module.FILE}, expected one of {have}")
        return self.cases[number]

    def with_preset(self, name: str) -> Config:
        """The same with another preset of laws, and no law named besides."""
        chosen = LawSettings.model_validate({"preset": name})
        return replace(self, settings=self.settings.model_copy(update={"laws": chosen}))

    def with_seed(self, seed: int) -> Config:
        """The same with another seed of the spheres' first arrangement."""
        return replace(self, settings=self.settings.model_copy(update={"seed": seed}))

    def without_rolling(self) -> Config:
        """The same with rolling resistance off, for engines that do not have it."""
        effects = self.settings.effects.model_copy(update={"rolling": "off"})
        return replace(self, settings=self.settings.model_copy(update={"effects": effects}))

    def resolved(self, number: int, scale: str) -> dict[str, Any]:
        """What concerns one run, with the source of every number, as plain data."""
        return {
            "case": self.case(number).model_dump(mode="json"),
            "scale": {"name": scale, **self.scale(scale).model_dump(mode="json", exclude_none=True)},
            "apparatus": self.apparatus.model_dump(mode="json", exclude_none=True),
            "materials": self.materials.model_dump(mode="json", exclude_none=True),
            "settings": self.settings.model_dump(mode="json", exclude_none=True, exclude={"cases", "scale"}),
        }


def twins(config: Config, cases: Mapping[str, int], wanted: bool) -> dict[str, tuple[int, str]]:
    """Runs that repeat a case with another preset: the first moist one with `exact`, if wanted and configured for `paper`.

    `cases`: folder name -> number. Returns folder name -> (number, preset).
    """
    if not wanted or config.settings.laws.preset != "paper":
        return {}
    moist = next((number for number in cases.values() if config.case(number).liquid_percent > 0), None)
    return {} if moist is None else {f"{config.case(moist).name}_exact": (moist, "exact")}


def load(config_dir: Path) -> Config:
    """Read config.yaml, materials.yaml, scales.yaml and cases.csv of a folder; raises `PywetError` for any mistake."""
    folder = Path(config_dir)
    config = Config(
        folder=folder,
        settings=_with_own_laws(_read_yaml(folder / settings.FILE, Settings)),
        materials=_read_yaml(folder / materials.FILE, Materials),
        scales=_read_yaml(folder / scales.FILE, Scales),
        cases=_read_cases(folder / cases_module.FILE),
    )
    _check_choice(config)
    for case in config.cases.values():
        _check_references(case, config.materials, folder)
    return config


def parse(model: type[Model], data: Any, where: str) -> Model:
    """Validate plain data; `where` names the file (and row) in the message."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise PywetError(explain(error, model, where)) from error


def _read_text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        raise PywetError(f"{path} could not be read ({why}), expected a file of the configuration folder") from error


def _read_yaml(path: Path, model: type[Model]) -> Model:
    try:
        data = yaml.safe_load(_read_text(path))
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = f" in line {mark.line + 1}" if mark is not None else ""
        problem = getattr(error, "problem", None) or "it cannot be parsed"
        raise PywetError(f"{path} is not YAML{line}: {problem}; mend it there") from error
    if not isinstance(data, dict):
        raise PywetError(f"{path} holds {type(data).__name__}, expected the keys {', '.join(model.model_fields)}")
    return parse(model, data, str(path))


def _read_cases(path: Path) -> dict[int, Case]:
    found: dict[int, Case] = {}
    for line, row in enumerate(csv.DictReader(_read_text(path).splitlines()), start=2):
        where = f"{path} line {line}"
        if None in row or None in row.values():
            raise PywetError(f"{where} has too many or too few columns, expected {', '.join(Case.model_fields)}")
        case = parse(Case, row, where)
        if case.case in found:
            raise PywetError(f"{where}: case {case.case} is given twice, expected another number for each row")
        found[case.case] = case
    if not found:
        raise PywetError(f"{path} has no case, expected one row for each")
    return found


def _with_own_laws(read: Settings) -> Settings:
    """The same with whole paths for the laws in files of the user's own, which may run from now on."""
    named = {kind: own.placed(law) for kind, law in read.laws.model_dump(exclude={"preset"}, exclude_none=True).items()}
    own.trust(named.values())
    return read.model_copy(update={"laws": read.laws.model_copy(update=named)})


def _check_choice(config: Config) -> None:
    """The scale and the cases that config.yaml chooses must exist."""
    try:
        config.scale(config.settings.scale)
        for number in config.settings.cases:
            config.case(number)
    except PywetError as error:
        raise PywetError(f"{config.folder / settings.FILE}: {error}") from error


def _check_references(case: Case, data: Materials, folder: Path) -> None:
    """What a case names must be in materials.yaml: material, sizes (the reference material's too), screen, stroke."""
    try:
        for diameter in case.diameters_mm:
            data.size(case.material, diameter)
            data.size(data.feed.reference_material, diameter)
        data.screen(case.aperture_mm)
        data.stroke(case.set_amplitude_mm)
        data.contact(case.material, case.material)
        data.wall_contact(case.material)
    except PywetError as error:
        raise PywetError(f"{folder / cases_module.FILE}: case {case.case} cannot be built: {error}") from error


def _join(names: Mapping[Any, Any]) -> str:
    return ", ".join(str(n) for n in names)
