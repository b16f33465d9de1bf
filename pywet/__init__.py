"""Moist particles in LIGGGHTS, with force laws in Python and an independent reference that checks every run.

A scene is described, run and read back::

    import pywet

    scene = pywet.Scene(
        name="two layers",
        duration_s=0.2,
        materials={"glass": pywet.Material(density_kg_per_m3=2500)},
        liquid=pywet.Liquid(percent=2),
        spheres=[pywet.Spheres(name="glass", material="glass", diameter_mm=3, count=200,
                               box=pywet.Box(low_mm=(-10, -10, 1), high_mm=(10, 10, 80)))],
        walls=[pywet.Wall(name="vessel", vessel=pywet.Vessel(inner_width_mm=22, height_mm=90))],
    )
    for line in pywet.plan(scene).lines:   # which effects the scene needs, and why
        print(line)
    run = pywet.run(scene, "results/two_layers")   # build, simulate, replay, evaluate
    run.ledger, run.events, run.liquid     # DataFrames; their units are in attrs["units"]
    pywet.view("results/two_layers")       # time series for ParaView and a picture

Scenes: `Scene`, `Material`, `Contact`, `Liquid`; `Spheres`, or a `Feed` of a `SizeDistribution` (sieve analysis,
`RosinRammler`, `LogNormal`, `GaudinSchuhmann`), in a `Box` or `Cylinder`, inserted during the run with `Insertion`; `Outlet`; a
`Deck` with its `Stroke`; `Wall` as an STL file, `Block`, `Tube`, `Disc`, `Vessel` or `Bars`, which `Vibrates`, `Turns`, `Moves`
or is `Removed`; `TimeStep`, `Results`. Functions: `read_scene`, `plan`, `run`, `load`, `replay`, `view`; of screens `screen` and
`kinetics`. Laws: `laws`, such as `pywet.laws.capillary.rabinovich`, and `force_law` for custom laws. Errors: `PywetError`.
Everything else may change; docs/own-scene.md explains scenes.
"""

from __future__ import annotations

import importlib
import warnings
from typing import Any

_OF = {
    "errors": "PywetError",
    "laws.force_law": "force_law",
    "scene_stages": "load plan read_scene replay run view",
    "cases.custom.description": "Results Scene TimeStep",
    "cases.custom.materials": "Contact Liquid Material",
    "cases.custom.spheres": "Cylinder Feed Insertion Spheres",
    "cases.custom.walls": "Bars Block Box Disc Moves Removed Tube Turns Vessel Vibrates Wall",
    "products.deck": "Deck Stroke",
    "products.kinetics": "kinetics",
    "products.outlets": "Outlet",
    "products.size_classes": "GaudinSchuhmann LogNormal RosinRammler SizeDistribution",
    "report.screen_page": "screen",
}
_PLACES = {name: module for module, names in _OF.items() for name in names.split()}
__all__ = sorted(_PLACES)


def __getattr__(name: str) -> Any:
    """Return a public name or `__version__`; it is imported at its first use, so that importing pywet is fast."""
    if name == "__version__":
        return _version()
    if name == "laws":
        importlib.import_module("pywet.laws.registry")  # this also imports all modules of laws
        return importlib.import_module("pywet.laws")
    if name == "Fed":
        warnings.warn("pywet.Fed is now pywet.Insertion", DeprecationWarning, 2)
        name = "Insertion"
    if name not in _PLACES:
        raise AttributeError(f"module {__name__} has no attribute {name}")
    return getattr(importlib.import_module(f"pywet.{_PLACES[name]}"), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__", "laws"]


def _version() -> str:
    """Read the version of the installed package."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("pywet")
    except PackageNotFoundError:
        return "not installed as a package"
