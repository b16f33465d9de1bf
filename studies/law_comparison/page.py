"""The law comparison as one HTML page with its pictures inside, its tables as CSV next to it, and the pictures as SVG files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from pywet.errors import LawError
from pywet.laws import custom_laws as files_of_laws
from pywet.report import page
from pywet.report.bridge import short
from pywet.report.page import Cell, Section, marked, paragraph, table
from pywet.report.pictures import STYLE, plt, svg
from pywet.util.files import atomic_write, write_csv
from studies.law_comparison import cost, errors, figures, points, stock
from studies.study import Report

LEAD = (
    "Every capillary law, rupture law and sharing law against the exact profile of the bridge, what misprints do, and "
    "what other programs compute."
)
FOOTER = "pywet study laws; the numbers are next to this page as CSV, the pictures as SVG"
Frame = Any
"""Type of tables whose columns pandas' types do not describe."""


def write_page(
    folder: Path, report: Report = lambda what, share: None, *, with_stock: bool = True, custom: Sequence[str] = ()
) -> Path:
    """Compute and draw everything and return the page's path; `custom`: capillary and rupture laws in the user's files."""
    pulls, breaks = (_of_kind(custom, kind) for kind in KINDS)
    report("exact bridges", 0.0)
    comparison = points.solve(lambda done, of: report("exact bridges", 0.15 * done / of))
    report("laws, and tables of the exact law", 0.15)
    force_errors = errors.force_errors(comparison.forces, pulls).drop(columns=list(cost.LEFT_OUT), errors="ignore")
    tables = {
        "forces": errors.force_table(comparison.forces, force_errors),
        "rupture": errors.rupture_table(comparison.limits, breaks),
        "transfer": errors.transfer_table(comparison.limits),
        "misprints": errors.misprint_table(comparison.forces, comparison.limits),
        "cost": cost.measure(pulls),
    }
    measured, missing = pd.DataFrame(), ["not asked for"]
    if with_stock:
        report("stock programs", 0.5)
        measured, missing = stock.measure(comparison.forces)
    tables["stock"] = stock.summary(measured)
    report("pictures", 0.85)
    with plt.rc_context(STYLE):
        drawn = {
            "error_maps": figures.error_maps(comparison.forces, force_errors, pulls),
            "force_curves": figures.force_curves(pulls),
            "rupture": figures.rupture_curves(comparison.limits, breaks),
            "fig7": figures.fig7(),
            "validation": figures.validation(),
            "cost": figures.cost_bars(tables["cost"]),
        }
        whole = {name: svg(figure, bbox_inches="tight") for name, figure in drawn.items()}
    pictures = {name: text[text.index("<svg") :] for name, text in whole.items()}
    for name, frame in tables.items():
        write_csv(frame, folder / f"{name}.csv")
    for name, text in pictures.items():
        with atomic_write(folder / f"{name}.svg") as temporary:
            temporary.write_text(text)
    path = page.write(
        folder / "atlas.html", "Which capillary law to take", LEAD, sections(tables, pictures, missing), footer=FOOTER
    )
    report("done", 1.0)
    return path


KINDS = ("capillary", "rupture")
"""Kinds of law in the comparison."""


def _of_kind(names: Sequence[str], kind: str) -> list[str]:
    """Select the user's laws of this kind; a kind that is not compared is refused."""
    for name in names:
        if not files_of_laws.is_custom(name):
            raise LawError(f"{name} is no law in a file of yours; expected path/to/file.py:function", law=name)
        if (reported := files_of_laws.kind_of(name)) not in KINDS:
            raise LawError(f"law {name} is one of {reported}; the atlas judges laws of {' and '.join(KINDS)}", law=name)
    return [name for name in names if files_of_laws.kind_of(name) == kind]


def sections(tables: dict[str, pd.DataFrame], pictures: dict[str, str], missing: list[str]) -> list[Section]:
    return [
        Section("Which one", _choice(tables["cost"]), "which one"),
        Section("Error of the force against the exact bridge", _forces(tables, pictures), "force"),
        Section("Rupture distance against the limit of stability", _rupture(tables["rupture"], pictures), "rupture"),
        Section("Who keeps the liquid: parabola against the exact profile", _sharing(tables["transfer"], pictures), "sharing"),
        Section("What the misprints do", _misprints(tables["misprints"]), "misprints"),
        Section("Validation configurations of the paper", paragraph(VALIDATION, True) + drawing(pictures["validation"]),
                "validation"),
        Section("Stock programs, as they are", _stock(tables["stock"], missing), "stock programs"),
    ]  # fmt: skip


VALIDATION = (
    "Parameters of Figs. 4 and 5 of Elskamp & Kruggel-Emden 2018; their text gives 24 to 28 mN/m for Fig. 4b, 27 is drawn. The "
    "points of the experiments are not available."
)


def _choice(cost: Frame) -> str:
    ratio = cost.set_index("law").loc["young_laplace", "ratio"]
    return paragraph(
        "Take `young_laplace`: the exact force, from a table made once per pair of contact angles; a bridge met before costs "
        f"{ratio:.1f} times a call of `rabinovich` here. Without tables, `willett` or `bagheri` are the best closed forms for "
        "equal spheres and contact angles up to about 40°. `rabinovich` reproduces the paper; it is too strong, the more so "
        "the more liquid there is and the less it wets."
    )


def _graded(value: float, hint: str = "") -> Cell:
    """Make a coloured cell with a median error in per cent."""
    return Cell(_percent(value), "good" if value < 0.02 else "fair" if value < 0.15 else "bad", hint)


def _forces(tables: dict[str, Frame], pictures: dict[str, str]) -> str:
    """Return every law by bodies and gap, the most accurate between equal spheres first, with its cost."""
    by_law = {name: rows.set_index(["bodies", "gap"]) for name, rows in tables["forces"].groupby("law", sort=False)}
    cost, places = tables["cost"].set_index("law"), [(b, g) for b in errors.BODIES for g in errors.GAPS]
    rows: page.Rows = []
    for law, row in sorted(by_law.items(), key=lambda item: float(item[1].loc[("equal spheres", "gap"), "median"])):
        hints = {p: f"95 %: {_percent(row.loc[p, 'p95'])} %, worst {_percent(row.loc[p, 'worst'])} % at {row.loc[p, 'where']}"
                 for p in row.index}  # fmt: skip
        cells = [_graded(row.loc[p, "median"], hints[p]) if p in hints else Cell("") for p in places]
        equal = _graded(row.loc[("equal spheres", "gap"), "p95"], hints["equal spheres", "gap"])
        of_cost = [f"{cost.loc[law, 'ns']:.0f}", f"{cost.loc[law, 'ratio']:.2f}"]
        rows.append([Cell(f"`{short(law)}`", "good" if law == "young_laplace" else ""), *cells, equal, *of_cost])
    header = ["law", *(f"{b}: {g}" for b, g in places), "95 %, all gaps, equal spheres", "ns per call", "× rabinovich"]
    return (
        paragraph(
            "Median of |F/F exact − 1| in per cent over a grid of V* from 1e-5 to 0.1 and contact angles 0/0°, 20/20°, 40/40°, "
            "60/60°, 10/40°; hover over a cell for the 95 % bound, the worst case and where it is. Gap: S from 0.02 to 0.8 of "
            "the rupture distance; near rupture: 0.9 and beyond. Radii 1:2 and 1:5 for unequal spheres.",
            soft=True,
        )
        + table(header, rows)
        + drawing(pictures["error_maps"], "Equal spheres, contact angle 20°: error over separation and volume. Red: too strong.")
        + drawing(pictures["force_curves"], "Equal spheres of radius r, V* = 0.01. Dotted: exact rupture distance.")
        + drawing(
            pictures["cost"],
            "Compiled laws called by address as the engine does, 4000 bridges in turn, best of 200 rounds. The first call of "
            "`young_laplace` for a new bridge costs about five times as much; it is remembered for the bridge's life.",
        )
    )  # fmt: skip


def _rupture(rupture: Frame, pictures: dict[str, str]) -> str:
    return page.table_of(rupture[~rupture["law"].isin(cost.LEFT_OUT)].itertuples(), {
        "law": lambda r: f"`{short(r.law)}`",
        "bodies": lambda r: r.bodies,
        "median |error| %": lambda r: _graded(r.median),
        "95 % %": lambda r: _percent(r.p95),
        "worst %": lambda r: _percent(r.worst),
    }) + drawing(pictures["rupture"])  # fmt: skip


def _sharing(transfer: Frame, pictures: dict[str, str]) -> str:
    """Return the comparison of parabola and exact transfer ratio, per pair of bodies."""
    pairs = transfer.assign(size=transfer["difference"].abs()).groupby(
        ["ratio", "angle_i_deg", "angle_j_deg"], sort=False
    )
    worst = transfer.loc[pairs["size"].idxmax()].assign(middle=pairs["size"].median().to_numpy())
    return page.table_of(worst.itertuples(), {
        "radius small/large (0: wall)": lambda r: f"{r.ratio:g}",
        "θ small / large": lambda r: f"{r.angle_i_deg:g}° / {r.angle_j_deg:g}°",
        "median |difference| of T": lambda r: f"{r.middle:.3f}",
        "largest difference": lambda r: f"{r.difference:+.3f}",
        "at V*": lambda r: f"{r.v_star:.0e}",
        "exact T there": lambda r: f"{r.transfer_i:.3f}",
    }) + drawing(pictures["fig7"], "Fig. 7 of Elskamp & Kruggel-Emden 2018: parabola solid, exact dashed.")  # fmt: skip


def _misprints(misprints: Frame) -> str:
    return page.table_of(misprints.itertuples(), {
        "as printed": lambda r: f"`{r.printed}`",
        "against": lambda r: f"`{r.mended}`",
        "bodies": lambda r: r.bodies,
        "smallest %": lambda r: f"{r.smallest:.0f}",
        "median %": lambda r: f"{r.median:.0f}",
        "largest %": lambda r: f"{r.largest:.0f}",
    })  # fmt: skip


def _stock(stock_errors: Frame, missing: list[str]) -> str:
    message = paragraph(
        "Two bodies inside Debian's LIGGGHTS 3.8.0 and YADE 2023.02a; range of F/F exact − 1 in per cent over V* = 1e-3 and 1e-2 "
        "and contact angles 0, 20, 40°.",
        soft=True,
    )
    measured = page.table_of(stock_errors.itertuples(), {
        "program": lambda r: r.program,
        "law": lambda r: r.law,
        "bodies": lambda r: r.bodies,
        "S / S_rup": lambda r: f"{r.share:g}",
        "smallest %": lambda r: _percent(r.low),
        "largest %": lambda r: _percent(r.high),
        "bridges": lambda r: str(r.bridges),
    })  # fmt: skip
    lines = "".join(paragraph(f"Not measured: {line}", soft=True) for line in missing)
    return message + (measured if len(stock_errors) else "") + lines


def _percent(value: float) -> str:
    size = abs(100 * value)
    return f"{100 * value:.0f}" if size >= 10 else f"{100 * value:.1f}" if size >= 1 else f"{100 * value:.2g}"


def drawing(svg: str, caption: str = "") -> str:
    """Return a picture given as SVG text, with its caption."""
    return f"<figure>{svg}{f'<figcaption>{marked(caption)}</figcaption>' if caption else ''}</figure>"
