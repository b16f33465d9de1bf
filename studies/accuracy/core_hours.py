"""Draw error over core-hours with the defaults marked: `python -m studies.accuracy.core_hours` updates docs/accuracy.md.

Errors are those of the stored study, times are predicted for the machine of `machine.json`, so that page and picture
are reproducible on any machine.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from pywet import config as settings
from pywet.config import Config
from pywet.cost import choice, cost, edit, needs
from pywet.cost.command import duration, habit
from pywet.errors import border
from pywet.report.pictures import STYLE, plt
from studies.accuracy import ranking
from studies.accuracy.parameters import PARAMETERS

ROOT = Path(__file__).parents[2]
PAGE, PICTURE = ROOT / "docs" / "accuracy.md", ROOT / "docs" / "pictures" / "accuracy_core_hours.svg"
SCALES = {"smoke": "#5d8a3a", "reduced": "#d98032", "full": "#0b3c78"}
CASES = {"moist": 2, "dry": 1}
PASSAGE = ("fraction retained", "liquid shares")
"""Groups of quantities in the picture."""
FLOOR = 0.05
"""Error [%] at which a point without a resolved error is drawn."""
ACCURACIES = (0.2, 0.1, 0.05, 0.02)


@dataclass(frozen=True)
class Point:
    """One combination of settings: its predicted time [s] and its relative error."""

    seconds: float
    error: float


def seconds(config: Config, case: int, scale: str, levels: edit.Levels) -> float:
    """Return the predicted time of the engine's run on the stored machine."""
    table, _ = choice.for_scale(scale)
    return cost.predict(edit.changed(config, scale, levels), case, scale, needs.stored_machine(), habit(table))[0]


def front(config: Config, kind: str, scale: str) -> tuple[list[Point], Point]:
    """Return the Pareto front of combinations in time and error, from fast to exact; and the default."""
    table, turned = choice.for_scale(scale)
    moist, wanted = kind == "moist", PASSAGE if kind == "moist" else PASSAGE[:1]

    def point(chosen: choice.Chosen) -> Point:
        levels = {setting: level for setting, level in chosen.levels.items() if setting in turned}
        return Point(seconds(config, CASES[kind], scale, levels), max(chosen.error.values()))

    points = [point(chosen) for chosen in choice.combinations(choice.options(table, moist, turned), wanted)]
    line: list[Point] = []
    for p in sorted(points, key=lambda p: (p.seconds, p.error)):
        if not line or p.error < line[-1].error - 1e-12:
            line.append(p)
    return line, point(choice.of_default(table, moist, wanted))


def figure(config: Config) -> Figure:
    """Draw the error of the fraction retained and of liquid shares over core-hours, all scales in one picture."""
    with plt.rc_context(STYLE):
        drawn, ax = plt.subplots(figsize=(9.2, 4.4), layout="constrained")
        for scale, colour in SCALES.items():
            for kind, style in (("moist", "-"), ("dry", ":")):
                line, default = front(config, kind, scale)
                x, y = [p.seconds / 3600.0 for p in line], [max(100.0 * p.error, FLOOR) for p in line]
                ax.plot(x, y, style, color=colour, lw=1.6, marker="o", ms=4.5, label=f"{scale} scale, {kind}")
                at, up = default.seconds / 3600.0, max(100.0 * default.error, FLOOR)
                ax.plot(at, up, "o", ms=13, mfc="none", mec="#b3261e", mew=1.8)
        ax.set(
            xscale="log",
            yscale="log",
            xlabel="predicted core-hours of one run",
            ylabel="error [% of feed or of liquid]",
        )
        ax.set_yticks(
            [FLOOR, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20], ["none resolved", "0.1", "0.2", "0.5", "1", "2", "5", "10", "20"]
        )
        ax.set_xticks([1e-3, 1e-2, 1e-1, 1.0], ["0.001", "0.01", "0.1", "1"])
        above = ax.secondary_xaxis("top")
        above.set_xticks([t / 3600.0 for t in (2, 10, 60, 600, 3600)], ["2 s", "10 s", "1 min", "10 min", "1 h"])
        ax.minorticks_off()
        above.minorticks_off()
        ax.plot([], [], "o", ms=11, mfc="none", mec="#b3261e", mew=1.8, ls="", label="default settings")
        drawn.legend(loc="outside right center", fontsize=8.5, frameon=False)
    return drawn


def chosen_rows(config: Config) -> list[str]:
    """Return settings, error and time of case 2 for each accuracy, without the smoke scale, which is too small."""
    columns = (
        *("error allowed", "scale", "settings other than the default", "largest error counted", "upper bound"),
        "time of case 2",
    )
    rows = [f"| {' | '.join(columns)} |", "|---" * len(columns) + "|"]
    for scale in ("reduced", "full"):
        table, turned = choice.for_scale(scale)
        default = choice.of_default(table, True)
        before = duration(seconds(config, CASES["moist"], scale, {}))
        rows.append(f"| as configured | {scale} | none | {_errors(default)} | {_bound(default)} | **{before}** |")
        seen: list[dict[str, Any]] = []
        for accuracy in ACCURACIES:
            best = choice.choose(table, accuracy, True, choice.WANTED, turned)
            levels = {setting: level for setting, level in best.levels.items() if setting in turned}
            if levels not in seen:
                took = duration(seconds(config, CASES["moist"], scale, levels))
                names = ", ".join(_name(k, v) for k, v in levels.items() if v != table["default"][k])
                errors = f"{_errors(best)} | {_bound(best)}"
                rows.append(f"| {100 * accuracy:g} % | {scale} | {names} | {errors} | {took} |")
            seen.append(levels)
    return rows


def _name(setting: str, level: Any) -> str:
    return "`preset: exact`" if level == "exact" else " ".join((PARAMETERS[setting].title, str(level)))


def _errors(chosen: choice.Chosen) -> str:
    worst = max(chosen.error, key=lambda group: chosen.error[group])
    return f"{100 * chosen.error[worst]:.2g} % ({worst})"


def _bound(chosen: choice.Chosen) -> str:
    return f"{100 * max(chosen.bound.values()):.2g} %"


def setting_rows(scale: str = "reduced") -> list[str]:
    """List cost and error of the levels of a scale, without references and levels that change nothing.

    An error is given as it is where it is resolved, otherwise by its bound.
    """
    table = choice.stored()["scales"][scale]
    columns = {"retained, dry": ("dry", "fraction retained"), "retained, moist": ("moist", "fraction retained")}
    columns |= {name: ("moist", name) for name in ("liquid shares", "force", "restitution")}
    rows = [f"| setting | cost | {' | '.join(columns)} |", "|---" * (2 + len(columns)) + "|"]
    for setting, levels in table["parameters"].items():
        title = PARAMETERS[setting].title
        for level in levels[:-1] if levels[-1]["level"] != table["default"][setting] else levels:
            default = " (default)" if level["level"] == table["default"][setting] else ""
            relative = level["cost"].get("moist") or level["cost"]["dry"]
            cells = [_cell(table, setting, level["level"], *asked) for asked in columns.values()]
            if set(cells) <= {"0", "–"}:
                continue
            rows.append(f"| {title} {level['level']}{default} | {relative['ratio']:.2f} | {' | '.join(cells)} |")
    return rows


def _cell(table: dict[str, Any], setting: str, level: Any, kind: str, group: str) -> str:
    point = next((p for p in ranking.points(table, setting, kind, group) if p["level"] == level), None)
    if point is None:
        return "–"
    if point["value"] == 0.0 and point["limit"] == 0.0:
        return "0"
    return f"**{100 * point['value']:.2g}**" if point["resolved"] else f"<{100 * (point['value'] + point['limit']):.2g}"


def blocks(config: Config) -> dict[str, list[str]]:
    """Return name of each generated block of the page, and its lines."""
    return {"choice": chosen_rows(config), "settings": setting_rows()}


def with_blocks(text: str, made: dict[str, list[str]]) -> str:
    """Return the page's text with its blocks updated."""
    for name, rows in made.items():
        lines = "\n".join(rows)
        text = re.sub(
            rf"(<!-- {name} -->\n).*?(\n<!-- end of {name} -->)",
            lambda found, lines=lines: found[1] + lines + found[2],  # type: ignore[misc]
            text,
            flags=re.DOTALL,
        )
    return text


def main() -> None:
    """Write the picture and renew the blocks."""
    config = settings.load(ROOT / "config")
    with plt.rc_context({"svg.hashsalt": "pywet"}):
        figure(config).savefig(PICTURE, metadata={"Date": None})
    PAGE.write_text(with_blocks(PAGE.read_text(), blocks(config)))


if __name__ == "__main__":
    with border():
        main()
