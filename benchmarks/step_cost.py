"""Cost of a step, side by side in one run, on the same bed: prints milliseconds a step and ratios to the stock dry program.

Variants: the stock program, dry; the same through this package; the plugin attached to a bed without liquid; moist with every
capillary law there is, and with semi-implicit drag; the stock program with its own `washino` cohesion model (capillary and
viscous forces of a bridge whose liquid stays on the spheres: other physics, the same bed).

`make bench`. Rounds take the variants in turn; `loop` is the engine's own loop time, `wall` has start-up and tables in it.
"""

from __future__ import annotations

import math
import re
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from pywet import small
from pywet.engines.liggghts import deck
from pywet.laws import registry
from pywet.scene import ContactPair, Liquid, Scene, SphereClass

RADIUS, STEPS, ROUNDS, SIDE, FILM = 2.5e-3, 10000, 3, 10, 5e-5
ANGLE = math.radians(15.0)
WATER = Liquid(
    surface_tension_N_per_m=0.07275, viscosity_Pa_s=1e-3, density_kg_per_m3=998.2, initial_film_thickness_m=FILM
)
WASHINO = f"""
fix p_liquid all property/global surfaceLiquidContentInitial scalar {3 * FILM / RADIUS!r}
fix p_tension all property/global surfaceTension scalar {WATER.surface_tension_N_per_m!r}
fix p_viscosity all property/global fluidViscosity scalar {WATER.viscosity_Pa_s!r}
fix p_angle all property/global contactAngle peratomtype {ANGLE!r} {ANGLE!r}
fix p_least all property/global minSeparationDistanceRatio scalar 1.01
fix p_most all property/global maxSeparationDistanceRatio scalar 1.1
"""
Times = tuple[float, float]


def bed() -> list[small.Sphere]:
    """SIDE³ spheres on a slightly shaken lattice above a floor."""
    jitter = np.random.default_rng(1).uniform(-0.1, 0.1, (SIDE**3, 3)) * RADIUS
    cells = np.stack(np.meshgrid(*[np.arange(SIDE)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    at = (cells + np.array([0.5, 0.5, 0.6])) * 2.2 * RADIUS + jitter - np.array([SIDE * 1.1 * RADIUS] * 2 + [0.0])
    return [small.Sphere(1, (float(x), float(y), float(z))) for x, y, z in at]


def prepare(folder: Path, spheres: list[small.Sphere], effects: small.Effects, film: float, how: str) -> Scene:
    """The bed as a scene."""
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
    return small.prepare(
        folder, [sphere], spheres, pairs, liquid=WATER.model_copy(update={"initial_film_thickness_m": film}),
        effects=effects, walls=[small.floor(0.19)], wall_angle_rad=ANGLE, time_step_s=2e-5, steps=STEPS,
        log_every_step=False, output_interval_s=1.0, gravity=(0.0, 0.0, -9.81), box=0.2, viscous_integration=how,
    )  # fmt: skip


def loop_time(log: Path) -> float:
    """Seconds in the engine's time loop."""
    return sum(float(t) for t in re.findall(r"Loop time of (\S+) on", log.read_text()))


def through_pywet(spheres: list[small.Sphere], effects: small.Effects, film: float, how: str = "explicit") -> Times:
    """Loop and wall seconds of a run through the driver."""
    with tempfile.TemporaryDirectory() as folder:
        prepare(Path(folder), spheres, effects, film, how)
        wall = small.run(Path(folder), spheres).wall_s
        return loop_time(Path(folder) / "engine" / "log.liggghts"), wall


def stock(spheres: list[small.Sphere], cohesion: bool) -> Times:
    """Loop and wall seconds of the stock program on the same deck, with its own cohesion model or dry."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        deck.write_deck(prepare(folder, spheres, small.DRY, 0.0, "explicit"), folder, folder)
        if cohesion:
            setup = (folder / "setup.liggghts").read_text()
            setup = setup.replace("tangential history", "tangential history cohesion washino/capillary/viscous")
            (folder / "setup.liggghts").write_text(setup.replace("pair_style", WASHINO + "pair_style", 1))
        started = time.monotonic()
        done = subprocess.run(
            ["liggghts", "-in", "in.liggghts"],
            cwd=folder,
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
        )
        if done.returncode != 0:
            raise SystemExit("\n".join(done.stdout.splitlines()[-5:]))
        return loop_time(folder / "log.liggghts"), time.monotonic() - started


def variants(spheres: list[small.Sphere]) -> dict[str, Callable[[], Times]]:
    """Name of a variant -> how to run it."""
    found: dict[str, Callable[[], Times]] = {
        "stock dry": partial(stock, spheres, False),
        "dry through pywet": partial(through_pywet, spheres, small.DRY, 0.0),
        "plugin, no liquid": partial(through_pywet, spheres, small.PAPER, 0.0),
    }
    for name in registry.names("capillary"):
        effects = small.PAPER.model_copy(update={"capillary": name})
        found[f"moist, {name}"] = partial(through_pywet, spheres, effects, FILM)
    found["moist, semi-implicit"] = partial(through_pywet, spheres, small.PAPER, FILM, "semi_implicit")
    found["stock washino"] = partial(stock, spheres, True)
    return found


def main() -> None:
    """Run all variants in turn and print medians."""
    spheres = bed()
    runs = variants(spheres)
    times: dict[str, list[Times]] = {name: [] for name in runs}
    for turn in range(ROUNDS):
        for name, once in runs.items():
            times[name].append(once())
            print(f"round {turn + 1} of {ROUNDS}: {name} {times[name][-1][0]:.1f} s", flush=True)
    print(f"{len(spheres)} spheres, {STEPS} steps, median of {ROUNDS} rounds")
    print(f"{'':24s}{'ms a step':>10s}{'loop':>16s}{'wall':>16s}")
    base = times["stock dry"]
    for name, values in times.items():
        loop, wall = (statistics.median(v[k] / b[k] for v, b in zip(values, base, strict=True)) for k in (0, 1))
        step = 1e3 * statistics.median(v[0] for v in values) / STEPS
        print(f"{name:24s}{step:10.3f}{loop:8.2f} x stock{wall:8.2f} x stock")


if __name__ == "__main__":
    main()
