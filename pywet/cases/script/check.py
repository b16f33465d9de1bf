"""Output of `pywet liggghts --check`: script and liquid, stable time step, effects with reasons, and what is unsupported."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from pywet.cases.script import facts as reading
from pywet.cases.script.facts import Facts, Kind, height_m, periodic_lengths_m
from pywet.cases.script.scan import scan
from pywet.cases.script.scene import Spheres, reach, scene_of
from pywet.cases.script.wet import Wet
from pywet.engines.liggghts.plugin_api import NEWCOMER
from pywet.errors import PywetError
from pywet.laws.contact import film_thickness
from pywet.laws.hertz import Elastic, Hertz
from pywet.laws.kinds import SWITCHED
from pywet.planning import time_steps
from pywet.planning.numbers import effect_numbers
from pywet.planning.surroundings import Surroundings
from pywet.scene import ContactPair, EngineScene

CROWD = time_steps.DENSE
"""Number of spheres of each kind assumed for the stable step: a dense packing."""
DEFAULTED = {"gravity", "coefficientRestitution", "coefficientFriction", "characteristicVelocity"}
"""Quantities that the estimates replace by a default if the script has none, which they must not if it hides the value."""
LEAST_SPEED = 0.1
"""Impact speed [m/s] if neither a fall nor the script gives a larger one."""


def check(path: Path, words: Sequence[str] = (), engine: str = "liggghts") -> tuple[list[str], list[PywetError]]:
    """Return a description of script and liquid, and the errors, without running. `words`: engine options such as -var."""
    found = scan(path, words, engine)
    facts = reading.facts(found.rows)
    wrong = [*found.problems, *reading.problems(facts)]
    lines = list(_script(path, facts))
    spheres, error = _spheres(found.wet, facts.kinds)
    wrong += error
    lines += _films(found.wet, facts.kinds, None if error or not facts.kinds else spheres.table)
    if not error and facts.kinds and facts.skin_m is not None:
        line, small = _skin(spheres, facts)
        lines += line
        wrong += small
    scene = None if error else _scene(found.wet, facts, spheres)
    lines += _time_step(facts, scene)
    lines += _effects(found.wet, facts, scene)
    lines.append(f"run: {found.line.log}, output every {found.line.every} steps")
    if facts.hidden:
        lines.append(f"known only when the engine comes to the line: {', '.join(dict.fromkeys(facts.hidden))}")
    return lines, list({str(p): p for p in wrong}.values())


def _script(path: Path, f: Facts) -> Iterator[str]:
    kinds = [
        f"type {k.atom_type}: radius {1e3 * k.radius_m:g} mm, {k.density_kg_per_m3:g} kg/m3 ({k.of})" for k in f.kinds
    ]
    yield f"{path}: {len(f.kinds)} kinds of spheres, {len(f.meshes)} meshes, {len(f.primitives)} primitive walls"
    yield from (f"  {line}" for line in kinds)
    for mesh in f.meshes:
        count = "triangles not known" if mesh.triangles is None else f"{mesh.triangles} triangles"
        use = "wall" if mesh.wall else "no wall"
        material = "not known" if mesh.atom_type is None else mesh.atom_type
        yield f"  mesh {mesh.name}: {count}, material {material}, {use} ({mesh.file})"
    yield from (f"  primitive wall {name}: {words}" for name, words in f.primitives.items())
    yield from (f"  {name} {' '.join(f'{v:g}' for v in values)}" for name, values in f.materials.items())
    models = sorted({m for m in f.wall_models if f"model {m}" != f.pair})
    yield f"  contacts: {f.pair or 'not known'}" + (f"; of walls: model {'; model '.join(models)}" if models else "")
    for axis in f.periodic:
        length = periodic_lengths_m(f).get(axis)
        size = "a length not known" if length is None else f"{1e3 * length:g} mm"
        yield f"  periodic along {axis}: {size}; bridges reach across"
    if f.gravity:
        yield f"  gravity: {' '.join(f'{g:g}' for g in f.gravity)} m/s2"


def _spheres(wet: Wet, kinds: Sequence[Kind]) -> tuple[Spheres, list[PywetError]]:
    """Return one sphere of each kind, with its film at any position."""
    anywhere = tuple(first for first in wet.first_films if first.everywhere)
    spheres = Spheres(wet.model_copy(update={"first_films": anywhere}))
    rows = [(n, k.atom_type, k.radius_m, k.mass_kg, (0.0,) * 3) for n, k in enumerate(kinds, start=1)]
    try:
        spheres.take_in(np.array(rows, NEWCOMER), 1)
    except PywetError as error:
        return spheres, [error]
    return spheres, []


def _films(wet: Wet, kinds: Sequence[Kind], table: pd.DataFrame | None) -> Iterator[str]:
    """Describe the liquid, the films, and the distance from a sphere's centre at which films touch."""
    liquid = wet.liquid
    amount = f"{liquid.percent:g} % by mass" if liquid.percent is not None else f"films of {liquid.film_um:g} um"
    of = f"{liquid.surface_tension_N_per_m:g} N/m, {liquid.viscosity_Pa_s:g} Pa s, {liquid.density_kg_per_m3:g} kg/m3"
    yield f"liquid: {of}, {amount}" + (", first_films apart" if wet.first_films else "")
    for k, first in enumerate(wet.first_films, start=1):
        if first.type is not None and first.type not in {kind.atom_type for kind in kinds}:
            yield f"  entry {k} of first_films: the text of the script has no spheres of type {first.type}"
    if table is None:
        return
    thickness = film_thickness(table["film"].to_numpy(), table["radius"].to_numpy())
    for kind, h in zip(kinds, thickness, strict=True):
        meets = f"touches at {1e3 * (kind.radius_m + h):.4g} mm from its centre"
        angle = wet.angle_deg(kind.atom_type)
        yield f"  type {kind.atom_type}, {2e3 * kind.radius_m:g} mm: film {1e6 * h:.3g} um, {meets}, angle {angle:g} degrees"


def _skin(spheres: Spheres, f: Facts) -> tuple[list[str], list[PywetError]]:
    """Describe how the skin of `neighbor` is divided, or report that it is too small."""
    radii = [kind.radius_m for kind in f.kinds]
    try:
        ways, films = reach(spheres, {"skin": f.skin_m, "largest_radius": max(radii), "least_radius": min(radii)})
    except PywetError as error:
        return [], [error]
    seen = (
        f"{1e3 * ways:.3g} mm for the motion of spheres, films up to {1e6 * films * min(radii):.3g} um on the smallest"
    )
    return [f"  skin {1e3 * (f.skin_m or 0.0):g} mm: {seen}"], []


def _speed(f: Facts) -> float:
    """Estimate the impact velocity: the script's characteristic velocity, or for Hertz contacts the speed of a fall through the
    box.
    """
    if f.normal_model == "hooke":
        return max(f.materials.get("characteristicVelocity", (LEAST_SPEED,)))
    fall = math.sqrt(2.0 * float(np.linalg.norm(f.gravity or (0.0,))) * height_m(f))
    return max(LEAST_SPEED, fall)


def _scene(wet: Wet, f: Facts, spheres: Spheres) -> EngineScene | None:
    """Return a scene for estimates: the script's spheres and contacts, with the thickest film; None if a number is unknown."""
    if not f.kinds or not f.time_step_s or DEFAULTED & set(f.hidden):
        return None
    scene = scene_of(wet, f.time_step_s, spheres, [], f.gravity or (0.0,) * 3)
    classes = tuple(c.model_copy(update={"count": CROWD}) for c in scene.classes)
    radius, film = (spheres.table[name].to_numpy() for name in ("radius", "film"))
    thickest = float(film_thickness(film, radius).max())
    liquid = scene.liquid.model_copy(update={"initial_film_thickness_m": thickest}) if scene.liquid else None
    scene = scene.model_copy(update={"classes": classes, "liquid": liquid})
    of = {c.type: kind.atom_type for c, kind in zip(classes, _first(f.kinds), strict=True)}
    hertz = _hertz(f, list(of.values())) if f.normal_model in ("hertz", "hooke") else None
    pairs = [_pair(f, scene, hertz, of, a, b) for a in of for b in of if a <= b]
    if any(p is None for p in pairs):
        return None
    return scene.model_copy(update={"pairs": tuple(pairs), "hertz": hertz if f.normal_model == "hertz" else None})


def _first(kinds: Sequence[Kind]) -> list[Kind]:
    """Return one sphere of each kind that the plugin distinguishes, in the order of the classes."""
    return list({(k.atom_type, k.radius_m, float(f"{k.density_kg_per_m3:.9g}")): k for k in kinds}.values())


def _hertz(f: Facts, types: Sequence[int]) -> Hertz | None:
    moduli = [(f.material("youngsModulus", t), f.material("poissonsRatio", t)) for t in types]
    if any(e is None or nu is None for e, nu in moduli):
        return None
    bodies = tuple(Elastic.model_construct(youngs_modulus_Pa=e, poissons_ratio=nu) for e, nu in moduli)
    return Hertz.model_construct(spheres=bodies, walls=bodies[0], impact_speed_m_per_s=_speed(f))


def _pair(f: Facts, scene: EngineScene, hertz: Hertz | None, of: dict[int, int], a: int, b: int) -> ContactPair | None:
    """Return the contact of a pair with its given stiffness (hooke/stiffness), or that at the script's impact speed."""
    restitution = f.material("coefficientRestitution", of[a], of[b])
    friction = f.material("coefficientFriction", of[a], of[b])
    normal = side = None
    if f.normal_model == "hooke/stiffness":
        normal, side = f.material("kn", of[a], of[b]), f.material("kt", of[a], of[b])
    elif hertz is not None:
        normal, side = hertz.springs(scene.classes, ContactPair.model_construct(a=a, b=b))
        side = normal if f.normal_model == "hooke" else side  # rule of the engine
    if not normal or side is None:
        return None
    return ContactPair.model_construct(
        a=a, b=b, normal_stiffness_N_per_m=normal, tangential_stiffness_N_per_m=side, friction=friction or 0.0,
        rolling_friction_m=0.0, restitution=restitution if restitution is not None else 1.0,
    )  # fmt: skip


def _time_step(f: Facts, scene: EngineScene | None) -> Iterator[str]:
    if f.time_step_s is None:
        yield "time step: not known before the engine comes to the line"
    elif scene is None:
        unknown = "a number of the spheres or contacts, or gravity, is not known"
        yield f"time step {f.time_step_s:g} s: no stable one to compare it with, {unknown}"
    else:
        yield "stable time steps, of two spheres in a packing:"
        yield from (f"  {line}" for line in time_steps.advise(scene).lines)


def _effects(wet: Wet, f: Facts, scene: EngineScene | None) -> Iterator[str]:
    """List each effect with its law, whether it is on and why, and the number on which this is decided."""
    numbers = {}
    if scene is not None:
        g = float(np.linalg.norm(scene.gravity_m_per_s2))
        numbers = effect_numbers(scene.classes, scene.pairs, scene.liquid, _speed(f), Surroundings(gravity_m_per_s2=g))
    effects, named = wet.effects, wet.laws.model_dump(exclude={"preset", "reference"}, exclude_none=True)
    rows = [("bridges", True, "", "the line of fix pywet")]
    for kind in SWITCHED:
        law = getattr(effects, kind)
        rows.append((kind, law is not None, law or "", "laws" if kind in named else f"preset {wet.laws.preset}"))
    dry = "no wall has an angle"
    rows.append(("wall_films", effects.wall_films, "", ", ".join(wet.wet_walls) or dry))
    rows.append(("liquid_weight", False, "", "a script's spheres keep their mass"))
    rows.append(("shedding", False, "", "no drops from a script's spheres"))
    yield f"effects ({wet.viscous_integration} drag):"
    for name, on, law, why in rows:
        quantity, number = numbers.get(name, ("", None))
        size = "" if number is None else f"; {quantity} = {number:.2g}"
        yield f"  {name:<19}{'on ' if on else 'off'} {law + ': ' if law else ''}{why}{size}"
    yield f"  laws of every bridge: {', '.join(f'{k} {v}' for k, v in effects.laws.items() if k not in SWITCHED)}"
