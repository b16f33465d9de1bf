"""Experiments that give a target: a bridge, a wall collision or a user-defined scene, and the quantities read from them.

A bridge and a collision are deterministic; a scene is run in the engine with a random seed.
"""

from __future__ import annotations

import hashlib
import json
import math
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from typing_extensions import TypedDict

from pywet import scene_stages as commands
from pywet.cases.custom.description import Scene
from pywet.cases.small import bridge_query
from pywet.collisions.wall import sweep
from pywet.collisions.wall.problem import Problem
from pywet.config.dotted_keys import filled, holds
from pywet.config.loading import begun, parse, read_yaml
from pywet.engines.process import package_version
from pywet.errors import ConfigError, PywetError
from pywet.laws import custom_laws, registry
from pywet.runs.loaded import Run
from pywet.util import sources
from pywet.util.files import read_bytes, read_if_there, read_json, write_json

CURE = "name a file of `pywet bridge`, `pywet collide wall` or `pywet run-scene`, counted from the calibration's folder"
AT_END = ("contacts_per_sphere", "bridges_per_sphere", "centre_of_mass_height_m")
OF_SCENE: dict[str, Callable[[Run], float]] = {
    "angle_of_repose_deg": lambda run: run.angle_of_repose(),
    "drum_angle_deg": lambda run: run.drum_angle(),
    **{name: lambda run, name=name: float(run.contact_statistics[name].iloc[-1]) for name in AT_END},  # type: ignore[misc]
}


def _collision(problem: Problem, name: str) -> float:
    from pywet.collisions.wall.wall import collide

    value = collide(problem)[name]
    return math.nan if value is None else float(value)


@dataclass(frozen=True)
class Kind:
    """Functions that build and evaluate an experiment; `random_start`: its result depends on the seed of an engine run."""

    read: Callable[[Path], dict[str, Any]]
    build: Callable[[dict[str, Any], Path], Any]
    quantities: Mapping[str, Callable[[Any], float]]
    random_start: bool = False
    files: Callable[[Any], list[tuple[Path, str]]] = lambda built: []
    """Files that a built experiment names, each with the advice if it cannot be read."""


def _of_laws(laws: Iterable[str], folder: Path) -> list[tuple[Path, str]]:
    """Return the files of custom laws with the advice if they cannot be read."""
    placed = [custom_laws.placed(law, folder) for law in laws if custom_laws.is_custom(law)]
    return [(Path(law.rpartition(":")[0]), custom_laws.CURE) for law in placed]


def _of_scene(scene: Scene) -> list[tuple[Path, str]]:
    """Return the files that a scene names, those of laws and of their references too, with the advice if they cannot be read."""
    chosen = scene.laws.model_dump(exclude={"preset", "reference"}, exclude_none=True)
    laws = _of_laws([*chosen.values(), *scene.laws.reference.values()], scene.folder)
    return [(file, CURE) for file in scene.files()] + laws


def _json(path: Path) -> dict[str, Any]:
    content = read_json(path, CURE)
    if not isinstance(content, dict):
        raise ConfigError(
            f"{path} holds no keys; expected an experiment: {CURE}", file=path, code="calibration.not_keys"
        )
    return content


KINDS = {
    "bridge": Kind(
        _json,
        bridge_query.checked,
        {"pull_off_force_N": bridge_query.pull_off, "rupture_distance_m": bridge_query.rupture_distance},
        files=lambda query: _of_laws(query.laws, Path()),
    ),
    "wall": Kind(
        _json,
        lambda content, path: parse(Problem, content, str(path)),
        {name: lambda p, name=name: _collision(p, name) for name in sweep.RESULTS if name.startswith("e_")},  # type: ignore[misc]
    ),
    "scene": Kind(
        lambda path: read_yaml(path, Scene, begun("drum")),
        lambda content, path: Scene(**{**content, "folder": path.parent, "file": path}),
        OF_SCENE,
        random_start=True,
        files=_of_scene,
    ),
}
"""Kind of experiment by the key of a target."""


class StoredResult(TypedDict):
    """Result of an engine's run: the value read from it, and its time."""

    quantities: dict[str, float]
    wall_s: float


@dataclass(frozen=True)
class Experiment:
    """An experiment as its file describes it."""

    kind: str
    file: Path
    content: dict[str, Any]

    @classmethod
    def read(cls, kind: str, file: Path, changes: Mapping[str, Any]) -> Experiment:
        """Read an experiment from its file, with some keys changed."""
        content = KINDS[kind].read(file)
        for key in changes:
            if not holds(content, key):
                raise ConfigError(
                    f"changes names {key}, which is not in {file}; expected a key that is written there",
                    code="calibration.unknown_key", file=file, key=key,
                )  # fmt: skip
        return cls(kind, file, filled(content, changes))

    @property
    def random_start(self) -> bool:
        """Return whether the experiment is run in an engine, with a random initial arrangement."""
        return KINDS[self.kind].random_start

    def built(self, settings: Mapping[str, float], seed: int = 0) -> Any:
        """Build the experiment with these values of its keys; the seed is added to that of the scene's file."""
        content = filled(self.content, {key: v for key, v in settings.items() if holds(self.content, key)})
        try:
            made = KINDS[self.kind].build(content, self.file)
            return made.with_(seed=made.seed + seed) if self.random_start else made
        except PywetError as error:
            cure = f"with {_text(settings)}: fix the bounds of the parameters"
            raise ConfigError(
                f"{error} ({cure})", file=self.file, code="calibration.bounds", key=error.key, given=settings
            ) from error

    def digests(self, settings: Mapping[str, float]) -> list[str]:
        """Return the digests of the files that the experiment names."""
        return _digests(KINDS[self.kind].files(self.built(settings)))

    def value(self, quantity: str, settings: Mapping[str, float]) -> float:
        """Compute the value of an experiment that needs no engine."""
        return _number(KINDS[self.kind].quantities[quantity](self.built(settings)), quantity, settings)

    def run(
        self, wanted: tuple[str, ...], settings: Mapping[str, float], seed: int, folder: Path, ranks: int
    ) -> StoredResult:
        """Return the quantities of an engine run; a run whose quantities are stored in the folder is not repeated."""
        scene = self.built(settings, seed)
        place = folder / _name(scene)
        stored = read_if_there(place / "calibration.json", shape=StoredResult)
        if stored is None or not set(wanted) <= set(stored["quantities"]):
            started = time.monotonic()
            run = commands.run(scene, place, ranks)
            numbers = {q: _number(OF_SCENE[q](run), q, {**settings, "seed": scene.seed}) for q in wanted}
            stored = StoredResult(quantities=numbers, wall_s=time.monotonic() - started)
            write_json(place / "calibration.json", stored)
        return stored


def _name(scene: Scene) -> str:
    """Return the digest of a run: its scene, the files that it names, and the program."""
    message = json.dumps(scene.model_dump(mode="json", exclude={"folder", "file"}), sort_keys=True)
    word = hashlib.sha256(message.encode() + _program() + registry.published_code(message).encode())
    for digest in _digests(_of_scene(scene)):
        word.update(bytes.fromhex(digest))
    return word.hexdigest()[:16]


def _digests(files: Iterable[tuple[Path, str]]) -> list[str]:
    return [hashlib.sha256(read_bytes(file, cure)).hexdigest() for file, cure in files]


@cache
def _program() -> bytes:
    """Return the digest of the code that a run executes and that evaluates it, the engine's plugin and the engine's version."""
    return sources.digest(
        sources.of_a_run(), sources.digest_of_evaluation(), package_version("liggghts") or ""
    ).encode()


def _number(value: float, quantity: str, settings: Mapping[str, float]) -> float:
    if not math.isfinite(value):
        raise PywetError(
            f"there is no {quantity} with {_text(settings)}; expected a number everywhere between the bounds: narrow "
            "them, or, if a heap is too small to have a slope, use more spheres",
            code="calibration.no_number", key=quantity, given=settings,
        )  # fmt: skip
    return value


def _text(settings: Mapping[str, float]) -> str:
    return ", ".join(f"{key} {value:.6g}" for key, value in settings.items())
