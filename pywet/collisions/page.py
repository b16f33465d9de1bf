"""The page results/wall_collision/index.html: the figures and tables of this model, one file beside its SVG and CSV files."""

from __future__ import annotations

import html
from collections.abc import Callable, Sequence
from pathlib import Path

import pandas as pd

from pywet.collisions import curves, effects, figures, study, twin
from pywet.errors import PywetError
from pywet.files import atomic_write


def _cost() -> pd.DataFrame:
    """The accuracy study, telling where it is (it takes a minute or two)."""
    return study.cost(report=lambda said: print(said, flush=True))


TABLES: dict[str, Callable[[], pd.DataFrame]] = {
    **curves.FIGURES,
    "accuracy": _cost,
    "engine": twin.over_velocity,
    "readings": effects.table,
}
"""Name of an item -> what computes its table."""
TITLES = {
    "fig06": "Fig. 6: convergence with the tolerance, 1.74 mm glass at 1 m/s on 400 µm of water",
    "fig07": "Fig. 7: glass on glass: (a) 1.74 mm, (b) 0.91 mm, (c) viscosity, (d) surface tension",
    "fig08": "Fig. 8: γ-Al2O3 on glass: (a) layers of water, (b) viscosity on 200 µm",
    "fig09": "Fig. 9: where the kinetic energy goes",
    "fig10": "Fig. 10: oblique, γ-Al2O3, dry and on 100 µm Tween 20",
    "fig11": "Fig. 11: four initial spins, γ-Al2O3 on 100 µm Tween 20",
    "fig12": "Fig. 12: sliding and rolling at −961 rad/s",
    "fig13": "Fig. 13: influence of the liquid at −500 rad/s",
    "accuracy": "What accuracy costs",
    "engine": "The same collision inside the engine, 1.74 mm glass on 100 µm of water",
    "readings": "Effect of each reading on the coefficients",
}
DRAWN = (*curves.FIGURES, "accuracy", "engine")
PAGE = """<!DOCTYPE html>
<html lang="en"><meta charset="utf-8"><title>Wet collisions with a wall</title>
<style>body{{font:15px/1.5 sans-serif;color:#27323d;max-width:72em;margin:2em auto;padding:0 1em}}
img{{max-width:100%}}table{{border-collapse:collapse}}td,th{{padding:.15em .8em;text-align:right}}
td:first-child,th:first-child{{text-align:left}}</style>
<h1>Wet collisions with a wall</h1>
<p>Lines of the force balance of Buck et al. (2018); the measurements of the paper are not shown.</p>
{body}
</html>
"""


def make(name: str, folder: Path) -> None:
    """Compute one item and write `folder`/NAME.csv, and NAME.svg where it is drawn."""
    if name not in TABLES:
        raise PywetError(f"there is no item {name} on the page, expected one of {', '.join(TABLES)}")
    table = TABLES[name]()
    if name in DRAWN:
        figures.save(name, table, folder / f"{name}.svg")
    with atomic_write(folder / f"{name}.csv") as temporary:
        table.to_csv(temporary, index=False)


def write(folder: Path, names: Sequence[str] = tuple(TABLES)) -> None:
    """Put the items together to `folder`/index.html."""
    parts = []
    for name in names:
        parts.append(f"<h2>{html.escape(TITLES[name])}</h2>")
        if name in DRAWN:
            parts.append(f'<img src="{name}.svg" alt="{html.escape(TITLES[name])}">')
        else:
            table = pd.read_csv(folder / f"{name}.csv")
            parts.append(table.to_html(index=False, float_format=lambda x: f"{x:.4g}", na_rep="not defined", border=0))
        parts.append(f'<p><a href="{name}.csv">values</a></p>')
    with atomic_write(folder / "index.html") as temporary:
        temporary.write_text(PAGE.format(body="\n".join(parts)))
