"""The plan against everything on, in small scenes; what is off is not there; the study's judgement on made-up numbers."""

from __future__ import annotations

import math
import shutil
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from pywet import stages
from pywet.cases.small import small
from pywet.engines.liggghts import contact_model, inputs
from pywet.geometry.initial import wall_groups
from pywet.util.files import write_json
from studies.effects import page, study, variants, verdict
from studies.effects.scenes import CONFIG, SCENES
from studies.effects.study import EffectsStudy
from tests.engines.liggghts import beds

SMALL = {
    "collision": (1.0, 1),
    "fast_dilute": (0.3, 3),
    "thick_oil": (0.4, 1),
    "micron_powder": (0.2, 2),
    "dry_glass": (0.2, 1),
}
"""Scene -> size and number of first arrangements."""


def runs_of(name: str, wanted: set[str]) -> pd.DataFrame:
    """Some choices of effects of a scene with all its seeds."""
    size, seeds = SMALL[name]
    rows = []
    for seed in range(seeds):
        setup = SCENES[name].setup(seed, size, CONFIG)
        chosen = {v: e for v, e in variants.variants(setup).items() if v in wanted}
        for variant, effects in chosen.items():
            rows.append(
                {"scene": name, "seed": seed, "variant": variant, **variants.measure(SCENES[name], setup, effects)}
            )
    return pd.DataFrame(rows)


@pytest.mark.engine
@pytest.mark.parametrize(
    ("name", "left_out"),
    [
        (
            "collision",
            {"capillary", "viscous_tangential", "dynamic_rupture", "wall_films", "sharing_by_size", "gravity"},
        ),
        ("fast_dilute", {"bridges"}),
        ("thick_oil", {"viscous_normal", "viscous_tangential", "dynamic_rupture"}),
        ("micron_powder", {"dynamic_rupture"}),
        ("dry_glass", set()),
    ],
)
def test_the_plan_is_right(name: str, left_out: set[str]) -> None:
    """No wanted quantity changes by more than the tolerance beyond twice the standard error over the first arrangements."""
    size, _ = SMALL[name]
    setup = SCENES[name].setup(0, size, CONFIG)
    made = variants.plan_of(setup, decide="tolerance")
    on = {row.effect for row in variants.plan_of(setup).rows if row.on}
    out = {row.effect for row in made.rows if row.effect in on and not row.on}
    assert left_out - on <= {"wall_films", "sharing_by_size", "gravity"}
    assert left_out & on <= out, made.lines
    runs = runs_of(name, {variants.EVERYTHING, variants.PLANNED, variants.IDLE})
    judged = verdict.choices(runs)
    plan = next(c for c in judged if c.variant == variants.PLANNED)
    assert plan.harmless, plan.worst
    for quantity in plan.changes:
        # a spread above half of a quantity would hide the effect
        assert quantity.spread < 0.5, quantity
    if name == "dry_glass":
        stock, idle = (runs[runs["variant"] == v].iloc[0] for v in (variants.EVERYTHING, variants.IDLE))
        for quantity in ("mean_height", "contacts_per_sphere"):
            assert stock[quantity] == idle[quantity]  # bit for bit: a plugin without liquid changes nothing
        assert not stock["plugin"] and stock["plugin_arrays_B"] == 0 and stock["shares"] is None
        assert stock["peak_memory_B"] < 0.5 * idle["peak_memory_B"]  # 46 and 341 MB


@pytest.mark.parametrize("name", ["moist_pom", "wet_drum", "screening"])
def test_a_scene_that_needs_everything_gets_it(name: str) -> None:
    """Water on beads that meet walls and each other: no number is below two per cent."""
    setup = SCENES[name].setup(0, 1.0, CONFIG)
    assert variants.plan_of(setup, decide="tolerance").effects == variants.plan_of(setup).effects


@pytest.mark.engine
def test_sharing_and_walls_off_are_cross_checked(tmp_path: Path) -> None:
    """Half to either side, no bridge with a wall, and the independent replay agrees with every event and force."""
    scene = beds.prepare(tmp_path, beds.bed((4, 4, 3)), 1500)
    effects = scene.effects.model_copy(update={"transfer": "half", "wall_films": False})
    scene = scene.model_copy(update={"effects": effects})
    write_json(tmp_path / "scene.json", scene.model_dump(mode="json"))
    small.run(tmp_path, [])
    events = pd.read_parquet(tmp_path / "history" / "events.parquet")
    broken = events[events["kind"] == 1]
    assert len(broken) >= 2 and (events["partner_kind"] == 0).all()
    assert (broken["share_i"] == broken["share_j"]).all()
    replayed = stages.replay(tmp_path)
    assert replayed is not None and replayed["ok"] and not replayed.get("unchecked")
    assert pd.read_parquet(tmp_path / "history" / "ledger.parquet")["walls"].max() == 0.0


def test_what_is_off_is_not_instantiated(tmp_path: Path) -> None:
    """Walls off: stock meshes without sums of force, no wall rows of transfer; halves: two nodes a row instead of 201.

    Nor are there sums of force where the plugin makes the contacts with walls.
    """
    scene = beds.prepare(tmp_path, beds.bed((2, 2, 2)), 100)
    assert {contact_model.mesh_style(scene, w) for w in scene.walls} == {"mesh/surface"}
    scene = scene.model_copy(update={"contacts": "batched"})
    off = scene.effects.model_copy(
        update={"transfer": "half", "wall_films": False, "tangential_history": False, "rolling": False}
    )
    bare = scene.model_copy(update={"effects": off})
    assert {contact_model.mesh_style(scene, w) for w in scene.walls} == {"mesh/surface/stress"}
    assert {contact_model.mesh_style(bare, w) for w in bare.walls} == {"mesh/surface"}
    assert len(inputs.transfer_tables(scene)) == 201 * (4 + 2 * len(wall_groups(scene)))
    assert len(inputs.transfer_tables(bare)) == 2 * 4
    properties = contact_model.property_matrices(bare)
    assert "coefficientRollingFriction" not in properties
    drag = float(properties["gammat_abs"].split()[0])
    # half the stability limit of a dense packing with spin: c < 2/7 m_eff/(4 dt)
    assert drag == pytest.approx(0.5 * 2 / 7 * 0.5 * scene.classes[0].mass_kg / (4 * scene.time_step_s))
    assert set(contact_model.property_matrices(scene)["gammat_abs"].split()) == {"0.0"}


def row_of(variant: str, seed: int, value: float, time: float, on: bool = True) -> dict[str, Any]:
    effects = {"bridges": True, "capillary": "rabinovich" if on else None, "rolling": True, "tangential_history": True,
               "gravity": True, "transfer": "parabola", "wall_films": True, "viscous_normal": "pitois",
               "viscous_tangential": "goldman", "dynamic_rupture": "pitois"}  # fmt: skip
    rows = [
        {"effect": e, "predicted_share": 0.25} for e in ("gravity", "capillary", "viscous_normal", "viscous_tangential")
    ]
    return {
        "scene": "moist_pom", "seed": seed, "variant": variant, "effects": effects, "mean_height": value,
        "cpu_s": time, "loop_cpu_s": time, "wall_s": time, "steps": 100, "spheres": 10, "plugin": True, "peak_memory_B": 10**8,
        "plugin_arrays_B": 1000, "shares": {r["effect"]: 0.25 for r in rows}, "plan": rows,
    }  # fmt: skip


def made_up(change: float, scatter: float) -> pd.DataFrame:
    rows = []
    for seed, wobble in enumerate((-scatter, 0.0, scatter)):
        rows.append(row_of(variants.EVERYTHING, seed, 1.0, 2.0))
        rows.append(row_of(variants.PLANNED, seed, 1.0 + change + wobble, 1.0, on=False))
        rows.append(row_of("no capillary", seed, 1.0 + change + wobble, 1.0, on=False))
    return pd.DataFrame(rows)


def test_judgement_by_hand() -> None:
    """Half the time is a saving of 50 %. -s, 0, s over three seeds have the variance s²; of two degrees of freedom the median is
    ln 2 of the true one, so that the spread is twice sqrt(s²/ln 2/3).
    """
    plan = verdict.choices(made_up(0.05, 0.01))[0]
    assert plan.worst.change == pytest.approx(0.05) and plan.worst.spread == pytest.approx(
        0.02 / (3 * math.log(2)) ** 0.5
    )
    assert not plan.harmless and plan.saving == pytest.approx(0.5)
    assert verdict.choices(made_up(0.02, 0.0))[0].worst.sure == pytest.approx(0.02)
    assert verdict.choices(made_up(0.019, 0.0))[0].harmless
    assert verdict.left_out(made_up(0.0, 0.0)) == ["capillary"]


def test_page_from_runs(tmp_path: Path) -> None:
    """Cards, matrix and verdict follow from the runs' rows alone, and a wrong plan is called wrong."""
    runs = {"moist_pom": made_up(0.3, 0.0)}
    judged = {"moist_pom": verdict.choices(runs["moist_pom"])}
    text = page.write_page(tmp_path / "effects.html", runs, judged).read_text()
    assert "0 of 1" in text and 'class="bad">wrong' in text and "+30.00 %" in text
    assert study.result(runs, judged)["scenes"]["moist_pom"]["plan_right"] is False
    assert "WRONG" in study.line("moist_pom", runs["moist_pom"], verdict.planned(judged["moist_pom"]))


def test_what_is_stored_belongs_to_configuration_and_size(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An edited number of the materials, or another size, and the runs that follow from it are done again; others stay."""
    monkeypatch.setattr(study, "measure", lambda scene, setup, effects: {"effects": effects.model_dump()})
    shutil.copytree(CONFIG, tmp_path / "config")

    def missing(size: float) -> set[str]:
        """Do what is missing of two scenes; the scenes it was missing of."""
        now = EffectsStudy(tmp_path / "effects", 1, size, None, tmp_path / "config")
        done: set[str] = set()
        for job in ("screening_0", "collision_0"):
            now.do(job, lambda name, share: done.add(name.split("_")[0]))
            assert len(now.gather([job])) == len(now.runs(job))
        return done

    assert missing(1.0) == {"screening", "collision"}
    assert missing(1.0) == set()
    materials = tmp_path / "config" / "materials.yaml"
    text = materials.read_text()
    materials.write_text(text.replace("viscosity_Pa_s: {value: ", "viscosity_Pa_s: {value: 2", 1))
    assert materials.read_text() != text
    assert missing(1.0) == {"screening"}  # the only scene taken from the configuration
    assert missing(0.5) == {"screening", "collision"}


@pytest.mark.parametrize("name", ["dry_glass", "moist_pom", "micron_powder"])
@pytest.mark.parametrize("seed", range(6))
def test_no_bed_begins_with_spheres_in_the_floor(name: str, seed: int) -> None:
    """A floor that a sphere begins in throws it up, and through its column the topmost one out of the box."""
    setup = SCENES[name].setup(seed, 1.0, CONFIG)
    radius = {c.type: c.radius_m for c in setup.classes}
    assert min(s.position[2] - radius[s.kind] for s in setup.spheres) > -1e-15
