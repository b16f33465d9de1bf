"""What lies beside the package and yet is part of the program: default configuration, deck templates, workflow, wet problems.

In a checkout they lie beside the package, where people look for them; `setup.py` puts them into the package of a wheel.
"""

from __future__ import annotations

import os
from pathlib import Path

from pywet.errors import PywetError, shown
from pywet.files import atomic_write

INSIDE = Path(__file__).parent / "shipped"
SNAKEFILE = """# The screening cases of config/, by the workflow that pywet brings along: snakemake --cores 2
from pywet.shipped import place


include: str(place("Snakefile"))


rule screening:
    default_target: True
    input:
        rules.all.input,
    localrule: True
"""
README = """# A screening study

What is to be run stands in `config/`: cases in `cases.csv`, scale and effects in `config.yaml`; every number has its source.

    pywet plan 1                       which effects case 1 calls for, and why
    pywet run 1                        one case: build, simulate, replay, results
    snakemake --cores 2 --keep-going   all cases and results/smoke/report.html
    pywet run 1                        after a change of config/: results/smoke/case01; before: case01.1, moved aside

LIGGGHTS 3.8.0 must be there, as Debian 12 has it, with its headers and a compiler; `pywet doctor` says what is missing:
`apt install liggghts libliggghts-dev libopenmpi-dev openmpi-bin g++`.
"""


def place(name: str) -> Path:
    """Where `config`, `liggghts_inputs`, `workflow`, `Snakefile` or `benchmarks/wet` is."""
    inside = INSIDE / name
    return inside if inside.exists() else Path(__file__).parents[1] / name


def _holds(path: Path, text: str) -> bool:
    """Whether a file of one's own has this text."""
    try:
        return not path.is_symlink() and path.read_text() == text
    except (OSError, UnicodeDecodeError):
        return False


def begin(folder: Path) -> list[Path]:
    """Write config/, Snakefile and README.md into a folder; refused where one of them is there already.

    What a call that was cut off has left of them is gone on with: a part of the files, each as it is written here.
    """
    folder = Path(folder)
    texts = {f"config/{path.name}": path.read_text() for path in sorted(place("config").iterdir())}
    texts |= {"Snakefile": SNAKEFILE, "README.md": README}
    begun = {name for name, text in texts.items() if _holds(folder / name, text)}
    left = {str(path.relative_to(folder)) for path in (folder / "config").glob("[!.]*")}
    left |= {name for name in ("Snakefile", "README.md", "config") if os.path.lexists(folder / name)} - {"config"}
    whole = begun == set(texts) or (folder / "config").is_symlink() or (folder / "config").is_file()
    for name in ("config", "Snakefile", "README.md"):
        if whole or any(file.partition("/")[0] == name for file in left - begun):
            raise PywetError(f"{shown(folder / name)} is there already; expected a folder without one: name another")
    for name, text in texts.items():
        with atomic_write(folder / name) as temporary:
            temporary.write_text(text)
    return [folder / name for name in texts]
