"""Scripts of LAMMPS: without liquid the program's own trajectory, with liquid bridges that the replay recomputes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet.cases.script.scan import scan
from pywet.engines.lammps import build
from pywet.errors import PywetError
from tests.cases.script.scripts import WET, read, run

needs_lammps = pytest.mark.skipif(not build.libraries()[1].exists(), reason="LAMMPS is not installed: make peers")
PACKING = """# packing in a box of region walls
atom_style      sphere
atom_modify     map array
boundary        f f f
newton          off
comm_modify     vel yes
units           si
region          reg block -0.02 0.02 -0.02 0.02 0 0.08 units box
create_box      1 reg
neighbor        0.002 bin
neigh_modify    delay 0 every 1 check yes
region          fill block -0.018 0.018 -0.018 0.018 0.003 0.05 units box
create_atoms    1 random 150 49979687 fill overlap 0.0061 maxtry 500
set             type 1 diameter 0.005
set             type 1 density 2500
pair_style      gran/hooke/history 2000.0 NULL 50.0 NULL 0.4 1
pair_coeff      * *
timestep        0.00001
fix             gravi all gravity 9.81 vector 0.0 0.0 -1.0
region          box block -0.02 0.02 -0.02 0.02 0 0.08 side in units box
fix             wall all wall/gran/region hooke/history 2000.0 NULL 50.0 NULL 0.4 1 region box
fix             integr all nve/sphere
LINE
thermo_style    custom step atoms ke SHOWN
thermo          1000
dump            d all custom 500 dump.txt id x y z vx vy vz omegax omegay omegaz
dump_modify     d sort id format line "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
run             2000
run             1000
"""
LINE = "fix wet all pywet liquid wet.yaml every 200"
STOCK = """
import ctypes, sys
mpi, lammps = (ctypes.CDLL(path, mode=ctypes.RTLD_GLOBAL) for path in sys.argv[1:3])
lammps.lammps_open_no_mpi.restype = ctypes.c_void_p
engine = ctypes.c_void_p(lammps.lammps_open_no_mpi(0, None, None))
lammps.lammps_file(engine, b"in.script")
sys.exit(lammps.lammps_has_error(engine))
"""


def write(folder: Path, line: str = LINE, shown: str = "f_wet[3] f_wet[6]", wet: str = WET) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "wet.yaml").write_text(wet)
    (folder / "in.script").write_text(PACKING.replace("LINE", line).replace("SHOWN", shown))
    return folder / "in.script"


@needs_lammps
@pytest.mark.engine
@pytest.mark.slow
def test_dry_as_the_program_itself_and_wet_as_the_replay_has_it(tmp_path: Path) -> None:
    from reference_impl.replay.command import outcome

    write(tmp_path / "stock", line="", shown="")
    write(tmp_path / "dry", wet=WET.replace("1.0", "0"))
    write(tmp_path / "wet")
    command = [sys.executable, "-c", STOCK, *map(str, build.libraries())]
    subprocess.run(command, cwd=tmp_path / "stock", check=True, capture_output=True)
    for name in ("dry", "wet"):
        done = run(tmp_path / name, sys.executable, "-m", "pywet.cli.app", "lammps")
        assert done.returncode == 0, done.stderr
    dumped = (tmp_path / "stock" / "dump.txt").read_text()
    assert dumped.count("ITEM: TIMESTEP") == 7 and (tmp_path / "dry" / "dump.txt").read_text() == dumped
    found = outcome(tmp_path / "wet" / "wet")
    assert found["status"] == "in part" and found["events"] > 100
    ledger = pd.read_parquet(tmp_path / "wet" / "wet" / "history" / "ledger.parquet")
    assert np.abs((ledger["films"] + ledger["bridges"]) / ledger["initial"] - 1).max() < 1e-12
    last = [row.split() for row in done.stdout.splitlines() if row.split()[:2] == ["3000", "150"]][-1]
    assert [float(last[3]), float(last[4])] == pytest.approx(
        ledger.iloc[-1][["bridges", "bridge_count"]].tolist(), rel=1e-6
    )


@needs_lammps
@pytest.mark.engine
@pytest.mark.slow
def test_bridges_reach_across_periodic_boundaries(tmp_path: Path) -> None:
    """Spheres that fly to and fro along two periodic axes."""
    from reference_impl.replay.command import outcome

    script = write(tmp_path)
    text = (
        script.read_text()
        .replace("f f f", "p p f")
        .replace("box block -0.02 0.02 -0.02 0.02", "box block INF INF INF INF")
    )
    speeds = [f'variable v{a} atom "0.8*sin(3e3*{a}+{b})"' for a, b in (("x", "z*1e3"), ("y", "x*2e3"))]
    speed = "\n".join([*speeds, "velocity all set v_vx v_vy -0.5", "timestep "])
    script.write_text(text.replace("timestep ", speed))
    done = run(tmp_path, sys.executable, "-m", "pywet.cli.app", "lammps")
    assert done.returncode == 0, done.stderr
    found = outcome(tmp_path / "wet")
    assert found["status"] == "in part" and found["events"] > 300
    bridges, ledger = (pd.read_parquet(tmp_path / f"wet/history/{name}.parquet") for name in ("bridges", "ledger"))
    for axis in "xy":
        assert (bridges[f"xj_{axis}"].abs() > 0.02).sum() > 10  # bridges across the periodic boundary
    assert np.abs((ledger["films"] + ledger["bridges"]) / ledger["initial"] - 1).max() < 1e-12


POUR = """region slab block -0.017 0.017 -0.017 0.017 0.01 0.04 units box
fix ins all pour 100 1 49979687 region slab diam one 0.005 dens 2500 2500 vol 0.3 50 vel -0.1 0.1 -0.1 0.1 -0.5
fix             integr"""


@needs_lammps
@pytest.mark.engine
@pytest.mark.slow
def test_spheres_poured_into_an_empty_box(tmp_path: Path) -> None:
    from reference_impl.replay.command import outcome

    script = write(tmp_path)
    made = PACKING[PACKING.index("create_atoms") : PACKING.index("pair_style")]
    script.write_text(script.read_text().replace(made, "").replace("fix             integr", POUR))
    done = run(tmp_path, sys.executable, "-m", "pywet.cli.app", "lammps")
    assert done.returncode == 0, done.stderr
    ledger = pd.read_parquet(tmp_path / "wet" / "history" / "ledger.parquet")
    assert ledger["spheres"].iloc[0] == 0 and ledger["spheres"].iloc[-1] == 100 and ledger["formations"].iloc[-1] > 10
    held = ledger["films"] + ledger["bridges"]
    assert np.abs(held - ledger["initial"]).max() < 1e-12 * ledger["initial"].iloc[-1]
    assert outcome(tmp_path / "wet")["status"] == "in part"


@needs_lammps
@pytest.mark.engine
@pytest.mark.slow
def test_a_line_that_lammps_reads_otherwise_than_the_text(tmp_path: Path) -> None:
    jump = "variable f string oil.yaml\njump SELF on\nvariable f string wet.yaml\nlabel on\n"
    write(tmp_path, line=f"{jump}fix wet all pywet liquid ${{f}}")
    done = run(tmp_path, sys.executable, "-m", "pywet.cli.app", "lammps")
    assert done.returncode == 1 and "`fix wet all pywet liquid oil.yaml log wet" in read(done.stderr), done.stderr


@pytest.mark.parametrize(
    ("code", "old", "new"),
    [
        ("wet.cohesion", "pair_coeff      * *", "pair_coeff * * jkr 1e6 0.5 0.3 10 tangential linear_nohistory 1 0.4"),
        ("wet.no_restart", "timestep ", "read_restart some.restart\ntimestep "),
        ("wet.newton", "newton          off", "newton on"),
        ("wet.walls", "walls: dry", ""),
    ],
)
def test_what_lammps_cannot_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: str, old: str, new: str
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    script = write(tmp_path)
    for path in (script, tmp_path / "wet.yaml"):
        path.write_text(path.read_text().replace(old, new))
    assert [p.code for p in scan(script, engine="lammps").problems] == [code]


def test_more_processes_than_one(monkeypatch: pytest.MonkeyPatch) -> None:
    from pywet.cases.script.hosts import refuse_ranks

    monkeypatch.setenv("OMPI_COMM_WORLD_SIZE", "2")
    refuse_ranks("liggghts")
    with pytest.raises(PywetError) as error:
        refuse_ranks("lammps")
    assert error.value.code == "wet.one_process"
