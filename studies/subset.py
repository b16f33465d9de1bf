"""A prepared scene with fewer spheres: for checks and studies that a whole screening case is too large for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.geometry.initial import sphere_table
from pywet.scene import EngineScene
from pywet.util.files import read_json, write_json, write_table


def with_spheres(scene: EngineScene, run_dir: Path, spheres: pd.DataFrame, **changed: Any) -> EngineScene:
    """Rewrite a run directory with a subset of its spheres, renumbered, and with scene fields replaced by `changed`.

    A stored configuration then lists the fields that no longer follow from it.
    """
    spheres = spheres.assign(id=np.arange(1, len(spheres) + 1)).reset_index(drop=True)
    count = spheres["type"].value_counts()
    classes = tuple(c.model_copy(update={"count": int(count.get(c.type, 0))}) for c in scene.classes)
    scene = scene.model_copy(update={"classes": classes, **changed})
    write_table(spheres, run_dir / scene.spheres_file)
    write_table(sphere_table(scene, spheres), run_dir / "history" / "spheres.parquet")
    write_json(run_dir / "scene.json", scene.model_dump(mode="json"))
    resolved = run_dir / "config.json"
    if resolved.exists():
        write_json(resolved, {**read_json(resolved), "edited": ["classes.count", *sorted(changed)]})
    return scene
