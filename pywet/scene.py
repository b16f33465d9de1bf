"""Typed description of what is simulated: spheres, walls, liquid, motion and timing.

An `EngineScene` is complete (every number an engine needs, SI units, radians) and engine-neutral; it is independent
of cases, files, decks and engines. It is written to `scene.json` in every run directory and read from there.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from pywet.law_names import Laws
from pywet.laws.hertz import LEAST_RESTITUTION, Hertz
from pywet.laws.kinds import NEEDED
from pywet.strict import Computable
from pywet.util.files import read_model


def _title(text: str) -> str:
    """Validate a title, which also appears in comments of decks and in messages."""
    if not text or len(text) > 80 or not text.isprintable() or text != text.strip():
        raise ValueError("a name is one line of 1 to 80 printable characters without leading or trailing blanks")
    return text


def _inside(path: Path) -> Path:
    """Validate a path that an engine's script can contain and that is inside the run directory."""
    if path.is_absolute() or ".." in path.parts or not re.fullmatch(r"[A-Za-z0-9_./-]{1,200}", str(path)):
        raise ValueError("a path inside the run directory: letters, digits, _, - and . between slashes, no ..")
    return path


Title = Annotated[str, AfterValidator(_title)]
Word = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,39}$")]
"""Name of a folder or a file: letters, digits, _, - and ., not starting with a dot or a dash."""
IDENTIFIER = r"^[A-Za-z][A-Za-z0-9_]{0,39}$"
Identifier = Annotated[str, Field(pattern=IDENTIFIER)]
"""Name that is one word of an engine's script."""
Contacts = Literal["batched", "stock", "planes"]
Profile = Literal["constant", "ramp", "pulsed"]
Product = Literal["overs", "middlings", "lower_middlings", "unders"]
"""Products of a screen, from the coarsest to the finest.

One deck has overs and unders; middlings are the overs of a deck beneath.
"""
Inside = Annotated[Path, AfterValidator(_inside)]
Positive = Annotated[float, Field(gt=0)]
NonNegative = Annotated[float, Field(ge=0)]
Vector = tuple[float, float, float]
Across = Literal["x", "y"]
"""Axis along which a box may be periodic; not z, because ranks divide the box into columns."""
Bound = tuple[float | None, float | None, float | None]
Reservoir = Literal["wires", "side_wall", "feed_bin", "slide", "impact_plate", "outlet", "collecting_bin", "wall"]


class Insertion(Computable):
    """Insertion of the spheres of a class: one after the other in the order of their ids, at a rate over time."""

    from_s: NonNegative
    for_s: Positive
    profile: Profile = "constant"
    """Rate over time; a ramp rises from zero to twice the mean, pulses have equal length and mass."""
    pulses: Annotated[int, Field(ge=1)] = 1
    pulse_share: Annotated[float, Field(gt=0, le=1)] = 0.5
    """Fraction of a period during which a pulse inserts spheres."""

    def at(self, k: Any, count: int) -> Any:
        """Return the time [s] at which the k-th (from 0; a number or an array) of `count` spheres enters.

        >>> Insertion(from_s=0.0, for_s=2.0).at(1, 2), Insertion(from_s=0.0, for_s=2.0, profile="pulsed", pulses=2).at(2, 4)
        (1.5, 1.125)
        """
        if self.profile == "ramp":
            return self.from_s + self.for_s * np.sqrt((k + 0.5) / count)
        if self.profile == "pulsed":
            whole, part = divmod((k + 0.5) / count * self.pulses, 1.0)
            return self.from_s + self.for_s * (whole + self.pulse_share * part) / self.pulses
        return self.from_s + self.for_s * (k + 0.5) / count


class Outlet(Computable):
    """Region in which spheres leave the run, with their films: low <= centre < high along x, y, z, None: open."""

    name: Identifier
    low_m: Bound
    high_m: Bound
    crossing_above_m: float | None = None
    """Least height of a sphere's centre [m] at or after its crossing of the plane of the smallest x; None: any height."""
    moves_with: Identifier | None = None
    """Wall with whose vibration that plane and that height move from where they are at the start; None: they are at rest."""
    product: Product | None = None
    """Product of the screen that is collected here."""

    @property
    def ends(self) -> tuple[Vector, Vector]:
        """Return both corners [m], infinite if the region is open."""
        x, y, z = (-math.inf if v is None else v for v in self.low_m)
        a, b, c = (math.inf if v is None else v for v in self.high_m)
        return (x, y, z), (a, b, c)


class SphereClass(Computable):
    """One size class of spheres of one material; its `type` (1, 2, …) is the index used by engines and logs."""

    name: Title
    type: Annotated[int, Field(ge=1)]
    radius_m: Annotated[float, Field(ge=1e-9, le=1e6)]
    density_kg_per_m3: Positive
    contact_angle_rad: Annotated[float, Field(ge=0, lt=3.15)]
    count: Annotated[int, Field(ge=0)]
    passes_aperture: bool = True
    insertion: Insertion | None = None
    """Insertion, until which they move uniformly without weight; None: they are present from the start."""

    @property
    def mass_kg(self) -> float:
        return self.density_kg_per_m3 * 4.0 / 3.0 * math.pi * self.radius_m**3


class ContactPair(Computable):
    """Dry contact of sphere type `a` with sphere type `b`, or with the walls when `b` is 0."""

    a: Annotated[int, Field(ge=1)]
    b: Annotated[int, Field(ge=0)]
    normal_stiffness_N_per_m: Annotated[float, Field(ge=1e-12, le=1e15)]
    """Stiffness of the linear spring; in a scene with `hertz` that of its equivalent (`Hertz.springs`), used for estimates."""
    tangential_stiffness_N_per_m: Annotated[float, Field(ge=1e-12, le=1e15)]
    friction: NonNegative
    rolling_friction_m: NonNegative
    restitution: Annotated[float, Field(gt=0, le=1)]


class Liquid(Computable):
    """The liquid and its initial distribution (same film thickness on every sphere, walls dry)."""

    surface_tension_N_per_m: NonNegative
    viscosity_Pa_s: NonNegative
    density_kg_per_m3: Positive
    initial_film_thickness_m: NonNegative


class Vibration(Computable):
    """Vibration x_k(t) = amplitude_k · sin(2π f t + phase_k), with t from the start of the run and the rest position at zero."""

    amplitude_m: Vector
    phase_rad: Vector
    frequency_Hz: Positive


class Slide(Computable):
    """Displacement of a wall such as the feed bin's floor: constant velocity from `opens_at_s` for `travel_s`."""

    velocity_m_per_s: Vector
    opens_at_s: NonNegative
    travel_s: Positive


class Rotation(Computable):
    """Rotation of walls about an axis through `origin_m`: right-handed, one turn in `period_s`, from the start of the run."""

    origin_m: Vector
    axis: Vector
    period_s: Positive


MOTIONS = {"vibrates": Vibration, "slides": Slide, "turns": Rotation}
"""Name of a wall's motion -> class that describes it."""


class WallMesh(Computable):
    """One closed surface, an STL file; its triangles are grouped into parts (a wire, a flat face)."""

    name: Identifier
    reservoir: Reservoir
    stl: Inside
    contact_angle_rad: Annotated[float, Field(ge=0, lt=3.15)]
    motion: Literal["fixed", "vibrates", "slides", "turns"] = "fixed"
    motion_parameters: Vibration | Slide | Rotation | None = None
    """Motion of the wall, if it is not the scene's motion of this kind."""
    triangle_part: tuple[int, ...]
    """Index of the part (0, 1, …) of each triangle of the STL file, in file order."""
    part_half_width_m: tuple[float | None, ...]
    """Half width r_w [m] of each part (a wire's radius); None for a large wall."""
    feature_angle_deg: Annotated[float, Field(gt=0, le=180)] | None = None
    """Angle between neighbouring facets above which a part ends; None: the parts follow from the construction of the wall."""
    analytic_wires: bool = False
    """Whether every part is an analytic wire: dry contacts are with its closest point, not with triangles."""

    @model_validator(mode="after")
    def _moving(self) -> WallMesh:
        if self.motion_parameters is not None and type(self.motion_parameters) is not MOTIONS.get(self.motion):
            kind = type(self.motion_parameters).__name__.lower()
            raise ValueError(
                f"wall {self.name}: its motion is {self.motion} but its own motion is a {kind}; expected one"
            )
        if self.analytic_wires and self.motion == "turns":
            raise ValueError(f"wall {self.name}: analytic_wires is true but the wall turns; expected false for it")
        return self


class Effects(Laws):
    """Simulated effects (the result of the effect plan), and their laws."""

    bridges: bool
    wall_films: bool = True
    """Bridges between spheres and walls; off: the liquid never wets a wall."""
    rolling: bool = True
    tangential_history: bool = True
    """Friction as a spring with tangential history; off: a drag up to the same Coulomb limit, without static friction."""
    gravity: bool = True
    liquid_weight: bool = False
    """Whether spheres have the mass of their liquid in addition to their own."""

    @model_validator(mode="after")
    def _complete(self) -> Effects:
        missing = [n for n in NEEDED if self.bridges and getattr(self, n) is None]
        if missing:
            raise ValueError(f"effects: bridges are on but no law is named for {', '.join(missing)}")
        if not self.bridges and (self.liquid_weight or self.shedding):
            raise ValueError(
                "effects: liquid_weight or shedding is on but bridges are off; expected both off: nothing is wet"
            )
        return self

    @property
    def laws(self) -> dict[str, str]:
        return {kind: law for kind, law in self if isinstance(law, str)}


SHORT_WINDOW = 4
"""Largest number of steps of sampling windows at random positions; longer ones are evenly spaced."""


class Output(Computable):
    """Intervals of outputs, and windows of detailed logs."""

    interval_s: Positive
    contact_windows: int = Field(default=2, ge=0)
    contact_window_steps: int = Field(default=20, ge=1)
    checkpoints: int = Field(default=0, ge=0)
    """Number of times during the run that the state is saved for a resumption, evenly spaced."""
    window_trajectories: bool = False
    """Whether motion, forces and contact springs of all spheres are recorded in every step of the windows."""
    energy: bool = True
    """Whether a moist run accumulates the work of every effect in every step, for `history/energy`."""


WallFilm = Literal["triangle", "part", "wall"]
WALL_FILMS: tuple[WallFilm, ...] = get_args(WallFilm)
"""Areas over which the liquid of a wall spreads at once."""
MOST_STEPS, MOST_OUTPUTS = 2**31 - 1, 1_000_000
"""Largest number of steps that an engine counts, and of outputs whose steps can be listed."""
SCRIPTED = "script"
"""Name of the scene of a user's script; it has no pairs, since the script defines the dry contacts."""
RESERVED = ("gravity", "walls", "integrate", "pywet")
RESERVED_STARTS = ("p_", "move_", "drive_")
"""Prefixes used in the decks, with which no wall's name may start."""


DROP_INTERVAL = 1e-3
"""Time [s] over which the specific force on a film is averaged; films of 1 mm3 respond in 0.6 ms, of 10 mm3 in 2 ms."""
RETIRED_DEPTH = 2.0
"""Depth of a retired sphere below the plane of the bin in largest diameters, so that it touches nothing above the plane."""
RETIRED_RISE = 0.01
"""Share of that depth by which its speed may lift it (v2/2g).

An impact by a heavier sphere doubles a speed, which gives four times the rise.
"""


def not_retirable(effects: Effects, output: Output, gravity: Vector, inserts: bool = False) -> str | None:
    """Return the reason why no sphere of a scene can be retired; None if retirement is possible."""
    obstacles = {
        "output.checkpoints is 0, and spheres are retired at checkpoints": output.checkpoints == 0,
        "gravity does not act along -z, so that nothing comes to rest in the bin": any(gravity[:2]) or gravity[2] >= 0,
        "effects.shedding is on, and drops may land on spheres in the bin": effects.shedding is not None,
        "output.energy is on, and its budget is of all spheres": effects.bridges and output.energy,
        "spheres enter during the run": inserts,
    }
    return next((why for why, met in obstacles.items() if met), None)


class EngineScene(Computable):
    """Complete description of one case for an engine."""

    name: Title
    seed: int
    classes: Annotated[tuple[SphereClass, ...], Field(min_length=1)]
    pairs: tuple[ContactPair, ...]
    hertz: Hertz | None = None
    """Hertz–Mindlin dry contacts; None: linear springs."""
    liquid: Liquid | None
    walls: tuple[WallMesh, ...]
    vibration: Vibration | None
    slide: Slide | None
    rotation: Rotation | None = None
    effects: Effects
    viscous_integration: Literal["explicit", "semi_implicit"] = "explicit"
    bridges_every: Annotated[int, Field(ge=1, le=16)] = 1
    """Steps between evaluations of the bridges, each of which acts for all of them; outputs and checkpoints are multiples."""
    contacts: Contacts = "planes"
    """Program that computes dry contacts if the plugin is in use, with identical results.

    `planes`: the plugin for pairs of spheres in batches and for triangles of walls; `batched`: the plugin for
    pairs of spheres only; `stock`: the engine. Batches are for the linear spring with history; the stock loop
    computes other contacts of spheres.
    """
    wall_film: WallFilm = "triangle"
    """Area that has a film of one thickness: a triangle, a part (a wire, a flat face) or a whole wall."""
    largest_overlap: Annotated[float, Field(gt=0, lt=1)] = 0.5
    """Overlap over the smaller radius at which a moist run stops."""
    transfer_nodes: Annotated[int, Field(ge=2)] = 201
    """Number of nodes over V* of the tables of transfer ratios of a rupturing bridge."""
    gravity_m_per_s2: Vector = (0.0, 0.0, -9.81)
    box_low_m: Vector
    box_high_m: Vector
    periodic: Across | None = None
    """Axis along which the box is periodic: spheres, contacts and bridges continue at the opposite face."""
    spheres_file: Inside
    """Parquet table of the spheres at the start: id, type, x, y, z [m] (and optional vx … wz)."""
    time_step_s: Positive
    duration_s: Positive
    blocks: Annotated[int, Field(ge=1)] | None = None
    """Number of equal blocks of a run that is extended block by block; None: its duration is given."""
    output: Output
    screen_z_m: float = 0.0
    bin_z_m: float
    """Height below which a sphere's centre counts as in the collecting bin."""
    retire: bool = False
    """Whether spheres that lie in the collecting bin are removed from the run at checkpoints (`retire_below_m`)."""
    created_ahead_s: Positive | None = None
    """Time [s] before its insertion at which a sphere is created, at the checkpoint before; None: all exist from the start."""
    outlets: tuple[Outlet, ...] = ()
    """Regions in which spheres are removed from the run at checkpoints, by the first outlet that contains their centre."""

    @model_validator(mode="after")
    def _consistent(self) -> EngineScene:
        walls = [w.name for w in self.walls]
        taken = sorted({n for n in walls if walls.count(n) > 1 or n in RESERVED or n.startswith(RESERVED_STARTS)})
        if taken:
            raise ValueError(
                f"scene {self.name}: the wall names {', '.join(taken)} are taken; expected one for each wall"
            )
        if not 1 <= self.steps <= MOST_STEPS:
            raise ValueError(
                f"scene {self.name}: duration_s ({self.duration_s:g}) of 1 to {MOST_STEPS} time steps ({self.time_step_s:g} s)"
            )
        if self.steps / self.output_every > MOST_OUTPUTS:
            raise ValueError(
                f"scene {self.name}: at most {MOST_OUTPUTS} outputs, not one each {self.output.interval_s:g} s; raise interval_s"
            )
        types = [c.type for c in self.classes]
        if types != list(range(1, len(types) + 1)):
            raise ValueError(f"scene {self.name}: sphere types must be 1, 2, … in order, got {types}")
        have = {(p.a, p.b) for p in self.pairs}
        want = {(a, b) for a in types for b in [0, *types] if b == 0 or a <= b}
        if want - have and (have or self.name != SCRIPTED):
            raise ValueError(f"scene {self.name}: no contact data for the pairs {sorted(want - have)} (0 is a wall)")
        if have - want:
            raise ValueError(
                f"scene {self.name}: contact data for {sorted(have - want)}, which are not pairs of its types"
            )
        if self.hertz and (obstacle := self._not_hertzian(self.hertz)):
            raise ValueError(f"scene {self.name}: {obstacle}")
        if self.effects.bridges and self.liquid is None:
            raise ValueError(f"scene {self.name}: bridges are on but no liquid is given")
        if not self.effects.gravity and any(self.gravity_m_per_s2):
            raise ValueError(f"scene {self.name}: gravity is off in its effects but gravity_m_per_s2 is not zero")
        output, windows = self.output, self.output.contact_windows > 0
        if windows and SHORT_WINDOW < output.contact_window_steps < self.bridges_every:
            raise ValueError(
                f"scene {self.name}: contact_window_steps is {output.contact_window_steps} and bridges_every "
                f"{self.bridges_every}; expected windows in which bridges act: at least as many steps, at most {SHORT_WINDOW}, "
                "or no windows"
            )
        if self.bridges_every > 1 and not self.effects.bridges:
            raise ValueError(f"scene {self.name}: bridges_every is {self.bridges_every} without bridges; expected 1")
        if self.effects.shedding and not any(self.gravity_m_per_s2):
            raise ValueError(
                f"scene {self.name}: shedding is {self.effects.shedding} but there is no gravity for drops to fall; expected none"
            )
        obstacle = (
            not_retirable(self.effects, self.output, self.gravity_m_per_s2, self.has_insertion) if self.retire else None
        )
        if obstacle:
            raise ValueError(f"scene {self.name}: retire is on but {obstacle}; expected retire off")
        if self.blocks and (self.steps % self.blocks or self.output.contact_windows % self.blocks):
            raise ValueError(
                f"scene {self.name}: {self.steps} steps and {self.output.contact_windows} contact_windows in {self.blocks} "
                "blocks; expected as many in each"
            )
        self._check_outlets()
        self._check_periodic()
        if any(w.motion == "turns" and self.motions[w.name] is None for w in self.walls):
            raise ValueError(f"scene {self.name}: a wall turns but no rotation is given")
        return self

    def _check_outlets(self) -> None:
        """Refuse outlets of the same name, together with `retire`, or in a run that cannot remove spheres."""
        names = [o.name for o in self.outlets]
        if len(set(names)) < len(names):
            raise ValueError(f"scene {self.name}: outlets {', '.join(names)}; expected a name for each")
        if self.outlets and self.retire:
            raise ValueError(f"scene {self.name}: outlets and retire; expected one of them")
        for o in self.outlets:
            if o.moves_with is not None and not isinstance(self.motions.get(o.moves_with), Vibration):
                raise ValueError(
                    f"scene {self.name}: outlet {o.name} moves with {o.moves_with}; expected a wall that vibrates"
                )
        if self.created_ahead_s and not (self.outlets and self.has_insertion):
            raise ValueError(
                f"scene {self.name}: created_ahead_s without insertion and outlets; expected both, or null"
            )
        down = (0.0, 0.0, -1.0)  # an outlet is a region, independent of gravity
        if self.outlets and (obstacle := not_retirable(self.effects, self.output, down)):
            raise ValueError(f"scene {self.name}: there are outlets but {obstacle}; expected no outlets")

    def _check_periodic(self) -> None:
        """Refuse objects that do not continue at the opposite face of a periodic box."""
        if self.periodic is None:
            return
        obstacles = {
            "contacts are planes, which are not known there; expected batched or stock": self.contacts == "planes",
            "a wall has analytic wires; expected triangles": any(w.analytic_wires for w in self.walls),
            "effects.shedding is on; expected it off": self.effects.shedding is not None,
            "output.energy is on; expected it off": self.effects.bridges and self.output.energy,
        }
        if why := next((why for why, met in obstacles.items() if met), None):
            raise ValueError(f"scene {self.name}: the box is periodic along {self.periodic} but {why}")

    def _not_hertzian(self, hertz: Hertz) -> str | None:
        """Return the reason why contacts of the scene cannot be Hertzian; None if they can."""
        least = min(p.restitution for p in self.pairs)
        obstacles = {
            f"hertz has moduli of {len(hertz.spheres)} types; expected {len(self.classes)}": len(hertz.spheres)
            != len(self.classes),
            "tangential_history is off with hertz, whose friction is a spring; expected it on": not (
                self.effects.tangential_history
            ),
            f"restitution is {least:g} with hertz; expected above {LEAST_RESTITUTION:g}": least <= LEAST_RESTITUTION,
        }
        return next((why for why, met in obstacles.items() if met), None)

    @property
    def periods_m(self) -> Vector:
        """Return the lengths of the box along x, y, z [m], 0 along non-periodic axes."""
        x, y, z = (
            high - low if axis == self.periodic else 0.0
            for axis, low, high in zip("xyz", self.box_low_m, self.box_high_m, strict=True)
        )  # fmt: skip
        return x, y, z

    @property
    def removes(self) -> bool:
        """Return whether spheres are removed from the run, from the collecting bin or at outlets."""
        return self.retire or bool(self.outlets)

    @property
    def retire_below_m(self) -> float:
        """Return the height of the centre [m] below which a slow sphere is retired: RETIRED_DEPTH below `bin_z_m`."""
        return self.bin_z_m - self._retired_depth_m

    @property
    def retire_slower_m_per_s(self) -> float:
        """Return the speed [m/s] below which a sphere is retired: it lifts the sphere by at most RETIRED_RISE of that depth."""
        return float((2.0 * abs(self.gravity_m_per_s2[2]) * RETIRED_RISE * self._retired_depth_m) ** 0.5)

    @property
    def _retired_depth_m(self) -> float:
        return RETIRED_DEPTH * 2.0 * max(c.radius_m for c in self.classes)

    @property
    def motions(self) -> dict[str, Vibration | Slide | Rotation | None]:
        """Return the motion of each wall by its name: the wall's own, or the scene's of its kind; None if it is fixed."""
        shared = {"vibrates": self.vibration, "slides": self.slide, "turns": self.rotation}
        return {w.name: w.motion_parameters or shared.get(w.motion) for w in self.walls}

    @property
    def has_insertion(self) -> bool:
        """Return whether spheres enter the scene during the run."""
        return self.insertion_s is not None

    @property
    def insertion_s(self) -> tuple[float, float] | None:
        """Return the times of the first start and the last end of an insertion [s]; None without insertion."""
        times = [(f.from_s, f.from_s + f.for_s) for f in (c.insertion for c in self.classes) if f]
        return (min(a for a, _ in times), max(b for _, b in times)) if times else None

    def enters(self, types: Iterable[int]) -> list[int]:
        """Return the step at which each sphere is released and its liquid is counted; `types` in the order of ids."""
        kinds = np.fromiter(types, dtype=np.int64)
        steps = np.zeros(len(kinds), dtype=np.int64)
        for c in self.classes:
            if c.insertion:
                members = np.flatnonzero(kinds == c.type)
                steps[members] = np.rint(c.insertion.at(np.arange(len(members)), c.count) / self.time_step_s)
        found: list[int] = steps.tolist()
        return found

    @property
    def steps(self) -> int:
        return round(self.duration_s / self.time_step_s)

    @property
    def block_steps(self) -> int:
        """Return the number of steps of a block; of all steps if the duration is given."""
        return self.steps // (self.blocks or 1)

    @property
    def block_s(self) -> float:
        """Return the duration of a block [s]."""
        return self.block_steps * self.time_step_s

    def of_blocks(self, blocks: int) -> EngineScene:
        """Return the scene with another number of blocks; a run of more blocks begins with the same steps and windows."""
        windows = self.output.contact_windows // (self.blocks or 1) * blocks
        return self.model_copy(
            update={
                "blocks": blocks,
                "duration_s": blocks * self.block_steps * self.time_step_s,
                "output": self.output.model_copy(update={"contact_windows": windows}),
            }
        )

    @property
    def output_every(self) -> int:
        """Return the number of steps between outputs, at which bridges act and, if spheres shed, drops may fall."""
        every = self.drop_every if self.effects.shedding else self.bridges_every
        return every * max(1, round(self.output.interval_s / self.time_step_s) // every)

    @property
    def drop_every(self) -> int:
        """Return the number of steps between checks for drops: about `DROP_INTERVAL`, and at most `output_every`."""
        steps, checks = round(self.output.interval_s / self.time_step_s), round(self.output.interval_s / DROP_INTERVAL)
        return self.bridges_every * max(1, steps // (max(1, checks) * self.bridges_every))

    @property
    def output_steps(self) -> list[int]:
        """Return the steps at which trajectory, liquid and ledger are written."""
        return list(range(0, self.steps + 1, self.output_every))

    @classmethod
    def read(cls, path: Path) -> EngineScene:
        return read_model(path, cls, "expected the scene of a run: build it again")
