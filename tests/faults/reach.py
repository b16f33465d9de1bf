"""Which lines of the program a run comes to: Python's by its own tracing, the plugin's by gcov."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

Lines = dict[str, set[int]]
"""File below the package -> lines."""
_open: list[Lines] = []
"""Those that are being looked at."""


@contextmanager
def traced(package: Path) -> Iterator[Lines]:
    """Lines of Python below `package` that are executed meanwhile, those of what is imported again included."""
    lines: Lines = {}
    _open.append(lines)
    start = f"{package}/"

    def look(frame: FrameType, event: str, _: Any) -> Any:
        name = frame.f_code.co_filename
        if not name.startswith(start):
            return None
        of_file = lines.setdefault(name[len(start) :], set())
        of_file.add(frame.f_lineno)

        def line(inner: FrameType, what: str, _: Any) -> Any:
            of_file.add(inner.f_lineno)
            return line

        return line

    sys.settrace(look)
    threading.settrace(look)
    try:
        yield lines
    finally:
        sys.settrace(None)
        threading.settrace(None)  # type: ignore[arg-type]
        _open.remove(lines)


def keep(path: Path) -> None:
    """Write down what a copy of this process has come to, for that which it is a copy of."""
    sys.settrace(None)
    path.write_text(json.dumps([{name: sorted(numbers) for name, numbers in lines.items()} for lines in _open]))


def recorded(path: Path) -> Lines:
    """Return the lines that a forked copy of this process has recorded."""
    lines: Lines = {}
    for part in json.loads(path.read_text()):
        for name, numbers in part.items():
            lines.setdefault(name, set()).update(numbers)
    return lines


def counted(sources: Path, objects: Path) -> Lines:
    """Lines of the plugin that gcov counted; `objects` holds its notes and counters."""
    lines: Lines = {}
    for path in objects.glob("*.gcda"):
        output_text = subprocess.run(
            ["gcov", "-t", path.name], cwd=objects, capture_output=True, text=True, check=False
        ).stdout
        name = None
        for row in output_text.splitlines():
            count, number, text = [*row.split(":", 2), "", ""][:3]
            if source := re.match(r"Source:(.*)", text):
                name = Path(source.group(1)).name if Path(source.group(1)).parent == sources else None
            elif name and count.strip().rstrip("*").isdigit():
                lines.setdefault(f"engines/liggghts/plugin/{name}", set()).add(int(number))
    return lines
