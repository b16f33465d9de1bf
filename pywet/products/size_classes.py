"""Size distributions: a sieve analysis, or Rosin-Rammler, log-normal, Gates-Gaudin-Schuhmann.

The result is a number of sizes with their shares of mass: each class of the distribution is represented by one size
or, divided into parts of equal mass, by several.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import Field, model_validator

from pywet.config.entries import Excusable, only
from pywet.errors import ConfigError, one_line, shown
from pywet.geometry.surface import Floats
from pywet.scene import Positive
from pywet.util.files import read_bytes

SUM_PERCENT = 0.5
"""Allowed deviation of the sum of the percentages of a sieve analysis from 100."""
MOST_SIZES = 60
"""Largest number of sizes of one feed: the engine has a contact for each pair of them."""
UPPER_TAIL = 0.01
"""Share of mass of an unbounded distribution that is cut off above if no largest size is given."""


class RosinRammler(Excusable):
    """Rosin-Rammler distribution: 1 - exp(-(d/size)^spread) of the mass passes (Rosin, Rammler, Sperling and Bennett)."""

    size_mm: Positive
    """Size that 63.2 % of the mass passes."""
    spread: Positive
    """Exponent; a large value gives a narrow distribution."""


class LogNormal(Excusable):
    """Log-normal distribution: the logarithm of the size, weighted by mass, is normally distributed."""

    median_mm: Positive
    """Size that half of the mass passes."""
    sigma: Positive
    """Standard deviation of the natural logarithm."""


class GaudinSchuhmann(Excusable):
    """Size distribution of Gates, Gaudin and Schuhmann: (d/largest)^exponent of the mass passes."""

    largest_mm: Positive
    """Size that the whole mass passes."""
    exponent: Positive
    """Slope of the passing curve in a doubly logarithmic plot."""


class Sizes(NamedTuple):
    """Sizes of a feed, their shares of its mass, and the shares cut off below and above."""

    diameter_mm: Floats
    share: Floats
    below: float
    above: float


class SizeDistribution(Excusable):
    """A sieve analysis as CSV, or one of three distributions; cut off below `smallest_mm` and above `largest_mm`."""

    file: Path | None = None
    """CSV file: lower and upper size in mm and mass %, or size in mm and cumulative % passing.

    Columns are separated by comma, semicolon or tab, with decimal commas allowed for the latter two.
    """
    rosin_rammler: RosinRammler | None = None
    """Rosin-Rammler distribution, in place of a file."""
    log_normal: LogNormal | None = None
    """Log-normal distribution, in place of a file."""
    gaudin_schuhmann: GaudinSchuhmann | None = None
    """Gates-Gaudin-Schuhmann distribution, in place of a file."""
    classes: Annotated[int, Field(ge=1, le=MOST_SIZES)] = 8
    """Number of classes of a distribution, with equal ratios of their limits; a file has its own."""
    sizes_per_class: Annotated[int, Field(ge=1, le=20)] = 1
    """Number of sizes that represent a class, each with an equal part of its mass."""
    within: Literal["logarithm", "size"] = "logarithm"
    """Quantity over which the mass is uniform within a class: the logarithm of the size, or the size."""
    smallest_mm: Positive | None = None
    """Size below which material is omitted, which is reported; required for a distribution.

    The finest class of a file, if it begins at 0, can only be cut with `within: size`.
    """
    largest_mm: Positive | None = None
    """Size above which material is omitted; by default that of the coarsest 1 % of an unbounded distribution."""

    @model_validator(mode="after")
    def _one(self) -> Self:
        kinds = ("file", "rosin_rammler", "log_normal", "gaudin_schuhmann")
        given = [k for k in kinds if getattr(self, k) is not None]
        if len(given) != 1:
            raise ValueError(f"psd: one of {', '.join(kinds)}, not {' and '.join(given) or 'none'}")
        only(self, "without file", self.file is None, "classes")
        if self.file is None and self.smallest_mm is None:
            raise ValueError("psd: a smallest_mm, below which material is left out")
        return self

    def passing(self) -> Callable[[Any], Any]:
        """Return the function for the share of mass that passes a size [mm]."""
        from scipy import stats

        if r := self.rosin_rammler:
            return stats.weibull_min(r.spread, scale=r.size_mm).cdf
        if n := self.log_normal:
            return stats.lognorm(n.sigma, scale=n.median_mm).cdf
        assert self.gaudin_schuhmann is not None
        return stats.powerlaw(self.gaudin_schuhmann.exponent, scale=self.gaudin_schuhmann.largest_mm).cdf

    def sizes(self, folder: Path = Path()) -> Sizes:
        """Return the sizes that represent the distribution; a file is looked up in `folder`."""
        edges, mass, outside = self._from_file(folder) if self.file else self._from_law()
        low, high = (np.log(edges), np.exp) if self.within == "logarithm" else (edges, lambda x: x)
        part = (np.arange(self.sizes_per_class) + 0.5) / self.sizes_per_class
        at = high(low[:-1, None] + np.diff(low)[:, None] * part)
        share = np.repeat(mass / mass.sum() / self.sizes_per_class, self.sizes_per_class)
        there = share > 0.0
        if there.sum() > MOST_SIZES:
            raise ConfigError(
                f"psd: {there.sum()} sizes; expected at most {MOST_SIZES}: fewer classes or sizes_per_class",
                code="psd.many_sizes", given=int(there.sum()), expected=MOST_SIZES,
            )  # fmt: skip
        return Sizes(at.ravel()[there], share[there], *outside)

    def _from_law(self) -> tuple[Floats, Floats, tuple[float, float]]:
        """Return the limits of the classes [mm], the mass shares between them, and those below and above."""
        from scipy.optimize import brentq

        passing, low = self.passing(), self.smallest_mm
        assert low is not None
        high = self.largest_mm
        if high is None and self.gaudin_schuhmann:
            high = self.gaudin_schuhmann.largest_mm
        if high is None:
            end = low
            while passing(end) < 1.0 - UPPER_TAIL:
                end *= 2.0
            high = float(brentq(lambda d: passing(d) - 1.0 + UPPER_TAIL, 1e-9 * end, end))
        if not low < high or passing(high) - passing(low) < 1e-9:
            raise ConfigError(
                f"psd: smallest_mm ({low:g}) leaves nothing of a feed up to {high:.4g} mm; expected a smaller one",
                code="psd.smallest", key="smallest_mm", given=low, expected=high,
            )  # fmt: skip
        edges = np.geomspace(low, high, self.classes + 1)
        return edges, np.diff(passing(edges)), (float(passing(low)), float(1.0 - passing(high)))

    def _from_file(self, folder: Path) -> tuple[Floats, Floats, tuple[float, float]]:
        """Divide a sieve analysis into size classes; a class that contains a limit is cut there."""
        assert self.file is not None
        lower, upper, mass = sieve_analysis(folder / self.file)
        low, high = self.smallest_mm or 0.0, self.largest_mm or np.inf
        scale = np.log if self.within == "logarithm" else np.asarray
        finest = float(upper[lower <= 0.0].max(initial=0.0))
        if self.within == "logarithm" and low < finest:
            raise ConfigError(
                f"psd: the finest class of {shown(self.file)}, 0 to {finest:g} mm, has no lower end on a logarithmic scale; "
                f"expected a smallest_mm of {finest:g} or more, a finer sieve in the file, or within: size",
                code="psd.from_zero", key="smallest_mm", file=self.file, given=low, expected=finest,
            )  # fmt: skip
        edges, shares, outside = [], [], [0.0, 0.0]
        for a, b, m in zip(lower, upper, mass, strict=True):
            if b <= low:
                outside[0] += m
                continue
            c, d = min(max(a, low), b), max(min(b, high), a)
            x = scale(np.array([a, c, d, b]))
            parts = np.diff(x) / (x[3] - x[0])
            outside[0] += m * parts[0]
            outside[1] += m * parts[2] if d < b else 0.0
            if d > c:
                edges.append((c, d))
                shares.append(m * parts[1])
        if not sum(shares) > 0.0:
            raise ConfigError(
                f"psd: nothing of {shown(self.file)} is between smallest_mm and largest_mm; expected a wider range",
                code="psd.empty", file=self.file,
            )  # fmt: skip
        limits = np.array([edges[0][0], *(d for _, d in edges)])
        return limits, np.array(shares), (outside[0], outside[1])


def sieve_analysis(path: Path) -> tuple[Floats, Floats, Floats]:
    """Read lower and upper size [mm] and share of mass of the classes of a CSV file, from the finest.

    Raises
    ------
    ConfigError
        If columns, sizes or percentages are not those of a sieve analysis.
    """
    columns = np.array(sorted(_numbers(path))).T
    if len(columns) == 3:
        lower, upper, percent = columns
        if not (lower < upper).all() or not np.allclose(upper[:-1], lower[1:]):
            raise ConfigError(
                f"{shown(path)}: its classes leave gaps or overlap; expected lower sizes below the upper ones, each class "
                "to begin where the one before ends",
                code="psd.gaps", file=path,
            )  # fmt: skip
    else:
        size, passing = columns
        if (np.diff(passing) < 0).any() or (np.diff(size) <= 0).any():
            raise ConfigError(
                f"{shown(path)}: the cumulative % passing falls from one size to a larger one; expected it to rise",
                code="psd.falls", file=path,
            )  # fmt: skip
        lower, upper = np.concatenate([[0.0], size[:-1]]), size
        percent = np.diff(passing, prepend=0.0)
        if percent[0] == 0.0:
            lower, upper, percent = lower[1:], upper[1:], percent[1:]
    total = percent.sum()
    if (percent < 0).any() or abs(total - 100.0) > SUM_PERCENT:
        what = "the largest size is passed by" if len(columns) == 2 else "the mass % add up to"
        raise ConfigError(
            f"{shown(path)}: {what} {total:.5g} %; expected 100 within {SUM_PERCENT:g}, and none below 0",
            code="psd.sum", file=path, given=total, expected=100.0,
        )  # fmt: skip
    return lower, upper, percent / total


def _rows(path: Path, text: str, separator: str) -> Iterator[list[str]]:
    """Yield the cells of each line."""
    try:
        yield from csv.reader(io.StringIO(text, newline=""), delimiter=separator)
    except csv.Error as error:
        raise ConfigError(
            f"{shown(path)} is not a CSV file ({error}); expected sizes in mm and mass %", code="psd.not_csv", file=path
        ) from error


def _numbers(path: Path) -> list[tuple[float, ...]]:
    """Read rows of two or three numbers; a header line is skipped."""
    raw = read_bytes(path, "name a sieve analysis in psd.file")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    separator = next((s for s in ";\t" if s in text), ",")
    found: list[tuple[float, ...]] = []
    for number, fields in enumerate(_rows(path, text, separator), start=1):
        cells = [f.strip().rstrip("%").strip() for f in fields if f.strip()]
        if not cells:
            continue
        try:
            row = tuple(float(c.replace(",", ".") if separator != "," else c) for c in cells)
        except ValueError:
            if found or number > 3:
                raise ConfigError(
                    f"{shown(path)}, line {number}: {one_line(' '.join(cells), 60)} is not a row of numbers; expected sizes in "
                    "mm and mass %",
                    code="psd.not_numbers", file=path, key=f"line {number}",
                ) from None  # fmt: skip
            continue
        if len(row) not in (2, 3) or (found and len(row) != len(found[0])) or not all(np.isfinite(row)):
            raise ConfigError(
                f"{shown(path)}, line {number}: {len(row)} columns; expected lower and upper size and mass %, or size and "
                "cumulative % passing, with a semicolon between columns where commas are decimal",
                code="psd.columns", file=path, key=f"line {number}", given=len(row),
            )  # fmt: skip
        found.append(row)
    if not found:
        raise ConfigError(
            f"{shown(path)} holds no rows of numbers; expected sizes in mm and mass %", code="psd.no_rows", file=path
        )
    return found
