"""The words of the report: its template, the labels of rows and columns, headings, axes and legends, as stored.

`python -m tests.report.test_template` writes tests/data/report.txt again, to be read before it is committed. In it a number is
the name of its key, so that no value of a run is stored but those in sentences of the audit.
"""

from __future__ import annotations

import html
import json
import re
import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

from pywet.util.files import write_json
from tests.reference_impl.test_report import made, with_seeds, written

STORED = Path(__file__).parent.parent / "data" / "report.txt"
LAW = {"effect": "capillary", "law": "/home/somebody/my_law.py:neck", "instead": "taken as logged"}
WORDS = ("label.", "figure.", "cross_check.outcome", "cross_check.liquid")
"""Keys whose texts are words."""


def reports(root: Path) -> dict[str, Path]:
    """Reports that have every sentence of the template."""
    several = made(root / "several", (1, 2, 4, 5))
    found = {"two configurations": written(several, cases=(1, 2, 4, 5))}
    seeds = with_seeds(several, root / "seeds")
    for run in ("case01-8", "case02-10", "case02_exact-9", "case02_exact-10"):
        shutil.copytree(seeds / "case02-8", seeds / run)
    replay = seeds / "case02" / "replay.json"
    write_json(
        replay, {**json.loads(replay.read_text()), "unchecked": [LAW], "nothing_compared": ["contacts: there is none"]}
    )
    status = seeds / "case01" / "status" / "simulate.json"
    write_json(status, {**json.loads(status.read_text()), "ok": False, "reason": "LIGGGHTS stopped"})
    found["one configuration with seeds, full scale"] = written(seeds, cases=(1, 2), scale="full")
    one = made(root / "one", (2, 3))
    write_json(one / "case02" / "replay.json", {"quantities": {}})
    replay = json.loads((one / "case03" / "replay.json").read_text())
    replay["quantities"]["force"]["largest"] = 1.0
    write_json(one / "case03" / "replay.json", replay)
    found["not recomputed"] = written(one, cases=(2, 3))
    return found


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


def rendered(root: Path) -> str:
    """All reports, each line once."""
    lines: dict[str, None] = {}
    for name, page in reports(root).items():
        lines |= dict.fromkeys([f"==== {name}", *words(page)])
    return "\n".join(lines) + "\n"


def test_every_word_of_the_report_is_as_stored(tmp_path: Path) -> None:
    assert rendered(tmp_path) == STORED.read_text()


if __name__ == "__main__":
    with TemporaryDirectory() as folder:
        STORED.write_text(rendered(Path(folder)))
