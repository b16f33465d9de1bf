"""Spheres thrown up in the screening apparatus: the cover throws them back, and takes liquid of moist ones as a wall does."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from pywet import config
from pywet.cases.screening import cases
from pywet.engines.liggghts import driver
from reference_impl.replay.replay import replay

pytestmark = pytest.mark.engine
CONFIG = config.load(Path(__file__).parents[3] / "config")
RIM, THICKNESS = 0.1615, 0.004


@pytest.mark.parametrize("number", [1, 2])
def test_what_is_thrown_up_stays_inside(tmp_path: Path, number: int) -> None:
    """At 3 m/s the topmost spheres of the fill would rise by 0.46 m: to three times the height of the rim."""
    scene = cases.build(CONFIG, number, "smoke", tmp_path)
    spheres = pd.read_parquet(tmp_path / "spheres.parquet")
    thrown = spheres["z"].nlargest(20).index
    spheres[["vx", "vy", "vz", "wx", "wy", "wz"]] = 0.0
    spheres.loc[thrown, "vz"] = 3.0
    spheres.to_parquet(tmp_path / "spheres.parquet")
    scene = scene.model_copy(update={"duration_s": 0.08, "retire": False})
    (tmp_path / "scene.json").write_text(scene.model_dump_json())
    driver.run(tmp_path, progress=False)
    path = pd.read_parquet(tmp_path / "trajectory.parquet")
    radii = path["type"].map({c.type: c.radius_m for c in scene.classes})
    assert (path.groupby("step").size() == len(spheres)).all()
    of_thrown = path["id"].isin(spheres["id"][thrown])
    tops = (path["z"] + radii)[of_thrown]
    assert 0.5 * RIM < tops.max() < RIM - 0.98 * THICKNESS  # soft contacts overlap by hundredths of a millimetre
    if number == 2:
        triangles = pd.read_parquet(tmp_path / "history" / "triangles.parquet")
        films = pd.read_parquet(tmp_path / "history" / "wall_films.parquet")
        on_cover = films["triangle"].isin(triangles["triangle"][triangles["mesh"] == "cover"])
        assert films["film"][on_cover].max() > 0.0
        found = replay(tmp_path)["quantities"]
        # the configuration has another duration and no speeds
        assert {name for name, q in found.items() if not q["ok"]} == {"scene_numbers"}
