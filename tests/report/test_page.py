"""The frame of the pages: everything asked for is in it, and text cannot break it."""

from __future__ import annotations

import json
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import matplotlib.pyplot as plt
import pandas as pd
import pytest

from pywet.report import page, plots, screen_page
from pywet.report.embedded_json import embedded

ROOT = Path(__file__).parents[2]


def _strictly(text: str) -> list[Any]:
    """Every embedded block of JSON, read as a browser reads it: without NaN."""

    def refused(word: str) -> None:
        raise AssertionError(f"{word} is no JSON")

    blocks = re.findall(r'<script type="application/json"[^>]*>(.*?)</script>', text, re.DOTALL)
    return [json.loads(block, parse_constant=refused) for block in blocks]


def test_page_holds_what_it_was_given(tmp_path: Path) -> None:
    """Cards, sections with anchors, a table with colours and links, a picture inside the file; text is escaped."""
    figure, axes = plt.subplots()
    axes.plot([0, 1], [0, 1])
    rows = [["a < b", page.Cell("1e-9", "good", "worst of 3", "runs/x")], ["c", page.Cell("?", "none")]]
    body = page.paragraph("Take `this` & that.") + page.table(["what", "value"], rows) + page.picture(figure, "a line")
    path = page.write(
        tmp_path / "p.html",
        "Title",
        "Lead <i>",
        [page.Section("One thing", body, "One")],
        [page.Card("3", "of 4", "bad")],
    )
    plt.close(figure)
    text = path.read_text()
    assert '<section id="one">' in text and 'href="#one"' in text
    assert "<code>this</code> &amp; that" in text and "a &lt; b" in text and "Lead &lt;i&gt;" in text
    assert '<td class="good" title="worst of 3"><a href="runs/x">1e-9</a></td>' in text
    assert 'src="data:image/svg+xml;base64,' in text and 'class="card bad"' in text


def test_the_curves_of_a_partition_are_its_columns() -> None:
    """Offered as CSV are the partition curve and the ends of its intervals in per cent, not the lines at d50 and aperture."""
    curve = pd.DataFrame({"diameter_mm": [2.0, 6.0], "T": [0.1, 0.9], "T_low": [0.0, 0.8], "T_high": [0.2, 1.0]})
    (lines,) = _strictly(screen_page._partition({"d50_mm": 4.0, "reference_mm": 5.0}, curve))
    assert {line["label"]: line["y"] for line in lines} == {
        "partition curve": [10.0, 90.0], "95 % low": [0.0, 80.0], "95 % high": [20.0, 100.0],
    }  # fmt: skip
    assert all(line["x"] == [2.0, 6.0] for line in lines)


def test_a_heading_is_aligned_as_its_column() -> None:
    """Left above text, right above numbers; of a column with both right, as its numbers are."""
    rows = [[page.left("a"), "1", page.left("x")], [page.left("b"), "2", "3"]]
    headings = re.findall(r"<th([^>]*)>(\w+)", page.table(["text", "number", "both"], rows))
    assert headings == [(' class="left"', "text"), ("", "number"), ("", "both")]


def test_curves_without_a_value_are_strict_json() -> None:
    """The moisture of a product that has no mass yet is NaN: null in the page, and the curves after it are there too."""
    series = pd.DataFrame({"time_s": [0.0, 1.0], "overs_kg": [0.0, 0.0], "unders_kg": [0.0, 2.0]})
    series["overs_liquid_m3"], series["unders_liquid_m3"] = 0.0, [0.0, 1e-5]
    run: Any = SimpleNamespace(scene=SimpleNamespace(liquid=SimpleNamespace(density_kg_per_m3=1000.0)))
    later, axes = plt.subplots()
    axes.plot([0.0, 1.0], [1.0, 2.0], label="later")
    body = screen_page._moisture(run, series) + page.curves(later, "later", "Later")
    moisture, after = _strictly(page.text("Title", "Lead", [page.Section("Curves", body)]))
    assert [line["y"] for line in moisture] == [[None, None], [None, pytest.approx(0.5)]]
    assert after == [{"label": "later", "x": [0.0, 1.0], "y": [1.0, 2.0]}]


def test_embedded_json_has_one_writer() -> None:
    """Infinity is null too, a tag inside a text ends no script, and no page writes its JSON another way."""
    text = embedded({"a": (1.5, float("inf")), "b": [{"c": float("-inf")}], "tag": "</script>"})
    assert json.loads(text) == {"a": [1.5, None], "b": [{"c": None}], "tag": "</script>"} and "<" not in text
    assert plots.embedded is embedded
    sources = {
        str(path): path.read_text() for path in (ROOT / "pywet").rglob("*.py") if path.name != "embedded_json.py"
    }
    for name, source in sources.items():
        assert "application/json" not in source or "json.dumps" not in source, name
        assert 'replace("<"' not in source, name
