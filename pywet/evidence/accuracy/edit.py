"""Chosen settings into a configuration: in memory for a prediction, or as a copy of the folder with the numbers replaced."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel
from ruamel.yaml import YAML

from pywet import config as settings
from pywet.config import Config
from pywet.errors import PywetError
from pywet.evidence.accuracy.knobs import KNOBS, Level
from pywet.files import atomic_write

Levels = Mapping[str, Level]
Entry = TypeVar("Entry", bound=BaseModel)


def put(entry: Entry, value: float) -> Entry:
    """An entry of the configuration with another value."""
    return entry.model_copy(update={"value": value})


def law_names(level: str) -> dict[str, str | None]:
    """Fields of the configuration's laws for a level of the capillary knob."""
    exact = level == "exact"
    own = {"preset": "exact", "capillary": None} if exact else {"preset": "paper", "capillary": level}
    return {**own, "rupture": None, "transfer": None}


def shown(knob: str, level: Level) -> str:
    """A level as it stands in the configuration, with its place."""
    if knob == "capillary":
        text = "laws: {preset: exact}" if level == "exact" else f"laws: {{preset: paper, capillary: {level}}}"
        return f"{text}   (config.yaml)"
    file, _, key = KNOBS[knob].place.partition(": ")
    return f"{key} = {level}   ({file})"


def changed(config: Config, scale: str, levels: Levels) -> Config:
    """The configuration with these levels, in memory."""
    now = config.settings
    step, laws, own = now.time_step, now.laws, config.scale(scale)
    if "fraction" in levels:
        step = step.model_copy(update={"fraction": put(step.fraction, float(levels["fraction"]))})
    if "integration" in levels:
        step = step.model_copy(update={"viscous_integration": levels["integration"]})
    if "bridges_every" in levels:
        step = step.model_copy(update={"bridges_every": int(levels["bridges_every"])})
    if "capillary" in levels:
        laws = laws.model_copy(update=law_names(str(levels["capillary"])))
    if "stiffness" in levels:
        own = own.model_copy(update={"stiffness_factor": put(own.stiffness_factor, float(levels["stiffness"]))})
    if "wire_sides" in levels:
        own = own.model_copy(update={"wire_sides": put(own.wire_sides, int(levels["wire_sides"]))})
    scales = config.scales.model_copy(update={"scales": {**config.scales.scales, scale: own}})
    return replace(config, settings=now.model_copy(update={"time_step": step, "laws": laws}), scales=scales)


def new_folder(target: Path) -> None:
    """Refuse a folder that something would be lost in."""
    if target.exists() and (not target.is_dir() or any(target.iterdir())):
        what = "not empty" if target.is_dir() else "a file"
        raise PywetError(f"{target} is {what}; expected a new folder for the configuration: name another")


def write(source: Path, target: Path, scale: str, levels: Levels, more: Mapping[str, Any] | None = None) -> None:
    """Copy a configuration folder and put the levels in, and `more` as `put_into` takes it."""
    new_folder(target)
    target.mkdir(parents=True, exist_ok=True)
    for name in settings.FILES:
        shutil.copyfile(source / name, target / name)
    places = {
        "fraction": "config.yaml: time_step fraction value",
        "integration": "config.yaml: time_step viscous_integration",
        "bridges_every": "config.yaml: time_step bridges_every",
        "stiffness": f"scales.yaml: scales {scale} stiffness_factor value",
        "wire_sides": f"scales.yaml: scales {scale} wire_sides value",
    }
    values: dict[str, Any] = {places[knob]: level for knob, level in levels.items() if knob in places}
    if "capillary" in levels:
        values |= {f"config.yaml: laws {key}": law for key, law in law_names(str(levels["capillary"])).items()}
    put_into(target, {**values, **(more or {})})


def put_into(folder: Path, values: Mapping[str, Any]) -> None:
    """Put entries into the files of a configuration; comments and the order of keys stay.

    An entry is named by its file and the path to it, `config.yaml: time_step fraction value`; None takes it away.
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
                entry = entry.setdefault(key, {})
            entry.pop(last, None) if value is None else entry.update({last: value})
        with atomic_write(folder / file) as temporary:
            yaml.dump(content, temporary)
