"""What goes wrong inside the engine ends in one sentence, and nothing half-written looks finished."""

from __future__ import annotations

from pathlib import Path

import pytest

from pywet import small
from pywet.engines.liggghts import build, driver
from pywet.errors import PywetError
from tests.engine.scenes import WATER, contacts, spheres_of

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
    """The spheres, the step and the separation are named; the finished-run folder does not appear."""
    path = tmp_path / "law.py"
    path.write_text(LAW)
    with pytest.raises(PywetError, match=r"not finite for the bridge of sphere 1 and sphere 2 at step \d+"):
        pair(tmp_path / "run", f"{path}:bad")
    assert not (tmp_path / "run" / "engine").exists()


def test_unknown_law(tmp_path: Path) -> None:
    """The sentence lists what exists."""
    with pytest.raises(PywetError, match="rabinovich"):
        pair(tmp_path, "rabinovitch")


def test_sphere_flying_out(tmp_path: Path) -> None:
    """A sphere that leaves the box stops the run with a sentence."""
    spheres = [small.Sphere(1, (0.0, 0.0, 0.0), (0.0, 0.0, 50.0))]
    small.prepare(tmp_path, spheres_of(R), spheres, contacts(1), time_step_s=1e-5, steps=1000, box=0.01)
    with pytest.raises(PywetError, match="left the simulated box"):
        small.run(tmp_path, spheres)


def test_sphere_outside_the_box(tmp_path: Path) -> None:
    """Refused before the engine starts."""
    spheres = [small.Sphere(1, (0.0, 0.0, 0.5))]
    small.prepare(tmp_path, spheres_of(R), spheres, contacts(1))
    with pytest.raises(PywetError, match="sphere 1 starts outside the box"):
        small.run(tmp_path, spheres)


def test_film_thicker_than_the_neighbour_list_allows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Films that could touch unseen stop the run."""
    monkeypatch.setattr("pywet.engines.liggghts.deck.FILM_GROWTH", 0.5)
    with pytest.raises(PywetError, match="raise FILM_GROWTH"):
        pair(tmp_path)


def test_engine_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the program: which package to install."""
    spheres = [small.Sphere(1, (0.0, 0.0, 0.0))]
    small.prepare(tmp_path, spheres_of(R), spheres, contacts(1))
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(PywetError, match="make setup"):
        driver.run(tmp_path, progress=False)


def test_engine_of_another_version(monkeypatch: pytest.MonkeyPatch) -> None:
    """The plugin is refused for another engine."""
    monkeypatch.setattr(build, "package_version", lambda package: "4.0.0-1")
    with pytest.raises(PywetError, match=r"LIGGGHTS 4\.0\.0-1 is installed, the plugin is written for 3\.8\.0"):
        build.engine_version()


def test_disk_full(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A write that fails leaves no run that looks finished."""

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    spheres = [small.Sphere(1, (0.0, 0.0, 0.0))]
    small.prepare(tmp_path, spheres_of(R), spheres, contacts(1))
    monkeypatch.setattr(driver, "read_trajectory", full)
    with pytest.raises(PywetError, match="No space left on device"):
        small.run(tmp_path, spheres)
    assert not (tmp_path / "engine").exists()
