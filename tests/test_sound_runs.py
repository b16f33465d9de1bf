"""No sound run raises an alarm: scenes that did, some of each kind of short runs, and (slow) two hundred of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from typer.testing import CliRunner

import pywet
from pywet import config, stages
from pywet.cases.screening import cases, verdict
from pywet.cli.app import app
from pywet.errors import PywetError, StoppedRun
from pywet.runs.tables import ledger_error
from pywet.util.files import read_json
from reference_impl.diagnosis import chain
from reference_impl.motion import newton, window
from reference_impl.replay import io
from reference_impl.replay.lives import Lives, none
from tests import sound_runs

BEADS = {"name": "beads", "material": "glass", "diameter_mm": 3}
SCENES: dict[str, dict[str, Any]] = {
    "no bridge forms": {
        "duration_s": 0.002, "materials": {"glass": {"density_kg_per_m3": 2500}}, "liquid": {"percent": 1},
        "spheres": [{**BEADS, "at_mm": [[0, 0, 2], [3.1, 0, 2]]}],
        "walls": [{"name": "tray", "block": {"low_mm": [-10, -10, -5], "high_mm": [10, 10, 0]}}],
    },
    "bridges shorter than a step's way": {
        "duration_s": 0.01, "materials": {"glass": {"density_kg_per_m3": 2500, "contact_angle_deg": 20}},
        "liquid": {"percent": 1.0e-9},
        "spheres": [{**BEADS, "count": 12, "box": {"low_mm": [-6, -6, 0.05], "high_mm": [6, 6, 14]}}],
        "walls": [{"name": "pan", "vessel": {"inner_width_mm": 13, "height_mm": 16}}],
    },
    "a liquid of hardly any surface tension": {  # whose bridges stretch beyond the box before they rupture
        "duration_s": 0.01, "materials": {"glass": {"density_kg_per_m3": 2500}},
        "liquid": {"percent": 1, "surface_tension_N_per_m": 1.0e-9},
        "spheres": [{**BEADS, "count": 12, "box": {"low_mm": [-6, -6, 0.05], "high_mm": [6, 6, 14]}}],
        "walls": [{"name": "pan", "vessel": {"inner_width_mm": 13, "height_mm": 16}}],
    },
    "a liquid of much viscosity": {  # the limit of a bridge falls with the speed, as at every turn of the pan
        "duration_s": 0.06, "materials": {"glass": {"density_kg_per_m3": 2500, "contact_angle_deg": 20}},
        "liquid": {"percent": 1, "viscosity_Pa_s": 1.4, "surface_tension_N_per_m": 0.063},
        "spheres": [{**BEADS, "count": 12, "box": {"low_mm": [-6, -6, 0.05], "high_mm": [6, 6, 14]}}],
        "walls": [{
            "name": "pan", "vessel": {"inner_width_mm": 13, "height_mm": 16},
            "vibrates": {"amplitude_mm": [0, 0, 1.5], "frequency_Hz": 50},
        }],
    },
    "spheres that are inserted later": {
        "duration_s": 0.02, "materials": {"glass": {"density_kg_per_m3": 2500}}, "liquid": {"percent": 1},
        "spheres": [{
            **BEADS, "count": 5, "box": {"low_mm": [-9, -9, 4], "high_mm": [9, 9, 12]},
            "velocity_m_per_s": [0, 0, -1], "insertion": {"from_s": 0.002, "for_s": 0.01},
        }],
        "walls": [{"name": "tray", "block": {"low_mm": [-20, -20, -5], "high_mm": [20, 20, 0]}}],
    },
    "outputs within an impact": {
        "duration_s": 0.012, "materials": {"steel": {"density_kg_per_m3": 7850}}, "liquid": {"film_um": 5},
        "spheres": [{
            "name": "ball", "material": "steel", "diameter_mm": 10, "at_mm": [[0, 0, 6]],
            "velocity_m_per_s": [0, 0, -2.2],
        }],
        "walls": [
            {"name": "plate", "block": {"low_mm": [-20, -20, -1], "high_mm": [20, 20, 0]}},
            {"name": "tray", "vessel": {"inner_width_mm": 50, "height_mm": 20, "origin_mm": [0, 0, -60]}},
        ],
    },
    "along the dry rim of a wet plate": {  # the film on top is the nearest only once the sphere has passed the edge
        "duration_s": 0.006, "materials": {"glass": {"density_kg_per_m3": 2500}}, "liquid": {"film_um": 40},
        "gravity_m_per_s2": [0, 0, 0],
        "spheres": [
            {**BEADS, "at_mm": [[-0.5, 0, 1.7]], "velocity_m_per_s": [0, 0, -1]},
            {**BEADS, "name": "passing", "at_mm": [[1.541, 0, -1.6]], "velocity_m_per_s": [0, 0, 0.5]},
        ],
        "walls": [
            {"name": "plate", "block": {"low_mm": [-2, -1, -6], "high_mm": [0, 1, 0]}},
            {"name": "box", "vessel": {"inner_width_mm": 40, "height_mm": 30, "origin_mm": [0, 0, -15]}},
        ],
    },
}  # fmt: skip
THIN_PLATE: dict[str, Any] = {
    "duration_s": 0.36, "materials": {"steel": {"density_kg_per_m3": 7850}}, "liquid": {"film_um": 5},
    "spheres": [{"name": "ball", "material": "steel", "diameter_mm": 10, "at_mm": [[0, 0, 255]]}],
    "walls": [
        {"name": "plate", "block": {"low_mm": [-20, -20, -1], "high_mm": [20, 20, 0]}},
        {"name": "tray", "vessel": {"inner_width_mm": 50, "height_mm": 20, "origin_mm": [0, 0, -60]}},
    ],
}  # fmt: skip
"""A ball of steel falls 0.25 m on a wet plate of 1 mm and is pressed into it."""
ONE_OF_EACH = {
    0: "a case whose bridges act every other step with semi-implicit drag, and form in a window",
    128: "a case whose films shed drops while its walls hold no films",
    31: "a sphere that rolls over the rim of a vessel, from the inner side to the outer one",
    10: "a case with two touching spheres of which one's spin is lost in the rounding of the other's kick",
    4: "a sphere in a turning tube whose spin is lost in the rounding of a drag's kick: rolling resistance has no direction",
    145: "the same of a case whose bridges act every other step",
    47: "a small bed at rest whose semi-implicit drag acts on the parts of spheres, which move more than the spheres do",
    151: "the same of spheres that fall on a vibrating vessel",
}


@pytest.mark.engine
@pytest.mark.parametrize("name", SCENES)
def test_scenes_that_raised_an_alarm(tmp_path: Path, name: str) -> None:
    """`pywet.run` raises where a check, the ledger or the replay objects; the replay has compared the liquid at all outputs."""
    run = pywet.run(pywet.Scene(name=name, **SCENES[name]), tmp_path)
    assert run.replay["quantities"]["ledger"]["count"] == len(run.scene.output_steps)
    assert read_json(tmp_path / "engine" / "run.json")["spheres"] == sum(c.count for c in run.scene.classes)
    link = chain.ledger(io.read(tmp_path))  # used for the diagnosis of a faulty run
    assert np.abs(link.logged - link.expected).max() <= link.tolerance * link.size.max()
    assert (len(run.events) == 0) == (name == "no bridge forms")


@pytest.mark.engine
def test_a_ball_falls_on_a_thin_plate(tmp_path: Path) -> None:
    """The work of its bridge is within the bound of the reference: half of what is allowed."""
    run = pywet.run(pywet.Scene(name="thin plate, moist", **THIN_PLATE), tmp_path)
    assert run.replay["quantities"]["energy_capillary"]["largest"] < 1.0 and len(run.events) > 0


@pytest.mark.engine
def test_results_of_a_run_with_an_objection_are_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`pywet run-scene` ends with 1 and the sentence, and has written tables, time series, picture and a page that is marked."""
    monkeypatch.setattr(verdict, "objections", lambda folder: ["check no_particle_lost failed: one is missing"])
    file = tmp_path / "scene.yaml"
    file.write_text(yaml.safe_dump({"name": "one", **SCENES["no bridge forms"]}))
    done = CliRunner().invoke(app, ["run-scene", str(file), "--out", str(tmp_path / "run")])
    output_text = " ".join(done.output.split())
    assert done.exit_code == 1 and "one is missing; all results are written and marked" in output_text
    made = {path.name for path in (tmp_path / "run").iterdir()}
    assert {"results", "summary.json", "replay.json", "vtk", "picture.png", "report.html"} <= made
    assert "one is missing" in (tmp_path / "run" / "report.html").read_text()


@pytest.mark.engine
@pytest.mark.parametrize("number", ONE_OF_EACH)
def test_short_runs(tmp_path: Path, number: int) -> None:
    sound_runs.simulate(number, tmp_path)
    assert sound_runs.alarms(tmp_path) == []


@pytest.mark.slow
@pytest.mark.engine
@pytest.mark.parametrize("number", range(200))
def test_two_hundred_runs(tmp_path: Path, number: int) -> None:
    """Expect no objection to a correct run; skip one that does not fit or that a sphere leaves."""
    try:
        sound_runs.simulate(number, tmp_path)
    except PywetError as error:
        pytest.skip(str(error))
    assert sound_runs.alarms(tmp_path) == []


def test_ledger_before_the_first_inserted_sphere() -> None:
    """Round-off before it is relative to all liquid that comes; a millionth of that lost at the end is a millionth."""
    none = [0.0, 0.0]
    ledger = pd.DataFrame(
        {
            "films": [0.0, 1e-9],
            "bridges": none,
            "walls": none,
            "left": none,
            "retired": none,
            "initial": [2.9e-23, 1e-9],
        }
    )
    assert ledger_error(ledger) == pytest.approx(2.9e-14)
    assert ledger_error(ledger.assign(films=[0.0, 1e-9 * (1.0 - 1e-6)])) == pytest.approx(1e-6, rel=1e-6)
    assert ledger_error(0.0 * ledger) == 0.0


def test_lives_of_no_bridges() -> None:
    """Expect no active bridge in an empty log, at any step."""
    whole = {name: np.zeros(0, np.int64) for name in ("step", "kind", "partner_kind", "i", "j")}
    real = {name: np.zeros(0) for name in ("volume", "rupture_distance", "speed")}
    lives = Lives(none(), pd.DataFrame({**whole, **real}), 0, -1)
    assert len(lives.active()) == len(lives.active(3)) == len(lives.previous) == 0


ENDS: dict[str, list[tuple[str, float]]] = {
    "materials": [
        ("friction", 0), ("friction", 5), ("rolling_friction_m", 0), ("rolling_friction_m", 1e-2), ("restitution", 1),
        ("restitution", 1e-3), ("contact_angle_deg", 0), ("contact_angle_deg", 89.9), ("surface_tension_N_per_m", 1e-9),
        ("viscosity_Pa_s", 0), ("viscosity_Pa_s", 0.05), ("density_kg_per_m3", 1), ("density_kg_per_m3", 1e5),
        ("residual_liquid_percent", 0), ("residual_liquid_percent", 100), ("z_amplitude_mm", 0), ("frequency_Hz", 1e-3),
        ("frequency_Hz", 1000), ("x_phase_deg", 0), ("poissons_ratio", 0), ("poissons_ratio", 0.5),
    ],
    "scales": [
        ("slide_opens_at_s", 0), ("slide_opens_at_s", 1), ("output_interval_s", 0.02), ("output_interval_s", 1e-5),
        ("wire_sides", 3), ("wire_sides", 4), ("wire_sides", 40), ("width_mm", 20), ("duration_s", 1e-4),
    ],
}  # fmt: skip
"""Values at the ends of what a case may have, and beyond; every entry of a file with that key gets the value."""
SHORT: dict[str, Any] = {
    "seed": 7, "ranks": 1, "preset": "paper", "effects": {}, "time_step": {},
    "output": {"energy": True, "contact_windows": 2, "checkpoints": 5},
    "scale": {
        "shape": "square", "width_mm": 40, "wire_sides": 6, "wires": "mesh", "stiffness_factor": 0.01, "duration_s": 0.02,
        "slide_opens_at_s": 0.01, "output_interval_s": 0.002,
    },
}  # fmt: skip


def test_a_component_that_counts_as_none_is_in_doubt() -> None:
    """A spin below 1e-13 of the kick is taken for none: by so much, and not by the rounding of the kick alone, it may be off."""
    dry = window.dry_contacts({"pairs": [], "time_step_s": 1e-5, "effects": {}}, {})
    one = np.ones(1)
    setup = window.Setup(
        Path(), {"time_step_s": 1e-5, "liquid": None, "effects": {}}, np.array([1]), one.astype(int), one, one, one > 0,
        dry, (), np.zeros((0, 3, 3)), np.zeros(0, int), np.zeros(1, int), np.full(1, 1 << 40), frozenset(),
    )  # fmt: skip
    torque, true = np.array([800.0, 0.0, 0.0]), np.array([0.0, 0.0, 3e-17])
    kick = 0.5 * 1e-5 / 0.4 * torque
    state = {name: np.zeros((1, 1, 3)) for name in "xvf"} | {"w": (true + kick)[None, None], "t": torque[None, None]}
    found = window._window(setup, np.array([5]), state, None)
    assert kick[0] == pytest.approx(1e-2) and found.w_half[0, 0, 2] == 0.0
    assert np.abs(found.w_half[0, 0] - true).max() <= found.w_margin[0, 0] <= 2e-13 * kick[0]


def test_rounding_of_positions_far_from_the_origin() -> None:
    """At a kilometre a position has 1.1e-13 m of rounding, a difference of two 4.4e-13 m; near the origin the radius decides."""
    far, near = newton._lost_digits(np.array([[1e3, 0.0, 0.0], [0.1, 0.0, 0.0]]))
    assert newton.DRIFT * far == pytest.approx(4.4e-13, rel=0.02) and near < 1e-3


def _put(node: Any, key: str, value: float) -> None:
    for name, below in node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ():
        if name == key and "value" in below:
            below["value"] = value
        else:
            _put(below, key, value)


@pytest.mark.slow
@pytest.mark.engine
@pytest.mark.parametrize(("file", "key", "value"), [(file, *row) for file, rows in ENDS.items() for row in rows])
def test_ends_of_ranges(tmp_path: Path, file: str, key: str, value: float) -> None:
    """A moist case with such a value is refused in a sentence before the engine runs, or raises no alarm."""
    folder = sound_runs._configuration(tmp_path / "config", SHORT)
    content = yaml.safe_load((folder / f"{file}.yaml").read_text())
    _put(content, key, value)
    (folder / f"{file}.yaml").write_text(yaml.safe_dump(content))
    try:
        cases.build(config.load(folder), 2, "short", tmp_path / "run")
        stages.simulate(tmp_path / "run", 1, progress=False)
    except StoppedRun:
        raise
    except PywetError:
        return
    (tmp_path / "run" / sound_runs.DONE).write_text('{"kind": "case"}')
    assert sound_runs.alarms(tmp_path / "run") == []
