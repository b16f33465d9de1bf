"""Notices are for people at work: shown where asked for, apart from answers, and dropped elsewhere."""

from __future__ import annotations

import subprocess
import sys
from types import SimpleNamespace

import pytest

from pywet.engines import process
from pywet.util import notices
from pywet.util.notices import notice, shown
from tests.cases.screening import synthetic


def test_shown_on_standard_error_and_only_while_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    notice.info("before")
    with shown():
        notice.info("while")
    notice.info("after")
    output_text = capsys.readouterr()
    assert (output_text.out, output_text.err) == ("", "while\n")


def test_a_program_that_shows_nothing_still_hears_of_warnings() -> None:
    text = "from pywet.util.notices import notice; notice.info('a tenth is done'); notice.warning('starts again')"
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("", "starts again\n")


def test_a_log_file_has_lines_of_progress_and_no_bar(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Clock of its own: moves after 4, 12, 15 and 400 s; lines at least 10 s and a twentieth of the time apart."""
    clock = iter([0.0, 4.0, 12.0, 15.0, 400.0, 415.0])
    monkeypatch.setattr(notices, "time", SimpleNamespace(monotonic=lambda: next(clock)))
    with shown(), notices.bar("runs") as move:
        for done in (1, 2, 3, 20, 21):
            move(done, 24)
    assert capsys.readouterr().err.splitlines() == [
        "runs: 2 of 24 after 12 s, about 132 s to go",
        "runs: 20 of 24 after 400 s, about 80 s to go",
    ]


def test_the_remaining_time_is_that_of_the_steps_since_the_checkpoint(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """A tenth of the steps in a minute leaves four for four tenths; the output of a resumed engine is empty at first."""
    clock = iter([0.0, 0.1, 60.0, 61.0])
    monkeypatch.setattr(process, "time", SimpleNamespace(monotonic=lambda: next(clock)))
    with process.progress_bar(synthetic.scene(), True, 500) as report:
        for done in (0, 600, 1000):
            report(done, 1000)
    assert [text.partition(": ")[2].strip() for text in caplog.messages] == [
        "50 % after 0 s",
        "60 % after 60 s, about 240 s to go",
        "100 % after 61 s",
    ]
