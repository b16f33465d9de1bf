"""Stock LIGGGHTS takes every surface as it is, finds the right contacts on wires, moves them as pywet.geometry.motion says."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from pywet import config
from pywet.cases.screening import cases
from pywet.engines.liggghts.deck import viblin_words
from pywet.geometry import Apparatus, Surface, write_stl
from pywet.geometry.motion import engine_displacement

CASES = config.load(Path(__file__).parents[2] / "config")

pytestmark = pytest.mark.skipif(shutil.which("liggghts") is None, reason="the engine is not installed")

TIME_STEP = 1e-5
HEAD = """
atom_style granular
atom_modify map array sort 0 0
boundary f f f
newton off
communicate single vel yes
units si
region box block {low[0]!r} {high[0]!r} {low[1]!r} {high[1]!r} {low[2]!r} {high[2]!r} units box
create_box 1 box
neighbor 0.001 bin
neigh_modify delay 0
fix m1 all property/global youngsModulus peratomtype 5.e6
fix m2 all property/global poissonsRatio peratomtype 0.3
fix m3 all property/global coefficientRestitution peratomtypepair 1 1.0
fix m4 all property/global coefficientFriction peratomtypepair 1 0.0
fix m5 all property/global characteristicVelocity scalar 1.0
pair_style gran model hooke
pair_coeff * *
timestep {step!r}
"""


def deck(apparatus: Apparatus, surfaces: list[Surface], folder: Path) -> str:
    lines = [HEAD.format(low=apparatus.box_low, high=apparatus.box_high, step=TIME_STEP)]
    for surface in surfaces:
        write_stl(surface, folder / f"{surface.name}.stl")
        lines.append(f"fix {surface.name} all mesh/surface file {surface.name}.stl type 1")
    names = " ".join(s.name for s in surfaces)
    lines.append(f"fix walls all wall/gran model hooke mesh n_meshes {len(surfaces)} meshes {names}")
    return "\n".join(lines) + "\n"


def test_all_surfaces_load_without_complaint(
    apparatus: Apparatus, tmp_path: Path, liggghts: Callable[[str], str]
) -> None:
    printed = liggghts(deck(apparatus, list(apparatus.surfaces), tmp_path) + "fix i all nve/sphere\nrun 2\n")
    assert printed.count("Import and parallelization of mesh") == len(apparatus.surfaces)
    for word in ("WARNING: Mesh", "aspect ratio", "duplicate", "highly skewed", "overlap"):
        assert word not in printed
    for surface in apparatus.surfaces:
        assert f"mesh {surface.name} containing {len(surface.triangles)} triangle(s) successful" in printed


def test_mesh_moves_as_pywet_motion_says(apparatus: Apparatus, tmp_path: Path, liggghts: Callable[[str], str]) -> None:
    vibration = cases.vibration_of(CASES, CASES.case(1))
    wires = apparatus.surfaces[0]
    moves = "".join(f"fix v{k} all move/mesh mesh wires {words}\n" for k, words in enumerate(viblin_words(vibration)))
    steps = 700
    liggghts(
        deck(apparatus, [wires], tmp_path)
        + moves
        + f"fix i all nve/sphere\ndump d all mesh/stl {steps} wires*.stl wires\nrun {steps}\n"
    )
    rest, moved = (read_corners(tmp_path / f"wires{n}.stl") for n in (0, steps))
    assert len(moved) == len(wires.triangles)
    # the engine writes STL with six significant digits of a coordinate up to 0.1 m
    np.testing.assert_allclose(rest, wires.corners, atol=6e-7)
    shift = (moved - rest).reshape(-1, 3).mean(axis=0)
    np.testing.assert_allclose(shift, engine_displacement(vibration, steps, TIME_STEP), atol=2e-7)


def read_corners(path: Path) -> NDArray[np.float64]:
    rows = [line.split()[1:] for line in path.read_text().splitlines() if line.split()[:1] == ["vertex"]]
    return np.array(rows, dtype=np.float64).reshape(-1, 3, 3)


def test_spheres_touch_wires_where_they_are(
    apparatus: Apparatus, tmp_path: Path, liggghts: Callable[[str], str]
) -> None:
    """Linear contact: no touch is missed on faces, edges, joints of the cut wires, and force is k times overlap.

    Next to an edge the engine counts the face and the edge, so between one and two times k times overlap is right.
    """
    wires = apparatus.surfaces[0]
    radius, overlap = 0.0015, 4e-6
    centres = touching_centres(wires, radius, overlap, apparatus.feed_region.width_m)
    assert len(centres) > 50
    create = "".join(f"create_atoms 1 single {x!r} {y!r} {z!r} units box\n" for x, y, z in centres.tolist())
    liggghts(
        deck(apparatus, [wires], tmp_path)
        + create
        + f"set group all diameter {2 * radius!r} density 1000.0\nfix i all nve/sphere\n"
        + "dump d all custom 1 forces.txt x y z fx fy fz\ndump_modify d format '%.17g %.17g %.17g %.17g %.17g %.17g'\n"
        + "run 1\n"
    )
    table = np.loadtxt(tmp_path / "forces.txt", skiprows=9, max_rows=len(centres))
    depth = radius - distance(wires, table[:, :3]).min(axis=1)
    ratio = np.linalg.norm(table[:, 3:], axis=1) / depth
    stiffness = np.median(ratio)
    assert ratio.min() >= stiffness * (1 - 1e-6)
    assert ratio.max() <= 2 * stiffness * (1 + 1e-6)
    assert (ratio < stiffness * (1 + 1e-6)).mean() > 0.8


def touching_centres(wires: Surface, radius: float, overlap: float, width: float) -> NDArray[np.float64]:
    """Centres that overlap exactly one wire and no other sphere: above faces, and around edges and corners."""
    generator = np.random.default_rng(3)
    draws = max(4, 4000 // len(wires.triangles))
    share = generator.dirichlet(np.ones(3), size=(len(wires.triangles), draws))
    share[:, ::2, 2] = 0.0
    share /= share.sum(axis=2, keepdims=True)
    points = np.einsum("tsk,tkx->tsx", share, wires.corners)
    outward = np.repeat(wires.normals[:, None, :], draws, axis=1)
    outward[:, ::2] += generator.normal(scale=0.3, size=outward[:, ::2].shape)
    outward /= np.linalg.norm(outward, axis=2, keepdims=True)
    trial = (points + outward * (radius - 0.5 * overlap)).reshape(-1, 3)
    trial = generator.permutation(trial[np.hypot(trial[:, 0], trial[:, 1]) < 0.5 * width - radius])[:3000]
    stored: list[NDArray[np.float64]] = []
    for x, per_wire in zip(trial, distance(wires, trial), strict=True):
        nearest, second = np.sort(per_wire)[:2]
        free = all(np.linalg.norm(x - k) > 2.1 * radius for k in stored)
        if radius - overlap < nearest < radius - 0.1 * overlap and second > 1.02 * radius and free:
            stored.append(x)
    return np.array(stored)


def distance(surface: Surface, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance of points (n, 3) to every part (n, parts), by projection on every triangle and its edges."""
    best = np.full((len(points), len(surface.part_half_width)), np.inf)
    for (a, b, c), normal, part in zip(surface.corners, surface.normals, surface.part, strict=True):
        away = np.minimum.reduce([to_segment(points, p, q) for p, q in ((a, b), (b, c), (c, a))])
        inside = np.logical_and.reduce(
            [(points - p) @ np.cross(normal, q - p) >= 0 for p, q in ((a, b), (b, c), (c, a))]
        )
        away = np.where(inside, np.abs((points - a) @ normal), away)
        best[:, part] = np.minimum(best[:, part], away)
    return best


def to_segment(points: NDArray[np.float64], p: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.float64]:
    share = np.clip((points - p) @ (q - p) / ((q - p) @ (q - p)), 0.0, 1.0)
    away: NDArray[np.float64] = np.linalg.norm(points - p - share[:, None] * (q - p), axis=1)
    return away
