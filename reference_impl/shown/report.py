"""Compare the report with its sources: report.json, every number of the page, every curve by legend, colour and points.

`python -m reference_impl.shown.report REPORT CASES.csv` prints errors of the report; exit status 1 if there are any.
The meaning of numbers and curves is read from report.json by keys, never from the wording of the page.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import combinations
from pathlib import Path

import numpy as np

from reference_impl.faults import Refused, border, reading, regular
from reference_impl.replay.arrays import Floats
from reference_impl.shown import drawn, report_page, report_values, scenes
from reference_impl.shown.case_files import Cases, name_of
from reference_impl.shown.drawn import Curve, Panel
from reference_impl.shown.report_page import Numbers

TIME, COARSE = "time_since_opening_s", "coarse_share"
FRACTION, LIQUID = "fraction_retained", "liquid_percent"
MARGIN = 1e-5
"""Error of a drawn curve, in units of the axis."""
APART = 40.0
"""Smallest distance of two colours of one panel, of 442 between black and white."""
CLASSES = ("", "_small", "_near_mesh", "_large")
DASHED = "_near_mesh"


@dataclass
class Read:
    """Content of the report as read, with sentences on errors."""

    curves: int = 0
    numbers: int = 0
    scenes: int = 0
    """Number of values in the 3-D scenes."""
    faults: list[str] = field(default_factory=list)
    unknown: list[str] = field(default_factory=list)
    """Unknown keys of report.json, whose values were not checked."""


class Runs(Cases):
    """Cases of a report, and for those with two presets the folder of each."""

    def __init__(self, report: Path, table: Path, numbers: Numbers) -> None:
        listed = [int(name) for key in numbers if (name := key.removeprefix("label.case")).isdigit()]
        super().__init__(report.parent, table, listed)
        self.numbers = numbers
        self.of_presets = report_values.runs_of_presets(self, numbers)

    def with_results(self) -> list[int]:
        """Return the cases of the report that have results."""
        return [n for n in self.listed if self.retained(n)]

    def title(self, figure: str, number: int) -> str:
        """Return the values that the heading of a panel with a case must state."""
        if figure == "dry":
            return self.rows[number]["material"]
        return (
            f"{self.configuration(number)} {self.amount(number)}" if figure == "liquid" else self.configuration(number)
        )

    def amount(self, number: int) -> str:
        """Return the per cent of liquid of a case, and the name of the liquid if the list of cases gives it."""
        return f"{self.liquid(number):g} {self.liquid_name(number)}".strip()

    def meaning(self, figure: str, run: str, column: str) -> str | None:
        """Return the values that the label of a curve must state; None for a run that the figure cannot contain."""
        if column == COARSE:
            return COARSE
        of_class = column.removeprefix(FRACTION).removeprefix("_")
        start, _, case = figure.partition(".")
        if start == "presets":
            names = {folder: preset for preset, folder in self.of_presets.get(case, {}).items()}
            return f"{names[run]} {of_class}".strip() if run in names else None
        number = self.number(run)
        if number is None or (start == "dry" and self.liquid(number)):
            return None
        if start == "liquid":
            return column.removesuffix("_m3")
        return self.screen(number) if start == "dry" else f"{self.amount(number)} {of_class}".strip()

    def number(self, run: str) -> int | None:
        """Return the number of the case of a folder, also for one with another preset; None for another folder."""
        return next((n for n in self.listed if run == name_of(n) or run.startswith(f"{name_of(n)}_")), None)


def check(report: Path, table: Path) -> Read:
    """Check a report in its two files and return all errors; `table`: the cases in CSV."""
    stored = report.with_suffix(".json")
    if not stored.is_file():
        raise Refused(f"{report} has no {stored.name} next to it; expected that file: write the report again")
    text, numbers = report.read_text(encoding="utf-8"), json.loads(stored.read_text(encoding="utf-8"))
    page, runs, read = report_page.Page(text), Runs(report, table, numbers), Read()
    read.numbers, read.faults, read.unknown = report_values.wrong(runs, numbers)
    read.faults += report_page.wrong(page, numbers)
    colours: dict[tuple[str, str], str] = {}
    figures = drawn.figures(text)
    for figure, panels in figures:
        for k, panel in enumerate(panels):
            read.curves += len(panel.curves) + len(panel.bands)
            where = f"figure {figure}, panel {k + 1}: "
            read.faults += [where + message for message in _panel(runs, figure, f"figure.{figure}.{k}", panel)]
            read.faults += [where + message for message in _colours(runs, figure, panel, colours)]
        read.faults += [f"figure {figure}: {message}" for message in _missing(runs, figure, panels)]
    read.faults += _figures_missing(runs, {figure for figure, _ in figures})
    moist = [name_of(n) for n in runs.with_results() if runs.results_are_last(n) and runs.bridged(n)]
    read.scenes, unlike = scenes.check(text, runs.folder, moist)
    read.faults += unlike
    return read


def _panel(runs: Runs, figure: str, key: str, panel: Panel) -> Iterator[str]:
    """List the errors in one panel of a figure."""
    axes = {"x": TIME, "y": LIQUID if figure == "liquid" else FRACTION}
    for axis, words in (("x", panel.x_label), ("y", panel.y_label)):
        yield from _words(runs, f"{key}.{axis}", axes[axis], [words], f"the axis {axis}")
    alongside = {(d["case"], d["column"]): d for d in panel.alongside}
    for curve in panel.curves:
        run, _, column = curve.claim.partition(":")
        meaning, number = runs.meaning(figure, run, column), runs.number(run)
        if curve.label is None:
            yield f"a curve in {curve.colour}{' dashed' if curve.dashed else ''} is not in the legend"
            continue
        if meaning is None or number is None:
            yield f"a curve is named {curve.claim}, which is no case of this figure"
            continue
        yield from _words(runs, f"{key}.{run}.{column}", meaning, [curve.label], f"the curve of {curve.claim}")
        yield from _words(
            runs, f"{key}.title", runs.title(figure, number), panel.titles, f"the heading above {curve.claim}"
        )
        if column == COARSE:
            yield from _coarse(runs, run, curve)
            continue
        if not _same(curve, runs.column(run, column)):
            yield f"the curve labelled {curve.label!r} should be {column} of {run}, {_is(runs, curve)}"
        elif (run, column) not in alongside or not _same(curve, _points(alongside[run, column])):
            yield f"the data next to the curve labelled {curve.label!r} are not those of the curve"
        elif alongside[run, column]["label"] != curve.label or alongside[run, column]["colour"] != curve.colour:
            yield f"label or colour next to the curve labelled {curve.label!r} are not those of the curve"
        if figure != "liquid":
            yield from _band(runs, panel, curve, run, column)
        if figure != "liquid" and curve.dashed != column.endswith(DASHED):
            yield f"{curve.label!r} is {'dashed' if curve.dashed else 'solid'}; expected near mesh dashed, all others solid"


def _points(data: dict[str, list[float]]) -> tuple[Floats, Floats]:
    return np.array(data["x"]), np.array(data["y"])


def _words(runs: Runs, key: str, value: str, words: list[str], what: str) -> Iterator[str]:
    """List errors in the labels of a picture, which must be those of report.json, mean `value` and state its parts."""
    stored = runs.numbers.get(key)
    if stored is None:
        yield f"{what}: report.json has no {key}"
    elif stored["shown"] not in words:
        yield f"{what} is called {' or '.join(map(repr, words)) or 'nothing'}; report.json has {stored['shown']!r}"
    elif stored["value"] != value:
        yield f"{what} is called {stored['shown']!r} for {stored['value']!r}; expected {value!r}"
    elif value not in (TIME, LIQUID, FRACTION) and not report_values.states(stored["shown"], value, runs.numbers):
        yield f"{what} is called {stored['shown']!r}; expected words that state {value!r}"


def _band(runs: Runs, panel: Panel, curve: Curve, run: str, column: str) -> Iterator[str]:
    """List errors in the band behind a curve, which spans the smallest to the largest value of all seeds of its case."""
    curves, seeds = runs.column(run, column), runs.seeds(run)
    others = [of for seed in seeds if (of := runs.column(seed, column)) is not None]
    bands = [b for b in panel.bands if b.claim == f"{curve.claim}{drawn.BAND}"]
    if curves is None or not others:
        if bands:
            yield f"behind the curve labelled {curve.label!r} is a band, but there are no other seeds of {run}"
        return
    every = [curves[1], *(np.interp(curves[0], *other) for other in others)]
    low, high = np.min(every, axis=0), np.max(every, axis=0)
    if len(bands) != 1 or bands[0].colour != curve.colour:
        yield f"behind the curve labelled {curve.label!r} should be the band of its {len(every)} seeds, in its colour"
        return
    top, inside = bands[0].top, curves[0] >= 0.0
    if len(top) != len(high) or not all(
        (np.abs(shown - of)[inside] <= MARGIN).all() for shown, of in ((top, high), (top - bands[0].y, low))
    ):
        yield f"the band behind the curve labelled {curve.label!r} is not from the least to the most of its {len(every)} seeds"


def _same(curve: Curve, of: tuple[Floats, Floats] | None, factor: float = 1.0) -> bool:
    """Return whether a curve shows these values within its axes."""
    if of is None or (points := _shown(curve, of[0])) is None:
        return False
    inside = of[0] >= 0.0
    margin = MARGIN * np.maximum(1.0, np.abs(of[1]).max(initial=0.0))
    return bool(
        (np.abs(points[0] - of[0][inside]) <= MARGIN).all()
        and (np.abs(points[1] - factor * of[1][inside]) <= margin).all()
    )


def _shown(curve: Curve, time: Floats) -> tuple[Floats, Floats] | None:
    """Return the points of a curve for these times within the axes, from zero on; None if their number differs.

    Points to the left may be clipped at the edge of the picture, with a point there.
    """
    many = int((time >= 0.0).sum())
    before = len(curve.x) - many
    if before < 0 or (curve.x[:before] > MARGIN).any():
        return None
    return curve.x[before:], curve.y[before:]


def _is(runs: Runs, curve: Curve) -> str:
    """Identify the data that a curve shows."""
    columns = [
        *(f"{FRACTION}{c}" for c in (*CLASSES, "_spheres")),
        *(f"{reservoir}_m3" for reservoir in report_values.RESERVOIRS),
    ]
    names = [name_of(n) for n in runs.with_results()]
    for run in [*names, *(run for of in runs.of_presets.values() for run in of.values() if run not in names)]:
        for column in columns:
            values = runs.column(run, column)
            if _same(curve, values):
                return f"but is {column} of {run}"
            if values is not None and len(left_out := _left_out(curve, values)):
                return f"but is {column} of {run} without its points at {', '.join(f'{t:.4g}' for t in left_out)} s"
            if values is not None and (points := _shown(curve, values[0])) is not None and len(points[0]):
                if _same(curve, (values[0], 1.0 - values[1])):
                    return f"but is 1 minus {column} of {run}"
                if _same(curve, (values[0] + curve.x[-1] - values[0][-1], values[1])):
                    return f"but is {column} of {run} moved by {curve.x[-1] - values[0][-1]:.3g} s"
                inside = values[1][values[0] >= 0.0]
                with np.errstate(all="ignore"):
                    factor = float(np.median((points[1] / inside)[inside != 0])) if inside.any() else 0.0
                if factor and _same(curve, values, factor):
                    return f"but is {factor:.4g} times {column} of {run}"
    return "but is none of the columns of any case"


def _left_out(curve: Curve, of: tuple[Floats, Floats]) -> Floats:
    """Times of the values that a curve leaves out, up to half of them; none where it has others than these."""
    time, values = (column[of[0] >= 0.0] for column in of)
    x, y = (points[curve.x >= time.min(initial=np.inf) - MARGIN] for points in (curve.x, curve.y))
    if not 0 < len(time) - len(x) <= len(time) // 2:
        return np.zeros(0)
    at = np.abs(time[:, None] - x).argmin(axis=0)
    same = (np.abs(time[at] - x) <= MARGIN).all() and (
        np.abs(values[at] - y) <= MARGIN * max(1.0, np.abs(values).max())
    ).all()
    return np.delete(time, at) if same else np.zeros(0)


def _coarse(runs: Runs, run: str, curve: Curve) -> Iterator[str]:
    """Check the line at the share that cannot pass."""
    share = (runs.summary(run) or {COARSE: np.nan})[COARSE]
    if not np.allclose(curve.y, share, atol=MARGIN, rtol=0.0):
        yield f"the line at the share that cannot pass is at {curve.y[0]:.4g}; expected {share:.4g}"


def _colours(runs: Runs, figure: str, panel: Panel, seen: dict[tuple[str, str], str]) -> Iterator[str]:
    """Check that a colour means one liquid amount per material, or one reservoir, in all panels, and that colours differ."""
    here, kind = {}, {"classes": "moisture"}.get(figure, figure.partition(".")[0])
    for curve in panel.curves if figure != "dry" else ():
        run, _, column = curve.claim.partition(":")
        meaning, number = runs.meaning(figure, run, column), runs.number(run)
        if column == COARSE or meaning is None or number is None:
            continue
        what = meaning.split()[0]
        here[what] = curve.colour
        # amounts differ between materials: each has one colour for the lower and one for the higher
        moist = kind == "moisture" and what != "0"
        for scope, means in ((f"{kind} {runs.rows[number]['material']}", what), (kind, "moist" if moist else what)):
            other = seen.setdefault((scope, curve.colour), means)
            if other != means:
                yield f"{curve.colour} means {means!r}, elsewhere {other!r}"
                break
    for (a, one), (b, two) in combinations(here.items(), 2):
        if np.linalg.norm(np.subtract(_rgb(one), _rgb(two))) < APART:
            yield f"the colours of {a!r} and {b!r} can hardly be distinguished"


def _rgb(colour: str) -> tuple[int, ...]:
    return tuple(int(colour[k : k + 2], 16) for k in (1, 3, 5))


def _missing(runs: Runs, figure: str, panels: list[Panel]) -> Iterator[str]:
    """Yield cases with results that a figure of all cases omits, and curves next to a figure that it does not show."""
    shown = {c.claim.split(":")[0] for panel in panels for c in panel.curves if not c.claim.endswith(COARSE)}
    for number in filter(runs.results_are_last, runs.with_results()):
        if name_of(number) not in shown and (figure == "moisture" or (figure == "dry" and not runs.liquid(number))):
            yield f"case {number} is not shown"
    for folder in set(runs.of_presets.get(figure.removeprefix("presets."), {}).values()) - shown:
        yield f"{folder} is not shown"
    for k, panel in enumerate(panels):
        claims = [c.claim for c in panel.curves]
        for data in panel.alongside:
            if f"{data['case']}:{data['column']}" not in claims:
                yield f"panel {k + 1}: {data['column']} of {data['case']} is next to it but not shown"


def _figures_missing(runs: Runs, there: set[str]) -> Iterator[str]:
    """Yield required figures that the report lacks."""
    done = [n for n in runs.with_results() if runs.results_are_last(n)]
    wanted = ["moisture"] * bool(done) + ["dry"] * any(not runs.liquid(n) for n in done)
    for figure in [*wanted, *(f"presets.{case}" for case in runs.of_presets)]:
        if figure not in there:
            yield f"figure {figure}: it is not on the page"


def main(arguments: list[str]) -> int:
    """Print deviations of the report from the result files."""
    if len(arguments) != 2:
        raise Refused(f"{len(arguments)} arguments were given; expected REPORT CASES.csv")
    with reading(" and ".join(arguments), "the report of a folder of runs and the table of its cases"):
        read = check(regular(Path(arguments[0])), regular(Path(arguments[1])))
    print(summary(read))
    print("\n".join(read.faults))
    return int(bool(read.faults))


def summary(read: Read) -> str:
    """Summarise in one line what was read, how much of it is wrong, and what was not checked."""
    found = f"{read.curves} curves, {read.numbers} numbers and {read.scenes} numbers of 3-D scenes read; {len(read.faults)} wrong"
    return found + (f"; not checked: {', '.join(read.unknown)}" if read.unknown else "")


if __name__ == "__main__":
    with border(1):
        sys.exit(main(sys.argv[1:]))
