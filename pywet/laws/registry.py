"""Find laws by kind and name: built in, published through the entry-point group `pywet.laws`, or `path/to/file.py:function`."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache, partial
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from pywet.errors import LawError, PywetError
from pywet.laws import (
    buck,
    capillary,
    capillary_fits,
    custom_laws,
    davis,
    formation,
    rupture,
    shedding,
    transfer,
    transfer_exact,
    viscous,
    young_laplace,
)
from pywet.laws.force_law import REGISTERED, ForceLaw, check, check_kind
from pywet.laws.kinds import KINDS
from pywet.util import sources

GROUP = "pywet.laws"
"""Entry-point group of published laws."""

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Law:
    """A named law: one function, or the few that make it up."""

    name: str
    kind: str
    functions: tuple[ForceLaw, ...]

    def prepare(self, angles: Iterable[tuple[float, float]], progress: Progress | None = None) -> None:
        """Prepare the tables that compiled code needs for pairs of contact angles (smaller body, larger body) [rad]."""
        if any(function.tabulated for function in self.functions):
            young_laplace.prepare(angles, progress)


TRANSFER: dict[str, Callable[..., transfer.Floats]] = {
    "parabola": transfer.transfer_table,
    "parabola_walls_at_fifth": partial(transfer.transfer_table, stretch=0.2),
    "parabola_walls_at_tenth": partial(transfer.transfer_table, stretch=0.1),
    "young_laplace": transfer_exact.exact_table,
    "half": transfer.halves,
}
"""Transfer models: functions that return a table over V*, see `transfer_table`."""
MODULES = (capillary, capillary_fits, viscous, rupture, formation, young_laplace, buck, davis, shedding)
"""Modules whose laws are registered at import; laws are listed in this order, whichever was imported first."""


def _listed(laws: dict[str, tuple[ForceLaw, ...]]) -> dict[str, tuple[ForceLaw, ...]]:
    order = [module.__name__ for module in MODULES]
    return dict(sorted(laws.items(), key=lambda item: order.index(item[1][0].__module__)))


BUILT_IN = {kind: _listed(laws) for kind, laws in REGISTERED.items()} | {"transfer": dict.fromkeys(TRANSFER, ())}


def transfer_model(name: str) -> Callable[..., transfer.Floats]:
    """Return the function that tabulates a transfer model."""
    get("transfer", name)
    return TRANSFER[name]


def names(kind: str) -> list[str]:
    """Names of the laws of a kind: built in, and published ones whose arguments are those of the kind."""
    check_kind(kind)
    fitting = (p.name for p in published() if _fits(kind, p))
    return sorted({*BUILT_IN[kind], *REGISTERED[kind], *fitting})


@cache
def published() -> tuple[EntryPoint, ...]:
    """Return the laws of installed packages; the entry points are searched once."""
    return tuple(entry_points(group=GROUP))


def published_code(text: str) -> str:
    """Return the digests of the packages that publish the laws which a JSON text names; empty if it names none."""
    named = sorted((p.name, p.module) for p in published() if json.dumps(p.name) in text)
    return "".join(_package_digest(module.partition(".")[0]) for _, module in named)


@cache
def _package_digest(package: str) -> str:
    """Return the digest of the Python files of an installed package, once for each process, as they are imported once."""
    spec = find_spec(package)
    folders = spec.submodule_search_locations if spec else None
    single = [Path(spec.origin)] if spec and spec.origin else []
    files = sorted(path for folder in folders for path in Path(folder).rglob("*.py")) if folders else single
    return sources.digest(files, package)


def get(kind: str, name: str) -> Law:
    """Return the law of a kind and name; a custom law is first checked on a probe grid, again if its file has changed."""
    return _found(kind, name, custom_laws.digest(name))


@cache
def _found(kind: str, name: str, digest: str) -> Law:
    check_kind(kind)
    if name in BUILT_IN[kind]:
        return Law(name, kind, BUILT_IN[kind][name])
    offered = {p.name: p for p in published()}
    if name in REGISTERED[kind]:
        functions: Any = REGISTERED[kind][name]
    elif name in offered:
        functions = _load(offered[name])
    elif custom_laws.is_custom(name):
        functions = custom_laws.functions(kind, name)
    else:
        raise LawError(
            f"there is no {kind} law named {name}; expected one of {', '.join(names(kind))}, or path/to/file.py:function",
            law=name, code="law.not_of_kind", expected=names(kind),
        )  # fmt: skip
    return checked(kind, name, functions)


def checked(kind: str, name: str, functions: Any) -> Law:
    """Make a law from the functions of a file or a package and test it on the probe grid."""
    law, wanted = Law(name, kind, functions if isinstance(functions, tuple) else (functions,)), KINDS[kind].parts
    if not wanted:
        raise LawError(
            f"law {name}: a {kind} law cannot be user-defined; expected {', '.join(names(kind))}",
            law=name, code="law.not_custom", expected=names(kind),
        )  # fmt: skip
    if not all(isinstance(f, ForceLaw) for f in law.functions):
        raise LawError(
            f"law {name} is not decorated with @force_law (a tuple of such functions where a kind has many)",
            law=name, code="law.not_decorated",
        )  # fmt: skip
    if len(law.functions) != len(wanted):
        raise LawError(
            f"law {name} has {len(law.functions)} functions; expected {len(wanted)} for {kind}",
            law=name, code="law.functions", expected=len(wanted),
        )  # fmt: skip
    for function, part in zip(law.functions, wanted, strict=True):
        check(function, part.arguments, part.sense)
    return law


def _load(point: EntryPoint) -> Any:
    try:
        return point.load()
    except (Exception, SystemExit) as error:
        raise LawError(
            f"law {point.name}: {point.value} raises {type(error).__name__}: {error}; fix or uninstall the package that "
            f"publishes it in the entry-point group {GROUP}",
            law=point.name, code="law.package",
        ) from error  # fmt: skip


def _fits(kind: str, point: EntryPoint) -> bool:
    try:
        law = _load(point)
    except PywetError:
        return False  # it is rejected when it is requested by name
    functions = law if isinstance(law, tuple) else (law,)
    return [getattr(f, "arguments", ()) for f in functions] == [part.arguments for part in KINDS[kind].parts]
