"""What `wet.yaml` says of the liquid in a script, and what the words of the line `fix ID all pywet …` say."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from pywet.cases.custom.description import Angle, Liquid
from pywet.cases.script.refusals import refusal
from pywet.config.loading import parse, placed_laws, read_yaml
from pywet.config.settings import LawSettings
from pywet.laws import registry
from pywet.laws.contact import film_volume
from pywet.laws.kinds import PRESETS
from pywet.scene import Effects
from pywet.strict import Strict

STYLE = "pywet"
EVERY = 1000
"""Steps between outputs where the line does not say it."""
LOG = "wet"
"""Folder of the tables where the line does not say it."""


class Wet(Strict):
    """The liquid of a script: its properties and amount, contact angles, laws."""

    liquid: Liquid
    """Liquid and how much of it: `percent` of each sphere's mass, or the film's thickness `film_um`."""
    contact_angle_deg: Angle | dict[Annotated[str, Field(pattern=r"^[1-9][0-9]*$")], Angle]
    """Of the liquid on the spheres: one, or one for each atom type of the script."""
    laws: LawSettings = LawSettings()
    """Preset of laws, and laws named for single effects."""
    viscous_integration: Literal["explicit", "semi_implicit"] = "semi_implicit"
    """Of the viscous force: explicit, or semi_implicit, which does not shorten the step."""
    walls: Literal["dry"] | None = None
    """`dry`: the liquid never meets a wall. A script with walls has to say it, since films on walls are not supported yet."""

    @model_validator(mode="after")
    def _amount(self) -> Self:
        if self.liquid.percent is None and self.liquid.film_um is None:
            raise ValueError("liquid.percent or liquid.film_um, how much of it there is (0: none)")
        return self

    @property
    def effects(self) -> Effects:
        """Bridges between spheres by the laws chosen."""
        named = self.laws.model_dump(exclude={"preset", "reference"}, exclude_none=True)
        return Effects(bridges=True, wall_films=False, **{**PRESETS[self.laws.preset], **named})

    def angle_deg(self, atom_type: int) -> float | None:
        """Contact angle on spheres of a type; None where the file has none."""
        given = self.contact_angle_deg
        return given.get(str(atom_type)) if isinstance(given, dict) else given

    def film_m3(self, mass_kg: float, radius_m: float) -> float:
        """Liquid on a sphere at the start."""
        if self.liquid.film_um is not None:
            return film_volume(1e-6 * self.liquid.film_um, radius_m)
        return 0.01 * (self.liquid.percent or 0.0) * mass_kg / self.liquid.density_kg_per_m3

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
    """The line of the script: name of the fix, file of the liquid, folder of the tables, steps between outputs."""

    name: str
    liquid: Path
    log: Path = Path(LOG)
    every: int = EVERY


def line(words: list[str]) -> Line:
    """What the words `ID all pywet liquid FILE [log FOLDER] [every N]` say."""
    name, group, rest = words[0], words[1], words[3:]
    if group != "all":
        raise refusal("wet.group", group)
    given = dict(zip(rest[::2], rest[1::2], strict=False))
    whole = re.fullmatch(r"[1-9][0-9]{0,8}", given.get("every", "1"))
    if (
        len(rest) % 2
        or len(given) < len(rest) // 2
        or "liquid" not in given
        or given.keys() - {"liquid", "log", "every"}
    ):
        raise refusal("wet.words", " ".join(rest))
    if not whole:
        raise refusal("wet.every", given["every"])
    return Line(name, Path(given["liquid"]), Path(given.get("log", LOG)), int(given.get("every", EVERY)))
