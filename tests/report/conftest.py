"""The synthetic run, and a real browser, where there is one."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.cases.screening import synthetic

WITHOUT_GPU = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox", "--disable-dev-shm-usage"]
DRAWS = "Boolean(document.createElement('canvas').getContext('webgl2'))"


@pytest.fixture
def run(tmp_path: Path) -> Path:
    return synthetic.make(tmp_path / "case02")


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    """Debian's chromium without a window, drawing by software; tests that need it are skipped where it is not installed.

    Closed after each module: while it is open, its loop of events is the process's own, and no other can be run."""
    sync_api = pytest.importorskip("playwright.sync_api")
    program = shutil.which("chromium")
    if program is None:
        pytest.skip("chromium is not installed; `make peers` installs it from Debian")
    with sync_api.sync_playwright() as player:
        try:
            browser = player.chromium.launch(executable_path=program, args=WITHOUT_GPU)
            draws = browser.new_page().evaluate(DRAWS)
        except sync_api.Error as error:
            pytest.skip(f"chromium does not start here: {str(error).splitlines()[0]}")
        if not draws:
            browser.close()
            pytest.skip("chromium has no WebGL here")
        yield browser
        browser.close()


def wrong(message: Any) -> bool:
    """Return whether a line of the console is of the page, and not the drawing driver's word on its own speed."""
    return message.type in ("error", "warning") and "GL Driver Message" not in message.text


@pytest.fixture
def tab(chromium: Any) -> Iterator[Any]:
    """A tab whose `said` collects errors and whatever is asked of a network."""
    page = chromium.new_page(viewport={"width": 1000, "height": 800})
    page.set_default_timeout(120_000)
    page.messages = []
    page.on("console", lambda message: page.messages.append(message.text) if wrong(message) else None)
    page.on("pageerror", lambda error: page.messages.append(str(error)))
    page.on(
        "request",
        lambda request: page.messages.append(request.url) if page.url not in ("about:blank", request.url) else None,
    )
    yield page
    page.close()
