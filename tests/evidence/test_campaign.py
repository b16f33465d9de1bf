"""Campaign, kept tables and page: what is stored, what goes on after a failure, and that the page follows from the tables."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from pywet import config as settings
from pywet.errors import PywetError
from pywet.evidence import campaign, kept, page
from pywet.evidence.kept import Kept, keep, wedged
from pywet.files import read_json, write_json, write_table
from pywet.motion import velocity
from pywet.scene import Vibration
from pywet.screening import results, summary
from pywet.screening.rundir import RunDir
from tests.evidence.made import make
from tests.screening import synthetic

ROOT = Path(__file__).parents[2]


@pytest.fixture
def finished(tmp_path: Path) -> Path:
    """A run directory with results, and a replay that agrees."""
    run = synthetic.make(tmp_path / "run" / "case02", moist=True)
    row = {"scale": "largest force", "count": 12, "largest": 1e-15, "median": 0.0, "tolerance": 1e-9}
    write_json(run / "replay.json", {"quantities": {"capillary": row}})
    results.write(run)
    summary.write(run)
    return run


def test_what_is_kept_can_be_read_again(finished: Path, tmp_path: Path) -> None:
    one = keep(finished, tmp_path / "data", "case02-1", {"case": 2, "variant": "", "scale": "full"})
    table = RunDir(finished).table("results/fraction_retained")
    np.testing.assert_allclose(one.retained(), table["fraction_retained"], rtol=1e-6)
    assert (one.case, one.about["contacts"], one.about["ledger_error"] < 1e-12) == (2, 12, True)
    held = one.liquid("coarse_material", "fines")[-1] + one.walls[-1] + one.liquid("collecting_bin")[-1]
    assert held == pytest.approx(1.0, rel=1e-6)
    assert list(kept.variants(tmp_path / "data")[""]) == [2]


def test_a_run_that_may_not_be_believed_is_not_kept(finished: Path, tmp_path: Path) -> None:
    replay = read_json(finished / "replay.json", "")
    replay["quantities"]["capillary"]["largest"] = 1e-3
    write_json(finished / "replay.json", replay)
    with pytest.raises(PywetError, match="the replay disagrees on capillary"):
        keep(finished, tmp_path / "data", "case02-1", {"case": 2})
    assert not (tmp_path / "data").exists()


@pytest.mark.parametrize(
    ("height", "share", "stuck"), [(6e-3, 1.0, False), (3e-3, 1.0, True), (3e-3, 0.6, True), (3e-3, 0.4, False)]
)
def test_a_sphere_is_wedged_when_it_moves_with_the_screen(
    tmp_path: Path, height: float, share: float, stuck: bool
) -> None:
    """A sphere of 4 mm over the vibrating screen with a share of its speed: stuck when slower against it than half of that."""
    run = synthetic.make(tmp_path / "case02", moist=True)
    shaken = Vibration(amplitude_m=(0.0, 0.0, 9e-4), phase_rad=(0.0, 0.0, 0.0), frequency_Hz=50.0)
    scene = RunDir(run).scene.model_copy(update={"vibration": shaken})
    write_json(run / "scene.json", scene.model_dump(mode="json"))
    assert scene.time_step_s * 100 * 50.0 == pytest.approx(
        0.5
    )  # at the outputs the screen is in its middle, at its fastest
    table, motion = RunDir(run).trajectory.astype({"vz": float}), RunDir(run).mesh_motion
    coarse = table["id"] == 1
    shift = table.loc[coarse, "step"].map(motion[motion["mesh"] == "wires"].set_index("step")["dz"]).to_numpy()
    table.loc[coarse, "z"] = scene.screen_z_m + shift + height
    table.loc[coarse, ["vx", "vy"]] = 0.0
    table.loc[coarse, "vz"] = share * velocity(shaken, table.loc[coarse, "time"].to_numpy())[:, 2]
    write_table(table, run / "trajectory.parquet")
    found = wedged(RunDir(run))[:, 0]
    assert len(found) == 3 and (found == stuck).all()


FAKE = """
import shutil, sys
number, seed, out = sys.argv[1], sys.argv[3], sys.argv[5]
if number == "1":
    sys.exit("case 1 cannot be run")
shutil.copytree(sys.argv[0].replace("fake.py", "run/case02"), out, dirs_exist_ok=True)
"""


def test_one_failed_case_does_not_stop_the_others_and_what_is_kept_is_not_run_again(
    finished: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "fake.py").write_text(FAKE)
    loaded = settings.load(ROOT / "config")
    jobs = campaign.prepare(loaded, [1, 2], [7], "smoke", tmp_path / "out", "")
    data, command = tmp_path / "data", [sys.executable, str(tmp_path / "fake.py")]
    failed = campaign.Campaign(jobs, data, command, {"variant": "", "scale": "smoke"}, cores=2).run()
    assert [(j.number, j.failed) for j in failed] == [(1, "case 1 cannot be run")]
    assert Kept(data / "case02-7").case == 2
    assert "case02-7: kept in" in capsys.readouterr().out


def test_disk_and_work_follow_from_the_configuration() -> None:
    """A moist case 2 at full scale: 4211 spheres, 20 s, 50 events of 128 B per sphere and second: half a GB."""
    loaded = settings.load(ROOT / "config")
    dry, moist = campaign.prepare(loaded, [1, 2], [1], "full", Path("out"), "")
    assert moist.name == "case02-1" and moist.work == pytest.approx(campaign.MOIST_PRICE * dry.work, rel=0.2)
    assert 0.5e9 < moist.disk_B < 3e9 and dry.disk_B < 0.5e9


def test_the_page_in_the_docs_follows_from_the_kept_tables(tmp_path: Path) -> None:
    folder = tmp_path / "full_scale"
    data = ROOT / "docs" / "full_scale" / "data"
    if data.exists():
        folder.mkdir()
        (folder / "data").symlink_to(data)
    assert page.write(folder / "data", settings.load(ROOT / "config")) == (ROOT / "docs" / "full_scale.md").read_text()


def test_the_page_draws_what_there_is(tmp_path: Path) -> None:
    for case in (1, 2, 11):
        make(tmp_path / "data", case)
    text = page.write(tmp_path / "data", settings.load(ROOT / "config"))
    assert (
        "Not run yet: 3, 4, 5" in text
        and "| case02-1 | full, springs 1e+04 N/m, dt 1 µs | 1.00 | 10 | 7 | 1e-15 |" in text
    )
    assert {p.name for p in tmp_path.glob("*.svg")} == {"fig10.svg", "fig12.svg", "fig13.svg", "fig14.svg", "fig15.svg"}
    assert all(f"full_scale/{p.name}" in text for p in tmp_path.glob("*.svg"))
