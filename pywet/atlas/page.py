"""The atlas as one HTML page with its pictures inside, its tables as CSV beside it, and the pictures as SVG files."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jinja2
import pandas as pd

from pywet.atlas import cost, errors, figures, points, stock
from pywet.files import atomic_write
from pywet.view import page as frame

TEMPLATE = Path(__file__).with_name("atlas.html.j2")
LEAD = (
    "Every capillary law, rupture law and sharing law against the exact profile of the bridge, what misprints do, and "
    "what other programs compute."
)
FOOTER = "pywet laws --atlas; the numbers are beside this page as CSV, the pictures as SVG"
SHORT = {
    "Which one": "which one",
    "Error of the force against the exact bridge": "force",
    "Rupture distance against the limit of stability": "rupture",
    "Who keeps the liquid: parabola against the exact profile": "sharing",
    "What the misprints do": "misprints",
    "Validation configurations of the paper": "validation",
    "Stock programs, as they are": "stock programs",
}
"""Heading in the template -> its name in the navigation."""
Report = Callable[[str, float], None]
"""Called with what is being done and the share that is done."""


def write(folder: Path, report: Report = lambda what, share: None, *, with_stock: bool = True) -> Path:
    """Compute and draw everything; returns the page's path."""
    report("exact bridges", 0.0)
    atlas = points.solve(lambda done, of: report("exact bridges", 0.15 * done / of))
    report("laws, and tables of the exact law", 0.15)
    found = errors.force_errors(atlas.forces).drop(columns=list(cost.LEFT_OUT), errors="ignore")
    tables = {
        "forces": errors.force_table(atlas.forces, found),
        "rupture": errors.rupture_table(atlas.limits),
        "transfer": errors.transfer_table(atlas.limits),
        "misprints": errors.misprint_table(atlas.forces, atlas.limits),
        "cost": cost.measure(),
    }
    report("stock programs", 0.5)
    measured, missing = stock.measure(atlas.forces) if with_stock else (pd.DataFrame(), ["not asked for"])
    tables["stock"] = stock.summary(measured)
    report("pictures", 0.85)
    pictures = {
        "error_maps": figures.error_maps(atlas.forces, found),
        "force_curves": figures.force_curves(),
        "rupture": figures.rupture_curves(atlas.limits),
        "fig7": figures.fig7(),
        "validation": figures.validation(),
        "cost": figures.cost_bars(tables["cost"]),
    }
    for name, table in tables.items():
        with atomic_write(folder / f"{name}.csv") as temporary:
            table.to_csv(temporary, index=False)
    for name, text in pictures.items():
        with atomic_write(folder / f"{name}.svg") as temporary:
            temporary.write_text(text)
    path = frame.write(
        folder / "atlas.html", "Which capillary law to take", LEAD, sections(tables, pictures, missing), footer=FOOTER
    )
    report("done", 1.0)
    return path


def context(tables: dict[str, pd.DataFrame], pictures: dict[str, str], missing: list[str]) -> dict[str, Any]:
    """What the template shows."""
    forces, price = tables["forces"], tables["cost"].set_index("law")
    laws: list[dict[str, Any]] = []
    for law in forces["law"].unique().tolist():
        cells = {(r["bodies"], r["gap"]): r for r in forces[forces["law"] == law].to_dict("records")}
        paid = price.loc[law]
        laws.append({"name": law, "cells": cells, "ns": float(paid["ns"]), "ratio": float(paid["ratio"])})
    laws.sort(key=lambda entry: entry["cells"][("equal spheres", "gap")]["median"])
    return {
        "laws": laws,
        "bodies": list(errors.REGIONS),
        "gaps": list(errors.GAPS),
        "rupture": tables["rupture"][~tables["rupture"]["law"].isin(cost.LEFT_OUT)].to_dict("records"),
        "transfer": _transfer(tables["transfer"]),
        "misprints": tables["misprints"].to_dict("records"),
        "stock": tables["stock"].to_dict("records"),
        "missing": missing,
        "pictures": pictures,
    }


def _transfer(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Parabola against exact, per pair of bodies."""
    rows = []
    for (q, small, large), part in table.groupby(["ratio", "angle_i_deg", "angle_j_deg"], sort=False):
        worst = part.iloc[int(part["difference"].abs().to_numpy().argmax())]
        row = {"ratio": q, "small": small, "large": large, "median": part["difference"].abs().median()}
        rows.append({**row, "worst": worst["difference"], "at": worst["v_star"], "exact": worst["transfer_i"]})
    return rows


def _percent(value: float) -> str:
    size = abs(100 * value)
    return f"{100 * value:.0f}" if size >= 10 else f"{100 * value:.1f}" if size >= 1 else f"{100 * value:.2g}"


def sections(tables: dict[str, pd.DataFrame], pictures: dict[str, str], missing: list[str]) -> list[frame.Section]:
    """The page's sections: the template's headings and what stands below each."""
    _, *parts = re.split(r"<h2>(.*?)</h2>\n", _render(context(tables, pictures, missing)))
    return [frame.Section(heading, body, SHORT[heading]) for heading, body in zip(parts[::2], parts[1::2], strict=True)]


def _render(shown: dict[str, Any]) -> str:
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["percent"] = _percent
    return environment.from_string(TEMPLATE.read_text()).render(shown)
