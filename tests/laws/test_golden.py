"""Golden table: every law against values evaluated outside pywet: its equation with 40 digits, an exact shape, another solver."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest

from pywet.laws import registry

TABLE = Path(__file__).parents[1] / "data" / "law_values.csv"
with TABLE.open() as stream:
    ROWS = list(csv.DictReader(stream))


def arguments(row: dict[str, str]) -> dict[str, float]:
    return {name: float(value) for name, value in (item.split("=") for item in row["arguments"].split(";"))}


def evaluate(row: dict[str, str]) -> float:
    given = arguments(row)
    if row["kind"] == "transfer":
        grid, kind = np.array([given.pop("v_star")]), int(given.pop("kind"))
        return float(registry.transfer_model(row["law"])(**given, kind=kind, v_star=grid)[0])
    functions = {f.name: f for f in registry.get(row["kind"], row["law"]).functions}
    function = functions[row["function"]]
    assert tuple(given) == function.arguments  # the table and the laws name the same arguments in the same order
    return float(function(*given.values()))


@pytest.mark.parametrize("row", ROWS, ids=lambda r: f"{r['function']}-{r['arguments'][:40]}")
def test_law_has_the_value_of_its_equation(row: dict[str, str]) -> None:
    # tolerance of the row: 1e-12 allows for the rounding of about ten operations and of cancelling subtractions
    assert evaluate(row) == pytest.approx(float(row["value"]), rel=float(row["relative_tolerance"]), abs=1e-300)


def test_every_built_in_function_has_ten_values() -> None:
    names = [f.name for kinds in registry.BUILT_IN.values() for law in kinds.values() for f in law]
    names += ["transfer_table", "exact_table"]
    counts = {name: sum(row["function"] == name for row in ROWS) for name in names}
    assert min(counts.values()) >= 10, counts
    assert all(math.isfinite(float(row["value"])) and row["source"] for row in ROWS)
