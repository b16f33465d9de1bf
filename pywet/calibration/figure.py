"""The figure of a calibration: for each parameter the responses with the targets' bands, and below them the likelihood."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from pywet.calibration.question import Question
from pywet.calibration.search import Found
from pywet.report.pictures import GREEN, INK, NAVY, ORANGE, STYLE, panels, plt, svg
from pywet.util.files import atomic_write

PLACES = 25


def draw(question: Question, found: Found, path: Path) -> None:
    """Draw responses, targets and likelihoods of a calibration as an SVG file."""
    rows, columns = len(question.targets) + 1, len(question.parameters)
    with plt.rc_context(STYLE):
        figure, axes = panels(rows * columns, columns, (4.6, 2.6))
        for k in range(columns):
            _column(question, found, k, axes[k::columns])
    text = svg(figure)
    with atomic_write(path) as temporary:
        temporary.write_text(text)


def _column(question: Question, found: Found, k: int, axes: list[Axes]) -> None:
    """Draw the responses against one parameter, with the other parameters optimised at each value."""
    solved, (name, parameter) = found.problem, list(question.parameters.items())[k]
    shares = np.linspace(solved.window[0][k], solved.window[1][k], PLACES)
    profiles = [solved.profile(k, float(u)) for u in shares]
    reported = [solved.response(place) for _, place in profiles]
    at = [parameter.at(float(u)) for u in shares]
    column = 0
    for j, target in enumerate(question.targets):
        axis = axes[j]
        mean, error = np.array([m[j] for m, _, _ in reported]), np.sqrt([v[j] for _, v, _ in reported])
        axis.axhspan(
            target.value - target.error, target.value + target.error, color=ORANGE, alpha=0.3, lw=0, label="target"
        )
        axis.plot(at, mean, color=NAVY, label="response")
        axis.fill_between(at, mean - error, mean + error, color=NAVY, alpha=0.2, lw=0)
        if found.runs is not None and target.kind == "scene":
            places = [parameter.at(float(place[k])) for place in found.runs.places]
            axis.plot(places, [v[column] for v in found.runs.values], ".", color=INK, ms=4, label="runs")
            column += 1
        axis.set(ylabel=target.quantity)
        axis.legend()
    likelihood = np.exp(-0.5 * np.array([above for above, _ in profiles]))
    axes[-1].plot(at, likelihood, color=GREEN)
    for span in solved.intervals(k):
        axes[-1].axvspan(parameter.at(span.low), parameter.at(span.high), color=GREEN, alpha=0.15, lw=0)
    axes[-1].axvline(parameter.at(float(solved.best[k])), color=GREEN, ls=":")
    axes[-1].set(ylabel=f"likelihood ({100 * question.confidence:g} %)", ylim=(0, 1.05))
    for axis in axes:
        axis.set(xlabel=name, xscale="log" if parameter.log else "linear")
