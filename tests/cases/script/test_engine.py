"""What a script asks of the liquid: numbers for dumps and thermo output, restart files, ranks, tables of a run that broke."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from subprocess import CompletedProcess

import numpy as np
import pandas as pd
import pytest

from tests.cases.script.scripts import BEFORE, LINE, read, run, write
from tests.cases.script.test_examples import EXAMPLES, prepare

pytestmark = [pytest.mark.engine, pytest.mark.slow]
SHOWN = (
    "thermo_style custom step atoms f_wet[1] f_wet[2] f_wet[3] f_wet[4] f_wet[5] f_wet[6] f_wet[7] f_wet[8] f_wet[9]"
)
COLUMNS = ["initial", "films", "bridges", "walls", "retired", "bridge_count", "formations", "ruptures"]


def edit(folder: Path, *changes: tuple[str, str], to: str = "in.script") -> None:
    """The script with some words changed."""
    text = (folder / "in.script").read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (folder / to).write_text(text)


def table(folder: Path, name: str, log: str = "wet") -> pd.DataFrame:
    return pd.read_parquet(folder / log / "history" / f"{name}.parquet")


def test_films_bridges_and_forces_in_dumps_and_thermo_output(tmp_path: Path) -> None:
    """Those of the tables at the same steps; of spheres alone in the packing, whose bridges' forces add up to nothing."""
    prepare(tmp_path / "a", "packing")
    edit(
        tmp_path / "a",
        ("\nthermo  ", f"\n{SHOWN}\nthermo  "),
        ("omegax omegay omegaz", "f_wet[1] f_wet[2] f_wet[3] f_wet[4] f_wet[5]"),
        ('%.17g %.17g %.17g"', '%.17g %g %.17g %.17g %.17g"'),
        ("run             8000\nrun             12000 upto", "run 5000"),
    )
    done = run(tmp_path / "a")
    assert done.returncode == 0, done.stderr
    lines = (tmp_path / "a" / "dump.txt").read_text().split("ITEM: TIMESTEP\n")[-1].splitlines()
    rows = np.array([line.split() for line in lines[8:]], float)
    films, ledger = table(tmp_path / "a", "films"), table(tmp_path / "a", "ledger")
    assert rows[:, 7].tolist() == films[films["step"] == 5000].sort_values("id")["film"].tolist()
    last = ledger.iloc[-1]
    assert last["step"] == 5000 and rows[:, 8].sum() == 2 * last["bridge_count"] > 100
    force = rows[:, 9:12]
    assert np.abs(force.sum(axis=0)).max() < 1e-12 < 1e-4 < np.abs(force).max()
    shown = re.findall(r"^ *5000 +200 +(.*)$", done.stdout, re.MULTILINE)[-1].split()
    assert [float(v) for v in shown[:8]] == pytest.approx([float(last[c]) for c in COLUMNS], rel=1e-6)
    assert -1e-3 < float(shown[8]) < 0


def test_killed_and_restarted(tmp_path: Path) -> None:
    """The engine's restart file holds the liquid: all of it, with bridges and wall films, is there again, and goes on."""
    one = tmp_path / "a"
    prepare(one, "mixer", line="log one every 500")
    edit(one, ("run             12000", "restart 2000 liq.*.restart\nrun 2200\n"))
    assert run(one).returncode == 0
    text = (one / "in.script").read_text()
    made = text[text.index("region          fill") : text.index("fix             integr")]
    edit(one, (made, ""), ("materials.in", "again.in"), ("log one", "log two"), ("restart 2000 liq.*.restart\n", ""))
    materials = (EXAMPLES / "materials.in").read_text()
    for old, new in (("atom_style", "#"), ("region ", "#"), ("create_box      1 reg", "read_restart liq.2000.restart")):
        materials = materials.replace(old, new)
    (one / "again.in").write_text(materials)
    done = run(one)
    assert done.returncode == 0, done.stderr
    before, after = (table(one, "ledger", log) for log in ("one", "two"))
    there, again = before[before["step"] == 2000].iloc[0], after.iloc[0]
    assert again["step"] == 2000 and again["bridge_count"] > 10
    assert again[COLUMNS].tolist() == pytest.approx(there[COLUMNS].tolist(), rel=1e-13)
    bridges = [table(one, "bridges", log).query("step == 2000")[["i", "j", "volume"]] for log in ("one", "two")]
    assert bridges[0].to_numpy().tolist() == bridges[1].to_numpy().tolist()
    held = after["films"] + after["bridges"] + after["walls"]
    assert np.abs(held / after["initial"] - 1).max() < 1e-12
    from reference_impl.replay.command import outcome

    found = outcome(one / "two")
    assert found["status"] == "unreadable" and "restart file" in found["reason"]


def resumed(folder: Path, line: str, more: str = "") -> CompletedProcess[str]:
    """Run the packing in a box from liq.restart, with this line and `more` after it."""
    made = BEFORE[BEFORE.index("fix             pts1") : BEFORE.index("fix             integr")]
    before = BEFORE.replace(made, "").replace("run             1\nunfix           ins\n", "")
    for old, new in (
        ("atom_style ", "# "), ("region          reg", "# "), ("create_box      1 reg", "read_restart liq.restart")
    ):  # fmt: skip
        assert old in before
        before = before.replace(old, new)
    write(folder, before=before, line=line, after=f"{more}run 100\n")
    return run(folder)


def test_spheres_created_after_a_restart_bring_their_liquid(tmp_path: Path) -> None:
    """It is part of the liquid put in; and films of a restart file without its bridges, of another fix ID, are refused."""
    write(tmp_path, line=f"{LINE} log one", after="run 300\nwrite_restart liq.restart\n")
    assert run(tmp_path).returncode == 0
    there = table(tmp_path, "ledger", "one").iloc[-1]
    new = int(there["spheres"]) + 1
    more = (
        "write_restart again.restart\n"  # the engine creates spheres only after a command that initialises it
        f"create_atoms 1 single 0 0 0.078 units box\nset atom {new} diameter 0.004 density 2500\n"
    )
    done = resumed(tmp_path, f"{LINE} log two", more)
    assert done.returncode == 0, done.stderr
    after = table(tmp_path, "ledger", "two")
    film = 0.01 * 2.5 * 4 / 3 * np.pi * 0.002**3
    assert after["spheres"].iloc[0] == new
    assert after["initial"].to_numpy() == pytest.approx(there["initial"] + film, rel=1e-13)
    assert np.abs((after["films"] + after["bridges"]) / after["initial"] - 1).max() < 1e-12
    done = resumed(tmp_path, f"{LINE} log three".replace("fix wet", "fix liq"))
    assert done.returncode == 1 and "the restart file holds films of spheres" in read(done.stderr), done.stderr


@pytest.mark.parametrize("name", ["stream", "drum"])
def test_two_ranks(tmp_path: Path, name: str) -> None:
    from reference_impl.replay.command import outcome

    prepare(tmp_path / "a", name)
    done = run(
        tmp_path / "a", "mpirun", "--oversubscribe", "-np", "2", sys.executable, "-m", "pywet.cli.app", "liggghts"
    )
    assert done.returncode == 0, done.stderr
    found = outcome(tmp_path / "a" / "wet")
    assert found["status"] == "in part" and found["events"] > 200


def test_an_engine_that_breaks_off_leaves_its_tables(tmp_path: Path) -> None:
    """One that ends by itself, which no line of the script foresaw."""
    prepare(tmp_path / "a", "stream")
    edit(tmp_path / "a", ("run             12000", "run 3000\nno_such_command"))
    done = run(tmp_path / "a")
    assert done.returncode == 1 and "tables until then are in wet" in read(done.stderr)
    assert table(tmp_path / "a", "ledger")["step"].max() == 3000
    assert not list((tmp_path / "a" / "wet" / "engine").iterdir())
