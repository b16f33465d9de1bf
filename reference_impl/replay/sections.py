"""Sections of a replay next to the logs: the scene compared with its configuration, the results with the logs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from reference_impl.diagnosis.held import Section
from reference_impl.scene import check as scene
from reference_impl.scene import configuration
from reference_impl.tables import check as results


def any_there(folder: Path) -> bool:
    """Return whether a run has a configuration or results that can be checked."""
    return (folder / configuration.FILE).exists() or results.there(folder)


def check(folder: Path) -> list[Section]:
    """Check the sections `scene` and `results` of a run."""
    return [scene.check(folder), results.check(folder)]


def add(result: dict[str, Any], sections: list[Section]) -> None:
    """Add the sections to a result of the replay: quantities, verdict, findings, what was and was not compared."""
    findings = [finding for section in sections for finding in section.findings]
    for section in sections:
        result[section.name] = section.as_dict()
        result["quantities"] |= {q.name: q.as_dict() for q in section.quantities}
        result["not_checked"] = [*result["not_checked"], *section.not_checked]
    result["ok"] = result["ok"] and all(q.ok for section in sections for q in section.quantities)
    result["notes"] = [*result["notes"], *(section.sentence for section in sections)]
    if findings:
        logs = result["diagnosis"] or {"findings": [], "follow": [], "not_explained": []}
        result["diagnosis"] = {**logs, "findings": [*findings, *logs["findings"]]}
