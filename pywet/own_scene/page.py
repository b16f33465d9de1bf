"""The page of one run: what was run, what came out, and whether it was checked.

A case with its configuration gets the screening report; a custom scene, and a case without, the page that is made here.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd

from pywet.errors import PywetError
from pywet.files import AGAIN, read_if_there
from pywet.own_scene.walls import word_of
from pywet.products import pages
from pywet.report import page, render, report
from pywet.report.pictures import STYLE, panels, plt
from pywet.runs.loaded import Run
from pywet.screening import verdict
from pywet.shipped import place

NOT_WALLS = ("step", "time_s", "total_m3", "initial_m3", "standing_bridges_m3", "left_m3")
"""Columns of liquid_by_wall that are no holder's."""
CURVES = {
    "number per sphere [-]": ("contacts_per_sphere", "bridges_per_sphere"),
    "overlap over the radius [-]": ("mean_overlap", "largest_overlap", "largest_wall_overlap"),
    "speed [m/s]": ("mean_speed_m_per_s", "largest_speed_m_per_s"),
}
GREY = "#7d8994"
DEEP = 0.05
"""Overlap over the radius from which on springs are said to be soft."""


def of_run(folder: Path) -> Path:
    """Write `report.html` into the folder of a finished run, with a picture as new as its results; returns its path."""
    picture, summary = folder / "picture.png", folder / "summary.json"
    if not summary.exists():
        raise PywetError(f"no summary.json in {folder}; expected a finished run of a case or of a scene: run it again")
    if not picture.exists() or picture.stat().st_mtime_ns < summary.stat().st_mtime_ns:
        render.write(folder, picture)
    if (folder / "config.json").exists():
        return report.write_run(folder, place("workflow") / "report", picture)
    return write(folder, picture)


def write(folder: Path, picture: Path) -> Path:
    """Write `report.html` of a custom scene into a run's folder, with its picture; returns its path."""
    run = Run(folder)
    standing = verdict.standing(folder)
    sections = [
        page.Section(
            "The scene at a telling moment", page.picture_file(picture, "Liquid on spheres and walls."), "Picture"
        ),
        *_sizes(run),
        *_retained(run),
        *pages.of_run(folder),
        page.Section("Where the liquid is", _liquid(run), "Liquid"),
        *_contacts(run),
        *([page.Section("Which effects were simulated", _effects(run), "Effects")] if run.has("plan.json") else []),
        page.Section("The independent replay", _replay(run), "Replay"),
        page.Section("The liquid ledger and energies", _ledger(run), "Ledger"),
        page.Section("Files", _files(folder), "Files"),
    ]
    return page.write(folder / "report.html", run.scene.name, standing.sentence, sections, _cards(run, standing))


def _cards(run: Run, standing: verdict.Standing) -> list[page.Card]:
    said, events = run.summary, run.summary["events"]
    cards = [
        page.Card(standing.word, "recomputed and agrees", standing.grade),
        page.Card(str(sum(said["spheres"].values())), "spheres"),
        page.Card(f"{said['simulated_s']:g} s", f"in {said['steps']} steps, {said['wall_s']:.0f} s of computing"),
    ]
    if any(run.origin_mm):
        cards.append(page.Card(", ".join(f"{x:.10g}" for x in run.origin_mm) + " mm", "origin of all positions here"))
    if events is not None:
        kept = said["ledger_error"] <= verdict.LEDGER_TOLERANCE
        cards += [
            page.Card(str(events["formations"]), f"bridges formed, {events['standing_bridges']} stand"),
            page.Card(f"{said['ledger_error']:.1g}", "of the liquid lost or made", "good" if kept else "bad"),
        ]
    return cards


def _sizes(run: Run) -> list[page.Section]:
    """Masses asked for and made, where numbers of spheres follow from masses."""
    rows = run.summary.get("amounts")
    if not rows:
        return []
    table = page.table_of(rows, {
        "size": lambda r: page.left(r["name"]),
        "spheres": lambda r: str(r["count"]),
        "asked [g]": lambda r: f"{1e3 * r['asked_kg']:.4g}",
        "made [g]": lambda r: f"{1e3 * r['made_kg']:.4g}",
        "difference": lambda r: f"{100 * (r['made_kg'] / r['asked_kg'] - 1):+.1f} %",
    })  # fmt: skip
    return [page.Section("Masses in whole spheres", table, "Sizes")]


def _retained(run: Run) -> list[page.Section]:
    """The fraction retained over time, where a run has it."""
    if not run.has("results/fraction_retained.parquet"):
        return []
    table = run.fraction_retained
    columns = [c for c in table.columns if str(c).startswith("fraction_retained") and c != "fraction_retained_spheres"]
    names = {str(c): str(c).removeprefix("fraction_retained").replace("_", " ").strip() or "all" for c in columns}
    drawn = _drawn(table, {"fraction retained Y": names})
    return [page.Section("Fraction retained", drawn, "Retained")]


def _liquid(run: Run) -> str:
    table = run.liquid
    holders = [c for c in table.columns if c not in NOT_WALLS]
    if not table["initial_m3"].iloc[-1]:
        return page.paragraph("The scene is dry.")
    description = read_if_there(run.path / "description.json", AGAIN) or {"walls": []}
    names = {word_of(wall["name"]): wall["name"] for wall in description["walls"]}
    order = sorted(holders, key=lambda c: -table[c].to_numpy(dtype=float).max())
    shown = {str(c): _holder(str(c), names) for c in order}
    in_mm3 = table.assign(**{c: 1e9 * table[c] for c in [*order, "initial_m3"]})
    if run.scene.is_fed:
        shown["initial_m3"] = "put in until then"
    drawn = _drawn(in_mm3, {"liquid [mm³]": shown}) + page.paragraph(
        "Active bridges are divided between their ends as if they ruptured now.", soft=True
    )
    last = {str(c): float(v) for c, v in table.iloc[-1].items()}
    share = {c: last[c] / last["initial_m3"] for c in [*holders, "left_m3"]}
    rows = [[_holder(c, names), f"{1e9 * last[c]:.4g}", f"{100 * part:.3g} %"] for c, part in share.items()]
    return drawn + page.table(["at the end on", "mm³", "of what was put in"], rows)


def _holder(column: str, names: dict[str, str]) -> str:
    """What a column's liquid is on; `names`: of the walls, by their words in tables."""
    kind, _, name = column.removesuffix("_m3").partition("_")
    return {"left": "left with drops"}.get(kind, f"{kind} {names.get(name, name) if kind == 'wall' else name}")


def _contacts(run: Run) -> list[page.Section]:
    if not run.has("results/contact_statistics.parquet"):
        return []
    table = run.contact_statistics
    names = {
        axis: {c: c.removesuffix("_m_per_s").replace("_", " ") for c in columns} for axis, columns in CURVES.items()
    }
    drawn = _drawn(table, names)
    drawn += page.paragraph("A sphere has one contact with a wall, at the wall's closest point.", soft=True)
    deepest = float(table["largest_overlap"].max())
    into, through = (100 * float(table[f"largest_wall_{c}"].max()) for c in ("overlap", "penetration"))
    text = (
        f"Spheres overlap by {100 * deepest:.2g} % of the smaller radius at most, at the outputs, and walls by {into:.2g} % of "
        f"the radius, {through:.2g} % of a wall's thickness."
    )
    if deepest > DEEP:
        key = "youngs_modulus_Pa" if run.scene.hertz else "stiffness_N_per_m"
        text += f" That is deep: stiffer contacts (`{key}`) would be nearer to hard spheres."
    body = "".join(page.paragraph(s) for s in (text, *run.summary.get("warnings", []))) + drawn
    return [page.Section("Contacts and speeds", body, "Contacts")]


def _drawn(table: pd.DataFrame, panels_of: dict[str, dict[str, str]]) -> str:
    """Drawings of columns over time, one below the other on a narrow screen; label of an axis -> column -> its name."""
    drawn = []
    with plt.rc_context(STYLE):
        for k, (label, columns) in enumerate(panels_of.items()):
            figure, (axes,) = panels(1, 1, (4.2, 3.3))
            for column, name in columns.items():
                put_in: Any = {"color": GREY, "linestyle": ":"} if column == "initial_m3" else {}
                axes.plot(table["time_s"], table[column], label=name, **put_in)
            axes.set(xlabel="time [s]", ylabel=label)
            axes.legend()
            drawn.append(page.curves(figure, f"{word_of(label)}{k}"))
    return f'<div class="panels">{"".join(drawn)}</div>'


def _effects(run: Run) -> str:
    return page.table_of(run.plan, {
        "effect": lambda row: page.left(row["effect"]),
        "": lambda row: page.Cell("on", "good") if row["on"] else page.Cell("off", "none"),
        "law": lambda row: page.left(row["law"] or ""),
        "number": lambda row: f"{row['number']:.3g}",
        "what it is, and why": lambda row: page.left(f"{row['quantity']}; {row['why']}"),
    })  # fmt: skip


def _replay(run: Run) -> str:
    said: dict[str, Any] = run.replay
    if not said:
        return page.paragraph("Nothing of this run could be replayed.")
    compared = page.table_of(verdict.agreement(said), {
        "quantity": lambda r: page.left(r.quantity),
        "values": lambda r: str(r.count),
        "largest deviation": lambda r: page.Cell(f"{r.largest:.2g}", "good" if r.ok else "bad"),
        "allowed": lambda r: f"{r.limit:g}",
        "relative to": lambda r: page.left(r.scale),
    })  # fmt: skip
    text = page.paragraph(
        "Recomputed by a second program that shares no code with the first, from what the engine logged."
    )
    amber = [[page.left(what, "fair")] for what in verdict.not_checked(said)]
    return text + compared + (page.table(["not checked"], amber) if amber else "")


def _ledger(run: Run) -> str:
    energies: page.Rows = [[page.left(k), f"{v:.4g}"] for k, v in run.summary["energy_J"].items() if v is not None]
    if run.summary["events"] is None:
        return page.table(["energy", "J"], energies)
    table = run.ledger.iloc[[0, len(run.ledger) // 2, -1]]
    held = ["films", "bridges", "walls", "left", "initial"]
    rows = [[f"{r.time:.4g}", *(f"{1e9 * getattr(r, c):.5g}" for c in held)] for r in table.itertuples()]
    text = "All liquid in mm³: `initial` is what had been put in until then, the others are where it is."
    return (
        page.paragraph(text)
        + page.table(["time [s]", *held], rows)
        + page.table(["energy at the end, and works", "J"], energies)
    )


def _files(folder: Path) -> str:
    said = {
        "summary.json": "numbers of the run", "replay.json": "what the replay said", "description.json": "the scene as given",
        "results/liquid_by_wall.csv": "liquid by wall and class", "results/contact_statistics.csv": "contacts over time",
        "vtk/particles.pvd": "time series for ParaView: spheres", "vtk/bridges.pvd": "bridges", "vtk/walls.pvd": "walls",
        "trajectory.parquet": "places and speeds", "history/events.parquet": "bridges that formed and broke",
    }  # fmt: skip
    there = [name for name in said if (folder / name).exists()]
    return page.table_of(there, {
        "file": lambda name: page.Cell(name, link=name, left=True), "what it holds": lambda name: page.left(said[name]),
    })  # fmt: skip
