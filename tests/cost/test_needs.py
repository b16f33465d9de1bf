"""What a run asks of a machine, compared with runs that were made."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from pywet import config
from pywet.cost import needs

CONFIG = config.load(Path(__file__).parents[2] / "config")


def test_tables_of_a_smoke_case_take_what_is_reported() -> None:
    """Smoke case 2 wrote 24,648 events and 34,335 contacts (docs/replay.md), 82 and 209 bytes each, and two windows of 20 steps
    of 335 spheres: 12 MB to within a factor of two, which a disk that is asked for has to allow."""
    reported = needs.need(CONFIG, 2, "smoke").disk_B
    assert 0.5 < reported / (24_648 * 82 + 34_335 * 209 + 2 * 40 * 335 * 146) < 2.0


def test_what_is_asked_of_a_cluster_doubles_with_each_attempt() -> None:
    one = needs.need(CONFIG, 8, "full")
    assert [one.minutes(k) for k in (2, 3)] == [2 * one.minutes(), 4 * one.minutes()]
    assert one.memory_mb(2) == 2 * one.memory_mb()
    assert one.minutes() > one.seconds / 60.0 and one.memory_mb() > one.memory_B / 1e6


@pytest.mark.parametrize("slower", [1.0, 40.0])
def test_campaign_counts_every_seed_and_the_run_of_another_preset(
    slower: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On a slow machine too: 1020 core-hours were once printed as 1.02e+03."""
    one = needs.need
    monkeypatch.setattr(needs, "need", lambda *a: replace(one(*a), seconds=slower * one(*a).seconds))
    several = CONFIG.settings.model_copy(update={"seeds": 3})
    output_text = {}
    for chosen in (CONFIG, config.Config(CONFIG.folder, several, CONFIG.materials, CONFIG.scales, CONFIG.cases)):
        last = needs.campaign(chosen, "full")[-2]
        runs, hours, tables = re.findall(r"(\d+) runs.*?([\d.]+) core-hours.*?([\d.]+) GB of tables", last)[0]
        output_text[chosen.settings.seeds] = int(runs), float(hours), float(tables)
    assert (output_text[1][0], output_text[3][0]) == (19, 57)
    assert output_text[3][1] == pytest.approx(3 * output_text[1][1], rel=0.01) and output_text[3][2] == pytest.approx(
        3 * output_text[1][2], rel=0.1
    )


def test_spheres_that_are_retired_cost_nothing() -> None:
    """Expect that 0.93 (20.1 - 3.3)/20.1 of the time loop of case 2 at full scale is saved; its start, some seconds, is not."""
    stored = needs.need(CONFIG.without_retirement(), 2, "full").seconds
    assert needs.need(CONFIG, 2, "full").seconds == pytest.approx((1.0 - 0.93 * 16.8 / 20.1) * stored, rel=0.02)
