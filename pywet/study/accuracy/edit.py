"""Chosen settings into a configuration: in memory for a prediction, or as a copy of the folder with the numbers replaced."""

from __future__ import annotations

import re
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pywet import config as settings
from pywet.config import Config
from pywet.errors import PywetError
from pywet.files import atomic_write
from pywet.study.accuracy.knobs import KNOBS, Level
from pywet.study.accuracy.sieve import law_names, put

Levels = Mapping[str, Level]


def settings_of(levels: Levels, turned: Sequence[str]) -> dict[str, Level]:
    """The levels that are written: those of the knobs that may be turned."""
    return {knob: level for knob, level in levels.items() if knob in turned}


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
    """Copy a configuration folder and put the levels in, comments stay; raises `PywetError` when it does not read back."""
    new_folder(target)
    target.mkdir(parents=True, exist_ok=True)
    for name in settings.FILES:
        shutil.copyfile(source / name, target / name)
    main, scales = ((target / name).read_text() for name in ("config.yaml", "scales.yaml"))
    if "fraction" in levels:
        main = _entry(main, "fraction", levels["fraction"], "")
    if "integration" in levels:
        main = _bare(main, "viscous_integration", str(levels["integration"]), "time_step")
    if "bridges_every" in levels:
        main = _bare(main, "bridges_every", str(levels["bridges_every"]), "time_step")
    if "capillary" in levels:
        main = _laws(main, str(levels["capillary"]))
    for knob, key in (("stiffness", "stiffness_factor"), ("wire_sides", "wire_sides")):
        if knob in levels:
            scales = _entry(scales, key, levels[knob], scale)
    for name, text in (("config.yaml", main), ("scales.yaml", scales)):
        with atomic_write(target / name) as temporary:
            temporary.write_text(text)
    _check(source, target, scale, levels)


def _check(source: Path, target: Path, scale: str, levels: Levels) -> None:
    """What was written must read as what was chosen."""
    wanted, got = changed(settings.load(source), scale, levels), settings.load(target)
    same = wanted.scale(scale) == got.scale(scale) and wanted.settings.time_step == got.settings.time_step
    if not same or wanted.settings.laws != got.settings.laws:
        raise PywetError(
            f"the settings could not be put into {target}; put them into config.yaml and scales.yaml by hand"
        )


def _entry(text: str, key: str, value: Any, after: str) -> str:
    """Replace the value of the first entry `key: {value: …` after the line `  after:`."""
    start = 0
    if after:
        found = re.search(rf"^\s+{re.escape(after)}:\s*$", text, flags=re.MULTILINE)
        start = found.end() if found else 0
    head, tail = text[:start], text[start:]
    return head + re.sub(rf"(\b{key}:\s*\{{value:\s*)[^,}}]+", rf"\g<1>{value}", tail, count=1)


def _bare(text: str, key: str, value: str, section: str) -> str:
    """Replace a word after `key:`, or add it under its section."""
    if re.search(rf"^\s+{key}:", text, flags=re.MULTILINE):
        return re.sub(rf"(^\s+{key}:\s*)\S+", rf"\g<1>{value}", text, count=1, flags=re.MULTILINE)
    return re.sub(rf"(^{section}:.*\n)", rf"\g<1>  {key}: {value}\n", text, count=1, flags=re.MULTILINE)


def _laws(text: str, level: str) -> str:
    """The section laws with its preset, and a capillary law where one is named."""
    for key in ("capillary", "rupture", "transfer"):
        text = re.sub(rf"(?<=\n)  {key}: (?!auto|on\b|off\b)\S+.*\n", "", text)
    text = _bare(text, "preset", "exact" if level == "exact" else "paper", "laws")
    if level != "exact":
        text = re.sub(r"(^  preset:.*\n)", rf"\g<1>  capillary: {level}\n", text, count=1, flags=re.MULTILINE)
    return text
