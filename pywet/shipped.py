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

LIGGGHTS 3.8.0 must be there, as Debian 12 has it, with its headers and a compiler; `pywet doctor` says what is missing:
`apt install liggghts libliggghts-dev libopenmpi-dev openmpi-bin g++`.
"""


def place(name: str) -> Path:
    """Where `config`, `liggghts_inputs`, `workflow`, `Snakefile` or `benchmarks/wet` is."""
    inside = INSIDE / name
    return inside if inside.exists() else Path(__file__).parents[1] / name


def begin(folder: Path) -> list[Path]:
    """Write config/, Snakefile and README.md into a folder; refused where one of them is there and holds anything else."""
    folder = Path(folder)
    texts = {f"config/{path.name}": path.read_text() for path in sorted(place("config").iterdir())}
    texts |= {"Snakefile": SNAKEFILE, "README.md": README}
    there = [name for name in ("config", "Snakefile", "README.md") if os.path.lexists(folder / name)]
    if "config" in there and (folder / "config").is_dir():
        there += [f"config/{name}" for name in os.listdir(folder / "config")]
        there.remove("config")
    for name in there:  # what an interrupted call has left is gone on from
        path, whole = folder / name, len(there) == len(texts)
        if whole or name not in texts or path.is_symlink() or not path.is_file() or path.read_text() != texts[name]:
            raise PywetError(f"{shown(path)} is there already; expected a folder without one: name another")
    for name, text in texts.items():
        with atomic_write(folder / name) as temporary:
            temporary.write_text(text)
    return [folder / name for name in texts]
