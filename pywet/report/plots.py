"""Curves of the report, in the grids of Figs. 10, 12, 13 and 15 of Elskamp & Kruggel-Emden (2018), as SVG text.

Panels follow from the cases given: one per material (dry), one per configuration (moisture), in the order of the cases.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pywet.report.collect import CaseResult
from pywet.report.pictures import STYLE, plt, svg

MOISTURE = ("#9a8f80", "#4a9bd4", "#0b3c78", "#6a51a3")
"""Colours of dry, first, second, … liquid amount."""
CONFIGURATION = ("#0b3c78", "#4a9bd4", "#d98032", "#5d8a3a", "#8b5fa5")
PLACES = {
    "coarse_material_large": ("on the screen: large", "#0b3c78"),
    "coarse_material_near_mesh": ("on the screen: near mesh", "#3b7fbf"),
    "coarse_material_small": ("on the screen: small", "#8fbfe3"),
    "fines": ("fines in the bin", "#7fb8a4"),
    "wires": ("wires", "#d98032"),
    "side_wall": ("side walls", "#edb67a"),
    "feed_bin": ("feed bin and slide", "#c9bda8"),
    "outlet": ("outlet", "#a79a86"),
    "impact_plate": ("impact plate", "#7f7463"),
    "collecting_bin": ("collecting bin", "#5b5347"),
}
"""Column of the liquid table (without _m3) -> label and colour, from bottom to top of the stack."""
Panel = tuple[str, Sequence[CaseResult]]
Draw = Callable[[Axes, Sequence[CaseResult]], None]


def dry_curves(results: Sequence[CaseResult]) -> str:
    """Fraction retained of the dry cases, one panel per material (Fig. 10)."""
    dry = [r for r in results if not r.moist]
    return _grid(
        _panels(dry, lambda r: r.case.material, lambda r: f"dry {r.case.material}"), _draw_dry, 2, _label_fraction
    )


def moisture_curves(results: Sequence[CaseResult]) -> str:
    """Fraction retained for every liquid amount, one panel per configuration (Fig. 12)."""
    return _grid(_panels(results, lambda r: r.configuration, title), _draw_moisture, 3, _label_fraction)


def class_curves(results: Sequence[CaseResult]) -> str:
    """Fraction retained of the small and the near mesh class at the larger amplitude (Fig. 13)."""
    return _grid(_panels(_strong(results), lambda r: r.configuration, title), _draw_classes, 2, _label_fraction)


def liquid_curves(results: Sequence[CaseResult]) -> str:
    """Where the liquid is over time, lowest liquid amount, larger amplitude (Fig. 15)."""
    moist = [r for r in _strong(results) if r.moist]
    least = {
        r.configuration: min(q.case.liquid_percent for q in moist if q.configuration == r.configuration) for r in moist
    }
    shown = [r for r in moist if r.case.liquid_percent == least[r.configuration]]
    panels = _panels(shown, lambda r: r.configuration, lambda r: f"{title(r)}, M = {r.case.liquid_percent:g} %")
    return _grid(panels, _draw_liquid, 2, _label_liquid)


def preset_curves(usual: CaseResult, twin: CaseResult, preset: str) -> str:
    """Fraction retained of one case with two presets of laws."""

    def draw(axes: Axes, group: Sequence[CaseResult]) -> None:
        for result, name, colour in zip(group, ("paper", preset), ("#0b3c78", "#d98032"), strict=True):
            _curve(axes, result, "fraction_retained", color=colour, label=f"{name}, all")
            _curve(axes, result, "fraction_retained_small", color=colour, linestyle=(0, (4, 2)), label=f"{name}, small")
        _end(axes, group)

    return _grid([(title(usual), [usual, twin])], draw, 1, _label_fraction)


def title(result: CaseResult) -> str:
    """A configuration in a few words."""
    case = result.case
    sizes = "/".join(f"{d:g}" for d in case.diameters_mm)
    return f"{case.material} {sizes} mm, a = {case.aperture_mm:g} mm, A = {case.set_amplitude_mm:g} mm"


def _strong(results: Sequence[CaseResult]) -> list[CaseResult]:
    """The cases at the largest amplitude there is."""
    largest = max((r.case.set_amplitude_mm for r in results), default=0.0)
    return [r for r in results if r.case.set_amplitude_mm == largest]


def _panels(
    results: Sequence[CaseResult], key: Callable[[CaseResult], Any], name: Callable[[CaseResult], str]
) -> list[Panel]:
    groups: dict[Any, list[CaseResult]] = {}
    for result in results:
        groups.setdefault(key(result), []).append(result)
    return [(f"({chr(97 + k)}) {name(group[0])}", group) for k, group in enumerate(groups.values())]


def _grid(panels: Sequence[Panel], draw: Draw, columns: int, label: Callable[[Axes], None]) -> str:
    """Draw every panel on a shared scale; failed cases are named in their panel. Empty text without panels."""
    if not panels:
        return ""
    columns = min(columns, len(panels))
    rows = -(-len(panels) // columns)
    with plt.rc_context(STYLE):
        size = (12.0, 0.6 + 3.3 * rows)
        figure, axes = plt.subplots(
            rows, columns, figsize=size, squeeze=False, sharex=True, sharey=True, layout="constrained"
        )
        for place, (name, group) in zip(axes.flat, panels, strict=False):
            place.set_title(name)
            draw(place, group)
            _name_failed(place, group)
            label(place)
        for place in list(axes.flat)[len(panels) :]:
            place.set_axis_off()
        if draw is _draw_liquid:
            _legend_below(figure)
        return svg(figure, transparent=True)


def _legend_below(figure: Figure) -> None:
    """One legend for all panels, below them."""
    found = {
        name: handle for axes in figure.axes for handle, name in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    if found:
        figure.legend(list(found.values()), list(found), loc="outside lower center", ncols=5)


def _name_failed(axes: Axes, group: Sequence[CaseResult]) -> None:
    failed = [str(r.case.case) for r in group if r.retained is None]
    if failed:
        text = f"case{'s' if len(failed) > 1 else ''} {', '.join(failed)} failed"
        axes.text(0.98, 0.06, text, transform=axes.transAxes, ha="right", color="#b3261e", fontsize=9)


def _label_fraction(axes: Axes) -> None:
    axes.set_ylim(0.0, 1.03)
    axes.set_xlim(left=0.0)
    axes.set_ylabel("fraction retained Y")
    axes.set_xlabel("time since the slide opened in s")
    axes.label_outer()
    _legend(axes)


def _label_liquid(axes: Axes) -> None:
    axes.set_ylim(0.0, 100.0)
    axes.set_xlim(left=0.0)
    axes.set_ylabel("liquid in % of what was put in")
    axes.set_xlabel("time since the slide opened in s")
    axes.label_outer()


def _legend(axes: Axes) -> None:
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="best")


def _curve(axes: Axes, result: CaseResult, column: str, **look: Any) -> None:
    table = result.retained
    if table is not None and column in table:
        axes.plot(table["time_since_opening_s"], table[column], linewidth=1.7, **look)


def _draw_dry(axes: Axes, group: Sequence[CaseResult]) -> None:
    for colour, result in zip(_cycle(CONFIGURATION, len(group)), group, strict=True):
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
        for kind, style in (("small", "-"), ("near mesh", (0, (4, 2)))):
            column = f"fraction_retained_{kind.replace(' ', '_')}"
            _curve(axes, result, column, color=colour, linestyle=style, label=f"{_moisture(result)}, {kind}")


def _draw_liquid(axes: Axes, group: Sequence[CaseResult]) -> None:
    table = group[0].liquid
    if table is None:
        return
    used = [name for name in PLACES if f"{name}_m3" in table]
    parts = [100.0 * table[f"{name}_m3"] / table["initial_m3"] for name in used]
    labels, colours = zip(*(PLACES[name] for name in used), strict=True)
    axes.stackplot(
        table["time_since_opening_s"], parts, labels=labels, colors=colours, edgecolor="white", linewidth=0.3
    )


def _end(axes: Axes, group: Sequence[CaseResult]) -> None:
    """Where the dry fraction retained must end: the share of the class that cannot pass."""
    share = next((r.summary["coarse_share"] for r in group if r.summary), None)
    if share is not None:
        axes.axhline(share, color="#aab3bb", linewidth=1.0, linestyle=":", label="share that cannot pass")


def _moisture(result: CaseResult) -> str:
    return f"M = {result.case.liquid_percent:g} %" if result.moist else "dry"


def _moisture_colours(group: Sequence[CaseResult]) -> list[str]:
    """Colour by rank of the liquid amount; the first colour is kept for dry."""
    amounts = sorted({r.case.liquid_percent for r in group if r.moist})
    return [
        MOISTURE[min(amounts.index(r.case.liquid_percent) + 1, len(MOISTURE) - 1)] if r.moist else MOISTURE[0]
        for r in group
    ]


def _cycle(colours: Sequence[str], count: int) -> list[str]:
    return [colours[k % len(colours)] for k in range(count)]
