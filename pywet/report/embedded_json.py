"""JSON inside a page, `<script type="application/json">`: every page writes it with `embedded`, and browsers can read it."""

from __future__ import annotations

import json
from typing import Any

from pywet.util.files import finite


def embedded(value: Any) -> str:
    """Return a value as strict JSON that can stand inside a page: NaN and infinity, which JSON does not have, become null.

    >>> embedded({"y": [0.5, float("nan")], "label": "</script>"})
    '{"y": [0.5, null], "label": "\\\\u003c/script>"}'
    """
    return json.dumps(finite(value), allow_nan=False).replace("<", "\\u003c")
