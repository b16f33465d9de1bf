"""Laws in batches give the values of the laws alone, in every place of a batch; their mathematics is the C library's."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from pathlib import Path

import numba
import numpy as np
import pytest

from pywet.engines.liggghts.plugin_api import loops
from pywet.laws import batch_math, registry
from pywet.laws.batch import BATCH, ROWS, batch
from pywet.laws.force_law import ForceLaw, force_law
from pywet.laws.kinds import FORCES, KINDS, PRESETS
from pywet.laws.young_laplace import prepare

BOTH_SIGNS = ("weigert", "weigert_as_printed", "soulie", "goldman", "lian", "buck")
"""Laws with values of both signs or cut at zero, where digits cancel: a value counts as at least a hundredth of the largest."""
LAWS = [(kind, name) for kind in FORCES for name in registry.BUILT_IN[kind]]
GIVEN = {"surface_tension": 0.07, "viscosity": 2e-3}
ANGLES = [(0.2, 0.5), (0.5, 0.2), (0.0, 0.0)]
CALL = ctypes.CFUNCTYPE(
    None, ctypes.c_int64, ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p
)


def bridges(n: int, seed: int) -> np.ndarray:
    """Rows of n random bridges, (len(ROWS), n): gaps from overlap to beyond rupture, V* from 1e-7 to 0.3, spheres and walls."""
    rng = np.random.default_rng(seed)
    radius_i, radius_j = rng.uniform(0.5e-3, 5e-3, (2, n))
    radius_j[rng.random(n) < 0.3] = math.inf
    volume = 10 ** rng.uniform(-7, -0.5, n) * np.minimum(radius_i, radius_j) ** 3
    separation = rng.uniform(-0.05, 1.3, n) * volume ** (1 / 3)
    separation[rng.random(n) < 0.1] = 0.0
    small, large = np.array(ANGLES)[rng.integers(0, len(ANGLES), n)].T
    swap = radius_i > radius_j
    angles = np.where(swap, large, small), np.where(swap, small, large)
    return np.array([separation, volume, radius_i, radius_j, *angles, rng.normal(0.0, 0.3, n)])


def alone(law: ForceLaw, rows: np.ndarray) -> np.ndarray:
    """The law's own compiled function, one bridge after the other."""
    c_function = ctypes.CFUNCTYPE(ctypes.c_double, *[ctypes.c_double] * len(law.arguments))(law.address)
    given = [rows[ROWS.index(name)] if name in ROWS else np.full(rows.shape[1], GIVEN[name]) for name in law.arguments]
    return np.array([c_function(*values) for values in zip(*given, strict=True)])


def together(functions: tuple[ForceLaw, ...], rows: np.ndarray) -> np.ndarray:
    """All bridges as one batch, (functions, n)."""
    n = rows.shape[1]
    block, out = np.full((len(ROWS), BATCH), math.nan), np.full((len(functions), BATCH), math.nan)
    block[:, :n] = rows
    address = np.zeros(BATCH, dtype=np.int64)
    prepared = functions[0].prepared
    numbers = np.zeros((BATCH, 8 * prepared.lines if prepared else 0))
    if prepared:
        fill = ctypes.CFUNCTYPE(None, *[ctypes.c_double] * 5, ctypes.c_void_p)(prepared.compiled.address)
        for k in range(n):
            address[k] = numbers[k].ctypes.data
            fill(*rows[1:6, k], int(address[k]))
    pointers = (x.ctypes.data for x in (address, out))
    CALL(batch(functions).address)(n, block.ctypes.data, GIVEN["surface_tension"], GIVEN["viscosity"], *pointers)
    return out[:, :n]


@pytest.fixture(autouse=True, scope="module")
def tables() -> None:
    """Exact bridges of these angles are at hand."""
    prepare(ANGLES)


@pytest.mark.parametrize(("kind", "name"), LAWS)
def test_a_batch_gives_the_values_of_the_law(kind: str, name: str) -> None:
    """640 random bridges: within 1e-13 of the value."""
    functions = registry.get(kind, name).functions
    assert batch(functions).inlined
    for seed in range(10):
        rows = bridges(BATCH, seed)
        for function, found in zip(functions, together(functions, rows), strict=True):
            wanted = alone(function, rows)
            size = np.abs(wanted)
            assert np.isfinite(wanted).all() and size.max() > 0.0
            if name in BOTH_SIGNS:
                size = np.maximum(size, 1e-2 * size.max())
            assert (np.abs(found - wanted) <= 1e-13 * size).all()


@pytest.mark.parametrize(("kind", "name"), LAWS)
def test_a_value_does_not_depend_on_its_place(kind: str, name: str) -> None:
    """Alone, in batches of all lengths, in turned order: the same bits. So ranks and restarts cannot change a force."""
    functions = registry.get(kind, name).functions
    rows = bridges(BATCH, 99)
    whole = together(functions, rows)
    assert np.array_equal(together(functions, rows[:, ::-1])[:, ::-1], whole)
    for n in (*range(1, 20), 31, 33, 63):
        assert np.array_equal(together(functions, rows[:, :n]), whole[:, :n])
        assert np.array_equal(together(functions, rows[:, -n:]), whole[:, -n:])


@pytest.mark.parametrize(("kind", "name"), [("capillary", "rabinovich"), ("capillary", "young_laplace")])
def test_the_laws_of_the_presets_are_vectorised(kind: str, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The code holds vector instructions and calls no function of the C library."""
    compile_one = numba.cfunc
    monkeypatch.setattr(numba, "cfunc", lambda *a, cache, **more: compile_one(*a, cache=False, **more))
    made = batch.__wrapped__(registry.get(kind, name).functions)
    text = made.compiled._library.get_asm_str()
    assert text.count("pd\t%ymm") + text.count("pd\t%zmm") + text.count("pd\t%xmm") > 20
    assert "movabsq\t$sin" not in text and "movabsq\t$cos" not in text


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [("sin", -1e5, 1e5), ("cos", -1e5, 1e5), ("sin", -4, 4), ("cos", -4, 4), ("exp", -700, 709)],
)
def test_functions_are_within_two_units_of_the_fifteenth_digit(name: str, low: float, high: float) -> None:
    compiled: Callable[[float], float] = getattr(batch_math, name)
    x = np.random.default_rng(1).uniform(low, high, 5000)
    wanted = getattr(np, name)(x.astype(np.longdouble))
    assert np.abs(np.array([compiled(v) for v in x]) / wanted - 1).max() < 2e-15


def test_logarithm_from_the_smallest_to_the_largest_number() -> None:
    rng = np.random.default_rng(2)
    x = np.concatenate([10 ** rng.uniform(-320, 308, 4000), rng.uniform(0.5, 2.0, 2000), 1 + rng.normal(0, 1e-6, 1000)])
    wanted = np.log(x.astype(np.longdouble))
    assert np.abs(np.array([batch_math.log(v) for v in x]) / wanted - 1).max() < 2e-15


@pytest.mark.parametrize("name", ["sin", "cos", "log", "exp"])
def test_ends_are_those_of_the_c_library(name: str) -> None:
    values = [0.0, -0.0, math.nan, *([math.inf, -1.0] if name != "exp" else [math.inf, -math.inf, 800.0, -800.0])]
    with np.errstate(all="ignore"):
        wanted = [float(getattr(np, name)(v)) for v in values]
    assert np.array_equal([getattr(batch_math, name)(v) for v in values], wanted, equal_nan=True)


def typed(text: str) -> ForceLaw:
    """A user's capillary law, typed at a prompt."""
    space: dict[str, Callable[..., float]] = {"math": math}
    names = ", ".join(KINDS["capillary"].parts[0].arguments)
    exec(f"def custom({names}):\n    {text}", space)
    return force_law(space["custom"])


def test_a_custom_law_takes_part() -> None:
    law = typed("return math.sin(volume**0.5) * surface_tension / (1.0 + math.exp(separation))")
    rows = bridges(BATCH, 3)
    assert batch((law,)).inlined
    assert np.allclose(together((law,), rows)[0], alone(law, rows), rtol=1e-13, atol=0.0)


def recursive() -> ForceLaw:
    """Return a law whose function calls itself: it compiles alone, where its type is declared, and not as part of a loop."""

    @numba.njit("float64(float64)")
    def root(x):  # type: ignore[no-untyped-def]
        return x if x < 1.0 else root(0.5 * x)

    law = typed("return root(1e9 * volume) * surface_tension")
    law.python.__globals__["root"] = root
    return law


def test_a_law_that_cannot_be_inlined_is_called() -> None:
    law = recursive()
    rows = bridges(BATCH, 4)
    assert not batch((law,)).inlined
    assert np.array_equal(together((law,), rows)[0], alone(law, rows))


def test_laws_that_differ_only_in_a_number_or_a_helper_are_distinguished(tmp_path: Path) -> None:
    """The compiled code is stored on disk under what a law consists of."""
    rows = bridges(2, 5)
    for factor in (2.0, 3.0):
        law = typed("return factor * volume")
        law.python.__globals__["factor"] = factor
        assert np.array_equal(together((law,), rows)[0], factor * rows[1])
    for power in (2, 3):

        @numba.njit
        def helper(x, n=power):  # type: ignore[no-untyped-def]
            return x * n

        law = typed("return helper(volume)")
        law.python.__globals__["helper"] = helper
        assert np.array_equal(together((law,), rows)[0], power * rows[1])


def test_a_law_that_raises_gives_no_number() -> None:
    """Expect that results stay as they were if a law raises; the plugin fills them with NaN before, which stops the run."""
    law = typed("if volume > 0.0:\n        raise ValueError('no')\n    return 1.0")
    assert np.isnan(together((law,), bridges(3, 6))).all()


def test_forces_in_one_loop_have_the_bits_of_each_alone() -> None:
    """Presets: capillary and viscous laws in one loop; a law that cannot be inlined, and one after a gap, have their own."""
    for laws in PRESETS.values():
        forces = {kind: registry.get(kind, laws[kind]) for kind in FORCES if kind in laws}
        ((first, loop, count),) = loops(forces)
        assert [(first, count) for first, _, count in loops(forces, apart=True)] == [(0, 1), (1, 1), (2, 2)]
        assert (first, count) == (0, 4) and loop.inlined
        rows = bridges(BATCH, 7)
        whole = together(tuple(f for law in forces.values() for f in law.functions), rows)
        assert np.array_equal(whole, np.concatenate([together(law.functions, rows) for law in forces.values()]))
    alone_again = {kind: forces[kind] for kind in ("capillary", "viscous_tangential")}
    assert [(first, count) for first, _, count in loops(alone_again)] == [(0, 1), (2, 2)]

    law = registry.Law("recursive", "capillary", (recursive(),))
    found = loops({**forces, "capillary": law})
    assert [(first, count) for first, _, count in found] == [(0, 1), (1, 1), (2, 2)]
    assert [loop.inlined for _, loop, _ in found] == [False, True, True]
