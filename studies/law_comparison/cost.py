"""Measure nanoseconds per bridge of capillary laws in batches, as in the engine: laws in turn, best of several rounds."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from typing import Any

import numba
import numpy as np
import pandas as pd

from pywet.laws import registry
from pywet.laws.batch import BATCH, ROWS, batch
from pywet.laws.force_law import ForceLaw
from pywet.laws.memory import floats_at, ints_at

BATCHES, ROUNDS = 62, 200
ANGLE = math.radians(20.0)
"""Contact angle of all bodies, so that one table is sufficient."""
LEFT_OUT = ("buck", "davis")
"""Laws of other models, with another definition of the bridge."""


def _loop() -> Any:
    @numba.njit
    def all_batches(law, rows, address, out):  # type: ignore[no-untyped-def]
        for k in range(BATCHES):
            at = 8 * BATCH * k
            law(BATCH, floats_at(rows + at * len(ROWS)), 0.07, 1e-3, ints_at(address + at), floats_at(out))

    return all_batches


def _prepared(law: ForceLaw, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the prepared numbers of each bridge and their memory addresses."""
    lines = law.prepared.lines if law.prepared else 0
    numbers = np.zeros((BATCHES * BATCH, max(8 * lines, 1)))
    address = numbers.ctypes.data + numbers.strides[0] * np.arange(len(numbers), dtype=np.int64)
    if law.prepared:
        prepare = law.prepared.compiled.ctypes
        pointer = prepare.argtypes[-1]
        for bridge, result in zip(rows[:, 1:6].swapaxes(1, 2).reshape(-1, 5), numbers, strict=True):
            prepare(*bridge, result.ctypes.data_as(pointer))
    return numbers, address


def measure(custom: Iterable[str] = (), seed: int = 1) -> pd.DataFrame:
    """Return law, ns, ratio (to rabinovich) of every built-in capillary law and of `custom` ones, on the same random bridges."""
    rng = np.random.default_rng(seed)
    rows = np.full((BATCHES, len(ROWS), BATCH), ANGLE)
    rows[:, 2:4] = rng.choice([1e-3, 1.5e-3, 2.5e-3], (BATCHES, 2, BATCH))
    rows[:, 1] = 10.0 ** rng.uniform(-5, -1, (BATCHES, BATCH)) * rows[:, 2:4].min(axis=1) ** 3
    rows[:, 0] = rng.uniform(0.0, 1.0, (BATCHES, BATCH)) * rows[:, 1] ** (1 / 3)
    names = [*(name for name in registry.BUILT_IN["capillary"] if name not in LEFT_OUT), *custom]
    laws = {name: registry.get("capillary", name) for name in names}
    loop, out, ready = _loop(), np.zeros(BATCH), {}
    for name, law in laws.items():
        law.prepare([(ANGLE, ANGLE)])
        ready[name] = batch(law.functions).compiled, *_prepared(law.functions[0], rows)
    best = dict.fromkeys(laws, np.inf)
    for turn in range(ROUNDS + 1):  # the first one compiles
        for name, (compiled, _, address) in ready.items():
            started = time.perf_counter()
            loop(compiled, rows.ctypes.data, address.ctypes.data, out.ctypes.data)
            best[name] = min(best[name], time.perf_counter() - started) if turn else np.inf
    table = pd.DataFrame({"law": list(best), "ns": [1e9 * t / (BATCHES * BATCH) for t in best.values()]})
    return table.assign(ratio=table["ns"] / table.loc[table["law"] == "rabinovich", "ns"].iloc[0])
