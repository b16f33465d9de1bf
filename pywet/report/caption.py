"""Caption below a picture of a run: legend, time, fraction retained and a scale bar; curves next to pictures that move."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from pywet.products import streams
from pywet.report.sketch import BRIDGE_COLOUR, METAL, METALS, solid
from pywet.runs.rundir import Floats, RunDir

INK, PAPER, SOFT, FILM, DRY = "#27323d", "#ffffff", "#aab3bb", "#5b9fd0", "#d9d3c7"
WALL = "#b9c4cf"
LENGTHS = tuple(unit * 10.0**power for power in range(-3, 3) for unit in (1, 2, 5))
"""Lengths of scale bars [mm]."""


def entries(run: RunDir) -> list[tuple[str, str]]:
    """Colours and what they stand for."""
    massive, custom = solid(run), (run.triangles["reservoir"] == "wall").to_numpy()
    there = {*run.triangles["reservoir"], *(["screen"] if (massive & custom).any() else [])}
    metal = ", ".join(name.replace("_", " ") for name in (*METALS, "screen") if name in there)
    moist = [(FILM, "spheres, darker where their film is thicker"), (BRIDGE_COLOUR, "liquid bridges")]
    cut = [(WALL, "walls, their near half cut away")] if (custom & ~massive).any() else []
    return [*(moist if run.moist else [(DRY, "spheres")]), *([(METAL, metal)] if metal else []), *cut]


@dataclass(frozen=True)
class Curve:
    """A quantity from 0 to 1 at the outputs, drawn next to a scene; `title` is what a reader sees."""

    quantity: str
    title: str
    values: Floats


def curves(run: RunDir) -> list[Curve]:
    """Return what has been screened over time: of a case the fraction retained, of a scene the share left by each product.

    Empty for a scene with neither a collecting bin nor outlets.
    """
    line = run.timeline
    if run.scene.slide is not None:
        retained = 1.0 - line.passed @ line.mass / line.mass.sum()
        return [Curve("fraction_retained_spheres", "fraction retained (spheres)", retained)]
    left = streams.shares_left(run).items()
    return [Curve(f"left_{name}", f"{name.replace('_', ' ')}, share of the feed", share) for name, share in left]


def sentence(run: RunDir, step: int) -> str:
    """Return name, time, and, of a case, the share of the spheres' mass that is not in the bin."""
    line = run.timeline
    row = int(np.searchsorted(line.steps, step))
    if run.scene.slide is None:
        return f"{run.scene.name}   t = {line.times[row]:.3f} s"
    retained = float(curves(run)[0].values[row])
    return f"{run.scene.name}   t = {line.times[row]:.3f} s   retained {100 * retained:.1f} % of the spheres' mass"


def below(image: Any, legend: list[tuple[str, str]], text: str, pixels_per_mm: float) -> Image.Image:
    """Return the picture with a strip below it."""
    scene = Image.fromarray(np.asarray(image)[..., :3])
    size = max(11, scene.width // 62)
    font, line = ImageFont.load_default(size), int(1.7 * size)
    whole = Image.new("RGB", (scene.width, scene.height + 2 * line + size), PAPER)
    whole.paste(scene, (0, 0))
    pen, top = ImageDraw.Draw(whole), scene.height + size // 2
    pen.text((size, top), text, fill=INK, font=font)
    length = max((mm for mm in LENGTHS if mm * pixels_per_mm < scene.width / 5), default=LENGTHS[0])
    right, y = scene.width - size, top + line // 2
    left = right - length * pixels_per_mm
    pen.line([(left, y), (right, y)], fill=INK, width=max(2, size // 6))
    for end in (left, right):
        pen.line([(end, y - size // 3), (end, y + size // 3)], fill=INK, width=max(2, size // 6))
    pen.text((left - size // 2, y), f"{length:g} mm", fill=INK, font=font, anchor="rm")
    x, y = float(size), top + line
    for colour, words in legend:
        pen.rectangle([x, y + size // 6, x + size, y + size + size // 6], fill=colour, outline=SOFT)
        pen.text((x + 1.5 * size, y), words, fill=INK, font=font)
        x += 3 * size + pen.textlength(words, font=font)
    return whole


def save(picture: Image.Image, path: Path) -> None:
    """Write a PNG; an error of the operating system names the file."""
    try:
        picture.save(path, format="PNG")
    except OSError as error:
        error.filename = error.filename or str(path)
        raise
