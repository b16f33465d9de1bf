"""Public interface to the exact bridge: force, angles, neck, stability, rupture distance and split of one bridge.

Two spheres or a sphere and a plate (radius infinite), contact angles from 0 to below 90°, no gravity, axisymmetric. Overlapping
bodies count as touching. Tables for engines are in `table.py`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pywet.errors import PywetError
from pywet.laws.exact_bridge import branch
from pywet.laws.exact_bridge.meridian import (
    CURVATURE,
    GAP,
    LENGTH,
    PHI_I,
    PHI_J,
    Case,
    Floats,
    contact,
    integrals,
    slope,
    square,
    start,
)
from pywet.laws.exact_bridge.split import neck_position, parts

KINDS = {branch.FOLD: "fold", branch.ASYMMETRY: "asymmetry"}


@dataclass(frozen=True)
class Bodies:
    """Two bodies; an infinite radius_j is a plate [m, rad]."""

    radius_i: float
    radius_j: float
    theta_i: float
    theta_j: float

    def __post_init__(self) -> None:
        for name, radius in (("radius_i", self.radius_i), ("radius_j", self.radius_j)):
            if not radius > 0.0:
                raise PywetError(
                    f"{name} = {radius:g} m given to the exact bridge; expected a positive length",
                    code="bridge.radius", key=name, given=radius,
                )  # fmt: skip
        if math.isinf(self.radius_i):
            raise PywetError(
                "radius_i is infinite; expected the sphere first: the plate is body j",
                code="bridge.plate_first", key="radius_i",
            )  # fmt: skip
        for name, angle in (("contact_angle_i", self.theta_i), ("contact_angle_j", self.theta_j)):
            if not 0.0 <= angle < math.pi / 2:
                raise PywetError(
                    f"{name} = {math.degrees(angle):g} deg given to the exact bridge; expected an angle from 0 to below 90 deg",
                    code="bridge.contact_angle", key=name, given=angle,
                )  # fmt: skip

    @property
    def unit(self) -> float:
        """Return the unit of length of the equations: the smaller radius."""
        return min(self.radius_i, self.radius_j)

    def holding(self, volume: float) -> Case:
        """Return the dimensionless case that is solved for a volume [m3] between the bodies."""
        equal = self.radius_i == self.radius_j and self.theta_i == self.theta_j
        radii = self.radius_i / self.unit, self.radius_j / self.unit
        return Case(volume / self.unit**3, *radii, self.theta_i, self.theta_j, equal)


@dataclass(frozen=True)
class Bridge:
    """A bridge in equilibrium; `state` contains the unknowns of `meridian.py` in units of the smaller radius."""

    bodies: Bodies
    volume: float
    state: Floats

    @property
    def case(self) -> Case:
        """Return the dimensionless problem that this bridge solves."""
        return self.bodies.holding(self.volume)

    @property
    def separation(self) -> float:
        """Return the separation of the surfaces [m]."""
        return float(self.state[GAP]) * self.bodies.unit

    def force(self, surface_tension: float) -> float:
        """Return the attraction [N]: 2πσ (r cos α − H r²), the same at every section."""
        if not 0.0 <= surface_tension < math.inf:
            raise PywetError(
                f"surface_tension = {surface_tension:g} N/m given to the exact bridge; expected a finite number of at least 0",
                code="bridge.surface_tension", key="surface_tension", given=surface_tension,
            )  # fmt: skip
        return 2.0 * math.pi * surface_tension * start(self.state, self.case)[3] * self.bodies.unit

    @property
    def half_filling_angles(self) -> tuple[float, float]:
        """Return the half-filling angles [rad]; nan on a plate."""
        plate = math.isinf(self.bodies.radius_j)
        return float(self.state[PHI_I]), math.nan if plate else float(self.state[PHI_J])

    @property
    def contact_radii(self) -> tuple[float, float]:
        """Return the radii of the two contact lines [m]."""
        c, unit = self.case, self.bodies.unit
        return contact(self.state[PHI_I], c.ri, c.ti)[0] * unit, contact(self.state[PHI_J], c.rj, c.tj)[0] * unit

    @property
    def mean_curvature(self) -> float:
        """Return the mean curvature H [1/m]; the liquid's pressure exceeds the gas's by 2σH."""
        return float(self.state[CURVATURE]) / self.bodies.unit

    @property
    def neck_radius(self) -> float:
        """Return the smallest radius between the contact lines [m]."""
        w0, w1, w2, _ = start(self.state, self.case)
        t = neck_position(self.state, self.case)
        return math.sqrt(square(t, self.state[CURVATURE], w0, w1, w2)) * self.bodies.unit

    @property
    def parts(self) -> tuple[float, float]:
        """Return the liquid on either side of the narrowest section [m3]."""
        share = parts(self.state, self.case)
        return share[0] * self.bodies.unit**3, share[1] * self.bodies.unit**3

    def meridian(self, points: int = 201) -> tuple[Floats, Floats, Floats]:
        """Return z from the contact line on body i [m], r [m], angle α between tangent and axis [rad]; each (points,)."""
        w0, w1, w2, f = start(self.state, self.case)
        h = self.state[CURVATURE]
        rows = []
        for t in np.linspace(0.0, self.state[LENGTH], points):
            w = square(t, h, w0, w1, w2)
            angle = math.atan2(0.5 * slope(t, h, w1, w2), f + h * w)
            rows.append((integrals(t, h, w0, w1, w2, f)[0], math.sqrt(w), angle))
        z, r, angles = np.array(rows).T
        return z * self.bodies.unit, r * self.bodies.unit, angles


@dataclass(frozen=True)
class Rupture:
    """Limit of stability: the bridge there, and whether it is a fold or the loss of symmetry of equal bodies."""

    bridge: Bridge
    kind: str

    @property
    def separation(self) -> float:
        """Return the rupture distance [m]."""
        return self.bridge.separation

    @property
    def transfer_ratio(self) -> float:
        """Return the share of the liquid on body i's side of the narrowest section; 1/2 for equal bodies."""
        i, j = self.bridge.parts
        return i / (i + j)


def solve(
    separation: float, volume: float, radius_i: float, radius_j: float, theta_i: float, theta_j: float
) -> Bridge | None:
    """Solve for the stable bridge at a separation.

    Parameters
    ----------
    separation : float
        Gap between the surfaces [m]; negative in overlap.
    volume : float
        Volume of the bridge [m³].
    radius_i : float
        Radius of sphere i [m].
    radius_j : float
        Radius of sphere j [m]; infinite for a plate.
    theta_i : float
        Contact angle on body i [rad], from 0 to below π/2.
    theta_j : float
        Contact angle on body j [rad].

    Returns
    -------
    Bridge or None
        The bridge; None beyond its rupture distance.

    Raises
    ------
    PywetError
        If an argument is not finite or outside its range; the radius of a plate is infinite.

    Notes
    -----
    Axisymmetric, at rest, without gravity; method and errors: docs/young_laplace.md.

    Examples
    --------
    >>> bridge = solve(1e-5, 1e-12, 1e-3, 2e-3, 0.3, 0.5)
    >>> bridge is not None and bridge.force(0.0728) > 0.0
    True
    """
    return solve_many([separation], volume, radius_i, radius_j, theta_i, theta_j)[0]


def solve_many(
    separations: Sequence[float], volume: float, radius_i: float, radius_j: float, theta_i: float, theta_j: float
) -> list[Bridge | None]:
    """Solve for the stable bridge at each of many separations.

    Parameters
    ----------
    separations : sequence of float
        Gaps between the surfaces [m]; negative in overlap.
    volume : float
        Volume of the bridge [m³].
    radius_i : float
        Radius of sphere i [m].
    radius_j : float
        Radius of sphere j [m]; infinite for a plate.
    theta_i : float
        Contact angle on body i [rad], from 0 to below π/2.
    theta_j : float
        Contact angle on body j [rad].

    Returns
    -------
    list of Bridge or None
        One entry for each separation; None beyond the rupture distance.

    Raises
    ------
    PywetError
        If an argument is not finite or outside its range; the radius of a plate is infinite.

    Notes
    -----
    Axisymmetric, at rest, without gravity; method and errors: docs/young_laplace.md.
    """
    bodies = Bodies(radius_i, radius_j, theta_i, theta_j)
    for separation in separations:
        if not math.isfinite(separation):
            raise PywetError(
                f"separation = {separation:g} m given to the exact bridge; expected a finite length, negative in overlap",
                code="bridge.separation", key="separation", given=separation,
            )  # fmt: skip
    gaps = [max(separation, 0.0) / bodies.unit for separation in separations]
    _, points = _trace(bodies, volume, max(gaps, default=0.0))
    return [_at(points, gap, bodies, volume) for gap in gaps]


def _at(points: Floats, gap: float, bodies: Bodies, volume: float) -> Bridge | None:
    """Return the bridge at a scaled separation from the points of its branch; None beyond their end."""
    if points[-1, GAP] < gap:
        return None
    if gap == 0.0:
        return Bridge(bodies, volume, points[0])
    k = int(np.searchsorted(points[:, GAP], gap))
    ok, state = branch.between(points[k - 1], points[k], gap, points[k, GAP], bodies.holding(volume))
    if not ok:
        raise _lost(bodies, volume)
    return Bridge(bodies, volume, state)


def rupture(volume: float, radius_i: float, radius_j: float, theta_i: float, theta_j: float) -> Rupture:
    """Solve for the limit of stability of a bridge.

    Parameters
    ----------
    volume : float
        Volume of the bridge [m³].
    radius_i : float
        Radius of sphere i [m].
    radius_j : float
        Radius of sphere j [m]; infinite for a plate.
    theta_i : float
        Contact angle on body i [rad], from 0 to below π/2.
    theta_j : float
        Contact angle on body j [rad].

    Returns
    -------
    Rupture
        Rupture distance [m], transfer ratio and kind of the instability.

    Raises
    ------
    PywetError
        If an argument is not finite or outside its range; the radius of a plate is infinite.

    Notes
    -----
    Axisymmetric, at rest, without gravity; method and errors: docs/young_laplace.md.

    Examples
    --------
    >>> rupture(1e-12, 1e-3, 2e-3, 0.3, 0.5).separation > 1e-5
    True
    """
    bodies = Bodies(radius_i, radius_j, theta_i, theta_j)
    kind, points = _trace(bodies, volume, math.inf)
    return Rupture(Bridge(bodies, volume, points[-1]), KINDS[kind])


def _trace(bodies: Bodies, volume: float, stop: float) -> tuple[int, Floats]:
    if not (volume > 0.0 and math.isfinite(volume)):
        raise PywetError(
            f"volume = {volume:g} m3 given to the exact bridge; expected a finite positive number",
            code="bridge.volume", key="volume", given=volume,
        )  # fmt: skip
    kind, points = branch.follow(bodies.holding(volume), stop)
    if kind == branch.LOST:
        raise _lost(bodies, volume)
    return kind, points


def _lost(bodies: Bodies, volume: float) -> PywetError:
    return PywetError(
        f"the exact bridge of {volume:g} m3 between radii {bodies.radius_i:g} and {bodies.radius_j:g} m with contact angles "
        f"{math.degrees(bodies.theta_i):g} and {math.degrees(bodies.theta_j):g} deg could not be followed; expected a volume "
        f"below half the cube of the effective radius",
        code="bridge.lost", given=volume,
    )  # fmt: skip
