"""Progress messages of the logger `pywet`, separate from the answer of a command.

A program that uses pywet may show or drop them; the command line shows them on standard error, the workflow's scripts
write them into the log of their job.
"""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

notice = logging.getLogger("pywet")
notice.setLevel(logging.INFO)
LINE_S, LINE_SHARE = 10.0, 0.05
"""Least time between two progress messages in a log file [s], and the same relative to the time since the start."""


@contextmanager
def shown() -> Iterator[None]:
    """Show notices on standard error, by rich in a terminal."""
    handler: logging.Handler = logging.StreamHandler()
    if sys.stderr.isatty():
        from rich.console import Console
        from rich.logging import RichHandler

        console = Console(stderr=True, highlight=False)
        handler = RichHandler(console=console, show_time=False, show_level=False, show_path=False)
    handler.setFormatter(logging.Formatter("%(message)s"))
    notice.addHandler(handler)
    try:
        yield
    finally:
        notice.removeHandler(handler)


@contextmanager
def bar(title: str) -> Iterator[Callable[..., None]]:
    """Show a progress bar on standard error, visible from its first update on.

    Updates have `done`, the total (1.0), and a new title. If standard error is no terminal, as for a log file,
    notices are printed occasionally.
    """
    if not sys.stderr.isatty():
        yield _line_mover(title)
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True, highlight=False), transient=True) as drawn:
        task = drawn.add_task(title, total=None, visible=False)

        def move(done: float, total: float = 1.0, title: str = title) -> None:
            drawn.update(task, completed=done, total=total, description=title, visible=True)

        yield move


def _line_mover(title: str) -> Callable[..., None]:
    """Report progress by notices at least `LINE_S` apart, less frequently the longer the work takes."""
    started = latest = time.monotonic()

    def move(done: float, total: float = 1.0, title: str = title) -> None:
        nonlocal latest
        now = time.monotonic()
        if done <= 0.0 or now - latest < max(LINE_S, LINE_SHARE * (now - started)):
            return
        latest, left = now, (now - started) * (total - done) / done
        count = f"{done:g} of {total:g}" if total > 1.0 else f"{100.0 * done:.0f} %"
        notice.info(f"{title}: {count} after {now - started:.0f} s, about {left:.0f} s to go")

    return move
