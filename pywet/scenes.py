"""Small scenes ready to run: a pull, a collision of two, a bed settling in a box, a rotating drum. `pywet scene NAME`.

Each is a function that prepares a run directory (pywet.small), runs the engine and returns what one wants to know as plain
numbers; the run directory holds everything else (trajectory, history) as after a screening case.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from pywet import advisor, small
from pywet.errors import PywetError
from pywet.files import read_table, write_json
from pywet.geometry.solids import bin_solid, plate, polygon, tube
from pywet.geometry.surface import Surface, make_surface
from pywet.ranges import SCENE
from pywet.scene import ContactPair, Liquid, Output, Rotation, Scene, SphereClass
from pywet.screening.amounts import common_film_thickness

RESULT = "scene_result.json"
FIT_IN_DRUM = 44
"""From this number on the spheres' lattice fits into the drum that is made for them."""


@dataclass(frozen=True)
class Choice:
    """What can be chosen of a scene; what a scene does not have is ignored."""

    spheres: int = 500
    radius_m: float = 1.5e-3
    moisture_percent: float = 1.0
    """Liquid over the mass of the spheres."""
    viscosity_Pa_s: float = 1e-3
    speed_m_per_s: float | None = None
    """Of the pull (0.05 if not given) or of the collision (0.5)."""
    turns_per_minute: float = 20.0
    seconds: float | None = None
    ranks: int = 1
    seed: int = 1
    viscous_integration: str = "semi_implicit"

    def __post_init__(self) -> None:
        for name, limits in SCENE.items():
            if getattr(self, name) is not None:
                limits.read(name, getattr(self, name))


def glass(choice: Choice, count: int) -> SphereClass:
    """Glass spheres."""
    return SphereClass(
        name="glass",
        type=1,
        radius_m=choice.radius_m,
        density_kg_per_m3=2500.0,
        contact_angle_rad=math.radians(15.0),
        count=count,
    )


def contacts(stiffness: float = 2e3) -> list[ContactPair]:
    """Glass on itself and on the walls; soft springs, as long as overlaps stay below some per cent of the radius."""
    return [
        ContactPair(
            a=1,
            b=b,
            normal_stiffness_N_per_m=stiffness,
            tangential_stiffness_N_per_m=2.0 / 7.0 * stiffness,
            friction=0.4,
            rolling_friction_m=2e-5,
            restitution=0.8,
        )
        for b in (0, 1)
    ]


def liquid(choice: Choice, sphere: SphereClass) -> Liquid:
    """Water of the chosen viscosity, as the same film on every sphere."""
    volume = 0.01 * choice.moisture_percent * sphere.mass_kg * sphere.count / 1000.0
    return Liquid(
        surface_tension_N_per_m=0.0728,
        viscosity_Pa_s=choice.viscosity_Pa_s,
        density_kg_per_m3=1000.0,
        initial_film_thickness_m=common_film_thickness((sphere,), volume),
    )


def time_step(choice: Choice, sphere: SphereClass, stiffness: float) -> float:
    """A tenth of the stable step of a dense packing, cut to two digits; explicit drag counts with its damping time."""
    log_e = math.log(0.8)
    m = 0.5 * sphere.mass_kg
    gamma = -2.0 * log_e * math.sqrt(m * stiffness) / math.hypot(math.pi, log_e)
    r_red, gap = 0.5 * sphere.radius_m, 1e-3 * sphere.radius_m
    drag = 6.0 * math.pi * choice.viscosity_Pa_s * r_red**2 / gap
    implicit = choice.viscous_integration == "semi_implicit"
    step = 0.1 * advisor.largest_step(m, stiffness, gamma, 0.0 if implicit else drag, False, advisor.PACKED)
    digit = 10.0 ** (math.floor(math.log10(step)) - 1)
    return math.floor(step / digit) * digit


def pull(run_dir: Path, choice: Choice) -> dict[str, float]:
    """Two spheres drawn apart from touch: largest force [N], rupture distance [m], work [J]."""
    sphere, step, speed = glass(choice, 2), 1e-5, choice.speed_m_per_s or 0.05
    r = sphere.radius_m
    bodies = [
        small.Sphere(1, (0.0, 0.0, 0.0), driven=True),
        small.Sphere(1, (0.0, 0.0, 2.0 * r), (0.0, 0.0, speed), driven=True),
    ]
    steps = round((choice.seconds or 0.8 * r / speed) / step)
    _prepare(run_dir, choice, sphere, bodies, step, steps, log_every_step=True)
    small.run(run_dir, bodies, choice.ranks)
    log, events = (read_table(run_dir / "history" / f"{name}.parquet") for name in ("contacts", "events"))
    broken = events[events["kind"] == 1]
    return {
        "largest_force_N": float(np.abs(log["force_i_z"]).max()),
        "rupture_distance_m": float(broken["separation"].iloc[0]) if len(broken) else math.nan,
        "work_J": float(read_table(run_dir / "history" / "energy.parquet")["drive"].iloc[-1]),
    }


def collision(run_dir: Path, choice: Choice) -> dict[str, float]:
    """Two wet spheres thrown at each other: coefficient of restitution, where the energy went [J]."""
    sphere, speed = glass(choice, 2), choice.speed_m_per_s or 0.5
    r, v = sphere.radius_m, 0.5 * speed
    film = liquid(choice, sphere).initial_film_thickness_m
    gap = 2.2 * film + 1e-6
    bodies = [
        small.Sphere(1, (0.0, 0.0, -r - 0.5 * gap), (0.0, 0.0, v)),
        small.Sphere(1, (0.0, 0.0, r + 0.5 * gap), (0.0, 0.0, -v)),
    ]
    step = min(time_step(choice, sphere, 1e5), 2e-6)
    steps = round((choice.seconds or (4.0 * gap + 2.0 * r) / speed) / step)
    _prepare(run_dir, choice, sphere, bodies, step, steps, stiffness=1e5)
    small.run(run_dir, bodies, choice.ranks)
    end = read_table(run_dir / "trajectory.parquet").query("step == step.max()").sort_values("id")["vz"].to_numpy()
    energy = read_table(run_dir / "history" / "energy.parquet").iloc[-1]
    apart = read_table(run_dir / "history" / "ledger.parquet")["bridge_count"].iloc[-1] == 0
    return {
        "restitution": float(end[1] - end[0]) / (2.0 * v) if apart else 0.0,
        **{f"{name}_J": float(energy[name]) for name in ("contact", "capillary", "viscous_normal")},
    }


def bed(run_dir: Path, choice: Choice) -> dict[str, float]:
    """Moist spheres that fall into a box and come to rest: solid fraction, bridges per sphere, liquid in bridges."""
    sphere, r = glass(choice, choice.spheres), choice.radius_m
    across = max(4, round(choice.spheres ** (1.0 / 3.0)))
    half = 1.15 * r * across + 0.5 * r
    layers = math.ceil(choice.spheres / across**2)
    vessel = make_surface("box", "wall", bin_solid(half, 0.004, 4, 0.0, 2.5 * r * (layers + 2)))
    bodies = _lattice(choice, across, 2.3, 1.5 * r)
    step = time_step(choice, sphere, 2e3)
    steps = round((choice.seconds or 0.4) / step)
    _prepare(run_dir, choice, sphere, bodies, step, steps, walls=(vessel,), gravity=(0.0, 0.0, -9.81))
    small.run(run_dir, bodies, choice.ranks)
    end = read_table(run_dir / "trajectory.parquet").query("step == step.max()")
    top = float(np.sort(end["z"].to_numpy())[-across * across // 2 :].mean()) + r
    ledger = read_table(run_dir / "history" / "ledger.parquet").iloc[-1]
    return {
        "solid_fraction": choice.spheres * 4.0 / 3.0 * math.pi * r**3 / (4.0 * half**2 * top),
        "bridges_per_sphere": 2.0 * float(ledger["bridge_count"]) / choice.spheres,
        "liquid_in_bridges": _share(ledger, "bridges"),
        "mean_speed_m_per_s": float(np.sqrt((end[["vx", "vy", "vz"]] ** 2).sum(axis=1)).mean()),
    }


def drum(run_dir: Path, choice: Choice) -> dict[str, float]:
    """Moist spheres in a drum that turns about the horizontal z axis: the bed's dynamic angle [deg].

    The angle is that of the line from the axis to the bed's centre of mass against gravity, which is the slope of a flat
    surface; mean and standard deviation over the second half of the run.
    """
    sphere, r = glass(choice, choice.spheres), choice.radius_m
    width = 8.0 * r
    radius = math.sqrt(choice.spheres * 4.0 / 3.0 * r**3 / (0.55 * 0.35 * width))
    walls = drum_walls(radius, width)
    bodies = _in_drum(choice, radius, width)
    step = time_step(choice, sphere, 2e3)
    steps = round((choice.seconds or 1.5) / step)
    turning = Rotation(origin_m=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0), period_s=60.0 / choice.turns_per_minute)
    _prepare(
        run_dir, choice, sphere, bodies, step, steps, walls=walls, gravity=(0.0, -9.81, 0.0), rotation=turning
    )  # fmt: skip
    small.run(run_dir, bodies, choice.ranks)
    centre = read_table(run_dir / "trajectory.parquet").groupby("step")[["x", "y"]].mean()
    angle = np.degrees(np.arctan2(centre["x"].to_numpy(), -centre["y"].to_numpy()))[len(centre) // 2 :]
    ledger = read_table(run_dir / "history" / "ledger.parquet").iloc[-1]
    return {
        "dynamic_angle_deg": float(angle.mean()),
        "dynamic_angle_deviation_deg": float(angle.std()),
        "drum_radius_m": radius,
        "bridges_per_sphere": 2.0 * float(ledger["bridge_count"]) / choice.spheres,
        "liquid_on_walls": _share(ledger, "walls"),
    }


SCENES: dict[str, Callable[[Path, Choice], dict[str, float]]] = {
    "pull": pull,
    "collision": collision,
    "bed": bed,
    "drum": drum,
}
"""Name of a scene -> the function that runs it."""


def run(name: str, run_dir: Path, choice: Choice | None = None) -> dict[str, float]:
    """Run a scene by name and leave its numbers in scene_result.json."""
    if name not in SCENES:
        raise PywetError(f"there is no scene named {name}; expected one of {', '.join(SCENES)}")
    found = SCENES[name](Path(run_dir), choice or Choice())
    write_json(Path(run_dir) / RESULT, {k: None if math.isnan(v) else v for k, v in found.items()})
    return found


def drum_walls(radius: float, width: float, sides: int = 32, thickness: float = 0.003) -> tuple[Surface, ...]:
    """Mantle and two lids of a drum about the z axis, turning."""
    low, high = -0.5 * width, 0.5 * width
    outline = polygon(radius + thickness, sides)
    return (
        make_surface("mantle", "wall", tube(radius, thickness, sides, low, high), "turns"),
        make_surface("lid_low", "wall", plate(outline, low - thickness, low), "turns"),
        make_surface("lid_high", "wall", plate(outline, high, high + thickness), "turns"),
    )


def _share(ledger: pd.Series, holder: str) -> float:
    """Part of the liquid that a holder has; 0 without liquid."""
    return float(ledger[holder] / ledger["initial"]) if ledger["initial"] > 0 else 0.0


def _lattice(choice: Choice, across: int, spacing: float, z_low: float) -> list[small.Sphere]:
    """Layers of across x across spheres, a little shaken."""
    random, r = np.random.default_rng(choice.seed), choice.radius_m
    cells = np.array([np.unravel_index(k, (10**6, across, across))[::-1] for k in range(choice.spheres)], dtype=float)
    at = (cells - [0.5 * (across - 1), 0.5 * (across - 1), 0.0]) * spacing * r
    at += random.uniform(-0.1, 0.1, at.shape) * r + [0.0, 0.0, z_low]
    return [small.Sphere(1, (float(x), float(y), float(z))) for x, y, z in at]


def _in_drum(choice: Choice, radius: float, width: float) -> list[small.Sphere]:
    """Spheres on a lattice inside the drum, from the bottom up."""
    random, pitch = np.random.default_rng(choice.seed), 2.15 * choice.radius_m
    n, layers = int(radius // pitch), int(width // pitch)
    grid = np.array([(i, j) for j in range(-n, n + 1) for i in range(-n, n + 1)], dtype=float) * pitch
    grid = grid[np.hypot(grid[:, 0], grid[:, 1]) < 0.98 * radius - 1.2 * choice.radius_m]
    z = (np.arange(layers) - 0.5 * (layers - 1)) * pitch
    at = np.array([(x, y, h) for x, y in grid for h in z])[: choice.spheres]
    if len(at) < choice.spheres:
        raise PywetError(
            f"{choice.spheres} spheres do not fit into their drum of {radius:g} m, only {len(at)}; expected {FIT_IN_DRUM} "
            "or more: mend spheres"
        )
    at += random.uniform(-0.05, 0.05, at.shape) * choice.radius_m
    return [small.Sphere(1, (float(x), float(y), float(h))) for x, y, h in at]


def _prepare(
    run_dir: Path,
    choice: Choice,
    sphere: SphereClass,
    bodies: list[small.Sphere],
    step: float,
    steps: int,
    *,
    walls: tuple[Surface, ...] = (),
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0),
    stiffness: float = 2e3,
    log_every_step: bool = False,
    rotation: Rotation | None = None,
) -> Scene:
    if steps < 1:
        raise PywetError(
            f"{choice.seconds or 0:g} s are less than half a time step of {step:g} s; expected more: raise --seconds"
        )
    reach = 1.1 * max([0.05, *(float(np.abs(w.corners).max()) for w in walls)])
    output = Output(
        interval_s=max(1, steps // 50) * step,
        contact_windows=1 if log_every_step else 2,
        contact_window_steps=2 * steps if log_every_step else 20,
        checkpoints=0 if steps < 5000 else 20,
    )
    return small.prepare(
        run_dir,
        [sphere],
        bodies,
        contacts(stiffness),
        liquid=liquid(choice, sphere),
        effects=small.PAPER,
        walls=walls,
        wall_angle_rad=math.radians(40.0),
        time_step_s=step,
        steps=steps,
        gravity=gravity,
        box=reach,
        output=output,
        rotation=rotation,
        viscous_integration=choice.viscous_integration,
    )
