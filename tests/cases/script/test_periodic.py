"""Bridges across a periodic boundary: as those in the middle of the box, replayed, on two ranks, restarted."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from subprocess import CompletedProcess

import numpy as np
import pandas as pd
import pytest

from pywet.geometry.surface import Floats
from tests.cases.script.scripts import BEFORE, WET, read, run, write

pytestmark = pytest.mark.engine
SIDE = 0.04
"""Length of the box [m]."""
R = 0.002
TWO = BEFORE[: BEFORE.index("fix             gravi")].replace("f f f", "p p p").replace("0 0.08", "-0.02 0.02")
GONE = "group gone id 2 4 6\ndelete_atoms group gone compress no\n"
LINE = "fix wet all pywet liquid wet.yaml every 50 windows 50"


MIDDLES = ((0.0, 0.0, 0.0), (0.02, 0.01, 0.0), (0.02, 0.02, -0.02))
"""Where two spheres meet: in the middle of the box, at a face and at a corner of it."""


def pairs(shift: float = 0.0) -> str:
    """Two spheres at each of these places, shifted along x, that meet aslant while they drift, touch, part and turn."""
    rows = []
    for k, middle in enumerate(MIDDLES):
        for side in (-1.0, 1.0):
            x = np.array(middle) + side * np.array((0.0021, 0.0005, 0.0)) + (shift, 0.0, 0.0)
            speed = 0.3 - side * 0.2, 0.05, -0.1 * side
            rows += sphere(2 * k + (1 if side < 0 else 2), x, speed)
    return "\n".join([TWO, *rows, "fix integr all nve/sphere\n"])


def sphere(number: int, x: Floats | Sequence[float], v: Sequence[float]) -> list[str]:
    """Lines that make one, at the copy of its place that is in the box along x, y and, if this is outside, z."""
    x = np.asarray(x)
    x = np.where(np.abs(x) > SIDE / 2, x - SIDE * np.rint(x / SIDE), x)
    return [
        f"create_atoms 1 single {' '.join(f'{a:.17g}' for a in x)} units box",
        f"set atom {number} diameter {2 * R} density 2500 vx {v[0]:.17g} vy {v[1]:.17g} vz {v[2]:.17g}",
    ]


def wet_run(
    folder: Path, before: str, after: str, line: str = LINE, wet: str = WET, mesh: str = "", program: Sequence[str] = ()
) -> Path:
    """Run a script with liquid, whose folder of tables is given back."""
    folder.mkdir()
    write(folder, before=before, line=line, after=after, wet=wet)
    (folder / "plate.stl").write_text(mesh or PLATE)
    done = run(folder, *program)
    assert done.returncode == 0, done.stderr + done.stdout[-2000:]
    return folder / "wet"


def table(log: Path, name: str) -> pd.DataFrame:
    return pd.read_parquet(log / "history" / f"{name}.parquet")


PLATE = "solid plate\n{}endsolid plate\n".format(
    "".join(
        "facet normal 0 0 1\nouter loop\n"
        + "".join(f"vertex {x} {y} .001\n" for x, y in corners)
        + "endloop\nendfacet\n"
        for corners in (
            ((-0.02, -0.02), (0.02, -0.02), (0.02, 0.02)),
            ((-0.02, -0.02), (0.02, 0.02), (-0.02, 0.02)),
        )
    )
)
WALLS = WET.replace("dry", "{plate: 30, y1: dry, y2: dry, z1: dry}") + "wall_film: part\n"
PLANES = [row for row in BEFORE.splitlines() if row.startswith(("fix y", "fix z"))]
SHAKES = """fix plate all mesh/surface/stress file plate.stl type 1
fix meshwall all wall/gran model hertz tangential history mesh n_meshes 1 meshes plate
fix shake all move/mesh mesh plate wiggle amplitude 0.001 0. 0.0005 period 0.02
"""


def bed(shift: float = 0.0, moves: str = SHAKES) -> str:
    """A bed of 192 spheres that is thrown and sheared, in a box periodic along x; shifted along x by a part of the box."""
    draw = np.random.default_rng(5)
    places = [(x, y, z) for z in range(3) for y in range(8) for x in range(8)]
    rows = []
    for n, place in enumerate(places, start=1):
        x = 0.005 * (np.array(place) + 0.5) + draw.uniform(-0.0004, 0.0004, 3) + (shift * SIDE - 0.02, -0.02, 0.002)
        vx, vy, vz = draw.normal(0.0, 0.1, 3)
        rows += sphere(n, x, (vx + 25.0 * x[2], vy, vz))
    start = TWO.replace("p p p", "p f f").replace("-0.02 0.02 units", "0 0.08 units")
    gravity = "fix gravi all gravity 9.81 vector 0 0 -1"
    return "\n".join([start, gravity, *PLANES, moves, *rows, "fix integr all nve/sphere\n"])


ENDS = ["step", "kind", "partner_kind", "i", "j"]
OF_BED = "fix wet all pywet liquid wet.yaml every 200 windows 2"
ROUND_OFF = 1e-11
"""Of the largest value of a column: some hundred steps of positions that are 1e-17 m off."""
TWO_RANKS = ("mpirun", "--oversubscribe", "-np", "2", sys.executable, "-m", "pywet.cli.app", "liggghts")


def agrees(log: Path) -> bool:
    """Whether the replay finds nothing in what it compares, without the motion."""
    from reference_impl.replay.command import outcome

    return outcome(log)["status"] == "in part"


def test_two_spheres_across_a_boundary_are_those_in_the_middle(tmp_path: Path) -> None:
    """The same volumes, forces, torques, separations and rupture at a face and a corner of the box, up to round-off."""
    log = wet_run(tmp_path / "a", pairs(), "run 500\n")
    events, contacts, bridges = (table(log, name) for name in ("events", "contacts", "bridges"))
    for name, rows, least in (("events", events, 2), ("contacts", contacts, 300), ("bridges", bridges, 6)):
        one, *others = (rows[rows["i"] == 2 * k + 1].reset_index(drop=True) for k in range(len(MIDDLES)))
        assert len(one) >= least
        # the second end is the periodic image nearest to the first
        assert name == "events" or (np.abs(rows["xi_x"] - rows["xj_x"]) < 3 * R).all()
        for other in others:
            assert other["step"].tolist() == one["step"].tolist()
            assert other["volume"].tolist() == pytest.approx(one["volume"].tolist(), rel=1e-14)
            for column in one.select_dtypes("float"):
                if column[:2] in ("xi", "xj"):
                    continue
                size = np.abs(one[column]).max()
                assert other[column].to_numpy() == pytest.approx(
                    one[column].to_numpy(), abs=ROUND_OFF * size + 1e-20
                ), column
    assert events["kind"].tolist() == [0, 0, 0, 1, 1, 1]
    assert np.abs(contacts[["torque_i_y", "torque_j_y"]]).max().min() > 1e-9


@pytest.mark.slow
@pytest.mark.parametrize(
    ("gone", "shift"), [(GONE, 0.0), (GONE.replace("2 4 6", "1 3 5"), 0.0), (f"run 0\n{GONE}", 0.0016)]
)
@pytest.mark.parametrize("program", [(), TWO_RANKS])
def test_bridges_of_deleted_spheres_end_with_the_separation_across(
    tmp_path: Path, gone: str, shift: float, program: tuple[str, ...]
) -> None:
    """Whichever end is deleted, also where a border of ranks is between them, and after a set-up in which spheres cross it."""
    before = divided(pairs(shift), "2 1 1") if program else pairs(shift)
    log = wet_run(tmp_path / "a", before, f"run 200\n{gone}run 100\n", program=program)
    ended, active = (table(log, name).sort_values("i") for name in ("events", "bridges"))
    ended, active = ended.query("kind == 2"), active.query("step == 200")
    assert len(ended) == 3
    assert np.abs(ended["separation"].to_numpy() - active["separation"].to_numpy()).max() < 1e-12 * R
    assert np.ptp(ended["speed"]) < 1e-9 * ended["speed"].min()
    ledger = table(log, "ledger")
    held = ledger["films"] + ledger["bridges"] + ledger["retired"]
    assert ledger["retired"].iloc[-1] > 0 and np.abs(held / ledger["initial"] - 1).max() < 1e-12
    assert agrees(log)


def test_deletions_in_set_ups_without_a_step_between_count_once(tmp_path: Path) -> None:
    """Spheres are deleted before each of three set-ups, one of them after it was made without any step."""
    late = "\n".join(["run 0", *sphere(7, (0.0, 0.01, 0.01), (0.0, 0.0, 0.0)), "run 0"])
    gone = "group {0} id {1}\ndelete_atoms group {0} compress no\n"
    after = f"run 200\n{gone.format('a', '2')}run 0\n{gone.format('b', '4')}{late}\n{gone.format('c', '6 7')}run 100\n"
    log = wet_run(tmp_path / "a", pairs(), after)
    retired, ledger = table(log, "retired"), table(log, "ledger")
    assert sorted(retired["id"]) == [2, 4, 6, 7] and retired["film"].sum() == pytest.approx(ledger["retired"].iloc[-1])
    held = ledger["films"] + ledger["bridges"] + ledger["retired"]
    assert np.abs(held / ledger["initial"] - 1).max() < 1e-12
    assert agrees(log)


@pytest.mark.slow
def test_a_sheared_bed_is_replayed_and_the_same_half_a_box_further_and_on_two_ranks(tmp_path: Path) -> None:
    """A plate below it shakes along the periodic axis. Shifted by half a box, and on two ranks that divide
    either axis, the same events: all of 2000 steps, with the same volumes to 1e-12."""
    log = wet_run(tmp_path / "a", bed(), "run 2000\n", OF_BED, WALLS)
    events, ledger = table(log, "events"), table(log, "ledger")
    held = ledger["films"] + ledger["bridges"] + ledger["walls"]
    assert len(events) > 200 and (events["partner_kind"] == 1).sum() > 30 and (events["kind"] == 1).sum() > 20
    assert np.abs(held / ledger["initial"] - 1).max() < 1e-12
    bridges = table(log, "bridges").query("partner_kind == 0")
    assert (np.abs(bridges["xj_x"]) > SIDE / 2).sum() > 10  # bridges across the periodic boundary
    assert agrees(log)
    others = {
        "half": wet_run(tmp_path / "half", bed(0.5), "run 2000\n", OF_BED, WALLS),
        "ranks along x": ranks(tmp_path / "x", "2 1 1"),
        "ranks along y": ranks(tmp_path / "y", "1 2 1"),
    }
    for name, other in others.items():
        again = table(other, "events")
        assert again[ENDS].to_numpy().tolist() == events[ENDS].to_numpy().tolist(), name
        assert again["volume"].to_numpy() == pytest.approx(events["volume"].to_numpy(), rel=1e-12)
        assert agrees(other), name


def ranks(folder: Path, processors: str) -> Path:
    """Run the bed on two ranks."""
    return wet_run(folder, divided(bed(), processors), "run 2000\n", OF_BED, WALLS, program=TWO_RANKS)


def divided(before: str, processors: str) -> str:
    """Return a script for two ranks."""
    return before.replace("create_box", f"processors {processors}\ncreate_box")


@pytest.mark.slow
def test_a_belt_of_triangles_that_leaves_the_box_and_comes_again(tmp_path: Path) -> None:
    """It moves by most of a box; the engine takes each triangle across as its middle passes the boundary."""
    belt = SHAKES.replace("wiggle amplitude 0.001 0. 0.0005 period 0.02", "linear 1.5 0. 0.")
    log = wet_run(tmp_path / "a", bed(moves=belt), "run 2000\n", OF_BED, WALLS)
    poses, ledger = table(log, "poses"), table(log, "ledger")
    assert poses["shift_x"].min() < -0.01 < 0.01 < poses["shift_x"].max()
    held = ledger["films"] + ledger["bridges"] + ledger["walls"]
    assert ledger["walls"].iloc[-1] > 0 and np.abs(held / ledger["initial"] - 1).max() < 1e-12
    assert agrees(log)


def drum() -> tuple[str, str]:
    """Script and mesh of a slice of a drum that turns about its axis, along which the box is periodic; 160 spheres fall in it."""
    angles = np.linspace(0.0, 2.0 * np.pi, 25)
    rims = [[(x, 0.019 * np.cos(a), 0.04 + 0.019 * np.sin(a)) for a in angles] for x in (-SIDE / 2, SIDE / 2)]
    facets = [
        corners
        for k in range(len(angles) - 1)
        for corners in (
            (rims[0][k], rims[1][k], rims[1][k + 1]),
            (rims[0][k], rims[1][k + 1], rims[0][k + 1]),
        )
    ]
    rows = [f"vertex {x:.9g} {y:.9g} {z:.9g}\n" for corners in facets for x, y, z in corners]
    loops = ["facet normal 0 0 1\nouter loop\n" + "".join(rows[k : k + 3]) for k in range(0, len(rows), 3)]
    draw, made = np.random.default_rng(7), []
    places = [(x, y, z) for x in range(8) for y in range(-2, 3) for z in range(-2, 2)]
    for n, place in enumerate(places, start=1):
        x = 0.005 * np.array(place) + draw.uniform(-0.0004, 0.0004, 3) + (-0.0175, 0.0, 0.04)
        made += [
            f"create_atoms 1 single {' '.join(f'{a:.17g}' for a in x)} units box",
            f"set atom {n} diameter {2 * R} density 2500 vx {0.5 * draw.normal():.17g} vy {0.2 * draw.normal():.17g} vz 0",
        ]
    turns = "rotate origin 0. 0. 0.04 axis 1. 0. 0. period 0.4"
    moves = SHAKES.replace("wiggle amplitude 0.001 0. 0.0005 period 0.02", turns)
    start = TWO.replace("p p p", "p f f").replace("-0.02 0.02 units", "0 0.08 units")
    script = [start, "fix gravi all gravity 9.81 vector 0 0 -1", moves, *made, "fix integr all nve/sphere\n"]
    return "\n".join(script), "solid drum\n" + "endloop\nendfacet\n".join([*loops, "endsolid drum\n"])


@pytest.mark.slow
def test_a_slice_of_a_drum_with_the_momentum_of_its_spheres(tmp_path: Path) -> None:
    """All walls are wet and only gravity acts besides: the replay compares momentum too, from the first output on."""
    from reference_impl.replay.command import outcome

    before, mesh = drum()
    log = wet_run(tmp_path / "a", before, "run 2000\n", OF_BED, WET.replace("dry", "{plate: 30}"), mesh)
    events, bridges, ledger = (table(log, name) for name in ("events", "bridges", "ledger"))
    assert len(events) > 300 and (events["partner_kind"] == 1).sum() > 10
    assert (np.abs(bridges["xj_x"]) > SIDE / 2).sum() > 20
    held = ledger["films"] + ledger["bridges"] + ledger["walls"]
    assert np.abs(held / ledger["initial"] - 1).max() < 1e-12
    found = outcome(log)
    assert found["status"] == "in part" and found["quantities"]["between_momentum"]["count"] > 300


@pytest.mark.slow
def test_a_box_that_is_too_short_is_refused_where_the_run_begins(tmp_path: Path) -> None:
    """Spheres of create_atoms are known to the engine alone: 40 mm for pairs within 4 mm and two skins of 10 mm."""
    write(
        tmp_path, before=bed().replace("neighbor        0.002", "neighbor        0.01"), line=OF_BED, after="run 10\n"
    )
    (tmp_path / "plate.stl").write_text(PLATE)
    (tmp_path / "wet.yaml").write_text(WALLS)
    done = run(tmp_path)
    assert done.returncode == 1 and "the periodic box is 0.04 m long" in read(done.stderr), done.stderr
    assert "over 0.048 m" in read(done.stderr) and not (tmp_path / "wet").exists()


@pytest.mark.slow
def test_restarted(tmp_path: Path) -> None:
    """From the engine's file of step 1000 on: bridges and liquid are there again, and the next 300 steps have the same events."""
    log = wet_run(tmp_path / "a", bed(), "restart 1000 liq.*.restart\nrun 1300\n", OF_BED, WALLS)
    text = bed()
    first, last = text.index("region          reg"), text.index("neighbor ")
    made, rest = text.index("create_atoms"), text.index("fix integr")
    again = f"{text[:first]}read_restart ../a/liq.1000.restart\n{text[last:made]}{text[rest:]}"
    two = wet_run(tmp_path / "b", again, "run 300\n", OF_BED, WALLS)
    bridges = [table(folder, "bridges").query("step == 1000")[["i", "j", "volume"]] for folder in (log, two)]
    assert len(bridges[0]) > 50 and bridges[0].to_numpy().tolist() == bridges[1].to_numpy().tolist()
    events = [table(folder, "events").query("step > 1000") for folder in (log, two)]
    assert len(events[0]) > 10 and events[0][ENDS].to_numpy().tolist() == events[1][ENDS].to_numpy().tolist()
    ledger = table(two, "ledger")
    held = ledger["films"] + ledger["bridges"] + ledger["walls"]
    assert np.abs(held / ledger["initial"] - 1).max() < 1e-12


def resumed(folder: Path, restart: str) -> CompletedProcess[str]:
    """Run the spheres of a restart file for 100 steps."""
    text = pairs()
    first, last, made = (text.index(word) for word in ("region          reg", "neighbor ", "create_atoms"))
    folder.mkdir()
    again = f"{text[:first]}read_restart {restart}\n{text[last:made]}fix integr all nve/sphere\n"
    write(folder, before=again, line=LINE, after="run 100\n", wet=WET)
    return run(folder)


def test_a_restart_file_written_after_deletions_is_refused_with_the_reason(tmp_path: Path) -> None:
    wet_run(tmp_path / "a", pairs(), f"run 200\n{GONE}run 10\nwrite_restart liq.restart\n")
    done = resumed(tmp_path / "b", "../a/liq.restart")
    assert done.returncode == 1 and "before the line or `write_restart`" in read(done.stderr)


@pytest.mark.parametrize(("between", "whole"), [("", False), ("run 0\n", False), ("run 1\n", True)])
def test_a_restart_file_is_refused_without_a_step_after_a_deletion(tmp_path: Path, between: str, whole: bool) -> None:
    """Of the last sphere, so that the numbers have no gap: the file has its bridge, or lacks its liquid."""
    gone = f"group gone id 6\ndelete_atoms group gone compress no\n{between}"
    wet_run(tmp_path / "a", pairs(), f"run 200\n{gone}write_restart liq.restart\n")
    done = resumed(tmp_path / "b", "../a/liq.restart")
    assert (done.returncode == 0) == whole, done.stderr
    if whole:
        ledger = table(tmp_path / "b" / "wet", "ledger")
        held = ledger["films"] + ledger["bridges"] + ledger["retired"]
        assert np.abs(held / ledger["initial"] - 1).max() < 1e-12
    else:
        assert "put `run 1` before `write_restart`" in read(done.stderr)


FAULTS = {
    "forces of bridges without the shortest way": (
        "forces.cpp", "at.images.nearest(x - vector_of(at.x, b))", "x - vector_of(at.x, b)",
        {"capillary"},
    ),
    "no bridge forms across the boundary": (
        "near_pairs.cpp", "at.images.nearest(Vec(x[0] - y[0], x[1] - y[1], x[2] - y[2]))",
        "Vec(x[0] - y[0], x[1] - y[1], x[2] - y[2])", {"formation_missed"},
    ),
    "torque arm of j without the shortest way": (
        "logs.cpp", "store(b.kind == SPHERE ? (-g.radius_j) * turn : Vec(), c.torque_j);",
        "const Vec raw = g.xi - Vec(b.b < 0 ? c.xj : world_.engine.at.x[b.b]);\n"
        "  store(b.kind == SPHERE ? (-g.radius_j / norm(raw)) * cross(raw, t.tangential) : Vec(), c.torque_j);",
        {"torque_j"},
    ),
    "ends of bridges in snapshots without the nearest copy": (
        "bridge.cpp", "if (at.images.any) g.xj = g.xi - d;", "",
        {"snapshot_ends"},
    ),
}  # fmt: skip
"""Name -> file of the plugin, its text, the faulty text, what the replay finds at least."""


@pytest.mark.slow
def test_the_replay_finds_faults_at_the_boundary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each in one plugin; the one without a fault agrees."""
    from pywet.engines.liggghts import build
    from pywet.util import caches
    from reference_impl.replay.command import outcome
    from tests.faults.native import Objects

    monkeypatch.setenv("PYWET_CACHE", str(tmp_path / "cache"))
    root = tmp_path / "copy"
    below = build.SOURCES.relative_to(Path(build.__file__).parents[3])
    shutil.copytree(build.SOURCES, root / below)
    objects = Objects(root, tmp_path / "objects")
    library = caches.folder() / f"libpywet-{build.source_hash()}.so"
    for n, (name, (file, old, new, found)) in enumerate({"sound": ("step.cpp", "", "", set()), **FAULTS}.items()):
        path = root / below / file
        sound = path.read_text()
        assert not old or sound.count(old) == 1, name
        path.write_text(sound.replace(old, new, 1) if old else sound)
        assert objects.library(library, path), name
        caches.seal(library)
        log = wet_run(tmp_path / str(n), pairs(), "run 500\n")
        path.write_text(sound)
        wrong = {q for q, of in outcome(log)["quantities"].items() if not of["ok"]}
        assert found <= wrong and bool(wrong) == bool(found), (name, wrong)
