"""The report held against the tables it speaks of: every curve by its legend, colour and points, and every number of its tables.

`python -m reference_impl.shown.report REPORT CASES.csv` says what is shown wrong; exit status 1 where anything is.
"""

from __future__ import annotations

import csv
import json
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from itertools import combinations
from pathlib import Path

import numpy as np

from reference_impl.faults import Refused, border, reading, regular
from reference_impl.replay.arrays import Floats
from reference_impl.replay.io import parquet_table
from reference_impl.shown import drawn, scenes, sentences, tables
from reference_impl.shown.drawn import Curve, Panel

FIGURES = ("moisture", "curves", "classes", "liquid", "presets")
TIME = "time since the slide opened in s"
AXES = {"liquid": (TIME, "liquid in % of what was put in")}
ROOM = 1e-5
"""Of the axis' unit: what is lost when a curve is drawn."""
APART = 40.0
"""Least distance of two colours of one panel, of 442 between black and white."""
CLASSES = {"": "", ", small": "_small", ", near mesh": "_near_mesh", ", large": "_large"}
PRESET_CLASSES = {"all": "", "near mesh": "_near_mesh"}
CANNOT = "share that cannot pass"


@dataclass
class Read:
    """Content of the report as read, with sentences on errors."""

    curves: int = 0
    numbers: int = 0
    scenes: int = 0
    """Numbers of the 3-D scenes."""
    faults: list[str] = field(default_factory=list)


class Runs:
    """The cases of a report and their tables."""

    def __init__(self, folder: Path, cases: Path, listed: set[int]) -> None:
        self.folder, self.listed = folder, listed
        self.pair: tuple[int, dict[str, str]] | None = None
        """Of the section at hand: the case it shows with two presets, and the folder of each."""
        with cases.open() as lines:
            self.rows = [row for row in csv.DictReader(line for line in lines if not line.startswith("#"))]
        self.column = cache(self._column)

    def name(self, number: int | str) -> str:
        """Folder of a case; of a case with a preset it is its name."""
        return f"case{number:02d}" if isinstance(number, int) else number

    def read_pair(self, section: str) -> None:
        """Know what a section on two presets is about."""
        message = tables.presets(section)
        self.pair = None
        if message is not None:
            comparisons = {p: f"{self.name(message[0])}_{p}" for p in message[1]}
            self.pair = (
                message[0],
                {p: t if (self.folder / t).exists() else self.name(message[0]) for p, t in comparisons.items()},
            )

    def numbers(self) -> list[int]:
        """Cases of the report that have results."""
        known = [int(row["case"]) for row in self.rows if int(row["case"]) in self.listed]
        return [n for n in known if (self.folder / self.name(n) / "results" / "fraction_retained.parquet").exists()]

    def done(self, number: int) -> bool:
        """Whether the results of a case are those of its last run."""
        path = self.folder / self.name(number) / "status" / "results.json"
        return path.exists() and bool(json.loads(path.read_text())["ok"])

    def moist(self, number: int) -> bool:
        """Whether a case is done and was run with bridges."""
        scene = self.folder / self.name(number) / "scene.json"
        return self.done(number) and bool(json.loads(scene.read_text())["effects"]["bridges"])

    def row(self, number: int) -> dict[str, str]:
        """Check the row of a case in the list of cases."""
        return next(row for row in self.rows if int(row["case"]) == number)

    def configuration(self, number: int) -> str:
        """A case but for its liquid, in the report's words."""
        return tables.title(self.row(number))

    def liquid(self, number: int) -> float:
        """Per cent of liquid of a case."""
        return float(self.row(number)["liquid_percent"])

    def seeds(self, number: int | str) -> list[str]:
        """Folders of a case from other first arrangements."""
        name = self.name(number)
        there = (path.parent.parent.name for path in self.folder.glob(f"{name}-*/results/fraction_retained.parquet"))
        return sorted(folder for folder in there if folder.removeprefix(f"{name}-").isdigit())

    def _column(self, number: int | str, column: str) -> tuple[Floats, Floats] | None:
        """Times and values of a column of a case; of liquid in per cent of what was put in."""
        of_liquid = column.endswith("_m3")
        name = "liquid_by_holder" if of_liquid else "fraction_retained"
        path = self.folder / self.name(number) / "results" / f"{name}.parquet"
        if not path.exists():
            return None
        table = parquet_table(path)
        if column not in table:
            return None
        y = 100.0 * table[column] / table["initial_m3"] if of_liquid else table[column]
        return table["time_since_opening_s"].to_numpy(float), y.to_numpy(float)


def check(report: Path, cases: Path) -> Read:
    """Everything that is wrong with a report, read as it stands in its file."""
    text, read = report.read_text(encoding="utf-8"), Read()
    listed = {int(row[0]) for row in tables.table(tables.section(text, "cases"))[1:]}
    runs = Runs(report.parent, cases, listed)
    colours: dict[str, dict[str, str]] = {"moisture": {}, "liquid": {}, "presets": {}}
    for figure, section in ((f, part) for f in FIGURES for part in tables.sections(text, f) or [""]):
        panels = drawn.panels(section)
        runs.read_pair(section)
        for panel in panels:
            read.curves += len(panel.curves) + len(panel.bands)
            read.faults += [
                f"figure {figure}, panel {panel.title!r}: {message}" for message in _panel(runs, figure, panel)
            ]
            read.faults += _colours(figure, panel, colours.get(figure, colours["moisture"]))
        read.faults += _missing(runs, figure, section, panels)
    read.numbers, wrong = tables.check(text, runs.folder, runs.numbers())
    liquid = {int(row["case"]): float(row["liquid_percent"] or 0.0) for row in runs.rows}
    reported, words = sentences.check(text, runs.folder, sorted(listed), liquid)
    read.scenes, unlike = scenes.check(text, runs.folder, [runs.name(n) for n in runs.numbers() if runs.moist(n)])
    read.numbers += len(reported)
    read.faults += [*wrong, *tables.wrong_of(reported), *words, *unlike]
    return read


def meant(runs: Runs, figure: str, panel: Panel, label: str) -> tuple[int | str, str] | None:
    """Case and column that a label of a panel means to a reader; None where there is none such."""
    if figure == "presets":
        preset, _, kind = label.partition(", ")
        number, folders = runs.pair or (0, {})
        named = preset in folders and panel.title == f"(a) {runs.configuration(number)}" and kind in PRESET_CLASSES
        return (folders[preset], f"fraction_retained{PRESET_CLASSES[kind]}") if named else None
    if figure == "curves":
        title = re.fullmatch(r"\(\w\) dry (\S+)", panel.title)
        dry = {n: runs.row(n) for n in runs.numbers() if not runs.liquid(n)}
        found = [n for n, row in dry.items() if title and (row["material"], tables.screen(row)) == (title[1], label)]
        return (found[0], "fraction_retained") if found else None
    title = re.fullmatch(r"\(\w\) (.*? mm, a = \S+ mm, A = \S+ mm)(?:, M = (\S+) %)?", panel.title)
    if title is None:
        return None
    here = [n for n in runs.numbers() if runs.configuration(n) == title[1]]
    if figure == "liquid":
        found = [n for n in here if title[2] and runs.liquid(n) == float(title[2])]
        return (found[0], f"{tables.HOLDERS[label]}_m3") if found and label in tables.HOLDERS else None
    words = re.fullmatch(r"(dry|M = (\S+) %)(, .*)?", label)
    if words is None or (words[3] or "") not in CLASSES:
        return None
    found = [n for n in here if runs.liquid(n) == float(words[2] or 0)]
    return (found[0], f"fraction_retained{CLASSES[words[3] or '']}") if found else None


def _panel(runs: Runs, figure: str, panel: Panel) -> Iterator[str]:
    """List the errors in one panel of a figure."""
    wanted = AXES.get(figure, (TIME, "fraction retained Y"))
    if (panel.x_label, panel.y_label) != wanted:
        yield f"the axes are called {panel.x_label!r} and {panel.y_label!r}; expected {wanted[0]!r} and {wanted[1]!r}"
    beside = {(d["case"], d["column"]): d for d in panel.beside}
    for curve in panel.curves:
        if curve.label is None:
            yield f"a curve in {curve.colour}{' dashed' if curve.dashed else ''} is not in the legend"
        elif curve.label == CANNOT:
            yield from _cannot_pass(runs, figure, panel, curve)
        else:
            case = meant(runs, figure, panel, curve.label)
            if case is None:
                yield f"there is no case for the label {curve.label!r} in this panel"
                continue
            name = (runs.name(case[0]), case[1])
            if not _same(curve, runs.column(*case)):
                yield f"the curve labelled {curve.label!r} should be {case[1]} of case {case[0]}, {_is(runs, curve)}"
            elif curve.claim != ":".join(name):
                yield f"the curve labelled {curve.label!r} is named {curve.claim} in the file"
            elif name not in beside or not _same(curve, (np.array(beside[name]["x"]), np.array(beside[name]["y"]))):
                yield f"the data beside the curve labelled {curve.label!r} are not those of the curve"
            elif beside[name]["label"] != curve.label or beside[name]["colour"] != curve.colour:
                yield f"label or colour beside the curve labelled {curve.label!r} are not those of the curve"
            if figure != "liquid":
                yield from _band(runs, panel, curve, case)


def _band(runs: Runs, panel: Panel, curve: Curve, case: tuple[int | str, str]) -> Iterator[str]:
    """What is wrong with the band behind a curve, which goes from the least to the most of all seeds of its case."""
    own, seeds = runs.column(*case), runs.seeds(case[0])
    others = [of for seed in seeds if (of := runs.column(seed, case[1])) is not None]
    bands = [b for b in panel.bands if b.claim == f"{curve.claim}{drawn.BAND}"]
    if own is None or not others:
        if bands:
            yield f"behind the curve labelled {curve.label!r} is a band, but there are no other seeds of case {case[0]}"
        return
    every = [own[1], *(np.interp(own[0], *other) for other in others)]
    low, high = np.min(every, axis=0), np.max(every, axis=0)
    if len(bands) != 1 or bands[0].colour != curve.colour:
        yield f"behind the curve labelled {curve.label!r} should be the band of its {len(every)} seeds, in its colour"
        return
    top, inside = bands[0].top, own[0] >= 0.0
    if len(top) != len(high) or not all(
        (np.abs(shown - of)[inside] <= ROOM).all() for shown, of in ((top, high), (top - bands[0].y, low))
    ):
        yield f"the band behind the curve labelled {curve.label!r} is not from the least to the most of its {len(every)} seeds"


def _same(curve: Curve, of: tuple[Floats, Floats] | None, factor: float = 1.0) -> bool:
    """Whether a curve shows these values, where its axes reach."""
    if of is None or (points := _shown(curve, of[0])) is None:
        return False
    inside = of[0] >= 0.0
    margin = ROOM * np.maximum(1.0, np.abs(of[1]).max(initial=0.0))
    return bool(
        (np.abs(points[0] - of[0][inside]) <= ROOM).all()
        and (np.abs(points[1] - factor * of[1][inside]) <= margin).all()
    )


def _shown(curve: Curve, time: Floats) -> tuple[Floats, Floats] | None:
    """Points of a curve for these times, where the axes reach: from zero on; None where their number differs.

    What lies left of that may be cut where the picture ends, with a point there.
    """
    many = int((time >= 0.0).sum())
    before = len(curve.x) - many
    if before < 0 or (curve.x[:before] > ROOM).any():
        return None
    return curve.x[before:], curve.y[before:]


def _is(runs: Runs, curve: Curve) -> str:
    """Identify the data that a curve shows."""
    columns = [
        *(f"fraction_retained{c}" for c in (*CLASSES.values(), "_spheres")),
        *(f"{h}_m3" for h in tables.HOLDERS.values()),
    ]
    for number in [*runs.numbers(), *(runs.pair[1].values() if runs.pair else ())]:
        for column in columns:
            values = runs.column(number, column)
            if _same(curve, values):
                return f"but is {column} of case {number}"
            if values is not None and (points := _shown(curve, values[0])) is not None and len(points[0]):
                if _same(curve, (values[0], 1.0 - values[1])):
                    return f"but is 1 minus {column} of case {number}"
                if _same(curve, (values[0] + curve.x[-1] - values[0][-1], values[1])):
                    return f"but is {column} of case {number} moved by {curve.x[-1] - values[0][-1]:.3g} s"
                own = values[1][values[0] >= 0.0]
                with np.errstate(all="ignore"):
                    factor = float(np.median((points[1] / own)[own != 0])) if own.any() else 0.0
                if factor and _same(curve, values, factor):
                    return f"but is {factor:.4g} times {column} of case {number}"
    return "but is none of the columns of any case"


def _cannot_pass(runs: Runs, figure: str, panel: Panel, curve: Curve) -> Iterator[str]:
    """The line at the share that cannot pass."""
    shares = []
    for number in runs.numbers():
        title = f"dry {runs.row(number)['material']}" if figure == "curves" else runs.configuration(number)
        summary = tables.summary(runs.folder, number)
        if panel.title.split(" ", 1)[-1] == title and summary:
            shares.append(summary["coarse_share"])
    if not any(np.allclose(curve.y, share, atol=ROOM, rtol=0.0) for share in shares):
        yield f"the line at the share that cannot pass is at {curve.y[0]:.4g}; expected {' or '.join(f'{s:.4g}' for s in shares)}"


def _colours(figure: str, panel: Panel, seen: dict[str, str]) -> list[str]:
    """A colour means one liquid amount in all panels of a material, or one holder in all; and two colours can be told apart."""
    found, here = [], {}
    for curve in panel.curves:
        if curve.label is None or curve.label == CANNOT or figure == "curves":
            continue
        what = curve.label.split(",")[0]
        here[what] = curve.colour
        amount = what.startswith("M = ")  # materials have other amounts: the lesser has one colour, the greater another
        of = panel.title.split(" ")[1] if amount and " " in panel.title else ""
        others = {seen.setdefault(curve.colour, what), seen.setdefault(of + curve.colour, what)} - {what}
        for other in sorted(
            o for o in others if not (amount and o.startswith("M = ") and o != seen[of + curve.colour])
        ):
            found.append(
                f"figure {figure}, panel {panel.title!r}: {curve.colour} stands for {what!r}, elsewhere for {other!r}"
            )
        if (", near mesh" in curve.label and not curve.dashed) or (", small" in curve.label and curve.dashed):
            found.append(f"figure {figure}, panel {panel.title!r}: {curve.label!r} is {'dashed' if curve.dashed else 'solid'}; "
                         "expected small solid, near mesh dashed")  # fmt: skip
    for (a, one), (b, two) in combinations(here.items(), 2):
        if np.linalg.norm(np.subtract(_rgb(one), _rgb(two))) < APART:
            found.append(
                f"figure {figure}, panel {panel.title!r}: the colours of {a!r} and {b!r} can hardly be told apart"
            )
    return found


def _rgb(colour: str) -> tuple[int, ...]:
    return tuple(int(colour[k : k + 2], 16) for k in (1, 3, 5))


def _missing(runs: Runs, figure: str, section: str, panels: list[Panel]) -> Iterator[str]:
    """Cases with results that a figure of all cases leaves out; curves next to a figure that it does not show."""
    shown = {c.claim.split(":")[0] for panel in panels for c in panel.curves if c.label and c.label != CANNOT}
    for number in filter(runs.done, runs.numbers()):
        if runs.name(number) not in shown and (
            figure == "moisture" or (figure == "curves" and not runs.liquid(number))
        ):
            yield f"figure {figure}: case {number} is not shown"
    for folder in set(runs.pair[1].values()) - shown if runs.pair and tables.table(section) else ():
        yield f"figure {figure}: {folder} is not shown"
    for panel in panels:
        for data in panel.beside:
            if f"{data['case']}:{data['column']}" not in [c.claim for c in panel.curves]:
                yield f"figure {figure}, panel {panel.title!r}: {data['column']} of {data['case']} is beside it but not shown"


def main(arguments: list[str]) -> int:
    """Print what the report shows differently from the result files."""
    if len(arguments) != 2:
        raise Refused(f"{len(arguments)} arguments were given; expected REPORT CASES.csv")
    with reading(" and ".join(arguments), "the report of a folder of runs and the table of its cases"):
        read = check(regular(Path(arguments[0])), regular(Path(arguments[1])))
    print(
        f"{read.curves} curves, {read.numbers} numbers and {read.scenes} numbers of 3-D scenes read; {len(read.faults)} wrong"
    )
    print("\n".join(read.faults))
    return int(bool(read.faults))


if __name__ == "__main__":
    with border(1):
        sys.exit(main(sys.argv[1:]))
