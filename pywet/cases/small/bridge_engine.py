"""One bridge measured inside the engine: two bodies drawn apart at constant speed, force over separation from the contact log.

Each law has its own run, because laws act as a scene's effects. The query and the remaining results: `bridge_query.py`.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import pandas as pd
from scipy.interpolate import CubicSpline

from pywet.cases.small import small
from pywet.cases.small.bodies import contacts, sphere_classes, water
from pywet.cases.small.bridge_query import DEFAULT, EXACT, Query, answer, film
from pywet.errors import PywetError
from pywet.geometry.surface import Surface
from pywet.laws import registry
from pywet.laws.kinds import PRESETS
from pywet.schema import FORMATION, RUPTURE
from pywet.util.files import read_table

STEPS = 4000
"""Steps from touch to the largest separation; the log is interpolated between them by a cubic spline."""


def measured(
    query: Query, engine: str = "liggghts", stretch: str | None = None, wall: Surface | None = None
) -> dict[str, Any]:
    """Return the answer with force, viscous force, rupture distance and transfer ratio from the engine: liggghts or lammps.

    With a law of dynamic rupture, `stretch`, the rupture distance is that at the query's speed. `wall` replaces
    the plate, with its top at 0.
    """
    answered = answer(query)
    forces: dict[str, list[float | None]] = {}
    viscous: dict[str, list[float | None]] = {}
    distances: dict[str, float | None] = {}
    shares: dict[str, float | None] = {}
    rupture = query.rule
    named, normal = query.named("capillary"), query.named("viscous_normal")
    closed = [name for name in named if name != EXACT]
    runs = [(name, EXACT if name == EXACT else rupture, normal[0]) for name in named]
    drawn = closed[0] if closed else DEFAULT["capillary"]  # viscous forces end by the rule, not with the exact bridge
    runs += [(drawn, rupture, name) for name in (normal[1:] if closed else normal)]
    for capillary, limit, drag in runs:
        with tempfile.TemporaryDirectory(prefix="pywet-bridge-") as folder:
            log, events = _pull(Path(folder), query, capillary, limit, drag, engine, stretch, wall)
        if limit == rupture:
            viscous.setdefault(drag, [None if v is None else -v + 0.0 for v in _at(query, log, "viscous_normal")])
        if capillary not in named:
            continue
        forces.setdefault(capillary, _at(query, log, "capillary"))
        broken = events[events["kind"] == RUPTURE]
        distances.setdefault(limit, float(broken["separation"].iloc[0]) if len(broken) else None)
        shares.setdefault(
            _transfer(limit), float((broken["share_i"] / broken["volume"]).iloc[0]) if len(broken) else None
        )
    answered.update(force_N=forces, viscous_normal_N=viscous, rupture_distance_m=distances, transfer_ratio=shares)
    answered["volume_m3"] = float(events.loc[events["kind"] == FORMATION, "volume"].iloc[0])
    answered["measured_in"] = engine
    return answered


def _transfer(rupture: str) -> str:
    """Return the transfer model that belongs to a rupture law."""
    return PRESETS["exact" if rupture == EXACT else "paper"]["transfer"]


def _pull(
    folder: Path,
    query: Query,
    capillary: str,
    rupture: str,
    drag: str,
    engine: str = "liggghts",
    stretch: str | None = None,
    other: Surface | None = None,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Run the two bodies; contact log and events."""
    ri, rj, ti, tj = query.pair
    wall = query.bodies[1].wall is not None
    forms = (query.named("formation") or [PRESETS["paper"]["formation"]])[0]
    radii, angles = ((ri,), (ti,)) if wall else ((ri, rj), (ti, tj))
    speed = query.velocity_m_per_s if query.velocity_m_per_s > 0.0 else 1e-3
    end = registry.get("rupture", rupture).functions[0](query.volume_m3, ri, rj, ti, tj)
    if stretch is not None:
        end *= registry.get("dynamic_rupture", stretch).functions[0](
            speed, query.viscosity_Pa_s, query.surface_tension_N_per_m
        )
    far = 1.02 * max(*query.separations_m, end)
    liquid = water(film(query, forms), query.viscosity_Pa_s, query.surface_tension_N_per_m)
    start = min(0.0, *query.separations_m) - 4.0 * far / STEPS  # a new bridge acts from the next step on
    moving = small.Sphere(
        1 if wall else 2, (0.0, 0.0, ri + start if wall else ri + rj + start), (0.0, 0.0, speed), driven=True
    )
    bodies = [moving] if wall else [small.Sphere(1, (0.0, 0.0, 0.0), driven=True), moving]
    step = (far - start) / speed / STEPS
    dry = contacts(len(radii), 1.0, friction=0.0, restitution=0.5)  # any contact law: driven bodies ignore it
    laws = {
        "capillary": capillary,
        "rupture": rupture,
        "viscous_normal": drag,
        "dynamic_rupture": stretch,
        "formation": forms,
        "transfer": _transfer(rupture),
    }
    small.prepare(
        folder, sphere_classes(*radii, angle_rad=angles, name="body {k}"), bodies, dry, liquid=liquid,
        effects=small.PAPER.model_copy(update=laws), wall_angle_rad=tj, time_step_s=step, steps=STEPS + 10,
        walls=[other or small.floor(half_side=10 * ri, thickness=2 * ri)] if wall else [], output_interval_s=STEPS * step,
        box=20 * max(radii) + 2 * far,
    )  # fmt: skip
    small.run(folder, bodies, engine=engine, allow_unstable=True)  # both are driven: no force moves them
    history = folder / "history"
    return read_table(history / "contacts.parquet"), read_table(history / "events.parquet")


def _at(query: Query, log: pd.DataFrame, column: str) -> list[float | None]:
    """Interpolate a column of the log at the requested separations; None beyond the rupture of the bridge."""
    if len(log) < 4:
        raise PywetError(
            "the bridge lived for fewer than four steps in the engine; expected a larger volume or more steps",
            code="bridge.short_life",
        )
    gaps, values = log["separation"].to_numpy(), log[column].to_numpy()
    apart = gaps > 0.0  # touch is extrapolated over less than a step: a law may give another force in overlap
    spline = CubicSpline(gaps[apart], values[apart])
    reach = gaps[-1] + (gaps[-1] - gaps[-2])
    return [float(spline(max(s, 0.0))) if s <= reach else None for s in query.separations_m]
