"""Notices are for people at work: shown where asked for, apart from answers, and dropped elsewhere."""

from __future__ import annotations

import subprocess
import sys

import pytest

from pywet.util.notices import notice, shown


def test_shown_on_standard_error_and_only_while_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    notice.info("before")
    with shown():
        notice.info("while")
    notice.info("after")
    said = capsys.readouterr()
    assert (said.out, said.err) == ("", "while\n")


def test_a_program_that_shows_nothing_still_hears_of_warnings() -> None:
    text = "from pywet.util.notices import notice; notice.info('a tenth is done'); notice.warning('begins anew')"
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("", "begins anew\n")
