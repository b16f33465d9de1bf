"""The decorator: address and Python agree, arrays broadcast, bad laws are refused, docstrings tell the truth."""

import ctypes
import doctest
import inspect
import itertools
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pywet.laws import registry, transfer
from pywet.laws.force_law import PROBE, ForceLaw, check, force_law
from pywet.laws.kinds import KINDS
from pywet.laws.young_laplace import TableLaw
from tests.error_codes import raises_code

BUILT_IN = [
    (function, part.arguments)
    for kind, laws in registry.BUILT_IN.items()
    for functions in laws.values()
    for function, part in zip(functions, KINDS[kind].parts, strict=True)
]
DYNAMIC = KINDS["dynamic_rupture"].parts[0].arguments
each_law = pytest.mark.parametrize(("law", "wanted"), BUILT_IN, ids=lambda x: x.name if isinstance(x, ForceLaw) else "")


@each_law
def test_what_is_no_number_is_refused(law: ForceLaw, wanted: tuple[str, ...]) -> None:
    """In each argument, alone or in an array: some laws took it for 0 or for their limit by their comparisons."""
    sound = {name: PROBE[name][0] for name in wanted}
    for name in wanted:
        for value in (math.nan, np.array([sound[name], math.nan])):
            with raises_code("law.argument_nan", key=name):
                law(**{**sound, name: value})


@pytest.mark.parametrize(
    ("law", "wanted"),
    [
        (law, wanted) for law, wanted in BUILT_IN if not isinstance(law, TableLaw)
    ],  # those are compiled only: test_table.py
    ids=lambda x: x.name if isinstance(x, ForceLaw) else "",
)
def test_c_function_equals_the_python_function(law: ForceLaw, wanted: tuple[str, ...]) -> None:
    c_function = ctypes.CFUNCTYPE(ctypes.c_double, *[ctypes.c_double] * len(wanted))(law.address)
    for values in itertools.product(*(PROBE[name] for name in wanted)):
        # 1e-14: the compiler may contract a multiplication and an addition
        assert c_function(*values) == pytest.approx(law.python(*values), rel=1e-14, abs=1e-300)


@each_law
def test_arrays_equal_scalars(law: ForceLaw, wanted: tuple[str, ...]) -> None:
    # each pair of contact angles requires a table
    one_pair = {"contact_angle_i": [0.2], "contact_angle_j": [0.5]} if isinstance(law, TableLaw) else {}
    grid = np.array(list(itertools.product(*(one_pair.get(name, PROBE[name][-2:]) for name in wanted)))).T
    assert law(*grid).tolist() == [law(*column) for column in grid.T]


@each_law
def test_built_in_laws_pass_the_probe(law: ForceLaw, wanted: tuple[str, ...]) -> None:
    check(law, wanted)
    assert law.address == law.address != 0


def test_scalars_give_a_float_and_shapes_broadcast() -> None:
    law = registry.get("dynamic_rupture", "pitois").functions[0]
    assert type(law(1.0, 1e-3, 0.07)) is float
    assert law(np.ones((3, 1)), 1e-3, np.ones(4)).shape == (3, 4)


@pytest.mark.parametrize("name", [f.name for f, _ in BUILT_IN])
def test_numbers_in_docstrings(name: str) -> None:
    law = next(f for f, _ in BUILT_IN if f.name == name)
    test = doctest.DocTestParser().get_doctest(law.__doc__ or "", {name: law, "math": math}, name, None, None)
    assert len(test.examples) == 1
    assert doctest.DocTestRunner(verbose=False).run(test).failed == 0


def test_numbers_in_the_transfer_docstring() -> None:
    assert doctest.testmod(transfer) == doctest.TestResults(failed=0, attempted=2)


def not_a_number(speed: float, viscosity: float, surface_tension: float) -> float:
    return float(np.sqrt(-1.0 - speed))


def infinite(speed: float, viscosity: float, surface_tension: float) -> float:
    return viscosity / speed


def raising(speed: float, viscosity: float, surface_tension: float) -> float:
    if speed > 0.0:
        raise ValueError("too fast")
    return 1.0


def misspelt(speed: float, viscosity: float, surface_tension: float) -> float:
    return speed * viscosty  # type: ignore[name-defined]  # noqa: F821


def no_float(speed: float, viscosity: float, surface_tension: float) -> float:
    return (speed, 1.0)  # type: ignore[return-value]


def other_arguments(speed: float, viscosity: float) -> float:
    return speed * viscosity


@pytest.mark.parametrize(
    ("function", "code"),
    [
        (not_a_number, "law.value"),
        (infinite, "law.value"),
        (raising, "law.raises_on_grid"),
        (misspelt, "law.not_compiled"),
        (no_float, "law.not_compiled"),
        (other_arguments, "law.arguments"),
    ],
)
def test_bad_law_is_refused_in_one_sentence(function: Callable[..., float], code: str) -> None:
    with raises_code(code) as refusal:
        check(force_law(function), DYNAMIC)
    text = str(refusal.value)
    assert f"law {function.__name__} " in text
    assert "\n" not in text
    assert __file__ in text  # the file to be fixed


def test_law_without_a_file_works() -> None:
    """A law typed at a prompt or in a notebook has no file next to which numba could keep it."""
    space: dict[str, Callable[..., float]] = {}
    exec("def typed(speed, viscosity, surface_tension):\n    return 1.0 + speed", space)
    assert force_law(space["typed"])(0.5, 1.0, 1.0) == 1.5


@each_law
def test_arguments_go_by_name_in_any_order(law: ForceLaw, wanted: tuple[str, ...]) -> None:
    """The signature is that of the function below the decorator; names give what places give."""
    assert tuple(inspect.signature(law).parameters) == wanted and law.__doc__
    named = {name: PROBE[name][-1] for name in wanted}
    if not isinstance(law, TableLaw):
        assert law(**dict(reversed(named.items()))) == law(*named.values())
    with raises_code("law.order"):
        law()
    with raises_code("law.order"):
        law(**named, gap=0.0)


def test_the_laws_of_the_page(capsys: pytest.CaptureFixture[str]) -> None:
    """At touch pi sigma r (cos + cos) + 2 pi sigma r sin(phi) sin(phi + theta); a wall has twice the first term."""
    page = (Path(__file__).parents[2] / "docs" / "laws.md").read_text()
    text = page.split("## From Python")[1].split("```python\n")[1].split("```")[0]
    exec(compile(text, "page", "exec"), {})
    around = 2 * math.pi * 0.07 * 1e-3
    lines = capsys.readouterr().out.splitlines()
    for line, times in zip(lines, (1, 2), strict=False):
        phi = math.sqrt(2 * math.sqrt(times * 1e-10 / (2 * math.pi * 1e-3)) / 1e-3)
        want = around * (times * math.cos(0.3) + math.sin(phi) * math.sin(phi + 0.3))
        assert float(line.split()[0]) == pytest.approx(want, rel=1e-3)
    at_touch, apart = map(float, lines[2].strip("[]").split())
    assert at_touch > apart > 0
