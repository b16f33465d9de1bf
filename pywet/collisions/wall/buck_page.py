"""The page results/wall_collision/index.html: the figures and tables of this model, one file beside its SVG and CSV files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import pandas as pd

from pywet.collisions.wall import accuracy_cost, buck_figures, curves, readings, twin
from pywet.errors import PywetError
from pywet.files import read_csv, write_csv
from pywet.report import page

TABLES: dict[str, Callable[[], pd.DataFrame]] = {
    **curves.FIGURES,
    "accuracy": lambda: accuracy_cost.cost(report=lambda said: print(said, flush=True)),  # a minute or two
    "engine": twin.over_velocity,
    "readings": readings.table,
}
"""Name of an item -> what computes its table."""
TITLES = {
    "fig06": "Fig. 6: how tight a tolerance must be",
    "fig07": "Fig. 7: glass on glass",
    "fig08": "Fig. 8: γ-Al2O3 on glass",
    "fig09": "Fig. 9: where the kinetic energy goes",
    "fig10": "Fig. 10: oblique, dry and wet",
    "fig11": "Fig. 11: four initial spins",
    "fig12": "Fig. 12: sliding and rolling",
    "fig13": "Fig. 13: influence of the liquid",
    "accuracy": "What accuracy costs",
    "engine": "The same collision inside the engine",
    "readings": "What each reading of the paper changes",
}
CAPTIONS = {
    "fig06": "1.74 mm glass at 1 m/s on 400 µm of water. With the toroid in the bridge phase only, 1e-8 is enough.",
    "fig07": "Rebound over impact velocity: (a) 1.74 mm, (b) 0.91 mm, (c) viscosity, (d) surface tension. Below a sticking "
    "velocity the sphere stays; from 2 m/s on the curves are flat.",
    "fig08": "Rebound over impact velocity: (a) layers of water, (b) viscosity on 200 µm. Thick and viscous layers take more.",
    "fig09": "Shares of the kinetic energy over impact velocity: the viscous part grows, gravity and capillarity hardly.",
    "fig10": "γ-Al2O3, dry and on 100 µm Tween 20, over the impact angle: sliding at small angles, a minimum, rolling beyond.",
    "fig11": "γ-Al2O3 on 100 µm Tween 20 with four spins before the impact.",
    "fig12": "The same at −961 rad/s: five regimes; dashed lines are their edges.",
    "fig13": "At −500 rad/s: the liquid hardly changes tangential motion.",
    "accuracy": "Largest error of four collisions over the time they take, each integrator at several tolerances.",
    "engine": "1.74 mm glass on 100 µm of water: this model, the equations that the engine has, the engine itself.",
    "readings": "Coefficients with one reading changed at a time; the first row is the default.",
}
DRAWN = (*curves.FIGURES, "accuracy", "engine")
LEAD = (
    "A sphere falls into the liquid layer of a wall, touches it, leaves, draws a bridge, and rebounds or stays. Lines of the "
    "force balance of Buck et al. (2018); the measurements of the paper are not shown."
)


def write_item(name: str, folder: Path) -> None:
    """Compute one item and write `folder`/NAME.csv, and NAME.svg where it is drawn."""
    if name not in TABLES:
        raise PywetError(f"there is no item {name} on the page, expected one of {', '.join(TABLES)}")
    table = TABLES[name]()
    if name in DRAWN:
        buck_figures.save(name, table, folder / f"{name}.svg")
    write_csv(table, folder / f"{name}.csv")


def write_page(folder: Path, names: Sequence[str] = tuple(TABLES)) -> None:
    """Put the items together to `folder`/index.html."""
    sections = []
    for name in names:
        if name in DRAWN:
            body = page.picture_file(folder / f"{name}.svg", CAPTIONS[name])
        else:
            body = page.paragraph(CAPTIONS[name]) + _as_table(read_csv(folder / f"{name}.csv"))
        body += f'<p class="soft"><a href="{name}.csv">values</a></p>'
        sections.append(page.Section(TITLES[name], body, name))
    page.write(folder / "index.html", "Wet collisions with a wall", LEAD, sections, footer="snakemake wall_collision")


def _as_table(values: pd.DataFrame) -> str:
    rows = [
        ["not defined" if pd.isna(v) else f"{v:.4g}" if isinstance(v, float) else str(v) for v in row]
        for row in values.itertuples(index=False)
    ]
    return page.table([str(c) for c in values.columns], rows)
