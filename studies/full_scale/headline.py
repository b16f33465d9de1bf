"""First lines of docs/full_scale.md: effect of liquid on passage, its distribution, number of confirmed statements."""

from __future__ import annotations

from collections.abc import Sequence

from studies.full_scale import spread
from studies.full_scale.judging import FAILS, HOLDS, MISSING, OPEN, Answer, Statement
from studies.full_scale.spread import Runs
from studies.full_scale.stored_runs import mean

INTRO = (
    'The 18 screening cases of Elskamp & Kruggel-Emden (2018, "the paper") were simulated on a sieve of 200 mm for 20 s from the '
    "opening of the slide."
)


def _half(runs: Runs, case: int) -> str:
    return f"{mean(runs[case], spread.half_through):.2f} s"


def lines(runs: Runs, answers: Sequence[tuple[Statement, Answer]]) -> list[str]:
    """Summarise passage, distribution of the liquid and confirmed statements; lines without cases are omitted."""
    written = ["# Full scale", "", INTRO, ""]
    if all(runs.get(n) for n in (1, 2, 10, 11)):
        written += [
            "- **Passage**: 5 % (POM) or 2.5 % (glass) of liquid delays passage. With apertures of 8 mm and an amplitude of 1 mm "
            "half of the undersize has passed after "
            f"{_half(runs, 1)} dry and {_half(runs, 2)} moist (POM), {_half(runs, 10)} and {_half(runs, 11)} (glass); after "
            "10 s all undersize has passed.",
        ]
    if all(runs.get(n) for n in (7, 8, 16, 17)):
        y = [f"{mean(runs[n], lambda k: k.at(k.retained(), 20.0)):.2f}" for n in (7, 8, 16, 17)]
        written += [
            f"  With 5.6 mm the screen retains after 20 s {y[0]} of the dry and {y[1]} of the moist feed (POM), {y[2]} and "
            f"{y[3]} (glass).",
        ]
    of = [(name, runs[n]) for name, n in (("POM", 2), ("glass", 11)) if runs.get(n)]
    if of:
        held = [
            " and ".join(f"{100.0 * mean(each, share):.0f} %{f' ({name})' * (not k)}" for name, each in of)
            for k, share in enumerate(
                (
                    lambda k: k.liquid("fines", "collecting_bin")[-1],
                    lambda k: k.liquid("coarse_material")[-1],
                    lambda k: k.walls[-1],
                )
            )
        ]
        written += [
            f"- **Liquid at the end** (8 mm, 1 mm): {held[0]} are in the bin, on fines and walls, {held[1]} on coarse spheres, "
            f"{held[2]} on the other walls."
        ]
    return [*written, f"- **Statements of the paper**: {_counted(answers)}.", ""]


def _counted(answers: Sequence[tuple[Statement, Answer]]) -> str:
    verdicts = [a.verdict for _, a in answers]
    return "; ".join(
        f"of the {len(part)} on {of} "
        + ", ".join(f"{part.count(v)} are {v}" for v in (HOLDS, FAILS, OPEN, MISSING) if v in part)
        for of, part in (("screening", verdicts[:39]), ("laws", verdicts[39:]))
    )
