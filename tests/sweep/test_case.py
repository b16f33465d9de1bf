"""A screening case as base: keys of its configuration, of its row and its scale; fingerprints of `pywet run`; mistakes."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import pytest

from pywet import config as settings
from pywet import stages
from pywet.cost import needs
from pywet.sweep import plan, run_numbers, running
from pywet.sweep.base_kind import stored_name
from pywet.sweep.case_base import OfCase
from pywet.sweep.plan import Plan
from tests.error_codes import raises_code
from tests.sweep.files import EXAMPLES, WALL, write

CONFIG = EXAMPLES.parent / "config"
CASE: dict[str, Any] = {
    "name": "moisture", "base": {"case": 2, "config": str(CONFIG), "scale": "smoke"},
    "axes": {"case.liquid_percent": [2.5, 5.0]}, "seeds": 2,
}  # fmt: skip


def asked(folder: Path, **changes: Any) -> Plan:
    return plan.read(write(folder, {**CASE, **changes}), folder / "out", folder / "store")


def test_the_name_of_a_point_is_made_of_the_fingerprint_that_pywet_run_gives_it(tmp_path: Path) -> None:
    """The case as configured with both seeds, among the points; the other moisture has others."""
    loaded = settings.load(CONFIG)
    seeds = [loaded.with_seed(loaded.settings.seed + k) for k in range(2)]
    words = [stages.fingerprint(one, 2, "smoke") for one in seeds]
    found = [run.built.name for run in asked(tmp_path).runs]
    assert found[2:] == [stored_name("case", word, run_numbers.__file__) for word in words] and len(set(found)) == 4


@pytest.mark.parametrize(("given", "used"), [(None, 2), (1, 1)])
def test_configured_ranks_count_unless_others_are_given(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, given: int | None, used: int
) -> None:
    """Each run starts as many ranks, and needs their memory or that of its replay; other bases have one rank."""
    shutil.copytree(CONFIG, folder := tmp_path / "config")
    text = (folder / "config.yaml").read_text()
    (folder / "config.yaml").write_text(text.replace("ranks: 1", "ranks: 2"))
    of, started = asked(tmp_path, base={**CASE["base"], "config": str(folder)}), []
    monkeypatch.setattr(OfCase, "run", lambda kind, built, run, ranks: started.append(ranks) or {})
    running.carry_out(of, of.runs, ranks=given)
    assert started == [used] * 4
    need = needs.need(settings.load(CONFIG), 2, "smoke", ranks=2)
    memory = [plan.kind.cost(plan.runs[2].built).memory_B for plan in (of, asked(tmp_path))]
    assert memory == [need.memory_B, need.replay_B]  # the job also replays, which takes more memory than one rank
    assert plan.read(write(tmp_path, WALL), tmp_path / "w", tmp_path / "store").kind.ranks == 1


@pytest.mark.parametrize(
    ("axis", "value", "of"),
    [
        ("liquid.surface_tension_N_per_m", 0.05, lambda c: c.materials.liquid.surface_tension_N_per_m.value),
        ("materials.yaml: feed sieve_diameter_mm value", 150, lambda c: c.materials.feed.sieve_diameter_mm.value),
        ("scale.duration_s", 1.0, lambda c: c.scale("smoke").duration_s.value),
        ("contacts.1.friction", 0.25, lambda c: c.materials.contact("POM", "POM").friction.value),
        ("config.laws.capillary", "willett", lambda c: c.settings.laws.capillary),
        ("laws.capillary", "willett", lambda c: c.settings.laws.capillary),
        ("case.set_amplitude_mm", 0.8, lambda c: c.case(2).set_amplitude_mm),
        ("effects.gravity", False, lambda c: c.settings.effects.gravity),
    ],
)
def test_a_key_of_any_file_of_the_configuration_is_an_axis(tmp_path: Path, axis: str, value: Any, of: Any) -> None:
    plain = asked(tmp_path)
    kind = plain.kind
    changed = kind.built({axis: value}, 0)
    assert of(changed.given[0]) == value
    assert changed.name != kind.built({}, 0).name


@pytest.mark.parametrize(
    ("changes", "code", "says"),
    [
        ({"axes": {"case.liquid_percent": [5.0, 101.0]}}, "config.value", "point 2 (case.liquid_percent 101): "),
        ({"axes": {"frequency": [50.0]}}, "sweep.axis_file", ""),
        ({"axes": {"liquid.surface_tension_N_per_m": [72.8]}}, "config.implausible", "surface_tension_N_per_m.value is 72.8"),
        ({"axes": {"materials.spheres.POM.contact_angle_deg": [95]}}, "case.not_wetted", ""),
        ({"axes": {"scale.stiffnes_factor": [0.1]}}, "config.unknown_key", ""),
        ({"axes": {"laws.capillary": ["wilett"]}}, "law.not_of_kind", "wilett"),
        ({"axes": {"scale": ["smoke", "reduced"]}}, "config.inconsistent", "axis scale cannot be varied in a sweep of case 2; "),
        ({"axes": {"config.scale": ["reduced"]}}, "config.inconsistent", "expected scale in base"),
        ({"axes": {"scales.scales.reduced.duration_s": [2.0]}}, "config.inconsistent", "expected a key of scale smoke"),
        ({"axes": {"config.yaml: cases 0": [3]}}, "config.inconsistent", "expected case in base"),
        ({"axes": {"case.case": [3]}}, "config.inconsistent", "expected case in base"),
        ({"axes": {"seeds": [1, 2]}}, "config.inconsistent", "expected the key seeds of the sweep"),
        ({"axes": {"config.seed": [1, 2]}}, "config.inconsistent", "expected the key seeds of the sweep"),
        ({"axes": {"ranks": [1, 2]}}, "config.inconsistent", "expected the option --ranks"),
        ({"axes": {"both_presets": [True]}}, "config.inconsistent", "expected the axis laws.preset"),
        ({"base": {**CASE["base"], "case": 99}}, "config.unknown_name", "case 99"),
        ({"base": {**CASE["base"], "scale": "huge"}}, "config.unknown_name", "scale huge"),
        ({"gather": ["fraction_retained"]}, "sweep.unknown_result", "fraction_retained_end"),
    ],
)  # fmt: skip
def test_a_mistake_in_a_case_is_one_sentence(tmp_path: Path, changes: dict[str, Any], code: str, says: str) -> None:
    with raises_code(code, re.escape(says)) as caught:
        of = asked(tmp_path, **changes)
        _ = of.runs
        of.cost()
    assert "\n" not in str(caught.value), caught.value


def test_cost_is_that_of_the_plan_and_disk_counts_every_run(tmp_path: Path) -> None:
    from pywet.sweep.costs import FILES_B, FINISHING_S, FINISHING_S_PER_B

    of = asked(tmp_path)
    costs = of.cost()
    five = [cost for run, cost in costs if run.point.number == 2]
    need = needs.need(settings.load(CONFIG), 2, "smoke")
    assert len(costs) == 4 and five[0].disk_B == need.disk_B + FILES_B
    assert five[0].seconds == pytest.approx(need.seconds + FINISHING_S + FINISHING_S_PER_B * need.disk_B)
    lines = plan.lines(of, costs, cores=2)
    assert lines[0] == "moisture: 2 points, 4 runs (2 seeds)"
    assert lines[1].startswith("0 are in the store, 4 to run: ")
    assert "core-hours" in lines[1] and lines[1].endswith("GB")
    assert plan.lines(of, costs[:1], cores=2)[1].startswith("3 are in the store, 1 to run: ")
