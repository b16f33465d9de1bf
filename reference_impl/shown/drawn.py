"""Read a panel of a figure from its visible content: labels in the legend, colours, dashes, points by the axes.

Only visible parts of the SVG are used: texts, strokes, fills, positions. matplotlib's names of groups identify axes
and legend; the name of a curve's group is returned as the name that it claims.
"""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from typing import Any

import numpy as np

from reference_impl.replay.arrays import Floats
from reference_impl.replay.io import ReplayError

SVG, LINK = "{http://www.w3.org/2000/svg}", "{http://www.w3.org/1999/xlink}href"


BAND = ":band"


@dataclass(frozen=True)
class Curve:
    """A line or an area as drawn; `y` of an area is its height."""

    label: str | None
    colour: str
    dashed: bool
    claim: str
    x: Floats
    y: Floats
    top: Floats


@dataclass(frozen=True)
class Panel:
    """One panel; `alongside` is the data next to it."""

    titles: list[str]
    """Texts above and in the axes."""
    x_label: str
    y_label: str
    curves: tuple[Curve, ...]
    alongside: list[dict[str, Any]]
    bands: tuple[Curve, ...] = ()
    """Areas named like a curve plus `:band`: from the smallest to the largest of its seeds."""


def figures(text: str) -> list[tuple[str, list[Panel]]]:
    """Return name and panels of every figure of a report."""
    found = re.findall(r'<div class="panels" data-figure="(.*?)">(.*?)</div>', text, re.DOTALL)
    return [(name, panels(figure)) for name, figure in found]


def panels(section: str) -> list[Panel]:
    """Return all panels of a part of a report."""
    found = []
    for figure in re.findall(r'<figure role="img".*?</figure>', section, re.DOTALL):
        text = re.search(r"<svg.*?</svg>", figure, re.DOTALL)
        data = re.search(r'<script type="application/json">(.*?)</script>', figure, re.DOTALL)
        if text is None:
            raise ReplayError("a figure of the report holds no picture; write the report again")
        found.append(_panel(ET.fromstring(text.group(0)), json.loads(data.group(1)) if data else []))
    return found


def _panel(root: ET.Element, alongside: list[dict[str, Any]]) -> Panel:
    named = {g.attrib["id"].split("-", 1)[-1]: g for g in root.iter(f"{SVG}g") if "id" in g.attrib}
    axes = named["axes_1"]
    along, up = (_axis(named[f"matplotlib.axis_{k}"], "xy"[k - 1]) for k in (1, 2))
    legend = _legend(named["legend_1"]) if "legend_1" in named else []
    plain = [e for g in axes if not g.attrib.get("id", "").split("-")[-1].startswith(("matplotlib.axis", "legend", "patch"))
             for e in g.iter(f"{SVG}text")]  # fmt: skip
    paths = {p.attrib["id"]: p for p in root.iter(f"{SVG}path") if "id" in p.attrib}
    curves = [c for g in axes if (c := _curve(g, paths, along[0], up[0], legend)) is not None]
    bands = tuple(c for c in curves if c.claim.endswith(BAND))
    lines = tuple(c for c in curves if not c.claim.endswith(BAND))
    return Panel([_words(e) for e in plain], along[1], up[1], lines, alongside, bands)


def _words(element: ET.Element) -> str:
    return " ".join("".join(element.itertext()).split())


def _style(element: ET.Element) -> dict[str, str]:
    parts = (part.split(":", 1) for part in element.attrib.get("style", "").split(";") if ":" in part)
    return {name.strip(): value.strip() for name, value in parts}


def _axis(group: ET.Element, axis: str) -> tuple[tuple[float, float], str]:
    """Return slope and offset from position on the page to value, by ticks and their labels, and the label of the axis."""
    at, value, name = [], [], ""
    for child in group:
        marks, texts = list(child.iter(f"{SVG}use")), [_words(t) for t in child.iter(f"{SVG}text")]
        if marks and texts and texts[0]:
            at.append(float(marks[0].attrib[axis]))
            value.append(float(texts[0].replace("−", "-")))
        elif texts:
            name = texts[0]
    if len(at) < 2:
        raise ReplayError("an axis of the report has fewer than two labels; write the report again")
    slope, start = np.polyfit(at, value, 1)
    return (float(slope), float(start)), name


def _legend(group: ET.Element) -> list[tuple[str, str, bool]]:
    """Return text, colour and whether dashed of each entry; its sample is on the left of the text in the same line."""
    samples, texts = [], []
    for child in group:
        for path in child.iter(f"{SVG}path"):
            style, points = _style(path), _points(path.attrib["d"])
            colour = style.get("fill", "none") if style.get("fill", "none") != "none" else style.get("stroke", "none")
            if "text" not in child.attrib.get("id", "") and colour != "none":
                samples.append((points.mean(axis=0), colour, "stroke-dasharray" in style))
        for text in child.iter(f"{SVG}text"):
            texts.append((float(text.attrib["x"]), float(text.attrib["y"]), _words(text)))
    found = []
    for x, y, words in texts:
        left = [s for s in samples if s[0][0] < x]
        _, colour, dashed = min(left, key=lambda s: abs(s[0][1] - y + 3.0) + 0.1 * abs(x - s[0][0]))
        found.append((words, colour, dashed))
    return found


def _points(d: str) -> Floats:
    return np.array(re.findall(r"[ML] (\S+) (\S+)", d), dtype=float)


def _curve(
    group: ET.Element, paths: dict[str, ET.Element], along: tuple[float, float], up: tuple[float, float],
    legend: list[tuple[str, str, bool]],
) -> Curve | None:  # fmt: skip
    """Return the line or area of a group; None if it is no curve."""
    claim = group.attrib.get("id", "").split("-", 1)[-1]
    if claim.startswith(("matplotlib", "patch", "text", "legend")):
        return None
    used, direct = next(group.iter(f"{SVG}use"), None), group.find(f"{SVG}path")
    if used is not None:
        points = _points(paths[used.attrib[LINK].removeprefix("#")].attrib["d"])
        points = points + np.array([float(used.attrib["x"]), float(used.attrib["y"])])
        style, area = _style(used), True
    elif direct is not None:
        points, style, area = _points(direct.attrib["d"]), _style(direct), _style(direct).get("fill", "none") != "none"
    else:
        return None
    points = points * [along[0], up[0]] + [along[1], up[1]]
    colour, dashed = style["fill" if area else "stroke"], "stroke-dasharray" in style
    label = next((text for text, c, d in legend if (c, d) == (colour, dashed)), None)
    if not area:
        return Curve(label, colour, dashed, claim, points[:, 0], points[:, 1], points[:, 1])
    half = (len(points) - 2) // 2
    one, two = points[1 : half + 1], points[half + 2 :][:half][::-1]
    return Curve(
        label, colour, dashed, claim, one[:, 0], np.abs(two[:, 1] - one[:, 1]), np.maximum(one[:, 1], two[:, 1])
    )
