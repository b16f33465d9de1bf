#!/usr/bin/env python3
"""Scores any program's answers to a wet benchmark problem; needs nothing but Python.

python score.py PROBLEM FILE.csv        score answers: columns case, quantity, at, value
python score.py PROBLEM --template      an empty CSV of what is asked
python score.py all FOLDER              all problems: FOLDER holds PROBLEM.csv of each

Each answer is compared with the true one: its deviation relative to the largest answer of the same quantity and case, its class
(exact: within the uncertainty of the true answer; 1 %, 10 %, worse), and its rank among the programs of scores.csv.
Exit code: 0 all is answered within the tolerance (--within, a tenth), 1 something is not, 2 the file cannot be scored.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import math
import os
import stat
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
COLUMNS = ["case", "quantity", "at", "value"]
VERSION = "1.2"
SAME = 1e-2
"""Relative difference up to which a row's `at`, which may be rounded, is the one that was asked for."""
WITHIN = 0.1
"""Deviation over the largest answer up to which a problem counts as solved, unless --within names another."""
CLASSES = ((0.01, "1 %"), (0.1, "10 %"))
"""Largest deviation of a class, and its name."""
UNITS = (-1.0, 1e3, 1e-3, 1e6, 1e-6, 1e9, 1e-9, 100.0, 0.01, 180.0 / math.pi, math.pi / 180.0)
"""Factors by which answers of the other sign or in another unit (mN, mm, per cent, radian) are off."""
FEW, APART = 0.2, 0.5
"""Relative distance of the median of the ratios from such a factor, and of each of them, up to which it is taken for it."""


MOST_B = 200_000_000
"""Largest file of answers that is read."""
LARGEST = 1e100
"""Largest number of an answer: squares of it are numbers as well."""
WORDS = 200
"""Longest piece of an input that a message repeats."""


class Refused(Exception):
    """Error that the given file cannot be scored."""


def printable(given: object) -> str:
    """Return a text as a message can contain it: on one line, printable, not long."""
    text = "".join(c if c.isprintable() else repr(c)[1:-1] for c in str(given))
    return text if len(text) <= WORDS else f"{text[:WORDS]}…"


def problems() -> list[str]:
    """Names of all problems."""
    return sorted(path.parent.name for path in HERE.glob("*/answers.json"))


def load(problem: str) -> dict:
    """Answers of a problem."""
    if problem not in problems():
        raise Refused(f"problem {printable(problem)} was given; expected one of {', '.join(problems())}")
    return json.loads((HERE / problem / "answers.json").read_text())


def template(problem: str) -> str:
    """An empty table of what is asked."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(COLUMNS)
    rows.writerows((a["case"], a["quantity"], repr(a["at"]), "") for a in load(problem)["answers"])
    return text.getvalue()


def read(path: Path) -> list[dict]:
    """Rows of a CSV file of answers; a value that is left empty counts as not answered."""
    expected = f"expected a CSV file with {', '.join(COLUMNS)}"
    try:
        found = os.stat(path)
        if not stat.S_ISREG(found.st_mode) or found.st_size > MOST_B:
            what = f"has {found.st_size} bytes" if stat.S_ISREG(found.st_mode) else "is no regular file"
            raise Refused(f"{printable(path)} {what}; {expected}, of at most {MOST_B // 10**6} MB")
        with open(path, newline="", encoding="utf-8-sig") as file:
            table = csv.DictReader(file, strict=True)
            names = table.fieldnames or []
            if not all(names.count(column) == 1 for column in COLUMNS):
                raise Refused(
                    f"{printable(path)} has the columns {printable(', '.join(names)) or 'none'}; "
                    f"expected {', '.join(COLUMNS)}, each once, separated by commas"
                )
            rows = list(table)
    except (OSError, UnicodeDecodeError, ValueError, csv.Error) as error:
        raise Refused(f"{printable(path)} cannot be read ({printable(error)}); {expected}") from None
    for number, row in enumerate(rows, 2):
        where = f"{printable(path)}, row {number}"
        if row["value"] is None:
            raise Refused(
                f"{where} has no cell for each of {', '.join(COLUMNS)}; expected one, empty where there is no answer"
            )
        if not row["value"].strip():
            continue
        try:
            at, value = float(row["at"]), float(row["value"])
        except (TypeError, ValueError):
            given = f"at {printable(repr(row['at']))}, value {printable(repr(row['value']))}"
            raise Refused(f"{where}: {given}; expected numbers") from None
        if not (abs(at) <= LARGEST and abs(value) <= LARGEST):  # false for NaN
            raise Refused(f"{where}: {value} at {at}; expected finite numbers, at most {LARGEST:g}")
        row["at"], row["value"] = at, value
    return [row for row in rows if not isinstance(row["value"], str)]


def scored(problem: str, rows: list[dict]) -> list[dict]:
    """One line for each quantity of each case."""
    asked = load(problem)["answers"]
    values = _matched(problem, asked, rows)
    lines = []
    factors = {
        name: _unit_factor(
            [(values[_key(a)], a["value"]) for a in asked if a["quantity"] == name and _key(a) in values]
        )
        for name in {a["quantity"] for a in asked}
    }
    for case, quantity in dict.fromkeys((a["case"], a["quantity"]) for a in asked):
        of = [a for a in asked if (a["case"], a["quantity"]) == (case, quantity)]
        scale = max(abs(a["value"]) for a in of) or 1.0
        errors = [(values[_key(a)] - a["value"], a) for a in of if _key(a) in values]
        lines.append(
            {
                "case": case,
                "quantity": quantity,
                "tier": of[0]["tier"],
                "asked": len(of),
                "answered": len(errors),
                "largest": max((abs(e) / scale for e, _ in errors), default=math.nan),
                "rms": math.sqrt(sum((e / scale) ** 2 for e, _ in errors) / len(errors)) if errors else math.nan,
                "uncertainty": max(a["uncertainty"] for a in of) / scale,
                "within": sum(abs(e) <= a["uncertainty"] for e, a in errors),
                "unit": of[0]["unit"],
                "factor": factors[quantity],
            }
        )
    return lines


def _key(answer: dict) -> tuple:
    return answer["case"], answer["quantity"], answer["at"]


def _matched(problem: str, asked: list[dict], rows: list[dict]) -> dict:
    """Value by what was asked; a row that was not asked for, or asked once and answered twice, is refused."""
    places: dict = {}
    for a in asked:
        places.setdefault((a["case"], a["quantity"]), []).append(a["at"])
    values: dict = {}
    for row in rows:
        name = row["case"], row["quantity"]
        what = f"case {printable(row['case'])}, quantity {printable(row['quantity'])}"
        if name not in places:
            raise Refused(f"{what} is not asked for by {problem}: see --template")
        at = min(places[name], key=lambda place: abs(place - row["at"]))
        if abs(at - row["at"]) > SAME * abs(at) + 1e-15:
            where = ", ".join(f"{place:g}" for place in places[name])
            raise Refused(f"{what} at {row['at']:g} is not asked for by {problem}; expected at {where}")
        if (*name, at) in values:
            raise Refused(f"{what} at {row['at']:g} is answered twice; expected one row for each")
        values[(*name, at)] = row["value"]
    return values


def _unit_factor(pairs: list[tuple[float, float]]) -> float | None:
    """The factor by which all answers to a quantity are off alike, as in another unit; None where there is none."""
    ratios = sorted(given / true for given, true in pairs if true and given)
    for f in UNITS if ratios else ():
        if abs(ratios[len(ratios) // 2] / f - 1.0) < FEW and all(abs(r / f - 1.0) < APART for r in ratios):
            return f
    return None


def grade(line: dict) -> str:
    """Class of a line: exact, 1 %, 10 %, worse; partial or none where answers are missing."""
    if line["answered"] < line["asked"]:
        return "partial" if line["answered"] else "none"
    if line["within"] == line["asked"]:
        return "exact"
    return next((name for limit, name in CLASSES if line["largest"] <= limit), "worse")


def solved(lines: list[dict], within: float) -> bool:
    """Return whether all is answered, each within the tolerance or its own uncertainty."""
    return all(
        line["answered"] == line["asked"] and (line["largest"] <= within or line["within"] == line["asked"])
        for line in lines
    )


def rank(problem: str, lines: list[dict]) -> str:
    """Place among the stored programs that answer all, by the largest deviation; empty where it cannot be had."""
    stored = HERE / "scores.csv"
    if not stored.exists() or any(line["answered"] < line["asked"] for line in lines):
        return ""
    worst: dict = {}
    with open(stored, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if row["problem"] == problem:
                whole = row["answered"] == row["asked"]
                off = float(row["largest"]) if whole and row["largest"] else math.inf
                worst[row["program"]] = max(worst.get(row["program"], 0.0), off)
    largest_error = max(line["largest"] for line in lines)
    better = [name for name, off in worst.items() if off < largest_error]
    return f"rank {len(better) + 1} of {len(worst) + 1} with the stored programs" if worst else ""


def verdict(problem: str, lines: list[dict], within: float) -> str:
    """The first line of a score: whether it is solved, how far off, the rank."""
    answered, asked = (sum(line[key] for line in lines) for key in ("answered", "asked"))
    worst = max((line["largest"] for line in lines if line["answered"]), default=None)
    off = "" if worst is None else f", largest deviation {_percent(worst)} %"
    how = "solved" if solved(lines, within) else "not solved"
    place = rank(problem, lines)
    return f"{problem}: {how} within {100 * within:g} %; {answered} of {asked} answered{off}{'; ' * bool(place)}{place}"


def show(problem: str, lines: list[dict], within: float) -> None:
    """The verdict, what looks like another unit, and the table."""
    print(verdict(problem, lines, within))
    for quantity, line in {line["quantity"]: line for line in lines if line["factor"]}.items():
        how = "have the other sign" if line["factor"] < 0 else f"are about {line['factor']:.4g} times the true ones"
        unit = line["unit"] if line["unit"] != "1" else "no unit (a ratio)"
        print(
            f"{quantity}: the answers {how}; expected values in {unit}, with the sign that the problem's README.md names"
        )
    wide, long = (max(len(line[key]) for line in lines) + 2 for key in ("case", "quantity"))
    wide, long = max(wide, 26), max(long, 22)
    print(
        f"{'case':<{wide}}{'quantity':<{long}}{'tier':<9}{'answered':>9}{'largest %':>11}{'rms %':>9}{'known to %':>12}  class"
    )
    for line in lines:
        print(
            f"{line['case']:<{wide}}{line['quantity']:<{long}}{line['tier']:<9}{line['answered']:>4}/{line['asked']:<4}"
            f"{_percent(line['largest']):>11}{_percent(line['rms']):>9}{_percent(line['uncertainty']):>12}  {grade(line)}"
        )
    print(
        "\nlargest, rms: deviations over the largest true answer of the line; known to: uncertainty of the true answers, likewise"
    )
    print(
        "class: exact (each within its uncertainty), 1 %, 10 % or worse by the largest; partial, none: answers are missing"
    )


def _percent(value: float) -> str:
    return "–" if math.isnan(value) else f"{100 * value:.0f}" if value >= 0.1 else f"{100 * value:.2g}"


def everything(folder: Path, within: float, as_json: bool) -> int:
    """All problems of which the folder holds answers, a line each; those without a file count as not solved."""
    files = {problem: folder / f"{problem}.csv" for problem in problems()}
    there = {problem: path for problem, path in files.items() if path.exists()}
    if not there:
        raise Refused(f"{printable(folder)} holds no answers; expected files such as {next(iter(files.values()))}")
    if others := sorted(path.name for path in folder.glob("*.csv") if path.stem not in files):
        print(f"not read, since no problem has that name: {printable(', '.join(others))}", file=sys.stderr)
    scores = {problem: scored(problem, read(path)) for problem, path in there.items()}
    count = sum(solved(lines, within) for lines in scores.values())
    if as_json:
        print(json.dumps({"version": VERSION, "solved": count, "problems": {p: _json(s) for p, s in scores.items()}}))
    else:
        print(f"{count} of {len(files)} problems solved within {100 * within:g} % (score.py {VERSION})")
        for problem in files:
            print(
                verdict(problem, scores[problem], within) if problem in scores else f"{problem}: no file {problem}.csv"
            )
    return 0 if count == len(files) else 1


def _json(lines: list[dict]) -> list[dict]:
    return [{k: None if v != v else v for k, v in line.items()} | {"class": grade(line)} for line in lines]


def main(given: list[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("problem", help=f"all, or one of {', '.join(problems())}")
    parser.add_argument("file", nargs="?", type=Path, help="answers; of all problems their folder")
    parser.add_argument("--template", action="store_true", help="print an empty CSV of what is asked")
    parser.add_argument("--json", action="store_true", help="print the score as JSON")
    parser.add_argument("--within", type=float, default=WITHIN, help="tolerance of a solved problem, a share (0.1)")
    parser.add_argument("--version", action="version", version=f"score.py {VERSION}")
    options = parser.parse_args(given)
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")  # a terminal without UTF-8
    try:
        if not 0 <= options.within < math.inf:
            raise Refused(f"--within is {options.within}; expected a share from 0, such as {WITHIN}")
        return _asked(options)
    except Refused as refusal:
        print(refusal, file=sys.stderr)
    except BrokenPipeError:  # the reader of the pipe has closed it
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (OSError, MemoryError) as error:
        print(
            f"{printable(error) or 'no memory'}; expected files that can be read and memory for them", file=sys.stderr
        )
    return 2


def _asked(options: argparse.Namespace) -> int:
    if options.template:
        print(template(options.problem), end="")
        print(f"the problem in words: {HERE / options.problem / 'README.md'}", file=sys.stderr)
        return 0
    if options.problem != "all":
        load(options.problem)
    if options.file is None:
        raise Refused("no file was given; expected a CSV file of answers, or --template")
    if options.problem == "all":
        return everything(options.file, options.within, options.json)
    lines = scored(options.problem, read(options.file))
    if options.json:
        print(json.dumps({"problem": options.problem, "version": VERSION, "score": _json(lines)}, indent=2))
    else:
        show(options.problem, lines, options.within)
    return 0 if solved(lines, options.within) else 1


if __name__ == "__main__":
    sys.exit(main())
