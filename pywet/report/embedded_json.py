"""JSON inside a page, `<script type="application/json">`: every page writes it with `embedded`, and browsers can read it."""

from __future__ import annotations

import json
import math
from typing import Any


def embedded(value: Any) -> str:
    """Return a value as strict JSON that can stand inside a page: NaN and infinity, which JSON does not have, become null.

    >>> embedded({"y": [0.5, float("nan")], "label": "</script>"})
    '{"y": [0.5, null], "label": "\\\\u003c/script>"}'
    """
    return json.dumps(_finite(value), allow_nan=False).replace("<", "\\u003c")


def _finite(value: Any) -> Any:
    """Return plain data with None in place of each number that is not finite."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: _finite(entry) for key, entry in value.items()}
    return [_finite(entry) for entry in value] if isinstance(value, list | tuple) else value
