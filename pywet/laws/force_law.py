"""`@force_law`: a plain Python function of floats becomes a law, callable on scalars and arrays and, by its address, from C.

Functions are compiled at their first use.
"""

from __future__ import annotations

import inspect
import itertools
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import ModuleType
from typing import Any, overload

import numpy as np
from numba.core.dispatcher import Dispatcher
from numba.extending import typeof_impl

from pywet.errors import LawError, PywetError
from pywet.laws.kinds import KINDS, Sense
from pywet.util.machine_code import numba


@dataclass(frozen=True)
class Prepared:
    """A law in two parts, for batches: one that depends only on the bridge, evaluated once, and one that depends on its gap.

    `prepare(volume, radius_i, radius_j, contact_angle_i, contact_angle_j, numbers)` fills an array of 8 `lines` numbers;
    `evaluate(…the law's arguments, address)` returns the law's value from the numbers at that address.
    """

    lines: int
    prepare: Callable[..., None]
    evaluate: Callable[..., float]

    @cached_property
    def compiled(self) -> Any:
        """Return `prepare` as a C function of five numbers and a pointer."""
        number = numba.float64
        return numba.cfunc(numba.void(*[number] * 5, numba.types.CPointer(number)), error_model="numpy")(self.prepare)


class ForceLaw:
    """A compiled law: scalars or arrays in, float or array out; `address` is a C function double(double, …)."""

    prepared: Prepared | None = None
    """The law in two parts, if that is cheaper."""
    cached = True
    """Whether the compiled code of a built-in law may be cached between processes."""
    fastmath: Any = False
    """Floating-point optimisations allowed to the compiler (numba's `fastmath`)."""

    def __init__(self, function: Callable[..., float]) -> None:
        self.python = function
        self.name = function.__name__
        self.__doc__ = function.__doc__
        self.__name__ = function.__name__
        self.__module__ = function.__module__
        self.__signature__ = inspect.signature(function)
        self.arguments = tuple(self.__signature__.parameters)

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Evaluate the law with positional or named arguments; arrays are broadcast against each other."""
        if named or len(arguments) != len(self.arguments):
            arguments = self._in_order(arguments, named)
        return self._value(*arguments)

    def _in_order(self, arguments: tuple[Any, ...], named: dict[str, Any]) -> tuple[Any, ...]:
        try:
            return self.__signature__.bind(*arguments, **named).args
        except TypeError as error:
            raise LawError(
                f"law {self.name}: {error}; expected ({', '.join(self.arguments)})",
                law=self.name, code="law.order", expected=self.arguments,
            ) from None  # fmt: skip

    def _value(self, *arguments: Any) -> Any:
        self._refuse_nan(arguments)
        if self.tabulated:
            self.tables(dict(zip(self.arguments, arguments, strict=True)))
        with np.errstate(all="ignore"):  # both sides of a branch may be evaluated; `check` examines the value
            value = self._ufunc(*arguments)
        return float(value) if np.ndim(value) == 0 else value

    def _refuse_nan(self, arguments: tuple[Any, ...]) -> None:
        """Refuse an argument that is no number: in its comparisons a law would take one branch or the other."""
        for name, value in zip(self.arguments, arguments, strict=True):
            if value != value if isinstance(value, float) else np.isnan(value).any():
                share = f" in {np.isnan(value).sum()} of {np.size(value)} values" if np.ndim(value) else ""
                raise LawError(
                    f"law {self.name}: {name} is nan{share}; expected numbers",
                    law=self.name, code="law.argument_nan", key=name, expected="numbers",
                )  # fmt: skip

    @property
    def address(self) -> int:
        """Return the address of the compiled C function, double(double, …)."""
        return int(self.compiled.address)

    @cached_property
    def callee(self) -> Any:
        """Return the law in the form in which another law's compiled code calls it."""
        return numba.njit(error_model="numpy", fastmath=self.fastmath)(self.python)

    @cached_property
    def calls(self) -> tuple[ForceLaw, ...]:
        """Return the laws that this law's function calls, directly or through other functions."""
        return tuple(_called(self.python, set()))

    @cached_property
    def tabulated(self) -> bool:
        """Return whether the compiled code reads tables that `tables` prepares."""
        return any(law.tabulated for law in self.calls)

    def tables(self, arguments: Mapping[str, Any]) -> None:
        """Prepare the tables that the laws called here read at these values of the arguments."""
        for law in self.calls:
            law.tables(arguments)

    @cached_property
    def _signature(self) -> Any:
        return numba.float64(*[numba.float64] * len(self.arguments))

    @cached_property
    def compiled(self) -> Any:
        """Return the compiled C function in the form in which numba's code can call it."""
        return self._compile(
            lambda cache: numba.cfunc(self._signature, cache=cache, error_model="numpy", fastmath=self.fastmath)(
                self.python
            )
        )

    @cached_property
    def _ufunc(self) -> Any:
        return self._compile(lambda cache: numba.vectorize([self._signature], cache=cache)(self.python))

    def _compile(self, build: Callable[[bool], Any]) -> Any:
        # numba compares only the file of the function itself: another law may call functions of other files, or read tables
        # at addresses of this process; closures with the same source would share a file
        built_in = str(self.__module__).startswith("pywet.") and self.__module__ in sys.modules
        in_file = self.cached and built_in and self.python.__closure__ is None and not self.tabulated
        try:
            return build(in_file)
        except Exception as error:  # numba passes on whatever the user's code raises
            lines = [line.strip() for line in str(error).splitlines() if line.strip()]
            reasons = [line for line in lines if not line.startswith("Failed in nopython mode")]
            reason = reasons[0] if reasons else type(error).__name__
            raise LawError(
                f"law {self.name} does not compile ({reason}); expected a function of floats that numba understands: "
                f"fix {self.python.__code__.co_filename}",
                law=self.name, code="law.not_compiled", where=self.python.__code__.co_filename,
            ) from error  # fmt: skip


@typeof_impl.register(ForceLaw)
def _as_called(law: ForceLaw, _: Any) -> Any:
    """Let numba compile a law that is called by another law's function."""
    return numba.types.Dispatcher(law.callee)


def _called(function: Any, seen: set[int]) -> Iterator[ForceLaw]:
    """Yield the laws among the names in a function, and recursively in the functions that it names."""
    cells = [cell.cell_contents for cell in function.__closure__ or ()]
    names = function.__code__.co_names
    values = [function.__globals__[name] for name in names if name in function.__globals__] + cells
    for value in values:  # the module adds the names that the function uses
        if id(value) in seen:
            continue
        seen.add(id(value))
        if isinstance(value, ModuleType):
            values += [vars(value)[name] for name in names if name in vars(value)]
        elif isinstance(value, ForceLaw):
            yield value
        elif isinstance(value, Dispatcher):
            yield from _called(value.py_func, seen)


@overload
def force_law(given: Callable[..., float]) -> ForceLaw: ...
@overload
def force_law(given: str, name: str = "") -> Callable[[Callable[..., float]], ForceLaw]: ...
def force_law(given: Any, name: str = "") -> Any:
    """Make a law of a plain function of floats.

    Parameters
    ----------
    given : callable or str
        The function (`@force_law`), or a kind of law (`@force_law("capillary")`), under which the function is also registered.
    name : str
        Name under which it is registered; default: that of the function. The functions of one law share a name, in the order of
        their kind.

    Returns
    -------
    ForceLaw or callable
        The law, callable with numbers or arrays, or the decorator.

    Raises
    ------
    LawError
        If the arguments are not those of the kind.

    Examples
    --------
    >>> @force_law
    ... def linear(speed: float, viscosity: float, surface_tension: float) -> float:
    ...     return 1.0 + speed * viscosity / surface_tension
    >>> round(float(linear(2.0, 0.01, 0.05)), 12)
    1.4
    """
    if isinstance(given, str):
        return lambda function: _known(given, name, force_law(function))
    if not inspect.isfunction(given):
        raise LawError(f"@force_law decorates {given!r}; expected a plain function of floats", code="law.not_plain")
    return ForceLaw(given)


def _known(kind: str, name: str, law: ForceLaw) -> ForceLaw:
    if law.__module__ in sys.modules:  # a file run by its path is identified by it
        register(kind, name or law.name, law)
    return law


REGISTERED: dict[str, dict[str, tuple[ForceLaw, ...]]] = {kind: {} for kind in KINDS}
"""Kind -> name -> functions of a registered law."""


def check_kind(kind: str) -> None:
    """Raise `LawError` where there is no kind of law of this name."""
    if kind not in KINDS:
        raise LawError(
            f"there is no kind of law named {kind}; expected one of {', '.join(KINDS)}",
            law=kind, code="law.kind", expected=tuple(KINDS),
        )  # fmt: skip


def register(kind: str, name: str, *functions: ForceLaw) -> None:
    """Register a law under a name, or add a function to a law that needs several."""
    check_kind(kind)
    together = (*REGISTERED[kind].get(name, ()), *functions)
    if len(together) > len(KINDS[kind].parts):
        raise PywetError(
            f"there is already a {kind} law named {name}; rename the second one", code="law.name_taken", given=name
        )
    REGISTERED[kind][name] = together


helper = numba.njit(cache=True, inline="always")
"""Decorator of small functions shared by laws."""

PROBE: dict[str, tuple[float, ...]] = {
    "separation": (-1e-5, 0.0, 1e-7, 1e-4, 1e-3),
    "volume": (1e-14, 1e-11, 1e-9),
    "film_volume_i": (0.0, 1e-11, 1e-8),
    "radius_i": (5e-4, 5e-3),
    "radius_j": (5e-4, 5e-3, np.inf),
    "half_width": (5e-4,),
    "film_thickness": (0.0, 1e-4),
    "contact_angle_i": (0.0, 0.8),
    "contact_angle_j": (0.0, 0.8),
    "surface_tension": (0.0728,),
    "viscosity": (1e-3,),
    "normal_velocity": (-0.1, 0.0, 0.1),
    "speed": (0.0, 1.0),
    "acceleration": (0.0, 9.81, 1000.0),
    "density": (1000.0,),
}
"""Values of the arguments on which a law is tested before a run."""

FINITE: Sense = ("finite numbers", lambda value, at: np.isfinite(value))


def check(law: ForceLaw, arguments: tuple[str, ...], sense: Sense | None = None) -> None:
    """Refuse a law whose arguments differ from those of its kind, or that gives invalid values on the probe grid."""
    if law.arguments != arguments:
        raise LawError(
            f"law {law.name} takes ({', '.join(law.arguments)}); expected ({', '.join(arguments)}): "
            f"fix {law.python.__code__.co_filename}",
            law=law.name, code="law.arguments", expected=tuple(arguments), where=law.python.__code__.co_filename,
        )  # fmt: skip
    grid = np.array(list(itertools.product(*(PROBE[name] for name in arguments)))).T
    try:
        values = np.asarray(law(*grid))
    except PywetError:
        raise
    except Exception as error:  # any exception of the user's law
        raise LawError(
            f"law {law.name} raises {type(error).__name__} ({error}) on the probe grid; fix {law.python.__code__.co_filename}",
            law=law.name, code="law.raises_on_grid", where=law.python.__code__.co_filename,
        ) from error  # fmt: skip
    probed = dict(zip(arguments, grid, strict=True))
    for expected, sensible in (FINITE, *([sense] if sense else [])):
        good = sensible(values, probed)
        if not good.all():
            worst = int(np.argmin(good))
            at = ", ".join(f"{name}={column[worst]:g}" for name, column in probed.items())
            value = f"{values[worst]:g}" if np.isfinite(values[worst]) else "a value that is not finite"
            raise LawError(
                f"law {law.name} gives {value} at {at}; expected {expected}: fix {law.python.__code__.co_filename}",
                law=law.name, code="law.value", where=law.python.__code__.co_filename,
            )  # fmt: skip
