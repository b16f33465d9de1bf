"""The page results/wall_collision/index.html: figures and tables of Buck et al. (2018), and the cost of accuracy."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from pywet.report import page
from studies.buck2018 import accuracy_cost, buck_impact, curves, readings
from studies.buck2018 import buck_figures as figures
from studies.items import Item, sections

ITEMS = {
    "fig06": Item(
        "Fig. 6: how tight a tolerance must be",
        "1.74 mm glass at 1 m/s on 400 µm of water. With the toroid in the bridge phase only, 1e-8 is enough.",
        curves.convergence, figures.convergence,
    ),
    "fig07": Item(
        "Fig. 7: glass on glass",
        "Rebound over impact velocity: (a) 1.74 mm, (b) 0.91 mm, (c) viscosity, (d) surface tension. Below a sticking "
        "velocity the sphere stays; from 2 m/s on the curves are flat.",
        curves.normal_glass, figures.over_velocity,
    ),
    "fig08": Item(
        "Fig. 8: γ-Al2O3 on glass",
        "Rebound over impact velocity: (a) layers of water, (b) viscosity on 200 µm. Thick and viscous layers take more.",
        curves.normal_alumina, figures.over_velocity,
    ),
    "fig09": Item(
        "Fig. 9: where the kinetic energy goes",
        "Shares of the kinetic energy over impact velocity: the viscous part grows, gravity and capillarity hardly.",
        curves.dissipation, figures.dissipation,
    ),
    "fig10": Item(
        "Fig. 10: oblique, dry and wet",
        "γ-Al2O3, dry and on 100 µm Tween 20, over the collision angle: rolling at small angles, a minimum, sliding beyond.",
        curves.oblique, lambda table: figures.over_angle(table, ("e_n", "e_t", "omega_out")),
    ),
    "fig11": Item(
        "Fig. 11: four initial spins", "γ-Al2O3 on 100 µm Tween 20 with four spins before the impact.",
        curves.spinning, figures.over_angle,
    ),
    "fig12": Item(
        "Fig. 12: sliding and rolling", "The same at −961 rad/s: five regimes, each shaded.",
        curves.spinning, figures.regimes,
    ),
    "fig13": Item(
        "Fig. 13: influence of the liquid", "At −500 rad/s: the liquid hardly changes tangential motion.",
        curves.liquids, figures.over_angle,
    ),
    "accuracy": Item(
        "What accuracy costs",
        "Largest error of four collisions over the time they take, each integrator at several tolerances.",
        accuracy_cost.cost, figures.accuracy,
    ),
    "engine": Item(
        "The same collision inside the engine",
        "1.74 mm glass on 100 µm of water: this model, the equations that the engine has, the engine itself.",
        buck_impact.over_velocity, figures.engine,
    ),
    "readings": Item(
        "What each reading of the paper changes",
        "Coefficients with one reading changed at a time; the first row is the default.",
        readings.table,
    ),
}  # fmt: skip
LEAD = (
    "A sphere falls into the liquid layer of a wall, touches it, leaves, draws a bridge, and rebounds or stays. Lines of the "
    "force balance of Buck et al. (2018); the measurements of the paper are not shown."
)


def write_page(folder: Path, items: Mapping[str, Item] = ITEMS) -> Path:
    """Make the items and assemble them in `folder`/index.html."""
    title, footer = "Wet collisions with a wall", "snakemake wall_collision"
    return page.write(folder / "index.html", title, LEAD, sections(folder, items), footer=footer)
