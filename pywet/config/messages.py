"""Turn a pydantic validation error into sentences, one for each mistake: file, key, what was given, what was expected."""

from __future__ import annotations

import difflib
import re
import reprlib
import types
import typing
from typing import Any

from pydantic import BaseModel, ValidationError

from pywet.errors import ConfigError, one_line
from pywet.util.ranges import comma

Loc = tuple[int | str, ...]


LITTLE = reprlib.Repr()
LITTLE.maxlist = LITTLE.maxtuple = LITTLE.maxdict = LITTLE.maxstring = LITTLE.maxother = LITTLE.maxlong = 100
LITTLE.maxlevel = 4
PAGES = {"Scene": "scene_reference", "Query": "bridge"}
"""Model of a file -> documentation page with its keys; for the files of config/ `configuration_reference`."""
MOST = 20
"""Largest number of mistakes listed; a file of another kind has hundreds."""


def mistake(error: ValidationError, model: type[BaseModel], where: str, given: Any = None) -> ConfigError:
    """Format one line per error, misspelt keys first; a missing key that a misspelt one explains is not reported.

    `given`: the data, in which mistakes are found that others hide.
    """
    problems: list[Any] = sorted(every(error, model, given), key=lambda p: p["type"] != "extra_forbidden")
    meant = {(*p["loc"][:-1], _meant(p, problems, model)) for p in problems if p["type"] == "extra_forbidden"}
    # a list that contains an invalid entry is reported as too short as well
    inside = {p["loc"][:n] for p in problems for n in range(len(p["loc"]))}
    reported = [p for p in problems if p["loc"] not in {"missing": meant, "too_short": inside}.get(p["type"], ())]
    lines = [f"{where}: {_sentence(p, problems, model)}" for p in reported[:MOST]]
    if len(reported) > MOST:
        lines.append(f"{where}: {len(reported) - MOST} more mistakes like these")
    if any(p["type"] in ("extra_forbidden", "missing") for p in reported):
        page = PAGES.get(model.__name__, "configuration_reference")
        lines[-1] += f" (all keys: pywet docs {page})"
    return ConfigError("\n".join(lines), file=where, **_data(problems[0], problems, model))


def every(error: ValidationError, model: type[BaseModel], given: Any) -> list[Any]:
    """Return the errors of data, and those found without the wrong entries: a group is checked only if its entries are valid.

    Entries are removed, then the groups that need them; a group from which one was removed is not called inconsistent.
    """
    found: list[Any] = list(error.errors())
    current, removed = found, set[Loc]()
    while len(found) <= MOST and isinstance(given, dict) and all(isinstance(key, str) for key in given):
        wrong = {_full(p) for p in current}
        wrong = (wrong - removed or {_around(loc, removed) for loc in wrong}) - {()}
        if not wrong:
            break
        removed |= wrong
        for loc in wrong:
            given = _without(given, loc)
        try:
            BaseModel.__init__(model.__new__(model), **given)
            break
        except ValidationError as more:
            known, current = {(p["type"], _full(p)) for p in found}, more.errors()
            found += [p for p in current if (p["type"], _full(p)) not in known and not _follows(p, removed)]
    return found


def _around(loc: Loc, removed: set[Loc]) -> Loc:
    """Return the innermost group or list around a position that was not removed."""
    while loc and (loc in removed or isinstance(loc[-1], int)):
        loc = loc[:-1]
    return loc


def _full(problem: Any) -> Loc:
    """Return the position of a wrong entry, also if its group reports it."""
    context = problem.get("ctx", {})
    return (*problem["loc"], *(context["key"].split(".") if "key" in context else ()))


def _follows(problem: Any, removed: set[Loc]) -> bool:
    """Return whether an error may follow from the removal of entries: theirs, or that of a group around one."""
    loc = problem["loc"]
    return any(loc[: len(r)] == r or (problem["type"] == "value_error" and r[: len(loc)] == loc) for r in removed)


def _without(given: Any, loc: Loc) -> Any:
    """Copy data without the entry of a group at a position; as they are if there is none."""
    key, rest = (loc[0], loc[1:]) if loc else (None, ())
    if isinstance(given, dict) and key in given:
        return {k: _without(v, rest) if k == key else v for k, v in given.items() if rest or k != key}
    if isinstance(given, list | tuple) and isinstance(key, int) and key < len(given) and rest:
        return [*given[:key], _without(given[key], rest), *given[key + 1 :]]
    return given


CODES = {
    "extra_forbidden": "config.unknown_key", "missing": "config.missing_key", "value_error": "config.inconsistent",
    "implausible": "config.implausible", "switch": "config.switch",
}  # fmt: skip
"""Code for each kind of mistake; all others are `config.value`."""


def _data(problem: Any, problems: list[Any], model: type[BaseModel]) -> dict[str, Any]:
    """Return code and key of a mistake, the given value and the expected one."""
    kind, given, context = problem["type"], problem["input"], problem.get("ctx", {})
    key = ".".join(str(k) for k in (*problem["loc"], *([context["key"]] if "key" in context else [])))
    expected = str(context.get("expected") or problem["msg"].removeprefix("Value error, "))
    if kind == "extra_forbidden":
        expected = _meant(problem, problems, model)
    if kind == "missing":
        given, expected = None, _kind(model, problem["loc"])
    if kind == "value_error":
        given = None  # an error of a whole group
    return {
        "code": CODES.get(kind, "config.value"),
        "key": key,
        "given": context.get("value", given),
        "expected": expected,
    }


def _sentence(problem: Any, problems: list[Any], model: type[BaseModel]) -> str:
    loc: Loc = problem["loc"]
    key = one_line(".".join(str(k) for k in loc)) if loc else "the content"
    kind, given = problem["type"], _shown(problem["input"])
    if kind == "extra_forbidden" and problem["input"] is None and re.fullmatch(r"\d+([eE][-+]?\d+)?", str(loc[-1])):
        parent = ".".join(str(k) for k in loc[:-1])
        return f"{parent} has {loc[-1]} behind a comma, expected a number with a decimal point, such as 0.{loc[-1]}"
    if kind == "extra_forbidden":
        return f"key {key} is not known, expected {_meant(problem, problems, model)}"
    if kind == "missing":
        return f"key {key} is missing, expected {_kind(model, loc)}"
    if kind == "model_type":
        return f"{key} is {given}, expected {_kind(model, loc)}"
    if kind == "value_error":
        return f"{key} is not consistent, expected {problem['msg'].removeprefix('Value error, ')}"
    if kind in ("implausible", "switch"):
        message = problem["ctx"]
        key = ".".join(str(k) for k in (*loc, message["key"]))
        return f"{key} is {_shown(message['value'])}, expected {message.get('expected') or 'a number or text, not a switch'}"
    expected = one_line(problem["msg"].removeprefix("Input should be ").replace("Input should have", "to have"))
    return f"{key} is {given}{comma(problem['input'])}, expected {expected[0].lower()}{expected[1:]}"


def _shown(value: Any) -> str:
    """Shorten a given value to one line for a message."""
    text = one_line(LITTLE.repr(value))
    return text if len(text) <= 80 else f"{text[:79]}…"


def _meant(problem: Any, problems: list[Any], model: type[BaseModel]) -> str:
    """Return the likely intended key for an unknown one, missing ones next to it first; otherwise all keys."""
    group, given = problem["loc"][:-1], str(problem["loc"][-1])
    missing = [str(p["loc"][-1]) for p in problems if p["type"] == "missing" and p["loc"][:-1] == group]
    known = missing or list(getattr(_model_at(model, group), "model_fields", {}))
    close = difflib.get_close_matches(given, known, n=1, cutoff=0.4)
    return close[0] if close else "one of " + ", ".join(known)


def _kind(model: type[BaseModel], loc: Loc) -> str:
    """Describe the kind of value that a key expects: an entry, a group of keys, a value."""
    found = _model_at(model, loc)
    if found is None:
        return "a value"
    fields = found.model_fields
    if "source" in fields and "value" in fields:
        return "an entry such as {value: 1.0, source: assumption, reason: why}"
    if "source" in fields and "material" in fields:
        return "an entry such as {material: steel, source: assumption, reason: why}"
    return f"the keys {', '.join(fields)}"


def _model_at(model: type[BaseModel], loc: Loc) -> type[BaseModel] | None:
    """Return the model that describes position `loc` within `model`; None if there is none."""
    here: Any = model
    for step in loc:
        if isinstance(here, type) and issubclass(here, BaseModel):
            field = here.model_fields.get(str(step))
            here = _bare(field.annotation) if field is not None else None
        else:
            inner = [a for a in typing.get_args(here) if a is not Ellipsis]
            here = _bare(inner[-1]) if inner else None
    return here if isinstance(here, type) and issubclass(here, BaseModel) else None


def _bare(annotation: Any) -> Any:
    """Remove Annotated and None from an annotation of a type."""
    if typing.get_origin(annotation) is typing.Annotated:
        return _bare(typing.get_args(annotation)[0])
    if typing.get_origin(annotation) in (typing.Union, types.UnionType):
        stored = [a for a in typing.get_args(annotation) if a is not type(None)]
        return _bare(stored[0]) if len(stored) == 1 else None
    return annotation
