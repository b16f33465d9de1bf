"""Runs at a point of a sweep: case, scene, script, wall collision or bridge, each from its file and the point's values."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from pywet import scene_stages as commands
from pywet.cases.custom import building, description
from pywet.cases.screening import identity
from pywet.cases.small import bridge_query
from pywet.collisions.wall import sweep as collisions
from pywet.collisions.wall.problem import Problem
from pywet.config.dotted_keys import filled
from pywet.config.loading import begun, parse, placed_laws, read_yaml
from pywet.errors import ConfigError
from pywet.laws import custom_laws as user_laws
from pywet.sweep import costs, run_numbers
from pywet.sweep.base_kind import Built, Kind, Numbers, number, stored_name
from pywet.sweep.case_base import OfCase
from pywet.sweep.costs import Cost
from pywet.sweep.description import Base, Point
from pywet.sweep.script_base import OfScript
from pywet.util import sources
from pywet.util.files import read_bytes, read_json

CURE = (
    "name a file of `pywet run-scene`, `pywet collide wall` or `pywet bridge`; its path counts from the sweep's folder"
)


class Wall(Kind):
    """Collision of a wet sphere with a wall as a base, computed immediately."""

    engine = seeded = False
    results = ("e_n", "e_t", "e_omega")
    code = "collisions"
    """Package that computes it."""

    @cached_property
    def content(self) -> dict[str, Any]:
        return _json(self.file)

    def built(self, values: Point, seed: int) -> Built:
        problem = parse(Problem, filled(self.content, values), str(self.file))
        return Built(f"wall-{_digest('wall', problem.model_dump(mode='json'), _code(Wall.code))}", problem)

    def run(self, built: Built, folder: Path, ranks: int) -> Numbers:
        from pywet.collisions.wall.wall import collide

        answer = collide(built.given)
        numbers = {name: number(answer[name]) for name in collisions.RESULTS}
        return numbers | {f"energy_{name}_J": number(answer["energy_J"][name]) for name in collisions.ENERGIES}

    def cost(self, built: Built) -> Cost:
        return costs.COLLISION

    def known(self, built: Built) -> list[str]:
        return [*collisions.RESULTS, *(f"energy_{name}_J" for name in collisions.ENERGIES)]


class Bridge(Kind):
    """One bridge with the capillary law that its file or an axis names as a base, computed immediately."""

    engine = seeded = False
    results = ("pull_off_force_N", "rupture_distance_m")
    code = "cases/small"
    """Package that computes it."""

    @cached_property
    def content(self) -> dict[str, Any]:
        return _json(self.file)

    def built(self, values: Point, seed: int) -> Built:
        query = bridge_query.checked(filled(self.content, values), self.file)
        user_laws.trust(query.laws, None if self.trust else self.file.parent)
        if len(query.named("capillary")) != 1:
            raise ConfigError(
                f"{self.file} names {len(query.named('capillary'))} capillary laws; expected one in laws",
                code="sweep.capillary_laws", key="laws", given=query.named("capillary"), file=self.file,
            )  # fmt: skip
        files = [_text(law) for law in query.laws if user_laws.is_custom(law)]
        given = query.model_dump(mode="json", exclude={"laws"})
        laws = [law.rpartition(":")[2] for law in query.laws]
        return Built(f"bridge-{_digest('bridge', given, laws, files, _code(Bridge.code))}", query)

    def run(self, built: Built, folder: Path, ranks: int) -> Numbers:
        return {
            "pull_off_force_N": number(bridge_query.pull_off(built.given)),
            "rupture_distance_m": number(bridge_query.rupture_distance(built.given)),
        }

    def cost(self, built: Built) -> Cost:
        return costs.BRIDGE

    def known(self, built: Built) -> list[str]:
        return [*self.results]


class OfScene(Kind):
    """Sweep of a user-defined scene that runs in the engine."""

    @cached_property
    def content(self) -> dict[str, Any]:
        return read_yaml(self.file, description.Scene, begun("drum"))

    def built(self, values: Point, seed: int) -> Built:
        content = filled(self.content, values)
        scene = description.Scene(**{**content, "folder": self.file.parent, "file": self.file})
        scene = scene.with_(seed=scene.seed + seed)
        placed_laws(scene.laws, scene.folder, self.trust)
        return Built(stored_name("scene", commands.fingerprint(scene), run_numbers.__file__), scene)

    def run(self, built: Built, folder: Path, ranks: int) -> Numbers:
        return run_numbers.numbers(commands.run(built.given, folder, ranks))

    def cost(self, built: Built) -> Cost:
        return costs.of_scene(building.Building(built.given))

    def known(self, built: Built) -> list[str]:
        return run_numbers.of_scene(built.given)


def _json(path: Path) -> dict[str, Any]:
    content = read_json(path, CURE)
    if not isinstance(content, dict):
        raise ConfigError(
            f"{path} holds {type(content).__name__}, expected keys and values: {CURE}", file=path, code="sweep.not_keys"
        )
    return content


def _digest(*parts: object) -> str:
    return identity.of(*(json.loads(json.dumps(part)) for part in parts))


def _text(law: str) -> str:
    return hashlib.sha256(read_bytes(Path(law.rpartition(":")[0]), user_laws.CURE)).hexdigest()


@cache
def _code(package: str) -> str:
    """Return the digest of the code of a package of pywet without an engine; that of the laws is in every fingerprint."""
    return sources.digest(sources.of([package]))


def kind(base: Base, folder: Path, trust: bool = False) -> Kind:
    """Return the base of a sweep whose file is in a folder."""
    of: Mapping[str, type[Kind]] = {
        "case": OfCase,
        "scene": OfScene,
        "script": OfScript,
        "wall": Wall,
        "bridge": Bridge,
    }
    return of[base.kind](base, folder, trust)
