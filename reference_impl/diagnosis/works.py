"""Works that do not close the budget, and forces outside the windows that do not reproduce positions (see diagnosis.py)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
import pandas as pd

from reference_impl.diagnosis.diagnosis import Link, Suspect
from reference_impl.diagnosis.suspects import factor, fitted, middle
from reference_impl.motion import budget, flights, window
from reference_impl.replay.arrays import Floats
from reference_impl.replay.io import Run


def columns(
    table: pd.DataFrame, logged: Floats, expected: Floats, names: Sequence[str], quantity: str, what: str, size: Floats,
    limit: float,
) -> Iterator[Link]:  # fmt: skip
    """Yield one link per column; columns may be exchanged."""
    for n, name in enumerate(names):

        def suspects(rows: Floats, n: int = n) -> Iterator[Suspect]:
            for m, other in enumerate(names):
                if m != n:
                    yield Suspect(f"{names[min(m, n)]} and {names[max(m, n)]} are exchanged", expected[:, m])
                    yield Suspect(f"{other} is counted in as well", expected[:, n] + expected[:, m])
            yield from factor(logged[:, n], expected[:, n], rows)
            yield Suspect("it is that of the output before", np.append(expected[:1, n], expected[:-1, n]))
            by = middle((logged[:, n] - expected[:, n])[rows])
            yield Suspect(f"it is off by {by:.6g} throughout", expected[:, n] + by, by)

        yield Link(quantity, f"{what} {name}", table, logged[:, n], expected[:, n], size, suspects, limit)


def works(run: Run) -> Iterator[Link]:
    """Diagnose works: those in windows column by column; otherwise which one, times a factor, would close the budget."""
    names = budget.WORKS
    if run.known.get("works_in_windows"):
        parts = run.known["works_in_windows"]
        logged, expected, size = (np.concatenate([p[k] for p in parts]) for k in range(3))
        table = pd.concat([p[3] for p in parts], ignore_index=True)
        yield from columns(
            table, logged, expected, names, "energy_windows", "work in a window:", size, budget.LIMITS["windows"]
        )
    closed: budget.Budget = run.known["budget"]
    both, turnover = closed.both()
    total = both[[*names]].sum(axis=1).to_numpy(float)
    gain = (both["kinetic_own"] + both["spin_own"]).to_numpy(float)
    expected = gain - gain[0] - both["half_kick"].to_numpy(float)

    def suspects(rows: Floats) -> Iterator[Suspect]:
        for name in names:
            work = both[name].to_numpy(float)
            with np.errstate(all="ignore"):
                f = np.divide(1.0, 1.0 - middle(((total - expected) / work)[rows & (np.abs(work) > 0.0)]))
            if np.isfinite(f):
                yield Suspect(
                    f"the work {name} is {f:.6g} times what it should be", expected + (1.0 - 1.0 / f) * work, f
                )

    yield Link("energy_budget", "sum of the works", both, total, expected, turnover, suspects)
    for name in ("kinetic", "spin", "gravity", *(budget.OF_BRIDGES if closed.known else ())):
        logged, mine = both[name].to_numpy(float), both[f"{name}_own"].to_numpy(float)

        def of_one(rows: Floats, logged: Floats = logged, mine: Floats = mine) -> Iterator[Suspect]:
            yield from factor(logged, mine, rows)
            yield Suspect("it is that of the output before", np.append(mine[:1], mine[:-1]))

        yield Link(f"energy_{name}", f"energy {name}", both, logged, mine, closed.size(name, both, turnover), of_one,
                   budget.LIMITS[name])  # fmt: skip


def flight(run: Run, setup: window.Setup) -> Iterator[Link]:
    """Diagnose forces outside the windows: each of them times a factor."""
    f: flights.Flights | None = run.known.get("flights")
    if f is None:
        return
    base = flights.fly(run, setup, f)
    table = pd.DataFrame({"step": f.step, "i": f.id})
    logged, expected = f.v_end, np.where(base[3][:, None], base[1], f.v_end)
    size = np.maximum(np.sqrt((f.v_end**2).sum(axis=1)), 1e-2)

    def flown(terms: tuple[str, ...], by: float) -> Floats:
        return np.where(base[3][:, None], flights.fly(run, setup, f, dict.fromkeys(terms, by))[1], f.v_end)

    def suspects(rows: Floats) -> Iterator[Suspect]:
        single = {name.replace("_", " ") + (" force" if name != "weight" else ""): (name,) for name in flights.TERMS}
        for what, terms in {**single, "drag": flights.TERMS[2:], "force of bridges": flights.TERMS[1:]}.items():
            by = fitted(partial(flown, terms), logged, rows)
            yield Suspect(f"the {what} is {by:.6g} times what it should be", flown(terms, by), by)

    pairs_of = np.zeros(len(f.id), dtype=bool)
    pairs_of[f.i] = pairs_of[f.j] = True
    marks = {"spheres with bridges": pairs_of, "spheres without": ~pairs_of}
    yield Link(
        "flight_velocity",
        "motion between two outputs",
        table,
        logged,
        expected,
        size,
        suspects,
        flights.LIMIT,
        marks=marks,
    )
