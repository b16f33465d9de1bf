"""Figures of runs for print: fraction retained, liquid and partition, groups of seeds as mean and band."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import reduce
from itertools import takewhile
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from pywet.cases.screening.results import class_titles
from pywet.errors import PywetError
from pywet.products import destinations
from pywet.products.screening_report import aperture_of
from pywet.report.pictures import INK, STYLE, colours, dash, panels, plt
from pywet.runs.distinct_seeds import distinct_seeds, not_counted
from pywet.runs.rundir import Floats, RunDir
from pywet.runs.spread import quantile
from pywet.util.files import atomic_write
from pywet.util.notices import notice

FORMATS = (".pdf", ".svg", ".png")
THESIS: Any = {
    **STYLE,
    "font.size": 8,
    "axes.titlesize": 8,
    "legend.fontsize": 7,
    "lines.linewidth": 1.2,
    "lines.markersize": 4,
    "savefig.dpi": 300,
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
}
"""Style of the figure: font sizes as printed, since the figure has its printed width; text of PDF and SVG remains text."""
WIDTH, LEAST, HEIGHT, FEW, ROW = 150.0, 65.0, 65.0, 2, 3.8
"""Sizes [mm] of a figure and its panels.

They are the width of a figure (text width of an A4 thesis), the least width and the height of a panel, the largest
number of entries of a legend inside the panel, and the height of a row of one below it.
"""
SHORT, LONG, SAME = 16, 40, 12
"""Letters of an entry up to which a legend has two columns or is inside its panel; at most; and on each side of a difference."""
LETTER = 1.3
"""Width of a letter of the notes [mm]."""
MOST = 6
"""Number of liquid reservoirs above which those of spheres and of walls are summed."""
INCH = 25.4
LIQUID = (
    "coarse_material", "fines", "films", "bridges", "walls", "wires", "side_wall", "feed_bin", "outlet", "impact_plate",
    "collecting_bin", "left",
)  # fmt: skip
"""Liquid reservoirs that are drawn if present; for user-defined scenes every class and wall, or sums of many."""
LEAST_SHARE = 0.01
"""Largest value over that of the panel below which the curve of a liquid reservoir is not drawn."""
LEDGER = {"films": "in films", "bridges": "in bridges", "walls": "on walls", "retired": "left with spheres"}
"""Columns of the ledger that are drawn of a user-defined scene with one class of spheres and no outlet."""
TIME, SINCE_OPENING = "time [s]", "time since the slide opened [s]"
BOTH = {"overs", "unders"}
"""Outlets of which the partition of the first says all."""
JOINED = {"spheres": "on spheres", "wall": "on walls"}
"""First word of the reservoirs of a user-defined scene that are summed if there are many, and name of the sum."""


@dataclass
class Panel:
    """One panel: for every group the curves of its runs by name, each as (positions, values)."""

    x: str
    y: str
    curves: dict[tuple[str, str], list[tuple[Floats, Floats]]] = field(default_factory=dict)
    """(group, curve) -> one entry for each run."""
    ends: dict[tuple[str, str], list[tuple[Floats, Floats]]] = field(default_factory=dict)
    """(group, curve) -> for each run the ends of the 95 % intervals at its positions, if known."""
    apertures: set[float] = field(default_factory=set)
    """Apertures of the runs [mm], drawn as vertical lines."""
    least: float = 0.0
    """Largest value over that of the panel below which a curve is left out."""

    def add(self, group: str, name: str, x: Any, y: Any) -> None:
        curve = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        self.curves.setdefault((group, name), []).append(curve)

    def common(self) -> None:
        """Retain of the runs of a curve the positions that all have: a size of which one run has no sphere has no mean."""
        for key, of in [(key, of) for key, of in self.curves.items() if len(of) > 1]:
            at = reduce(np.intersect1d, (x for x, _ in of))
            self.curves[key] = [(x[np.isin(x, at)], y[np.isin(x, at)]) for x, y in of]
            if not len(at):
                del self.curves[key]

    @property
    def bars(self) -> bool:
        """Return whether intervals of single runs are drawn."""
        return any(len(of) == 1 for of in self.ends.values())

    def largest(self) -> dict[tuple[str, str], list[tuple[Floats, Floats]]]:
        """Return the curves without those whose largest value is below `least` of the panel's."""
        names = list(dict.fromkeys(name for _, name in self.curves))
        top = {
            name: max(float(y.max()) for key, of in self.curves.items() if key[1] == name for _, y in of)
            for name in names
        }
        return {key: of for key, of in self.curves.items() if not top[key[1]] < self.least * max(top.values())}

    def entries(self, labels: Mapping[str, str]) -> dict[str, tuple[str, Any]]:
        """Return the legend entries with colour and dash: for one group its curves; for several the groups, then their curves."""
        names = list(dict.fromkeys(name for _, name in self.largest()))
        if len(labels) == 1:
            (label,) = labels.values()
            return {name or label: (of, dash(0)) for name, of in zip(names, colours(len(names)), strict=True)}
        there, of_groups = {group for group, _ in self.curves}, zip(labels.items(), colours(len(labels)), strict=True)
        found = {label: (of, dash(0)) for (group, label), of in of_groups if group in there}
        if len(names) > 1:
            found |= {name: (INK, dash(j)) for j, name in enumerate(names)}
        return found


def grouped(run_dirs: Sequence[Path], alike: Callable[[Path, Path], bool]) -> dict[str, list[Path]]:
    """Group runs by case: a folder CASE-SEED given together with CASE is another seed of it, each seed once.

    A run that differs from CASE in more than the seed, by `alike`, is a separate group, with a notice.
    """
    groups: dict[str, list[Path]] = {}
    for folder in sorted(map(Path, run_dirs), key=str):
        first = re.sub(r"-\d+$", "", str(folder))
        if first in groups and not alike(groups[first][0], folder):
            not_counted(folder, groups[first][0])
            first = str(folder)
        groups.setdefault(first if first in groups else str(folder), []).append(folder)
    groups = {name: distinct_seeds(runs) for name, runs in groups.items()}
    names = [Path(name).name for name in groups]
    short = len(set(names)) == len(names)
    return {Path(name).name if short else name: runs for name, runs in groups.items()}


def panels_of(groups: Mapping[str, Sequence[Path]]) -> list[Panel]:
    """Return the panels for which the runs have tables; raises if a group has none of them."""
    retained = Panel(SINCE_OPENING, "fraction retained [-]")
    liquid = {x: Panel(x, "share of the liquid put in [-]", least=LEAST_SHARE) for x in (SINCE_OPENING, TIME)}
    touching = Panel(TIME, "number per sphere [-]")
    partition = Panel("diameter [mm]", "partition: share retained [-]")
    outlets, trays = (Panel("diameter [mm]", f"partition by {by} [-]") for by in ("outlet", "tray"))
    drawn = (retained, partition, outlets, trays, *liquid.values(), touching)
    for group, folders in groups.items():
        runs = [RunDir(Path(folder)) for folder in folders]
        for run in runs:
            _retained(run, group, retained, partition)
            _touching(run, group, touching)
        _destinations(runs, group, {"outlet": outlets, destinations.TRAY: trays})
        _liquid(runs, group, liquid)
        for of_sizes in (partition, outlets, trays):
            of_sizes.common()
        if not any(key[0] == group for p in drawn for key in p.curves):
            raise PywetError(
                f"{folders[0]} has neither a fraction retained nor a partition nor liquid to plot; expected a finished "
                "screening case, a scene whose sizes part by outlet or tray, or a moist scene",
                code="plot.nothing", where=folders[0],
            )  # fmt: skip
        for panel in drawn:
            counts = [len(of) for key, of in panel.curves.items() if key[0] == group]
            if counts and min(counts) < len(runs):
                quantity = panel.y.partition(" [")[0]
                notice.warning(
                    f"{group}: {min(counts)} of {len(runs)} runs have data for '{quantity}'; others are left out"
                )
    if {name for _, name in outlets.curves} == BOTH:
        outlets.y = "share to the overs [-]"
        for held in (outlets.curves, outlets.ends):
            for key in [key for key in held if key[1] == "unders"]:
                held.pop(key)
    return [p for p in drawn if p.curves]


def _retained(run: RunDir, group: str, retained: Panel, partition: Panel) -> None:
    table = run.table_if_there("results/fraction_retained")
    if table is None:
        return
    retained.add(group, "", table["time_since_opening_s"], table["fraction_retained"])
    at_end = run.table_if_there("results/partition")
    if at_end is not None and len(at_end) > 1:
        partition.add(group, "", at_end["diameter_mm"], at_end["T"])
        partition.ends.setdefault((group, ""), []).append((at_end["T_low"].to_numpy(), at_end["T_high"].to_numpy()))
        _aperture(run, partition)


def _aperture(run: RunDir, panel: Panel) -> None:
    if (aperture := aperture_of(run)) is not None:
        panel.apertures.add(aperture)


def _destinations(runs: Sequence[RunDir], group: str, panels_by: Mapping[str, Panel]) -> None:
    """Add the shares of each size of finished runs of a custom scene by outlet or tray."""
    finished = [run for run in runs if run.scene.slide is None and (run.path / "trajectory.parquet").exists()]
    by, tables = destinations.shares(finished) or ("", [])
    for run, table in [(run, table) for run, table in zip(finished, tables, strict=False) if len(table)]:
        panel, ends = panels_by[by], destinations.intervals(run, [str(name) for name in table])
        for name in table.columns:
            curve = str(name).replace("_", " ")
            panel.add(group, curve, table.index, table[name])
            panel.ends.setdefault((group, curve), []).append(ends[str(name)])
        _aperture(run, panel)


def _touching(run: RunDir, group: str, panel: Panel) -> None:
    """Add bridges and touching spheres per sphere of a user-defined scene without outlets."""
    table = run.table_if_there("results/contact_statistics")
    if table is None or run.scene.outlets:
        return
    for name in ("bridges", "contacts")[0 if run.moist else 1 :]:
        panel.add(group, name, table["time_s"], table[f"{name}_per_sphere"])


def _liquid(runs: Sequence[RunDir], group: str, panels_by: Mapping[str, Panel]) -> None:
    """Add the liquid reservoirs of moist runs, each to the panel of its time; one that is empty in some runs is zero there."""
    scene = runs[0].scene
    if not runs[0].moist:
        return
    titles = class_titles(scene)
    by_wall = ("results/liquid_by_wall",) if scene.outlets or len(scene.classes) > 1 else ()
    for name in ("results/liquid_by_holder", *by_wall, "history/ledger"):
        tables = [table for run in runs if (table := run.table_if_there(name)) is not None]
        reservoirs = list(dict.fromkeys(c for table in tables for c in _reservoirs(table, name.endswith("wall"))))
        time, initial, end = ("time", "initial", "") if name == "history/ledger" else ("time_s", "initial_m3", "_m3")
        last = min((table[time].max() for table in tables), default=0.0)  # of the shortest run, as of the band
        for table in tables:
            put_in = table[initial][table[time] <= last + 1e-12].max() or 1.0
            opened = "time_since_opening_s" in table
            at, panel = table["time_since_opening_s" if opened else time], panels_by[SINCE_OPENING if opened else TIME]
            shares: dict[str, Any] = {}
            for reservoir in reservoirs:
                word = reservoir.removesuffix(end)
                curve = LEDGER.get(word) if name == "history/ledger" else titles.get(word)
                curve = curve or word.removeprefix("outlet_").replace("_", " ")
                if len(reservoirs) > MOST:  # all spheres, all walls
                    curve = JOINED.get(word.partition("_")[0], curve)
                shares[curve] = shares.get(curve, 0.0) + table[reservoir] / put_in
            for curve, share in shares.items():
                panel.add(group, curve, at, share)
        if tables:
            return


def _reservoirs(table: pd.DataFrame, every: bool) -> list[str]:
    if every:
        return [c for c in table.columns if c.startswith(("spheres_", "wall_", "outlet_")) and table[c].any()]
    return [c for c in table.columns if c.removesuffix("_m3") in LIQUID and table[c].any()]


def mean_and_band(curves: Sequence[tuple[Floats, Floats]]) -> tuple[Floats, Floats, Floats | None]:
    """Positions of the first curve that all cover, the mean there, half width of its 95 % interval (None of one run).

    >>> at = np.array([0.0, 1.0])
    >>> x, mean, half = mean_and_band([(at, np.array([1.0, 3.0])), (at, np.array([1.0, 5.0]))])
    >>> mean.tolist(), half.round(2).tolist()
    ([1.0, 4.0], [0.0, 12.71])
    """
    low, high = max(x[0] for x, _ in curves), min(x[-1] for x, _ in curves)
    first = curves[0][0]
    at = first[(first >= low - 1e-12) & (first <= high + 1e-12)]
    values = np.array([np.interp(at, x, y) for x, y in curves])
    if len(curves) < 2:
        return at, values[0], None
    return at, values.mean(0), quantile(len(curves)) * values.std(0, ddof=1) / np.sqrt(len(curves))


def check_name(path: Path, formats: Sequence[str] = FORMATS) -> None:
    """Refuse the name of a figure whose suffix is not one of the formats."""
    if path.suffix.lower() not in formats:
        raise PywetError(
            f"{path} was given for a figure; expected a name that ends in {', '.join(formats)}",
            code="plot.suffix", given=path.suffix, expected=formats,
        )  # fmt: skip


def write(path: Path, groups: Mapping[str, Sequence[Path]], width_mm: float = WIDTH) -> Path:
    """Draw the groups into a PDF, SVG or PNG file of this width; panels are side by side if they are at least LEAST wide."""
    path = Path(path)
    check_name(path)
    shown = panels_of(groups)
    with plt.rc_context(THESIS):
        columns = max(1, min(len(shown), int(width_mm // LEAST)))
        labels = _labels(groups)
        below = max(_rows(panel.entries(labels)) for panel in shown) * ROW
        figure, axes = panels(len(shown), columns, (width_mm / columns / INCH, (HEIGHT + below) / INCH))
        for one, panel in zip(axes, shown, strict=False):  # the last row may have unused axes
            _draw(one, panel, labels)
        notes = ["bands: 95 % confidence interval of the mean over the seeds"] * any(
            len(of) > 1 for panel in shown for of in panel.curves.values()
        )
        notes += ["bars: 95 % intervals of the counts of one run"] * any(panel.bars for panel in shown)
        hidden = any(len(panel.largest()) < len(panel.curves) for panel in shown)
        notes += [f"reservoirs below {100 * LEAST_SHARE:g} % of the largest are left out"] * hidden
        if notes:
            lines = [line for note in notes for line in textwrap.wrap(note, int(width_mm / LETTER))]
            figure.supxlabel("\n".join(lines), fontsize=7, color=INK)
        with atomic_write(path) as temporary:
            stamp = {".pdf": {"CreationDate": None}, ".svg": {"Date": None}}.get(path.suffix.lower())
            figure.savefig(temporary, format=path.suffix.lower()[1:], metadata=stamp)
        plt.close(figure)
    return path


def _labels(groups: Mapping[str, Sequence[Path]]) -> dict[str, str]:
    """Return the name of each group in a legend, distinct, with its liquid if the groups differ in it."""
    percent = [_percent(RunDir(Path(folders[0]))) for folders in groups.values()]
    liquid = [f" ({value} liquid)" if len(set(percent)) > 1 else "" for value in percent]
    short = _short(list(groups), LONG - max(map(len, liquid)))
    return {group: name + of for group, name, of in zip(groups, short, liquid, strict=True)}


def _percent(run: RunDir) -> str:
    """Return the liquid over the dry mass, both of the spheres that have entered by the end, in per cent."""
    liquid, mass_of = run.scene.liquid, {c.type: c.mass_kg for c in run.scene.classes}
    last = run.ledger.iloc[-1] if run.moist else {"initial": 0.0}
    if liquid is None or not last["initial"]:
        return "0 %"
    mass = run.spheres["type"][run.enters <= last["step"]].map(mass_of).sum()
    return f"{100.0 * last['initial'] * liquid.density_kg_per_m3 / mass:.3g} %"


def _short(texts: Sequence[str], most: int = LONG) -> list[str]:
    """Return distinct labels of at most about `most` letters: without what all begin and end with, shortened in the middle.

    >>> _short([f"deck_15_degrees_2_mm_20_Hz_moisture_{k}_percent_run_of_ore" for k in (2, 8)])
    ['…Hz_moisture_2_percent_run…', '…Hz_moisture_8_percent_run…']
    """
    if max(map(len, texts)) <= most:
        return list(texts)
    first, last = map(_alike, (texts, [text[::-1] for text in texts]))
    start, end = max(first - SAME, 0), max(min(last, min(map(len, texts)) - first) - SAME, 0)
    short = ["…" * (start > 0) + text[start : len(text) - end] + "…" * (end > 0) for text in texts]
    half = (most - 1) // 2
    short = [text if len(text) <= most else f"{text[:half]}…{text[-half:]}" for text in short]
    return short if len(set(short)) == len(short) else [f"{k}: {text}" for k, text in enumerate(short, 1)]


def _alike(texts: Sequence[str]) -> int:
    """Return the number of letters with which all texts begin; 0 for a single one."""
    same = takewhile(lambda letters: len(set(letters)) == 1, zip(*texts, strict=False))
    return len(list(same)) if len(texts) > 1 else 0


def _inside(entries: Collection[str]) -> bool:
    """Return whether a legend fits into its panel."""
    return len(entries) <= FEW and max(map(len, entries)) <= SHORT


def _columns(entries: Collection[str]) -> int:
    return 1 if max(map(len, entries)) > SHORT else 2


def _rows(entries: Collection[str]) -> int:
    """Return the number of rows of a legend below a panel, 0 for one inside."""
    return 0 if _inside(entries) else -(-len(entries) // _columns(entries))


def _draw(axes: Axes, panel: Panel, labels: Mapping[str, str]) -> None:
    """Draw one panel: a colour for each group, or for each curve if there is one group; otherwise curves differ in dashes."""
    groups, drawn = list(labels), panel.largest()
    names = list(dict.fromkeys(name for _, name in drawn))
    of = colours(len(groups) if len(groups) > 1 else len(names))
    for (group, name), curves in drawn.items():
        k, j = groups.index(group), names.index(name)
        colour, line = (of[k], dash(j)) if len(groups) > 1 else (of[j], dash(0))
        x, mean, half = mean_and_band(curves)
        axes.plot(x, mean, marker="o" if panel.x.startswith("diameter") else "", color=colour, linestyle=line)
        ends = panel.ends.get((group, name), [])
        if half is not None:
            axes.fill_between(x, mean - half, mean + half, color=colour, alpha=0.2, linewidth=0)
        elif len(ends) == 1:
            axes.vlines(x, *ends[0], color=colour, alpha=0.5, linewidth=1)
    for aperture in sorted(panel.apertures):
        axes.axvline(aperture, color=INK, linestyle=":", linewidth=0.8)
        axes.annotate(
            " aperture", (aperture, 1.0), (0, 2), ("data", "axes fraction"), "offset points", ha="center", fontsize=7
        )
    axes.set_xlabel(panel.x)
    axes.set_ylabel(panel.y)
    axes.locator_params(axis="x", nbins=6)
    entries = panel.entries(labels)
    handles = [Line2D([], [], color=colour, linestyle=line) for colour, line in entries.values()]
    below: Any = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.22), "ncols": _columns(entries)}
    axes.legend(handles, _short(list(entries)), **({} if _inside(entries) else below))
