"""Expected content of scene.json by the configuration: every number, name and switch by its path, with its source."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from reference_impl.scene import amounts, effects, tower
from reference_impl.scene.amounts import Class
from reference_impl.scene.configuration import OF_OUTPUT, OF_TIME, contact, near, number, reading

GRAVITY = 9.81
MARGIN = 0.010
"""Margin between the walls, over their whole motion, and the box [m]."""
Expected = dict[str, tuple[Any, str]]
"""Path in the scene -> value, and its position in the configuration. A tuple as value: one of them."""


def scene(config: Mapping[str, Any], given: Mapping[str, Any]) -> Expected:
    """Return the expected scene; from `given` only results of the plan's numbers are taken."""
    of, pairs, chosen = amounts.classes(config), contacts(config), effects.expected(config)
    found: Expected = {
        "name": (f"case{int(config['case']['case']):02d}", "cases.csv: case"),
        "seed": (config["settings"]["seed"], "config.yaml: seed"),
        **_classes(config, of),
        **{f"pairs.{p['a']}-{p['b']}.{k}": (v, _of_pair(config, p, k)) for p in pairs for k, v in p.items()},
        **_liquid(config, of),
        **_motion(config),
        **{f"effects.{k}": (v, "config.yaml: effects, laws") for k, v in chosen.items()},
        **_walls(config),
        **_times(config),
    }
    on = {**given["effects"], **{k: v for k, v in chosen.items() if not isinstance(v, tuple)}}
    down = -GRAVITY if on.get("gravity", True) else 0.0
    found |= {
        f"gravity_m_per_s2.{axis}": (g, "9.81 m/s2 downwards") for axis, g in zip("xyz", (0, 0, down), strict=True)
    }
    settings = config["settings"]["time_step"]
    every, explicit = (settings.get(k, OF_TIME[k]) for k in ("bridges_every", "viscous_integration"))
    found["viscous_integration"] = (explicit, "config.yaml: time_step.viscous_integration")
    found["bridges_every"] = (every if on["bridges"] else 1, "config.yaml: time_step.bridges_every")
    damped = on["bridges"] and on.get("viscous_normal") and explicit == "explicit"
    viscosity = number(config["materials"]["liquid"], "viscosity_Pa_s") if damped else 0.0
    step = amounts.time_step(of, pairs, number(settings, "fraction"), viscosity)
    found["time_step_s"] = (step, "config.yaml: time_step.fraction of the shortest collision")
    return found


def _classes(config: Mapping[str, Any], of: Sequence[Class]) -> Expected:
    material = config["case"]["material"]
    angle = math.radians(number(config["materials"]["spheres"][material], "contact_angle_deg"))
    of_material = f"materials.yaml: spheres.{material}"
    found: Expected = {"classes": ([c.name for c in of], "the size classes of a case")}
    for kind, c in enumerate(of, 1):
        rows = {
            "type": (kind, "small, near_mesh, large in order"),
            "radius_m": (c.radius, f"{of_material}.sizes diameter_mm"),
            "density_kg_per_m3": (c.density, f"{of_material}.sizes density_kg_per_m3"),
            "contact_angle_rad": (angle, f"{of_material}.contact_angle_deg"),
            "count": (c.count, "materials.yaml: feed.class_mass_g on the sieve's area"),
            "passes_aperture": (c.passes, "cases.csv: aperture_mm"),
            "insertion": (None, "all are there from the start"),
        }
        found |= {f"classes.{c.name}.{key}": value for key, value in rows.items()}
    return found


def contacts(config: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the dry contacts of all pairs of types (b = 0: walls), in the form of the scene."""
    data, material = config["materials"], config["case"]["material"]
    spheres, factor = data["spheres"][material], number(config["scale"], "stiffness_factor")
    found = []
    for a in range(1, len(amounts.NAMES) + 1):
        for b in (0, *range(a, len(amounts.NAMES) + 1)):
            partner = material if b else data["wall_materials"]["wires"]["material"]
            dry = contact(data, material, partner)
            k = factor * number(spheres, f"stiffness_sphere_{'sphere' if b else 'wall'}_N_per_m")
            found.append(
                {
                    "a": a,
                    "b": b,
                    "normal_stiffness_N_per_m": k,
                    "tangential_stiffness_N_per_m": k * number(data, "tangential_stiffness_ratio"),
                    **{name: number(dry, name) for name in ("friction", "rolling_friction_m", "restitution")},
                }
            )
    return found


def _of_pair(config: Mapping[str, Any], pair: Mapping[str, Any], key: str) -> str:
    material = config["case"]["material"]
    if "stiffness" in key:
        ratio = " x tangential_stiffness_ratio" if key.startswith("tangential") else ""
        of = "sphere" if pair["b"] else "wall"
        return (
            f"materials.yaml: spheres.{material}.stiffness_sphere_{of}_N_per_m x scales.yaml: stiffness_factor{ratio}"
        )
    return f"materials.yaml: contacts of {material} with {material if pair['b'] else 'the walls'}, {key}"


def _liquid(config: Mapping[str, Any], of: Sequence[Class]) -> Expected:
    if float(config["case"]["liquid_percent"]) == 0.0:
        return {"liquid": (None, "cases.csv: liquid_percent 0")}
    keys = ("surface_tension_N_per_m", "viscosity_Pa_s", "density_kg_per_m3")
    found: Expected = {
        f"liquid.{k}": (number(config["materials"]["liquid"], k), f"materials.yaml: liquid.{k}") for k in keys
    }
    found["liquid.initial_film_thickness_m"] = (
        amounts.film(of, config),
        "cases.csv: liquid_percent of the spheres' mass",
    )
    return found


def _motion(config: Mapping[str, Any]) -> Expected:
    motion = config["materials"]["motion"]
    peak = {"zero_to_peak": 1e-3, "peak_to_peak": 0.5e-3}[reading(config, "amplitude", "zero_to_peak")]
    stroke, found = near(motion["strokes"], "set_amplitude_mm", float(config["case"]["set_amplitude_mm"])), {}
    for axis in "xyz":
        amplitude, phase = f"{axis}_amplitude_mm", f"{axis}_phase_deg"
        found[f"vibration.amplitude_m.{axis}"] = (
            peak * number(stroke, amplitude),
            f"materials.yaml: motion.strokes {amplitude}, config.yaml: readings.amplitude",
        )
        found[f"vibration.phase_rad.{axis}"] = (math.radians(number(motion, phase)), f"materials.yaml: motion.{phase}")
    found["vibration.frequency_Hz"] = (number(motion, "frequency_Hz"), "materials.yaml: motion.frequency_Hz")
    return found


def _walls(config: Mapping[str, Any]) -> Expected:
    data, analytic_wires = config["materials"], config["scale"].get("wires", "mesh") == "analytic"
    found: Expected = {"walls": (list(tower.MOTION), "the parts of the tower in order")}
    for name, motion in tower.MOTION.items():
        reservoir = "feed_bin" if name == "cover" else name
        material = data["wall_materials"][reservoir]["material"]
        angle = math.radians(number(data["walls"][material], "contact_angle_deg"))
        rows = {
            "reservoir": (reservoir, "the part it is; the cover is the feed bin's"),
            "stl": (f"stl/{name}.stl", "the part it is"),
            "motion": (motion, "docs/geometry.md"),
            "contact_angle_rad": (angle, f"materials.yaml: walls.{material}.contact_angle_deg"),
            "analytic_wires": (analytic_wires and name == "wires", "scales.yaml: wires"),
            "motion_parameters": (None, "walls of a case share the scene's motions"),
            "feature_angle_deg": (None, "the parts of a case's walls are those of the tower"),
        }
        found |= {f"walls.{name}.{key}": value for key, value in rows.items()}
    return found


def _times(config: Mapping[str, Any]) -> Expected:
    scale, heights = config["scale"], tower.Heights.of(config)
    speed = number(config["apparatus"], "slide_speed_m_per_s")
    written = {**OF_OUTPUT, **(config["settings"].get("output") or {})}
    found: Expected = {
        "duration_s": (number(scale, "duration_s"), "scales.yaml: duration_s"),
        "output.interval_s": (number(scale, "output_interval_s"), "scales.yaml: output_interval_s"),
        **{f"output.{key}": (written[key], f"config.yaml: output.{key}") for key in OF_OUTPUT},
        "slide.opens_at_s": (number(scale, "slide_opens_at_s"), "scales.yaml: slide_opens_at_s"),
        "slide.travel_s": (
            2.0 * tower.Plan.of(config).half_slide / speed,
            "the slide's length over scales.yaml: slide_speed_m_per_s",
        ),
        "screen_z_m": (0.0, "the screen's plane"),
        "bin_z_m": (heights.bin, "wire diameter, scales.yaml: outlet_height_mm and clearance_mm"),
        "rotation": (None, "nothing turns"),
        "hertz": (None, "contacts of a case are linear springs"),
        "retire": (_retires(config), "config.yaml: retire"),
        "outlets": ([], "a case has a collecting bin"),
        "created_ahead_s": (None, "all spheres are there from the start"),
        "periodic": (None, "a case has no periodic faces"),
        "blocks": (None, "a case runs for its duration"),
        "contacts": (config["settings"].get("contacts", "planes"), "config.yaml: contacts"),
        "wall_film": (reading(config, "wall_film", "triangle"), "config.yaml: readings"),
    }
    along = zip("xyz", (speed, 0.0, 0.0), strict=True)
    return {**found, **{f"slide.velocity_m_per_s.{axis}": (v, "scales.yaml: slide_speed_m_per_s") for axis, v in along}}


def _retires(config: Mapping[str, Any]) -> bool:
    """Return whether spheres are retired: as set, otherwise if it saves half of a plugin run (0.93 of the time from 3.3 s on)."""
    settings, scale = config["settings"], config["scale"]
    switch, output = settings.get("retire", "auto"), {**OF_OUTPUT, **(settings.get("output") or {})}
    if switch in (True, False, "on", "off"):
        return switch in (True, "on")
    wanted = effects.expected(config)
    moist = bool(wanted["bridges"])
    after = number(scale, "duration_s") - number(scale, "slide_opens_at_s")
    barred = output["checkpoints"] == 0 or wanted["shedding"] is not None or (moist and output["energy"])
    attached = moist or scale.get("wires", "mesh") == "analytic"
    falls = settings["effects"].get("gravity", "auto") not in (False, "off")
    return bool(attached and falls and not barred and after > 0 and 0.93 * (1.0 - 3.3 / after) >= 0.5)


def flat(scene: Mapping[str, Any]) -> dict[str, Any]:
    """Return path -> value of a scene; classes and walls by name, pairs by their types, vectors by axis."""
    found: dict[str, Any] = {}

    def put(path: str, value: Any) -> None:
        if isinstance(value, Mapping):
            for key, inner in value.items():
                put(f"{path}.{key}" if path else key, inner)
        elif isinstance(value, list) and len(value) == 3 and all(isinstance(v, int | float) for v in value):
            for axis, inner in zip("xyz", value, strict=True):
                put(f"{path}.{axis}", inner)
        else:
            found[path] = value

    named = {
        "classes": {c["name"]: {"insertion": None, **_but(c, "name")} for c in scene["classes"]},
        "pairs": {f"{p['a']}-{p['b']}": p for p in scene["pairs"]},
        "walls": {
            w["name"]: {"motion_parameters": None, "feature_angle_deg": None, **_but(w, "name", *OF_THE_MESH)}
            for w in scene["walls"]
        },
    }
    put("", {"hertz": None, "wall_film": "triangle", "outlets": [], "created_ahead_s": None, **scene, **named})
    for key in ("classes", "walls"):
        found[key] = [row["name"] for row in scene[key]]
    return found


def _but(row: Mapping[str, Any], *names: str) -> dict[str, Any]:
    return {k: v for k, v in row.items() if k not in names}


OF_THE_MESH = ("triangle_part", "part_half_width_m")
"""Fields of a wall that are compared with its STL file (walls.py)."""
