"""Results of a user-defined scene: liquid by named wall, contact statistics, checks, summary."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.cases.custom.at_walls import PRESSED, AtWalls
from pywet.cases.screening.results import LIQUID_TOLERANCE, Check, at_end, at_most
from pywet.geometry import periodic
from pywet.products import screening_report, until
from pywet.products.streams import PRODUCTS, decks
from pywet.runs.retired import taken_out
from pywet.runs.rundir import Bools, Floats, RunDir
from pywet.runs.summary import general
from pywet.scene import EngineScene
from pywet.schema import column
from pywet.util.files import write_json, write_table
from pywet.util.notices import notice

STATISTICS = (
    "contacts_per_sphere", "mean_overlap", "largest_overlap", "walls_per_sphere", "mean_wall_overlap", "largest_wall_overlap",
    "largest_wall_penetration", "bridges_per_sphere", "mean_speed_m_per_s", "largest_speed_m_per_s", "centre_of_mass_height_m",
)  # fmt: skip
"""Columns of contact_statistics other than step and time."""


def liquid_by_wall(run: RunDir) -> pd.DataFrame:
    """Liquid [m3] at the outputs on each class of spheres and each wall, active bridges shared between their ends.

    Only spheres that have entered and not left are counted; `initial_m3` is the liquid that has entered so far,
    `outlet_…_m3` the liquid that has left at an outlet.
    """
    scene, line = run.scene, run.timeline
    gone, booked = taken_out(run)
    on = line.liquid - np.where(line.entered, 0.0, line.initial_film)
    on[_left(run, gone)] = 0.0
    frame = pd.DataFrame({"step": line.steps, "time_s": line.times})
    for kind in scene.classes:
        frame[column("spheres", kind.name, "_m3")] = on[:, line.types == kind.type].sum(axis=1)
    for name, held in run.on_walls({wall.name: wall.name for wall in scene.walls}, "mesh").items():
        frame[f"wall_{name}_m3"] = held.to_numpy()
    for k, outlet in enumerate(scene.outlets):
        frame[f"outlet_{outlet.name}_m3"] = booked[:, k]
    frame["left_m3"] = run.ledger_at("left")
    frame["total_m3"] = frame.drop(columns=["step", "time_s"]).sum(axis=1)
    frame["standing_bridges_m3"] = run.ledger_at("bridges")
    frame["initial_m3"] = line.put_in
    return frame


def _left(run: RunDir, gone: Bools) -> Bools:
    """Return whose liquid has left: spheres from the output of their removal on, and at the last output those in an outlet."""
    if not run.scene.outlets:
        return gone
    table, line = run.table("history/retired"), run.timeline
    found = gone.copy()
    found[np.searchsorted(line.steps, table["step"]), np.searchsorted(line.ids, table["id"])] = True
    return found


def contact_statistics(run: RunDir) -> pd.DataFrame:
    """At the outputs: touching spheres per sphere, overlaps over the smaller radius, bridges per sphere, speeds, centre of mass.

    For walls: number touched per sphere, overlaps over the radius, the largest over the wall's thickness. Only spheres that
    have entered and not left are counted.
    """
    scene, rows, walls, line = run.scene, [], AtWalls(run), run.timeline
    radius_of = np.array([c.radius_m for c in scene.classes])
    ledger = run.ledger.set_index("step")["bridge_count"] if run.moist else None
    up = -np.array(scene.gravity_m_per_s2) / max(float(np.linalg.norm(scene.gravity_m_per_s2)), 1e-300)
    mass = np.array([c.mass_kg for c in scene.classes])
    for step, entered in zip(line.steps.tolist(), line.entered, strict=True):
        here = run.trajectory[run.trajectory["step"] == step]
        here = here[here["id"].isin(line.ids[entered])]
        if here.empty:  # none has entered, or all have left
            rows.append({"step": step, "time_s": step * scene.time_step_s, **dict.fromkeys(STATISTICS, 0.0)})
            continue
        at, kind = here[[*"xyz"]].to_numpy(), here["type"].to_numpy() - 1
        speed = np.linalg.norm(here[["vx", "vy", "vz"]].to_numpy(), axis=1)
        overlap = _overlaps(at, radius_of[kind], run.scene)
        at_walls, pressed = walls.overlaps(step, at, radius_of[kind])
        rows.append(
            {
                "step": step,
                "time_s": step * scene.time_step_s,
                "contacts_per_sphere": 2.0 * len(overlap) / len(at),
                "mean_overlap": float(overlap.mean()) if len(overlap) else 0.0,
                "largest_overlap": float(overlap.max(initial=0.0)),
                "walls_per_sphere": len(at_walls) / len(at),
                "mean_wall_overlap": float(at_walls.mean()) if len(at_walls) else 0.0,
                "largest_wall_overlap": float(at_walls.max(initial=0.0)),
                "largest_wall_penetration": float(pressed.max(initial=0.0)),
                "bridges_per_sphere": 2.0 * float(ledger[step]) / len(at) if ledger is not None else 0.0,
                "mean_speed_m_per_s": float(speed.mean()),
                "largest_speed_m_per_s": float(speed.max()),
                "centre_of_mass_height_m": float(np.average((at + run.origin_m) @ up, weights=mass[kind])),
            }
        )
    return pd.DataFrame(rows)


def _overlaps(at: Floats, radius: Floats, scene: EngineScene) -> Floats:
    """Overlap over the smaller radius of every pair of spheres that touches."""
    i, j = periodic.near_pairs(at, 2.0 * radius.max(), scene.box_low_m, scene.periods_m).T
    apart = np.linalg.norm(periodic.nearest(at[i] - at[j], scene.periods_m), axis=1)
    depth = (radius[i] + radius[j] - apart) / np.minimum(radius[i], radius[j])
    return np.asarray(depth[depth > 0.0])


def checks(run: RunDir, liquid: pd.DataFrame) -> list[Check]:
    """Check that no sphere is lost and that the tables account for all liquid."""
    line, initial = run.timeline, float(run.timeline.put_in[-1])
    missing = int((~line.present & ~taken_out(run)[0]).sum(axis=1).max())
    error = float((liquid["total_m3"] - liquid["initial_m3"]).abs().max(skipna=False)) / initial if initial > 0 else 0.0
    return [
        at_most("no_particle_lost", missing, 0, f"{line.entered_by_end.sum()} spheres in, {missing} missing at most"),
        at_most(
            "liquid_accounted_for", error, LIQUID_TOLERANCE,
            f"the sum over spheres and walls differs from the total liquid by at most {error:.3g} of it",
        ),
    ]  # fmt: skip


def warnings(touching: pd.DataFrame, hertz: bool = False) -> list[str]:
    """Return warnings for spheres that are pressed deep into walls, from `contact_statistics`."""
    through = touching["largest_wall_penetration"].to_numpy(dtype=float)
    deepest = int(through.argmax())
    if through[deepest] < PRESSED:
        return []
    at = float(touching["time_s"].to_numpy(dtype=float)[deepest])
    stiffness = "youngs_modulus_Pa" if hertz else "stiffness_N_per_m"
    return [
        f"at {at:.3g} s a sphere overlaps a wall by {100 * through[deepest]:.0f} % of the wall's "
        f"thickness and may come out at its far side; expected less than {100 * PRESSED:.0f} %: raise {stiffness} or "
        "make the wall thicker"
    ]


def write(run_dir: Path) -> dict[str, Any]:
    """Write results/liquid_by_wall and results/contact_statistics (Parquet and CSV) and summary.json; returns the summary."""
    run = RunDir(Path(run_dir))
    liquid, touching = liquid_by_wall(run), contact_statistics(run)
    write_table(liquid, run.path / "results" / "liquid_by_wall.parquet", csv=True)
    write_table(touching, run.path / "results" / "contact_statistics.parquet", csv=True)
    summary = {
        **general(run),
        "liquid_end_m3": at_end(liquid),
        "contacts_end": {str(k): float(v) for k, v in touching.iloc[-1].drop(["step", "time_s"]).items()},
        "checks": [asdict(c) for c in checks(run, liquid)],
        "warnings": warnings(touching, run.scene.hertz is not None),
    }
    for sentence in summary["warnings"]:
        notice.warning("%s: %s", run.scene.name, sentence)
    write_json(run.path / "summary.json", summary)
    if {o.product for o in run.scene.outlets} >= {*PRODUCTS}:
        for deck in range(1, decks(run.scene) + 1):
            screening_report.write(run.path, deck=deck)
    if run.scene.blocks:
        until.write(run)
    return summary
