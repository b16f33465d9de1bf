"""Progress of a replay: in a log file a line at most every ten seconds."""

from __future__ import annotations

import pytest

from reference_impl.replay import io


def test_progress_without_a_terminal(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [0.0]
    monkeypatch.setattr(io.time, "monotonic", lambda: clock[0])
    monkeypatch.setattr(io, "_latest", 0.0)
    monkeypatch.setattr(io, "LINE_S", 10.0)
    for clock[0] in (1.0, 9.9, 10.1, 12.0, 20.2):
        io.note(f"events: {clock[0]:g}")
    assert capsys.readouterr().err.splitlines() == ["replay: events: 10.1", "replay: events: 20.2"]
