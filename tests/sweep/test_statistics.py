"""Statistics of a sweep on tables whose truth is known: effects, optimum, surface, where the next points go."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from scipy.stats import qmc

from pywet.sweep import adaptive, costs, figures, plan, running, significance, surface, sweep_command, sweep_page
from pywet.sweep.description import Axis, Base, Sweep
from pywet.sweep.table import DONE, FAILED
from tests.error_codes import raises_code
from tests.sweep.files import EXAMPLES, WALL, write

AXES = {"a": [0.0, 1.0, 2.0], "b": [0.0, 1.0], "law": ["x", "y"]}


def table_of(sweep: Sweep, seeds: int, noise: float) -> pd.DataFrame:
    """e_n = a + (law is y) + 2 a (law is y), with noise of seeds; b changes nothing."""
    random, rows = np.random.default_rng(5), []
    for k, values in enumerate(product(*(axis.listed for axis in sweep.axes.values())), start=1):
        at = dict(zip(sweep.axes, values, strict=True))
        for seed in range(seeds):
            y = at["a"] + (1.0 + 2.0 * at["a"]) * (at["law"] == "y") + noise * random.normal()
            rows.append({"point": k, **at, "seed": seed, "e_n": y, "f": random.normal(), "status": DONE, "reason": ""})
    return pd.DataFrame(rows).assign(run=range(len(rows)))


def repeated(made: pd.DataFrame) -> pd.DataFrame:
    """The same where a and b mean nothing to law x, as properties of the liquid to a dry bed: these points share their runs."""
    same = made["run"].where(made["law"] == "y", made.groupby(["law", "seed"])["run"].transform("first"))
    return made.assign(run=same)


@pytest.fixture
def sweep(tmp_path: Path) -> Sweep:
    return plan.description.read(write(tmp_path, {**WALL, "axes": AXES, "gather": ["e_n"]}))


def test_effects_that_are_there_are_significant_and_others_not(sweep: Sweep) -> None:
    found = significance.effects(sweep, table_of(sweep, 4, 0.3), "e_n")
    assert found is not None and found.error.startswith("the scatter of seeds (36 degrees of freedom)")
    assert {t.name for t in found.terms if t.significant} == {"a", "law", "a × law"}
    assert len(found.terms) == 6
    of = {t.name: t for t in found.terms}
    assert of["law"].change == pytest.approx(3.0, abs=0.3)  # 1 + 2a at the mean of a
    assert of["a × law"].change == pytest.approx(
        2.0 * 2.0 / 2.0 * 1.0, abs=0.3
    )  # ±1 of a times ±½ of law, times 2·2 / 2


@pytest.mark.parametrize("change", [lambda made: made, repeated], ids=["all different", "some share runs"])
def test_equal_groups_are_called_different_no_more_often_than_the_level(
    sweep: Sweep, change: Callable[[pd.DataFrame], pd.DataFrame]
) -> None:
    """Expect significant terms in 5 % of 200 results of noise alone; 20 are 3.2 standard deviations more."""
    random = np.random.default_rng(11)
    made = change(table_of(sweep, 2, 0.0))
    called = 0
    for _ in range(200):
        noise = random.normal(size=len(made))
        found = significance.effects(sweep, made.assign(e_n=noise[made["run"]]), "e_n")
        assert found is not None
        called += any(t.significant for t in found.terms)
    assert called < 20


def test_points_that_share_runs_count_once(sweep: Sweep) -> None:
    """7 points of 2 seeds are left, and the sentence names the other 10 rows; all points of the best runs are like the best."""
    made = repeated(table_of(sweep, 2, 0.0))
    made["e_n"] = np.random.default_rng(4).normal(made["law"] == "x", 0.01)[made["run"]]
    found = significance.effects(sweep, made, "e_n")
    assert found is not None and found.error == (
        "the scatter of seeds (7 degrees of freedom); 10 of 24 rows repeat the run of another point and are not counted"
    )
    best = significance.optimum(sweep, made, "e_n", largest=True)
    assert best is not None and best.ranges == {"a": "0 to 2", "b": "0 to 1", "law": "x"} and len(best.alike) == 6
    curves = [
        [[*line.get_ydata()] for line in figures.drawn(sweep, rows, ["e_n"], "law", "e_n").axes[0].get_lines()]
        for rows in (made, made.drop_duplicates("run"))
    ]
    assert curves[0] == curves[1]


def test_without_seeds_nothing_is_tested_and_shares_add_up(sweep: Sweep) -> None:
    found = significance.effects(sweep, table_of(sweep, 1, 0.0), "e_n", seeded=False)
    assert found is not None and all(t.p is None for t in found.terms)
    assert sum(t.share for t in found.terms) == pytest.approx(1.0)  # a balanced grid: terms are orthogonal


def test_the_optimum_has_an_interval_and_the_points_like_it(sweep: Sweep) -> None:
    """The largest mean is at a = 2 with law y; b, which changes nothing, makes the one point that is like it."""
    made = table_of(sweep, 5, 0.3)
    best = significance.optimum(sweep, made, "e_n", largest=True)
    assert best is not None and best.half_width is not None
    assert (best.values["a"], best.values["law"]) == (2.0, "y")
    assert abs(best.mean - 7.0) < 2 * best.half_width and best.half_width < 0.8
    assert best.ranges == {"a": "2", "b": "0 to 1", "law": "y"} and len(best.alike) == 2
    method, rows = significance.differences(made, ["e_n", "f"], best.number, int(best.next_best or 0))
    assert "permutation test" in method and [r.p > 0.05 for r in rows] == [True, True]
    _, rows = significance.differences(made, ["e_n", "f"], best.number, 1)
    assert [r.p <= 0.05 for r in rows] == [True, False]


@pytest.mark.parametrize("common", [0.0, 3.0])
def test_statements_on_the_best_point_hold_although_it_is_chosen(sweep: Sweep, common: float) -> None:
    """100 tables of 12 equal points and 2 seeds, also with an error of each seed that all points share.

    The interval misses the truth, and any point is called different, in at most 5 %; 10 are 2.3 standard deviations more.
    """
    random, made = np.random.default_rng(12), table_of(sweep, 2, 0.0)
    held = called = 0
    for _ in range(100):
        noise = random.normal(size=len(made)) + common * random.normal(size=2)[made["seed"]]
        best = significance.optimum(sweep, made.assign(e_n=noise), "e_n", largest=True)
        assert best is not None and best.half_width is not None
        held += abs(best.mean) <= best.half_width
        called += len(best.alike) < 12
    assert held > 90 and called < 10


def test_failed_runs_are_left_out(sweep: Sweep) -> None:
    made = table_of(sweep, 3, 0.1)
    made.loc[made["point"] == 12, ["status", "e_n"]] = [FAILED, np.nan]
    best = significance.optimum(sweep, made, "e_n", largest=True)
    assert best is not None and best.number == 10 and best.half_width is not None


def test_a_surface_is_known_within_its_standard_error(tmp_path: Path) -> None:
    """Compare at 300 points with noise of 0.2: at 90 to 99 % of them the truth is within two standard errors."""
    axes = {"a": {"linspace": [0.0, 1.0, 5]}, "b": {"logspace": [1.0, 100.0, 5]}}
    sweep = plan.description.read(write(tmp_path, {**WALL, "axes": axes, "gather": ["e_n"]}))
    random, inside = np.random.default_rng(3), []

    def truth(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return 1.0 + a - 0.5 * a * np.log10(b) + np.log10(b) ** 2

    a, b = (v.ravel() for v in np.meshgrid(*(axis.listed for axis in sweep.axes.values())))
    for _ in range(30):
        made = pd.DataFrame({"a": a, "b": b, "e_n": truth(a, b) + random.normal(0, 0.2, 25), "status": DONE})
        made["run"] = range(25)
        response = surface.through(sweep, made, "e_n", ["a", "b"])
        assert response is not None
        at = np.column_stack([random.uniform(0, 1, 10), 10 ** random.uniform(0, 2, 10)])
        mean, error = response.at(at)
        inside += (np.abs(mean - truth(*at.T)) < 2.09 * error).tolist()
    assert 0.90 < np.mean(inside) < 0.99
    twice = surface.through(sweep, pd.concat([made, made]), "e_n", ["a", "b"])
    assert twice is not None and twice.at(at)[1] == pytest.approx(error)  # rows that share a run count once


ZIPPED = {"c": [0.1, 0.2, 0.4], "a": [1.0, 2.0, 3.0], "b": [10.0, 20.0, 30.0]}


@pytest.mark.parametrize(
    ("axes", "zips", "significant", "over"),
    [
        (ZIPPED, [["a", "b"]], {"c", "a + b"}, "c and a + b"),
        (ZIPPED | {"c": [0.1, 0.4]}, [["a", "b"]], {"c", "a + b"}, None),
        (ZIPPED | {"d": [5.0, 7.0, 8.0]}, [["c", "d"], ["a", "b"]], {"c + d", "a + b"}, "c + d and a + b"),
        (ZIPPED | {"law": ["x", "y", "z"]}, [["a", "b", "law"]], {"c", "a + b + law"}, "c and a + b + law"),
        ({"d": [1.0, 2.0], **ZIPPED}, [["b", "a"]], {"c", "b + a"}, "c and b + a"),
        ({"d": [1.0, 2.0], "c": ZIPPED["c"], "a": ZIPPED["a"]}, [], {"c", "a"}, "c and a"),
    ],
    ids=["two of three", "two values", "two zips", "with text", "after two values", "no zip"],
)  # fmt: skip
def test_axes_that_change_together_are_one(
    tmp_path: Path, axes: dict[str, list[Any]], zips: list[list[str]], significant: set[str], over: str | None
) -> None:
    """e_n = 100 c + a and noise: a term for each zip; the map is over the first two independent axes of three values each."""
    asked = zipped(tmp_path, axes, zips)
    made = table_of_points(asked, 4, lambda at: 100.0 * at["c"] + at["a"])
    found = significance.effects(asked.sweep, made, "e_n")
    assert found is not None and {t.name for t in found.terms if t.significant} == significant
    groups = len(axes) - sum(len(group) - 1 for group in zips)
    assert len(found.terms) == groups + groups * (groups - 1) // 2
    (section,) = sweep_page._maps(asked, made)
    assert (f"e_n over {over}<" in section.body) == (over is not None) == (sweep_page.NO_MAP not in section.body)
    for group in zips:
        assert f"{' + '.join(group)} change together." in sweep_page._varied(asked, made)


def test_text_of_a_zip_has_its_levels_and_a_curved_zip_no_map(tmp_path: Path) -> None:
    """Seven laws, each with its numbers, in no order: the zip explains all. Points along a curve determine no surface."""
    axes = {"a": [1.0, 2.0, 4.0, 8.0, 16.0, 33.0, 47.0], "b": [5.0, 1.0, 9.0, 3.0, 12.0, 4.0, 7.0], "law": [*"tuvwxyz"]}
    asked = zipped(tmp_path, axes, [[*axes]])
    made = table_of_points(asked, 2, lambda at: (13.0 * at["a"]) % 5.0)
    found = significance.effects(asked.sweep, made, "e_n")
    assert found is not None and [t.share for t in found.terms] == pytest.approx([1.0], abs=0.05)
    assert surface.through(asked.sweep, made, "e_n", ["a", "b"]) is None
    with raises_code("sweep.map_points"):
        figures.response_map(asked.sweep, made, "e_n", "a", "b")
    (section,) = sweep_page._maps(asked, made)
    assert sweep_page.NO_MAP in section.body


def test_more_names_the_zipped_axis(tmp_path: Path) -> None:
    with raises_code("sweep.axis_range", key="axes.a"):
        adaptive._axes(zipped(tmp_path, ZIPPED, [["a", "b"]]))


def zipped(folder: Path, axes: dict[str, list[Any]], zips: list[list[str]]) -> plan.Plan:
    """A sweep of a base that is not read."""
    file = write(folder, {**WALL, "axes": axes, "zips": zips, "gather": ["e_n"]})
    return plan.Plan(file, plan.description.read(file), None, None, folder)  # type: ignore[arg-type]


def table_of_points(asked: plan.Plan, seeds: int, truth: Callable[[Mapping[str, Any]], float]) -> pd.DataFrame:
    """A result at all points with noise of 0.1."""
    random = np.random.default_rng(6)
    rows = [
        {"point": p.number, **p.values, "seed": seed, "e_n": truth(p.values) + 0.1 * random.normal(), "status": DONE}
        for p in asked.points for seed in range(seeds)
    ]  # fmt: skip
    made = pd.DataFrame(rows).assign(run=range(len(rows)))
    made.attrs["units"] = {}
    return made


def test_next_points_go_where_no_point_is_and_where_interpolations_differ() -> None:
    """A hole in one corner is filled first; of two equal gaps that with the bend."""
    axes = {"a": Axis(low=0.0, high=1.0), "b": Axis(low=0.0, high=1.0)}
    grid = np.array(list(product(np.linspace(0, 1, 5), repeat=2)))
    rest = grid[~((grid[:, 0] > 0.6) & (grid[:, 1] > 0.6))]
    first = adaptive.least_known(rest, np.ones(len(rest)) + rest[:, 0], 1, axes, [])[0]
    assert first["a"] > 0.8 and first["b"] > 0.8
    line = np.array([[0.0], [0.1], [0.2], [0.5], [0.8], [0.9], [1.0]])
    bend = np.where(line[:, 0] > 0.45, 10.0 * (line[:, 0] - 0.5) ** 2, 0.0)
    found = adaptive.least_known(line, bend, 1, {"a": Axis(low=0.0, high=1.0)}, [])[0]
    assert 0.5 < found["a"] < 0.8


def test_no_whole_number_is_added_twice() -> None:
    """Of 1 to 6 three are points; the other three are added, and no fourth."""
    axes = {"n": Axis(low=1.0, high=6.0, whole=True)}
    there = np.array([1.0, 3.0, 6.0])
    found = adaptive.least_known((there[:, None] - 1.0) / 5.0, there**2, 4, axes, [])
    assert sorted(point["n"] for point in found) == [2, 4, 5]


def test_round_off_of_a_result_without_scatter_is_not_significant(sweep: Sweep) -> None:
    """A result that depends on one axis alone: no other term is significant."""
    random = np.random.default_rng(5)
    made = table_of(sweep, 1, 0.0)
    for _ in range(50):
        level = dict(zip(AXES["a"], random.uniform(1.0, 10.0, 3), strict=True))
        found = significance.effects(sweep, made.assign(e_n=made["a"].map(level)), "e_n")
        assert found is not None and [t.name for t in found.terms if t.significant] == ["a"]


def test_where_the_seeds_coincide_nothing_is_tested(sweep: Sweep) -> None:
    """No result scatters, as where all positions are given, or this one does not by accident: there is no interval, and no p."""
    made = table_of(sweep, 2, 0.0)
    for results in (made, made.assign(f=1.0)):
        counts = results.assign(e_n=40.0 + made["a"] * (1.0 + 1e-15 * made["seed"]))
        found, best = (
            significance.effects(sweep, counts, "e_n"),
            significance.optimum(sweep, counts, "e_n", largest=True),
        )
        assert found is not None and found.error == "none, as the seeds coincide: nothing is tested"
        assert all(t.p is None for t in found.terms)
        assert best is not None and (best.mean, best.half_width, best.runs) == (42.0, None, 2)


def _interpolated(places: np.ndarray, values: np.ndarray, at: np.ndarray, power: int) -> np.ndarray:
    """Radial-basis interpolation by the dense system: -r with a constant, or r³ with a plane."""

    def kernel(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        r = np.linalg.norm(x[:, None] - y[None], axis=-1)
        return np.asarray(r**3 if power == 3 else -r)

    def tail(x: np.ndarray) -> np.ndarray:
        return np.hstack([np.ones((len(x), 1)), x]) if power == 3 else np.ones((len(x), 1))

    n, t = len(places), tail(places)
    matrix = np.block([[kernel(places, places), t], [t.T, np.zeros((t.shape[1], t.shape[1]))]])
    solved = np.linalg.solve(matrix, np.concatenate([values, np.zeros(t.shape[1])]))
    return np.asarray(kernel(at, places) @ solved[:n] + tail(at) @ solved[n:])


def test_next_points_follow_the_stated_rule() -> None:
    """Largest distance times 1 + difference of both interpolations over the deviation, recomputed for three points in turn."""
    axes = {"a": Axis(low=0.0, high=1.0), "b": Axis(low=1.0, high=100.0, log=True)}
    random = np.random.default_rng(7)
    places = random.uniform(size=(9, 2))
    values = np.sin(5.0 * places[:, 0]) + places[:, 1] ** 2
    found = adaptive.least_known(places, values, 3, axes, [])
    candidates = qmc.Sobol(2, rng=1).random(adaptive.CANDIDATES)
    for point in found:
        apart = np.linalg.norm(candidates[:, None] - places[None], axis=-1).min(axis=1)
        cubic, linear = (_interpolated(places, values, candidates, power) for power in (3, 1))
        best = int((apart * (1.0 + np.abs(cubic - linear) / values.std())).argmax())
        u, v = candidates[best]
        assert (point["a"], point["b"]) == pytest.approx((u, 100.0**v))
        places, values = np.vstack([places, candidates[best]]), np.append(values, cubic[best])


def test_adaptive_points_belong_to_the_sweep(tmp_path: Path) -> None:
    axes = {"friction": {"low": 0.05, "high": 0.4}, "liquid.viscosity_Pa_s": {"low": 1e-3, "high": 1e-2, "log": True}}
    content = {**WALL, "axes": axes, "design": {"sobol": 8}, "constraints": ["friction < 0.3"]}
    file = write(tmp_path, content)
    first = plan.read(file, tmp_path / "out", tmp_path / "store")
    before = len(first.points)
    made = sweep_command.carry_out(first, 1, 1, 4, lambda line: None)
    assert len(made) == before + 4 and made["e_n"].notna().all()
    new = made.iloc[-4:]
    assert (new["friction"] < 0.3).all() and not new.duplicated(subset=list(axes)).any()
    assert len(plan.read(file, tmp_path / "out", tmp_path / "store").missing) == 0
    text = plan.read(
        write(tmp_path, {**WALL, "axes": {"variant": ["mended", "as_printed"]}}), tmp_path / "b", tmp_path / "store"
    )
    with raises_code("sweep.axis_range", key="axes.variant"):
        sweep_command.carry_out(text, 1, 1, 1, lambda line: None)


def test_a_point_that_cannot_be_run_is_not_added(tmp_path: Path) -> None:
    """The largest gap is at the corner of the file's grid that has no toroid; another call begins as before."""
    axes = {"liquid.contact_angle_deg": [15, 50, 85], "liquid.half_filling_angle_deg": [40, 65, 90]}
    content = {**WALL, "axes": axes, "constraints": ["contact_angle_deg < 85 or half_filling_angle_deg < 90"]}
    content["gather"] = ["e_n"]
    asked = plan.read(write(tmp_path, content), tmp_path / "out", tmp_path / "store")
    made = sweep_command.carry_out(asked, 1, 1, 3, lambda line: None)
    new = made.iloc[8:]
    assert len(new) == 3 and new["e_n"].notna().all() and (new[[*axes]].sum(axis=1) <= 170.0).all()
    assert len(plan.read(asked.file, tmp_path / "out", tmp_path / "store").runs) == 11


def test_a_point_whose_run_fails_is_not_chosen_again(tmp_path: Path) -> None:
    axes = {"friction": {"low": 0.05, "high": 0.4}, "normal_velocity_m_per_s": {"low": 0.5, "high": 1.0}}
    content = {**WALL, "axes": axes, "design": {"sobol": 8}, "gather": ["e_n"]}
    asked = plan.read(write(tmp_path, content), tmp_path / "out", tmp_path / "store")
    rows = [{"point": p.number, **p.values, "e_n": p.values["friction"], "status": DONE} for p in asked.points]
    for count in (9, 10, 11):
        asked = adaptive.extended(asked, pd.DataFrame(rows), 1)
        assert len(asked.points) == count
        rows.append({"point": count, **asked.points[-1].values, "e_n": np.nan, "status": FAILED})


def test_points_beyond_the_limit_are_not_added(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A refused call leaves a sweep that the next call finds complete."""
    content = {**WALL, "axes": {**WALL["axes"], "friction": [0.1, 0.2, 0.3]}}
    asked = plan.read(write(tmp_path, content), tmp_path / "out", tmp_path / "store")
    running.carry_out(asked, asked.runs)
    monkeypatch.setattr(costs, "COLLISION", costs.Cost(1e9, 0.0))
    with raises_code("sweep.too_much"):
        sweep_command.carry_out(asked, 1, 1, 2, lambda line: None)
    assert plan.read(asked.file, tmp_path / "out", tmp_path / "store").missing == []


def test_listed_numbers_of_spheres_become_whole_numbers(tmp_path: Path) -> None:
    """A count has no fraction, also written as 20.0; a speed of rotation has, also where all listed ones are integers."""
    base = {"scene": str(EXAMPLES / "sweeps" / "small_drum_scene.yaml")}
    axes = {"spheres.0.count": {"linspace": [10, 40, 4]}, "walls.mantle.turns.turns_per_minute": [10, 40, 70]}
    content = {"name": "drum", "base": base, "axes": axes, "gather": ["ruptures"]}
    asked = plan.read(write(tmp_path, content), tmp_path / "out", tmp_path / "store")
    rows = [{"point": p.number, **p.values, "ruptures": float(p.number), "status": DONE} for p in asked.points]
    found = adaptive.extended(asked, pd.DataFrame(rows), 3)
    new = pd.DataFrame([p.values for p in found.points[len(rows) :]])
    assert len(new) == 3 and len(found.runs) == len(rows) + 3
    assert all(isinstance(count, int) for count in new["spheres.0.count"].tolist())
    assert not all(speed.is_integer() for speed in new["walls.mantle.turns.turns_per_minute"])
    script = plan.Plan(asked.file, asked.sweep.model_copy(update={"base": Base(script="in")}), *([None] * 3))  # type: ignore[arg-type]
    assert [adaptive._integer(script, "script.n", values) for values in ([10, 20], [10, 20.0])] == [True, False]


def test_a_figure_has_means_and_intervals_of_the_table(sweep: Sweep) -> None:
    made = table_of(sweep, 4, 0.1)
    figure = figures.drawn(sweep, made, ["e_n"], "a", "e_n", "law")
    lines = [line for line in figure.axes[0].get_lines() if len(line.get_xdata()) == 3 and line.get_linestyle() == "-"]
    means = made[made["law"] == "y"].groupby("a")["e_n"].mean().tolist()
    assert any(np.allclose(np.asarray(line.get_ydata(), float), means) for line in lines)
    labels = {str(line.get_label()): list(line.get_ydata()) for line in figure.axes[0].get_lines()}
    assert labels["_law y mean"] == pytest.approx(means)  # means and interval bounds are also in the CSV of the page
    ends = [
        np.add(labels["_law y 95 % high"], labels["_law y 95 % low"]) / 2,
        np.subtract(labels["_law y 95 % high"], means),
    ]
    groups = made[made["law"] == "y"].groupby("a")["e_n"]
    half = [stats.t.ppf(0.975, len(g) - 1) * g.std() / np.sqrt(len(g)) for _, g in groups]
    assert ends[0] == pytest.approx(means) and ends[1] == pytest.approx(half)
    with raises_code("sweep.two_axes"):
        figures.drawn(sweep, made, ["e_n"], "a", "b")
