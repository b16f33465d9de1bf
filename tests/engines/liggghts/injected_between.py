"""Faults injected in the plugin that act between the sampling windows, for a while, at one kind of contact, or in one effect's
work. The scene is the fixture scene (tests/reference_impl/fixture_scene.py) with the shipped windows, 20 of two steps.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pywet.cases.small import small
from pywet.cases.small.bodies import water
from tests.engines.liggghts import beds
from tests.reference_impl import fixture_scene

SOAPY = water(4.5e-4, tension=0.02, density=998.2)
DRIPS = small.PAPER.model_copy(update={"shedding": "tate"})
UNSEEN = "!world_.clock.logs_contacts()"
A_WHILE = "(world_.clock.now >= 1500 && world_.clock.now < 2900)"
PATCHES: list[tuple[str, str, str]] = [
    ("forces.cpp", 'if (injected("viscosity ten times")) t.viscous[k] = 10 * t.viscous[k];',
     'if (injected("viscosity ten times")) t.viscous[k] = 10 * t.viscous[k];\n'
     "    const bool wall = b.kind != SPHERE;\n"
     f"    const bool unseen = {UNSEEN}, now = {A_WHILE};\n"
     '    if (injected("pull of spheres halved unseen") && unseen && !wall) t.pull[k] *= 0.5;\n'
     '    if (injected("pull of walls a tenth high unseen") && unseen && wall) t.pull[k] *= 1.1;\n'
     '    if (injected("pull of spheres halved for a while") && now && !wall) t.pull[k] *= 0.5;\n'
     '    if (injected("pull without volume unseen") && unseen) t.pull[k] = t.pull[k] > 0 ? 1e-4 : 0.0;\n'
     '    if (injected("forces of walls halved unseen") && unseen && wall) { t.pull[k] *= 0.5; t.viscous[k] *= 0.5; }\n'
     '    if (injected("forces of walls halved") && wall) { t.pull[k] *= 0.5; t.viscous[k] *= 0.5; }\n'
     '    if (injected("drag halved for a while unseen") && unseen && now) t.viscous[k] *= 0.5;\n'
     '    if (injected("drag of spheres halved for a while") && now && !wall) t.viscous[k] *= 0.5;'),
    ("forces.cpp", '(injected("half of it acts") ? 0.5 : 1.0)',
     '(injected("half of it acts") || (injected("half of it acts unseen") && !world_.clock.logs_contacts()) ? 0.5 : 1.0)'),
    ("forces.cpp", "if (recorded) record(t, k);",
     'if (injected("capillary left out of the motion unseen") && !world_.clock.logs_contacts() && b >= 0) {\n'
     "      f = f + t.pull[k] * at(t.normal, k);\n"
     "    }\n"
     '    const double net = t.pull[k] - t.viscous[k];\n'
     '    if (injected("forces of walls halved in the motion") && b < 0) f = f + 0.5 * net * at(t.normal, k);\n'
     '    if (injected("spheres pulled less in the motion") && b >= 0) f = f + 0.5 * t.pull[k] * at(t.normal, k);\n'
     "    if (recorded) record(t, k);"),
    ("single.cpp", "t.viscous = -t.drag * t.factor_normal * dot(pushed, g.n);",
     't.viscous = (injected("semi-implicit drag halved unseen") && !world_.clock.logs_contacts() ? 0.5 : 1.0) * -t.drag *\n'
     "                t.factor_normal * dot(pushed, g.n);\n"
     f'    if (injected("semi-implicit drag halved for a while") && {A_WHILE}) t.viscous *= 0.5;'),
    ("energy.cpp", "power[CAPILLARY] += c;", 'power[CAPILLARY] += (injected("work of capillary halved") ? 0.5 : 1.0) * c;'),
    ("energy.cpp", "power[WALL] += wall_power[e];",
     'power[WALL] += (injected("work of walls turned") ? -1.0 : 1.0) * wall_power[e];'),
    ("energy.cpp", "power[VISCOUS_TANGENTIAL] += side;",
     'power[VISCOUS_TANGENTIAL] += injected("work of spin left out") ? power_of(on.tangential, v) : side;'),
    ("analytic_wires.cpp", "if (spring != known.end() && !(wanted < *spring)) std::copy(",
     'if (spring != known.end() && !(wanted < *spring) && !injected("springs of wires lost when found again")) std::copy('),
    ("analytic_wires.cpp", "if (!world_.ranks.alone()) known",
     'if (!world_.ranks.alone() && !injected("springs of wires stay on their rank")) known'),
    ("analytic_wires.cpp", "std::sort(known.begin(), known.end());",
     "std::sort(known.begin(), known.end());\n"
     '  if (injected("springs of wires of the next sphere"))\n'
     "    for (size_t k = 1; k < known.size(); k++) std::swap(known[k].spring, known[k - 1].spring);"),
    ("analytic_wires.cpp", "dot(world_.engine.press(c.a, r, d, r - distance,",
     'dot(world_.engine.press(c.a, r, d + (injected("wires push aslant") ? 0.1 * r : 0.0) * Vec(0, 1, 0),\n'
     '            (injected("forces of wires a tenth high") ? 1.1 : 1.0) * (r - distance),'),
    ("analytic_wires.cpp", "if (!touches) c.spring[0] = c.spring[1] = c.spring[2] = 0;",
     'if (!touches || injected("friction of wires forgets")) c.spring[0] = c.spring[1] = c.spring[2] = 0;'),
    ("analytic_wires.cpp", "energy_.wall_power[CONTACT] += dot(",
     'energy_.wall_power[CONTACT] += (injected("work of wires turned") ? -1 : 1) * dot('),
    ("analytic_wires.cpp", "const Vec point = mesh.to_world(Vec(q)), d",
     'const Vec point = mesh.to_world(Vec(q)) + (injected("wires off by a micrometre") ? 1e-6 : 0.0) * Vec(0, 0, 1), d'),
    ("analytic_wires.cpp", "touches = distance <= r;",
     'touches = distance <= (injected("wires are touched late") ? 0.98 : 1.0) * r;'),
    ("analytic_wires.cpp", "velocity = mesh.velocity_at(point);",
     'velocity = (injected("wires at rest for friction") ? 0.0 : 1.0) * mesh.velocity_at(point);'),
    ("shedding.cpp", "norm(felt), world_.rules.density",
     '(injected("drops at half the force felt") ? 0.5 : 1.0) * norm(felt), world_.rules.density'),
    ("shedding.cpp", "const double part = -std::expm1(",
     'const double part = injected("films feel at once") ? 1.0 : -std::expm1('),
    ("shedding.cpp", "/ span - g[k];", '/ span - (injected("gravity is not felt") ? 0.0 : g[k]);'),
    ("shedding.cpp", "if (!(d.volume > 0)) continue;",
     'if (injected("drops a tenth large")) d.volume *= 1.1;\n'
     '    if (!(d.volume > 0) || (injected("one sphere never drips") && id == 3)) continue;'),
    ("shedding.cpp", "for (Drop &d : drops) fall(now, d);",
     "for (Drop &d : drops) {\n    fall(now, d);\n"
     '    if (injected("films forget with a drop")) std::fill_n(&felt_[3 * d.i], 3, 0.0);\n  }'),
    ("shedding.cpp", "felt_[3 * id + k] += part * (mean",
     'felt_[3 * id + k] += (injected("films feel more") ? 1.1 : 1.0) * part * (mean'),
]  # fmt: skip
"""Changes of the sources: file, text, what replaces it."""
EXPLICIT, SEMI, WIRES, DRIPPING = "explicit", "semi_implicit", "wires", "dripping"
FORCES: dict[str, tuple[str, str, str]] = {
    "pull of spheres halved unseen": (EXPLICIT, "between_capillary", "it is 0.5 times what is expected (between spheres"),
    "pull of walls a tenth high unseen": (EXPLICIT, "between_capillary", "it is 1.1 times what is expected (at walls"),
    "pull of spheres halved for a while": (EXPLICIT, "capillary", "half of it counts (between spheres"),
    "pull without volume unseen": (EXPLICIT, "between_capillary", "capillary impulse between sampled steps: it is"),
    "forces of walls halved unseen": (EXPLICIT, "between_capillary", "it is 0.5 times what is expected (at walls"),
    "forces of walls halved": (EXPLICIT, "capillary", "half of it counts (at walls"),
    "drag halved for a while unseen": (EXPLICIT, "flight_velocity", "the viscous normal force is 0.5 times what it should be"),
    "drag of spheres halved for a while": (EXPLICIT, "viscous_law", "half of it counts (between spheres"),
    "half of it acts unseen": (EXPLICIT, "between_momentum", "by bridges between sampled steps: half of it counts"),
    "capillary left out of the motion unseen": (EXPLICIT, "between_momentum", "it is "),
    "forces of walls halved in the motion": (
        EXPLICIT, "newton_force",
        "the capillary force at walls: half of it counts and the normal viscous force at walls: half of it counts"),
    "spheres pulled less in the motion": (EXPLICIT, "newton_force", "the capillary force between spheres"),
    "semi-implicit drag halved unseen": (SEMI, "between_drag", "it is about 0."),
    "semi-implicit drag halved for a while": (SEMI, "viscous_normal", "half of it counts"),
}  # fmt: skip
WORKS: dict[str, tuple[str, str, str]] = {
    "work of drag twice": (EXPLICIT, "energy_windows", "work in a window: viscous_normal: it is 2 times what is expected"),
    "work of capillary halved": (EXPLICIT, "energy_windows", "work in a window: capillary: it is 0.5 times what is expected"),
    "work of walls turned": (EXPLICIT, "energy_windows", "work in a window: wall_motion: the sign is turned"),
    "work of spin left out": (EXPLICIT, "energy_windows", "work in a window: viscous_tangential"),
    "work of wires turned": (WIRES, "energy_windows", "work in a window: wall_motion"),
}  # fmt: skip
OF_WIRES: dict[str, tuple[str, str, str]] = {
    "wires off by a micrometre": (WIRES, "newton_force", "it is off along the normal of the dry contacts at screen"),
    "wires at rest for friction": (WIRES, "newton_force", "the wall's velocity does not count at screen"),
    "springs of wires lost when found again": (
        WIRES, "contact_spring",
        "it starts from zero, without that of the step before (at screen"),
    "springs of wires of the next sphere": (
        WIRES, "contact_spring",
        "it continues from that of another contact (at screen"),
    "forces of wires a tenth high": (
        WIRES, "newton_force",
        "along the normal of the dry contacts at screen; the springs of the dry contacts at screen would be 1.1"),
    "friction of wires forgets": (WIRES, "contact_logged", "dry contact in the log: it is left out (at screen"),
    "wires are touched late": (WIRES, "newton_force", "of the dry contacts at screen"),
    "wires push aslant": (WIRES, "newton_force", "of the dry contacts at screen"),
}  # fmt: skip
OF_DROPS: dict[str, tuple[str, str, str]] = {
    "drops at half the force felt": (DRIPPING, "felt_drops", "drop of a sampled sphere: it is"),
    "films feel at once": (DRIPPING, "felt_force", "force felt by a sampled film: it is"),
    "gravity is not felt": (DRIPPING, "felt_force", "force felt by a sampled film: its direction is not the expected one"),
    "films feel more": (DRIPPING, "felt_force", "force felt by a sampled film: it is"),
    "one sphere never drips": (DRIPPING, "felt_drops", "drop of a sampled sphere: it is left out"),
    "drops a tenth large": (DRIPPING, "felt_drops", "drop of a sampled sphere: it is 1.1 times"),
    "films forget with a drop": (DRIPPING, "felt_force", "drop of a sampled sphere: it is left out"),
}  # fmt: skip
FAULTS = {**FORCES, **WORKS, **OF_WIRES, **OF_DROPS}
"""Fault -> scene, quantity in which it must show, words of the sentence that names it."""
ON_RANKS: dict[str, tuple[str, str]] = {
    "springs of wires stay on their rank": (
        "contact_spring", "it starts from zero, without that of the step before (at wires"),
}  # fmt: skip
"""The same of a bed on two ranks whose steps are all recorded."""


def prepare(folder: Path, kind: str) -> list[small.Sphere]:
    """Prepare the fixture scene with the shipped windows: with explicit or semi-implicit drag, or wires; or a small wet bed."""
    if kind == DRIPPING:
        # so few spheres that all are sampled
        beds.prepare(folder, beds.bed((2, 2, 4)), 900, effects=DRIPS, liquid=SOAPY)
        return []
    more: dict[str, Any] = {"viscous_integration": "semi_implicit"} if kind == SEMI else {}
    bodies = fixture_scene.prepare(folder, **more, analytic_wires=("screen",) if kind == WIRES else ())
    path = folder / "scene.json"
    scene = json.loads(path.read_text())
    scene["output"] |= {"contact_windows": 20, "contact_window_steps": 2, "checkpoints": 5 if kind == WIRES else 0}
    path.write_text(json.dumps(scene))
    return bodies
