"""Search for readings and dimensions under which the paper's statements are confirmed, `pywet study search`.

Statements are inequalities with the 95 % interval over seeds. Dry cases are run first, then moist ones of the best combinations;
see docs/search-readings.md. There is no fit, because readings are discrete and a screen close to clogging has no smooth response.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from pywet import config as settings
from pywet import run_folder
from pywet.config.loading import parse, read_yaml
from pywet.errors import ConfigError, PywetError
from pywet.util.files import make_folder, write_json
from studies.full_scale import judging
from studies.full_scale.statements import STATEMENTS
from studies.full_scale.stored_runs import variants
from studies.search import screening_runs
from studies.search.statement_question import Place, Search, name_of

MARGIN = 1
"""Number of unconfirmed statements by which a combination may be behind the best and remain."""
DONE, SPENT = "all combinations that survive have been run", "most_runs are spent"
Measure = Callable[[Place, Sequence[int], Sequence[int]], None]
"""Function (combination, cases, missing seeds) that stores their tables."""


class Stage(NamedTuple):
    """Judged statements, the cases that they need, and the number of seeds."""

    statements: list[judging.Statement]
    cases: list[int]
    seeds: int


@dataclass(frozen=True)
class Outcome:
    """The remaining combinations, the verdict on each statement for every combination, finished runs, and the reason for the
    end.
    """

    survivors: list[Place]
    verdicts: list[dict[int, str]]
    runs: int
    stopped: str


def stages(asked: Sequence[judging.Statement], dry: Callable[[int], bool], seeds: int) -> Iterator[Stage]:
    """Yield the stages: dry statements with one seed, then with all seeds; then all statements in the same manner."""
    first = [s for s in asked if all(dry(case) for case in s.cases)]
    for statements in (first, list(asked)):
        cases = sorted({case for s in statements for case in s.cases}, key=lambda c: (not dry(c), c))
        for count in sorted({1, seeds}):
            if statements and (statements == list(asked) or len(first) < len(asked)):
                yield Stage(statements, cases, count)


def find(
    question: Search, folder: Path, dry: Callable[[int], bool], first_seed: int, measure: Measure,
    say: Callable[[str], None] = lambda line: None,
) -> Outcome:  # fmt: skip
    """Run the stages; `measure` leaves tables in `folder`/NAME/data as the campaign does."""
    alive, done = list(question.places), 0
    for stage in stages(question.asked, dry, question.seeds):
        seeds = range(first_seed, first_seed + stage.seeds)
        for k, place in enumerate(alive):
            missing = [(c, s) for s in seeds for c in stage.cases if not _there(folder, place, c, s)]
            if done + len(missing) > question.most_runs:
                return Outcome(alive, [_verdicts(question, folder, p) for p in question.places], done, SPENT)
            say(
                f"{name_of(place)}, {k + 1} of {len(alive)}: {len(missing)} runs, {done} of {question.most_runs} are done"
            )
            for seed in seeds:
                if cases := [c for c, s in missing if s == seed]:
                    measure(place, cases, [seed])
            done += len(missing)
        wrong = [_refuted(_verdicts(question, folder, p), stage.statements) for p in alive]
        alive = [p for p, n in zip(alive, wrong, strict=True) if n <= min(wrong) + MARGIN]
        say(
            f"{len(alive)} of {len(wrong)} combinations survive {len(stage.statements)} statements, seeds {stage.seeds}"
        )
    return Outcome(alive, [_verdicts(question, folder, p) for p in question.places], done, DONE)


def _there(folder: Path, place: Place, case: int, seed: int) -> bool:
    return (folder / name_of(place) / "data" / f"case{case:02d}-{seed}" / "run.json").exists()


def _verdicts(question: Search, folder: Path, place: Place) -> dict[int, str]:
    runs = variants(folder / name_of(place) / "data").get("", {})
    return {s.number: judging.judge(s, runs).verdict for s in question.asked}


def _refuted(verdicts: Mapping[int, str], statements: Sequence[judging.Statement]) -> int:
    return sum(verdicts[s.number] == judging.FAILS for s in statements)


def calibrate(file: Path, folder: Path, say: Callable[[str], None] = lambda line: None) -> dict[str, Any]:
    """Answer a file; writes `calibration.json` into the folder, next to configurations and runs, and returns the answer."""
    question = parse(Search, read_yaml(file, Search), str(file))
    source = file.parent / question.configuration
    base = settings.load(source)
    for statement in question.asked:
        for case in statement.cases:
            base.case(case)
    make_folder(folder)
    runs = screening_runs.Runs(question, source, folder)
    with run_folder.hold_part(folder, "calibrate"):
        for place in question.places:
            try:
                runs.configured(place)
            except PywetError as error:
                raise ConfigError(
                    f"{file}: {name_of(place)} is no configuration: {error}", file=file, key="turned"
                ) from error
        found = find(
            question, folder, lambda c: base.case(c).liquid_percent == 0, base.settings.seed, runs.measure, say
        )  # fmt: skip
        answer = described(question, found)
        write_json(folder / "calibration.json", answer)
    return answer


def described(question: Search, found: Outcome) -> dict[str, Any]:
    """Return the answer as plain data: verdicts of all combinations, survivors, sentences."""
    table = [
        {
            "values": dict(place),
            "survived": place in found.survivors,
            "verdicts": {str(n): v for n, v in message.items()},
        }
        for place, message in zip(question.places, found.verdicts, strict=True)
    ]
    never = [s.number for s in question.asked if not any(v[s.number] == judging.HOLDS for v in found.verdicts)]
    sentences = [_counted(row) for row in table if row["survived"]]
    if never:
        sentences.append(f"confirmed by no combination: statements {', '.join(map(str, never))}")
    sentences.append(f"{found.runs} runs; {found.stopped}")
    return {
        "name": question.name, "statements_digest": judging.fingerprint(STATEMENTS), "combinations": table,
        "confirmed_by_none": never, "runs": found.runs, "stopped": found.stopped, "sentences": sentences,
        "reached": bool(found.survivors) and found.stopped == DONE,
    }  # fmt: skip


def _counted(row: Mapping[str, Any]) -> str:
    counts = Counter(row["verdicts"].values())
    kinds = (judging.HOLDS, judging.OPEN, judging.FAILS, judging.MISSING)
    return f"{name_of(row['values'])}: {', '.join(f'{counts[kind]} {kind}' for kind in kinds if counts[kind])}"
