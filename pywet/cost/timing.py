"""Measured run time of an engine run, and the machine on which it was measured."""

from __future__ import annotations

import os
import platform
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pywet.engines.pipeline import RunInfo
from pywet.runs.rundir import RunDir
from pywet.util.files import read_table


def timed(folder: Path, begin: Callable[[], RunInfo]) -> dict[str, Any]:
    """Run and measure: total wall and processor time, those of the engine's time loop [s], and the operations of the loop."""
    info = begin()
    log = (folder / "engine" / "log.liggghts").read_text(errors="replace")
    loop = sum(float(t) for t in re.findall(r"^Loop time of (\S+)", log, flags=re.MULTILINE))
    builds = sum(int(n) for n in re.findall(r"^Neighbor list builds = (\d+)", log, flags=re.MULTILINE))
    scene = RunDir(folder).scene
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
    """Describe the machine on which the times were measured."""
    model = ""
    info = Path("/proc/cpuinfo")
    if info.exists():
        names = re.findall(r"^model name\s*:\s*(.+)$", info.read_text(), flags=re.MULTILINE)
        model = names[0] if names else ""
    return {"processor": model or platform.processor() or platform.machine(), "cores": os.cpu_count()}
