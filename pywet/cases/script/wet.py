"""Keys of `wet.yaml`, the liquid of a script, and arguments of the line `fix ID all pywet …`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from pywet.cases.custom.materials import Angle, Liquid, Percent
from pywet.cases.custom.walls import chosen
from pywet.cases.script.refusals import refusal
from pywet.config.loading import parse, placed_laws, read_yaml
from pywet.config.settings import LawSettings
from pywet.laws import custom_laws, registry
from pywet.laws.contact import film_volume
from pywet.laws.kinds import PRESETS
from pywet.planning.time_steps import refuse_nonlinear_drag
from pywet.scene import WALL_FILMS, Effects, Identifier, NonNegative, Vector, WallFilm
from pywet.strict import Strict

STYLE = "pywet"
EVERY = 1000
"""Default number of steps between outputs."""
LOG = "wet"
"""Default folder of the run."""
WINDOW = 1
"""Default number of steps of the contact log from each output on."""


class First(Strict):
    """Initial film of some spheres, in place of the common one."""

    type: Annotated[int, Field(ge=1)] | None = None
    """Atom type of the script; None for every type."""
    low_mm: Vector | None = None
    """Corner with the smallest x, y, z of the box that contains their centres; None: open."""
    high_mm: Vector | None = None
    """Opposite corner."""
    percent: Percent | None = None
    """Mass of the liquid over that of the sphere, in per cent."""
    film_um: NonNegative | None = None
    """Thickness of the film, in place of `percent`."""

    @model_validator(mode="after")
    def _one_amount(self) -> Self:
        chosen(self, "percent", "film_um", needed=True)
        low, high = self.low_mm, self.high_mm
        if low and high and not all(a < b for a, b in zip(low, high, strict=True)):
            raise ValueError("each number of low_mm to be less than that of high_mm")
        return self

    @property
    def everywhere(self) -> bool:
        """Whether this entry applies at every position."""
        return self.low_mm is None and self.high_mm is None

    def holds(self, atom_type: int, place_m: Vector) -> bool:
        """Decide whether this entry of `first_films` applies to a sphere."""
        low, high = self.low_mm or (-float("inf"),) * 3, self.high_mm or (float("inf"),) * 3
        inside = all(1e-3 * a <= x < 1e-3 * b for a, x, b in zip(low, place_m, high, strict=True))
        return inside and self.type in (None, atom_type)


class Wet(Strict):
    """The liquid of a script: its properties and amount, contact angles, laws."""

    liquid: Liquid
    """Properties and amount of the liquid: `percent` of each sphere's mass, or the film thickness `film_um`."""
    contact_angle_deg: Angle | dict[Annotated[str, Field(pattern=r"^[1-9][0-9]*$")], Angle]
    """Contact angle of the liquid on the spheres: one value, or one for each atom type of the script."""
    first_films: tuple[First, ...] = ()
    """Initial films of spheres of a type or in a box, also for spheres inserted there; the first entry that applies is used."""
    laws: LawSettings = LawSettings()
    """Preset of laws, and laws for single effects."""
    viscous_integration: Literal["explicit", "semi_implicit"] = "semi_implicit"
    """Integration of the viscous force: explicit, or semi_implicit, which does not shorten the time step."""
    walls: Literal["dry"] | dict[Identifier, Angle | Literal["dry"]] | None = None
    """`dry`: the liquid never wets a wall.

    Otherwise the contact angle [deg] or `dry` of each mesh, and `dry` for each primitive wall, by the ID of its
    fix.
    """
    wall_film: WallFilm = WALL_FILMS[0]
    """Area that shares a film of one thickness: a triangle, a part (a flat or curved face) or a whole wall."""

    @model_validator(mode="after")
    def _amount(self) -> Self:
        if self.liquid.percent is None and self.liquid.film_um is None:
            raise ValueError("liquid.percent or liquid.film_um, the amount of liquid (0: none)")
        if self.laws.shedding is not None:
            raise ValueError(f"no laws.shedding ({self.laws.shedding}): the spheres of a script shed no drops")
        if any(first.everywhere and first.type is None for first in self.first_films[:-1]):
            raise ValueError("an entry without type and box only as the last one of first_films")
        return self

    @property
    def wet_walls(self) -> Mapping[str, float]:
        """Return the contact angle [deg] of each mesh that the liquid wets."""
        return {n: a for n, a in self.walls.items() if a != "dry"} if isinstance(self.walls, dict) else {}

    @property
    def effects(self) -> Effects:
        """Return the effects: bridges with the selected laws."""
        named = self.laws.model_dump(exclude={"preset", "reference"}, exclude_none=True)
        return Effects(bridges=True, wall_films=bool(self.wet_walls), **{**PRESETS[self.laws.preset], **named})

    def angle_deg(self, atom_type: int) -> float | None:
        """Return the contact angle [deg] on spheres of a type; None if the file gives none."""
        given = self.contact_angle_deg
        return given.get(str(atom_type)) if isinstance(given, dict) else given

    def first(self, atom_type: int, place_m: Vector) -> First | None:
        """Return the entry of `first_films` that applies to a sphere."""
        return next((first for first in self.first_films if first.holds(atom_type, place_m)), None)

    def film_m3(self, atom_type: int, mass_kg: float, radius_m: float, place_m: Vector) -> float:
        """Return the liquid [m3] on a sphere when it is inserted."""
        amount = self.first(atom_type, place_m) or self.liquid
        if amount.film_um is not None:
            return film_volume(1e-6 * amount.film_um, radius_m)
        return 0.01 * (amount.percent or 0.0) * mass_kg / self.liquid.density_kg_per_m3

    @classmethod
    def read(cls, path: Path) -> Wet:
        """Read the file of the liquid; its laws must exist and be trusted."""
        wet = parse(cls, read_yaml(path, cls, "`pywet docs your-script` has one to begin with"), str(path))
        wet = wet.model_copy(update={"laws": placed_laws(wet.laws, path.resolve().parent)})
        for kind, law in wet.effects.laws.items():
            registry.get(kind, law)
            if custom_laws.is_custom(law):
                from pywet.laws import checks  # it imports the exact bridge

                checks.warn(kind, law)
        refuse_nonlinear_drag(wet.effects, wet.viscous_integration, "viscous_integration", str(path))
        return wet


@dataclass(frozen=True)
class Line:
    """Line of fix pywet: name of the fix, file of the liquid, folder of the run, steps between outputs and per window."""

    name: str
    liquid: Path
    log: Path = Path(LOG)
    every: int = EVERY
    windows: int = WINDOW

    def __str__(self) -> str:
        """Return the words of the line, with the default values."""
        return f"{self.name} all {STYLE} liquid {self.liquid} log {self.log} every {self.every} windows {self.windows}"


def line(words: list[str]) -> Line:
    """Parse the line `ID all pywet liquid FILE [log FOLDER] [every N] [windows N]` of a script."""
    name, group, rest = words[0], words[1], words[3:]
    if group != "all":
        raise refusal("wet.group", group)
    given = dict(zip(rest[::2], rest[1::2], strict=False))
    unknown = given.keys() - {"liquid", "log", "every", "windows"}
    if len(rest) % 2 or len(given) < len(rest) // 2 or "liquid" not in given or unknown:
        raise refusal("wet.words", " ".join(rest))
    if hidden := [word for word in given.values() if "$" in word]:
        raise refusal("wet.hidden", hidden[0])
    counts = {key: given.get(key, str(usual)) for key, usual in (("every", EVERY), ("windows", WINDOW))}
    for key, count in counts.items():
        if not re.fullmatch(r"[1-9][0-9]{0,8}", count):
            raise refusal(f"wet.{key}", count)
    every, windows = (int(count) for count in counts.values())
    return Line(name, Path(given["liquid"]), Path(given.get("log", LOG)), every, min(windows, every))
