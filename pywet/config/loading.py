"""Read the configuration folder and report every mistake in it in one sentence."""

from __future__ import annotations

import csv
import math
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ValidationError
from typing_extensions import TypedDict
from yaml.constructor import ConstructorError

from pywet.config import cases as cases_module
from pywet.config import materials, scales, settings
from pywet.config.cases import Case
from pywet.config.materials import SIEVE_MM, Materials, Size
from pywet.config.messages import mistake
from pywet.config.scales import Apparatus, Scale, Scales
from pywet.config.settings import LawSettings, Settings
from pywet.errors import ConfigError, PywetError, one_line
from pywet.laws import custom_laws
from pywet.laws.kinds import PRESETS
from pywet.util.files import AGAIN, read_bytes, read_json

Model = TypeVar("Model", bound=BaseModel)
Key = TypeVar("Key")
Entry = TypeVar("Entry")
FILES: dict[str, type[BaseModel]] = {
    settings.FILE: Settings,
    materials.FILE: Materials,
    scales.FILE: Scales,
    cases_module.FILE: Case,
}
"""File of the configuration -> type of its content (of each row for cases.csv)."""


@dataclass(frozen=True)
class Config:
    """Contents of all files of the configuration, checked; `cases` by number."""

    folder: Path
    settings: Settings
    materials: Materials
    scales: Scales
    cases: Mapping[int, Case]
    read: Mapping[str, tuple[str, Any]] = field(default_factory=dict)
    """File -> its text and its parsed content; empty for a configuration that was not read from files."""

    @property
    def apparatus(self) -> Apparatus:
        return self.scales.apparatus

    @property
    def readings(self) -> list[str]:
        """Return a line for each non-default reading of the paper."""
        diameter = self.materials.feed.sieve_diameter_mm.value
        other = f"reading: feed.sieve_diameter_mm is {diameter:g} (default {SIEVE_MM:g})"
        return [*self.settings.readings.lines, *([other] if diameter != SIEVE_MM else [])]

    def size(self, material: str, diameter_mm: float) -> Size:
        """Return a size of spheres, with the density selected by the readings."""
        found = self.materials.size(material, diameter_mm)
        return found.as_weighed if self.settings.readings.sphere_mass == "weighed" else found

    def liquid_percent(self, number: int) -> float:
        """Return the initial liquid on the spheres of a case [% of their mass], according to the readings."""
        case = self.case(number)
        if case.liquid_percent == 0 or self.settings.readings.liquid_amount == "full":
            return case.liquid_percent
        lost = self.materials.sphere(case.material).residual_liquid_percent
        if lost is None or lost.value >= 100:
            raise ConfigError(
                f"{materials.FILE}: spheres.{case.material} has "
                f"{'no residual_liquid_percent' if lost is None else f'a residual_liquid_percent of {lost.value:g}'}, expected "
                "0 to below 100 where readings.liquid_amount in config.yaml is less_residual",
                code="config.residual",
                key=f"spheres.{case.material}.residual_liquid_percent",
                given=None if lost is None else lost.value,
                expected="0 to below 100",
                file=materials.FILE,
            )
        return case.liquid_percent * (1.0 - 0.01 * lost.value)

    def scale(self, name: str) -> Scale:
        """Return a scale by its name; a sieve without a width has that of the feed."""
        found = self._one_of(self.scales.scales, name, f"scale {one_line(name) if name else '(empty)'}", scales.FILE)
        return found.model_copy(update={"width_mm": found.width_mm or self.materials.feed.sieve_diameter_mm})

    def case(self, number: int) -> Case:
        return self._one_of(self.cases, number, f"case {number}", cases_module.FILE)

    def _one_of(self, known: Mapping[Key, Entry], key: Key, what: str, file: str) -> Entry:
        if key not in known:
            have, path = ", ".join(map(str, known)), self.folder / file
            raise ConfigError(
                f"there is no {what} in {path}, expected one of {have}",
                file=path,
                code="config.unknown_name",
                key=what.partition(" ")[0],
                given=key,
                expected=have,
            )
        return known[key]

    def with_preset(self, name: str) -> Config:
        """Return a copy of the configuration with another preset of laws and no individually chosen laws."""
        if name not in PRESETS:
            raise ConfigError(
                f"there is no preset {name and one_line(name)!r}; expected one of {', '.join(PRESETS)}",
                code="config.unknown_preset",
                key="laws.preset",
                given=name,
                expected=tuple(PRESETS),
            )
        chosen = LawSettings.model_validate({"preset": name})
        return replace(self, settings=self.settings.with_laws(chosen))

    def with_seed(self, seed: int) -> Config:
        """Return a copy of the configuration with another seed of the spheres' initial arrangement."""
        return replace(self, settings=self.settings.model_copy(update={"seed": seed}))

    def without_retirement(self) -> Config:
        """Return a copy of the configuration that retires no sphere, for engines that cannot remove any."""
        return replace(self, settings=self.settings.model_copy(update={"retire": False}))

    def without_rolling(self) -> Config:
        """Return a copy of the configuration without rolling resistance, for engines that do not have it."""
        effects = self.settings.effects.model_copy(update={"rolling": False})
        return replace(self, settings=self.settings.model_copy(update={"effects": effects}))

    def resolved(self, number: int, scale: str) -> dict[str, Any]:
        """Collect the configuration of one run, with the source of every number, as plain data."""
        liquid = self.materials.liquid_named(self.case(number).liquid)
        materials = self.materials.model_copy(update={"liquid": liquid, "liquids": {}})
        return {
            "case": self.case(number).model_dump(mode="json", exclude_none=True),
            "scale": {"name": scale, **self.scale(scale).model_dump(mode="json", exclude_none=True)},
            "apparatus": self.apparatus.model_dump(mode="json", exclude_none=True),
            "materials": materials.model_dump(mode="json", exclude_none=True, exclude={"liquids"}),
            "settings": self.settings.model_dump(mode="json", exclude_none=True, exclude={"cases", "scale"}),
        }


def texts(config: Config) -> dict[str, Any]:
    """Return the configuration's files as text, and the keys of config.yaml that were set after reading.

    A part that was replaced since is left out.
    """
    now = {
        settings.FILE: config.settings,
        materials.FILE: config.materials,
        scales.FILE: config.scales,
        cases_module.FILE: config.cases,
    }
    files, later = {}, []
    for name, (text, model) in config.read.items():
        if name == settings.FILE:
            before, after = (part.model_dump(mode="json") for part in (model, config.settings))
            later = [key for key in before if before[key] != after[key]]
        if name == settings.FILE or now[name] is model:
            files[name] = text
    return {"files": files, "set_later": later}


def preset_comparisons(config: Config, cases: Mapping[str, int], wanted: bool) -> dict[str, tuple[int, str]]:
    """Return runs that repeat a case with another preset: the first moist one with `exact`, if wanted and set to `paper`.

    `cases`: folder name -> number. Result: folder name -> (number, preset).
    """
    if not wanted or config.settings.laws.preset != "paper":
        return {}
    moist = next((number for number in cases.values() if config.case(number).liquid_percent > 0), None)
    return {} if moist is None else {f"{config.case(moist).name}_exact": (moist, "exact")}


def load(config_dir: Path, trust: bool = False) -> Config:
    """Read config.yaml, materials.yaml, scales.yaml and cases.csv of a folder; raises `PywetError` for any mistake.

    `trust`: permit law files outside of the folder.
    """
    folder, wrong = Path(config_dir), Mistakes()
    read = {
        file: wrong.keep(partial(_read_model, folder / file, model))
        for file, model in FILES.items()
        if model is not Case
    }
    cases = wrong.keep(lambda: _read_cases(folder / cases_module.FILE))
    wrong.say()
    chosen = read[settings.FILE]
    chosen = chosen.model_copy(update={"laws": placed_laws(chosen.laws, folder, trust)})
    made = {**read, settings.FILE: chosen, cases_module.FILE: cases}
    stored = {name: (_read_text(folder / name), part) for name, part in made.items()}
    config = Config(folder, chosen, read[materials.FILE], read[scales.FILE], cases, stored)
    wrong.keep(lambda: _check_choice(config))
    wrong.keep(lambda: _check_references(config))
    wrong.say()
    return config


class Resolved(TypedDict):
    """Content of config.json of a run, see `Config.resolved`: its materials contain only the case's liquid."""

    case: dict[str, Any]
    scale: dict[str, Any]
    apparatus: dict[str, Any]
    materials: dict[str, Any]
    settings: dict[str, Any]


def of_run(run_dir: Path) -> tuple[Config, int, str]:
    """Return the configuration of a case's run from its config.json, the case's number and the scale."""
    path = Path(run_dir) / "config.json"
    where, data = str(path), read_json(path, AGAIN, Resolved)
    name = str(data["scale"].get("name", ""))
    scale = {key: value for key, value in data["scale"].items() if key != "name"}
    case = parse(Case, {**data["case"], "liquid": None}, where)
    config = Config(
        Path(run_dir),
        parse(Settings, {**data["settings"], "cases": [case.case], "scale": name}, where),
        parse(Materials, data["materials"], where),
        parse(Scales, {"apparatus": data["apparatus"], "scales": {name: scale}}, where),
        {case.case: case},
    )
    return config, case.case, name


class Mistakes:
    """Collect mistakes so that all are reported together."""

    def __init__(self) -> None:
        self._stored: list[ConfigError] = []

    def keep(self, read: Callable[[], Any]) -> Any:
        """Return the result of `read`, or None if it raises, and store the error."""
        try:
            return read()
        except ConfigError as error:
            self._stored.append(error)
            return None

    def say(self) -> None:
        """Raise all stored mistakes in one error, one line each."""
        if len(self._stored) == 1:
            raise self._stored[0]
        if self._stored:
            lines = "\n".join(str(error) for error in self._stored)
            raise ConfigError(lines, **self._stored[0].data) from self._stored[0]


def parse(model: type[Model], data: Any, where: str) -> Model:
    """Validate plain data; `where` names the file (and row) in the message."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise mistake(error, model, where, data) from error


def _read_model(path: Path, model: type[Model]) -> Model:
    return parse(model, read_yaml(path, model), str(path))


CONFIGURATION = "a folder of the configuration has it, `pywet init DIR` writes one"
"""Hint on how to create a missing file of the configuration; `begun` is that of files of other commands."""


def begun(example: str) -> str:
    """Return the sentence that tells how to create a missing file."""
    return f"name one that exists, `pywet init DIR --example {example}` writes one to begin with"


def _read_text(path: Path, cure: str = CONFIGURATION) -> str:
    content = read_bytes(path, cure)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ConfigError(
            f"{path} is not text (byte {error.start}), expected UTF-8: save it again in that encoding",
            file=path,
            code="config.not_text",
            expected="UTF-8",
        ) from error


MOST_NODES = 1_000_000
"""Largest number of values and groups of a YAML file, with aliases expanded."""


class _Loader(yaml.SafeLoader):
    """YAML loader that reads keys as text and refuses duplicate keys."""

    def get_single_node(self) -> Any:
        """Return the document, unless its aliases expand to more than `MOST_NODES` nodes."""
        node = super().get_single_node()
        if node is not None and _size(node, {}) > MOST_NODES:
            raise ConstructorError(None, None, f"its aliases unfold to more than {MOST_NODES} values", node.start_mark)
        return node

    def compose_mapping_node(self, anchor: Any) -> yaml.MappingNode:
        node = super().compose_mapping_node(anchor)
        seen = set()
        for key, _ in node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise ConstructorError(None, None, "a key is a list or a group, expected a word", key.start_mark)
            if key.value in seen:
                raise ConstructorError(None, None, f"the key {key.value} is given twice", key.start_mark)
            seen.add(key.value)
        return node

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        self.flatten_mapping(node)
        return {str(key.value): self.construct_object(value, deep=deep) for key, value in node.value}


def _size(node: Any, known: dict[int, float]) -> float:
    """Return the number of nodes at and below a node, with aliases expanded; infinite for a node that contains itself."""
    if not isinstance(node, yaml.CollectionNode):
        return 1.0
    if id(node) not in known:
        known[id(node)] = math.inf  # until it is done
        inside = node.value if isinstance(node, yaml.SequenceNode) else [n for pair in node.value for n in pair]
        known[id(node)] = 1.0 + sum(_size(n, known) for n in inside)
    return known[id(node)]


def read_yaml(path: Path, model: type[BaseModel], cure: str = CONFIGURATION) -> dict[str, Any]:
    """Return the content of a YAML file for `model`, without duplicate keys and not yet validated.

    `cure`: hint for a missing file.
    """
    try:
        data = yaml.load(_read_text(path, cure), _Loader)
    except (yaml.YAMLError, ValueError, RecursionError) as error:  # ValueError: an impossible date or number
        mark = getattr(error, "problem_mark", None)
        line = f" in line {mark.line + 1}" if mark is not None else ""
        raise ConfigError(
            f"{path} is not YAML{line}: {getattr(error, 'problem', None) or one_line(error)}; fix it there",
            file=path,
            code="config.not_yaml",
        ) from error
    if not isinstance(data, dict):
        raise ConfigError(
            f"{path} holds {type(data).__name__}, expected the keys {', '.join(model.model_fields)}",
            file=path,
            code="config.not_keys",
            given=type(data).__name__,
            expected=tuple(model.model_fields),
        )
    return data


def _read_cases(path: Path) -> dict[int, Case]:
    found: dict[int, Case] = {}
    needed = [name for name, field in Case.model_fields.items() if field.is_required()]
    wanted = f"{', '.join(needed)} (and {', '.join(sorted(Case.model_fields.keys() - needed))})"
    rows, wrong = csv.DictReader(_read_text(path).splitlines()), Mistakes()
    try:
        header = [name.strip() for name in rows.fieldnames or ()]
        if not set(needed) <= set(header) <= Case.model_fields.keys() or len(set(header)) < len(header):
            raise ConfigError(
                f"{path} has the columns {one_line(', '.join(header)) or 'none'}, expected {wanted}, each once, with commas "
                "between them",
                file=path,
                code="config.columns",
                given=header,
                expected=wanted,
            )
        rows.fieldnames = header
        for row in rows:
            where = f"{path} line {rows.line_num}"
            if None in row or None in (row[name] for name in needed):
                raise ConfigError(
                    f"{where} has too many or too few columns, expected {wanted} (a decimal comma makes two of one)",
                    file=path,
                    code="config.row_length",
                    expected=wanted,
                )
            given = {name: value for name, value in row.items() if value or name in needed}
            case = wrong.keep(partial(parse, Case, given, where))
            if case is not None and case.case in found:
                raise ConfigError(
                    f"{where}: case {case.case} is given twice, expected a different number in each row",
                    file=path,
                    code="config.case_twice",
                    key="case",
                    given=case.case,
                )
            if case is not None:
                found[case.case] = case
    except csv.Error as error:
        raise ConfigError(
            f"{path} line {rows.line_num} is not CSV ({error}); fix it there", file=path, code="config.not_csv"
        ) from error
    wrong.say()
    if not found:
        raise ConfigError(f"{path} has no case, expected one row for each", file=path, code="config.no_case")
    return found


def placed_laws(laws: LawSettings, folder: Path, trust: bool = False) -> LawSettings:
    """Return a copy of the laws in which the user's files have absolute paths, found relative to `folder`.

    Files in or below it are permitted to run; with `trust` the others too.
    """
    given = laws.model_dump(exclude={"preset", "reference"}, exclude_none=True)
    named = {kind: custom_laws.placed(law, folder) for kind, law in given.items()}
    seconds = {kind: custom_laws.placed(function, folder) for kind, function in laws.reference.items()}
    custom_laws.trust([*named.values(), *seconds.values()], None if trust else folder)
    for kind, function in seconds.items():
        custom_laws.check_second(kind, function)
    return laws.model_copy(update={**named, "reference": seconds})


def _check_choice(config: Config) -> None:
    """Check that the scale and the cases selected in config.yaml exist."""
    try:
        config.scale(config.settings.scale)
        for number in config.settings.cases:
            config.case(number)
    except PywetError as error:
        where = config.folder / settings.FILE
        raise ConfigError(f"{where}: {error}", **{**error.data, "where": where}) from error


def _check_references(config: Config) -> None:
    """Raise an error if a case refers to something that is not in materials.yaml, with one line for each reason."""
    path, cases_of = config.folder / cases_module.FILE, defaultdict(list)
    for number, case in config.cases.items():
        try:
            _look_up(case, config.materials)
        except PywetError as error:
            cases_of[str(error)].append(str(number))
    lines = [
        f"{path}: case{'s' if len(numbers) > 1 else ''} {', '.join(numbers)} cannot be built: {reason}"
        for reason, numbers in cases_of.items()
    ]
    if lines:
        raise ConfigError("\n".join(lines), file=path, code="config.reference")


def _look_up(case: Case, data: Materials) -> None:
    """Check that all names and sizes of a case exist.

    These are material, sizes (the reference material's too, unless the case has its own feed), liquid, screen,
    stroke and contacts.
    """
    for diameter in case.diameters_mm:
        data.size(case.material, diameter)
        if not case.has_feed:
            data.size(data.feed.reference_material, diameter)
    data.liquid_named(case.liquid)
    data.screen(case.aperture_mm)
    data.stroke(case.set_amplitude_mm)
    data.contact(case.material, case.material)
    data.wall_contact(case.material)
