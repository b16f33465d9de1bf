"""Description of a user-defined scene: materials, spheres, liquid, walls, motions. `pywet run-scene` reads the same keys.

Lengths in mm, angles in degrees, all else in SI units, as the keys say. `building.py` builds the engine's scene from it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, ValidationError, model_validator

from pywet.cases.custom.materials import STIFFNESS, Contact, Dry, Liquid, Material
from pywet.cases.custom.spheres import Feed, Spheres, derived
from pywet.cases.custom.walls import Wall
from pywet.config.entries import Excusable, doubled, only
from pywet.config.messages import mistake
from pywet.config.settings import EffectSettings, LawSettings
from pywet.engines.schedule import OUTLET_EVERY_S
from pywet.errors import ConfigError
from pywet.laws.hertz import LEAST_RESTITUTION
from pywet.products.deck import Deck
from pywet.products.outlets import Outlet
from pywet.products.until import Until
from pywet.scene import Across, Positive, Title, Vector
from pywet.schema import column

WALLS = "walls"
"""Name of all walls in a contact; walls are one material in the engine."""
PRESET = {"tolerance": {"value": 0.01, "source": "assumption", "reason": "one per cent of the larger"}}
ROUNDED_M_PER_S2 = 1e-3
"""Rounding of a gravity that is given together with the inclination of a deck."""
SPHERE_ANGLE_DEG, WALL_ANGLE_DEG = 15.0, 40.0
"""Contact angles of spheres and of walls if none is given."""


class Periodic(Excusable):
    """Periodic boundary along one axis: spheres that leave at one face enter at the other; contacts and bridges cross it."""

    axis: Across
    """Axis along which the scene is periodic."""
    low_mm: float
    """Position of its lower face."""
    high_mm: float
    """Position of its upper face."""

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.low_mm < self.high_mm:
            raise ValueError(f"periodic: low_mm below high_mm ({self.low_mm:g} is not below {self.high_mm:g})")
        return self


class TimeStep(Excusable):
    """`time_step_s`, or a share of the largest stable step of a dense packing."""

    time_step_s: Positive | None = None
    """Time step; refused if it exceeds a stability limit."""
    share: Annotated[float, Field(gt=0, le=1)] = 0.1
    """Time step as a share of the largest stable step of a dense packing."""
    viscous_integration: Annotated[str, Field(pattern="^(explicit|semi_implicit)$")] = "semi_implicit"
    """Integration of the viscous force: explicit, or semi_implicit, which does not shorten the time step."""

    @model_validator(mode="after")
    def _one_step(self) -> Self:
        only(self, "without time_step_s", self.time_step_s is None, "share")
        return self


class Results(Excusable):
    """Interval at which results are written, and sampling windows in which every contact is recorded for the replay."""

    interval_s: Positive | None = None
    """Interval between outputs; by default a fiftieth of the duration, at most 0.02 s with outlets."""
    windows: Annotated[int, Field(ge=0, le=1000)] = 20
    """Number of sampling windows; 0: forces and motion are not replayed."""
    window_steps: Annotated[int, Field(ge=1, le=100_000)] = 2
    """Steps per window; windows of up to 4 steps are at random times."""
    checkpoints: Annotated[int, Field(ge=0, le=1000)] = 10
    """Number of times the state is saved, evenly spaced; a killed run resumes from the last one."""

    @model_validator(mode="after")
    def _has_windows(self) -> Self:
        only(self, "with windows", self.windows > 0, "window_steps")
        return self


class Scene(Excusable):
    """User-defined scene: `pywet.run(scene, folder)` simulates it, `pywet.plan(scene)` lists the effects it calls for.

    Mistakes raise one `pywet.errors.ConfigError`, with a sentence for each.
    """

    name: Title
    """Name of the scene, on one line."""
    duration_s: Positive
    """Simulated time."""
    materials: dict[str, Material]
    """Properties of each material by its name."""
    contact: Literal["linear", "hertz"] = "linear"
    """Dry contact law: linear springs (`stiffness_N_per_m`), or Hertz–Mindlin (`youngs_modulus_Pa`, `poissons_ratio`)."""
    contacts: tuple[Contact, ...] = ()
    """Dry contacts between two materials, or between one and `walls`; keys that are not given are those of both materials."""
    wall_material: str | None = None
    """Material of all walls, a key of `materials`; required with the contact law `hertz` and spheres of several materials."""
    spheres: tuple[Spheres, ...] = ()
    """Size classes of spheres."""
    feed: tuple[Feed, ...] = ()
    """Materials with a size distribution, in place of or in addition to `spheres`."""
    liquid: Liquid | None = None
    """Liquid of the scene; None for a dry scene."""
    walls: tuple[Wall, ...] = ()
    """Walls, each with its own motion."""
    deck: Deck | None = None
    """A vibrating deck: its walls, outlets and the direction of gravity follow from a few numbers."""
    outlets: tuple[Outlet, ...] = ()
    """Regions in which spheres leave the run, with their films; none: a sphere that leaves the box stops the run."""
    periodic: Periodic | None = None
    """Periodic boundary along an axis; a periodic deck repeats across its width."""
    gravity_m_per_s2: Vector = (0.0, 0.0, -9.81)
    """Gravitational acceleration; 0, 0, 0 for none."""
    origin_mm: Vector = (0.0, 0.0, 0.0)
    """Origin of the engine's coordinates, for plant coordinates; `pywet.load` and `vtk/` return the scene's own coordinates."""
    seed: Annotated[int, Field(ge=0, lt=2**32)] = 1
    """Seed of the random positions; another seed gives another packing of the same scene."""
    laws: LawSettings = LawSettings()
    """Preset of force laws, or a law by kind."""
    effects: EffectSettings = EffectSettings.model_validate(PRESET)
    """Which effects are simulated, and the tolerance that decides."""
    time_step: TimeStep = TimeStep()
    """Time step; by default a tenth of the largest stable step."""
    results: Results = Results()
    """Outputs, sampling windows, checkpoints."""
    until: Until | None = None
    """Criterion to end the run once the partition is known well enough, at the latest after `duration_s`."""
    folder: Path = Path()
    """Folder in which STL files and law files are looked up; for a scene read from YAML, the folder of that file."""
    file: Path | None = None
    """File from which the scene was read."""

    def __init__(self, **given: Any) -> None:
        try:
            super().__init__(**given)
        except ValidationError as error:
            where = str(given.get("file") or f"scene {given.get('name') or ''}".strip())
            raise mistake(error, Scene, where, given) from error

    def with_(self, **changes: Any) -> Self:
        """Return a copy of the scene with other values of some keys, checked like a new scene.

        `scene.with_(liquid=pywet.Liquid(percent=7), seed=2)`.
        """
        given = {name: getattr(self, name) for name in self.model_fields_set}
        return type(self)(**{**given, **changes})

    def files(self) -> list[Path]:
        """Return the paths of the files that the scene's keys name: STL files and sieve analyses, not those of laws."""
        return [self.folder / path for path in _paths(self.model_dump(exclude={"folder", "file"}))]

    def __setattr__(self, name: str, value: Any) -> None:
        raise ConfigError(
            f"scene {self.name}: {name} cannot be set, since a scene is immutable; make a new one: "
            f"scene.with_({name}=…)",
            code="scene.frozen",
            key=name,
        )

    @model_validator(mode="before")
    @classmethod
    def _with_tolerance(cls, given: Any) -> Any:
        """Complete `effects` of which only some are given."""
        effects = given.get("effects") if isinstance(given, dict) else None
        return {**given, "effects": {**PRESET, **effects}} if isinstance(effects, dict) else given

    @model_validator(mode="after")
    def _names(self) -> Self:
        if not self.spheres and not self.feed:
            raise ValueError("spheres, or a feed")
        wrong: list[str] = []
        for key in ("spheres", "feed", "walls", "outlets"):
            wrong += doubled(f"{key} of different names", (entry.name for entry in getattr(self, key)))
        wrong += _alike("spheres", [s.name for s in self.spheres]) + _alike("feed", [f.name for f in self.feed])
        if self.periodic and self.deck and self.deck.periodic:
            wrong.append("no periodic together with a deck with periodic: true")
        wrong += self._wrong_gravity()
        if (self.outlets or self.deck) and self.results.checkpoints == 0:
            wrong.append("results.checkpoints of at least 1 together with outlets: spheres leave at checkpoints")
        if (interval := self.results.interval_s or 0.0) > self.duration_s:
            wrong.append(f"results.interval_s of at most duration_s, {self.duration_s:g} s, not {interval:g}")
        if self.deck and interval > OUTLET_EVERY_S:
            wrong.append(
                f"results.interval_s of at most {OUTLET_EVERY_S:g} with a deck, whose spheres leave at outputs"
            )
        known = ", ".join(self.materials) or "none"
        named = [(f"spheres {s.name}", s.material) for s in self.spheres]
        named += [(f"feed {f.name}", f.material) for f in self.feed]
        named += [("contacts", m) for c in self.contacts for m in sorted({*c.between} - {WALLS} or {WALLS})]
        named += [("wall_material", self.wall_material)] if self.wall_material is not None else []
        wrong += [f"{where} to name a material ({known}), not {m}" for where, m in named if m not in self.materials]
        wrong += self._wrong_contacts()
        late = [s.name for s in self.spheres if s.insertion and s.insertion.end_s > self.duration_s]
        wrong += [f"spheres {name} to be inserted before the end, duration_s ({self.duration_s:g})" for name in late]
        wet = [x for s in self.spheres for x in (s.percent, s.film_um)] + [f.moisture_percent for f in self.feed]
        if self.liquid is None and any(wet):
            wrong.append("the key liquid, as spheres have some")
        if self.liquid and all(x is None for x in (*wet, self.liquid.percent, self.liquid.film_um)):
            wrong.append(
                "an amount of liquid: percent or film_um of liquid or spheres, moisture_percent of a feed (0: none)"
            )
        wrong += self._wrong_stiffness() + self._wrong_until() + self._wrong_outlets()
        if wrong:
            raise ValueError("; ".join(wrong))
        return self

    def _wrong_gravity(self) -> list[str]:
        """List a gravity that is not that of the deck's inclination."""
        if self.deck is None or not self.deck.inclination_deg or "gravity_m_per_s2" not in self.model_fields_set:
            return []
        made = self.deck.gravity
        if max(abs(a - b) for a, b in zip(self.gravity_m_per_s2, made, strict=True)) < ROUNDED_M_PER_S2:
            return []
        x, y, z = (f"{g:.4g}" for g in made)
        return [
            f"no gravity_m_per_s2 with deck.inclination_deg {self.deck.inclination_deg:g}, which makes it ({x}, {y}, {z})"
        ]

    def _wrong_outlets(self) -> list[str]:
        """List outlets that move with a wall that does not vibrate; those of a deck are known once it is written out."""
        shaken = [wall.name for wall in self.walls if wall.vibrates]
        return [
            f"outlet {o.name}: moves_with to name a wall that vibrates ({', '.join(shaken) or 'none'}), not {o.moves_with}"
            for o in self.outlets if o.moves_with is not None and o.moves_with not in shaken and self.deck is None
        ]  # fmt: skip

    def _wrong_contacts(self) -> list[str]:
        """List dry contacts that are given twice or not at all."""
        used = {*self._of_spheres} & self.materials.keys()
        alone = {} if self.wall_material in used else {self.wall_material: WALLS}  # a material that only walls have
        pairs = (sorted(alone.get(m, m) for m in c.between) for c in self.contacts)
        found = doubled("contacts of different pairs", map(" and ".join, pairs))
        if WALLS in self.materials:
            found.append(f"materials of other names than {WALLS}, by which contacts mean all walls")
        walls = {m for m in self.materials if m == self.wall_material}
        met = {(a, b): self.dry(a, b if b in used else WALLS) for a in used for b in used | walls if a != b}
        missing = sorted({(min(pair), max(pair)) for pair, dry in met.items() if dry is None})
        for contact in self.contacts:
            if keys := contact.differing(*self._materials_of(contact)):
                found.append(
                    f"{' and '.join(keys)} in contacts between {' and '.join(contact.between)}, whose own values differ"
                )
        return found + [f"an entry in contacts with between: [{a}, {b}]" for a, b in missing]

    def _wrong_until(self) -> list[str]:
        """List what is missing for a run that ends with a known partition."""
        if self.until is None:
            return []
        found = []
        if not self.outlets and self.deck is None:
            found.append("until together with a deck or with outlets, by which spheres are counted")
        given = [*(s.insertion for s in self.spheres), *(f.insertion for f in self.feed)]
        inserted = [one for one in given if one]
        if not inserted:
            found.append("until together with spheres that are inserted during the run, or a feed with an insertion")
        ends = [one.end_s for one in inserted]
        if ends and min(ends) < self.duration_s * (1.0 - 1e-9):
            found.append(
                f"until with an insertion up to duration_s, {self.duration_s:g} s, the longest run, not to {min(ends):g} s"
            )
        if (self.until.from_s or 0.0) >= self.duration_s:
            found.append(f"until.from_s below duration_s, {self.duration_s:g} s, not {self.until.from_s:g}")
        return found

    def _wrong_stiffness(self) -> list[str]:
        """List keys that belong to the other contact law, and keys that Hertz contacts require."""
        of: list[tuple[str, Dry | Contact]] = [(f"materials.{name}", m) for name, m in self.materials.items()]
        of += [(f"contacts between {' and '.join(c.between)}", c) for c in self.contacts]
        elastic = ("youngs_modulus_Pa", "poissons_ratio")
        if self.contact == "linear":
            given = [f"{where}.{key}" for where, m in of for key in elastic if key in m.model_fields_set]
            return [f"contact: hertz for {key}; linear springs have stiffness_N_per_m" for key in given]
        found = [
            f"no stiffness_N_per_m of {where} with contact: hertz, which has youngs_modulus_Pa and poissons_ratio"
            for where, m in of if "stiffness_N_per_m" in m.model_fields_set
        ]  # fmt: skip
        found += [
            f"a restitution above {LEAST_RESTITUTION:g} of {where} with contact: hertz, not {m.restitution:g}"
            for where, m in of if m.restitution is not None and m.restitution <= LEAST_RESTITUTION
        ]  # fmt: skip
        if self.effects.tangential_history is False:
            found.append("effects.tangential_history on or auto with contact: hertz, whose friction is a spring")
        used = {*self._of_spheres}
        if (self.walls or self.deck) and self.wall_material is None and len(used) > 1:
            found.append(f"a wall_material (one of {', '.join(self.materials)}) with contact: hertz")
        needed = (used | {self.material_of_walls}) & self.materials.keys()
        return found + [
            f"{key} of materials.{name} with contact: hertz"
            for name in sorted(needed) for key in elastic if getattr(self.materials[name], key) is None
        ]  # fmt: skip

    @property
    def material_of_walls(self) -> str:
        """Return the key of the material of all walls: the given one, or that of the spheres."""
        return self.wall_material or self._of_spheres[0]

    def wall_angle_deg(self, wall: Wall) -> float:
        """Return the contact angle [deg] on a wall: its own, or that of `wall_material`."""
        of = self.materials[self.wall_material].contact_angle_deg if self.wall_material is not None else None
        given = wall.contact_angle_deg if wall.contact_angle_deg is not None else of
        return WALL_ANGLE_DEG if given is None else given

    @property
    def _of_spheres(self) -> list[str]:
        """Return the keys of the materials of spheres and feeds, in order."""
        return [s.material for s in self.spheres] + [f.material for f in self.feed]

    def in_full(self) -> Self:
        """Return a copy of the scene with its feeds and its deck written out as spheres, walls, outlets and gravity."""
        if not self.feed and self.deck is None:
            return self
        made = tuple(entry for feed in self.feed for entry in feed.spheres(self.folder)[0])
        changes: dict[str, Any] = {"spheres": (*self.spheres, *made), "feed": (), "deck": None}
        if deck := self.deck:
            changes["walls"] = (*(derived(Wall, wall, "deck") for wall in deck.walls()), *self.walls)
            changes["outlets"] = (*self.outlets, *(derived(Outlet, one, "deck") for one in deck.outlets()))
            if deck.periodic:
                changes["periodic"] = derived(Periodic, deck.strip, "deck")
            if deck.inclination_deg or "gravity_m_per_s2" not in self.model_fields_set:
                changes["gravity_m_per_s2"] = deck.gravity
        return self.with_(**changes)

    def dry(self, a: str, b: str) -> Dry | None:
        """Return the dry contact of two materials, or of one with `walls`; None if not given."""
        for other in (b, self.wall_material) if b == WALLS and self.wall_material else (b,):
            for contact in self.contacts:
                if sorted(contact.between) == sorted((a, other)):
                    return contact.of(self._materials_of(contact)[0])
        return self.materials[a] if a == ((self.wall_material or a) if b == WALLS else b) else None

    def _materials_of(self, contact: Contact) -> list[Material]:
        """Return the materials of an entry of `contacts`; walls have one if `wall_material` is given."""
        names = [self.wall_material if name == WALLS else name for name in contact.between]
        return [self.materials[name] for name in names if name in self.materials]

    @property
    def from_materials(self) -> tuple[str, ...]:
        """Describe the values that entries of `contacts` have from their materials, in one line each."""
        found = []
        for contact in self.contacts:
            taken = contact.taken(self._materials_of(contact)[0])
            values = [f"{key} {x:g}" for key, x in taken.items() if self.contact == "linear" or key != STIFFNESS]
            found += [f"contact {'–'.join(contact.between)}, as in materials: {', '.join(values)}"] if values else []
        return tuple(found)


def _alike(what: str, names: list[str]) -> list[str]:
    """Return a mistake if the columns of different names would have one name."""
    columns = {column("", name): name for name in names}
    twins = [(name, columns[column("", name)]) for name in names if columns[column("", name)] != name]
    return [
        f"{what} whose names differ in a to z or digits, of which columns have theirs ({a}, {b})" for a, b in twins[:1]
    ]


def _paths(value: Any) -> list[Path]:
    """Return all paths among the values of keys, in their order."""
    if isinstance(value, Path):
        return [value]
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, list | tuple) else ()
    return [path for part in parts for path in _paths(part)]
