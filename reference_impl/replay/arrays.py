"""Tables as arrays by name, and vectors as arrays (n, 3) with contiguous columns.

A frame of pandas costs a millisecond for fifty columns at every access, and `numpy.cross` more than the rest of a
force law: for millions of contacts both took longer than the physics.
"""

from __future__ import annotations

from collections.abc import ItemsView, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

Floats = NDArray[Any]


@dataclass(frozen=True)
class Columns:
    """Columns of equal length, by name."""

    by_name: Mapping[str, Floats]

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(next(iter(self.by_name.values()), ()))

    def __getitem__(self, name: str) -> Floats:
        return self.by_name[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.by_name)

    def items(self) -> ItemsView[str, Floats]:
        """Return name and values of each column."""
        return self.by_name.items()

    def rows(self, names: Sequence[str]) -> Floats:
        """Return some columns as one array of floats."""
        return np.stack([self.by_name[name] for name in names], axis=1).astype(float)

    def cut(self, first: int, last: int) -> Columns:
        """Select a range of rows without copying them."""
        return Columns({name: values[first:last] for name, values in self.by_name.items()})

    def take(self, rows: Floats) -> Columns:
        """Select rows by their numbers, in that order."""
        return Columns({name: values[rows] for name, values in self.by_name.items()})

    def frame(self) -> pd.DataFrame:
        """Convert the columns to a data frame of pandas."""
        return pd.DataFrame(dict(self.by_name), copy=False)


Table = pd.DataFrame | Columns


def joined(parts: list[Columns]) -> Columns:
    """Join the rows of all parts, at least one."""
    if len(parts) == 1:
        return parts[0]
    return Columns({name: np.concatenate([part[name] for part in parts]) for name in parts[0]})


def column(table: Table, name: str) -> Floats:
    """Return one column as floats."""
    return np.asarray(table[name], dtype=np.float64)


def vectors(table: Table, name: str) -> Floats:
    """Read a vector from three columns of a table."""
    return np.array([np.asarray(table[f"{name}_{axis}"]) for axis in "xyz"], dtype=np.float64).T


def apart(table: Table, one: str, other: str) -> Floats:
    """Return the norm of the difference of two vectors in each row."""
    pairs = ((np.asarray(table[f"{one}_{axis}"]), np.asarray(table[f"{other}_{axis}"])) for axis in "xyz")
    return np.array([a - b for a, b in pairs], dtype=np.float64).T


def dot(a: Floats, b: Floats) -> Floats:
    """Return the scalar product of two vectors in each row."""
    return np.asarray(np.einsum("ij,ij->i", a, b))


def size(a: Floats) -> Floats:
    """Return the length of each row."""
    return np.asarray(np.sqrt(dot(a, a)))


def cross(a: Floats, b: Floats) -> Floats:
    """Return the vector product of two vectors in each row."""
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]).T
