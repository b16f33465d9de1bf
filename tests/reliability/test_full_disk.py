"""A disk full from a stage on, in each stage of a run: one sentence, nothing that was computed lost, and the run resumes."""

from __future__ import annotations

import contextlib
import importlib
import os
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from pywet.report import movie
from tests.error_codes import raises_code
from tests.reliability.kills import assert_same, tables_of
from tests.reliability.test_pairs import SIMULATES, call, finished, forked, given

__all__ = ["finished", "given"]
"""Fixtures: a finished moist run, and the files that commands are given."""
RUN = SIMULATES["run-scene A"]
BEFORE_TABLES = ("prepare", "simulate", "collect")
STAGES: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "prepare": ("pywet.cases.custom.building", "write", RUN),
    "simulate": ("pywet.engines.liggghts.driver", "simulate", RUN),
    "collect": ("pywet.engines.liggghts.collecting", "make", RUN),
    "results": ("pywet.cases.custom.results", "write", RUN),
    "replay": ("pywet.stages", "replay", RUN),
    "time series": ("pywet.report.vtk", "write", RUN),
    "picture": ("pywet.report.render", "write", RUN),
    "page": ("pywet.report.scene_page", "write", RUN),
    "end": ("pywet.cli.ending", "show", RUN),
    "replay alone": ("reference_impl.replay.command", "outcome", ("replay", "{run}")),
    "view": ("pywet.report.vtk", "write", ("view", "{run}")),
    "movie": ("pywet.report.movie", "write", ("view", "{run}", "--movie")),
    "vtkhdf": ("pywet.report.vtkhdf", "write", ("view", "{run}", "--vtkhdf")),
    "ovito": ("pywet.report.ovito", "write", ("view", "{run}", "--ovito")),
    "paraview": ("pywet.report.vtk", "write", ("view", "{run}", "--paraview")),
    "close-up": ("pywet.report.closeup", "write", ("view", "{run}", "--close-up", "1")),
    "report": ("pywet.report.scene_page", "of_run", ("report", "{run}")),
}


@contextlib.contextmanager
def small_disk(folder: Path, size: str = "40m") -> Iterator[Path]:
    folder.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder], capture_output=True).returncode:
        pytest.skip("only root can mount a small disk")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", folder], check=True)


def fill(disk: Path, left: int) -> None:
    """Take all of the disk but some bytes."""
    with open(disk / "filler", "wb", buffering=0) as file, contextlib.suppress(OSError):
        while True:
            file.write(bytes(4096))
    os.truncate(disk / "filler", max(0, (disk / "filler").stat().st_size - left))


def full_from(module: Any, name: str, disk: Path, left: int) -> None:
    """Let the disk be full from the call of a function on."""
    whole: Callable[..., Any] = getattr(module, name)

    def late(*words: Any, **named: Any) -> Any:
        setattr(module, name, whole)
        fill(disk, left)
        return whole(*words, **named)

    setattr(module, name, late)


def names(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*")}


@pytest.mark.engine
@pytest.mark.parametrize(
    ("stage", "left"),
    [("results", 8192), *(pytest.param(stage, left, marks=pytest.mark.slow) for stage in STAGES for left in (0, 8192))],
)
def test_a_full_disk(given: dict[str, str], finished: Path, tmp_path: Path, stage: str, left: int) -> None:
    """The sentence is the last line, before which there are progress and notices; files of before and of a user's are there."""
    module, name, words = STAGES[stage]
    with small_disk(tmp_path / "disk") as disk:
        run = disk / "run"
        shutil.copytree(finished, run) if stage not in BEFORE_TABLES else run.mkdir()
        named = given | {"run": str(run)}

        def struck() -> dict[str, Any]:
            full_from(importlib.import_module(module), name, disk, left)
            return call(words, named)

        answer = forked(struck, tmp_path / "answer.json")
        lines = answer["said"].strip().splitlines()
        assert answer["code"] in (1, 2) and "Traceback" not in answer["said"], answer
        assert "space" in lines[-1] or "free space on the disk" in lines[-1], lines
        assert not any("could not" in line or "cannot" in line for line in lines[:-1]), lines
        if stage not in BEFORE_TABLES:
            assert_same(tables_of(finished), tables_of(run))
        (disk / "filler").unlink()
        again = forked(lambda: call(words, named), tmp_path / "answer.json")
        assert again["code"] == 0, again
        assert_same(tables_of(finished), tables_of(run))
        assert names(finished) <= names(run) and not [n for n in names(run) if ".partial" in n]


def test_a_movie_cut_off_by_a_full_disk_is_not_given_its_name(tmp_path: Path) -> None:
    """ffmpeg ends without a word where its file has no end: the earlier movie stays."""
    noise = np.random.default_rng(1)
    pictures = [Image.fromarray(noise.integers(0, 256, (64, 96, 3), dtype=np.uint8)) for _ in range(48)]
    with small_disk(tmp_path / "disk", "128k") as disk:
        (disk / "movie.mp4").write_text("of an earlier run")
        with raises_code("movie.cut_off"):
            movie._mp4(pictures, disk / "movie.mp4")
        assert os.listdir(disk) == ["movie.mp4"] and (disk / "movie.mp4").read_text() == "of an earlier run"
    assert movie._mp4(pictures[:3], tmp_path / "movie.mp4").stat().st_size > 1000
