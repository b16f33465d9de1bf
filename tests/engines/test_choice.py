"""Which engines there are is asked in tests of what uses them; here: ranks are what was asked for."""

from __future__ import annotations

from pathlib import Path

import pytest

from pywet.engines.choice import refuse_fewer_cores
from pywet.engines.pipeline import Job, simulate
from pywet.engines.process import surroundings
from pywet.engines.run_store import RunStore
from pywet.run_folder import alone
from tests.cases.screening import synthetic
from tests.error_codes import raises_code
from tests.reliability.kills import Stopped


@pytest.mark.parametrize(
    ("ranks", "threads", "of_slurm", "cores"),
    [
        (4, 2, None, 2),
        (2, 1, None, 1),
        (4, 1, "2", 2),  # SLURM's value for the job, not that of the submitting machine
        (4, 4, None, None),
        (4, 1, "4", None),
        (1, 1, None, None),
    ],
)
def test_fewer_cores_than_ranks_are_refused(
    monkeypatch: pytest.MonkeyPatch, ranks: int, threads: int, of_slurm: str | None, cores: int | None
) -> None:
    """Snakemake caps the cores of a job at those that it sees, and says nothing."""
    monkeypatch.delenv("SLURM_CPUS_PER_TASK", raising=False)
    if of_slurm:
        monkeypatch.setenv("SLURM_CPUS_PER_TASK", of_slurm)
    if cores is None:
        refuse_fewer_cores(ranks, threads)
    else:
        with raises_code("engine.few_cores", given=ranks, expected=cores):
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

    def stop(_: Path) -> None:
        raise Stopped

    folder = tmp_path / "engine.partial"
    job = Job(synthetic.scene(), RunStore(tmp_path, ""), "YADE", "2023", None)
    for expected in (0, 1):
        with pytest.raises(Stopped), alone(tmp_path):
            simulate(job, stop, (), code="yade.stopped")
        assert len(caplog.records) == expected
        folder.mkdir(exist_ok=True)
    assert caplog.messages == [
        f"{folder} holds a run in YADE that was stopped; YADE has no checkpoints: it starts again"
    ]
