"""The words of the report: its template, the labels of rows and columns, headings, axes and legends, as stored.

`python -m tests.report.test_template` writes tests/data/report/ again, to be read before it is committed. In it a number is
the name of its key, so that no value of a run is stored but those in sentences of the audit.
"""

from __future__ import annotations

import html
import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from pywet import config as settings
from pywet.util.files import write_json
from tests.reference_impl.test_report import ROOT, made, read, with_seeds, written

STORED = Path(__file__).parent.parent / "data" / "report"
LAW = {"effect": "capillary", "law": "/home/somebody/my_law.py:neck", "instead": "taken as logged"}
FORCE = {"scale": "itself", "count": 3, "largest": 1e-13, "median": 1e-16, "tolerance": 1e-9}
WORDS = ("label.", "figure.", "cross_check.outcome", "cross_check.liquid")
"""Keys whose texts are words."""


def several(folder: Path) -> Path:
    """Two configurations, dry and moist, and a case by two presets."""
    return written(folder, cases=(1, 2, 4, 5))


def seeds(folder: Path) -> Path:
    """One configuration at full scale with seeds; one case stopped, the other was checked in part."""
    root, config = with_seeds(folder, folder.parent / "seeds"), settings.load(ROOT / "config")
    for run in ("case01-8", "case02-10", "case02_exact-9", "case02_exact-10"):
        shutil.copytree(root / "case02-8", root / run)
    for case in (1, 2):
        write_json(root / f"case{case:02d}" / "config.json", config.resolved(case, "full"))
    for run in root.glob("case*-*"):
        first = root / run.name.rpartition("-")[0]
        shutil.copytree(first / "status", run / "status")
        for path in first.glob("[rs]*y.json"):  # summary and replay
            shutil.copy(path, run)
    _changed(root / "case02" / "replay.json", unchecked=[LAW], nothing_compared=["contacts: there is none"])
    _changed(root / "case01" / "status" / "simulate.json", ok=False, reason="LIGGGHTS stopped")
    return written(root, cases=(1, 2), scale="full")


def not_recomputed(folder: Path) -> Path:
    """One case that was not replayed and one on which the replay disagrees."""
    root = Path(shutil.copytree(folder, folder.parent / "moist"))
    _changed(root / "case02" / "replay.json", quantities={})
    _changed(root / "case05" / "replay.json", quantities={"force": {**FORCE, "largest": 1.0}})
    return written(root, cases=(2, 5))


REPORTS = (several, seeds, not_recomputed)
"""Reports that have every sentence of the template."""


def _changed(path: Path, **values: object) -> None:
    write_json(path, {**json.loads(path.read_text()), **values})


def words(page: Path) -> list[str]:
    """The words of a page line by line, with the keys of its numbers, and the words of its figures."""
    numbers = json.loads(page.with_suffix(".json").read_text())
    text = re.sub(r"<(script|style|svg|title)\b.*?</\1>|<footer>.*?</footer>", "", page.read_text(), flags=re.DOTALL)
    text = re.sub(r'<data value="[^"]*" data-key="([^"]*)">[^<]*</data>', lambda m: _named(m[1], numbers), text)
    text = re.sub(r"</t[dh]>", " | ", re.sub(r"\s*\n\s*", " ", text))
    lines = re.sub(r"</?(?:p|div|section|h\d|tr|li|nav|header|summary)\b[^>]*>", "\n", text)
    shown = [" ".join(html.unescape(re.sub(r"<[^>]*>", "", line)).split()) for line in lines.splitlines()]
    assumed = [line for line in shown if line.startswith("{label.assumption.")]
    figures = [f"{key}: {of['shown']}" for key, of in numbers.items() if key.startswith(("figure.", "label.word."))]
    return [*(line for line in shown if line and line not in assumed[1:]), *figures]


def _named(key: str, numbers: dict[str, dict[str, str]]) -> str:
    return f"{{{key}: {numbers[key]['shown']}}}" if key.startswith(WORDS) else f"{{{key}}}"


def rendered(page: Path) -> str:
    """Words and figures as stored."""
    return "".join(f"{line}\n" for line in words(page))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made(tmp_path_factory.mktemp("words") / "runs", (1, 2, 4, 5))


@pytest.mark.parametrize("report", REPORTS)
def test_every_word_of_the_report_is_as_stored(report: Callable[[Path], Path], folder: Path) -> None:
    page = report(folder)
    assert rendered(page) == (STORED / f"{report.__name__}.txt").read_text()
    assert read(page) == []


if __name__ == "__main__":
    with TemporaryDirectory() as root:
        runs = made(Path(root) / "runs", (1, 2, 4, 5))
        for report in REPORTS:
            (STORED / f"{report.__name__}.txt").write_text(rendered(report(runs)))
