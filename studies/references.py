"""Reference scenes whose digests are stored (tests/data/digests): small, each finished in seconds, over several seeds if random.

`pywet digest` reruns them and refuses if the replay disagrees.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from pywet import config, stages
from pywet.cases.screening import cases
from pywet.cases.small import scenes
from pywet.compare import digest
from pywet.compare.digest import Digest
from pywet.compare.quantities import facts
from pywet.errors import PywetError
from pywet.scene import EngineScene
from pywet.shipped import place
from pywet.util.files import read_table
from studies.subset import with_spheres

STORE = Path("tests/data/digests")
Numbers = dict[str, tuple[float, float, str]]
COUNTS = {1: 12, 2: 2, 3: 2}
"""Number of spheres of each class in the tiny screening."""
SHORTEST_S = 0.9


@dataclass(frozen=True)
class Reference:
    """A scene: the function that runs a seed of it, and the seeds of its digest."""

    command: str
    seeds: tuple[int, ...]
    run: Callable[[int, Path], Numbers]


def _replayed(run_dir: Path) -> Numbers:
    """Replay a run and return its numbers; raises if the replay disagrees."""
    replay = stages.replay(run_dir)
    if replay is not None and not replay["ok"]:
        bad = [name for name, q in replay["quantities"].items() if not q["ok"]]
        raise PywetError(f"the replay of {run_dir.name} disagrees on {', '.join(bad)}; no digest is made of such a run")
    return digest.numbers_in(run_dir)


def _scene(name: str, **chosen: float) -> Callable[[int, Path], Numbers]:
    """Return the function that runs a seed of a scene of `pywet scene` with some choices."""

    def run_seed(seed: int, folder: Path) -> Numbers:
        scenes.run(name, folder, scenes.Choice(**{**chosen, "seed": seed}))  # type: ignore[arg-type]
        return _replayed(folder)

    return run_seed


def screening(seed: int, folder: Path) -> Numbers:
    """Run case 2 at smoke scale with sixteen spheres, the first 0.9 s, from configuration to results."""
    loaded = config.load(place("config")).with_seed(10000 + seed)
    scene = cases.build(loaded, 2, "smoke", folder)
    spheres = read_table(folder / scene.spheres_file)
    first = spheres[spheres.groupby("type").cumcount() < spheres["type"].map(COUNTS)]
    output = scene.output.model_copy(update={"checkpoints": 0, "energy": True})
    with_spheres(scene, folder, first, duration_s=SHORTEST_S, output=output)
    stages.simulate(folder, ranks=1, progress=False)
    stages.results(folder)
    return _replayed(folder)


def wall(seed: int, folder: Path) -> Numbers:
    """Run a wet glass sphere against a wall by the model of Buck et al. 2018: coefficients and budget."""
    from pywet.collisions.wall import wall as module
    from studies.buck2018.curves import problem

    outcome = module.collide(problem("glass_1.74mm", ("water", 100), normal_velocity_m_per_s=1.0, angle_deg=30.0))
    return {k: (float(v), max(abs(float(v)), 1e-300), "") for k, v in outcome.items() if isinstance(v, int | float)}


def spheres(seed: int, folder: Path) -> Numbers:
    """Run three wet spheres by the model of Davis 2023: final velocities and energy."""
    from pywet.collisions.spheres.equal import three_equal_spheres
    from pywet.collisions.spheres.simulate import run

    made = run(three_equal_spheres(6.0, theta12_deg=30.0, t_end=4.0, h_a=0.01, h_min=0.05))
    numbers: Numbers = {}
    for k in range(3):
        for axis, value in zip("xy", made.velocity[k], strict=True):
            numbers[f"final velocity {k + 1} {axis}"] = (float(value), 1.0, "v_n0")
    for name in ("end", "viscous", "impact"):
        numbers[f"energy {name}"] = (float(getattr(made.energy, name)), float(made.energy.start), "")
    return numbers


SCENES: dict[str, Reference] = {
    "pull": Reference("pywet scene pull --seconds 0.02", (1,), _scene("pull", seconds=0.02)),
    "collision": Reference(
        "pywet scene collision --moisture 0.2 --seconds 0.0060522", (1,),
        _scene("collision", moisture_percent=0.2, seconds=0.0060522),
    ),
    "bed": Reference("pywet scene bed --spheres 40 --seconds 0.12 --seed N", tuple(range(1, 11)),
                     _scene("bed", spheres=40, seconds=0.12)),
    "screening": Reference("case 2, smoke scale, 16 spheres, 0.9 s", tuple(range(1, 9)), screening),
    "wall": Reference("pywet collide wall (glass 1.74 mm, 100 µm of water, 1 m/s, 30°)", (1,), wall),
    "spheres": Reference("pywet collide spheres (three equal, St 6, 30°)", (1,), spheres),
}  # fmt: skip
"""Name of a digest -> its scene. A scene with one seed is deterministic."""


def made(name: str) -> Digest:
    if name not in SCENES:
        raise PywetError(f"there is no reference scene {name}; expected one of {', '.join(SCENES)}")
    one, runs = SCENES[name], []
    for seed in one.seeds:
        with tempfile.TemporaryDirectory(prefix="pywet-digest-") as folder:
            runs.append(one.run(seed, Path(folder)))
            reported = Path(folder) / "scene.json"
            scene = facts(EngineScene.read(reported), reported.parent) if reported.exists() else None
    return digest.make(name, one.command, runs, scene)


def renew(name: str, folder: Path = STORE) -> Path:
    return digest.save(made(name), folder / f"{name}.json")
