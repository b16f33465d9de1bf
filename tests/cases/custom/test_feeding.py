"""Spheres that enter during a run: where they wait, how they fall, and that their liquid is put in when they come."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pywet
from pywet import scene as typed
from pywet.cases.custom.building import Building
from pywet.errors import PywetError
from reference_impl.replay.plans import enter_times
from tests.cases.custom.conftest import beads, example
from tests.error_codes import raises_code

LEFT_OUT = {"value": 0.02, "source": "assumption", "reason": "of a test"}
FLOOR = {"name": "floor", "block": {"low_mm": (-20, -20, -70), "high_mm": (20, 20, -65)}}
"""Not reached."""
INLET = {"low_mm": (-10, -10, 20), "high_mm": (10, 10, 26)}


def inserted(**changes: Any) -> dict[str, Any]:
    entry = {
        "name": "beads", "material": "glass", "diameter_mm": 3, "count": 12, "box": INLET, "velocity_m_per_s": (0, 0, -0.2),
        "insertion": {"from_s": 0.01, "for_s": 0.06}, **changes,
    }  # fmt: skip
    return beads(duration_s=0.1, spheres=[entry])


def test_a_sphere_waits_as_far_back_as_it_has_to_come() -> None:
    """At its time it is in the region; centres keep more than touch."""
    made = Building(pywet.Scene(**inserted()))
    table, times = made.spheres, 0.01 + 0.06 * (np.arange(12) + 0.5) / 12
    assert np.array(made.scene().enters(table["type"])) == pytest.approx(times / made.time_step, abs=0.51)
    at = table[[*"xyz"]].to_numpy() + times[:, None] * table[["vx", "vy", "vz"]].to_numpy()
    assert (np.abs(at[:, :2]) <= 0.0085).all() and (at[:, 2] >= 0.0215).all() and (at[:, 2] <= 0.0245).all()
    apart = np.linalg.norm(table[[*"xyz"]].to_numpy()[:, None] - table[[*"xyz"]].to_numpy(), axis=2)
    assert apart[apart > 0].min() > 0.003


@pytest.mark.parametrize(
    ("entry", "walls", "code", "says"),
    [
        ({"velocity_m_per_s": (0, 0, 0)}, [], "config.inconsistent", "velocity_m_per_s together with insertion"),
        ({"insertion": {"for_s": 0.2}}, [], "config.inconsistent", "to be inserted before the end"),
        (
            {"insertion": {"for_s": 0.05, "pulses": 2}},
            [],
            "config.inconsistent",
            "pulses only with profile: pulsed",
        ),
        (
            {"insertion": {"for_s": 0.05, "profile": "pulsed"}},
            [],
            "config.inconsistent",
            "pulses with profile: pulsed",
        ),
        ({"count": 3000}, [], "scene.crowded_feed", ""),
        (
            {},
            [{"name": "lid", "block": {"low_mm": (-20, -20, 28), "high_mm": (20, 20, 30)}}],
            "scene.in_wall",
            "",
        ),
    ],
)
def test_a_feed_that_cannot_be_is_refused(
    entry: dict[str, Any], walls: list[dict[str, Any]], code: str, says: str
) -> None:
    with raises_code(code, says=says):
        _ = Building(pywet.Scene(**{**inserted(**entry), "walls": walls})).spheres


@pytest.mark.parametrize(
    ("profile", "peak"), [({}, 1.0), ({"profile": "pulsed", "pulses": 2}, 2.0), ({"profile": "ramp"}, 2.0)]
)
def test_too_high_a_rate_is_named_as_a_share_of_the_stream(profile: dict[str, Any], peak: float) -> None:
    """140 spheres of 3 mm in 0.06 s through 20 mm x 20 mm at 0.2 m/s; a stream of a third of the volume is possible."""
    _ = Building(pywet.Scene(**inserted(count=110))).spheres
    with raises_code("scene.crowded_feed", key="spheres.beads") as error:
        _ = Building(pywet.Scene(**inserted(count=140, insertion={"from_s": 0.01, "for_s": 0.06, **profile}))).spheres
    assert error.value.given == pytest.approx(peak * 140 * np.pi / 6 * 0.003**3 / 0.06 / (0.02 * 0.02 * 0.2))


@pytest.mark.engine
def test_a_dry_feed_falls_from_where_it_enters(tmp_path: Path) -> None:
    """Straight on until then, free fall after: z - z0 = v t - g (t - t_enters)^2/2."""
    scene = pywet.Scene(**{**inserted(), "time_step": {"time_step_s": 2e-5}, "walls": [FLOOR]})
    run = pywet.run(scene, tmp_path)
    table = run.trajectory.sort_values(["step", "id"])
    first = table[table["step"] == 0]
    since = table["time"].to_numpy().reshape(-1, 12) - 2e-5 * np.array(run.scene.enters(first["type"]))
    want = (
        first["z"].to_numpy() - 0.2 * table["time"].to_numpy().reshape(-1, 12) - 0.5 * 9.81 * np.maximum(since, 0) ** 2
    )
    assert table["z"].to_numpy().reshape(-1, 12) == pytest.approx(want, abs=9.81 * 0.1 * 2e-5)
    speeds = np.where(since >= 0.0, 0.2 + 9.81 * since, np.nan)  # of those that have entered alone
    inside = np.isfinite(speeds).any(axis=1)
    mean = run.contact_statistics["mean_speed_m_per_s"].to_numpy()
    assert mean[inside] == pytest.approx(np.nanmean(speeds[inside], axis=1), abs=9.81 * 2e-5)
    assert not mean[~inside].any() and 0 < inside.sum() < len(inside)
    weight = 2500 * np.pi / 6 * 0.003**3 * 9.81
    fallen = 0.2 * np.maximum(since[-1], 0) + 0.5 * 9.81 * np.maximum(since[-1], 0) ** 2
    assert run.summary["energy_J"]["gravity"] == pytest.approx(weight * fallen.sum(), rel=1e-3)


@pytest.mark.engine
def test_a_deck_with_feed_counts_liquid_as_it_comes(tmp_path: Path) -> None:
    """Add a film to the inserted liquid for each sphere that enters; the replay disagrees if it is given other times."""
    scene = example(
        "slotted_deck",
        {"insertion": {"from_s": 0.0, "for_s": 0.05, "profile": "pulsed", "pulses": 2}},
        Path(__file__).parent,
        duration_s=0.07,
    )
    smaller = [s.model_copy(update={"count": s.count // 3}) for s in scene.spheres if s.count]
    run = pywet.run(pywet.Scene(**{**dict(scene), "spheres": smaller, "results": {"windows": 3}}), tmp_path / "deck")
    start = run._run.spheres.sort_values("id")
    enters = np.array(run.scene.enters(start["type"]))
    due = [start.loc[enters <= step, "film"].sum() for step in run.ledger["step"]]
    assert due[0] < 0.1 * due[-1] and run.liquid["total_m3"].to_numpy() == pytest.approx(due, rel=1e-9, abs=1e-22)
    assert run.ledger["initial"].to_numpy() == pytest.approx(due, rel=1e-9, abs=1e-22)
    assert run.liquid["wall_deck_m3"].iloc[-1] > 0 and len(run.events)
    copy = Path(shutil.copytree(tmp_path / "deck", tmp_path / "other"))
    reported = json.loads((copy / "scene.json").read_text())
    for c in reported["classes"]:
        c["insertion"]["from_s"] += 0.01
    (copy / "scene.json").write_text(json.dumps(reported))
    wrong = {name for name, q in (pywet.replay(copy) or {})["quantities"].items() if not q["ok"]}
    assert {"newton_force", "ledger", "energy_gravity", "results_liquid_by_wall"} <= wrong


@pytest.mark.engine
def test_spheres_that_wait_shed_no_drops_and_catch_none(tmp_path: Path) -> None:
    """Others lie above the feed, and their films are thicker than what they can hold: drops pass those that wait."""
    resting = {"name": "rest", "material": "glass", "diameter_mm": 3, "count": 30,
               "box": {"low_mm": (-10, -10, 50), "high_mm": (10, 10, 62)}}  # fmt: skip
    given, plate = inserted(), {"name": "plate", "block": {"low_mm": (-30, -30, 46), "high_mm": (30, 30, 49)}}
    scene = {
        **given, "duration_s": 0.075,
        "effects": {"shedding": True, "wall_films": False, "tolerance": LEFT_OUT},
        "liquid": {"percent": 10, "surface_tension_N_per_m": 0.002}, "spheres": [*given["spheres"], resting],
        "walls": [FLOOR, plate],
    }  # fmt: skip
    run = pywet.run(pywet.Scene(**scene), tmp_path / "run")
    start, drops = run._run.spheres.set_index("id"), run._run.table("history/drops")
    enters = dict(zip(start.index, run.scene.enters(start["type"]), strict=True))
    assert len(drops) > 20
    for end in ("i", "j"):
        on = drops[drops["partner_kind"] == 0] if end == "j" else drops
        assert len(on) and (on["step"] >= on[end].map(enters)).all(), end
    assert run.replay["ok"]


def test_a_single_pulse() -> None:
    """One is a pulse; none is refused."""
    given = {"for_s": 0.05, "profile": "pulsed", "pulses": 1, "pulse_share": 0.25}
    entry = example("slotted_deck", {"insertion": given}, Path(__file__).parent).spheres[0]
    assert entry.insertion is not None and entry.insertion.pulses == 1
    with pytest.raises(PywetError, match=r"insertion\.pulses is 0"):
        example("slotted_deck", {"insertion": {**given, "pulses": 0}}, Path(__file__).parent)


@pytest.mark.parametrize("profile", ["constant", "ramp", "pulsed"])
def test_rates_over_time(profile: str) -> None:
    """Part that has entered by t of 4 s: t/4, (t/4)^2, and by halves in the first quarter of every two seconds."""
    insertion = typed.Insertion(from_s=1.0, for_s=4.0, profile=profile, pulses=2, pulse_share=0.25)
    at = np.array([insertion.at(k, 4000) for k in range(4000)]) - 1.0
    come = [(at <= t).mean() for t in (0.25, 0.5, 1.0, 2.0, 2.5, 3.0, 4.0)]
    want = {
        "constant": [1 / 16, 1 / 8, 1 / 4, 1 / 2, 5 / 8, 3 / 4, 1],
        "ramp": [1 / 256, 1 / 64, 1 / 16, 1 / 4, 25 / 64, 9 / 16, 1],
        "pulsed": [1 / 4, 1 / 2, 1 / 2, 1 / 2, 1, 1, 1],
    }
    assert come == pytest.approx(want[profile], abs=5e-4)
    assert enter_times(insertion.model_dump(), 4000) == pytest.approx(at + 1.0, rel=1e-14)


@pytest.mark.engine
def test_a_feed_that_begins_late_begins(tmp_path: Path) -> None:
    """The engine needs one sphere at the start: the first one waits; the replay agrees with the run."""
    entry = {
        **inserted()["spheres"][0],
        "count": 3,
        "velocity_m_per_s": (0, 0, -1),
        "insertion": {"from_s": 0.3, "for_s": 0.02},
    }
    below = {"name": "below", "high_mm": (None, None, -10)}
    scene = pywet.Scene(**beads(duration_s=0.4, spheres=[entry], outlets=[below], liquid={"percent": 1}))
    made = Building(scene)
    assert len(made._there(made.spheres)) == 1
    assert pywet.run(scene, tmp_path / "run").summary["ranks"] == 1
