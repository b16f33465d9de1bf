"""What a test expects of a refusal: its code and its data; the sentences are those of tests/data/messages.yaml."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from typer.testing import Result

from pywet.errors import PywetError


@contextmanager
def raises_code(code: str, says: str = "", **data: Any) -> Iterator[pytest.ExceptionInfo[PywetError]]:
    """Expect a `PywetError` with this code and these data (key, given, expected, where, or of its class).

    `says`: a pattern in its sentence, where several rules share a code (`config.inconsistent`) or a part comes from elsewhere.
    """
    with pytest.raises(PywetError) as caught:
        yield caught
    error = caught.value
    found = {name: getattr(error, name) for name in data}
    assert (error.code, found) == (code, data), f"{error.code}: {error}"
    assert re.search(says, str(error)), str(error)


def error_of(result: Result) -> PywetError | None:
    """Return the error that a command ended in; None if it ended otherwise."""
    error = result.exception and result.exception.__context__
    return error if isinstance(error, PywetError) else None


def code_of(result: Result) -> str:
    """Return the code of the error that a command ended in; empty if it ended otherwise."""
    error = error_of(result)
    return error.code if error else ""
