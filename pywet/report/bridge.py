"""Print the answer of `pywet bridge` as a table against the exact bridge, and plot it over the gap."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from rich.table import Table

from pywet.report.pictures import DPI, GREEN, INK, NAVY, ORANGE, RED, SKY, STYLE, VIOLET, colours, dash, panels, plt
from pywet.util.files import atomic_write

FORMATS = (".svg", ".png")
COLOURS = (ORANGE, NAVY, GREEN, VIOLET, RED, SKY)
Values = Sequence[float | None]
Measured = tuple[Sequence[float], Mapping[str, Any]] | None
EXACT = "young_laplace"


def short(law: str) -> str:
    """Return a law's name without the folder of its file."""
    return law.rpartition("/")[2]


def deviation(value: float | None, exact: float | None) -> float | None:
    """Value over exact − 1 in per cent; None where either has no value.

    >>> deviation(1.5, 1.0)
    50.0
    """
    return None if value is None or not exact else 100.0 * (value / exact - 1.0)


def table(gaps: Sequence[float], answer: Mapping[str, Any], exact: Values) -> list[Table]:
    """Return each capillary law's force and its deviation from the exact one, rupture distances likewise, and viscous forces."""
    forces = Table("law", "gap in µm", "force in mN", "exact in mN", "deviation", box=None, header_style="bold")
    for law, values in answer["force_N"].items():
        for gap, value, true in zip(gaps, values, exact, strict=True):
            forces.add_row(
                short(law), f"{1e6 * gap:.6g}", _times(1e3, value), _times(1e3, true), _percent(deviation(value, true))
            )
    ends = Table("rupture law", "distance in µm", "exact in µm", "deviation", box=None, header_style="bold")
    limit = answer["rupture_distance_m"].get(EXACT)
    for law, distance in answer["rupture_distance_m"].items():
        ends.add_row(short(law), _times(1e6, distance), _times(1e6, limit), _percent(deviation(distance, limit)))
    drags = Table("viscous law", "gap in µm", "force in mN", box=None, header_style="bold")
    for law, values in answer["viscous_normal_N"].items():
        for gap, value in zip(gaps, values, strict=True) if any(values) else ():  # without velocity there are none
            drags.add_row(short(law), f"{1e6 * gap:.6g}", _times(1e3, value))
    return [forces, ends, drags]


def figure(gaps: Sequence[float], answer: Mapping[str, Any], exact: Values, measured: Measured = None) -> Figure:
    """Draw force over gap of each law and of the exact bridge, with rupture distances as dotted lines.

    `measured`: separations and answer from an engine, drawn as points.
    """
    laws = [name for name in answer["force_N"] if name != EXACT]
    colour_of = {EXACT: INK, **dict(zip(laws, colours(len(laws), COLOURS), strict=True))}
    with plt.rc_context(STYLE):
        drawn, (axis,) = panels(1, 1, (6.4, 4.0))
        for law in laws:
            _line(axis, gaps, answer["force_N"][law], color=colour_of[law], lw=1.3, label=short(law))
        _line(axis, gaps, exact, color=INK, lw=2.0, label="exact (Young-Laplace)")
        for k, (law, distance) in enumerate(answer["rupture_distance_m"].items()):
            dots = ":" if law == EXACT else dash(5 + k)
            axis.axvline(1e6 * distance, color=INK, lw=0.8, ls=dots, label=f"rupture: {short(law)}")
        at, found = measured or ((), {"force_N": {}})
        for law, values in found["force_N"].items():
            look: Any = {"ls": "", "marker": "o", "ms": 4, "color": colour_of[law]}
            _line(axis, at, values, label=f"{short(law)} in the engine", **look)
        axis.set(xlabel="gap in µm", ylabel="capillary force in mN", ylim=(0, None), xlim=(0, None))
        axis.legend()
    return drawn


def draw(path: Path, drawn: Figure) -> None:
    """Draw the figure in the format of its suffix, one of `FORMATS`, and close it."""
    form = path.suffix.lower().removeprefix(".")
    how: Any = {"dpi": DPI} if form == "png" else {"metadata": {"Date": None}}
    with atomic_write(path) as temporary:
        drawn.savefig(temporary, format=form, **how)
    plt.close(drawn)


def _line(axis: Any, gaps: Sequence[float], values: Values, **look: Any) -> None:
    both = [(1e6 * g, 1e3 * v) for g, v in zip(gaps, values, strict=True) if v is not None]
    axis.plot([g for g, _ in both], [v for _, v in both], **look)


def _times(factor: float, value: float | None) -> str:
    return "-" if value is None else f"{factor * value:.6g}"


def _percent(value: float | None) -> str:
    return "-" if value is None else f"{value:+.2g} %" if abs(value) < 10 else f"{value:+.0f} %"
