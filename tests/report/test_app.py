"""`pywet app`: two runs with one time, seen in a real browser, and sent nowhere else."""

from __future__ import annotations

import threading
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from pywet.report import app
from tests.cases.screening import synthetic


@pytest.fixture
def server(tmp_path: Path) -> Iterator[app.Server]:
    """A moist run next to a dry one."""
    runs = [synthetic.make(tmp_path / name, moist=name == "moist") for name in ("moist", "dry")]
    with app.Server(app.html(runs)) as made:
        thread = threading.Thread(target=made.serve_forever)
        thread.start()
        yield made
        made.shutdown()
        thread.join()


def test_only_requests_by_the_name_of_this_machine_are_answered(server: app.Server) -> None:
    assert server.server_address[0] == "127.0.0.1"
    assert b'class="viewer"' in urllib.request.urlopen(server.address).read()
    for path, host, code in (("", "elsewhere.example", 403), ("etc/passwd", None, 404)):
        asked = urllib.request.Request(server.address + path, headers={"Host": host} if host else {})
        with pytest.raises(urllib.error.HTTPError) as refused:
            urllib.request.urlopen(asked)
        assert refused.value.code == code


def test_two_runs_go_side_by_side_in_time(server: app.Server, tab: Any) -> None:
    tab.goto(server.address)
    tab.wait_for_selector(".viewer[data-ready]")
    boxes = [tab.locator("canvas").nth(k).bounding_box() for k in (0, 1)]
    assert boxes[0]["y"] == boxes[1]["y"] and boxes[0]["x"] + boxes[0]["width"] <= boxes[1]["x"]
    tab.focus(".time")
    tab.keyboard.press("End")
    frames = tab.evaluate("document.querySelector('.viewer').panels.map((panel) => [panel.run.name, panel.frame])")
    assert [(Path(name).name, frame) for name, frame in frames] == [("moist", 2), ("dry", 2)]
    # the fraction retained of both, liquid in bridges of the moist one; a tenth of the mass is in the bin at the second output
    assert [tab.locator(".charts svg").nth(k).locator("polyline").count() for k in (0, 1)] == [2, 1]
    tab.keyboard.press("ArrowLeft")
    heights = [float(tab.locator(".charts svg circle").nth(k).get_attribute("cy")) for k in (0, 1)]
    assert heights == pytest.approx([122 - 96 * 0.9] * 2, abs=0.1)
    assert tab.messages == []
