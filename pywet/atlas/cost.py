"""Nanoseconds per call of compiled laws, side by side in one run: rounds of all laws in turn, the best round of each counts."""

from __future__ import annotations

import math
import time
from typing import Any

import numba
import numpy as np
import pandas as pd

from pywet.laws import registry

CALLS, ROUNDS = 4000, 200
ANGLE = math.radians(20.0)
"""Contact angle of all bodies, so that one table serves."""
LEFT_OUT = ("buck", "davis")
"""Laws of other models, whose bridge is not this one."""


def _loop() -> Any:
    @numba.njit
    def total(law, s, v, ri, rj, t, sigma):  # type: ignore[no-untyped-def]
        """Sum of a capillary law over arrays, called through its address as the engine does."""
        value = 0.0
        for k in range(s.size):
            value += law(s[k], v[k], ri[k], rj[k], t, t, sigma)
        return value

    return total


def measure(seed: int = 1) -> pd.DataFrame:
    """law, ns, ratio (to rabinovich) of every built-in capillary law, on the same random bridges."""
    rng = np.random.default_rng(seed)
    radii = rng.choice([1e-3, 1.5e-3, 2.5e-3], (2, CALLS))
    volume = 10.0 ** rng.uniform(-5, -1, CALLS) * radii.min(axis=0) ** 3
    separation = rng.uniform(0.0, 1.0, CALLS) * volume ** (1 / 3)
    laws = {name: registry.get("capillary", name) for name in registry.BUILT_IN["capillary"] if name not in LEFT_OUT}
    loop = _loop()
    best = dict.fromkeys(laws, np.inf)
    for law in laws.values():
        law.prepare([(ANGLE, ANGLE)])
        loop(law.functions[0].compiled, separation, volume, *radii, ANGLE, 0.07)
    for _ in range(ROUNDS):
        for name, law in laws.items():
            started = time.perf_counter()
            loop(law.functions[0].compiled, separation, volume, *radii, ANGLE, 0.07)
            best[name] = min(best[name], time.perf_counter() - started)
    table = pd.DataFrame({"law": list(best), "ns": [1e9 * t / CALLS for t in best.values()]})
    return table.assign(ratio=table["ns"] / table.loc[table["law"] == "rabinovich", "ns"].iloc[0])
