"""What the text of a script gives: variables, spheres, meshes, materials; and what `--check` says of it."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from pywet.cases.script.check import check
from pywet.cases.script.facts import facts, height_m, triangles_of
from pywet.cases.script.scan import commands, meshes_of, scan
from pywet.cases.script.variables import Variables
from pywet.geometry.stl import write_stl
from tests.cases.script.scripts import BEFORE, PLATE_ALONE, SHAKEN, WET, write
from tests.cases.script.test_examples import prepare


def test_variables_with_numbers_words_and_arithmetic() -> None:
    """As the engine fills them in; what it alone can know stays as it is, and the command line comes first."""
    variables = Variables(["-log", "none", "-var", "n", "7"])
    for line in (
        "variable r equal 0.5*3e-3", "variable d equal 2*v_r^1", "variable m string sjkr", "variable n index 3 4",
        "variable k loop 5", "variable q equal step*2", "variable e equal ramp(1,2)",
    ):  # fmt: skip
        variables.learn(line.split())
    assert variables.filled(["${r}", "${d}", "$m.in", "${n}"]) == ["0.0015", "0.003", "sjkr.in", "7"]
    assert variables.filled(["${k}", "${q}", "${e}"]) == ["${k}", "${q}", "${e}"]


def test_variables_that_a_command_within_another_sets_are_unknown(tmp_path: Path) -> None:
    """Those of `if`, and those that `next` moves on; what is set again after it, or by the command line, is known."""
    script = tmp_path / "in.script"
    script.write_text(
        "variable a string water\nvariable b string water\nvariable c index 1 2\nvariable d index 1 2\n"
        'if "${k} == 1" then "variable a string oil" "variable b string oil" else "variable e index 5"\n'
        'run 100 every 10 "next d"\nvariable b string dry\nvariable e index 6\nnext c\nvariable v string no\n'
        'if "1 > 0" then "variable v string no"\nprint ${a} ${b} ${c} ${d} ${e} ${v}\n'
    )
    last = list(commands(script, variables=Variables(["-var", "v", "given"])))[-1]
    assert last == ["print", "${a}", "dry", "${c}", "${d}", "${e}", "given"]


def test_lines_that_end_as_in_other_systems_are_read_alike(tmp_path: Path) -> None:
    for name, end in (("unix", "\n"), ("windows", "\r\n")):
        (tmp_path / name).write_bytes(BEFORE.replace("\n", end).encode())
    rows = [list(commands(tmp_path / name)) for name in ("unix", "windows")]
    assert rows[0] == rows[1] and ["pair_style", "gran", "model", "hertz", "tangential", "history"] in rows[1]


@pytest.mark.parametrize(
    ("words", "expected"),
    [("chute 30", (4.905, 0.0, -8.4957)), ("spherical 90 150", (0.0, 4.905, -8.4957)), ("vector 0 3 -4", (0.0, 5.886, -7.848)),
     ("chute ${a}", None), ("gradient 0 180 0 10", None), ("vector 0 0", None)],
)  # fmt: skip
def test_gravity_in_every_style_is_known_or_named(words: str, expected: tuple[float, ...] | None) -> None:
    found = facts([["fix", "g", "all", "gravity", "9.81", *words.split()]])
    assert found.gravity == (None if expected is None else pytest.approx(expected, abs=1e-4))
    assert found.hidden == (["gravity"] if expected is None else [])


def test_values_that_only_the_engine_knows_are_not_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither by those of the next atom type nor by zero: the quantity is named, and nothing is estimated from it."""
    monkeypatch.chdir(tmp_path)
    before = BEFORE.replace("youngsModulus peratomtype 5.e6", "youngsModulus peratomtype ${soft} 5.e6")
    script = write(tmp_path, before=before.replace("0.0 0.0 -1.0", "0.0 ${tilt} -1.0"))
    found = facts(scan(script).rows)
    assert found.hidden[:2] == ["youngsModulus", "gravity"] and "youngsModulus" not in found.materials
    assert found.gravity is None and found.materials["poissonsRatio"] == (0.45,)
    lines = check(write(tmp_path, before=BEFORE.replace("0.0 0.0 -1.0", "0.0 ${tilt} -1.0")))[0]
    assert any("no stable one to compare it with" in line for line in lines)


def test_what_the_text_does_not_give_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The material of a mesh in a variable that the engine computes, and spheres of a data file that is not one of spheres."""
    monkeypatch.chdir(tmp_path)
    script = write(
        tmp_path,
        before=SHAKEN.replace("plate.stl type 1", "plate.stl type ${late}"),
        wet=WET.replace("dry", PLATE_ALONE),
    )
    (tmp_path / "no.data").write_text("Atoms\n\n1 one 0.004 2500 0 0 0\n2 1 0.0 2500 0 0 0\n")
    script.write_text(f"read_data no.data\n{script.read_text()}")
    found, lines = facts(scan(script).rows), check(script)[0]
    assert [mesh.atom_type for mesh in found.meshes] == [None]
    assert any(line.startswith("  mesh plate: 2 triangles, material not known, wall") for line in lines)
    assert {"material of mesh plate", "spheres of no.data"} <= set(found.hidden)


def test_what_the_text_gives(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    found = facts(scan(write(tmp_path, before=SHAKEN, wet=WET.replace("dry", PLATE_ALONE))).rows)
    assert [(k.atom_type, k.radius_m, k.density_kg_per_m3) for k in found.kinds] == [(1, 2e-3, 2500), (1, 3e-3, 2500)]
    assert [(m.name, m.triangles, m.wall) for m in found.meshes] == [("plate", 2, True)]
    assert sorted(found.primitives) == ["x1", "x2", "y1", "y2", "z1"] and found.primitives["x1"] == "xplane -0.02"
    assert found.material("coefficientRestitution", 1, 1) == 0.6 and found.material("youngsModulus", 1) == 5e6
    assert found.material("youngsModulus", 2) is None
    assert (found.time_step_s, found.skin_m, found.normal_model) == (1e-5, 2e-3, "hertz")
    assert found.gravity == (0.0, 0.0, -9.81) and height_m(found) == pytest.approx(0.08)


def test_triangles_of_text_and_binary(tmp_path: Path) -> None:
    from pywet.geometry.solids import plate, polygon
    from pywet.geometry.surface import make_surface

    disc = make_surface("disc", "wall", plate(polygon(0.01, 8), 0.0, 0.003))
    write_stl(disc, tmp_path / "disc.stl")
    write(tmp_path)
    assert triangles_of(tmp_path / "disc.stl") == len(disc.triangles) and triangles_of(tmp_path / "plate.stl") == 2
    assert triangles_of(tmp_path / "none.stl") is None


def test_check_of_an_example(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The film that one per cent makes, h = 0.01 rho_s/(3 rho_l) r for thin ones; Hertz's limits; each effect and why."""
    prepare(tmp_path / "a", "mixer")
    monkeypatch.chdir(tmp_path / "a")
    lines, problems = check(Path("in.script"))
    assert problems == []
    text = "\n".join(lines)
    thickness = 2e-3 * ((1 + 0.01 * 2.5) ** (1 / 3) - 1)
    assert f"film {1e6 * thickness:.3g} um" in text
    wave = math.pi * 2e-3 * math.sqrt(2500 / (5e6 / 2.9)) / (0.1631 * 0.45 + 0.8766)
    assert f"Rayleigh time / 5    {wave / 5:.2e} s" in text and "time step 1e-05 s is 0." in text
    assert "mesh vessel: " in text and " triangles, material 1, wall" in text
    assert "wall_films         on  vessel, paddle" in text and "capillary          on  rabinovich: preset paper" in text


@pytest.mark.parametrize(
    ("models", "more", "known"),
    [
        ("hooke tangential history", "fix v all property/global characteristicVelocity scalar 0.5\n", True),
        ("hooke/stiffness tangential history", "fix k all property/global kn peratomtypepair 1 1e4\n"
         "fix s all property/global kt peratomtypepair 1 3e3\n", True),
        ("thornton_ning", "", False),
    ],
)  # fmt: skip
def test_stable_step_of_other_contact_models(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, models: str, more: str, known: bool
) -> None:
    """2 sqrt(m/(4 k)) of two spheres in a packing where no dashpot counts; a model that is not known says so."""
    monkeypatch.chdir(tmp_path)
    before = BEFORE.replace("model hertz &\n                tangential history", f"model {models}")
    before = before.replace("pair_style", f"{more}pair_style").replace("peratomtypepair 1 0.6", "peratomtypepair 1 1.0")
    lines = check(write(tmp_path, before=before))[0]
    if not known:
        assert any("no stable one to compare it with" in line for line in lines)
        return
    mass = 4 / 3 * math.pi * 2e-3**3 * 2500 / 2
    modulus = 5e6 / (2 * (1 - 0.45**2))
    root = modulus * math.sqrt(1e-3)
    spring = 16 / 15 * root * (15 * mass * 0.25 / (16 * root)) ** 0.2 if "kn" not in more else 1e4
    side = 3.5 * (spring if "kn" not in more else 3e3)
    step = math.sqrt(mass / max(spring, side))
    assert any(line.strip().startswith(f"contact              {step:.2e} s") for line in lines), lines


def test_a_formula_that_the_engine_reads_otherwise_than_python_is_unknown() -> None:
    """Without brackets -2^2 is 4 and 2^3^2 is 64 there; a root of a negative number is none."""
    known = Variables(())
    for name, formula in (("a", "-2^2"), ("b", "2^3^2"), ("c", "(-8)^0.5"), ("d", "(2^3)^2")):
        known.learn(["variable", name, "equal", formula])
    assert [known.filled([f"${{{name}}}"]) for name in "abcd"] == [["${a}"], ["${b}"], ["${c}"], ["64"]]


def test_commands_within_commands_that_are_empty_or_have_a_quote_are_no_error(tmp_path: Path) -> None:
    script = tmp_path / "in.script"
    script.write_text('if "1 > 2" then "" else "print hello"\nif "1 > 2" then "print it\'s"\n')
    assert [words[0] for words in commands(script)] == ["if", "print", "if", "print"]
    assert (
        meshes_of(["fix", "w", "all", "wall/gran", "model", "hooke", "mesh", "n_meshes", "${n}", "meshes", "a", "b"])
        == []
    )
