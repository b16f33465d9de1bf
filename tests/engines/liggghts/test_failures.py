"""What goes wrong inside the engine ends in one sentence, and nothing half-written looks finished."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from pywet.cases.small import small
from pywet.cases.small.bodies import water
from pywet.engines import process
from pywet.engines.liggghts import build, checkpoint, driver
from pywet.engines.liggghts.departure import _last_frames, departure
from pywet.engines.liggghts.process import execute
from pywet.runs import tables
from pywet.runs.rundir import RunDir
from tests.engines.liggghts import beds
from tests.engines.liggghts.scenes import WATER, contacts, spheres_of
from tests.error_codes import raises_code

pytestmark = pytest.mark.engine
R = 2.5e-3
LAW = '''
from pywet.laws.force_law import force_law

@force_law
def bad(separation: float, volume: float, radius_i: float, radius_j: float, contact_angle_i: float,
        contact_angle_j: float, surface_tension: float) -> float:
    """Fine on the probe grid, NaN in a narrow range of gaps."""
    if 4.0e-4 < separation < 5.0e-4:
        return (separation - separation) / (separation - separation)
    return 1e-6
'''


def pair(run_dir: Path, law: str = "rabinovich", speed: float = 0.05, **options: object) -> None:
    """Two wet spheres drawn apart."""
    spheres = [
        small.Sphere(1, (0.0, 0.0, 0.0), driven=True),
        small.Sphere(1, (0.0, 0.0, 2 * R), (0.0, 0.0, speed), driven=True),
    ]
    small.prepare(
        run_dir, spheres_of(R), spheres, contacts(1), liquid=WATER,
        effects=small.PAPER.model_copy(update={"capillary": law}), time_step_s=2e-5, steps=1000, **options,
    )  # type: ignore[arg-type]  # fmt: skip
    small.run(run_dir, spheres)


def test_nan_of_a_law_stops_the_run_and_names_the_contact(tmp_path: Path) -> None:
    """The spheres, the step and the separation, to six digits; the finished-run folder does not appear."""
    path = tmp_path / "law.py"
    path.write_text(LAW)
    with raises_code("engine.stopped", spheres=(1, 2), says=r"\(separation 0\.00040098\d m\)"):
        pair(tmp_path / "run", f"{path}:bad", speed=0.0501234)  # a multiple of 1.002468e-6 m each step
    assert not (tmp_path / "run" / "engine").exists()


def test_unknown_law(tmp_path: Path) -> None:
    """The sentence lists what exists."""
    with raises_code("law.not_of_kind", given="rabinovitch"):
        pair(tmp_path, "rabinovitch")


def test_sphere_flying_out(tmp_path: Path) -> None:
    """A sphere that leaves the box stops the run with a sentence."""
    spheres = [small.Sphere(1, (0.0, 0.0, 0.0), (0.0, 0.0, 50.0))]
    small.prepare(tmp_path, spheres_of(R), spheres, contacts(1), time_step_s=1e-5, steps=1000, box=0.01)
    where = r"left the simulated .*sphere 1 at about \(0, 0, 10\) mm through the upper z face, z = 10 mm"
    with raises_code("engine.stopped", says=where):
        small.run(tmp_path, spheres)


FRAME = """ITEM: TIMESTEP
{step}
ITEM: NUMBER OF ATOMS
{count}
ITEM: BOX BOUNDS ff ff ff
-0.01 0.01
-0.01 0.01
-0.01 0.01
ITEM: ATOMS id type x y z vx vy vz
{rows}
"""


@pytest.mark.parametrize("removed", [False, True])
def test_a_sphere_removed_at_an_outlet_is_not_named_as_one_that_left_the_box(tmp_path: Path, removed: bool) -> None:
    """Of two spheres missing in the last output, the faster one leaves first unless it was removed at an outlet."""
    small.prepare(
        tmp_path, spheres_of(R), [small.Sphere(1, (0.0, 0.0, 0.0))], contacts(1), time_step_s=1e-5, steps=1000, box=0.01
    )
    scene = RunDir(tmp_path).scene.model_copy(update={"retire": True})
    rows = ["1 1 0 0 0 0 0 0", "2 1 0 0 0.002 0 0 5000", "3 1 0 0 0.002 900 0 0"]
    folder = tmp_path / "engine.partial"
    folder.mkdir()
    frames = [FRAME.format(step=step, count=len(of), rows="\n".join(of)) for step, of in ((0, rows), (100, rows[:1]))]
    (folder / "trajectory.txt").write_text("".join(frames))
    gone = np.zeros(int(removed), tables.RAW["retired"])
    gone["step"], gone["id"] = 50, 2
    (folder / "retired.0.bin").write_bytes(gone.tobytes())
    says = departure(scene, folder, None)
    assert says.startswith("sphere 3 at about (10, " if removed else "sphere 2 at about (0, 0, 10) mm"), says


def test_the_end_of_a_long_trajectory_is_read(tmp_path: Path) -> None:
    """Two frames of 64 MB, the last complete ones before one that is cut off, wherever that is."""
    rows = ["1 1 0 0 0 0 0 0", "2 1 0 0 0.002 0 0 5000"]
    frame = FRAME.format(step=0, count=2, rows="\n".join(rows))
    path = tmp_path / "trajectory.txt"
    for cut in (0, 20, len(frame) - 4):
        path.write_text(frame * 400_000 + FRAME.format(step=9, count=1, rows=rows[0]) + frame[:cut])
        tracemalloc.start()
        last, before = _last_frames(path)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert (len(last), len(before)) == (1, 2) and peak < 2**20


def test_messages_of_set_ups_are_no_flood(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a program that writes 0.4 MB into each log before each of six checkpoints, with 1 MB allowed between two."""
    scene = small.prepare(tmp_path, spheres_of(R), [small.Sphere(1, (0.0, 0.0, 0.0))], contacts(1))
    monkeypatch.setattr("pywet.engines.liggghts.process.LARGEST_LOG", 10**6)
    (tmp_path / "checkpoint").mkdir()
    piece = "yes | head -c 400000 | tee -a log.liggghts; : > checkpoint/sums.$k.json; sleep 0.4"
    execute(["sh", "-c", f"for k in 1 2 3 4 5 6; do {piece}; done"], tmp_path, scene, lambda done, total: None)
    assert all((tmp_path / name).stat().st_size == 6 * 400_000 for name in ("output.log", "log.liggghts"))


def test_a_set_up_at_a_checkpoint_is_not_in_the_log(tmp_path: Path) -> None:
    """The engine echoes the lines of the first set-up and of all runs."""
    spheres = [small.Sphere(1, (0.0, 0.0, 0.0))]
    small.prepare(tmp_path, spheres_of(R), spheres, contacts(1), steps=600, output_interval_s=1e-3, checkpoints=5)
    small.run(tmp_path, spheres)
    log = (tmp_path / "engine" / "log.liggghts").read_text()
    assert log.count("\npair_style ") == 1 and log.count("\nrun 100\n") == 6


def test_sphere_outside_the_box(tmp_path: Path) -> None:
    """Refused before the engine starts."""
    spheres = [small.Sphere(1, (0.0, 0.0, 0.5))]
    small.prepare(tmp_path, spheres_of(R), spheres, contacts(1))
    with raises_code("scene.outside_box", given=1):
        small.run(tmp_path, spheres)


def test_film_thicker_than_the_neighbour_list_allows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Films that could touch unseen stop the run."""
    monkeypatch.setattr("pywet.engines.liggghts.deck.FILM_GROWTH", 0.5)
    with raises_code("engine.stopped", says="raise FILM_GROWTH"):
        pair(tmp_path)


def test_engine_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the program: which package to install."""
    spheres = [small.Sphere(1, (0.0, 0.0, 0.0))]
    small.prepare(tmp_path, spheres_of(R), spheres, contacts(1))
    monkeypatch.setenv("PATH", str(tmp_path))
    with raises_code("engine.no_program"):
        driver.run(tmp_path, progress=False)


def test_engine_of_another_version(monkeypatch: pytest.MonkeyPatch) -> None:
    """The plugin is refused for another engine."""
    monkeypatch.setattr(process, "package_version", lambda package: "4.0.0-1")
    with raises_code("liggghts.version", given="4.0.0-1"):
        build.engine_version()


def test_disk_full(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A write that fails leaves no run that looks finished."""

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    spheres = [small.Sphere(1, (0.0, 0.0, 0.0))]
    small.prepare(tmp_path, spheres_of(R), spheres, contacts(1))
    monkeypatch.setattr(tables, "write", full)
    with raises_code("run.refused"):
        small.run(tmp_path, spheres)
    assert not (tmp_path / "engine").exists()


def free(run_dir: Path, bodies: list[small.Sphere], **options: object) -> None:
    """Free wet spheres."""
    given: dict[str, object] = {"time_step_s": 2e-5, "steps": 1000, "output_interval_s": 1e-2, **options}
    small.prepare(run_dir, spheres_of(R), bodies, contacts(1), liquid=WATER, effects=small.PAPER, **given)  # type: ignore[arg-type]
    small.run(run_dir, bodies)


def test_sphere_that_leaves_the_box_is_named(tmp_path: Path) -> None:
    """A moist run names the sphere and the step, saves where everything was, and does not look finished."""
    bodies = [small.Sphere(1, (1e-3, 2e-3, 3e-3), driven=True), small.Sphere(1, (0.02, 0.0, 0.0), (2.0, 0.0, 0.0))]
    with raises_code("engine.stopped", spheres=(2,), says="through the upper x face, x = 30 mm"):
        free(tmp_path, bodies, box=0.03)
    assert not (tmp_path / "engine").exists()
    text = (tmp_path / "engine.partial" / "stopped.0.csv").read_text().splitlines()
    assert text[0].startswith("# step") and len(text) == 3
    row = [float(word) for word in text[2].split(",")]
    assert row[:7] == pytest.approx([1.0, 1e-3, 2e-3, 3e-3, 0.0, 0.0, 0.0], abs=1e-12)


def test_too_large_an_overlap_is_named(tmp_path: Path) -> None:
    """Two spheres pressed into each other."""
    bodies = [
        small.Sphere(1, (0.0, 0.0, 0.0), driven=True),
        small.Sphere(1, (0.0, 0.0, 2 * R), (0.0, 0.0, -0.2), driven=True),
    ]
    with raises_code("engine.stopped", spheres=(1, 2), says=r"overlaps .* by 0\.50"):
        free(tmp_path, bodies)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_too_fast_for_the_time_step(tmp_path: Path, axis: int) -> None:
    """More than a tenth of the radius in a step, along any axis."""
    speed = tuple(30.0 * (k == axis) for k in range(3))
    bodies = [small.Sphere(1, (0.0, 0.0, 0.0)), small.Sphere(1, (0.02, 0.0, 0.0), speed)]
    with raises_code("engine.stopped", spheres=(2,), says="moves at 30 m/s"):
        free(tmp_path, bodies)


def test_a_small_sphere_too_fast_for_the_time_step(tmp_path: Path) -> None:
    """In one step the large one moves by 0.08 of its radius, the small one, at half the speed, by 0.4."""
    bodies = [small.Sphere(1, (0.0, 0.0, 0.0), (10.0, 0.0, 0.0)), small.Sphere(2, (0.0, 0.02, 0.0), (5.0, 0.0, 0.0))]
    small.prepare(
        tmp_path, spheres_of(R, 0.1 * R), bodies, contacts(2, stiffness=10.0), liquid=WATER, effects=small.PAPER,
        time_step_s=2e-5, steps=100,
    )  # fmt: skip
    with raises_code("engine.stopped", spheres=(2,), says="moves at 5 m/s"):
        small.run(tmp_path, bodies)


def test_nan_velocity_is_named(tmp_path: Path) -> None:
    """Not-a-number is no speed."""
    bodies = [small.Sphere(1, (0.0, 0.0, 0.0)), small.Sphere(1, (0.02, 0.0, 0.0), (float("nan"), 0.0, 0.0))]
    with raises_code("engine.stopped", spheres=(2,)):
        free(tmp_path, bodies)


def formation_law(path: Path, drawn: str) -> str:
    """Write a formation law without liquid of walls that draws such an amount from a sphere's film; its name."""
    text = "from pywet.laws.force_law import force_law\n"
    names = {"a": "film_volume_i, radius_i, radius_j", "b": "film_volume_i, radius_i, half_width"}
    names |= {"c": "film_thickness, radius_i", "d": "film_thickness, radius_i, half_width"}
    for name, arguments in names.items():
        value = drawn if name == "a" else "0.0"
        text += f'@force_law\ndef {name}({arguments}):\n    """Test."""\n    return {value}\n\n'
    path.write_text(text + "laws = (a, b, c, d)\n")
    return f"{path}:laws"


def test_film_below_zero_is_named(tmp_path: Path) -> None:
    """A formation law that gives back more than it draws, at radii that no probe has, is found out in the run."""
    drawn = "0.1 * film_volume_i if radius_i < 2.1e-3 or radius_i > 4e-3 else -0.05 * film_volume_i"
    bodies = [small.Sphere(1, (0.0, 0.0, 0.0)), small.Sphere(2, (0.0, 0.0, R + 2e-3))]
    small.prepare(
        tmp_path / "run", spheres_of(R, 2e-3), bodies, contacts(2), liquid=WATER, time_step_s=2e-5, steps=200,
        effects=small.PAPER.model_copy(update={"formation": formation_law(tmp_path / "law.py", drawn)}),
    )  # fmt: skip
    with raises_code("engine.stopped", says="draws a share below zero from sphere 1"):
        small.run(tmp_path / "run", bodies)


@pytest.mark.parametrize("middle", [1, 2, 3])
def test_bridges_that_ask_for_more_than_a_film_holds_share_it(tmp_path: Path, middle: int) -> None:
    """Of the sphere between two others each draws 70 %: both get half, as first or second end; the outer ones give 70 %."""
    places = [(2.0 * R * x, 0.0, 0.0) for x in (-1.0, 1.0)]
    places.insert(middle - 1, (0.0, 0.0, 0.0))
    bodies = [small.Sphere(1, place, driven=True) for place in places]
    small.prepare(
        tmp_path / "run", spheres_of(R), bodies, contacts(1), liquid=WATER, time_step_s=2e-5, steps=20,
        effects=small.PAPER.model_copy(update={"formation": formation_law(tmp_path / "law.py", "0.7 * film_volume_i")}),
    )  # fmt: skip
    small.run(tmp_path / "run", bodies)
    events, (film,) = (
        beds.table(tmp_path / "run", "history/events"),
        beds.table(tmp_path / "run", "history/spheres")["film"].unique(),
    )
    assert events["kind"].to_list() == [0, 0]
    for side in "ij":
        share = np.where(events[side] == middle, 0.5, 0.7) * film
        assert events[f"share_{side}"].to_numpy() == pytest.approx(share, rel=1e-9)


WITHOUT_NUMBER = """
import math
from pywet.laws.force_law import force_law

@force_law
def at_a_volume(volume, radius_i, radius_j, contact_angle_i, contact_angle_j):
    return math.sqrt(-1.0) if 1e-11 < volume < 5e-9 and volume != 1e-9 else volume ** (1.0 / 3.0)

@force_law
def stretched(speed, viscosity, surface_tension):
    return 1.0 / math.sqrt(1.0 - 5.0 * speed * viscosity / surface_tension)

@force_law
def drop(film_volume_i, radius_i, acceleration, density, surface_tension):
    return math.sqrt(-1.0) if 1.0 < acceleration < 9.0 else 0.0

@force_law
def time(film_volume_i, density, surface_tension):
    return 1e-3

drops = (drop, time)
"""


@pytest.mark.parametrize(
    ("kind", "name", "spheres", "says"),
    [
        ("rupture", "at_a_volume", (1, 2), "the rupture law gives a rupture distance of -?nan m"),
        ("dynamic_rupture", "stretched", (1, 2), "the dynamic_rupture law gives a rupture distance of -?nan m"),
        ("shedding", "drops", (1,), "the shedding law gives a value that is not finite"),
    ],
)
def test_a_law_without_a_number_ends_the_run(
    tmp_path: Path, kind: str, name: str, spheres: tuple[int, ...], says: str
) -> None:
    """NaN at a bridge or film that the probe grid does not have: a comparison with it never ruptured the bridge."""
    (tmp_path / "law.py").write_text(WITHOUT_NUMBER)
    bodies = [
        small.Sphere(1, (0.0, 0.0, 0.0), driven=True),
        small.Sphere(1, (0.0, 0.0, 2 * R), (0.0, 0.0, 1.0), driven=True),
    ]
    small.prepare(
        tmp_path / "run", spheres_of(R), bodies, contacts(1), liquid=water(1e-4, viscosity=0.02), time_step_s=2e-5, steps=400,
        effects=small.PAPER.model_copy(update={kind: f"{tmp_path / 'law.py'}:{name}"}), box=0.02, log_every_step=False,
        gravity=(0.0, 0.0, -9.81),
    )  # fmt: skip
    with raises_code("engine.stopped", spheres=spheres, says=says):
        small.run(tmp_path / "run", bodies)


def test_two_runs_in_one_folder(tmp_path: Path) -> None:
    """Expect that a run of a second process in the same folder is refused."""
    spheres = [small.Sphere(1, (0.0, 0.0, 0.0))]
    small.prepare(tmp_path, spheres_of(R), spheres, contacts(1))
    held = f"with run_folder.hold(Path({str(tmp_path)!r})): print(1, flush=True); time.sleep(60)"
    program = f"import time; from pathlib import Path; from pywet import run_folder\n{held}"
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE) as other:
        assert other.stdout is not None and other.stdout.readline()
        with raises_code("lock.active"):
            small.run(tmp_path, spheres)
        other.kill()


def test_the_last_word_of_an_aborting_engine_is_stored(tmp_path: Path) -> None:
    """LIGGGHTS ends by MPI_Abort, which flushes nothing: the message is in the log that the sentence names all the same."""
    bodies = [small.Sphere(1, (0.0, 0.0, 0.0)), small.Sphere(1, (0.0, 0.0, 2.001 * R), (0.0, 0.0, 0.1))]
    small.prepare(
        tmp_path, spheres_of(R), bodies, contacts(1), liquid=WATER, effects=small.PAPER, time_step_s=1e-5, steps=10
    )
    with raises_code("engine.stopped", says="Unknown command: no_such_command"):
        driver.run(tmp_path, extra=("no_such_command",), allow_unstable=True)
    assert b"Unknown command: no_such_command" in (tmp_path / "engine.partial" / "output.log").read_bytes()


def test_no_mpirun_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ranks without MPI are not a matter of a writable folder."""
    small.prepare(tmp_path, spheres_of(R), [small.Sphere(1, (0.0, 0.0, 0.0))], contacts(1))
    monkeypatch.setattr(shutil, "which", lambda name: None if name == "mpirun" else f"/usr/bin/{name}")
    with raises_code("engine.no_mpirun", given=2):
        driver.run(tmp_path, ranks=2)


def test_progress_is_what_the_engine_has_reported_last(tmp_path: Path) -> None:
    """The setting up after a checkpoint is 10 kB of messages, and the engine's own log lags behind what it prints."""
    assert checkpoint.last_step(tmp_path) == 0
    (tmp_path / "output.log").write_text("LIGGGHTS\n")
    assert checkpoint.last_step(tmp_path) == 0
    head = "    Step    Atoms         KinEng            CPU\n"
    rows = head + "       0     4211              0              0\n  294922     4211   0.025    42.1\n"
    (tmp_path / "output.log").write_text(rows + 100 * ("fix move_wires all move/mesh " + 70 * "x" + "\n"))
    (tmp_path / "log.liggghts").write_text(head)
    assert checkpoint.last_step(tmp_path) == 294922
