"""Size of the drop that a film sheds, and response time of the film to an acceleration. Spheres only."""

from __future__ import annotations

import math

from pywet.laws.force_law import force_law


@force_law("shedding", "tate")
def tate_drop(
    film_volume_i: float, radius_i: float, acceleration: float, density: float, surface_tension: float
) -> float:
    """Volume of the drop that leaves a sphere when its film exceeds the largest pendant volume; 0 otherwise.

    Parameters
    ----------
    film_volume_i : float or array
        Liquid L of the film on sphere i [m³].
    radius_i : float or array
        Radius r of the sphere [m], used where the sources have the radius of a tube.
    acceleration : float or array
        Magnitude a of the specific force on the sphere [m/s²]: 9.81 at rest, 0 in free fall.
    density : float or array
        Density ρ of the liquid [kg/m³].
    surface_tension : float or array
        Surface tension σ [N/m].

    Returns
    -------
    float or array
        Volume of the drop, at most L [m³].

    Notes
    -----
    A film hangs as one drop on the sphere's lee side. It holds as long as ρ a L ≤ 2π r σ (Tate 1864). Beyond, the part
    Ψ = V_f ρ a/(2π r σ) of that falls, with r/V_f^(1/3) = Φ and 3.60 Φ^2.81 = Bo = ρ a r²/σ, and the rest stays.

    Valid for drops that form slowly, Φ 0.2 to 1.2 (Bo 0.04 to 6); beyond, Ψ stays constant. Ψ is within 1 % of Harkins
    and Brown's table for Φ 0.3 to 0.8, 6 % low at 1.0, 15 % at 1.2. The largest drop that can hang on a circle of
    radius r, solved exactly, is 0.75 to 1.05 of Tate's for Bo 0.04 to 6. Above Bo 10 several drops hang side by side:
    an estimate.

    References
    ----------
    Tate (1864), Phil. Mag. 27, 176; Harkins & Brown (1919), J. Am. Chem. Soc. 41, 499; the closed form: Yildirim, Xu &
    Basaran (2005), Phys. Fluids 17, 062107.

    Examples
    --------
    >>> f"{1e9 * tate_drop(2e-7, 2.5e-3, 9.81, 998.2, 0.0728):.2f}"
    '73.82'
    """
    if acceleration <= 0.0:
        return 0.0
    most = 2.0 * math.pi * radius_i * surface_tension / (density * acceleration)
    if film_volume_i <= most:
        return 0.0
    if most <= 0.0:
        return film_volume_i
    bond = density * acceleration * radius_i * radius_i / surface_tension
    bond = min(max(bond, 3.60 * 0.2**2.81), 3.60 * 1.2**2.81)
    return most * bond / (2.0 * math.pi) * (3.60 / bond) ** (3.0 / 2.81)


@force_law("shedding", "tate")
def rayleigh_time(film_volume_i: float, density: float, surface_tension: float) -> float:
    """Response time of a film to a force: 1/ω of the slowest oscillation of a free drop of its volume.

    Parameters
    ----------
    film_volume_i : float or array
        Liquid L of the film on sphere i [m³].
    density : float or array
        Density ρ of the liquid [kg/m³].
    surface_tension : float or array
        Surface tension σ [N/m].

    Returns
    -------
    float or array
        Response time 1/ω [s].

    Notes
    -----
    ω² = 8 σ/(ρ R³), L = 4/3 π R³, so 1/ω = √(3 ρ L/(32 π σ)). Viscosity is left out (Ohnesorge number below 0.1).

    0 without surface tension. That a hanging film oscillates like a free drop is assumed.

    References
    ----------
    Rayleigh (1879), Proc. R. Soc. Lond. 29, 71-97.

    Examples
    --------
    >>> f"{1e3 * rayleigh_time(1e-8, 998.2, 0.0728):.3f}"
    '2.023'
    """
    if surface_tension <= 0.0:
        return 0.0
    return math.sqrt(3.0 * density * film_volume_i / (32.0 * math.pi * surface_tension))
