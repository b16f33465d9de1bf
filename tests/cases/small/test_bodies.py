"""The bench: numbers that follow by hand, and scenes that are what they were asked to be."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet.cases.small import bodies, small
from pywet.laws.contact import film_thickness, film_volume
from pywet.laws.hertz import Elastic, Hertz
from pywet.planning import step_choice, time_steps
from pywet.scene import EngineScene
from studies.pair import Pair
from studies.subset import with_spheres
from tests.error_codes import raises_code

R = 1e-3
PULLS = Path(__file__).parents[3] / "docs" / "second_engine.md"


def test_a_pair_of_types_has_the_softer_spring() -> None:
    """Types 1 and 2 with each other and the wall, tangential springs of 2/7."""
    made = {(p.a, p.b): p for p in bodies.contacts(2, (4e3, 7e3), friction=0.3)}
    assert list(made) == [(1, 0), (1, 1), (1, 2), (2, 0), (2, 2)]
    assert made[1, 2].normal_stiffness_N_per_m == 4e3 and made[2, 0].normal_stiffness_N_per_m == 7e3
    assert made[2, 2].tangential_stiffness_N_per_m == pytest.approx(2e3) and made[1, 1].friction == 0.3


def test_wetting_puts_in_what_was_asked_for() -> None:
    """2 % of the mass of both sizes, as films of one thickness; 1e-12 as the root of the film equation is that exact."""
    classes = bodies.sphere_classes(R, 2.0 * R, counts=(30, 5))
    film = bodies.wetting(classes, 2.0).initial_film_thickness_m
    liquid = sum(c.count * film_volume(film, c.radius_m) for c in classes) * 1000.0
    assert liquid == pytest.approx(0.02 * sum(c.count * c.mass_kg for c in classes), rel=1e-12)
    assert film_thickness(film_volume(film, R), R) == pytest.approx(film, rel=1e-12)


def test_a_step_of_drag_is_shorter_than_the_dry_one() -> None:
    """The dry step goes with sqrt(m/k), cut to two digits: a hundred times the spring, a tenth of the step."""
    classes = bodies.sphere_classes(R)
    soft, hard = (step_choice.of_packing(classes, bodies.contacts(1, k), 0.1) for k in (1e3, 1e5))
    assert soft / hard == pytest.approx(10.0, rel=0.1)
    assert step_choice.of_packing(classes, bodies.contacts(1, 1e3), 0.1, viscosity_Pa_s=10.0) < 0.1 * soft
    # a wall has twice the relative mass and four times the drag of two spheres
    each = {p.b: step_choice.of_packing(classes, [p], 1.0, viscosity_Pa_s=10.0) for p in bodies.contacts(1, 1e3)}
    assert each[0] / each[1] == pytest.approx(0.5, rel=0.05)


def test_a_step_of_hertz_contacts_is_a_fifth_of_the_rayleigh_time() -> None:
    """Expect a fifth of pi r sqrt(rho/G)/(0.1631 nu + 0.8766), G = E/(2 + 2 nu), if no other limit is shorter."""
    glass, classes = Elastic(youngs_modulus_Pa=6e10, poissons_ratio=0.22), bodies.sphere_classes(R, density=2500.0)
    hertz = Hertz(spheres=(glass,) * len(classes), walls=glass, impact_speed_m_per_s=1.0)
    pairs = bodies.hertzian(classes, bodies.contacts(1, 1e5), hertz)
    rayleigh = math.pi * R * math.sqrt(2500.0 * 2.44 / 6e10) / (0.1631 * 0.22 + 0.8766)
    assert step_choice.of_packing(classes, pairs, 1e3, hertz=hertz) == pytest.approx(0.2 * rayleigh, rel=0.1)
    # the plan's lines: at 2 m/s the wall is pressed deepest, δ = (15 m v²/(16 E* √R))^(2/5); two spheres part first, 2.943 δ/v
    modulus, mass, present = (
        6e10 / (2.0 * (1.0 - 0.22**2)),
        2500.0 * 4.0 / 3.0 * math.pi * R**3,
        [c.model_copy(update={"count": 2}) for c in classes],
    )
    deep, shared = (
        (15.0 * m * 4.0 / (16.0 * modulus * math.sqrt(r))) ** 0.4 for m, r in ((mass, R), (mass / 2.0, R / 2.0))
    )
    lines = " ".join(time_steps.hertz_lines(present, pairs, hertz, 1e-7))
    assert f"the deepest overlap is {100.0 * deep / R:.2g} % of the radius" in lines
    assert f"lasts {2.943 * shared / 2.0:.3g} s" in lines and f"Rayleigh time {rayleigh:.3g} s" in lines


@pytest.mark.parametrize("seed", range(3))
def test_arrangements_have_no_overlap(seed: int) -> None:
    """Spheres in the box and in the drum, next to each other and inside the walls."""
    poured, box = bodies.loose_box(100, R, seed)
    at = np.array([s.position for s in poured])
    assert np.abs(at[:, :2]).max() + R < np.abs(box.corners[..., :2]).max() and at[:, 2].min() > R
    radius = bodies.drum_radius(100, R, 8.0 * R)
    turned = np.array([s.position for s in bodies.in_drum(100, R, radius, 8.0 * R, seed)])
    assert np.hypot(turned[:, 0], turned[:, 1]).max() + R < radius and np.abs(turned[:, 2]).max() + R < 4.0 * R
    for places in (at, turned):
        apart = np.linalg.norm(places[:, None] - places[None], axis=2) + 9.0 * np.eye(len(places))
        assert apart.min() > 2.0 * R
    with raises_code("small.crowded_drum", key="spheres"):
        bodies.in_drum(5000, R, radius, 8.0 * R, seed)


def test_coordination_by_hand() -> None:
    """Four in a row, three touches: 1.5 a sphere; a gap of 0.02 r counts only where it is allowed."""
    at = np.array([[0.0, 0, 0], [2.0, 0, 0], [4.0, 0, 0], [6.0, 0, 0]])
    assert bodies.coordination(at, np.ones(4)) == 1.5
    assert bodies.coordination(1.01 * at, np.ones(4)) == 0.0 and bodies.coordination(1.01 * at, np.ones(4), 0.03) == 1.5


def test_a_scene_with_films_by_sphere_and_with_fewer_spheres(tmp_path: Path) -> None:
    """A film that is given is started from, the others from the scene's thickness; what is left is numbered again."""
    spheres = [
        small.Sphere(k, (4.0 * R * n, 0.0, 0.0), film=f) for n, (k, f) in enumerate(((1, 3e-11), (2, None), (2, 0.0)))
    ]
    classes = bodies.sphere_classes(R, 1.5 * R)
    scene = small.prepare(
        tmp_path, [c.model_copy(update={"count": c.type}) for c in classes], spheres, bodies.contacts(2, 1e3),
        liquid=bodies.water(1e-5), effects=small.PAPER,
    )  # fmt: skip
    film = pd.read_parquet(tmp_path / "history" / "spheres.parquet")["film"]
    assert film.tolist() == [3e-11, pytest.approx(film_volume(1e-5, 1.5 * R)), 0.0]
    table = pd.read_parquet(tmp_path / scene.spheres_file)
    fewer = with_spheres(scene, tmp_path, table[table["type"] == 2], duration_s=0.5)
    assert [c.count for c in fewer.classes] == [0, 2] and EngineScene.read(tmp_path / "scene.json") == fewer
    assert pd.read_parquet(tmp_path / scene.spheres_file)["id"].tolist() == [1, 2]


def test_a_wall_is_the_limit_of_a_large_sphere() -> None:
    """Against a sphere a million times as large; 1e-4: what differs goes with r/R, and forces are solved to better."""
    gaps = np.array([1e-6, 1e-5])
    wall, ball = (Pair("", R, rj, 1e-12, (0.2, 0.2), 0.07) for rj in (math.inf, 1e6 * R))
    assert wall.exact(gaps) == pytest.approx(ball.exact(gaps), rel=1e-4)
    assert wall.wall and not ball.wall and 0.5 < wall.limit("paper") / wall.limit("exact") < 2.0
    assert wall.query(gaps).bodies[1].wall is not None


def test_force_at_touch_of_small_volumes() -> None:
    """2 pi r sigma cos(theta) between spheres, twice that at a wall.

    Rabinovich's second term adds to it, about sin(alpha) sin(theta + alpha) with alpha = 0.29 here: 10 to 35 %.
    """
    angle, tension = math.radians(20.0), 0.07275
    for other, factor in ((R, 1.0), (math.inf, 2.0)):
        pair = Pair("", R, other, 1e-11, (angle, angle), tension)
        (force,) = pair.paper(np.array([0.0]))
        assert 1.1 < force / (factor * 2 * math.pi * R * tension * math.cos(angle)) < 1.35
        assert pair.exact(np.array([1e-8]))[0] < force


def test_pulls_of_the_second_engine() -> None:
    """Forces in docs/second_engine.md: ours the closed form, YADE's at a wall that between equal spheres (tests/engines)."""
    rows = [line.split("|")[1:-1] for line in PULLS.read_text().splitlines() if "| force at" in line]
    angle, tension = math.radians(20.0), 0.07275
    for scene, other in (("two equal spheres", R), ("spheres 1:3", 3.0 * R), ("sphere and wall", math.inf)):
        pair = Pair(scene, R, other, 1e-11, (angle, angle), tension)
        of = [row for row in rows if row[0].strip() == scene]
        gaps = np.array([float(row[1].strip(" %").split()[-1]) for row in of]) / 100.0 * pair.limit("exact")
        shown = np.array([[float(cell) for cell in row[2:5]] for row in of])
        assert len(gaps) == 2
        exact, between = pair.exact(gaps), Pair("", R, R if pair.wall else other, 1e-11, (angle, angle), tension)
        assert shown[:, 0] == pytest.approx(exact, rel=5e-3)  # three digits
        assert shown[:, 1] == pytest.approx(100.0 * (pair.paper(gaps) / exact - 1.0), abs=0.06)
        assert shown[:, 2] == pytest.approx(100.0 * (between.paper(gaps) / exact - 1.0), abs=0.06)
