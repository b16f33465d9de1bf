"""Test a custom law in a child process, started by `custom_laws.py`, since a law may loop forever or end the program."""

from __future__ import annotations

import resource
import sys
from pathlib import Path

from pywet.errors import PywetError
from pywet.laws import custom_laws, registry
from pywet.util.files import write_json


def main() -> None:
    """Run the test as `python -m pywet.laws.trial KIND NAME ANSWER LIMIT < TEXT`.

    It writes why the law is refused, or an empty text.
    """
    kind, name, answer, limit = sys.argv[1:]
    resource.setrlimit(resource.RLIMIT_CPU, (int(limit), int(limit) + 5))
    refused = ""
    try:
        registry.checked(kind, name, custom_laws.execute(name, sys.stdin.buffer.read()))
    except PywetError as error:
        refused = str(error)
    write_json(Path(answer), refused)


if __name__ == "__main__":
    main()
