"""Description of the residuals of violated records: factor or amount, whatever the cause."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import permutations, product

import numpy as np
import pandas as pd

from reference_impl.replay.arrays import Floats

NEAR = 0.05
"""Distance of a factor from one below which the size of the deviation says more."""
NARROW = 0.1
"""Width of the middle half of the deviations, relative to their median, within which one number describes all records."""
LEAST = 1e-3
"""Width of the middle half of factors that are the same whatever their median is."""
TURNED = 0.5
"""Part of a vector across the expected one from which on its direction is another."""
FOLLOWS = 0.7
"""Rank correlation from which on a deviation is reported to depend on a logged value."""
FEW = 20
"""Records from which a correlation may be estimated."""
HALF = 0.5
"""Part of the residual that a term must explain to be named."""
ROUND_OFF, RARE = 1e-6, 0.01
"""A component is not off whose residual is that part of the whole one, in all but that share of the records."""
INPUTS = {"separation": "the gap", "volume": "the volume", "speed": "the speed", "v_star": "V*"}
"""Columns on which a law depends, as they are called."""
COMPONENTS = ((0.0, "is zero"), (-1.0, "has the other sign"))


def described(
    logged: Floats, expected: Floats, table: pd.DataFrame | None = None, terms: Mapping[str, Floats] | None = None,
    groups: Mapping[str, Floats] | None = None,
) -> str:  # fmt: skip
    """One phrase: the factor between logged and expected values or its range, how far they are apart, what this follows.

    `table`: the records, of which some columns are inputs of a law; `terms`: parts of the expected value by name; `groups`: kinds
    of contact, each of which may have a factor.
    """
    one, two = logged.reshape(len(logged), -1), expected.reshape(len(expected), -1)
    with np.errstate(all="ignore"):
        every = (one * two).sum(axis=1) / (two**2).sum(axis=1)
        across = np.linalg.norm(one - every[:, None] * two, axis=1) / np.linalg.norm(one, axis=1)
    nothing = ~np.isfinite(every)
    if nothing.mean() > HALF:
        given = f"it is {float(np.median(np.linalg.norm(one[nothing], axis=1))):.4g} where zero is expected"
        return given + ("" if nothing.all() else f", in {nothing.sum()} records") + alone(one - two)
    if logged.ndim > 1 and _middle(across) > TURNED:
        words = _components(one, two) or "its direction is not the expected one"
    else:
        words, same = _amount(one, two, every)
        if same:
            return words
        judged = {name: at & np.isfinite(every) for name, at in (groups or {}).items()}
        of_kinds = {name: _amount(one[at], two[at], every[at]) for name, at in judged.items() if at.any()}
        if len(of_kinds) > 1 and all(constant for _, constant in of_kinds.values()):
            return " and ".join(f"{phrase} {name}" for name, (phrase, _) in of_kinds.items())
        words += _trend(every, table) if table is not None else ""
    words += alone(one - two)
    share = follows(one - two, {name: term.reshape(len(one), -1) for name, term in (terms or {}).items()}, HALF)
    return f"{words}; {share}" if share else words


def alone(rest: Floats) -> str:
    """The components that are off, where not all are; nothing for what is no vector."""
    if rest.shape[1] != 3:
        return ""
    with np.errstate(all="ignore"):
        off = (np.abs(rest) > ROUND_OFF * np.linalg.norm(rest, axis=1)[:, None]).mean(axis=0) > RARE
    names = listed("xyz"[k] for k in np.flatnonzero(off)) if off.any() and not off.all() else ""
    return f", in component {names} alone" if names else ""


def _amount(one: Floats, two: Floats, every: Floats) -> tuple[str, bool]:
    """The factor, the constant amount or the range of factors; and whether one number describes all records."""
    low, middle, high = np.quantile(every[np.isfinite(every)], [0.25, 0.5, 0.75])
    left = np.median(np.linalg.norm(one - middle * two, axis=1)) <= HALF * np.median(np.linalg.norm(one - two, axis=1))
    if left and high - low <= max(NARROW * abs(middle - 1.0), LEAST * (abs(middle - 1.0) > NEAR)):
        apart = middle - 1.0
        digits = 4 if abs(apart) > NEAR else 6
        words = f"{middle:.{digits}g}" if abs(apart) > 1e-4 else f"1 {'+' if apart > 0.0 else '-'} {abs(apart):.2g}"
        return f"it is {words} times what is expected", True
    if one.shape[1] == 1:
        first, by, last = np.quantile(one - two, [0.25, 0.5, 0.75])
        if last - first <= NARROW * abs(by):
            return f"it is off by {by:+.4g} in every record", True
    if abs(middle - 1.0) >= NEAR:
        return f"it is {middle:.3g} times what is expected (middle half of the records {low:.3g} to {high:.3g})", False
    size = np.maximum(np.linalg.norm(one, axis=1), np.linalg.norm(two, axis=1))
    typical = float(np.median(np.linalg.norm(one - two, axis=1) / np.maximum(size, 1e-300)))
    side = "too large" if low > 1.0 else "too small" if high < 1.0 else "off to both sides"
    return f"it is {side} by {typical:.2g} of its value", False


def _components(one: Floats, two: Floats) -> str:
    """Components exchanged, turned or lost; nothing where that does not give the logged vectors."""
    if two.shape[1] != 3:
        return ""
    scale = 1e-6 * float(np.abs(two).max())
    changed = np.flatnonzero(np.abs(one - two).max(axis=0) > scale)
    for order, signs in product(permutations(range(3)), product((1.0, 0.0, -1.0), repeat=3)):
        if np.abs(one - two[:, order] * signs).max() <= scale:
            if list(order) != [0, 1, 2]:
                return f"components {', '.join('xyz'[k] for k in changed)} are exchanged or turned"
            return " and ".join(f"component {'xyz'[k]} {dict(COMPONENTS)[signs[k]]}" for k in changed)
    return ""


def _trend(every: Floats, table: pd.DataFrame) -> str:
    """The input that the factor follows most closely, if it does."""
    best, of = "", FOLLOWS
    use = np.isfinite(every)
    for name, words in INPUTS.items():
        if name not in table or use.sum() < FEW or (values := table[name].to_numpy(float)[use]).min() == values.max():
            continue
        rank = float(np.corrcoef(pd.Series(values).rank(), pd.Series(every[use]).rank())[0, 1])
        if abs(rank) > of:
            best, of = f"; the factor {'rises' if rank > 0.0 else 'falls'} with {words}", abs(rank)
    return best


def follows(rest: Floats, terms: Mapping[str, Floats], least: float = 0.0) -> str:
    """The term that the residual follows best, and by which factor it would be wrong; nothing below `least` of the residual."""
    best, factor, left = "", 1.0, np.inf
    for name, term in terms.items():
        with np.errstate(all="ignore"):
            more = _middle((rest * term).sum(axis=1) / (term**2).sum(axis=1))
            over = _middle((np.linalg.norm(rest - more * term, axis=1) / np.linalg.norm(rest, axis=1)) ** 2)
        if over < left:
            best, factor, left = name, 1.0 + more, over
    if not best or 1.0 - left < least:
        return ""
    return f"{best} would be {factor:.4g} times what is expected ({100.0 * (1.0 - left):.3g} % of the residual)"


def _middle(values: Floats) -> float:
    """Median of what is finite, NaN where nothing is."""
    values = values[np.isfinite(values)]
    return float(np.median(values)) if len(values) else float("nan")


def listed(words: Iterable[str]) -> str:
    """Words as a list: a, b and c."""
    *most, last = words
    return f"{', '.join(most)} and {last}" if most else last
