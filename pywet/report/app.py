"""Show runs side by side in a browser on this machine: one page on a local server.

The page holds the report's scene (`browser.py`) twice, with one slider; the standard library serves it. trame or panel would draw
in Python and keep a connection for every turn of the scene; here nothing is left to do once the page is read.
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
    """The page of these runs; of more than two, which two are seen is chosen in it."""
    runs = [(str(folder), RunDir(Path(folder))) for folder in run_dirs]
    scene = page.Section("Side by side" if len(runs) > 1 else "Scene", browser.element(runs, SIDE_BY_SIDE))
    return page.text("pywet", "One time and one camera for all that is shown.", [scene])


class Page(BaseHTTPRequestHandler):
    """Gives the server's page to whoever asks for it by the name of this machine: no site's name can be made to point here."""

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
        """Say nothing of what was asked."""


class Server(ThreadingHTTPServer):
    """Serves one page on the loopback interface."""

    def __init__(self, text: str, port: int = 0) -> None:
        self.body = text.encode()
        super().__init__((HOST, port), Page)

    @property
    def address(self) -> str:
        """Address that a browser opens to show the runs."""
        return f"http://{HOST}:{self.server_port}/"
