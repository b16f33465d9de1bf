"""Draw the curves of the report, in the grids of Figs. 10, 12, 13 and 15 of Elskamp & Kruggel-Emden (2018), as SVG text.

Panels follow from the cases given: one per material (dry), one per configuration (moisture), in the order of the cases.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from pywet.report.collect import CaseResult, by_liquid, grouped, named
from pywet.report.embedded_json import embedded
from pywet.report.pictures import GREEN, NAVY, ORANGE, SKY, STYLE, VIOLET, colours, inline, panels, plt, svg

MOISTURE = ("#9a8f80", SKY, NAVY, "#6a51a3")
"""Colours of dry, first, second, … liquid amount."""
TIME = "time since the slide opened in s"
CONFIGURATION = (NAVY, SKY, ORANGE, GREEN, VIOLET)
DASHED = (0, (4, 2))
WIDEST = 40
"""Letters of a heading that fit a panel; longer ones are printed smaller."""
BAND = ":band"
"""Suffix of the name of a curve for the band between its seeds."""
COARSE = "coarse_share"
"""Column for the line at the share that cannot pass."""
FRACTION, LIQUID = "fraction_retained", "liquid_percent"
QUANTITIES = {"time_since_opening_s": TIME, FRACTION: "fraction retained Y", LIQUID: "liquid in % of what was put in"}
"""Quantity of an axis and its label."""
PLACES = {
    "coarse_material_large": ("on the screen: large", "#0b3c78"),
    "coarse_material_near_mesh": ("on the screen: near mesh", "#3b7fbf"),
    "coarse_material_small": ("on the screen: small", "#8fbfe3"),
    "fines": ("fines in the bin", "#2a9d6f"),
    "wires": ("wires", "#d98032"),
    "side_wall": ("side walls", "#f2c14e"),
    "feed_bin": ("feed bin and slide", "#8b5fa5"),
    "outlet": ("outlet", "#e07a9c"),
    "impact_plate": ("impact plate", "#3d4650"),
    "collecting_bin": ("collecting bin", "#8a5a33"),
}
"""Column of the liquid table (without _m3) -> label and colour, from bottom to top of the stack."""
SIZES = {"small": "small", "near_mesh": "near mesh"}
"""Size class that is drawn and its label in a legend."""
WORDS = {**SIZES, COARSE: "share that cannot pass", **{name: label for name, (label, _) in PLACES.items()}}
"""Label in a legend of a size class, a liquid reservoir or the line of the coarse share."""
Panel = tuple[str, Sequence[CaseResult]]
Draw = Callable[[Axes, Sequence[CaseResult]], None]


@dataclass(frozen=True)
class Sheet:
    """Panels of one figure, the function that draws each, the number side by side, and the axes.

    `title`: values in a panel's heading, of its first case; `meaning`: values in the label of a curve.
    """

    panels: Sequence[Panel]
    draw: Draw
    columns: int
    label: Callable[[Axes], None]
    title: Callable[[CaseResult], str]
    meaning: Callable[[CaseResult, str], str]
    quantity: str = FRACTION


@dataclass(frozen=True)
class Meaning:
    """Label of a panel or a curve, and the values that it states."""

    key: str
    value: str
    shown: str


def dry(results: Sequence[CaseResult]) -> Sheet:
    """Return the fraction retained of the dry cases, one panel per material (Fig. 10)."""
    cases = [r for r in results if not r.moist]
    groups = grouped(cases, lambda r: r.case.material).values()
    shown = _panels(groups, lambda group: f"dry {group[0].case.material}")
    return Sheet(shown, _draw_dry, 2, _label_fraction, lambda r: r.case.material, _screen)


def moisture(results: Sequence[CaseResult]) -> Sheet:
    """Return the fraction retained for every liquid amount, one panel per configuration and liquid (Fig. 12)."""
    shown = _panels(by_liquid(results), _heading)
    return Sheet(shown, _draw_moisture, 3, _label_fraction, configuration_value, _amount)


def classes(results: Sequence[CaseResult]) -> Sheet:
    """Return the fraction retained of the small and the near mesh class at the larger amplitude (Fig. 13)."""
    shown = _panels(by_liquid(_strong(results)), _heading)
    return Sheet(shown, _draw_classes, 2, _label_fraction, configuration_value, _amount)


def liquid(results: Sequence[CaseResult]) -> Sheet:
    """Draw the distribution of the liquid over time, lowest liquid amount, larger amplitude (Fig. 15)."""
    moist = by_liquid(r for r in _strong(results) if r.moist)
    least = [[min(group, key=lambda r: r.case.liquid_percent)] for group in moist]
    of_each = _panels(least, lambda group: f"{title(group[0])}, {_moisture(group[0])}")
    return Sheet(of_each, _draw_liquid, 2, _label_liquid, lambda r: f"{configuration_value(r)} {_amount(r, '')}",
                 lambda _, column: column.removesuffix("_m3"), LIQUID)  # fmt: skip


def configuration_value(result: CaseResult) -> str:
    """Return the values of a configuration: material, sizes, aperture, amplitude and, if the case has its feed, its amount."""
    sizes = "/".join(f"{d:g}" for d in result.case.diameters_mm)
    return " ".join([f"{result.case.material} {sizes} {_screen(result)}", *(f"{v:g}" for v, _ in _feed(result))])


def _feed(result: CaseResult) -> list[tuple[float, str]]:
    """Return the amount of each class with its unit if the case has one."""
    case = result.case
    return [(v, unit) for v, unit in ((case.class_mass_g, "g"), (case.class_volume_cm3, "cm³")) if v is not None]


def _screen(result: CaseResult, _: str = "") -> str:
    return f"{result.case.aperture_mm:g} {result.case.set_amplitude_mm:g}"


def _amount(result: CaseResult, column: str) -> str:
    """Return the liquid amount, the name of the liquid if the case gives it and, for one size class, its name."""
    liquid = result.case.liquid if result.moist else None
    return " ".join(filter(None, (f"{result.case.liquid_percent:g}", liquid, _class(column))))


def _class(column: str) -> str:
    return column.removeprefix(FRACTION).removeprefix("_")


def apart(sheet: Sheet, name: str) -> list[dict[str, Any]]:
    """Return every panel as a separate picture, so that a narrow screen shows them one below the other; `name`: of the figure.

    Each has its SVG text, a text alternative, its curves as JSON, and the meaning of its labels.
    """
    found = []
    with plt.rc_context({**STYLE, "svg.fonttype": "none", "path.simplify": False}):
        for k, (heading, group) in enumerate(sheet.panels):
            figure, (axes,) = panels(1, 1, (4.2, 3.3 if sheet.draw is not _draw_liquid else 4.5))
            _panel(axes, sheet, heading, group)
            if sheet.draw is _draw_liquid:
                _legend_below(figure, 2)
            every = [*axes.get_lines(), *axes.collections]
            drawn = [a for a in every if not (a.get_gid() or BAND).endswith((BAND, COARSE))]
            curves = [_data(artist) for artist in drawn]
            ends = [f"{c['label']} ends at {c['y'][-1]:.3g}" for c in curves if c["y"]]
            found.append({"svg": inline(svg(figure, transparent=True), f"{name}{k}"),
                          "alt": f"{heading}: {'; '.join(ends) or 'nothing to show'}",
                          "curves": embedded(curves),
                          "meanings": list(_meanings(sheet, f"figure.{name}.{k}", heading, group, every))})  # fmt: skip
    return found


def _meanings(
    sheet: Sheet, key: str, heading: str, group: Sequence[CaseResult], artists: Sequence[Any]
) -> Iterator[Meaning]:
    """Return the meanings of heading, axes and legend of a panel."""
    yield Meaning(f"{key}.title", sheet.title(group[0]), heading)
    for axis, quantity in (("x", "time_since_opening_s"), ("y", sheet.quantity)):
        yield Meaning(f"{key}.{axis}", quantity, QUANTITIES[quantity])
    results = {_run(r): r for r in group}
    for artist in artists:
        name = artist.get_gid() or BAND
        if not name.endswith(BAND):
            run, _, column = name.rpartition(":")  # a folder may have colons in its name
            value = column if column == COARSE else sheet.meaning(results[run], column)
            yield Meaning(f"{key}.{run}.{column}", value, artist.get_label())


def _run(result: CaseResult) -> str:
    return result.folder.name if result.folder else result.case.name


def _data(artist: Any) -> dict[str, Any]:
    """Return the data of a curve in the units of its axes: case, column of the table, label, colour, x, y."""
    case, _, column = artist.get_gid().rpartition(":")
    if isinstance(artist, PolyCollection):
        corners: Any = artist.get_paths()[0].vertices
        colour: Any = artist.get_facecolor()
        half = (len(corners) - 1) // 2  # along the lower edge, back along the upper one
        low, high = corners[1:half], corners[half + 1 : -1][::-1]
        x, y, colour = low[:, 0], high[:, 1] - low[:, 1], colour[0]
    else:
        (x, y), colour = artist.get_data(), artist.get_color()
    return {"case": case, "column": column, "label": artist.get_label(), "colour": to_hex(colour),
            "x": np.asarray(x, float).tolist(), "y": np.asarray(y, float).tolist()}  # fmt: skip


def preset_curves(usual: CaseResult, comparison: CaseResult, preset: str) -> list[dict[str, Any]]:
    """Return the fraction retained of one case with two presets of laws, in one panel."""

    def draw(axes: Axes, group: Sequence[CaseResult]) -> None:
        for result, name, colour in zip(group, ("paper", preset), (NAVY, ORANGE), strict=True):
            _curve(axes, result, "fraction_retained", color=colour, label=f"{name}, all")
            near = {"color": colour, "linestyle": DASHED, "label": f"{name}, {SIZES['near_mesh']}"}
            _curve(axes, result, "fraction_retained_near_mesh", **near)
        _end(axes, group)

    names = {_run(usual): "paper", _run(comparison): preset}

    def meaning(result: CaseResult, column: str) -> str:
        return " ".join(filter(None, (names[_run(result)], _class(column))))

    sheet = Sheet(
        [(f"(a) {title(usual)}", [usual, comparison])], draw, 1, _label_fraction, configuration_value, meaning
    )
    return apart(sheet, f"presets.{usual.case.name}")


def title(result: CaseResult) -> str:
    """Name a configuration of material, sizes, screen and amplitude."""
    case = result.case
    sizes = "/".join(f"{d:g}" for d in case.diameters_mm)
    screen = f"{case.material} {sizes} mm, a = {case.aperture_mm:g} mm, A = {case.set_amplitude_mm:g} mm"
    return ", ".join([screen, *(f"{v:g} {unit} per class" for v, unit in _feed(result))])


def _strong(results: Sequence[CaseResult]) -> list[CaseResult]:
    """Return the cases at the largest amplitude."""
    largest = max((r.case.set_amplitude_mm for r in results), default=0.0)
    return [r for r in results if r.case.set_amplitude_mm == largest]


def _panels(groups: Iterable[Sequence[CaseResult]], name: Callable[[Sequence[CaseResult]], str]) -> list[Panel]:
    return [(f"({chr(97 + k)}) {name(group)}", group) for k, group in enumerate(groups)]


def _heading(group: Sequence[CaseResult]) -> str:
    """Name the configuration of a group, and its liquid if its cases give it."""
    return ", ".join([title(group[0]), *dict.fromkeys(r.case.liquid for r in group if r.moist and r.case.liquid)])


def _panel(axes: Axes, sheet: Sheet, name: str, group: Sequence[CaseResult]) -> None:
    """Draw one panel; failed cases are named in it."""
    axes.set_title(name, fontsize=STYLE["axes.titlesize"] * min(1.0, WIDEST / len(name)))
    sheet.draw(axes, group)
    if failed := [r for r in group if r.retained is None]:
        look: Any = {"transform": axes.transAxes, "ha": "right", "color": "#b3261e", "fontsize": 9}
        axes.text(0.98, 0.06, f"{named(failed)} failed", **look)
    sheet.label(axes)


def grid(sheet: Sheet, width: float = 12.0) -> str:
    """Draw all panels on a shared scale with a width in inches; empty text without panels."""
    if not sheet.panels:
        return ""
    columns = min(sheet.columns, len(sheet.panels))
    rows = -(-len(sheet.panels) // columns)
    with plt.rc_context(STYLE):
        size = (width / columns, 3.3 + 0.6 / rows)
        figure, axes = panels(len(sheet.panels), columns, size, sharex=True, sharey=True)
        for place, (name, group) in zip(axes, sheet.panels, strict=False):
            _panel(place, sheet, name, group)
            place.label_outer()
        if sheet.draw is _draw_liquid:
            _legend_below(figure, 5)
        return svg(figure, transparent=True)


def _legend_below(figure: Figure, columns: int) -> None:
    """Draw one legend for all panels, below them."""
    found = {
        name: handle for axes in figure.axes for handle, name in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    if found:
        figure.legend(list(found.values()), list(found), loc="outside lower center", ncols=columns)


def _label_fraction(axes: Axes) -> None:
    axes.set(ylim=(0.0, 1.03), xlim=(0.0, None), ylabel=QUANTITIES[FRACTION], xlabel=TIME)
    handles, labels = axes.get_legend_handles_labels()
    coarse = [handle for handle, label in zip(handles, labels, strict=True) if label == WORDS[COARSE]]
    if handles:
        axes.legend(handles=[handle for handle in handles if handle not in coarse[1:]], loc="best")


def _label_liquid(axes: Axes) -> None:
    axes.set(ylim=(0.0, 100.0), xlim=(0.0, None), ylabel=QUANTITIES[LIQUID], xlabel=TIME)


def _curve(axes: Axes, result: CaseResult, column: str, **look: Any) -> None:
    """Draw one curve, and behind it a band from the smallest to the largest of all seeds of the case."""
    table = result.retained
    if table is None or column not in table:
        return
    time, run = table["time_since_opening_s"], _run(result)
    axes.plot(time, table[column], linewidth=1.7, gid=f"{run}:{column}", **look)
    if result.seeds:
        every = [np.interp(time, seed["time_since_opening_s"], seed[column]) for seed in (table, *result.seeds)]
        band = axes.fill_between(
            time, np.min(every, axis=0), np.max(every, axis=0), color=look["color"], alpha=0.2, linewidth=0
        )
        band.set_gid(f"{run}:{column}{BAND}")


def _draw_dry(axes: Axes, group: Sequence[CaseResult]) -> None:
    for colour, result in zip(colours(len(group), CONFIGURATION), group, strict=True):
        case = result.case
        name = f"a = {case.aperture_mm:g} mm, A = {case.set_amplitude_mm:g} mm"
        _curve(axes, result, "fraction_retained", color=colour, label=name)
    _end(axes, group)


def _draw_moisture(axes: Axes, group: Sequence[CaseResult]) -> None:
    for colour, result in zip(_moisture_colours(group), group, strict=True):
        _curve(axes, result, "fraction_retained", color=colour, label=_moisture(result))
    _end(axes, group)


def _draw_classes(axes: Axes, group: Sequence[CaseResult]) -> None:
    for colour, result in zip(_moisture_colours(group), group, strict=True):
        for (kind, words), style in zip(SIZES.items(), ("-", DASHED), strict=True):
            label = f"{_moisture(result)}, {words}"
            _curve(axes, result, f"{FRACTION}_{kind}", color=colour, linestyle=style, label=label)


def _draw_liquid(axes: Axes, group: Sequence[CaseResult]) -> None:
    table = group[0].liquid
    if table is None:
        return
    used = [name for name in PLACES if f"{name}_m3" in table]
    parts = [100.0 * table[f"{name}_m3"] / table["initial_m3"] for name in used]
    labels, colours = zip(*(PLACES[name] for name in used), strict=True)
    axes.grid(False)  # lines through areas cannot be distinguished
    stack = axes.stackplot(
        table["time_since_opening_s"], parts, labels=labels, colors=colours, edgecolor="white", linewidth=0.3
    )
    for name, area in zip(used, stack, strict=True):
        area.set_gid(f"{_run(group[0])}:{name}_m3")


def _end(axes: Axes, group: Sequence[CaseResult]) -> None:
    """Draw the lines at which the dry fraction retained must end: each share of the classes that cannot pass."""
    done = (r for r in group if r.summary)
    for share, (r, *_) in grouped(done, lambda r: r.summary and r.summary["coarse_share"]).items():
        look: Any = {"color": "#aab3bb", "linewidth": 1.0, "linestyle": ":", "label": WORDS[COARSE]}
        axes.axhline(share, gid=f"{_run(r)}:{COARSE}", **look)


def _moisture(result: CaseResult) -> str:
    liquid = f" {result.case.liquid}" if result.case.liquid else ""
    return f"M = {result.case.liquid_percent:g} %{liquid}" if result.moist else "dry"


def _moisture_colours(group: Sequence[CaseResult]) -> list[str]:
    """Return a colour by rank of the liquid amount; the first colour is reserved for dry."""
    amounts = sorted({r.case.liquid_percent for r in group if r.moist})
    of = dict(zip(amounts, colours(len(amounts), MOISTURE[1:]), strict=True))
    return [of[r.case.liquid_percent] if r.moist else MOISTURE[0] for r in group]
