"""Apply chosen settings to a configuration: in memory for a prediction, or as a copy of the folder."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

from pywet import config as settings
from pywet.config import Config
from pywet.cost.parameters import CONFIGURABLE, PARAMETERS, Level, Setting, log_windows
from pywet.errors import PywetError
from pywet.util.files import atomic_write

Levels = Mapping[str, Level]
SCALE = "study"
"""Name of the scale made for the study."""
PLACES = {
    "fraction": "config.yaml: time_step fraction value",
    "integration": "config.yaml: time_step viscous_integration",
    "bridges_every": "config.yaml: time_step bridges_every",
    "stiffness": "scales.yaml: scales {scale} stiffness_factor value",
    "wire_sides": "scales.yaml: scales {scale} wire_sides value",
}
"""Setting -> its entry in the configuration: the file, and the key in it."""


@dataclass(frozen=True)
class Size:
    """Size of a study: sieve [mm], simulated time and opening of the slide [s] (None: as in the scale), number of seeds.

    `dry_seeds`: number for dry screening, whose runs are short (0: the same).
    """

    scale: str
    width_mm: float | None
    duration_s: float | None
    opens_s: float | None
    seeds: int
    dry_seeds: int = 0


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
    file, _, key = PARAMETERS[parameter].place.partition(": ")
    return f"{key} = {level}   ({file})"


def entries(scale: str, levels: Levels) -> dict[str, Any]:
    """Return the entries that levels set, with their values; None removes an entry."""
    laws = law_names(str(levels["capillary"])) if "capillary" in levels else {}
    numbers = {
        PLACES[parameter].format(scale=scale): level for parameter, level in levels.items() if parameter in PLACES
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
    return config


def with_setting(config: Config, setting: Setting, size: Size, seed: int) -> Config:
    """Return the configuration with another setting, another seed and the scale SCALE, which has the size of the study."""
    windows, steps = log_windows(setting.contact_log)
    log = {"contact_windows": windows, "contact_window_steps": steps, "checkpoints": 0}
    given = {"width_mm": size.width_mm, "duration_s": size.duration_s, "slide_opens_at_s": size.opens_s}
    values = {"config.yaml: seed": seed, f"scales.yaml: scales {SCALE}": config.scale(size.scale)}
    values |= {f"config.yaml: output {name}": value for name, value in log.items()}
    values |= {f"scales.yaml: scales {SCALE} {name} value": v for name, v in given.items() if v is not None}
    turned = with_entries(
        config, {**values, **entries(SCALE, {parameter: getattr(setting, parameter) for parameter in CONFIGURABLE})}
    )
    return turned.without_retirement()  # a study uses the whole bed, without checkpoints


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


def write(source: Path, target: Path, scale: str, levels: Levels, more: Mapping[str, Any] | None = None) -> None:
    """Copy a configuration folder with the levels applied, and `more` as `put_into` takes it."""
    new_folder(target)
    target.mkdir(parents=True, exist_ok=True)
    for name in settings.FILES:
        shutil.copyfile(source / name, target / name)
    put_into(target, {**entries(scale, levels), **(more or {})})


def write_again(source: Path, target: Path, scale: str, levels: Levels, more: Mapping[str, Any] | None = None) -> None:
    """Rewrite a configuration over the copies of an earlier call; a folder with any other file is refused."""
    if not target.is_dir() or {path.name for path in target.iterdir()} - set(settings.FILES):
        new_folder(target)
    for name in settings.FILES:
        (target / name).unlink(missing_ok=True)
    write(source, target, scale, levels, more)


def put_into(folder: Path, values: Mapping[str, Any]) -> None:
    """Write entries into the files of a configuration, preserving comments and the order of keys.

    An entry is named by its file and its key, `config.yaml: time_step fraction value`; None removes it.
    """
    yaml = YAML()
    yaml.preserve_quotes, yaml.width = True, 10_000
    for file in dict.fromkeys(place.partition(": ")[0] for place in values):
        content = yaml.load(folder / file)
        for place, value in values.items():
            of, _, path = place.partition(": ")
            if of != file:
                continue
            entry, (*above, last) = content, path.split()
            for key in above:
                entry = entry[int(key)] if isinstance(entry, list) else entry.setdefault(key, {})
            entry.pop(last, None) if value is None else entry.update({last: value})
        with atomic_write(folder / file) as temporary:
            yaml.dump(content, temporary)
