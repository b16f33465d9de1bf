"""Numbers that decide which effects are on, derived independently from scene.json by the formulas of docs/effects.md.

The speed of a case is the peak speed of its screen. For a user-defined scene it is not known here: it is computed
from the number of dynamic rupture, sqrt(v eta/sigma), and the others must agree with it, or with a slow phase.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from reference_impl.diagnosis.held import MISSING, Held
from reference_impl.faults import reading
from reference_impl.scene import described, expanded

FILE = "plan.json"
SOURCE = "scene.json by the formulas of docs/effects.md"
LEAST_GAP = 1e-3
"""Smallest gap of the viscous laws over the radius."""
WEIGHT = 9.81
"""Gravity for which a case is planned [m/s2]."""
SLOW = 0.1
"""Speed of slow phases of a user-defined scene [m/s]."""
DRAWN = 0.5 - math.sqrt(3.0) / 4.0
"""Share of its film that a sphere gives to a bridge with an equal one: a cap of half angle 30 degrees on each side."""
CAPPED = ("viscous_normal", "rolling", "tangential_history", "wall_films")
"""Numbers that are shares of something: at most one."""


def there(run: Path) -> bool:
    """Return whether the run has a plan."""
    return (run / FILE).exists()


def compared(run: Path, scene: Mapping[str, Any], case: bool) -> Iterator[Held]:
    """Compare the number of each row with the recomputed one; without weight or liquid only those that do not need it."""
    with reading(f"{run / FILE}", "the plan that `pywet run` writes: build the run again"):
        rows = {row["effect"]: row for row in json.loads((run / FILE).read_text())["rows"]}
    g = WEIGHT if case else math.hypot(*scene["gravity_m_per_s2"])
    speed = peak_speed(scene["vibration"]) if case else _speed(rows, scene["liquid"])
    if speed is None or g == 0.0:
        return
    written = None if case else described.of_run(run)
    films = described.films(expanded.in_full(written, scene), scene) if written else None
    expected = numbers(scene, {speed} if case else {speed, min(speed, SLOW)}, g, films)
    for effect, number in expected.items():
        given = rows.get(effect, {}).get("number", MISSING)
        yield Held(f"plan.{effect}.number", given, number, SOURCE, scale=max(abs(number), 1e-12))


def peak_speed(vibration: Mapping[str, Any]) -> float:
    """Return the largest speed of the screen if its three directions were in phase [m/s]."""
    return 2.0 * math.pi * float(vibration["frequency_Hz"]) * math.dist(vibration["amplitude_m"], (0.0, 0.0, 0.0))


def _speed(rows: Mapping[str, Any], liquid: Mapping[str, Any] | None) -> float | None:
    """Return the speed of a user-defined scene by its plan; None if it cannot be determined."""
    number = rows.get("dynamic_rupture", {}).get("number")
    if not liquid or not number or not liquid["viscosity_Pa_s"]:
        return None
    return float(number) ** 2 * float(liquid["surface_tension_N_per_m"]) / float(liquid["viscosity_Pa_s"])


def numbers(
    scene: Mapping[str, Any], speeds: set[float], g: float, films: Sequence[float] | None = None
) -> dict[str, float]:
    """Return effect -> its number in a moving bed with walls, the largest over speeds and contacts of spheres that exist.

    `films`: of each class [m]; by default all have that of the liquid.
    """
    liquid = scene["liquid"] or {}
    common = liquid.get("initial_film_thickness_m", 0.0)
    thick = {c["type"]: h for c, h in zip(scene["classes"], films or [common] * len(scene["classes"]), strict=True)}
    classes = [c for c in scene["classes"] if c["count"]]
    exist = {0, *(c["type"] for c in classes)}
    met = [(p, kinds) for p in scene["pairs"] if (kinds := {p["a"], p["b"]}) <= exist]
    each = [
        _of_class(c, p, liquid, thick[c["type"]], v, g)
        for v in speeds for c in classes for p, kinds in met if c["type"] in kinds
    ]  # fmt: skip
    found = {effect: max(of[effect] for of in each) for effect in each[0]}
    radii = [c["radius_m"] for c in classes]
    wet = found["bridges"] > 0.0
    unequal = (max(radii) - min(radii)) / (max(radii) + min(radii))
    found["sharing_by_size"] = max(unequal, 0.25) if wet else 0.0
    found["formation"] = DRAWN if wet else 0.0
    if scene.get("hertz"):
        for effect in ("viscous_normal", "wall_films"):  # the contact stiffness depends on the impact speed
            del found[effect]
    return found


def _of_class(
    c: Mapping[str, Any], pair: Mapping[str, Any], liquid: Mapping[str, Any], film: float, v: float, g: float
) -> dict[str, float]:
    """Compute the numbers of effects that follow from Bond, Stokes and capillary numbers of two equal spheres in a contact."""
    r, mu, arm = c["radius_m"], pair["friction"], pair["rolling_friction_m"] / c["radius_m"]
    mass = 4.0 / 3.0 * math.pi * r**3 * c["density_kg_per_m3"]
    sigma, eta, rho = (liquid.get(k, 0.0) if film else 0.0 for k in ("surface_tension_N_per_m", "viscosity_Pa_s",
                                                                      "density_kg_per_m3"))  # fmt: skip
    # a difference of cubes would be inaccurate for thin films
    load = 4.0 / 3.0 * math.pi * film * (3.0 * r * (r + film) + film**2) * rho
    bond = mass * g / (2.0 * math.pi * r * sigma * math.cos(c["contact_angle_rad"])) if sigma else math.inf
    found = {"bridges": film / r, "capillary": 1.0 / bond, "liquid_weight": load / mass, "gravity": 1.0}
    found["dynamic_rupture"] = math.sqrt(v * eta / sigma) if sigma else 0.0
    gap = LEAST_GAP * r
    stokes = mass * v / (3.0 * math.pi * eta * r**2) if eta else math.inf  # m_eff v/(6 pi eta r_red^2)
    if pair["normal_stiffness_N_per_m"]:
        overlap = v * math.sqrt(0.5 * mass / pair["normal_stiffness_N_per_m"])
        lost = math.log(1.0 + 2.0 * film / gap) + overlap / gap
        found["viscous_normal"] = lost / stokes if stokes else math.inf  # a screen at rest
    else:
        found["viscous_normal"] = 0.0
    slides = 3.0 * math.pi * eta * r * (8.0 / 15.0 * math.log(0.5 * r / gap) + 0.9588)
    found["viscous_tangential"] = slides * v / (mu * mass * g) if mu else float(eta > 0.0)
    found["wall_films"] = max(
        DRAWN if film else 0.0, *(found[n] for n in ("capillary", "viscous_normal", "viscous_tangential"))
    )
    found["wall_films"] *= bool(film)
    found["rolling"] = arm * max(1.0 / mu if mu else 0.0, 1.0 / bond)
    found["tangential_history"] = mu
    swing = math.sqrt(32.0 * math.pi * sigma / (3.0 * load)) if load else 0.0
    pulls = load * (g + v * swing)
    found["shedding"] = max(0.0, 1.0 - 2.0 * math.pi * r * sigma / pulls) if pulls and sigma else 0.0
    return found | {name: min(found[name], 1.0) for name in CAPPED}
