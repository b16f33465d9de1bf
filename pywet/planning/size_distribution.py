"""Convert the requested mass of each size into whole numbers of spheres, rounded over the whole distribution."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from pywet.errors import ConfigError

UNNOTICED = 0.005
"""Largest relative error of the total mass for which each size is rounded separately."""
OFF = 0.05
"""Relative error allowed for the total mass, and for a size if it exceeds half a sphere."""
FINE = 1.001
"""Factor between successive trial values in the search for the smallest suitable total mass."""


@dataclass(frozen=True)
class Amount:
    """Requested mass [kg] of one size, mass of one sphere [kg] and number of spheres simulated."""

    name: str
    asked_kg: float
    sphere_kg: float
    count: int

    @property
    def made_kg(self) -> float:
        return self.count * self.sphere_kg


def whole_counts(asked_kg: Sequence[float], sphere_kg: Sequence[float]) -> tuple[int, ...]:
    """Number of spheres of each size, at least one.

    To the nearest number, each for itself, where that keeps the total within `UNNOTICED`. Elsewhere from the coarsest to the
    finest: what the coarser ones have too much or lack is spread over the finer ones in proportion, by at most `OFF` of each.

    >>> whole_counts([1.0, 1.0], [0.7, 0.01])
    (1, 105)
    """
    nearest = tuple(_nearest(m / one) for m, one in zip(asked_kg, sphere_kg, strict=True))
    if abs(_off(asked_kg, sphere_kg, nearest)) <= UNNOTICED:
        return nearest
    left, rest, counts = sum(asked_kg), sum(asked_kg), list(nearest)
    for k in sorted(range(len(counts)), key=lambda k: -sphere_kg[k]):
        scale = min(max(left / rest, 1.0 - OFF), 1.0 + OFF)
        counts[k] = _nearest(scale * asked_kg[k] / sphere_kg[k])
        left, rest = left - counts[k] * sphere_kg[k], max(rest - asked_kg[k], 1e-300)
    return tuple(counts)


def amounts(
    names: Sequence[str], asked_kg: Sequence[float], sphere_kg: Sequence[float], where: str
) -> tuple[Amount, ...]:
    """Return the integer numbers of spheres of one size distribution.

    Raises `ConfigError`, which starts with `where` and states the smallest suitable total mass, for a size of
    less than half a sphere and for a total that is off by more than `OFF`.
    """
    counts, total = whole_counts(asked_kg, sphere_kg), sum(asked_kg)
    if not _good(asked_kg, sphere_kg):
        least, share = _least(asked_kg, sphere_kg), [m / one for m, one in zip(asked_kg, sphere_kg, strict=True)]
        k = min(range(len(share)), key=lambda k: share[k])
        off = _off(asked_kg, sphere_kg, counts)
        reason = (
            f"{_g(asked_kg[k])} of {names[k]} are {share[k]:.2g} of one sphere ({_g(sphere_kg[k])})"
            if share[k] < 0.5
            else f"{_g(total)} in whole spheres are {_g((1.0 + off) * total)}, {100 * off:+.0f} %"
        )
        raise ConfigError(
            f"{where}: {reason}; expected at least half a sphere of every size and a total within {100 * OFF:g} %: "
            f"{_g(least)} in all in place of {_g(total)}, or fewer or smaller sizes",
            code="psd.few_spheres", given=total, expected=least,
        )  # fmt: skip
    return tuple(Amount(*row) for row in zip(names, asked_kg, sphere_kg, counts, strict=True))


def lines(made: Sequence[Amount]) -> list[str]:
    """Format requested and simulated amounts side by side, one line for each size and one for the total."""
    rows = [(a.name, a.count, a.asked_kg, a.made_kg) for a in made]
    if len(rows) > 1:
        rows.append(("all", sum(r[1] for r in rows), sum(r[2] for r in rows), sum(r[3] for r in rows)))
    head = [f"{'size':<24}{'spheres':>9}{'asked':>14}{'made':>14}"] if rows else []
    return head + [
        f"{name[:23]:<24}{n:>9}{_g(asked):>14}{_g(real):>14}  {100 * (real / asked - 1):+.1f} %"
        for name, n, asked, real in rows
    ]


def _nearest(number: float) -> int:
    return max(1, math.floor(number + 0.5))


def _off(asked_kg: Sequence[float], sphere_kg: Sequence[float], counts: Sequence[int]) -> float:
    """Return the excess of the total mass over the requested one, relative to it."""
    return sum(n * one for n, one in zip(counts, sphere_kg, strict=True)) / sum(asked_kg) - 1.0


def _good(asked_kg: Sequence[float], sphere_kg: Sequence[float]) -> bool:
    half = all(m >= 0.5 * one for m, one in zip(asked_kg, sphere_kg, strict=True))
    return half and abs(_off(asked_kg, sphere_kg, whole_counts(asked_kg, sphere_kg))) <= OFF


def _least(asked_kg: Sequence[float], sphere_kg: Sequence[float]) -> float:
    """Return the smallest suitable total mass [kg], at least the requested one, rounded up to three digits."""
    total = sum(asked_kg)
    least = total * max(1.0, *(0.5 * one / m for m, one in zip(asked_kg, sphere_kg, strict=True)))
    digit = 10.0 ** (math.floor(math.log10(least)) - 2)
    least = math.ceil(least / digit) * digit
    while not _good([m * least / total for m in asked_kg], sphere_kg):
        least = math.ceil(FINE * least / digit) * digit
    return least


def _g(mass_kg: float) -> str:
    return f"{1e3 * mass_kg:.4g} g"
