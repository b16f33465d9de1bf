"""A LIGGGHTS script as the base of a sweep: keys of its liquid and variables of the script are axes, files go with it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import yaml

from pywet.sweep import plan, sweep_command, table
from pywet.sweep.plan import Plan
from tests.cases.script import scripts
from tests.error_codes import raises_code
from tests.sweep.files import write

VARIABLES = (
    "variable friction equal 0.4 # of glass\nvariable packing index 49979687\nvariable steps equal 1500\n"
    "variable part string plate\nvariable end index tail\n"
)
BEFORE = VARIABLES + scripts.SHAKEN.replace("peratomtypepair 1 0.4", "peratomtypepair 1 ${friction}").replace(
    "seed 49979687", "seed ${packing}"
).replace("plate.stl", "${part}.stl")  # fmt: skip
AFTER = "include more/${end}\n"
TAIL = "dump d all custom 500 post_${friction}/dump*.txt id x y z\nrun ${steps}\n"
SWEEP: dict[str, Any] = {
    "name": "script",
    "base": {"script": "mine/in.script", "seed": "packing"},
    "axes": {"liquid.percent": [0.0, 1.0], "script.friction": [0.3, 0.4]},
    "gather": ["formations", "liquid_films_share"],
}


def asked(folder: Path, *, before: str = BEFORE, line: str = scripts.LINE, after: str = AFTER, **changes: Any) -> Plan:
    """The sweep of a script with an included file, a mesh and variables, with changes of the script and the sweep's file."""
    mine = folder / "mine"
    (mine / "more").mkdir(parents=True, exist_ok=True)
    scripts.write(mine, before=before, line=line, after=after)
    (mine / "more" / "tail").write_text(TAIL)
    return plan.read(write(folder, {**SWEEP, **changes}), folder / "out", folder / "store")


def test_points_have_their_values_in_script_and_liquid(tmp_path: Path) -> None:
    of = asked(tmp_path, seeds=3)
    names = [run.built.name for run in of.runs]
    assert len(set(names)) == 12 and all(name.startswith("script-") for name in names)
    given = of.run(4, 2).built.given
    text = given.files["in.script"].decode()
    assert "equal 0.4\n" in text and given.wet.liquid.percent == 1.0  # a comment after a value is replaced with it
    assert "packing index 49979737\n" in text  # the second prime after 49979687
    assert sorted(given.files) == ["in.script", "more/tail", "plate.stl"]
    changed = (tmp_path / "mine" / "more" / "tail").write_text(TAIL.replace("500", "50"))
    # written again without changes
    assert changed and not {run.built.name for run in asked(tmp_path, seeds=3).runs} - {*names}
    (tmp_path / "mine" / "plate.stl").write_text(scripts.PLATE.replace(".001", ".0011"))
    again = plan.read(of.file, of.folder, of.store.folder)
    assert not {run.built.name for run in again.runs} & {*names}


def test_a_file_by_an_absolute_path_is_used_in_place_and_part_of_the_fingerprint(tmp_path: Path) -> None:
    """A mesh and an included file; a change of either renames all points."""
    (tmp_path / "plate.stl").write_text(scripts.PLATE)
    (tmp_path / "tail").write_text("thermo 500\n")
    of = asked(
        tmp_path,
        before=BEFORE.replace("${part}.stl", f"{tmp_path}/${{part}}.stl"),
        after=f"{AFTER}include {tmp_path}/tail\n",
    )
    names = {run.built.name for run in of.runs}
    assert len(names) == 4 and sorted(of.runs[0].built.given.files) == ["in.script", "more/tail"]
    for path, text in (("plate.stl", scripts.PLATE.replace(".001", ".0011")), ("tail", "thermo 5\n")):
        (tmp_path / path).write_text(text)
        changed = {run.built.name for run in plan.read(of.file, of.folder, of.store.folder).runs}
        assert len(changed) == 4 and not changed & names
        names |= changed


LOOP = """variable n loop 2
variable side index left right
label again
fix m${n} all mesh/surface file part_$n.stl type 1
fix s${n} all mesh/surface file ${side}_side.stl type 1
unfix s${n}
next n
next side
jump SELF again
fix noted all print 100 ${friction} file noted.txt
"""


def test_files_and_folders_that_variables_name_are_those_of_the_point(tmp_path: Path) -> None:
    """Files of other points are not copied, those of all turns of a loop are; results of a run by hand are no input."""
    there = ("part_1.stl", "part_2.stl", "left_side.stl", "right_side.stl", "other.stl", "plate2.stl")
    (tmp_path / "mine" / "more").mkdir(parents=True)
    for name in (*there, "more/tail2", "noted.txt"):
        (tmp_path / "mine" / name).write_text(scripts.PLATE if name.endswith("stl") else TAIL)
    axes = {"script.part": ["plate", "plate2"], "script.end": ["tail", "tail2"], "script.friction": [0.3, 0.4]}
    of = asked(tmp_path, after=LOOP + AFTER, axes=axes, zips=[[*axes]])
    for run, part, end, friction in zip(of.runs, *axes.values(), strict=True):
        given = run.built.given
        assert sorted(given.files) == sorted(["in.script", f"more/{end}", f"{part}.stl", *there[:4]])
        assert f"post_{friction}" in given.folders and not [*(tmp_path / "mine").glob("post_*")]


@pytest.mark.parametrize("place", ["{there}", "../there", "more/../../there"])
@pytest.mark.parametrize(
    ("what", "command"),
    [
        ("liquid", "fix wet all pywet liquid {place} every 100"),
        ("tables", f"{scripts.LINE} log {{place}}"),
        ("results", "dump d all custom 500 {place} id x y z"),
        ("results", "variable to string {place}\ndump d all custom 500 ${{to}}_*.txt id x y z"),
        ("results", "log {place}"),
        ("results", "write_restart {place}"),
        ("results", "restart 500 a.restart {place}"),
        ("results", "print hello append {place}"),
        ("results", "fix p all print 100 hello file {place}"),
        ("results", "fix a all ave/time 1 1 100 c_thermo_temp file {place}"),
        ("results", 'if "1 > 0" then "write_data {place}"'),
    ],
)
def test_a_path_to_which_all_points_would_write_is_refused(tmp_path: Path, place: str, what: str, command: str) -> None:
    """Points run at the same time, and would mix their results; the liquid is written by the sweep itself."""
    (tmp_path / "there").write_text(scripts.WET)
    command = command.format(place=place.format(there=tmp_path / "there"))
    line = {"line": command} if what != "results" else {"after": f"{command}\n{AFTER}"}
    with raises_code("sweep.script_shared", key=what):
        _ = asked(tmp_path, **line).runs
    assert (tmp_path / "there").read_text() == scripts.WET


def test_a_script_costs_what_its_runs_in_the_store_took(tmp_path: Path) -> None:
    of = asked(tmp_path)
    assert "time and disk unknown before one run is in the store" in plan.lines(of, of.cost(), 1)[1]
    of.store.place(of.runs[0].built.name).mkdir(parents=True)
    of.store.note(of.runs[0].built.name, 7200.0)
    assert "about 8 core-hours, " in plan.lines(of, of.cost(), 1)[1]


@pytest.mark.parametrize(
    ("changes", "code", "key"),
    [
        ({"axes": {"script.frict": [1, 2]}}, "sweep.script_variable", "axes.frict"),
        ({"axes": {"script.friction": ["1\nshell rm", "2"]}}, "sweep.script_value", "axes.friction"),
        ({"axes": {"liquid.percentage": [1, 2]}}, "config.unknown_key", "liquid.percentage"),
        ({"axes": {"liquid.percent": [-1.0, 2.0]}}, "config.value", "liquid.percent"),
        ({"base": {"script": "mine/in.script"}, "seeds": 2}, "sweep.seeds", "seeds"),
        ({"base": {"script": "mine/in.script", "seed": "none"}}, "sweep.script_seed", "none"),
        ({"gather": ["rupture"]}, "sweep.unknown_result", "gather"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_sentence(tmp_path: Path, changes: dict[str, Any], code: str, key: str) -> None:
    with raises_code(code, key=key):
        _ = asked(tmp_path, **changes).runs


def _log_by_friction(folder: Path) -> None:
    script = folder / "in.script"
    script.write_text(script.read_text().replace(scripts.LINE, f"{scripts.LINE} log wet_${{friction}}"))


@pytest.mark.engine
def test_a_point_is_the_run_of_the_script_by_hand(tmp_path: Path) -> None:
    """Sweep two moistures with a function of the folder; the wet run has the events of `pywet liggghts` with the same values.

    The folders of tables and dumps are named after an axis, the files of mesh and tail by variables.
    """
    (tmp_path / "mine.py").write_text(
        "import pandas as pd\n\ndef films(folder):\n"
        "    return pd.read_parquet(folder / 'wet_0.3' / 'history' / 'films.parquet')['film'].sum()\n"
    )
    gather = [*SWEEP["gather"], "ruptures", "mine.py:films"]
    asked(tmp_path, axes={**SWEEP["axes"], "script.friction": [0.3]})
    _log_by_friction(tmp_path / "mine")
    content = {**SWEEP, "axes": {"liquid.percent": [0.0, 1.0], "script.friction": [0.3]}, "gather": gather}
    of = plan.read(write(tmp_path, content), tmp_path / "out", tmp_path / "store", trust=True)
    made = sweep_command.carry_out(of, 1, 1, 0, print)
    assert made["status"].tolist() == [table.DONE] * 2, made["reason"].tolist()
    assert made["formations"].tolist()[0] == 0 and made["formations"].tolist()[1] > 10
    assert 0.5 < made["liquid_films_share"][1] < 1.0 and made["films"][1] > made["films"][0] == 0.0
    assert of.missing == [] and not [*(tmp_path / "mine").glob("wet_*")]
    hand = tmp_path / "hand"
    (hand / "more").mkdir(parents=True)
    scripts.write(hand, before=BEFORE.replace("friction equal 0.4", "friction equal 0.3"), after=AFTER)
    (hand / "more" / "tail").write_text(TAIL)
    (hand / "post_0.3").mkdir()
    _log_by_friction(hand)
    done = scripts.run(hand)
    assert done.returncode == 0, done.stderr
    there = of.store.place(of.runs[1].built.name) / "work"
    events = [pd.read_parquet(folder / "wet_0.3" / "history" / "events.parquet") for folder in (hand, there)]
    pd.testing.assert_frame_equal(*events, check_exact=True)
    assert yaml.safe_load((there / "wet.yaml").read_text())["liquid"]["percent"] == 1.0
    dumps = [{p.name: p.read_text() for p in (folder / "post_0.3").glob("dump*")} for folder in (hand, there)]
    assert len(dumps[0]) > 2 and dumps[0] == dumps[1]
