"""What is done with a scene of one's own: read, plan, run, load, replay, view. These are the functions of `import pywet`."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

from pywet import run_lock, stages
from pywet.config.loading import placed_laws, read_yaml
from pywet.errors import PywetError
from pywet.files import read_bytes
from pywet.own_scene import building, results
from pywet.own_scene.description import Scene
from pywet.planning import EffectPlan
from pywet.runs import second
from pywet.runs.loaded import Run
from pywet.screening import identity, verdict


def read_scene(file: Path | str) -> Scene:
    """The scene of a YAML file, checked; STL files and laws in files are looked for in its folder."""
    path = Path(file)
    given = read_yaml(path, Scene)
    return Scene(**{**given, "folder": path.parent, "file": path})


def plan(scene: Scene) -> EffectPlan:
    """Which effects a scene calls for, and why: `for line in pywet.plan(scene).lines: print(line)`."""
    return building.Building(scene).plan


def run(scene: Scene, folder: Path | str, ranks: int = 1, progress: bool = False) -> Run:
    """Build, simulate, evaluate and replay a scene in a folder; a finished run of the same scene there is not simulated again.

    Raises `PywetError` where the engine stops, or where a check, the liquid's ledger or the replay disagrees: then all results
    are written all the same, and `load` reads them.
    """
    objections = finish(scene, folder, ranks, progress)
    if objections:
        raise PywetError("; ".join(objections))
    return load(folder)


def finish(scene: Scene, folder: Path | str, ranks: int = 1, progress: bool = False) -> list[str]:
    """Do the same, and return the objections: one sentence for every check that failed."""
    if not str(folder):
        raise PywetError("the folder of the run is empty; expected the path of a run directory")
    where, word = Path(folder), _fingerprint(scene)
    with identity.held(where, word):
        identity.leave(where, word)
        building.write(scene, where)
        second.leave(where, placed_laws(scene.laws, scene.folder, scene.file is None).reference)
        stages.simulate(where, ranks, progress)
        results.write(where)
        try:
            stages.replay(where)
        except PywetError as unreadable:
            return [str(unreadable), *verdict.objections(where)]
        return verdict.objections(where)


def _fingerprint(scene: Scene) -> str:
    """What a run of this scene follows from: its description, the files that it names, the program's code."""
    named = placed_laws(scene.laws, scene.folder, scene.file is None).model_dump().values()
    laws = [law for law in named if isinstance(law, str)]
    files = [Path(law.rpartition(":")[0]) for law in laws if ".py:" in law]
    files += [scene.folder / wall.stl for wall in scene.walls if wall.stl]
    files += [scene.folder / feed.psd.file for feed in scene.feed if feed.psd.file]
    texts = [hashlib.sha256(read_bytes(file, "mend its path in the scene")).hexdigest() for file in files]
    return identity.of(scene.model_dump(mode="json", exclude={"folder", "file"}), texts)


def load(folder: Path | str) -> Run:
    """A finished run as tables with units."""
    return Run(Path(folder))


def replay(folder: Path | str) -> dict[str, Any] | None:
    """Recompute a run by the independent reference: what it compared, how far it is off; None where nothing can be replayed."""
    with run_lock.hold(Path(folder), shared=True):
        return stages.replay(Path(folder))


def view(folder: Path | str, step: int | None = None) -> Path:
    """Write a run's time series for ParaView into `vtk/` and a picture, `picture.png`, of an output step; returns the picture.

    Of a scene of one's own also the page `report.html`.
    """
    from pywet.own_scene import page
    from pywet.report import render

    stages.vtk(Path(folder))
    picture = Path(folder) / "picture.png"
    render.write(Path(folder), picture, step)
    if (Path(folder) / "description.json").exists():
        page.write(Path(folder), picture)
    return picture
