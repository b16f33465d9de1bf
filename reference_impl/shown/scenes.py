"""Compare the 3-D scenes of a page, decoded as by its script, with the raw logs of their runs, time by time.

The rendering of these numbers by the script is not checked.
"""

from __future__ import annotations

import base64
import html
import json
import re
import zlib
from collections.abc import Collection, Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from reference_impl.replay import io, retired
from reference_impl.replay.arrays import Floats
from reference_impl.replay.formations import thickness
from reference_impl.replay.stream import Rows
from reference_impl.shown.logs import Logs

SCENE = re.compile(r'<script type="application/json" class="run" data-name="(.*?)">(.*?)</script>', re.DOTALL)
KINDS = {"Int32Array": "<i4", "Int16Array": "<i2", "Uint16Array": "<u2", "Uint8Array": "u1", "Float32Array": "<f4"}
LEVELS = 65535
"""Number of levels of a film or a speed, up to the largest of the scene."""
ROUNDED = 0.51
"""Rounding error in units of a level or of the smallest length."""
SINGLE = 1e-6
"""Relative error of numbers in single precision, with a margin."""
SEEN = 3e-2
"""Relative difference of two quadratures of a volume with an edge where bodies overlap; at most 1.2e-2 was observed."""
SOLID, HIDDEN = {"wires", "impact_plate"}, {"feed_bin", "slide"}
OTHER_WALL, WIRE = -1, -2
WIRES = 2
"""Value of partner_kind of a bridge at a wire."""
NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)


def check(text: str, folder: Path, expected: Collection[str] = ()) -> tuple[int, list[str]]:
    """Count the numbers in the scenes of a page and list errors; runs are folders in `folder` with the names shown.

    `expected`: runs that must have a scene.
    """
    found = [(html.unescape(name), data) for name, data in SCENE.findall(text)]
    wrong = [f"scene of {name}: there is none" for name in expected if name not in {name for name, _ in found}]
    count = 0
    for name, data in found:
        run = folder / name
        scene = Scene(json.loads(data), Logs(run))
        wrong += [f"scene of {run.name}: {message}" for message in scene.wrong()]
        count += scene.count
    return count, wrong


class Scene:
    """One run as contained in a page, with its logs."""

    def __init__(self, head: dict[str, Any], logs: Logs) -> None:
        self.head, self.logs = head, logs
        whole = zlib.decompress(base64.b64decode(head["data"]))
        self.arrays = {n: np.frombuffer(whole, KINDS[k], size, at) for n, (k, at, size) in head["arrays"].items()}
        self.count = sum(a.size for a in self.arrays.values()) + sum(len(c["x"]) for c in head["curves"])
        self.rows = len(self.arrays["id"])

    def places(self, name: str) -> Floats:
        """Decode the points of an array of a 3-D scene [m]."""
        return np.asarray(self.head["origin"] + self.head["quantum"] * self.arrays[name].reshape(-1, 3).astype(float))

    @cached_property
    def steps(self) -> list[int]:
        """Return the output step nearest to each time shown."""
        outputs = np.asarray(self.logs.outputs)
        expected = outputs * self.logs.scene["time_step_s"]
        return [int(outputs[np.abs(expected - time).argmin()]) for time in self.head["times"]]

    def wrong(self) -> Iterator[str]:
        """Describe the errors of the 3-D scenes in sentences, the first of each kind."""
        reported: set[str] = set()
        for what, where in self._all():
            if what not in reported:
                reported.add(what)
                yield f"{what}{where}"

    def _all(self) -> Iterator[tuple[str, str]]:
        step = self.logs.scene["time_step_s"]
        expected = np.array(self.steps) * step
        if np.abs(np.array(self.head["times"]) - expected).max() > SINGLE * max(expected[-1], step):
            yield "times are not those of the outputs", ""
        for what in self._bodies():
            yield what, ""
        in_bridges = []
        for frame, at in enumerate(self.steps):
            for what in (*self._spheres(frame, at), *self._bridges(frame, at), *self._walls(frame, at)):
                yield what, f" at t = {self.head['times'][frame]:.4g} s"
            in_bridges.append(self._in_bridges(at))
        for what in self._curves(in_bridges):
            yield what, ""

    def _bodies(self) -> Iterator[str]:
        if self.rows != len(self.logs.ids) or not np.array_equal(self.arrays["id"], self.logs.ids):
            yield "numbers of the spheres are not those of the run"
            return
        if not np.allclose(self.arrays["radius"], self.logs.radius, rtol=SINGLE, atol=0.0):
            yield "radii are wrong"
        if not np.array_equal(self.arrays["class"], self.logs.kind - 1):
            yield "size classes are wrong"
        names = [c["name"] for c in self.logs.scene["classes"]]
        if self.head["classes"] != names:
            yield f"classes are called {', '.join(self.head['classes'])}; expected {', '.join(names)}"

    def _of(self, name: str, frame: int, each: int = 1) -> np.ndarray[Any, Any]:
        return self.arrays[name][each * self.rows * frame :][: each * self.rows]

    def _spheres(self, frame: int, step: int) -> Iterator[str]:
        moment = self.logs.at(step)
        here = np.searchsorted(self.logs.ids, moment.ids)
        there = np.zeros(self.rows, bool)
        there[here] = True
        if not np.array_equal(self._of("there", frame).astype(bool), there):
            yield "spheres are shown that are not there, or not shown"
        head = self.head
        place = head["origin"] + head["quantum"] * self._of("place", frame, 3).reshape(-1, 3)[here].astype(float)
        if (wrong := _off(place, moment.place, ROUNDED * head["quantum"])).any():
            yield f"places are wrong{self._elsewhere(place, step)}, of {wrong.any(axis=1).sum()} spheres"
        film, speed = thickness(moment.film, moment.radius), np.linalg.norm(moment.speed, axis=1)
        for name, expected in (("film", film), ("speed", speed)):
            most = head[f"{name}_most"]
            shown = self._of(name, frame)[here] * (most / LEVELS)
            if (wrong := _off(shown, expected, (ROUNDED / LEVELS + SINGLE) * most + 1e-15)).any():
                yield f"{name} is wrong{_factor(shown, expected)}, of {wrong.sum()} spheres"

    def _elsewhere(self, place: Floats, step: int) -> str:
        """Return a phrase if the positions are those of the previous or next output, or time shown."""
        for steps in (self.logs.outputs.tolist(), self.steps):
            k = steps.index(step)
            for other in {*steps[max(0, k - 1) : k + 2]} - {step}:
                at = self.logs.at(other).place
                if at.shape == place.shape and not _off(at, place, self.head["quantum"]).any():
                    return f": those of step {other}"
        return ""

    def _bridges(self, frame: int, step: int) -> Iterator[str]:
        expected = self.logs.at(step).bridges.frame()
        first, last = (self.head["starts"][k] if k < len(self.head["starts"]) else 0 for k in (frame, frame + 1))
        if last - first != len(expected):
            yield f"{last - first} bridges are shown; expected {len(expected)}"
            return
        if not len(expected):
            return
        ends = [expected[[f"{end}_{axis}" for axis in "xyz"]].to_numpy(float) for end in ("xi", "xj")]
        kind = expected["partner_kind"].to_numpy()
        i, j = (np.searchsorted(self.logs.ids, expected[end].to_numpy()) for end in "ij")
        j = np.where(kind == 0, j, np.where(kind == WIRES, WIRE, OTHER_WALL))
        mine, theirs = (
            np.stack(pair) for pair in ((i, j), (self.arrays["i"][first:last], self.arrays["j"][first:last]))
        )
        if not np.array_equal(mine, theirs):
            yield "bridges join other bodies than in the log"
            return
        side = self.arrays["side"][first:last].astype(float)
        ri = self.logs.radius[i]
        rj = np.where(kind == 0, self.logs.radius[np.maximum(j, 0)], np.inf)
        apart = expected["separation"].to_numpy(float) + ri + np.where(kind == 0, rj, 0.0)
        free = side < (1.0 - SINGLE) * np.sqrt(2.0) * np.minimum(ri, rj)  # otherwise it is as wide as its sphere
        volume = expected["volume"].to_numpy(float)
        if _off(_seen(side, apart, ri, rj)[free], volume[free], SEEN * volume[free]).any():
            yield "bridges have another volume to be seen than they hold"
        along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0], axis=1)[:, None]
        deep = [np.sqrt(r**2 - np.minimum(side**2 / 2.0, r**2)) for r in (ri, np.where(np.isfinite(rj), rj, 0.0))]
        begins, finishes = deep[0], np.maximum(apart - np.where(np.isfinite(rj), deep[1], 0.0), deep[0])
        for name, far in (("from", begins), ("to", finishes)):
            if _off(self.places(name)[first:last], ends[0] + far[:, None] * along, 2.0 * self.head["quantum"]).any():
                yield "bridges do not end at their bodies"
                return

    def _walls(self, frame: int, step: int) -> Iterator[str]:
        if not len(self.logs.triangles):
            return
        expected, rest = self.logs.corners(step), self.places("corners").reshape(-1, 3, 3)
        shown = np.full_like(expected, np.nan)
        for mesh in self.head["meshes"]:
            rows, moved = mesh["triangles"], np.reshape(mesh["moved"][frame], (3, 4))
            shown[rows] = rest[rows] @ moved[:, :3].T + moved[:, 3]
            reservoirs = set(self.logs.triangles["reservoir"].iloc[rows])
            if (mesh["solid"], mesh["hidden"]) != (reservoirs <= SOLID, reservoirs <= HIDDEN):
                yield f"walls of {', '.join(sorted(reservoirs))} are drawn as others are"
        if np.isnan(shown).any() or _off(shown, expected, 2.0 * self.head["quantum"]).any():
            yield "walls are not where the log says"

    def _curves(self, in_bridges: list[float]) -> Iterator[str]:
        """Check values at the times of the scene, and all times; the share of liquid in bridges is that of each time [%]."""
        outputs = np.asarray(self.logs.outputs) * self.logs.scene["time_step_s"]
        expected = {"fraction_retained_spheres": self._retained()} if self.logs.scene.get("slide") else self._left()
        if self.logs.plan.moist:
            expected["liquid_in_bridges_percent"] = in_bridges
        if [c["quantity"] for c in self.head["curves"]] != list(expected):
            yield f"curves are of {[c['quantity'] for c in self.head['curves']]}; expected {list(expected)}"
            return
        for curve in self.head["curves"]:
            if len(curve["x"]) != len(outputs) or not np.allclose(curve["x"], outputs, rtol=SINGLE, atol=1e-12):
                yield f"times of the curve {curve['quantity']} are not those of the outputs"
                continue
            for step, right in zip(self.steps, expected[curve["quantity"]], strict=True):
                value = curve["y"][int(np.searchsorted(self.logs.outputs, step))]
                if abs(value - right) > SINGLE * max(1.0, abs(value)):
                    yield f"the curve {curve['quantity']} is wrong at t = {step * self.logs.scene['time_step_s']:.4g} s"
                    break

    def _retained(self) -> list[float]:
        """Return, at the times of the scene, the mass that has never been below the bin's edge, over that of all spheres."""
        mass = self._masses()
        stream = Rows(io.where(self.logs.folder, "trajectory"), "trajectory", ["step", "id", "z"])
        edge = self.logs.scene.get("bin_z_m")
        above, values = np.ones(self.rows, bool), []
        for step in self.steps:
            rows = stream.until(step)
            if edge is not None:
                above[np.searchsorted(self.logs.ids, rows["id"][rows["z"] < edge].to_numpy())] = False
            values.append(float(mass[above].sum() / mass.sum()))
        return values

    def _left(self) -> dict[str, list[float]]:
        """Return, at the times of the scene, the mass that has left by each product over that of all that has entered."""
        outlets = self.logs.scene.get("outlets") or []
        names = {k: f"left_{o.get('product') or o['name']}" for k, o in enumerate(outlets, start=1)}
        found: dict[str, list[float]] = {name: [] for name in names.values()}
        if not found:
            return found
        gone, mass = retired.table(self.logs.folder), self._masses()
        by, kg = gone["outlet"].map(names), mass[np.searchsorted(self.logs.ids, gone["id"])]
        for step in self.steps:
            entered = float(mass[self.logs.enters <= step].sum())
            for name, values in found.items():
                left = float(kg[(by == name) & (gone["step"] <= step)].sum())
                values.append(left / entered if entered else 0.0)
        return found

    def _in_bridges(self, step: int) -> float:
        """Return the share of the liquid put in until a step that is in bridges then [%]."""
        put_in = float(self.logs.film[self.logs.enters <= step].sum())
        volume = self.logs.at(step).bridges
        return float(100.0 * volume["volume"].sum() / put_in) if len(volume) and put_in else 0.0

    def _masses(self) -> Floats:
        """Return the mass of every sphere over 4 pi/3."""
        density = {c["type"]: c["density_kg_per_m3"] for c in self.logs.scene["classes"]}
        return np.asarray(self.logs.radius**3 * np.array([density[k] for k in self.logs.kind]))


def _off(shown: Floats, expected: Floats, limit: Any) -> np.ndarray[Any, Any]:
    return np.asarray(~(np.abs(shown - expected) <= limit))


def _factor(shown: Floats, expected: Floats) -> str:
    """Return a phrase if all values are wrong by one factor."""
    known = expected > 0.05 * expected.max() if len(expected) else np.zeros(0, bool)
    if not known.any():
        return ""
    ratio = shown[known] / expected[known]
    return f": {np.median(ratio):.4g} times what it is" if np.ptp(ratio) < 1e-2 * abs(np.median(ratio)) else ""


def _seen(side: Floats, apart: Floats, ri: Floats, rj: Floats) -> Floats:
    """Return the volume [m3] of a square bar between two centres that is outside both spheres; rj infinite: up to a plane."""
    y = side[:, None] * NODES / 2.0
    square = y[:, :, None] ** 2 + y[:, None, :] ** 2

    def reach(radius: Floats) -> Floats:
        r = np.where(np.isfinite(radius), radius, 0.0)[:, None, None]
        return np.asarray(np.sqrt(np.maximum(r**2 - square, 0.0)))

    height = np.maximum(apart[:, None, None] - reach(ri) - reach(rj), 0.0)
    return np.asarray(side**2 / 4.0 * np.einsum("nij,i,j->n", height, WEIGHTS, WEIGHTS))
