"""Sentences of docs/rig.md on what other rigs and readings change, computed from their runs."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

from studies.full_scale import quantities as q
from studies.full_scale.judging import FAILS, HOLDS, OPEN, judge
from studies.full_scale.statements import STATEMENTS
from studies.full_scale.stored_runs import StoredRun, mean

Runs = Mapping[int, Sequence[StoredRun]]
"""Case -> its runs, one for each seed."""
LESS = 0.01
"""Share of the undersize below which all of it counts as passed (statement 1)."""


def of_diameters(rigs: Mapping[str, Runs]) -> str:
    """Return for each diameter when the undersize of case 1 has passed, and which confirm statements 1 and 2."""
    sieves = sorted(
        (rig for rig, runs in rigs.items() if re.fullmatch(r"sieve[\d.]+", rig) and 1 in runs),
        key=lambda rig: -float(rig.removeprefix("sieve")),
    )
    times = [f"**{_mm(rig)} mm** {_until(rigs[rig][1], 1)}" for rig in sieves]
    confirm = [[_mm(rig) for rig in sieves if _verdicts(rigs[rig]).get(n) == HOLDS] for n in (1, 2)]
    first, second = (f"{', '.join(found)} mm" if found else "none" for found in confirm)
    return (
        "On a smaller sieve the bed is deeper and spheres pass more slowly. All undersize of case 1 (99 %) has passed on "
        f"{', on '.join(times)}; the paper states about 15 s. "
        f"[Statement](full_scale.md#statements) 1 (this time) is confirmed by {first}, statement 2 (amplitude) by {second}."
    )


def of_presets(rigs: Mapping[str, Runs], presets: Sequence[str]) -> str:
    """Return how many statements each preset confirms, and what it retains at 20 s with apertures of 5.6 mm."""
    sentences = []
    for rig in reversed(presets):
        found = list(_verdicts(rigs[rig]).values())
        pom, glass = (100.0 * mean(rigs[rig][case], lambda run: run.at(run.undersize, 20.0)) for case in (7, 16))
        sentences.append(
            f"**{_mm(rig)} mm**: of {len(found)} statements {found.count(HOLDS)} are confirmed, {found.count(FAILS)} are not, "
            f"{found.count(OPEN)} are inconclusive; {pom:.0f} % of the undersize of dry POM and {glass:.0f} % of "
            "that of dry glass are left (5.6 mm, 20 s)."
        )
    return " ".join(sentences)


def of_printed_force(rigs: Mapping[str, Runs], sieve: str) -> str:
    """Return what equation (14) as printed changes on a sieve."""
    printed = rigs[f"{sieve}_printed"]
    corrected, as_printed = _verdicts(rigs[sieve]), _verdicts(printed)
    both = [n for n in corrected if {corrected[n], as_printed[n]} <= {HOLDS, FAILS, OPEN}]
    gained, lost = (
        [str(n) for n in both if one[n] == HOLDS != other[n]]
        for one, other in ((as_printed, corrected), (corrected, as_printed))
    )
    return (
        f"**Equation (14) as printed** (`printed`): on {_mm(sieve)} mm the undersize of case 2 has passed "
        f"{_until(printed[2], 2)} instead of {_until(rigs[sieve][2], 2)}. "
        f"Confirmed in addition: {', '.join(gained) or 'none'}; no longer: {', '.join(lost) or 'none'}."
    )


def of_walls(rigs: Mapping[str, Runs], sieves: Sequence[str]) -> str:
    """Return what films of whole walls change in case 2."""
    rises = [
        " to ".join(f"{_on_apparatus(rigs[rig][2]):.2f}" for rig in (sieve, f"{sieve}_wall")) + f" on {_mm(sieve)} mm"
        for sieve in sieves
    ]
    found = _verdicts(rigs[f"{sieves[0]}_wall"])
    return (
        "**Films of whole walls** (`wall`): all triangles of a wall share one film, and the transfer ratio is that at a tenth "
        "of the rupture distance. In case 2 the liquid on the apparatus over that on the coarse material then rises from "
        f"{', from '.join(rises)}. On {_mm(sieves[0])} mm statement 26 is {found[26]}, statement 30 {found[30]}."
    )


def _verdicts(runs: Runs) -> dict[int, str]:
    """Return the verdict of each statement on cases."""
    return {s.number: judge(s, runs).verdict for s in STATEMENTS if s.cases}


def _until(runs: Sequence[StoredRun], case: int) -> str:
    """Say when less than 1 % of the undersize is left, mean and range over seeds."""
    times = [q.through({case: run}, case, LESS) for run in runs]
    if not all(map(math.isfinite, times)):
        return "not within 20 s"
    spread = f" ({min(times):.1f} to {max(times):.1f})" if len(times) > 1 else ""
    return f"after {sum(times) / len(times):.1f} s{spread}"


def _on_apparatus(runs: Sequence[StoredRun]) -> float:
    """Return the liquid on the walls over that on the coarse material in case 2 at 20 s, mean over seeds."""
    return mean(runs, lambda run: q.share({2: run}, 2, 20.0, "walls") / q.share({2: run}, 2, 20.0, q.COARSE_MATERIAL))


def _mm(rig: str) -> str:
    """Return the diameter of a rig's sieve [mm] as text."""
    return rig.removeprefix("sieve").partition("_")[0]
