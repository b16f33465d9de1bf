"""Group runs by scene: runs of one group differ only in the seed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pywet.cases.custom.seeds import but_seed
from pywet.compare.quantities import facts, unlike
from pywet.runs import record
from pywet.runs.rundir import RunDir


def by_scene(folders: Sequence[Path]) -> list[list[Path]]:
    """Group runs that differ only in the seed, in the given order."""
    groups: list[list[Path]] = []
    for folder in map(Path, folders):
        found = next((group for group in groups if same_scene(group[0], folder)), None)
        if found is None:
            groups.append([folder])
        else:
            found.append(folder)
    return groups


def same_scene(a: Path, b: Path) -> bool:
    """Return whether two runs differ only in the seed, comparing their descriptions, facts of the scene, effects and steps.

    For runs without a description, such as cases, whole scenes are compared, except the box, which depends on the
    initial positions. Of runs with `until` blocks are compared, not their number. Fingerprints without the seed must agree.
    """
    if not record.alike(a, b):
        return False
    one, other = but_seed(a), but_seed(b)
    scenes = [scene.of_blocks(1) if scene.blocks else scene for scene in (RunDir(folder).scene for folder in (a, b))]
    if one or other:
        engine = [(s.effects, s.time_step_s, s.duration_s) for s in scenes]
        return one == other and engine[0] == engine[1] and not unlike(facts(scenes[0]), scenes[1])
    left_out = {"seed", "spheres_file", "box_low_m", "box_high_m"}
    whole = [scene.model_dump(mode="json", exclude=left_out) for scene in scenes]
    return bool(whole[0] == whole[1])
