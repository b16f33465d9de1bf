"""Spheres that left a run: the product, times and liquid of each.

In a run with outlets they define the products; without insertion it is a batch, whose overs are also what stays. In a
screening case the spheres in the collecting bin at the end are the unders, the rest the overs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from pywet.engines import schedule
from pywet.errors import PywetError
from pywet.products.apertures import DECKS
from pywet.products.steady import start_of_steady
from pywet.runs.rundir import Floats, RunDir
from pywet.scene import EngineScene

PRODUCTS = ("overs", "unders")
TIE = 1e-9
"""Difference of two times that is round-off [s]."""
Spheres = tuple[Any, Any, Any]
"""Ids, types and masses [kg] of all spheres, in the order of the ids."""


@dataclass(frozen=True)
class Streams:
    """Spheres of a run by product, and the averaging period."""

    spheres: pd.DataFrame
    """id, type, diameter_m, mass_kg, entered_s, left_s, product (overs, unders or empty), liquid_m3 at the end."""
    continuous: bool
    start_s: float
    end_s: float
    steady: bool
    """Whether a steady state was found; otherwise the second half of the feed is used."""
    deck: int = 1
    """Deck of the overs and unders, counted from the top; spheres that left over a deck above are no product of it."""

    @property
    def counted(self) -> pd.DataFrame:
        """Return the spheres of both products that left during the averaging period; for a batch all."""
        with_product = self.spheres[self.spheres["product"] != ""]
        if not self.continuous:
            return with_product
        left = with_product["left_s"] - TIE
        return with_product[(left > self.start_s) & (left <= self.end_s)]


def read(run: RunDir, from_s: float | None = None, deck: int = 1) -> Streams:
    """Return the streams of a deck of a finished run; averaging starts at `from_s`, by default as `until` asks or when steady.

    Raises
    ------
    PywetError
        For a run with neither a collecting bin nor outlets named as products, or without that deck; for `from_s` of a batch.
    """
    most = decks(run.scene)
    if not 1 <= deck <= most:
        raise PywetError(
            f"{run.path}: deck {deck} was asked for; expected one from 1 to {most}, counted from above",
            code="screen.deck", key="--deck", given=deck, expected=most, where=run.path,
        )  # fmt: skip
    if from_s and run.scene.insertion_s is None:
        raise PywetError(
            f"--from {from_s:g} s; {run.path} is a batch, all of which is evaluated; expected a run with a feed, or no --from",
            code="screen.from_batch", key="--from", given=from_s, where=run.path,
        )  # fmt: skip
    if run.scene.outlets:
        return _of_outlets(run, asked_from(run) if from_s is None else from_s, deck)
    if run.scene.slide is None:
        raise PywetError(
            f"{run.path}: its scene has no outlets, so that no product leaves; expected a screening case, or outlets whose names "
            "begin with overs and unders, or that have the key product",
            code="screen.no_outlets", where=run.path,
        )  # fmt: skip
    return _batch(run)


def asked_from(run: RunDir) -> float | None:
    """Return the time [s] of the first block that counts by `until.from_s`; None if the scene does not set it."""
    asked = (run.description.get("until") or {}).get("from_s")
    return None if asked is None else first_block(run.scene, asked) * run.scene.block_s


def first_block(scene: EngineScene, from_s: float) -> int:
    """Return the number of blocks before the first that begins at or after a time."""
    return math.ceil(from_s / scene.block_s - 1e-9)


def decks(scene: EngineScene) -> int:
    """Return the number of decks of a scene with separate overs."""
    collected = {o.product for o in scene.outlets}
    return max((k for k, product in enumerate(DECKS, start=1) if product in collected), default=1)


def _table(
    scene: EngineScene, spheres: Spheres, entered: Floats, left: Floats, product: Any, liquid: Floats
) -> pd.DataFrame:
    (ids, types, mass), radius = spheres, np.array([c.radius_m for c in scene.classes])
    return pd.DataFrame(
        {
            "id": ids, "type": types, "diameter_m": 2.0 * radius[types - 1], "mass_kg": mass,
            "entered_s": entered, "left_s": left, "product": product, "liquid_m3": liquid,
        }
    )  # fmt: skip


def _batch(run: RunDir) -> Streams:
    line, scene = run.timeline, run.scene
    passed = line.passed[-1] & line.present[-1]
    left = np.where(passed, line.times[line.passed.argmax(axis=0)], np.nan)
    opened = scene.slide.opens_at_s if scene.slide else 0.0
    spheres, product = (line.ids, line.types, line.mass), np.where(passed, "unders", "overs")
    table = _table(scene, spheres, np.full(len(line.ids), opened), left, product, line.liquid[-1])
    return Streams(table, False, opened, float(line.times[-1]), True)


def _of_outlets(run: RunDir, from_s: float | None, deck: int) -> Streams:
    line, scene = run.timeline, run.scene
    if missing := uncollected(scene):
        raise PywetError(f"{run.path}: {missing}", code="screen.uncollected", where=run.path)
    table = leaving(scene, (line.ids, line.types, line.mass), run.table("history/retired"), deck)
    if scene.insertion_s is None:
        if decks(scene) == 1:  # of several decks it is not known which one a sphere has reached
            stays = table["left_s"].isna()
            table.loc[stays, "product"], table.loc[stays, "liquid_m3"] = "overs", line.liquid[-1][stays]
        return Streams(table, False, 0.0, float(line.times[-1]), True, deck)
    first, last = scene.insertion_s
    end = min(float(line.times[-1]), last)
    if from_s is not None:
        if not 0.0 <= from_s < end:
            raise PywetError(
                f"--from {from_s:g} s; expected a time before the end of the feed, {end:g} s",
                code="screen.late", key="--from", given=from_s, expected=end,
            )  # fmt: skip
        return Streams(table, True, from_s, end, True, deck)
    start = steady_from(scene, table, end)
    return Streams(table, True, first + 0.5 * (end - first) if start is None else start, end, start is not None, deck)


def uncollected(scene: EngineScene) -> str | None:
    """Return a sentence if no outlet collects the overs, or none the unders."""
    missing = [p for p in PRODUCTS if p not in [o.product for o in scene.outlets]]
    if not missing:
        return None
    names = ", ".join(o.name for o in scene.outlets) or "none"
    return (
        f"none of its outlets ({names}) collects the {missing[0]}; expected one whose name begins "
        f"with {missing[0]}, or with the key product: {missing[0]}"
    )


def leaving(scene: EngineScene, spheres: Spheres, retired: pd.DataFrame, deck: int) -> pd.DataFrame:
    """Return the table of `Streams` of a run with outlets, from the spheres that left it (id, time, outlet, film)."""
    ids, types, _ = spheres
    gone = retired.set_index("id").reindex(ids)
    seen = {**dict.fromkeys(DECKS[: deck - 1], ""), DECKS[deck - 1]: "overs"}
    by_outlet = np.array(
        ["", *(seen.get(o.product, "unders") if o.product else "" for o in scene.outlets)], dtype=object
    )
    product = by_outlet[gone["outlet"].fillna(0).to_numpy(dtype=int)]
    entered = np.array(scene.enters(types.tolist())) * scene.time_step_s
    left, film = gone["time"].to_numpy(dtype=float), gone["film"].fillna(0.0).to_numpy(dtype=float)
    return _table(scene, spheres, entered, left, product, film)


def edges(scene: EngineScene, end_s: float) -> Floats:
    """Return the times between which fluxes are counted: the steps at which spheres may leave, up to `end_s` [s]."""
    every = schedule.checkpoint_every(scene) * scene.time_step_s
    return np.asarray(every * np.arange(int(end_s / every + 1e-9) + 1), dtype=np.float64)


def flux(spheres: pd.DataFrame, times: Floats) -> Floats:
    """Return the mass that left in each interval over its length [kg/s]."""
    mass, _ = np.histogram(
        spheres["left_s"].dropna(), times + TIE, weights=spheres["mass_kg"][spheres["left_s"].notna()]
    )
    return np.asarray(mass / np.diff(times))


def hold_up(spheres: pd.DataFrame, times: Floats) -> Floats:
    """Return the mass that has entered and not left at each time [kg]; what leaves just then has left, whatever the round-off."""
    mass = spheres["mass_kg"].to_numpy()
    entered, left = spheres["entered_s"].to_numpy(), spheres["left_s"].fillna(np.inf).to_numpy()
    return np.array([mass[(entered <= t) & (left > t)].sum() for t in times + TIE])


def shares_left(run: RunDir) -> dict[str, Floats]:
    """Return by product, or outlet without one, the mass that left until each output over that which entered until then.

    0 until something has entered; empty for a run without outlets.
    """
    line, of = run.timeline, [o.product or o.name for o in run.scene.outlets]
    if not of:
        return {}
    gone = run.table("history/retired")
    out, mass = np.array(of)[gone["outlet"].to_numpy(dtype=int) - 1], line.mass[np.searchsorted(line.ids, gone["id"])]
    feed = line.entered @ line.mass
    left = {p: (gone["step"].to_numpy()[out == p] <= line.steps[:, None]) @ mass[out == p] for p in dict.fromkeys(of)}
    return {p: np.divide(kg, feed, out=np.zeros(len(feed)), where=feed > 0) for p, kg in left.items()}


def spilled_share(run: RunDir) -> float:
    """Return the share of the mass that has entered by the end that left through outlets of no product."""
    left = shares_left(run)
    return sum((float(left[o.name][-1]) for o in run.scene.outlets if not o.product), 0.0)


def steady_from(scene: EngineScene, table: pd.DataFrame, end: float) -> float | None:
    """Return the time [s] from which hold-up and outflow are both steady; None if one of them never is."""
    times = edges(scene, end)
    if len(times) < 3:
        return None
    found = [start_of_steady(hold_up(table, times[1:])), start_of_steady(flux(table, times))]
    return None if None in found else float(times[1 + max(k for k in found if k is not None)])
