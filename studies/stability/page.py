"""The page of the stability study: the maps with the advisor's line first, then stress tests and random cases."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import NullFormatter
from numpy.typing import NDArray

from pywet.report import page
from pywet.report.pictures import panels, plt
from studies.stability.maps import MAPS, Map

Floats = NDArray[np.float64]
STATES = ("stable", "energy", "ledger", "not finite", "speed", "overlap", "box", "other")
COLOURS = ("#bfe3c8", "#f6c667", "#7b5ea7", "#222222", "#e07a5f", "#c8553d", "#8f2d20", "#999999")
NAMES = (
    "stable", "makes more than 1 % of the energy in play", "ledger lost", "not finite", "stopped: too fast for the step",
    "stopped: overlap above half a radius", "stopped: left the box", "stopped: other",
)  # fmt: skip
READS = {
    "step_explicit": (
        "The stable region ends where the advisor says: for thin liquids at the contact's limit, for thick ones at "
        "the drag's, which falls with the viscosity. "
    ),
    "step_semi_implicit": (
        "The viscosity no longer limits the step, and the thicker the liquid, the longer the step that still "
        "holds; with thin liquids the last part before the limit makes some energy. "
    ),
    "stiffness": (
        "Elastic spheres of 1 mm at a step of 10 µs. Beyond the line a contact blows up. Short of it a contact is "
        "stable, but a collision that begins between two steps gives back up to k Δt²/(4 m) more or less than it "
        "got: a tenth of the limit (dashed) keeps the energy to 1 %, and the default, a twentieth of the contact "
        "time, lies below it. Spheres faster than a tenth of their radius a step, or pressed in by more than half "
        "a radius, are stopped by name. "
    ),
    "ratio": (
        "A thick liquid (0.1 Pa s), explicit drag, one step for all. The advisor takes the drag at contact: it is "
        "sharp where the spheres meet, and cautious for thick films, where the drag stops them before they touch. "
    ),
    "angle": (
        "Slow collisions in which the capillary force decides. The advisor's line is one of resolution: to its "
        "left a bridge is passed in a few steps. Nothing becomes unstable there, since so small a bridge holds too "
        "little energy. "
    ),
}


def kind_of(state: str, message: str) -> str:
    """Name the guard that stopped a point."""
    if state != "stopped":
        return state
    for words, name in (("moves at", "speed"), ("overlaps", "overlap"), ("left the simulated box", "box")):
        if words in message:
            return name
    return "other"


def edges(centres: Floats, log: bool) -> Floats:
    """Return the borders between the points of an axis."""
    at = np.log(centres) if log else centres
    middle = 0.5 * (at[1:] + at[:-1])
    ends = np.concatenate([[2.0 * at[0] - middle[0]], middle, [2.0 * at[-1] - middle[-1]]])
    return np.exp(ends) if log else ends


def draw(axes: Axes, chart: Map, table: pd.DataFrame) -> set[str]:
    """Draw one map and return the kinds of points in it."""
    x, y = chart.x[1], chart.y[1]
    kinds = [kind_of(str(s), str(t)) for s, t in zip(table["state"], table["message"], strict=True)]
    grid = np.array([STATES.index(k) for k in kinds]).reshape(len(y), len(x))
    colours = ListedColormap(COLOURS)
    axes.pcolormesh(
        edges(x, chart.x_log), edges(y, chart.y_log), grid, cmap=colours, vmin=-0.5, vmax=len(STATES) - 0.5,
        edgecolors="white", linewidth=0.6,
    )  # fmt: skip
    limit = table["limit"].to_numpy(float).reshape(len(y), len(x))
    for level, style in ((1.0, "-"), (10.0, "--")):
        if level == 10.0 and chart.name not in ("step_explicit", "step_semi_implicit", "stiffness"):
            continue
        if limit.min() < level < limit.max():
            look: dict[str, Any] = {"colors": "#0b3c78", "linewidths": 2.2, "linestyles": style}
            axes.contour(x, y, np.log(limit), levels=[np.log(level)], **look)
    scales: dict[str, Any] = {
        "xscale": "log" if chart.x_log else "linear",
        "yscale": "log" if chart.y_log else "linear",
    }
    axes.set(xlabel=chart.x[0], ylabel=chart.y[0], **scales)
    axes.set_title(chart.title, fontsize=10.5, loc="left", fontweight="bold")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_formatter(NullFormatter())
    axes.tick_params(labelsize=8.5)
    return set(kinds)


def maps_figure(charts: list[tuple[Map, pd.DataFrame]], columns: int = 2) -> Figure:
    """Draw maps side by side with one legend."""
    figure, axes = panels(len(charts), columns, (11.5 / columns, 4.1))
    seen: set[str] = set()
    for panel, (chart, table) in zip(axes, charts, strict=False):
        seen |= draw(panel, chart, table)
    shown: list[Patch | Line2D] = [
        Patch(color=c, label=n) for s, c, n in zip(STATES, COLOURS, NAMES, strict=True) if s in seen
    ]
    shown.append(Line2D([], [], color="#0b3c78", lw=2.2, label="advisor's limit"))
    if any(chart.name.startswith(("step", "stiff")) for chart, _ in charts):
        shown.append(Line2D([], [], color="#0b3c78", lw=2.2, ls="--", label="a tenth of it (energy to 1 %)"))
    figure.legend(handles=shown, loc="outside lower center", ncols=3, fontsize=9, frameon=False)
    return figure


def field(cases: pd.DataFrame) -> Figure:
    """Draw the distribution of the cases over viscosity and smallest radius, films and speeds."""
    colour = {"stable": "#2f7d4f", "law": "#e0a030", "stopped": "#8f2d20"}
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(12.0, 3.9), layout="constrained")
    tint = [colour.get(str(s), "#000000") for s in cases["state"]]
    pairs = (
        (left, "smallest_m", "viscosity_Pa_s", "smallest sphere [m]", "viscosity [Pa s] (0 at the bottom)"),
        (middle, "film_over_r3_high", "fastest_m_per_s", "largest film over r³ (0 at the left)", "fastest sphere [m/s]"),
        (right, "of_advised", "time_step_s", "time step over the advisor's limit", "time step [s]"),
    )  # fmt: skip
    for panel, x, y, x_message, y_message in pairs:
        across, up = cases[x].to_numpy(float), cases[y].to_numpy(float)
        low_x, low_y = (v[v > 0].min() / 4.0 if (v > 0).any() else 1.0 for v in (across, up))
        panel.scatter(np.maximum(across, low_x), np.maximum(up, low_y), c=tint, s=7, alpha=0.7, linewidths=0)
        panel.set(xscale="log", yscale="log", xlabel=x_message, ylabel=y_message)
        panel.tick_params(labelsize=8.5)
    names = {"stable": "stable", "law": "energy made by the tangential law", "stopped": "stopped by a guard"}
    present = [s for s in names if (cases["state"] == s).any()]
    figure.legend(
        handles=[Line2D([], [], marker="o", ls="", color=colour[s], label=names[s]) for s in present],
        loc="outside lower center", ncols=3, frameon=False,
    )  # fmt: skip
    return figure


def score(table: pd.DataFrame) -> str:
    """Count the stable points inside and outside the advisor's limit, in one sentence."""
    inside, state = table["limit"].astype(float) >= 1.0, table["state"]
    stable, more = state == "stable", (inside & (state == "energy")).sum()
    stopped = (inside & ~state.isin(["stable", "energy"])).sum()
    return (
        f"Within the line {(inside & stable).sum()} of {inside.sum()} points are stable to 1 % of energy, {more} make more, "
        f"{stopped} stop; beyond it {(~inside & stable).sum()} of {(~inside).sum()} are still stable."
    )


def map_sections(maps: dict[str, pd.DataFrame]) -> list[page.Section]:
    others = "Stiffness and speed, film and size ratio, angle and volume"
    groups = (
        ("Time step and viscosity", "Time step", ("step_explicit", "step_semi_implicit")),
        (others, "Stiffness, film, angle", ("stiffness", "ratio", "angle")),
    )
    sections = []
    for heading, short, names in groups:
        charts = [(MAPS[n], maps[n]) for n in names]
        drawn = maps_figure(charts, len(charts))
        picture = page.picture(drawn, "Each field is one point, judged in the engine")
        words = [page.paragraph(f"{MAPS[n].title}. " + READS[n] + score(maps[n])) for n in names]
        sections.append(page.Section(heading, picture + "".join(words), short))
    return sections


def hard_section(table: pd.DataFrame) -> page.Section:
    body = page.paragraph(
        "What a scene may meet on a bad day, at small size; the same run in the tests. Each is finite, keeps its "
        "liquid to round-off, makes no energy beyond the order of the method, and is recomputed by the independent "
        "replay, or stops by a sentence that names the sphere and the cause."
    )
    body += page.table_of(table.itertuples(), {
        "scene": lambda r: page.left(r.case),
        "outcome": _outcome,
        "ledger error": lambda r: f"{r.ledger:.0e}" if r.state != "stopped" else "",
        "events": lambda r: str(r.events),
        "replay": lambda r: r.replay,
        "sentence of the guard": lambda r: page.left(r.message),
    })  # fmt: skip
    return page.Section("Stress tests", body, "Stress tests")


def _outcome(r: Any) -> page.Cell:
    words = {"stable": "stable", "law": "energy by the tangential law", "stopped": "stopped by name"}
    fine = r.state in ("stable", "law", r.expected)
    return page.Cell(words.get(r.state, r.state), "bad" if not fine else "fair" if r.state == "law" else "good")


def case_section(cases: pd.DataFrame) -> page.Section:
    counts = pd.crosstab(cases["kind"], cases["state"])
    rows: page.Rows = [[page.left(k), *(str(v) if v else "" for v in counts.loc[k])] for k in counts.index]
    body = page.picture(field(cases), "The cases: each point is one", vector=False)
    body += page.paragraph(
        "Random pairs, chains, packings, and spheres at plates, edges and wires: radii 20 µm to 10 mm, size ratio "
        "to 10, surface tension 0 to 0.1 N/m, viscosity 0 to 10 Pa s, contact angles 0 to 89 degrees, V* from 1e-9 "
        "to 0.5, speeds over three decades, presets paper and exact and seven other choices of laws, explicit and "
        "semi-implicit drag within the advisor's limits, one or two ranks."
    )
    body += page.paragraph(
        "Energy by the tangential law: Elskamp's (28), (29) drag sliding and spin with different coefficients, and "
        "the torque is the force times its arm. Such a law is not passive: a sphere that slides along a plate ends "
        "with up to 1.4 times its energy, whatever the step. The same case with the law `lian`, which has one "
        "coefficient, makes none, which distinguishes it from an error of the method."
    )
    body += page.table(["what", *map(str, counts.columns)], rows)
    bad = cases[~cases["state"].isin(["stable", "law"])]
    if len(bad):
        body += page.table_of(bad.itertuples(), {
            "case": lambda r: r.case, "what": lambda r: r.kind, "state": lambda r: page.Cell(r.state, "bad"),
            "sentence": lambda r: r.message, "replay": lambda r: r.replay,
        })  # fmt: skip
    return page.Section(f"{len(cases)} hard cases", body, "Cases")


def write_page(path: Path, maps: dict[str, pd.DataFrame], scenes: pd.DataFrame, cases: pd.DataFrame) -> Path:
    """Write the page of the maps' points, the stress tests and the random cases, a row each."""
    by_law = int((cases["state"] == "law").sum())
    unexplained = len(cases) - by_law - int((cases["state"] == "stable").sum())
    fine = int(((scenes["state"] == scenes["expected"]) | (scenes["state"] == "law")).sum())
    cards = [
        page.Card(f"{unexplained}", f"of {len(cases)} hard cases without an explanation", "bad" if unexplained else "good"),
        page.Card(f"{cases['ledger'].max():.0e}", "largest error of a cell's liquid ledger, over its liquid", "good"),
        page.Card(f"{by_law}", "cases in which the paper's tangential law makes energy, whatever the step"),
        page.Card(f"{fine} of {len(scenes)}", "stress tests as they should be", "good" if fine == len(scenes) else "bad"),
    ]  # fmt: skip
    return page.write(
        path,
        "What stays stable",
        "Where a run stays finite, keeps its liquid and makes no energy; where it does not, and whether the time "
        "step advisor "
        "knows it.",
        [*map_sections(maps), hard_section(scenes), case_section(cases)],
        cards,
        f"{len(cases)} cases in {cases['wall_s'].sum() / 60.0:.0f} min of wall time; tables next to this page in {path.stem}/.",
    )
