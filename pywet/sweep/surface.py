"""Response of a sweep over its numerical axes: a polynomial of second order with the standard error of its mean."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from pywet.calibration.inference import Floats, Surface, terms
from pywet.sweep.description import Sweep
from pywet.sweep.table import DONE


@dataclass(frozen=True)
class Response:
    """A response surface over the unit cube of some axes; `low` and `width` of each axis on its scale."""

    keys: list[str]
    logarithmic: list[bool]
    low: Floats
    width: Floats
    fitted: Surface

    def places(self, values: Floats) -> Floats:
        """Convert values of the axes (n, axes) to points in the unit cube."""
        on_scale = np.where(self.logarithmic, np.log(np.where(self.logarithmic, values, 1.0)), values)
        return np.asarray((on_scale - self.low) / self.width)

    def at(self, values: Floats) -> tuple[Floats, Floats]:
        """Return mean and its standard error at values of the axes (n, axes)."""
        found = [self.fitted.at(place) for place in self.places(values)]
        return np.array([m[0] for m, _ in found]), np.sqrt([v[0] for _, v in found])


def through(sweep: Sweep, made: pd.DataFrame, result: str, keys: list[str]) -> Response | None:
    """Fit a surface of a result over numerical axes to all given rows, a run once at each place.

    It is None if they are too few, or if axes are of one zip, whose points are along a line.
    """
    if len({sweep.factor(key) for key in keys}) < len(keys):
        return None
    rows = made[(made["status"] == DONE) & made[result].notna()].drop_duplicates([*keys, "run"])
    if rows.empty:
        return None
    values = rows[keys].to_numpy(float)
    logarithmic = [sweep.axes[key].logarithmic for key in keys]
    on_scale = np.where(logarithmic, np.log(np.where(logarithmic, values, 1.0)), values)
    low, width = on_scale.min(axis=0), np.ptp(on_scale, axis=0)
    if (width == 0.0).any():
        return None
    places = (on_scale - low) / width
    known = terms(places)
    if len(rows) <= known.shape[1] or np.linalg.matrix_rank(known) < known.shape[1]:
        return None
    return Response(keys, logarithmic, low, width, Surface.through(places, rows[[result]].to_numpy(float)))
