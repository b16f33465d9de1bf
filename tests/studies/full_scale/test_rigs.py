"""Other dimensions of the rig: what is written into the configuration, and which ranges judged the stored runs."""

from __future__ import annotations

import csv
import json
import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from pywet import config as settings
from pywet.cases.screening import cases
from pywet.errors import PywetError
from studies.full_scale import campaign, page, rig_sentences, rigs
from studies.full_scale.judging import Part, Statement, above, below, decide, each, fingerprint, judge, refuted
from studies.full_scale.quantities import through
from studies.full_scale.statements import EARLIER, STATEMENTS
from studies.full_scale.stored_runs import mean, variants
from tests.studies.full_scale.test_campaign import MACHINE

ROOT = Path(__file__).parents[3]
FOUND = variants(ROOT / rigs.DATA)


def test_a_rig_is_in_its_configuration(tmp_path: Path) -> None:
    """The cloth's diameter and the vertical amplitudes, at the campaign's settings, with spheres taken out."""
    folder = rigs.configure(ROOT / "config", tmp_path, "sieve190_amplitude80", 8.0)
    made = settings.load(folder)
    assert cases.apparatus_spec(made, made.case(1), made.scale("full")).width_m == pytest.approx(0.190)
    assert made.materials.feed.sieve_diameter_mm.value == 190.0
    assert made.materials.stroke(1.0).z_amplitude_mm.value == pytest.approx(0.72)
    assert made.materials.stroke(0.8).z_amplitude_mm.value == pytest.approx(0.576)
    assert made.scale("full").stiffness_factor.value == 0.1 and made.settings.time_step.fraction.value == 0.1
    assert made.settings.retire is True
    stiff = settings.load(rigs.configure(ROOT / "config", tmp_path, "sieve180_stiff", 8.0))
    assert stiff.scale("full").stiffness_factor.value == 1.0
    assert settings.load(rigs.configure(ROOT / "config", tmp_path, rigs.ALL, 8.0)).settings.retire is False


def test_an_unknown_rig_is_refused(tmp_path: Path) -> None:
    with pytest.raises((PywetError, typer.Exit), match="no rig sieve10"):
        rigs.run(["sieve10"], out=tmp_path)


def test_the_command_that_the_page_names_repeats_a_stored_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With another folder for tables case 2 has a run to do; without it that run is stored."""
    found: list[tuple[int, int, bool]] = []

    class Listed(campaign.Campaign):
        def run(self) -> list[campaign.Job]:
            found.extend((job.number, job.seed, job.done) for job in self.jobs)
            return []

    monkeypatch.setattr(rigs, "Campaign", Listed)
    monkeypatch.setattr(rigs, "calibrated", lambda: MACHINE)
    assert page.AGAIN in " ".join((ROOT / "docs/full_scale.md").read_text().split())
    words = page.AGAIN.strip("`").split()
    assert words[:3] == ["python", "-m", "studies.full_scale.rigs"]
    named = {"N": "2", "S": "10007", "FOLDER": str(tmp_path / "tables")}
    arguments = [*(named.get(word, word) for word in words[3:]), "--out", str(tmp_path)]
    for given in (arguments, arguments[: arguments.index("--data")] + arguments[-2:]):
        assert CliRunner().invoke(rigs.app, given).exit_code == 0
    assert found == [(2, 10007, False), (2, 10007, True)]


@dataclass(frozen=True)
class Number:
    """A run with one number."""

    seed: int
    value: float

    @property
    def about(self) -> dict[str, Any]:
        return {"seed": self.seed}


def test_a_statement_is_refuted_by_one_part_outside_its_range() -> None:
    """Case 2 of three seeds scatters by 0.1, of which the 95 % limit for one run is 0.43: 1.5 refutes `> 2`, 1.6 does not."""
    statement = Statement(
        0,
        "",
        "",
        (1, 2),
        (above("a", 0.0, lambda c: c[1].value), above("b", 2.0, lambda c: c[2].value)),  # type: ignore[attr-defined]
    )
    seeds: Any = {2: [Number(k, 3.0 + 0.1 * k) for k in range(3)]}
    for value, refutes in ((1.5, 1), (1.6, None)):
        assert refuted(statement, {2: [Number(0, value)]}, seeds) == refutes  # type: ignore[list-item]
    # the mean of four seeds has half the interval of one: 1.7 refutes `> 2` by it alone
    assert refuted(statement, {2: [Number(0, 1.7)]}, seeds) is None  # type: ignore[list-item]
    assert refuted(statement, {2: [Number(k, 1.7) for k in range(4)]}, seeds) == 1  # type: ignore[misc]
    assert refuted(statement, {1: [Number(0, -1.0)]}, seeds) is None  # type: ignore[list-item]  # no scatter is known


def test_a_time_that_some_seeds_never_reach_decides_nothing() -> None:
    """Times of 1, 2 and inf leave `< 5` inconclusive; three infinite ones refute it, three of 1, 2 and 3 confirm `< 8`."""
    for values, limit, verdict in (
        ((1.0, 2.0, math.inf), 5.0, "inconclusive"),
        ((math.inf,) * 3, 5.0, "not confirmed"),
        ((1.0, 2.0, 3.0), 8.0, "confirmed"),
    ):
        runs: Any = {1: [Number(k, value) for k, value in enumerate(values)]}
        statement = Statement(0, "", "", (1,), (below("time", limit, lambda c: c[1].value),))  # type: ignore[attr-defined]
        assert judge(statement, runs).verdict == verdict


def test_stored_runs_were_judged_by_the_ranges_of_today() -> None:
    """The digest of all statements that each run stored as it ended is that of the statements, or that before pegging was."""
    runs = [json.loads(path.read_text()) for path in (ROOT / rigs.DATA).glob("*/run.json")]
    assert len(runs) >= 7
    assert {run["statements"] for run in runs} <= {EARLIER, fingerprint(STATEMENTS)}
    assert {run["variant"] for run in runs} <= set(rigs.RIGS)


def test_the_table_holds_what_a_rig_decides() -> None:
    """Statement 1 at 185 and 190 mm by hand from the stored curve: the time at which less than 1 % is left."""
    columns, rows = rigs.values(FOUND)
    (row,) = [row for row in rows if row[0] == 1 and row[1] != "verdict"]
    cells = dict(zip(columns, row, strict=True))
    for rig in ("sieve185", "sieve190"):
        by_hand = [run.times[(run.undersize < 0.01).argmax()] for run in FOUND[rig][1]]
        assert float(str(cells[rig]).partition(" ")[0]) == pytest.approx(sum(by_hand) / len(by_hand), abs=0.11)


def test_the_page_is_made_of_the_stored_tables() -> None:
    """docs/rig.md and its two tables, the signs of its verdicts, and the times that its first lines name."""
    assert (ROOT / rigs.PAGE).read_text() == rigs.text(FOUND)
    ordered = dict(sorted(FOUND.items()))
    for name, (columns, rows) in (
        ("undersize", rigs.curves(ordered)),
        ("statements", rigs.values(rigs.whole(ordered))),
    ):
        with open(ROOT / "docs/full_scale" / f"rig_{name}.csv", encoding="utf-8") as file:
            assert [*csv.reader(file)] == [columns, *([str(cell) for cell in row] for row in rows)]
    answers = {s.number: judge(s, FOUND["sieve185"]).verdict for s in STATEMENTS if s.cases}
    column = rigs.PRESETS.index("sieve185")
    for line in rigs.verdicts(rigs.whole(ordered))[2:]:
        number, *signs = [cell.strip() for cell in line.strip("|").split("|")]
        assert rigs.SIGNS[answers[int(number)]] == signs[column]


def test_when_passage_ends_on_each_diameter() -> None:
    """The page's times, by hand from the stored curves of case 1, mean over seeds."""
    sentence = rig_sentences.of_diameters(rigs.whole(FOUND))
    for rig in ("sieve190", "sieve185", "sieve180"):
        # an output at or above 1 % ends before the next
        times = [run.times[(run.undersize >= 0.01).nonzero()[0][-1] + 1] for run in FOUND[rig][1]]
        assert f"**{rig.removeprefix('sieve')} mm** after {sum(times) / len(times):.1f} s" in sentence
    assert "**150 mm** not within 20 s" in sentence


def test_what_the_page_says_of_its_presets_and_of_statements_that_no_run_confirms() -> None:
    """Counts of both; each range shown is missed on 200 mm; all readings refute 7 and 17, 17 by a negative value."""
    runs = rigs.whole(FOUND)
    sentences = rig_sentences.of_presets(runs, rigs.PRESETS)
    for name in rigs.PRESETS:
        verdicts = [judge(s, runs[name]).verdict for s in STATEMENTS if s.cases]
        assert (
            len(verdicts) == 37
            and (
                f"{verdicts.count('confirmed')} are confirmed, {verdicts.count('not confirmed')} are not, "
                f"{verdicts.count('inconclusive')} are inconclusive"
            )
            in sentences
        )
        left = [100.0 * mean(runs[name][case], lambda run: run.at(run.undersize, 20.0)) for case in (7, 16)]
        assert (
            "{:.0f} % of the undersize of dry POM and {:.0f} % of that of dry glass are left".format(*left) in sentences
        )
    first = {case: min(run.about["seed"] for run in found) for case, found in runs["sieve200"].items()}
    assert first == dict.fromkeys(range(1, 19), 10007)  # of a case without all seeds here the full-scale page's
    _, none = rigs.any_reading(runs)
    parts = {part.range.replace("|", "&#124;"): part for s in STATEMENTS for part in s.parts if s.number in none}
    missed = [
        part
        for s, answer in ((s, judge(s, runs["sieve200"])) for s in STATEMENTS if s.number in none)
        for part, values, half in zip(s.parts, answer.values, answer.uncertainty, strict=True)
        if decide(part, sum(values) / len(values), half) != "confirmed"
    ]
    impossible, dry = [], ""
    for line in rigs.impossible(runs, none)[2:]:
        number, range_, here, _, verdict = (cell.strip() for cell in line.strip("|").split(" | "))
        assert parts[range_] in missed and here.startswith(f"{mean_of(parts[range_], runs):.4g}"), line
        impossible += [int(number)] if verdict.startswith("yes") else []
        dry = verdict if number == "5" else dry
    assert impossible == [7, 17]
    # readings of bridges share the dry runs of 200 mm, which count once
    assert int(re.search(r"of (\d+)\)", dry)[1]) <= 1 + len(rigs.TURNED) - len(rigs.OF_BRIDGES)  # type: ignore[index]
    lags = [each(parts["mean Y_small − Y_near, 1 to 5 s > 0"], runs[rig]) for rig in ("sieve200", *rigs.TURNED)]
    assert len(lags) == 14 and all(values and max(values) < -0.09 for values in lags)


def mean_of(part: Part, runs: dict[str, Any]) -> float:
    """Mean over seeds of a number on 200 mm."""
    values = each(part, runs["sieve200"])
    return sum(values) / len(values)


def test_what_equation_14_as_printed_gains_and_loses() -> None:
    """Statements confirmed by one reading only, and the end of passage in case 2, both on 185 mm."""
    both = rigs.with_dry({rig: FOUND[rig] for rig in ("sieve185", "sieve185_printed")})
    corrected, printed = (
        {s.number: judge(s, both[rig]).verdict for s in STATEMENTS if s.cases}
        for rig in ("sieve185", "sieve185_printed")
    )
    sentence = rig_sentences.of_printed_force(both, "sieve185")
    gained, lost = (
        [int(n) for n in part.strip(" .").split(", ") if n != "none"]
        for part in sentence.partition("in addition:")[2].split("; no longer:")
    )
    for numbers, here, there in ((gained, printed, corrected), (lost, corrected, printed)):
        assert numbers and all(here[n] == "confirmed" != there[n] for n in numbers)
    assert "confirmed" not in {printed[n] for n in (7, 12, 17, 21, 26)}
    printed_s, corrected_s = (
        sum(through({2: run}, 2, 0.01) for run in FOUND[rig][2]) / len(FOUND[rig][2])
        for rig in ("sieve185_printed", "sieve185")
    )
    assert f"after {printed_s:.1f} s" in sentence and f"instead of after {corrected_s:.1f} s" in sentence


def test_what_films_of_whole_walls_gain() -> None:
    """Liquid of the apparatus over that of the coarse material at the end of case 2."""
    (statement,) = (s for s in STATEMENTS if s.number == 26)
    wide = {2: FOUND["sieve200"][2]}
    runs = (wide, FOUND["sieve200_wall"], FOUND["sieve185"], FOUND["sieve185_wall"])
    answers = [judge(statement, run) for run in runs]
    assert [a.verdict for a in answers] == ["not confirmed", "confirmed", "not confirmed", "not confirmed"]
    values = [f"{sum(a.values[0]) / len(a.values[0]):.2f}" for a in answers]
    sentence = rig_sentences.of_walls(rigs.whole(FOUND), rigs.PRESETS)
    assert "from {} to {} on 200 mm, from {} to {} on 185 mm".format(*values) in sentence
    assert "statement 26 is confirmed, statement 30 not confirmed" in sentence


def test_the_page_names_the_statements_that_any_run_confirms() -> None:
    """Every statement is in one of three groups: confirmed by the default, by a reading, by none."""
    rigs_and_dry = rigs.whole(FOUND)
    any_run = {s.number: {judge(s, runs).verdict for runs in rigs_and_dry.values()} for s in STATEMENTS if s.cases}
    sentence = next(
        line for line in (ROOT / rigs.PAGE).read_text().splitlines() if "the full-scale page confirm" in line
    )
    none = {int(n) for n in sentence.partition("No run confirms ")[2].rstrip(".").split(", ")}
    assert none == {n for n, verdicts in any_run.items() if "confirmed" not in verdicts}
    gained = {int(n) for n in sentence.partition("paper: ")[2].partition(". No run")[0].split(", ")}
    shipped = {s.number for s in STATEMENTS if s.cases and judge(s, rigs_and_dry["sieve200"]).verdict == "confirmed"}
    assert gained == set(any_run) - none - shipped
    assert f"confirm {len(shipped)}; {len(gained)} others" in sentence


def test_more_seeds_on_200_mm_decide_statements_7_and_8() -> None:
    """Three seeds confirm 8 with small differences; six of case 1 and 2 leave none for 7."""
    (eighth,) = (s for s in STATEMENTS if s.number == 8)
    of_amplitude = judge(eighth, FOUND["sieve200"])
    assert of_amplitude.verdict == "confirmed" and [len(v) for v in of_amplitude.values] == [3, 3]
    (statement,) = (s for s in STATEMENTS if s.number == 7)
    answer = judge(statement, FOUND["sieve200"])
    campaign = judge(statement, variants(ROOT / rigs.CAMPAIGN)[""])
    assert (campaign.verdict, answer.verdict) == ("inconclusive", "not confirmed")
    first = answer.values[0]
    assert len(first) == 6 and max(map(abs, first)) < 0.005  # the least that the statement asks


def test_what_other_cases_say_of_films_of_whole_walls_and_of_equation_14() -> None:
    """Verdicts of the page on 200 mm: cases 2, 3 and 11 with films of whole walls, 3 and 12 with equation (14) as printed."""
    walls = {s.number: judge(s, FOUND["sieve200_wall"]) for s in STATEMENTS if s.cases}
    assert {walls[n].verdict for n in (23, 24, 25, 26, 29, 31)} == {"confirmed"}
    assert {walls[n].verdict for n in (17, 30)} == {"not confirmed"} and f"{walls[30].values[0][0]:.3f}" == "0.994"
    printed = rigs.with_dry({rig: FOUND[rig] for rig in ("sieve200", "sieve200_printed")})["sieve200_printed"]
    assert "confirmed" not in {judge(s, printed).verdict for s in STATEMENTS if s.number in (17, 21)}
