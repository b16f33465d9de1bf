"""Source `forces`: capillary force over gap and in overlap, rupture distance, volume drawn, normal drag; every program measured.

The true values of preset `paper` are those of the law in `reference_impl`; those of preset `exact` are the exact
bridge of `pywet.laws.exact_bridge`, confirmed by the reference's own solver. Stock programs run as installed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.cases.small import bridge_engine
from pywet.errors import PywetError
from pywet.schema import FORMATION, RUPTURE
from pywet.util.files import read_table
from reference_impl.bridge import bridge as computed_bridge
from reference_impl.replay import laws
from studies.cross_code.model import Cell, Floats, Source, impossible, measured, not_run, truth
from studies.cross_code.pairs import ANGLE, ETA, OVERLAPS, RADII, SIGMA, V_STAR, R, compared_gaps, drawn_gaps, pairs
from studies.cross_code.rows import EASO, EXACT, LIGGGHTS, PAIRS, REFERENCE, ROWS, WASHINO, YADE
from studies.cross_code.stock import SCAN, YADE_LAWS, Stock, scans
from studies.pair import Pair
from studies.stock.liggghts import liggghts_drag

CAPILLARY = {"paper": ("rabinovich", "willett_unequal"), "exact": ("young_laplace", "young_laplace")}
"""Preset -> capillary law and rupture law."""


def source(folder: Path) -> Source:
    """Return all cells of the force rows, and the curves of the picture; run directories are made in `folder`."""
    cells: list[Cell] = []
    curves: dict[str, Any] = {}
    stock = _stock_forces()
    for column, why in stock.missing.items():
        rows = [row.key for row in ROWS if row.key.startswith(("capillary_", "rupture_paper", "rupture_exact"))]
        cells += [not_run(row, column, why) for row in rows]
    for pair in pairs():
        curves[pair.key] = {}
        for preset in CAPILLARY:
            log, found = pulled(pair, preset, folder / f"pull_{preset}_{pair.key}")
            cells += found
            curves[pair.key][f"LIGGGHTS + pywet, {preset}"] = _thinned(log)
        cells += [*_stock(pair, stock), *_edges(pair, stock)]
        if pair.key == "equal":
            cells += [*_overlap(pair, stock), *_drag(pair, compared_gaps(pair))]
        curves[pair.key] |= _curves(pair, stock)
    return Source("forces", cells, curves)


def _stock_forces() -> Stock:
    """Compute the forces of the stock programs: two calls of each law."""
    stock, asked = Stock(), []
    for pair in pairs():
        asked += [pair.points(compared_gaps(pair), "gaps"), pair.points(drawn_gaps(pair), "curve")]
        asked.append(pair.points(np.array(OVERLAPS) * R, "overlap"))
        asked.append(pair.points(np.linspace(0.3, 2.5, SCAN) * pair.limit("paper"), "coarse"))
    stock.measure(pd.concat(asked, ignore_index=True))
    fine = [
        {p.key: p for p in pairs()}[key].points(gaps, f"fine {column}")
        for column in stock.there
        for key, gaps in scans(stock, list(RADII), column).items()
    ]
    if fine:
        stock.measure(pd.concat(fine, ignore_index=True))
    return stock


def pulled(pair: Pair, preset: str, folder: Path, engine: str = "liggghts") -> tuple[pd.DataFrame, list[Cell]]:
    """Return the contact log of two bodies drawn apart in the engine, from a small overlap, and the resulting cells."""
    query = pair.query([1.2 * min(OVERLAPS) * R, 1e-4], viscosity_Pa_s=0.0, velocity_m_per_s=0.05)
    log, events = bridge_engine._pull(folder, query, *CAPILLARY[preset], "pitois", engine)
    cells = [*_engine(pair, preset, compared_gaps(pair), log, events)]
    if pair.key == "equal":
        cells.append(_engine_overlap(pair, preset, log))
        if preset == "paper":
            cells.append(_engine_formation(folder, events))
    return log, cells


def _at(log: pd.DataFrame, wanted: Floats) -> pd.DataFrame:
    """Return the logged rows nearest to the wanted gaps."""
    held = log["separation"].to_numpy(float)
    return log.iloc[[int(np.abs(held - s).argmin()) for s in wanted]]


def _named(gaps: Floats, limit: float) -> list[str]:
    return [f"gap {1e6 * s:.0f} µm, {s / limit:.0%} of rupture" for s in gaps]


def _engine(
    pair: Pair, preset: str, gaps: Floats, log: pd.DataFrame, events: pd.DataFrame
) -> Iterator[Cell]:  # fmt: skip
    """Yield the cells of LIGGGHTS + pywet, and of the two true values, for one pair."""
    row, rows = f"capillary_{preset}_{pair.key}", _at(log, gaps)
    at, force, limit = rows["separation"].to_numpy(float), rows["capillary"].to_numpy(float), pair.limit(preset)
    link = f"runs/pull_{preset}_{pair.key}/"
    names = _named(at, limit)
    where = f"V* {V_STAR:g}, contact angle 15°, {len(at)} gaps"
    wanted = pair.exact(at) if preset == "exact" else pair.paper(at)
    computed = lambda: np.array([computed_bridge.solve(g, *pair.bridge).force * SIGMA for g in at])  # noqa: E731
    source_text = (
        "Young-Laplace meridian in closed form" if preset == "exact" else "closed form, typed again from the paper"
    )
    fit = "the law is a fit; what the exact bridge gives is in the rows below"
    yield from _best(
        row, preset, f"{source_text}; {where}", fit, computed, wanted, "collocation, shares no code", names
    )
    table = "tabulated force in the engine, stated error 0.1 % of the force at touch"
    note = table if preset == "exact" else "contact log of a pull at 0.05 m/s"
    yield measured(row, LIGGGHTS, force, wanted, at=names, note=note, link=link)
    broken = events.loc[events["kind"] == RUPTURE, "rupture_distance"].to_numpy(float)[:1]
    row = f"rupture_{preset}_{pair.key}"
    computed = lambda: np.array([computed_bridge.rupture(*pair.bridge).separation])  # noqa: E731
    source_text = (
        "limit of stability of the exact bridge" if preset == "exact" else "closed form, typed again from the paper"
    )
    fit = "the law is a fit; the exact limit is in the rows below"
    yield from _best(row, preset, source_text, fit, computed, np.array([limit]), "second variation, shares no code")
    note = "event log; table, stated error 2e-4" if preset == "exact" else "event log"
    yield measured(row, LIGGGHTS, broken, np.array([limit]), note=note, link=link)


def _best(
    row: str, preset: str, source_text: str, fit: str, computed: Callable[[], Floats], exact: Floats, note: str,
    at: Sequence[str] = (),
) -> Iterator[Cell]:  # fmt: skip
    """Yield the reference of a row: the paper's law by the reference, or the exact bridge, which the reference solves too."""
    if preset == "paper":
        yield impossible(row, EXACT, fit)
        yield truth(row, REFERENCE, source_text, len(exact))
    else:
        yield truth(row, EXACT, source_text, len(exact))
        yield measured(row, REFERENCE, computed(), exact, at=at, note=note)


def _engine_formation(folder: Path, events: pd.DataFrame) -> Cell:
    """Compare the volume of the new bridge with what the law draws from the initial films."""
    films = read_table(folder / "history" / "spheres.parquet")["film"].to_numpy(float)
    drawn = np.sum(laws.drawn_from_sphere(laws.SPHERE, films, R, R, 0.0))
    volume = events.loc[events["kind"] == FORMATION, "volume"].to_numpy(float)[:1]
    note = "event log; which volumes the films of every formation give is replayed in the rows above"
    return measured("formation_equal", LIGGGHTS, volume, np.array([drawn]), note=note, link="runs/pull_paper_equal/")


def _engine_overlap(pair: Pair, preset: str, log: pd.DataFrame) -> Cell:
    """Compare the force at three overlaps with that at touch."""
    rows = _at(log, np.array(OVERLAPS) * R)
    exact = pair.exact(np.zeros(3)) if preset == "exact" else pair.paper(np.zeros(3))
    names = [f"overlap {-s / R:.1%} of r" for s in rows["separation"]]
    return measured(
        f"capillary_{preset}_overlap", LIGGGHTS, rows["capillary"].to_numpy(float), exact, at=names,
        note="by convention the bridge of overlapping spheres has the force at touch", link=f"runs/pull_{preset}_equal/",
    )  # fmt: skip


NOTES = {
    WASHINO: "half of Rabinovich's radius, product of the contact angles, walls as spheres",
    EASO: "Soulié's fit with the product of the contact angles, walls as spheres",
}


def _note(column: str, preset: str) -> str:
    return NOTES.get(column) or f"YADE's law {YADE_LAWS[preset]}; it takes a wall for an equal sphere"


def _stock(pair: Pair, stock: Stock) -> Iterator[Cell]:
    """Yield YADE and the stock models at the same gaps."""
    for column in stock.there:
        for preset in CAPILLARY:
            row = f"capillary_{preset}_{pair.key}"
            gaps, values = stock.force(column, preset, pair.key, "gaps")
            wanted = pair.paper(gaps) if preset == "paper" else pair.exact(gaps)
            yield measured(row, column, values, wanted, at=_named(gaps, pair.limit(preset)), note=_note(column, preset))


def _overlap(pair: Pair, stock: Stock) -> Iterator[Cell]:
    """Measure the forces of the stock programs in overlap."""
    for preset in CAPILLARY:
        row = f"capillary_{preset}_overlap"
        touch = pair.paper(np.zeros(3)) if preset == "paper" else pair.exact(np.zeros(3))
        computed = lambda: np.full(3, computed_bridge.solve(0.0, *pair.bridge).force * SIGMA)  # noqa: E731
        yield from _best(row, preset, "force at touch", "the law is a fit", computed, touch, "collocation")
        for column in stock.there:
            at, values = stock.force(column, preset, pair.key, "overlap")
            says = "no capillary force while spheres overlap" if column == YADE else _note(column, preset)
            yield measured(row, column, values, touch, at=[f"overlap {-s / R:.1%} of r" for s in at], note=says)


def _edges(pair: Pair, stock: Stock) -> Iterator[Cell]:
    """Yield the distance at which the force of a stock program ends, and its bridge's volume by the stock models' law."""
    for column in stock.there:
        edge = stock.edge(column, pair.key)
        for preset in CAPILLARY:
            row, limit = f"rupture_{preset}_{pair.key}", np.array([pair.limit(preset)])
            note = "where its force ends, found within 4e-4; no dynamic factor"
            yield measured(row, column, np.array([edge]), limit, note=note)
        if pair.key == "equal":
            yield from _formation(pair, column, edge)
    if pair.key == "equal":
        row = "formation_equal"
        yield impossible(row, EXACT, "a law of the paper, not a solution")
        yield truth(row, REFERENCE, "V = Σ (L/2)(1 − √0.75), L the film of each sphere (E 8)", 1)


def _formation(pair: Pair, column: str, edge: float) -> Iterator[Cell]:
    """Volume of a stock model's bridge for given films, inferred from its rupture distance, compared with Shi & McCarthy."""
    row = "formation_equal"
    if column == YADE:
        yield impossible(row, YADE, "no liquid migration: the volume of a bridge is a property of the material")
        return
    angle = 0.5 * ANGLE**2  # both models use half the product of the angles in place of the mean angle
    volume = (edge / (1.0 + 0.5 * angle)) ** 3
    share = 0.05 if column == WASHINO else 0.5 * (1.0 - math.sqrt(0.75))
    film = pair.volume / (2.0 * share)
    drawn = 2.0 * laws.drawn_from_sphere(laws.SPHERE, film, R, R, 0.0)
    note = "volume from the distance where its force ends (to 1e-3); washino takes 5 % of both films, easo Shi & McCarthy's share"
    yield measured(row, column, np.array([volume]), np.array([drawn]), note=note)


def _drag(pair: Pair, gaps: Floats) -> Iterator[Cell]:
    """Measure the normal viscous drag over the speed."""
    row = "drag_equal"
    ri, rj, wall = pair.flags
    wanted = -laws.pitois(gaps, np.array([pair.volume]), ri, rj, wall, np.array([1.0]), ETA)
    yield impossible(row, EXACT, "no exact solution for a finite bridge; the law is lubrication cut off at its volume")
    yield truth(row, REFERENCE, "Pitois et al. 2000 (E 26), S_min = 0.001 r", len(gaps))
    yield impossible(row, YADE, "the capillary laws of YADE's ViscElCapMat have no viscous force of the liquid")
    from pywet.laws import registry

    law = registry.get("viscous_normal", "pitois").functions[0]
    computed = np.array([-law(s, pair.volume, R, R, 1.0, ETA) for s in gaps])
    names = _named(gaps, pair.limit("paper"))
    yield measured(
        row, LIGGGHTS, computed, wanted, at=names, note="the compiled law the engine calls; its log is replayed below"
    )
    for column in (WASHINO, EASO):
        try:
            drag = liggghts_drag(pair.points(gaps), column, ETA)["drag"].to_numpy(float)
        except PywetError as error:
            yield not_run(row, column, str(error))
            continue
        yield measured(
            row, column, drag, wanted, at=names, note="force with viscosity less that without, over the speed"
        )


def _thinned(log: pd.DataFrame) -> dict[str, list[float]]:
    stored = log.iloc[:: max(1, len(log) // 150)]
    return {"gap": [float(s) for s in stored["separation"]], "force": [float(f) for f in stored["capillary"]]}


def _curves(pair: Pair, stock: Stock) -> dict[str, Any]:
    """Return the force over gap of all programs for the picture."""
    apart = drawn_gaps(pair)[drawn_gaps(pair) >= 0]
    exact = [None if math.isnan(f) else f for f in pair.exact(apart)]
    curves: dict[str, Any] = {"exact solution": {"gap": apart.tolist(), "force": exact}}
    for column in stock.there:
        for preset in CAPILLARY if column == YADE else ("paper",):
            gaps, values = stock.force(column, preset, pair.key, "curve")
            name = f"YADE {YADE_LAWS[preset]}" if column == YADE else f"stock {column}"
            curves[name] = {"gap": gaps.tolist(), "force": [float(v) for v in np.nan_to_num(values)]}
    return curves


assert set(RADII) == set(PAIRS)
