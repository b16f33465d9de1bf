"""Data for plugin and replay from a script's engine: sphere classes, mesh walls, range of the neighbour lists."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.cases.script.refusals import refusal
from pywet.cases.script.wet import Wet
from pywet.engines.liggghts.deck import FILM_GROWTH
from pywet.geometry.faces import FEATURE_ANGLE_DEG, face_of, half_width
from pywet.geometry.initial import wall_mesh
from pywet.geometry.surface import Floats, Surface
from pywet.laws.contact import film_thickness
from pywet.scene import SCRIPTED, EngineScene, Liquid, Output, SphereClass

KINDS = 32
"""Largest number of kinds of spheres: each pair of them has a table."""
KNOWN = ("gravity", "wall/gran", "mesh/surface", "pywet", "nve/sphere", "property/", "contacthistory", "neighlist/mesh")
"""Fixes whose forces are known (dry contacts, weight, bridges) or that exert none."""
CARRIERS = ("insert/stream",)
"""Fixes that move spheres at a prescribed speed until these have passed a face."""
LEAST_SKIN = 0.1
"""Smallest displacement of a sphere, over the smallest radius, that the neighbour list must allow for in addition to films."""


class Spheres:
    """Classes by atom type, radius and density, created as spheres are inserted, and the table of all spheres inserted so far."""

    def __init__(self, wet: Wet) -> None:
        self.wet = wet
        self.classes: list[SphereClass] = []
        self.come: list[pd.DataFrame] = []
        self._known: dict[tuple[int, float, float], int] = {}
        self.unused = dict(enumerate(wet.first_films, start=1))
        """Entries of `first_films` that have applied to no sphere so far, by number."""

    @property
    def table(self) -> pd.DataFrame:
        """Return id, type (the class), radius, film and the step `enters` of all inserted spheres, in order of their ids."""
        return pd.concat(self.come, ignore_index=True).sort_values("id", ignore_index=True)

    def take_in(self, rows: np.ndarray, step: int) -> pd.DataFrame:
        """Add the classes and films of spheres from records of the plugin."""
        for row in rows:
            self._known.setdefault(_kind(row), len(self._known) + 1)
        if len(self._known) > KINDS:
            raise refusal("wet.sizes", len(self._known))
        for k, (atom_type, radius, density) in enumerate(self._known, start=1):
            if k <= len(self.classes):
                continue
            angle = self.wet.angle_deg(atom_type)
            if angle is None:
                raise refusal("wet.angle", atom_type)
            name = f"type {atom_type}, {2e3 * radius:.6g} mm, {density:.6g} kg per m3"
            self.classes.append(
                SphereClass(
                    name=name, type=k, radius_m=radius, count=0, density_kg_per_m3=density,
                    contact_angle_rad=math.radians(angle),
                )
            )  # fmt: skip
        films = [self.wet.film_m3(int(r["type"]), float(r["mass"]), float(r["radius"]), tuple(r["x"])) for r in rows]
        used = {id(self.wet.first(int(r["type"]), tuple(r["x"]))) for r in rows} if self.unused else set()
        self.unused = {k: first for k, first in self.unused.items() if id(first) not in used}
        table = pd.DataFrame(
            {
                "id": rows["id"].astype(np.int64), "type": [self._known[_kind(row)] for row in rows],
                "radius": rows["radius"], "film": films, "enters": step,
            }
        ).astype({"type": np.int64, "film": float, "enters": np.int64})  # fmt: skip
        self.come.append(table)
        return table


def _kind(row: Any) -> tuple[int, float, float]:
    """Return atom type, radius and density [kg/m3], rounded to nine digits because density is computed from mass."""
    density = float(row["mass"]) / (4.0 / 3.0 * math.pi * float(row["radius"]) ** 3)
    return int(row["type"]), float(row["radius"]), float(f"{density:.9g}")


def surface(name: str, corners: Floats) -> Surface:
    """Return a mesh of the engine, (n, 3, 3) [m], in the order of its triangles; open or closed."""
    part = face_of(corners)
    widths = tuple(half_width(corners[part == k]) for k in range(int(part.max()) + 1))
    triangles = np.arange(3 * len(corners)).reshape(-1, 3)
    return Surface(name, "wall", corners.reshape(-1, 3), triangles, part, widths)


def other_forces(state: dict[str, Any]) -> list[str]:
    """List the forces on spheres other than dry contacts, steady gravity and bridges, as worded in the replay."""
    found = [
        f"fix {fix['id']} ({fix['style']})" for fix in state["fixes"]
        if (fix["acts"] and not fix["style"].startswith(KNOWN)) or fix["style"].startswith(CARRIERS)
    ]  # fmt: skip
    return found if state["steady_gravity"] else [*found, "gravity that varies or is not of all spheres"]


def dry_walls(state: dict[str, Any], wet: Wet) -> list[str]:
    """List walls that spheres touch without a bridge: primitive ones by their fix, and meshes without films."""
    fixes = [(fix["id"], fix["meshes"]) for fix in state["fixes"] if "meshes" in fix]
    return [name for fix, meshes in fixes for name in meshes or [fix] if name not in wet.wet_walls]


def scene_of(
    wet: Wet, time_step: float, spheres: Spheres, surfaces: list[Surface], gravity: Sequence[float]
) -> EngineScene:
    """Return the scene for the plugin, without dry contacts and motion, which the script defines; not validated as a whole."""
    liquid = wet.liquid
    angle = {name: math.radians(degrees) for name, degrees in wet.wet_walls.items()}
    feature = {"feature_angle_deg": FEATURE_ANGLE_DEG}
    walls = tuple(wall_mesh(s, angle[s.name]).model_copy(update=feature) for s in surfaces)
    far = max([1.0, *(float(np.abs(s.vertices).max()) for s in surfaces)])
    return EngineScene.model_construct(
        name=SCRIPTED, seed=0, classes=tuple(spheres.classes), pairs=(), hertz=None, walls=walls, vibration=None, slide=None,
        rotation=None, effects=wet.effects,
        liquid=Liquid(
            surface_tension_N_per_m=liquid.surface_tension_N_per_m, viscosity_Pa_s=liquid.viscosity_Pa_s,
            density_kg_per_m3=liquid.density_kg_per_m3, initial_film_thickness_m=0.0,
        ),
        viscous_integration=wet.viscous_integration, bridges_every=1, contacts="stock", wall_film=wet.wall_film,
        largest_overlap=0.5, transfer_nodes=201, gravity_m_per_s2=tuple(gravity), box_low_m=(-far,) * 3,
        box_high_m=(far,) * 3, spheres_file=Path("spheres.parquet"), time_step_s=time_step, duration_s=time_step,
        output=Output(interval_s=time_step, contact_windows=0, energy=False), screen_z_m=0.0, bin_z_m=-far, retire=False,
        outlets=(),
    )  # fmt: skip


def reach(spheres: Spheres, state: dict[str, Any]) -> tuple[float, float]:
    """Divide the skin of the script: the displacement that is left for spheres [m], and the films it covers, over the radius.

    Films may grow as in a scene; if the skin is larger they get half of it. Without liquid all of it is for displacements.
    """
    skin = float(state["skin"])
    table = spheres.table
    radius = table["radius"].to_numpy()
    first = float((film_thickness(table["film"].to_numpy(), radius) / radius).max()) if len(table) else 0.0
    wet = spheres.wet
    given = [(a.percent, a.film_um) for a in wet.first_films]
    if first == 0.0 and not any(map(any, [*given, (wet.liquid.percent, wet.liquid.film_um)])):
        return skin, 0.0
    if not float(state["largest_radius"]):
        raise refusal("wet.no_spheres")
    most, least = 2.0 * float(state["largest_radius"]), LEAST_SKIN * float(state["least_radius"])
    needed = FILM_GROWTH * first * most + least
    if skin < needed or skin < 2.0 * least:
        raise refusal("wet.skin", skin, f"{math.ceil(1e6 * max(needed, 2.0 * least)) / 1e6:g}")
    films = min(max(needed - least, 0.5 * skin), skin - least)
    return skin - films, films / most


def too_thick(come: pd.DataFrame, thickest: float) -> int | None:
    """Find the first inserted sphere whose film is thicker than neighbour lists allow."""
    radius = come["radius"].to_numpy()
    over = FILM_GROWTH * film_thickness(come["film"].to_numpy(), radius) > thickest * radius
    return int(come["id"].to_numpy()[over][0]) if over.any() else None
