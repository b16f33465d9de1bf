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


def gathered(plan: Plan, run: Run) -> tuple[Numbers, list[str]] | None:
    """Return the gathered results of a run, and why some could not be measured; None if it is not done.

    Values computed from the run are stored with its results.
    """
    numbers = plan.store.numbers(run.built.name, plan.kind.engine)
    if numbers is None:
        return None
    found: Numbers = dict.fromkeys(plan.results)
    why, read = [], dict(numbers)
    for name, result in zip(plan.results, plan.gather, strict=True):
        try:
            found[name] = _measured(plan, run, result, numbers, read)
        except PywetError as error:
            why.append(str(error))
    if read.keys() != numbers.keys():
        plan.store.leave(run.built.name, read)
    return found, why


def _measured(plan: Plan, run: Run, result: str | Function, numbers: Numbers, read: Numbers) -> float | None:
    """Return a result from the stored `numbers` or, if it is computed from the run, from `read`, to which it is added."""
    if isinstance(result, Function):
        word, measure = _function(plan, result)
        if word not in read:
            read[word] = measure(_subject(plan, run, numbers))
        return read[word]
    if result in run_numbers.ON_REQUEST and plan.kind.engine and result not in read:
        read[result] = _finite(run_numbers.ON_REQUEST[result](Loaded(plan.store.place(run.built.name))), result)
    return read.get(result)


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
