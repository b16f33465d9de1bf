"""Whole runs of which a file is damaged: the replay agrees, disagrees or says what it cannot read; never a fault of its own."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from reference_impl.replay import command
from tests.reference_impl import newton_scenes
from tests.reliability.mangled import mangled
from tests.reliability.test_fuzzed_files import named

BESIDE = (".engine.lock", ".pywet-run", "replay.json", "contributions.json", "output.log", "log.liggghts")
"""What the replay does not read."""
FEW = (8, 54, 176, 234)
"""Seeds: a script that is not UTF-8, a cut table of springs, a corner at 1e308 m, a type without its radius."""
LIMIT_S = 300
"""A disagreement is diagnosed, which takes some ten times as long as the replay."""


@pytest.mark.engine
@pytest.mark.parametrize("seeds", [FEW, pytest.param(range(1000), marks=pytest.mark.slow)], ids=["few", "thousand"])
def test_a_run_with_a_damaged_file_is_replayed_or_refused(seeds: range | tuple[int, ...], tmp_path: Path) -> None:
    run = newton_scenes.moist_bed(tmp_path / "bed")
    assert command.outcome(run)["status"] == "agrees"
    sound = {p: p.read_bytes() for p in run.rglob("*") if p.is_file() and p.name not in BESIDE}
    paths, ends = sorted(sound), Counter[str]()
    for seed in seeds:
        path = paths[seed % len(paths)]
        path.write_bytes(mangled(sound[path], seed, path.suffix))
        with named(f"seed {seed}, {path.relative_to(run)}", LIMIT_S):
            found = command.outcome(run)
        assert (found["reason"] or "-").isprintable() and (found["status"] == "unreadable") == bool(found["reason"])
        ends[found["status"]] += 1
        path.write_bytes(sound[path])
    print(f"whole runs: {sum(ends.values())} with a damaged file:", dict(ends))
    assert sum(ends.values()) == len(seeds) and ends["unreadable"]
