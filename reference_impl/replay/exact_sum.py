"""Sums that are independent of the order of the terms, and of how they are divided into parts."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from reference_impl.replay.arrays import Floats

HIGH, LOW = 27, 26
"""Bits of the two halves of a double's fraction: up to 2^26 of them can be added exactly in doubles."""
LEAST = -1073
"""Smallest exponent of a double as returned by frexp."""


@dataclass
class Exact:
    """A sum of doubles without round-off; `value` is rounded once."""

    high: dict[int, int] = field(default_factory=dict)
    """Exponent -> sum of the fractions, in units of 2^(exponent - 53)."""
    odd: float = 0.0
    """Sum of terms that are not finite."""

    def add(self, values: Floats) -> None:
        """Add numbers to the sum without round-off."""
        finite = np.isfinite(values)
        if not finite.all():
            self.odd += float(values[~finite].sum())
        fraction, exponent = np.frexp(values[finite])
        upper, lower = np.divmod(np.ldexp(fraction, HIGH), 1.0)
        sums = [np.bincount(exponent - LEAST, half) for half in (upper, np.ldexp(lower, LOW))]
        for at in np.flatnonzero(sums[0]):
            more = (int(sums[0][at]) << LOW) + int(sums[1][at])
            self.high[int(at) + LEAST] = self.high.get(int(at) + LEAST, 0) + more

    @property
    def value(self) -> float:
        """Sum of all numbers so far, rounded once."""
        return float(sum(n * Fraction(2) ** (e - HIGH - LOW) for e, n in self.high.items())) + self.odd
