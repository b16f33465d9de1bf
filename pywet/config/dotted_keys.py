"""Dotted keys in the content of a file, such as `bodies.0.radius_m`: axes of a sweep, parameters of a calibration."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any

from pywet.errors import ConfigError


def dotted(key: str) -> str:
    """A key as a dotted path; that of the configuration editor, `materials.yaml: feed sieve_diameter_mm value`, as well.

    >>> dotted("materials.yaml: feed sieve_diameter_mm value"), dotted("friction")
    ('materials.feed.sieve_diameter_mm.value', 'friction')
    """
    file, found, path = key.partition(".yaml: ")
    return ".".join([file, *path.split()]) if found else key


def filled(content: dict[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy with other values at dotted paths; the values are checked when the content is read."""
    changed = copy.deepcopy(content)
    for key, value in values.items():
        _put(changed, key, value)
    return changed


def holds(content: Any, key: str) -> bool:
    """Return whether a dotted path exists in a content.

    >>> holds({"bodies": [{"radius_m": 1e-3}]}, "bodies.0.radius_m"), holds({"bodies": []}, "bodies.0.radius_m")
    (True, False)
    """
    try:
        for part in key.split("."):
            content = content[_index(content, part, key)]
    except (ConfigError, KeyError, TypeError):
        return False
    return True


def _put(content: Any, key: str, value: Any) -> None:
    """Set a value at a path. An entry with a source gets another `value` (or `material`); a last key may be new."""
    *path, last = key.split(".")
    for part in path:
        index = _index(content, part, key)
        if isinstance(content, dict):
            content.setdefault(index, {})
        content = content[index]
        if not isinstance(content, dict | list):
            raise ConfigError(
                f"the axis {key} leads into {part}, which is {content!r}; expected the key of a value",
                code="sweep.axis_in_value", key=f"axes.{key}", given=content,
            )  # fmt: skip
    index = _index(content, last, key)
    there = content[index] if isinstance(content, list) else content.get(index)
    if isinstance(there, dict) and {"value", "material"} & there.keys() and "source" in there:
        there["value" if "value" in there else "material"] = value
    elif isinstance(there, dict | list) and type(value) is not type(there):
        inside = ", ".join(map(str, there if isinstance(there, dict) else range(len(there))))
        raise ConfigError(
            f"the axis {key} is a group of keys; expected one value: {key}.X with X of {inside}",
            code="sweep.axis_group", key=f"axes.{key}",
        )  # fmt: skip
    else:
        content[index] = value


def _index(content: Any, part: str, key: str) -> Any:
    """Return the key of a group; for a list the index of an entry from 0, given by number or by `name`."""
    if not isinstance(content, list):
        return part
    names = [entry.get("name") if isinstance(entry, dict) else None for entry in content]
    if part in names:
        return names.index(part)
    if not part.isdecimal() or int(part) >= len(content):
        known = ", ".join(str(name) for name in names if name is not None)
        raise ConfigError(
            f"the axis {key} names {part} of a list with {len(content)} entries; expected 0 to {len(content) - 1}"
            f"{f' or one of {known}' if known else ''}",
            code="sweep.axis_entry", key=f"axes.{key}", given=part,
        )  # fmt: skip
    return int(part)
