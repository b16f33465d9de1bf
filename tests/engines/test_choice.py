"""Which engines there are is asked in tests of what uses them; here: ranks are what was asked for."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from pywet.engines.choice import refuse_fewer_cores
from pywet.engines.process import start_again, surroundings
from pywet.errors import PywetError


@pytest.mark.parametrize(
    ("ranks", "threads", "of_slurm", "words"),
    [
        (
            4,
            2,
            None,
            "ranks is 4, but Snakemake gives this job 2 cores; expected as many: call it with --cores 4 or more",
        ),
        (2, 1, None, "gives this job 1 core; "),
        (4, 1, "2", "gives this job 2 cores"),  # SLURM's own answer, where Snakemake looks at another machine
        (4, 4, None, None),
        (4, 1, "4", None),
        (1, 1, None, None),
    ],
)
def test_fewer_cores_than_ranks_are_refused(
    monkeypatch: pytest.MonkeyPatch, ranks: int, threads: int, of_slurm: str | None, words: str | None
) -> None:
    """Snakemake caps the cores of a job at those that it sees, and says nothing."""
    monkeypatch.delenv("SLURM_CPUS_PER_TASK", raising=False)
    if of_slurm:
        monkeypatch.setenv("SLURM_CPUS_PER_TASK", of_slurm)
    if words is None:
        refuse_fewer_cores(ranks, threads)
    else:
        with pytest.raises(PywetError, match=re.escape(words)):
            refuse_fewer_cores(ranks, threads)


@pytest.mark.parametrize("python", [False, True])
def test_memory_in_huge_pages_unless_the_user_says_otherwise(monkeypatch: pytest.MonkeyPatch, python: bool) -> None:
    monkeypatch.delenv("GLIBC_TUNABLES", raising=False)
    assert surroundings(python)["GLIBC_TUNABLES"] == "glibc.malloc.hugetlb=1"
    monkeypatch.setenv("GLIBC_TUNABLES", "glibc.malloc.hugetlb=0")
    assert surroundings(python)["GLIBC_TUNABLES"] == "glibc.malloc.hugetlb=0"


def test_an_engine_without_checkpoints_says_that_it_starts_again(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """One sentence where a stopped run is found, none for a new folder."""
    folder = tmp_path / "engine.partial"
    start_again(folder, "YADE")
    assert not caplog.records
    folder.mkdir()
    start_again(folder, "YADE")
    assert caplog.messages == [
        f"{folder} holds a run in YADE that was stopped; YADE has no checkpoints: it starts again"
    ]
