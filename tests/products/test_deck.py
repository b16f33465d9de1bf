"""Decks from a few numbers: their motion and openings; screens whose answer is known: Gaudin's chance, a feed that cannot peg."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import pywet
from pywet.cases.custom import building
from pywet.cases.custom.description import Scene
from pywet.config.loading import read_yaml
from pywet.geometry.motion import velocity
from pywet.products.deck import Deck, Stroke
from pywet.scene import Vibration
from reference_impl.tables import plant
from tests.cases.custom.conftest import EXAMPLES, beads
from tests.error_codes import raises_code
from tests.products import made_up

STROKE = {"amplitude_mm": 2, "frequency_Hz": 20}
DECK = {"length_mm": 60, "width_mm": 30, "aperture_mm": 4, "wire_mm": 1, "stroke": STROKE}


def path_of(stroke: Stroke) -> tuple[np.ndarray, np.ndarray]:
    """Displacement and velocity along x and z over one period [mm, mm/s]."""
    given = stroke.vibrates()
    t = np.linspace(0.0, 1.0 / stroke.frequency_Hz, 401)
    made = Vibration(
        amplitude_m=given["amplitude_mm"],
        phase_rad=tuple(np.radians(given["phase_deg"])),
        frequency_Hz=given["frequency_Hz"],
    )
    phase = 2 * np.pi * stroke.frequency_Hz * t[:, None] + np.array(made.phase_rad)
    return (np.array(made.amplitude_m) * np.sin(phase))[:, [0, 2]], velocity(made, t)[:, [0, 2]]


def test_strokes_are_lines_circles_and_ellipses() -> None:
    """By hand: along 30 deg; a radius of 2; half axes of 2 and 0.5, the long one at 60 deg; forward at the top of the path."""
    x, _ = path_of(Stroke(**STROKE, angle_deg=30))
    assert np.abs(x @ [-math.sin(math.pi / 6), math.cos(math.pi / 6)]).max() < 1e-12
    assert np.linalg.norm(x, axis=1).max() == pytest.approx(2.0)
    x, _ = path_of(Stroke(**STROKE, kind="circular"))
    assert np.linalg.norm(x, axis=1) == pytest.approx(np.full(401, 2.0))
    x, _ = path_of(Stroke(**STROKE, kind="elliptic", ratio=0.25, angle_deg=60))
    long, short = np.array([0.5, math.sqrt(0.75)]), np.array([math.sqrt(0.75), -0.5])
    assert (x @ long / 2.0) ** 2 + (x @ short / 0.5) ** 2 == pytest.approx(np.ones(401))
    for forward in (True, False):
        x, v = path_of(Stroke(**STROKE, kind="circular", forward=forward))
        assert (v[np.argmax(x[:, 1]), 0] > 0) == forward


def test_an_unusual_stroke_is_accepted_with_its_reason() -> None:
    """The reason holds for the walls that the stroke moves."""
    stroke = {**STROKE, "frequency_Hz": 1200}
    with raises_code("config.implausible"):
        Scene(**beads(deck={**DECK, "stroke": stroke}))
    scene = Scene(**beads(deck={**DECK, "stroke": {**stroke, "unusual": "ultrasound"}})).in_full()
    assert {wall.vibrates.frequency_Hz for wall in scene.walls if wall.vibrates} == {1200}


def test_an_unusual_wire_or_feed_is_accepted_with_its_reason() -> None:
    """The reason holds for the walls and spheres that are made of it."""
    mesh = {**DECK, "aperture_mm": 0.05, "wire_mm": 0.005, "length_mm": 1, "width_mm": 1}
    box = {"low_mm": (0, 0, 1), "high_mm": (1, 1, 2)}
    psd = {"log_normal": {"median_mm": 0.02, "sigma": 0.5}, "smallest_mm": 0.005}
    dust = {"name": "dust", "material": "glass", "psd": psd, "mass_g": 1e-6, "box": box}
    plate = {**mesh, "mesh": "punched_square", "width_mm": 0.5}
    for deck, feed in ((mesh, []), (plate, []), (None, [dust])):
        with raises_code("config.implausible"):
            Scene(**beads(deck=deck, feed=feed)).in_full()
    why = {"unusual": "a microsieve"}
    scene = Scene(**beads(deck={**mesh, **why}, feed=[{**dust, **why}])).in_full()
    assert scene.walls[0].bars and scene.walls[0].bars.diameter_mm == 0.005
    assert Scene(**beads(deck={**plate, **why})).in_full().walls[0].punched
    assert min(s.diameter_mm for s in scene.spheres) < 0.01


@pytest.mark.parametrize("mesh", ["square", "slotted"])
@pytest.mark.parametrize("width", [30.0, 33.0])
def test_no_gap_is_wider_than_an_aperture(mesh: str, width: float) -> None:
    """Between wires it is the aperture, at the side walls that or less; wires across reach both ends."""
    deck = Deck(**{**DECK, "width_mm": width, "mesh": mesh})
    bars = deck.walls()[0]["bars"]
    outer = 0.5 * (bars["count"] - 1) * bars["pitch_mm"] + 0.5 * bars["diameter_mm"]
    assert bars["pitch_mm"] - bars["diameter_mm"] == 4.0 and -0.51 <= 0.5 * width - outer <= 4.0
    if mesh == "square":
        across = deck.walls()[1]["bars"]
        ends = [across["origin_mm"][0] + side * (0.5 * (across["count"] - 1) * 5.0 + 0.5) for side in (-1, 1)]
        assert across["axis"] == "y" and ends[0] == pytest.approx(0.0) and 60.0 - 4.0 <= ends[1] <= 61.0
    back = next(w["block"] for w in deck.walls() if w["name"] == "back")
    assert -0.2 <= back["high_mm"][0] < 0.0 and back["high_mm"][1] >= 0.5 * width - 0.2


def test_the_example_is_short_and_whole() -> None:
    """At most 26 lines of YAML; gravity is inclined by 15 deg; outlets are overs, sections of the unders and what jumps off."""
    text = (EXAMPLES / "deck.yaml").read_text()
    assert sum(bool(line.strip()) and not line.startswith("#") for line in text.splitlines()) <= 26
    made = building.Building(Scene(**{**read_yaml(EXAMPLES / "deck.yaml", Scene), "folder": EXAMPLES}))
    scene = made.scene()
    g = np.array(scene.gravity_m_per_s2)
    assert math.degrees(math.atan2(g[0], -g[2])) == pytest.approx(15.0) and np.linalg.norm(g) == pytest.approx(9.81)
    assert [(o.name, o.product) for o in scene.outlets] == [
        ("spilled_left", None), ("spilled_right", None), ("spilled_back", None), ("overs", "overs"),
        ("unders_1", "unders"), ("unders_2", "unders"),
    ]  # fmt: skip
    assert made.warnings == []


TWO = {**DECK, "aperture_mm": 8, "wire_mm": 2, "beneath": [{"aperture_mm": 4, "wire_mm": 1, "below_mm": 30}]}


def test_decks_beneath_each_other() -> None:
    """Names by number from above; the second 30 mm lower; overs of both cross the end, each above the lower face of its deck."""
    grains = {"name": "grain", "material": "glass", "diameter_mm": 2, "at_mm": [(20.0, 0.0, 10.0)]}
    made = building.Building(pywet.Scene(**beads(deck=TWO, spheres=[grains]))).scene()
    assert [w.name for w in made.walls] == [
        "screen", "cross_wires", "screen_2", "cross_wires_2", "left", "right", "back"
    ]  # fmt: skip
    by_name = {o.name: o for o in made.outlets}
    assert [(o.name, o.product) for o in made.outlets if o.product] == [
        ("overs", "overs"), ("middlings", "middlings"), ("unders", "unders")
    ]  # fmt: skip
    for name, face in (("overs", -0.002), ("middlings", -0.031)):
        assert by_name[name].low_m == pytest.approx((0.060, None, None)) and by_name[name].crossing_above_m == face
    assert by_name["unders"].high_m[2] == pytest.approx(-0.030 - 0.024)
    deck = Deck(**TWO)
    heights = {w["name"]: w["bars"]["origin_mm"][2] for w in deck.walls() if "bars" in w}
    assert heights == {"screen": -1.0, "cross_wires": -1.0, "screen_2": -30.5, "cross_wires_2": -30.5}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"aperture_mm": 8}, "beneath 1: an aperture_mm below that of the deck above, 8 mm"),
        ({"below_mm": 17}, "beneath 1: below_mm of at least two apertures and a wire of the deck above, 18 mm"),
    ],
)
def test_decks_that_do_not_fit_are_refused(change: dict[str, float], message: str) -> None:
    with raises_code("config.inconsistent", says=message):
        pywet.Scene(**beads(deck={**TWO, "beneath": [{**TWO["beneath"][0], **change}]}))


def test_a_deck_smaller_than_an_aperture_is_refused() -> None:
    with raises_code("config.inconsistent", says="of at least one aperture and wire"):
        pywet.Scene(**beads(deck={**DECK, "width_mm": 4}))


def test_gravity_that_is_not_that_of_the_inclination_is_refused() -> None:
    """15 deg rotate gravity to 9.81 (sin, 0, -cos) = (2.539, 0, -9.476) m/s2; a level deck may have any."""
    sloped = {**DECK, "inclination_deg": 15}
    for gravity in ([0, 0, -9.81], [0, 0, 0], [-2.539, 0, -9.476]):
        with raises_code("config.inconsistent", says=r"inclination_deg 15, .*\(2.539, 0, -9.476\)"):
            pywet.Scene(**beads(deck=sloped, gravity_m_per_s2=gravity))
    tilted = 9.81 * np.array([math.sin(math.radians(15)), 0.0, -math.cos(math.radians(15))])
    for deck, given, made in (
        (sloped, {}, tilted),
        (sloped, {"gravity_m_per_s2": [2.539, 0, -9.476]}, tilted),
        (DECK, {"gravity_m_per_s2": [2.5, 0, -9.4]}, [2.5, 0.0, -9.4]),
    ):
        full = pywet.Scene(**beads(deck=deck, **given)).in_full()
        assert full.gravity_m_per_s2 == pytest.approx(made, rel=1e-12)


def scene(**changes: Any) -> pywet.Scene:
    """Dry and soft, so that steps are long."""
    glass = {"glass": {"density_kg_per_m3": 2500, "stiffness_N_per_m": 200, "restitution": 0.5}}
    return pywet.Scene(**beads(**{"materials": glass, "results": {"interval_s": 0.01, "windows": 0}, **changes}))


def flight(**changes: Any) -> pywet.Scene:
    """Softer still, as nothing touches."""
    return scene(
        materials={"glass": {"density_kg_per_m3": 2500, "stiffness_N_per_m": 10, "restitution": 0.5}}, **changes
    )


@pytest.mark.engine
def test_a_product_is_decided_where_the_end_is_crossed(tmp_path: Path) -> None:
    """Free flights over a deck of 60 mm whose lower face is at -1 mm: by the parabola a slow sphere crosses the end at -0.005 mm
    and one that rises at -0.5 mm; a fast one at -3.2 mm, which reaches x = 68 mm before it is 24 mm below the deck."""
    still = {**STROKE, "amplitude_mm": 1e-6}
    flights = {
        "slow": ((59.95, 0.0, 0.0), (0.05, 0.0, 0.0), "overs"),
        "rising": ((59.0, 0.0, -4.0), (0.1, 0.0, 0.4), "overs"),
        "falling": ((59.0, 5.0, 4.0), (0.05, 0.0, -0.3), "unders"),
        "fast": ((58.0, -5.0, -3.0), (0.3, 0.0, 0.0), "unders"),
    }
    spheres = [
        {"name": name, "material": "glass", "diameter_mm": 0.5 + 0.1 * k, "at_mm": [at], "velocity_m_per_s": v}
        for k, (name, (at, v, _)) in enumerate(flights.items())
    ]
    run = pywet.run(flight(spheres=spheres, deck={**DECK, "stroke": still}, duration_s=0.15), tmp_path)
    gone = run._run.table("history/retired").sort_values("id")
    names = np.array([o.name for o in run.scene.outlets])[gone["outlet"] - 1]
    assert dict(zip(flights, names, strict=True)) == {name: product for name, (*_, product) in flights.items()}
    assert (pywet.replay(tmp_path) or {})["ok"]
    for name, product in (("slow", "unders"), ("fast", "overs")):
        to = 1 + [o.name for o in run.scene.outlets].index(product)
        wrong = gone.assign(outlet=gone["outlet"].where(gone["id"] != 1 + [*flights].index(name), to))
        wrong.to_parquet(tmp_path / "history" / "retired.parquet", index=False)
        found = pywet.replay(tmp_path) or {}
        assert not found["ok"] and not found["quantities"]["retired_who"]["ok"]


@pytest.mark.parametrize("kind", ["linear", "circular", "elliptic"])
@pytest.mark.parametrize("aperture", [1.0, 4.0, 12.0])
def test_outlets_are_clear_of_a_deck_wherever_its_stroke_takes_it(kind: str, aperture: float) -> None:
    """One aperture below the lowest place of the lower face, two behind the rearmost one of the back wall, by the path itself."""
    turns: tuple[dict[str, Any], ...] = ({},) if kind == "linear" else ({"forward": True}, {"forward": False})
    for more in turns:
        for angle in (0, 30, 45, 90):
            stroke = {"kind": kind, "amplitude_mm": 8, "frequency_Hz": 12, "angle_deg": angle, **more}
            place, _ = path_of(Stroke(**stroke))
            x, z = (place - place[0]).min(axis=0)
            deck = Deck(**{**DECK, "aperture_mm": aperture, "stroke": stroke})
            found = {o["name"]: o for o in deck.outlets()}
            back = min(w["block"]["low_mm"][0] for w in deck.walls() if w["name"] == "back")
            assert found["unders"]["high_mm"][2] <= z - 1.0 - aperture + 1e-2
            assert found["spilled_back"]["high_mm"][0] <= back + x - 2.0 * aperture + 1e-2
    still = {
        o["name"]: o for o in Deck(**DECK).outlets()
    }  # where the stroke is short they stay six apertures and 10 mm away
    assert still["unders"]["high_mm"][2] == -24.0 and still["spilled_back"]["high_mm"][0] == -18.0


@pytest.mark.engine
def test_a_product_is_decided_by_where_the_deck_is_then(tmp_path: Path) -> None:
    """A circle of 4 mm at 16 Hz from 45 deg on: at 39.06 ms the deck is at its lowest, 6.83 mm down, its end 2.83 mm out.

    A sphere crosses that then at -4 mm, 3.83 mm above the lower face. At 7.81 ms the deck is at its top, 1.17 mm up: one crosses
    its end at -1.5 mm, 1.67 mm below the lower face, and rises to -0.5 mm, above where that is at the start.
    """
    circle = {"kind": "circular", "amplitude_mm": 4, "frequency_Hz": 16}
    out, g = 60.0 + 4.0 * math.sqrt(0.5), 9.81e3
    crossings = {
        "carried": (0.625 / 16, (out, 0.0, -4.0), (300.0, 0.0, -400.0), "overs"),
        "passed": (0.125 / 16, (out, 5.0, -1.5), (1000.0, 0.0, 140.0), "unders"),
    }
    spheres = []
    for k, (name, (t, at, v, _)) in enumerate(crossings.items()):
        start = (at[0] - t * v[0], at[1], at[2] - t * v[2] - 0.5 * g * t**2)
        thrown = (1e-3 * v[0], 0.0, 1e-3 * (v[2] + g * t))
        entry = {"name": name, "material": "glass", "diameter_mm": 0.5 + 0.1 * k, "at_mm": [start]}
        spheres.append({**entry, "velocity_m_per_s": thrown})
    run = pywet.run(flight(spheres=spheres, deck={**DECK, "stroke": circle}, duration_s=0.15), tmp_path)
    gone = run._run.table("history/retired").sort_values("id")
    names = [run.scene.outlets[k - 1].name for k in gone["outlet"]]
    assert dict(zip(crossings, names, strict=True)) == {name: product for name, (*_, product) in crossings.items()}
    assert (pywet.replay(tmp_path) or {})["ok"]
    swapped = gone.assign(outlet=gone["outlet"].to_numpy()[::-1])
    swapped.to_parquet(tmp_path / "history" / "retired.parquet", index=False)
    assert not (pywet.replay(tmp_path) or {})["quantities"]["retired_who"]["ok"]


def test_outlets_of_the_user_come_before_those_of_the_deck() -> None:
    """A part of the overs is collected on its own; what lies where spheres leave first is named, a lid at the end is not."""
    grains = {"name": "grain", "material": "glass", "diameter_mm": 2, "at_mm": [(20.0, 0.0, 10.0)]}
    walls = [
        {"name": "chute", "block": {"low_mm": (80, -10, -20), "high_mm": (120, 10, -10)}},
        {"name": "lid", "block": {"low_mm": (60.2, -10, -4), "high_mm": (64, 10, 40)}},
    ]
    outlets = [{"name": "overs_left", "low_mm": (60, 0, None)}, {"name": "bunker", "low_mm": (125, None, None)}]
    made = building.Building(scene(spheres=[grains], deck=DECK, walls=walls, outlets=outlets))
    assert [o.name for o in made.scene().outlets] == [
        "overs_left", "bunker", "spilled_left", "spilled_right", "spilled_back", "overs", "unders"
    ]  # fmt: skip
    assert [line for line in made.warnings if "removed" in line] == [
        f"{what} is in outlet overs, in which spheres are removed before they reach it"
        for what in ("wall chute", "outlet bunker")
    ]


@pytest.mark.parametrize("inserted", [True, False])
def test_a_feed_box_behind_the_deck_is_refused(inserted: bool) -> None:
    """All of it would be removed at the first check, as spilled over the back."""
    box = {"low_mm": (-60, -10, 10), "high_mm": (-30, 10, 30)}
    grains = {"name": "grain", "material": "glass", "diameter_mm": 2, "count": 5, "box": box}
    more = {"velocity_m_per_s": (0, 0, -0.3), "insertion": {"for_s": 0.005}} if inserted else {}
    with raises_code("scene.in_outlet", says="5 of 5 spheres start or enter in outlet spilled_back", given=5):
        building.Building(scene(spheres=[{**grains, **more}], deck=DECK)).scene()


@pytest.mark.slow
@pytest.mark.engine
def test_probability_of_passage_by_gaudin(tmp_path: Path) -> None:
    """Dry single spheres of 1 mm fall on a square mesh: those that touch no wire are ((a - d)/(a + w))^2, 9/25, of 360 spheres,
    and they are just those whose path is free, where the eight faces of a wire leave no doubt."""
    random = np.random.default_rng(5)
    cells = np.array([(5.0 * i, 5.0 * j) for i in range(1, 21) for j in range(-9, 9)])
    at = cells + random.uniform(-2.5, 2.5, cells.shape)
    keep = [k for k in range(len(at)) if (np.hypot(*(at[:k] - at[k]).T) > 1.6).all()]
    at = at[keep]
    still = {"amplitude_mm": 1e-6, "frequency_Hz": 1}
    deck = {**DECK, "length_mm": 110, "width_mm": 99, "stroke": still, "side_mm": 20}
    places = [(x, y, 6.0) for x, y in at]
    spheres = [{"name": "single", "material": "glass", "diameter_mm": 1, "at_mm": places}]
    run = pywet.run(scene(spheres=spheres, deck=deck, duration_s=0.2), tmp_path)
    walls = {w["name"]: w["bars"] for w in Deck(**deck).walls() if "bars" in w}
    low = {}
    for name, k in (("screen", 1), ("cross_wires", 0)):
        bars = walls[name]
        axes = bars["origin_mm"][k] + (np.arange(bars["count"]) - 0.5 * (bars["count"] - 1)) * 5.0
        low[name] = np.abs(at[:, k][:, None] - axes).min(axis=1)
    clear = np.minimum(low["screen"], low["cross_wires"]) - 1.0  # touch at r + w/2 = 1 mm from an axis
    gone = run._run.table("history/retired").set_index("id")
    straight = np.array([
        k + 1 in gone.index and math.hypot(gone.loc[k + 1, "v_x"], gone.loc[k + 1, "v_y"]) < 1e-9 for k in range(len(at))
    ])  # fmt: skip
    sure = np.abs(clear) > 0.08
    assert (straight == (clear > 0))[sure].all() and sure.sum() > 300
    probability = ((4.0 - 1.0) / (4.0 + 1.0)) ** 2
    assert straight.mean() == pytest.approx(probability, abs=3.0 * math.sqrt(probability * (1 - probability) / len(at)))


@pytest.mark.slow
@pytest.mark.engine
def test_two_decks_part_three_sizes(tmp_path: Path) -> None:
    """Spheres of 12, 6 and 2 mm over 8 and 4 mm: what cannot pass a deck never leaves below it, to the sphere; what can pass
    does so but for a tenth of the fine spheres and a half of the middle ones, of which some jump; the numbers of both screens
    are those of the counts; the replay agrees."""
    box = {"low_mm": (2, -12, 8), "high_mm": (30, 12, 40)}
    sizes = {"coarse": (12, 4), "middle": (6, 8), "fine": (2, 40)}
    spheres = [
        {"name": name, "material": "glass", "diameter_mm": d, "count": n, "box": box} for name, (d, n) in sizes.items()
    ]
    stroke = {"amplitude_mm": 1, "frequency_Hz": 25, "angle_deg": 60}
    deck = {**TWO, "length_mm": 150, "inclination_deg": 12, "side_mm": 60, "stroke": stroke}
    run = pywet.run(scene(spheres=spheres, deck=deck, duration_s=2.5, results={"windows": 2}), tmp_path)
    gone = run._run.table("history/retired")
    names = np.array(["", *(o.product or "spilled" for o in run.scene.outlets)])[gone["outlet"]]
    counts = pd.crosstab(gone["type"], names)
    assert set(counts) == {"overs", "middlings", "unders"} and counts.sum(axis=1).to_list() == [4, 8, 40]
    assert counts["overs"][1] == 4 and counts["unders"][2] == 0  # too large for the upper deck and for the lower one
    assert counts["middlings"][2] >= 4 and counts["unders"][3] >= 36
    first, second = (pywet.screen(tmp_path, from_s=0.0, deck=k) for k in (1, 2))
    # relative to the spheres that can pass the upper deck
    mass = counts.mul(pd.Series({1: 12.0**3, 2: 6.0**3, 3: 2.0**3}), axis=0).drop(index=1)
    assert first["undersize_recovery"] == pytest.approx(1.0 - mass["overs"].sum() / mass.to_numpy().sum())
    passed = counts.loc[3, ["middlings", "unders"]]
    assert second["undersize_recovery"] == pytest.approx(passed["unders"] / passed.sum())
    assert (tmp_path / "screen_2.html").exists()


@pytest.mark.slow
@pytest.mark.engine
def test_the_double_deck_of_the_examples(tmp_path: Path) -> None:
    """At most 26 lines; three products, the mean size of which falls from deck to deck; spheres leave in the last step too; the
    replay, which `run_scene` asks, agrees."""
    file = EXAMPLES.parent / "decks" / "double_deck.yaml"
    assert sum(bool(line.strip()) and not line.startswith("#") for line in file.read_text().splitlines()) <= 26
    run = pywet.run(pywet.read_scene(file), tmp_path)
    gone = run._run.table("history/retired")
    names = np.array(["", *(o.product or "spilled" for o in run.scene.outlets)])[gone["outlet"]]
    radius = np.array([c.radius_m for c in run.scene.classes])[gone["type"] - 1]
    mean = pd.Series(radius).groupby(names).mean()
    assert mean["overs"] > mean["middlings"] > mean["unders"] and "spilled" not in mean
    assert gone["step"].max() == run.scene.steps
    for k, page in ((1, "screen.html"), (2, "screen_2.html")):
        found = pywet.screen(tmp_path, deck=k)
        assert 0.0 < found["efficiency"] < 1.0 and (tmp_path / page).exists()
        # the strip is periodic: as many apertures as wires across
        assert found["apertures"] == (4 * 7 if k == 1 else 6 * 11)
        # recomputed by the reference, which names a wrong one
        for key in ("pegged", "pegged_half_width", "pegged_share"):
            changed = {**found, key: found[key] * 1.01 + 1e-3}
            assert made_up.disagrees(tmp_path, changed) == [f"{plant.RESULTS[k]}: {key}"]


@pytest.mark.slow
@pytest.mark.engine
def test_a_feed_that_cannot_peg(tmp_path: Path) -> None:
    """Spheres of half an aperture pass, those of two apertures do not: a step, without misplaced material, to the sphere."""
    box = {"low_mm": (2, -12, 6), "high_mm": (25, 12, 30)}
    spheres = [
        {"name": "fine", "material": "glass", "diameter_mm": 2, "count": 60, "box": box},
        {"name": "coarse", "material": "glass", "diameter_mm": 8, "count": 6, "box": box},
    ]
    deck = {
        **DECK,
        "length_mm": 200,
        "inclination_deg": 10,
        "side_mm": 40,
        "stroke": {"amplitude_mm": 1, "frequency_Hz": 25, "angle_deg": 60},
    }
    run = pywet.run(scene(spheres=spheres, deck=deck, duration_s=3.0, results={"windows": 2}), tmp_path)
    gone, types = run._run.table("history/retired"), run._run.spheres.set_index("id")["type"]
    names = np.array(["", *(o.product or "spilled" for o in run.scene.outlets)])[gone["outlet"]]
    counts = pd.crosstab(gone["type"], names)
    assert counts.loc[1].to_dict() == {"overs": 0, "unders": 60} and counts.loc[2].to_dict() == {
        "overs": 6,
        "unders": 0,
    }
    assert set(gone["id"]) == set(types.index)
    numbers = pywet.screen(tmp_path, aperture_mm=4, from_s=0.0)
    assert (numbers["efficiency"], numbers["misplaced"], numbers["d50_mm"]) == pytest.approx((1.0, 0.0, 5.0))


OPEN = {
    "square": (4 / 5) ** 2, "woven": (4 / 5) ** 2, "slotted": 4 / 5, "punched_square": (4 / 5) ** 2,
    "punched_round": math.pi / (2 * math.sqrt(3)) * (4 / 5) ** 2,
}  # fmt: skip
"""Open area of an endless deck of apertures of 4 mm that are 1 mm apart: (a/p)^2, a/p, of a triangular pattern 0.907 (a/p)^2."""


@pytest.mark.parametrize("mesh", [*OPEN])
def test_open_area_is_that_of_the_closed_form(mesh: str) -> None:
    """Of the deck and of its triangles seen from above, which cover what is not open: on a deck of 48 by 48 apertures the
    margins at both ends are all that differs."""
    spacing = 5 * math.sqrt(0.75) if mesh == "punched_round" else 5.0
    deck = Deck(**{**DECK, "length_mm": 240, "width_mm": 48 * spacing, "mesh": mesh})
    assert deck.open_area(deck) == pytest.approx(OPEN[mesh], rel=0.03 if mesh == "punched_round" else 1e-9)
    if not deck.is_plate:
        return
    small = Deck(**{**DECK, "length_mm": 42.5, "width_mm": 4 * spacing, "mesh": mesh})
    grains = {"name": "grain", "material": "glass", "diameter_mm": 2, "at_mm": [(20.0, 0.0, 10.0)]}
    made = building.Building(pywet.Scene(**beads(deck=small.model_dump(exclude_unset=True), spheres=[grains])))
    plate = made.surfaces[0]
    top = plate.area[plate.normals[:, 2] > 0.5].sum()
    share = 1.0 - top / (42.5e-3 * 4e-3 * spacing)
    faces_of_hole = 24 / math.pi * math.tan(math.pi / 24) if mesh == "punched_round" else 1.0
    assert share == pytest.approx(small.open_area(small) * faces_of_hole, rel=1e-6)
    assert plate.vertices[:, 2].max() == 0.0 and plate.vertices[:, 2].min() == pytest.approx(-1e-3)


def test_wires_of_a_woven_deck_touch_and_do_not_cut() -> None:
    """At a crossing one is above, the other below, and neighbours change places."""
    deck = Deck(**{**DECK, "mesh": "woven", "width_mm": 33})
    grains = {"name": "grain", "material": "glass", "diameter_mm": 2, "at_mm": [(20.0, 0.0, 10.0)]}
    made = building.Building(pywet.Scene(**beads(deck=deck.model_dump(exclude_unset=True), spheres=[grains])))
    along, across = made.surfaces[:2]
    crossings = 0
    for k in range(int(along.part.max()) + 1):
        one = along.corners[along.part == k].reshape(-1, 3)
        for n in range(int(across.part.max()) + 1):
            two = across.corners[across.part == n].reshape(-1, 3)
            x, y = two[:, 0].mean(), one[:, 1].mean()
            heights = [
                points[np.abs(points[:, axis] - at) < 1e-5][:, 2].mean()
                for points, axis, at in ((one, 0, x), (two, 1, y))
            ]
            assert abs(heights[0] - heights[1]) == pytest.approx(1e-3, rel=1e-3)
            assert (heights[0] > heights[1]) == ((k + n) % 2 == 0)
            crossings += 1
    assert crossings > 50 and max(s.vertices[:, 2].max() for s in (along, across)) < 1e-9


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"plate_mm": 2}, "plate_mm only with mesh: punched_round or punched_square"),
        (
            {"mesh": "punched_square", "periodic": True},
            "mesh square, woven or slotted with periodic, not punched_square",
        ),
        ({"mesh": "punched_round", "wire_mm": 0.5}, "wire_mm of at least 0.72 mm between round holes of 4 mm, not 0.5"),
        (
            {"mesh": "woven", "periodic": True, "width_mm": 35},
            "such as 40 mm for a pitch of 5 mm and mesh: woven, not 35",
        ),
    ],
)
def test_meshes_that_cannot_be_are_refused(change: dict[str, Any], message: str) -> None:
    with raises_code("config.inconsistent", says=message):
        pywet.Scene(**beads(deck={**DECK, **change}))


@pytest.mark.slow
@pytest.mark.engine
@pytest.mark.parametrize("mesh", ["punched_round", "punched_square", "woven"])
def test_smaller_spheres_pass_and_larger_do_not(tmp_path: Path, mesh: str) -> None:
    """Spheres of 0.8 and 1.1 apertures over a level deck that throws them nine times: those above the aperture all stay.

    Of the others pass at least as many as by Gaudin's chance per throw, as those that touch an edge may roll in as well (six
    seeds with square holes: 5 to 13 of 24, by the chance 3.2). The replay agrees and counts the apertures of the deck.
    """
    box = {"low_mm": (3, -9, 4), "high_mm": (27, 9, 24)}
    spheres = [
        {"name": name, "material": "glass", "diameter_mm": d, "count": n, "box": box}
        for name, d, n in (("passes", 3.2, 24), ("stays", 4.4, 10))
    ]
    deck = {
        **DECK, "mesh": mesh, "length_mm": 30, "width_mm": 20, "wire_mm": 2 if mesh != "woven" else 1, "side_mm": 40,
        "stroke": {"amplitude_mm": 1.2, "frequency_Hz": 25, "angle_deg": 90},
    }  # fmt: skip
    lid = {"name": "gate", "block": {"low_mm": (30.2, -10, -4), "high_mm": (34, 10, 40)}}
    # softer spheres would be pressed through the wires
    glass = {"glass": {"density_kg_per_m3": 2500, "restitution": 0.5}}
    more = {"materials": glass, "duration_s": 0.4, "time_step": {"share": 0.2}, "results": {"windows": 4}}
    made = scene(spheres=spheres, deck=deck, walls=[lid], **more)
    run = pywet.run(made, tmp_path)
    gone = run._run.table("history/retired")
    names = np.array([o.name for o in run.scene.outlets])[gone["outlet"] - 1]
    through = pd.Series(names == "unders", dtype=bool).groupby(gone["type"].to_numpy()).sum()
    given = Deck(**deck)
    free_mm = 4.0 - 3.2
    probability = (free_mm / 5.0) ** 2
    if given.is_plate:
        hole_mm2 = free_mm**2 * (math.pi / 4 if mesh == "punched_round" else 1.0)
        probability = len(given.punching(given).centres) * hole_mm2 / (30 * 20)
    assert through.get(1, 0) >= 24 * (1 - (1 - probability) ** 9) and through.get(2, 0) == 0
    if given.is_plate:
        assert pywet.screen(tmp_path, from_s=0.0)["apertures"] == len(given.punching(given).centres)
