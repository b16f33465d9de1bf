"""Convert a feed (size distribution, mass or rate, moisture) to entries of `spheres` of a user-defined scene."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from pywet.config.entries import Excusable, only
from pywet.products.size_classes import SizeDistribution, Sizes
from pywet.scene import Positive

G_PER_S = 1e6 / 3600.0
"""Factor from t/h to g/s."""
MOST_PERCENT = 100.0
"""Largest amount of liquid in % of the dry mass."""
LEFT_OUT = "left_out"
"""Key of a run's description with the shares of each feed's mass that are not simulated."""


class FeedAmount(Excusable):
    """Size distribution, amount and moisture of a feed."""

    psd: SizeDistribution
    """Size distribution: a sieve analysis or a formula."""
    mass_g: Positive | None = None
    """Dry mass, in place of a rate."""
    rate_t_per_h: Positive | None = None
    """Mass inserted per hour, in place of a mass."""
    rate_of: Literal["dry", "moist"] = "dry"
    """Whether the rate is of the dry or of the moist material."""
    moisture_percent: Annotated[float, Field(ge=0, lt=100)] | None = None
    """Mass of liquid over the mass of `moisture_of`, in per cent, the same for each size: larger spheres have thicker films.

    `percent` of the liquid, without `moisture_percent`, gives all sizes films of one thickness.
    """
    moisture_of: Literal["dry", "moist"] = "dry"
    """Whether moisture is % of the dry or of the moist mass."""

    @model_validator(mode="after")
    def _one_amount(self) -> Self:
        if (self.mass_g is None) == (self.rate_t_per_h is None):
            raise ValueError("feed: a mass_g or a rate_t_per_h, one of them")
        if self.rate_of == "moist" and self.moisture_percent is None:
            raise ValueError("feed: a moisture_percent with rate_of: moist")
        only(self, "with rate_t_per_h", self.rate_t_per_h is not None, "rate_of")
        only(self, "with moisture_percent", self.moisture_percent is not None, "moisture_of")
        if (self.dry_percent or 0.0) > MOST_PERCENT:
            raise ValueError(f"feed: a moisture of at most {MOST_PERCENT:g} % of the dry mass")
        return self

    @property
    def dry_percent(self) -> float | None:
        """Return the moisture as % of the dry mass."""
        w = self.moisture_percent
        return w if w is None or self.moisture_of == "dry" else 100.0 * w / (100.0 - w)

    def dry_g(self, for_s: float | None) -> float:
        """Return the total dry mass [g]; for a rate, the mass inserted in `for_s`."""
        if self.mass_g is not None:
            return self.mass_g
        assert self.rate_t_per_h is not None and for_s is not None
        moist = self.rate_of == "moist"
        return self.rate_t_per_h * G_PER_S * for_s / (1.0 + 0.01 * (self.dry_percent or 0.0) * moist)


def entries(
    name: str, amount: FeedAmount, folder: Path, for_s: float | None, common: dict[str, Any]
) -> tuple[list[dict[str, Any]], Sizes]:
    """Return the entries of `spheres`, one for each size, with the `common` keys, and the sizes."""
    sizes, total = amount.psd.sizes(folder), amount.dry_g(for_s)
    percent = {} if amount.dry_percent is None else {"percent": amount.dry_percent}
    found = [
        {**common, **percent, "name": of_size, "diameter_mm": float(d), "mass_g": float(total * share)}
        for of_size, d, share in zip(entry_names(name, sizes), sizes.diameter_mm, sizes.share, strict=True)
    ]
    return found, sizes


def entry_names(name: str, sizes: Sizes) -> list[str]:
    """Return the name of the entry of each size of a feed."""
    return [f"{name} {d:.4g} mm" for d in sizes.diameter_mm]


def sentence(name: str, sizes: Sizes, spheres: int, dry_percent: float | None) -> str:
    """Describe a feed in one sentence: number and sizes of spheres, their liquid, mass left out."""
    left_out = f"; left out: {cut}" if (cut := cut_off(sizes)) else ""
    smallest, largest = sizes.diameter_mm.min(), sizes.diameter_mm.max()
    of_size = (
        f", each size with {dry_percent or 0.0:.3g} % of liquid (liquid.percent: one film thickness for all sizes)"
    )
    return (
        f"feed {name}: {spheres} spheres of {len(sizes.share)} sizes, {smallest:.3g} to {largest:.3g} mm"
        f"{of_size if dry_percent else ''}{left_out}"
    )


def cut_off(sizes: Sizes) -> str:
    """Describe the shares of a feed's mass that are finer and coarser than the simulated sizes; empty if there are none."""
    return _described(shares_left_out(sizes))


def shares_left_out(sizes: Sizes) -> dict[str, float]:
    """Return the shares of a feed's mass that are finer and coarser than the simulated sizes."""
    return {"finer": float(sizes.below), "coarser": float(sizes.above)}


def _described(shares: dict[str, float]) -> str:
    return " and ".join(f"{100 * share:.2g} % of its mass {where}" for where, share in shares.items() if share > 0)


def not_simulated(description: dict[str, Any]) -> list[str]:
    """Return a sentence for each feed of a scene of which sizes were left out.

    Runs of earlier versions did not store these shares: they follow from a formula, and are unknown with a file.
    """
    given = {entry["name"]: entry["psd"] for entry in description.get("feed") or ()}
    shares = {
        name: shares_left_out(SizeDistribution.model_validate(psd).sizes())
        for name, psd in given.items()
        if not psd.get("file")
    } | (description.get(LEFT_OUT) or {})
    cuts = {name: _described(shares[name]) for name in given if name in shares}
    return [
        f"feed {name} was simulated without {cut}: the numbers are those of the rest"
        for name, cut in cuts.items()
        if cut
    ]
