"""Bridges that formed too early or not at all, and the snapshots of films and bridges at every output against the events.

A missed formation is looked for where positions are known: between spheres, at the output steps of trajectory.parquet and in the
windows that record motion, there at every step at which bridges act. So none is later than the steps between those.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from reference_impl import laws
from reference_impl.compare import Floats, Quantity, compare
from reference_impl.io import Run
from reference_impl.links_rows import of_bridges
from reference_impl.liquid import FORMATION, bodies
from reference_impl.transfer import Tables

ROOM = 1e-9
"""Part of the radius by which films may miss each other: a gap is a difference of positions."""
SMALLEST = 1e-12
"""V* below which nothing forms, by definition of the model's numerical zero."""


def thickness(film: Floats, radius: Floats) -> Floats:
    """Of the film on a sphere: (3 L/(4 pi) + r^3)^(1/3) - r (E 34)."""
    return np.asarray(radius * np.expm1(np.log1p(3.0 * film / (4.0 * np.pi * radius**3)) / 3.0))


def films_at_events(run: Run) -> tuple[Floats, Floats, Floats]:
    """Sum of both films' thicknesses before each event, the separation, and the radius of i."""
    fixed, events = bodies(run), run.table("events")
    wall = (events["partner_kind"] != laws.SPHERE).to_numpy()
    ri = events["i"].map(fixed.radius).to_numpy(float)
    rj = np.where(wall, 1.0, events["j"].map(fixed.radius).fillna(1.0).to_numpy(float))
    area = np.where(wall, events["triangle"].map(fixed.area).fillna(1.0), 1.0).astype(float)
    i, j = (np.maximum(events[f"film_{s}_before"].to_numpy(float), 0.0) for s in "ij")
    return thickness(i, ri) + np.where(wall, j / area, thickness(j, rj)), events["separation"].to_numpy(float), ri


def formation_due(run: Run) -> Quantity:
    """A bridge forms only where the films touch, S < h_i + h_j."""
    films, gap, ri = films_at_events(run)
    events = run.table("events")
    early = ((events["kind"] == FORMATION) & (gap > films + ROOM * ri)).to_numpy(float)
    zero = np.zeros(len(early))
    return compare("formation_due", "formations before the films touch", early, zero, zero + 1.0, events, 0.0)


def formation_missed(run: Run) -> list[Quantity]:
    """Spheres whose films touch at an output step, or where bridges act in a window, have a bridge."""
    table = touching_pairs(run)
    if not len(table):
        return []
    missed, zero = table["missed"].to_numpy(float), np.zeros(len(table))
    return [compare("formation_missed", "films that touch without a bridge", missed, zero, zero + 1.0, table, 0.0)]


def touching_pairs(run: Run) -> pd.DataFrame:
    """Spheres whose films touch and whether their bridge is missing; not those with an event in that step."""
    found = [table for table in (_at_outputs(run), _in_windows(run)) if len(table)]
    if not found:
        return pd.DataFrame()
    table, events = pd.concat(found, ignore_index=True), run.table("events")
    moved = pd.MultiIndex.from_frame(pd.concat([events[["step", s]].set_axis(["step", "id"], axis=1) for s in "ij"]))
    busy = [pd.MultiIndex.from_frame(table[["step", s]]).isin(moved) for s in "ij"]
    return table[~(busy[0] | busy[1])].reset_index(drop=True)


def _at_outputs(run: Run) -> pd.DataFrame:
    """Pairs that touch at the output steps, and whether they are missing in the snapshot of bridges."""
    path = run.folder / "trajectory.parquet"
    if not path.exists() or not len(run.table("films")):
        return pd.DataFrame()
    steps = set(run.table("films")["step"])
    where = pd.read_parquet(path, columns=["step", "id", "x", "y", "z"])
    where = where[where["step"].isin(steps) & (where["step"] > 0)]
    table = _all_touching(run, where.merge(run.table("films"), on=["step", "id"]))
    bridges = run.table("bridges")
    standing = pd.MultiIndex.from_frame(bridges.loc[bridges["partner_kind"] == laws.SPHERE, ["step", "i", "j"]])
    return table.assign(missed=~pd.MultiIndex.from_frame(table[["step", "i", "j"]]).isin(standing))


def _in_windows(run: Run) -> pd.DataFrame:
    """The same at the windows' steps at which bridges act, with films and bridges by the event log."""
    path, events = run.folder / "history" / "window_states.parquet", run.table("events")
    if not path.exists() or not len(events):
        return pd.DataFrame()
    where = pd.read_parquet(path, columns=["step", "id", "x", "y", "z"])
    where = where[(where["step"] > 0) & (where["step"] % run.meta.get("bridges_every", 1) == 0)].sort_values("step")
    events = events.astype({"i": np.int64, "j": np.int64}).sort_values("step", kind="stable")
    pairs = events[events["partner_kind"] == laws.SPHERE]
    names = {"i": "film_i_after", "j": "film_j_after"}
    moved = pd.concat([t[["step", s, names[s]]].set_axis(["step", "id", "film"], axis=1)
                       for t, s in ((events, "i"), (pairs, "j"))])  # fmt: skip
    films = pd.merge_asof(where, moved.sort_values("step", kind="stable"), on="step", by="id")
    first = films["id"].map(run.table("spheres").set_index("id")["film"])
    table = _all_touching(run, films.assign(film=films["film"].fillna(first).clip(lower=0.0)))
    if not len(table):
        return table
    last = pd.merge_asof(table, pairs[["step", "i", "j", "kind"]], on="step", by=["i", "j"])
    return table.assign(missed=(last["kind"] != FORMATION).to_numpy())


def _all_touching(run: Run, films: pd.DataFrame) -> pd.DataFrame:
    """Pairs that touch in each step of a table of places and films."""
    films["radius"] = films["id"].map(bodies(run).radius)
    films["reach"] = films["radius"] + thickness(films["film"].to_numpy(float), films["radius"].to_numpy(float))
    none = pd.DataFrame({name: np.zeros(0) for name in ("step", "i", "j", "separation", "films")})
    return pd.concat([none, *(_touching(rows) for _, rows in films.groupby("step"))], ignore_index=True).astype(
        {"step": np.int64, "i": np.int64, "j": np.int64}
    )


def _touching(rows: pd.DataFrame) -> pd.DataFrame:
    """Pairs of spheres of one step whose films overlap and hold something."""
    at, reach = rows[["x", "y", "z"]].to_numpy(), rows["reach"].to_numpy()
    near = cKDTree(at).query_pairs(2.0 * float(reach.max()), output_type="ndarray")
    near = near if len(near) else np.zeros((0, 2), dtype=int)
    ids, film, radius = (rows[n].to_numpy() for n in ("id", "film", "radius"))
    first = np.where(ids[near[:, 0]] < ids[near[:, 1]], near[:, 0], near[:, 1])
    second = near.sum(axis=1) - first
    distance = np.sqrt(((at[first] - at[second]) ** 2).sum(axis=1))
    # the dump of positions holds about six digits
    touch = distance < reach[first] + reach[second] - 1e-4 * radius[first]
    drawn = given(film[first], radius[first], radius[second]) + given(film[second], radius[second], radius[first])
    r = laws.harmonic_radius(radius[first], radius[second], np.zeros(len(first), dtype=bool))
    keep = touch & (drawn > SMALLEST * r**3)
    step = int(rows["step"].iloc[0])
    gap, films = distance - radius[first] - radius[second], (reach - radius)[first] + (reach - radius)[second]
    named = {"i": ids[first], "j": ids[second], "separation": gap, "films": films}
    return pd.DataFrame({"step": step, **{name: values[keep] for name, values in named.items()}})


def given(film: Floats, ri: Floats, rj: Floats) -> Floats:
    """Liquid that sphere i gives to a bridge with sphere j (E 8)."""
    return np.asarray(film / 2.0 * (1.0 - np.sqrt(1.0 - (rj / (ri + rj)) ** 2)))


def standing_at_outputs(run: Run, tables: Tables, own: dict[str, list[float]]) -> list[Quantity]:
    """Volumes and shares of the bridges at every output; `own` are the columns that liquid.replay computed."""
    bridges, events = run.table("bridges"), run.table("events")
    if not len(bridges) or not len(events):
        return []
    key = ["wall", "i", "j"]
    left = bridges.assign(wall=bridges["partner_kind"] != laws.SPHERE).sort_values("step", kind="stable")
    right = events.assign(wall=events["partner_kind"] != laws.SPHERE, own=own["volume"])
    rows = pd.merge_asof(
        left, right.sort_values("step", kind="stable")[["step", *key, "kind", "own"]], on="step", by=key
    )
    volume = rows["own"].where(rows["kind"] == FORMATION).to_numpy(float)
    share = volume * tables.ratios(*of_bridges(left, volume, run))
    return [
        compare("snapshot_volume", "itself", rows["volume"].to_numpy(float), volume, volume, left),
        compare("snapshot_share", "volume of the bridge", rows["share_i"].to_numpy(float), share, volume, left),
    ]


def films_at_outputs(run: Run, own: dict[str, list[float]]) -> list[Quantity]:
    """Films of spheres and walls at every output; `own` as above."""
    events, spheres = run.table("events"), run.table("spheres")
    wall = events["partner_kind"].to_numpy() != laws.SPHERE
    j = np.where(wall, -1 - events["triangle"].to_numpy(), events["j"].to_numpy())
    last = pd.DataFrame(
        {"step": np.tile(events["step"].to_numpy(), 2), "holder": np.concatenate([events["i"].to_numpy(), j]).astype(np.int64),
         "own": np.concatenate([own["film_i_after"], own["film_j_after"]])}
    )  # fmt: skip
    last = last.drop_duplicates(["step", "holder"], keep="last").sort_values("step", kind="stable")
    first, found = dict(zip(spheres["id"], spheres["film"], strict=True)), []
    for name in ("films", "wall_films"):
        table = run.table(name)
        holder = table["id"] if name == "films" else -1 - table["triangle"]
        rows = table.assign(holder=holder.astype(np.int64)).sort_values("step", kind="stable").reset_index(drop=True)
        merged = pd.merge_asof(rows, last, on="step", by="holder")
        mine = merged["own"].fillna(rows["holder"].map(first)).fillna(0.0).to_numpy(float)
        mean = np.full(len(rows), float(spheres["film"].mean()))
        logged = rows["film"].to_numpy(float)
        found.append(compare(f"snapshot_{name}", "mean film of a sphere", logged, mine, mean, rows))
    return found


def check(run: Run, tables: Tables, own: dict[str, list[float]]) -> list[Quantity]:
    """All of these; `own` are the columns that liquid.replay computed beside the event log."""
    if not len(run.table("events")):
        return []
    return [
        formation_due(run),
        *formation_missed(run),
        *films_at_outputs(run, own),
        *standing_at_outputs(run, tables, own),
    ]
