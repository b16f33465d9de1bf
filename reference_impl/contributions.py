"""What each effect contributed: shares of impulse and energy over the windows, of liquid moved and of ruptures over the run.

Impulse of an effect: sum of |F| dt over steps and contacts (a bridge or contact counted once), for the weight over spheres. Its
share is relative to weight, capillary and viscous forces that acted together; contact forces have the same denominator. Energy:
sum of |F·v| dt with the relative motion at the contact; its denominator holds what dry contacts dissipate as well. A viscous or
capillary effect that was off is judged by its usual law on the motion that was (`acting` false): what it would have done.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from reference_impl import coverage, laws
from reference_impl.compare import Floats
from reference_impl.dry import dot, size
from reference_impl.io import Run
from reference_impl.newton import Forces
from reference_impl.window import Setup

WET = ("capillary", "viscous_normal", "viscous_tangential")
BEYOND = 0.01
"""A rupture counts as dynamic where the gap exceeds the static distance by more than this part of it."""


def measure(setup: Setup, run: Run | None, found: list[Forces]) -> dict[str, Any]:
    """The content of contributions.json."""
    impulse, energy, dissipated = _totals(setup, found)
    acting = found[0].bridges.acting if found and found[0].bridges is not None else dict.fromkeys(WET, False)
    on = [name for name in WET if acting[name]]
    push = impulse["weight"] + sum(impulse[name] for name in on)
    work = energy["weight"] + sum(energy[name] for name in on) + sum(dissipated.values())
    effects: dict[str, dict[str, Any]] = {}
    for name in impulse:
        off = name in WET and not acting[name]
        more, power = (impulse[name], energy[name]) if off else (0.0, 0.0)
        effects[name] = {
            "acting": not off and (name != "rolling" or bool(setup.scene["effects"].get("rolling", True))),
            "impulse_Ns": impulse[name],
            "impulse_share": _share(impulse[name], push + more),
            "energy_J": energy[name],
            "energy_share": _share(energy[name], work + power),
            "dissipated_J": dissipated.get(name),
            "liquid_share": None,
        }
    if run is not None:
        effects.update(_liquid(run, found, push))
    windows = [[int(f.window.steps[0]), int(f.window.steps[-1])] for f in found]
    return {
        "windows": windows,
        "window_time_s": setup.step * sum(len(f.window.steps) for f in found),
        "spheres": len(setup.ids),
        "impulse_of_all_Ns": push,
        "energy_of_all_J": work,
        "effects": effects,
    }


def _share(part: float, whole: float) -> float | None:
    return part / whole if whole > 0.0 else None


def _totals(setup: Setup, found: list[Forces]) -> tuple[dict[str, float], dict[str, float], dict[str, float]]:
    """Impulses, energies turned over, energies that dry contacts dissipated; all windows together."""
    names = ("weight", "contact_normal", "contact_tangential", "rolling", *WET)
    impulse, energy, dissipated = dict.fromkeys(names, 0.0), dict.fromkeys(names, 0.0), dict.fromkeys(names[1:4], 0.0)
    dt = setup.step
    for f in found:
        _weight(setup, f, impulse, energy)
        t, c = f.touches, f.contacts
        normal, side, sliding = c.elastic + c.damping, size(c.tangential), c.slid / dt
        partner = np.where(t.wall, 0, t.b)
        turn = f.window.w_half[t.k, t.a] - np.where(t.wall[:, None], 0.0, f.window.w_half[t.k, partner])
        ra = setup.radius[t.a]
        arm = np.where(t.wall, ra, ra * setup.radius[partner] / (ra + setup.radius[partner]))
        lost = np.abs(dot(c.rolling, turn))
        for name, force, power, heat in (
            ("contact_normal", np.abs(normal), np.abs(normal * c.vn), -c.damping * c.vn),
            ("contact_tangential", side, np.abs(dot(c.tangential, c.slip)), side * sliding),
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
    return impulse, energy, dissipated


def _weight(setup: Setup, f: Forces, impulse: dict[str, float], energy: dict[str, float]) -> None:
    """Of the spheres that are not driven."""
    weight = (setup.mass * setup.free)[:, None] * setup.gravity
    impulse["weight"] += setup.step * len(f.window.steps) * float(size(weight).sum())
    energy["weight"] += setup.step * float(np.abs((f.window.v_half * weight).sum(axis=2)).sum())


def _liquid(run: Run, found: list[Forces], push: float) -> dict[str, dict[str, Any]]:
    """Effects that move liquid or decide when a bridge ends: from all events of the run."""
    events = run.table("events")
    wall = (events["partner_kind"] != laws.SPHERE).to_numpy()
    broke = (events["kind"] == 1).to_numpy()
    volume, share = events["volume"].to_numpy(float), events["share_i"].to_numpy(float)
    drawn = events["share_j"].to_numpy(float)
    pairs = broke & ~wall
    unequal = float(np.abs(share - 0.5 * volume)[pairs].sum())
    stretch, beyond = _stretch(run, broke)
    none = {"acting": True, "impulse_Ns": None, "impulse_share": None, "energy_J": None, "energy_share": None}
    none["dissipated_J"] = None
    long = _beyond_static(run, found)
    return {
        "dynamic_rupture": {
            **none,
            "acting": coverage.law(run, "dynamic_rupture") is not None,
            "impulse_Ns": long,
            "impulse_share": _share(long, push),
            "liquid_share": None,
            "ruptures": int(broke.sum()),
            "ruptures_beyond_static": beyond,
            "mean_stretch": stretch,
        },
        "wall_films": {**none, "liquid_share": _share(float(np.abs(drawn[wall]).sum()), float(volume.sum()))},
        "sharing_by_size": {**none, "liquid_share": _share(unequal, float(volume[pairs].sum()))},
    }


def _stretch(run: Run, broke: Floats) -> tuple[float | None, float | None]:
    """Mean of limit over static distance less one at rupture, and the share of ruptures where that is beyond `BEYOND`.

    The limit is that of the speed at rupture also where dynamic rupture was off: then what it would have been.
    """
    events = run.table("events")[broke]
    if not len(events) or run.meta["surface_tension"] <= 0.0:
        return None, None
    factor = laws.pitois_factor(events["speed"].to_numpy(float), run.meta["viscosity"], run.meta["surface_tension"])
    return float(factor.mean() - 1.0), float((factor - 1.0 > BEYOND).mean())


def _beyond_static(run: Run, found: list[Forces]) -> float:
    """Impulse of bridges longer than their static rupture distance."""
    total, dt = 0.0, float(run.meta["time_step"])
    if coverage.law(run, "dynamic_rupture") is None or not coverage.known(run, "dynamic_rupture"):
        return total
    for f in found:
        b = f.bridges
        if b is None:
            continue
        limit = b.table["rupture_distance"].to_numpy(float)
        factor = laws.pitois_factor(size(b.relative), run.meta["viscosity"], run.meta["surface_tension"])
        total += dt * float((b.weight * size(b.force()))[b.gap * factor > limit].sum())
    return total
