"""Fraction retained and liquid by reservoir of a screening run: Elskamp & Kruggel-Emden 2018, (44), (45)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.replay.arrays import Floats
from reference_impl.tables.recomputed import ALL_THERE, Bodies, Output, Recomputed, accounted, outputs, slug

FEED_BIN, BIN = "feed_bin", "collecting_bin"
NAMES = ("fraction_retained", "liquid_by_holder")


def tables(folder: Path, scene: Mapping[str, Any]) -> Recomputed:
    """Read all outputs of a run once. The slide is the feed bin's floor."""
    of = Bodies.of(folder, scene, lambda wall: FEED_BIN if wall["reservoir"] == "slide" else wall["reservoir"])
    passed, back = np.zeros(len(of.ids), bool), np.zeros(len(of.ids), bool)
    opening = scene["slide"]["opens_at_s"] if scene["slide"] else 0.0
    rows: list[tuple[dict[str, float], dict[str, float]]] = []
    for o in outputs(folder, scene, of, ["z"]):
        below = np.zeros(len(of.ids), bool)
        below[o.at] = o.places["z"] < scene["bin_z_m"]
        passed |= below
        back |= passed & o.here & ~below
        time = o.step * scene["time_step_s"]
        stamp = {"step": float(o.step), "time_s": time, "time_since_opening_s": time - opening}
        rows.append(({**stamp, **_retained(of, o, passed)}, {**stamp, **_held(of, o, passed)}))
    y, liquid = (pd.DataFrame([row[k] for row in rows]) for k in (0, 1))
    return _recomputed(of, scene, y, liquid, int(back.sum()))


def _retained(of: Bodies, o: Output, passed: Floats) -> dict[str, float]:
    """Return one row of Y(t): mass of spheres and liquid that is not in the bin over that at the start."""
    above = o.here & ~passed
    wet, start = of.mass + of.density * o.on, of.mass + of.density * of.film
    outside = sum(amount for name, amount in zip(of.walls, o.walls, strict=True) if name != BIN)
    row = {
        "fraction_retained": (wet[above].sum() + of.density * outside) / start.sum(),
        "fraction_retained_spheres": of.mass[above].sum() / of.mass.sum(),
    }
    for kind, name in of.names.items():
        of_class = of.kind == kind
        if of_class.any():
            row[f"fraction_retained_{slug(name)}"] = wet[above & of_class].sum() / start[of_class].sum()
    counts = {"on_screen": above, "in_bin": o.here & passed, "lost": ~o.here}
    return {**row, **{f"spheres_{name}": float(rows.sum()) for name, rows in counts.items()}}


def _held(of: Bodies, o: Output, passed: Floats) -> dict[str, float]:
    """Return one row of the distribution of liquid [m3]."""
    row, total = {}, o.left + o.walls.sum()
    for name, rows in (("coarse_material", o.here & ~passed), ("fines", o.here & passed)):
        row[f"{name}_m3"] = o.on[rows].sum()
        total += row[f"{name}_m3"]
        row |= {f"{name}_{slug(c)}_m3": o.on[rows & (of.kind == kind)].sum() for kind, c in of.names.items()}
    row |= {f"{name}_m3": amount for name, amount in zip(of.walls, o.walls, strict=True)}
    all_of = {"left": o.left, "total": total, "standing_bridges": o.in_bridges, "initial": of.film.sum()}
    return {**row, **{f"{name}_m3": amount for name, amount in all_of.items()}}


def _recomputed(
    of: Bodies, scene: Mapping[str, Any], y: pd.DataFrame, liquid: pd.DataFrame, came_back: int
) -> Recomputed:
    """Return the results with the checks of every run.

    No sphere is lost, Y never rises (except by drawn liquid), and all liquid is accounted for.
    """
    seen, count = y["spheres_on_screen"] + y["spheres_in_bin"], len(of.ids)
    initial, mass = float(of.film.sum()), float(of.mass.sum())
    lost, wet = float((count - seen).abs().max()), initial * of.density
    return Recomputed(
        tables=dict(zip(NAMES, (y, liquid), strict=True)),
        liquid=liquid,
        checks={
            "no_particle_lost": lost,
            "fraction_retained_monotone": max(0.0, float(np.diff(y["fraction_retained"]).max(initial=0.0))),
            "liquid_accounted_for": accounted(liquid, initial),
        },
        limits={
            "no_particle_lost": 0.0,
            "fraction_retained_monotone": 1e-12 + 1e-3 * wet / (mass + wet),
            "liquid_accounted_for": ALL_THERE,
        },
        printed=[count, int(seen.iloc[-1]), int(lost)],
        more={
            "fraction_retained_end": (float(y["fraction_retained"].iloc[-1]), "the raw logs"),
            "coarse_share": (_coarse(scene), "scene.json"),
            "spheres_that_came_back_from_the_bin": (came_back, "the raw logs"),
        },
        ends=None,
        mass=mass,
        initial=initial,
        counts=of.counts(np.ones(count, bool)),
    )


def _coarse(scene: Mapping[str, Any]) -> float:
    """Return the mass share of the classes that are larger than the aperture."""
    mass = [c["count"] * c["density_kg_per_m3"] * c["radius_m"] ** 3 for c in scene["classes"]]
    stays = [m for m, c in zip(mass, scene["classes"], strict=True) if not c.get("passes_aperture", True)]
    return float(sum(stays) / sum(mass))
