"""The exact bridge as an engine's law: interpolation against the direct solution, smoothness, ends of the table, its cache."""

from __future__ import annotations

import ctypes
import math
from pathlib import Path

import numpy as np
import pytest

from pywet.laws import young_laplace as laws
from pywet.laws.capillary import lambert
from pywet.laws.contact import effective_radius
from pywet.laws.exact_bridge import rupture, solve
from pywet.laws.exact_bridge import table as tables
from tests.error_codes import raises_code

SIGMA = 0.07
PLATE = math.inf
SIXTY = 1.0471975511965977462
PAIRS = [(0.0, 0.0), (0.2, 0.5), (SIXTY, SIXTY)]
"""Contact angles of the smaller and the larger body; the table of each is made once and stored in the user's cache."""
IDS = ["0-0", "0.2-0.5", "60-60deg"]
Bodies = tuple[float, float, float, float]
"""Radii and contact angles."""


def random_bodies(rng: np.random.Generator, angles: tuple[float, float]) -> Bodies:
    """A sphere of 1 mm against one up to ten times as large, a plate, or the same the other way round."""
    kind = rng.integers(5)
    if kind == 0:
        return (1e-3, PLATE, *angles)
    if kind == 1 and angles[0] == angles[1]:
        return (1e-3, 1e-3, *angles)
    larger = 1e-3 * 10 ** float(rng.uniform(1e-3, 1.0))
    return (1e-3, larger, *angles) if kind < 4 else (larger, 1e-3, angles[1], angles[0])


def table_force(gap: float, volume: float, bodies: Bodies) -> float:
    return float(laws.young_laplace(gap, volume, *bodies, SIGMA))


def exact_force(gap: float, volume: float, bodies: Bodies) -> float:
    found = solve(gap, volume, *bodies)
    assert found is not None
    return found.force(SIGMA)


@pytest.mark.parametrize("angles", PAIRS, ids=IDS)
def test_force_is_within_a_thousandth_of_the_direct_solution(angles: tuple[float, float]) -> None:
    """The stated error: 0.1 % of the force at touch, anywhere up to rupture; volumes over the whole range of the table."""
    rng = np.random.default_rng(3)
    errors = []
    for _ in range(100):
        bodies = random_bodies(rng, angles)
        volume = 10 ** rng.uniform(-9.0, math.log10(0.5)) * effective_radius(*bodies[:2]) ** 3
        share = rng.uniform(0.0, 0.999) if rng.random() < 0.5 else 10 ** rng.uniform(-4.0, -1.0)  # thin rings end early
        gap = share * rupture(volume, *bodies).separation
        difference = table_force(gap, volume, bodies) - exact_force(gap, volume, bodies)
        errors.append(abs(difference) / exact_force(0.0, volume, bodies))
    assert max(errors) < 1e-3, f"worst {max(errors):.1e}, median {np.median(errors):.1e}"
    assert np.median(errors) < 1e-5  # most of the table is far better than its worst corner


@pytest.mark.parametrize("angles", PAIRS, ids=IDS)
def test_rupture_distance_is_within_2e_4_of_the_direct_solution(angles: tuple[float, float]) -> None:
    rng = np.random.default_rng(4)
    errors = []
    for _ in range(60):
        bodies = random_bodies(rng, angles)
        volume = 10 ** rng.uniform(-9.0, math.log10(0.5)) * effective_radius(*bodies[:2]) ** 3
        errors.append(abs(laws.young_laplace_rupture(volume, *bodies) / rupture(volume, *bodies).separation - 1))
    assert max(errors) < 2e-4, f"worst {max(errors):.1e}, median {np.median(errors):.1e}"


@pytest.mark.parametrize("angles", PAIRS, ids=IDS)
@pytest.mark.parametrize("bodies", [(1e-3, 1e-3), (1e-3, 2.7e-3), (1e-3, PLATE)], ids=["equal", "unequal", "plate"])
def test_slope_over_separation_has_no_jump(angles: tuple[float, float], bodies: tuple[float, float]) -> None:
    """At the nodes of the table slopes from the left and the right differ by h F'' (a jump would not shrink with h)."""
    case, volume = (*bodies, *angles), 3e-3 * effective_radius(*bodies) ** 3
    limit = laws.young_laplace_rupture(volume, *case)
    nodes = limit * (1 - np.linspace(0.1, 0.95, 18) ** 2)
    nodes = np.append(nodes, limit * (1 - (np.arange(2, 24) / 24) ** 2))
    bends = []
    for h in (1e-4 * limit, 1e-5 * limit):
        left, middle, right = (laws.young_laplace(nodes + k * h, volume, *case, SIGMA) for k in (-1, 0, 1))
        bends.append(np.abs(right - 2 * middle + left) / h)
    scale = float(laws.young_laplace(0.0, volume, *case, SIGMA)) / limit
    assert (bends[1] < 0.15 * bends[0] + 1e-7 * scale).all()


@pytest.mark.parametrize("angles", PAIRS, ids=IDS)
def test_slope_over_volume_has_no_jump(angles: tuple[float, float]) -> None:
    case = (1e-3, 2.7e-3, *angles)
    at = np.exp(np.linspace(tables.X_FIRST, tables.X_LAST, tables.X_NODES)[10:-3]) * effective_radius(*case[:2]) ** 3
    gap = 0.3 * laws.young_laplace_rupture(at[0], *case)
    bends = []
    for h in (3e-2, 3e-3):
        left, middle, right = (laws.young_laplace(gap, at * (1 + k * h), *case, SIGMA) for k in (-1, 0, 1))
        bends.append(np.abs(right - 2 * middle + left) / h)
    # the splines of a bridge are stored in single precision: four roundings of 6e-8 over h are 8e-5
    assert (bends[1] < 0.15 * bends[0] + 1e-4 * middle).all()


@pytest.mark.parametrize("angles", PAIRS, ids=IDS)
@pytest.mark.parametrize("v_star", [1e-6, 1e-3, 0.1])
def test_force_falls_where_the_direct_solution_falls(angles: tuple[float, float], v_star: float) -> None:
    case = (1e-3, 2.7e-3, *angles)
    volume = v_star * effective_radius(*case[:2]) ** 3
    gaps = rupture(volume, *case).separation * (1 - np.linspace(1.0, 0.03, 40) ** 2)
    exact = np.array([exact_force(s, volume, case) for s in gaps])
    falls = np.diff(exact) < -1e-5 * exact[0]
    assert falls.sum() > 30
    assert (np.diff(laws.young_laplace(gaps, volume, *case, SIGMA))[falls] < 0).all()


def test_overlap_and_beyond_rupture_hold_the_force_at_touch_and_at_rupture() -> None:
    case, volume = (1e-3, 2e-3, 0.2, 0.5), 1e-12
    limit = laws.young_laplace_rupture(volume, *case)
    assert table_force(-1e-5, volume, case) == table_force(0.0, volume, case)
    at_rupture = table_force(limit, volume, case)
    assert at_rupture == pytest.approx(rupture(volume, *case).bridge.force(SIGMA), rel=1e-3)
    for gap in (1.001 * limit, 3 * limit, 1e-2):
        assert table_force(gap, volume, case) == pytest.approx(at_rupture, rel=1e-12)


def test_exchanging_the_spheres_changes_nothing() -> None:
    for volume in (1e-16, 1e-12, 1e-9):
        one, other = (1e-3, 2e-3, 0.2, 0.5), (2e-3, 1e-3, 0.5, 0.2)
        assert table_force(1e-5, volume, one) == table_force(1e-5, volume, other)
        assert laws.young_laplace_rupture(volume, *one) == laws.young_laplace_rupture(volume, *other)


def test_one_force_law_at_every_size() -> None:
    one, other = (1e-3, 2e-3, 0.2, 0.5), (1e-1, 2e-1, 0.2, 0.5)
    assert table_force(1e-3, 1e-6, other) == pytest.approx(100 * table_force(1e-5, 1e-12, one), rel=1e-10)


@pytest.mark.parametrize("angles", PAIRS, ids=IDS)
@pytest.mark.parametrize("bodies", [(1e-3, 1e-3), (1e-3, PLATE)], ids=["equal", "plate"])
def test_tiny_volumes_approach_the_law_of_little_liquid(
    angles: tuple[float, float], bodies: tuple[float, float]
) -> None:
    """A few times the ring's thickness d apart `lambert` is exact for V → 0; below V* = 1e-9 nothing is tabulated.

    The first correction goes with V*^(1/4), 0.001 at V* = 1e-12, where the table law keeps that of V* = 1e-9: half a per cent.
    """
    case = (*bodies, *angles)
    volume = 1e-12 * effective_radius(*case[:2]) ** 3
    gaps = np.array([0.0, 0.3, 1.0]) * math.sqrt(volume / (math.pi * effective_radius(*case[:2])))
    ratio = laws.young_laplace(gaps, volume, *case, SIGMA) / lambert(gaps, volume, *case, SIGMA)
    assert np.abs(ratio - 1).max() < 5e-3
    limit = rupture(volume, *case).separation
    assert laws.young_laplace_rupture(volume, *case) == pytest.approx(limit, rel=6e-3)
    for share in (0.0, 0.003, 0.01, 0.1, 0.5, 0.95):
        difference = table_force(share * limit, volume, case) - exact_force(share * limit, volume, case)
        assert abs(difference) < 5e-3 * exact_force(0.0, volume, case)
    assert laws.young_laplace(0.0, 0.0, *case, SIGMA) == pytest.approx(lambert(0.0, 0.0, *case, SIGMA), rel=1e-12)
    assert laws.young_laplace(1e-6, 0.0, *case, SIGMA) == laws.young_laplace_rupture(0.0, *case) == 0.0


def test_angles_that_were_not_prepared_give_nan_in_compiled_code() -> None:
    """An engine calls the address; NaN stops its run. From Python the table is prepared by the call itself."""
    force = ctypes.CFUNCTYPE(ctypes.c_double, *[ctypes.c_double] * 7)(laws.young_laplace.address)
    distance = ctypes.CFUNCTYPE(ctypes.c_double, *[ctypes.c_double] * 5)(laws.young_laplace_rupture.address)
    assert math.isnan(force(1e-5, 1e-12, 1e-3, 2e-3, 0.123, 0.456, SIGMA))
    assert math.isnan(distance(1e-12, 1e-3, 2e-3, 0.123, 0.456))
    laws.prepare([(0.217, 0.481)])  # no other test's: what one prepares is there for all
    case = (1e-3, 2e-3, 0.217, 0.481)
    assert force(1e-5, 1e-12, *case, SIGMA) == pytest.approx(table_force(1e-5, 1e-12, case), rel=1e-12)
    assert distance(1e-12, *case) == pytest.approx(float(laws.young_laplace_rupture(1e-12, *case)), rel=1e-12)
    # a pair has an order: the smaller body's angle comes first
    assert math.isnan(force(1e-5, 1e-12, 1e-3, 2e-3, 0.481, 0.217, SIGMA))


def test_more_pairs_of_angles_than_fit_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    laws.prepare([(0.0, 0.0)])
    held = int(laws._BLOCKS[laws.MOST_PAIRS])
    try:
        laws._BLOCKS[laws.MOST_PAIRS] = laws.MOST_PAIRS
        laws.prepare([(0.0, 0.0)])  # already there
        with raises_code("law.many_angles", expected=256):
            laws.prepare([(0.123, 0.456)])
    finally:
        laws._BLOCKS[laws.MOST_PAIRS] = held


@pytest.fixture
def counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """An empty cache, and a quick stand-in for `build` that counts its calls."""
    calls: list[int] = []

    def build(small: float, large: float, progress: object = None) -> tables.Table:
        calls.append(1)
        y, x, u = tables.Y_NODES, tables.X_NODES, tables.U_NODES
        return tables.Table(small, large, np.ones(x), np.full((y, x), 2.0), np.full((y, x), 0.5), np.ones((y, x, u)))

    monkeypatch.setenv("PYWET_CACHE", str(tmp_path))
    monkeypatch.setattr(tables, "build", build)
    return calls


def test_a_table_is_made_once(counted: list[int], tmp_path: Path) -> None:
    first = tables.load(0.1, 0.2)
    (file,) = tmp_path.glob("*.npz")
    before = file.stat().st_mtime_ns
    again = tables.load(0.1, 0.2)
    assert (len(counted), file.stat().st_mtime_ns) == (1, before)
    for name in tables.NAMES:
        assert np.array_equal(getattr(first, name), getattr(again, name))
    tables.load(0.2, 0.1)
    assert len(counted) == 2 and len(list(tmp_path.glob("*.npz"))) == 2


def test_a_damaged_file_is_replaced(counted: list[int], tmp_path: Path) -> None:
    tables.load(0.1, 0.2)
    (file,) = tmp_path.glob("*.npz")
    whole = file.read_bytes()
    flipped = bytearray(whole)
    flipped[len(whole) // 2] ^= 0xFF
    shorter, not_finite = tmp_path / "shorter.npz", tmp_path / "nan.npz"
    with np.load(file) as held:
        arrays = {name: held[name] for name in tables.NAMES}
    np.savez(shorter, **{**arrays, "share": arrays["share"][:, :-1]})
    np.savez(not_finite, **{**arrays, "balance": np.full(tables.X_NODES, np.nan)})
    damaged = [
        b"",
        b"no archive",
        whole[: len(whole) // 2],
        bytes(flipped),
        shorter.read_bytes(),
        not_finite.read_bytes(),
    ]
    for k, content in enumerate(damaged, start=1):
        file.write_bytes(content)
        held_now = tables.load(0.1, 0.2)
        assert len(counted) == 1 + k, f"damage {k} was not noticed"
        assert np.array_equal(held_now.rupture, arrays["rupture"])
        assert len(file.read_bytes()) == len(whole)
        tables.load(0.1, 0.2)
        assert len(counted) == 1 + k  # the new file is whole


def test_a_cache_that_cannot_be_written_is_one_sentence(
    counted: list[int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("PYWET_CACHE", str(tmp_path / "file" / "below"))
    with raises_code("cache.not_made"):
        tables.load(0.1, 0.2)


def test_refuses_angles_of_90_degrees() -> None:
    with raises_code("bridge.table_angle"):
        tables.build(0.0, math.pi / 2)
