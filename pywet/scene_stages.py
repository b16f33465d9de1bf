"""Stages of a user-defined scene: read, plan, run, load, replay, view; the functions of `import pywet`."""

from __future__ import annotations

import hashlib
from functools import partial
from pathlib import Path
from typing import Any

from pywet import run_folder, stages
from pywet.cases.custom import building, results
from pywet.cases.custom.description import Scene
from pywet.cases.screening import identity, verdict
from pywet.config.loading import begun, placed_laws, read_yaml
from pywet.errors import PywetError
from pywet.laws import custom_laws
from pywet.planning.effect_plan import EffectPlan
from pywet.products import until
from pywet.runs import record
from pywet.runs.loaded import Run
from pywet.runs.rundir import RunDir
from pywet.util.files import read_bytes


def read_scene(file: Path | str) -> Scene:
    """Read a scene from a YAML file and check it.

    Parameters
    ----------
    file : Path or str
        The YAML file; STL files and laws are found relative to its folder.

    Returns
    -------
    Scene
        The checked scene.

    Raises
    ------
    ConfigError
        With one line for each key that is unknown, missing or out of range.
    """
    path = Path(file)
    given = read_yaml(path, Scene, begun("drum"))
    return Scene(**{**given, "folder": path.parent, "file": path})


def plan(scene: Scene | Path | str) -> EffectPlan:
    """Decide which effects a scene calls for; a scene that `run` refuses is refused here too.

    Parameters
    ----------
    scene : Scene, Path or str
        The scene, or its YAML file.

    Returns
    -------
    EffectPlan
        Effects, their numbers and reasons; `lines` holds one line of text per effect.

    Notes
    -----
    The numbers are estimates for equal spheres at one typical speed (docs/effects.md).
    """
    made = building.Building(scene if isinstance(scene, Scene) else read_scene(scene))
    made.scene()  # including its checks
    return made.plan


def run(scene: Scene, folder: Path | str, ranks: int = 1, progress: bool = False) -> Run:
    """Build, simulate, evaluate and replay a scene in a folder.

    Parameters
    ----------
    scene : Scene
        The scene.
    folder : Path or str
        Run directory. A finished run of the same scene there is not simulated again; an interrupted one resumes.
    ranks : int
        Number of MPI ranks.
    progress : bool
        Print progress messages.

    Returns
    -------
    Run
        Tables of the run with units.

    Raises
    ------
    PywetError
        If the engine stops, or if a check, the liquid ledger or the replay disagrees; all results are written in
        this case too, and `load` reads them.
    """
    objections = finish(scene, folder, ranks, progress)
    if objections:
        raise PywetError("; ".join(objections), code="scene.objections", given=tuple(objections))
    return load(folder)


def finish(scene: Scene, folder: Path | str, ranks: int = 1, progress: bool = False) -> list[str]:
    """Run a scene like `run`, but return one sentence for every failed check instead of raising an error."""
    if not str(folder):
        raise PywetError("the folder of the run is empty; expected the path of a run directory", code="scene.no_folder")
    where, word = Path(folder), fingerprint(scene)
    begin = partial(record.begin, where, word, fingerprint(scene.model_copy(update={"seed": record.ANY_SEED})))
    with run_folder.hold(where):
        blocks = until.under_way(where) if scene.until and record.left_identity(where) == word else None
        building.write(scene, where, blocks, begin)
        record.leave_reference(where, placed_laws(scene.laws, scene.folder, scene.file is None).reference)
        stages.simulate(where, ranks, progress, extend=until.extension(scene.until) if scene.until else None)
        results.write(where)
        refusal = []
        try:
            stages.replay(where)
        except PywetError as unreadable:
            refusal = [str(unreadable)]
        return verdict.objections(RunDir(where)) or refusal


def fingerprint(scene: Scene) -> str:
    """Return the data that determine a run of this scene: its description, the files that it names, the program's code."""
    named = placed_laws(scene.laws, scene.folder, scene.file is None).model_dump(
        exclude={"reference"}, exclude_none=True
    )
    files = [*(Path(law.rpartition(":")[0]) for law in named.values() if custom_laws.is_custom(law)), *scene.files()]
    texts = [hashlib.sha256(read_bytes(file, "fix its path in the scene")).hexdigest() for file in files]
    return identity.of(scene.model_dump(mode="json", exclude={"folder", "file"}), texts)


def load(folder: Path | str) -> Run:
    """Read a finished run from its directory.

    Parameters
    ----------
    folder : Path or str
        Run directory.

    Returns
    -------
    Run
        Tables of the run with units.

    Raises
    ------
    FileError
        If a file of the run is missing or unreadable.
    """
    return Run(Path(folder))


def replay(folder: Path | str) -> dict[str, Any] | None:
    """Recompute a run by the independent reference.

    Parameters
    ----------
    folder : Path or str
        Run directory.

    Returns
    -------
    dict or None
        Content of `replay.json`: quantities, deviations, limits, diagnosis; None if nothing can be replayed.

    Raises
    ------
    PywetError
        If the run is incomplete or unreadable.
    """
    with run_folder.hold(Path(folder), shared=True):
        return stages.replay(Path(folder))


def view(folder: Path | str, step: int | None = None) -> Path:
    """Write the time series for ParaView (`vtk/`), a picture and, for a user-defined scene, `report.html` with it.

    Parameters
    ----------
    folder : Path or str
        Run directory.
    step : int, optional
        Output step of the picture, then `picture_STEP.png`; default: the one at which a third of what passes or leaves has
        done so, then `picture.png`.

    Returns
    -------
    Path
        The picture.
    """
    from pywet.report import render
    from pywet.report import scene_page as page

    stages.vtk(Path(folder))
    picture = Path(folder) / render.name(step)
    render.write(Path(folder), picture, step)
    if (Path(folder) / "description.json").exists():
        page.write(Path(folder), picture)
    return picture
