"""Infer parameters from responses and targets: best values, profile-likelihood intervals, undetermined directions.

Points are in the unit cube of the parameters' bounds. A residual is (response - target) over the standard error of
both together. An interval holds all values of a parameter for which the sum of squared residuals, minimised over the
other parameters, exceeds the minimum by at most Student's quantile squared. For one parameter and one target that is
Fieller's interval of inverse regression, and with a flat prior and a straight response the posterior's.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations_with_replacement, product

import numpy as np
from numpy.typing import NDArray
from scipy import stats
from scipy.ndimage import minimum_filter
from scipy.optimize import brentq, least_squares

Floats = NDArray[np.float64]
Response = Callable[[Floats], tuple[Floats, Floats, Floats]]
"""Point -> mean of each target's response, variance of that mean, degrees of freedom of the variance."""
STEP = 1e-3
"""Step of difference quotients: above the noise of the experiments, below the scale on which responses curve."""
GRID = {1: 33, 2: 9, 3: 5}
"""Number of points along each axis of the grid of starting points, by the number of parameters."""
PLACES = 33
"""Number of values of a parameter at which its profile is evaluated."""
STARTS = 8
EXACT = 1e-12
"""Relative scatter below which a quantity is not random: round-off."""
LEAST = 1e-9
KNOWN = 1e9
"""Degrees of freedom from which on a scatter counts as exactly known."""
MISFIT = 0.01
"""Probability below which runs are reported not to follow the polynomial."""


@dataclass(frozen=True)
class Interval:
    """Interval of a parameter, as shares of its bounds; an end is open if it is set by the window, not by the targets."""

    low: float
    high: float
    open_low: bool
    open_high: bool


@dataclass
class Problem:
    """Targets with their standard errors and degrees of freedom, and the response; `window`: lowest and highest corner."""

    response: Response
    values: Floats
    errors: Floats
    freedoms: Floats
    confidence: float
    window: tuple[Floats, Floats]
    _known: dict[bytes, Floats] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """Number of parameters."""
        return len(self.window[0])

    def residuals(self, place: Floats) -> Floats:
        """Return the residual of each target at a point."""
        key = place.tobytes()
        if key not in self._known:
            mean, variance, _ = self.response(place)
            self._known[key] = (mean - self.values) / np.sqrt(self.errors**2 + variance)
        return self._known[key]

    def sum(self, place: Floats) -> float:
        """Sum of squared residuals."""
        return float((self.residuals(place) ** 2).sum())

    def slopes(self, place: Floats, free: Sequence[int] | None = None) -> Floats:
        """Derivatives of the residuals (targets, parameters) by difference quotients within the window."""
        columns = []
        for k in range(self.count) if free is None else free:
            ends = [place.copy(), place.copy()]
            ends[0][k] = max(place[k] - STEP * self._width[k], self.window[0][k])
            ends[1][k] = min(place[k] + STEP * self._width[k], self.window[1][k])
            columns.append((self.residuals(ends[1]) - self.residuals(ends[0])) / (ends[1][k] - ends[0][k]))
        return np.stack(columns, axis=1)

    @property
    def _width(self) -> Floats:
        return self.window[1] - self.window[0]

    def least(self, start: Floats, held: int | None = None) -> Floats:
        """Minimise the sum of squares from a starting point, with one parameter fixed or none."""
        free = [k for k in range(self.count) if k != held]
        if not free:
            return start

        def whole(part: Floats) -> Floats:
            place = start.copy()
            place[free] = part
            return place

        def residuals(part: Floats) -> Floats:
            return self.residuals(whole(part))

        def slopes(part: Floats) -> Floats:
            return self.slopes(whole(part), free)

        low, high = self.window[0][free], self.window[1][free]
        inside = np.clip(start[free], low + LEAST, high - LEAST)
        found = least_squares(residuals, inside, slopes, (low, high), xtol=1e-10)
        return whole(found.x)

    @cached_property
    def minima(self) -> list[Floats]:
        """Return the local minima of the sum of squares, the best first, searched from the lowest points of a grid."""
        places = self._grid()
        sums = np.array([self.sum(place) for place in places]).reshape([GRID[self.count]] * self.count)
        lowest = (sums == minimum_filter(sums, size=3, mode="nearest")).ravel()
        starts = places[lowest][np.argsort(sums.ravel()[lowest])][:STARTS]
        return sorted((self.least(start) for start in starts), key=self.sum)

    def _grid(self, held: int | None = None, at: float = 0.0) -> Floats:
        """Return a grid of points over the window, with one parameter fixed or none."""
        axes = [np.linspace(low, high, GRID[self.count]) for low, high in zip(*self.window, strict=True)]
        if held is not None:
            axes[held] = np.array([at])
        return np.array(list(product(*axes)))

    @property
    def best(self) -> Floats:
        """Return the point with the smallest sum of squares."""
        return self.minima[0]

    @property
    def _free(self) -> Floats:
        """Degrees of freedom of the scatter of each target and its response at the best values, by Welch and Satterthwaite."""
        _, variance, freedom = self.response(self.best)
        squares = self.errors**4 / self.freedoms + variance**2 / freedom
        return np.asarray((self.errors**2 + variance) ** 2 / np.maximum(squares, 1e-300))

    @cached_property
    def quantile(self) -> float:
        """Two-sided Student quantile with the degrees of freedom of the least certain target."""
        return float(stats.t.ppf(0.5 + 0.5 * self.confidence, self._free.min()))

    @property
    def reached(self) -> bool:
        """Return whether the response at the best values is compatible with the targets: not rejected at 1 %.

        A residual, of Student's distribution if the scatter is of few measurements, counts as the normal one of the same
        probability. A fitted parameter takes one degree of freedom; with as many parameters as targets one is left.
        """
        tails = stats.t.sf(np.abs(self.residuals(self.best)), np.minimum(self._free, KNOWN))
        squares = np.asarray(stats.norm.isf(tails)) ** 2
        return bool(stats.chi2.sf(squares.sum(), max(len(squares) - self.count, 1)) >= 0.01)

    def profile(self, k: int, at: float) -> tuple[float, Floats]:
        """Return the sum of squares above its minimum with parameter k fixed and the others optimised, and the point."""
        held = np.array(self.minima)
        held[:, k] = at
        place = self.least(min([*held, *self._grid(k, at)], key=self.sum), k)
        return self.sum(place) - self.sum(self.best), place

    def intervals(self, k: int) -> list[Interval]:
        """Return the intervals of parameter k, in order; the profile is evaluated at `PLACES` and at the minima."""

        def beyond(at: float) -> float:
            return self.profile(k, at)[0] - self.quantile**2

        low, high = float(self.window[0][k]), float(self.window[1][k])
        places = np.union1d(np.linspace(low, high, PLACES), [place[k] for place in self.minima]).tolist()
        fit = [False, *(beyond(at) <= 0.0 for at in places), False]
        first = [n for n in range(len(places)) if fit[n + 1] and not fit[n]]
        last = [n for n in range(len(places)) if fit[n + 1] and not fit[n + 2]]

        def end(inside: float, outside: int) -> float:
            at_window = not 0 <= outside < len(places)
            return inside if at_window else float(brentq(beyond, inside, places[outside], xtol=1e-7))

        return [
            Interval(end(places[a], a - 1), end(places[b], b + 1), places[a] == low, places[b] == high)
            for a, b in zip(first, last, strict=True)
        ]

    def unknown(self) -> list[list[int]]:
        """Return the parameters of each flat direction: along it the residuals change by less than the quantile.

        Determined from the slopes at the best point. A parameter belongs to a direction if changing it alone
        has an effect; a direction without such parameters is one parameter on which the targets do not
        depend.
        """
        slopes = self.slopes(self.best) * self._width
        _, sizes, directions = np.linalg.svd(slopes, full_matrices=True)
        groups = []
        for v, size in zip(directions, np.append(sizes, np.zeros(self.count))[: self.count], strict=True):
            way = np.abs(v) / np.abs(v).max()
            if size / np.abs(v).max() < self.quantile:
                matters = way * np.linalg.norm(slopes, axis=0) > 0.5 * self.quantile
                groups.append([k for k in range(self.count) if matters[k] or way[k] == 1.0])
        return groups


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
    """The response of an engine over the parameters: a polynomial through runs of several seeds, and how well it is known.

    Of third order for one parameter, of second for several. Coefficients (terms, quantities), their spread, and
    the deviation of a single run from the surface: its residuals contain the scatter of seeds and the misfit of
    the polynomial, so that both widen the intervals.
    """

    coefficients: Floats
    inverse: Floats
    deviation: Floats
    freedom: int
    misfit: float
    """Probability that the scatter of seeds alone explains the deviation of the means (smallest over the quantities)."""

    @classmethod
    def through(cls, places: Floats, values: Floats) -> Surface:
        """Fit the surface to runs at points (n, parameters) with values (n, quantities); it needs more runs than terms."""
        known = terms(places)
        coefficients: Floats = np.asarray(np.linalg.lstsq(known, values, rcond=None)[0], dtype=float)
        freedom = len(known) - known.shape[1]
        squares = ((values - known @ coefficients) ** 2).sum(axis=0)
        misfit = _misfit(places, values, squares, freedom)
        inverse: Floats = np.asarray(np.linalg.pinv(known.T @ known), dtype=float)
        return cls(coefficients, inverse, np.sqrt(squares / freedom), freedom, misfit)

    def at(self, place: Floats) -> tuple[Floats, Floats]:
        """Return the mean of each quantity at a point, and the variance of that mean."""
        row = terms(place[None, :])[0]
        return row @ self.coefficients, self.deviation**2 * float(row @ self.inverse @ row)


def _misfit(places: Floats, values: Floats, squares: Floats, freedom: int) -> float:
    """Return p of the F test of lack of fit against the scatter at repeated points; 1 if there are too few of them."""
    _, group = np.unique(places.round(9), axis=0, return_inverse=True)
    group = group.ravel()
    counts = np.bincount(group)
    means = np.stack([np.bincount(group, weights=v) / counts for v in values.T], axis=1)
    pure = ((values - means[group]) ** 2).sum(axis=0)
    inside = len(values) - len(counts)
    beyond = freedom - inside
    if beyond < 1 or inside < 1:
        return 1.0
    round_off = np.maximum((EXACT * np.abs(values).max(axis=0)) ** 2, np.finfo(float).tiny)
    ratio = np.where(squares > round_off, (squares - pure) / beyond / np.maximum(pure / inside, round_off), 0.0)
    return float(min(1.0, stats.f.sf(ratio, beyond, inside).min() * len(ratio)))
