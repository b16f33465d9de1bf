"""Runs as 3-D scenes inside a page: spheres, bridges, walls and curves at some output times, drawn by viewer.js with three.js.

The page is self-contained: numbers rounded to 16 bits of the scene's size, deflated, as base64. three.min.js contains
the parts of three.js 0.187 (MIT, 0.57 MB) that viewer.js uses; it is made by `tools/three` and stored here, since no
maintained Python package provides it and an installation from a wheel has no npm.
"""

from __future__ import annotations

import base64
import html
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pywet.laws.contact import film_thickness
from pywet.report import active_bridges, caption, render, vtk
from pywet.report.embedded_json import embedded
from pywet.report.movie import spread
from pywet.report.pictures import colours
from pywet.report.sketch import solid
from pywet.runs.rundir import Floats, RunDir
from pywet.runs.walls import moved
from pywet.schema import LARGE_WALL, SPHERE

FRAMES = 20
MOST = 15_000_000
"""Size of a run in the page [bytes]; a larger run is shown at fewer times."""
STEPS = 65534
"""Number of steps into which a length or a value is divided."""
CLASSES = ("#e0a83e", "#4a9bd4", "#8b5fa5", "#5d8a3a", "#c0392b", "#27323d")
"""Colours of size classes, by name in all runs of a page."""


def element(runs: Sequence[tuple[str, RunDir]], panels: int = 1, most: int = MOST) -> str:
    """Return HTML that shows the named runs, a given number of them side by side."""
    here = Path(__file__).parent
    style, three, viewer = ((here / name).read_text() for name in ("viewer.css", "three.min.js", "viewer.js"))
    data = "".join(
        f'<script type="application/json" class="run" data-name="{html.escape(name)}">{packed(run, most)}</script>\n'
        for name, run in runs
    )
    names = list(dict.fromkeys(c.name for _, run in runs for c in run.scene.classes))
    classes = html.escape(embedded(dict(zip(names, colours(len(names), CLASSES), strict=True))))
    return (
        f'<style>{style}</style>\n<div class="viewer" data-panels="{panels}" data-classes="{classes}">\n{data}</div>\n'
        f"<script>{three}</script>\n<script>{viewer}</script>\n"
    )


def packed(run: RunDir, most: int = MOST) -> str:
    """Return a run as JSON for a page, at fewer times if it would be too large."""
    frames = FRAMES
    while len(text := _text(run, frames)) > most and frames > 2:
        frames = max(2, min(frames - 1, frames * most // len(text)))
    return text


def _text(run: RunDir, frames: int) -> str:
    line = run.timeline
    rows = spread(len(line.steps), frames)
    steps = line.steps[rows].tolist()
    telling = render.telling_step(run)
    centre, width = render.view(run, telling)
    seen, camera, _, up = render.camera(run, centre, width)
    arrays, head = _spheres(run, rows)
    bridges, starts = _bridges(run, steps)
    arrays |= bridges
    meshes = list(run.triangles["mesh"].unique())
    corners = run.triangles[[f"v{n}_{axis}" for n in range(3) for axis in "xyz"]].to_numpy(dtype=float)
    arrays["corners"] = corners.reshape(-1, 3, 3)
    low, high = (
        np.array([way(arrays[name].reshape(-1, 3), axis=0) for name in PLACES if arrays[name].size])
        for way in (np.nanmin, np.nanmax)
    )
    middle, quantum = (low.min(axis=0) + high.max(axis=0)) / 2.0, float((high.max(0) - low.min(0)).max()) / STEPS
    for name in PLACES:
        arrays[name] = np.nan_to_num((arrays[name] - middle) / quantum).round().astype("<i2")
    layout, data = _blob(arrays)
    return embedded(
        {
            **head,
            "times": line.times[rows].tolist(),
            "telling": telling * run.scene.time_step_s,
            "classes": [c.name for c in run.scene.classes],
            "origin": middle.tolist(),
            "quantum": quantum,
            "middle": seen.tolist(),
            "camera": camera.tolist(),
            "up": up.tolist(),
            "width": width,
            "starts": starts,
            "meshes": [_mesh(run, name, steps) for name in meshes],
            "curves": _curves(run),
            "arrays": layout,
            "data": data,
        }
    )


PLACES = ("place", "from", "to", "corners")
"""Names of arrays that contain points [m]."""


def _spheres(run: RunDir, rows: Sequence[int]) -> tuple[dict[str, NDArray[Any]], dict[str, float]]:
    """Collect position (NaN: not in the box), film and speed of every sphere at rows of the timeline, and their maxima."""
    line = run.timeline
    place, speed = np.full((len(rows), len(line.ids), 3), np.nan), np.zeros((len(rows), len(line.ids)))
    for k, row in enumerate(rows):
        here = run.trajectory[run.trajectory["step"] == line.steps[row]]
        index = np.searchsorted(line.ids, here["id"].to_numpy())
        place[k, index] = here[["x", "y", "z"]]
        speed[k, index] = np.linalg.norm(here[["vx", "vy", "vz"]], axis=1)
    radius = run.spheres["radius"].to_numpy(dtype=float)
    film = np.array([film_thickness(line.film[row], radius) for row in rows])
    most = {"film_most": float(film.max()), "speed_most": float(speed.max())}
    arrays = {
        "id": line.ids.astype("<i4"),
        "radius": radius.astype("<f4"),
        "place": place,
        "film": _levels(film, most["film_most"]),
        "speed": _levels(speed, most["speed_most"]),
        "class": (line.types - 1).astype("u1"),
        "there": line.present[list(rows)].astype("u1"),
    }
    return arrays, most


def _levels(values: Floats, most: float) -> NDArray[Any]:
    return np.asarray((values * (65535 / most if most else 0.0)).round().astype("<u2"))


def _bridges(run: RunDir, steps: Sequence[int]) -> tuple[dict[str, NDArray[Any]], list[int]]:
    """Return the cuboids of the bridges of all times, one after the other, and the first index of each time.

    A cuboid has ends [m], side [m], and the index of both spheres in the list of spheres (-1 a large wall, -2 a
    wire).
    """
    tables = [vtk.active_at(run, step) for step in steps]
    starts = np.cumsum([0, *(len(table) for table in tables)]).tolist()
    table = pd.concat(tables)
    box, kind = active_bridges.corners(run, table), table["partner_kind"].to_numpy()
    i, j = (np.searchsorted(run.timeline.ids, table[name].to_numpy(dtype=int)) for name in "ij")
    arrays: dict[str, NDArray[Any]] = {
        "i": i.astype("<i4"),
        "j": np.where(kind == SPHERE, j, np.where(kind == LARGE_WALL, -1, -2)).astype("<i4"),
        "side": np.linalg.norm(box[:, 1] - box[:, 0], axis=1).astype("<f4"),
        "from": box[:, :4].mean(axis=1),
        "to": box[:, 4:].mean(axis=1),
    }
    return arrays, starts


def _mesh(run: RunDir, name: str, steps: Sequence[int]) -> dict[str, Any]:
    """Return a wall: its triangles in the common list, its style, and 12 numbers per time for its position (3 rows of 4)."""
    table = run.triangles
    chosen = np.flatnonzero((table["mesh"] == name).to_numpy())
    units = [moved(run, name, step, np.vstack([np.zeros(3), np.eye(3)])) for step in steps]
    matrices = [np.column_stack([(unit[1:] - unit[0]).T, unit[0]]) for unit in units]
    reservoir = str(table["reservoir"].iloc[chosen[0]])
    return {
        "solid": bool(solid(run)[chosen[0]]),
        "hidden": reservoir in render.HIDDEN,
        "triangles": chosen.tolist(),
        "moved": [matrix.ravel().round(9).tolist() for matrix in matrices],
    }


def _curves(run: RunDir) -> list[dict[str, Any]]:
    """Return quantity, title, times [s] and values of the curves next to the scene."""
    curves: list[tuple[str, str, Any, Any]] = [
        (curve.quantity, curve.title, run.timeline.times, curve.values) for curve in caption.curves(run)
    ]
    if run.moist:
        ledger = run.ledger
        share = (100.0 * ledger["bridges"] / ledger["initial"]).where(ledger["initial"] > 0, 0.0)
        curves.append(("liquid_in_bridges_percent", "liquid in bridges, %", ledger["time"], share))
    return [{"quantity": of, "title": title, "x": x.tolist(), "y": y.tolist()} for of, title, x, y in curves]


def _blob(arrays: dict[str, NDArray[Any]]) -> tuple[dict[str, tuple[str, int, int]], str]:
    """Return kind, first byte and length of each array by name, as for JavaScript, and all of them deflated, as base64."""
    kinds = {"i1": "Int8", "u1": "Uint8", "i2": "Int16", "u2": "Uint16", "i4": "Int32", "f4": "Float32"}
    layout, whole = {}, b""
    for name, values in arrays.items():
        layout[name] = (f"{kinds[values.dtype.str[1:]]}Array", len(whole), values.size)
        whole += values.tobytes() + bytes(-values.nbytes % 4)
    return layout, base64.b64encode(zlib.compress(whole, 9)).decode()
