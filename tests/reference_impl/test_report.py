"""The report read as it is shown: injected faults in labels, colours, panels, curves and tables are found and named."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from pywet import config as settings
from pywet import stages
from pywet.planning import audit
from pywet.report import collect, plots, report
from pywet.runs.shapes import FORCES
from pywet.util.files import write_json, write_table
from reference_impl.shown import report as shown
from reference_impl.shown.drawn import panels
from tests.cases.screening import synthetic

ROOT = Path(__file__).parent.parent.parent
CASES = (1, 2, 3, 4, 5, 6)
"""Dry, 5 % and 10 % liquid at two amplitudes: two panels of three curves."""
TWIN = "case02_exact"
"""Case 2 with the other preset of laws."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six cases whose tables differ in every column."""
    root, config, random = tmp_path_factory.mktemp("report"), settings.load(ROOT / "config"), np.random.default_rng(3)
    for number in CASES:
        case = config.case(number)
        run = synthetic.make(root / case.name, moist=case.liquid_percent > 0, name=case.name)
        stages.results(run)
        _tables(run, random)
        _files(run, number, random)
        write_json(run / "config.json", config.resolved(number, "smoke"))
        for stage in stages.NEEDS:
            stages.attempt(run, stage, lambda: None)
    twin = synthetic.make(root / TWIN, name=TWIN)
    stages.results(twin)
    _tables(twin, random)
    _files(twin, 7, random)
    for stage in stages.NEEDS:
        stages.attempt(twin, stage, lambda: None)
    return root


def _tables(run: Path, random: np.random.Generator) -> None:
    """Curves of 31 outputs that fall at random, and liquid that goes from reservoir to reservoir."""
    time = np.linspace(-0.1, 1.4, 31)
    clock = {"step": np.arange(31) * 100, "time_s": time + 0.1, "time_since_opening_s": time}
    for name in ("fraction_retained", "liquid_by_holder"):
        path = run / "results" / f"{name}.parquet"
        columns = [c for c in pd.read_parquet(path) if c not in clock]
        table = pd.DataFrame({**clock, **{c: 1.0 - np.sort(random.uniform(0, 0.6, 31)) * (time > 0) for c in columns}})
        for kind in ("small", "near_mesh", "large") if name == "fraction_retained" else ():
            table[f"fraction_retained_{kind}"] = 1.0 - np.sort(random.uniform(0, 0.6, 31)) * (time > 0)
        if name == "liquid_by_holder":
            shares = np.cumsum(random.uniform(0, 1, (31, len(plots.PLACES))), axis=0)
            shares *= 2e-6 / shares.sum(axis=1)[:, None]
            table = table.assign(initial_m3=2e-6, **dict(zip((f"{p}_m3" for p in plots.PLACES), shares.T, strict=True)))
        write_table(table, path)


def _files(run: Path, number: int, random: np.random.Generator) -> None:
    data = json.loads((run / "summary.json").read_text())
    table = pd.read_parquet(run / "results" / "fraction_retained.parquet")
    data["fraction_retained_end"] = float(table["fraction_retained"].iloc[-1])
    data["coarse_share"], data["wall_s"], data["steps"] = 0.3, float(random.uniform(10, 90)), 48000 + number
    if data["events"]:
        data["events"] = {"formations": 12000 + number, "ruptures": 11000 + number}
        data["ledger_error"] = float(random.uniform(1e-16, 9e-16))
        reservoirs = (
            "coarse_material",
            "fines",
            "wires",
            "side_wall",
            "outlet",
            "collecting_bin",
            "left",
            "standing_bridges",
        )
        data["liquid_end_m3"] = {name: float(random.uniform(1e-8, 1e-6)) for name in reservoirs}
        rows = {}
        for name in ("volume", "force"):
            largest, median = (float(v) for v in random.uniform(2, 9, 2) * [1e-13, 1e-16])
            rows[name] = {"scale": "itself", "count": 3, "largest": largest, "median": median, "tolerance": 1e-9}
        write_json(run / "replay.json", {"quantities": rows})
    write_json(run / "summary.json", data)
    effects = []
    for name, law in (("bridges", None), ("capillary", "rabinovich"), ("gravity", None)):
        number, share = (float(v) for v in random.uniform([0.02, 0.1], [3.0, 0.9]))
        words = {"effect": name, "on": True, "why": "preset", "quantity": "force over weight", "law": law}
        effects.append(
            {**words, "number": number, "threshold": 0.01, "predicted_share": share, "predicted_within": 3.0}
        )
    write_json(run / "plan.json", {"rows": effects, "effects": {}})
    shares = {
        name: {"acting": True, "impulse_share": float(random.uniform(0.1, 0.9)), "energy_share": 0.1} for name in FORCES
    }
    write_json(run / "contributions.json", {"effects": shares})
    audit.write(run)


def written(folder: Path) -> Path:
    out = folder / "report.html"
    template, comparisons = ROOT / "workflow" / "report", {TWIN: (2, "exact")}
    report.write(settings.load(ROOT / "config"), "smoke", CASES, folder, template, None, out, comparisons)
    return out


@pytest.fixture(scope="module")
def right(folder: Path) -> str:
    """The report without a fault."""
    return written(folder).read_text()


def read(path: Path) -> list[str]:
    return shown.check(path, ROOT / "config" / "cases.csv").faults


def test_the_report_as_it_is(folder: Path, right: str) -> None:
    """Two panels of three curves and a line, one of two and a line, one of two classes for three amounts, one stack of ten, and
    one of two classes for two presets and a line."""
    path = folder / "whole.html"
    path.write_text(right)
    found = shown.check(path, ROOT / "config" / "cases.csv")
    assert found.faults == [] and found.curves == 2 * 4 + 3 + 6 + 10 + 5 and found.numbers > 300


def test_a_slide_that_opens_late_is_no_fault(folder: Path, tmp_path: Path) -> None:
    """Curves begin left of the picture, where they are cut: 26 of 31 points lie before the opening."""
    late = tmp_path / "late"
    shutil.copytree(folder, late, ignore=shutil.ignore_patterns("*.html"))
    for path in late.glob("*/results/*.parquet"):
        table = pd.read_parquet(path)
        if "time_since_opening_s" in table:
            write_table(table.assign(time_since_opening_s=table["time_since_opening_s"] - 1.2), path)
    report = written(late)
    drawn = min(len(c.x) for p in panels(report.read_text()) for c in p.curves if c.label != shown.CANNOT)
    assert drawn < 31 and read(report) == []


Curve = Callable[..., None]


def curve(
    change: Callable[[Any, str, dict[str, Any]], tuple[Any, str, dict[str, Any]]],
) -> Callable[[pytest.MonkeyPatch], None]:
    """Every curve drawn with another table, column or look."""
    drawn = plots._curve

    def other(axes: Any, result: collect.CaseResult, column: str, **look: Any) -> None:
        table, column, look = change(result.retained, column, look)
        drawn(axes, _with(result, table), column, **look)

    return lambda patch: patch.setattr(plots, "_curve", other)


def _with(result: collect.CaseResult, table: Any) -> collect.CaseResult:
    from dataclasses import replace

    return replace(result, retained=table)


def swapped(text: str, one: str, two: str) -> str:
    return text.replace(one, "\0").replace(two, one).replace("\0", two)


def places(**labels: tuple[str, str]) -> Callable[[pytest.MonkeyPatch], None]:
    return lambda patch: [patch.setitem(plots.PLACES, name, look) for name, look in labels.items()] and None


def titles_swapped(patch: pytest.MonkeyPatch) -> None:
    made = plots._panels

    def other(*given: Any) -> list[plots.Panel]:
        panels = made(*given)
        names = [name for name, _ in panels]
        return [(name, group) for name, (_, group) in zip(names[::-1], panels, strict=True)]

    patch.setattr(plots, "_panels", other)


def colours_of_one_panel(patch: pytest.MonkeyPatch) -> None:
    made, calls = plots._moisture_colours, iter(range(100))
    patch.setattr(plots, "_moisture_colours", lambda group: made(group)[:: -1 if next(calls) == 1 else 1])


def in_fractions(patch: pytest.MonkeyPatch) -> None:
    made = plots._draw_liquid

    def other(axes: Any, group: Any) -> None:
        made(axes, [replace(group[0], liquid=group[0].liquid.assign(initial_m3=2e-4))])

    patch.setattr(plots, "_draw_liquid", other)


DASHES = {"-": (0, (4, 2)), (0, (4, 2)): "-"}
DRAWN: dict[str, tuple[Callable[[pytest.MonkeyPatch], None], str]] = {
    "labels swapped": (
        lambda p: p.setattr(
            plots, "_moisture", lambda r: {0: "M = 5 %", 5: "dry"}.get(r.case.liquid_percent, "M = 10 %")
        ),
        "labelled 'dry' should be fraction_retained of case 1, but is fraction_retained of case 2",
    ),
    "classes swapped": (
        curve(lambda t, c, k: (t, c.replace("small", "x").replace("near_mesh", "small").replace("x", "near_mesh"), k)),
        "labelled 'dry, small' should be fraction_retained_small of case 1, but is fraction_retained_near_mesh of case 1",
    ),
    "spheres without liquid": (
        curve(lambda t, c, k: (t, "fraction_retained_spheres" if c == "fraction_retained" else c, k)),
        "but is",
    ),
    "one minus": (
        curve(lambda t, c, k: (t.assign(**{c: 1 - t[c]}), c, k)),
        "but is 1 minus fraction_retained of case 1",
    ),
    "late": (
        curve(lambda t, c, k: (t.assign(time_since_opening_s=t["time_since_opening_s"] + 0.05), c, k)),
        "moved by 0.05 s",
    ),
    "a hundredth off": (
        curve(lambda t, c, k: (t.assign(**{c: 0.99 * t[c]}), c, k)),
        "but is 0.99 times fraction_retained of case 1",
    ),
    "dashes swapped": (
        curve(lambda t, c, k: (t, c, {**k, "linestyle": DASHES.get(k.get("linestyle", ""), "-")})),
        "expected small solid, near mesh dashed",
    ),
    "colours of one panel swapped": (colours_of_one_panel, "stands for 'M = 10 %', elsewhere for 'dry'"),
    "panels swapped": (titles_swapped, "should be fraction_retained of case 4, but is fraction_retained of case 1"),
    "another amplitude in the title": (
        lambda p: p.setattr(plots, "title", lambda r: "POM 5/7/10 mm, a = 8 mm, A = 2 mm"),
        "there is no case for the label 'dry' in this panel",
    ),
    "a case left out": (
        lambda p: p.setattr(plots, "_draw_moisture", lambda axes, g, d=plots._draw_moisture: d(axes, g[1:])),
        "figure moisture: case 1 is not shown",
    ),
    "holders swapped": (
        places(wires=("outlet", "#d98032"), outlet=("wires", "#e07a9c")),
        "should be outlet_m3 of case 2, but is wires_m3",
    ),
    "two colours alike": (
        places(outlet=("outlet", "#d98436")),
        "the colours of 'wires' and 'outlet' can hardly be told apart",
    ),
    "liquid in fractions": (in_fractions, "but is 0.01 times"),
    "presets swapped in the legend": (
        lambda p: p.setattr(
            plots, "preset_curves", lambda usual, twin, _, drawn=plots.preset_curves: drawn(twin, usual, "exact")
        ),
        "labelled 'paper, all' should be fraction_retained of case case02, but is fraction_retained of case case02_exact",
    ),
    "both presets the same run": (
        lambda p: p.setattr(
            plots, "preset_curves", lambda usual, _, name, drawn=plots.preset_curves: drawn(usual, usual, name)
        ),
        "labelled 'exact, all' should be fraction_retained of case case02_exact, but is fraction_retained of case 2",
    ),
    "no figure of the presets": (
        lambda p: p.setattr(plots, "preset_curves", lambda *_: []),
        "figure presets: case02_exact is not shown",
    ),
    "share of another": (
        lambda p: p.setattr(
            plots, "_end", lambda axes, g: axes.axhline(0.35, color="#aab3bb", linestyle=":", label=shown.CANNOT)
        ),
        "the line at the share that cannot pass is at 0.35; expected 0.3",
    ),
    "axes swapped": (
        lambda p: p.setattr(
            plots, "_label_liquid", lambda a: (a.set_xlabel("liquid in % of what was put in"), a.set_ylabel(shown.TIME))
        ),
        "the axes are called 'liquid in % of what was put in'",
    ),
}
"""Faults of the code that draws."""


@pytest.mark.parametrize("name", DRAWN)
def test_faults_of_what_draws_are_found_and_named(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plant, said = DRAWN[name]
    plant(monkeypatch)
    faults = read(written(folder))
    assert any(said in fault for fault in faults), faults


@pytest.fixture(scope="module")
def seeded(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same cases, case 2 with two more seeds, one of them with other outputs, and its preset with one."""
    root, random = tmp_path_factory.mktemp("seeds") / "runs", np.random.default_rng(5)
    shutil.copytree(folder, root, ignore=shutil.ignore_patterns("*.html"))
    for name, rows in (("case02-8", 31), ("case02-9", 16), (f"{TWIN}-8", 31)):
        table = pd.read_parquet(root / "case02" / "results" / "fraction_retained.parquet").iloc[:: 30 // (rows - 1)]
        for column in [c for c in table if str(c).startswith("fraction_retained")]:
            table[column] = 1.0 - np.sort(random.uniform(0, 0.6, rows)) * (table["time_since_opening_s"] > 0)
        write_table(table, root / name / "results" / "fraction_retained.parquet")
    return root


def banded(change: Callable[[Any, tuple[Any, ...]], collect.CaseResult]) -> Callable[[pytest.MonkeyPatch], None]:
    """Every curve drawn with other seeds: what they were -> what they are."""
    drawn = plots._curve

    def other(axes: Any, result: collect.CaseResult, column: str, **look: Any) -> None:
        drawn(axes, replace(result, seeds=change(result, result.seeds)), column, **look)

    return lambda patch: patch.setattr(plots, "_curve", other)


BANDS: dict[str, tuple[Callable[[pytest.MonkeyPatch], None], str]] = {
    "a seed left out": (banded(lambda r, s: s[1:]), "is not from the least to the most of its 3 seeds"),
    "no band": (banded(lambda r, s: ()), "should be the band of its 3 seeds, in its colour"),
    "a band of what has one seed": (
        banded(lambda r, s: s or (r.retained.assign(fraction_retained=0.5),)),
        "is a band, but there are no other seeds of case 1",
    ),
    "seeds too low": (
        banded(lambda r, s: tuple(t.assign(fraction_retained=0.9 * t["fraction_retained"]) for t in s)),
        "labelled 'M = 5 %' is not from the least to the most",
    ),
}


def test_bands_go_from_the_least_to_the_most_of_all_seeds(seeded: Path) -> None:
    """Of case 2 in the moist panel, of its classes, and of both presets, all and near mesh: 1 + 2 + 4."""
    found = shown.check(written(seeded), ROOT / "config" / "cases.csv")
    assert found.faults == [] and found.curves == 2 * 4 + 3 + 6 + 10 + 5 + 7


@pytest.mark.parametrize("name", BANDS)
def test_faults_of_bands_are_found_and_named(name: str, seeded: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plant, said = BANDS[name]
    plant(monkeypatch)
    faults = read(written(seeded))
    assert any(said in fault for fault in faults), faults


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            lambda t: re.sub(r"<td>(0\.\d+) ± [\d.]+</td>", r"<td>\1</td>", t),
            "table of cases, case 2, Y at end, interval",
        ),
        (lambda t: re.sub(r"(<b>\S+) ± [\d.]+ \(3", r"\1 ± 0.99 (3", t), "first table, .*, retained, interval"),
        (lambda t: re.sub(r"± [\d.]+ % passed", "± 99 % passed", t), "first table, .*, passed, interval"),
    ],
)
def test_faults_of_intervals_are_found_and_named(change: Callable[[str], str], said: str, seeded: Path) -> None:
    """A number of one seed where there are three, and intervals that are not Student's."""
    page = written(seeded)
    text = page.read_text()
    assert change(text) != text
    page.write_text(change(text))
    faults = read(page)
    assert any(re.search(said, fault) for fault in faults), faults


def cell(section: str, row: str, column: int, change: Callable[[str], str]) -> Callable[[str], str]:
    """One cell of a table changed: section, words of the first cell of its row, number of the column."""

    def changed(text: str) -> str:
        start = text.index(f'<section id="{section}">')
        rows = [
            m
            for m in re.finditer(r"<tr.*?</tr>", text[start:], re.DOTALL)
            if re.match(rf"<tr[^>]*>\s*<td>{row}</td>", m[0])
        ]
        cells = list(re.finditer(r"<td.*?>(.*?)</td>", rows[0][0], re.DOTALL))
        at = start + rows[0].start() + cells[column].start(1)
        was = cells[column][1]
        return text[:at] + change(was) + text[at + len(was) :]

    return changed


def digit(was: str) -> str:
    """The last digit one more."""
    at = max(m.start() for m in re.finditer(r"\d", was.split("e")[0]))
    return was[:at] + str((int(was[at]) + 1) % 10) + was[at + 1 :]


def in_section(name: str, change: Callable[[str], str]) -> Callable[[str], str]:
    def changed(text: str) -> str:
        start = text.index(f'<section id="{name}">')
        end = text.index("</section>", start)
        return text[:start] + change(text[start:end]) + text[end:]

    return changed


SHOWN: dict[str, tuple[Callable[[str], str], str]] = {
    "texts of the legend swapped": (
        in_section("moisture", lambda s: swapped(s, ">M = 5 %<", ">dry<")),
        "labelled 'dry' should be",
    ),
    "colours of the legend swapped": (
        in_section(
            "liquid",
            lambda s: re.sub(r"(legend_1.*)", lambda m: swapped(m[1], "#d98032", "#e07a9c"), s, flags=re.DOTALL),
        ),
        "labelled 'outlet' should be outlet_m3 of case 2, but is wires_m3",
    ),
    "a colour not in the legend": (
        in_section("classes", lambda s: s.replace("stroke: #4a9bd4", "stroke: #4a9bd5", 1)),
        "is not in the legend",
    ),
    "names of curves": (
        in_section("moisture", lambda s: s.replace("case01:fraction_retained", "case02:fraction_retained", 1)),
        "is named case02:fraction_retained in the file",
    ),
    "data beside": (
        in_section("moisture", lambda s: re.sub(r'("y": \[.*?), [\d.]+\]', r"\1, 0.5]", s, count=1)),
        "the data beside the curve labelled",
    ),
    "labels beside": (
        in_section("moisture", lambda s: s.replace('"label": "dry"', '"label": "wet"')),
        "label or colour beside the curve labelled 'dry'",
    ),
    "numbers of an axis": (
        in_section("curves", lambda s: s.replace(">0.6<", ">0.7<").replace(">0.8<", ">0.9<")),
        "should be fraction_retained of case",
    ),
    "end misprinted": (cell("cases", "3", 10, digit), "table of cases, case 3, Y at end"),
    "a sphere more": (cell("cases", "1", 6, digit), "table of cases, case 1, spheres"),
    "events swapped": (
        lambda t: cell("cases", "2", 13, lambda _: "12002")(cell("cases", "2", 12, lambda _: "11002")(t)),
        "case 2, formations: '11002' is shown; expected 12002",
    ),
    "ledger misprinted": (cell("ledger", "5", 3, digit), "liquid ledger, case 5, fines"),
    "columns of the ledger swapped": (
        in_section("ledger", lambda s: swapped(s, "<th>fines</th>", "<th>wires</th>")),
        "liquid ledger, case 2, fines",
    ),
    "ledger's error": (cell("ledger", "6", 12, digit), "liquid ledger, case 6, largest error"),
    "largest and median swapped": (
        cell("agreement", "force", 3, lambda was: "<br>".join(was.split("<br>")[::-1])),
        "cross-check, force, case 2, largest",
    ),
    "number of an effect": (cell("effects", "capillary", 4, digit), "effects, capillary, case 3"),
    "contribution misprinted": (
        cell("contributed", "capillary", 3, lambda was: "77 %" + was[4:]),
        "contributions, capillary, case 2",
    ),
    "prediction misprinted": (
        cell("contributed", "capillary", 3, lambda was: re.sub(r"predicted \S+", "predicted 99", was)),
        "case 2, predicted",
    ),
    "amounts in the first table swapped": (
        in_section("answer", lambda s: swapped(s, "5 % liquid", "10 % liquid")),
        "first table",
    ),
    "passed misprinted": (
        in_section("answer", lambda s: re.sub(r"(\d+) % passed", "3 % passed", s, count=1)),
        "dry, passed",
    ),
    "card misprinted": (
        lambda t: re.sub(r"<b>(\d\.\d)(e−16)", r"<b>9.9\2", t, count=1),
        "card, largest error of the liquid ledger",
    ),
    "columns of the presets swapped": (
        in_section("presets", lambda s: swapped(s, "<th>paper</th>", "<th>exact</th>")),
        "presets, case 2, columns",
    ),
    "presets swapped, heads and words alike": (
        in_section(
            "presets", lambda s: swapped(swapped(s, "<th>paper</th>", "<th>exact</th>"), "<code>paper<", "<code>exact<")
        ),
        "presets, fraction retained, exact",
    ),
    "rows of the presets swapped": (
        in_section("presets", lambda s: swapped(s, ">bridges formed<", ">bridges ruptured<")),
        "presets, bridges formed, paper: '11002' is shown; expected 12002",
    ),
    "holders of the presets swapped": (
        in_section("presets", lambda s: swapped(s, ">liquid wires<", ">liquid outlet<")),
        "presets, liquid wires, paper",
    ),
    "presets of another case": (
        in_section("presets", lambda s: s.replace("<p>Case 2 ", "<p>Case 3 ")),
        "presets, fraction retained, paper",
    ),
    "dry and moist swapped in the answer": (
        lambda t: re.sub(r"(\d+ to \d+ %) dry, (\d+ to \d+ %) moist", r"\2 dry, \1 moist", t),
        "head, least passed dry",
    ),
    "time of the answer": (
        lambda t: t.replace("passed 1.4 s after", "passed 1.5 s after"),
        "head, time: '1.5' is shown; expected 1.4",
    ),
    "a case more": (
        lambda t: t.replace("6 cases of batch", "7 cases of batch"),
        "head, cases: '7' is shown; expected 6",
    ),
    "not proven": (
        lambda t: re.sub(r"Bookkeeping and forces recomputed: [^<]*", "Not cross-checked: case 2.", t),
        "the proof is said to be 'Not cross-checked: case 2.'",
    ),
    "quantities of the proof": (
        lambda t: t.replace("agrees on all 2 quantities", "agrees on all 3 quantities"),
        "the proof is said",
    ),
    "done and all": (
        lambda t: t.replace("6 of 6</b><span>cases done", "5 of 6</b><span>cases done"),
        "card, cases done, done",
    ),
    "done but listed": (
        lambda t: t.replace(
            '<section id="answer">', '<section><ul><li><b>case03</b>: failed</li></ul></section><section id="answer">'
        ),
        "case 3 is listed as not done",
    ),
    "laws of other cases": (
        in_section("cases", lambda s: s.replace("capillary: rabinovich", "capillary: willett")),
        "laws of case 1 are said to be 'capillary: willett'",
    ),
    "hours for minutes": (
        lambda t: re.sub(r"<p>(\S+) min of", lambda m: f"<p>{float(m[1]) / 60:.2g} min of", t),
        "engine time",
    ),
    "sphere-steps": (lambda t: re.sub(r"for (\S+) million", r"for 7\1 million", t), "sphere-steps"),
    "softening": (lambda t: t.replace("softened to 0.01 of", "softened to 0.1 of"), "simulated, softening"),
    "duration and opening swapped": (
        lambda t: t.replace("lasts 1.6 s, of which 0.2 s", "lasts 0.2 s, of which 1.6 s"),
        "simulated, duration: '0.2' is shown; expected 1.6",
    ),
    "a 3-D scene missing": (
        lambda t: re.sub(
            r'<script type="application/json" class="run" data-name="case02">.*?</script>', "", t, flags=re.DOTALL
        ),
        "scene of case02: there is none",
    ),
    "shape of the sieve": (lambda t: t.replace("mm square sieve", "mm round sieve"), "simulated, shape"),
    "an assumption misprinted": (
        cell("assumptions", "apparatus · outlet height mm", 1, digit),
        "assumption apparatus · outlet height mm: '101' is shown; expected 100",
    ),
    "reasons of assumptions swapped": (
        lambda t: swapped(t, "holds the loose fill at full depth", "just above the side wall"),
        "assumption apparatus · slide height mm, reason",
    ),
}
"""Faults of what is shown, injected in the page."""


@pytest.mark.parametrize("name", SHOWN)
def test_faults_of_what_is_shown_are_found_and_named(name: str, folder: Path, right: str) -> None:
    plant, said = SHOWN[name]
    wrong = plant(right)
    assert wrong != right
    path = folder / "wrong.html"
    path.write_text(wrong)
    faults = read(path)
    assert any(said in fault for fault in faults), faults


@pytest.mark.skipif(shutil.which("chromium") is None, reason="no browser on this machine")
def test_a_browser_shows_what_was_read(folder: Path, right: str, tmp_path: Path) -> None:
    """The page as chromium has it in memory, after its scripts and its mending of markup, reads the same."""
    (folder / "page.html").write_text(right)
    command = [
        "chromium",
        "--headless=new",
        "--no-sandbox",
        "--disable-gpu",
        f"--user-data-dir={tmp_path}",
        "--dump-dom",
    ]
    dom = subprocess.run(
        [*command, str(folder / "page.html")], capture_output=True, text=True, timeout=120, check=True
    ).stdout
    (folder / "dom.html").write_text(dom)
    path, cases = folder / "page.html", ROOT / "config" / "cases.csv"
    mine, theirs = shown.check(path, cases), shown.check(folder / "dom.html", cases)
    assert (theirs.faults, theirs.curves, theirs.numbers) == ([], mine.curves, mine.numbers)
