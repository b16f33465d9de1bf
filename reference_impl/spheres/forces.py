"""Forces between N wet spheres in a plane from Cartesian positions and velocities (Davis 2023, 1-4), for
`reference_impl.spheres.spheres`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from reference_impl.compiled import compiled


@compiled
def accelerations(
    y: Any, radius: Any, mass: Any, film: Any, wet: Any, viscosity: float, tension: float, h_min: float, gravity: Any
) -> Any:
    """Compute the time derivative of (x, y, vx, vy, ω per sphere; viscous and capillary loss, work of gravity).

    The matrices `film` and `wet` are n × n.
    """
    n = radius.size
    rate = np.zeros(5 * n + 3)
    for i in range(n):
        rate[5 * i] = y[5 * i + 2]
        rate[5 * i + 1] = y[5 * i + 3]
        rate[5 * i + 2] = gravity[0]
        rate[5 * i + 3] = gravity[1]
        rate[5 * n + 2] += mass[i] * (gravity[0] * y[5 * i + 2] + gravity[1] * y[5 * i + 3])
    for i in range(n):
        for j in range(i + 1, n):
            if not wet[i, j]:
                continue
            away = np.array([y[5 * j] - y[5 * i], y[5 * j + 1] - y[5 * i + 1]])
            distance = math.sqrt(away[0] ** 2 + away[1] ** 2)
            away /= distance
            side = np.array([-away[1], away[0]])
            relative = np.array([y[5 * i + 2] - y[5 * j + 2], y[5 * i + 3] - y[5 * j + 3]])
            closing = relative[0] * away[0] + relative[1] * away[1]
            sliding = relative[0] * side[0] + relative[1] * side[1]
            sliding += radius[i] * y[5 * i + 4] + radius[j] * y[5 * j + 4]
            gap = distance - radius[i] - radius[j]
            gap = min(max(gap, 0.05 * h_min), 1.25 * film[i, j])
            a = radius[i] * radius[j] / (radius[i] + radius[j])
            outer = 2.0 * film[i, j] - gap
            resistance = 6.0 * math.pi * viscosity * a**2 * (1.0 - gap / outer) ** 2 / gap
            shear = 2.0 * math.pi * viscosity * a * math.log(outer / gap) * sliding
            pull = 8.0 * math.pi * a * tension
            force = (resistance * closing - pull) * away + shear * side
            for k in range(2):
                rate[5 * i + 2 + k] -= force[k] / mass[i]
                rate[5 * j + 2 + k] += force[k] / mass[j]
            rate[5 * i + 4] -= radius[i] * shear / (0.4 * mass[i] * radius[i] ** 2)
            rate[5 * j + 4] -= radius[j] * shear / (0.4 * mass[j] * radius[j] ** 2)
            rate[5 * n] += resistance * closing**2 + shear * sliding
            rate[5 * n + 1] -= pull * closing
    return rate
