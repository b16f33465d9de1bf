"""Cost of a step, side by side in one run, on the same bed: milliseconds of processor time and ratios to the stock dry program.

Variants: the stock program, dry; the same through this package; the plugin attached to a bed without liquid; moist with every
capillary law there is, and with semi-implicit drag; the stock program with its own `washino` cohesion model (capillary and
viscous forces of a bridge whose liquid stays on the spheres: other physics, the same bed).

`make bench`. Rounds take the variants in turn. A step's cost is the difference of two runs of different length, in processor
time of the engine's process, so that neither start-up nor other work on the machine counts.
"""

from __future__ import annotations

import math
import resource
import statistics
import subprocess
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from pywet.bench import small
from pywet.engines.liggghts import deck
from pywet.laws import registry
from pywet.scene import ContactPair, Liquid, Scene, SphereClass

RADIUS, STEPS, SHORT, ROUNDS, SIDE, FILM = 2.5e-3, 8000, 500, 3, 10, 5e-5
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
Run = Callable[[int], None]


def bed() -> list[small.Sphere]:
    """SIDE³ spheres on a slightly shaken lattice above a floor."""
    jitter = np.random.default_rng(1).uniform(-0.1, 0.1, (SIDE**3, 3)) * RADIUS
    cells = np.stack(np.meshgrid(*[np.arange(SIDE)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    at = (cells + np.array([0.5, 0.5, 0.6])) * 2.2 * RADIUS + jitter - np.array([SIDE * 1.1 * RADIUS] * 2 + [0.0])
    return [small.Sphere(1, (float(x), float(y), float(z))) for x, y, z in at]


def prepare(
    folder: Path, spheres: list[small.Sphere], effects: small.Effects, film: float, steps: int, how: str
) -> Scene:
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
        effects=effects, walls=[small.floor(0.19)], wall_angle_rad=ANGLE, time_step_s=2e-5, steps=steps,
        log_every_step=False, output_interval_s=1.0, gravity=(0.0, 0.0, -9.81), box=0.2, viscous_integration=how,
    )  # fmt: skip


def through_pywet(spheres: list[small.Sphere], effects: small.Effects, film: float, how: str, steps: int) -> None:
    """A run through the driver."""
    with tempfile.TemporaryDirectory() as folder:
        prepare(Path(folder), spheres, effects, film, steps, how)
        small.run(Path(folder), spheres)


def stock(spheres: list[small.Sphere], cohesion: bool, steps: int) -> None:
    """The stock program on the same deck, with its own cohesion model or dry."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        deck.write_deck(prepare(folder, spheres, small.DRY, 0.0, steps, "explicit"), folder, folder)
        if cohesion:
            setup = (folder / "setup.liggghts").read_text()
            setup = setup.replace("tangential history", "tangential history cohesion washino/capillary/viscous")
            (folder / "setup.liggghts").write_text(setup.replace("pair_style", WASHINO + "pair_style", 1))
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


def variants(spheres: list[small.Sphere]) -> dict[str, Run]:
    """Name of a variant -> how to run it for a number of steps."""
    found: dict[str, Run] = {
        "stock dry": partial(stock, spheres, False),
        "dry through pywet": partial(through_pywet, spheres, small.DRY, 0.0, "explicit"),
        "plugin, no liquid": partial(through_pywet, spheres, small.PAPER, 0.0, "explicit"),
    }
    for name in registry.names("capillary"):
        effects = small.PAPER.model_copy(update={"capillary": name})
        found[f"moist, {name}"] = partial(through_pywet, spheres, effects, FILM, "explicit")
    found["moist, semi-implicit"] = partial(through_pywet, spheres, small.PAPER, FILM, "semi_implicit")
    found["stock washino"] = partial(stock, spheres, True)
    return found


def seconds(run: Run, steps: int) -> float:
    """Processor time of the engine's process in a run."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run(steps)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Run all variants in turn and print medians."""
    spheres = bed()
    runs = variants(spheres)
    times: dict[str, list[float]] = {name: [] for name in runs}
    start: dict[str, float] = {}
    for turn in range(ROUNDS):
        for name, run in runs.items():
            start[name] = seconds(run, SHORT)
            times[name].append(1e3 * (seconds(run, SHORT + STEPS) - start[name]) / STEPS)
            print(f"round {turn + 1} of {ROUNDS}: {name} {times[name][-1]:.3f} ms a step", flush=True)
    print(f"{len(spheres)} spheres, {STEPS} steps, median of {ROUNDS} rounds")
    base = times["stock dry"]
    for name, values in times.items():
        ratio = statistics.median(v / b for v, b in zip(values, base, strict=True))
        cost = f"{statistics.median(values):8.3f} ms a step{ratio:7.2f} x stock dry"
        print(f"{name:24s}{cost}   start and {SHORT} steps {start[name]:.1f} s")


if __name__ == "__main__":
    main()
