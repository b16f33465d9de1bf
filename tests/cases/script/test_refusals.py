"""Every mistake in a script or its liquid, by its code; each is said in one sentence."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from pywet.cases.script.check import check
from pywet.cases.script.refusals import SENTENCES, of_box, of_state, refusal
from pywet.cases.script.scan import scan
from pywet.cases.script.scene import Spheres, reach, too_thick
from pywet.cases.script.wet import Wet
from pywet.cli.app import app
from pywet.config.loading import parse
from pywet.engines.liggghts.plugin_api import NEWCOMER
from pywet.errors import ConfigError, PywetError
from pywet.laws.kinds import KINDS
from tests.cases.script.scripts import AFTER, BEFORE, LINE, PLATE_ALONE, SHAKEN, WET, write
from tests.error_codes import raises_code

STATE: dict[str, Any] = {
    "ranks": 1, "layers": 1, "ghost_velocity": 1, "least_radius": 2e-3, "largest_radius": 3e-3,
    "step": 1, "last": -1, "time_step": 1e-5, "spheres": 2, "map": 1, "newton": 0, "delay": 0, "every": 1,
    "check": 1, "contact_distance_factor": 1.0, "skin": 2e-3, "periodic": [0.0, 0.0, 0.0], "tilted": 0, "reach": 8e-3,
    "coarsegraining": 0, "units": "si",
    "granular": 1, "cohesion": 0, "steady_gravity": 1, "gravity": [0.0, 0.0, -9.81],
    "fixes": [{"id": "integr", "style": "nve/sphere", "all": 1, "later": 0, "acts": 0}],
}  # fmt: skip
SPHERES = np.array([(1, 1, 2e-3, 8.4e-5, (0, 0, 0)), (2, 1, 3e-3, 2.8e-4, (0.01, 0, 0))], NEWCOMER)
MESHES = {"walls": {"drum": 40, "lid": "dry"}}
WRONG_STATES = [
    ("wet.layers", {"layers": 2}), ("wet.ghosts", {"ranks": 2, "ghost_velocity": 0}),
    ("wet.units", {"units": "cgs"}), ("wet.atoms", {"granular": 0}), ("wet.map", {"map": 0}),
    ("wet.newton", {"newton": 1}), ("wet.tilted", {"periodic": [0.1, 0.0, 0.0], "tilted": 1}),
    ("wet.coarsegraining", {"coarsegraining": 1}),
    ("wet.pair", {"cohesion": -1}), ("wet.cohesion", {"cohesion": 1}), ("wet.neighbour", {"delay": 10}),
    ("wet.contact_distance", {"contact_distance_factor": 1.2}), ("wet.integrate", {"fixes": []}),
]  # fmt: skip
WRONG_FIXES = [
    ("wet.multisphere", "multisphere", 0), ("wet.walls", "wall/gran", 0), ("wet.order", "gravity", 1),
    ("wet.frozen", "freeze", 0), ("wet.deform", "deform", 0), ("wet.cohesion", "wall/gran", 0),
]  # fmt: skip
WRONG_SCRIPTS = [
    ("wet.no_line", {"line": ""}),
    ("wet.two_lines", {"line": f"{LINE}\n{LINE}"}),
    ("wet.words", {"line": f"{LINE} window 3"}),
    ("wet.windows", {"line": f"{LINE} windows 0"}),
    ("wet.words", {"line": "fix wet all pywet"}),
    ("wet.every", {"line": "fix wet all pywet liquid wet.yaml every 0"}),
    ("wet.hidden", {"line": f"{LINE} log run_${{k}}"}),
    (
        "wet.hidden",
        {
            "line": 'variable f string wet.yaml\nif "${k} == 1" then "variable f string oil.yaml"\n'
            "fix wet all pywet liquid ${f}"
        },
    ),
    ("wet.group", {"line": LINE.replace("all", "fine")}),
    ("wet.newton", {"before": BEFORE.replace("newton          off", "newton on")}),
    ("wet.short_box", {"before": BEFORE.replace("f f f", "f f p").replace("0 0.08", "0 0.0199")}),
    ("wet.deform", {"before": f"{BEFORE}fix shear all deform 1 xy erate 0.1\n"}),
    ("wet.deform", {"after": f"{AFTER}change_box all x scale 1.1\n"}),
    ("wet.units", {"before": BEFORE.replace("units           si", "units cgs")}),
    ("wet.coarsegraining", {"before": f"coarsegraining 2\n{BEFORE}"}),
    ("wet.cohesion", {"before": BEFORE.replace("tangential history\npair", "tangential history cohesion sjkr\npair")}),
    ("wet.multisphere", {"before": BEFORE.replace("particletemplate/sphere", "particletemplate/multisphere")}),
    (
        "wet.cohesion",
        {"before": BEFORE.replace("tangential history primitive", "tangential history cohesion sjkr primitive")},
    ),
    ("wet.primitive", {"wet": WET.replace("dry", "{x1: dry, x2: dry, y1: dry, y2: dry, z1: 30}")}),
    ("wet.primitive", {"wet": WET.replace("dry", "{x1: dry, x2: dry, y1: dry, y2: dry}")}),
    (
        "wet.wall_missing",
        {"before": SHAKEN, "wet": WET.replace("dry", "{x1: dry, x2: dry, y1: dry, y2: dry, z1: dry}")},
    ),
    ("wet.wall_unknown", {"before": SHAKEN, "wet": f"{WET.replace('dry', PLATE_ALONE)}"[:-2] + ", drum: 40}\n"}),
    ("wet.lost_wall", {"before": SHAKEN, "wet": WET.replace("dry", PLATE_ALONE), "after": f"{AFTER}unfix plate\n"}),
    ("wet.compress", {"after": f"{AFTER}delete_atoms region gone\n"}),
    ("wet.unfix", {"after": 'if "1 > 0" then "unfix wet"\n'}),
    ("wet.clear", {"after": "run 1000 every 100 clear\n"}),
    ("wet.walls", {"wet": WET.replace("walls: dry\n", "")}),
    ("wet.frozen", {"before": f"{BEFORE}fix still all freeze\n"}),
    ("wet.frozen", {"after": f"fix still all setforce 0 0 0\n{AFTER}"}),
    ("wet.exclude", {"before": f"neigh_modify exclude group all all\n{BEFORE}"}),
    ("wet.exclude", {"after": f"neigh_modify exclude type 1 1\n{AFTER}"}),
    ("wet.clear", {"before": f"clear\n{BEFORE}"}),
    ("wet.unfix", {"after": f"{AFTER}unfix wet\n"}),
    ("wet.neighbour", {"before": BEFORE.replace("delay 0", "delay 5 every 2")}),
    ("wet.contact_distance", {"before": BEFORE.replace("delay 0", "delay 0 contact_distance_factor 1.2")}),
    (
        "wet.cohesion",
        {"before": f"variable x string sjkr\n{BEFORE}".replace("history\npair", "history cohesion ${x}\npair")},
    ),
    ("wet.moved_group", {"before": BEFORE.replace("integr all", "integr fine")}),
    ("wet.skin", {"before": BEFORE.replace("0.002 bin", "0.0001 bin")}),
    ("wet.drawn", {"before": BEFORE.replace("radius constant 0.003", "radius uniform 0.002 0.003")}),
    ("wet.positive", {"before": BEFORE.replace("radius constant 0.003", "radius constant 0")}),
    ("wet.positive", {"before": BEFORE.replace("density constant 2500", "density constant -2500")}),
    ("wet.positive", {"before": BEFORE.replace("0.00001", "0.0")}),
    ("wet.positive", {"before": BEFORE.replace("peratomtype 5.e6", "peratomtype 0")}),
    ("wet.positive", {"before": BEFORE.replace("peratomtypepair 1 0.6", "peratomtypepair 1 0")}),
    ("wet.mesh_file", {"before": SHAKEN.replace("plate.stl", "plat.stl"), "wet": WET.replace("dry", PLATE_ALONE)}),
    ("wet.angle", {"wet": WET.replace("15", "{2: 15}")}),
]
WRONG_LIQUIDS = [
    ("config.unknown_key", WET.replace("percent", "percentage")),
    ("config.missing_key", WET.replace("contact_angle_deg: 15\n", "")),
    ("config.inconsistent", WET.replace("percent: 1.0", "")),
    ("config.inconsistent", f"{WET}laws: {{shedding: tate}}\n"),
    ("config.inconsistent", f"{WET}first_films: [{{low_mm: [0, 0, 50], high_mm: [90, 90, 0], film_um: 20}}]\n"),
    ("config.inconsistent", f"{WET}first_films: [{{film_um: 20}}, {{type: 1, film_um: 10}}]\n"),
    ("config.value", WET.replace("15", "100")),
    ("config.value", WET.replace("dry", "wet")),
    ("config.not_yaml", "liquid: ["),
]


def first(problems: Any) -> PywetError:
    return next(iter(problems))


@pytest.mark.parametrize(("code", "wrong"), WRONG_STATES)
def test_what_the_engine_says_is_judged(code: str, wrong: dict[str, Any]) -> None:
    assert [p.code for p in of_state({**STATE, **wrong}, "dry")] == [code]


def test_a_periodic_box_is_longer_than_two_copies_of_a_sphere_reach() -> None:
    """Twice the reach of lists, of 8 mm here, and the skin of 2 mm by which two spheres may part before the next one."""
    assert [p.code for p in of_box([0.02, 0.0, 0.02], 8e-3, 2e-3)] == ["wet.short_box"] * 2
    assert not list(of_box([0.02001, 0.0, 1.0], 8e-3, 2e-3))


@pytest.mark.parametrize(("code", "style", "later"), WRONG_FIXES)
def test_fixes_that_do_not_go_with_liquid(code: str, style: str, later: int) -> None:
    fix = {"id": "f", "style": style, "all": 1, "later": later, "cohesive": code == "wet.cohesion"}
    found = list(of_state({**STATE, "fixes": [*STATE["fixes"], fix]}, "dry" if fix["cohesive"] else None))
    assert [p.code for p in found] == [code] and found[0].given == f"fix f ({style})"


@pytest.mark.parametrize(("code", "changed"), WRONG_SCRIPTS)
def test_mistakes_in_a_script(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: str, changed: dict[str, str]
) -> None:
    monkeypatch.chdir(tmp_path)
    try:
        error = first(check(write(tmp_path, **changed))[1])
    except PywetError as raised:
        error = raised
    assert error.code == code and "\n" not in str(error) and error.expected


@pytest.mark.parametrize(("code", "wet"), WRONG_LIQUIDS)
def test_mistakes_in_the_liquid(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: str, wet: str) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ConfigError) as error:
        scan(write(tmp_path, wet=wet))
    assert error.value.code == code


def test_a_drag_that_is_not_proportional_to_the_velocity(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is refused with the default integration of a script, and read with the explicit one."""
    monkeypatch.chdir(tmp_path)
    named = f"{WET}laws: {{viscous_normal: buck_water}}\n"
    with raises_code("step.not_proportional", key="viscous_integration", where="wet.yaml"):
        scan(write(tmp_path, wet=named))
    found = scan(write(tmp_path, wet=f"{named}viscous_integration: explicit\n"))
    assert found.wet.effects.viscous_normal == "buck_water"


def test_a_wrong_law_is_warned_of(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """A force in another unit than newton, as in a plan."""
    names = ", ".join(KINDS["capillary"].parts[0].arguments)
    law = f"from pywet.laws.force_law import force_law\n\n\n@force_law\ndef law({names}):\n    return surface_tension\n"
    (tmp_path / "mine.py").write_text(law)
    (tmp_path / "wet.yaml").write_text(f"{WET}laws: {{capillary: mine.py:law}}\n")
    Wet.read(tmp_path / "wet.yaml")
    assert any("WRONG law: dimensions" in r.getMessage() for r in caplog.records)


def wet(**more: Any) -> Wet:
    return parse(Wet, {"liquid": {"percent": 1.0}, "contact_angle_deg": 15, **more}, "wet.yaml")


def spheres(rows: Any = SPHERES, **more: Any) -> Spheres:
    found = Spheres(wet(**more))
    found.take_in(rows, 1)
    return found


def test_walls_by_what_the_liquid_says_of_each() -> None:
    """A mesh whose surface alone moves cannot be wet; one that is not in any wall is none."""
    fixes = [*STATE["fixes"], {"id": "w", "style": "wall/gran", "all": 1, "later": 0, "meshes": ["drum", "lid"]},
             {"id": "drum", "style": "mesh/surface", "all": 1, "later": 0, "belt": 1},
             {"id": "lid", "style": "mesh/surface", "all": 1, "later": 0, "belt": 1}]  # fmt: skip
    found = list(of_state({**STATE, "fixes": fixes}, MESHES["walls"]))
    assert [(p.code, p.given) for p in found] == [("wet.belt", "drum")]
    found = list(of_state({**STATE, "fixes": fixes[:2]}, {**MESHES["walls"], "feeder": 10}))
    assert [(p.code, p.given, p.expected) for p in found] == [("wet.wall_unknown", "feeder", "drum, lid")]


def test_mistakes_in_the_spheres() -> None:
    with pytest.raises(PywetError) as error:
        spheres(contact_angle_deg={"2": 15})
    assert (error.value.code, error.value.given) == ("wet.angle", 1)
    many = np.array([(k + 1, 1, 1e-3 + 1e-6 * k, 1e-5, (0, 0, 0)) for k in range(40)], NEWCOMER)
    with pytest.raises(PywetError) as error:
        spheres(many)
    assert (error.value.code, error.value.given) == ("wet.sizes", 40)


def test_classes_are_types_and_sizes_of_the_script() -> None:
    """Those of spheres that come later follow; films are of the type's and the place's own amount."""
    rows = np.array(
        [(1, 2, 2e-3, 8e-5, (0,) * 3), (2, 1, 2e-3, 8e-5, (0,) * 3), (3, 1, 3e-3, 3e-4, (1,) * 3)], NEWCOMER
    )
    films = [{"low_mm": [500, 500, 500], "percent": 2}, {"type": 2, "film_um": 0}]
    found = spheres(rows[:2], contact_angle_deg={"1": 10, "2": 40}, first_films=films)
    come = found.take_in(rows[2:], 7)
    assert [c.radius_m for c in found.classes] == [2e-3, 2e-3, 3e-3] and come["enters"].tolist() == [7]
    assert found.table["type"].tolist() == [1, 2, 3]
    assert found.table["film"].to_numpy() == pytest.approx([0, 8e-10, 6e-9])
    assert found.classes[0].contact_angle_rad == pytest.approx(0.6981317)


def test_first_films_of_no_sphere_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the check those of types that the text does not have, by the run also those of boxes without spheres."""
    films = [
        {"type": 1, "high_mm": [5, 5, 5], "percent": 2},
        {"type": 7, "percent": 5},
        {"low_mm": [99] * 3, "film_um": 1},
    ]
    assert [*spheres(first_films=films).unused] == [2, 3]
    monkeypatch.chdir(tmp_path)
    lines, wrong = check(write(tmp_path, wet=f"{WET}first_films: {json.dumps(films)}\n"))
    assert [line.strip() for line in lines if "no spheres of type" in line] == [
        "entry 2 of first_films: the text of the script has no spheres of type 7"
    ]
    assert not wrong


def test_the_skin_is_shared_between_films_and_ways() -> None:
    ways, thickest = reach(spheres(), STATE)
    assert ways + 6e-3 * thickest == pytest.approx(2e-3) and ways == pytest.approx(1e-3)
    with pytest.raises(PywetError) as error:
        reach(spheres(), {**STATE, "skin": 1e-4})
    assert error.value.code == "wet.skin"
    assert reach(spheres(), {**STATE, "skin": float(error.value.expected)})[0] >= 2e-4 * (1 - 1e-9)
    assert reach(spheres(liquid={"percent": 0}), {**STATE, "skin": 1e-4}) == (1e-4, 0.0)
    assert reach(spheres(SPHERES[:0]), STATE)[0] == pytest.approx(1e-3)
    with pytest.raises(PywetError) as error:
        reach(spheres(SPHERES[:0]), {**STATE, "largest_radius": 0.0})
    assert error.value.code == "wet.no_spheres"
    assert too_thick(spheres().table, thickest) is None and too_thick(spheres().table, 1e-3) == 1


def test_every_refusal_is_one_sentence() -> None:
    for code in SENTENCES:
        error = refusal(code, "given", "wanted")
        assert error.code == code and "; expected " in str(error) and "{" not in str(error)


def test_check_says_all_that_is_in_the_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write(tmp_path)
    good = CliRunner().invoke(app, ["liggghts", "-in", "in.script", "--check"])
    assert good.exit_code == 0 and "5 primitive walls" in good.output and "rabinovich" in good.output
    write(tmp_path, before=BEFORE.replace("newton          off", "newton on"), after="clear\n")
    bad = CliRunner().invoke(app, ["liggghts", "-in", "in.script", "--check"])
    assert bad.exit_code == 1 and "newton" in bad.stderr and "clear" in bad.stderr


def test_more_than_twenty_mistakes_are_one_sentence_each(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the command, nothing runs: a line each, with what was given and what was expected."""
    monkeypatch.chdir(tmp_path)
    messages = {}
    mistakes = [*(changed for _, changed in WRONG_SCRIPTS), *({"wet": wet} for _, wet in WRONG_LIQUIDS)]
    for changed in mistakes:
        write(tmp_path, **changed)
        done = CliRunner().invoke(app, ["liggghts", "-in", "in.script", "--check"])
        lines = done.stderr.strip().splitlines()
        assert done.exit_code == 1 and lines and all("expected " in line for line in lines), (changed, lines)
        messages[lines[0]] = changed
    print(f"{len(messages)} mistakes, each reported in one sentence of its own")
    assert len(messages) >= 20


def test_included_files_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in.wet").write_text(f"{LINE}\n")
    assert scan(write(tmp_path, line="include in.wet")).line.every == 100
    (tmp_path / "in.wet").write_text("include in.wet\n")
    with pytest.raises(PywetError) as error:
        scan(tmp_path / "in.script")
    assert error.value.code == "wet.includes"


def test_the_check_says_where_the_box_is_periodic(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    script = write(tmp_path, before=BEFORE.replace("f f f", "p f f"))
    lines, wrong = check(script)
    assert "  periodic along x: 40 mm; bridges reach across" in lines and not wrong
