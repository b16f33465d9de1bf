"""Build the scene and the initial run directory of one screening case at one scale from the configuration."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from pywet.cases.screening import amounts
from pywet.config import Case, Config, Scale, texts
from pywet.config.cases import CLASS_NAMES
from pywet.engines.schedule import early_end
from pywet.errors import PywetError
from pywet.geometry import Apparatus, ApparatusSpec, Surface, build_apparatus, fill
from pywet.geometry.initial import wall_mesh, write_initial
from pywet.geometry.motion import peak_speed
from pywet.planning import step_choice, time_steps
from pywet.planning.effect_plan import EffectPlan
from pywet.planning.effect_plan import plan as plan_effects
from pywet.planning.retirement import Retirement, decide
from pywet.planning.surroundings import GRAVITY
from pywet.scene import ContactPair, EngineScene, Liquid, Output, Slide, SphereClass, Vibration, WallMesh
from pywet.util.files import write_json
from pywet.util.notices import notice

WORTH_SAYING = 1.5
"""Ratio of time steps from which a longer possible step is reported."""


@dataclass(frozen=True)
class Ingredients:
    """A case at a scale without its walls: enough for the effect plan and the time step."""

    classes: tuple[SphereClass, ...]
    pairs: tuple[ContactPair, ...]
    liquid: Liquid | None
    vibration: Vibration
    plan: EffectPlan
    retirement: Retirement
    time_step_s: float


def ingredients(config: Config, case_number: int, scale_name: str) -> Ingredients:
    """Spheres, dry contacts, liquid, motion, effect plan and time step of a case; quick, writes nothing."""
    case, scale = config.case(case_number), config.scale(scale_name)
    classes = sphere_classes(config, case, scale)
    pairs = contact_pairs(config, case, scale)
    liquid = liquid_of(config, case, classes)
    vibration = vibration_of(config, case)
    settings = config.settings
    chosen = replace(
        plan_effects(classes, pairs, liquid, peak_speed(vibration), settings.effects, settings.laws_as_read),
        amounts=amounts.amounts_of(config, case, scale),
    )
    if chosen.effects.bridges:
        refuse_unwetted(config, case, walls=chosen.effects.wall_films)
    how = settings.time_step.viscous_integration
    time_steps.refuse_nonlinear_drag(chosen.effects, how, "time_step.viscous_integration", "config.yaml")
    explicit = how == "explicit"
    viscosity = liquid.viscosity_Pa_s if liquid and chosen.effects.viscous_normal and explicit else 0.0
    step = step_choice.of_collisions(pairs, classes, settings.time_step.fraction.value, viscosity)
    gravity = (0.0, 0.0, -GRAVITY if chosen.effects.gravity else 0.0)
    plugin = chosen.effects.bridges or scale.wires == "analytic"
    after = scale.duration_s.value - scale.slide_opens_at_s.value
    retirement = decide(settings.retire, chosen.effects, output_of(config, scale), gravity, plugin, after)
    return Ingredients(classes, pairs, liquid, vibration, chosen, retirement, step)


def output_of(config: Config, scale: Scale) -> Output:
    """Return the times at which results and logs of a case are written."""
    return Output(interval_s=scale.output_interval_s.value, **config.settings.output.model_dump())


def longer_by(config: Config, case_number: int, scale_name: str) -> float:
    """Return the factor by which the time step would be longer without the viscous limit; 1 if that does not limit it."""
    made, fraction = ingredients(config, case_number, scale_name), config.settings.time_step.fraction.value
    return step_choice.of_collisions(made.pairs, made.classes, fraction) / made.time_step_s


def shorter_step(config: Config, case_number: int, scale_name: str) -> str | None:
    """Suggest settings if the viscous force makes the time step of a case much shorter than the collision does."""
    times = longer_by(config, case_number, scale_name)
    if times < WORTH_SAYING:
        return None
    return (
        f"the viscous force governs the time step: `time_step.viscous_integration: semi_implicit` in config.yaml makes steps "
        f"{times:.1f} times as long"
    )


def refuse_unwetted(config: Config, case: Case, walls: bool) -> None:
    """Raise for a bridge with a contact angle of 90 deg or more, for which no bridge law is valid."""
    data = config.materials
    reservoirs = {choice.material for _, choice in data.wall_materials} if walls else set()
    angles = {f"spheres.{case.material}": data.sphere(case.material).contact_angle_deg.value}
    angles |= {f"walls.{name}": data.walls[name].contact_angle_deg.value for name in sorted(reservoirs)}
    for name, angle in angles.items():
        if angle >= 90.0:
            raise PywetError(
                f"materials.yaml: {name}.contact_angle_deg is {angle:g} in moist case {case.case}, expected 0 to below 90 "
                "(or effects.bridges off in config.yaml)",
                code="case.not_wetted", key=f"{name}.contact_angle_deg", given=angle, where="materials.yaml",
            )  # fmt: skip


def planned(made: Ingredients) -> dict[str, Any]:
    """Return the content of plan.json: the effect plan, and whether spheres are retired."""
    return {**made.plan.as_dict(), "retirement": asdict(made.retirement)}


def build(
    config: Config, case_number: int, scale_name: str, run_dir: Path, begin: Callable[[], object] = lambda: None
) -> EngineScene:
    """Write a case's run directory and return its scene; `begin` is called when all is built, before anything is written.

    Writes stl/, spheres.parquet, scene.json, plan.json, config.json, config_files.json, history/spheres, triangles, parts.
    The same configuration gives the same files. Raises `PywetError` for an inconsistent configuration.
    """
    run_dir = Path(run_dir)
    case, scale = config.case(case_number), config.scale(scale_name)
    made = ingredients(config, case_number, scale_name)
    apparatus = build_apparatus(apparatus_spec(config, case, scale))
    scene = assemble(config, case, scale, made, apparatus)
    for sentence in early_end(scene):
        notice.warning("%s: %s", scene.name, sentence)
    spheres = fill(scene.classes, apparatus.feed_region, scene.seed)
    begin()
    write_initial(scene, apparatus.surfaces, spheres, run_dir)
    write_json(run_dir / "plan.json", planned(made))
    write_json(run_dir / "config.json", config.resolved(case_number, scale_name))
    write_json(run_dir / "config_files.json", texts(config))
    return scene


def assemble(config: Config, case: Case, scale: Scale, made: Ingredients, apparatus: Apparatus) -> EngineScene:
    speed = config.apparatus.slide_speed_m_per_s.value
    return EngineScene(
        name=case.name,
        seed=config.settings.seed,
        classes=made.classes,
        pairs=made.pairs,
        liquid=made.liquid,
        walls=tuple(mesh_of(config, scale, surface) for surface in apparatus.surfaces),
        vibration=made.vibration,
        slide=Slide(
            velocity_m_per_s=(speed, 0.0, 0.0),
            opens_at_s=scale.slide_opens_at_s.value,
            travel_s=apparatus.slide_travel / speed,
        ),
        effects=made.plan.effects,
        gravity_m_per_s2=(0.0, 0.0, -GRAVITY if made.plan.effects.gravity else 0.0),
        viscous_integration=config.settings.time_step.viscous_integration,
        bridges_every=config.settings.time_step.bridges_every if made.plan.effects.bridges else 1,
        contacts=config.settings.contacts,
        wall_film=config.settings.readings.wall_film,
        box_low_m=apparatus.box_low,
        box_high_m=apparatus.box_high,
        spheres_file=Path("spheres.parquet"),
        time_step_s=made.time_step_s,
        duration_s=scale.duration_s.value,
        output=output_of(config, scale),
        screen_z_m=apparatus.screen_z,
        bin_z_m=apparatus.bin_z,
        retire=made.retirement.on,
    )


def sphere_classes(config: Config, case: Case, scale: Scale) -> tuple[SphereClass, ...]:
    """The classes small, near_mesh, large (types 1, 2, 3) with their counts."""
    counts = [a.count for a in amounts.amounts_of(config, case, scale)]
    angle = config.materials.sphere(case.material).contact_angle_deg.value
    classes = []
    for kind, (name, diameter, count) in enumerate(zip(CLASS_NAMES, case.diameters_mm, counts, strict=True), start=1):
        size = config.size(case.material, diameter)
        classes.append(
            SphereClass(
                name=name,
                type=kind,
                radius_m=size.radius_m,
                density_kg_per_m3=size.density_kg_per_m3.value,
                contact_angle_rad=math.radians(angle),
                count=count,
                passes_aperture=diameter < case.aperture_mm,
            )
        )
    return tuple(classes)


def contact_pairs(config: Config, case: Case, scale: Scale) -> tuple[ContactPair, ...]:
    """Return the dry contacts of all types with each other and with walls (b = 0), softened by the scale's factor."""
    data, factor = config.materials, scale.stiffness_factor.value
    material = data.sphere(case.material)
    kinds = range(1, len(CLASS_NAMES) + 1)
    pairs = []
    for a, b in [(a, b) for a in kinds for b in (0, *kinds) if b == 0 or a <= b]:
        contact = data.contact(case.material, case.material) if b else data.wall_contact(case.material)
        entry = material.stiffness_sphere_sphere_N_per_m if b else material.stiffness_sphere_wall_N_per_m
        friction, rolling, restitution = contact.numbers
        pairs.append(
            ContactPair(
                a=a,
                b=b,
                normal_stiffness_N_per_m=factor * entry.value,
                tangential_stiffness_N_per_m=data.tangential_stiffness_ratio.value * factor * entry.value,
                friction=friction,
                rolling_friction_m=rolling,
                restitution=restitution,
            )
        )
    return tuple(pairs)


def liquid_of(config: Config, case: Case, classes: tuple[SphereClass, ...]) -> Liquid | None:
    """The liquid as the same film on every sphere; None for a dry case."""
    if case.liquid_percent == 0:
        return None
    data = config.materials.liquid_named(case.liquid)
    volume = amounts.liquid_volume(classes, config.liquid_percent(case.case), data.density_kg_per_m3.value)
    return Liquid(
        surface_tension_N_per_m=data.surface_tension_N_per_m.value,
        viscosity_Pa_s=data.viscosity_Pa_s.value,
        density_kg_per_m3=data.density_kg_per_m3.value,
        initial_film_thickness_m=amounts.common_film_thickness(classes, volume),
    )


def vibration_of(config: Config, case: Case) -> Vibration:
    motion, stroke = config.materials.motion, config.materials.stroke(case.set_amplitude_mm)
    x, y, z = stroke.x_amplitude_mm.value, stroke.y_amplitude_mm.value, stroke.z_amplitude_mm.value
    u, v, w = (math.radians(p.value) for p in (motion.x_phase_deg, motion.y_phase_deg, motion.z_phase_deg))
    share = config.settings.readings.stroke_share
    amplitude = (share * 1e-3 * x, share * 1e-3 * y, share * 1e-3 * z)
    return Vibration(amplitude_m=amplitude, phase_rad=(u, v, w), frequency_Hz=motion.frequency_Hz.value)


def apparatus_spec(config: Config, case: Case, scale: Scale) -> ApparatusSpec:
    """Dimensions of the apparatus for a case's screen at a scale."""
    screen, tower = config.materials.screen(case.aperture_mm), config.apparatus
    aperture, wire = 1e-3 * screen.aperture_mm.value, 1e-3 * screen.wire_diameter_mm.value
    lengths = {name.replace("_mm", "_m"): 1e-3 * entry.value for name, entry in tower if name.endswith("_mm")}
    sides = {"cylinder_sides": scale.cylinder_sides.value} if scale.cylinder_sides else {}
    return ApparatusSpec(
        aperture_m=aperture,
        wire_diameter_m=wire,
        shape=scale.shape,
        width_m=scale.sieve_width_m(aperture + wire),
        wire_sides=scale.wire_sides.value,
        impact_plate_angle_rad=math.radians(tower.impact_plate_angle_deg.value),
        **lengths,
        **sides,
    )


def mesh_of(config: Config, scale: Scale, surface: Surface) -> WallMesh:
    """Return the scene's description of a surface, with the contact angle of its reservoir's material."""
    material = config.materials.walls[getattr(config.materials.wall_materials, surface.reservoir).material]
    angle = math.radians(material.contact_angle_deg.value)
    if surface.reservoir != "wires":
        return wall_mesh(surface, angle)
    mesh, read = (
        wall_mesh(surface, angle, analytic_wires=scale.wires == "analytic"),
        config.settings.readings.small_half_width,
    )
    widths = tuple(None if w is None else read(w, scale.wire_sides.value) for w in mesh.part_half_width_m)
    return mesh.model_copy(update={"part_half_width_m": widths})
