"""One of several keys, said once for all descriptions."""

from __future__ import annotations

from pydantic import BaseModel


def chosen(of: BaseModel, *keys: str, needed: bool = True) -> str | None:
    """The one key that is given; more than one, or none where one is `needed`, is refused."""
    given = [key for key in keys if getattr(of, key) is not None]
    if len(given) > 1 or (needed and not given):
        raise ValueError(
            f"{'one' if needed else 'at most one'} of {', '.join(keys)}, not {' and '.join(given) or 'none'}"
        )
    return given[0] if given else None
