"""Low-level pieces of laws that read tables by address: pointers, bits of a number, a cube root. Compiled code only."""

from __future__ import annotations

from typing import Any

import numba
from numba.core import cgutils, types
from numba.extending import intrinsic

FAST = {"contract", "reassoc", "arcp", "nsz"}
"""Floating-point optimisations allowed in table laws: order of sums and reciprocals, but not NaN or infinity."""
inline = numba.njit(inline="always", error_model="numpy", fastmath=FAST)
"""Decorator of helper functions; not cached, because addresses are valid for one process only."""


def _reinterpret(source: Any, target: Any, instruction: str = "bitcast") -> Any:
    """Return an intrinsic that reinterprets the bits of a 64-bit type as another, or an address as a pointer."""

    @intrinsic
    def bits(typing: Any, value: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return getattr(builder, instruction)(arguments[0], context.get_value_type(target))

        return target(source), code

    return bits


floats_at, singles_at, ints_at = (
    _reinterpret(types.int64, types.CPointer(kind), "inttoptr") for kind in (types.float64, types.float32, types.int64)
)


def stack(count: int) -> Any:
    """Return an intrinsic that allocates `count` numbers on the caller's stack and returns their address."""

    @intrinsic
    def numbers(typing: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return cgutils.alloca_once(builder, context.get_value_type(types.float64), size=count)

        return types.CPointer(types.float64)(), code

    return numbers


to_bits, from_bits = _reinterpret(types.float64, types.int64), _reinterpret(types.int64, types.float64)


@inline
def cube_root(a):  # type: ignore[no-untyped-def]
    """Return the cube root to 1e-14: a third of the exponent, then two Halley steps (numba's own costs several times as much)."""
    x = abs(a) + 1e-18
    y = from_bits(to_bits(x) // 3 + 0x2A9F7893782DA1CE)
    for _ in range(2):
        y3 = y * y * y
        y *= (y3 + 2.0 * x) / (2.0 * y3 + x)
    return y if a > 0.0 else -y
