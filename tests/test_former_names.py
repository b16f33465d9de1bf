"""Former names warn for one version and give the same."""

from __future__ import annotations

import pytest

import pywet
from pywet.cases.custom.description import Spheres
from pywet.laws import custom_laws


def test_the_module_of_custom_laws() -> None:
    from pywet.laws import own

    with pytest.warns(DeprecationWarning, match=r"pywet\.laws\.own is now pywet\.laws\.custom_laws"):
        assert own.trust is custom_laws.trust


def test_insertion_of_spheres(caplog: pytest.LogCaptureFixture) -> None:
    with pytest.warns(DeprecationWarning, match=r"pywet\.Fed is now pywet\.Insertion"):
        assert pywet.Fed is pywet.Insertion
    entry = {"name": "beads", "material": "glass", "diameter_mm": 3, "count": 1, "velocity_m_per_s": [0, 0, -1],
             "box": {"low_mm": [-9, -9, 5], "high_mm": [9, 9, 20]}}  # fmt: skip
    given = Spheres.model_validate({**entry, "fed": {"for_s": 1}})
    assert "the key fed is now insertion" in caplog.text and given == Spheres.model_validate(
        {**entry, "insertion": {"for_s": 1}}
    )
