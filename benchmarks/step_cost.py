"""Cost of a step, side by side in one run: stock dry, plugin attached without liquid, moist. Prints ratios to stock dry.

`make bench`. The same bed of spheres in a box, the same number of steps; each variant is run in turn, several rounds.
"""

from __future__ import annotations

import math
import statistics
import tempfile
from pathlib import Path

import numpy as np

from pywet import small
from pywet.scene import ContactPair, Liquid, SphereClass

RADIUS, STEPS, ROUNDS, SIDE = 2.5e-3, 20000, 3, 10
ANGLE = math.radians(15.0)
WATER = Liquid(
    surface_tension_N_per_m=0.07275, viscosity_Pa_s=1e-3, density_kg_per_m3=998.2, initial_film_thickness_m=5e-5
)
VARIANTS = {"stock dry": (small.DRY, 0.0), "plugin, no liquid": (small.PAPER, 0.0), "moist": (small.PAPER, 5e-5)}


def bed() -> list[small.Sphere]:
    """SIDE³ spheres on a slightly shaken lattice above a floor."""
    jitter = np.random.default_rng(1).uniform(-0.1, 0.1, (SIDE**3, 3)) * RADIUS
    cells = np.stack(np.meshgrid(*[np.arange(SIDE)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    at = (cells + np.array([0.5, 0.5, 0.6])) * 2.2 * RADIUS + jitter - np.array([SIDE * 1.1 * RADIUS] * 2 + [0.0])
    return [small.Sphere(1, (float(x), float(y), float(z))) for x, y, z in at]


def once(effects: small.Effects, film: float, spheres: list[small.Sphere]) -> float:
    """Wall seconds of one run."""
    sphere = SphereClass(
        name="glass", type=1, radius_m=RADIUS, density_kg_per_m3=2500.0, contact_angle_rad=ANGLE, count=len(spheres)
    )
    pairs = [
        ContactPair(
            a=1, b=b, normal_stiffness_N_per_m=1e3, tangential_stiffness_N_per_m=285.7, friction=0.2,
            rolling_friction_m=9e-5, restitution=0.8,
        )
        for b in (0, 1)
    ]  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        small.prepare(
            Path(folder), [sphere], spheres, pairs, liquid=WATER.model_copy(update={"initial_film_thickness_m": film}),
            effects=effects, walls=[small.floor(0.19)], wall_angle_rad=ANGLE, time_step_s=2e-5, steps=STEPS,
            log_every_step=False, output_interval_s=1.0, gravity=(0.0, 0.0, -9.81), box=0.2,
        )  # fmt: skip
        return small.run(Path(folder), spheres).wall_s


def main() -> None:
    """Run all variants in turn and print the median ratios."""
    spheres = bed()
    times: dict[str, list[float]] = {name: [] for name in VARIANTS}
    for _ in range(ROUNDS):
        for name, (effects, film) in VARIANTS.items():
            times[name].append(once(effects, film, spheres))
    base = times["stock dry"]
    print(f"{len(spheres)} spheres, {STEPS} steps, {ROUNDS} rounds; start-up included")
    for name, values in times.items():
        ratio = statistics.median(v / b for v, b in zip(values, base, strict=True))
        print(f"{name:20s} {statistics.median(values):7.2f} s   {ratio:5.2f} x stock dry")


if __name__ == "__main__":
    main()
