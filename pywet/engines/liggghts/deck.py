"""Write the LIGGGHTS deck of a scene: data file, set-up script, run script, from the templates in liggghts_inputs/."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import jinja2
import numpy as np
import pandas as pd

from pywet.engines import schedule
from pywet.engines.liggghts import contact_model, creation, grid, windows
from pywet.engines.liggghts.checkpoint import Checkpoint, saved
from pywet.errors import PywetError, shown
from pywet.geometry.stl import write_first_triangle
from pywet.laws import registry
from pywet.scene import EngineScene, Rotation, Slide, Vibration, WallMesh
from pywet.shipped import place
from pywet.util.files import atomic_write, read_table

TEMPLATES = place("liggghts_inputs")
FILM_GROWTH = 2.5
"""Growth of the films on the smallest spheres that the neighbour list allows for (other sizes: same ratio to r)."""


FALLING, SKIN = 2.0, 3.6
"""Speed [m/s] of the spheres that cause most lists, and the factor of the skin.

The skin is this factor times the square root of their displacement per step times the largest diameter; measured,
docs/engine.md.
"""
FASTEST = 5.0
"""Largest speed [m/s] at which a stretched bridge is within the ghost cut-off; beyond it the run stops with a message.

Also the largest at which the engine without the plugin deletes the spring of a pair that separates.
"""
UNIT_VECTORS = ("1 0 0", "0 1 0", "0 0 1")
IDS_A_LINE = 100
"""Number of sphere ids in one line of the engine's script."""


def film_factor(scene: EngineScene) -> float:
    """Return the range, in radii, within which the neighbour list includes touching films; 1 for a dry scene."""
    if not scene.effects.bridges or scene.liquid is None:
        return 1.0
    smallest = min(c.radius_m for c in scene.classes)
    return 1.0 + FILM_GROWTH * scene.liquid.initial_film_thickness_m / smallest


def listed(scene: EngineScene) -> float:
    """Return the distance beyond touch [m] that the neighbour list covers: the skin and the distance at which films can touch."""
    return skin(scene) + 2.0 * max(c.radius_m for c in scene.classes) * (film_factor(scene) - 1.0)


def contact_distance_factor(scene: EngineScene) -> float:
    """Return the sum of radii, relative, within which the engine deletes the tangential springs of separated pairs.

    It keeps those of pairs farther apart as long as they are in its neighbour list; a pair that separates at `FASTEST` is
    within it for a step. With the plugin, which deletes them itself, it is 1: the engine needs nearly as long for each such pair
    as for a contact.
    """
    if contact_model.attached(scene) or not scene.effects.tangential_history:
        return 1.0
    return 1.0 + FASTEST * scene.time_step_s / min(c.radius_m for c in scene.classes)


def longest_bridge(scene: EngineScene) -> float:
    """Return an upper bound of a bridge's length [m] for the rupture laws: V* = 0.5, the two largest spheres, 5 m/s.

    It is never longer than the diagonal of the box, which the stretch of a liquid of almost no surface tension would exceed,
    and which is taken where the laws give no number.
    """
    if not scene.effects.bridges or scene.liquid is None or scene.effects.rupture is None:
        return 0.0
    r = max(c.radius_m for c in scene.classes)
    angle = max(c.contact_angle_rad for c in scene.classes)
    length = registry.get("rupture", scene.effects.rupture).functions[0](0.5 * r**3, r, r, angle, angle)
    factor = 1.0
    if scene.effects.dynamic_rupture is not None:
        stretch = registry.get("dynamic_rupture", scene.effects.dynamic_rupture).functions[0]
        factor = stretch(FASTEST, scene.liquid.viscosity_Pa_s, scene.liquid.surface_tension_N_per_m)
    return float(np.fmin(length * factor, math.dist(scene.box_low_m, scene.box_high_m)))


def skin(scene: EngineScene) -> float:
    """Return the skin [m] of the neighbour list, which is rebuilt when a sphere has moved by half of it.

    With a thick skin it is rebuilt rarely, with a thin one it has few pairs; c1 d^3/(s/way) + c2 d^2 s is
    smallest at a multiple of sqrt(d way), with the displacement `way` of a falling sphere per step.
    """
    smallest, largest = (f(c.radius_m for c in scene.classes) for f in (min, max))
    return min(max(0.4 * smallest, SKIN * (2.0 * largest * FALLING * scene.time_step_s) ** 0.5), 1.2 * smallest)


def viblin_words(vibration: Vibration) -> list[str]:
    """Return the arguments after the mesh's name of the `fix move/mesh … viblin` for this vibration, one list per moving axis."""
    period = 1.0 / vibration.frequency_Hz
    return [
        f"viblin axis {axis} order 1 amplitude {amplitude!r} phase {phase - 0.5 * math.pi!r} period {period!r}"
        for axis, amplitude, phase in zip(UNIT_VECTORS, vibration.amplitude_m, vibration.phase_rad, strict=True)
        if amplitude != 0.0
    ]


def movers(scene: EngineScene) -> list[dict[str, str]]:
    """Return three viblin movers per vibrating mesh, one rotation per turning mesh."""
    fixes = []
    for name, way in scene.motions.items():
        if isinstance(way, Vibration):
            fixes += [
                {"id": f"move_{name}_{k}", "mesh": name, "words": words} for k, words in enumerate(viblin_words(way))
            ]
        if isinstance(way, Rotation):
            origin, axis = (" ".join(map(repr, v)) for v in (way.origin_m, way.axis))
            words = f"rotate origin {origin} axis {axis} period {way.period_s!r}"
            fixes.append({"id": f"move_{name}", "mesh": name, "words": words})
    return fixes


class Run(NamedTuple):
    """One `run` of the engine with the lines around it, and the step whose state is saved after it (None: not saved)."""

    before: list[str]
    steps: int
    after: list[str]
    checkpoint: int | None

    @property
    def lines(self) -> list[str]:
        """All lines of a piece of the deck, in the order in which the engine reads them."""
        return [*self.before, f"run {self.steps}", *self.after]


def runs(scene: EngineScene, done: int = 0) -> list[Run]:
    """Return the run commands that remain after `done` steps; checkpoints empty the engine."""
    moving = scene.motions.items()
    speed = {name: " ".join(map(repr, way.velocity_m_per_s)) for name, way in moving if isinstance(way, Slide)}
    return [
        Run(
            [f"fix draw_{name} all move/mesh mesh {name} linear {speed[name]}" for name in piece.drawn],
            piece.steps,
            [f"unfix draw_{name}" for name in piece.stops],
            piece.checkpoint,
        )
        for piece in schedule.pieces(scene, done, contact_model.attached(scene))
    ]


def retirement(ids: Iterable[int]) -> list[str]:
    """Return lines that remove spheres from the engine after a run."""
    words = [str(number) for number in ids]
    if not words:
        return []
    group = [f"group retired id {' '.join(words[k : k + IDS_A_LINE])}" for k in range(0, len(words), IDS_A_LINE)]
    return [*group, "delete_atoms group retired compress no"]


def write_data(scene: EngineScene, spheres: pd.DataFrame, path: Path) -> None:
    """Write the engine's data file: box and spheres (id, type, diameter, density, position), velocities if given."""
    inside = np.ones(len(spheres), dtype=bool)
    for axis, low, high in zip("xyz", scene.box_low_m, scene.box_high_m, strict=True):
        inside &= (spheres[axis] > low) & (spheres[axis] < high) | (spheres[axis] == low) & (axis == scene.periodic)
    if not inside.all():
        first = spheres.loc[~inside].iloc[0]
        raise PywetError(
            f"sphere {int(first['id'])} starts outside the box of scene {scene.name}; enlarge the box",
            code="scene.outside_box", given=int(first["id"]),
        )  # fmt: skip
    lines = ["spheres of pywet", "", f"{len(spheres)} atoms", f"{len(scene.classes) + 1} atom types", ""]
    for axis, low, high in zip("xyz", scene.box_low_m, scene.box_high_m, strict=True):
        lines.append(f"{low!r} {high!r} {axis}lo {axis}hi")
    lines += ["", "Atoms", ""]
    rows = spheres.to_dict("records")
    for row in rows:
        c = scene.classes[int(row["type"]) - 1]
        at = " ".join(repr(float(row[axis])) for axis in "xyz")
        lines.append(f"{row['id']} {row['type']} {2 * c.radius_m!r} {c.density_kg_per_m3!r} {at}")
    if "vx" in spheres.columns:
        lines += ["", "Velocities", ""]
        for row in rows:
            lines.append(f"{row['id']} " + " ".join(repr(float(row[k])) for k in ("vx", "vy", "vz", "wx", "wy", "wz")))
    with atomic_write(path) as temporary:
        temporary.write_text("\n".join(lines) + "\n")


def _stl(wall: WallMesh, run_dir: Path, folder: Path) -> str:
    """Write the file of a mesh; if the plugin computes the contacts, one triangle that moves like the wall."""
    if not wall.analytic_wires:
        return from_folder(run_dir / wall.stl, folder)
    name = f"{wall.name}.moves.stl"
    write_first_triangle(run_dir / wall.stl, folder / name)
    return name


def from_folder(path: Path, folder: Path) -> str:
    """Return the path of a file relative to the engine's working directory, so that no absolute path enters the deck."""
    way = os.path.relpath(path.resolve(), folder.resolve())
    if not re.fullmatch(r"[A-Za-z0-9_./-]+", way):
        raise PywetError(
            f"the path {shown(Path(way))} cannot be used in the engine's script; expected letters, digits, _, - and . "
            "between slashes: rename what is below the run directory",
            code="engine.path", given=way,
        )  # fmt: skip
    return way


def write_deck(
    scene: EngineScene,
    run_dir: Path,
    folder: Path,
    *,
    extra: tuple[str, ...] = (),
    integrate: str = "all",
    resume: Checkpoint | None = None,
    ranks: int = 1,
) -> int:
    """Write data file and scripts into `folder`; returns the number of spheres.

    `extra` lines and the group `integrate` are used by driven small scenes. With `resume` the deck starts from the
    engine's restart file and contains the rest of the run.
    """
    every, done = scene.output_every, resume.step if resume else 0
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    g = np.asarray(scene.gravity_m_per_s2)
    size = float(np.linalg.norm(g))
    direction = dict(zip("xyz", (repr(float(x)) for x in g / size), strict=True)) if size else {}
    contact = contact_model.commands(scene)
    plugin = contact["attached"]
    spheres = creation.at_start(scene, read_table(run_dir / scene.spheres_file))
    context = {
        "scene": scene,
        **contact,
        # the plugin's worker says them, at each checkpoint again
        "columns": "${columns}" if plugin else grid.words(scene, spheres[["x", "y"]], ranks),
        "boundary": " ".join("p" if axis == scene.periodic else "f" for axis in "xyz"),
        "types": len(scene.classes) + 1,
        "skin": repr(skin(scene)),
        "bin": repr(2.0 * max(c.radius_m for c in scene.classes) * film_factor(scene) + skin(scene)),
        "listed": repr(listed(scene)),
        "contact_distance_factor": repr(contact_distance_factor(scene)),
        "thickest_film": repr(film_factor(scene) - 1.0),
        "ghost_cutoff": repr(2.0 * max(c.radius_m for c in scene.classes) + longest_bridge(scene)),
        "gravity": {"magnitude": repr(size), **direction} if size else None,
        "stl": {w.name: _stl(w, run_dir, folder) for w in scene.walls},
        "below": repr(2.0 * scene.box_low_m[2] - scene.box_high_m[2]),
        "movers": movers(scene),
        "runs": [(run, saved("engine", run.checkpoint, whole=False)) for run in runs(scene, done)],
        "extra": extra,
        "integrate": integrate,
        "thermo": max(1, scene.steps // 200),
        "output_every": every,
        "windows": windows.deck_lines(scene, schedule.recorded(scene), contact["touched"]),
    }
    write_data(scene, spheres, folder / "particles.data")
    begin = {
        "restart_file": resume.engine.relative_to(folder) if resume else None,
        "at": done,
        "again": False,
        "first_frame": done % every == 0 and not (done and scene.removes),  # else the frame is of the spheres that stay
    }
    # the plugin's worker has given the file its name by then, the stock program cannot
    again = {"restart_file": saved("engine", "${at}", whole=plugin), "at": "${at}", "again": True, "first_frame": False}
    for name, template, more in (
        ("setup", "setup", begin),
        ("again", "setup", again),
        ("run", "run", {}),
        ("in", "in", {}),
    ):
        text = environment.get_template(f"{template}.liggghts.j2").render({**context, **more})
        with atomic_write(folder / f"{name}.liggghts") as temporary:
            temporary.write_text(text)
    return len(spheres)
