"""Table of agreement: cells say what they compare, a failed source blanks its own cells only, engines meet solutions."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet import stages
from pywet.engines.lammps import build
from pywet.errors import PywetError
from studies.cross_code import dry, engines, lammps, page, pictures, replayed, single, sources
from studies.cross_code import stock as stock_programs
from studies.cross_code.model import Cell, Source, deviation_text, impossible, measured, truth
from studies.cross_code.rows import BY_KEY, COLUMNS, GROUPS, LIGGGHTS, QUANTITIES, REFERENCE, ROWS, YADE
from studies.cross_code.stock import Stock
from tests.cases.screening import synthetic


def test_rows_are_one_of_each_and_grouped() -> None:
    """Keys are unique; rows of a group stand together."""
    assert len(BY_KEY) == len(ROWS)
    order = [GROUPS.index(r.group) for r in ROWS]
    assert order == sorted(order) and set(order) == set(range(len(GROUPS)))


def test_a_cell_knows_its_worst() -> None:
    """Largest, median and place over all values; a value that is not finite fails the cell."""
    cell = measured("r", YADE, np.array([1.0, 2.2, 3.03]), np.array([1.0, 2.0, 3.0]), at=["a", "b", "c"])
    assert cell.deviation == pytest.approx(0.1) and cell.median == pytest.approx(0.01)
    assert (cell.count, cell.worst_at) == (3, "b")
    assert measured("r", YADE, np.array([np.nan]), np.array([1.0])).state == "failed"


def test_deviations_as_text() -> None:
    """Powers where small, per cent where large, multiples where absurd."""
    assert [deviation_text(x) for x in (0.0, 4e-16, 9e-4, 2e-3, 0.1234, 1.0, 172.0)] == [
        "0", "4e-16", "9e-4", "0.2 %", "12 %", "100 %", "172 ×",
    ]  # fmt: skip


def test_page_shows_cells_with_hints_and_links(tmp_path: Path) -> None:
    """Colour by deviation, hint with count and place, link to the run; reasons of empty cells are collected."""
    row = "momentum_wet"
    cells = [
        measured(row, LIGGGHTS, np.array([1e-15]), np.array([0.0]), np.ones(1), at=["t = 1 ms"], link="runs/x/"),
        impossible(row, YADE, "it cannot <do> this"),
        truth("restitution", "exact", "closed form"),
        Cell("restitution", YADE, "measured", 0.3, 7),
    ]
    for name in sources.SOURCES:
        Source(name, cells if name == "replayed" else []).write(sources.data_file(tmp_path, name))
    text = page.write_page(tmp_path).read_text()
    assert '<td class="" style="background:#b5dfc4" title="largest 1e-15; over 1 comparisons' in text
    assert "worst at t = 1 ms" in text and '<a href="runs/x/">1e-15</a>' in text
    assert text.count("it cannot &lt;do&gt; this") == 2  # in the cell's hint and in the list of limits
    assert 'style="background:#f2ab9b"' in text and ">30 %<" in text and '<td class="truth"' in text
    assert len(json.loads((tmp_path / "table.json").read_text())) == len(cells)


def test_a_failed_source_blanks_only_its_cells(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A mistake and a fault are both written with their reason, and the page is made all the same."""

    def broken(folder: Path) -> Source:
        raise PywetError("the program yade was not found")

    monkeypatch.setitem(sources.SOURCES, "dry", broken)
    monkeypatch.setitem(sources.SOURCES, "single", lambda folder: 1 / 0)  # type: ignore[arg-type,return-value]
    assert sources.run_source("dry", tmp_path).failed == "the program yade was not found"
    assert "ZeroDivisionError" in sources.run_source("single", tmp_path).failed
    sources.run_source("screening", tmp_path)
    text = page.write_page(tmp_path).read_text()
    assert "the program yade was not found" in text and "not run" in text
    with pytest.raises(PywetError, match="no source"):
        sources.run_source("guesses", tmp_path)


def test_screening_takes_the_worst_case_of_each_preset(tmp_path: Path) -> None:
    """Two replayed cases: the larger deviation, both counts."""
    for name, largest in (("case02", 1e-14), ("case05", 3e-13)):
        folder = tmp_path / "smoke" / name
        synthetic.make(folder)
        quantities = {
            "capillary": {"scale": "1", "tolerance": 1e-9, "largest": largest, "count": 10, "median": 0.0,
                          "worst": {"step": 1, "i": 2, "j": 3}}
        }  # fmt: skip
        (folder / "replay.json").write_text(json.dumps({"contacts": 10, "quantities": quantities}))
    cells = {(c.row, c.column): c for c in replayed.screening(tmp_path).cells}
    force = cells["force_screening", LIGGGHTS]
    assert (force.deviation, force.count, force.worst_at) == (3e-13, 20, "step 1, bridge 2-3")
    assert "smoke case05: capillary" in force.note
    assert cells["force_screening_exact", LIGGGHTS].state == "not run"
    assert cells["ledger_screening", LIGGGHTS].state == "impossible"


def test_engines_are_read_from_the_crosscheck(tmp_path: Path) -> None:
    """Without it every cell says how to run it; with it means, and whether the difference is beyond the spread."""
    assert {c.state for c in engines.source(tmp_path).cells} == {"impossible", "not run", "truth"}
    random = np.random.default_rng(1)
    for engine, shift in (("liggghts", 0.0), ("yade", 0.2)):
        for seed in range(5):
            run = tmp_path / "dry" / engine / f"seed{seed}"
            synthetic.make(run, moist=False)
            stages.results(run)
            for path in (run / "results" / "fraction_retained.parquet", run / "trajectory.parquet"):
                table = pd.read_parquet(path)
                column = "fraction_retained" if "results" in str(path) else "x"
                table[column] += (shift if column != "x" else 0.0) + 1e-3 * random.normal()
                table.to_parquet(path)
    for seed in range(4):
        folder = tmp_path / "bed" / f"seed{seed}"
        folder.mkdir(parents=True)
        programs = ("LIGGGHTS+pywet", "YADE", "washino", "easo", "LIGGGHTS, dry", "YADE, dry")
        table = pd.DataFrame({"engine": programs, "contacts_per_sphere": 4 + random.normal(size=6)})
        table["mean_height_over_radius"] = np.where(table["engine"] == "washino", 6, 5) + 0.01 * random.normal(size=6)
        table.to_parquet(folder / "bed.parquet")
    rows = [
        ("restitution, a", "YADE", 0.81, 0.8),
        ("restitution, a", "LIGGGHTS", 0.8, 0.8),
        ("friction, a", "YADE", 0.3, 0.3),
    ]
    (tmp_path / "contacts").mkdir()
    named = pd.DataFrame(rows, columns=["quantity", "engine", "value", "reference_value"])
    named.to_parquet(tmp_path / "contacts" / "rows.parquet")
    made = engines.source(tmp_path)
    cells = {(c.row, c.column): c for c in made.cells}
    assert [len(made.curves["retained"][column]) for column in (LIGGGHTS, YADE)] == [5, 5]
    assert cells["case_restitution", YADE].deviation == pytest.approx(0.0125)
    assert cells["case_friction", LIGGGHTS].state == "not run" and cells["bed_dry_contacts", YADE].within is not None
    stored = cells["retained_dry", YADE]
    assert stored.deviation == pytest.approx(0.2, abs=5e-3) and "beyond the spread of 5 and 5 seeds" in stored.note
    assert stored.within is False and cells["retained_dry", LIGGGHTS].state == "basis"
    assert cells["bed_moist_height", YADE].within
    assert cells["bed_moist_height", "washino"].deviation == pytest.approx(0.2, abs=0.01)
    assert "beyond their spread" in cells["bed_moist_height", "washino"].note
    assert "within their spread" in cells["bed_moist_height", YADE].note


def test_picture_of_both_engines_holds_their_difference() -> None:
    """Means 0.5 and 0.6, both of variance 0.02 over two runs: difference 0.1, two standard errors 2 sqrt(0.02/2 + 0.02/2)."""
    runs = {"time": [0.0, 1.0], LIGGGHTS: [[0.4, 0.4], [0.6, 0.6]], YADE: [[0.5, 0.5], [0.7, 0.7]]}
    top, low = pictures.retained(runs).axes
    assert len(top.lines) == 6  # each run and the mean of each engine
    assert low.lines[-1].get_ydata() == pytest.approx([0.1, 0.1])
    band = np.asarray(low.collections[0].get_paths()[0].vertices)[:, 1]
    assert [band.min(), band.max()] == pytest.approx([-2 * math.sqrt(0.02), 2 * math.sqrt(0.02)])


def test_without_lammps_its_column_says_how_to_get_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every row has a cell; none counts as failed."""
    monkeypatch.setattr(build, "PREFIX", tmp_path)
    cells = lammps.source(tmp_path).cells
    assert [c.row for c in cells] == [row.key for row in ROWS]
    assert {c.state for c in cells} == {"not run"} and "make peers" in cells[0].note


def test_end_of_a_force_is_found_between_two_points() -> None:
    """The coarse scan's bracket; a scan that does not hold the end gives NaN."""
    points = pd.DataFrame({"pair": "p", "what": "coarse", "separation": np.linspace(0, 1, 11)})
    stock = Stock({"easo": points.assign(force=np.where(points["separation"] < 0.55, 1.0, 0.0))})
    assert stock.bracket("easo", "p", "coarse") == pytest.approx((0.5, 0.6))
    stock.tables["easo"] = points.assign(force=1.0)
    assert np.isnan(stock.bracket("easo", "p", "coarse")).all()


def test_a_stock_program_that_is_missing_blanks_its_column(monkeypatch: pytest.MonkeyPatch) -> None:
    """The others are measured, in both calls."""

    def absent(points: pd.DataFrame, law: str) -> pd.DataFrame:
        raise PywetError("the program yade was not found")

    programs = {YADE: absent, "easo": lambda points, law: points.assign(force=2.0)}
    monkeypatch.setattr(stock_programs, "PROGRAMS", programs)
    stock = Stock()
    for what in ("gaps", "curve"):
        stock.measure(pd.DataFrame({"pair": ["p"], "what": what, "separation": 1e-5}))
    assert stock.missing == {YADE: "the program yade was not found"} and stock.there == ["easo"]
    gaps, force = stock.force("easo", "exact", "p", "curve")
    assert (gaps.tolist(), force.tolist()) == ([1e-5], [2.0])


def test_dry_impact_solved() -> None:
    """Head on: the configured restitution. Sliding: the impulse of Coulomb's law μ(1+e)v_n, but for the springs' first stick
    (less than 1 % of it). Both to the error of 200,000 steps."""
    assert dry.exact(0.0).normal == pytest.approx(0.8, abs=1e-6)
    steep = dry.exact(60.0)
    lost = 0.3 * 1.8 * math.cos(math.radians(60.0))
    assert math.sin(math.radians(60.0)) - steep.tangential == pytest.approx(lost, rel=0.01)
    assert steep.spin == pytest.approx(lost / 0.8, rel=0.01)  # I = 0.4 m R², m twice the reduced mass


def test_two_spheres_head_on_by_the_reference() -> None:
    """The description handed to the reference is the one of equation 41: 1 - 3.9332/12."""
    from reference_impl.spheres import spheres

    assert single.restitution(spheres.solve(single.two_spheres(12.0))) == pytest.approx(0.672233, abs=1e-6)


@pytest.mark.engine
def test_dry_impacts_in_the_engines(tmp_path: Path) -> None:
    """Both programs within the first-order error of 200 steps in a contact; momentum to round-off."""
    cells = {(c.row, c.column): c for c in dry.source(tmp_path).cells}
    for column in (LIGGGHTS, YADE):
        if column == YADE and shutil.which("yade") is None:
            assert cells["restitution", YADE].state == "not run"
            continue
        for row in dry.ANGLES:
            assert cells[row, column].deviation == pytest.approx(0.0, abs=2e-3)
        assert cells["momentum_dry", column].deviation == pytest.approx(0.0, abs=1e-12)


@pytest.mark.engine
def test_replayed_pair_gives_every_quantity(tmp_path: Path) -> None:
    """All eleven quantities have a cell of LIGGGHTS + pywet within 1e-9 of the reference."""
    cells = {
        (c.row, c.column): c for c in replayed._cells("pair", [replayed._pair(tmp_path, LIGGGHTS)], "runs/pair/", "")
    }
    for key in QUANTITIES:
        ours = cells[f"{key}_pair", LIGGGHTS]
        assert ours.deviation is not None and ours.deviation <= 1e-9 and ours.count > 0
        assert cells[f"{key}_pair", REFERENCE].state == "truth"


@pytest.mark.slow
@pytest.mark.engine
def test_every_row_has_a_cell_or_a_reason_in_every_column(tmp_path: Path) -> None:
    """All sources: no cell is missing, no row is unknown, no source fails."""
    for name in sources.SOURCES:
        assert sources.run_source(name, tmp_path / "agreement").failed == ""
    found = page.read_sources(tmp_path / "agreement").cells
    assert {key for key, _ in found} <= set(BY_KEY)
    ours = [key for key in BY_KEY if (key, LIGGGHTS) not in found]
    assert ours == []
    missing = [
        (k, c) for k in BY_KEY for c in COLUMNS if (k, c) not in found and "screening" not in k and "dry" not in k
    ]
    assert missing == []
