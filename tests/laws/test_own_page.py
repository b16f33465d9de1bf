"""docs/howto-own-law.md as a reader follows it: the example as it is printed, in a configuration and as a single bridge."""

from __future__ import annotations

import ctypes
import json
import math
import re
import shutil
from pathlib import Path

import numba
import pytest
from typer.testing import CliRunner

import pywet.laws.young_laplace
from pywet import config
from pywet.cases.screening import cases
from pywet.cli.app import app
from pywet.laws import custom_laws, registry
from pywet.laws import young_laplace as exact
from pywet.laws.batch import batch
from pywet.laws.capillary import rabinovich
from pywet.laws.force_law import force_law
from pywet.runs import record
from tests.error_codes import code_of, raises_code
from tests.test_docs import check_shown

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "howto-own-law.md").read_text()


def block(language: str, number: int = 0) -> str:
    """A block of a language on the page."""
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)[number]


@pytest.fixture
def followed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the page's law and bridge, and a configuration that names the law, in a cache of its own."""
    monkeypatch.setenv("PYWET_CACHE", str(tmp_path / "cache"))
    study = tmp_path / "study"
    shutil.copytree(ROOT / "config", study)
    text = (study / "config.yaml").read_text()
    (study / "config.yaml").write_text(re.sub(r"^laws:\n(  .*\n)+", block("yaml"), text, count=1, flags=re.MULTILINE))
    (study / "my_law.py").write_text(block("python"))
    (study / "my_bridge.json").write_text(block("json"))
    return study


def test_a_configuration_finds_the_law_beside_it(followed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From whichever folder pywet is called; the plan has tried it."""
    monkeypatch.chdir("/")
    loaded = config.load(followed)
    assert loaded.settings.laws.capillary == f"{followed / 'my_law.py'}:constant_neck"
    plan = cases.ingredients(loaded, 2, "smoke").plan
    assert plan.effects.capillary == f"{followed / 'my_law.py'}:constant_neck"


def test_a_law_that_calls_a_registered_law(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The page's `half` gives half of `rabinovich`: as a call, as a C function and inlined in a batch; a law may call it too."""
    monkeypatch.setenv("PYWET_CACHE", str(tmp_path / "cache"))
    law = tmp_path / "half_law.py"
    names = "separation, volume, radius_i, radius_j, contact_angle_i, contact_angle_j, surface_tension"
    law.write_text(f"{block('python', 1)}\n\n@force_law\ndef same({names}):\n    return 2.0 * half({names})\n")
    custom_laws.trust([f"{law}:half"])
    given = (1e-5, 1e-11, 1e-3, 2e-3, 0.2, 0.4, 0.07)
    for name, factor in (("half", 0.5), ("same", 1.0)):
        (function,) = registry.get("capillary", f"{law}:{name}").functions
        wanted = factor * rabinovich(*given)
        assert function(*given) == pytest.approx(wanted, rel=1e-15)
        assert ctypes.CFUNCTYPE(ctypes.c_double, *[ctypes.c_double] * 7)(function.address)(*given) == pytest.approx(
            wanted, rel=1e-15
        )
        assert batch((function,)).inlined and not function.tabulated


def test_a_law_that_calls_the_exact_bridge_gets_its_tables() -> None:
    """However its function reaches it: by name, through modules, through a helper."""

    @numba.njit
    def helper(gap: float) -> float:
        return exact.young_laplace(gap, 1e-11, 1e-3, 1e-3, 0.0, 0.0, 0.07)

    def by_helper(separation: float) -> float:
        return helper(separation)

    def by_module(separation: float) -> float:
        return pywet.laws.young_laplace.young_laplace(separation, 1e-11, 1e-3, 1e-3, 0.0, 0.0, 0.07)

    for function in (by_helper, by_module):
        assert force_law(function).calls == (exact.young_laplace,) and force_law(function).tabulated
    for law, cached in ((force_law(by_module), False), (exact.young_laplace, False), (rabinovich, True)):
        assert law._compile(lambda in_file: in_file) is cached  # addresses of tables are those of one process


def test_laws_are_found_in_their_package() -> None:
    """A name that several laws have is answered with where each is."""
    assert pywet.laws.rabinovich is rabinovich
    with pytest.raises(
        AttributeError, match=r"expected pywet.laws.capillary_fits.willett or pywet.laws.rupture.willett$"
    ):
        pywet.laws.willett  # noqa: B018
    with pytest.raises(AttributeError, match="expected a module or a law that `pywet laws` lists"):
        pywet.laws.rabinowitsch  # noqa: B018


def test_the_law_of_a_run_is_tried_before_it_starts(followed: Path) -> None:
    law = followed / "my_law.py"
    law.write_text(law.read_text().replace("return 4.0", "return -4.0"))
    done = CliRunner().invoke(app, ["run", "2", "--config", str(followed), "--out", str(followed / "run")])
    assert done.exit_code == 1 and "expected a force of 0 or more" in done.stderr
    assert not (followed / "run" / "engine").exists()


@pytest.mark.engine
def test_the_bridge_of_the_page(followed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In Python and inside the engine the force is 4 pi sigma r_red cos(theta), whatever the gap; then with a law of formation
    next to it, by which the engine forms the bridge."""
    monkeypatch.chdir(followed)
    wanted = 4.0 * math.pi * 0.0728 * 0.00125 * math.cos(math.radians(10.0))
    for more in ([], ["--engine", "liggghts"]):
        done = CliRunner().invoke(app, ["bridge", "my_bridge.json", "--trust", *more])
        assert done.exit_code == 0, done.stderr
        forces = json.loads(done.stdout)["force_N"]
        assert forces[f"{followed / 'my_law.py'}:constant_neck"] == pytest.approx([wanted] * 3, rel=1e-9)
    (followed / "laws.py").write_text(LAWS)
    query = {**json.loads(block("json")), "laws": ["laws.py:halves", "my_law.py:constant_neck"], "separations_m": [0.0]}
    (followed / "q.json").write_text(json.dumps(query))
    done = CliRunner().invoke(app, ["bridge", "q.json", "--trust", "--engine", "liggghts"])
    assert done.exit_code == 0, done.stderr
    assert json.loads(done.stdout)["volume_m3"] == pytest.approx(1e-10, rel=1e-9)


def test_a_second_function_goes_to_the_reference(followed: Path) -> None:
    """Named next to the law; what it is refused for is said as the configuration is read."""
    file = followed / "config.yaml"
    file.write_text(file.read_text().replace("laws:\n", "laws:\n  reference: {capillary: my_reference.py:neck}\n", 1))
    with raises_code("law.no_reference"):
        config.load(followed)
    text = block("python", 2)
    (followed / "my_reference.py").write_text(text.replace("separation,", "separation, more,"))
    with raises_code("law.reference_arguments"):
        config.load(followed)
    (followed / "my_reference.py").write_text(text)
    name = f"{followed / 'my_reference.py'}:neck"
    loaded = config.load(followed)
    assert loaded.settings.laws.reference == {"capillary": name} and custom_laws.may_run(name)
    record.leave_reference(followed, loaded.settings.laws.reference)
    assert record.same_reference(followed, loaded.settings.laws.reference) and record.reference(followed) == {
        "capillary": name
    }
    (followed / "my_reference.py").write_text(text + "\n")
    assert not record.same_reference(followed, loaded.settings.laws.reference) and record.reference(followed) == {}
    file.write_text(file.read_text().replace("capillary: my_law.py:constant_neck", "capillary: willett"))
    with raises_code("config.inconsistent", says="only together with a custom law"):
        config.load(followed)


LAWS = """
from pywet.laws.force_law import force_law

@force_law
def longer(volume, radius_i, radius_j, contact_angle_i, contact_angle_j):
    return 2.0 * volume ** (1.0 / 3.0)

@force_law
def drag(separation, volume, radius_i, radius_j, normal_velocity, viscosity):
    return -1e-3 * normal_velocity

@force_law
def slip(separation, radius_i, radius_j, viscosity):
    return 3.0 * viscosity * radius_i

@force_law
def steady(speed, viscosity, surface_tension):
    return 1.25

@force_law
def nearly(volume, radius_i, radius_j, angle_i, angle_j):
    return 1.0

@force_law
def half_film(film_volume_i, radius_i, radius_j):
    return 0.5 * film_volume_i

@force_law
def half_at_wire(film_volume_i, radius_i, half_width):
    return 0.5 * film_volume_i

@force_law
def of_wall(film_thickness, radius_i):
    return film_thickness * radius_i * radius_i

@force_law
def of_wire(film_thickness, radius_i, half_width):
    return film_thickness * radius_i * half_width

sideways = (slip, slip)
halves = (half_film, half_at_wire, of_wall, of_wire)
"""


def test_a_bridge_takes_laws_of_every_kind_that_it_asks(followed: Path) -> None:
    """Each is identified by its arguments; what they give is in the answer under their names."""
    file, query = followed / "laws.py", json.loads(block("json"))
    file.write_text(LAWS)
    query["laws"] = [f"laws.py:{name}" for name in ("longer", "drag", "sideways", "steady", "halves")]
    (followed / "q.json").write_text(json.dumps({**query, "velocity_m_per_s": 0.1, "viscosity_Pa_s": 0.01}))
    done = CliRunner().invoke(app, ["bridge", str(followed / "q.json"), "--trust"])
    assert done.exit_code == 0, done.stderr
    answer = json.loads(done.stdout)
    distance = 2.0 * 1e-10 ** (1 / 3)
    assert answer["rupture_distance_m"][f"{file}:longer"] == pytest.approx(distance)
    assert answer["rupture_used_m"]["rabinovich"] == pytest.approx(distance)
    assert answer["viscous_normal_N"][f"{file}:drag"] == pytest.approx([1e-4] * 3)
    assert answer["viscous_tangential_kg_per_s"][f"{file}:sideways"] == [pytest.approx([3e-2 * 0.0025] * 3)] * 2
    assert answer["dynamic_rupture_factor"] == 1.25
    film = math.cbrt(3.0 * 1e-10 / (4.0 * math.pi) + 0.0025**3) - 0.0025  # each of two films gives half of its liquid
    assert answer["film_thickness_m"][f"{file}:halves"] == pytest.approx(film, rel=1e-9)


def test_a_law_that_draws_no_such_volume_is_refused(followed: Path) -> None:
    text = LAWS.replace("return 0.5 * film_volume_i", "return min(0.5 * film_volume_i, 1e-12)")
    (followed / "laws.py").write_text(text)
    (followed / "q.json").write_text(json.dumps({**json.loads(block("json")), "laws": ["laws.py:halves"]}))
    done = CliRunner().invoke(app, ["bridge", str(followed / "q.json"), "--trust"])
    assert (done.exit_code, code_of(done)) == (1, "bridge.no_film")


def test_the_table_prints_what_a_law_is_off_the_exact_bridge(followed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The exact force is the reference's, which shares nothing with the solver that the command uses."""
    from reference_impl.bridge import bridge as second

    monkeypatch.chdir(followed.rename(followed.with_name("config")).parent)
    command = "pywet bridge config/my_bridge.json --trust --table --plot neck.svg"
    done = CliRunner().invoke(app, command.split()[1:])
    assert done.exit_code == 0, done.stderr
    check_shown(command, done.stdout)
    angle, wanted = math.radians(10.0), 4.0 * math.pi * 0.0728 * 0.00125 * math.cos(math.radians(10.0))
    rows = [line.split() for line in done.stdout.splitlines() if line.strip().startswith("my_law.py:")]
    assert [float(row[1]) for row in rows] == [0.0, 100.0, 200.0]
    for row, gap in zip(rows, (0.0, 1e-4, 2e-4), strict=True):
        exact = 0.0728 * second.solve(gap, 1e-10, 0.0025, 0.0025, angle, angle).force
        assert float(row[3]) == pytest.approx(1e3 * exact, rel=1e-5)
        assert float(row[4]) == pytest.approx(100.0 * (wanted / exact - 1.0), rel=0.05)  # two digits are printed


def test_the_drawing_holds_the_law_and_the_exact_force(followed: Path) -> None:
    from pywet.cases.small import bridge_query
    from pywet.report import bridge

    query = bridge_query.read(followed / "my_bridge.json")
    custom_laws.trust(query.laws)
    answer, exact = bridge_query.answer(query), bridge_query.exact_force(query)
    lines = {line.get_label(): line for line in bridge.figure(query.separations_m, answer, exact).axes[0].lines}
    assert lines["my_law.py:constant_neck"].get_ydata() == pytest.approx(
        [1e3 * answer["force_N"][query.laws[0]][0]] * 3
    )
    assert lines["exact (Young-Laplace)"].get_ydata() == pytest.approx([1e3 * value for value in exact])
    assert any(str(label).startswith("rupture: ") for label in lines)
    assert not [label for label in lines if str(label).startswith("_")]
    picture = followed / "my.svg"
    done = CliRunner().invoke(app, ["bridge", str(followed / "my_bridge.json"), "--trust", "--plot", str(picture)])
    assert done.exit_code == 0 and picture.read_text().startswith("<?xml")


def test_a_law_of_other_arguments_is_refused_with_what_its_kind_expects(followed: Path) -> None:
    (followed / "laws.py").write_text(LAWS)
    name = f"{followed / 'laws.py'}:nearly"
    assert custom_laws.kind_of(name) == "rupture"
    (followed / "q.json").write_text(json.dumps({**json.loads(block("json")), "laws": [name]}))
    done = CliRunner().invoke(app, ["bridge", str(followed / "q.json"), "--trust"])
    assert done.exit_code == 1
    assert "expected (volume, radius_i, radius_j, contact_angle_i, contact_angle_j)" in done.stderr
