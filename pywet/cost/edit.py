"""Apply chosen settings to a configuration: in memory for a prediction, or as a copy of the folder."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.constructor import RoundTripConstructor
from ruamel.yaml.tag import Tag

from pywet import config as settings
from pywet.config import Config
from pywet.config.settings import Settings
from pywet.errors import PywetError
from pywet.laws.custom_laws import is_custom
from pywet.util.files import atomic_write

Level = float | int | str
Levels = Mapping[str, Level]


@dataclass(frozen=True)
class Configurable:
    """A setting that a choice changes: its title, and its file, key and entry in the configuration."""

    title: str
    file: str
    key: str
    entry: str = ""
    """Path of the entry in its file, by keys; empty for `laws`, of which several change."""


CONFIGURABLE = {
    "fraction": Configurable("time step", "config.yaml", "time_step.fraction", "time_step fraction value"),
    "stiffness": Configurable(
        "spring stiffness", "scales.yaml", "stiffness_factor", "scales {scale} stiffness_factor value"
    ),
    "wire_sides": Configurable("wire facets", "scales.yaml", "wire_sides", "scales {scale} wire_sides value"),
    "capillary": Configurable("capillary law", "config.yaml", "laws"),
    "integration": Configurable(
        "viscous integration", "config.yaml", "time_step.viscous_integration", "time_step viscous_integration"
    ),
    "bridges_every": Configurable(
        "steps between impulses", "config.yaml", "time_step.bridges_every", "time_step bridges_every"
    ),
}
"""Settings that a choice changes; contact log and ranks affect only the cost and are left to the user."""

MERGE, TEXT = "tag:yaml.org,2002:merge", "tag:yaml.org,2002:str"
"""Tags of YAML: of the key `<<`, and of a text."""


def law_names(level: str) -> dict[str, str | None]:
    """Return the fields of the configuration's laws for a level of the capillary setting."""
    exact = level == "exact"
    chosen = {"preset": "exact", "capillary": None} if exact else {"preset": "paper", "capillary": level}
    return {**chosen, "rupture": None, "transfer": None}


def shown(parameter: str, level: Level) -> str:
    """Format a level as its key and value in the configuration."""
    if parameter == "capillary":
        text = "laws: {preset: exact}" if level == "exact" else f"laws: {{preset: paper, capillary: {level}}}"
        return f"{text}   (config.yaml)"
    of = CONFIGURABLE[parameter]
    return f"{of.key} = {level}   ({of.file})"


def entries(scale: str, levels: Levels) -> dict[str, Any]:
    """Return the entries that levels set, with their values; None removes an entry."""
    laws = law_names(str(levels["capillary"])) if "capillary" in levels else {}
    numbers = {
        f"{of.file}: {of.entry.format(scale=scale)}": levels[name]
        for name, of in CONFIGURABLE.items()
        if name in levels and of.entry
    }
    return {**numbers, **{f"config.yaml: laws {key}": law for key, law in laws.items()}}


def changed(config: Config, scale: str, levels: Levels) -> Config:
    """Return the configuration with these levels, in memory."""
    return with_entries(config, entries(scale, levels))


def with_entries(config: Config, values: Mapping[str, Any]) -> Config:
    """Return the configuration with other values of entries, in memory."""
    for place, value in values.items():
        file, _, path = place.partition(".yaml: ")
        part = "settings" if file == "config" else file
        config = replace(config, **{part: put(getattr(config, part), path, value)})
    return replace(config, settings=config.settings.with_laws(config.settings.laws))


def put(part: Any, path: str, value: Any) -> Any:
    """Return a part of the configuration with another value at a path."""
    key, _, rest = path.partition(" ")
    if isinstance(part, dict):
        return {**part, key: put(part[key], rest, value) if rest else value}
    return part.model_copy(update={key: put(getattr(part, key), rest, value) if rest else value})


def new_folder(target: Path) -> None:
    """Refuse a folder whose content would be overwritten."""
    if target.exists() and (not target.is_dir() or any(target.iterdir())):
        what = "not empty" if target.is_dir() else "a file"
        raise PywetError(
            f"{target} is {what}; expected a new folder for the configuration: name another",
            code="cost.folder", where=target,
        )  # fmt: skip


def write(source: Path, target: Path, scale: str, levels: Levels) -> None:
    """Copy a configuration folder with the levels applied; the files of its laws are used where they are."""
    new_folder(target)
    before = settings.load(source)
    after = changed(before, scale, levels)
    target.mkdir(parents=True, exist_ok=True)
    for name in settings.FILES:
        shutil.copyfile(source / name, target / name)
    put_into(target, {**entries(scale, levels), **_of_laws(before.settings, after.settings)})


def _of_laws(before: Settings, after: Settings) -> dict[str, Any]:
    """Return the entries of the user's laws by absolute paths, and of what applied to laws that were replaced."""
    laws = after.laws.model_dump(exclude={"preset", "reference"}, exclude_none=True)
    changes = {f"laws {kind}": law for kind, law in laws.items() if is_custom(law)}
    if before.laws.reference:
        changes["laws reference"] = dict(after.laws.reference)
    changes |= {f"readings {key}": value for key, value in after.readings if value != getattr(before.readings, key)}
    return {f"config.yaml: {path}": value for path, value in changes.items()}


class _WithWords(RoundTripConstructor):
    """Constructor that reads keys as text, as `load` does."""

    def construct_mapping(self, node: Any, *more: Any, **how: Any) -> Any:
        for key, _ in node.value:
            if key.tag != MERGE:
                key.ctag = Tag(suffix=TEXT)
        return super().construct_mapping(node, *more, **how)


def _unshared(group: Any, key: Any) -> Any:
    """Return a part of a group that no other group shares by an alias; a new one if there is none."""
    group[key] = copy(group[key]) if isinstance(group, list) or key in group else {}
    return group[key]


def put_into(folder: Path, values: Mapping[str, Any]) -> None:
    """Write entries into the files of a configuration, preserving comments and the order of keys.

    An entry is named by its file and its key, `config.yaml: time_step fraction value`; None removes it.
    """
    yaml = YAML()
    yaml.Constructor = _WithWords
    yaml.preserve_quotes, yaml.width = True, 10_000
    for file in dict.fromkeys(place.partition(": ")[0] for place in values):
        content = yaml.load(folder / file)
        for place, value in values.items():
            of, _, path = place.partition(": ")
            if of != file:
                continue
            entry, (*above, last) = content, path.split()
            for key in above:
                entry = _unshared(entry, int(key) if isinstance(entry, list) else key)
            entry.pop(last, None) if value is None else entry.update({last: value})
        with atomic_write(folder / file) as temporary:
            yaml.dump(content, temporary)
