"""`pywet plot`: figures in the width in which they are printed, with the panels that the runs have and seeds as bands."""

from __future__ import annotations

import json
import re
import shutil
import warnings
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from PIL import Image
from typer.testing import CliRunner

from pywet import stages
from pywet.cli.app import app
from pywet.compare.grouping import same_scene
from pywet.products import streams
from pywet.products.partition import wilson
from pywet.report import bands, pictures, plots
from pywet.runs import record
from pywet.runs.rundir import RunDir
from pywet.util.files import read_table, write_table
from tests.cases.screening import synthetic
from tests.error_codes import raises_code
from tests.products import made_up

MM = 72.0 / 25.4
"""Points of a PDF."""


@pytest.fixture(scope="module")
def seeds(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Three seeds of a case, whose fraction retained at the end differs by hand: 0.4, 0.5, 0.6."""
    folder, runs = tmp_path_factory.mktemp("seeds"), []
    for name, end in (("case02", 0.4), ("case02-8", 0.5), ("case02-9", 0.6)):
        run = synthetic.make(folder / name)
        stages.results(run)
        table = read_table(run / "results" / "fraction_retained.parquet")
        table.loc[table.index[-1], "fraction_retained"] = end
        write_table(table, run / "results" / "fraction_retained.parquet")
        scene = json.loads((run / "scene.json").read_text())
        (run / "scene.json").write_text(json.dumps({**scene, "seed": 10007 + len(runs)}))
        runs.append(run)
    return runs


@pytest.mark.parametrize("width", [84, 150])
def test_the_figure_has_the_width_it_is_printed_in(seeds: list[Path], tmp_path: Path, width: int) -> None:
    """MediaBox of the PDF in points of 1/72 inch, pixels of the PNG at 300 dpi; letters have their size in print: 8 points."""
    words = [*map(str, seeds), "--width", str(width), "--out"]
    for end in ("pdf", "png", "svg"):
        assert CliRunner().invoke(app, ["plot", *words, str(tmp_path / f"f.{end}")]).exit_code == 0
    box = re.search(rb"/MediaBox \[ 0 0 ([\d.]+)", (tmp_path / "f.pdf").read_bytes())
    assert box is not None and float(box[1]) == pytest.approx(width * MM, abs=0.1)
    assert Image.open(tmp_path / "f.png").width == pytest.approx(width / 25.4 * 300, abs=1)
    drawn = ElementTree.parse(tmp_path / "f.svg").getroot()
    output_text = [" ".join("".join(t.itertext()).split()) for t in drawn.iter("{http://www.w3.org/2000/svg}text")]
    labels = (
        "fraction retained [-]",
        "partition: share retained [-]",
        "share of the liquid put in [-]",
        "diameter [mm]",
    )
    assert [label for label in labels if label not in output_text] == []
    assert any("95 % confidence interval" in text for text in output_text) and output_text.count("case02") == 2
    assert "font-size: 8px" in (tmp_path / "f.svg").read_text()


def test_the_band_is_students_interval(seeds: list[Path]) -> None:
    """0.5 ± 4.303 × 0.1/√3 at the end; a partition of the two sizes that the run has."""
    groups = bands.grouped(seeds, same_scene)
    assert list(groups) == ["case02"]
    retained, partition, liquid = bands.panels_of(groups)
    _, mean, half = bands.mean_and_band(retained.curves["case02", ""])
    assert half is not None and (mean[-1], half[-1]) == pytest.approx((0.5, 4.303 * 0.1 / np.sqrt(3)), rel=1e-3)
    assert partition.curves["case02", ""][0][0] == pytest.approx([4.0, 8.0])  # diameters [mm]
    assert ("case02", "wires") in liquid.curves


def test_each_seed_is_in_a_band_once(seeds: list[Path], tmp_path: Path) -> None:
    """A folder CASE-SEED whose scene has the seed of CASE is left out."""
    again = shutil.copytree(seeds[0], tmp_path / "case02"), shutil.copytree(seeds[0], tmp_path / "case02-8")
    other = shutil.copytree(seeds[1], tmp_path / "case02-9")
    assert bands.grouped([*again, other], same_scene) == {"case02": [again[0], other]}


@pytest.mark.parametrize("changed", ["film", "fingerprint"])
def test_runs_that_differ_in_more_than_the_seed_have_separate_curves(
    seeds: list[Path], tmp_path: Path, caplog: pytest.LogCaptureFixture, changed: str
) -> None:
    """Of three folders CASE and CASE-SEED one has another film, or was made from other files: a band of two and a curve."""
    runs = [shutil.copytree(run, tmp_path / run.name) for run in seeds]
    if changed == "film":
        scene = json.loads((runs[1] / "scene.json").read_text())
        scene["liquid"]["initial_film_thickness_m"] *= 2.0
        (runs[1] / "scene.json").write_text(json.dumps(scene))
    else:
        for k, word in enumerate(("one", "other", "one")):
            record.leave_identity(runs[k], f"seed {k}", word)
    assert bands.grouped(runs, same_scene) == {"case02": [runs[0], runs[2]], "case02-8": [runs[1]]}
    assert caplog.text.count("it is not counted as a seed of it") == 1
    done = CliRunner().invoke(app, ["plot", *map(str, runs), "--out", str(tmp_path / "f.svg")])
    assert done.exit_code == 0 and "case02-8" in (tmp_path / "f.svg").read_text()


def test_a_reservoir_that_is_empty_in_some_seeds_is_zero_there(seeds: list[Path], tmp_path: Path) -> None:
    """Shares of 0, 0 and 0.3 at the end: the mean is 0.1, with Student's interval of all three, 0.1 ± 4.303 × 0.1."""
    runs = [Path(shutil.copytree(run, tmp_path / run.name)) for run in seeds]
    for run, share in zip(runs, (0.0, 0.0, 0.3), strict=True):
        path = run / "results" / "liquid_by_holder.parquet"
        table = read_table(path).assign(wires_m3=0.0)
        table.loc[table.index[-1], "wires_m3"] = share * table["initial_m3"].max()
        write_table(table, path)
    *_, liquid = bands.panels_of(bands.grouped(runs, same_scene))
    _, mean, half = bands.mean_and_band(liquid.curves["case02", "wires"])
    assert half is not None and (mean[-1], half[-1]) == pytest.approx((0.1, 4.303 * 0.1), rel=1e-3)


def test_runs_without_a_table_are_named(seeds: list[Path], tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """One of three seeds has no fraction retained: the curve of two says so, and that of all three says nothing."""
    runs = [Path(shutil.copytree(run, tmp_path / run.name)) for run in seeds]
    (runs[1] / "results" / "fraction_retained.parquet").unlink()
    assert len(bands.panels_of({"case02": runs})[0].curves["case02", ""]) == len(runs) - 1
    assert "case02: 2 of 3 runs have data for 'fraction retained'; others are left out" in caplog.text
    assert "share of the liquid put in" not in caplog.text


def test_reservoirs_are_summed_in_all_seeds_or_in_none(tmp_path: Path) -> None:
    """Ten reservoirs in the first run, three in the second: of both the sums over spheres and over walls are drawn."""
    runs = [RunDir(run) for (run,) in decks(tmp_path).values()]
    path = runs[1].path / "results" / "liquid_by_wall.parquet"
    empty = {
        f"{word}_m3": 0.0 for word in (*(f"spheres_{k}_mm" for k in range(2, 5)), *(f"wall_{k}" for k in range(4)))
    }
    write_table(read_table(path).assign(**empty), path)
    panel = bands.Panel(bands.TIME, "share")
    bands._liquid([as_moist(run) for run in runs], "deck", {bands.TIME: panel})
    ends = {name: [y[-1] for _, y in of] for (_, name), of in panel.curves.items()}
    assert ends == {"on spheres": [0.4, 0.1], "on walls": [0.4, 0.0], "overs": [0.1, 0.1], "unders": [0.1, 0.1]}


def test_a_partition_is_of_the_dry_mass_and_liquid_has_the_time_of_the_fraction_retained(seeds: list[Path]) -> None:
    """A class that gained liquid is retained by more than its mass at the start, and its partition is 1 all the same."""
    run = seeds[0]
    table = read_table(run / "results" / "fraction_retained.parquet")
    retained, partition, liquid = bands.panels_of({"one": [run]})
    large = partition.curves["one", ""][0][1][-1]
    (ends,) = partition.ends["one", ""]
    assert large == 1.0 and (ends[0] < ends[1]).all() and (ends[1] <= 1.0).all()
    assert retained.x == liquid.x and (liquid.curves["one", "wires"][0][0] == table["time_since_opening_s"]).all()


def test_what_cannot_be_drawn_is_refused(seeds: list[Path], tmp_path: Path) -> None:
    """Another format, a width that is no paper's, and a run with nothing to draw, each in a sentence that names the way out."""
    with raises_code("plot.suffix", given=".bmp"):
        bands.write(tmp_path / "fig.bmp", bands.grouped(seeds, same_scene))
    done = CliRunner(env={"COLUMNS": "300"}).invoke(app, ["plot", str(seeds[0]), "--width", "2"])
    assert done.exit_code != 0 and "40 to 500" in done.output
    dry = synthetic.make(tmp_path / "dry", moist=False)
    with raises_code("plot.nothing"):
        bands.write(tmp_path / "fig.pdf", bands.grouped([dry], same_scene))


@pytest.mark.parametrize(("count", "name"), [(2, "overs"), (3, "largest overlap of spheres with walls"), (14, "wall")])
def test_curves_differ_and_their_legend_is_below(count: int, name: str) -> None:
    """No two have colour and dash in common; the legend covers no axes and is within the figure, by as many columns as fit."""
    with pictures.plt.rc_context(pictures.STYLE):
        figure, (axes,) = pictures.panels(1, 1, (4.2, 3.3))
        for k in range(count):
            axes.plot([0.0, 1.0], [0.0, float(k)], label=f"{name} {k}")
        axes.set(xlabel="time [s]", ylabel="liquid [mm³]")
        pictures.legend(figure)
        figure.canvas.draw()
    looks = {(line.get_color(), line.get_linestyle()) for line in axes.lines}
    assert len(looks) == count
    (below,) = figure.legends
    box = below.get_window_extent()
    assert box.y1 <= axes.get_window_extent().y0 and box.y0 >= 0.0 and 0.0 <= box.x0 <= box.x1 <= figure.bbox.x1
    pictures.plt.close(figure)


def lines_of(count: int, groups: int) -> list[tuple[Any, Any]]:
    """Colour and dash of each line of a panel of made-up groups with `count` curves in all, and of its legend's entries."""
    panel, labels = bands.Panel("t", "y"), {f"case{k}": f"case{k}" for k in range(groups)}
    for k in range(count):
        panel.add(f"case{k % groups}", f"tray {k // groups}", np.array([0.0, 1.0]), [1.0, 0.1 * k])
    figure, (axes,) = pictures.panels(1, 1, (4.2, 3.3))
    bands._draw(axes, panel, labels)
    pictures.plt.close(figure)
    entries = panel.entries(labels)
    assert len(set(entries.values())) == len(entries)
    return [(line.get_color(), line._dash_pattern) for line in axes.lines]  # type: ignore[attr-defined]


def amounts(count: int) -> list[str]:
    """Colours of a dry case and of moist ones that differ in their amount of liquid."""
    cases: list[Any] = [
        SimpleNamespace(moist=k > 0, case=SimpleNamespace(liquid_percent=0.5 * k)) for k in range(count)
    ]
    return plots._moisture_colours(cases)


@pytest.mark.parametrize("count", [5, 8, 18, 40])
@pytest.mark.parametrize(
    "looks",
    [amounts, pictures.colours, lambda n: lines_of(n, 1), lambda n: lines_of(n, n), lambda n: lines_of(n, 2)],
    ids=["amounts", "colours", "curves", "groups", "curves of two groups"],
)
def test_looks_are_distinct_however_many(looks: Callable[[int], list[Any]], count: int) -> None:
    found = looks(count)
    assert len(found) == count and len(set(map(str, found))) == count


def test_every_tray_is_drawn_and_only_liquid_is_left_out() -> None:
    """Eight trays have eight curves; of liquid all reservoirs above a hundredth of the largest, seven of these eight."""
    for least, drawn in ((0.0, 8), (bands.LEAST_SHARE, 7)):
        panel = bands.Panel("x", "y", least=least)
        for k in range(8):
            panel.add("stack", f"{k}", [0.0, 1.0], [0.0, 0.5 if k else 0.004])
        assert len(panel.largest()) == drawn


@pytest.mark.parametrize("width", [50, 84, 150])
def test_notes_are_within_the_figure(
    seeds: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, width: float
) -> None:
    """All three of them, on lines of their own that may be broken; none speaks of what is not there."""
    found = bands.panels_of(bands.grouped(seeds, same_scene))
    found[1].ends["case02", ""] = found[1].ends["case02", ""][:1]
    found[2].add("case02", "feed bin", [0.0, 1.0], [0.0, 1e-6])
    monkeypatch.setattr(bands, "panels_of", lambda groups: found)
    monkeypatch.setattr(bands.plt, "close", lambda figure: None)
    bands.write(tmp_path / "f.png", bands.grouped(seeds, same_scene), width)
    figure = bands.plt.gcf()
    (note,) = figure.texts
    assert " ".join(note.get_text().split()) == (
        "bands: 95 % confidence interval of the mean over the seeds bars: 95 % intervals of the counts of one run "
        "reservoirs below 1 % of the largest are left out"
    )
    figure.canvas.draw()
    box = note.get_window_extent()
    assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1 and figure.bbox.y0 <= box.y0


def test_long_names_remain_distinct(monkeypatch: pytest.MonkeyPatch) -> None:
    """Names that differ in the middle, at the end, or where they are cut off; the liquid is not cut off."""
    long = [
        "deck_15deg_2mm_20Hz_moisture_2_percent_ore_seed_run",
        "deck_15deg_2mm_20Hz_moisture_8_percent_ore_seed_run",
    ]
    same = [f"{k}{'a' * 30}{n}{'a' * 30}{k}" for k in (1, 2) for n in (1, 2)]
    for names in (long, same, ["a" * 50, "a" * 60], [*long, "b"], long[:1]):
        short = bands._short(names)
        assert len(set(short)) == len(names) and max(map(len, short)) <= bands.LONG + 3
    assert "moisture_2_" in bands._short(long)[0] and "moisture_8_" in bands._short(long)[1]
    monkeypatch.setattr(bands, "_percent", lambda run: f"{len(str(run.path))} %")
    labels = bands._labels({long[0]: [Path("a")], long[1]: [Path("bb")]}).values()
    assert [label[-13:] for label in labels] == [" (1 % liquid)", " (2 % liquid)"] and max(
        map(len, labels)
    ) <= bands.LONG


def test_liquid_over_two_times_has_two_panels() -> None:
    """A case's reservoirs are over the time since the slide opened, a scene's ledger over that since the start."""
    tables = {
        "results/liquid_by_holder": pd.DataFrame(
            {"time_s": [0.0, 1.0], "time_since_opening_s": [-0.4, 0.6], "initial_m3": 1.0, "wires_m3": [0.0, 0.5]}
        ),
        "history/ledger": pd.DataFrame({"time": [0.0, 1.0], "initial": 1.0, "films": [1.0, 0.5]}),
    }
    panels = {x: bands.Panel(x, "share") for x in (bands.SINCE_OPENING, bands.TIME)}
    scene = SimpleNamespace(classes=[SimpleNamespace(name="a")], outlets=[])
    for name in tables:
        run: Any = SimpleNamespace(moist=True, scene=scene, table_if_there={name: tables[name]}.get)
        bands._liquid([run], name, panels)
    assert [[x.tolist() for ((x, _),) in panel.curves.values()] for panel in panels.values()] == [
        [[-0.4, 0.6]], [[0.0, 1.0]],
    ]  # fmt: skip


def test_liquid_of_a_longer_run_is_a_share_of_what_was_put_in_by_the_end_of_the_shortest() -> None:
    """Two runs of a feed of 1 m3/s that stays on the spheres, of 2 and 3 s: at 2 s the share is 1 in both."""
    scene = SimpleNamespace(classes=[SimpleNamespace(name="a")], outlets=[])
    panel, runs = bands.Panel(bands.TIME, "share"), []
    for end in (2, 3):
        times = np.arange(end + 1.0)
        ledger = {"history/ledger": pd.DataFrame({"time": times, "initial": times, "films": times})}
        runs.append(SimpleNamespace(moist=True, scene=scene, table_if_there=ledger.get))
    bands._liquid(cast(Any, runs), "seeds", {bands.TIME: panel, bands.SINCE_OPENING: panel})
    ((at, mean, half),) = (bands.mean_and_band(of) for of in panel.curves.values())
    assert at.tolist() == [0.0, 1.0, 2.0] and mean.tolist() == [0.0, 0.5, 1.0] and half is not None and not half.any()


def as_moist(run: RunDir) -> Any:
    """A made-up run, which has tables of liquid without bridges, as one with bridges."""
    return SimpleNamespace(moist=True, scene=run.scene, table_if_there=run.table_if_there)


def drawn(monkeypatch: pytest.MonkeyPatch, path: Path, groups: dict[str, list[Path]]) -> Figure:
    """The figure that was written; the made-up runs have tables of liquid without bridges."""
    liquid = bands._liquid

    def moist(runs: list[RunDir], group: str, panels: dict[str, bands.Panel]) -> None:
        liquid([as_moist(run) for run in runs], group, panels)

    monkeypatch.setattr(bands, "_liquid", moist)
    figures: list[Figure] = []
    monkeypatch.setattr(bands.plt, "close", figures.append)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        bands.write(path, groups)
    return figures[0]


def decks(tmp_path: Path) -> dict[str, list[Path]]:
    """Two made-up runs with ten liquid reservoirs and an aperture of 2.5 mm."""
    groups = {}
    for name in ("A a run whose name is rather long", "B another run with an even longer name"):
        run = made_up.make(tmp_path / name)
        (run / "config.json").write_text(json.dumps({"case": {"aperture_mm": 2.5}}))
        words = [
            *(f"spheres_{k}_mm" for k in range(1, 5)),
            *(f"wall_{k}" for k in range(4)),
            "outlet_overs",
            "outlet_unders",
        ]
        table = pd.DataFrame({"time_s": [0.0, 1.0], "initial_m3": 10.0, **{f"{word}_m3": [0.0, 1.0] for word in words}})
        write_table(table, run / "results" / "liquid_by_wall.parquet")
        groups[name] = [run]
    return groups


def test_panels_of_decks_are_readable(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two runs with ten reservoirs each: panels of 45 mm and more, at most eight entries each, in the figure, side by side."""
    figure = drawn(monkeypatch, tmp_path / "f.png", decks(tmp_path))
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    whole, boxes = figure.bbox, []
    for axes in figure.axes:
        legend = axes.get_legend()
        assert legend is not None and 2 <= len(legend.get_texts()) <= 8
        boxes.append(legend.get_window_extent(renderer))
        assert axes.get_window_extent(renderer).width >= 45 / 25.4 * figure.dpi
        assert axes.get_window_extent(renderer).height >= 40 / 25.4 * figure.dpi
        assert whole.x0 <= boxes[-1].x0 and boxes[-1].x1 <= whole.x1 and boxes[-1].y0 >= whole.y0
        assert not boxes[-1].overlaps(axes.get_window_extent(renderer))
    assert len(boxes) == 2 and not boxes[0].overlaps(boxes[1])
    liquid = {text.get_text() for text in figure.axes[1].get_legend().get_texts()}
    assert {"on spheres", "on walls", "overs", "unders"} < liquid
    assert figure.axes[1].get_lines()[0].get_ydata()[-1] == pytest.approx(0.4)


def test_a_partition_has_its_aperture_and_the_intervals_of_the_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A line at 2.5 mm; bars from Wilson's interval of the spheres of a size that are counted."""
    (first, runs), *_ = decks(tmp_path).items()
    figure = drawn(monkeypatch, tmp_path / "f.png", {first: runs})
    axes = figure.axes[0]
    assert [line.get_xdata()[0] for line in axes.get_lines() if line.get_linestyle() == ":"] == [2.5]
    counted = streams.read(RunDir(runs[0])).counted
    of = counted[counted["type"] == 2]
    ends = wilson(int((of["product"] == "overs").sum()), len(of))
    bar = axes.collections[0].get_segments()[1]  # type: ignore[attr-defined]
    assert bar[:, 0] == pytest.approx([2.0, 2.0]) and bar[:, 1] == pytest.approx(ends)
