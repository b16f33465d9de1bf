"""Every mistake in a script or its liquid, by its code; each is said in one sentence."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from typer.testing import CliRunner

from pywet.cases.script.refusals import SENTENCES, of_state, refusal
from pywet.cases.script.run import reach, scene_of
from pywet.cases.script.scan import scan
from pywet.cases.script.wet import Wet
from pywet.cli.app import app
from pywet.config.loading import parse
from pywet.errors import ConfigError, PywetError
from tests.cases.script.scripts import AFTER, BEFORE, LINE, WET, write

STATE: dict[str, Any] = {
    "ranks": 1, "step": 1, "last": -1, "time_step": 1e-5, "spheres": 2, "map": 1, "newton": 0, "delay": 0, "every": 1,
    "check": 1, "contact_distance_factor": 1.0, "skin": 2e-3, "periodic": 0, "coarsegraining": 0, "units": "si",
    "granular": 1, "cohesion": 0, "fixes": [{"id": "integr", "style": "nve/sphere", "all": 1, "later": 0}],
}  # fmt: skip
SPHERES = pd.DataFrame({"id": [1, 2], "type": [1, 1], "radius": [2e-3, 3e-3], "mass": [8.4e-5, 2.8e-4]})
WRONG_STATES = [
    ("wet.ranks", {"ranks": 2}), ("wet.units", {"units": "cgs"}), ("wet.atoms", {"granular": 0}), ("wet.map", {"map": 0}),
    ("wet.newton", {"newton": 1}), ("wet.periodic", {"periodic": 1}), ("wet.coarsegraining", {"coarsegraining": 1}),
    ("wet.pair", {"cohesion": -1}), ("wet.cohesion", {"cohesion": 1}), ("wet.neighbour", {"delay": 10}),
    ("wet.contact_distance", {"contact_distance_factor": 1.2}), ("wet.spheres", {"spheres": 0}), ("wet.integrate", {"fixes": []}),
]  # fmt: skip
WRONG_FIXES = [
    ("wet.insertion", "insert/stream", 0), ("wet.multisphere", "multisphere", 0), ("wet.walls", "wall/gran", 0),
    ("wet.walls", "mesh/surface/stress", 0), ("wet.order", "gravity", 1), ("wet.frozen", "freeze", 0),
]  # fmt: skip
WRONG_SCRIPTS = [
    ("wet.no_line", {"line": ""}),
    ("wet.two_lines", {"line": f"{LINE}\n{LINE}"}),
    ("wet.words", {"line": f"{LINE} windows 3"}),
    ("wet.words", {"line": "fix wet all pywet"}),
    ("wet.every", {"line": "fix wet all pywet liquid wet.yaml every 0"}),
    ("wet.group", {"line": LINE.replace("all", "fine")}),
    ("wet.newton", {"before": BEFORE.replace("newton          off", "newton on")}),
    ("wet.periodic", {"before": BEFORE.replace("f f f", "p p f")}),
    ("wet.units", {"before": BEFORE.replace("units           si", "units cgs")}),
    ("wet.coarsegraining", {"before": f"coarsegraining 2\n{BEFORE}"}),
    ("wet.cohesion", {"before": BEFORE.replace("tangential history\npair", "tangential history cohesion sjkr\npair")}),
    ("wet.multisphere", {"before": BEFORE.replace("particletemplate/sphere", "particletemplate/multisphere")}),
    ("wet.insertion", {"before": BEFORE.replace("unfix           ins", "")}),
    ("wet.insertion", {"after": "fix more all insert/stream seed 1\n"}),
    ("wet.walls", {"wet": WET.replace("walls: dry\n", "")}),
    ("wet.restart", {"after": f"restart 1000 a b\n{AFTER}"}),
    ("wet.restart", {"before": f"restart 1000 a b\n{BEFORE}"}),
    ("wet.frozen", {"before": f"{BEFORE}fix still all freeze\n"}),
    ("wet.frozen", {"after": f"fix still all setforce 0 0 0\n{AFTER}"}),
    ("wet.exclude", {"before": f"neigh_modify exclude group all all\n{BEFORE}"}),
    ("wet.exclude", {"after": f"neigh_modify exclude type 1 1\n{AFTER}"}),
    ("wet.clear", {"before": f"clear\n{BEFORE}"}),
    ("wet.unfix", {"after": f"{AFTER}unfix wet\n"}),
]
WRONG_LIQUIDS = [
    ("config.unknown_key", WET.replace("percent", "percentage")),
    ("config.missing_key", WET.replace("contact_angle_deg: 15\n", "")),
    ("config.inconsistent", WET.replace("percent: 1.0", "")),
    ("config.value", WET.replace("15", "100")),
    ("config.value", WET.replace("dry", "wet")),
    ("config.not_yaml", "liquid: ["),
]


def first(problems: Any) -> PywetError:
    return next(iter(problems))


@pytest.mark.parametrize(("code", "wrong"), WRONG_STATES)
def test_what_the_engine_says_is_judged(code: str, wrong: dict[str, Any]) -> None:
    assert [p.code for p in of_state({**STATE, **wrong}, True)] == [code]


@pytest.mark.parametrize(("code", "style", "later"), WRONG_FIXES)
def test_fixes_that_do_not_go_with_liquid(code: str, style: str, later: int) -> None:
    fixes = [*STATE["fixes"], {"id": "f", "style": style, "all": 1, "later": later}]
    found = list(of_state({**STATE, "fixes": fixes}, walls_are_dry=False))
    assert [p.code for p in found] == [code] and found[0].given == f"fix f ({style})"


@pytest.mark.parametrize(("code", "changed"), WRONG_SCRIPTS)
def test_mistakes_in_a_script(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: str, changed: dict[str, str]
) -> None:
    monkeypatch.chdir(tmp_path)
    try:
        error = first(scan(write(tmp_path, **changed)).problems)
    except PywetError as raised:
        error = raised
    assert error.code == code and "\n" not in str(error) and error.expected


@pytest.mark.parametrize(("code", "wet"), WRONG_LIQUIDS)
def test_mistakes_in_the_liquid(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: str, wet: str) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ConfigError) as error:
        scan(write(tmp_path, wet=wet))
    assert error.value.code == code


def wet(**more: Any) -> Wet:
    return parse(Wet, {"liquid": {"percent": 1.0}, "contact_angle_deg": 15, **more}, "wet.yaml")


def test_mistakes_in_the_spheres() -> None:
    with pytest.raises(PywetError) as error:
        scene_of(wet(), STATE, SPHERES.assign(id=[1, 3]))
    assert error.value.code == "wet.ids"
    with pytest.raises(PywetError) as error:
        scene_of(wet(contact_angle_deg={"2": 15}), STATE, SPHERES)
    assert (error.value.code, error.value.given) == ("wet.angle", 1)
    many = pd.DataFrame({"id": range(1, 41), "type": 1, "radius": [1e-3 + 1e-6 * k for k in range(40)], "mass": 1e-5})
    with pytest.raises(PywetError) as error:
        scene_of(wet(), STATE, many)
    assert (error.value.code, error.value.given) == ("wet.sizes", 40)


def test_classes_are_types_and_sizes_of_the_script() -> None:
    spheres = pd.DataFrame(
        {"id": [2, 1, 3], "type": [1, 2, 1], "radius": [2e-3, 2e-3, 3e-3], "mass": [8e-5, 8e-5, 3e-4]}
    )
    scene, table = scene_of(wet(contact_angle_deg={"1": 10, "2": 40}), STATE, spheres)
    assert [(c.radius_m, c.count) for c in scene.classes] == [(2e-3, 1), (3e-3, 1), (2e-3, 1)]
    assert table["type"].tolist() == [1, 3, 2]
    assert table["film"].to_numpy() == pytest.approx(0.01 * spheres["mass"].to_numpy() / 1000.0)
    assert scene.classes[2].contact_angle_rad == pytest.approx(0.6981317)


def test_the_skin_is_shared_between_films_and_ways() -> None:
    scene, table = scene_of(wet(), STATE, SPHERES)
    ways, thickest = reach(scene, table, 2e-3)
    assert ways + 6e-3 * thickest == pytest.approx(2e-3) and ways == pytest.approx(1e-3)
    with pytest.raises(PywetError) as error:
        reach(scene, table, 1e-4)
    assert error.value.code == "wet.skin"
    assert reach(scene, table, float(error.value.expected))[0] >= 2e-4 * (1 - 1e-9)
    assert reach(*scene_of(wet(liquid={"percent": 0}), STATE, SPHERES), 1e-4) == (1e-4, 0.0)


def test_every_refusal_is_one_sentence() -> None:
    for code in SENTENCES:
        error = refusal(code, "given", "wanted")
        assert error.code == code and "; expected " in str(error) and "{" not in str(error)


def test_check_says_all_that_is_in_the_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write(tmp_path)
    good = CliRunner().invoke(app, ["liggghts", "-in", "in.script", "--check"])
    assert good.exit_code == 0 and "5 wall/gran" in good.output and "rabinovich" in good.output
    write(tmp_path, before=BEFORE.replace("unfix           ins", ""), after="restart 10 a b\n")
    bad = CliRunner().invoke(app, ["liggghts", "-in", "in.script", "--check"])
    assert bad.exit_code == 1 and "insert/pack" in bad.stderr and "restart" in bad.stderr


def test_included_files_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in.wet").write_text(f"{LINE}\n")
    assert scan(write(tmp_path, line="include in.wet")).line.every == 100
    (tmp_path / "in.wet").write_text("include in.wet\n")
    with pytest.raises(PywetError) as error:
        scan(tmp_path / "in.script")
    assert error.value.code == "wet.includes"
