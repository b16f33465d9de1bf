"""The targets of `make` that pages show: their recipes are executed in a checkout whose programs install nothing."""

from __future__ import annotations

import importlib
import os
import shutil
import sys
from pathlib import Path

import pytest

from tests.test_docs import ROOT, call, check_shown, link_checkout

PYTHON = f"""case "$2" in pip | venv | pywet.cli.warm) exit 0 ;; esac
exec {sys.executable} "$@"
"""
"""Of the checkout: installs nothing, and compiles nothing ahead of time."""
SNAKEMAKE = f"""{sys.executable} -m snakemake -n "$@"
for setting in "$@"; do
  case $setting in engine=liggghts) out=results/smoke ;; engine=yade) out=results/smoke_yade ;; esac
done
mkdir -p $out
touch $out/report.html
"""
"""Plans the jobs, and makes an empty report."""
PROGRAMS = {
    ".venv/bin/python": PYTHON,
    ".venv/bin/pip": "# of {folder}/.venv/bin/python",
    "bin/python3": PYTHON,
    ".venv/bin/snakemake": SNAKEMAKE,
    ".venv/bin/pywet": f'exec {sys.executable} -m pywet.cli.app "$@" --check',
    "bin/dpkg-query": f'case $2 in *db:Status*) exit 1 ;; esac\nexec {shutil.which("dpkg-query")} "$@"',
    "bin/apt-get": "exit 0",
    "bin/sudo": '[ "$1" != -n ] || shift\nexec "$@"',
}
"""Program -> what it does in the folder: no package is installed, and each can be."""


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """The files of the checkout, with these programs."""
    link_checkout(tmp_path)
    for name in ("Makefile", "constraints.txt", "pyproject.toml"):
        (tmp_path / name).symlink_to(ROOT / name)
    shutil.copytree(ROOT / "tools", tmp_path / "tools")  # copied, as tools/setup works in the folder above it
    for name, text in PROGRAMS.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"#!/bin/sh\n{text.replace('{folder}', str(tmp_path))}\n")
        path.chmod(0o755)
    return tmp_path


@pytest.fixture
def installed(checkout: Path) -> Path:
    """The checkout as one in which set-up, by whatever target, has nothing to do."""
    (checkout / "tools" / "setup").write_text("#!/bin/sh\n")
    return checkout


def make(folder: Path, *words: str, **environment: str) -> str:
    """What `make` prints in a folder."""
    path = f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}"
    done = call("make", "--no-print-directory", *words, folder=folder, PATH=path, **environment)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.engine
@pytest.mark.parametrize("target", ["setup", "peers"])
def test_setup_on_a_fresh_machine(checkout: Path, target: str) -> None:
    check_shown(f"make {target}", make(checkout, target))


@pytest.mark.parametrize("words", [("run",), ("run", "ENGINE=yade")])
def test_run(installed: Path, words: tuple[str, ...]) -> None:
    check_shown(
        " ".join(["make", *words]),
        make(installed, *words, XDG_CACHE_HOME=str(installed / "cache")),
    )


def test_the_report_is_of_the_engine_that_is_named(installed: Path) -> None:
    """All files that are to be made are in the folder of this engine, with the verdict, by which failed cases are an error."""
    printed = make(installed, "report", "ENGINE=yade", XDG_CACHE_HOME=str(installed / "cache"))
    assert "results/smoke_yade/verdict.txt" in printed and "results/smoke/" not in printed


@pytest.mark.parametrize("target", ["run", "report"])
def test_the_scale_is_that_of_the_configuration_unless_one_is_given(checkout: Path, target: str) -> None:
    """By its reader, which allows names of letters, digits and signs, quoted, with a comment behind them."""
    (checkout / "config").unlink()
    shutil.copytree(ROOT / "config", checkout / "config")
    for name, old, new in (
        ("config.yaml", "scale: smoke", 'scale: "smoke-Wide_2" # mine'), ("scales.yaml", "\n  smoke:", "\n  smoke-Wide_2:")
    ):  # fmt: skip
        text = (checkout / "config" / name).read_text()
        assert text.count(old) == 1
        (checkout / "config" / name).write_text(text.replace(old, new))
    words = ("-n", "-o", "essentials", target)
    assert " scale=" not in (configured := make(checkout, *words))
    assert "--config engine=liggghts scale=reduced" in (given := make(checkout, *words, "SCALE=reduced"))
    if target == "run":
        assert "results/smoke-Wide_2/report.html" in configured and "results/reduced/report.html" in given


def test_a_moved_or_copied_checkout_is_set_up_again(checkout: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    """The programs of its .venv have the path of the first folder in them; a second call there has nothing to do."""
    python3, moved = checkout / "bin" / "python3", tmp_path_factory.mktemp("other") / "moved"
    (checkout / ".venv/bin/pip").unlink()
    python3.write_text('#!/bin/sh\n[ "$2" != venv ] || echo "#!$(pwd -P)/.venv/bin/python" >>.venv/bin/pip\n')
    python3.chmod(0o755)
    installed = []
    for folder in (checkout, checkout, moved, moved):
        if not folder.exists():
            shutil.copytree(checkout, folder, symlinks=True)
        installed.append("Python packages into .venv" in make(folder, "essentials"))
    assert installed == [True, False, True, False]
    assert (moved / ".venv/bin/pip").read_text().split() == [f"#!{f}/.venv/bin/python" for f in (checkout, moved)]


@pytest.mark.slow
def test_lint() -> None:
    check_shown("make lint", make(ROOT, "-o", "setup", "lint"))


@pytest.mark.slow
@pytest.mark.engine
def test_bench(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Both programs of the recipe, on a few spheres and collisions."""
    recipe = call("make", "-n", "-o", "setup", "bench").stdout.split()
    for name, small, arguments in (
        ("step_cost", {"SETTLE": 20, "SHORT": 10, "STEPS": 200, "ROUNDS": 1}, ["--side", "3", "--only", "stock dry"]),
        ("collisions", {"ROUNDS": 1, "COUNT": 4, "SINGLE": 1}, []),
    ):
        assert f"benchmarks/{name}.py" in recipe
        monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
        monkeypatch.setattr(sys, "argv", [name, *arguments])
        module = importlib.import_module(name)
        for constant, value in small.items():
            monkeypatch.setattr(module, constant, value)
        module.main()
    check_shown("make bench", capsys.readouterr().out)
