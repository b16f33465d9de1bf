"""Group runs by scene: runs that differ in nothing but the seed belong together."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pywet.cases.custom.seeds import but_seed
from pywet.compare.quantities import facts, unlike
from pywet.runs.rundir import RunDir


def by_scene(folders: Sequence[Path]) -> list[list[Path]]:
    """Group runs that differ in nothing but the seed, in the order in which they were given."""
    groups: list[list[Path]] = []
    for folder in map(Path, folders):
        found = next((group for group in groups if same_scene(group[0], folder)), None)
        if found is None:
            groups.append([folder])
        else:
            found.append(folder)
    return groups


def same_scene(a: Path, b: Path) -> bool:
    """Return whether two runs differ in nothing but the seed: in their descriptions, facts of the scene, effects and steps.

    Of runs without a description, such as cases, scenes are compared as a whole; the box follows the initial positions.
    """
    one, other = but_seed(a), but_seed(b)
    if one or other:
        scenes = [RunDir(folder).scene for folder in (a, b)]
        engine = [(s.effects, s.time_step_s, s.duration_s) for s in scenes]
        return one == other and engine[0] == engine[1] and not unlike(facts(scenes[0]), scenes[1])
    left_out = {"seed", "spheres_file", "box_low_m", "box_high_m"}
    whole = [RunDir(folder).scene.model_dump(mode="json", exclude=left_out) for folder in (a, b)]
    return bool(whole[0] == whole[1])
