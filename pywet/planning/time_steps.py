"""Time step advisor: the largest steps that contact, capillary and viscous forces allow, and which of them governs.

A pair of relative mass m with a spring k, a dashpot γ and a drag c, stepped as the engine does (speeds half a step
back), is stable while, with κ = k Δt²/m, y = γ Δt/m, x = c Δt/m,

explicit: κ < 4 − 2 (x + y) (c alone: Δt < 2 m/c, the limit of Washino et al. 2016 up to their factor) semi-implicit:
κ < 4 − 2 (y − x) (never below the dry contact's limit, whatever the viscosity)

In a dense packing the largest eigenvalue of springs or dashpots is four times that of a pair (face-centred cubic: 8
k/m against 2 k/m), so that a drag allows a quarter and a spring half of a pair's step. Sliding and spinning count
with 7/2 of the inverse mass. The capillary force has a negative slope: its limit is one of resolution, not of
stability, and is not refused.

A Hertz contact is stiffest at its largest overlap. Its limit is that of a spring with the slope there, in a head-on
impact of two bodies that each have the impact speed of the scene (the largest due to a wall, a thrown sphere or a
fall through the whole scene), which gives the largest overlap. The duration of that impact and the Rayleigh time are
limits of resolution.

If bridges act every n-th step for n steps at once (`bridges_every`), all limits of bridges are computed for n Δt,
with the spring and the dashpot as if they, too, were integrated with n Δt. This is conservative (their own step is
Δt) and avoids the resonance of impulses with the oscillation of a contact, at n Δt of half its period (Biesiadecki &
Skeel 1993, J. Comput. Phys. 109, 318).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType

import numpy as np
import scipy
from numpy.typing import NDArray

from pywet.errors import PywetError, UnstableStep
from pywet.geometry.motion import peak_speed
from pywet.laws import contact, registry
from pywet.laws.force_law import PROBE
from pywet.laws.hertz import HEAD_ON, STIFFEST, Hertz, impact_duration, rayleigh_time
from pywet.scene import ContactPair, Effects, EngineScene, Rotation, Slide, SphereClass, Vibration

PACKED = 4.0
"""Largest eigenvalue in a dense packing over that of a pair."""
DENSE = 13
"""Number of spheres from which on a scene counts as a packing."""
IMPULSES = "impulses of bridges"
"""Name of the limit that contact stiffness imposes on bridges that act every few steps."""
OF_RAYLEIGH, OF_IMPACT = 0.2, 1.0 / 20.0
"""Fractions of the Rayleigh time, and of the duration of a Hertz impact, that resolve them."""
DRAWN = {"normal_velocity": (1.0, 0.1, 0.01, -0.01, -0.1, -1.0), "viscosity": (1e-3, 1.0)}
"""Normal velocities [m/s] and viscosities [Pa s] at which a drag is compared with one proportional to the velocity."""
ROUND_OFF = 1e-6
"""Relative difference of a drag coefficient that is attributed to rounding."""
LEAST_SPEED_M_PER_S = 0.1
"""Impact speed where no wall is faster."""
Corners = Mapping[str, NDArray[np.float64]]
"""Name of a wall -> positions of its corners [m]."""
SPIN = 2.5
"""r²/I of a sphere in units of 1/m: tangential forces also spin the bodies."""


@dataclass(frozen=True)
class Limit:
    """One limit: the largest time step [s] that `effect` allows between `bodies`; `stability` False: only resolution."""

    effect: str
    bodies: str
    time_step_s: float
    stability: bool = True


@dataclass(frozen=True)
class Advice:
    """List all limits of the time step, the smallest first."""

    time_step_s: float
    limits: tuple[Limit, ...]

    @property
    def governs(self) -> Limit:
        return self.limits[0]

    @property
    def elastic_step_s(self) -> float:
        """Return the step [s] at which an elastic collision conserves its energy to 1 %.

        It is a tenth of the contact's stability limit. A collision that begins between two steps gains or
        loses up to κ/4 of its energy, κ = k Δt²/m; at the limit κ is 4.
        """
        return 0.1 * min((m.time_step_s for m in self.limits if m.effect == "contact"), default=math.inf)

    @property
    def lines(self) -> list[str]:
        """Format the limits of the time step as text, one line for the smallest limit of each effect."""
        shown: dict[str, Limit] = {}
        for limit in (limit for limit in self.limits if math.isfinite(limit.time_step_s)):
            shown.setdefault(limit.effect, limit)
        lines = [
            f"{limit.effect:<20}{limit.time_step_s:9.2e} s  {limit.bodies}{'' if limit.stability else ' (resolution)'}"
            for limit in shown.values()
        ]
        if math.isfinite(self.elastic_step_s):
            lines.append(f"{'energy to 1 %':<20}{self.elastic_step_s:9.2e} s  of an elastic contact (resolution)")
        part = self.time_step_s / self.governs.time_step_s
        return [
            *lines,
            f"time step {self.time_step_s:.3g} s is {part:.2g} of the smallest, which is: {self.governs.effect}",
        ]


def largest_step(
    m: float, k: float, gamma: float, c: float, implicit: bool, crowd: float = 1.0, adjusted: bool = True
) -> float:
    """Return the largest stable step [s] of a relative mass m [kg] with a spring, a dashpot and a drag; inf without any.

    Units are k [N/m], gamma and c [kg/s]. `crowd` multiplies all of them, such as by PACKED; `adjusted`: the
    engine's dashpot is adjusted to its step. With `implicit` the drag is evaluated at the end of the step, with
    the mass divided among the bridges, so that neighbours do not make it stiffer.
    """
    if max(k, gamma, c) <= 0.0:
        return math.inf

    def margin(step: float) -> float:
        dashpot = contact.at_step(gamma, m, step) if adjusted else gamma
        kappa, y, x = crowd * k * step**2 / m, crowd * dashpot * step / m, c * step / m
        if implicit:
            return 4.0 - 2.0 * (y - x) - kappa
        return 4.0 - 2.0 * (crowd * x + y) - kappa

    bounds = [value for value in (math.sqrt(m / k) if k > 0 else 0.0, m / gamma if gamma > 0 else 0.0) if value > 0]
    if implicit and (k <= 0.0 or c >= 1e3 * math.sqrt(m * k)):
        return math.inf  # no limit, or one far above any useful step
    high = 4.0 * max([*bounds, m / c if c > 0 else 0.0])
    while margin(high) > 0.0:
        high *= 2.0
    return float(scipy.optimize.brentq(margin, 0.0, high, rtol=1e-12))


def advise(scene: EngineScene, corners: Corners = MappingProxyType({})) -> Advice:
    """Compute the largest time steps that contact, drag and capillary force of a scene allow.

    `corners` of turning walls, whose speed is otherwise that of the corners of the box.
    """
    limits = _limits(scene, _speed(scene, corners))
    if not limits:
        raise PywetError(
            f"scene {scene.name} has no spheres, so it has no time step limit; expected at least one",
            code="step.no_spheres",
        )
    return Advice(scene.time_step_s, tuple(sorted(limits, key=lambda limit: limit.time_step_s)))


def refuse_unstable(scene: EngineScene) -> None:
    """Raise `UnstableStep` if the scene's time step exceeds a stability limit."""
    for limit in sorted(_limits(scene, LEAST_SPEED_M_PER_S), key=lambda limit: limit.time_step_s):
        if limit.stability and scene.time_step_s > limit.time_step_s:
            implicit = scene.viscous_integration == "semi_implicit"
            alone = implicit or limit.effect in ("contact", IMPULSES)
            remedy = "lower it" if alone else "lower it or set viscous_integration to semi_implicit"
            if scene.bridges_every > 1 and limit.effect != "contact":
                remedy = f"{remedy}, or bridges_every, which is {scene.bridges_every}"
            raise UnstableStep(
                f"the time step of scene {scene.name}, {scene.time_step_s:.3g} s, would be unstable: the {limit.effect} of "
                f"{limit.bodies} allows at most {limit.time_step_s:.3g} s; {remedy}",
                step_s=scene.time_step_s, largest_s=limit.time_step_s, code="step.unstable",
            )  # fmt: skip


def refuse_nonlinear_drag(effects: Effects, integration: str, key: str, where: str) -> None:
    """Raise for a normal viscous law that is not proportional to the velocity, if its force is integrated semi-implicitly.

    That takes its coefficient at 1 m/s at every velocity. The law is compared on its probe grid, for two viscosities.
    """
    name = effects.viscous_normal
    if name is None or integration != "semi_implicit":
        return
    law = registry.get("viscous_normal", name).functions[0]
    grid = np.meshgrid(*({**PROBE, **DRAWN}[argument] for argument in law.arguments), indexing="ij")
    axis = law.arguments.index("normal_velocity")
    coefficients = np.moveaxis(law(*grid) / grid[axis], axis, 0)
    if not (np.abs(coefficients - coefficients[0]) <= ROUND_OFF * np.abs(coefficients[0])).all():
        raise PywetError(
            f"{where}: the force of law {name} is not proportional to the velocity, and {key} is semi_implicit; "
            "expected explicit: set it",
            code="step.not_proportional", key=key, given=integration, expected="explicit", where=where,
        )  # fmt: skip


def _limits(scene: EngineScene, speed: float) -> list[Limit]:
    """Return all limits; the impact speed [m/s] is of a limit of resolution alone."""
    crowd = PACKED if sum(c.count for c in scene.classes) >= DENSE else 1.0
    return [limit for pair in _present(scene) for limit in _pair_limits(scene, pair, crowd, speed)]


def _present(scene: EngineScene) -> list[ContactPair]:
    count = {c.type: c.count for c in scene.classes}
    alone = [t for t, n in count.items() if n == 1]
    walls = bool(scene.walls)
    return [
        p
        for p in scene.pairs
        if count[p.a] and (walls if p.b == 0 else count[p.b] and not (p.a == p.b and p.a in alone and len(count) > 1))
    ]


def packed_step(classes: Sequence[SphereClass], pairs: Iterable[ContactPair]) -> float:
    """Return the largest stable step [s] of linear contacts in a dense bed, also for impulses of bridges."""
    steps = []
    for pair in pairs:
        m, k = contact.pair_mass(classes, pair), pair.normal_stiffness_N_per_m
        k_t = (1.0 + SPIN) * pair.tangential_stiffness_N_per_m
        steps.append(_linear_step(m, k, k_t, contact.damping(pair.restitution, m, k), PACKED))
    return min(steps)


def _linear_step(m: float, k: float, k_t: float, gamma: float, crowd: float) -> float:
    return min(largest_step(m, k, gamma, 0.0, False, crowd), largest_step(m, k_t, 0.0, 0.0, False, crowd))


def _pair_limits(scene: EngineScene, pair: ContactPair, crowd: float, speed: float) -> Iterator[Limit]:
    one, two = scene.classes[pair.a - 1], scene.classes[pair.b - 1] if pair.b else None
    m = contact.pair_mass(scene.classes, pair)
    bodies = f"{one.name} and {two.name if two else 'a wall'}"
    stiffer = 1.0 if scene.hertz is None else STIFFEST
    k = stiffer * pair.normal_stiffness_N_per_m
    gamma = contact.damping(pair.restitution, m, k)
    implicit = scene.viscous_integration == "semi_implicit"
    k_t = (1.0 + SPIN) * stiffer * pair.tangential_stiffness_N_per_m
    dry = _linear_step(m, k, k_t, gamma, crowd) if scene.hertz is None else hertz_step(m, pair, crowd)
    yield Limit("contact", bodies, dry)
    if scene.hertz is not None:
        lasts, wave = _hertz_times(scene.hertz, scene.classes, pair)
        yield Limit("Hertz impact / 20", bodies, OF_IMPACT * lasts, stability=False)
        yield Limit("Rayleigh time / 5", bodies, OF_RAYLEIGH * wave, stability=False)
    if scene.effects.bridges and scene.liquid is not None:
        bridge, every = _Bridge(scene, pair), scene.bridges_every
        if every > 1:
            yield Limit(IMPULSES, bodies, dry / every)
        normal, tangential = bridge.drags()
        if normal > 0.0:
            yield Limit("viscous normal", bodies, largest_step(m, k, gamma, normal, implicit, crowd) / every)
        if tangential > 0.0:
            step = largest_step(m, k_t, 0.0, tangential, implicit, crowd) / every
            yield Limit("viscous tangential", bodies, step)
        slope = bridge.steepest()
        if slope > 0.0:
            yield Limit("capillary", bodies, 2.0 * math.sqrt(m / (crowd * slope)) / every, stability=False)
        yield Limit("passing a bridge", bodies, 0.1 * bridge.rupture() / speed / every, stability=False)


def hertz_step(m: float, pair: ContactPair, crowd: float) -> float:
    """Return the largest stable step [s] of a Hertz contact at its stiffest, normal and tangential, each with its dashpot."""
    k, k_t = (STIFFEST * k for k in (pair.normal_stiffness_N_per_m, pair.tangential_stiffness_N_per_m))
    of_normal, of_side = (math.sqrt(5.0 / 6.0) * contact.damping(pair.restitution, m, s) for s in (k, k_t))
    sliding = 1.0 + SPIN
    return min(
        largest_step(m, k, of_normal, 0.0, False, crowd, adjusted=False),
        largest_step(m, sliding * k_t, sliding * of_side, 0.0, False, crowd, adjusted=False),
    )


def _hertz_times(hertz: Hertz, classes: Sequence[SphereClass], pair: ContactPair) -> tuple[float, float]:
    """Return the duration of the fastest head-on impact of a pair, and the shorter Rayleigh time of its spheres [s]."""
    radius, mass = contact.reduced_radius(*contact.pair_radii(classes, pair)), contact.pair_mass(classes, pair)
    balls = [(classes[k - 1], hertz.spheres[k - 1]) for k in (pair.a, pair.b) if k]
    wave = min(rayleigh_time(c.radius_m, c.density_kg_per_m3, elastic) for c, elastic in balls)
    return impact_duration(hertz.moduli(pair)[0], radius, mass, HEAD_ON * hertz.impact_speed_m_per_s), wave


def hertz_lines(
    classes: Sequence[SphereClass], pairs: Sequence[ContactPair], hertz: Hertz, step: float
) -> tuple[str, ...]:  # fmt: skip
    """Return the lines of a plan on Hertz contacts: the shortest impact, its duration, and its number of time steps."""
    of = [(*_hertz_times(hertz, classes, p), p) for p in pairs if classes[p.a - 1].count]
    (lasts, _, pair), wave, fast = min(of, key=lambda row: row[0]), min(w for _, w, _ in of), hertz.impact_speed_m_per_s
    deep = max(hertz.overlap(classes, p, HEAD_ON * fast) / min(contact.pair_radii(classes, p)) for *_, p in of)
    bodies = f"{classes[pair.a - 1].name} and {classes[pair.b - 1].name if pair.b else 'a wall'}"
    return (
        f"contact: Hertz-Mindlin, two bodies at {fast:.3g} m/s each (the fastest), head on:",
        f"  the shortest impact, of {bodies}, lasts {lasts:.3g} s: {lasts / step:.0f} time steps",
        f"  of {step:.3g} s; the deepest overlap is {100 * deep:.2g} % of the radius",
        f"  Rayleigh time {wave:.3g} s: {wave / step:.0f} steps, expected 5 or more",
        "  made by the engine's stock loop: batches hold the linear spring alone",
    )


def _speed(scene: EngineScene, corners: Corners) -> float:
    """Return the typical impact speed [m/s]: that of the fastest wall, at least LEAST_SPEED_M_PER_S."""
    fastest = LEAST_SPEED_M_PER_S
    box = np.array([*product(*zip(scene.box_low_m, scene.box_high_m, strict=True))])
    for name, way in scene.motions.items():
        if isinstance(way, Vibration):
            fastest = max(fastest, peak_speed(way))
        if isinstance(way, Slide):
            fastest = max(fastest, math.hypot(*way.velocity_m_per_s))
        if isinstance(way, Rotation):
            arm = np.cross(corners.get(name, box) - way.origin_m, way.axis) / math.hypot(*way.axis)
            fastest = max(fastest, 2.0 * math.pi / way.period_s * float(np.linalg.norm(arm, axis=-1).max(initial=0.0)))
    return fastest


class _Bridge:
    """The bridge that forms between initial films of a pair of types, by the scene's laws."""

    def __init__(self, scene: EngineScene, pair: ContactPair) -> None:
        assert scene.liquid is not None
        self._scene, self._liquid = scene, scene.liquid
        one, two = scene.classes[pair.a - 1], scene.classes[pair.b - 1] if pair.b else None
        self._radii = contact.pair_radii(scene.classes, pair)
        largest = max((w.contact_angle_rad for w in scene.walls), default=0.0)
        self._angles = (one.contact_angle_rad, two.contact_angle_rad if two else largest)
        films = [contact.film_volume(self._liquid.initial_film_thickness_m, r) for r in self._radii if math.isfinite(r)]
        draw = self._law("formation")
        i, j = self._radii
        self._volume = draw(films[0], i, j) + (draw(films[1], j, i) if two else 0.0)

    def _law(self, kind: str, number: int = 0) -> Callable[..., float]:
        return registry.get(kind, str(getattr(self._scene.effects, kind))).functions[number]

    def drags(self) -> tuple[float, float]:
        """Return the largest drag coefficients [kg/s], normal and tangential (sliding and spinning): those at contact."""
        i, j = self._radii
        normal = tangential = 0.0
        if self._scene.effects.viscous_normal and self._volume > 0.0:
            normal = -self._law("viscous_normal")(0.0, self._volume, i, j, 1.0, self._liquid.viscosity_Pa_s)
        if self._scene.effects.viscous_tangential and self._volume > 0.0:
            slide, roll = (self._law("viscous_tangential", n)(0.0, i, j, self._liquid.viscosity_Pa_s) for n in (0, 1))
            tangential = slide + SPIN * roll
        return normal, tangential

    def rupture(self) -> float:
        """Return the static rupture distance [m]."""
        return self._law("rupture")(self._volume, *self._radii, *self._angles) if self._volume > 0.0 else math.inf

    def steepest(self) -> float:
        """Return the largest |dF/dS| of the capillary force between contact and rupture [N/m], by differences over 200 gaps."""
        if not self._scene.effects.capillary or self._volume <= 0.0:
            return 0.0
        longest = self.rupture()
        if math.isnan(longest):  # the run stops with the bridge
            return 0.0
        gaps = np.linspace(0.0, longest, 201)
        law, sigma = self._law("capillary"), self._liquid.surface_tension_N_per_m
        force = np.array([law(float(s), self._volume, *self._radii, *self._angles, sigma) for s in gaps])
        return float(np.abs(np.diff(force) / np.diff(gaps)).max())
