"""Run one task with the plugin in this process: YADE's modules, plugin, compiled laws. Started by driver.py.

YADE's packages are Debian's and come last in the search path, so that none replaces a package of this program.
"""

from __future__ import annotations

import ctypes as C
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from pywet.engines import schedule
from pywet.engines.liggghts.plugin_api import Plugin
from pywet.engines.liggghts.worker import attach_once
from pywet.engines.process import worker_border
from pywet.engines.yade import build
from pywet.errors import EngineError
from pywet.runs.rundir import RunDir
from pywet.scene import EngineScene
from pywet.util.files import read_json

HOOK = "pywet_step()"
"""Python command that YADE calls in every step."""


class Host:
    """The plugin's host, which accesses the memory of YADE's objects."""

    def __init__(
        self, scene: EngineScene, task: dict[str, Any], spheres: list[int], walls: dict[str, list[int]]
    ) -> None:
        from yade import O  # type: ignore[import-not-found]

        from pywet.engines.yade import memory

        rows = np.array(task["spheres"])
        kind = rows[:, 1].astype(np.int32)
        classes = scene.classes
        moving = {name for name in walls if name in {*task["vibrates"], *task["turns"], *task["slides"]}}
        states = [memory.address(O.bodies[walls[w.name][0]].state) if w.name in moving else 0 for w in scene.walls]
        recorded = np.zeros(scene.steps + 1, np.int8)
        for first, last in schedule.recorded(scene):
            recorded[first:last] = 1
        self._keep: dict[str, np.ndarray] = {
            "state": np.array([memory.address(O.bodies[i].state) for i in spheres], np.uint64),
            "tag": rows[:, 0].astype(np.int32),
            "kind": kind,
            "wall_state": np.array(states, np.uint64),
            "wall_turns": np.array([w.name in task["turns"] for w in scene.walls], np.int32),
            "driven": np.isin(rows[:, 0], task["driven"]).astype(np.int32),
            "mass": np.array([classes[k - 1].mass_kg for k in kind]),
            "radius": np.array([classes[k - 1].radius_m for k in kind]),
            "rolling": rolling(scene),
            "recorded": recorded,
            "low": np.array(scene.box_low_m),
            "high": np.array(scene.box_high_m),
            "gravity": np.array(scene.gravity_m_per_s2, float),
        }
        given = memory.Given(
            len(spheres), len(walls), len(O.bodies), len(classes), scene.output_every,
            **{name: array.ctypes.data for name, array in self._keep.items()},
            scene=memory.address(O.forces), interactions=memory.address(O.interactions),
            dt=scene.time_step_s, skin=2.0 * task["skin"], thickest_film=task["reach"] - 1.0,
            at=memory.Layout(*memory.LAYOUT.values()),
        )  # fmt: skip
        if not scene.effects.rolling:
            given.rolling = None
        self._library = C.CDLL(str(build.plugin_path()), mode=C.RTLD_GLOBAL)
        self._library.pywet_yade_open.restype = C.c_void_p
        self.handle = C.c_void_p(self._library.pywet_yade_open(C.byref(given)))

    def step(self, number: int, is_sorted: bool) -> None:
        """Call the plugin between contacts and integration."""
        self._library.pywet_yade_step(self.handle, C.c_int64(number), is_sorted)

    def close(self) -> None:
        """Close the library's handle after the last step."""
        self._library.pywet_yade_close(self.handle)


def rolling(scene: EngineScene) -> np.ndarray:
    """Return the torque of rolling resistance over the overlap [N], for each type and each partner; 0: a wall."""
    table = np.zeros((len(scene.classes) + 1,) * 2)
    for p in scene.pairs:
        table[p.a, p.b] = table[p.b, p.a] = p.rolling_friction_m * p.normal_stiffness_N_per_m
    return table


def as_yade_has_it(scene: EngineScene) -> EngineScene:
    """Return the scene with all contacts computed by YADE."""
    walls = tuple(wall.model_copy(update=dict(analytic_wires=False)) for wall in scene.walls)
    return scene.model_copy(update={"walls": walls, "contacts": "stock"})


def reach_yade() -> None:
    """Make YADE's modules importable; `EngineError` if this Python cannot load them."""
    sys.path += build.PACKAGES
    try:
        import yade  # noqa: F401
    except ImportError as error:
        version = ".".join(map(str, sys.version_info[:2]))
        raise EngineError(
            f"YADE's modules cannot be imported into Python {version} ({error}); expected Python 3.11, for which Debian 12 has "
            "built them: run `make setup` with it",
            code="yade.python",
        ) from error


def run(run_dir: Path, folder: Path, contacts: Callable[[dict[str, Any]], Any] | None = None) -> None:
    """Read the scene, set YADE up, attach the plugin, run; `contacts`: of the bodies, in place of `in_yade.contacts`."""
    scene, task = RunDir(run_dir).scene, read_json(folder / "task.json")
    plain = as_yade_has_it(scene)
    reach_yade()
    from yade import O, Vector3

    from pywet.engines.yade import in_yade, memory

    memory.check()
    spheres, walls, collider = in_yade.build(task, HOOK, (contacts or in_yade.contacts)(task))
    host = Host(scene, task, spheres, walls)
    plugin = Plugin(build.plugin_path(), build.engine_version())
    attach_once(plugin, host.handle, plain, run_dir, folder)
    sorts = -1

    def hook() -> None:
        nonlocal sorts
        host.step(O.iter, collider.numAction != sorts)
        sorts = collider.numAction
        for name, window in task["drawn"].items():  # a step's contacts have the speed of the way to it
            for body in walls[name] if O.iter in window else ():
                O.bodies[body].state.vel = Vector3(*(task["slides"][name] if O.iter == window[0] else (0, 0, 0)))

    vars(sys.modules["__main__"])[HOOK.removesuffix("()")] = hook
    marks = max(1, scene.steps // 200)
    for step in range(scene.steps + 1):
        O.step()
        if step % marks == 0:
            print(step, len(spheres), "- -", flush=True)
    host.close()
    plugin.finish()


def main() -> int:
    """Run a task as `python -m pywet.engines.yade.worker RUN_DIR ENGINE_FOLDER`, in that folder."""
    return worker_border(run)


if __name__ == "__main__":
    sys.exit(main())
