"""Destination of each size in a user-defined scene: its shares by outlet, or by tray at the end."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from pywet.products import apertures, streams
from pywet.products.partition import wilson
from pywet.products.streams import PRODUCTS
from pywet.runs.rundir import Floats, RunDir

TRAY = "tray"
"""Prefix of the names of walls that are trays; a fixed vessel is a tray, too."""


def shares(runs: Sequence[RunDir]) -> tuple[str, list[pd.DataFrame]] | None:
    """Return `outlet` or `tray`, and for each run of one scene the share of the mass of each size in each of them.

    Returns
    -------
    tuple of str and list of DataFrame, or None
        Index: diameter in mm, columns: names of destinations with spheres in at least one run. Of a screen with outlets, the
        spheres that `pywet screen` counts. None where the runs together have not at least two sizes and two destinations.
    """
    if not runs:
        return None
    every, by_outlet = [_rows(run)[1] for run in runs], bool(runs[0].scene.outlets)
    if min(len({v for rows in every for v in rows[column]}) for column in ("diameter_mm", "where")) < 2:
        return None
    order = [o.name for o in runs[0].scene.outlets] if by_outlet else [w.name for w in runs[0].scene.walls]
    names = [name for name in order if any((rows["where"] == name).any() for rows in every)]
    found = []
    for rows in every:
        masses = rows.pivot_table(index="diameter_mm", columns="where", values="mass_kg", aggfunc="sum", fill_value=0.0)
        found.append(masses.div(masses.sum(axis=1), axis=0).reindex(columns=names, fill_value=0.0))
    return ("outlet" if by_outlet else TRAY), found


def intervals(run: RunDir, names: list[str]) -> dict[str, tuple[Floats, Floats]]:
    """Return the ends of the 95 % interval of each share of `shares` by name, with spheres as independent trials (Wilson)."""
    _, rows = _rows(run)
    counts = rows.pivot_table(index="diameter_mm", columns="where", values="mass_kg", aggfunc="size", fill_value=0)
    number, found = counts.sum(axis=1), {}
    for name, of in counts.reindex(columns=names, fill_value=0).items():
        ends = np.array([wilson(k, n) for k, n in zip(of, number, strict=True)])
        found[str(name)] = (ends[:, 0], ends[:, 1])
    return found


def _rows(run: RunDir) -> tuple[bool, pd.DataFrame]:
    """Return whether destinations are outlets, and mass, size and destination of each sphere."""
    by_outlet = bool(run.scene.outlets)
    return by_outlet, _by_outlet(run) if by_outlet else _by_tray(run)


def _by_outlet(run: RunDir) -> pd.DataFrame:
    """Return mass, size and outlet of the spheres that left; of a screen of those it counts, and what stays is with the overs."""
    scene, gone = run.scene, run.table("history/retired")
    where = dict(zip(gone["id"], (scene.outlets[k - 1].name for k in gone["outlet"]), strict=True))
    if not {o.product for o in scene.outlets} >= set(PRODUCTS):
        return _named(run, gone, gone["id"].map(where).to_numpy())
    counted = streams.read(run).counted
    overs = min((o.name for o in scene.outlets if o.product == PRODUCTS[0]), key=lambda name: name != PRODUCTS[0])
    return _named(run, counted, counted["id"].map(where).fillna(overs).to_numpy())


def _by_tray(run: RunDir) -> pd.DataFrame:
    """Return mass, size and smallest enclosing tray of the spheres at the end; no tray if there is none."""
    last = run.at_step("trajectory", int(run.scene.output_steps[-1]))
    at, found = last[["x", "y", "z"]].to_numpy(dtype=float), np.full(len(last), "", dtype=object)
    boxes = []
    for name in _trays(run):
        low, high = apertures.extents(run, next(w for w in run.scene.walls if w.name == name))
        boxes.append((low.min(axis=0), high.max(axis=0), name))
    for low, high, name in sorted(boxes, key=lambda box: -float(np.prod(box[1] - box[0]))):
        found[((at >= low) & (at <= high)).all(axis=1)] = name
    return _named(run, last, found)


def _trays(run: RunDir) -> list[str]:
    scene, given = run.scene, run.description.get("walls", [])
    vessels = {w.name for w, of in zip(scene.walls[::-1], given[::-1], strict=False) if of.get("vessel")}
    fixed = [name for name, motion in scene.motions.items() if motion is None]
    return [name for name in fixed if name in vessels or name.lower().startswith(TRAY)]


def _named(run: RunDir, spheres: pd.DataFrame, where: np.ndarray) -> pd.DataFrame:
    """Return mass and size of spheres by their type."""
    sizes = {c.type: (c.mass_kg, 2e3 * c.radius_m) for c in run.scene.classes}
    kind = run.spheres.set_index("id")["type"].reindex(spheres["id"]).tolist()
    return pd.DataFrame(
        {"mass_kg": [sizes[k][0] for k in kind], "diameter_mm": [sizes[k][1] for k in kind], "where": where}
    )
