"""Test a custom law in a child process, started by `custom_laws.py`, since a law may loop forever or end the program."""

from __future__ import annotations

import resource
import sys
from pathlib import Path
from typing import Any

from pywet.errors import PywetError
from pywet.laws import custom_laws, registry
from pywet.util.files import write_json


def main() -> None:
    """`python -m pywet.laws.trial KIND NAME ANSWER LIMIT < TEXT`: writes the sentence and data of a refusal, or ""."""
    kind, name, answer, limit = sys.argv[1:]
    resource.setrlimit(resource.RLIMIT_CPU, (int(limit), int(limit) + 5))
    refused: dict[str, Any] | str = ""
    try:
        registry.checked(kind, name, custom_laws.execute(name, sys.stdin.buffer.read()))
    except PywetError as error:
        refused = {"sentence": str(error), **error.data}
    write_json(Path(answer), refused)


if __name__ == "__main__":
    main()
