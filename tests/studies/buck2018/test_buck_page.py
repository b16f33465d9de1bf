"""Cost of accuracy, fixed steps, figures and page: what they compute (their speed is in benchmarks/)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet.collisions.wall import wall
from pywet.collisions.wall.problem import RTOL
from studies.buck2018 import accuracy_cost, buck_figures, buck_page, curves, readings, verlet
from tests.collisions.cases import problem


def test_errors_fall_with_the_tolerance_and_the_default_is_the_knee() -> None:
    """The default tolerance is the loosest from which on the error stays below 1e-6, the contract's, in the hardest example."""
    table = accuracy_cost.cost(methods={"compiled": 13}, repeats=1)
    rows = table[table["method"] == "compiled"]
    assert rows["error"].iloc[0] > 1e-4 and rows["error"].iloc[-2] < 1e-9
    assert accuracy_cost.knee(table, "compiled")["setting"] == pytest.approx(RTOL, rel=1e-12)
    assert (rows["calls"].diff().dropna() > 0).all()


def test_fixed_steps_converge_slowly() -> None:
    """Velocity Verlet, phases seen step by step: first order, 1e-4 and not 1e-8 at 500 steps per contact."""
    case = problem("alumina_1.74mm", angle_deg=20.0)
    p, first = case.parameters(), wall.start(case, case.parameters())
    exact = accuracy_cost.coefficients(case, wall.integrate(p, first, 1e-13, "compiled").state)
    contact = 6.7e-6
    errors = []
    for n in (20, 500):
        raw = verlet.collide(p, first, contact / n)
        assert abs(raw.steps - n) <= 2
        errors.append(np.abs(accuracy_cost.coefficients(case, raw.state) - exact)[:2].max())
    assert 1e-3 < errors[0] < 0.05 and 1e-6 < errors[1] < 1e-3


def test_fixed_steps_stick_where_the_model_does() -> None:
    for v, stuck in ((0.3, True), (1.0, False)):
        case = problem("glass_1.74mm", ("water", 400), normal_velocity_m_per_s=v)
        p = case.parameters()
        assert bool(verlet.collide(p, wall.start(case, p), 1e-7).state[1] <= 0.0) is stuck


def test_knee_of_a_table() -> None:
    table = pd.DataFrame({"method": "m", "setting": [1e-3, 1e-5, 1e-7, 1e-9], "error": [1e-2, 1e-7, 1e-5, 1e-8]})
    # the small error at 1e-5 is a coincidence: the next tolerance is worse
    assert accuracy_cost.knee(table, "m")["setting"] == 1e-9


def test_readings_change_what_they_should() -> None:
    """Only the shear modulus touches dry tangential motion, nothing but the end of contact the dry coefficient; the gap as
    printed holds the sphere; the toroid in a thick film is not defined.
    """
    table = readings.table().set_index("reading")
    change = table.drop(index="default") - table.loc["default"]
    assert set(change.index[change["e_n dry"].abs() > 1e-6]) == {"contact_end: force"}
    assert set(change.index[change["e_t dry 5°"].abs() > 1e-6]) == {"shear_modulus: as_printed", "variant: as_printed"}
    assert table.loc["gap: as_printed", "e_n 400 µm"] == 0.0
    assert np.isnan(table.loc["capillary: film_and_bridge", "e_n 400 µm"])
    assert table.loc["bridge_volume: frozen", "e_n 400 µm"] > table.loc["default", "e_n 400 µm"] + 0.2
    assert (change.loc["neck_radius: as_printed"].abs() < 1e-12).all()  # φ + θ < 90° in all of table 5


def test_regime_edges_of_figure_12() -> None:
    """Five regimes: four edges, the third regime between about 33° and 45°."""
    rows = pd.DataFrame(curves.over_angle(("tween20", 100), 0.16, -961.0, list(np.arange(1.0, 80.0, 0.5))))
    edges = buck_figures.regime_edges(rows)
    assert edges == pytest.approx([19.5, 33.5, 45.0, 53.5], abs=1.5)


@pytest.mark.parametrize("name", ["fig06", "fig09", "fig12"])
def test_item_of_the_page(name: str, tmp_path: Path) -> None:
    text = buck_page.write_page(tmp_path, {name: buck_page.ITEMS[name]}).read_text()
    table = pd.read_csv(tmp_path / f"{name}.csv")
    assert len(table) >= 20 and table["x"].notna().all()
    assert (tmp_path / f"{name}.svg").read_text().lstrip().startswith("<?xml")
    assert buck_page.ITEMS[name].title in text and "data:image/svg+xml" in text and f'href="{name}.csv"' in text
