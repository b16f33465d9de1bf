"""Keys of `wet.yaml`, the liquid of a script, and arguments of the line `fix ID all pywet …`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from pywet.cases.custom.description import Angle, Liquid, Percent
from pywet.cases.custom.walls import chosen
from pywet.cases.script.refusals import refusal
from pywet.config.loading import parse, placed_laws, read_yaml
from pywet.config.settings import LawSettings
from pywet.laws import registry
from pywet.laws.contact import film_volume
from pywet.laws.kinds import PRESETS
from pywet.scene import WALL_FILMS, Effects, Identifier, NonNegative, Vector, WallFilm
from pywet.strict import Strict

STYLE = "pywet"
EVERY = 1000
"""Steps between outputs where the line does not say it."""
LOG = "wet"
"""Folder of the run where the line does not say it."""
WINDOW = 1
"""Steps of the contact log from each output on where the line does not say it."""


class First(Strict):
    """The first film of some spheres, in place of that of all."""

    type: Annotated[int, Field(ge=1)] | None = None
    """Atom type of the script; None: of every type."""
    low_mm: Vector | None = None
    """Corner of least x, y, z of the box in which their centres are; None: it is open."""
    high_mm: Vector | None = None
    """Opposite corner."""
    percent: Percent | None = None
    """Mass of the liquid over that of the sphere, in per cent."""
    film_um: NonNegative | None = None
    """Thickness of the film, in place of `percent`."""

    @model_validator(mode="after")
    def _one_amount(self) -> Self:
        chosen(self, "percent", "film_um", needed=True)
        return self

    def holds(self, atom_type: int, place_m: Vector) -> bool:
        """Decide whether this entry of `first_films` applies to a sphere."""
        low, high = self.low_mm or (-float("inf"),) * 3, self.high_mm or (float("inf"),) * 3
        inside = all(1e-3 * a <= x < 1e-3 * b for a, x, b in zip(low, place_m, high, strict=True))
        return inside and self.type in (None, atom_type)


class Wet(Strict):
    """The liquid of a script: its properties and amount, contact angles, laws."""

    liquid: Liquid
    """Liquid and how much of it: `percent` of each sphere's mass, or the film's thickness `film_um`."""
    contact_angle_deg: Angle | dict[Annotated[str, Field(pattern=r"^[1-9][0-9]*$")], Angle]
    """Of the liquid on the spheres: one, or one for each atom type of the script."""
    first_films: tuple[First, ...] = ()
    """Of spheres of a type or in a box, also of those that are inserted there; the first one that holds a sphere counts."""
    laws: LawSettings = LawSettings()
    """Preset of laws, and laws named for single effects."""
    viscous_integration: Literal["explicit", "semi_implicit"] = "semi_implicit"
    """Of the viscous force: explicit, or semi_implicit, which does not shorten the step."""
    walls: Literal["dry"] | dict[Identifier, Angle | Literal["dry"]] | None = None
    """`dry`: the liquid never meets a wall. Else for each mesh its contact angle [deg] or `dry`, and for each primitive wall
    `dry`, by the ID of its fix."""
    wall_film: WallFilm = WALL_FILMS[0]
    """What has a film of one thickness: a triangle, a part (a flat or curved face) or a whole wall."""

    @model_validator(mode="after")
    def _amount(self) -> Self:
        if self.liquid.percent is None and self.liquid.film_um is None:
            raise ValueError("liquid.percent or liquid.film_um, the amount of liquid (0: none)")
        return self

    @property
    def wet_walls(self) -> Mapping[str, float]:
        """Contact angle [deg] of each mesh that the liquid meets."""
        return {n: a for n, a in self.walls.items() if a != "dry"} if isinstance(self.walls, dict) else {}

    @property
    def effects(self) -> Effects:
        """Bridges by the laws chosen."""
        named = self.laws.model_dump(exclude={"preset", "reference"}, exclude_none=True)
        return Effects(bridges=True, wall_films=bool(self.wet_walls), **{**PRESETS[self.laws.preset], **named})

    def angle_deg(self, atom_type: int) -> float | None:
        """Contact angle on spheres of a type; None where the file has none."""
        given = self.contact_angle_deg
        return given.get(str(atom_type)) if isinstance(given, dict) else given

    def film_m3(self, atom_type: int, mass_kg: float, radius_m: float, place_m: Vector) -> float:
        """Liquid on a sphere when it comes."""
        amount = next((first for first in self.first_films if first.holds(atom_type, place_m)), self.liquid)
        if amount.film_um is not None:
            return film_volume(1e-6 * amount.film_um, radius_m)
        return 0.01 * (amount.percent or 0.0) * mass_kg / self.liquid.density_kg_per_m3

    @classmethod
    def read(cls, path: Path) -> Wet:
        """The file, whose laws are there and may run."""
        wet = parse(cls, read_yaml(path, cls, "`pywet docs your-script` has one to begin with"), str(path))
        wet = wet.model_copy(update={"laws": placed_laws(wet.laws, path.resolve().parent)})
        for kind, law in wet.effects.laws.items():
            registry.get(kind, law)
        return wet


@dataclass(frozen=True)
class Line:
    """The line of the script: name of the fix, file of the liquid, folder of the run, steps between outputs and of windows."""

    name: str
    liquid: Path
    log: Path = Path(LOG)
    every: int = EVERY
    windows: int = WINDOW


def line(words: list[str]) -> Line:
    """Parse the line `ID all pywet liquid FILE [log FOLDER] [every N] [windows N]` of a script."""
    name, group, rest = words[0], words[1], words[3:]
    if group != "all":
        raise refusal("wet.group", group)
    given = dict(zip(rest[::2], rest[1::2], strict=False))
    unknown = given.keys() - {"liquid", "log", "every", "windows"}
    if len(rest) % 2 or len(given) < len(rest) // 2 or "liquid" not in given or unknown:
        raise refusal("wet.words", " ".join(rest))
    counts = {key: given.get(key, str(usual)) for key, usual in (("every", EVERY), ("windows", WINDOW))}
    for key, count in counts.items():
        if not re.fullmatch(r"[1-9][0-9]{0,8}", count):
            raise refusal(f"wet.{key}", count)
    every, windows = (int(count) for count in counts.values())
    return Line(name, Path(given["liquid"]), Path(given.get("log", LOG)), every, min(windows, every))
