"""Writes docs/planted_faults.md from runs with each planted fault: `python -m tests.planted_table`. Takes a few minutes."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

from reference_impl.replay.replay import replay
from tests import planted_honest
from tests.engines.liggghts import planted
from tests.reference_impl import planted_log

PAGE = Path(__file__).parents[1] / "docs" / "planted_faults.md"
HEAD = """# Planted faults

Made by `python -m tests.planted_table` from runs with one fault each; the same faults are tests
(`tests/engines/liggghts/test_planted_faults.py`, `tests/reference_impl/test_diagnosis.py`).

**In the engine**: a copy of the plugin's sources in which the fault is switched on, built and run; spheres of two sizes are
drawn off a floor, off a thin plate and off each other. **In the log**: the history of a sound run (twelve wet spheres fallen on a
floor) is changed afterwards; *claims* are the laws and constants that `meta.json` names.

*Shows in*: the quantity of the replay's table that is furthest beyond its limit, its largest deviation, and how many quantities
are beyond theirs. *Named as*: what the replay says first. *Next-best*: the explanation after it, with the share of the records
that it explains (100 %: these records cannot tell the two apart).

| fault | planted in | shows in | deviation | quantities | named as | explains | next-best |
|---|---|---|---|---|---|---|---|
"""
UNSEEN = (
    ("a bridge missed between two outputs outside the windows, and made up for before the next", "",
     "missed formations are looked for at output steps and in windows; a late one shows in its event"),
    ("errors of the exact bridge's tables below their stated limits", "",
     "a sample of the records is solved anew: force within 1e-3 of that at touch, rupture distance within 2e-4"),
    ("a law that is not built in", "", "its term is taken as logged (`unchecked` in replay.json)"),
    ("contact forces of the dry model, without recorded motion", "",
     "with `output.window_trajectories` Newton's law shows them "
     "(`tests/reference_impl/test_newton.py`): a wrong tangential stiffness, rolling resistance, gravity or "
     "mass, stiffness, friction or damping is named"),
    ("a wrong reading of a paper that both sides share", "",
     "both are written from the same mended equations; the atlas and the exact bridge judge the laws"),
)  # fmt: skip
"""What the replay cannot see without a run to show it."""
WHY = {
    "forces that act": "the log says what was computed; what acts shows in the motion only",
    "forces outside the contact log": "forces are logged in windows; volumes, shares and films are checked in the whole run",
}
TAIL = """
## What the replay cannot see

Those with a fault are run with it, agree all the same, and are tests that say so.

| what | planted | why it is not seen |
|---|---|---|
"""


def row(name: str, where: str, result: dict[str, Any]) -> str:
    """One line of the table."""
    bad = {n: q for n, q in result["quantities"].items() if not q["ok"]}
    worst = max(bad, key=lambda n: bad[n]["largest"] / max(bad[n]["tolerance"], 1e-12))
    first = result["diagnosis"]["findings"][0]
    deviation = f"{bad[worst]['largest']:.1e}" if bad[worst]["largest"] < 1e300 else "not a number"
    other = first["next_best"]
    said = f"{other['fault']} ({100 * other['share']:.3g} %)" if other else "–"
    share = f"{first['explained']} of {first['disagree']}"
    columns = (
        name,
        where,
        worst,
        deviation,
        str(len(bad)),
        f"{first['what']}: {first['fault']}",
        share,
        said,
    )
    return "| " + " | ".join(columns) + " |"


def main() -> None:
    """Run all, write the page."""
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        foundry = planted.Foundry(folder)
        for fault in planted.NAMED:
            print(fault, file=sys.stderr, flush=True)
            run_dir = folder / fault.replace(" ", "_")
            foundry.run(run_dir, planted.scene(run_dir), fault)
            rows.append(row(fault, "engine", replay(run_dir)))
        for fault in planted.MOTION:
            run_dir = folder / fault.replace(" ", "_")
            foundry.run(run_dir, planted.scene(run_dir, motion=True), fault)
            rows.append(row(f"{fault} (motion recorded)", "engine", replay(run_dir)))
        foundry.close()
        sound = planted_log.heap(folder / "sound")
        for fault, change in planted_log.FAULTS.items():
            print(fault, file=sys.stderr, flush=True)
            (folder / "log" / fault).mkdir(parents=True)
            where = "log (claims)" if "claims" in fault or "in place of" in fault or "lian's" in fault else "log"
            rows.append(row(fault, where, replay(planted_log.plant(sound, folder / "log" / fault, change))))
    count = f"\n{len(rows)} faults, all found and named.\n"
    shown = [(what, words, WHY[what]) for what, (_, _, words) in planted.UNSEEN.items()]
    unseen = ["| " + " | ".join(columns) + " |" for columns in (*shown, *UNSEEN)]
    PAGE.write_text(HEAD + "\n".join(rows) + "\n" + count + TAIL + "\n".join(unseen) + "\n\n" + planted_honest.TEXT)


if __name__ == "__main__":
    main()
