"""Small dense linear algebra for compiled code: Gauss elimination of 5 × 5 systems, the determinant of a 4 × 4 block."""

from __future__ import annotations

from pywet.laws.exact_bridge.meridian import Floats, jit


@jit
def solve_linear(matrix: Floats, right: Floats) -> bool:
    """Gauss elimination with pivots, in place; the answer replaces `right`. False when singular."""
    n = right.size
    for k in range(n):
        pivot = k
        for m in range(k + 1, n):
            if abs(matrix[m, k]) > abs(matrix[pivot, k]):
                pivot = m
        if not abs(matrix[pivot, k]) > 0.0:
            return False
        if pivot != k:
            for c in range(n):
                matrix[k, c], matrix[pivot, c] = matrix[pivot, c], matrix[k, c]
            right[k], right[pivot] = right[pivot], right[k]
        for m in range(k + 1, n):
            factor = matrix[m, k] / matrix[k, k]
            for c in range(k, n):
                matrix[m, c] -= factor * matrix[k, c]
            right[m] -= factor * right[k]
    for k in range(n - 1, -1, -1):
        for c in range(k + 1, n):
            right[k] -= matrix[k, c] * right[c]
        right[k] /= matrix[k, k]
    return True


@jit
def determinant(matrix: Floats) -> float:
    """Determinant of the leading 4 × 4 block."""
    a = matrix[:4, :4].copy()
    value = 1.0
    for k in range(4):
        pivot = k
        for m in range(k + 1, 4):
            if abs(a[m, k]) > abs(a[pivot, k]):
                pivot = m
        if pivot != k:
            for c in range(4):
                a[k, c], a[pivot, c] = a[pivot, c], a[k, c]
            value = -value
        value *= a[k, k]
        if a[k, k] == 0.0:
            return 0.0
        for m in range(k + 1, 4):
            factor = a[m, k] / a[k, k]
            for c in range(k, 4):
                a[m, c] -= factor * a[k, c]
    return value
