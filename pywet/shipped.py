"""Data files of the program outside the package: configuration, deck templates, workflow, wet problems, scenes, documentation.

In a checkout they are next to the package; `setup.py` copies them into the package of a wheel.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from pywet import run_folder
from pywet.errors import PywetError, one_line, shown
from pywet.util.files import atomic_write

INSIDE = Path(__file__).parent / "shipped"
NOTEBOOK = "first-steps.ipynb"
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

What is to be run is in `config/`: cases in `cases.csv`, scale and effects in `config.yaml`; every number has its source.

    pywet plan 1                       which effects case 1 calls for, and why
    pywet run 1                        one case: build, simulate, replay, results
    snakemake --cores 2 --keep-going   all cases and results/smoke/report.html
    pywet run 1                        after a change of config/: results/smoke/case01; before: case01.1, moved aside
    pywet docs compare                 is 7 % significantly different from 5 %? Cases of your own: pywet docs configuration

`pywet doctor` lists what is missing: `apt install liggghts libliggghts-dev libopenmpi-dev openmpi-bin g++` and `pywet[workflow]`.
"""
OTHERS = {
    "sweep": (("sweeps/small_drum.yaml", "sweeps/small_drum_scene.yaml"), "sweep small_drum.yaml --cores 2", "sweep"),
    "bridge": (("bridge.json", "bridge_wall.json"), "bridge bridge.json --table", "bridge"),
    "collision": (
        ("wall_wet.json", "wall_sweep.json", "wall_oblique_dry.json", "three_equal_spheres.json", "four_spheres.json"),
        "collide wall wall_wet.json", "wall_collision",
    ),
    "calibration": (("calibrations/drum.yaml", "calibrations/small_drum.yaml"), "calibrate drum.yaml", "calibrate"),
}  # fmt: skip
"""Examples that are not scenes: files in `examples`, command for them, page of the documentation."""
OTHER_README = """# An example: {name}

    pywet {words}

`pywet docs {page}` is the guide. `pywet doctor` reports what is missing on this machine.
"""
SCENE_README = """# {title}

    pywet run-scene {name}.yaml --out run    plan, simulation, replay, results, picture
    run/report.html                          the page to open first

`pywet docs own-scene` is the guide, `pywet docs scene_reference` lists all keys with meaning, unit and default. `pywet doctor`
reports what is missing on this machine: `apt install liggghts libliggghts-dev libopenmpi-dev openmpi-bin g++`.
"""


def place(name: str) -> Path:
    """Return the path of `config`, `liggghts_inputs`, `workflow`, `Snakefile`, `benchmarks/wet`, `examples` or `docs`."""
    inside = INSIDE / name
    return inside if inside.exists() else Path(__file__).parents[1] / name


def open_studies() -> bool:
    """Make the studies of a checkout importable in this process and its children; False if there are none, as in a wheel."""
    root = Path(__file__).parents[1]
    if not (root / "studies" / "command.py").exists():
        return False
    if str(root) not in sys.path:
        sys.path.append(str(root))
    paths = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    os.environ["PYTHONPATH"] = os.pathsep.join(dict.fromkeys(filter(None, (*paths, str(root)))))
    return True


def _holds(path: Path, data: bytes) -> bool:
    """Return whether a file of the user has this content."""
    try:
        return not path.is_symlink() and path.read_bytes() == data
    except OSError:
        return False


def examples() -> list[str]:
    """Return the names of the examples for `begin`: the screening study, the notebook, scenes, files of other commands."""
    return ["case", "notebook", *sorted(path.stem for path in place("examples/scenes").glob("*.yaml")), *OTHERS]


def _contents(example: str) -> dict[str, bytes]:
    """Return the files of an example by name."""
    if example not in examples():
        raise PywetError(
            f"there is no example {one_line(example)}; expected one of {', '.join(examples())}",
            code="init.unknown_example",
            given=example,
            expected=tuple(examples()),
        )
    if example == "case":
        files = {f"config/{path.name}": path.read_bytes() for path in sorted(place("config").iterdir())}
        return files | {"Snakefile": SNAKEFILE.encode(), "README.md": README.encode()}
    if example == "notebook":
        return {NOTEBOOK: (place("docs") / NOTEBOOK).read_bytes()}
    if example in OTHERS:
        names, words, page = OTHERS[example]
        files = {Path(name).name: (place("examples") / name).read_bytes() for name in names}
        return files | {"README.md": OTHER_README.format(name=example, words=words, page=page).encode()}
    scenes = place("examples/scenes")
    files = {path.name: path.read_bytes() for path in sorted(scenes.glob(f"{example}.*"))}
    title = files[f"{example}.yaml"].decode().partition("\n")[0].removeprefix("# ")
    return files | {"README.md": SCENE_README.format(title=title, name=example).encode()}


def begin(folder: Path, example: str = "case") -> list[Path]:
    """Write an example into a folder, ready to run; a folder that contains one of its files is refused.

    A folder left incomplete by an interrupted call is completed, if its files are unchanged.
    """
    folder = Path(folder)
    run_folder.refuse_within(folder)
    files = _contents(example)
    tops = list(dict.fromkeys(name.partition("/")[0] for name in files))
    folders = [top for top in tops if top not in files]
    begun = {name for name, data in files.items() if _holds(folder / name, data)}
    left = {str(path.relative_to(folder)) for top in folders for path in (folder / top).glob("[!.]*")}
    left |= {top for top in tops if top in files and os.path.lexists(folder / top)}
    whole = begun == set(files) or any((folder / top).is_symlink() or (folder / top).is_file() for top in folders)
    for top in tops:
        if whole or any(file.partition("/")[0] == top for file in left - begun):
            raise PywetError(
                f"{shown(folder / top)} exists already; expected a folder without it: name another",
                code="init.there",
                where=folder / top,
            )
    for name, data in files.items():
        with atomic_write(folder / name) as temporary:
            temporary.write_bytes(data)
    return [folder / name for name in files]
