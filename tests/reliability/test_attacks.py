"""Attacks: scenes, queries, folders and programs made by somebody else must not have anything done that was not asked for."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from pydantic import ValidationError
from typer.testing import CliRunner

from pywet import config, stages
from pywet.cases.small import small
from pywet.cli import doctor
from pywet.cli.app import app
from pywet.engines import process
from pywet.engines.liggghts import build
from pywet.laws import custom_laws, davis, registry, viscous
from pywet.scene import EngineScene
from pywet.util import caches, machine_code, sources
from tests.cases.screening import synthetic
from tests.cases.script import scripts
from tests.engines.liggghts.scenes import WATER, contacts, spheres_of
from tests.error_codes import raises_code

ROOT = Path(__file__).parents[2]
SIDE = """
import pathlib
pathlib.Path({ran!r}).touch()
from pywet.laws.force_law import force_law

@force_law
def law(separation, volume, radius_i, radius_j, contact_angle_i, contact_angle_j, surface_tension):
    return surface_tension * radius_i
"""


def pywet(*arguments: object) -> tuple[int, str]:
    """Exit code and all that a command said, blanks joined."""
    done = CliRunner(env={"COLUMNS": "400", "NO_COLOR": "1"}).invoke(app, [str(a) for a in arguments])
    assert done.exception is None or isinstance(done.exception, SystemExit), repr(done.exception)
    return done.exit_code, re.sub(r"\s+", " ", done.stderr + done.stdout)


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache."""
    monkeypatch.setenv("PYWET_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


# --- names and paths of a scene


@pytest.mark.parametrize(
    ("where", "value"),
    [
        (("name",), "case02\nshell touch pwned"),
        (("name",), "case02\x1b[2J"),
        (("name",), ""),
        (("name",), "x" * 81),
        (("classes", 0, "name"), "POM\r8 mm"),
        (("walls", 0, "name"), "wires all mesh/surface file x\nshell touch pwned\nfix a"),
        (("walls", 0, "name"), "wires all"),
        (("walls", 0, "name"), "${x}"),
        (("walls", 0, "name"), "gravity"),
        (("walls", 0, "name"), "side_wall"),
        (("walls", 0, "stl"), "stl/a.stl type 1\nshell touch pwned\n#"),
        (("walls", 0, "stl"), "stl/$(touch pwned).stl"),
        (("walls", 0, "stl"), "../../secret.stl"),
        (("walls", 0, "stl"), "/etc/passwd"),
        (("spheres_file",), "../other/spheres.parquet"),
        (("spheres_file",), "/etc/passwd"),
        (("effects", "capillary"), "rabinovich\nshell touch pwned"),
        (("effects", "rupture"), ""),
    ],
)
def test_a_scene_holds_no_name_that_an_engine_could_take_for_a_command(where: tuple[Any, ...], value: str) -> None:
    given = synthetic.scene().model_dump(mode="json")
    place = given
    for key in where[:-1]:
        place = place[key]
    place[where[-1]] = value
    with pytest.raises(ValidationError, match=r"name|path inside|pattern"):
        EngineScene.model_validate_json(json.dumps(given))


ODD = "a b#$HOME&'\"ä ${x} `y`"


@pytest.mark.engine
@pytest.mark.parametrize(("effects", "ranks"), [(small.DRY, 1), (small.PAPER, 2)])
def test_a_run_directory_with_any_name_works(effects: Any, ranks: int, tmp_path: Path) -> None:
    """Expect the same bits as in a plain folder: no path above the run directory enters the engine's script."""
    sphere = small.Sphere(1, (0.0, 0.0, 1.0e-3), velocity=(0.0, 0.0, -0.1))
    found = []
    for name in ("plain", ODD):
        liquid = WATER if effects.bridges else None
        small.prepare(
            tmp_path / name, spheres_of(1e-3), [sphere], contacts(1), liquid=liquid, effects=effects,
            walls=[small.floor()], steps=60, output_interval_s=3e-4, log_every_step=False,
        )  # fmt: skip
        small.run(tmp_path / name, [sphere], ranks)
        found.append(pd.read_parquet(tmp_path / name / "trajectory.parquet"))
    assert len(found[0]) == 3
    pd.testing.assert_frame_equal(*found, check_exact=True)


# --- laws in files


@pytest.fixture
def side(tmp_path: Path) -> tuple[Path, Path]:
    """A law's file, and the file that it makes when it is run."""
    (tmp_path / "law.py").write_text(SIDE.format(ran=str(tmp_path / "ran")))
    return tmp_path / "law.py", tmp_path / "ran"


def run_with(law: Path, folder: Path) -> Path:
    """Somebody else's run directory whose scene names the law."""
    synthetic.make(folder, moist=True)
    given = json.loads((folder / "scene.json").read_text())
    given["effects"]["capillary"] = f"{law}:law"
    (folder / "scene.json").write_text(json.dumps(given))
    return folder


def query_with(law: Path, path: Path) -> Path:
    query = {
        "bodies": [{"radius_m": 0.002, "contact_angle_deg": 10}, {"wall": "large", "contact_angle_deg": 30}],
        "volume_m3": 1e-10, "surface_tension_N_per_m": 0.07, "separations_m": [0.0],
        "laws": [f"{law}:law", "willett_unequal"],
    }  # fmt: skip
    path.write_text(json.dumps(query))
    return path


@pytest.mark.parametrize("command", ["timestep", "bridge"])
def test_a_law_that_somebody_else_names_runs_only_with_trust(
    command: str, side: tuple[Path, Path], tmp_path: Path, cache: Path
) -> None:
    law, ran = side
    folder = tmp_path / "given"
    folder.mkdir()
    file = run_with(law, tmp_path / "run") if command == "timestep" else query_with(law, folder / "query.json")
    code, output_text = pywet(command, file)
    assert code == 1
    assert f"{law} is not in or below the folder of a file that you passed" in output_text and "--trust" in output_text
    assert not ran.exists()
    code, output_text = pywet(command, file, "--trust")
    assert (code, ran.exists()) == (0, True), output_text


CUSTOM_SCENE = """
name: a bead with a law
duration_s: 0.001
materials: {glass: {density_kg_per_m3: 2500}}
liquid: {percent: 1}
laws: {capillary: LAW}
spheres: [{name: beads, material: glass, diameter_mm: 3, at_mm: [[0, 0, 2]]}]
"""


ASKED = {
    "sweep": {
        "name": "s", "base": {"scene": "base.yaml"}, "axes": {"liquid.percent": [1, 2]}, "gather": ["ruptures"],
    },
    "calibrate": {
        "name": "c", "targets": [{"scene": "base.yaml", "quantity": "bridges_per_sphere", "value": 1, "scatter": 0.1}],
        "parameters": {"liquid": {"keys": ["liquid.percent"], "low": 0.5, "high": 2.0}},
    },
}  # fmt: skip
"""A sweep and a calibration of the scene."""


def naming(command: str, law: str, folder: Path) -> list[str]:
    """Arguments of a command on a file in a folder that names the law."""
    if command == "bridge":
        return ["bridge", str(query_with(Path(law), folder / "query.json"))]
    if command == "run-scene":
        (folder / "scene.yaml").write_text(CUSTOM_SCENE.replace("LAW", f"{law}:law"))
        return ["run-scene", str(folder / "scene.yaml"), "--out", str(folder / "out")]
    if command in ("sweep", "calibrate"):
        (folder / "base.yaml").write_text(CUSTOM_SCENE.replace("LAW", f"{law}:law"))
        (folder / f"{command}.yaml").write_text(json.dumps(ASKED[command]))
        return [command, str(folder / f"{command}.yaml"), *(["--check"] if command == "sweep" else [])]
    if command == "liggghts":
        line = scripts.LINE.replace("wet.yaml", f"{folder}/wet.yaml")
        scripts.write(folder, line=line, wet=f"{scripts.WET}laws: {{capillary: {law}:law}}\n")
        return ["liggghts", "-in", str(folder / "in.script"), "--check"]
    shutil.copytree(ROOT / "config", folder / "config")
    settings = folder / "config" / "config.yaml"
    text = settings.read_text()
    assert "  preset: paper " in text
    settings.write_text(text.replace("  preset: paper ", f"  capillary: {law}:law\n  preset: paper ", 1))
    return ["plan", "2", "--config", str(folder / "config")]


@pytest.mark.parametrize("command", ["bridge", "run-scene", "plan", "sweep", "calibrate", "liggghts"])
def test_one_rule_for_laws_that_a_given_file_names(
    command: str, side: tuple[Path, Path], tmp_path: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the folder of the file that was given a law runs; elsewhere, also behind a link in that folder, only with --trust."""
    monkeypatch.setattr(stages, "simulate", lambda *_, **__: 1 / 0)  # the law is tested before the simulation
    law, ran = side
    folder = tmp_path / "given"
    folder.mkdir()
    arguments = naming(command, str(law), folder)
    code, output_text = pywet(*arguments)
    assert code == 1 and "move it below the file that names it, or give --trust" in output_text, output_text
    assert not ran.exists()
    shutil.rmtree(folder / "config", ignore_errors=True)
    arguments = naming(command, "law.py", folder)
    below = folder / ("config" if command == "plan" else "") / "law.py"
    below.symlink_to(law)
    assert pywet(*arguments)[0] == 1 and not ran.exists()
    below.unlink()
    shutil.copy(law, below)
    pywet(*arguments)
    assert ran.exists()
    ran.unlink()
    if command in ("calibrate", "liggghts"):  # these commands have no --trust
        return
    pywet(*naming_elsewhere(command, law, folder), "--trust")
    assert ran.exists()


def naming_elsewhere(command: str, law: Path, folder: Path) -> list[str]:
    """Write a configuration that names a law outside of the folder, with another text, so that it has not been tested yet."""
    other = law.with_name("other.py")
    other.write_text(law.read_text() + "# other\n")
    shutil.rmtree(folder / "config", ignore_errors=True)
    return naming(command, str(other), folder)


@pytest.mark.parametrize("command", ["replay", "compare", "vtk"])
def test_no_other_command_runs_a_law_of_a_run_directory(
    command: str, side: tuple[Path, Path], tmp_path: Path, cache: Path
) -> None:
    law, ran = side
    folder = run_with(law, tmp_path / "run")
    if command == "vtk":
        from pywet import stages

        stages.vtk(folder)
    else:
        pywet(command, *[folder] * (2 if command == "compare" else 1))
    assert not ran.exists()


def test_a_law_of_the_configuration_runs_as_it_was_when_it_was_named(
    side: tuple[Path, Path], tmp_path: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Named by its way from the configuration, it is known from every folder; a changed file has to be named again."""
    made, ran = side
    shutil.copytree(ROOT / "config", tmp_path / "config")
    text = (tmp_path / "config" / "config.yaml").read_text()
    (tmp_path / "config" / "config.yaml").write_text(
        text.replace("  preset: paper", "  preset: paper\n  capillary: law.py:law", 1)
    )
    law = Path(shutil.copy(made, tmp_path / "config"))
    monkeypatch.chdir(tmp_path)
    name = config.load(Path("config")).settings.laws.capillary
    assert name == f"{law}:law"
    assert not ran.exists()  # reading a configuration runs nothing
    monkeypatch.chdir("/")
    assert registry.get("capillary", name).functions[0](0.0, 1e-11, 2.0, 1.0, 0.0, 0.0, 0.5) == 1.0
    law.write_text(law.read_text() + "\n")
    with raises_code("law.untrusted"):
        registry.get("capillary", name)


LOOP = """
from pywet.laws.force_law import force_law

@force_law
def law(speed, viscosity, surface_tension):
    n = 1.0
    while n > 0.0:
        n += speed - speed
    return n
"""


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("import time\ntime.sleep(1e6)", "law.endless"),
        ("while True: pass", "law.endless"),
        (LOOP, "law.endless"),
        ("import os\nos._exit(0)", "law.ends_program"),
        ("import os\nos.abort()", "law.ends_program"),
        ("import sys\nsys.exit(7)", "law.raises"),
        ("raise KeyError('x')", "law.raises"),
        ("law = 1\n\0", "law.raises"),
        ("def law(:", "law.raises"),
    ],
)
def test_a_law_that_does_not_end_or_ends_the_program_is_one_sentence(
    text: str, code: str, tmp_path: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if "while" in text or "sleep" in text:
        monkeypatch.setattr(custom_laws, "TRIAL_S", 4 if "while" in text else 1)
    path = tmp_path / "law.py"
    path.write_text(text)
    custom_laws.trust([f"{path}:law"])
    with raises_code(code) as refusal:
        registry.get("dynamic_rupture", f"{path}:law")
    assert "\n" not in str(refusal.value) and str(path) in str(refusal.value)


def test_no_child_takes_modules_from_the_folder_it_works_in() -> None:
    """Python's -P: a run directory, or the working folder, may hold a numpy.py."""
    started = [t for p in (ROOT / "pywet").rglob("*.py") for t in re.findall(r"sys.executable, .*", p.read_text())]
    assert len([t for t in started if t.startswith('sys.executable, "-P", "-m"')]) >= 3
    assert not [t for t in started if t.startswith('sys.executable, "-m"')]


# --- the cache


def test_the_cache_is_private_and_where_it_should_be(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PYWET_CACHE", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert caches.folder("below") == tmp_path / "xdg" / "pywet" / "below"
    assert (tmp_path / "xdg" / "pywet").stat().st_mode & 0o777 == 0o700
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert caches.folder() == tmp_path / "home" / ".cache" / "pywet"
    (tmp_path / "file").write_text("")  # a home that even root cannot write
    monkeypatch.setenv("HOME", str(tmp_path / "file"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    assert caches.folder() == tmp_path / f"pywet-{os.getuid()}"
    assert caches.folder().stat().st_mode & 0o777 == 0o700


def other_owner(path: Path) -> None:
    os.chown(path, 65534, 65534)


def link_of_another(path: Path) -> None:
    path.rename(path.with_name("target"))
    path.symlink_to(path.with_name("target"))
    os.chown(path, 65534, 65534, follow_symlinks=False)


@pytest.mark.parametrize(
    ("spoil", "code"),
    [
        (lambda path: path.chmod(0o777), "cache.mode"),
        (lambda path: path.chmod(0o770), "cache.mode"),
        (other_owner, "cache.owner"),
        (link_of_another, "cache.owner"),
    ],
)
def test_a_folder_that_others_could_fill_is_refused(
    spoil: Callable[[Path], None], code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if code == "cache.owner" and os.getuid() != 0:
        pytest.skip("only root can give a folder away")
    injected = tmp_path / f"pywet-{os.getuid()}"
    injected.mkdir(mode=0o700)
    spoil(injected)
    monkeypatch.delenv("PYWET_CACHE", raising=False)
    monkeypatch.setenv("HOME", "/dev/null")
    monkeypatch.setenv("XDG_CACHE_HOME", "/dev/null")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with raises_code(code):
        caches.folder()


def test_a_plugin_that_is_not_what_was_built_is_built_anew(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    built: list[Path] = []

    def compile_(target: Path) -> None:
        target.write_bytes(b"the plugin" * 100)
        caches.seal(target)
        built.append(target)

    monkeypatch.setattr(build, "_compile", compile_)
    monkeypatch.setattr(build, "source_hash", lambda: "0123")
    path = build.cached()
    path.write_bytes(b"injected")
    for spoil in (
        lambda: None,  # injected without a check sum
        lambda: path.write_bytes(path.read_bytes()[:500]),  # cut
        lambda: path.write_bytes(b"injected"),
        lambda: path.with_name(path.name + caches.SEAL).unlink(),
        lambda: path.with_name(path.name + caches.SEAL).write_bytes(b"\xff"),
        path.unlink,
    ):
        spoil()
        count = len(built)
        assert build.plugin_path().read_bytes() == b"the plugin" * 100
        build.plugin_path()
        assert len(built) == count + 1


def test_damaged_machine_code_counts_as_missing(tmp_path: Path) -> None:
    files = machine_code.CheckedFiles(str(tmp_path), "law", "stamp")
    files.save("key", {"code": b"abc" * 50})
    assert files.load("key") == {"code": b"abc" * 50}
    assert machine_code.CheckedFiles(str(tmp_path), "law", "another text").load("key") is None
    for name in ("law.nbi", "law.1.nbc"):
        good = (tmp_path / name).read_bytes()
        flipped = bytearray(good)
        flipped[-3] ^= 4
        for bad in (b"", good[: len(good) // 2], bytes(flipped), b"injected"):
            (tmp_path / name).write_bytes(bad)
            assert files.load("key") is None
        files.save("key", {"code": b"abc" * 50})
        assert files.load("key") == {"code": b"abc" * 50}


def test_machine_code_is_stored_under_all_sources_that_are_compiled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """numba alone looks at the file of the cached function only, and for it where it lies: another checkout has nothing ready.

    And whoever asks it to keep has it look in that folder.
    """
    for package in sources.COMPILED:
        shutil.copytree(ROOT / "pywet" / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    before = machine_code.key()
    monkeypatch.setattr(sources, "PACKAGE", tmp_path)
    elsewhere = machine_code.key()
    assert elsewhere != before
    assert machine_code.key() == elsewhere
    with (tmp_path / "laws" / "viscous.py").open("a") as file:
        file.write("#\n")
    assert machine_code.key() not in (before, elsewhere)
    for path in (ROOT / "pywet").rglob("*.py"):
        if "cache=True" in path.read_text():
            assert "from pywet.util.machine_code import" in path.read_text(), path
            assert path.relative_to(ROOT / "pywet").parts[0] in sources.COMPILED, path


def test_laws_of_one_text_that_enclose_other_values_are_not_stored() -> None:
    """Files of one name would hold the code of many laws."""
    for film, expected in ((0.02, 3.616892e-4), (0.08, 5.794478e-4)):  # 2 pi eta a ln((2 d' - h)/h), a = 0.5 mm
        law = davis.tangential(film)[0]
        assert law(1e-6, 1e-3, 1e-3, 0.05) == pytest.approx(expected, rel=1e-6)
        assert law.compiled._cache.cache_path is None
    assert viscous.pitois.compiled._cache.cache_path.startswith(machine_code.numba.config.CACHE_DIR)


@pytest.fixture
def open_folder() -> Iterator[Path]:
    """A temporary folder that every user can write and reach, which pytest's own is not."""
    with tempfile.TemporaryDirectory() as name:
        Path(name).chmod(0o1777)
        yield Path(name)


@pytest.mark.skipif(os.getuid() != 0 or shutil.which("setpriv") is None, reason="only root can become another user")
def test_a_user_without_a_home_can_work(open_folder: Path) -> None:
    """The checkout is read-only for nobody, who has no home: everything goes into a private folder below TMPDIR."""
    become = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"]
    # Python may be installed in root's home
    become += ["--inh-caps=+dac_read_search", "--ambient-caps=+dac_read_search"]
    if subprocess.run([*become, sys.executable, "-c", ""], check=False, stderr=subprocess.DEVNULL).returncode:
        pytest.skip("nobody cannot start this Python")
    environment = {
        "PATH": os.environ["PATH"], "HOME": "/nonexistent", "TMPDIR": str(open_folder), "PYTHONPATH": str(ROOT),
        "OPENBLAS_NUM_THREADS": "1",
    }  # fmt: skip
    law = "from pywet.laws import capillary; print(capillary.lambert(0.0, 1e-11, 1e-3, 1e-3, 0.0, 0.0, 1.0))"
    for arguments in (["-m", "pywet.cli.app", "laws"], ["-c", law]):
        done = subprocess.run(
            [*become, sys.executable, *arguments], cwd=open_folder, env=environment, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
    assert float(done.stdout) == pytest.approx(6.2831853e-3, rel=1e-6)  # 4 pi sigma r_red at touch
    stored = open_folder / "pywet-65534"
    assert (stored.stat().st_uid, stored.stat().st_mode & 0o777) == (65534, 0o700)
    assert list(stored.rglob("*.nbc"))


@pytest.mark.parametrize("variable", ["NUMBA_CACHE_DIR", "XDG_CACHE_HOME"])
def test_machine_code_is_not_loaded_from_a_folder_open_to_all(variable: str, tmp_path: Path) -> None:
    """Its pickles would run: an own folder is taken in its place."""
    shared = tmp_path / "shared"
    shared.mkdir()
    shared.chmod(0o777)
    code = (
        "from pywet.util import machine_code as m; print(m._settings.CACHE_DIR); "
        "from pathlib import Path; from pywet.util import caches; print(caches.folder())"
    )
    surroundings = {
        k: v for k, v in os.environ.items() if k not in ("PYWET_CACHE", "NUMBA_CACHE_DIR", "XDG_CACHE_HOME")
    }
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=surroundings | {"HOME": str(tmp_path / "home"), "TMPDIR": str(tmp_path), variable: str(shared)},
        capture_output=True, text=True, check=True, cwd=ROOT,
    )  # fmt: skip
    for folder in map(Path, done.stdout.split()):
        assert not folder.is_relative_to(shared)
        assert folder.stat().st_mode & 0o777 == 0o700
    assert not any(shared.iterdir())
    if variable == "NUMBA_CACHE_DIR":
        assert (
            f"{shared} can be written by others (mode 777)" in done.stderr
            and "machine code is stored in" in done.stderr
        )


def test_the_reference_keeps_nothing_in_a_folder_open_to_all(tmp_path: Path) -> None:
    shared = tmp_path / "shared"
    shared.mkdir()
    for mode, stored in ((0o777, "False"), (0o700, "True")):
        shared.chmod(mode)
        code = "from reference_impl import compiled; print(compiled.CACHED)"
        done = subprocess.run(
            [sys.executable, "-c", code], env=os.environ | {"NUMBA_CACHE_DIR": str(shared)}, capture_output=True,
            text=True, check=True, cwd=ROOT,
        )  # fmt: skip
        assert done.stdout.strip() == stored


# --- programs that hang


@pytest.mark.parametrize("program", ["liggghts", "g++"])
def test_the_doctor_ends_though_a_program_hangs(
    program: str, tmp_path: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where the shell that is ended leaves behind what it started, which keeps the pipe open."""
    script = tmp_path / program
    script.write_text("#!/bin/sh\nsleep 1000\necho late\n")
    script.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    monkeypatch.setattr(process, "ANSWER_S", 1.0)
    name = "plugin" if program == "g++" else program
    found = next(check for check in doctor.checks() if check.name == name)
    assert not found.ok
    assert f"{program} did not answer within 1 s" in found.sentence()
