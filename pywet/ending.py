"""End a process early: by a signal, together with the process that started it."""

from __future__ import annotations

import ctypes
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

DEATH_SIGNAL = 1
"""Constant PR_SET_PDEATHSIG of prctl(2)."""
ASKED = (signal.SIGTERM, signal.SIGHUP)
"""Signals that request the end of a command, in addition to that of Ctrl-C."""


RESUMES = "what is written is whole: call it again, and a run resumes from its last checkpoint"


class Ended(KeyboardInterrupt):
    """Raised if a signal requests the end; handlers of Ctrl-C clean up after it as well. `left`: phrase on what is written."""

    def __init__(self, number: int, left: str = RESUMES) -> None:
        super().__init__(number)
        self.number, self.left = number, left

    @classmethod
    def of(cls, stop: KeyboardInterrupt) -> Ended:
        """Return an interrupt of either kind with the number of its signal."""
        return stop if isinstance(stop, Ended) else cls(signal.SIGINT)


def die_with_parent() -> None:
    """Let the kernel end this process when its parent has ended, so that no orphan continues to write."""
    ctypes.CDLL(None).prctl(DEATH_SIGNAL, signal.SIGKILL)


def _end(number: int, _: FrameType | None) -> None:
    for asked in ASKED:
        signal.signal(asked, signal.SIG_IGN)  # a second signal must not interrupt the clean-up
    raise Ended(number)


@contextmanager
def clearing_up() -> Iterator[None]:
    """Let SIGTERM and SIGHUP end the enclosed code as Ctrl-C does: engine included, and without temporary files.

    A signal that is ignored, such as SIGHUP under nohup, remains ignored.
    """
    main = threading.current_thread() is threading.main_thread()
    before = {s: signal.getsignal(s) for s in ASKED if main and signal.getsignal(s) == signal.SIG_DFL}
    for number in before:
        signal.signal(number, _end)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def message(given: str, stop: KeyboardInterrupt) -> tuple[str, int]:
    """Return the sentence and the exit code, as in shells, of a command that a signal ended."""
    ended = Ended.of(stop)
    name = signal.Signals(ended.number).name + (" (Ctrl-C)" if ended.number == signal.SIGINT else "")
    return f"{given}: ended by {name}; {ended.left}", 128 + ended.number
