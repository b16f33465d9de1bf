#!/usr/bin/env python3
"""Scores any program's answers to a wet benchmark problem; needs nothing but Python.

python score.py PROBLEM FILE.csv        score answers: columns case, quantity, at, value
python score.py PROBLEM --template      an empty CSV of what is asked

Each answer is set against the true one: its deviation relative to the largest answer of the same quantity and case, and whether
it lies within the uncertainty that the true answer is known to.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
COLUMNS = ["case", "quantity", "at", "value"]
SAME = 1e-6
"""Relative difference up to which a row's `at` is the place that was asked for."""


class Refused(Exception):
    """What was given cannot be scored."""


def problems() -> list[str]:
    """Names of all problems."""
    return sorted(path.parent.name for path in HERE.glob("*/answers.json"))


def load(problem: str) -> dict:
    """Answers of a problem."""
    if problem not in problems():
        raise Refused(f"problem {problem} was given; expected one of {', '.join(problems())}")
    return json.loads((HERE / problem / "answers.json").read_text())


def template(problem: str) -> str:
    """An empty table of what is asked."""
    rows = [f"{a['case']},{a['quantity']},{a['at']!r}," for a in load(problem)["answers"]]
    return "\n".join([",".join(COLUMNS), *rows]) + "\n"


def read(path: Path) -> list[dict]:
    """Rows of a CSV file of answers; a value that is left empty counts as not answered."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            table = csv.DictReader(file)
            if not set(COLUMNS) <= set(table.fieldnames or []):
                raise Refused(f"{path} has the columns {table.fieldnames}; expected {', '.join(COLUMNS)}")
            rows = [row for row in table if (row["value"] or "").strip()]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise Refused(f"{path} cannot be read ({error}); expected a CSV file with {', '.join(COLUMNS)}") from None
    for number, row in enumerate(rows, 2):
        try:
            row["at"], row["value"] = float(row["at"]), float(row["value"])
        except (TypeError, ValueError):
            raise Refused(f"{path}, row {number}: at {row['at']!r}, value {row['value']!r}; expected numbers") from None
        if not (math.isfinite(row["at"]) and math.isfinite(row["value"])):
            raise Refused(f"{path}, row {number}: {row['value']} at {row['at']}; expected finite numbers")
    return rows


def scored(problem: str, rows: list[dict]) -> list[dict]:
    """One line for each quantity of each case."""
    asked = load(problem)["answers"]
    known = {(a["case"], a["quantity"]) for a in asked}
    for row in rows:
        if (row["case"], row["quantity"]) not in known:
            raise Refused(
                f"case {row['case']}, quantity {row['quantity']} is not asked for by {problem}: see --template"
            )
    lines = []
    for case, quantity in dict.fromkeys((a["case"], a["quantity"]) for a in asked):
        of = [a for a in asked if (a["case"], a["quantity"]) == (case, quantity)]
        scale = max(abs(a["value"]) for a in of) or 1.0
        given = [(a, _at(rows, a)) for a in of]
        errors = [(value - a["value"], a) for a, value in given if value is not None]
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
            }
        )
    return lines


def _at(rows: list[dict], answer: dict) -> float | None:
    """The value that was given where an answer was asked for; the last one counts."""
    near = SAME * abs(answer["at"]) + 1e-15
    values = [
        row["value"]
        for row in rows
        if (row["case"], row["quantity"]) == (answer["case"], answer["quantity"])
        and abs(row["at"] - answer["at"]) <= near
    ]
    return values[-1] if values else None


def main(given: list[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("problem", help=", ".join(problems()))
    parser.add_argument("file", nargs="?", type=Path)
    parser.add_argument("--template", action="store_true", help="print an empty CSV of what is asked")
    parser.add_argument("--json", action="store_true", help="print the score as JSON")
    options = parser.parse_args(given)
    try:
        if options.template:
            print(template(options.problem), end="")
            return 0
        if options.file is None:
            raise Refused("no file was given; expected a CSV file of answers, or --template")
        lines = scored(options.problem, read(options.file))
    except Refused as refusal:
        print(refusal, file=sys.stderr)
        return 2
    if options.json:
        none = [{k: None if v != v else v for k, v in line.items()} for line in lines]
        print(json.dumps({"problem": options.problem, "score": none}, indent=2))
        return 0
    print(
        f"{'case':<26}{'quantity':<22}{'tier':<13}{'answered':>9}{'largest':>10}{'rms':>10}{'known to':>10}{'within':>8}"
    )
    for line in lines:
        print(
            f"{line['case']:<26}{line['quantity']:<22}{line['tier']:<13}{line['answered']:>4}/{line['asked']:<4}"
            f"{line['largest']:>10.2g}{line['rms']:>10.2g}{line['uncertainty']:>10.1g}{line['within']:>8}"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
