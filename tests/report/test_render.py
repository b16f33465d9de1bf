"""The picture, looked at by numbers: a sphere's film must show as blue where the sphere is, in both ways of drawing."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
import pandas as pd
import pytest

import pywet
from pywet.cases.custom.description import Scene
from pywet.config.loading import read_yaml
from pywet.report import render, sketch
from pywet.runs.rundir import RunDir
from pywet.scene import Rotation
from tests.cases.custom.conftest import EXAMPLES, example
from tests.error_codes import raises_code


def _share_of_blue(picture: Path) -> float:
    image = matplotlib.image.imread(picture)[..., :3]
    return float(np.mean(image[..., 2] - image[..., 0] > 0.15))


def test_telling_step_is_where_a_third_has_passed(run: Path) -> None:
    # Two spheres pass, at steps 100 and 200: a third of two has passed at step 100.
    assert render.telling_step(RunDir(run)) == 100


def test_colours_reach_to_the_tick_above_the_thickest_film(run: Path) -> None:
    """5e-9 m³ on a 2 mm sphere: h = (3L/(4π) + r³)^(1/3) − r = 94.9 µm, so the ticks are 0, 20, …, 100 µm."""
    thickest = (3 * 5e-9 / (4 * np.pi) + 8e-9) ** (1 / 3) - 2e-3
    assert 1e6 * thickest == pytest.approx(94.9, abs=0.1)
    assert render.colour_limit(RunDir(run), 0) == pytest.approx(100e-6, rel=1e-9)
    assert sketch.colour_ticks(100.0).tolist() == [0, 20, 40, 60, 80, 100]


@pytest.mark.parametrize("largest", [0.31, 0.5, 1.0, 4.99, 7.2, 25.0, 83.9, 1234.0])
def test_ticks_of_a_colour_bar_are_equal_round_steps(largest: float) -> None:
    """Three to six ticks from 0 to the first at or above the largest value, printed without loss by their format."""
    ticks = sketch.colour_ticks(largest)
    assert 3 <= len(ticks) <= 6 and ticks[-2] < largest <= ticks[-1]
    printed = [float(f"{tick:.{render.places(ticks[1])}f}") for tick in ticks]
    assert printed == pytest.approx(ticks.tolist(), abs=1e-12) and np.ptp(np.diff(printed)) < 1e-9


FAR = """
import sys
from pathlib import Path
import numpy as np
from pywet.report import render
from pywet.runs.rundir import RunDir
run = RunDir(Path(sys.argv[1]))
centre, width = render.view(run, 200)
plotter = render.plotter((900, 750))
render._add_bridges(plotter, run, 200, centre, 2.0)
pixels, _ = render.pixels(plotter, run, centre, 8 * width, (900, 750))
print(int(((pixels[..., 0] > 180) & (pixels[..., 2] < 120)).sum()))
"""


def test_bridges_are_seen_in_a_large_bed(run: Path) -> None:
    """Seen from 8 times as far: the cuboids of the synthetic run cover five pixels, with edges two pixels wide more."""
    environment = {**os.environ, "VTK_DEFAULT_OPENGL_WINDOW": "vtkOSOpenGLRenderWindow"}
    command = [sys.executable, "-c", FAR, str(run)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip("VTK cannot draw here")
    assert int(done.stdout) > 5


MARKED = """
import sys
from pathlib import Path
import numpy as np
from pywet.report import render
from pywet.runs.rundir import RunDir
run, size = RunDir(Path(sys.argv[1])), (600, 500)
image, _ = render.scene(run, 0, render.view(run, 0), render.colour_limit(run, 0), size, fine=False)
centre, width = render.view(run, 0)
eye, aim = centre + width * np.array([0.7, -2.2, 0.85]), centre + width * np.array([0.04, 0.0, 0.0])
away = (aim - eye) / np.linalg.norm(aim - eye)
right = np.cross(away, [0.0, 0.0, 1.0])
right /= np.linalg.norm(right)
here = run.trajectory[run.trajectory["step"] == 0].sort_values("id")[["x", "y", "z"]].to_numpy() - eye
focus = 250.0 / np.tan(np.radians(17.5)) / (here @ away)
for x, y in zip(300.0 + focus * (here @ right), 250.0 - focus * (here @ np.cross(right, away))):
    print(*image[round(y), round(x)])
"""


@pytest.mark.parametrize("marked", [0, 1, 2])
def test_the_wet_sphere_is_the_dark_one(run: Path, marked: int) -> None:
    """Of three spheres one has a film; by a pinhole camera of the test's own the pixel of its centre is dark blue, theirs not."""
    for name in ("spheres", "films"):
        path = run / "history" / f"{name}.parquet"
        table = pd.read_parquet(path)
        table.assign(film=np.where(table["id"] == marked + 1, 5e-9, 1e-12)).to_parquet(path)
    environment = {**os.environ, "VTK_DEFAULT_OPENGL_WINDOW": "vtkOSOpenGLRenderWindow"}
    done = subprocess.run(
        [sys.executable, "-c", MARKED, str(run)], env=environment, capture_output=True, text=True, check=False
    )
    if done.returncode:
        pytest.skip("VTK cannot draw here")
    red = [int(line.split()[0]) for line in done.stdout.splitlines()]
    assert int(np.argmin(red)) == marked and sorted(red)[1] - min(red) > 40, done.stdout


FILLED, OTHER_WAY = 0.8, 0.4
"""Least share of a picture's width or height over which what is drawn extends, and of the other of both."""
SHARES = """
import sys
from pathlib import Path
import numpy as np
from pywet.report import render
from pywet.runs.rundir import RunDir
run, size = RunDir(Path(sys.argv[1])), (600, 500)
step = render.telling_step(run)
image, _ = render.scene(run, step, render.view(run, step, size), 1.0, size, fine=False)
drawn = (np.abs(image[:, :525, :3].astype(int) - image[0, 0, :3]) > 20).any(axis=2)
rows, columns = np.flatnonzero(drawn.any(axis=1)), np.flatnonzero(drawn.any(axis=0))
print(np.ptp(rows) / 500, np.ptp(columns) / 525)
"""


@pytest.mark.parametrize("name", ["case", "deck", "drum", "hopper"])
def test_the_scene_fills_the_picture(run: Path, name: str, tmp_path: Path) -> None:
    """Screen or drum and the spheres, not bins, feeds and the box, decide on the camera; a colour bar is right of column 525."""
    changes: dict[str, Any] = {"duration_s": 0.02}
    if name == "deck":
        (feed,) = read_yaml(EXAMPLES / "deck.yaml", Scene)["feed"]
        changes["feed"] = [{**feed, "rate_t_per_h": 0.524, "insertion": {"for_s": 0.02}}]
    folder = run if name == "case" else pywet.run(example(name, **changes), tmp_path / name).path
    environment = {**os.environ, "VTK_DEFAULT_OPENGL_WINDOW": "vtkOSOpenGLRenderWindow"}
    command = [sys.executable, "-c", SHARES, str(folder)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip("VTK cannot draw here")
    shares = sorted(map(float, done.stdout.split()))
    assert shares[1] >= FILLED and shares[0] >= OTHER_WAY, done.stdout


@pytest.mark.parametrize("seed", range(40))
def test_what_is_framed_is_in_the_picture(run: Path, seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Boxes up to five times as long as wide, by an independent pinhole camera: inside the margins, up to two of them."""
    draw = np.random.default_rng(seed)
    points = draw.uniform(-1.0, 1.0, 3) + draw.uniform(-1, 1, (50, 3)) * 10.0 ** draw.uniform(-1.7, -1.0, 3)
    monkeypatch.setattr(render, "_worth_seeing", lambda *_: points)
    centre, width = render.view(RunDir(run), 0, (800, 600))
    eye, aim = centre + width * np.array([0.7, -2.2, 0.85]), centre + width * np.array([0.04, 0.0, 0.0])
    away = (aim - eye) / np.linalg.norm(aim - eye)
    right = np.cross(away, [0.0, 0.0, 1.0]) / np.hypot(*away[:2])
    focus = 300.0 / np.tan(np.radians(17.5)) / ((points - eye) @ away)
    x, y = 400.0 + focus * ((points - eye) @ right), 300.0 + focus * ((points - eye) @ np.cross(right, away))
    shares = x.min() / 800, 1 - x.max() / 800, y.min() / 600, 1 - y.max() / 600
    least = render.MARGIN, 1 - render.BESIDE_BAR, render.MARGIN, render.MARGIN
    spare = np.array(shares) - least
    assert spare.min() >= -0.002
    assert spare[:2].max() <= 0.005 or spare[2:].max() <= 0.005


def test_sketch_shows_the_films(run: Path, tmp_path: Path) -> None:
    sketch.draw(RunDir(run), 0, tmp_path / "sketch.png")
    # The discs of three spheres cover several per cent of the picture.
    assert _share_of_blue(tmp_path / "sketch.png") > 0.02


def test_picture_is_drawn_whatever_the_machine_has(run: Path, tmp_path: Path) -> None:
    how = render.write(run, tmp_path / "picture.png", step=0)
    assert how in ("vtk", "matplotlib")
    assert _share_of_blue(tmp_path / "picture.png") > 0.01


def test_falls_back_when_vtk_dies(run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(render.sys, "executable", "/bin/false")
    assert render.write(run, tmp_path / "picture.png", step=0) == "matplotlib"


def test_a_step_without_output_is_refused(run: Path, tmp_path: Path) -> None:
    with raises_code("render.step", given=7):
        render.write(run, tmp_path / "picture.png", step=7)


@pytest.mark.parametrize(
    ("gravity", "axis", "rows"),
    [
        ((0, 0, -9.81), None, np.eye(3)),
        ((0, 0, -9.81), (0, 2, 0), np.eye(3)),
        ((0, -9.81, 0), (0, 0, 1), [[1, 0, 0], [0, 0, -1], [0, 1, 0]]),  # `pywet scene drum`
        ((0, 0, -9.81), (-3, 0, 0), [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
        ((0, 0, -9.81), (0, 0, 1), np.eye(3)),  # a turntable
        ((0, 0, 0), None, np.eye(3)),
    ],
)
def test_gravity_points_down_and_one_looks_along_the_axis_of_a_drum(
    run: Path, gravity: tuple[float, ...], axis: tuple[float, ...] | None, rows: np.ndarray
) -> None:
    """Right, away, up: by hand. What falls is lower in the sketch and farther from the camera's up."""
    turning = axis and Rotation(origin_m=(0, 0, 0), axis=axis, period_s=1.0)
    scene = RunDir(run).scene
    walls = tuple(wall.model_copy(update={"motion": "turns" if axis else "fixed"}) for wall in scene.walls)
    scene = scene.model_copy(update={"gravity_m_per_s2": gravity, "rotation": turning, "walls": walls})
    turned = RunDir(run)
    turned.__dict__["scene"] = scene
    np.testing.assert_allclose(sketch.frame(turned), rows, atol=1e-15)
    _, place, _, up = render.camera(turned, np.zeros(3), 1.0)
    np.testing.assert_allclose(up, np.array(rows)[2], atol=1e-15)
    assert place @ np.array(rows)[1] == pytest.approx(-2.2)
    if any(gravity):
        fallen = sketch.project(np.array([np.zeros(3), gravity]), sketch.frame(turned))
        np.testing.assert_allclose(
            fallen[1], [0.0, -9.81 * np.cos(sketch.TILT), -9.81 * np.sin(sketch.TILT)], atol=1e-12
        )


def test_projection_keeps_heights_and_order() -> None:
    # Straight up: right unchanged, up by cos(tilt); a point in front (smaller y) is nearer.
    up = sketch.project(np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]))
    np.testing.assert_allclose(up[0], [0.0, np.cos(sketch.TILT), np.sin(sketch.TILT)], atol=1e-15)
    assert up[1, 2] > 0
