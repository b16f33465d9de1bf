"""Results that a sweep gathers from a point: stored ones by name, others on request and by functions of its run."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pywet.errors import PywetError, one_line
from pywet.laws import custom_laws
from pywet.runs.loaded import Run as Loaded
from pywet.sweep import run_numbers
from pywet.sweep.base_kind import Numbers
from pywet.sweep.description import Function
from pywet.sweep.plan import Plan, Run, path_of, refuse_untrusted
from pywet.util.files import read_bytes


def gathered(plan: Plan, run: Run) -> Numbers | None:
    """Return the gathered results of a run; None if it is not done.

    Values computed from the run are stored with its results. Raises `PywetError` if a function fails or a
    requested result does not exist.
    """
    numbers = plan.store.numbers(run.built.name, plan.kind.engine)
    if numbers is None:
        return None
    found: Numbers = {}
    read = dict(numbers)
    for name in plan.gather:
        if isinstance(name, Function):
            word, measure = _function(plan, name)
            if word not in read:
                read[word] = measure(_subject(plan, run, numbers))
            found[name.name] = read[word]
        elif name in run_numbers.ON_REQUEST and plan.kind.engine:
            if name not in read:
                read[name] = _finite(run_numbers.ON_REQUEST[name](Loaded(plan.store.place(run.built.name))), name)
            found[name] = read[name]
        else:
            found[name] = numbers.get(name)
    if read.keys() != numbers.keys():
        plan.store.leave(run.built.name, read)
    return found


def _subject(plan: Plan, run: Run, numbers: Numbers) -> Any:
    """Return the argument of a user's function: the finished run as tables, or the numbers of a run without an engine."""
    return plan.kind.subject(plan.store.place(run.built.name)) if plan.kind.engine else dict(numbers)


def stored_names(plan: Plan) -> list[str]:
    """Return the names under which the results of functions are stored."""
    return [_function(plan, function)[0] for function in plan.gather if isinstance(function, Function)]


def _function(plan: Plan, function: Function) -> tuple[str, Callable[[Any], float]]:
    """Return the name under which a function's result is stored, with the digest of its file, and the function."""
    name = path_of(plan.file, function)
    source = read_bytes(Path(name.rpartition(":")[0]), "fix its path in gather")
    refuse_untrusted(plan.file, function)

    def measure(subject: Any) -> float:
        call = custom_laws.execute(name, source)
        try:
            return _finite(float(call(subject)), function.name)
        except PywetError:
            raise
        except Exception as error:
            raise PywetError(
                f"{function.function} raises {type(error).__name__}: {one_line(error)}; expected a number of every run",
                code="sweep.function_raises", given=function.function,
            ) from error  # fmt: skip

    return f"{function.name} {hashlib.sha256(source).hexdigest()[:16]}", measure


def _finite(value: float, name: str) -> float:
    if not math.isfinite(value):
        raise PywetError(
            f"{name} is {value}; expected a number of every run", code="sweep.not_finite", key=name, given=value
        )
    return float(value)
