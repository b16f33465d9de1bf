"""One run of the accuracy study: prepared, timed, measured; its run directory is removed."""

from __future__ import annotations

import os
import platform
import re
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pywet.bench import small
from pywet.engines.liggghts import driver
from pywet.errors import PywetError
from pywet.evidence.accuracy import bodies, sieve
from pywet.evidence.accuracy.knobs import Setting, reference
from pywet.evidence.accuracy.sieve import SCREENING
from pywet.evidence.study import Row
from pywet.files import read_table
from pywet.scene import Scene


def rows_of(
    scene: str, seed: int, knob: str, setting: Setting, size: str, config_dir: Path, vary: sieve.Vary = lambda same: same
) -> list[Row]:  # fmt: skip
    """Do a run: a row, of colliding pairs one for each; of one that the engine refuses or that fails the reason, in `failed`.

    `vary` changes what a screening scene is made from.
    """
    if scene == "laws":
        errors = {} if knob == "transfer_nodes" else bodies.law_errors(setting)
        if knob in ("default", "transfer_nodes"):
            errors |= bodies.sharing_error(setting, int(reference("transfer_nodes", size)))
        return [{**errors, "failed": None}]
    with tempfile.TemporaryDirectory(prefix="pywet-study-") as name:
        folder = Path(name)
        begin: Callable[[], driver.RunInfo]
        try:
            if scene in SCREENING:
                sieve.prepare(folder, scene, setting, sieve.SIZES[size], seed, config_dir, vary)
                begin = lambda: driver.run(folder, setting.ranks, progress=False)  # noqa: E731
            else:
                spheres = bodies.prepare(scene, folder, setting, seed)
                begin = lambda: small.run(folder, spheres, setting.ranks)  # noqa: E731
            took = {**timed(folder, begin), "failed": None}
            measured = [sieve.quantities(folder)] if scene in SCREENING else bodies.quantities(scene, folder)
        except PywetError as error:
            return [{"failed": str(error).replace(name, "RUN_DIR")}]
    return [{**row, **took} for row in measured]


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
        "bridges": count,
        "builds": builds,
    }


def machine() -> dict[str, Any]:
    """What the times were measured on."""
    model = ""
    info = Path("/proc/cpuinfo")
    if info.exists():
        names = re.findall(r"^model name\s*:\s*(.+)$", info.read_text(), flags=re.MULTILINE)
        model = names[0] if names else ""
    return {"processor": model or platform.processor() or platform.machine(), "cores": os.cpu_count()}
