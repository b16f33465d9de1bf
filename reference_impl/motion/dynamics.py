"""Check Newton's law, contributions and the interpolation of the transfer table as parts of a replay."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from reference_impl.diagnosis import diagnosis
from reference_impl.diagnosis import motion as links_motion
from reference_impl.motion import budget, contributions, newton, pushes, window
from reference_impl.replay import between_nodes, io, stored_tables, whole
from reference_impl.replay.compare import Quantity, merged

MOTION = {"newton_force", "newton_torque", "wall_closest_point", "contact_spring", "contact_logged", *pushes.SCALES}
"""Quantities whose faults are looked for in the motion."""


def check(
    run_dir: Path, run: io.Run | None, moved: contributions.Moved | None = None, between: Sequence[Quantity] = ()
) -> tuple[list[Quantity], dict[str, Any]]:
    """Return quantities and entries for replay.json; writes contributions.json next to it.

    `moved` and `between`: liquid moved by the events, and the errors of the transfer table between its nodes.
    """
    folder = Path(run_dir)
    found: list[Quantity] = []
    more: dict[str, Any] = {"newton": None, "transfer_interpolation": None}
    if between and run is not None:
        if between_nodes.judged(run):
            found += between
        else:
            more["transfer_interpolation"] = {**between[0].as_dict(), "note": between_nodes.note(between[0])}
    setup = window.read(folder)
    found += [*stored_tables.mesh_motion(setup), *stored_tables.times(setup, run is not None)]
    if not window.recorded(folder):
        return found, more
    found += stored_tables.velocities(setup)
    works = run is not None and not setup.foreign and budget.judged(run)
    shares, counts = contributions.Shares(setup, run), Counter[str]()
    parts: dict[str, list[Quantity]] = {}
    waiting: list[newton.Compared] = []  # of short windows, compared in one batch
    small = io.small(io.where(folder, "trajectory"), "trajectory")
    for f in newton.each(setup, run):  # one window at a time, because its forces take much memory
        io.note(f"window from step {f.window.steps[0]}")
        shares.add(f)
        counts.update({"foreign": len(f.touches)} if setup.foreign else f.counts)
        first, last = shares.windows[-1]
        if small is not None:
            table = small[(small["step"] >= first) & (small["step"] <= last)]
        else:
            table = io.table(
                io.where(folder, "trajectory"), "trajectory", [("step", ">=", first), ("step", "<=", last)]
            )
        common = whole.trajectory(newton.places(setup, [f]), table) if len(table) else []
        in_windows = [replace(q, name="trajectory_in_windows") for q in common]
        of_works = budget.in_window(setup, f, run) if works and run is not None else []
        waiting.append(newton.compared(setup, f))
        full = sum(len(part[0]) for one in waiting for part in one.values()) > io.FEW
        for q in (*(newton.quantities(setup, waiting) if full else ()), *in_windows, *of_works):
            parts.setdefault(q.name, []).append(q)
        waiting = [] if full else waiting
        del f  # free the memory before the next window
    for q in newton.quantities(setup, waiting):
        parts.setdefault(q.name, []).append(q)
    found += [merged(p) for _, p in sorted(parts.items(), key=lambda item: item[0] == "trajectory_in_windows")]
    if not setup.foreign:
        io.write_json(folder / "contributions.json", shares.result(moved))
    driven = int((~setup.free).sum())
    more["newton"] = {"windows": shares.windows, "spheres": len(setup.ids), "driven": driven, **counts}
    return found, more


def named(run_dir: Path, run: io.Run | None, failed: list[str]) -> dict[str, Any] | None:
    """Name the fault of the motion if nothing else is wrong; None if the motion is right."""
    if not set(failed) & MOTION or not window.recorded(Path(run_dir)):
        return None
    setup = window.read(Path(run_dir))
    if setup.foreign:
        return None
    return diagnosis.diagnose(links_motion.links(setup, newton.forces(setup, run), failed), failed)


def seen(run: io.Run | None, held: dict[str, Any]) -> dict[str, float]:
    """Return the shares of the run that were recomputed step by step or checked by bounds: steps, bridges, capillary impulse."""
    steps = len(set().union(*(range(*window) for window in held["windows"]))) / (held["steps"] + 1)
    return {"steps": steps, **({} if run is None else run.known["between"].seen())}


def beyond(shares: dict[str, float]) -> list[str]:
    """Describe in one sentence how much of a moist run is not checked."""
    if "bridges" not in shares or shares["steps"] == 1.0:
        return []
    return [
        f"forces and motion: checked step by step: {100.0 * shares['steps']:.2g} % of the steps, "
        f"{100.0 * shares['bridges']:.3g} % of the bridges and {100.0 * shares['impulse_in_windows']:.2g} % of the capillary "
        f"impulse; {100.0 * shares['impulse_by_bounds']:.3g} % of the impulse by bounds between outputs"
    ]


def notes(more: dict[str, Any]) -> list[str]:
    """Return sentences on values taken from the engine's log."""
    law, between = more["newton"], more["transfer_interpolation"]
    found = [between["note"]] if between else []
    if law is None:
        return found
    if law.get("skipped_beside_another"):
        found.append(
            f"newton: {law['skipped_beside_another']} wall contacts that the engine skipped next to another in the same plane"
        )
    if law.get("beside_an_edge"):
        found.append(
            f"newton: {law['beside_an_edge']} of {law['dry_contacts']} dry contacts are a second one of a sphere with the same "
            "wall part, where the engine counts a convex edge in addition to the face; the reference does the same"
        )
    return found


def not_checked(more: dict[str, Any], held: dict[str, Any]) -> list[str]:
    """Return sentences on what no quantity checks."""
    law, every = more["newton"], held["steps"] + 1
    outside = every - len(set().union(*(range(*window) for window in held["windows"])))
    found = [f"forces and motion: steps outside the windows, {outside} of {every}"] if outside else []
    if law is None:
        return found
    if law.get("foreign"):
        found.append(
            f"newton: forces on spheres in {law['foreign']} dry contacts, which follow the engine's own law; those of all others "
            "are checked, and of all how forces change the motion"
        )
    elif law.get("no_rolling_direction"):
        found.append(
            f"newton: rolling resistance of {law['no_rolling_direction']} contacts, where the spin is lost in the rounding of "
            "the step's kick and has no direction"
        )
    return found
