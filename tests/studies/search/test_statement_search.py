"""Statements as targets: a made-up screening whose sieve decides, the order of runs, the budget, mistakes in the file."""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Sequence
from pathlib import Path

import pytest
import yaml
from typer.testing import CliRunner

from pywet.cli.app import app
from pywet.config.loading import parse
from studies.search import screening_runs, statement_search
from studies.search.statement_question import Place, Search
from studies.search.statement_search import DONE, SPENT, find
from tests.studies.full_scale.made import make
from tests.studies.full_scale.test_campaign import MACHINE
from tests.test_docs import check_shown

ROOT = Path(__file__).parents[3]
DRY = (1, 4, 7, 10, 13, 16)
ASKED = {
    "name": "which sieve", "configuration": str(ROOT / "config"), "statements": [1, 24],
    "turned": {
        "sieve": {"entry": "materials.yaml: feed sieve_diameter_mm value", "values": [200, 195, 190]},
        "film": {"entry": "config.yaml: readings wall_film", "values": ["triangle", "wall"]},
    },
    "seeds": 2,
}  # fmt: skip
RATE = {200.0: 1.0, 195.0: 0.8, 190.0: 0.326}
"""Passage [1/s]: at 190 mm undersize is below 1 % at ln(50)/(0.8 · 0.326) = 15 s, at 200 mm at 4.9 s."""


def asked(**other: object) -> Search:
    return parse(Search, {**ASKED, **other}, "search.yaml")


class Rig:
    """Stores made-up tables in place of runs, and what was asked for."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.calls = folder, []  # type: ignore[var-annotated]

    def measure(self, place: Place, cases: Sequence[int], seeds: Sequence[int]) -> None:
        name = statement_search.name_of(place)
        for case in cases:
            for seed in seeds:
                slower = 0.93 if case == 4 and place["sieve"] == 190.0 else 1.0
                rate = slower * RATE[float(place["sieve"])] * (1.0 + 0.01 * (seed % 2))
                walls = 0.2 if case < 10 or place["film"] == "wall" else 0.3
                make(self.folder / name / "data", case, seed, rate=rate, walls=walls)
                self.calls.append((name, case, seed))


def test_the_sieve_that_makes_the_statements_come_true_survives(tmp_path: Path) -> None:
    """Statement 1 holds at 190 mm only (dry), 24 (walls hold more with POM than with glass) for no film: 0.2 against 0.2 or 0.3.
    A combination one statement behind survives, so with one dry statement all are run moist."""
    rig, question = Rig(tmp_path), asked()
    found = find(question, tmp_path, DRY.__contains__, 1, rig.measure)
    assert found.stopped == DONE and found.runs == len(rig.calls) == 6 * 3 * 2
    assert [case for _, case, _ in rig.calls[:6]] == [1] * 6  # dry ones of all combinations before any other
    assert {seed for _, _, seed in rig.calls[:6]} == {1}
    assert {p["sieve"] for p in found.survivors} == {190.0, 195.0, 200.0}
    verdicts = {statement_search.name_of(p): v for p, v in zip(question.places, found.verdicts, strict=True)}
    assert verdicts["sieve=190,film=triangle"] == {1: "confirmed", 24: "not confirmed"}
    assert verdicts["sieve=200,film=wall"][1] == "not confirmed"
    again = Rig(tmp_path)
    assert find(question, tmp_path, DRY.__contains__, 1, again.measure).runs == 0 and not again.calls


def test_the_command_of_the_page_prints_its_answer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With made-up tables in place of the runs: undersize passes more slowly through the smaller sieves."""

    def measure(self: screening_runs.Runs, place: Place, cases: Sequence[int], seeds: Sequence[int]) -> None:
        for case, seed in itertools.product(cases, seeds):
            make(self.folder / statement_search.name_of(place) / "data", case, seed, rate=float(place["sieve"]) / 200)

    for name in ("config", "examples"):
        (tmp_path / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(screening_runs.Runs, "measure", measure)
    command = "pywet study search examples/calibrations/readings.yaml --out results/calibrations/readings"
    done = CliRunner().invoke(app, command.split()[1:])
    assert done.exit_code == 0, done.output
    check_shown(command, done.stdout)
    assert (tmp_path / "results" / "calibrations" / "readings" / "calibration.json").exists()


def test_what_is_two_statements_behind_is_not_run_moist(tmp_path: Path) -> None:
    """At 190 mm statements 1 and 2 (0.8 mm passes more slowly) hold, at the others neither: these never see a moist case."""
    rig, question = Rig(tmp_path), asked(statements=[1, 2, 24])
    found = find(question, tmp_path, DRY.__contains__, 1, rig.measure)
    assert {p["sieve"] for p in found.survivors} == {190.0}
    assert {name for name, case, _ in rig.calls if case not in DRY} == {
        "sieve=190,film=triangle",
        "sieve=190,film=wall",
    }
    # one seed of cases 1 and 4 for all combinations; the second seed and moist cases for two
    assert found.runs == 6 * 2 + 2 * 2 + 2 * 2 * 2


def test_no_more_runs_than_allowed(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    found = find(asked(most_runs=8), tmp_path, DRY.__contains__, 1, rig.measure)
    assert found.stopped == SPENT and found.runs == len(rig.calls) == 8
    answer = statement_search.described(asked(most_runs=8), found)
    assert not answer["reached"] and answer["sentences"][-1] == "8 runs; most_runs are spent"
    assert "confirmed by no combination: statements 24" in answer["sentences"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"statements": [1, 99]}, "statements to be of 1 to"),
        ({"turned": {"film": {"entry": "config.yaml: readings wall_film", "values": ["sky"]}}},
         "film=sky is no configuration: .*readings.wall_film is 'sky', expected 'triangle', 'part' or 'wall'"),
        ({"turned": {"x": {"entry": "config.yaml: readings walls", "values": [1]}}}, "key readings.walls is not known"),
        ({"turned": {"x": {"entry": "cases.csv: case", "values": [1]}}}, "turned.x.entry"),
    ],
)  # fmt: skip
def test_mistakes_are_sentences_before_anything_runs(tmp_path: Path, change: dict[str, object], words: str) -> None:
    file = tmp_path / "search.yaml"
    file.write_text(yaml.safe_dump({**ASKED, **change}))
    done = CliRunner().invoke(app, ["study", "search", str(file), "--out", str(tmp_path / "out")])
    assert done.exit_code == 1
    assert re.search(words, " ".join(done.output.split())), done.output


def test_each_combination_has_a_configuration(tmp_path: Path) -> None:
    """At full scale with the campaign's springs for the aperture, 0.1 and 0.03 of the paper's."""
    runs = screening_runs.Runs(asked(), ROOT / "config", tmp_path)
    place = {"sieve": 185.0, "film": "wall"}
    for aperture, stiffness in ((8.0, 0.1), (5.6, 0.03)):
        made = runs.configured(place, aperture)
        assert made.scale("full").stiffness_factor.value == stiffness and made.scale("full").asked_width_mm == 185
        assert made.settings.readings.wall_film == "wall"


@pytest.mark.slow
@pytest.mark.engine
def test_runs_of_a_search_are_stored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A dry case at the smoke scale, whose 1.4 s of screening judge no statement of 20 s; the second call runs nothing."""
    monkeypatch.setattr(screening_runs, "calibrated", lambda _: MACHINE)  # predicted times are not tested here
    file = tmp_path / "search.yaml"
    turned = {"stroke": {"entry": "config.yaml: readings amplitude", "values": ["peak_to_peak"]}}
    file.write_text(yaml.safe_dump({**ASKED, "scale": "smoke", "statements": [1], "turned": turned, "seeds": 1}))
    for runs in (1, 0):
        answer = statement_search.calibrate(file, tmp_path / "out")
        assert answer["runs"] == runs and answer["reached"]
    stored = json.loads((tmp_path / "out" / "stroke=peak_to_peak" / "data" / "case01-10007" / "run.json").read_text())
    assert stored["combination"] == "stroke=peak_to_peak" and stored["statements"] == answer["statements_digest"]
