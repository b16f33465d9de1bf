"""One scene run both ways: as a scene, and as a script with the line of fix pywet: the same events to the last bit."""

from __future__ import annotations

import math
from pathlib import Path

import pandas as pd
import pytest

from pywet.cases.small import small
from pywet.cases.small.bodies import contacts, sphere_classes, water
from pywet.engines.liggghts import deck
from pywet.scene import EngineScene
from tests.cases.script.scripts import run

pytestmark = [pytest.mark.engine, pytest.mark.slow]
R, FILM_UM, STEP, STEPS, EVERY = 2.5e-3, 50.0, 1e-5, 4000, 500
FILM = 1e-6 * FILM_UM
TABLES = ("events", "bridges", "films", "ledger")
THROWN = [
    small.Sphere(
        1 + k % 2, (5.4e-3 * (k % 3), 5.4e-3 * (k // 3 % 3), 4e-3 + 5.6e-3 * (k // 9)), (0.02 * (k % 5), 0.1, -0.3)
    )
    for k in range(27)
]
"""Spheres of two sizes in a loose block that falls on a plate."""


def script(scene: EngineScene, folder: Path) -> None:
    """The scene's own deck without the plugin's lines, and one line in their place."""
    text = (folder.parent / "scene" / "engine" / "setup.liggghts").read_text()
    plugin = (
        "fix             p_liquid",
        "fix             pywet",
        "variable        skin",
        "variable        thickest",
        "#",
    )
    lines = [row for row in text.splitlines() if not row.startswith(plugin)]
    # a script reserves half of the skin for films: with twice the skin neighbour lists are rebuilt at the same steps
    lines = [f"neighbor {2.0 * deck.skin(scene)!r} bin" if row.startswith("neighbor ") else row for row in lines]
    lines = [row for row in lines if not row.startswith(("dump", "variable        frame"))]
    lines = [row.replace("processors      ${columns} 1", "processors      * * 1") for row in lines]
    lines += [f"fix wet all pywet liquid wet.yaml every {EVERY} windows 1", f"run {STEPS}"]
    folder.mkdir()
    (folder / "particles.data").write_text((folder.parent / "scene" / "engine" / "particles.data").read_text())
    for wall in scene.walls:
        target = folder / (folder.parent / "scene" / wall.stl).name
        target.write_bytes((folder.parent / "scene" / wall.stl).read_bytes())
        lines = [row.replace(f"file {deck.from_folder(folder.parent / 'scene' / wall.stl, folder.parent / 'scene' / 'engine')}",
                             f"file {target.name}") for row in lines]  # fmt: skip
    (folder / "in.script").write_text("\n".join(lines) + "\n")
    angles = {c.type: math.degrees(c.contact_angle_rad) for c in scene.classes}
    walls = {w.name: math.degrees(w.contact_angle_rad) for w in scene.walls}
    liquid = scene.liquid
    assert liquid
    (folder / "wet.yaml").write_text(
        f"liquid: {{surface_tension_N_per_m: {liquid.surface_tension_N_per_m!r}, viscosity_Pa_s: {liquid.viscosity_Pa_s!r}, "
        f"density_kg_per_m3: {liquid.density_kg_per_m3!r}, film_um: {FILM_UM!r}}}\n"
        f"contact_angle_deg: {{{', '.join(f'{t}: {a!r}' for t, a in angles.items())}}}\n"
        f"viscous_integration: {scene.viscous_integration}\n"
        f"walls: {{{', '.join(f'{n}: {a!r}' for n, a in walls.items())}}}\n"
    )


def test_the_same_scene_as_a_script(tmp_path: Path) -> None:
    """Formations, ruptures, volumes, films and the ledger; columns of energies and works a script does not have."""
    folder = tmp_path / "scene"
    small.prepare(
        folder, sphere_classes(R, 2e-3), THROWN, contacts(2, 1e4, friction=0.2), walls=[small.floor()],
        wall_angle_rad=math.radians(45.0), gravity=(0.0, 0.0, -9.81), liquid=water(FILM), effects=small.PAPER,
        time_step_s=STEP, steps=STEPS, output_interval_s=EVERY * STEP, contacts="stock",
    )  # fmt: skip
    small.run(folder, THROWN)
    scene = EngineScene.read(folder / "scene.json")
    script(scene, tmp_path / "script")
    done = run(tmp_path / "script")
    assert done.returncode == 0, done.stderr
    counted = {}
    for name in TABLES:
        one, two = (
            pd.read_parquet(way / "history" / f"{name}.parquet") for way in (folder, tmp_path / "script" / "wet")
        )
        order = [c for c in ("step", "kind", "partner_kind", "i", "j", "id") if c in one]
        one, two = (table.sort_values(order, ignore_index=True)[sorted(set(one) & set(two))] for table in (one, two))
        pd.testing.assert_frame_equal(one, two, check_exact=True)
        counted[name] = len(one)
        assert {"films": "film", "ledger": "bridges"}.get(name, "volume") in one
    assert counted["events"] > 50
