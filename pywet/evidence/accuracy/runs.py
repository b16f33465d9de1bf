"""The runs of the study: which there are, in which order, how one is done and kept. What is there is not done again.

A round is a scene with one seed: all its settings in turn, the default first and last, so that whatever else the machine does
meets all of them. Each run leaves one small JSON file; its run directory is removed.
"""

from __future__ import annotations

import os
import platform
import re
import shutil
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NotRequired

from typing_extensions import TypedDict

from pywet.bench import small
from pywet.engines.liggghts import driver
from pywet.errors import PywetError
from pywet.evidence.accuracy import bodies, knobs, sieve
from pywet.evidence.accuracy.knobs import Level, Setting
from pywet.files import read_json, read_table, write_json
from pywet.scene import Scene

SEEDS = (10007, 10009, 10037, 10039, 10061, 10067)
"""Seeds of the engine are primes above 10000."""
SCREENING = ("dry", "moist")
KNOBS_OF: dict[str, tuple[str, ...]] = {
    "dry": ("fraction", "stiffness", "wire_sides", "ranks"),
    "moist": tuple(knobs.KNOBS),
    "bed": ("fraction", "stiffness", "capillary", "integration", "bridges_every", "transfer_nodes"),
    "pair_dry": ("fraction", "stiffness"),
    "pair_wet": ("fraction", "stiffness", "capillary", "integration", "bridges_every"),
    "pull": ("fraction", "capillary", "integration", "bridges_every"),
    "laws": ("capillary", "transfer_nodes"),
}
"""Scene -> the knobs that are turned in it."""
ONCE = ("pair_dry", "pair_wet", "pull", "laws")
"""Scenes without chance: one round."""
Report = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Run:
    """One run: a scene, a seed, and the default setting with one knob turned; `knob` is `default` or `again` for itself."""

    scene: str
    seed: int
    knob: str
    level: Level | None
    setting: Setting

    @property
    def name(self) -> str:
        """Name of its file, without folder."""
        return f"{self.scene}-{self.seed}-{self.knob}" + ("" if self.level is None else f"-{self.level}")

    def file(self, folder: Path, size: str) -> Path:
        """Where the study in this folder keeps it."""
        return folder / "runs" / size / f"{self.name}.json"


def rounds(size: str) -> list[tuple[str, int]]:
    """Scene and seed of every round, in the order they are done: rounds of one scene are not neighbours."""
    shape = sieve.size_named(size)
    seeds = {"bed": shape.seeds, "moist": shape.seeds, "dry": shape.dry_seeds or shape.seeds}
    small_scenes = [(scene, SEEDS[0]) for scene in ONCE]
    return small_scenes + [(s, seed) for k, seed in enumerate(SEEDS) for s in ("bed", *SCREENING) if k < seeds[s]]


def design(scene: str, seed: int, size: str) -> list[Run]:
    """The runs of a round: default, every level of every knob but the default's (from another start each seed), default."""
    base = knobs.default(size)
    turned = [
        Run(scene, seed, knob, level, base.but(knob, level))
        for knob in KNOBS_OF[scene]
        for level in knobs.KNOBS[knob].levels(size)
        if level != getattr(base, knob)
    ]
    shift = SEEDS.index(seed) * len(turned) // len(SEEDS)
    ends = [Run(scene, seed, "default", None, base)]
    again = [Run(scene, seed, "again", None, base)] if scene in SCREENING else []
    return [*ends, *turned[shift:], *turned[:shift], *again]


def do_round(folder: Path, scene: str, seed: int, size: str, config_dir: Path, report: Report) -> list[Path]:
    """Do what is missing of a round; returns its files."""
    made = []
    wanted, key = design(scene, seed, size), _key(scene, size, config_dir)
    for k, run in enumerate(wanted):
        path = run.file(folder, size)
        report(run.name, k, len(wanted))
        if not _there(path, run, size, key):
            write_json(path, {**do(run, size, config_dir), "config": key})
        made.append(path)
    return made


def missing(folder: Path, scene: str, seed: int, size: str, config_dir: Path) -> list[Run]:
    """Runs of a round that are not kept yet."""
    key = _key(scene, size, config_dir)
    return [r for r in design(scene, seed, size) if not _there(r.file(folder, size), r, size, key)]


def _key(scene: str, size: str, config_dir: Path) -> str:
    """What a scene's kept runs must have been made with; only screening reads the configuration."""
    return sieve.key(config_dir, sieve.size_named(size)) if scene in SCREENING else ""


class Kept(TypedDict):
    """What is kept of a run, as far as every reader needs it."""

    scene: str
    seed: int
    knob: str
    level: Any
    size: str
    config: str
    setting: dict[str, Any]
    failed: str | None
    quantities: NotRequired[dict[str, float | None]]
    curve: NotRequired[dict[str, Any] | list[Any]]
    samples: NotRequired[dict[str, list[float]]]


def _there(path: Path, run: Run, size: str, key: str) -> bool:
    """Whether a file holds this run; one of other settings, or of another configuration, is done again."""
    try:
        kept = read_json(path, shape=Kept)
    except PywetError:
        return False
    return bool((kept["setting"], kept["size"], kept["config"]) == (run.setting.as_dict(), size, key))


def do(run: Run, size: str, config_dir: Path) -> dict[str, Any]:
    """Do one run; a setting that the engine refuses or that fails leaves its reason."""
    kept: dict[str, Any] = {
        "scene": run.scene,
        "seed": run.seed,
        "knob": run.knob,
        "level": run.level,
        "size": size,
        "setting": run.setting.as_dict(),
        "failed": None,
    }
    with tempfile.TemporaryDirectory(prefix="pywet-study-") as name:
        try:
            kept |= _measure(run, size, Path(name), config_dir)
        except PywetError as error:
            kept["failed"] = str(error).replace(name, "RUN_DIR")
    return kept


def _measure(run: Run, size: str, folder: Path, config_dir: Path) -> dict[str, Any]:
    if run.scene == "laws":
        return {"quantities": _without_engine(run, size)}
    begin: Callable[[], driver.RunInfo]
    if run.scene in SCREENING:
        sieve.prepare(folder, run.scene, run.setting, sieve.SIZES[size], run.seed, config_dir)
        begin = lambda: driver.run(folder, run.setting.ranks, progress=False)  # noqa: E731
    else:
        spheres = _prepare_bodies(run, folder)
        begin = lambda: small.run(folder, spheres, run.setting.ranks)  # noqa: E731
    found = timed(folder, begin)
    return {**found, **_quantities(run.scene, folder)}


def _without_engine(run: Run, size: str) -> dict[str, float]:
    found = {} if run.knob == "transfer_nodes" else bodies.law_errors(run.setting)
    if run.knob in ("default", "transfer_nodes"):
        found |= bodies.sharing_error(run.setting, int(knobs.reference("transfer_nodes", size)))
    return found


def _prepare_bodies(run: Run, folder: Path) -> list[small.Sphere]:
    if run.scene == "bed":
        return bodies.prepare_bed(folder, run.setting, run.seed)
    if run.scene == "pull":
        return bodies.prepare_pull(folder, run.setting)
    return bodies.prepare_pairs(folder, run.scene == "pair_wet", run.setting)


def _quantities(scene: str, folder: Path) -> dict[str, Any]:
    if scene in SCREENING:
        return {"quantities": sieve.quantities(folder), "curve": sieve.curve(folder)}
    if scene == "bed":
        return {"quantities": bodies.settled(folder)}
    if scene == "pull":
        return {"quantities": bodies.pulled(folder)}
    return {"samples": {"restitution": bodies.restitutions(folder)}, "quantities": {}}


def timed(folder: Path, begin: Callable[[], driver.RunInfo]) -> dict[str, Any]:
    """Run and measure: wall and processor time in all and in the engine's time loop [s], and what the loop did."""
    info = begin()
    log = (folder / "engine" / "log.liggghts").read_text(errors="replace")
    loop = sum(float(t) for t in re.findall(r"^Loop time of (\S+)", log, flags=re.MULTILINE))
    builds = sum(int(n) for n in re.findall(r"^Neighbor list builds = (\d+)", log, flags=re.MULTILINE))
    scene = Scene.read(folder / "scene.json")
    count = 0.0
    if scene.effects.bridges:
        count = float(read_table(folder / "history" / "ledger.parquet")["bridge_count"].mean())
    return {
        "wall_s": info.wall_s,
        "cpu_s": info.cpu_s,
        "loop_wall_s": loop,
        "loop_cpu_s": info.cpu_s if info.loop_cpu_s is None else info.loop_cpu_s,
        "steps": info.steps,
        "spheres": info.spheres,
        "triangles": sum(len(w.triangle_part) for w in scene.walls),
        "bridges": count,
        "builds": builds,
        "time_step_s": scene.time_step_s,
    }


def load(folder: Path, size: str, config_dir: Path) -> Iterator[dict[str, Any]]:
    """All kept runs of a size that belong to its design and to the configuration."""
    keys = {scene: _key(scene, size, config_dir) for scene in KNOBS_OF}
    for scene, seed in rounds(size):
        for run in design(scene, seed, size):
            path = run.file(folder, size)
            if _there(path, run, size, keys[scene]):
                yield read_json(path)


def forget(folder: Path, size: str) -> None:
    """Remove the kept runs of a size."""
    sieve.size_named(size)
    shutil.rmtree(folder / "runs" / size, ignore_errors=True)


def machine() -> dict[str, Any]:
    """What the times were measured on."""
    model = ""
    info = Path("/proc/cpuinfo")
    if info.exists():
        names = re.findall(r"^model name\s*:\s*(.+)$", info.read_text(), flags=re.MULTILINE)
        model = names[0] if names else ""
    return {"processor": model or platform.processor() or platform.machine(), "cores": os.cpu_count()}
