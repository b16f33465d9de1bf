"""Tables 1 to 5 of Buck et al. (2018): particles, wall, liquids, friction, initial spins, half-filling angles."""

from __future__ import annotations

from pywet.errors import PywetError

PARTICLES: dict[str, dict[str, float]] = {
    name: {
        "radius_m": 0.5e-3 * diameter,
        "density_kg_per_m3": density,
        "youngs_modulus_Pa": modulus,
        "poisson_ratio": poisson,
        "restitution": restitution,
    }
    for name, diameter, density, modulus, poisson, restitution in (
        ("glass_0.91mm", 0.91, 2500.0, 63.0e9, 0.23, 0.96),
        ("glass_1.74mm", 1.74, 2500.0, 63.0e9, 0.23, 0.96),
        ("alumina_1.74mm", 1.74, 1040.0, 14.5e9, 0.25, 0.76),
    )
}
"""Table 1: particles; `alumina` is γ-Al2O3."""
GLASS_WALL = {"youngs_modulus_Pa": 63.0e9, "poisson_ratio": 0.23}
"""Properties of the glass plate, from the glass beads of table 1 (the paper gives none for the plate)."""
LIQUIDS: dict[str, dict[str, float]] = {
    name: {"density_kg_per_m3": density, "viscosity_Pa_s": 1e-3 * viscosity, "surface_tension_N_per_m": 1e-3 * tension}
    for name, density, viscosity, tension in (
        ("water", 998.0, 1.0, 72.80),
        ("tween20", 998.0, 1.0, 37.30),
        ("glycerol35", 1086.0, 3.0, 69.61),
        ("glycerol50", 1130.0, 6.7, 68.20),
    )
}
"""Table 2: liquids at 20 °C; glycerol50 is the 51 % solution (the paper's text and table 5 call it 50 %)."""
FRICTION = {"dry": 0.195, "tween20": 0.160, "glycerol35": 0.140}
"""Table 3: sliding friction of γ-Al2O3 on glass; other liquids, and glass on glass, are not given."""
SPINS: dict[str, dict[float, tuple[float, float]]] = {
    "dry": {20: (-698, 172), 30: (-1056, 179), 40: (-1777, 411), 50: (-2171, 569)},
    "tween20_100um": {20: (-623, 188), 30: (-961, 199), 40: (-1366, 196), 50: (-1777, 344)},
    "tween20_150um": {20: (-741, 102), 30: (-1125, 178), 40: (-1803, 172), 50: (-2035, 152)},
    "glycerol35_100um": {20: (-704, 96), 30: (-1330, 109), 40: (-1564, 135), 50: (-2181, 151)},
}
"""Table 4: collision angle [deg] -> initial spin and its deviation [rad/s]; the last is printed '50 % glycerol, 3 mPa s'."""
CONTACT_ANGLE_DEG = 15.0
"""Contact angle of all materials and liquids (text of section 3.1)."""
HALF_FILLING_DEG: dict[str, dict[tuple[str, int], float]] = {
    "glass_1.74mm": {
        ("water", 100): 35, ("water", 200): 45, ("water", 400): 55,
        ("glycerol35", 400): 53, ("glycerol50", 400): 51, ("tween20", 100): 35,
    },
    "glass_0.91mm": {("water", 100): 45, ("water", 200): 55},
    "alumina_1.74mm": {
        ("water", 100): 28, ("water", 200): 45, ("water", 400): 53,
        ("glycerol35", 100): 34, ("glycerol35", 200): 44, ("glycerol50", 200): 43,
        ("tween20", 100): 35, ("tween20", 150): 42,
    },
}  # fmt: skip
"""Table 5: particle -> (liquid, layer [µm]) -> half-filling angle [deg]; its '1.8 mm glass' is the 1.74 mm of table 1."""


def layer(particle: str, liquid: str, thickness_um: int) -> dict[str, float]:
    """Return the liquid part of an input file for a pair of table 5."""
    have = HALF_FILLING_DEG.get(particle, {})
    if (liquid, thickness_um) not in have:
        known = ", ".join(f"{name} {t} µm" for name, t in have) or f"a particle of {', '.join(PARTICLES)}"
        raise PywetError(
            f"table 5 has no half-filling angle for {particle} on {thickness_um} µm of {liquid}; expected one of {known}, or "
            "a layer with half_filling_angle_deg of your own"
        )
    return {
        **LIQUIDS[liquid],
        "layer_thickness_m": 1e-6 * thickness_um,
        "contact_angle_deg": CONTACT_ANGLE_DEG,
        "half_filling_angle_deg": have[(liquid, thickness_um)],
    }
