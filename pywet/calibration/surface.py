"""The response of an engine over the parameters: a polynomial through runs of several seeds, and how well it is known.

Of third order for one parameter, of second for several.

Its residuals hold the scatter of seeds and what the polynomial does not follow, so that both widen what is said of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Floats = NDArray[np.float64]


def terms(places: Floats) -> Floats:
    """1, u, v, u², uv, v² … at places (n, parameters); of a single parameter u³ too.

    >>> terms(np.array([[2.0, 3.0]])).tolist()
    [[1.0, 2.0, 3.0, 4.0, 6.0, 9.0]]
    """
    count = places.shape[1]
    pairs = [places[:, i] * places[:, j] for i, j in combinations_with_replacement(range(count), 2)]
    cubic = [places[:, 0] ** 3] if count == 1 else []
    return np.column_stack([np.ones(len(places)), places, *pairs, *cubic])


@dataclass(frozen=True)
class Surface:
    """Coefficients (terms, quantities), their spread, and the deviation of a single run from the surface."""

    coefficients: Floats
    inverse: Floats
    deviation: Floats
    freedom: int
    misfit: float
    """Probability that seeds alone make the means of places deviate as far (least of all quantities)."""

    @classmethod
    def through(cls, places: Floats, values: Floats) -> Surface:
        """Through runs at places (n, parameters) with values (n, quantities); more runs than terms."""
        known = terms(places)
        coefficients: Floats = np.asarray(np.linalg.lstsq(known, values, rcond=None)[0], dtype=float)
        freedom = len(known) - known.shape[1]
        squares = ((values - known @ coefficients) ** 2).sum(axis=0)
        misfit = _misfit(places, values, squares, freedom)
        inverse: Floats = np.asarray(np.linalg.pinv(known.T @ known), dtype=float)
        return cls(coefficients, inverse, np.sqrt(squares / freedom), freedom, misfit)

    def at(self, place: Floats) -> tuple[Floats, Floats]:
        """Mean of each quantity at a place, and the variance of that mean."""
        row = terms(place[None, :])[0]
        return row @ self.coefficients, self.deviation**2 * float(row @ self.inverse @ row)


def _misfit(places: Floats, values: Floats, squares: Floats, freedom: int) -> float:
    """p of the F test of lack of fit against the scatter at equal places; 1 where too few places are there for it."""
    _, group = np.unique(places.round(9), axis=0, return_inverse=True)
    group = group.ravel()
    counts = np.bincount(group)
    means = np.stack([np.bincount(group, weights=v) / counts for v in values.T], axis=1)
    pure = ((values - means[group]) ** 2).sum(axis=0)
    inside = len(values) - len(counts)
    beyond = freedom - inside
    if beyond < 1 or inside < 1:
        return 1.0
    ratio = (squares - pure) / beyond / np.maximum(pure / inside, 1e-300)
    return float(min(1.0, stats.f.sf(ratio, beyond, inside).min() * len(ratio)))
