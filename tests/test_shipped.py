"""A wheel holds all that the program is made of, and works outside the checkout; `pywet init` writes what is ready to run."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import subprocess
import sys
import sysconfig
import venv
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

from pywet import shipped
from pywet.calibration import question
from pywet.cases.custom.building import Building
from pywet.cases.small import bridge_query
from pywet.cli.app import app
from pywet.collisions.wall import sweep
from pywet.scene_stages import read_scene
from pywet.sweep import plan
from tests.error_codes import raises_code
from tests.test_docs import check_shown

ROOT = Path(__file__).parent.parent
SOURCES = (
    "pywet",
    "reference_impl",
    "config",
    "liggghts_inputs",
    "workflow",
    "benchmarks/wet",
    "examples",
    "docs",
)
BESIDE = ("Snakefile", "pyproject.toml", "setup.py", "MANIFEST.in", "README.md", "LICENSE")
BUILD = "import os; from setuptools import build_meta; os.mkdir('out'); build_meta.build_sdist('out')"
TRY = """
import os, pywet
from pywet.cli.app import app
from pywet.collisions.wall import sweep
print(pywet.__file__)
for words in ("laws", "init study", "plan 1 --config study/config", "docs own-scene", "docs scene_reference"):
    app(words.split(), standalone_mode=False)
app(["init", "mill", "--example", "hopper"], standalone_mode=False)
"""


def call(*command: str, folder: Path, **environment: str) -> str:
    """Standard output of a command that must succeed, in a folder, with the environment's own PYTHONPATH left out."""
    usual = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    done = subprocess.run(
        command, cwd=folder, env={**usual, "COLUMNS": "200", **environment}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A wheel of the source distribution of a copy of the checkout, which building would litter."""
    folder, source = tmp_path_factory.mktemp("wheel"), tmp_path_factory.mktemp("source")
    for name in SOURCES:
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in BESIDE:
        shutil.copy(ROOT / name, folder)
    call(sys.executable, "-c", BUILD, folder=folder)
    shutil.unpack_archive(next((folder / "out").glob("*.tar.gz")), source)
    (unpacked,) = source.iterdir()
    command = "pip wheel --no-deps -w dist ."
    check_shown(command, call(sys.executable, "-m", *command.split(), "--no-build-isolation", folder=unpacked))
    return next((unpacked / "dist").glob("*.whl"))


@pytest.fixture(scope="module")
def unpacked(wheel: Path) -> Path:
    """The wheel's content in a folder."""
    folder = wheel.parent.parent.parent / "unpacked"
    zipfile.ZipFile(wheel).extractall(folder)
    return folder


def test_every_file_of_the_program_is_in_the_wheel(unpacked: Path) -> None:
    """C++, headers, templates, style, stored tables, default configuration, workflow: byte for byte."""
    for name in SOURCES:
        target = unpacked if name in ("pywet", "reference_impl") else unpacked / "pywet" / "shipped"
        files = [p for p in (ROOT / name).rglob("*") if p.is_file() and "__pycache__" not in p.parts]
        files = [p for p in files if name != "docs" or (p.suffix in (".md", ".ipynb") and p.parent.name == "docs")]
        assert files
        for path in files:
            assert (target / path.relative_to(ROOT)).read_bytes() == path.read_bytes(), path
    kinds = {path.suffix for path in unpacked.rglob("*")}
    assert {".cpp", ".h", ".j2", ".css", ".js", ".json", ".yaml", ".csv", ".smk"} <= kinds


def test_an_unpacked_wheel_answers_outside_the_checkout(unpacked: Path, tmp_path: Path) -> None:
    """Laws, a folder to begin with, the plan of its first case; then the workflow finds its rules, scripts and template."""
    output_text = call(sys.executable, "-P", "-c", TRY, folder=tmp_path, PYTHONPATH=str(unpacked))
    assert output_text.splitlines()[0] == str(unpacked / "pywet" / "__init__.py")
    assert "willett_unequal" in output_text and "tangential_history" in output_text
    assert {path.name for path in (tmp_path / "mill").iterdir()} == {"hopper.yaml", "hopper.stl", "README.md"}
    assert "# User-defined scenes" in output_text and "| `half_width_mm` | number or null: " in output_text
    planned = call(
        *(sys.executable, "-P", "-m", "snakemake", "-n", "--cores", "1", "--config", "cases=[1]"),
        folder=tmp_path / "study", PYTHONPATH=str(unpacked), XDG_CACHE_HOME=str(tmp_path / "cache"),
    )  # fmt: skip
    assert "simulate" in planned and "results/smoke/report_cases1.html" in planned


def test_init_writes_once_and_overwrites_nothing(tmp_path: Path) -> None:
    made = shipped.begin(tmp_path / "new")
    assert {path.name for path in made} == {
        "cases.csv", "config.yaml", "materials.yaml", "scales.yaml", "Snakefile", "README.md",
    }  # fmt: skip
    assert (tmp_path / "new" / "config" / "cases.csv").read_bytes() == (ROOT / "config" / "cases.csv").read_bytes()
    assert len((tmp_path / "new" / "README.md").read_text().splitlines()) <= 12
    for name in ("config", "Snakefile", "README.md"):
        folder = tmp_path / f"has {name}"
        folder.mkdir()
        (folder / name).touch()
        with raises_code("init.there"):
            shipped.begin(folder)
        assert [path.name for path in folder.iterdir()] == [name]


@pytest.mark.parametrize(
    "name", [name for name in shipped.examples() if name not in ("case", "notebook", *shipped.OTHERS)]
)
def test_an_example_is_a_scene_that_is_ready_to_run(name: str, tmp_path: Path) -> None:
    """Its folder holds all that it needs (tests/cases/custom/test_examples.py runs each); a second call overwrites nothing."""
    output_text = CliRunner().invoke(app, ["init", str(tmp_path / "new"), "--example", name])
    assert output_text.exit_code == 0, output_text.output
    scene = read_scene(tmp_path / "new" / f"{name}.yaml")
    assert Building(scene).scene().walls
    assert f"pywet run-scene {name}.yaml" in (tmp_path / "new" / "README.md").read_text()
    with raises_code("init.there"):
        shipped.begin(tmp_path / "new", name)


@pytest.mark.parametrize("name", shipped.OTHERS)
def test_an_example_of_another_command_is_what_it_reads(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The command of its README gets as far as the files' content; a word that is wrong in one of them is refused."""
    made = shipped.begin(tmp_path, name)
    words = shipped.OTHERS[name][1].split()
    assert f"pywet {' '.join(words)}" in (tmp_path / "README.md").read_text()
    monkeypatch.chdir(tmp_path)
    read: dict[str, Callable[[Path], object]] = {
        "sweep": lambda path: plan.read(path).points, "bridge": bridge_query.read, "collision": sweep.read,
        "calibration": question.read,
    }  # fmt: skip
    file = next(Path(word) for word in words if Path(word).suffix in (".yaml", ".json"))
    assert read[name](file) and file in [path.relative_to(tmp_path) for path in made]


def test_an_example_that_is_not_there_is_refused_with_those_that_are(tmp_path: Path) -> None:
    with raises_code("init.unknown_example", given="mill"):
        shipped.begin(tmp_path, "mill")
    assert list(tmp_path.iterdir()) == []


def test_the_notebook_is_that_of_the_documentation(tmp_path: Path) -> None:
    """`pywet init` writes the notebook that tests/test_docs_site.py executes, byte for byte and without stored output."""
    done = CliRunner().invoke(app, ["init", str(tmp_path), "--example", "notebook"])
    written = tmp_path / shipped.NOTEBOOK
    assert done.exit_code == 0 and written.read_bytes() == (ROOT / "docs" / shipped.NOTEBOOK).read_bytes()
    notebook = json.loads(written.read_text())
    code = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert notebook["nbformat"] == 4 and len(code) == 5 and not any(cell["outputs"] for cell in code)


@pytest.mark.slow
@pytest.mark.engine
def test_an_installed_wheel_does_what_the_checkout_does(wheel: Path, tmp_path: Path) -> None:
    """`pip install` into a new environment, whose other packages are those of this one; case 1 from init to replay."""
    venv.create(tmp_path / "env", with_pip=True)
    program = tmp_path / "env" / "bin"
    inside = call(
        str(program / "python"), "-c", "import sysconfig; print(sysconfig.get_path('purelib'))", folder=tmp_path
    )
    # packages of this environment, without its editable pywet
    (Path(inside.strip()) / "others.pth").write_text(sysconfig.get_path("purelib"))
    command = 'pip install "dist/pywet-0.2.0-py3-none-any.whl[workflow]"'
    installed = call(
        *(str(program / "python"), "-m", *shlex.split(command), "--no-deps", "--no-index"), folder=wheel.parents[1]
    )
    check_shown(command, installed)

    def pywet(*words: str, folder: Path = tmp_path) -> str:
        return call(str(program / "pywet"), *words, folder=folder)

    where = call(
        str(program / "python"), "-c", "import pywet; print(pywet.__file__, pywet.__version__)", folder=tmp_path
    )
    assert where.startswith(str(tmp_path / "env")) and where.split()[1][0].isdigit()
    assert "rabinovich" in pywet("laws")
    assert '"force_N"' in pywet("bridge", str(ROOT / "examples" / "bridge.json"))
    assert '"e_n"' in pywet("collide", "wall", str(ROOT / "examples" / "wall_wet.json"))
    assert '"outcome"' in pywet("collide", "spheres", str(ROOT / "examples" / "three_equal_spheres.json"))
    assert "quantity" in pywet("score", "viscous_pull", "--template")
    pywet("init", "study")
    assert "fraction retained" in pywet("run", "1", folder=tmp_path / "study")
    pywet("scene", "pull", "--seconds", "0.02", folder=tmp_path / "study")  # requires the plugin
    output_text = pywet("replay", "--json", "results/scenes/pull", folder=tmp_path / "study")
    assert json.loads(output_text)["status"] == "in part"
