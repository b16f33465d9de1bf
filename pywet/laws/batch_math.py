"""`math` for laws in a batch: sine, cosine, logarithm and exponential without branches or calls, so that a loop vectorises.

Other functions are those of `math`. Relative errors are below 2e-15 (tested), for sine and cosine up to
|x| = 1e5. Multiplications and additions are fused only where stated: a value has the same bits in every place
of a batch and on every processor. Polynomials and split constants are those of fdlibm (Sun Microsystems 1993).
"""

from __future__ import annotations

import math
from typing import Any

import numba
from numba.core import types
from numba.extending import intrinsic

from pywet.laws.memory import from_bits, to_bits

inline = numba.njit(forceinline=True, error_model="numpy")
_ROUND = 6755399441055744.0
"""Constant 1.5·2⁵²: adding and subtracting it rounds to an integer, which the last bits of the sum then contain."""
_ROUND_BITS = 0x4338000000000000


def __getattr__(name: str) -> Any:
    return getattr(math, name)


def _fused(typing: Any, a: Any, b: Any, c: Any) -> Any:
    """Return a b + c, rounded once."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), code


_fma: Any = intrinsic(_fused)


@inline
def _quarter(x):  # type: ignore[no-untyped-def]
    """Return x minus the nearest multiple of π/2, and the quadrant of that multiple."""
    shifted = _fma(x, 0.6366197723675814, _ROUND)
    n = shifted - _ROUND
    r = _fma(n, -2.0222662487959506e-21, _fma(n, -6.077100506303966e-11, _fma(n, -1.5707963267341256, x)))
    return r, to_bits(shifted) & 3


@inline
def _sine(r):  # type: ignore[no-untyped-def]
    z = r * r
    p = _fma(z, 1.58969099521155010221e-10, -2.50507602534068634195e-8)
    p = _fma(z, _fma(z, p, 2.75573137070700676789e-6), -1.98412698298579493134e-4)
    p = _fma(z, _fma(z, p, 8.33333333332248946124e-3), -1.66666666666666324348e-1)
    return _fma(r * z, p, r)


@inline
def _cosine(r):  # type: ignore[no-untyped-def]
    z = r * r
    p = _fma(z, -1.13596475577881948265e-11, 2.08757232129817482790e-9)
    p = _fma(z, _fma(z, p, -2.75573143513906633035e-7), 2.48015872894767294178e-5)
    p = _fma(z, _fma(z, p, -1.38888888888741095749e-3), 4.16666666666666019037e-2)
    return _fma(z, _fma(z, p, -0.5), 1.0)


@inline
def sin(x):  # type: ignore[no-untyped-def]
    """Return the sine of x."""
    r, quarter = _quarter(x)
    value = _sine(r) if quarter & 1 == 0 else _cosine(r)
    return value if quarter & 2 == 0 else -value


@inline
def cos(x):  # type: ignore[no-untyped-def]
    """Return the cosine of x."""
    r, quarter = _quarter(x)
    value = _cosine(r) if quarter & 1 == 0 else _sine(r)
    return value if (quarter + 1) & 2 == 0 else -value


@inline
def log(x):  # type: ignore[no-untyped-def]
    """Return the natural logarithm; like `math.log` in compiled code, −∞ at 0 and NaN below."""
    small = x < 2.2250738585072014e-308
    bits = to_bits(x * 18014398509481984.0 if small else x)
    above = bits - 0x3FE6A09E667F3BCD  # √½: the mantissa is reduced to √½ … √2
    k = from_bits((above >> 52) + _ROUND_BITS) - _ROUND
    f = from_bits(bits - (above & -0x10000000000000)) - 1.0
    k = k - 54.0 if small else k
    s = f / (2.0 + f)
    z = s * s
    w = z * z
    even = _fma(w, _fma(w, 1.531383769920937332e-1, 2.222219843214978396e-1), 3.999999999940941908e-1)
    odd = _fma(w, _fma(w, 1.479819860511658591e-1, 1.818357216161805012e-1), 2.857142874366239149e-1)
    half = 0.5 * f * f
    r = _fma(w, even, z * _fma(w, odd, 6.666666666666735130e-1))
    low = _fma(s, half + r, k * 1.90821492927058770002e-10)
    value = _fma(k, 6.93147180369123816490e-1, f - (half - low))
    value = value if x < math.inf else x
    value = value if x != 0.0 else -math.inf
    return math.nan if x < 0.0 else value


@inline
def exp(x):  # type: ignore[no-untyped-def]
    """Return the exponential of x; 0 below −708."""
    shifted = _fma(x, 1.4426950408889634, _ROUND)
    n = shifted - _ROUND
    high, low = _fma(n, -6.93147180369123816490e-1, x), n * 1.90821492927058770002e-10
    r = high - low
    t = r * r
    p = _fma(t, 4.13813679705723846039e-8, -1.65339022054652515390e-6)
    p = _fma(t, _fma(t, p, 6.61375632143793436117e-5), -2.77777777770155933842e-3)
    c = _fma(-t, _fma(t, p, 1.66666666666666019037e-1), r)
    value = 1.0 - ((low - (r * c) / (2.0 - c)) - high)
    value = from_bits(to_bits(value) + (to_bits(shifted) << 52))
    value = value if x > -708.0 else 0.0
    value = value if x <= 709.782712893384 else math.inf
    return value if x == x else x
