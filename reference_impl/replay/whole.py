"""Check that a run's tables contain every planned output step, window, sphere and bridge, and none of another run.

The plan follows from scene.json alone. Only the necessary columns of each table are read, so that this is fast for
long runs. An incomplete table is refused in one sentence; complete ones are counted, so that the result can state its
extent.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.motion import window
from reference_impl.replay import io, plans, retired, script
from reference_impl.replay.arrays import Floats
from reference_impl.replay.bodies import refuse
from reference_impl.replay.compare import TOLERANCE, Quantity, compare
from reference_impl.replay.io import ReplayError
from reference_impl.replay.plans import AGAIN, Plan, plan

MOVING = ("vx", "vy", "vz", "wx", "wy", "wz")
OF_BRIDGES = (
    "meta.json",
    *(f"{n}.parquet" for n in ("events", "contacts", "ledger", "films", "impulses", "bridges", "wall_films")),
)
"""Files of history/ that only a moist run has."""


def check(folder: Path) -> dict[str, Any]:
    """Refuse an incomplete run; otherwise return its content: steps, outputs, windows, rows of each table."""
    run, planned = Path(folder), plan(Path(folder))
    rows = {"trajectory": _trajectory(run, planned)}
    if planned.walls:
        rows["mesh_motion"] = _each(run / "mesh_motion.parquet", planned, planned.walls)
        rows |= _numbered(run)
    if planned.moist:
        rows |= _liquid(run / "history", planned)
    else:
        left = [name for name in OF_BRIDGES if (run / "history" / name).exists()]
        if left:
            raise ReplayError(f"{run / 'history'} holds {', '.join(left)} of a moist run, but scene.json has no bridges; "
                              f"expected the tables of one run: {AGAIN} in an empty folder")  # fmt: skip
    if gone := retired.whole(run):
        rows["retired"] = gone
    for name in planned.recorded:
        rows[name] = _recorded(run / "history" / f"{name}.parquet", planned)
    windows = [list(window) for window in planned.windows]
    return {"steps": planned.steps, "outputs": len(planned.outputs), "windows": windows, "rows": rows}


def sentence(held: dict[str, Any]) -> str:
    """State in one sentence how many rows each table of a run has."""
    rows = ", ".join(f"{name} {count}" for name, count in held["rows"].items())
    return (
        f"compared: all {held['outputs']} output steps to step {held['steps']}, {len(held['windows'])} windows of "
        f"{sum(b - a for a, b in held['windows'])} steps; rows: {rows}"
    )


def _steps(path: Path, steps: Floats, planned: Floats, what: str) -> None:
    """Refuse a table that lacks a planned step or has an additional one."""
    there = np.unique(steps)
    for wrong, word in (
        (np.setdiff1d(planned, there), "is not there"),
        (np.setdiff1d(there, planned), "is none of them"),
    ):
        if len(wrong):
            more = f" (nor {len(wrong) - 1} more)" if len(wrong) > 1 else ""
            raise ReplayError(f"{path} is not whole: step {wrong[0]} {word}{more}; "
                              f"expected the {len(planned)} {what} of scene.json: {AGAIN}")  # fmt: skip


def _each(path: Path, planned: Plan, count: int | Floats) -> int:
    """Check that a table has `count` rows at every output step (a number, or one for each), and return its number of rows."""
    steps = io.columns(path, ["step"])["step"].to_numpy()
    want = np.broadcast_to(count, planned.outputs.shape)
    _steps(path, np.concatenate([steps, planned.outputs[want == 0]]), planned.outputs, "output steps")
    rows = np.bincount(np.searchsorted(planned.outputs, steps), minlength=len(want))
    if (rows != want).any():
        at = int(np.argmax(rows != want))
        raise ReplayError(f"{path} holds {rows[at]} rows at step {planned.outputs[at]}; expected {want[at]}: {AGAIN}")
    return len(steps)


def _trajectory(run: Path, planned: Plan) -> int:
    """Check that every sphere that has not left is in the trajectory at every output step, from the scene's initial positions."""
    path, spheres = run / "trajectory.parquet", io.columns(run / "history" / "spheres.parquet", ["id", "type"])
    left = np.sort(retired.table(run)["step"].to_numpy()) if io.scene(run).get("outlets") else np.zeros(0)
    rows = _each(path, planned, _there(run, planned, len(spheres) - np.searchsorted(left, planned.outputs)))
    table = io.columns(path, ["step", "id", "type"])
    _known(path, table["id"], spheres["id"], "sphere")
    kinds = table["id"].map(spheres.set_index("id")["type"])
    if (kinds != table["type"]).any() or table.duplicated(["step", "id"]).any() or _start_off(run):
        raise ReplayError(f"{path} has other spheres, types, first places or velocities than history/spheres.parquet and the "
                          f"file that scene.json starts from; expected the trajectory of this run: {AGAIN}")  # fmt: skip
    return rows


def _there(run: Path, planned: Plan, scene: int | Floats) -> int | Floats:
    """Return the number of spheres at every output: in a script's run those inserted and not removed, else those of the scene."""
    return script.present(run, planned.outputs) if script.of(run) else scene


def _start_off(run: Path) -> bool:
    """Return whether the first frame differs from the start of the scene: places, and in LIGGGHTS velocities and spins.

    Without velocities in the scene's file the spheres are at rest; those that the engine drives are left out.
    """
    path = run / io.scene(run)["spheres_file"]
    if not path.exists():
        return False
    moving = MOVING if plans.engine(run) == "LIGGGHTS" else ()
    start = io.columns(path, ["id", *"xyz", *(n for n in moving if n in io.names(path))])
    frame = io.table(run / "trajectory.parquet", "trajectory", [("step", "==", 0)])
    both = start.merge(frame, on="id", suffixes=("_0", ""))
    free = ~both["id"].isin(window.driven(run)).to_numpy()
    for names, rows in (((*"xyz",), np.ones(len(both), bool)), (moving[:3], free), (moving[3:], free)):
        if not names:
            continue
        at = both.loc[rows, list(names)].to_numpy(float)
        first = np.stack(
            [both.loc[rows, f"{n}_0"] if f"{n}_0" in both else np.zeros(rows.sum()) for n in names], axis=1
        )
        if (np.abs(at - first) > TOLERANCE * np.maximum(np.abs(first).max(axis=1, initial=0.0), 1e-3)[:, None]).any():
            return True
    return False


def _numbered(run: Path) -> dict[str, int]:
    """Check that triangles and wall parts are numbered from zero through all of the scene's walls."""
    walls, rows = io.scene(run)["walls"], {}
    for name, of in (("triangle", "triangle_part"), ("part", "part_half_width_m")):
        path, want = run / "history" / f"{name}s.parquet", sum(len(w[of]) for w in walls)
        if np.sort(io.columns(path, [name])[name].to_numpy()).tolist() != list(range(want)):
            raise ReplayError(
                f"{path} is not whole; expected {name}s numbered 0 to {want - 1} as in scene.json: {AGAIN}"
            )
        rows[f"{name}s"] = want
    return rows


def _known(path: Path, found: pd.Series, known: Any, what: str) -> None:
    """Refuse numbers that the start does not have."""
    refuse(path, found[~found.isin(known)].to_numpy(), what)


def _liquid(history: Path, planned: Plan) -> dict[str, int]:
    """Check completeness of the liquid's tables.

    Ledger, films and energy must be at every output, with as many bridges and wall films as the ledger counts;
    events and contacts are checked, too.
    """
    ids = io.columns(history / "spheres.parquet", ["id"])["id"]
    single = ("ledger", "energy") if planned.energy else ("ledger",)
    rows = {name: _each(history / f"{name}.parquet", planned, 1) for name in single}
    there = _there(history.parent, planned, len(ids))
    rows["films"] = _each(history / "films.parquet", planned, there)
    rows["impulses"] = _each(history / "impulses.parquet", planned, there)
    films = io.columns(history / "films.parquet", ["step", "id"])
    _known(history / "films.parquet", films["id"], ids, "sphere")
    columns = ["step", "walls", "initial", "bridge_count", "formations", "ruptures"]
    ledger = io.columns(history / "ledger.parquet", columns).sort_values("step")
    walls = io.columns(history / "wall_films.parquet", ["step", "triangle", "film"])
    bridges = io.columns(history / "bridges.parquet", ["step"])
    for name, table, weight, want, margin in (
        ("wall_films", walls, walls["film"].to_numpy(float), ledger["walls"], 1e-12 * ledger["initial"].max()),
        ("bridges", bridges, np.ones(len(bridges)), ledger["bridge_count"], 0.0),
    ):
        path = history / f"{name}.parquet"
        _steps(path, np.concatenate([table["step"], planned.outputs]), planned.outputs, "output steps")
        sums = np.bincount(np.searchsorted(planned.outputs, table["step"]), weight, len(planned.outputs))
        off = np.abs(sums - want.to_numpy(float)) > margin
        if off.any():
            raise ReplayError(f"{path} holds {sums[off][0]:.6g} at step {planned.outputs[off][0]}, where the ledger has "
                              f"{want.to_numpy()[off][0]:.6g}; expected both to be the same: {AGAIN}")  # fmt: skip
        rows[name] = len(table)
    triangles = history / "triangles.parquet"
    known: Any = io.columns(triangles, ["triangle"])["triangle"] if triangles.exists() else []
    _known(history / "wall_films.parquet", walls["triangle"], known, "triangle")
    rows["events"] = _events(history / "events.parquet", ledger, planned)
    rows["contacts"] = _contacts(history, planned)
    return rows


def _events(path: Path, ledger: pd.DataFrame, planned: Plan) -> int:
    """Check that the event log does not end before the ledger stops counting, and return its number of rows."""
    events = io.columns(path, ["step", "kind"])
    _in_time(path, events, planned)
    counted = event_counts(events, ledger)
    right = (counted["logged"] == counted["counted"]).to_numpy()
    last = counted["last"].iloc[0]
    if not right.all() and right[(ledger["step"] <= last).to_numpy()].all():
        end = int(counted["counted"].iloc[-1])
        raise ReplayError(f"{path} ends with {counted['logged'].iloc[-1]} events at step {last}, where the ledger counts {end} "
                          f"in all; expected every formation and rupture: {AGAIN}")  # fmt: skip
    return int(counted["rows"].iloc[0])


def event_counts(events: pd.DataFrame, ledger: pd.DataFrame) -> pd.DataFrame:
    """Return events up to each output by log and ledger: `step`, `logged`, `counted`; `last` step and `rows` of the log."""
    steps = np.sort(events["step"].to_numpy())
    logged = np.searchsorted(steps, ledger["step"], "right")
    counted = (ledger["formations"] + ledger["ruptures"]).to_numpy()
    last = int(steps[-1]) if len(steps) else -1
    return pd.DataFrame(
        {"step": ledger["step"], "logged": logged, "counted": counted, "last": last, "rows": len(steps)}
    )


def contact_counts(contacts: pd.DataFrame, events: pd.DataFrame, planned: Plan) -> pd.DataFrame:
    """Return the rows of the contact log at every step of the windows, and the bridges that act there by the event log.

    Columns are `logged` and `acting`. A bridge acts from the step after its formation to the step before its
    rupture; if bridges act every few steps, from its formation on.
    """
    steps, kind, at = planned.contact_steps, events["kind"].to_numpy(), events["step"].to_numpy()
    formed = np.searchsorted(np.sort(at[kind == 0]), steps, "left" if planned.every == 1 else "right")
    ended = np.searchsorted(np.sort(at[kind > 0]), steps, "right")
    rows = np.sort(contacts["step"].to_numpy())
    logged = np.searchsorted(rows, steps, "right") - np.searchsorted(rows, steps, "left")
    return pd.DataFrame({"step": steps, "logged": logged, "acting": formed - ended})


def _contacts(history: Path, planned: Plan) -> int:
    """Check that contacts are logged only in windows, in every one in which bridges act throughout; return the number of rows."""
    path = history / "contacts.parquet"
    contacts, events = io.columns(path, ["step"]), io.columns(history / "events.parquet", ["step", "kind"])
    steps = planned.contact_steps
    _steps(
        path, np.concatenate([contacts["step"].to_numpy(), steps]), steps, "steps of the windows at which bridges act"
    )
    count = contact_counts(contacts, events, planned)
    lost = count[(count["logged"] == 0) & (count["acting"] > 0)]
    if len(lost):
        raise ReplayError(f"{path} has nothing at step {lost['step'].iloc[0]} of the windows, where "
                          f"{lost['acting'].iloc[0]} bridges act by the event log; expected whole windows: {AGAIN}")  # fmt: skip
    return len(contacts)


def _recorded(path: Path, planned: Plan) -> int:
    """Check that motion is recorded at every step of the windows until all spheres have left, and springs at no other step."""
    steps, run = io.columns(path, ["step"])["step"].to_numpy(), path.parent.parent
    gone, count = retired.table(run)["step"], len(io.columns(run / "history" / "spheres.parquet", ["id"]))
    last = gone.max() if len(gone) == count else np.inf
    more = planned.window_steps
    more = more[more > last] if path.stem == "window_states" else more
    _steps(path, np.concatenate([steps, more]), planned.window_steps, "steps of the windows")
    return len(steps)


def inputs(run: io.Run) -> None:
    """Refuse start tables that are cut or of another scene."""
    scene, history = io.scene(run.folder), run.folder / "history"
    meta, types = run.meta, [c["radius_m"] for c in scene["classes"]]
    planned = plan(run.folder)
    if (
        [t["radius"] for t in meta["types"]] != types
        or meta["time_step"] != scene["time_step_s"]
        or meta["output_steps"] != planned.outputs.tolist()
    ):
        raise ReplayError(f"{history / 'meta.json'} and scene.json differ in radii, time step or output steps; "
                          f"expected both of one run: {AGAIN}")  # fmt: skip
    groups = run.table("parts")["part_class"].nunique() if "parts" in run.tables else 0
    groups = groups if scene["effects"].get("wall_films", True) else 0
    nodes = 2 if scene["effects"].get("transfer") == "half" else int(scene.get("transfer_nodes", 201))
    rows, want = len(run.table("transfer")), len(types) * (len(types) + groups) * nodes
    if rows != want:
        raise ReplayError(
            f"{history / 'transfer.parquet'} holds {rows} rows; expected the {want} of scene.json: {AGAIN}"
        )


def _in_time(path: Path, events: pd.DataFrame, planned: Plan) -> None:
    """Refuse events at steps at which the scene does not let the bridges act."""
    late = events[events["step"] % planned.every != 0]
    if len(late):
        raise ReplayError(f"{path} has an event at step {late['step'].iloc[0]}; expected events at multiples of the scene's "
                          f"bridges_every, {planned.every}: {AGAIN}")  # fmt: skip


def counted(run: io.Run) -> list[Quantity]:
    """Compare events with the ledger's counts, and contacts with the bridges that act by the events."""
    history = run.folder / "history"
    log = io.columns(history / "events.parquet", ["step", "kind"])
    events = event_counts(log, run.table("ledger").sort_values("step"))
    contacts = contact_counts(io.columns(history / "contacts.parquet", ["step"]), log, plan(run.folder))
    return [
        compare(name, scale, rows["logged"].to_numpy(float), rows[other].to_numpy(float), np.ones(len(rows)), rows, 0.0)
        for name, scale, rows, other in (
            ("event_counts", "each counts 1", events, "counted"),
            ("contact_rows", "each counts 1", contacts, "acting"),
        )
    ]


def places(run: io.Run) -> pd.DataFrame:
    """Return positions of spheres from the snapshots of the bridges: `step`, `id`, x, y, z [m]."""
    return run.table("bridges")[["step", "i", "xi_x", "xi_y", "xi_z"]].set_axis(["step", "id", *"xyz"], axis=1)


def trajectory(place: pd.DataFrame, table: pd.DataFrame) -> list[Quantity]:
    """Compare positions of spheres in another log (`step`, `id`, x, y, z) with the trajectory at common steps."""
    both = place.merge(table[["step", "id", *"xyz"]], on=["step", "id"], suffixes=("", "_dump"))
    expected, dump = (both[[f"{axis}{end}" for axis in "xyz"]].to_numpy(float) for end in ("", "_dump"))
    size = np.maximum(np.abs(expected).max(axis=1, initial=0.0), 1e-3)
    return (
        [compare("trajectory", "largest coordinate, or 1 mm", dump, expected, size, both, TOLERANCE)]
        if len(both)
        else []
    )
