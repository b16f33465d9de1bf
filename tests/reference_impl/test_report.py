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
from pywet.products import screening_report
from pywet.report import collect, plots, report, report_numbers
from pywet.runs.shapes import FORCES
from pywet.util.files import write_json, write_table
from reference_impl.faults import Refused
from reference_impl.shown import report as shown
from reference_impl.shown import report_values
from reference_impl.shown.drawn import figures
from tests.cases.screening import synthetic

ROOT = Path(__file__).parent.parent.parent
CASES = (1, 2, 3, 4, 5, 6)
"""Dry, 5 % and 10 % liquid at two amplitudes: two panels of three curves."""
COMPARISON = "case02_exact"
"""Case 2 with the other preset of laws."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six cases whose tables differ in every column."""
    return made(tmp_path_factory.mktemp("report"), CASES)


def made(root: Path, cases: tuple[int, ...]) -> Path:
    """Folders of cases, and of case 2 with the other preset, whose tables differ in every column."""
    config, random = settings.load(ROOT / "config"), np.random.default_rng(3)
    for number in cases:
        case = config.case(number)
        run = synthetic.make(root / case.name, moist=case.liquid_percent > 0, name=case.name)
        stages.results(run)
        _tables(run, random)
        _files(run, number, random)
        write_json(run / "config.json", config.resolved(number, "smoke"))
        for stage in stages.NEEDS:
            stages.attempt(run, stage, lambda: None)
    comparison = synthetic.make(root / COMPARISON, name=COMPARISON)
    stages.results(comparison)
    _tables(comparison, random)
    _files(comparison, 7, random)
    for stage in stages.NEEDS:
        stages.attempt(comparison, stage, lambda: None)
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
    data["resumed_at_step"] = 24000 if number == 4 else None
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


def written(
    folder: Path, template: Path = ROOT / "workflow" / "report", cases: tuple[int, ...] = CASES, scale: str = "smoke"
) -> Path:
    """Write the report on cases, with case 2 by both presets."""
    out, comparisons = folder / "report.html", {COMPARISON: (2, "exact")} if 2 in cases else {}
    report.write(settings.load(ROOT / "config"), scale, cases, folder, template, None, out, comparisons)
    return out


Numbers = dict[str, dict[str, Any]]


@pytest.fixture(scope="module")
def right(folder: Path) -> tuple[str, Numbers]:
    """The report without a fault: its page and its numbers."""
    page = written(folder)
    return page.read_text(), json.loads(page.with_suffix(".json").read_text())


def stored(path: Path, text: str, numbers: Numbers) -> Path:
    """Write a page and its numbers."""
    path.write_text(text)
    write_json(path.with_suffix(".json"), numbers)
    return path


def read(path: Path) -> list[str]:
    return shown.check(path, ROOT / "config" / "cases.csv").faults


def test_the_report_as_it_is(folder: Path, right: tuple[str, Numbers]) -> None:
    """Two panels of three curves and a line, one of two and a line, one of two classes for three amounts, one stack of ten, and
    one of two classes for two presets and a line."""
    found = shown.check(stored(folder / "whole.html", *right), ROOT / "config" / "cases.csv")
    assert (found.faults, found.unknown) == ([], []) and found.curves == 2 * 4 + 3 + 6 + 10 + 5 and found.numbers > 300


def test_options_of_an_evaluation_change_no_number(
    folder: Path, right: tuple[str, Numbers], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """A case whose screen was last evaluated with another aperture is shown, and read back, at that of the case."""
    runs = Path(shutil.copytree(folder, tmp_path / "runs"))
    usual = screening_report.write(runs / "case02")
    wrong = screening_report.write(runs / "case02", aperture_mm=1.0)
    page = written(runs)
    numbers = json.loads(page.with_suffix(".json").read_text())
    shown_at = numbers["case02.screen.efficiency_percent"]["value"]
    assert shown_at == pytest.approx(100.0 * usual["efficiency"]) and wrong["efficiency"] != usual["efficiency"]
    assert "case02 was last evaluated with --aperture 1: evaluated here without" in caplog.text
    assert read(page) == []
    numbers["case02.screen.efficiency_percent"]["value"] = 100.0 * wrong["efficiency"]
    assert any("case02.screen.efficiency_percent" in fault for fault in read(stored(page, page.read_text(), numbers)))


def test_other_words_of_the_template_are_no_fault(folder: Path, tmp_path: Path) -> None:
    """Every word of the template that is not markup is another: the check reads keys, not words."""
    templates = tmp_path / "templates"
    templates.mkdir()
    text = (ROOT / "workflow" / "report" / report.TEMPLATE).read_text()
    head, body = text.split("{% block lead %}")
    parts = re.split(r"(\{%.*?%\}|\{\{.*?\}\}|&\w+;|<(?:\{%.*?%\}|\{\{.*?\}\}|[^>{])*>)", body)
    changed = [part if k % 2 else re.sub(r"[A-Za-z]{3,}", "word", part) for k, part in enumerate(parts)]
    for old, new in (("against", "over"), ("recomputed every", "sieved every"), ("agrees on", "is the same on")):
        assert old in head
        head = head.replace(old, new)
    (templates / report.TEMPLATE).write_text(head + "{% block lead %}" + "".join(changed))
    page = written(folder, templates)
    assert "Cross-check" not in page.read_text() and read(page) == []


def test_other_words_of_labels_are_no_fault(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Columns, rows, axes, legends and headings are called otherwise."""
    for words in (report_numbers.LEDGER, report_numbers.CASES, report_numbers.PRESETS, report_numbers.OUTCOMES):
        for name, of in words.items():
            monkeypatch.setitem(words, name, f"other {of}")
    for name, of in plots.QUANTITIES.items():
        monkeypatch.setitem(plots.QUANTITIES, name, f"{of}, otherwise")
    for name, size in (("small", "fine"), ("near_mesh", "about the mesh")):
        monkeypatch.setitem(plots.SIZES, name, size)
        monkeypatch.setitem(plots.WORDS, name, size)
    monkeypatch.setattr(plots, "TIME", plots.QUANTITIES["time_since_opening_s"])
    monkeypatch.setattr(plots, "title", lambda r, made=plots.title: f"sieving {made(r)}")
    page = written(folder)
    assert read(page) == []


def test_a_key_that_is_not_known_is_listed(folder: Path, right: tuple[str, Numbers]) -> None:
    text, numbers = right
    page = text.replace("</main>", '<data value="3" data-key="new.number">3</data></main>')
    path = stored(folder / "more.html", page, {**numbers, "new.number": {"value": 3, "shown": "3"}})
    found = shown.check(path, ROOT / "config" / "cases.csv")
    assert found.faults == [] and shown.summary(found).endswith("; not checked: new.number")


def test_a_report_without_its_numbers_is_refused(folder: Path, right: tuple[str, Numbers]) -> None:
    (folder / "alone.html").write_text(right[0])
    with pytest.raises(Refused, match=r"has no alone\.json next to it"):
        read(folder / "alone.html")


def opened(folder: Path, root: Path, by_s: float) -> Path:
    """The same cases whose slide opens later."""
    shutil.copytree(folder, root, ignore=shutil.ignore_patterns("*.html"))
    for path in root.glob("*/results/*.parquet"):
        table = pd.read_parquet(path)
        if "time_since_opening_s" in table:
            write_table(table.assign(time_since_opening_s=table["time_since_opening_s"] - by_s), path)
    return root


@pytest.fixture(scope="module")
def late(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The slide opens 1.2 s later: 26 of 31 points lie before the opening."""
    return opened(folder, tmp_path_factory.mktemp("late") / "runs", 1.2)


@pytest.mark.parametrize("by_s", [0.3, 0.625, 1.2, 1.35, 1.375])
def test_a_slide_that_opens_late_is_no_fault(folder: Path, tmp_path: Path, by_s: float) -> None:
    """Curves begin left of the picture, where they are cut: at an output or between two, down to the last two or one."""
    report = written(opened(folder, tmp_path / "runs", by_s))
    every = (c for _, panels in figures(report.read_text()) for p in panels for c in p.curves)
    drawn = min(len(c.x) for c in every if not c.claim.endswith("coarse_share"))
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


def without(nth: int) -> Callable[[pytest.MonkeyPatch], None]:
    """Every curve without one of its points after the opening."""
    return curve(lambda t, c, k: (t.drop(index=t.index[t["time_since_opening_s"] >= 0.0][nth]), c, k))


def moved(by_s: float) -> Callable[[pytest.MonkeyPatch], None]:
    return curve(lambda t, c, k: (t.assign(time_since_opening_s=t["time_since_opening_s"] + by_s), c, k))


def axis_to(end_s: float) -> Callable[[pytest.MonkeyPatch], None]:
    """Panels whose axis of time ends before the curves do."""
    made = plots._end

    def other(axes: Any, group: Any) -> None:
        made(axes, group)
        axes.set_xlim(0.0, end_s)

    return lambda patch: patch.setattr(plots, "_end", other)


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
        "the curve of case01:fraction_retained is called 'M = 5 %'; expected words that state '0'",
    ),
    "classes swapped": (
        curve(lambda t, c, k: (t, c.replace("small", "x").replace("near_mesh", "small").replace("x", "near_mesh"), k)),
        "the curve of case01:fraction_retained_near_mesh is called 'dry, small'; expected words that state '0 near_mesh'",
    ),
    "spheres without liquid": (
        curve(lambda t, c, k: (t, "fraction_retained_spheres" if c == "fraction_retained" else c, k)),
        "is called 'dry'; expected words that state '0 spheres'",
    ),
    "one minus": (
        curve(lambda t, c, k: (t.assign(**{c: 1 - t[c]}), c, k)),
        "but is 1 minus fraction_retained of case01",
    ),
    "late": (moved(0.05), "moved by 0.05 s"),
    "first point left out": (without(0), "is fraction_retained of case01 without its points at 0 s"),
    "last point left out": (without(-1), "is fraction_retained of case01 without its points at 1.4 s"),
    "a point in between left out": (without(7), "is fraction_retained of case01 without its points at 0."),
    "cut before the end": (axis_to(0.5), "should be fraction_retained of case01"),
    "a hundredth off": (
        curve(lambda t, c, k: (t.assign(**{c: 0.99 * t[c]}), c, k)),
        "but is 0.99 times fraction_retained of case01",
    ),
    "dashes swapped": (
        curve(lambda t, c, k: (t, c, {**k, "linestyle": DASHES.get(k.get("linestyle", ""), "-")})),
        "expected near mesh dashed, all others solid",
    ),
    "colours of one panel swapped": (colours_of_one_panel, "means '10', elsewhere '0'"),
    "panels swapped": (titles_swapped, "A = 0.8 mm'; expected words that state 'POM 5/7/10 8 1'"),
    "another amplitude in the title": (
        lambda p: p.setattr(plots, "title", lambda r: "POM 5/7/10 mm, a = 8 mm, A = 2 mm"),
        "A = 2 mm'; expected words that state 'POM 5/7/10 8 1'",
    ),
    "a case left out": (
        lambda p: p.setattr(plots, "_draw_moisture", lambda axes, g, d=plots._draw_moisture: d(axes, g[1:])),
        "figure moisture: case 1 is not shown",
    ),
    "labels of reservoirs swapped": (
        places(wires=("outlet", "#d98032"), outlet=("wires", "#e07a9c")),
        "the curve of case02:outlet_m3 is called 'wires'; expected words that state 'outlet'",
    ),
    "two colours alike": (
        places(outlet=("outlet", "#d98436")),
        "the colours of 'wires' and 'outlet' can hardly be distinguished",
    ),
    "liquid in fractions": (in_fractions, "but is 0.01 times"),
    "presets swapped in the legend": (
        lambda p: p.setattr(
            plots,
            "preset_curves",
            lambda usual, comparison, _, drawn=plots.preset_curves: drawn(comparison, usual, "exact"),
        ),
        "the curve of case02_exact:fraction_retained is called 'paper, all' for 'paper'; expected 'exact'",
    ),
    "both presets the same run": (
        lambda p: p.setattr(
            plots, "preset_curves", lambda usual, _, name, drawn=plots.preset_curves: drawn(usual, usual, name)
        ),
        "the curve of case02:fraction_retained is called 'exact, all' for 'exact'; expected 'paper'",
    ),
    "no figure of the presets": (
        lambda p: p.setattr(plots, "preset_curves", lambda *_: []),
        "figure presets.case02: it is not on the page",
    ),
    "share of another": (
        lambda p: p.setattr(
            plots,
            "_end",
            lambda axes, g: axes.axhline(
                0.35,
                color="#aab3bb",
                linestyle=":",
                label="share that cannot pass",
                gid=f"{g[0].case.name}:coarse_share",
            ),
        ),
        "the line at the share that cannot pass is at 0.35; expected 0.3",
    ),
    "axes swapped": (
        lambda p: p.setattr(
            plots, "_label_liquid", lambda a: (a.set_xlabel("liquid in % of what was put in"), a.set_ylabel(plots.TIME))
        ),
        "the axis x is called 'liquid in % of what was put in'; report.json has 'time since the slide opened in s'",
    ),
}
"""Faults of the code that draws."""


@pytest.mark.parametrize("name", DRAWN)
def test_faults_of_what_draws_are_found_and_named(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plant, named = DRAWN[name]
    plant(monkeypatch)
    faults = read(written(folder))
    assert any(named in fault for fault in faults), faults


@pytest.fixture(scope="module")
def seeded(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same cases with more seeds."""
    return with_seeds(folder, tmp_path_factory.mktemp("seeds") / "runs")


def with_seeds(folder: Path, root: Path) -> Path:
    """Copy cases; case 2 has two more seeds, one of them with other outputs, and its preset one."""
    random = np.random.default_rng(5)
    shutil.copytree(folder, root, ignore=shutil.ignore_patterns("report.*", "*.html"))
    for name, rows in (("case02-8", 31), ("case02-9", 16), (f"{COMPARISON}-8", 31)):
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
        "is a band, but there are no other seeds of case01",
    ),
    "seeds too low": (
        banded(lambda r, s: tuple(t.assign(fraction_retained=0.9 * t["fraction_retained"]) for t in s)),
        "labelled 'M = 5 %' is not from the least to the most",
    ),
    "seeds one output late": (
        banded(lambda r, s: tuple(t.assign(fraction_retained=t["fraction_retained"].shift(1).fillna(1.0)) for t in s)),
        "labelled 'M = 5 %' is not from the least to the most",
    ),
    "seeds of the classes for those of all": (
        banded(lambda r, s: tuple(t.assign(fraction_retained=t["fraction_retained_small"]) for t in s)),
        "labelled 'M = 5 %' is not from the least to the most",
    ),
}


def test_bands_go_from_the_least_to_the_most_of_all_seeds(seeded: Path) -> None:
    """Of case 2 in the moist panel, of its classes, and of both presets, all and near mesh: 1 + 2 + 4."""
    found = shown.check(written(seeded), ROOT / "config" / "cases.csv")
    assert found.faults == [] and found.curves == 2 * 4 + 3 + 6 + 10 + 5 + 7


@pytest.mark.parametrize("name", BANDS)
def test_faults_of_bands_are_found_and_named(name: str, seeded: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plant, named = BANDS[name]
    plant(monkeypatch)
    faults = read(written(seeded))
    assert any(named in fault for fault in faults), faults


LATE: dict[str, tuple[Callable[[pytest.MonkeyPatch], None], str]] = {
    "opens late: first point left out": (without(0), "is fraction_retained of case01 without its points at 0 s"),
    "opens late: last point left out": (without(-1), "is fraction_retained of case01 without its points at 0.2 s"),
    "opens late: drawn as if it had not": (moved(1.2), "should be fraction_retained of case01"),
    "opens late: an output early": (moved(-0.05), "moved by -0.05 s"),
    "opens late: cut before the end": (axis_to(0.1), "should be fraction_retained of case01"),
}


@pytest.mark.parametrize("name", LATE)
def test_faults_of_curves_that_begin_left_of_the_picture_are_found(
    name: str, late: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plant, named = LATE[name]
    plant(monkeypatch)
    faults = read(written(late))
    assert any(named in fault for fault in faults), faults


Fault = Callable[[str, Numbers], str]


def page(change: Callable[[str], str]) -> Fault:
    """A fault of the page alone."""
    return lambda text, numbers: change(text)


def on_page(key: str, change: Callable[[str], str]) -> Fault:
    """The text of a number changed on the page alone."""
    return lambda text, numbers: _with_text(text, key, lambda _, shown: change(shown))


def computed(key: str, value: Any, text: str) -> Fault:
    """A number that is computed wrongly, and so is on the page and in report.json."""

    def fault(page: str, numbers: Numbers) -> str:
        numbers[key] = {"value": value, "shown": text}
        return _with_text(page, key, lambda *_: text, value)

    return fault


def exchanged(one: str, two: str) -> Fault:
    """Two numbers exchanged, on the page and in report.json."""

    def fault(page: str, numbers: Numbers) -> str:
        a, b = dict(numbers[one]), dict(numbers[two])
        return computed(two, **_of(a))(computed(one, **_of(b))(page, numbers), numbers)

    return fault


def _of(number: dict[str, Any]) -> dict[str, Any]:
    return {"value": number["value"], "text": number["shown"]}


def _with_text(text: str, key: str, change: Callable[[str, str], str], value: Any = None) -> str:
    """The page with what it has of a key changed: value and text -> text."""

    def changed(found: re.Match[str]) -> str:
        of = found[1] if value is None else value if isinstance(value, str) else json.dumps(value)
        return f'<data value="{of}" data-key="{key}">{change(found[1], found[2])}</data>'

    found, count = re.subn(rf'<data value="([^"]*)" data-key="{re.escape(key)}">([^<]*)</data>', changed, text)
    assert count
    return found


@pytest.mark.parametrize(
    ("fault", "named"),
    [
        (page(lambda t: re.sub(r" ± <data [^>]*case02.fraction_retained.half_width.*?</data>", "", t)),
         "case02.fraction_retained.half_width: it is in report.json but not on the page"),
        (computed("case02.fraction_retained.half_width", 0.99, "0.99"), "case02.fraction_retained.half_width: '0.99' is shown"),
        (computed("case02.passed_percent.half_width", 99.0, "99"), "case02.passed_percent.half_width: '99' is shown"),
    ],
)  # fmt: skip
def test_faults_of_intervals_are_found_and_named(fault: Fault, named: str, seeded: Path) -> None:
    """A number of one seed where there are three, and intervals that are not Student's."""
    path = written(seeded)
    text, numbers = path.read_text(), json.loads(path.with_suffix(".json").read_text())
    wrong = fault(text, numbers)
    assert wrong != text
    faults = read(stored(path, wrong, numbers))
    assert any(named in fault for fault in faults), faults


def digit(was: str) -> str:
    """The last digit one more."""
    at = max(m.start() for m in re.finditer(r"\d", was.split("e")[0]))
    return was[:at] + str((int(was[at]) + 1) % 10) + was[at + 1 :]


def in_section(name: str, change: Callable[[str], str]) -> Fault:
    def changed(text: str, numbers: Numbers) -> str:
        start = text.index(f'<section id="{name}">')
        end = text.index("</section>", start)
        return text[:start] + change(text[start:end]) + text[end:]

    return changed


def columns_swapped(section: str, one: str, two: str) -> Fault:
    """The heads of two columns or rows exchanged as a whole."""
    pattern = r'<data value="[^"]*" data-key="label\.{}">[^<]*</data>'

    def change(text: str) -> str:
        heads = [re.search(pattern.format(re.escape(name)), text) for name in (one, two)]
        assert heads[0] and heads[1]
        return swapped(text, heads[0][0], heads[1][0])

    return in_section(section, change)


SHOWN: dict[str, tuple[Fault, str]] = {
    "texts of the legend swapped": (
        in_section("moisture", lambda s: swapped(s, ">M = 5 %<", ">dry<")),
        "the curve of case01:fraction_retained is called 'M = 5 %'; report.json has 'dry'",
    ),
    "colours of the legend swapped": (
        in_section(
            "liquid",
            lambda s: re.sub(r"(legend_1.*)", lambda m: swapped(m[1], "#d98032", "#e07a9c"), s, flags=re.DOTALL),
        ),
        "the curve of case02:outlet_m3 is called 'wires'; report.json has 'outlet'",
    ),
    "a colour not in the legend": (
        in_section("classes", lambda s: s.replace("stroke: #4a9bd4", "stroke: #4a9bd5", 1)),
        "is not in the legend",
    ),
    "names of curves": (
        in_section("moisture", lambda s: s.replace("case01:fraction_retained", "case02:fraction_retained", 1)),
        "the curve of case02:fraction_retained is called 'dry'; report.json has 'M = 5 %'",
    ),
    "data next to a figure": (
        in_section("moisture", lambda s: re.sub(r'("y": \[.*?), [\d.]+\]', r"\1, 0.5]", s, count=1)),
        "the data next to the curve labelled",
    ),
    "labels next to a figure": (
        in_section("moisture", lambda s: s.replace('"label": "dry"', '"label": "wet"')),
        "label or colour next to the curve labelled 'dry'",
    ),
    "numbers of an axis": (
        in_section("curves", lambda s: s.replace(">0.6<", ">0.7<").replace(">0.8<", ">0.9<")),
        "should be fraction_retained of case",
    ),
    "end misprinted": (on_page("case03.fraction_retained", digit), "case03.fraction_retained: "),
    "a sphere more": (computed("case01.spheres", 4, "4"), "case01.spheres: '4' is shown; expected 3"),
    "events swapped": (
        exchanged("case02.formations", "case02.ruptures"),
        "case02.formations: '11002' is shown; expected 12002",
    ),
    "ledger misprinted": (on_page("case05.liquid_mm3.fines", digit), "case05.liquid_mm3.fines: "),
    "heads of the ledger swapped": (
        in_section("ledger", lambda s: swapped(s, ">fines<", ">wires<")),
        "label.liquid_mm3.fines: 'wires' is shown; report.json has 'fines'",
    ),
    "columns of the ledger swapped": (
        columns_swapped("ledger", "liquid_mm3.fines", "liquid_mm3.wires"),
        "case02.liquid_mm3.fines: it is in the column 'wires', which is for liquid_mm3.wires",
    ),
    "columns of the ledger alike": (
        computed("label.liquid_mm3.fines", "liquid_mm3.fines", "wires"),
        "label.liquid_mm3.fines and label.liquid_mm3.wires: both are called 'wires' in one table",
    ),
    "cases of the effects swapped": (
        columns_swapped("effects", "case02", "case03"),
        "case02.effect.capillary: it is in the column '3', which is for case03",
    ),
    "ledger's error": (on_page("case06.ledger_error", digit), "case06.ledger_error: "),
    "largest and median swapped": (
        exchanged("case02.deviation.force.largest", "case02.deviation.force.median"),
        "case02.deviation.force.largest: ",
    ),
    "number of an effect": (on_page("case03.effect.capillary", digit), "case03.effect.capillary: "),
    "contribution misprinted": (
        on_page("case02.contribution.capillary", lambda _: "77"),
        "case02.contribution.capillary: '77'",
    ),
    "prediction misprinted": (
        on_page("case02.contribution.capillary.predicted", lambda _: "99"),
        "case02.contribution.capillary.predicted: '99' is shown",
    ),
    "amounts in the first table swapped": (
        in_section("answer", lambda s: swapped(s, ">5 % liquid<", ">10 % liquid<")),
        "case02.moisture: '10 % liquid' is shown; report.json has '5 % liquid'",
    ),
    "another amount in the first table": (
        computed("case02.moisture", 5.0, "7 % liquid"),
        "case02.moisture: '7 % liquid' is shown; expected 5",
    ),
    "another amplitude in the first table": (
        on_page("case01.configuration", lambda was: was.replace("A = 1 mm", "A = 2 mm")),
        "case01.configuration: ",
    ),
    "passed misprinted": (computed("case01.passed_percent", 3.0, "3"), "case01.passed_percent: '3' is shown"),
    "rounded to too few digits": (
        lambda t, n: computed("case01.coarse_share", n["case01.coarse_share"]["value"], "0")(t, n),
        "case01.coarse_share: '0' is shown; expected 0.3 (3 digits)",
    ),
    "value next to the right text": (
        page(lambda t: re.sub(r'<data value="[^"]*" (data-key="case01.wall_s")', r'<data value="1.5" \1', t)),
        "case01.wall_s: the page has the value 1.5",
    ),
    "card misprinted": (
        computed("largest_ledger_error", 9.9e-16, "9.9e−16"),
        "largest_ledger_error: '9.9e−16' is shown",
    ),
    "columns of the presets swapped": (
        columns_swapped("presets", "presets.case02.paper", "presets.case02.exact"),
        "presets.case02.paper.wall_s: it is in the column 'exact', which is for exact",
    ),
    "presets swapped": (
        exchanged("presets.case02.paper.fraction_retained", "presets.case02.exact.fraction_retained"),
        "presets.case02.exact.fraction_retained: ",
    ),
    "rows of the presets swapped": (
        columns_swapped("presets", "presets.formations", "presets.ruptures"),
        "presets.case02.paper.formations: it is in the row 'bridges ruptured', which is for ruptures",
    ),
    "liquid of the presets swapped": (
        exchanged("presets.case02.paper.liquid_percent.wires", "presets.case02.paper.liquid_percent.outlet"),
        "presets.case02.paper.liquid_percent.wires: ",
    ),
    "presets of another case": (
        computed("presets.case02.case", 3, "3"),
        "presets.case02.case: '3' is shown; expected 2",
    ),
    "dry and moist swapped in the answer": (
        lambda t, n: exchanged("passed.dry.least_percent", "passed.moist.least_percent")(
            exchanged("passed.dry.most_percent", "passed.moist.most_percent")(t, n), n
        ),
        "passed.dry.least_percent: ",
    ),
    "time of the answer": (
        computed("time_since_opening_s", 1.5, "1.5"),
        "time_since_opening_s: '1.5' is shown; expected 1.4",
    ),
    "a case more": (computed("cases.count", 7, "7"), "cases.count: '7' is shown; expected 6"),
    "not recomputed": (
        computed("cross_check.outcome", "disagrees", "Not cross-checked: case 2."),
        "cross_check.outcome: 'Not cross-checked: case 2.' is shown; expected 'agrees'",
    ),
    "quantities of the proof": (
        computed("cross_check.quantities", 3, "3"),
        "cross_check.quantities: '3' is shown; expected 2",
    ),
    "liquid is lost": (
        computed("cross_check.liquid", "not conserved", ""),
        "cross_check.liquid: '' is shown; expected 'conserved'",
    ),
    "done and all": (computed("cases.done", 5, "5"), "cases.done: '5' is shown; expected 6"),
    "done but listed": (
        lambda t, n: (
            n.update({"case03.not_done": {"value": "case03", "shown": "case03"}})
            or t.replace(
                '<section id="answer">',
                '<ul><li><data value="case03" data-key="case03.not_done">case03</data>: failed</li></ul><section id="answer">',
            )
        ),
        "case03.not_done: not expected",
    ),
    "laws of other cases": (
        computed("law.capillary.rabinovich", "1, 2", "1, 2"),
        "law.capillary.rabinovich: '1, 2' is shown; expected '1, 2, 3, 4, 5, 6'",
    ),
    "another law": (
        on_page("label.law.capillary.rabinovich", lambda _: "willett"),
        "label.law.capillary.rabinovich: 'willett' is shown; report.json has 'rabinovich'",
    ),
    "hours for minutes": (
        lambda t, n: computed("engine_time_min", n["engine_time_min"]["value"] / 60.0, "0.12")(t, n),
        "engine_time_min",
    ),
    "sphere-steps": (on_page("million_sphere_steps", lambda was: f"7{was}"), "million_sphere_steps"),
    "softening": (
        computed("scale.stiffness_factor", 0.1, "0.1"),
        "scale.stiffness_factor: '0.1' is shown; expected 0.01",
    ),
    "duration and opening swapped": (
        exchanged("scale.duration_s", "scale.slide_opens_at_s"),
        "scale.duration_s: '0.2' is shown; expected 1.6",
    ),
    "a 3-D scene missing": (
        page(
            lambda t: re.sub(
                r'<script type="application/json" class="run" data-name="case02">.*?</script>', "", t, flags=re.DOTALL
            )
        ),
        "scene of case02: there is none",
    ),
    "shape of the sieve": (
        computed("scale.shape", "cylinder", "round"),
        "scale.shape: 'round' is shown; expected 'square'",
    ),
    "an assumption misprinted": (
        on_page("assumption.apparatus.outlet_height_mm", digit),
        "assumption.apparatus.outlet_height_mm: '101' is shown; report.json has '100'",
    ),
    "reasons of assumptions swapped": (
        exchanged("assumption.apparatus.feed_bin_height_mm.reason", "assumption.apparatus.slide_height_mm.reason"),
        "assumption.apparatus.slide_height_mm.reason: ",
    ),
    "a number left out": (
        lambda t, n: n.pop("case04.steps") and re.sub(r'<data [^>]*data-key="case04.steps">[^<]*</data>', "", t),
        "case04.steps: it is missing; expected 48004",
    ),
}
"""Faults of what is shown: of the page alone, or computed wrongly and so in report.json too."""


@pytest.mark.parametrize("name", SHOWN)
def test_faults_of_what_is_shown_are_found_and_named(name: str, folder: Path, right: tuple[str, Numbers]) -> None:
    plant, named = SHOWN[name]
    text, numbers = right[0], {key: dict(of) for key, of in right[1].items()}
    wrong = plant(text, numbers)
    assert wrong != text
    faults = read(stored(folder / "wrong.html", wrong, numbers))
    assert any(named in fault for fault in faults), faults


@pytest.mark.parametrize("part", range(8))
def test_every_number_that_is_computed_wrongly_is_found(part: int, folder: Path, right: tuple[str, Numbers]) -> None:
    """Each number of report.json 2 % or, of whole numbers, 1 greater, in value and text; each word another; each left out.

    Every eighth at a time, so that its neighbours are right.
    """
    numbers = right[1]
    runs = shown.Runs(folder / "report.html", ROOT / "config" / "cases.csv", numbers)
    wrong = {}
    for key, of in numbers.items():
        value = of["value"]
        if value is None or key.startswith(("label.", "figure.")):
            continue
        more = f"{value} more" if isinstance(value, str) else 1.02 * value if value % 1 else value + 1
        wrong[key] = {"value": more, "shown": more if isinstance(more, str) else f"{more:.6g}"}
    chosen = [*wrong][part::8]
    left = {k: v for k, v in numbers.items() if k not in chosen}
    for changed in ({**numbers, **{key: wrong[key] for key in chosen}}, left):
        faults = report_values.wrong(runs, changed)[1]
        assert {*chosen} - {fault.partition(": ")[0] for fault in faults} == set()


@pytest.mark.skipif(shutil.which("chromium") is None, reason="no browser on this machine")
def test_a_browser_shows_what_was_read(folder: Path, right: tuple[str, Numbers], tmp_path: Path) -> None:
    """The page as chromium has it in memory, after its scripts and its mending of markup, reads the same."""
    stored(folder / "page.html", *right)
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
    stored(folder / "dom.html", dom, right[1])
    path, cases = folder / "page.html", ROOT / "config" / "cases.csv"
    mine, theirs = shown.check(path, cases), shown.check(folder / "dom.html", cases)
    assert (theirs.faults, theirs.curves, theirs.numbers) == ([], mine.curves, mine.numbers)
