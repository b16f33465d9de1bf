"""Compare a user-defined scene with its description: scene.json, initial spheres and walls as determined by description.json.

Lengths there are in millimetres, angles in degrees, positions relative to `origin_mm`; `NOT_HELD` lists keys that are
not compared here.
"""

from __future__ import annotations

import hashlib
import json
import math
import re
import unicodedata
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

from reference_impl.diagnosis.held import MISSING, Held
from reference_impl.replay import plans
from reference_impl.replay.arrays import Floats
from reference_impl.replay.io import ReplayError, every
from reference_impl.scene import amounts, effects, expanded, inserted
from reference_impl.scene.numbers import flat

FILE = "description.json"
MM = 1e-3
RATIO = 2.0 / 7.0
"""Tangential over normal stiffness of linear contacts."""
BODIES_DEG = 180.0
"""Angle up to which facets form one part of a wall whose bodies have a half width."""
WALLS = "walls"
OUTLET_EVERY_S = 0.02
"""Longest time between outputs of a scene with outlets [s]."""
NOT_HELD = "shapes of walls, random positions of spheres that do not enter later"
Expected = dict[str, tuple[Any, str]]


def of_run(folder: Path) -> dict[str, Any] | None:
    """Return the description in a run directory; None if there is none."""
    path = Path(folder) / FILE
    if not path.exists():
        return None
    try:
        found = json.loads(path.read_text())
        _ = found["materials"].items(), (found["spheres"] or found["feed"])[0]["name"], found["walls"]
        return dict(found)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, IndexError) as error:
        raise ReplayError(
            f"{path} cannot be read ({error!r}); expected the description of the run's scene: build the run again"
        ) from error


def held(folder: Path, written: Mapping[str, Any], scene: Mapping[str, Any]) -> list[Held]:
    """Compare every number of the scene that the description determines, and the spheres at the start."""
    written = expanded.in_full(written, scene)
    given = {**flat(scene), **_given_outlets(scene), **_given_widths(scene)}
    wanted = {
        **_general(written, scene),
        **_faces(written),
        **_classes(written, scene),
        **_pairs(written),
        **_liquid(written, scene),
        **_walls(written),
        **_hertz(written),
        **_effects(written, scene),
    }
    wanted |= _outlets(written)
    found = [Held(path, given.get(path, MISSING), value, f"{FILE}: {key}") for path, (value, key) in wanted.items()]
    return [*found, *_start(folder, written, scene)]


def not_held(written: Mapping[str, Any]) -> str:
    """Name the parts of a user-defined scene that are not compared."""
    found = [NOT_HELD, *expanded.not_held(written)]
    if not written["time_step"]["time_step_s"]:
        found.append("a time step that was not given")
    if written["contact"] == "hertz":
        found.append("equivalent stiffnesses and the impact speed of Hertz contacts")
    if written["effects"]["decide"] == "tolerance":
        found.append("effects and laws decided by numbers")
    return ", ".join(found)


def _general(written: Mapping[str, Any], scene: Mapping[str, Any]) -> Expected:
    results, step = written["results"], written["time_step"]
    down = written["gravity_m_per_s2"] if scene["effects"].get("gravity", True) else (0.0, 0.0, 0.0)
    shortest = min(written["duration_s"] / 50.0, OUTLET_EVERY_S if written["outlets"] else math.inf)
    found: Expected = {
        "name": (written["name"], "name"),
        "seed": (written["seed"], "seed"),
        "duration_s": (written["duration_s"], "duration_s"),
        "viscous_integration": (step["viscous_integration"], "time_step"),
        "output.interval_s": (results["interval_s"] or shortest, "results.interval_s"),
        "output.contact_windows": (results["windows"], "results.windows"),
        "output.contact_window_steps": (results["window_steps"], "results.window_steps"),
        "output.checkpoints": (results["checkpoints"], "results.checkpoints"),
        **{f"gravity_m_per_s2.{a}": (g, "gravity_m_per_s2") for a, g in zip("xyz", down, strict=True)},
    }
    found |= _blocks(written, scene)
    if step["time_step_s"]:
        found["time_step_s"] = (step["time_step_s"], "time_step.time_step_s")
    return found


def _blocks(written: Mapping[str, Any], scene: Mapping[str, Any]) -> Expected:
    """Return duration and sampling windows of a run that ends when its partition is known, for its number of equal blocks."""
    asked = written.get("until")
    if not asked:
        return {"blocks": (None, "until")} if "blocks" in scene else {}
    step, longest = scene["time_step_s"], round(written["duration_s"] / scene["time_step_s"])
    unit = plans.checkpoints_every(dict(scene), longest)
    size = unit * max(1, round((asked["block_s"] or written["duration_s"] / 20.0) / step / unit))
    most, passed = longest // size, math.ceil((asked["from_s"] or 0.0) / (size * step) - 1e-9)
    number = min(max(scene.get("blocks") or 0, passed + asked["least_blocks"]), most)
    of_each = math.ceil(written["results"]["windows"] / most)
    return {
        "blocks": (number, "until"),
        "duration_s": (number * size * step, "until"),
        "output.contact_windows": (number * of_each, "results.windows"),
    }


def _classes(written: Mapping[str, Any], scene: Mapping[str, Any]) -> Expected:
    found: Expected = {"classes": ([s["name"] for s in written["spheres"]], "spheres")}
    for kind, s in enumerate(written["spheres"], start=1):
        material, at = written["materials"][s["material"]], f"classes.{s['name']}"
        found |= {
            f"{at}.type": (kind, "order of spheres"),
            f"{at}.radius_m": (0.5 * MM * s["diameter_mm"], f"spheres {s['name']} diameter_mm"),
            f"{at}.density_kg_per_m3": (material["density_kg_per_m3"], f"materials.{s['material']}"),
            f"{at}.contact_angle_rad": (
                math.radians(_angle(material["contact_angle_deg"], 15.0)),
                f"materials.{s['material']}",
            ),
        }
        if s["count"] or s["at_mm"]:
            found[f"{at}.count"] = (s["count"] or len(s["at_mm"]), f"spheres {s['name']}")
        if s["insertion"]:
            insertion = {"profile": "constant", "pulse_share": 0.5, **s["insertion"]}
            insertion["pulses"] = insertion.get("pulses") or 1
            found |= {
                f"{at}.insertion.{k}": (insertion[k], f"spheres {s['name']} insertion")
                for k in insertion
                if k != "unusual"
            }
    return found


def _dry(written: Mapping[str, Any], a: str, b: str) -> tuple[Mapping[str, Any], str]:
    """Return the dry contact of two materials, or of one with the walls, and its key."""
    others = [b, written["wall_material"]] if b == WALLS and written["wall_material"] else [b]
    for other in others:
        for contact in written["contacts"]:
            if set(contact["between"]) == {a, other} and len(set(contact["between"])) == len({a, other}):
                return _complete(contact, written["materials"][a]), f"contacts between {a} and {other}"
    return written["materials"][a], f"materials.{a}"


def _complete(contact: Mapping[str, Any], material: Mapping[str, Any]) -> dict[str, Any]:
    """Return a contact in which the keys that are null have the values of its materials, which agree."""
    found = {key: material.get(key) if value is None else value for key, value in contact.items()}
    rolling = ("rolling_friction", "rolling_friction_m")
    if any(contact[key] is not None for key in rolling):
        found |= {key: contact[key] for key in rolling}
    return found


def _pairs(written: Mapping[str, Any]) -> Expected:
    spheres = written["spheres"]
    found: Expected = {}
    for a, one in enumerate(spheres, start=1):
        for b in (0, *range(a, len(spheres) + 1)):
            dry, key = _dry(written, one["material"], spheres[b - 1]["material"] if b else WALLS)
            r = 0.5 * MM * one["diameter_mm"]
            s = 0.5 * MM * spheres[b - 1]["diameter_mm"] if b else math.inf
            rolling = dry["rolling_friction_m"]
            if dry["rolling_friction"] is not None:
                rolling = dry["rolling_friction"] * (r if b == 0 else r * s / (r + s))
            found |= {
                f"pairs.{a}-{b}.friction": (dry["friction"], f"{key} friction"),
                f"pairs.{a}-{b}.restitution": (dry["restitution"], f"{key} restitution"),
                f"pairs.{a}-{b}.rolling_friction_m": (rolling, f"{key} rolling friction"),
            }
            if written["contact"] == "linear":
                k = dry["stiffness_N_per_m"]
                found[f"pairs.{a}-{b}.normal_stiffness_N_per_m"] = (k, f"{key} stiffness_N_per_m")
                found[f"pairs.{a}-{b}.tangential_stiffness_N_per_m"] = (RATIO * k, f"{key} stiffness_N_per_m")
    return found


def _hertz(written: Mapping[str, Any]) -> Expected:
    """Return the moduli of classes and walls, whose material is given or that of all spheres."""
    if written["contact"] == "linear":
        return {"hertz": (None, "contact")}

    def elastic(name: str) -> dict[str, float]:
        return {key: written["materials"][name][key] for key in ("youngs_modulus_Pa", "poissons_ratio")}

    of = [s["material"] for s in written["spheres"]]
    walls = elastic(written["wall_material"] or of[0])
    found: Expected = {f"hertz.walls.{key}": (value, "materials") for key, value in walls.items()}
    return {**found, "hertz.spheres": ([elastic(name) for name in of], "materials")}


def _asked(written: Mapping[str, Any], scene: Mapping[str, Any]) -> dict[str, Any]:
    """Return the effects and laws that are asked for; a pair: the dimensionless number decides between both."""
    moist = float(any(films(written, scene)))
    config = {"settings": {"effects": written["effects"], "laws": written["laws"]}, "case": {"liquid_percent": moist}}
    return {**effects.expected(config), "tangential_history": True}


def _effects(written: Mapping[str, Any], scene: Mapping[str, Any]) -> Expected:
    """Return them by path; a function in a file of the user is one of that name in a file of that name."""
    found: Expected = {}
    for effect, asked in _asked(written, scene).items():
        given, wanted = scene["effects"].get(effect), asked
        if isinstance(asked, str) and ":" in asked and _function(given) == _function(asked):
            wanted = given
        found[f"effects.{effect}"] = (wanted, "effects, laws")
    return found


def _function(law: Any) -> tuple[str, ...]:
    path, _, name = str(law).rpartition(":")
    return Path(path).name, name


def layer(part: float) -> float:
    """Return (1 + part)^3 - 1 without the difference, which has no significant digits for a thin layer."""
    return part * (3.0 + part * (3.0 + part))


def films(written: Mapping[str, Any], scene: Mapping[str, Any]) -> list[float]:
    """Return the thickness of the initial film of each class [m]; classes without a specific amount share one."""
    liquid, classes = written["liquid"], scene["classes"]
    if liquid is None:
        return [0.0] * len(classes)

    def of(some: list[Mapping[str, Any]], percent: float | None, film_um: float | None) -> float:
        if film_um is not None:
            return 1e-6 * float(film_um)
        if not percent or not some:
            return 0.0
        ball = [4.0 / 3.0 * math.pi * c["radius_m"] ** 3 * c["count"] for c in some]
        volume = sum(b * c["density_kg_per_m3"] for b, c in zip(ball, some, strict=True))
        volume *= 0.01 * percent / liquid["density_kg_per_m3"]

        def more(h: float) -> float:
            held = (b * layer(h / c["radius_m"]) for b, c in zip(ball, some, strict=True))
            return sum(held) / volume - 1.0

        return float(brentq(more, 0.0, 10.0 * max(c["radius_m"] for c in some), xtol=1e-18, rtol=1e-15))

    individual = [s["percent"] is not None or s["film_um"] is not None for s in written["spheres"]]
    common = of([c for c, o in zip(classes, individual, strict=True) if not o], liquid["percent"], liquid["film_um"])
    return [
        of([c], s["percent"], s["film_um"]) if o else common
        for c, s, o in zip(classes, written["spheres"], individual, strict=True)
    ]


def _liquid(written: Mapping[str, Any], scene: Mapping[str, Any]) -> Expected:
    thick = films(written, scene)
    if not any(thick):
        return {"liquid": (None, "liquid")}
    keys = ("surface_tension_N_per_m", "viscosity_Pa_s", "density_kg_per_m3")
    found: Expected = {f"liquid.{k}": (written["liquid"][k], f"liquid.{k}") for k in keys}
    return {**found, "liquid.initial_film_thickness_m": (max(thick), "liquid percent or film_um")}


def _word(name: str) -> str:
    """Return the name of a wall in the scene: its own, if it has up to 40 ASCII letters, digits, underscores, a letter first."""
    if re.fullmatch(r"[A-Za-z]\w{0,39}", name, re.ASCII):
        return name
    bare = unicodedata.normalize("NFKD", name)
    runs = "".join(c if c.isascii() and c.isalnum() else " " for c in bare if not unicodedata.combining(c)).split()
    latin = "_".join(runs)[:20]
    digest = hashlib.sha256(name.encode()).hexdigest()[:6]
    return f"{latin}_{digest}" if latin[:1].isalpha() else f"wall_{digest}"


def _angle(*given: float | None) -> float:
    """Return the first contact angle that is given [deg]."""
    return next(a for a in given if a is not None)


def _walls(written: Mapping[str, Any]) -> Expected:
    words = [_word(w["name"]) for w in written["walls"]]
    material = written["materials"].get(written["wall_material"]) or {"contact_angle_deg": None}
    found: Expected = {"walls": (words, "walls")}
    for word, w in zip(words, written["walls"], strict=True):
        at, key = f"walls.{word}", f"walls {w['name']}"
        angle = _angle(w["contact_angle_deg"], material["contact_angle_deg"], 40.0)
        found[f"{at}.contact_angle_rad"] = (math.radians(angle), f"{key} contact_angle_deg")
        found |= {f"{at}.motion_parameters.{k}": (v, f"{key} {m}") for k, v, m in _motion(w, written["origin_mm"])}
        if not any(w[m] for m in MOTIONS):
            found[f"{at}.motion"], found[f"{at}.motion_parameters"] = ("fixed", key), (None, key)
        if "feature_angle_deg" in w:  # not of a deck's walls
            width = 0.5 * w["bars"]["diameter_mm"] if w["bars"] else w["half_width_mm"]
            angle = w["feature_angle_deg"] if width is None else BODIES_DEG
            if width is not None:
                found[f"{at}.part_half_width_m"] = (MM * width, f"{key} half_width_mm or bars")
            found[f"{at}.feature_angle_deg"] = (angle, f"{key} feature_angle_deg")
    return found


def _given_widths(scene: Mapping[str, Any]) -> dict[str, Any]:
    """Return the half width of the parts of each wall, all of them if they differ."""
    widths = {w["name"]: list(dict.fromkeys(w["part_half_width_m"])) for w in scene["walls"]}
    return {f"walls.{name}.part_half_width_m": w[0] if len(w) == 1 else w for name, w in widths.items()}


def _faces(written: Mapping[str, Any]) -> Expected:
    """Return the periodic axis of the scene, and its faces in the single precision of walls."""
    periodic = written.get("periodic")
    if not periodic:
        return {"periodic": (None, "periodic")}
    k = "xyz".index(periodic["axis"])
    ends = {b: float(np.float32(MM * (periodic[f"{b}_mm"] - written["origin_mm"][k]))) for b in ("low", "high")}
    found: Expected = {f"box_{b}_m.{'xyz'[k]}": (v, f"periodic {b}_mm") for b, v in ends.items()}
    return {"periodic": (periodic["axis"], "periodic axis"), **found}


def _outlets(written: Mapping[str, Any]) -> Expected:
    """Return names, bounds relative to the origin, and products: as given, or that with which the name begins."""
    found: Expected = {"outlets": ([o["name"] for o in written["outlets"]], "outlets")}
    for o in written["outlets"]:
        at, key = f"outlets.{o['name']}", f"outlets {o['name']}"
        begins = [p for p in ("overs", "middlings", "lower_middlings", "unders") if o["name"].startswith(p)]
        above = o.get("crossing_above_mm")
        wanted = None if above is None else MM * (above - written["origin_mm"][2])
        found[f"{at}.crossing_above_m"] = (wanted, f"{key} crossing_above_mm")
        moves = o.get("moves_with")
        found[f"{at}.moves_with"] = (None if moves is None else _word(moves), f"{key} moves_with")
        found[f"{at}.product"] = (o["product"] or (begins[0] if begins else None), f"{key} product")
        for bound in ("low", "high"):
            for axis, value, x in zip("xyz", o[f"{bound}_mm"], written["origin_mm"], strict=True):
                wanted = None if value is None else MM * (value - x)
                found[f"{at}.{bound}_m.{axis}"] = (wanted, f"{key} {bound}_mm")
    return found


def _given_outlets(scene: Mapping[str, Any]) -> dict[str, Any]:
    """Return the scene's outlets, path by path."""
    outlets = scene.get("outlets") or []
    found: dict[str, Any] = {"outlets": [o["name"] for o in outlets]}
    for o in outlets:
        found[f"outlets.{o['name']}.product"] = o["product"]
        found[f"outlets.{o['name']}.crossing_above_m"] = o.get("crossing_above_m")
        found[f"outlets.{o['name']}.moves_with"] = o.get("moves_with")
        for bound in ("low_m", "high_m"):
            found |= {f"outlets.{o['name']}.{bound}.{axis}": v for axis, v in zip("xyz", o[bound], strict=True)}
    return found


MOTIONS = ("vibrates", "turns", "moves", "removed")


def _motion(wall: Mapping[str, Any], origin: list[float]) -> Iterator[tuple[str, Any, str]]:
    """Yield the numbers of a wall's motion, except those of a removed wall that follow from its shape."""
    if v := wall["vibrates"]:
        yield "frequency_Hz", v["frequency_Hz"], "vibrates"
        for axis, a, p in zip("xyz", v["amplitude_mm"], v["phase_deg"], strict=True):
            yield f"amplitude_m.{axis}", MM * a, "vibrates amplitude_mm"
            yield f"phase_rad.{axis}", math.radians(p), "vibrates phase_deg"
    if t := wall["turns"]:
        yield "period_s", 60.0 / t["turns_per_minute"], "turns turns_per_minute"
        axis_of = np.array(t["axis"], dtype=float) / np.linalg.norm(t["axis"])
        for axis, a, o, x in zip("xyz", axis_of.tolist(), t["origin_mm"], origin, strict=True):
            yield f"axis.{axis}", a, "turns axis"
            yield f"origin_m.{axis}", MM * (o - x), "turns origin_mm"
    if m := wall["moves"]:
        yield "opens_at_s", m["from_s"], "moves from_s"
        yield "travel_s", m["for_s"], "moves for_s"
        for axis, v in zip("xyz", m["velocity_m_per_s"], strict=True):
            yield f"velocity_m_per_s.{axis}", v, "moves velocity_m_per_s"
    if r := wall["removed"]:
        yield "opens_at_s", r["at_s"], "removed at_s"
        way = r["speed_m_per_s"] * np.array(r["towards"], dtype=float) / np.linalg.norm(r["towards"])
        for axis, v in zip("xyz", way.tolist(), strict=True):
            yield f"velocity_m_per_s.{axis}", v, "removed towards, speed_m_per_s"


def _start(folder: Path, written: Mapping[str, Any], scene: Mapping[str, Any]) -> Iterator[Held]:
    """Compare given positions, velocities, films, and initial positions of spheres that enter later."""
    table = every(folder / scene["spheres_file"]).sort_values("id")
    first = every(folder / "history" / "spheres.parquet").sort_values("id")
    kind, x = table["type"].to_numpy(), table[["x", "y", "z"]].to_numpy(float)
    v, thick = table[["vx", "vy", "vz"]].to_numpy(float), films(written, scene)
    origin = np.array(written["origin_mm"], dtype=float)
    for k, s in enumerate(written["spheres"], start=1):
        at, r = kind == k, 0.5 * MM * s["diameter_mm"]
        source = f"{FILE}: spheres {s['name']}"
        yield from _vectors(f"velocity of {s['name']}", v[at], np.array(s["velocity_m_per_s"]), source, 1.0)
        film = amounts.film_volume(thick[k - 1], r)
        given = first["film"].to_numpy(float)[first["type"].to_numpy() == k]
        worst = given[int(np.argmax(np.abs(given - film)))] if len(given) else film
        yield Held(f"first film of {s['name']} [m3]", float(worst), film, f"{source} liquid")
        if s["at_mm"]:
            places = MM * (np.array(s["at_mm"], dtype=float) - origin)
            yield from _vectors(f"position of {s['name']}", x[at], places, f"{source} at_mm", r)
    waits = inserted.places(written, scene, thick)
    for k, places in waits.items():
        name, r = written["spheres"][k - 1]["name"], 0.5 * MM * written["spheres"][k - 1]["diameter_mm"]
        yield from _vectors(
            f"position of {name}, waiting to enter",
            x[kind == k],
            places,
            f"{FILE}: seed, insertion and region of {name}",
            r,
        )


def _vectors(name: str, given: Floats, wanted: Floats, source: str, scale: float) -> Iterator[Held]:
    """Compare the row with the largest deviation, component by component."""
    wanted = np.broadcast_to(wanted, given.shape) if wanted.ndim == 1 or len(wanted) == len(given) else wanted
    if wanted.shape != given.shape:
        yield Held(f"number of rows: {name}", len(given), len(wanted), source)
        return
    if len(given):
        row = int(np.argmax(np.abs(given - wanted).max(axis=1)))
        for axis, a, b in zip("xyz", given[row], wanted[row], strict=True):
            yield Held(f"{name}, {axis} (row {row + 1})", float(a), float(b), source, scale=scale)
