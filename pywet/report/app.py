"""Show runs side by side in a browser on this machine: one page on a local server.

The page contains the report's scene (`browser.py`) twice, with one slider; the standard library serves it. trame or
panel would draw in Python and need a connection for every rotation of the scene; here the page needs no server once
loaded.
"""

from __future__ import annotations

from collections.abc import Sequence
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from pywet.report import browser, page
from pywet.runs.rundir import RunDir

HOST = "127.0.0.1"
SIDE_BY_SIDE = 2


def html(run_dirs: Sequence[Path]) -> str:
    """Return the page of these runs; for more than two, two of them are selected in the page."""
    runs = [(str(folder), RunDir(Path(folder))) for folder in run_dirs]
    scene = page.Section("Side by side" if len(runs) > 1 else "Scene", browser.element(runs, SIDE_BY_SIDE))
    return page.text("pywet", "One time and one camera for all that is shown.", [scene])


class Page(BaseHTTPRequestHandler):
    """Handler that serves the page only to requests by this machine's name, so that no web site's name can point here."""

    def do_GET(self) -> None:
        assert isinstance(self.server, Server)
        here = f":{self.server.server_port}"
        if self.headers.get("Host") not in (f"{HOST}{here}", f"localhost{here}"):
            self.send_error(403)
        elif self.path != "/":
            self.send_error(404)
        else:
            self.send_response(200)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.send_header("Content-Length", str(len(self.server.body)))
            self.end_headers()
            self.wfile.write(self.server.body)

    def log_message(self, format: str, *args: object) -> None:
        """Do not log requests."""


class Server(ThreadingHTTPServer):
    """Server of one page on the loopback interface."""

    def __init__(self, text: str, port: int = 0) -> None:
        self.body = text.encode()
        super().__init__((HOST, port), Page)

    @property
    def address(self) -> str:
        """Return the address at which a browser shows the runs."""
        return f"http://{HOST}:{self.server_port}/"
