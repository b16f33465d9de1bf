"""Keys of config.yaml that `snakemake --config KEY=VALUE` may override; all others are refused in one sentence."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from pywet.config.messages import mistake
from pywet.config.settings import LawSettings, Settings
from pywet.errors import ConfigError

REPLACED = ("scale", "cases", "ranks", "both_presets", "seed", "seeds")


def chosen(configured: Settings, given: Mapping[str, Any]) -> Settings:
    """Settings with the overrides of the command line; `given` is the whole config.yaml with overrides.

    A single case is a list of one. Numbers in a list are given as text. Raises `PywetError` for a wrong value and
    for a key that cannot be overridden.
    """
    cases = given.get("cases")
    listed = list(cases) if isinstance(cases, list | tuple) else [cases]
    numbers = [int(str(case)) if str(case).isdecimal() else case for case in listed]
    try:
        found = Settings.model_validate({**given, "cases": numbers})
    except ValidationError as error:
        raise mistake(error, Settings, "--config") from error
    other = [name for name in Settings.model_fields if _text(found, name) != _text(configured, name)]
    for name in other:
        if name not in REPLACED:
            raise ConfigError(
                f"--config {name} was given, expected one of {', '.join(REPLACED)}: write {name} into config/config.yaml",
                code="config.not_on_command_line",
                key=name,
                expected=tuple(REPLACED),
            )
    return configured.model_copy(update={name: getattr(found, name) for name in REPLACED})


def _text(settings: Settings, name: str) -> object:
    """Return a setting in comparable form: without the folders of law files, which only `configured` contains in full."""
    value = getattr(settings, name)
    if not isinstance(value, LawSettings):
        return value
    named = value.model_dump()
    named |= {f"reference.{kind}": function for kind, function in named.pop("reference").items()}
    return {kind: str(law).rpartition("/")[2] for kind, law in named.items()}
