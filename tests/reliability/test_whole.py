"""Neither the replay nor a comparison says "agrees" of a run that is not whole, and both say what they speak of."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from pywet import stages
from pywet.cli.app import app
from reference_impl.replay import command
from reference_impl.replay.replay import table
from tests.cases.screening import synthetic
from tests.error_codes import raises_code
from tests.reference_impl import newton_scenes

Change = Callable[[pd.DataFrame], pd.DataFrame]


def empty(rows: pd.DataFrame) -> pd.DataFrame:
    return rows.iloc[:0]


def halved(rows: pd.DataFrame) -> pd.DataFrame:
    return rows.iloc[: len(rows) // 2]


def last(rows: pd.DataFrame) -> pd.DataFrame:
    return rows.iloc[:-1]


def named(column: str) -> Change:
    """A number that the run does not have."""

    def change(rows: pd.DataFrame) -> pd.DataFrame:
        return rows.assign(**{column: rows[column].where(np.arange(len(rows)) != len(rows) // 2, 9999)})

    return change


def elsewhere(rows: pd.DataFrame) -> pd.DataFrame:
    """As if of another run that began alike: every sphere a tenth of a millimetre off after the start."""
    return rows.assign(z=rows["z"] + 1e-4 * (rows["step"] > 0))


def damaged(run: Path, name: str, change: Change | None) -> Path:
    path = run / f"{name}.parquet"
    if change is None:
        path.unlink()
    else:
        change(pd.read_parquet(path)).to_parquet(path, index=False)
    return run


@pytest.fixture(scope="module")
def bed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Thirty wet spheres on a shaken floor, their motion recorded in four windows."""
    return newton_scenes.moist_bed(tmp_path_factory.mktemp("bed"))


REFUSED = [
    ("trajectory", None, "trajectory.parquet is missing"),
    ("trajectory", empty, "step 0 is not there (nor 8 more); expected the 9 output steps"),
    ("trajectory", halved, "step 1000 is not there (nor 3 more)"),
    ("trajectory", last, "holds 31 rows at step 1600; expected 32"),
    ("trajectory", named("id"), "names the sphere 9999"),
    ("mesh_motion", halved, "step 800 is not there"),
    ("history/window_states", None, "window_states.parquet is missing"),
    ("history/window_states", halved, "expected the 300 steps of the windows"),
    ("history/window_wall_springs", None, "window_wall_springs.parquet is missing"),
    ("history/wall_films", named("triangle"), "names the triangle 9999"),
    ("history/wall_films", last, "at step 1600, where the ledger has"),
    ("history/films", last, "holds 31 rows at step 1600"),
    ("history/ledger", halved, "step 800 is not there"),
    ("history/energy", None, "energy.parquet is missing"),
    ("history/bridges", last, "holds 11 at step 1600, where the ledger has 12"),
    ("history/events", empty, "ends with 0 events at step -1, where the ledger counts 80"),
    ("history/events", halved, "ends with 40 events at step 560"),
    ("history/events", named("i"), "names the sphere 9999"),
    ("history/contacts", halved, "has nothing at step 633 of the windows, where 18 bridges act"),
    ("history/triangles", last, "expected triangles numbered 0 to 11"),
    ("history/parts", last, "expected parts numbered 0 to 2"),
    ("history/transfer", halved, "holds 603 rows; expected the 1206"),
]


@pytest.mark.engine
@pytest.mark.parametrize(("name", "change", "words"), REFUSED, ids=[f"{r[0]} {r[2][:20]}" for r in REFUSED])
def test_the_replay_refuses_what_is_not_whole(
    bed: Path, tmp_path: Path, name: str, change: Change | None, words: str
) -> None:
    """Exit status 2 and the reason; no replay.json stays that could be taken for an answer."""
    found = command.outcome(damaged(Path(shutil.copytree(bed, tmp_path / "run")), name, change))
    assert (found["status"], command.STATUS[found["status"]]) == ("unreadable", 2)
    assert words in found["reason"]
    assert not (tmp_path / "run" / "replay.json").exists()


@pytest.mark.engine
@pytest.mark.parametrize(
    ("name", "change", "quantity"),
    [
        ("trajectory", elsewhere, "trajectory"),
        ("history/contacts", last, "contact_rows"),
        ("history/window_pair_springs", empty, "contact_logged"),
        ("history/window_wall_springs", halved, "contact_logged"),
    ],
)
def test_the_replay_disagrees_where_a_table_contradicts_another(
    bed: Path, tmp_path: Path, name: str, change: Change, quantity: str
) -> None:
    found = command.outcome(damaged(Path(shutil.copytree(bed, tmp_path / "run")), name, change))
    assert found["status"] == "disagrees" and not found["quantities"][quantity]["ok"]


@pytest.mark.engine
def test_the_replay_says_what_it_compared_and_what_not(bed: Path) -> None:
    """Outputs 0, 200, … 1600; four windows of 75 steps; 32 spheres at 9 outputs and 300 steps."""
    found = command.outcome(bed)
    held = found["compared"]
    assert found["ok"] and (held["steps"], held["outputs"]) == (1600, 9)
    assert held["windows"] == [[163, 238], [563, 638], [963, 1038], [1363, 1438]]
    assert (held["rows"]["trajectory"], held["rows"]["window_states"]) == (32 * 9, 32 * 300)
    assert "forces and motion: steps outside the windows, 1301 of 1601" in found["not_checked"]
    output_text = table(found)
    assert "compared: all 9 output steps to step 1600, 4 windows of 300 steps; rows: trajectory 288," in output_text
    assert all(f"not checked: {sentence}" in output_text for sentence in found["not_checked"])


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("trajectory", None, "trajectory.parquet is missing"),
        ("trajectory", empty, "step 0 is not there"),
        ("trajectory", halved, "step 200 is not there; expected the 3 output steps"),
        ("history/events", None, "events.parquet is missing"),
        ("history/events", empty, "ends with 0 events at step -1, where the ledger counts 6"),
        ("history/events", halved, "ends with 3 events at step 163"),
        ("history/ledger", last, "step 200 is not there"),
        ("results/fraction_retained", last, "holds 2 rows; expected one for each of the 3 output steps"),
        ("results/fraction_retained", None, "has no results/fraction_retained.parquet, but"),
    ],
)
def test_a_comparison_refuses_what_is_not_whole(tmp_path: Path, name: str, change: Change | None, words: str) -> None:
    """Exit code 2 whichever of the two it is; whole, they are the same."""
    a = synthetic.make(tmp_path / "a")
    stages.results(a)
    b = Path(shutil.copytree(a, tmp_path / "b"))
    whole = CliRunner().invoke(app, ["compare", str(a), str(b)])
    assert whole.exit_code == 0
    assert "A compared: all 3 output steps to step 200" in " ".join(whole.output.split())
    damaged(b, name, change)
    for pair in ((a, b), (b, a)):
        done = CliRunner(env={"COLUMNS": "400"}).invoke(app, ["compare", *map(str, pair)])
        assert done.exit_code == 2 and words in " ".join(done.output.split()), done.output


def test_a_dry_case_over_a_moist_folder_is_no_run(tmp_path: Path) -> None:
    """The tables of the moist run are still there."""
    run = synthetic.make(tmp_path / "run")
    (run / "scene.json").write_text(synthetic.scene(moist=False).model_dump_json())
    words = "history holds events.parquet, contacts.parquet, ledger.parquet, films.parquet"
    found = command.outcome(run)
    assert found["status"] == "unreadable" and words in found["reason"]
    with raises_code("replay.refused", says="of a moist run"):
        stages.replay(run)
    assert CliRunner().invoke(app, ["compare", str(run), str(run)]).exit_code == 2
