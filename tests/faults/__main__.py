"""`python -m tests.faults --new N --seed S`: N random faults, who notices each, and the score by package.

Found by the replay (and in which words), by the program itself (it stops with a sentence), by its tests (`--tests`, slow), a
crash that anybody sees, without any effect on what the run leaves, at a line to which no scene comes, or surviving. One line for
each as it is tried; all of them in OUT/faults.csv. A call with the same OUT and seed goes on where the last one was ended.
"""

from __future__ import annotations

import csv
import random
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from tests.faults import asked
from tests.faults.follow import Verdict
from tests.faults.mutants import code, draw
from tests.faults.packages import PACKAGES, below
from tests.faults.trial import Bench

COLUMNS = ("number", "package", "file", "line", "what", "code", "by", "message")
OPEN = ("not reached", "no effect", "survives")
"""Verdicts after which the tests are asked."""
LONGEST_MESSAGE = 300
"""Number of characters of a message that are stored."""
ASKED = "asked:"
"""Beginning of the message of a fault that no test noticed."""


def main(
    new: Annotated[int, typer.Option(min=0, help="Faults.")] = 20,
    seed: Annotated[int, typer.Option(help="Of the draw; the same seed and sources give the same faults.")] = 1,
    module: Annotated[list[str] | None, typer.Option(help=f"Of {', '.join(PACKAGES)}; default all in turn.")] = None,
    tests: Annotated[bool, typer.Option("--tests", help="Then ask the tests about what nothing else notices.")] = False,
    engine: Annotated[bool, typer.Option(help="Ask tests that run an engine about Python's faults too.")] = True,
    out: Annotated[Path, typer.Option(help="Folder of the trials.")] = Path("results/faults"),
) -> None:
    """Try random faults."""
    packages = module or list(PACKAGES)
    unknown = sorted(set(packages) - set(PACKAGES))
    if unknown:
        raise typer.BadParameter(f"there is no package {unknown[0]}; expected one of {', '.join(PACKAGES)}")
    table = out.absolute() / "faults.csv"
    table.parent.mkdir(parents=True, exist_ok=True)
    rows = read(table)
    bench, begun = Bench(out.absolute()), time.monotonic()
    bench.open(packages)
    print(f"without a fault: {time.monotonic() - begun:.0f} s", flush=True)
    known = {(row["package"], int(row["number"])) for row in rows}
    wanted = [(packages[n % len(packages)], n // len(packages)) for n in range(new)]
    ahead, begun = [place for place in wanted if place not in known], time.monotonic()
    for done, (place, number) in enumerate(ahead, 1):
        row = one(bench, number, seed, place)
        rows.append(row)
        write(table, rows)
        left = (time.monotonic() - begun) / done * (len(ahead) - done)
        print(f"{done}/{len(ahead)} {one_line(row)} ({left / 60:.0f} min to go)", flush=True)
    for row in rows if tests else ():
        if row["by"] in OPEN and not row["message"].startswith(ASKED) and row["package"] in packages:
            if (mutant := asked.again(row, bench.tree / "pywet")) is None:
                continue
            failed = asked.ask(bench, mutant, engine=engine)
            row |= {"by": "tests", "message": failed} if failed else {"message": f"{ASKED} {row['message']}"}
            write(table, rows)
            print(one_line(row), flush=True)
    print("\n".join(score(rows)))


def one_line(row: dict[str, str]) -> str:
    """Write one fault on a line."""
    return f"{row['package']} {row['file']}:{row['line']} {row['what'][:60]}: {row['by']} {row['message'][:90]}"


def one(bench: Bench, number: int, seed: int, module: str) -> dict[str, str]:
    """The fault of a number in its package, the first of its draw that compiles, tried."""
    rng, verdict = random.Random(f"{seed} {module} {number}"), None
    while verdict is None:
        mutant = draw(bench.files(module), rng)
        verdict: Verdict | None = bench.judge(mutant, module)
    reported = verdict.message.replace(f"{bench.tree}/", "")[
        :LONGEST_MESSAGE
    ]  # before truncation, which might cut the path
    text = code(mutant.path.read_text(), mutant.line)
    values = (str(number), module, below(mutant.path), str(mutant.line), mutant.what, text, verdict.by, reported)
    return dict(zip(COLUMNS, values, strict=True))


def read(table: Path) -> list[dict[str, str]]:
    """Faults tried so far."""
    if not table.exists():
        return []
    with open(table, newline="") as file:
        return list(csv.DictReader(file))


def write(table: Path, rows: list[dict[str, str]], columns: Sequence[str] = COLUMNS) -> None:
    """The table, whole or not at all."""
    partial = table.with_suffix(".partial")
    with open(partial, "w", newline="") as file:
        lines = csv.DictWriter(file, columns)
        lines.writeheader()
        lines.writerows(rows)
    partial.rename(table)


def score(rows: list[dict[str, str]]) -> list[str]:
    """For each package how many were found by whom; crashes, and those without effect, do not count."""
    names = ("crash", "no effect", "replay", "program", "tests", "not reached", "survives")
    lines = [f"{'package':<10}{'faults':>7}" + "".join(f"{name:>12}" for name in names) + f"{'found':>8}"]
    for module in [*dict.fromkeys(r["package"] for r in rows), ""]:
        of = Counter(r["by"] for r in rows if module in ("", r["package"]))
        acting = sum(of[name] for name in names[2:])
        share = (of["replay"] + of["program"] + of["tests"]) / acting if acting else 1.0
        counts = "".join(f"{of[name]:>12}" for name in names)
        lines.append(f"{module or 'all':<10}{sum(of.values()):>7}{counts}{100 * share:>7.0f}%")
    return lines


if __name__ == "__main__":
    typer.run(main)
