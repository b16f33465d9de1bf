"""Build what an engine runs from a description: classes, contacts, films, surfaces, initial positions, time step."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from pydantic import ValidationError

from pywet import scene as typed
from pywet.cases.custom import extent, repeating
from pywet.cases.custom.at_walls import PRESSED, expected, thickness
from pywet.cases.custom.description import SPHERE_ANGLE_DEG, WALLS, Scene
from pywet.cases.custom.feeding import ahead_s, times, waiting, ways
from pywet.cases.custom.placing import (
    COUNT_FROM,
    ask_unit,
    from_origin,
    mention_bars,
    mention_crossing,
    origin_of,
    refuse_far,
)
from pywet.cases.custom.spheres import Spheres
from pywet.cases.custom.walls import EngineMotion
from pywet.cases.screening.amounts import common_film_thickness, liquid_volume, refuse_too_thin
from pywet.cases.small import bodies
from pywet.config.loading import placed_laws
from pywet.config.messages import mistake
from pywet.engines.liggghts.deck import listed, skin
from pywet.engines.schedule import OUTLET_EVERY_S, early_end
from pywet.errors import ConfigError
from pywet.geometry import Surface, fill, periodic
from pywet.geometry.initial import wall_mesh, write_initial
from pywet.geometry.surface import Floats
from pywet.laws.contact import film_volume, reduced_radius
from pywet.laws.hertz import Elastic, Hertz
from pywet.planning import step_choice
from pywet.planning.effect_plan import EffectPlan
from pywet.planning.effect_plan import plan as plan_effects
from pywet.planning.size_distribution import Amount
from pywet.planning.size_distribution import amounts as whole_amounts
from pywet.planning.surroundings import Surroundings
from pywet.planning.time_steps import hertz_lines, refuse_nonlinear_drag
from pywet.products import until
from pywet.products.deck import Deck
from pywet.products.feed import LEFT_OUT, entry_names, shares_left_out
from pywet.products.feed import sentence as feed_sentence
from pywet.products.outlets import out_of_reach, refuse_begins, refuse_skipped, refuse_thin, with_reach
from pywet.runs.rundir import placed
from pywet.util.file_list import remove
from pywet.util.files import write_json
from pywet.util.notices import notice

MARGIN_M = 0.010
"""Margin [m] between all bodies, over their whole motion, and the simulated box."""
SLOWEST = 0.1
"""Speed [m/s] of slow phases in the plan, and the smallest for Hertz contacts: bridges still draw spheres at rest together."""
TOUCHING = 1.0 - 1e-6
"""Fraction of the touching distance below which two bodies overlap at the start."""


@dataclass(frozen=True)
class Building:
    """Scene built from a description; each part is made when it is first used."""

    user_scene: Scene
    """The description, with all positions relative to the origin."""
    origin_mm: typed.Vector = (0.0, 0.0, 0.0)
    """Origin of the description, which is added to positions in messages."""
    deck: Deck | None = None
    """Deck of the description, of which `user_scene` has the walls and outlets."""

    def __post_init__(self) -> None:
        origin = origin_of(self.user_scene)
        object.__setattr__(self, "origin_mm", origin)
        object.__setattr__(self, "deck", self.user_scene.deck)
        object.__setattr__(
            self, "user_scene", from_origin(self.user_scene.model_copy(update={"origin_mm": origin}).in_full())
        )

    @cached_property
    def classes(self) -> tuple[typed.SphereClass, ...]:
        """One class for each entry of `spheres`, in its order."""
        counts = {a.name: a.count for a in self.amounts}
        return tuple(
            _sphere_class(k, s, self.user_scene, counts.get(s.name))
            for k, s in enumerate(self.user_scene.spheres, start=1)
        )

    @cached_property
    def amounts(self) -> tuple[Amount, ...]:
        """Requested and simulated masses of entries with `mass_g`; those of one material and region are distributed together."""
        groups: dict[Any, list[Spheres]] = defaultdict(list)
        for s in self.user_scene.spheres:
            if s.mass_g is not None:
                groups[s.material, s.box or s.cylinder, s.insertion].append(s)
        return tuple(
            amount
            for group in groups.values()
            for amount in whole_amounts(
                [s.name for s in group], [1e-3 * (s.mass_g or 0.0) for s in group],
                [_sphere_kg(s, self.user_scene) for s in group], f"scene {self.user_scene.name}",
            )
        )  # fmt: skip

    @cached_property
    def pairs(self) -> tuple[typed.ContactPair, ...]:
        """Dry contacts of all classes with each other and with the walls."""
        kinds = range(1, len(self.classes) + 1)
        given = tuple(self._pair(a, b) for a in kinds for b in (0, *range(a, len(self.classes) + 1)))
        return bodies.hertzian(self.classes, given, self.hertz) if self.hertz else given

    @cached_property
    def hertz(self) -> Hertz | None:
        """Moduli of classes and walls, and the impact speed used for planning; None for linear springs."""
        if self.user_scene.contact == "linear":
            return None
        found = []
        for name in (*(s.material for s in self.user_scene.spheres), self.user_scene.material_of_walls):
            material = self.user_scene.materials[name]
            assert material.youngs_modulus_Pa is not None and material.poissons_ratio is not None  # else refused
            found.append(Elastic(youngs_modulus_Pa=material.youngs_modulus_Pa, poissons_ratio=material.poissons_ratio))
        return Hertz(spheres=tuple(found[:-1]), walls=found[-1], impact_speed_m_per_s=max(SLOWEST, self.speed))

    def _pair(self, a: int, b: int) -> typed.ContactPair:
        spheres = self.user_scene.spheres
        dry = self.user_scene.dry(spheres[a - 1].material, spheres[b - 1].material if b else WALLS)
        assert dry is not None  # scenes without contact data are rejected on reading
        other = self.classes[b - 1].radius_m if b else math.inf
        return bodies.contact(
            a, b, dry.stiffness_N_per_m, friction=dry.friction, restitution=dry.restitution,
            rolling_m=dry.rolling_m(reduced_radius(self.classes[a - 1].radius_m, other)),
        )  # fmt: skip

    @cached_property
    def thickness(self) -> tuple[float, ...]:
        """Thickness of the first film on each class [m]."""
        liquid = self.user_scene.liquid
        if liquid is None:
            return (0.0,) * len(self.classes)
        common = [
            c
            for c, s in zip(self.classes, self.user_scene.spheres, strict=True)
            if s.percent is None and s.film_um is None
        ]
        of_all = _film(common, liquid.percent, liquid.film_um, liquid.density_kg_per_m3) if common else 0.0
        return tuple(
            of_all if c in common else _film([c], s.percent, s.film_um, liquid.density_kg_per_m3)
            for c, s in zip(self.classes, self.user_scene.spheres, strict=True)
        )

    @cached_property
    def liquid(self) -> typed.Liquid | None:
        """The liquid, with the thickest film: what the neighbour list must allow for."""
        liquid = self.user_scene.liquid
        if liquid is None or not any(self.thickness):
            return None
        return typed.Liquid(
            surface_tension_N_per_m=liquid.surface_tension_N_per_m, viscosity_Pa_s=liquid.viscosity_Pa_s,
            density_kg_per_m3=liquid.density_kg_per_m3, initial_film_thickness_m=max(self.thickness),
        )  # fmt: skip

    @cached_property
    def surfaces(self) -> tuple[Surface, ...]:
        """Surfaces of all walls, in the order of the scene."""
        found = tuple(wall.surface(self.user_scene.folder) for wall in self.user_scene.walls)
        for wall, surface in zip(self.user_scene.walls, found, strict=True):
            ask_unit(wall, surface, [2.0 * s.radius_m for s in self.user_scene.spheres])
            mention_bars(wall, surface)
            mention_crossing(wall, surface)
        return tuple(
            repeating.continued(self.user_scene, wall.name, surface, wall.motion_parameters(surface.vertices))
            for wall, surface in zip(self.user_scene.walls, found, strict=True)
        )

    @cached_property
    def motions(self) -> tuple[EngineMotion | None, ...]:
        """Motion of each wall, in the order of the scene."""
        return tuple(w.motion_parameters(s.vertices) for w, s in zip(self.user_scene.walls, self.surfaces, strict=True))

    @cached_property
    def spheres(self) -> pd.DataFrame:
        """id, type, position, velocity and film of every sphere at the start; overlaps are refused."""
        table = _first_places(self)
        repeating.refuse_beyond(self.user_scene, table)
        films = [film_volume(h, c.radius_m) for h, c in zip(self.thickness, self.classes, strict=True)]
        table["film"] = table["type"].map(dict(enumerate(films, start=1)))
        refuse_far(self.user_scene, [self._there(table)[[*"xyz"]].to_numpy(), *(s.vertices for s in self.surfaces)])
        _refuse_overlaps(self, table)
        return table

    def _there(self, table: pd.DataFrame) -> pd.DataFrame:
        """Select the spheres that the engine may hold from the start."""
        return table[self._insertion_s(table) <= (self.ahead_s or math.inf)]

    def _insertion_s(self, table: pd.DataFrame) -> Floats:
        """Return the time [s] at which each sphere is inserted; 0: present from the start."""
        at = np.zeros(len(table))
        for c in self.classes:
            at[table["type"] == c.type] = times(c) or 0.0
        return at

    @cached_property
    def ahead_s(self) -> float | None:
        """Time [s] before its insertion at which the engine creates a sphere; None: all exist from the start."""
        return ahead_s(self.user_scene, self.classes, self.wall_speed)

    @cached_property
    def extent(self) -> tuple[Floats, Floats]:
        """Corners of a box around all spheres at the start, their paths until they enter, and all walls wherever they move."""
        corners = [self._there(self.spheres)[[*"xyz"]].to_numpy(), ways(self.classes, self.spheres, self.ahead_s)[0]]
        for surface, motion in zip(self.surfaces, self.motions, strict=True):
            corners += [surface.vertices, *extent.moved(surface.vertices, motion, self.user_scene.duration_s)]
        margin = MARGIN_M + 2.0 * max(c.radius_m for c in self.classes)
        everything = np.concatenate(corners)
        return everything.min(axis=0) - margin, everything.max(axis=0) + margin

    @cached_property
    def wall_speed(self) -> float:
        """Largest speed of any wall [m/s]."""
        return max([0.0, *(extent.speed(s.vertices, m) for s, m in zip(self.surfaces, self.motions, strict=True))])

    @cached_property
    def box(self) -> tuple[Floats, Floats]:
        """Return the corners of the simulated region: its extent and space for spheres that walls or outlets displace."""
        scene, cell = self.user_scene, 2.0 * max(c.radius_m for c in self.classes)
        low, high = with_reach(
            self.outlets, *self.extent, self.speed, scene.gravity_m_per_s2, scene.results.interval_s, self._sway
        )
        extent.refuse_vast(scene.name, low, high, cell)
        below, above = extent.thrown(self.wall_speed, scene.gravity_m_per_s2, scene.duration_s)
        if scene.periodic is not None:
            k = repeating.axis_of(scene.periodic)
            low[k], high[k] = repeating.faces_m(scene.periodic)
            below[k] = above[k] = 0.0
        return extent.with_margin(low, high, below, above, cell)

    @cached_property
    def outlets(self) -> tuple[typed.Outlet, ...]:
        """Regions in which spheres are removed; one too thin for the fastest sphere or with a first position in it is refused."""
        scene = self.user_scene
        refuse_thin(scene.name, scene.outlets, self.speed, scene.gravity_m_per_s2, scene.results.interval_s)
        found = tuple(outlet.region({wall.name: wall.word for wall in scene.walls}) for outlet in scene.outlets)
        refuse_begins(scene.name, found, self._released, self.origin_mm)
        return found

    @property
    def _sway(self) -> list[float]:
        """Return the largest displacements along x, y, z of walls with which outlets move [m]."""
        with_them = {outlet.moves_with for outlet in self.user_scene.outlets}
        found = [
            [2.0 * a for a in motion.amplitude_m]
            for wall, motion in zip(self.user_scene.walls, self.motions, strict=True)
            if wall.name in with_them and isinstance(motion, typed.Vibration)
        ]
        return np.max([[0.0] * 3, *found], axis=0).tolist()

    @property
    def speed(self) -> float:
        """Largest speed of approach [m/s]: of the walls, or of a sphere that was thrown and falls through the scene."""
        heights = np.concatenate([self._released, *(s.vertices for s in self.surfaces)]) @ np.array(
            self.user_scene.gravity_m_per_s2
        )
        fall = math.sqrt(2.0 * float(np.ptp(heights)))
        thrown = float(np.linalg.norm(self.spheres[["vx", "vy", "vz"]].to_numpy(), axis=1).max())
        return max(self.wall_speed, math.hypot(fall, thrown))

    @property
    def _released(self) -> Floats:
        """Return the positions [m] at which gravity begins to act on the spheres: at the start, or on insertion."""
        at = self._insertion_s(self.spheres)
        return np.asarray(self.spheres[[*"xyz"]].to_numpy() + at[:, None] * self.spheres[["vx", "vy", "vz"]].to_numpy())

    @cached_property
    def plan(self) -> EffectPlan:
        """Plan of the effects of the scene, with reasons."""
        user_scene = self.user_scene
        around = Surroundings(
            gravity_m_per_s2=math.hypot(*user_scene.gravity_m_per_s2), duration_s=user_scene.duration_s,
            slow_m_per_s=SLOWEST, films_m=dict(enumerate(self.thickness, start=1)),
        )  # fmt: skip
        laws = placed_laws(user_scene.laws, user_scene.folder, user_scene.file is None)
        chosen = plan_effects(self.classes, self.pairs, self.liquid, self.speed, user_scene.effects, laws, around)
        lines = user_scene.from_materials
        if self.hertz is None:
            return replace(chosen, amounts=self.amounts, contact=lines)
        # friction of this model is a tangential spring
        effects = chosen.effects.model_copy(update={"tangential_history": True})
        lines += hertz_lines(self.classes, self.pairs, self.hertz, self.time_step)
        return replace(chosen, amounts=self.amounts, effects=effects, contact=lines)

    @property
    def interval(self) -> float:
        """Default time between outputs [s]: a fiftieth of the duration, with outlets at most `OUTLET_EVERY_S`."""
        scene = self.user_scene
        return min(scene.duration_s / 50.0, OUTLET_EVERY_S if scene.outlets else math.inf)

    @property
    def warnings(self) -> list[str]:
        """Return warnings for an amount of liquid and motions without effect, and spheres that may pass through walls."""
        found, liquid = [], self.user_scene.liquid
        amount = next((n for n in ("percent", "film_um") if getattr(liquid, n, None) is not None), None)
        if amount and all(s.percent is not None or s.film_um is not None for s in self.user_scene.spheres):
            found.append(
                f"liquid.{amount} has no effect: all spheres have their own amount, those of a feed moisture_percent"
            )
        end = self.user_scene.duration_s
        for wall, motion in zip(self.user_scene.walls, self.motions, strict=True):
            if isinstance(motion, typed.Slide) and motion.opens_at_s >= end:
                found.append(
                    f"wall {wall.name} does not move: it would from {motion.opens_at_s:g} s on, and the run ends at {end:g} s"
                )
        corners = {w.name: s.vertices for w, s in zip(self.user_scene.walls, self.surfaces, strict=True)}
        found += out_of_reach(self.outlets, corners, max(c.radius_m for c in self.classes))
        for wall, surface in zip(self.user_scene.walls, self.surfaces, strict=True):
            thick = thickness(surface.corners)
            for c, pair in [(c, p) for c in self.classes for p in self.pairs if (p.a, p.b) == (c.type, 0)]:
                deep = expected(self.speed, c.mass_kg, pair.normal_stiffness_N_per_m)
                if deep > PRESSED * thick:
                    least = f"stiffness_N_per_m {(self.speed / (PRESSED * thick)) ** 2 * c.mass_kg:.2g}"
                    if self.hertz:  # the overlap scales with the modulus to the power -2/5
                        least = f"{(deep / (PRESSED * thick)) ** 2.5:.2g} times youngs_modulus_Pa of both"
                    found.append(
                        f"{c.name} at up to {self.speed:.2g} m/s may overlap wall {wall.name} by {1e3 * deep:.2g} mm, and the "
                        f"wall is {1e3 * thick:.2g} mm thick: a sphere pressed through it comes out at its far side; from "
                        f"{least} on it does not, nor with a thicker wall"
                    )
        return found

    @property
    def time_step(self) -> float:
        """Return the time step [s]: the given one, or a share of the stable step of a packing."""
        how, liquid = self.user_scene.time_step, self.liquid
        drag = liquid.viscosity_Pa_s if liquid and how.viscous_integration == "explicit" else 0.0
        return how.time_step_s or step_choice.of_packing(self.classes, self.pairs, how.share, drag, self.hertz)

    def scene(self, blocks: int | None = None) -> typed.EngineScene:
        """Return the engine-neutral scene; `blocks`: number of blocks of a run with `until`, by default the minimum."""
        user_scene, (low, high), effects = self.user_scene, self.box, self.plan.effects
        how = user_scene.time_step.viscous_integration
        refuse_nonlinear_drag(effects, how, "time_step.viscous_integration", f"scene {user_scene.name}")
        given: dict[str, Any] = {
            "name": user_scene.name,
            "seed": user_scene.seed,
            "classes": self.classes,
            "pairs": self.pairs,
            "hertz": self.hertz,
            "liquid": self.liquid,
            "walls": tuple(
                wall_mesh(s, math.radians(user_scene.wall_angle_deg(w))).model_copy(
                    update={"motion_parameters": motion, "feature_angle_deg": w.fold_deg}
                )
                for s, w, motion in zip(self.surfaces, user_scene.walls, self.motions, strict=True)
            ),
            "vibration": None,
            "slide": None,
            "effects": effects,
            "viscous_integration": how,
            "gravity_m_per_s2": user_scene.gravity_m_per_s2 if effects.gravity else (0.0, 0.0, 0.0),
            "box_low_m": tuple(low.tolist()),
            "box_high_m": tuple(high.tolist()),
            **({"periodic": user_scene.periodic.axis, "contacts": "batched"} if user_scene.periodic else {}),
            "spheres_file": Path("spheres.parquet"),
            "time_step_s": self.time_step,
            "duration_s": user_scene.duration_s,
            "output": typed.Output(
                interval_s=user_scene.results.interval_s or self.interval,
                contact_windows=user_scene.results.windows,
                contact_window_steps=user_scene.results.window_steps,
                checkpoints=user_scene.results.checkpoints,
                window_trajectories=user_scene.results.windows > 0,
                energy=not user_scene.outlets and user_scene.periodic is None,
            ),
            "outlets": self.outlets,
            "created_ahead_s": self.ahead_s,
            "bin_z_m": float(low[2]),
        }
        try:
            scene = typed.EngineScene(**given)
        except ValidationError as error:
            raise mistake(error, typed.EngineScene, f"scene {self.user_scene.name}") from error
        repeating.refuse_short(user_scene, 2.0 * max(c.radius_m for c in self.classes) + listed(scene) + skin(scene))
        if user_scene.until:
            return until.in_blocks(scene, user_scene.until, blocks)
        refuse_skipped(scene)
        return scene


def write(
    user_scene: Scene, run_dir: Path, blocks: int | None = None, begin: Callable[[], object] = lambda: None
) -> typed.EngineScene:
    """Write the run directory of a description: scene, plan, first spheres and films, surfaces; returns the scene.

    `blocks`: number of blocks simulated so far in a run with `until`; `begin` is called when all is built, before anything
    is written.
    """
    made, run_dir = Building(user_scene), Path(run_dir)
    scene = made.scene(blocks)
    for sentence in (*made.warnings, *early_end(scene)):
        notice.warning("%s: %s", user_scene.name, sentence)
    for sentence in feeds(user_scene, made.classes):
        notice.warning("%s", sentence)
    if any(made.origin_mm):
        notice.warning("%s: %s", user_scene.name, COUNT_FROM.format(*made.origin_mm))
    begin()
    write_initial(scene, made.surfaces, made.spheres, run_dir)
    write_json(run_dir / "plan.json", made.plan.as_dict())
    left_out = {feed.name: shares_left_out(feed.psd.sizes(user_scene.folder)) for feed in user_scene.feed}
    more = {"origin_mm": made.origin_mm, **({LEFT_OUT: left_out} if left_out else {})}
    write_json(run_dir / "description.json", user_scene.model_dump(mode="json") | more)
    remove(run_dir, "config.json")  # left by a screening case that was built here before
    return scene


def feeds(user_scene: Scene, classes: Sequence[typed.SphereClass]) -> list[str]:
    """Describe each feed of a scene: number and sizes of spheres, their liquid, mass left out."""
    found = []
    for feed in user_scene.feed:
        sizes = feed.psd.sizes(user_scene.folder)
        count = sum(c.count for c in classes if c.name in {*entry_names(feed.name, sizes)})
        found.append(feed_sentence(feed.name, sizes, count, feed.dry_percent))
    return found


def _sphere_kg(spheres: Spheres, user_scene: Scene) -> float:
    """Mass of one sphere of an entry [kg]."""
    return user_scene.materials[spheres.material].density_kg_per_m3 * 4.0 / 3.0 * math.pi * spheres.radius_m**3


def _sphere_class(kind: int, spheres: Spheres, user_scene: Scene, of_mass: int | None) -> typed.SphereClass:
    """Return the size class of an entry; `of_mass`: number of spheres computed from its mass."""
    material, given = user_scene.materials[spheres.material], spheres.insertion
    angle = SPHERE_ANGLE_DEG if material.contact_angle_deg is None else material.contact_angle_deg
    return typed.SphereClass(
        name=spheres.name, type=kind, radius_m=spheres.radius_m, density_kg_per_m3=material.density_kg_per_m3,
        contact_angle_rad=math.radians(angle),
        count=of_mass or spheres.count or len(spheres.at_mm or ()),
        insertion=typed.Insertion(**given.model_dump(exclude_none=True, exclude={"unusual"})) if given else None,
    )  # fmt: skip


def _film(classes: list[typed.SphereClass], percent: float | None, film_um: float | None, density: float) -> float:
    """Thickness [m] of the same film on all spheres of these classes."""
    if film_um is not None:
        refuse_too_thin(1e-6 * film_um, classes)
        return 1e-6 * film_um
    return common_film_thickness(classes, liquid_volume(classes, percent or 0.0, density))


def _first_places(made: Building) -> pd.DataFrame:
    """Return id, type, x to wz of every sphere: random positions per region, given positions, and inserted spheres waiting."""
    regions: dict[Any, list[typed.SphereClass]] = defaultdict(list)
    tables = []
    for sphere, entry in zip(made.classes, made.user_scene.spheres, strict=True):
        if entry.at_mm is not None:
            at = 1e-3 * np.array(entry.at_mm)
            tables.append(pd.DataFrame({"type": sphere.type, "x": at[:, 0], "y": at[:, 1], "z": at[:, 2]}))
        elif entry.insertion is None:
            regions[entry.box or entry.cylinder].append(sphere)
    for number, (shape, inside) in enumerate(regions.items()):
        tables.append(fill(inside, shape.region(), [made.user_scene.seed, number]))
    tables.append(waiting(made.classes, made.user_scene.spheres, made.thickness, made.user_scene.seed, made.ahead_s))
    table = pd.concat(tables, ignore_index=True)[["type", *"xyz"]].astype({"type": np.int64})
    table.insert(0, "id", np.arange(1, len(table) + 1))
    thrown = np.array([s.velocity_m_per_s for s in made.user_scene.spheres])[table["type"].to_numpy() - 1]
    table[["vx", "vy", "vz"]], table[["wx", "wy", "wz"]] = thrown, 0.0
    return table


def _refuse_overlaps(made: Building, table: pd.DataFrame) -> None:
    """Refuse spheres that overlap each other or a wall at the start."""
    there = made._there(table)
    at, kind = there[[*"xyz"]].to_numpy(), there["type"].to_numpy() - 1
    radius = np.array([c.radius_m for c in made.classes])[kind]
    names = [c.name for c in made.classes]
    low, period = repeating.period_m(made.user_scene)
    close = periodic.near_pairs(at, 2.0 * radius.max(), low, period)
    away = periodic.nearest(at[close[:, 0]] - at[close[:, 1]], period)
    gap = np.linalg.norm(away, axis=1) - TOUCHING * radius[close].sum(axis=1)
    if (gap < 0.0).any():
        a, b = close[int(np.argmin(gap))]
        raise ConfigError(
            f"scene {made.user_scene.name}: {int((gap < 0).sum())} pairs of spheres overlap at the start, such as one of "
            f"{names[kind[a]]} and one of {names[kind[b]]}; expected no overlap: fix their regions or positions",
            code="scene.overlap",
            key="spheres",
            given=int((gap < 0).sum()),
            expected=0,
        )
    import pyvista as pv

    on_way, size = ways(made.classes, table, made.ahead_s)
    at, radius = np.concatenate([at, on_way]), np.concatenate([radius, size])
    copies = periodic.copies(at, period)
    for wall, surface in zip(made.user_scene.walls, made.surfaces, strict=True):
        faces = np.insert(surface.triangles, 0, 3, axis=1).ravel()
        solid = pv.PolyData(surface.vertices, faces)
        distance = pv.PolyData(copies.reshape(-1, 3)).compute_implicit_distance(solid)["implicit_distance"]
        distance = np.array(distance).reshape(len(copies), -1)
        distance[1:] = np.abs(
            distance[1:]
        )  # the wall ends at the faces: no copy is inside, and an open end has no inside
        inside = distance.min(axis=0) < TOUCHING * radius
        if inside.any():
            first = placed(at[inside][0], made.origin_mm)
            raise ConfigError(
                f"scene {made.user_scene.name}: {_some(int(inside[: len(there)].sum()))} begin in wall {wall.name}, such as at "
                f"{first} mm; expected all outside: fix the region or the wall",
                code="scene.in_wall",
                key=f"walls.{wall.name}",
                expected="all outside",
            )


def _some(spheres: int) -> str:
    return f"{spheres} spheres" if spheres else "the paths of spheres that are inserted"
