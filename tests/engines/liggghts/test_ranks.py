"""Ranks change nothing but round-off: events, ledger, trajectories on 1, 2, 4 and 8 ranks; long bridges across a boundary."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet.cases.small import small
from pywet.engines.liggghts import deck
from pywet.geometry.solids import plate
from pywet.geometry.surface import make_surface
from pywet.scene import EngineScene, Insertion
from reference_impl.replay.replay import replay
from tests.engines.liggghts import beds
from tests.engines.liggghts.scenes import WATER, contacts, spheres_of

pytestmark = pytest.mark.engine
R = 2.5e-3
STEPS = 900


@pytest.fixture(scope="module")
def one_rank(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The bed on one rank."""
    run_dir = tmp_path_factory.mktemp("one")
    return bed(run_dir, 1)


def bed(run_dir: Path, ranks: int) -> Path:
    """A moist bed of more than 500 spheres with a vibrating and a drawn wall."""
    spheres = beds.bed((9, 9, 7))
    assert len(spheres) >= 500
    beds.prepare(run_dir, spheres, STEPS)
    small.run(run_dir, spheres, ranks)
    return run_dir


@pytest.mark.parametrize("ranks", [2, 4, pytest.param(8, marks=pytest.mark.slow)])
def test_same_bed(one_rank: Path, tmp_path: Path, ranks: int) -> None:
    """Expect equal formations and ruptures in equal steps and an equal ledger; trajectories within round-off growth of 18 ms.

    Pairs are visited in another order, so forces may differ in the last digit; collisions amplify that. 1e-9 of a radius leaves
    four decades; a bridge booked one step late would show at 1e-5 of a radius.
    """
    other = bed(tmp_path, ranks)
    events, same = (beds.table(p, "history/events") for p in (one_rank, other))
    assert len(events) > 300
    pd.testing.assert_frame_equal(events[beds.LOOKS], same[beds.LOOKS])
    assert np.allclose(events["volume"], same["volume"], rtol=1e-9, atol=0.0)
    ledger, sums = (beds.table(p, "history/ledger") for p in (one_rank, other))
    for column in ("films", "bridges", "walls"):
        assert np.allclose(ledger[column], sums[column], rtol=0.0, atol=1e-12 * ledger["initial"].iloc[0])
    assert beds.apart(one_rank, other).max() < 1e-9 * beds.RADIUS
    contacts_log, same_log = (beds.table(p, "history/contacts") for p in (one_rank, other))
    assert len(contacts_log) == len(same_log) > 0
    if ranks <= 4:  # eight ranks divide the box into more columns than the bed covers
        balanced_in_x_and_y(other, ranks)
    holds_what_is_near(one_rank, other, ranks)


def holds_what_is_near(one: Path, other: Path, ranks: int) -> None:
    """No rank holds more than the spheres within a ghost cut-off of its column, and the bridges with an end there.

    The columns meet at x = 0 (and y = 0); a skin more, since spheres have moved when lists were made.
    """
    scene = EngineScene.read(other / "scene.json")
    skin = deck.skin(scene)
    cutoff = max(2 * beds.RADIUS + deck.longest_bridge(scene), 2 * beds.RADIUS * deck.film_factor(scene) + skin) + skin
    last = [beds.table(other, name)[lambda rows: rows["step"] == STEPS] for name in ("trajectory", "history/bridges")]
    spheres, bridges = last

    def near(way: float, *names: str) -> int:
        """Count the rows with one of their positions within `way` of a column; return the largest count of all columns."""
        rows = bridges if len(names) > 1 else spheres
        inside = [
            np.any(
                [(sx * rows[f"{n}x"] < way) & ((ranks == 2) | (sy * rows[f"{n}y"] < way)) for n in names], axis=0
            ).sum()
            for sx in (-1, 1)
            for sy in (-1, 1)
        ]
        return max(inside)

    alone, held = (json.loads((p / "engine" / "held.json").read_text()) for p in (one, other))
    assert (alone["spheres_and_ghosts"], alone["bridges"]) == (len(spheres), len(bridges))
    assert held["spheres_and_ghosts"] <= near(cutoff, "") < len(spheres)
    assert held["bridges"] <= near(skin, "xi_", "xj_") < (0.7 if ranks == 2 else 0.45) * len(bridges)


def test_spheres_that_enter_on_two_ranks(tmp_path: Path) -> None:
    """Half of a bed enters during the run, each sphere at its step, and forms bridges before and after: the same as on one rank.

    What was put in is counted as it comes: a film for each sphere that has entered, to 1e-12 of all.
    """
    spheres, runs, steps = beds.bed((6, 6, 4)), [], 500
    count = sum(s.kind == 2 for s in spheres)
    for ranks in (1, 2):
        run_dir = tmp_path / str(ranks)
        scene = beds.prepare(run_dir, spheres, steps)
        inserted = scene.classes[1].model_copy(
            update={"count": count, "insertion": Insertion(from_s=0.0, for_s=0.8 * steps * beds.STEP)}
        )
        scene = scene.model_copy(update={"classes": (scene.classes[0], inserted)})
        (run_dir / "scene.json").write_text(scene.model_dump_json())
        small.run(run_dir, spheres, ranks)
        runs.append(run_dir)
    events, same = (beds.table(p, "history/events") for p in runs)
    assert len(events) > 20
    pd.testing.assert_frame_equal(events[beds.LOOKS], same[beds.LOOKS])
    assert beds.apart(*runs).max() < 1e-9 * beds.RADIUS
    start = beds.table(runs[1], "history/spheres").sort_values("id")
    enters, films = np.array(scene.enters(start["type"])), start["film"].to_numpy()
    for ledger in (beds.table(p, "history/ledger") for p in runs):
        due = np.array([films[enters <= step].sum() for step in ledger["step"]])
        assert due[0] < 0.7 * due[-1] == pytest.approx(0.7 * films.sum())
        held = ledger["films"] + ledger["bridges"] + ledger["walls"] + ledger["left"]
        assert np.abs(held - due).max() < 1e-12 * films.sum()


def test_hertz_contacts_on_two_ranks(tmp_path: Path) -> None:
    """The tangential history goes with its spheres: the same events, positions within 1e-9 of a radius; replayed."""
    spheres, runs = beds.bed((6, 6, 4)), []
    for ranks in (1, 2):
        run_dir = tmp_path / str(ranks)
        scene = beds.hertzian(beds.prepare(run_dir, spheres, 500))
        (run_dir / "scene.json").write_text(scene.model_dump_json())
        small.run(run_dir, spheres, ranks)
        runs.append(run_dir)
    events, same = (beds.table(p, "history/events") for p in runs)
    assert len(events) > 20
    pd.testing.assert_frame_equal(events[beds.LOOKS], same[beds.LOOKS])
    assert beds.apart(*runs).max() < 1e-9 * beds.RADIUS
    found = replay(runs[1])
    assert found["quantities"]["newton_force"]["largest"] < 1e-9 and found["newton"]["dry_contacts"] > 50


def balanced_in_x_and_y(run_dir: Path, ranks: int) -> None:
    """Ranks share the plan view (2 x 1 or 2 x 2) of a bed in the middle of the box; none has more than 1.15 times the mean."""
    log = (run_dir / "engine" / "log.liggghts").read_text()
    assert f"2 by {ranks // 2} by 1 MPI processor grid" in log
    mean, most = re.findall(r"Nlocal:\s+(\S+) ave (\S+) max", log)[-1]
    assert float(most) < 1.15 * float(mean)


def test_stretched_pair_crosses_a_boundary_and_comes_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two spheres, stretched beyond the reach of the neighbour list, are driven across x = 0 and back, on one and two ranks.

    One formation, no rupture, and the same forces to 1e-12 of the largest (the same formula on the same numbers).
    """
    monkeypatch.setattr(deck, "skin", lambda scene: 0.1 * R)
    first, gap, stretch, way, period = -4e-3, 1.5e-4, 8e-4, 7e-3, 0.08
    bodies = [
        small.Sphere(1, (first, 0.0, 0.0), driven=True, wiggle=((way, 0.0, 0.0), period)),
        small.Sphere(1, (first + 2 * R + gap, 0.0, 0.0), driven=True, wiggle=((way + stretch, 0.0, 0.0), period)),
    ]
    logs = []
    for ranks in (1, 2):
        run_dir = tmp_path / str(ranks)
        small.prepare(
            run_dir, spheres_of(R), bodies, contacts(1), liquid=WATER, effects=small.PAPER, time_step_s=2e-5, steps=2000,
            output_interval_s=1e-2,
        )  # fmt: skip
        small.run(run_dir, bodies, ranks)
        events = beds.table(run_dir, "history/events")
        assert events["kind"].tolist() == [0]
        logs.append(beds.table(run_dir, "history/contacts"))
    one, two = logs
    listed = 2 * R * 1.1 + deck.skin(None)  # type: ignore[arg-type]
    reach = one["separation"] + 2 * R
    assert reach.max() > listed  # longer than the range of the neighbour list
    assert one["xi_x"].max() > 0 and one["xi_x"].iloc[-1] < 0 and (one["xi_x"] * one["xj_x"] < 0).sum() > 100
    force = [f"force_i_{axis}" for axis in "xyz"]
    size = np.abs(one[force].to_numpy()).max()
    assert np.abs(one[force].to_numpy() - two[force].to_numpy()).max() < 1e-12 * size


def test_a_wall_triangle_that_two_ranks_share(tmp_path: Path) -> None:
    """A sphere on either side of x = 0 dips twice onto one narrow strip: both give to its film and draw on it in the same steps.

    Together they ask for more than it holds, so that each is granted a share, which a rank cannot know by itself.
    """
    outline = R * np.array([[-1.5, -0.17], [1.5, -0.17], [1.5, 0.17], [-1.5, 0.17]])
    strip = make_surface("strip", "wall", plate(outline, -R, 0.0))
    dips = (0.0, 0.0, -0.26 * R), 0.04
    bodies = [small.Sphere(1, (x * R, 0.15 * R, 1.25 * R), driven=True, wiggle=dips) for x in (-1.05, 1.05)]
    runs = [tmp_path / str(ranks) for ranks in (1, 2)]
    for ranks, run_dir in enumerate(runs, 1):
        small.prepare(
            run_dir, spheres_of(R), bodies, contacts(1), liquid=WATER, effects=small.PAPER, time_step_s=2e-5, steps=4000,
            walls=[strip], output_interval_s=1e-2, log_every_step=False,
        )  # fmt: skip
        small.run(run_dir, bodies, ranks)
    one, two = (beds.table(p, "history/events") for p in runs)
    pd.testing.assert_frame_equal(one, two, rtol=1e-12)
    emptied = one[
        (one["kind"] == 0) & (one["share_j"] > 0) & (one["film_j_after"].abs() < 1e-12 * one["film_j_before"])
    ]
    assert emptied.groupby(["step", "triangle"])["i"].nunique().max() == 2
    ledger, same = (beds.table(p, "history/ledger") for p in runs)
    pd.testing.assert_frame_equal(ledger, same, rtol=1e-12)
    held = same["films"] + same["bridges"] + same["walls"]
    assert same["walls"].iloc[-1] > 0 and np.abs(held / same["initial"] - 1.0).max() < 1e-14


def test_neighbour_list_made_at_other_steps(one_rank: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With half the skin the engine makes its lists at other steps and sees other near pairs: the same run."""
    monkeypatch.setattr(deck, "skin", lambda scene: 0.2 * min(c.radius_m for c in scene.classes))
    other = bed(tmp_path, 1)
    counts = [
        int(re.findall(r"Neighbor list builds = (\d+)", (p / "engine" / "log.liggghts").read_text())[-1])
        for p in (one_rank, other)
    ]
    assert counts[1] > 1.3 * counts[0]
    events, same = (beds.table(p, "history/events") for p in (one_rank, other))
    pd.testing.assert_frame_equal(events[beds.LOOKS], same[beds.LOOKS])
    assert beds.apart(one_rank, other).max() < 1e-9 * beds.RADIUS
