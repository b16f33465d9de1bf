"""A law over many bridges at once: one compiled loop, in which the law's own Python function is inlined and vectorised.

A law remains one function of one bridge. Here it is compiled a second time with `batch_math` in place of `math`,
without branch or call, so that the compiler turns the loop into vector instructions. Operations are not reordered: no
value depends on its position in the batch. A law that does not compile in this form is called by its address.
"""

from __future__ import annotations

import hashlib
import math
import pickle
import types
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from numba.core.dispatcher import Dispatcher

from pywet.laws import batch_math, memory
from pywet.laws.force_law import ForceLaw
from pywet.util.machine_code import numba

BATCH = 64
"""Largest number of bridges in a batch, as in `laws.h` of the plugin."""
ROWS = (
    "separation", "volume", "radius_i", "radius_j", "contact_angle_i", "contact_angle_j", "normal_velocity",
)  # fmt: skip
"""Arguments of a batch for each bridge: arrays of BATCH numbers, in this order."""
_F, _I, _NUMBERS = numba.float64, numba.int64, numba.types.CPointer(numba.float64)
WHOLE = (memory.__name__, batch_math.__name__)
"""Modules that a batch uses unchanged."""
SIGNATURE = numba.void(_I, _NUMBERS, _F, _F, numba.types.CPointer(_I), _NUMBERS)
"""Signature void(n, rows, surface_tension, viscosity, prepared, out) of a batch.

`prepared` contains the address of each bridge's prepared numbers, for laws that have some; `out` receives BATCH
numbers of each function.
"""
TEXT = """def make(key):
    def batch(n, rows, surface_tension, viscosity, prepared, out):
        key
        values = stack()  # laws receive no pointers: data that a law reads from memory cannot change
        for k in range(n):
{body}
        for k in range({count}):
            out[k] = values[k]
    return batch
"""


@dataclass(frozen=True)
class Batch:
    """A compiled loop; `inlined`: the laws are inlined and not called."""

    compiled: Any
    inlined: bool

    @property
    def address(self) -> int:
        """Return the address of the C function, see `SIGNATURE`."""
        return int(self.compiled.address)


@cache
def batch(functions: tuple[ForceLaw, ...]) -> Batch:
    """Compile one loop over bridges that evaluates several laws, each into its own array."""
    digest = hashlib.sha256(Path(batch_math.__file__).read_bytes() + Path(memory.__file__ or "").read_bytes())
    try:
        laws = [_inlined(f.prepared.evaluate if f.prepared else f.python, digest) for f in functions]
        try:
            return Batch(_compiled(functions, laws, digest.hexdigest()), True)
        except Exception:  # code that numba cannot cache, such as that of a law that raises
            return Batch(_compiled(functions, laws, digest.hexdigest(), keep=False), True)
    except Exception:  # whatever the error: compiled alone the law works, or is rejected with a message
        return Batch(_compiled(functions, [f.compiled for f in functions], ""), False)


def _compiled(functions: tuple[ForceLaw, ...], laws: list[Any], key: str, keep: bool = True) -> Any:
    """Compile a loop; `key` names the laws' code in numba's cache; if empty, laws are called and the loop is not cached."""
    lines = []
    for m, function in enumerate(functions):
        given = [f"rows[{BATCH * ROWS.index(name)} + k]" if name in ROWS else name for name in function.arguments]
        given += ["prepared[k]"] if key and function.prepared else []
        lines.append(f"            values[{BATCH * m} + k] = law{m}({', '.join(given)})")
    space: dict[str, Any] = {
        "__name__": __name__,
        "stack": memory.stack(BATCH * len(functions)),
        **{f"law{m}": law for m, law in enumerate(laws)},
    }
    exec(compile(TEXT.format(body="\n".join(lines), count=BATCH * len(functions)), __file__, "exec"), space)
    return numba.cfunc(SIGNATURE, cache=bool(key) and keep, error_model="numpy")(space["make"](key))


def _inlined(function: Callable[..., float], digest: Any) -> Any:
    """Return a copy of a function, and of all functions it calls, that uses `batch_math`; the digest includes their code."""
    code = function.__code__
    digest.update(code.co_code + repr((code.co_consts, code.co_names)).encode())
    space = {n: _swapped(function.__globals__[n], digest) for n in code.co_names if n in function.__globals__}
    _swapped(function.__defaults__, digest)
    cells = tuple(types.CellType(_swapped(c.cell_contents, digest)) for c in function.__closure__ or ())
    copy = types.FunctionType(code, space, function.__name__, function.__defaults__, cells)
    return numba.njit(forceinline=True, error_model="numpy")(copy)


def _swapped(value: Any, digest: Any) -> Any:
    """Return the replacement of a law's global variable in a batch."""
    if value is math:
        return batch_math
    name = getattr(value, "__name__", "")
    if isinstance(value, types.BuiltinFunctionType) and getattr(math, name, None) is value:
        return getattr(batch_math, name)
    if isinstance(value, ForceLaw):
        return _inlined(value.python, digest)
    if isinstance(value, Dispatcher) and value.py_func.__module__ not in WHOLE:
        return _inlined(value.py_func, digest)
    try:
        digest.update(pickle.dumps(value))
    except Exception:  # for example modules
        digest.update(repr(value).encode())
    return value
