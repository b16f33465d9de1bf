"""Curves of process models: what a known curve parted is got back, and what cannot tell a sharpness is not fitted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet.products import flowsheet, screening_report
from reference_impl.tables import flowsheet as reference
from tests.products import made_up

SIZES = np.array([2.0, 3.0, 4.0, 4.5, 5.0, 5.5, 6.0, 8.0])
KNOWN = {"Plitt": (5.2, 7.0), "Molerus & Hoffmann": (4.8, 2.5), "Teipel & Hennig": (5.0, 1.5, 4.0, 0.08)}


def parted(t: np.ndarray) -> pd.DataFrame:
    """A partition curve of eight sizes, as wide as a hundred spheres of each make it."""
    return pd.DataFrame({"diameter_mm": SIZES, "T": t, "T_low": t - 0.05, "T_high": t + 0.05})


@pytest.mark.parametrize("curve", flowsheet.CURVES, ids=lambda c: c.name)
def test_a_known_curve_is_got_back(curve: flowsheet.Curve) -> None:
    """Cut size and sharpness; half of the cut size goes to the overs, all of the coarse, of the fine none but the offset."""
    known = KNOWN[curve.name]
    rows = flowsheet.fitted(parted(curve(SIZES, *known))).set_index("model")
    row = rows.loc[curve.name]
    assert 1e3 * row["Xcut_m"] == pytest.approx(known[0], rel=1e-6) and row["rms"] < 1e-8 and pd.isna(row["note"])
    assert [row[name] for name in curve.parameters] == pytest.approx(known[1:], rel=1e-5)
    offset = known[3] if len(known) == 4 else 0.0
    sizes = np.array([1e-3, known[0], 1e2])
    assert curve(sizes, *known) == pytest.approx([offset, 0.5 + 0.5 * offset, 1.0], abs=1e-4)


@pytest.mark.parametrize("known", flowsheet.CURVES, ids=lambda c: c.name)
def test_the_reference_names_what_is_wrong_with_a_fit(known: flowsheet.Curve) -> None:
    """A sound fit of scattered shares agrees; another rms or a parameter 3 % off is named with its curve."""
    t = np.clip(known(SIZES, *KNOWN[known.name]) + np.tile([0.02, -0.03], 4), 0.01, 0.99)
    curve = parted(t).assign(overs_kg=t, unders_kg=1.0 - t)
    sound = flowsheet.fitted(curve)

    def named(rows: pd.DataFrame) -> set[str]:
        return {h.name for h in reference.held("fits", rows, curve) if h.wrong}

    assert named(sound) == set()
    for column, more in (("rms", 0.0), ("Xcut_m", 0.0), ("Alpha", 0.05)):  # an Alpha may be zero
        wrong = sound.copy()
        row = wrong["model"] == known.name
        wrong.loc[row, column] = 1.03 * wrong.loc[row, column] + more
        found = named(wrong)
        assert found and all(name.startswith(f"fits: {known.name}: ") for name in found)


@pytest.mark.parametrize(
    "t", [[0, 0, 0, 0, 1, 1, 1, 1], [0, 0, 0, 0.2, 1, 1, 1, 1], [0.1] * 8], ids=["all or nothing", "one", "no cut"]
)
def test_what_cannot_tell_a_sharpness_is_noted(t: list[float]) -> None:
    rows = flowsheet.fitted(parted(np.array(t, dtype=float)))
    assert rows["Xcut_m"].isna().all() and rows["note"].str.contains("are needed, on both sides of the cut size").all()


def test_a_cut_size_outside_the_sizes_is_not_reported() -> None:
    """Between the two smallest sizes T jumps from 0.49 to 0.9: all three curves would cut below 2 mm, the smallest."""
    rows = flowsheet.fitted(parted(np.array([0.49, 0.9, 0.9, 0.9, 0.92, 0.93, 0.95, 0.97])))
    assert rows["Xcut_m"].isna().all() and set(rows["note"]) == {"no fit: its cut size is outside the sizes"}


def test_files_beside_the_numbers_of_a_screen(tmp_path: Path) -> None:
    """SI units, from the finest size on, the partition curve's own values."""
    folder = made_up.make(tmp_path)
    _, curve, _ = screening_report.analyse(folder, 2.5)
    screening_report.write(folder, aperture_mm=2.5)
    held = pd.read_csv(folder / "results" / "grade_efficiency.csv")
    assert list(held) == ["x_m", "G", "G_low", "G_high"]
    assert held["x_m"].to_numpy() == pytest.approx(1e-3 * np.array(sorted(made_up.SIZES_MM)))
    assert held["G"].to_numpy() == pytest.approx(curve["T"].to_numpy(), abs=0)
    assert list(pd.read_csv(folder / "results" / "flowsheet.csv")["model"]) == [c.name for c in flowsheet.CURVES]
