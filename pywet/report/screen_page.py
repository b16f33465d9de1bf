"""The page of a screen, `screen.html` in the run's folder: five numbers, partition curve, products over time, pegging map."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.collections import PolyCollection

from pywet import run_folder
from pywet.products import apertures, screening_report, until
from pywet.products.apertures import of_deck
from pywet.products.feed import not_simulated
from pywet.products.partition import LEFT_NONE, WITHIN
from pywet.products.screening_report import cut_position, unsteady
from pywet.products.streams import PRODUCTS, asked_from, decks
from pywet.report import page
from pywet.report.pictures import COLOURS, INK, STYLE, colours, legend, panels, plt
from pywet.runs.rundir import RunDir
from pywet.runs.spread import plus_minus, with_interval

COLOUR_OF = dict(zip((*PRODUCTS, "hold_up"), COLOURS, strict=False))
"""Colour of each product, and of the mass in the machine, in all charts."""
STRETCHED = 0.5
"""Smallest height of the pegging map over its width."""
MOISTURE = "moisture, overs / unders"
"""Name of the moisture of both products, which a dry feed does not have."""
SPILLED = "spilled, in no product"
"""Name of the share that left through outlets of no product, named where there is one."""
PAGE = "screen"
"""Name of the page."""
Evaluated = tuple[dict[str, Any], pd.DataFrame, pd.DataFrame]
"""Numbers, partition curve and time series of a deck."""


def shown(value: float | None, unit: str = "", digits: int = 3) -> str:
    """Format a number with its unit, – if undefined."""
    return "–" if value is None else f"{value:.{digits}g}{unit}"


def measured(value: float | None, half: float | None, unit: str, factor: float = 1.0) -> str:
    """Format a number ± half its 95 % interval with its unit, without ± if there is none or if blocks coincide by chance."""
    return "–" if value is None else plus_minus(factor * value, factor * half if half else None) + unit


def between(value: float | None, ends: tuple[float | None, float | None], unit: str, factor: float = 1.0) -> str:
    """A number with its unit and the ends of its 95 % interval, of which one may not be defined."""
    if value is None:
        return "–"
    low, high = (shown(None if end is None else factor * end) for end in ends)
    interval = f"at most {high}" if ends[0] is None else f"at least {low}" if ends[1] is None else f"{low} – {high}"
    return shown(factor * value, unit) + ("" if ends == (None, None) else f" ({interval})")


def five(numbers: dict[str, Any]) -> dict[str, str]:
    """Describe cut size and sharpness, efficiency, throughput, product moisture and blinding, with 95 % intervals."""
    rates, moist = numbers["throughput_t_per_h"], numbers["moisture_percent_of_dry_mass"]
    of = "all" if "all" in rates else "unders"
    per_area, share = numbers["throughput_t_per_h_m2"].get(of), numbers.get("pegged_share")
    scatter = numbers.get("moisture_half_width_percent") or {}
    rate = measured(rates[of], numbers["throughput_half_width_t_per_h"].get(of), " kg/h", 1e3)
    cut = numbers.get("d50_low_mm"), numbers.get("d50_high_mm")
    sharp = numbers.get("efficiency_low"), numbers.get("efficiency_high")
    products = " / ".join(measured(moist[p], scatter.get(p), " %") for p in PRODUCTS)
    feed = "feed" if numbers.get("deck", 1) == 1 else "feed of the top deck"
    products += f", {feed} {shown(numbers['feed_moisture_percent'], ' %')}"
    return {
        "cut size d50": between(numbers["d50_mm"], cut, " mm") + _outside(numbers),
        "ecart probable": shown(numbers["ecart_probable_mm"], " mm") + _without_quartiles(numbers),
        "efficiency": between(numbers["efficiency"], sharp, " %", 100.0),
        f"throughput, {of}": f"{rate}, {shown(per_area, ' t/(h m²)')}",
        **({MOISTURE: products} if moistened(numbers) else {}),
        **({SPILLED: shown(100.0 * spilled, " % of the feed")} if (spilled := numbers.get("spilled_share")) else {}),
        "apertures pegged": measured(share, numbers.get("pegged_share_half_width"), " %", 100.0)
        if numbers["screen"]
        else "–",
    }


def moistened(numbers: dict[str, Any]) -> bool:
    """Return whether the feed was moist."""
    return bool(numbers["feed_moisture_percent"])


def _outside(numbers: dict[str, Any]) -> str:
    """Say that the cut size is at an end of the sizes, or why there is none; nothing if sizes on both sides enclose it."""
    where = cut_position(numbers)
    if numbers["d50_mm"] is not None:
        return "" if where == WITHIN else f", {where}"
    counts = ", ".join(f"{numbers['spheres'][p]} {p}" for p in PRODUCTS)
    return f" ({where})" if where == LEFT_NONE else f" ({where}: {counts})"


def _without_quartiles(numbers: dict[str, Any]) -> str:
    """Say why the ecart probable is not defined; nothing if it is, or if nothing left the screen."""
    undefined = numbers["ecart_probable_mm"] is None and any(numbers["spheres"][p] for p in PRODUCTS)
    return " (d25 or d75 outside the sizes)" if undefined else ""


def not_within(every: Iterable[dict[str, Any]]) -> str:
    """Count the cut sizes that sizes on both sides do not enclose, by where they are; empty if all are enclosed."""
    counts = Counter(cut_position(numbers) for numbers in every)
    return ", ".join(f"{count} {where}" for where, count in counts.items() if where != WITHIN)


def over_seeds(every: Sequence[dict[str, Any]]) -> dict[str, str]:
    """Return the five numbers of several seeds: mean ± half of its 95 % interval over those for which they are defined."""
    of = "all" if all("all" in numbers["throughput_t_per_h"] for numbers in every) else "unders"

    def mean(values: Iterable[float | None], unit: str, factor: float = 1.0, others: str = "") -> str:
        there = [factor * value for value in values if value is not None]
        notes = [f"{len(there)} of {len(every)} seeds"] if 0 < len(there) < len(every) else []
        notes += [others] if others else []
        return (f"{with_interval(there)}{unit}" if there else "–") + (f" ({'; '.join(notes)})" if notes else "")

    ecart = mean((n["ecart_probable_mm"] for n in every), " mm")
    moist = [numbers["moisture_percent_of_dry_mass"] for numbers in every]
    return {
        "cut size d50": mean((n["d50_mm"] for n in every), " mm", others=not_within(every)),
        "ecart probable": ecart + (_without_quartiles(every[0]) if ecart == "–" else ""),
        "efficiency": mean((n["efficiency"] for n in every), " %", 100.0),
        f"throughput, {of}": mean((n["throughput_t_per_h"].get(of) for n in every), " kg/h", 1e3),
        **({MOISTURE: " / ".join(mean((m[p] for m in moist), " %") for p in PRODUCTS)} if moistened(every[0]) else {}),
        "apertures pegged": mean((n.get("pegged_share") for n in every), " %", 100.0),
    }


def cards(words: dict[str, str]) -> list[page.Card]:
    """Return a card for each number in words, with what follows the first value in small print."""
    found = []
    for name, value in words.items():
        first, *more = re.split(r"(?= \()|, ", value, maxsplit=1)
        found.append(page.Card(first, " ".join([name, *(m.strip() for m in more)])))
    return found


def unlevel(numbers: dict[str, Any]) -> str | None:
    """Return a sentence if pegging and passage are undefined, as the screen is not horizontal."""
    return numbers.get("pegged_undefined")


def left_out(folder: Path) -> list[str]:
    """Return sentences on the sizes of the feeds that were not simulated."""
    return not_simulated(RunDir(folder).json("description.json", dict[str, Any]) or {})


def sections(run: RunDir, numbers: dict[str, Any], curve: pd.DataFrame, series: pd.DataFrame) -> list[page.Section]:
    """Return the sections of a page on a screen."""
    known = run.json(until.RESULT, dict[str, Any])
    with plt.rc_context(STYLE):
        drawn = [_partition(numbers, curve), _products(series)]
        drawn += [_moisture(run, series)] if moistened(numbers) else []
        drawn += [] if unlevel(numbers) else [_passage(run, numbers)]
        drawn += [] if unlevel(numbers) or not numbers["screen"] else [_pegging(run, numbers)]
    rows: list[list[page.Cell | str]] = [
        [page.left(name), page.left(value)] for name, value in {**five(numbers), **_more(run, numbers)}.items()
    ]
    deck = f" {numbers['deck']}" if numbers["deck"] > 1 else ""
    return [
        page.Section(
            "Screen" + (f", deck{deck}" if deck else ""),
            "".join(page.paragraph(f"{s[0].upper()}{s[1:]}.") for s in (unsteady(numbers), unlevel(numbers)) if s)
            + page.table(["number", "value (95 % interval within the run)"], rows)
            + (page.paragraph(until.sentence(known)) if known else ""),
            f"Screen{deck}",
        ),
        page.Section("Partition, products, pegging", f'<div class="panels">{"".join(drawn)}</div>', f"Curves{deck}"),
    ]


def _more(run: RunDir, numbers: dict[str, Any]) -> dict[str, str]:
    keys = {
        "imperfection": ("imperfection", 1.0, ""),
        "size that parts undersize from oversize": ("reference_mm", 1.0, " mm"),
        "undersize recovery": ("undersize_recovery", 100.0, " %"), "oversize recovery": ("oversize_recovery", 100.0, " %"),
        "purity of the unders": ("unders_purity", 100.0, " %"), "purity of the overs": ("overs_purity", 100.0, " %"),
        "misplaced, of both products": ("misplaced", 100.0, " %"),
    }  # fmt: skip
    found = {
        name: shown(numbers[key] if numbers[key] is None else factor * numbers[key], unit)
        for name, (key, factor, unit) in keys.items()
    }
    found["spheres, overs / unders"] = " / ".join(str(numbers["spheres"][p]) for p in PRODUCTS)
    for p in PRODUCTS:
        found[f"residence of the {p}, mean"] = shown(numbers["residence_s"][p]["mean"], " s")
    found["means from – to"] = f"{numbers['from_s']:.3g} – {numbers['to_s']:.3g} s ({_period(run, numbers)})"
    return found


def _period(run: RunDir, numbers: dict[str, Any]) -> str:
    """Describe why means are over this time: only what was looked for is called steady."""
    if numbers["kind"] == "batch":
        return "batch"
    if "from" in numbers.get("options", {}):
        return "from --from on"
    if asked_from(run) is not None:
        return "from until.from_s on"
    return "steady" if numbers["steady"] else "no steady state: second half of the feed"


def _partition(numbers: dict[str, Any], curve: pd.DataFrame) -> str:
    figure, (axes,) = panels(1, 1, (4.2, 3.3))
    d, t = curve["diameter_mm"], curve["T"]
    axes.plot(d, 100 * t, marker="o", label="partition curve")
    axes.vlines(d, 100 * curve["T_low"], 100 * curve["T_high"], color=COLOURS[0], alpha=0.5)
    for end in ("low", "high"):  # for the CSV file
        axes.plot(d, 100 * curve[f"T_{end}"], linestyle="none", label=f"95 % {end}")
    if numbers["d50_mm"]:
        axes.axvline(numbers["d50_mm"], color=INK, linestyle="--")
    if numbers["reference_mm"] not in (None, numbers["d50_mm"]):
        axes.axvline(numbers["reference_mm"], color=INK, linestyle=":")
    axes.set(xlabel="size [mm]", ylabel="to the overs [%]", ylim=(-3, 103))
    lines = {"cut size": "dashed", "aperture": "dotted"}
    there = [numbers["d50_mm"], numbers["reference_mm"] not in (None, numbers["d50_mm"])]
    named = [f"; {line}: {what}" for (what, line), drawn in zip(lines.items(), there, strict=True) if drawn]
    return page.curves(figure, "partition", f"Partition curve with 95 % intervals of the counts{''.join(named)}")


def _products(series: pd.DataFrame) -> str:
    figure, (axes,) = panels(1, 1, (4.2, 3.3))
    for name, colour in COLOUR_OF.items():
        axes.plot(
            series["time_s"], 1e3 * series[f"{name}_kg"], label=name.replace("_", "-"), color=colour, linestyle="-"
        )
    axes.set(xlabel="time [s]", ylabel="dry mass [g]")
    legend(figure)
    return page.curves(figure, "products", "Mass in the machine, and of both products until then")


def _moisture(run: RunDir, series: pd.DataFrame) -> str:
    figure, (axes,) = panels(1, 1, (4.2, 3.3))
    density = run.scene.liquid.density_kg_per_m3 if run.scene.liquid else 0.0
    for p in PRODUCTS:
        mass = series[f"{p}_kg"].where(series[f"{p}_kg"] > 0)
        axes.plot(series["time_s"], 100 * density * series[f"{p}_liquid_m3"] / mass, label=p, color=COLOUR_OF[p])
    axes.set(xlabel="time [s]", ylabel="moisture [% of dry mass]")
    legend(figure)
    return page.curves(figure, "moisture", "Moisture of the products collected until then")


def crossings(run: RunDir, deck: int = 1) -> pd.DataFrame:
    """Return the position along x of each sphere at the first output below the screen, where that then is: id, type, x [m]."""
    table, screen = run.trajectory, apertures.screen_of(run, deck)
    plane, raised = run.scene.screen_z_m, np.zeros(len(table))
    if screen and screen.name != "wires":
        plane = float(apertures.extents(run, screen)[0][:, 2].min())
    if screen:
        motion = run.mesh_motion[run.mesh_motion["mesh"] == screen.name]
        raised = motion.set_index("step")["dz"].reindex(table["step"]).to_numpy()
    entered = table["step"].to_numpy() >= run.enters[np.searchsorted(run.timeline.ids, table["id"])]
    below = table[(table["z"].to_numpy() - raised < plane) & entered].drop_duplicates("id")
    return below[["id", "type", "x"]]


def _passage(run: RunDir, numbers: dict[str, Any]) -> str:
    figure, (axes,) = panels(1, 1, (4.2, 3.3))
    crossed, screen = crossings(run, numbers["deck"]), apertures.screen_of(run, numbers["deck"])
    x = crossed["x"].to_numpy(dtype=float)
    low, high = (x.min(), x.max()) if len(x) else (0.0, 1.0)
    if screen:
        ends = apertures.extents(run, screen)
        low, high = float(ends[0][:, 0].min()), float(ends[1][:, 0].max())
    edges, feed = np.linspace(low, high, 11), run.timeline.types[run.timeline.entered_by_end]
    for c in run.scene.classes:
        here = crossed[crossed["type"] == c.type]["x"].to_numpy(dtype=float)
        counts, _ = np.histogram(here, edges)
        axes.plot(
            1e3 * 0.5 * (edges[1:] + edges[:-1]), counts / max((feed == c.type).sum(), 1), marker=".", label=c.name
        )
    axes.set(xlabel="x along the screen [mm]", ylabel="share of the feed of its size [-]")
    legend(figure)
    return page.curves(
        figure, "passage", "Passage along the deck: what passed at each place, of all that was fed of its size"
    )


def stretch(x_m: float, y_m: float) -> float:
    """Length of a unit of y over one of x on the map of a deck, so that no side is shorter than `STRETCHED` of the other.

    >>> stretch(0.2, 0.1), stretch(0.4, 0.1), stretch(0.1, 0.4)
    (1.0, 2.0, 0.5)
    """
    return float(max(1.0, STRETCHED * x_m / y_m) * min(1.0, x_m / y_m / STRETCHED))


def _pegging(run: RunDir, numbers: dict[str, Any]) -> str:
    screen = apertures.screen_of(run, numbers["deck"])
    assert screen is not None
    stuck, line = apertures.pegged(run, screen), run.timeline
    wanted = pd.DataFrame(np.argwhere(stuck & line.entered), columns=["output", "sphere"])
    wanted = wanted.assign(step=line.steps[wanted["output"]], id=line.ids[wanted["sphere"]])
    at = wanted.merge(run.trajectory[["step", "id", "type", "x", "y"]], on=["step", "id"])
    figure, (axes,) = panels(1, 1, (4.2, 3.3))
    low, high = apertures.extents(run, screen)
    frames = 1e3 * np.stack(
        [low[:, :2], np.c_[high[:, 0], low[:, 1]], high[:, :2], np.c_[low[:, 0], high[:, 1]]], axis=1
    )
    axes.add_collection(PolyCollection(list(frames), facecolors="none", edgecolors="#b9c2ca", linewidths=0.5))
    for c, colour in zip(run.scene.classes, colours(len(run.scene.classes)), strict=True):
        rows = at[at["type"] == c.type]
        if len(rows):
            axes.plot(
                1e3 * rows["x"], 1e3 * rows["y"], "o", ms=4, mew=0, alpha=0.6, color=colour,
                label=c.name, rasterized=True,
            )  # fmt: skip
    axes.autoscale_view()
    stretched = stretch(*(high[:, :2].max(axis=0) - low[:, :2].min(axis=0)))
    axes.set(xlabel="x [mm]", ylabel="y [mm]", aspect=stretched)
    if len(at):
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.02), ncols=2)
    scale = "" if stretched == 1.0 else f"; y is stretched {stretched:.2g} times"
    caption = f"Pegging map from above: spheres that peg an aperture, at all outputs; darker: longer{scale}"
    return page.curves(figure, "pegging", caption)


def of_run(folder: Path) -> list[Evaluated]:
    """Return the results of all decks of a run as `pywet screen` evaluates them without options; none for other runs."""
    every = (screening_report.stored_with_tables(folder, deck) for deck in range(1, decks(RunDir(folder).scene) + 1))
    return [found for found in every if found]


def write(folder: Path, numbers: dict[str, Any]) -> Path:
    """Write the page of a deck of an evaluated run and return its path."""
    run, deck = RunDir(folder), numbers["deck"]
    warning = unsteady(numbers)
    lead = "".join(f"{line[0].upper()}{line[1:]}. " for line in (warning, *left_out(folder)) if line)
    lead += "Partition, efficiency, throughput, products, with 95 % intervals within the run."
    return page.write(
        page_of(folder, deck), f"Screen: {numbers['run']}", lead,
        sections(run, numbers, *screening_report.tables(run, deck)), cards(five(numbers)),
    )  # fmt: skip


def page_of(folder: Path, deck: int) -> Path:
    """Return the path of the page of a deck."""
    return folder / f"{of_deck(PAGE, deck)}.html"


def screen(
    folder: Path | str, aperture_mm: float | None = None, from_s: float | None = None, deck: int = 1
) -> dict[str, Any]:
    """Compute cut size, efficiency, throughput, moisture and pegging of a run, and write its tables and `screen.html`.

    Parameters
    ----------
    folder : Path or str
        Finished run of a screening case, or of a custom scene whose outlets are overs and unders.
    aperture_mm : float, optional
        Size that parts undersize from oversize; if not given that of the case or of the deck, else the cut size.
    from_s : float, optional
        Time from which means are taken; if not given, from where the run is steady.
    deck : int
        Of several decks the one meant, counted from above; its files have its number in their names.

    Returns
    -------
    dict
        Content of `results/screen.json`; None for what is not defined.

    Raises
    ------
    PywetError
        If the run has neither a collecting bin nor outlets that are overs and unders.
    """
    with run_folder.reading(Path(folder)):
        numbers = screening_report.write(Path(folder), aperture_mm, from_s, deck)
        write(Path(folder), numbers)
    return numbers
