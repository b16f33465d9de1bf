"""End a continuous run when its partition is known: blocks, intervals of T of each size, decision after each block.

A run consists of equal blocks. After each, T and its interval are computed from the blocks since the steady state;
the run ends when the widest interval is narrow enough. Stopping when an interval happens to be narrow favours
intervals that are too narrow: such an interval contains the true value in fewer than 95 % of all runs, the fewer the
smaller the number of blocks.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pandas as pd
from pydantic import Field

from pywet.config.entries import Excusable
from pywet.engines import schedule
from pywet.errors import ConfigError, PywetError
from pywet.products import streams
from pywet.products.outlets import refuse_skipped
from pywet.products.partition import mean_and_half_width, wilson
from pywet.products.streams import PRODUCTS
from pywet.runs import retired, tables
from pywet.runs.rundir import RunDir
from pywet.scene import EngineScene, NonNegative, Positive
from pywet.util.files import read_table, write_json
from pywet.util.notices import notice

RESULT = "results/until.json"
"""File with the accuracy of the partition reached so far."""
BLOCKS = 20
"""Default number of blocks of the longest run."""
LEAST_BLOCKS = 5
"""Smallest number of blocks for an interval."""


class Until(Excusable):
    """End of a run: the first block at whose end T of every size is known, at the latest `duration_s`."""

    partition_percent: Annotated[float, Field(gt=0, le=50)]
    """Half the 95 % interval of T, in percent of the feed of a size."""
    block_s: Positive | None = None
    """Length of a block; by default a twentieth of `duration_s`."""
    least_blocks: Annotated[int, Field(ge=LEAST_BLOCKS, le=1000)] = 8
    """Smallest number of blocks in the steady state."""
    least_spheres: Annotated[int, Field(ge=10)] = 50
    """Number of counted spheres below which a size does not delay the end."""
    from_s: NonNegative | None = None
    """Time from which blocks count; by default that from which the run is steady."""
    deck: Annotated[int, Field(ge=1, le=3)] = 1
    """Deck whose partition is evaluated, counted from the top."""


def in_blocks(scene: EngineScene, until: Until, blocks: int | None) -> EngineScene:
    """Divide the scene of the longest run into blocks and return the run of the first `blocks`, by default the minimum.

    Raises
    ------
    ConfigError
        If no product is collected, if blocks are too short or too few, or if sampling windows prevent removals.
    """
    name, step = f"scene {scene.name}: until", scene.time_step_s
    if missing := streams.uncollected(scene):
        raise ConfigError(f"{name}: {missing}", code="scene.until_outlets", key="until")
    collected = streams.decks(scene)
    if until.deck > collected:
        raise ConfigError(
            f"{name}: deck is {until.deck}; expected 1 to {collected}, the number of decks",
            code="scene.until_deck",
            key="until.deck",
        )
    every = schedule.checkpoint_every(scene)
    size = every * max(1, round((until.block_s or scene.duration_s / BLOCKS) / step / every))
    most, least = scene.steps // size, fewest(until, size * step)
    if most < least:
        raise ConfigError(
            f"{name}: {most} blocks of {size * step:.4g} s fit into duration_s, {scene.duration_s:g} s; expected at least "
            f"{least}: lower block_s or least_blocks, or raise duration_s",
            code="scene.until_blocks",
            key="until.block_s",
            given=most,
            expected=least,
        )
    of_each = -(-scene.output.contact_windows // most)
    whole = scene.model_copy(
        update={
            "blocks": most,
            "duration_s": most * size * step,
            "output": scene.output.model_copy(update={"contact_windows": of_each * most}),
        }
    )
    if schedule.checkpoint_every(whole.of_blocks(1)) != every:
        shortest = step * scene.output_every * ((every // scene.output_every - 1) * (scene.output.checkpoints + 1) + 1)
        raise ConfigError(
            f"{name}: block_s is {size * step:.4g} s; expected at least {shortest:.4g} s with "
            f"{scene.output.checkpoints} checkpoints: raise block_s or results.checkpoints",
            code="scene.until_short",
            key="until.block_s",
            given=size * step,
            expected=shortest,
        )
    refuse_skipped(whole)
    return whole.of_blocks(min(most, blocks or least))


def fewest(until: Until, block_s: float) -> int:
    """Return the number of blocks of the shortest run."""
    return math.ceil((until.from_s or 0.0) / block_s - 1e-9) + until.least_blocks


def most_blocks(scene: EngineScene) -> int:
    """Return the number of blocks of the longest run, for which there is feed."""
    last = (scene.insertion_s or (0.0, 0.0))[1]
    return round(last / scene.time_step_s) // scene.block_steps


def under_way(run_dir: Path) -> int | None:
    """Return the number of blocks, finished or in progress, of a run; None without a run."""
    try:
        return RunDir(Path(run_dir)).scene.blocks
    except PywetError:
        return None


def extension(until: Until) -> Callable[[Path, EngineScene], EngineScene | None]:
    """Return the function for the decision after a block: the scene with one more, or None to end the run."""

    def extend(folder: Path, scene: EngineScene) -> EngineScene | None:
        gone = tables.to_frame(retired.records(folder))
        found = assess(scene, read_table(folder.parent / scene.spheres_file), gone, until)
        notice.info("%s: %s", scene.name, sentence(found))
        assert scene.blocks is not None
        return None if found["reached"] or found["longest"] else scene.of_blocks(scene.blocks + 1)

    return extend


def assess(scene: EngineScene, spheres: pd.DataFrame, gone: pd.DataFrame, until: Until) -> dict[str, Any]:
    """Compute T of every size with half of its 95 % interval from the blocks of a run since its steady state.

    Parameters
    ----------
    scene : EngineScene
        With the blocks that were run.
    spheres : DataFrame
        id and type of all spheres.
    gone : DataFrame
        Spheres that left: id, step, time, outlet, film.
    until : Until

    Returns
    -------
    dict
        Content of `results/until.json`.

    Notes
    -----
    T is the share of the mass of a size. Of two intervals the wider one counts: that of the blocks, by the deviations of the
    overs of each from T times its feed (ratio estimator) and Student's t, and that of as many independent spheres (Wilson).
    """
    order = spheres.sort_values("id")
    ids, types = order["id"].to_numpy(), order["type"].to_numpy()
    mass = np.array([c.mass_kg for c in scene.classes])[types - 1]
    table = streams.leaving(scene, (ids, types, mass), gone, until.deck)
    block_s, blocks = scene.block_s, scene.blocks or 1
    start = until.from_s if until.from_s is not None else streams.steady_from(scene, table, blocks * block_s)
    first = blocks if start is None else min(blocks, streams.first_block(scene, start))
    table["block"] = np.ceil(table["left_s"].to_numpy() / block_s - 1e-9) - 1.0
    counted = table[(table["product"] != "") & (table["block"] >= first)]
    sizes = [
        _of_size(float(d), counted[counted["diameter_m"] == d], first, blocks, until.least_spheres)
        for d in sorted(counted["diameter_m"].unique().tolist())
    ]
    asked = [s["half_width"] for s in sizes if s["asked"]]
    enough = blocks - first >= until.least_blocks and bool(asked)
    return {
        "asked": 0.01 * until.partition_percent,
        "reached": enough and max(asked) <= 0.01 * until.partition_percent,
        "longest": blocks >= most_blocks(scene),
        "blocks": blocks,
        "block_s": block_s,
        "counted_blocks": blocks - first,
        "least_blocks": until.least_blocks,
        "from_s": first * block_s,
        "steady": start is not None,
        "sizes": sizes,
    }


def _of_size(diameter_m: float, rows: pd.DataFrame, first: int, blocks: int, least: int) -> dict[str, Any]:
    """Return T of the mass of a size with half its interval, and whether that size is required."""
    block, overs_too = rows["block"].to_numpy(dtype=int) - first, (rows["product"] == PRODUCTS[0]).to_numpy()
    mass, number = rows["mass_kg"].to_numpy(), len(rows)
    overs, feed = (np.bincount(block, kg, minlength=blocks - first) for kg in (mass * overs_too, mass))
    t = overs.sum() / feed.sum()
    low, high = wilson(float(overs_too.sum()), float(number))
    _, between = mean_and_half_width(((overs - t * feed) / feed.mean()).tolist())
    half = max(0.5 * (high - low), 0.0 if math.isnan(between) else between)
    return {
        "diameter_mm": 1e3 * diameter_m, "spheres": number, "T": float(t), "half_width": float(half),
        "asked": number >= least,
    }  # fmt: skip


def sentence(found: dict[str, Any]) -> str:
    """Describe in one sentence how accurately the partition is known."""
    after = f"{found['blocks']} blocks of {found['block_s']:.3g} s"
    if not found["steady"]:
        known = "not steady"
    else:
        asked = [s for s in found["sizes"] if s["asked"]]
        widest = max(asked, key=lambda s: s["half_width"], default=None)
        known = "too few spheres of every size"
        if widest:
            known = f"T is known to ± {100 * widest['half_width']:.2g} % ({widest['diameter_mm']:.3g} mm)"
        known += f" from {found['counted_blocks']} blocks since {found['from_s']:.3g} s"
        if found["counted_blocks"] < found["least_blocks"]:
            known += f", at least {found['least_blocks']} wanted"
    end = "reached" if found["reached"] else "not reached in the longest run" if found["longest"] else "goes on"
    return f"after {after} {known}; asked ± {100 * found['asked']:.3g} %: {end}"


def write(run: RunDir) -> dict[str, Any]:
    """Write `results/until.json` of a finished run and return its content."""
    found = assess(run.scene, run.spheres, run.table("history/retired"), Until(**run.description["until"]))
    write_json(run.path / RESULT, found)
    return found
