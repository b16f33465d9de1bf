"""Chosen settings into a configuration: in memory for a prediction, or as a copy of the folder with the numbers replaced."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

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


def write(source: Path, target: Path, scale: str, levels: Levels) -> None:
    """Copy a configuration folder and put the levels in; comments and the order of keys stay."""
    new_folder(target)
    target.mkdir(parents=True, exist_ok=True)
    for name in settings.FILES:
        shutil.copyfile(source / name, target / name)
    yaml = YAML()
    yaml.preserve_quotes, yaml.width = True, 10_000
    main, scales = ((yaml.load(target / name)) for name in ("config.yaml", "scales.yaml"))
    if "fraction" in levels:
        main["time_step"]["fraction"]["value"] = levels["fraction"]
    if "integration" in levels:
        main["time_step"]["viscous_integration"] = levels["integration"]
    if "bridges_every" in levels:
        main["time_step"]["bridges_every"] = levels["bridges_every"]
    if "capillary" in levels:
        laws = main.setdefault("laws", {})
        for key, law in law_names(str(levels["capillary"])).items():
            laws.pop(key, None) if law is None else laws.update({key: law})
    for knob, key in (("stiffness", "stiffness_factor"), ("wire_sides", "wire_sides")):
        if knob in levels:
            scales["scales"][scale][key]["value"] = levels[knob]
    for name, content in (("config.yaml", main), ("scales.yaml", scales)):
        with atomic_write(target / name) as temporary:
            yaml.dump(content, temporary)
