"""Convert a feed (size distribution, mass or rate, moisture) to entries of `spheres` of a user-defined scene."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from pywet.config.entries import Excusable
from pywet.products.size_classes import SizeDistribution, Sizes
from pywet.scene import Positive

G_PER_S = 1e6 / 3600.0
"""Factor from t/h to g/s."""
MOST_PERCENT = 100.0
"""Largest amount of liquid in % of the dry mass."""


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
    """Mass of liquid over the mass of `moisture_of`, in per cent."""
    moisture_of: Literal["dry", "moist"] = "dry"
    """Whether moisture is % of the dry or of the moist mass."""

    @model_validator(mode="after")
    def _one_amount(self) -> Self:
        if (self.mass_g is None) == (self.rate_t_per_h is None):
            raise ValueError("feed: a mass_g or a rate_t_per_h, one of them")
        if self.rate_of == "moist" and self.moisture_percent is None:
            raise ValueError("feed: a moisture_percent with rate_of: moist")
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


def sentence(name: str, sizes: Sizes, spheres: int) -> str:
    """Describe a feed in one sentence: number and sizes of spheres, mass left out."""
    left_out = f"; left out: {cut}" if (cut := cut_off(sizes)) else ""
    smallest, largest = sizes.diameter_mm.min(), sizes.diameter_mm.max()
    return f"feed {name}: {spheres} spheres of {len(sizes.share)} sizes, {smallest:.3g} to {largest:.3g} mm{left_out}"


def cut_off(sizes: Sizes) -> str:
    """Describe the shares of a feed's mass that are finer and coarser than the simulated sizes; empty if there are none."""
    parts = (sizes.below, "finer"), (sizes.above, "coarser")
    return " and ".join(f"{100 * part:.2g} % of its mass {where}" for part, where in parts if part > 0)


def not_simulated(description: dict[str, Any]) -> list[str]:
    """Return a sentence for each feed of a scene of which sizes were left out; not if a file, found from elsewhere, has them."""
    given = {entry["name"]: entry["psd"] for entry in description.get("feed") or () if not entry["psd"].get("file")}
    cuts = {name: cut_off(SizeDistribution.model_validate(psd).sizes(Path())) for name, psd in given.items()}
    return [
        f"feed {name} was simulated without {cut}: the numbers are those of the rest"
        for name, cut in cuts.items()
        if cut
    ]
