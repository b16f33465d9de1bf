"""Compare every value in the configuration's files with the resolved copy from which the run was made.

`config_files.json` contains the text of config.yaml, materials.yaml, scales.yaml and cases.csv. They are parsed
independently here, including the case's row, its scale, its liquid.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from reference_impl.diagnosis.held import MISSING, Held
from reference_impl.replay.io import ReplayError

FILE = "config_files.json"
CONFIG, MATERIALS, SCALES, CASES = "config.yaml", "materials.yaml", "scales.yaml", "cases.csv"
NOT_OF_A_RUN = ("cases", "scale")
"""Keys of config.yaml that select runs."""
LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""YAML loader: the fast one if available."""
WORDS = ("material", "source", "liquid")
"""Columns of cases.csv that are not numerical."""


def of_run(folder: Path) -> dict[str, Any] | None:
    """Return the texts by file, and the values set after reading; None if the run contains none."""
    path = Path(folder) / FILE
    if not path.exists():
        return None
    try:
        found = json.loads(path.read_text())
        return {"files": {str(k): str(v) for k, v in found["files"].items()}, "set_later": list(found["set_later"])}
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise ReplayError(
            f"{path} cannot be read ({error!r}); expected the texts of the configuration: build the run again"
        ) from error


def held(texts: Mapping[str, Any], config: Mapping[str, Any]) -> list[Held]:
    """Return every value of the configuration files by its path in config.json."""
    files: Mapping[str, str] = texts["files"]
    try:
        data = {name: yaml.load(text, LOADER) for name, text in files.items() if name != CASES}
        row = _row(files[CASES], int(config["case"]["case"])) if CASES in files else dict(config["case"])
    except (yaml.YAMLError, csv.Error, StopIteration) as error:
        raise ReplayError(f"{FILE} cannot be parsed ({error!r}): build the run again") from error
    parts: list[tuple[str, str, Any]] = [(CASES, "case", row)] if CASES in files else []
    if MATERIALS in data:
        parts.append((MATERIALS, "materials", _with_liquid(data[MATERIALS], row.get("liquid"))))
    if SCALES in data:
        parts.append((SCALES, "apparatus", data[SCALES]["apparatus"]))
        scales = {str(name): scale for name, scale in data[SCALES]["scales"].items()}
        parts.append((SCALES, "scale", scales[config["scale"]["name"]]))
    if CONFIG in data:
        skipped = {*NOT_OF_A_RUN, *texts["set_later"]}
        parts.append((CONFIG, "settings", {k: v for k, v in data[CONFIG].items() if k not in skipped}))
    return [
        Held(f"{part}.{path}" if path else part, _at(config[part], path), value, f"{file}: {path}")
        for file, part, tree in parts
        for path, value in leaves(tree)
        if not _is_file(value)
    ]


def not_checked(texts: Mapping[str, Any]) -> list[str]:
    """List settings of a program or the command line, and files replaced in memory, which are not checked."""
    lost = [name for name in (CONFIG, MATERIALS, SCALES, CASES) if name not in texts["files"]]
    found = [f"scene: set after config.yaml was read: {', '.join(texts['set_later'])}"] if texts["set_later"] else []
    return found + ([f"scene: {', '.join(lost)}, replaced in memory"] if lost else [])


def _row(text: str, number: int) -> dict[str, Any]:
    """Return the case's row of cases.csv; empty cells count as not given."""
    rows = csv.DictReader(text.lstrip("\ufeff").splitlines(), skipinitialspace=True)
    row = next(r for r in rows if int(r["case"]) == number)
    return {k.strip(): (v if k.strip() in WORDS else float(v)) for k, v in row.items() if v}


def _with_liquid(materials: Mapping[str, Any], name: str | None) -> dict[str, Any]:
    """Return the materials with the case's liquid in place of the list of liquids."""
    chosen = materials["liquids"][name] if name and name in (materials.get("liquids") or {}) else materials["liquid"]
    return {**{k: v for k, v in materials.items() if k != "liquids"}, "liquid": chosen}


def leaves(tree: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Yield path and value of everything that is not a group."""
    if isinstance(tree, Mapping):
        for key, value in tree.items():
            yield from leaves(value, f"{path}.{key}" if path else str(key))
    elif isinstance(tree, list):
        for n, value in enumerate(tree):
            yield from leaves(value, f"{path}[{n}]")
    else:
        yield path, tree


def _at(tree: Any, path: str) -> Any:
    """Return the value at a path; a switch as YAML reads it."""
    for key in path.replace("[", ".[").split("."):
        try:
            tree = tree[int(key[1:-1])] if key.startswith("[") else tree[key]
        except (KeyError, IndexError, TypeError):
            return MISSING
    return {"on": True, "off": False}.get(tree, tree) if isinstance(tree, str) else tree


def _is_file(value: Any) -> bool:
    """Return whether a value names a law's file, which is looked up in the configuration's folder."""
    return isinstance(value, str) and ".py:" in value
