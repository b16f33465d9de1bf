"""Contribution of each effect: shares of impulse and energy over the windows, of liquid moved and of ruptures over the run.

The impulse of an effect is the sum of |F| dt over steps and contacts (a bridge or contact counted once), for the
weight over spheres. Its share is relative to weight, capillary and viscous forces that acted together; contact forces
have the same denominator. Energy is the sum of |F·v| dt with the relative motion at the contact; its denominator
includes the dissipation of dry contacts. A viscous or capillary effect that was off is estimated by its usual law for
the recorded motion (`acting` false).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.motion.newton import Forces
from reference_impl.motion.window import Setup
from reference_impl.replay import coverage, laws
from reference_impl.replay.arrays import Floats, dot, size
from reference_impl.replay.bodies import Pairs
from reference_impl.replay.io import Run
from reference_impl.replay.lives import RUPTURE

WET = ("capillary", "viscous_normal", "viscous_tangential")
SWITCHED = (*WET, "liquid_weight")
BEYOND = 0.01
"""Relative excess of the gap over the static distance above which a rupture counts as dynamic."""


class Shares:
    """Sums over the windows, added one after the other."""

    def __init__(self, setup: Setup, run: Run | None) -> None:
        self.setup, self.run = setup, run
        self.windows: list[list[int]] = []
        self._acting = dict.fromkeys(WET, False)
        names = ("weight", "contact_normal", "contact_tangential", "rolling", *SWITCHED)
        self._impulse, self._energy = dict.fromkeys(names, 0.0), dict.fromkeys(names, 0.0)
        self._dissipated = dict.fromkeys(names[1:4], 0.0)
        self._steps, self._long = 0, 0.0

    def add(self, f: Forces) -> None:
        """Add the impulses and energies of one sampling window."""
        self.windows.append([int(f.window.steps[0]), int(f.window.steps[-1])])
        self._steps += len(f.window.steps)
        if f.bridges is not None:
            self._acting = f.bridges.acting
        _totals(self.setup, f, self._impulse, self._energy, self._dissipated)
        if self.run is not None:
            self._long += _beyond_static(self.run, f)

    def result(self, moved: Moved | None) -> dict[str, Any]:
        """Return the content of contributions.json; `moved`: liquid moved by all events of the run."""
        impulse, energy, dissipated = self._impulse, self._energy, self._dissipated
        acting = {**self._acting, "liquid_weight": bool(self.setup.scene["effects"].get("liquid_weight"))}
        on = [name for name in SWITCHED if acting[name]]
        push = impulse["weight"] + sum(impulse[name] for name in on)
        work = energy["weight"] + sum(energy[name] for name in on) + sum(dissipated.values())
        effects: dict[str, dict[str, Any]] = {}
        for name in impulse:
            off = name in SWITCHED and not acting[name]
            more, power = (impulse[name], energy[name]) if off else (0.0, 0.0)
            effects[name] = {
                "acting": not off and (name != "rolling" or bool(self.setup.scene["effects"].get("rolling", True))),
                "impulse_Ns": impulse[name],
                "impulse_share": _share(impulse[name], push + more),
                "energy_J": energy[name],
                "energy_share": _share(energy[name], work + power),
                "dissipated_J": dissipated.get(name),
                "liquid_share": None,
            }
        if self.run is not None and moved is not None:
            effects.update(_liquid(self.run, moved, self._long, push))
        return {
            "windows": self.windows,
            "window_time_s": self.setup.step * self._steps,
            "spheres": len(self.setup.ids),
            "impulse_of_all_Ns": push,
            "energy_of_all_J": work,
            "effects": effects,
        }


def _share(part: float, whole: float) -> float | None:
    return part / whole if whole > 0.0 else None


def _totals(
    setup: Setup, f: Forces, impulse: dict[str, float], energy: dict[str, float], dissipated: dict[str, float]
) -> None:
    """Add a window's impulses, converted energies, and energies that dry contacts dissipated."""
    dt = setup.step
    _weight(setup, f, impulse, energy)
    t, c = f.touches, f.contacts
    normal, side = c.elastic + c.damping, size(c.tangential)
    partner = np.where(t.wall, 0, t.b)
    turn = f.window.w_half[t.k, t.a] - np.where(t.wall[:, None], 0.0, f.window.w_half[t.k, partner])
    ra = setup.radius[t.a]
    arm = np.where(t.wall, ra, ra * setup.radius[partner] / (ra + setup.radius[partner]))
    lost = np.abs(dot(c.rolling, turn))
    for name, force, power, heat in (
        ("contact_normal", np.abs(normal), np.abs(normal * c.vn), -c.damping * c.vn),
        ("contact_tangential", side, np.abs(dot(c.tangential, c.slip)), c.lost),
        ("rolling", size(c.rolling) / arm, lost, lost),
    ):
        impulse[name] += dt * float(force.sum())
        energy[name] += dt * float(power.sum())
        dissipated[name] += dt * float(heat.sum())
    if f.bridges is not None:
        b = f.bridges
        approach = dot(b.relative, b.n)
        for name, force, power in (
            ("capillary", np.abs(b.capillary), np.abs(b.capillary * approach)),
            ("viscous_normal", np.abs(b.normal), np.abs(b.normal * approach)),
            ("viscous_tangential", size(b.tangential), np.abs(dot(b.tangential, b.slip))),
        ):
            impulse[name] += dt * float((b.weight * force).sum())
            energy[name] += dt * float((b.weight * power).sum())


def _weight(setup: Setup, f: Forces, impulse: dict[str, float], energy: dict[str, float]) -> None:
    """Add impulse and energy of the weight of free spheres and of the liquid on them."""
    dry = np.broadcast_to(setup.mass, f.window.liquid.shape)
    for name, mass in (("weight", dry), ("liquid_weight", f.window.liquid)):
        weight = (mass * setup.free)[:, :, None] * setup.pull(f.window.steps)
        impulse[name] += setup.step * float(np.sqrt((weight**2).sum(axis=2)).sum())
        energy[name] += setup.step * float(np.abs((f.window.v_half * weight).sum(axis=2)).sum())


class Sum:
    """A sum over terms in order, so that it does not depend on how they are divided into parts."""

    def __init__(self) -> None:
        self.value = 0.0

    def add(self, terms: Floats) -> None:
        """Add terms to the running sum, one after the other."""
        self.value = float(np.cumsum(np.concatenate([[self.value], terms]))[-1])


@dataclass
class Moved:
    """Sums over events: liquid moved at walls and between spheres, deviation from equal sharing, stretch of ruptures."""

    volume: Sum = field(default_factory=Sum)
    walls: Sum = field(default_factory=Sum)
    pairs: Sum = field(default_factory=Sum)
    unequal: Sum = field(default_factory=Sum)
    stretch: Sum = field(default_factory=Sum)
    ruptures: int = 0
    beyond: int = 0

    def add(self, run: Run, events: pd.DataFrame, p: Pairs) -> None:
        """Add the liquid that the events of one chunk of the log exchange."""
        volume, share, drawn = (events[name].to_numpy(float) for name in ("volume", "share_i", "share_j"))
        broke = events["kind"].to_numpy() == RUPTURE
        shared = broke & ~p.wall
        self.volume.add(volume)
        self.walls.add(np.abs(drawn[p.wall]))
        self.pairs.add(volume[shared])
        self.unequal.add(np.abs(share - 0.5 * volume)[shared])
        self.ruptures += int(broke.sum())
        # computed also if dynamic rupture is off: the contribution that it would have
        if run.meta["surface_tension"] > 0.0:
            speed = events["speed"].to_numpy(float)[broke]
            longer = laws.pitois_factor(speed, run.meta["viscosity"], run.meta["surface_tension"]) - 1.0
            self.stretch.add(longer)
            self.beyond += int((longer > BEYOND).sum())

    def stretched(self, run: Run) -> tuple[float | None, float | None]:
        """Return the mean of limit over static distance minus one at rupture, and the share of ruptures beyond `BEYOND`."""
        if not self.ruptures or run.meta["surface_tension"] <= 0.0:
            return None, None
        return self.stretch.value / self.ruptures, self.beyond / self.ruptures


def _liquid(run: Run, moved: Moved, long: float, push: float) -> dict[str, dict[str, Any]]:
    """Return the effects that move liquid or decide when a bridge ends, from all events of the run."""
    none = {"acting": True, "impulse_Ns": None, "impulse_share": None, "energy_J": None, "energy_share": None}
    none["dissipated_J"] = None
    stretch, beyond = moved.stretched(run)
    return {
        "dynamic_rupture": {
            **none,
            "acting": coverage.law(run, "dynamic_rupture") is not None,
            "impulse_Ns": long,
            "impulse_share": _share(long, push),
            "liquid_share": None,
            "ruptures": moved.ruptures,
            "ruptures_beyond_static": beyond,
            "mean_stretch": stretch,
        },
        "shedding": {**none, "acting": coverage.law(run, "shedding") is not None, "liquid_share": _shed(run)},
        "wall_films": {**none, "liquid_share": _share(moved.walls.value, moved.volume.value)},
        "sharing_by_size": {**none, "liquid_share": _share(moved.unequal.value, moved.pairs.value)},
    }


def _shed(run: Run) -> float:
    """Return the liquid shed as drops over all liquid; a volume that falls twice counts twice."""
    return float(run.shed["volume"].sum() / run.table("spheres")["film"].sum())


def _beyond_static(run: Run, f: Forces) -> float:
    """Return the impulse of bridges longer than their static rupture distance in a window."""
    b = f.bridges
    if b is None or coverage.law(run, "dynamic_rupture") is None or not coverage.known(run, "dynamic_rupture"):
        return 0.0
    limit = b.table["rupture_distance"].to_numpy(float)
    factor = laws.pitois_factor(size(b.relative), run.meta["viscosity"], run.meta["surface_tension"])
    return float(run.meta["time_step"]) * float((b.weight * size(b.force()))[b.gap * factor > limit].sum())
