"""Keeps the measured costs of the effects for the plan: `python -m pywet.evidence.effects.store results/studies WHERE`."""

from __future__ import annotations

import sys
from pathlib import Path

from pywet.evidence.effects import study, verdict
from pywet.files import read_json, write_json
from pywet.plan import OPT_IN
from pywet.plan.costs import STORED


def store(out_dir: Path, where: str) -> Path:
    """Write costs.json from the records in `out_dir`; `where`: machine and date, for the provenance."""
    records = study.read(sorted((out_dir / study.RUNS).glob("*.json")))
    judged = {name: verdict.choices(of) for name, of in records.items()}
    said = (
        f"median over the scenes of `pywet study effects` ({', '.join(judged)}) of the processor time of the steps with "
        f"everything on over that without the effect, less one; scenes whose steps took under {verdict.SHORTEST} s are left "
        f"out; {where}"
    )
    others = {effect: cost for effect, cost in read_json(STORED)["added"].items() if effect in OPT_IN}
    said += f"; {' and '.join(others)}, which are on in none of these: as stored before" if others else ""
    write_json(STORED, {"provenance": said, "added": {**verdict.costs(judged), **others}})
    return STORED


if __name__ == "__main__":
    print(store(Path(sys.argv[1]), sys.argv[2]))
