"""Facts read from the text of a script: spheres, walls, materials, contact models, time step, skin, gravity.

Values hidden in variables, loops or restart files are omitted; the engine provides them at the line of fix pywet.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np

from pywet.cases.script.refusals import of_box, refusal
from pywet.cases.script.scan import meshes_of
from pywet.errors import PywetError
from pywet.geometry.stl import corners_in
from pywet.util.files import read_bytes

POSITIVE = {"youngsModulus", "coefficientRestitution", "characteristicVelocity"}
"""Material properties that the engine refuses unless they are above 0."""


@dataclass(frozen=True)
class Kind:
    """Spheres of one template or data file: atom type, radius [m], density [kg/m3], and the template or file."""

    of: str
    atom_type: int
    radius_m: float
    density_kg_per_m3: float

    @property
    def mass_kg(self) -> float:
        return 4.0 / 3.0 * math.pi * self.radius_m**3 * self.density_kg_per_m3


@dataclass(frozen=True)
class Mesh:
    """A mesh: file, atom type of its material and number of triangles (None: not known), whether a wall uses it."""

    name: str
    file: str
    atom_type: int | None
    triangles: int | None
    wall: bool


@dataclass
class Facts:
    """Facts found in the commands of a script."""

    kinds: list[Kind] = field(default_factory=list)
    drawn: list[tuple[str, str]] = field(default_factory=list)
    """Templates whose radius follows a distribution, with that distribution."""
    meshes: list[Mesh] = field(default_factory=list)
    primitives: dict[str, str] = field(default_factory=dict)
    """Primitive walls by the ID of their fix."""
    materials: dict[str, tuple[float, ...]] = field(default_factory=dict)
    pair: str = ""
    """Contact models between spheres."""
    wall_models: set[str] = field(default_factory=set)
    time_step_s: float | None = None
    skin_m: float | None = None
    gravity: tuple[float, float, float] | None = None
    box: tuple[float, ...] = ()
    """Bounds of the box along x, y, z [m]."""
    periodic: str = ""
    """Axes along which the box repeats."""
    hidden: list[str] = field(default_factory=list)
    """Quantities that only the engine can determine."""
    not_positive: list[str] = field(default_factory=list)
    """Quantities of 0 or less that must be above 0, which are otherwise left out."""

    @property
    def normal_model(self) -> str:
        """Return the contact model of the normal force, such as hertz."""
        words = self.pair.split()
        return words[words.index("model") + 1] if "model" in words[:-1] else ""

    def material(self, name: str, one: int, other: int | None = None) -> float | None:
        """Return a material property of one atom type, or of a pair of types."""
        values = self.materials.get(name, ())
        n = len(values) if other is None else math.isqrt(len(values))
        if not all(1 <= t <= n for t in (one, other or one)):
            return None
        return values[one - 1] if other is None else values[(one - 1) * n + other - 1]


def facts(rows: Sequence[list[str]]) -> Facts:
    """Read the commands of a script (`Found.rows`)."""
    found, used = Facts(), _used(rows)
    walls = {mesh for words in rows if words[0] == "fix" and words[3:4] == ["wall/gran"] for mesh in meshes_of(words)}
    regions = {words[1]: words[3:] for words in rows if words[0] == "region" and words[2:3] == ["block"]}
    for words in rows:
        match words:
            case ["fix", name, _, style, *more]:
                _fix(found, name, style, more, used, walls)
            case ["pair_style", "gran", *models]:
                found.pair = " ".join(models)
            case ["timestep", value, *_]:
                found.time_step_s = number(value)
                if found.time_step_s is not None and found.time_step_s <= 0.0:
                    found.time_step_s = None
                    found.not_positive.append(f"timestep {value}")
            case ["neighbor", value, *_]:
                found.skin_m = number(value)
            case ["create_box", _, region, *_] if region in regions:
                found.box = tuple(v for word in regions[region][:6] if (v := number(word)) is not None)
            case ["boundary", *sides]:
                found.periodic = "".join(axis for axis, side in zip("xyz", sides, strict=False) if side in ("p", "pp"))
            case ["read_data", file, *_]:
                _data(found, file)
            case ["read_restart", file, *_]:
                found.hidden.append(f"spheres of read_restart {file}")
            case ["create_atoms", *_]:
                found.hidden.append("spheres of create_atoms")
            case ["jump", *_]:
                found.hidden.append("what a jump repeats or leaves out")
            case ["include", file, *_] if "$" in file:
                found.hidden.append(f"include {file}")
    return found


def number(word: str) -> float | None:
    """Return a finite number of the script; None for anything else, such as an undefined variable."""
    try:
        value = float(word)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _numbers(words: Sequence[str]) -> tuple[float, ...] | None:
    """Return the numbers of all words; None if one is unknown."""
    values = tuple(value for word in words if (value := number(word)) is not None)
    return values if len(values) == len(words) else None


def triangles_of(path: Path) -> int | None:
    """Return the number of triangles of an STL file, text or binary; None if there is none."""
    if not path.is_file() or path.suffix.lower() != ".stl":
        return None
    return len(corners_in(path)[0])


def _used(rows: Sequence[list[str]]) -> set[str]:
    """Return the templates that distributions use."""
    lists = [w for w in rows if w[0] == "fix" and w[3:4] and w[3].startswith("particledistribution/")]
    return {word for words in lists for word in words[4:]}


def _fix(found: Facts, name: str, style: str, more: list[str], used: set[str], walls: set[str]) -> None:
    given = dict(pairwise(more))
    if style == "property/global" and len(more) > 1:
        skip = 3 if more[1] in ("peratomtypepair", "atomtypepair") else 2
        if (values := _numbers(more[skip:])) is None:
            found.hidden.append(more[0])
        elif more[0] in POSITIVE and min(values, default=1.0) <= 0.0:
            found.not_positive.append(f"{more[0]} {min(values):g}")
        else:
            found.materials[more[0]] = values
    elif style == "gravity":
        if (gravity := _gravity(more)) is None:
            found.hidden.append("gravity")
        else:
            found.gravity = gravity
    elif style == "particletemplate/sphere" and name in used:
        _template(found, name, more, given)
    elif style.startswith("mesh/surface"):
        file = given.get("file", "?")
        count = triangles_of(Path(file))
        if not (atom_type := number(given.get("type", ""))):
            found.hidden.append(f"material of mesh {name}")
        found.meshes.append(Mesh(name, file, int(atom_type) if atom_type else None, count, name in walls))
    elif style == "wall/gran":
        models = more[more.index("model") + 1 :] if "model" in more else []
        ends = [models.index(word) for word in ("mesh", "primitive") if word in models]
        found.wall_models.add(" ".join(models[: min(ends)] if ends else models))
        if "primitive" in more:
            found.primitives[name] = " ".join(more[more.index("primitive") + 3 :])


def _gravity(more: list[str]) -> tuple[float, float, float] | None:
    """Return gravity [m/s2] from arguments such as `9.81 vector 0 0 -1`, `9.81 chute 20` or `9.81 spherical 0 160`."""
    style = more[1] if len(more) > 1 else ""
    count = {"vector": 3, "chute": 1, "spherical": 2}.get(style, 0)
    values = _numbers([more[0], *more[2 : 2 + count]]) if count else None
    if values is None or len(values) != 1 + count:
        return None
    size, *way = values
    if style != "vector":
        phi, theta = map(math.radians, way if style == "spherical" else (0.0, 180.0 - way[0]))
        way = [math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)]
    length = math.hypot(*way)
    return (size * way[0] / length, size * way[1] / length, size * way[2] / length) if length else None


def _template(found: Facts, name: str, more: list[str], given: dict[str, str]) -> None:
    """Add a template from arguments such as `atom_type 1 density constant 2500 radius constant 0.002`."""
    values = {}
    for key in ("density", "radius"):
        words = more[more.index(key) + 1 :][:3] if key in more else []
        if words[:1] == ["constant"] and len(words) > 1 and (value := number(words[1])) is not None:
            values[key] = value
        elif key == "radius" and words and words[0] != "constant":
            found.drawn.append((name, " ".join(words)))
    if wrong := [f"{key} {value:g} of template {name}" for key, value in values.items() if value <= 0.0]:
        found.not_positive += wrong
        return
    atom_type = number(given.get("atom_type", "1"))
    if len(values) == 2 and atom_type:
        found.kinds.append(Kind(f"template {name}", int(atom_type), values["radius"], values["density"]))
    elif name not in dict(found.drawn):
        found.hidden.append(f"radius or density of template {name}")


def _data(found: Facts, file: str) -> None:
    """Add the spheres of a data file of atom_style granular: number, type, diameter, density, position."""
    path = Path(file)
    if not path.is_file():
        return
    text = read_bytes(path, "a data file").decode(errors="replace")
    ends = [re.search(rf"^\s*(\S+)\s+(\S+)\s+{axis}lo\s+{axis}hi", text, re.MULTILINE) for axis in "xyz"]
    if all(ends):
        found.box = tuple(float(end) for match in ends if match for end in match.groups())
    part = re.search(r"^Atoms[^\n]*\n\s*\n(.*?)(?:\n\s*\n|\Z)", text, re.MULTILINE | re.DOTALL)
    rows = {tuple(line.split()[1:4]) for line in part[1].splitlines()} if part else set()
    for values in sorted(filter(None, map(_numbers, rows))):
        atom_type, diameter, density = values if len(values) == 3 else (0.0,) * 3
        if diameter > 0.0 and density > 0.0:
            found.kinds.append(Kind(f"data file {file}", int(atom_type), 0.5 * diameter, density))
    if part and not found.kinds:
        found.hidden.append(f"spheres of {file}")


def height_m(found: Facts) -> float:
    """Return the height [m] from which a sphere may fall within the box, along gravity."""
    if len(found.box) != 6 or not found.gravity:
        return 0.0
    size = np.abs(np.diff(np.reshape(found.box, (3, 2)), axis=1)[:, 0])
    return float(np.abs(np.asarray(found.gravity)) @ size / np.linalg.norm(found.gravity))


def periodic_lengths_m(found: Facts) -> dict[str, float]:
    """Return the length of the box along each periodic axis, if its bounds are known."""
    if len(found.box) != 6:
        return {}
    return {
        axis: abs(found.box[2 * k + 1] - found.box[2 * k]) for k, axis in enumerate("xyz") if axis in found.periodic
    }


def problems(found: Facts) -> Iterator[PywetError]:
    """List the faults of a script that these facts show."""
    if found.kinds and found.skin_m is not None:
        touch = 2.0 * max(kind.radius_m for kind in found.kinds)
        yield from of_box(periodic_lengths_m(found).values(), touch + found.skin_m, found.skin_m)
    for template, words in found.drawn:
        yield refusal("wet.drawn", f"template {template} draws its radius from `{words}`")
    for given in found.not_positive:
        yield refusal("wet.positive", given)
    for mesh in found.meshes:
        if "$" not in mesh.file and not Path(mesh.file).is_file():
            yield refusal("wet.mesh_file", f"{mesh.file} of the mesh {mesh.name}")
