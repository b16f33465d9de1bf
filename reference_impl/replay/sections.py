"""Sections of a replay next to the logs: the scene compared with its configuration, the results with the logs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from reference_impl.diagnosis.held import Section
from reference_impl.scene import check as scene
from reference_impl.scene import configuration
from reference_impl.tables import check as results

PREDICTED = "scene_plan"
"""Numbers of effects, by which a run only says what it expects."""


def any_there(folder: Path) -> bool:
    """Return whether a run has a configuration or results that can be checked."""
    return (folder / configuration.FILE).exists() or results.there(folder)


def check(folder: Path) -> list[Section]:
    """Check the sections `scene` and `results` of a run."""
    return [scene.check(folder), results.check(folder)]


def add(result: dict[str, Any], sections: list[Section]) -> None:
    """Put the sections into a result of the replay: quantities, verdict, findings, what was and was not compared.

    Findings of the inputs come before those of the logs, findings of results and predictions after them.
    """
    for section in sections:
        result[section.name] = section.as_dict()
        result["quantities"] |= {q.name: q.as_dict() for q in section.quantities}
        result["not_checked"] = [*result["not_checked"], *section.not_checked]
    result["ok"] = result["ok"] and all(q.ok for section in sections for q in section.quantities)
    result["notes"] = [*result["notes"], *(section.sentence for section in sections)]
    if any(section.findings for section in sections):
        logs = result["diagnosis"] or {"findings": [], "follow": [], "not_explained": []}
        every = [f for section in sections for f in section.findings]
        before = [f for f in every if f["where"] == "scene" and PREDICTED not in f["quantities"]]
        after = [f for f in every if f not in before]
        result["diagnosis"] = {**logs, "findings": [*before, *logs["findings"], *after]}
