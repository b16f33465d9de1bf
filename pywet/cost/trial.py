"""Measure the cost of a step on this machine: short runs of spheres on a lattice with a negligible time step.

In a time step of 1e-10 s nothing moves, so that counts are known and constant: spheres that touch or do not, in the
feed bin or on the wires, dry or with bridges, with a constant neighbour list or one rebuilt in every tenth step.
Differences of runs give the cost of each operation, for few spheres and for too many for the processor's cache.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from pywet.cases.screening import cases
from pywet.config import Config
from pywet.cost.edit import Level, entries, with_entries
from pywet.cost.timing import timed
from pywet.engines.liggghts import driver
from pywet.engines.liggghts.contact_model import attached
from pywet.engines.liggghts.deck import skin
from pywet.engines.liggghts.process import LOOP_TIME
from pywet.geometry import Surface, build_apparatus
from pywet.geometry.initial import write_initial
from pywet.scene import EngineScene, Output
from pywet.util.files import read_json, write_json

SIZES = ((1, 50.0), (7, 180.0))
"""Dry case, followed by its moist counterpart, and sieve [mm]: 335 and 17,416 spheres."""
FROZEN = 1e-10
"""Time step [s] in which nothing moves."""
WORK = 2e6
"""Spheres times steps of a timed run; a third of it if lists are rebuilt."""
FIRST = 20
"""Number of steps before the timed ones; bridges form in them."""
EVERY = 10
"""Number of steps between rebuilt lists."""
LOOSE = 0.01
"""Gap in radii between spheres whose films touch in the moist cases."""
JITTER = 1e-4
"""Random displacement, in radii, in a lattice without gap: half of the pairs touch, unpredictably for the processor."""
REPEATS = 3
"""Number of repeats of a run of the stock program."""
SPEED = 0.1
"""Speed [m/s] of the spheres, and of their surfaces by their spins."""
COLUMNS = ("x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz")
SEED = 10007
"""Seed of the engine, a prime above 10000."""
SCALE = "trial"
"""Name of the scale made for the runs."""
SETTINGS: dict[str, Level] = {
    "fraction": 0.05, "stiffness": 0.01, "wire_sides": 6, "capillary": "rabinovich", "integration": "explicit",
    "bridges_every": 1,
}  # fmt: skip
"""Settings of the runs, whatever the configuration's: costs of other laws and integrations are factors (`cost.Habit`)."""
LATTICES = 9
"""Number of lattices with one number of spheres."""


@dataclass(frozen=True)
class Costs:
    """Time per operation [s] for one number of spheres; dry steps for the stock program (mesh wires) and for the plugin."""

    spheres: float
    step: float
    """Cost of a dry step of all spheres, without contact and away from wires."""
    step_stock: float
    """Cost of the same with the stock program, in which the wires' mesh moves with this number of triangles."""
    triangles: float
    touch: float
    """Cost of a step per touching pair; the floor's contacts are included in those of the pairs."""
    triangle: float
    """Cost of a step per triangle of the wires' mesh."""
    mesh: float
    """Cost of a step per sphere near a mesh wire."""
    analytic: float
    """Cost of a step per sphere near an analytic wire."""
    bridge: float
    """Cost of a step per bridge, including all other extra work of moist steps."""
    list_stock: float
    """Cost of a neighbour list."""
    list_analytic: float
    list_moist: float
    start_stock: float
    """Time before the first step of a run."""
    start_analytic: float
    start_moist: float


@dataclass(frozen=True)
class Lattice:
    """Trial run: the case's wires as meshes or analytic wires, with spheres on them or in the feed bin."""

    case: int
    screen: bool = False
    analytic_wires: bool = True
    pressed: bool = False
    lists: bool = False


@dataclass(frozen=True)
class Timed:
    """Measured time per step and before the first step [s], with the operation counts of the lattice."""

    step: float
    start: float
    spheres: int
    pairs: int
    near: int
    triangles: int
    bridges: float


def measure(config: Config, case: int, width_mm: float, report: Callable[[], None]) -> Costs:
    """Measure nine lattices with one number of spheres."""

    def of(which: Lattice) -> Timed:
        return _timed(config, width_mm, which, report)

    on_wires = {
        "stock": Lattice(case, screen=True, analytic_wires=False),
        "analytic": Lattice(case, screen=True),
        "moist": Lattice(case + 1, screen=True),
    }
    near = {kind: of(which) for kind, which in on_wires.items()}
    rebuilt = {kind: of(replace(which, lists=True)) for kind, which in on_wires.items()}
    loose, pressed = of(Lattice(case)), of(Lattice(case, pressed=True))
    mesh = of(Lattice(case, analytic_wires=False))
    lists = {f"list_{kind}": max(0.0, EVERY * (rebuilt[kind].step - near[kind].step)) for kind in on_wires}
    return Costs(
        spheres=loose.spheres,
        step=loose.step,
        step_stock=mesh.step,
        triangles=mesh.triangles,
        touch=max(0.0, pressed.step - loose.step) / pressed.pairs,
        triangle=max(0.0, mesh.step - loose.step) / mesh.triangles,
        mesh=max(0.0, near["stock"].step - mesh.step) / near["stock"].near,
        analytic=max(0.0, near["analytic"].step - loose.step) / near["analytic"].near,
        bridge=max(0.0, near["moist"].step - near["analytic"].step) / max(1.0, near["moist"].bridges),
        **lists,
        **{f"start_{kind}": of_kind.start for kind, of_kind in near.items()},
    )


def _timed(config: Config, width_mm: float, which: Lattice, report: Callable[[], None]) -> Timed:
    """Return the smaller time of two parts of a run, or of its repeats, because other load on the machine only adds to it."""
    with tempfile.TemporaryDirectory(prefix="pywet-trial-") as name:
        folder = Path(name)
        scene, spheres, near = _prepare(folder, config, width_mm, which)
        steps = max(2 * EVERY, round(WORK / (3.0 if which.lists else 1.0) / len(spheres)))
        if attached(scene):
            run = _run(folder, scene, (FIRST, steps, steps), which)
            spent = [piece["run_s"] for piece in read_json(folder / "engine" / LOOP_TIME)]
            step, start = min(spent[1:]) / steps, run["cpu_s"] - sum(spent)
        else:
            short, long = (
                min(_run(folder, scene, (n,), which)["cpu_s"] for _ in range(REPEATS))
                for n in (FIRST, FIRST + 3 * steps)
            )
            run, step, start = {"bridges": 0.0}, (long - short) / (3 * steps), short
        report()
        return Timed(
            step=step,
            start=start,
            spheres=len(spheres),
            pairs=len(cKDTree(spheres[["x", "y", "z"]]).query_pairs(2.0 * min(c.radius_m for c in scene.classes))),
            near=near,
            triangles=sum(len(w.triangle_part) for w in scene.walls if w.reservoir == "wires"),
            bridges=run["bridges"],
        )


def _run(folder: Path, scene: EngineScene, steps: Sequence[int], which: Lattice) -> dict[str, Any]:
    """Run a number of steps in each stage: before, during and after the opening of the slide."""
    output = Output(interval_s=sum(steps) * FROZEN, contact_windows=0, checkpoints=0)
    opens, travel = (FROZEN * n for n in (*steps, 1)[:2])
    slide = scene.slide.model_copy(update={"opens_at_s": opens, "travel_s": travel}) if scene.slide else None
    scene = scene.model_copy(update={"duration_s": sum(steps) * FROZEN, "output": output, "slide": slide})
    write_json(folder / "scene.json", scene.model_dump(mode="json"))
    extra = (f"neigh_modify every {EVERY} check no",) if which.lists else ()
    return timed(folder, lambda: driver.run(folder, progress=False, extra=extra))


def _prepare(folder: Path, config: Config, width_mm: float, which: Lattice) -> tuple[EngineScene, pd.DataFrame, int]:
    """Write the run directory; return its scene, its spheres, and the number of near pairs of a sphere and a wire."""
    size = {
        f"scales.yaml: scales {SCALE}": config.scale("smoke"),
        f"scales.yaml: scales {SCALE} width_mm value": width_mm,
    }
    made = with_entries(config, {"config.yaml: seed": SEED, **size, **entries(SCALE, SETTINGS)}).without_retirement()
    case, scale = made.case(which.case), made.scale(SCALE)
    apparatus = build_apparatus(cases.apparatus_spec(made, case, scale))
    scene = cases.assemble(made, case, scale, cases.ingredients(made, case.case, SCALE), apparatus)
    walls = tuple(
        w.model_copy(update={"analytic_wires": which.analytic_wires and w.reservoir == "wires"}) for w in scene.walls
    )
    scene = scene.model_copy(update={"walls": walls, "time_step_s": FROZEN})
    wires = next(s for s in apparatus.surfaces if s.reservoir == "wires")
    low = float(wires.corners[..., 2].max()) if which.screen else apparatus.feed_region.z_low_m
    spheres = _lattice(scene, apparatus.feed_region.width_m, low, 0.0 if which.pressed else LOOSE)
    write_initial(scene, apparatus.surfaces, spheres, folder)
    reach = 0.5e-3 * config.materials.screen(case.aperture_mm).wire_diameter_mm.value + 1.5 * skin(scene)
    return scene, spheres, _near(wires, spheres, reach + min(c.radius_m for c in scene.classes))


def _lattice(scene: EngineScene, width: float, low: float, gap: float) -> pd.DataFrame:
    """Place the scene's number of spheres, all of its smallest class, a `gap` of radii apart in random order.

    They have speeds and spins, so that friction and rolling resistance act. One at the top is so fast that it has
    moved by almost half a skin at the end, which sets the range in which the plugin checks pairs.
    """
    smallest = min(scene.classes, key=lambda c: c.radius_m)
    count, spacing = sum(c.count for c in scene.classes), (2.0 + gap) * smallest.radius_m
    side = int((width - 2.0 * smallest.radius_m) / spacing) + 1
    random = np.random.default_rng(1)
    k = random.permutation(count)
    place = np.stack([k % side - 0.5 * (side - 1), k // side % side - 0.5 * (side - 1), k // side**2], axis=1)
    if gap == 0.0:
        place += 0.5 * JITTER * random.normal(size=place.shape)
    xyz = spacing * place + np.array([0.0, 0.0, low + (1.0 + gap) * smallest.radius_m])
    motion = random.normal(0.0, SPEED, (count, 6)) / np.repeat([1.0, smallest.radius_m], 3)
    motion[np.argmax(xyz[:, 2])] = 0.0, 0.0, 0.4 * skin(scene) / (2.0 * WORK / count * FROZEN), 0.0, 0.0, 0.0
    columns = dict(zip(COLUMNS, np.hstack([xyz, motion]).T, strict=True))
    return pd.DataFrame({"id": np.arange(1, count + 1), "type": smallest.type, **columns})


def _near(wires: Surface, spheres: pd.DataFrame, reach: float) -> int:
    """Return the number of pairs of a sphere and a wire whose axis is nearer than `reach`."""
    near, x = 0, spheres[["x", "y", "z"]].to_numpy()
    for part in range(len(wires.part_half_width)):
        points = wires.corners[wires.part == part].reshape(-1, 3)
        low, high = points.min(axis=0), points.max(axis=0)
        across = np.delete(x - 0.5 * (low + high), np.argmax(high - low), axis=1)
        near += int((np.hypot(*across.T) < reach).sum())
    return near
