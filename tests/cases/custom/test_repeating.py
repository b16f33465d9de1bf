"""Scenes and decks that repeat along an axis: walls continue through the faces, spheres and bridges are those in the middle."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import pywet
from pywet.cases.custom.building import Building
from pywet.engines.lammps import deck as lammps
from pywet.engines.yade import driver as yade
from pywet.products.deck import Deck
from reference_impl.replay.command import outcome
from tests.cases.custom.conftest import beads
from tests.error_codes import raises_code

SIDE = 0.035
"""Width of the strip [m]: five apertures and wires."""
DECK = {
    "length_mm": 60, "width_mm": 35, "periodic": True, "aperture_mm": 5, "wire_mm": 2, "inclination_deg": 15,
    "stroke": {"amplitude_mm": 2, "frequency_Hz": 20},
}  # fmt: skip
FACES = {"axis": "y", "low_mm": -17.5, "high_mm": 17.5}
ONE = {"name": "beads", "material": "glass", "diameter_mm": 3, "at_mm": [(30.0, 0.0, 10.0)]}
LEDGER = 1e-12
"""Of the liquid put in."""
PLACE, SPEED = 1e-12, 1e-9
"""How far two paths may be apart [m, m/s] that differ by roundings of 3e-18 m; contacts are of 2000 N/m and some mg."""


def strip(**changes: Any) -> pywet.Scene:
    return pywet.Scene(**beads(**{"deck": DECK, "spheres": [ONE], **changes}))


def test_a_sphere_in_a_wall_beyond_the_face_is_refused_and_one_on_the_face_is_not() -> None:
    """At y = -47 mm its copy is at 53, 3 mm from a block that ends at the face; at the lower face itself it may begin."""
    sphere = {"name": "beads", "material": "glass", "diameter_mm": 10, "at_mm": [(0.0, -47.0, 0.0)]}
    wall = {"name": "block", "block": {"low_mm": (-20, 30, -20), "high_mm": (20, 50, 20)}}
    there = {"periodic": {"axis": "y", "low_mm": -50, "high_mm": 50}, "spheres": [sphere]}
    with raises_code("scene.in_wall"):
        _ = Building(pywet.Scene(**beads(walls=[wall], **there))).spheres
    sphere["at_mm"] = [(0.0, -50.0, 0.0)]
    assert len(Building(pywet.Scene(**beads(**there))).spheres) == 1


def test_a_strip_has_no_sides_and_repeats_where_its_apertures_do() -> None:
    """Half an aperture is left at both faces; wires across and the back wall are open there, all edges of bars closed."""
    made = Building(strip())
    scene = made.scene()
    assert [w.name for w in scene.walls] == ["screen", "cross_wires", "back"] and scene.periodic == "y"
    assert [o.name for o in scene.outlets] == ["spilled_back", "overs", "unders"]
    assert scene.periods_m == pytest.approx((0.0, SIDE, 0.0), rel=1e-7)
    screen, cross, back = made.surfaces
    assert np.abs(screen.vertices[:, 1]).max() == pytest.approx(0.5 * SIDE - 0.0025)
    for surface, at_faces in ((screen, 0), (cross, 2 * 8 * 9), (back, 2 * 4)):
        triangles = surface.triangles
        edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
        both, count = np.unique(edges, axis=0, return_counts=True)
        lone = surface.vertices[both[count == 1]]
        assert len(lone) == at_faces and np.abs(lone[..., 1]) == pytest.approx(0.5 * SIDE, abs=2e-9)


@pytest.mark.parametrize(
    ("change", "code", "says"),
    [
        ({"deck": {**DECK, "width_mm": 36}},
         "config.inconsistent", "width_mm of whole apertures and wires with periodic, such as 35 mm"),
        ({"periodic": FACES}, "config.inconsistent", "no periodic together with a deck with periodic: true"),
        ({"deck": None, "periodic": {**FACES, "low_mm": 20}}, "config.inconsistent", "low_mm below high_mm"),
        (
            {"spheres": [{**ONE, "at_mm": [(30.0, 18.0, 10.0)]}]},
            "scene.periodic",
            "1 spheres,.* at 18 mm along y",
        ),
        (
            {"walls": [{"name": "tray", "block": {"low_mm": (0, -20, -40), "high_mm": (60, 20, -30)}}]},
            "scene.periodic",
            "wall tray reaches from -20 to 20 mm",
        ),
        (
            {"walls": [{"name": "rod", "block": {"low_mm": (0, -2, -40), "high_mm": (60, 2, -30)},
                        "vibrates": {"amplitude_mm": (0, 1, 0), "frequency_Hz": 5}}]},
            "scene.periodic",
            "wall rod moves along y",
        ),
        (
            {"spheres": [{**ONE, "at_mm": None, "count": 2, "velocity_m_per_s": (0, 9, -1), "insertion": {"for_s": 0.005},
                          "box": {"low_mm": (0, -9, 5), "high_mm": (20, 9, 20)}}]},
            "scene.periodic",
            "beads at -.* outside",
        ),
        ({"deck": {**DECK, "width_mm": 7}}, "scene.periodic", "faces of periodic are 7 mm apart"),
        (
            {"spheres": [{**ONE, "at_mm": [(30.0, -17.0, 10.0), (30.0, 17.0, 10.0)]}]},
            "scene.overlap",
            "",
        ),
    ],
)  # fmt: skip
def test_what_cannot_repeat_is_refused(change: dict[str, Any], code: str, says: str) -> None:
    with raises_code(code, says=says):
        Building(strip(**change)).scene()


def test_an_origin_moves_the_faces() -> None:
    scene = Building(
        pywet.Scene(**beads(periodic={"axis": "y", "low_mm": 0, "high_mm": 30}, origin_mm=(0, 5, 0)))
    ).scene()
    assert (scene.box_low_m[1], scene.box_high_m[1]) == pytest.approx((-0.005, 0.025))


def test_other_engines_refuse_a_scene_that_repeats() -> None:
    scene = Building(strip()).scene()
    for refuse, code in ((yade.refuse, "yade.scene"), (lammps.refuse, "lammps.scene")):
        with raises_code(code, says="walls in a box that is periodic"):
            refuse(scene)


def held(folder: Path) -> float:
    """Largest part of the liquid that is not accounted for at an output."""
    ledger = pd.read_parquet(folder / "history" / "ledger.parquet")
    total = ledger[["films", "bridges", "walls", "left", "retired"]].sum(axis=1)
    return float(np.abs(total / ledger["initial"] - 1.0).max())


@pytest.mark.slow
@pytest.mark.engine
def test_two_spheres_across_a_face_are_those_in_the_middle(tmp_path: Path) -> None:
    """Two spheres meet over a wire, touch it and each other, and part, in the middle of the strip and at its face: the same
    events at the same steps, the same volumes and paths up to round-off; the replay, which `run` asks, agrees."""
    deck = {**DECK, "inclination_deg": 0, "width_mm": 42, "stroke": {"amplitude_mm": 0.5, "frequency_Hz": 40}}
    face = 1e3 * float(np.float32(0.021))  # in single precision, as wall coordinates
    ends = {"left": (-1.1, 0.1), "right": (1.1, -0.1)}
    spheres = [
        {**ONE, "name": name, "diameter_mm": 2, "at_mm": [(30.3, y, 2.2), (30.3, y - math.copysign(face, y), 2.2)],
         "velocity_m_per_s": (0.02, v, -0.3)}
        for name, (y, v) in ends.items()
    ]  # fmt: skip
    more = {"liquid": {"percent": 2}, "duration_s": 0.02, "results": {"windows": 30, "window_steps": 4}}
    pywet.run(strip(deck=deck, spheres=spheres, **more), tmp_path)
    assert held(tmp_path) < LEDGER
    events = pd.read_parquet(tmp_path / "history" / "events.parquet")
    one, two = (events[events["i"].isin(ids)].reset_index(drop=True) for ids in ((1, 3), (2, 4)))
    assert one["kind"].tolist() == 3 * [0] + 2 * [1] and one["partner_kind"].tolist() == [0, 1, 1, 1, 1]
    assert (
        two[["step", "kind", "partner_kind"]].to_numpy().tolist()
        == one[["step", "kind", "partner_kind"]].to_numpy().tolist()
    )
    assert two["volume"].to_numpy() == pytest.approx(one["volume"].to_numpy(), rel=1e-12)
    path = pd.read_parquet(tmp_path / "trajectory.parquet").pivot_table(index="step", columns="id")
    for a, b in ((1, 2), (3, 4)):
        off = np.array([path[axis][b] - path[axis][a] for axis in "xyz"])
        off[1] = np.remainder(off[1], 2e-3 * face) - 1e-3 * face
        assert np.abs(off).max() < PLACE
        assert np.abs([path[f"v{axis}"][b] - path[f"v{axis}"][a] for axis in "xyz"]).max() < SPEED


@pytest.mark.slow
@pytest.mark.engine
@pytest.mark.parametrize(("shape", "ranks"), [("rods", 1), ("rods", 2), ("bent", 1), ("block", 1)])
def test_a_wall_is_the_same_at_a_face_as_in_the_middle(tmp_path: Path, shape: str, ranks: int) -> None:
    """Pairs of spheres on the same wall, one near the face and one half a strip away, roll and slide over its edges alike.

    Wires that bend at the face are compared with the replay alone: of two triangles at an angle the later one owns their edge,
    next to which both press, and at the face that is the other one.
    """
    off, face = (3.0, 1.0, 0.7, 0.4, 0.1, 0.01), 1e3 * float(np.float32(0.021))
    pitch = (
        10.5  # two of them are the period of bent wires, half a strip; their crests are at the face and in the middle
    )
    more = {"crimp_mm": 1.0, "first_crossing_mm": 0.0} if shape == "bent" else {}
    bars = {
        "diameter_mm": 2, "pitch_mm": pitch, "count": len(off), "axis": "y", "length_mm": 42, **more,
        "origin_mm": (0.5 * pitch * (len(off) - 1), 0, -1),
    }  # fmt: skip
    block = {"low_mm": (-50, -21, -6), "high_mm": (100, 21, 0)}
    top = 1.0 if shape == "bent" else 0.0
    at = [(pitch * k + 0.15, y, top + 3.02) for k, o in enumerate(off) for y in (face - o, -o)]
    walls = [{"name": "wall", **({"block": block} if shape == "block" else {"bars": bars})}]
    scene = pywet.Scene(
        **beads(
            spheres=[{**ONE, "diameter_mm": 6, "at_mm": at, "velocity_m_per_s": (0.05, 0.2, -0.3)}],
            walls=[*walls, {"name": "tray", "block": {"low_mm": (-50, -21, -16), "high_mm": (100, 21, -10)}}],
            periodic={"axis": "y", "low_mm": -21, "high_mm": 21}, duration_s=0.006,
            results={"windows": 20, "window_steps": 4},
        )
    )  # fmt: skip
    pywet.run(scene, tmp_path, ranks=ranks)
    path = pd.read_parquet(tmp_path / "trajectory.parquet").pivot_table(index="step", columns="id")
    assert path["vz"].iloc[-1].max() > 0.1  # thrown back
    for n in range(len(off) if shape != "bent" else 0):
        apart = np.array([path[axis][2 * n + 1] - path[axis][2 * n + 2] for axis in "xyz"])
        apart[1] = np.remainder(apart[1], 2e-3 * face) - 1e-3 * face
        assert np.abs(apart).max() < PLACE, off[n]
        speeds = [path[f"v{axis}"][2 * n + 1] - path[f"v{axis}"][2 * n + 2] for axis in "xyz"]
        assert np.abs(speeds).max() < SPEED, off[n]


@pytest.mark.slow
@pytest.mark.engine
def test_a_strip_of_a_deck(tmp_path: Path) -> None:
    """Bridges reach across the face, spheres cross it and no sphere is lost; ledger and replay hold, on two ranks too."""
    sizes = {"fine": (3, 60), "coarse": (6, 14)}
    box = {"low_mm": (2, -17, 4), "high_mm": (32, 17, 32)}
    spheres = [
        {"name": n, "material": "glass", "diameter_mm": d, "count": k, "box": box} for n, (d, k) in sizes.items()
    ]
    scene = strip(spheres=spheres, liquid={"percent": 3}, duration_s=0.15, time_step={"share": 0.2})
    for ranks in (1, 2):
        folder = tmp_path / f"ranks_{ranks}"
        pywet.run(scene, folder, ranks=ranks)
        bridges = pd.read_parquet(folder / "history" / "bridges.parquet").query("partner_kind == 0")
        assert (np.abs(bridges["xj_y"]) > 0.5 * SIDE).sum() > 20
        way = pd.read_parquet(folder / "trajectory.parquet").sort_values(["id", "step"]).groupby("id")["y"].diff()
        assert (way.abs() > 0.8 * SIDE).sum() > 5
        assert held(folder) < LEDGER
    plain = json.loads((folder / "scene.json").read_text())
    (folder / "scene.json").write_text(json.dumps({**plain, "periodic": None}))
    found = outcome(folder)
    assert found["status"] == "disagrees"


def test_the_strip_of_a_deck_is_as_wide_as_it() -> None:
    assert Deck(**DECK).strip == FACES
