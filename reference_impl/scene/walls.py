"""The walls of a run measured on their STL files, compared with the configuration; and the tables that repeat them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from reference_impl.diagnosis.held import Held
from reference_impl.replay import io
from reference_impl.replay.arrays import Floats, vectors
from reference_impl.scene import stl
from reference_impl.scene.numbers import MARGIN
from reference_impl.scene.stl import LENGTH_ERROR
from reference_impl.scene.tower import Heights, Plan

OPENING = (0.4, 3.0)
"""Limits of the free width next to the impact plate: this share of the sieve's width, or so many apertures."""


def measured(config: Mapping[str, Any], scene: Mapping[str, Any], meshes: Mapping[str, Floats]) -> list[Held]:
    """Compare lengths of all walls, the box around them, and the half widths of their parts in the scene."""
    plan, heights = Plan.of(config), Heights.of(config)
    found = [*_wires(plan, meshes["wires"])] if "wires" in meshes else []
    found += [*_tubes(plan, heights, meshes), *_plates(config, plan, heights, meshes)]
    if meshes:
        found += _box(plan, scene, meshes)
    for wall in scene["walls"]:
        if wall["name"] in meshes:
            found += _parts(wall, meshes[wall["name"]], plan)
    return found


def read(folder: Path, scene: Mapping[str, Any]) -> dict[str, Floats]:
    """Return the triangles of every wall by its name."""
    return {wall["name"]: stl.read(folder / wall["stl"]) for wall in scene["walls"]}


def by_table(folder: Path, scene: Mapping[str, Any]) -> dict[str, Floats]:
    """Return the corners of every wall [m] as the engine reported them, for scenes whose STL files are only a copy."""
    table = io.every(folder / "history" / "triangles.parquet").sort_values("triangle")
    corners = np.stack([vectors(table, f"v{k}") for k in range(3)], axis=1)
    return {wall["name"]: corners[(table["mesh"] == wall["name"]).to_numpy()] for wall in scene["walls"]}


def _length(name: str, given: float, expected: float, source: str) -> Held:
    return Held(f"{name} (measured on the STL)", given, expected, source, allowance=LENGTH_ERROR)


def _wires(plan: Plan, corners: Floats) -> Iterator[Held]:
    wires, screens = stl.wires(corners), "materials.yaml: screens"
    of_aperture, of_wire = f"{screens} aperture_mm", f"{screens} wire_diameter_mm"
    k = np.arange(plan.wire_sides)
    section = float(np.ptp(np.sin(2.0 * np.pi * k / plan.wire_sides))) * 0.5 * plan.wire
    across = np.ptp(np.cos(2.0 * np.pi * k / plan.wire_sides)) * 0.5 * plan.wire
    facing = 2.0 * np.pi * np.arange(plan.sides) / plan.sides
    outward = np.column_stack([np.cos(facing), np.sin(facing)])
    for along, name in enumerate("xy"):
        row = sorted((w for w in wires if w.along == along), key=lambda w: w.at)
        names = ("at", "width", "height", "middle", "sides")
        places, widths, heights, middles, sides = (np.array([float(getattr(w, n)) for w in row]) for n in names)
        yield Held(f"wires along {name}, their number", len(row), len(plan.wires), of_aperture)
        if len(row) == len(plan.wires):
            of_place = "a pitch apart, about the axis"
            yield _worst(f"place of a wire along {name}", places, plan.wires, of_place, plan.pitch)
        free = np.diff(places) - 0.5 * (widths[1:] + widths[:-1])
        of_row = f"wires along {name}"
        yield _worst(f"{of_row}.diameter_m", widths, across, of_wire)
        yield _worst(f"{of_row}.aperture_m", free, plan.aperture, of_aperture)
        yield _worst(f"{of_row}.height_m", heights, section, of_wire)
        yield _worst(f"{of_row}, height of their axes", middles, 0.0, "the screen's plane", plan.wire)
        yield _worst(f"{of_row}.sides", sides, plan.wire_sides, "scales.yaml: wire_sides")
        ends = np.array([[(e, w.at) if along == 0 else (w.at, e) for e in w.ends] for w in row]).reshape(-1, 2)
        reach = (ends @ outward.T).max(axis=1)
        middle = plan.apothem + 0.5 * plan.thickness
        yield _worst(f"ends of the {of_row}, from the axis", reach, middle, "the middle of the wall's thickness")


def _worst(name: str, given: Floats, expected: Floats | float, source: str, scale: float | None = None) -> Held:
    """Compare the value with the largest deviation."""
    if len(given) == 0:
        return Held(f"{name} (measured on the STL)", None, 0.0, source)
    expected = np.broadcast_to(expected, given.shape)
    at = int(np.argmax(np.abs(given - expected)))
    return Held(f"{name} (measured on the STL)", float(given[at]), float(expected[at]), source, scale, LENGTH_ERROR)


def _tubes(plan: Plan, z: Heights, meshes: Mapping[str, Floats]) -> Iterator[Held]:
    a, t = plan.apothem, plan.thickness
    outer = a + t + plan.clearance
    wire, rim, of_scale = (
        "the wire diameter below the plane",
        "6 mm above the outlet's end",
        "scales.yaml: {}_mm".format,
    )
    for name, inner, low, high, of_low, of_high in (
        ("side_wall", a, z.outlet_top, z.side_wall_top, wire, of_scale("side_wall_height")),
        ("feed_bin", a, z.feed_bin_low, z.feed_bin_top, of_scale("clearance"), of_scale("feed_bin_height")),
        ("outlet", a, z.outlet_end, z.outlet_top, of_scale("outlet_height"), wire),
        ("collecting_bin", outer, z.bin_floor - t, z.bin_rim, of_scale("collecting_bin_height"), rim),
    ):
        if name not in meshes:
            continue
        tube = stl.tube(meshes[name])
        yield _length(f"{name}, axis to inner face", tube.inner, inner, "scales.yaml: width_mm in whole pitches")
        yield _length(f"{name}.thickness_m", tube.outer - tube.inner, t, "scales.yaml: wall_thickness_mm")
        yield Held(f"{name}.sides (measured on the STL)", tube.sides, plan.sides, "scales.yaml: shape, cylinder_sides")
        yield _length(f"{name}, lower end", tube.low, low, of_low)
        yield _length(f"{name}, upper end", tube.high, high, of_high)
        if name == "collecting_bin":
            yield _length(f"{name}, floor", tube.floor, z.bin_floor, of_low)


def _plates(config: Mapping[str, Any], plan: Plan, z: Heights, meshes: Mapping[str, Floats]) -> Iterator[Held]:
    t = plan.thickness
    for name, top, of_top in (
        ("slide", z.slide_top, "slide_height_mm"),
        ("cover", z.feed_bin_top, "feed_bin_height_mm"),
    ):
        if name not in meshes:
            continue
        flat = stl.plate(meshes[name])
        for axis, low, high in zip("xy", flat.low, flat.high, strict=False):
            length, source = float(high - low), "the middle of the wall's thickness"
            yield _length(f"{name}, length along {axis}", length, 2.0 * plan.half_slide, source)
        yield _length(f"{name}, upper face", float(flat.high[2]), top, f"scales.yaml: {of_top}")
        yield _length(f"{name}.thickness_m", flat.thickness, t, "scales.yaml: wall_thickness_mm")
    if "impact_plate" in meshes:
        plate = stl.plate(meshes["impact_plate"])
        angle = float(np.radians(config["apparatus"]["impact_plate_angle_deg"]["value"]))
        edge = plan.apothem - max(OPENING[0] * plan.width, OPENING[1] * plan.aperture)
        tilt, of_tilt = "impact_plate, angle [rad] (measured on the STL)", "scales.yaml: impact_plate_angle_deg"
        yield Held(tilt, plate.angle, angle, of_tilt, allowance=2e-6)
        yield _length("impact_plate, high end", float(plate.high[2]), z.plate_top, "two apertures below the wires")
        yield _length("impact_plate, low edge", float(plate.high[0]), edge, "opening of 0.4 widths or 3 apertures")
        yield _length("impact_plate.thickness_m", plate.thickness, t, "scales.yaml: wall_thickness_mm")


def _box(plan: Plan, scene: Mapping[str, Any], meshes: Mapping[str, Floats]) -> list[Held]:
    """Check that the box is 10 mm beyond the outermost wall, with the slide in its end position."""
    drawn = np.array([2.0 * plan.half_slide, 0.0, 0.0])
    low = np.min([c.reshape(-1, 3).min(axis=0) for c in meshes.values()], axis=0) - MARGIN
    high = np.max([c.reshape(-1, 3).max(axis=0) + drawn * (n == "slide") for n, c in meshes.items()], axis=0) + MARGIN
    return [
        Held(f"{end}.{axis}", given, float(want), "10 mm beyond the walls", allowance=LENGTH_ERROR)
        for end, wanted in (("box_low_m", low), ("box_high_m", high))
        for axis, given, want in zip("xyz", scene[end], wanted, strict=True)
    ]


def _parts(wall: Mapping[str, Any], corners: Floats, plan: Plan) -> list[Held]:
    """Check the parts into which the scene groups the triangles, and their half widths."""
    name, part, given = wall["name"], np.asarray(wall["triangle_part"]), wall["part_half_width_m"]
    found = [Held(f"walls.{name}.triangle_part, its number", len(part), len(corners), "triangles of the STL")]
    if found[0].wrong or len(part) == 0 or int(part.max()) + 1 != len(given):
        return [
            *found,
            Held(f"walls.{name}.part_half_width_m, its number", len(given), int(part.max(initial=-1)) + 1, "its parts"),
        ]
    if name == "wires":
        pairs = np.unique(np.column_stack([part, stl.bodies(corners)]), axis=0)
        found.append(Held("wires, parts that are one bar", len(pairs), len(given), "each wire is one part"))
    for k, width in enumerate(given):
        in_part = corners[part == k]
        upright = name in ("slide", "impact_plate", "cover")
        want = plan.small_half_width if name == "wires" else stl.half_width(in_part, upright)
        found.append(
            Held(
                f"walls.{name}.part_half_width_m[{k}]",
                width,
                want,
                "half the shorter side of the part",
                allowance=LENGTH_ERROR,
            )
        )
    return found


def tables(folder: Path, scene: Mapping[str, Any], meshes: Mapping[str, Floats]) -> list[Held]:
    """Compare history/triangles and history/parts with the STL files and the scene."""
    history = folder / "history"
    corners, areas = np.concatenate(list(meshes.values())), np.concatenate([stl.area(c) for c in meshes.values()])
    offset = np.cumsum([0, *(len(w["part_half_width_m"]) for w in scene["walls"])])
    part = np.concatenate([np.asarray(w["triangle_part"]) + o for w, o in zip(scene["walls"], offset, strict=False)])
    names = [f"v{k}_{axis}" for k in range(3) for axis in "xyz"]
    t = io.columns(
        history / "triangles.parquet", ["triangle", "part", "mesh", "reservoir", "area", *names]
    ).sort_values("triangle")
    p = io.columns(history / "parts.parquet", ["part", "half_width", "contact_angle", "area"]).sort_values("part")
    if len(t) != len(corners) or len(p) != offset[-1]:
        return [
            Held("history/triangles, rows", len(t), len(corners), "stl/"),
            Held("history/parts, rows", len(p), int(offset[-1]), "scene.json"),
        ]
    wall_of = np.repeat(np.arange(len(meshes)), [len(c) for c in meshes.values()])
    of_part = [(w, width) for w in scene["walls"] for width in w["part_half_width_m"]]
    wide = np.array([np.nan if width is None else width for _, width in of_part])
    size = np.bincount(part, weights=areas, minlength=len(p))
    angle, in_part = np.array([w["contact_angle_rad"] for w, _ in of_part]), p["half_width"].to_numpy(float)
    found = [
        _row("history/triangles.part", t["part"].to_numpy(float), part.astype(float), 1.0),
        _row("history/triangles.area", t["area"].to_numpy(float), areas, areas, 1e-6),
        *(
            _row(f"history/triangles.{n}", t[n].to_numpy(float), corners.reshape(-1, 9)[:, k], 1e-3)
            for k, n in enumerate(names)
        ),
        _row("history/parts.contact_angle", p["contact_angle"].to_numpy(float), angle, 1.0),
        _row("history/parts.area", p["area"].to_numpy(float), size, size, 1e-6),
        _row("history/parts.half_width", np.nan_to_num(in_part, posinf=0.0), np.nan_to_num(wide, posinf=0.0), 1e-3),
    ]
    for column, key in (("mesh", "name"), ("reservoir", "reservoir")):
        want = [scene["walls"][k][key] for k in wall_of]
        bad = next((k for k, (a, b) in enumerate(zip(t[column], want, strict=True)) if a != b), 0)
        found.append(
            Held(f"history/triangles.{column} (triangle {bad})", t[column].iloc[bad], want[bad], "scene.json: walls")
        )
    return found


def _row(name: str, given: Floats, expected: Floats, size: Floats | float, allowance: float = 0.0) -> Held:
    """Compare the row of a column with the largest deviation."""
    off = np.abs(given - expected) / size
    at = int(np.argmax(np.where(np.isfinite(off), off, np.inf)))
    scale = float(np.broadcast_to(size, off.shape)[at])
    return Held(
        f"{name} (row {at})", float(given[at]), float(expected[at]), "stl/ and scene.json", scale, allowance * scale
    )
