"""Former names warn for one version and give the same."""

from __future__ import annotations

import importlib

import pytest
import yaml

import pywet
from pywet.cases.custom.spheres import Spheres
from pywet.config.scales import Scale
from pywet.laws import custom_laws
from tests.import_graph import ROOT


@pytest.mark.parametrize(
    ("module", "name", "now", "sentence"),
    [
        ("pywet.laws.own", "trust", custom_laws.trust, r"pywet\.laws\.own is now pywet\.laws\.custom_laws"),
        ("pywet", "Fed", pywet.Insertion, r"pywet\.Fed is now pywet\.Insertion"),
    ],
)
def test_former_names_in_python(module: str, name: str, now: object, sentence: str) -> None:
    with pytest.warns(DeprecationWarning, match=sentence):
        assert getattr(importlib.import_module(module), name) is now


def test_former_name_of_analytic_wires(caplog: pytest.LogCaptureFixture) -> None:
    given = yaml.safe_load((ROOT / "config" / "scales.yaml").read_text())["scales"]["full"]
    assert given["wires"] == "analytic"
    assert Scale.model_validate({**given, "wires": "prism"}) == Scale.model_validate(given)
    assert "wires: prism is now wires: analytic" in caplog.text


def test_former_name_of_insertion(caplog: pytest.LogCaptureFixture) -> None:
    entry = {"name": "beads", "material": "glass", "diameter_mm": 3, "count": 1, "velocity_m_per_s": [0, 0, -1],
             "box": {"low_mm": [-9, -9, 5], "high_mm": [9, 9, 20]}}  # fmt: skip
    given = Spheres.model_validate({**entry, "fed": {"for_s": 1}})
    assert "the key fed is now insertion" in caplog.text and given == Spheres.model_validate(
        {**entry, "insertion": {"for_s": 1}}
    )
