"""Writes docs/planted_files.md: `python -m tests.planted_files_table RUN_DIR`, a sound run of sixteen spheres of case 2.

(The run is that of the fixture `screened_dir`, whose folder pytest's --basetemp keeps.)
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

from reference_impl.scene import check as scene
from reference_impl.tables import check as results
from tests import planted_honest
from tests.reference_impl.planted_files import RESULTS, SCENE

PAGE = Path(__file__).parents[1] / "docs" / "planted_files.md"
HEAD = """# Planted faults of scene and results

Made by `python -m tests.planted_files_table RUN_DIR` from one run of sixteen moist spheres of case 2 at smoke scale; the same
faults are tests (`tests/reference_impl/test_sections.py`). Each is planted in the files of a copy: the scene and what follows
from it before the engine, or the tables and the summary after it. *Shows in*: the quantity of the replay
([what it holds against what](replay.md)) and its largest deviation. *Named as*: the sentence of it that is tested.
Faults of engine, laws and logs: [planted faults](planted_faults.md).

A fault of `scene.json` planted afterwards parts it from the deck as well; that finding stands further down in the replay's list.

| fault | shows in | deviation | named as |
|---|---|---|---|
"""


def main(sound: Path) -> None:
    """Plant, look, write."""
    rows = []
    for faults, check in ((SCENE, scene.check), (RESULTS, results.check)):
        for name, fault in faults.items():
            with tempfile.TemporaryDirectory() as folder:
                copy = Path(shutil.copytree(sound, Path(folder) / "run"))
                fault.change(copy)
                found = check(copy)
            quantity = next(q for q in found.quantities if q.name == fault.quantity)
            sentence = next(f["sentence"] for f in found.findings if fault.words in f["sentence"])
            said = sentence.partition(": ")[2].replace("|", "\\|")
            deviation = "not a number" if quantity.largest > 1e100 else f"{quantity.largest:.1e}"
            rows.append(f"| {name} | {quantity.name} | {deviation} | {said} |")
    PAGE.write_text(f"{HEAD}{chr(10).join(rows)}\n\n{len(rows)} faults, all found and named.\n\n{planted_honest.TEXT}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
