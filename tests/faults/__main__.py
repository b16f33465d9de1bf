"""`python -m tests.faults --new N --seed S`: N random faults, who notices each, and the score by room.

Found by the replay (and in which words), by the program itself (it stops with a sentence), by its tests (`--tests`, slow),
without any effect on what the run leaves, or surviving. One line for each as it is tried; all of them in OUT/faults.csv.
"""

from __future__ import annotations

import csv
import random
import time
from collections import Counter
from pathlib import Path
from typing import Annotated

import typer

from tests.faults import trial
from tests.faults.mutants import draw

COLUMNS = ("room", "file", "line", "what", "by", "said")


def main(
    new: Annotated[int, typer.Option(min=1, help="Faults.")] = 20,
    seed: Annotated[int, typer.Option(help="Of the draw; the same seed and sources give the same faults.")] = 1,
    room: Annotated[list[str] | None, typer.Option(help=f"Of {', '.join(trial.ROOMS)}; default all in turn.")] = None,
    tests: Annotated[
        bool, typer.Option("--tests", help="Ask the room's tests about what the program does not notice.")
    ] = False,
    out: Annotated[Path, typer.Option(help="Folder of the trials.")] = Path("results/faults"),
) -> None:
    """Try random faults."""
    rooms = room or list(trial.ROOMS)
    unknown = sorted(set(rooms) - set(trial.ROOMS))
    if unknown:
        raise typer.BadParameter(f"there is no room {unknown[0]}; expected one of {', '.join(trial.ROOMS)}")
    out = out.absolute()
    out.mkdir(parents=True, exist_ok=True)
    folder, chance, begun = out / "tree", random.Random(seed), time.monotonic()
    trial.copy(folder)
    done = trial.run(folder)
    if done.returncode:
        raise SystemExit(f"the program without a fault fails: {done.stderr.strip()[-300:]}")
    sound = trial.marks(folder)
    print(f"without a fault: {len(sound)} files, {time.monotonic() - begun:.0f} s", flush=True)
    rows: list[dict[str, str]] = []
    with open(out / "faults.csv", "w", newline="") as file:
        table = csv.DictWriter(file, COLUMNS)
        table.writeheader()
        while len(rows) < new:
            place = rooms[len(rows) % len(rooms)]
            mutant = draw(trial.files(place), chance)
            trial.copy(folder, mutant)
            if not trial.compiles(folder, mutant):
                continue
            verdict = trial.judge(folder, place, sound, tests)
            name = str(mutant.path.relative_to(trial.PACKAGE))
            rows.append(
                dict(zip(COLUMNS, (place, name, str(mutant.line), mutant.what, verdict.by, verdict.said), strict=True))
            )
            table.writerow(rows[-1])
            file.flush()
            left = (time.monotonic() - begun) / len(rows) * (new - len(rows))
            print(f"{len(rows)}/{new} {place} {name}:{mutant.line} {mutant.what[:60]}: {verdict.by} {verdict.said[:90]}"
                  f" ({left / 60:.0f} min to go)", flush=True)  # fmt: skip
    print("\n".join(score(rows)))


def score(rows: list[dict[str, str]]) -> list[str]:
    """For each room how many were found by whom; those without effect do not count."""
    lines = [f"{'room':<10}{'faults':>7}{'effect':>8}{'replay':>8}{'program':>9}{'tests':>7}{'survive':>9}{'found':>8}"]
    for room in [*dict.fromkeys(r["room"] for r in rows), ""]:
        of = Counter(r["by"] for r in rows if room in ("", r["room"]))
        total = sum(of.values())
        acting = total - of["no effect"]
        share = 1.0 - of["survives"] / acting if acting else 1.0
        lines.append(f"{room or 'all':<10}{total:>7}{acting:>8}{of['replay']:>8}{of['program']:>9}{of['tests']:>7}"
                     f"{of['survives']:>9}{100 * share:>7.0f}%")  # fmt: skip
    return lines


if __name__ == "__main__":
    typer.run(main)
