"""Faults injected into retirement: in the plugin (test_injected_faults.py), in tables of a sound run (test_retirement.py)."""

from __future__ import annotations

from collections.abc import Callable

import pandas as pd

PATCHES: list[tuple[str, str, str]] = [
    ("retirement.cpp", "const bool lies = at.x[a][2] < rules.retire_below",
     'const bool lies = at.x[a][2] < rules.retire_below + (injected("retired above the limit") ? 0.006 : 0.0)'),
    ("retirement.cpp", "dot(v, v) < rules.retire_slower * rules.retire_slower;",
     'dot(v, v) < (injected("fast ones retired") ? 100 : 1) * rules.retire_slower * rules.retire_slower;'),
    ("retirement.cpp", "s.film = films_.volume(a);",
     's.film = (injected("half of a film retired") ? 0.5 : 1.0) * films_.volume(a);'),
    ("retirement.cpp", "e.share_j = b.volume - e.share_i;",
     'e.share_j = injected("share lost at retirement") ? 0.0 : b.volume - e.share_i;'),
]  # fmt: skip
"""As those of injected.py."""
IN_PLUGIN: dict[str, tuple[str, str]] = {
    "retired above the limit": ("retired_who", "it does not qualify"),
    "fast ones retired": ("retired_who", "it does not qualify"),
    "half of a film retired": ("retired_film", "half of it counts"),
    "share lost at retirement": ("share_j", "all liquid goes to i"),
}
"""Fault of the plugin -> the quantity in which it shows, and words that name it."""


def scaled(column: str, factor: float) -> Callable[[pd.DataFrame], pd.DataFrame]:
    """One value of a column times a factor, in the last row."""

    def change(table: pd.DataFrame) -> pd.DataFrame:
        table.loc[table.index[-1], column] *= factor
        return table

    return change


def lost_share(events: pd.DataFrame) -> pd.DataFrame:
    """The other side of a bridge that ends gets nothing."""
    row = events.index[(events["kind"] == 2) & (events["partner_kind"] == 0)][0]
    events.loc[row, "share_j"] = 0.0
    return events


def retained_bridge(events: pd.DataFrame) -> pd.DataFrame:
    """A bridge of a retired sphere does not end."""
    return events.drop(events.index[events["kind"] == 2][3]).reset_index(drop=True)


def called_rupture(events: pd.DataFrame) -> pd.DataFrame:
    """A bridge that ends by retirement is called a rupture."""
    events.loc[events.index[events["kind"] == 2][0], "kind"] = 1
    return events


def called_retirement(events: pd.DataFrame) -> pd.DataFrame:
    """A rupture is said to follow from a retirement."""
    events.loc[events.index[events["kind"] == 1][0], "kind"] = 2
    return events


def moved(trajectory: pd.DataFrame) -> pd.DataFrame:
    """A retired sphere is elsewhere at the last output."""
    last = trajectory["step"] == trajectory["step"].max()
    trajectory.loc[last & (trajectory["id"] == trajectory.attrs["gone"]), "x"] += 1e-4
    return trajectory


FAULTS: dict[str, tuple[str, Callable[[pd.DataFrame], pd.DataFrame], str, str]] = {
    "a film off by a factor": ("history/retired", scaled("film", 1.001), "retired_film", "1.001 times"),
    "a sphere above the plane": ("history/retired", scaled("x_z", 20.0), "retired_who", "does not qualify"),
    "a sphere that is too fast": ("history/retired", scaled("v_z", 1e4), "retired_who", "does not qualify"),
    "a sphere left out": ("history/retired", lambda t: t.drop(t.index[-1]), "retired_missed", "qualifies and was not retired"),
    "a share lost": ("history/events", lost_share, "share_j", "all liquid goes to i"),
    "a bridge that is not removed": ("history/events", retained_bridge, "final_bridges_missing", "missing from the log"),
    "a retirement called rupture": ("history/events", called_rupture, "rupture_due", "rupture"),
    "a rupture called retirement": ("history/events", called_retirement, "retired_events", "no sphere of it is retired"),
    "a position that is not stored": ("trajectory", moved, "retired_rest", "moves"),
    "the ledger's column": ("history/ledger", scaled("retired", 1.5), "ledger_held", "mm³ are too much"),
}  # fmt: skip
"""Fault -> table, change of it, the quantity in which it shows, words that name it."""
