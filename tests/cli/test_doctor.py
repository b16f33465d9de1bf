"""The doctor: what is missing or of another version is named in one sentence each, and the exit code says so."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from pywet.cli import doctor
from pywet.engines import process
from pywet.engines.liggghts import build


def engine_that_says(folder: Path, text: str, code: int = 0) -> None:
    """A program `liggghts` that prints a text, first on the path."""
    program = folder / "liggghts"
    program.write_text(f"#!/bin/sh\necho '{text}'\nexit {code}\n")
    program.chmod(0o755)


@pytest.fixture
def path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The only folder on PATH besides the shell's; empty."""
    folder = tmp_path / "bin"
    folder.mkdir()
    (folder / "sh").symlink_to(shutil.which("sh") or "/bin/sh")
    monkeypatch.setenv("PATH", str(folder))
    return folder


def by_name() -> dict[str, doctor.Check]:
    return {check.name: check for check in doctor.checks()}


def test_without_the_programs_each_is_named_and_the_exit_code_is_1(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert doctor.main() == 1
    lines = capsys.readouterr().out.splitlines()
    assert "liggghts: nothing was found, 3.8.0 is needed: run `make setup`" in lines
    for program in ("mpirun", "mpicxx", "g++"):
        assert f"{program}: nothing was found, any is needed: run `make setup`" in lines
    assert sum(line.startswith("plugin: ") for line in lines) == 1


def test_an_engine_of_another_version_is_refused_with_both_versions(path: Path) -> None:
    engine_that_says(path, "LIGGGHTS (Version LIGGGHTS-PUBLIC 3.7.0, compiled 2017-01-01-00:00:00 by someone)")
    engine = by_name()["liggghts"]
    assert (engine.ok, engine.version, engine.needed) == (False, "3.7.0", "3.8.0")
    assert engine.sentence().startswith("liggghts: 3.7.0 was found, 3.8.0 is needed: ")
    assert "make setup" not in engine.fix  # `make setup` does not replace an installed engine


def test_an_engine_that_does_not_start_is_not_taken_for_a_good_one(path: Path) -> None:
    engine_that_says(path, "error while loading shared libraries", code=127)
    engine = by_name()["liggghts"]
    assert (engine.ok, engine.version) == (False, None)
    assert "does not start" in engine.sentence()


def test_the_right_engine_is_accepted_by_its_banner(path: Path) -> None:
    engine_that_says(path, "LIGGGHTS (Version LIGGGHTS-PUBLIC 3.8.0, compiled 2022-01-26-19:42:32 by buildd)")
    assert by_name()["liggghts"].ok


def test_headers_of_another_version_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process, "package_version", lambda package: "4.0.0-1")
    found = by_name()
    assert (found["engine headers"].ok, found["engine headers"].version) == (False, "4.0.0-1")
    assert not found["plugin"].ok
    assert "3.8.0" in found["plugin"].sentence()


def test_a_library_that_does_not_load_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "LIBRARY", "libliggghts-nowhere.so.3")
    library = by_name()["libliggghts-nowhere.so.3"]
    assert (library.ok, library.found) == (False, None)


def test_a_python_package_of_another_version_is_reported_with_the_pinned_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    constraints = tmp_path / "constraints.txt"
    constraints.write_text("NumPy==0.0.1\nrich==15.0.0\n")
    monkeypatch.setattr(doctor, "CONSTRAINTS", constraints)
    numpy = by_name()["numpy"]
    assert (numpy.ok, numpy.needed) == (False, "0.0.1")


def test_too_little_space_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "FREE_GB", 1e9)
    disk = by_name()["free disk"]
    assert not disk.ok
    assert disk.sentence().endswith(": free some space")


@pytest.mark.engine
def test_nothing_is_missing_after_setup(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Of what `make setup` installs: how much space is free is no matter of it."""
    monkeypatch.setattr(doctor, "FREE_GB", 0.0)
    build.plugin_path()
    assert doctor.main() == 0, capsys.readouterr().out
    assert by_name()["liggghts"].version == build.ENGINE_VERSION


def test_every_main_package_is_pinned() -> None:
    assert set(doctor.MAIN_PACKAGES) <= set(doctor.pinned())
