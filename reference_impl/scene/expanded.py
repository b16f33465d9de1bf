"""Expand a description: spheres in place of feeds; walls, outlets and gravity in place of a deck.

For a deck only names and motions of its walls are made, not their shapes; for a feed the sizes, not the numbers of
spheres.
"""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.special import ndtri

Description = Mapping[str, Any]
G = 9.81
SIDE_MM = 5.0
"""Thickness of a deck's side walls and back wall."""
SLIT_MM = 0.1
"""Gap between a deck and its back wall."""
TAIL = 0.01
"""Share of the coarsest mass that is cut off an unbounded distribution."""
NO_MOTION: dict[str, Any] = {"vibrates": None, "turns": None, "moves": None, "removed": None}
OPEN: dict[str, Any] = {"low_mm": [None] * 3, "high_mm": [None] * 3, "product": None}
OPEN |= {"crossing_above_mm": None, "moves_with": None}


def in_full(written: Description, scene: Description) -> dict[str, Any]:
    """Expand feeds and deck of a description; `scene` provides files that are not in the run directory."""
    found = {"outlets": [], **written}
    found["spheres"] = [*written["spheres"], *(s for feed in written.get("feed") or () for s in _spheres(feed, scene))]
    if deck := written.get("deck"):
        found["walls"] = [*_walls(deck), *written["walls"]]
        found["outlets"] = [*found["outlets"], *_outlets(deck)]
        if deck.get("periodic"):
            half = 0.5 * deck["width_mm"]
            found["periodic"] = {"axis": "y", "low_mm": -half, "high_mm": half}
        if deck["inclination_deg"]:
            found["gravity_m_per_s2"] = _gravity(deck)
    return found


def not_held(written: Description) -> Iterator[str]:
    """List the parts of this description that could not be compared."""
    if any(s.get("mass_g") for s in written["spheres"]) or written.get("feed"):
        yield "numbers of spheres that follow from a mass or a rate"
    for feed in written.get("feed") or ():
        if feed["psd"]["file"]:
            yield f"sizes of {feed['name']}, which are in {feed['psd']['file']}"


def _gravity(deck: Description) -> list[float]:
    """Return gravity rotated about y by the inclination, so that downhill is along +x."""
    turn = cmath.rect(G, math.radians(deck["inclination_deg"]))
    return [turn.imag, 0.0, -turn.real]


def _levels(deck: Description) -> list[Description]:
    """Return a deck and those beneath it, from the top."""
    return [deck, *(deck.get("beneath") or ())]


def _walls(deck: Description) -> Iterator[dict[str, Any]]:
    """Return names and motion of the walls; the wires across are a separate wall."""
    names = []
    for k, level in enumerate(_levels(deck)):
        number = f"_{k + 1}" if k else ""
        names += [f"screen{number}", f"cross_wires{number}"][: 1 + (level["mesh"] in ("square", "woven"))]
    names += ["back"] if deck.get("periodic") else ["left", "right", "back"]
    for name in names:
        yield {"name": name, "contact_angle_deg": None, **NO_MOTION, "vibrates": _stroke(deck["stroke"])}


def _thick(level: Description) -> float:
    """Return the height of a deck: of its wires, two if woven, or of its plate."""
    if level["mesh"].startswith("punched"):
        return float(level.get("plate_mm") or level["wire_mm"])
    return float(level["wire_mm"]) * (2.0 if level["mesh"] == "woven" else 1.0)


def _stroke(stroke: Description) -> dict[str, Any]:
    """Return amplitudes and phases of the sines along x and z.

    Each combines a sine along the long axis, at the angle, with a cosine along the short axis; the top of the path moves to
    +x if the phase of z is ahead of that of x.
    """
    across = {"linear": 0.0, "circular": 1.0, "elliptic": stroke["ratio"]}[stroke["kind"]]
    along = cmath.rect(1.0, math.radians(stroke["angle_deg"]))
    ahead = 1j * across * (1.0 if stroke["forward"] else -1.0)
    x, z = along.real - ahead * along.imag, along.imag + ahead * along.real
    size, phase = ([f(x), 0.0, f(z)] for f in (abs, cmath.phase))
    return {
        "frequency_Hz": stroke["frequency_Hz"],
        "amplitude_mm": [stroke["amplitude_mm"] * s for s in size],
        "phase_deg": [math.degrees(p) for p in phase],
    }


def _outlets(deck: Description) -> Iterator[dict[str, Any]]:
    """Yield the outlets: two apertures from the deck at both sides and the back; six below the lowest deck for the sections.

    They are as far from where its stroke takes the back wall, and one aperture from where it takes the lowest face. A later
    section contains what no earlier one does. Overs of a deck cross its end above its lower face, which move with the deck.
    """
    away, sections = 2.0 * deck["aperture_mm"], deck["sections"]
    edge = 0.5 * deck["width_mm"] + SIDE_MM + away
    if not deck.get("periodic"):
        yield {**OPEN, "name": "spilled_left", "low_mm": [None, edge, None]}
        yield {**OPEN, "name": "spilled_right", "high_mm": [None, -edge, None]}
    stroke = _stroke(deck["stroke"])
    rear, _, lowest = (
        -size - size * math.sin(math.radians(phase))
        for size, phase in zip(stroke["amplitude_mm"], stroke["phase_deg"], strict=True)
    )
    back = min(-SIDE_MM, rear - SLIT_MM) - SIDE_MM - away
    yield {**OPEN, "name": "spilled_back", "high_mm": [back, None, None]}
    levels, top = _levels(deck), 0.0
    end = [deck["length_mm"], None, None]
    for k, level in enumerate(levels):
        top -= level["below_mm"] if k else 0.0
        name = ("overs", "middlings", "lower_middlings")[k]
        moves = f"screen_{k + 1}" if k else "screen"
        yield {**OPEN, "name": name, "low_mm": end, "crossing_above_mm": top - _thick(level), "moves_with": moves}
    floor = top + min(-6.0 * level["aperture_mm"], lowest - _thick(level) - level["aperture_mm"])
    ends = [deck["length_mm"] * k / sections for k in range(1, sections)]
    for k, end in enumerate([*ends, None], start=1):
        name = f"unders_{k}" if sections > 1 else "unders"
        yield {**OPEN, "name": name, "high_mm": [end, None, floor]}


def _spheres(feed: Description, scene: Description) -> Iterator[dict[str, Any]]:
    """Make an entry of spheres for each size of a feed."""
    moist = feed["moisture_percent"]
    if moist is not None and feed["moisture_of"] == "moist":
        moist = 100.0 / (100.0 / moist - 1.0) if moist else 0.0
    common = {key: feed[key] for key in ("material", "box", "cylinder", "velocity_m_per_s")}
    common |= {"insertion": feed["insertion"], "percent": moist, "film_um": None, "at_mm": None, "count": None}
    for size in _read(feed, scene) if feed["psd"]["file"] else _sizes(feed["psd"]):
        yield {**common, "name": f"{feed['name']} {size:.4g} mm", "diameter_mm": size}


def _read(feed: Description, scene: Description) -> list[float]:
    """Return the sizes as given in the scene."""
    name = re.compile(rf"{re.escape(feed['name'])} [0-9.e+-]+ mm")
    return [2e3 * c["radius_m"] for c in scene["classes"] if name.fullmatch(c["name"])]


def _sizes(psd: Description) -> list[float]:
    """Return the mean sizes of equal parts of the non-empty classes, starting with the finest."""
    low, high, per = float(psd["smallest_mm"]), _largest(psd), psd["sizes_per_class"]
    edges = [low * (high / low) ** (k / psd["classes"]) for k in range(psd["classes"] + 1)]
    found = []
    for a, b in pairwise(edges):
        if _finer(psd, b) > _finer(psd, a):
            parts = [(k + 0.5) / per for k in range(per)]
            found += [a * (b / a) ** p if psd["within"] == "logarithm" else a + p * (b - a) for p in parts]
    return found


def _finer(psd: Description, size: float) -> float:
    """Return the share of the mass that is finer."""
    if r := psd["rosin_rammler"]:
        return -math.expm1(-((size / r["size_mm"]) ** r["spread"]))
    if n := psd["log_normal"]:
        return 0.5 * math.erfc(-math.log(size / n["median_mm"]) / n["sigma"] / math.sqrt(2.0))
    g = psd["gaudin_schuhmann"]
    return float(min(1.0, (size / g["largest_mm"]) ** g["exponent"]))


def _largest(psd: Description) -> float:
    """Return the largest size of a distribution: given, its end, or the size at which its tail is cut off."""
    if psd["largest_mm"] is not None:
        return float(psd["largest_mm"])
    if r := psd["rosin_rammler"]:
        return float(r["size_mm"] * (-np.log(TAIL)) ** (1.0 / r["spread"]))
    if n := psd["log_normal"]:
        return float(n["median_mm"] * np.exp(n["sigma"] * ndtri(1.0 - TAIL)))
    return float(psd["gaudin_schuhmann"]["largest_mm"])
