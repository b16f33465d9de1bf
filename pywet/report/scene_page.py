"""The page of one run: what was run, its results, and whether they were checked.

A case with its configuration has the screening report; a user-defined scene, or a case without configuration, this
page.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from pywet.cases.custom import seeds
from pywet.cases.custom.walls import word_of
from pywet.cases.screening import verdict
from pywet.cases.screening.results import class_titles
from pywet.errors import PywetError
from pywet.products import screening_report
from pywet.report import page, render, report, screen_page
from pywet.report.bands import mean_and_band
from pywet.report.pictures import STYLE, legend, panels, plt
from pywet.runs.loaded import Run
from pywet.runs.rundir import RunDir
from pywet.shipped import place

NOT_WALLS = ("step", "time_s", "total_m3", "initial_m3", "standing_bridges_m3", "left_m3")
"""Columns of liquid_by_wall that are no reservoirs."""
CURVES = {
    "number per sphere [-]": ("contacts_per_sphere", "bridges_per_sphere"),
    "overlap over the radius [-]": ("mean_overlap", "largest_overlap", "largest_wall_overlap"),
    "speed [m/s]": ("mean_speed_m_per_s", "largest_speed_m_per_s"),
}
GREY = "#7d8994"
LARGEST, OTHERS = 6, "others"
"""Reservoirs of liquid that are drawn with a curve each, and the sum of all others."""
ROUNDING = 1e-12
"""Share of the largest volume of the ledger below which a volume is shown as 0."""
DEEP = 0.05
"""Overlap over the radius above which springs are reported to be soft."""
OVERLAPS = {"largest_overlap": "the smaller radius", "largest_wall_overlap": "the radius at a wall"}
"""Columns of the largest overlaps: of two spheres, of a sphere and a wall."""


def of_run(folder: Path) -> Path:
    """Write `report.html` into the folder of a finished run, with a picture as new as its results; returns its path."""
    picture, summary = folder / render.name(), folder / "summary.json"
    if not summary.exists():
        raise PywetError(
            f"no summary.json in {folder}; expected a finished run of a case or of a scene: run it again",
            code="report.no_summary", where=folder,
        )  # fmt: skip
    if not picture.exists() or picture.stat().st_mtime_ns < summary.stat().st_mtime_ns:
        render.write(folder, picture)
    if (folder / "config.json").exists():
        return report.write_run(folder, place("workflow") / "report", picture)
    return write(folder, picture)


def write(folder: Path, picture: Path) -> Path:
    """Write `report.html` of a custom scene into a run's folder, with its picture; returns its path."""
    runs = seeds.of_scene(folder)
    run, found = runs[0], seeds.worst(runs)
    evaluated = screen_page.of_run(run.path)
    words = _screen(evaluated, runs)
    sections = [
        page.Section("Picture", page.picture_file(picture, _caption(run)), "Picture"),
        *_screens(evaluated, words, runs),
        *_sizes(run),
        *_retained(runs),
        page.Section("Where the liquid is", _liquid(runs), "Liquid"),
        *_contacts(runs),
        *([page.Section("Which effects were simulated", _effects(run), "Effects")] if run.has("plan.json") else []),
        page.Section("The independent replay", _replay(runs), "Replay"),
        page.Section("The liquid ledger and energies", _ledger(runs), "Ledger"),
        page.Section("Files", _files(folder), "Files"),
    ]
    return page.write(folder / "report.html", run.scene.name, found.sentence, sections, _cards(words, runs, found))


def _caption(run: Run) -> str:
    return "Spheres and walls." if run.summary["events"] is None else "Liquid on spheres and walls."


def _screen(evaluated: list[screen_page.Evaluated], runs: seeds.Runs) -> dict[str, str]:
    """Return the five numbers of the screen in words, over several seeds as means; none of a run without a screen."""
    others = (screening_report.stored(run.path) for run in runs[1:])
    found = [numbers for numbers in (*(of[0] for of in evaluated[:1]), *others) if numbers]
    if len(found) < len(runs):
        return {}
    return screen_page.five(found[0]) if len(found) == 1 else screen_page.over_seeds(found)


def _screens(evaluated: list[screen_page.Evaluated], words: dict[str, str], runs: seeds.Runs) -> list[page.Section]:
    """Sections on the screen: of several seeds the means, then all of the first one."""
    run = RunDir(runs[0].path)
    sections = [section for of in evaluated for section in screen_page.sections(run, *of)]
    if len(runs) == 1 or not words:
        return sections
    table = page.table(
        ["number", f"mean of {len(runs)} seeds ± its 95 % interval"],
        [[page.left(name), page.left(value)] for name, value in words.items()],
    )
    of_first = [
        replace(s, heading=f"{s.heading}, of {runs[0].path.name} alone", short=f"{s.short} of one") for s in sections
    ]
    read = ((run.path.name, screening_report.stored(run.path)) for run in runs)
    moving = [name for name, numbers in read if numbers and screening_report.unsteady(numbers)]
    warning = page.paragraph(f"Not steady: {', '.join(moving)}.") if moving else ""
    return [page.Section("Screen", warning + table, "Screen"), *of_first]


def _cards(words: dict[str, str], runs: seeds.Runs, found: verdict.CheckResult) -> list[page.Card]:
    """Numbers of the screen, then what was checked and what was simulated."""
    summary = runs[0].summary
    whole = not any(
        run.summary.get("resumed_at_step") for run in runs
    )  # otherwise the time is that of some of the steps
    computing = f"; {sum(run.summary['wall_s'] for run in runs):.0f} s of computing" if whole else ""
    cards = screen_page.cards(words)
    cards += [
        page.Card(found.word, "recomputed and agrees", found.grade),
        page.Card(
            f"{summary['simulated_s']:g} s",
            f"of {sum(summary['spheres'].values())} spheres in {summary['steps']} steps{computing}",
        ),
    ]
    if summary["events"] is not None:
        events = [run.summary["events"] for run in runs]
        formed, active = (seeds.over([of[kind] for of in events], 9) for kind in ("formations", "standing_bridges"))
        error = max(run.summary["ledger_error"] for run in runs)
        closed = error <= verdict.LEDGER_TOLERANCE
        cards += [
            page.Card(formed, f"bridges formed, {active} stand"),
            page.Card(f"{error:.1g}", "of the liquid lost or made", "good" if closed else "bad"),
        ]
    return cards


def _sizes(run: Run) -> list[page.Section]:
    """Return the requested and simulated masses if numbers of spheres follow from masses."""
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
    entered, planned = sum(run.summary["spheres"].values()), sum(c.count for c in run.scene.classes)
    early = f"The run ended after {entered} of the {planned} spheres had entered." if entered < planned else ""
    return [page.Section("Masses in whole spheres", table + (page.paragraph(early) if early else ""), "Sizes")]


def _retained(runs: seeds.Runs) -> list[page.Section]:
    """Return the fraction retained over time, if the run has it."""
    if not all(run.has("results/fraction_retained.parquet") for run in runs):
        return []
    tables = [run.fraction_retained for run in runs]
    table = tables[0]
    columns = [c for c in table.columns if str(c).startswith("fraction_retained") and c != "fraction_retained_spheres"]
    names = {str(c): str(c).removeprefix("fraction_retained").replace("_", " ").strip() or "all" for c in columns}
    drawn = _drawn(tables, {"fraction retained Y": names})
    return [page.Section("Fraction retained", drawn, "Retained")]


def _liquid(runs: seeds.Runs) -> str:
    run, table = runs[0], runs[0].liquid
    reservoirs = [c for c in table.columns if c not in NOT_WALLS]
    if not table["initial_m3"].iloc[-1]:
        return page.paragraph("The scene is dry.")
    walls = RunDir(run.path).description.get("walls", [])
    names = {f"wall_{word_of(wall['name'])}": f"wall {wall['name']}" for wall in walls}
    names |= class_titles(run.scene)
    order = sorted(reservoirs, key=lambda c: -table[c].to_numpy(dtype=float).max())
    few, rest = (order, []) if len(order) <= LARGEST + 1 else (order[:LARGEST], order[LARGEST:])
    shown = {str(c): _reservoir_name(str(c), names) for c in few} | ({OTHERS: f"{len(rest)} others"} if rest else {})
    tables = [of.liquid.assign(**{OTHERS: of.liquid[rest].sum(axis=1)}) for of in runs]
    tables = [of.assign(**{c: 1e9 * of[c] for c in [*few, OTHERS, "initial_m3"]}) for of in tables]
    if run.scene.has_insertion:
        shown["initial_m3"] = "put in until then"

    def at_end(column: str, of: str | None = None) -> str:
        last = [run.liquid.iloc[-1] for run in runs]
        values = [1e9 * row[column] if of is None else 100.0 * row[column] / row[of] for row in last]
        return seeds.over(values, 4 if of is None else 3)

    by_end = sorted([*reservoirs, "left_m3"], key=lambda c: -table[c].to_numpy(dtype=float)[-1])
    rows = [[_reservoir_name(c, names), at_end(c), f"{at_end(c, 'initial_m3')} %"] for c in by_end]
    at_end_on = page.table(["at the end on", "mm³", "of what was put in"], rows)
    return _drawn(tables, {"liquid [mm³]": shown}, at_end_on) + page.paragraph(
        "Active bridges are divided between their ends as if they ruptured now.", soft=True
    )


def _reservoir_name(column: str, names: dict[str, str]) -> str:
    """Name the liquid reservoir of a column; `names`: of walls and classes, by their columns without unit."""
    kind = column.removesuffix("_m3")
    return names.get(kind, "left with drops" if kind == "left" else kind.replace("_", " ", 1))


def deep(runs: seeds.Runs) -> str | None:
    """Return the sentence on the deepest overlap of two spheres, or of a sphere and a wall; None without deep overlaps."""
    tables = [of.contact_statistics for of in runs if of.has("results/contact_statistics.parquet")]
    most, column = max(((float(t[column].max()), column) for t in tables for column in OVERLAPS), default=(0.0, ""))
    if not most > DEEP:
        return None
    key, where, now, power = _stiffness(runs[0], column == "largest_wall_overlap")
    times = (most / DEEP) ** power
    to = f"from {now:g} to about {float(f'{times * now:.2g}'):g}" if now else f"about {times:.2g} times"
    return (
        f"deep overlaps: up to {100.0 * most:.2g} % of {OVERLAPS[column]}, soft above {100.0 * DEEP:g} %: "
        f"raise {key} in {where} {to}; the run takes {times**0.5:.2g} times as many steps"
    )


def _stiffness(run: Run, at_walls: bool) -> tuple[str, str, float | None, float]:
    """Return the key of the stiffness of contacts with walls or of two spheres, where it is given, its value if all have one.

    The last number is k of an overlap that falls as 1/value^(1/k).
    """
    hertz, where = run.scene.hertz, "materials"
    if hertz:
        values, key, power = {e.youngs_modulus_Pa for e in (*hertz.spheres, hertz.walls)}, "youngs_modulus_Pa", 2.5
    else:
        pairs = (p for p in run.scene.pairs if (p.b == 0) == at_walls)
        values, key, power = {p.normal_stiffness_N_per_m for p in pairs}, "stiffness_N_per_m", 2.0
        if any(contact.get(key) for contact in RunDir(run.path).description.get("contacts") or ()):
            where = "materials and contacts"
    return key, where, values.pop() if len(values) == 1 else None, power


def _contacts(runs: seeds.Runs) -> list[page.Section]:
    if not all(of.has("results/contact_statistics.parquet") for of in runs):
        return []
    tables = [of.contact_statistics for of in runs]
    names = {
        axis: {c: c.removesuffix("_m_per_s").replace("_", " ") for c in columns} for axis, columns in CURVES.items()
    }
    drawn = _drawn(tables, names)
    drawn += page.paragraph("A sphere has one contact with a wall, at the wall's closest point.", soft=True)
    overlaps = ("largest_overlap", "largest_wall_overlap", "largest_wall_penetration")
    most, into, through = (seeds.over([100.0 * t[column].max() for t in tables], 2) for column in overlaps)
    text = (
        f"Spheres overlap by {most} % of the smaller radius at most, at the outputs, and walls by {into} % of "
        f"the radius, {through} % of a wall's thickness."
    )
    if warning := deep(runs):
        text += f" {warning[0].upper()}{warning[1:]}."
    text += " Between two outputs an impact may go deeper."
    body = (
        "".join(page.paragraph(s) for s in (text, *seeds.lines_of(runs, lambda r: r.summary.get("warnings", []))))
        + drawn
    )
    return [page.Section("Contacts and speeds", body, "Contacts")]


def _drawn(tables: list[pd.DataFrame], panels_of: dict[str, dict[str, str]], more: str = "") -> str:
    """Return drawings of columns over time, `more` next to them, one below the other on a narrow screen.

    `panels_of`: label of an axis -> column -> its name.
    """
    drawn = []
    with plt.rc_context(STYLE):
        for k, (label, columns) in enumerate(panels_of.items()):
            figure, (axes,) = panels(1, 1, (4.2, 3.3))
            held = {c: name for c, name in columns.items() if any(t[c].any() for t in tables)} or columns
            for column, name in held.items():
                put_in: Any = {"color": GREY, "linestyle": ":"} if column == "initial_m3" else {}
                time, mean, half = mean_and_band([(t["time_s"].to_numpy(), t[column].to_numpy()) for t in tables])
                (line,) = axes.plot(time, mean, label=name, **put_in)
                if half is not None:
                    axes.fill_between(time, mean - half, mean + half, color=line.get_color(), alpha=0.2, linewidth=0)
            axes.set(xlabel="time [s]", ylabel=label)
            legend(figure)
            drawn.append(page.curves(figure, f"{word_of(label)}{k}"))
    return f'<div class="panels">{"".join(drawn)}{more}</div>'


def _effects(run: Run) -> str:
    return page.table_of(run.plan, {
        "effect": lambda row: page.left(row["effect"]),
        "": lambda row: page.Cell("on", "good") if row["on"] else page.Cell("off", "none"),
        "law": lambda row: page.left(row["law"] or ""),
        "number": lambda row: f"{row['number']:.3g}",
        "what it is, and why": lambda row: page.left(f"{row['quantity']}; {row['why']}"),
    })  # fmt: skip


def _replay(runs: seeds.Runs) -> str:
    without = [run.path.name for run in runs if not run.replay]
    if len(without) == len(runs):
        return page.paragraph("Nothing of this run could be replayed.")
    rows = seeds.agreement(runs)
    compared = page.table_of(rows, {
        "quantity": lambda r: page.left(r.quantity),
        "values": lambda r: str(r.count),
        "largest deviation": lambda r: page.Cell(f"{r.largest:.2g}", "good" if r.ok else "bad"),
        "allowed": lambda r: f"{r.limit:g}",
        "relative to": lambda r: page.left(r.scale),
    })  # fmt: skip
    text = page.paragraph(
        f"{len(rows)} quantities in {sum(r.count for r in rows)} values were recomputed, by a second program that shares no "
        f"code with the first, from what the engine logged; {sum(not r.ok for r in rows)} disagree."
        + (" Deviations are the largest of all seeds." if len(runs) > 1 else "")
        + (f" Nothing of {', '.join(without)} was replayed." if without else "")
    )
    amber = [[page.left(what, "fair")] for what in seeds.lines_of(runs, lambda r: verdict.not_checked(r.replay or {}))]
    open_points = page.folded(f"{len(amber)} points that were not checked", page.table(["not checked"], amber))
    return text + (open_points if amber else "") + page.folded("All quantities", compared)


def _ledger(runs: seeds.Runs) -> str:
    summaries = [run.summary["energy_J"] for run in runs]
    energies: page.Rows = [
        [page.left(k), seeds.over([of[k] for of in summaries])] for k, v in summaries[0].items() if v is not None
    ]
    if runs[0].summary["events"] is None:
        return page.table(["energy", "J"], energies)
    names = {"films": "films", "bridges": "bridges", "walls": "walls", "left": "left with drops",
             "retired": "with spheres that left", "initial": "put in"}  # fmt: skip
    held = [c for c in names if c in ("films", "initial") or any(run.ledger[c].any() for run in runs)]
    tables = [of[["time"]].join(of[held].where(of[held].abs() > ROUNDING * of[held].max().max(), 0.0)) for of in
              (run.ledger.drop_duplicates("step", keep="last").set_index("step") for run in runs)]  # fmt: skip
    steps = sorted(set.intersection(*(set(of.index) for of in tables)))  # runs with `until` end at different times
    rows = [
        [f"{tables[0].loc[k, 'time']:.4g}", *(seeds.over([1e9 * float(t.loc[k, c]) for t in tables], 5) for c in held)]
        for k in dict.fromkeys(steps[at] for at in (0, len(steps) // 2, -1))
    ]
    text = "All liquid in mm³: what had been put in until then, and where it is."
    return (
        page.paragraph(text)
        + page.table(["time [s]", *(names[c] for c in held)], rows)
        + page.table(["energy at the end, and works", "J"], energies)
    )


def _files(folder: Path) -> str:
    message = {
        "summary.json": "numbers of the run", "replay.json": "what the replay said", "description.json": "the scene as given",
        "results/liquid_by_wall.csv": "liquid by wall and class", "results/contact_statistics.csv": "contacts over time",
        "vtk/particles.pvd": "time series for ParaView: spheres", "vtk/bridges.pvd": "bridges", "vtk/walls.pvd": "walls",
        "trajectory.parquet": "places and speeds", "history/events.parquet": "bridges that formed and broke",
    }  # fmt: skip
    there = [name for name in message if (folder / name).exists()]
    return page.table_of(there, {
        "file": lambda name: page.Cell(name, link=name, left=True), "what it holds": lambda name: page.left(message[name]),
    })  # fmt: skip
