"""The comparison of a page's lines with an output notices what it has to notice."""

from __future__ import annotations

import math

import pytest

from tests.shown_output import is_output, lines_of, same_line

PRINTED = ["12 spheres in 3.5 s", "law a 1.5 +2 %", "law b 2.5 -1e-3 %", "written to /tmp/x/report.html"]


@pytest.mark.parametrize(
    "shown",
    [
        PRINTED,
        ["12 spheres in 80 min", "…"],
        ["…", "law b 2.5 …", "…"],
        ["…", "written to /home/of/another/report.html"],
        ["12 … in …", "law … 1.5 …", "law b 2.5 … %", "…"],
        ["12 spheres …", "law a 1.5 +2 %", "law b 2.5 -1e-3 %", "…", "written to /x"],
    ],
)
def test_an_abridged_output_is_recognised(shown: list[str]) -> None:
    assert is_output(shown, PRINTED)


@pytest.mark.parametrize(
    "shown",
    [
        PRINTED[:-1],  # the end is missing, without a mark
        [PRINTED[0], PRINTED[2], "…"],  # a line between is missing
        ["…", PRINTED[2], PRINTED[1], "…"],  # another order
        ["13 spheres in 3.5 s", "…"],
        ["12 spheres in 3.5 m", "…"],
        ["…", "law b 2.5 1e-3 %", "…"],
        ["…", "law b 2.50001 …", "…"],
        ["…", "no such line", "…"],
    ],
)
def test_another_output_is_noticed(shown: list[str]) -> None:
    assert not is_output(shown, PRINTED)


def test_numbers_of_a_run_agree_within_the_tolerance() -> None:
    assert same_line("12,158 formed, 64.9 %", "12300 formed, 65.1 %", 0.02)
    assert not same_line("12,158 formed, 64.9 %", "12300 formed, 55 %", 0.02)
    assert same_line("12,158 formed, 64.9 %", "1 formed, 0 %", math.inf)
    assert not same_line("12,158 formed, 64.9 %", "1 ruptured, 0 %", math.inf)


def test_tables_are_compared_without_their_rules() -> None:
    assert lines_of("┏━━━┳━━━┓\n┃ a ┃ b ┃\n└───┴───┘\n") == ["a b"] == lines_of("\n  a   b\n")
