"""The frame of the studies: what is stored is done once, what was cut off goes on, all of it becomes one table."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pywet.util import sources
from studies.study import Run, Study


@dataclass
class Squares(Study):
    """Squares of numbers, two a job; `done` says which were computed."""

    folder: Path
    power: int = 2
    stop_at: int | None = None
    done: list[int] = field(default_factory=list)

    def jobs(self) -> list[str]:
        return ["low", "high"]

    def runs(self, job: str) -> list[Run]:
        numbers = (1, 2) if job == "low" else (3, 4)
        return [Run(f"{job}/{n}", {"n": n, "power": self.power}, lambda n=n: self.row(n), {"n": n}) for n in numbers]

    def row(self, n: int) -> list[dict[str, Any]]:
        if n == self.stop_at:
            raise KeyboardInterrupt
        self.done.append(n)
        return [{"value": n**self.power}]

    def show(self) -> Path:
        self.page.write_text(self.gather().to_csv(index=False))
        return self.page


def test_a_study_that_was_cut_off_goes_on(tmp_path: Path) -> None:
    """Killed in its third run, damaged in its first: these and the last are done, and all are in the table."""
    with pytest.raises(KeyboardInterrupt):
        Squares(tmp_path / "squares", stop_at=3).carry_out()
    (tmp_path / "squares" / "runs" / "low" / "1.json").write_text('{"key"')
    again = Squares(tmp_path / "squares")
    assert [run.name for run in again.missing()] == ["low/1", "high/3", "high/4"]
    shares: list[float] = []
    again.carry_out(lambda name, share: shares.append(share))
    assert again.done == [1, 3, 4] and shares == [
        0.0,
        0.5,
        0.75,
    ]  # of what is left to do, from which the rest is estimated
    assert again.gather()[["n", "value"]].to_numpy().tolist() == [[1, 1], [2, 4], [3, 9], [4, 16]]
    assert again.page == tmp_path / "squares.html" and again.page.exists()


def test_a_run_is_done_again_where_it_would_be_another(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """After a change of its data, or of the code that runs or evaluates it."""
    Squares(tmp_path).do("low")
    cubes = Squares(tmp_path, power=3)
    assert cubes.gather().empty and len(cubes.missing()) == 4
    cubes.do("low")
    assert cubes.gather()["value"].tolist() == [1, 8]
    for digest in ("digest_of_a_run", "digest_of_evaluation"):
        monkeypatch.setattr(sources, digest, lambda digest=digest: digest)
        assert cubes.gather().empty and len(cubes.missing()) == 4
        cubes.do("low")
        assert len(cubes.missing()) == 2


def test_only_what_was_asked_for_is_forgotten(tmp_path: Path) -> None:
    study = Squares(tmp_path)
    study.carry_out()
    (tmp_path / "runs" / "other.json").touch()
    study.forget()
    assert len(study.missing()) == 4 and (tmp_path / "runs" / "other.json").exists()


def test_equal_runs_are_done_once_and_stand_twice_in_the_table(tmp_path: Path) -> None:
    class Comparisons(Squares):
        def runs(self, job: str) -> list[Run]:
            run = super().runs(job)[0]
            return [run, Run(run.name, run.given, run.make, {"n": 10 * run.labels["n"]})]

    comparisons = Comparisons(tmp_path)
    comparisons.do("low")
    assert comparisons.done == [1] and comparisons.gather(["low"])["n"].tolist() == [1, 10]


def test_a_number_that_is_not_finite_is_missing(tmp_path: Path) -> None:
    """JSON has no infinity; whole numbers, words and numbers come back as they were, to the last bit."""

    class Odd(Squares):
        def row(self, n: int) -> list[dict[str, Any]]:
            return [{"value": np.inf if n == 1 else 0.1 + 0.2, "count": n, "word": ""}]

    odd = Odd(tmp_path)
    odd.do("low")
    table = odd.gather(["low"])
    assert np.isnan(table["value"][0]) and table["value"][1] == 0.1 + 0.2
    assert table["count"].tolist() == [1, 2] and table["word"].tolist() == ["", ""]
