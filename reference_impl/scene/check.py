"""Section `scene` of a replay: the simulated scene compared with the configuration in the run directory."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from reference_impl.diagnosis.held import MISSING, NONE, Held, Section
from reference_impl.replay import io, script
from reference_impl.scene import configuration, deck, described, effects, files, numbers, parts, plan, start, walls

NAME = "scene"
NOT_HELD = ("largest_overlap", "transfer_nodes", "spheres_file")
"""Fields of a scene that no configuration sets."""


def check(folder: Path, config: Mapping[str, Any] | None = None) -> Section:
    """Compare the scene with its configuration; `config` replaces the run's copy. Without either it never agrees."""
    section, run = Section(NAME), Path(folder)
    config = configuration.of_run(run) if config is None else config
    if config is None:
        scene = io.scene(run)
        if any(wall.get("feature_angle_deg") is not None for wall in scene["walls"]):
            meshes = walls.read(run, scene) if script.of(run) is None else walls.by_table(run, scene)
            section.add(
                "scene_parts",
                "itself",
                [*parts.derived(scene, meshes)],
                "walls whose parts follow from a feature angle",
            )
            section.add("scene_tables", "itself", walls.tables(run, scene, meshes), "columns of triangles and parts")
        if (description := described.of_run(run)) is None:
            section.not_checked.append(f"scene: no configuration ({configuration.FILE}) in the run directory")
        else:
            _user_defined(section, run, description, scene)
        return section
    scene = io.scene(run)
    try:
        _compare(section, run, dict(config), scene)
    except (KeyError, TypeError, ValueError, StopIteration, IndexError, AttributeError, ArithmeticError) as error:
        raise io.ReplayError(
            f"{run}: scene.json and {configuration.FILE} cannot be compared ({error!r}); expected both as "
            "`pywet run` writes them: build the run again"
        ) from error
    return section


def _user_defined(section: Section, run: Path, description: dict[str, Any], scene: dict[str, Any]) -> None:
    try:
        held = described.held(run, description, scene)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, ArithmeticError) as error:
        raise io.ReplayError(
            f"{run}: scene.json and {described.FILE} do not describe the same scene ({error!r}); expected both of one run: "
            "build the run again"
        ) from error
    section.add("scene_description", "itself", held, f"numbers of the scene against {described.FILE}")
    if scene["effects"]["bridges"] and plan.there(run):
        section.add("scene_plan", "itself", [*plan.compared(run, scene, case=False)], "numbers that decide effects")
    if scene["effects"]["bridges"] and (run / "history" / "meta.json").exists():
        section.add("scene_told", "itself", _passed_to_plugin(run, scene), "numbers passed to the plugin")
    section.not_checked.append(f"scene: {described.not_held(description)}")


def _compare(section: Section, run: Path, config: dict[str, Any], scene: dict[str, Any]) -> None:
    edited = config.get(configuration.EDITED, [])
    wanted, given = numbers.scene(config, scene), numbers.flat(scene)
    stored = {path: value for path, value in wanted.items() if not _is_edited(path, edited)}
    held = [Held(path, given.get(path, MISSING), value, source) for path, (value, source) in stored.items()]
    held += [Held(path, given[path], NONE, "the scene of a case") for path in given if _beyond(path, wanted, edited)]
    if (texts := files.of_run(run)) is not None:
        values = files.held(texts, config)
        section.add("scene_configuration", "itself", values, f"values of {configuration.FILE} against the files")
        section.not_checked += files.not_checked(texts)
    section.add("scene_numbers", "itself", held, f"numbers of scene.json against {configuration.FILE}")
    meshes = walls.read(run, scene)
    section.add("scene_walls", "itself", walls.measured(config, scene, meshes), "lengths measured on the STL files")
    section.add("scene_tables", "itself", walls.tables(run, scene, meshes), "columns of triangles and parts")
    section.add("scene_start", "itself", start.starts(run, config, scene), "numbers of the start")
    if scene["effects"]["bridges"] and (run / "history" / "meta.json").exists():
        section.add("scene_told", "itself", _passed_to_plugin(run, scene), "numbers passed to the plugin")
    if deck.there(run):
        section.add("scene_deck", "itself", deck.read(run, scene, _resumed(run)), "numbers of the deck")
    else:
        section.not_checked.append("scene: the deck, of which there is none in engine/")
    if plan.there(run) and not edited:
        section.add("scene_plan", "itself", [*plan.compared(run, scene, case=True)], "numbers that decide effects")
    if edited:
        section.not_checked.append(f"scene: set by hand after the configuration: {', '.join(edited)}")
    if any(isinstance(value, tuple) for path, (value, _) in stored.items() if path.startswith("effects.")):
        section.not_checked.append(f"scene: {effects.DECIDED}")
    section.not_checked.append(
        f"scene: where the seed puts the spheres, and what no configuration sets: {', '.join(NOT_HELD)}"
    )


def _is_edited(path: str, edited: list[str]) -> bool:
    """Return whether a field, or one within it, was set explicitly; `classes.count` represents that of every class."""
    parts = path.split(".")
    short = ".".join([parts[0], *parts[2:]])
    return any(name in (path, short) or path.startswith(f"{name}.") for name in edited)


def _beyond(path: str, wanted: Mapping[str, Any], edited: list[str]) -> bool:
    """Return whether a field of the scene is not determined by the configuration, except effects and box."""
    known = path in wanted or path in NOT_HELD or _is_edited(path, edited)
    return not known and not path.startswith(("effects.", "box_"))


def _passed_to_plugin(run: Path, scene: Mapping[str, Any]) -> list[Held]:
    """Compare history/meta.json, which is passed to the plugin, with the scene."""
    meta, liquid = json.loads((run / "history" / "meta.json").read_text()), scene["liquid"]
    source = "scene.json"
    found = [
        Held("meta.surface_tension", meta["surface_tension"], liquid["surface_tension_N_per_m"], source),
        Held("meta.viscosity", meta["viscosity"], liquid["viscosity_Pa_s"], source),
        Held("meta.time_step", meta["time_step"], scene["time_step_s"], source),
        *(
            Held(f"meta.effects.{name}", meta["effects"].get(name), value, source)
            for name, value in scene["effects"].items()
        ),
    ]
    for reported, c in zip(meta["types"], scene["classes"], strict=True):
        for key, name in (
            ("radius", "radius_m"),
            ("contact_angle", "contact_angle_rad"),
            ("density", "density_kg_per_m3"),
        ):
            found.append(Held(f"meta.{c['name']}.{key}", reported[key], c[name], source))
    return found


def _resumed(run: Path) -> int:
    """Return the step from which the run of this deck resumed."""
    path = run / "engine" / "run.json"
    return int(json.loads(path.read_text()).get("resumed_at_step") or 0) if path.exists() else 0
