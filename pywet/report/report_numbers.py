"""The numbers of the report, by key: each in full precision and as text. The page is rendered from them; report.json stores them.

A key is a path of parts, such as `case02.liquid_mm3.fines`; `….half_width` is the 95 % interval of the mean over
seeds. Keys that begin with `label.` are the labels of rows, columns and curves; their value is the corresponding part
of the keys.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from markupsafe import Markup

from pywet.cases.screening.verdict import LEDGER_TOLERANCE, REPLAY_TOLERANCE
from pywet.config import Config
from pywet.report import answer, contributed
from pywet.report.collect import CaseResult, deep
from pywet.report.plots import PLACES, WORDS, configuration_value, title
from pywet.runs.spread import ROUND_OFF, difference, half_width, with_interval

LEDGER = {
    "coarse_material": "coarse material", "fines": "fines", "wires": "wires", "side_wall": "side walls", "feed_bin": "feed bin",
    "outlet": "outlet", "impact_plate": "impact plate", "collecting_bin": "collecting bin", "left": "left",
    "standing_bridges": "of which in bridges",
}  # fmt: skip
"""Liquid reservoir in summary.json and its column of the liquid ledger."""
CASES = {
    "material": "material", "sizes_mm": "d in mm", "aperture_mm": "a in mm", "set_amplitude_mm": "A in mm",
    "liquid_percent": "M in %", "spheres": "spheres", "steps": "steps", "wall_s": "wall s",
    "million_sphere_steps_per_s": "10⁶ sphere-steps/s", "fraction_retained": "Y at end", "coarse_share": "cannot pass",
    "formations": "formations", "ruptures": "ruptures",
}  # fmt: skip
"""Last part of a key and its column of the table of cases."""
SCREEN: dict[str, tuple[str, float, tuple[str, ...]]] = {
    "undersize_recovery_percent": ("undersize recovery [%]", 100.0, ("undersize_recovery",)),
    "overs_purity_percent": ("purity of the overs [%]", 100.0, ("overs_purity",)),
    "efficiency_percent": ("efficiency [%]", 100.0, ("efficiency",)),
    "t_per_h_m2": ("passed [t/(h m²)]", 1.0, ("throughput_t_per_h_m2", "unders")),
    "moisture_overs_percent": ("moisture of the overs [%]", 1.0, ("moisture_percent_of_dry_mass", "overs")),
    "moisture_unders_percent": ("moisture of the unders [%]", 1.0, ("moisture_percent_of_dry_mass", "unders")),
    "pegged_percent": ("apertures pegged [%]", 100.0, ("pegged_share",)),
}  # fmt: skip
"""Last part of a key: its column of the table of screens, factor, and keys in screen.json."""
PRESETS = {
    "fraction_retained": "fraction retained", "formations": "bridges formed", "ruptures": "bridges ruptured",
    "wall_s": "wall time in s", **{f"liquid_percent.{name}": f"liquid {label}" for name, (label, _) in PLACES.items()},
}  # fmt: skip
"""Last part of a key and its row of the table of two presets."""
SIEVES = {"cylinder": "round", "square": "square"}
OUTCOMES = {
    "dry": "Nothing moist to cross-check.",
    "disagrees": "",
    "agrees": "Bookkeeping and forces recomputed: ",
    "agrees in part": "Bookkeeping and forces recomputed in part: ",
    "agrees but for laws": "Bookkeeping and forces recomputed but for laws that the reference does not know: of the rest, ",
    "agrees in part but for laws": "Bookkeeping and forces recomputed in part but for laws that the reference does not know: "
    "of the rest, ",
}
"""Outcome of the cross-check and the beginning of the sentence on it."""


class Numbers(dict[str, dict[str, Any]]):
    """Values and their texts by key."""

    def put(self, key: str, value: Any, shown: str | None = None) -> None:
        """Store a value and its text, which is the value itself if not given."""
        plain = value.item() if isinstance(value, np.generic) else value
        self[key] = {"value": plain, "shown": _plain(plain) if shown is None else shown}

    def label(self, key: str, words: str, name: str = "") -> None:
        """Store the label for a part `name` of keys, which is `key` itself if not given."""
        self.put(f"label.{key}", name or key, words)

    def spread(self, key: str, values: Sequence[float], digits: int = 3, form: str = "") -> str:
        """Store a number over seeds as mean and half width of its interval; for one seed in the format `form`."""
        if not values:
            self.put(key, None)
            return "–"
        one = f"{values[0]:{form}}" if form and len(values) == 1 else with_interval(values, digits)
        shown, _, half = one.partition(" ± ")
        self.put(key, float(np.mean(values)) if len(values) > 1 else values[0], shown)
        if half:
            self.put(f"{key}.half_width", half_width(values), half)
        return one

    def html(self, key: str) -> Markup:
        """Render a number, with its half width if it has one."""
        half = f"{key}.half_width"
        return _datum(key, self[key]) + (" ± " + _datum(half, self[half]) if half in self else "")


def _datum(key: str, of: dict[str, Any]) -> Markup:
    value = of["value"] if isinstance(of["value"], str) else json.dumps(of["value"])
    return Markup('<data value="{}" data-key="{}">{}</data>').format(value, key, of["shown"])


def _plain(value: Any) -> str:
    return "–" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)


def significant(value: float | None, digits: int = 3) -> str:
    """Format a number with some significant digits; a dash for None."""
    return "–" if value is None else f"{value:.{digits}g}"


def power(value: float | None) -> str:
    """Format a small number as 3.2e−16; zero as 0; a dash for None."""
    if value is None:
        return "–"
    return "0" if value == 0 else f"{value:.1e}".replace("e-0", "e-").replace("-", "−")


def collected(results: Sequence[CaseResult], config: Config, scale: str) -> Numbers:
    """Collect the numbers of all cases, except those of figures and of presets."""
    numbers = Numbers()
    for part in (_cases, _answer, _screens, _cross_check, _laws, _effects, _contributions, _deviations, _ledger):
        part(numbers, results)
    _scale(numbers, config, scale)
    return numbers


def _cases(numbers: Numbers, results: Sequence[CaseResult]) -> None:
    for column, words in CASES.items():
        numbers.label(f"cases.{column}", words, column)
    for name, words in WORDS.items():
        numbers.label(f"word.{name}", words, name)
    for r in results:
        name, case, s = r.case.name, r.case, r.summary
        numbers.label(name, str(case.case))
        numbers.put(f"{name}.material", case.material)
        numbers.put(f"{name}.sizes_mm", "/".join(f"{d:g}" for d in case.diameters_mm))
        for column in ("aperture_mm", "set_amplitude_mm", "liquid_percent"):
            numbers.put(f"{name}.{column}", getattr(case, column))
        numbers.put(
            f"{name}.state", "done" if r.done else "not done", "done" if r.done else "not accepted" if s else "failed"
        )
        if not r.done:
            numbers.put(f"{name}.not_done", name)
        if s is None:
            continue
        speed = s["particle_steps_per_s"]
        numbers.put(f"{name}.spheres", sum(s["spheres"].values()))
        numbers.put(f"{name}.steps", s["steps"])
        numbers.spread(f"{name}.wall_s", r.wall_s)
        numbers.put(f"{name}.million_sphere_steps_per_s", *_rounded(speed / 1e6 if speed else None))
        numbers.spread(f"{name}.fraction_retained", r.ends)
        numbers.put(f"{name}.coarse_share", *_rounded(s["coarse_share"]))
        for kind in ("formations", "ruptures"):
            numbers.spread(f"{name}.{kind}", r.over_seeds("events", kind))
    done = [r.summary for r in results if r.summary]
    numbers.put("cases.count", len(results))
    numbers.put("cases.done", sum(r.done for r in results))
    numbers.put("engine_time_min", *_rounded(sum(s["wall_s"] for s in done) / 60.0, 2))
    numbers.put("million_sphere_steps", *_rounded(sum(_steps(s) * sum(s["spheres"].values()) for s in done) / 1e6))


def _steps(summary: Mapping[str, Any]) -> int:
    """Return the steps that took the summary's computing time: of a resumed run those since."""
    return int(summary["steps"]) - int(summary["resumed_at_step"] or 0)


def _rounded(value: float | None, digits: int = 3) -> tuple[float | None, str]:
    return value, significant(value, digits)


def _answer(numbers: Numbers, results: Sequence[CaseResult]) -> None:
    """Store the share of passable material that has passed, for each case, all dry and all moist ones, and whether it differs."""
    rows = answer.rows(results)
    shares: dict[str, list[list[float]]] = {"dry": [], "moist": []}
    for row in rows:
        first = row[0].case.name
        numbers.put(f"{first}.configuration", configuration_value(row[0]), title(row[0]))
        numbers.put(f"{first}.coarse_percent", *_rounded(100.0 * _coarse(row[0])))
        for r in row:
            name, liquid, passed = r.case.name, r.case.liquid_percent, answer.passed(r.dry_ends, _coarse(r))
            shares["moist" if liquid else "dry"].append(passed)
            numbers.put(f"{name}.moisture", liquid, f"{liquid:g} % {r.case.liquid or 'liquid'}" if liquid else "dry")
            numbers.spread(f"{name}.passed_percent", passed, form=".0f")
            if len(passed) > 1:
                numbers.put(f"{name}.seeds", len(passed))
    for table in [row[0].retained for row in rows[:1]]:
        assert table is not None
        numbers.put("time_since_opening_s", *_rounded(float(table["time_since_opening_s"].iloc[-1]), 2))
    for kind, of in shares.items() if len(rows) > 1 else ():
        key, least, most = f"passed.{kind}", min(of, key=np.mean, default=[]), max(of, key=np.mean, default=[])
        if of and numbers.spread(f"{key}.least_percent", least, form=".0f") != Numbers().spread(key, most, form=".0f"):
            numbers.spread(f"{key}.most_percent", most, form=".0f")
    compared = {f"{row[-1].case.name}.difference": row for row in rows if len(row) > 1}
    for key, row in compared.items():
        significance(numbers, key, row[0].dry_ends, row[-1].dry_ends, len(compared))
    if compared and len(rows) > 1:
        numbers.put("comparisons.count", len(compared))
        numbers.put("comparisons.significant", sum(numbers[key]["value"] == "significant" for key in compared))


def _screens(numbers: Numbers, results: Sequence[CaseResult]) -> None:
    """Store the results of the screen: recovery, purity, efficiency, rate, moisture of the products, pegging."""
    there = [r for r in results if r.screens]
    for key, (words, factor, path) in SCREEN.items() if there else ():
        numbers.label(f"screen.{key}", words)
        for r in there:
            found = [factor * v for s in r.screens if (v := deep(s, path)) is not None]
            numbers.spread(f"{r.case.name}.screen.{key}", found)
            if 0 < len(found) < len(r.screens):
                numbers.put(f"{r.case.name}.screen.{key}.seeds", f"{len(found)} of {len(r.screens)}")


def _coarse(result: CaseResult) -> float:
    return float(result.summary["coarse_share"]) if result.summary else float("nan")


def significance(numbers: Numbers, key: str, one: Sequence[float], two: Sequence[float], comparisons: int = 1) -> None:
    """Store whether two groups of seeds differ (Welch), at 5 % for so many comparisons together; inconclusive without scatter."""
    ends = difference(two, one, comparisons)
    if ends is None:
        numbers.put(key, "inconclusive")
        return
    low, high = ends
    numbers.put(key, "significant" if low > ROUND_OFF or high < -ROUND_OFF else "not significant")
    numbers.put(f"{key}.low", low, f"{low:+.3f}")
    numbers.put(f"{key}.high", high, f"{high:+.3f}")


def _cross_check(numbers: Numbers, results: Sequence[CaseResult]) -> None:
    moist, replayed = [r for r in results if r.bridged], [r for r in results if r.agreement]
    errors = [e for r in moist if (e := r.ledger_error) is not None]
    found = answer.outcome(results)
    whole = bool(errors) and max(errors) <= LEDGER_TOLERANCE
    numbers.put("cross_check.outcome", found, OUTCOMES[found])
    if found.startswith("agrees"):
        numbers.put(
            "cross_check.liquid", "conserved" if whole else "not conserved", "; no liquid is lost" if whole else ""
        )
    for kind, group in answer.not_agreeing(results).items():
        numbers.put(f"cross_check.{kind}", ", ".join(str(r.case.case) for r in group))
    if replayed:
        numbers.put("cross_check.quantities", len({row.quantity for r in replayed for row in r.agreement}))
        numbers.put("cross_check.cases", len(replayed))
    numbers.put("moist.count", len(moist))
    numbers.put("moist.agreeing", sum(r.cross_checked for r in moist))
    if laws_unknown := sum(bool(r.unchecked) for r in moist):
        numbers.put("moist.laws_unknown", laws_unknown)
    tight = [row.largest for r in replayed for row in r.agreement if row.limit <= REPLAY_TOLERANCE]
    for key, value in (("largest_deviation", max(tight, default=None)), ("largest_ledger_error", max(errors, default=None)),
                       ("limit.deviation", REPLAY_TOLERANCE), ("limit.ledger_error", LEDGER_TOLERANCE)):  # fmt: skip
        numbers.put(key, value, power(value))


def _laws(numbers: Numbers, results: Sequence[CaseResult]) -> None:
    """Store the cases of each law, and those without."""
    for (effect, law), cases in answer.laws(results).items():
        numbers.label(f"law.{effect}.{law}", law, law)
        numbers.put(f"law.{effect}.{law}", ", ".join(map(str, cases)))


def _effects(numbers: Numbers, results: Sequence[CaseResult]) -> None:
    for r in results:
        for row in r.plan["rows"] if r.plan else ():
            effect = row["effect"]
            numbers.label(f"effect.{effect}", effect.replace("_", " "), f"effect.{effect}")
            if f"effect.{effect}.threshold" not in numbers:
                numbers.put(f"effect.{effect}.threshold", *_rounded(row["threshold"]))
            numbers.put(f"{r.case.name}.effect.{effect}", *_rounded(row["number"], 2))


def _contributions(numbers: Numbers, results: Sequence[CaseResult]) -> None:
    for effect, _, cells in contributed.rows(results):
        numbers.label(
            f"contribution.{effect}", contributed.FORCES.get(effect, effect.replace("_", " ")), f"contribution.{effect}"
        )
        for r, cell in zip(results, cells, strict=True):
            if cell is not None:
                _percent(numbers, f"{r.case.name}.contribution.{effect}", cell.share)
                if cell.predicted is not None:
                    _percent(numbers, f"{r.case.name}.contribution.{effect}.predicted", cell.predicted)


def _percent(numbers: Numbers, key: str, share: float | None) -> None:
    numbers.put(key, None if share is None else 100.0 * share, contributed.percent(share))


def _deviations(numbers: Numbers, results: Sequence[CaseResult]) -> None:
    for r in results:
        for row in r.agreement:
            key = f"deviation.{row.quantity}"
            numbers.label(key, row.quantity.replace("_", " "))
            if f"{key}.limit" not in numbers:
                numbers.put(f"{key}.limit", row.limit, power(row.limit))
            for name, value in (("largest", row.largest), ("median", row.median)):
                numbers.put(f"{r.case.name}.{key}.{name}", value, power(value))


def _ledger(numbers: Numbers, results: Sequence[CaseResult]) -> None:
    for name, words in {"put_in": "put in", **LEDGER}.items():
        numbers.label(f"liquid_mm3.{name}", words)
    numbers.label("ledger_error", "largest error")
    for r in results:
        if r.summary is None or not r.bridged:
            continue
        key = f"{r.case.name}.liquid_mm3"
        numbers.spread(f"{key}.put_in", r.over_seeds("initial_liquid_m3", factor=1e9), 5)
        for name in LEDGER:
            numbers.spread(f"{key}.{name}", r.over_seeds("liquid_end_m3", name, factor=1e9), 4)
        numbers.put(f"{r.case.name}.ledger_error", r.ledger_error, power(r.ledger_error))


def _scale(numbers: Numbers, config: Config, name: str) -> None:
    """List how the scale differs from the experiment, and every assumed number of the configuration."""
    scale = config.scale(name)
    factor = scale.stiffness_factor.value
    numbers.put("scale.width_mm", scale.asked_width_mm)
    numbers.put("scale.shape", scale.shape, SIEVES[scale.shape])
    numbers.put("scale.sieve_of_the_paper_mm", config.materials.feed.sieve_diameter_mm.value)
    if factor < 1.0:
        numbers.put("scale.stiffness_factor", factor)
        numbers.put("scale.collisions_longer", *_rounded(factor**-0.5))
    numbers.put("scale.duration_s", scale.duration_s.value)
    numbers.put("scale.slide_opens_at_s", scale.slide_opens_at_s.value)
    rows = list(assumptions(config, name))
    numbers.put("assumptions.count", len(rows))
    for path, value, reason in rows:
        key = f"assumption.{'.'.join(path)}"
        numbers.label(key, " · ".join(path).replace("_", " "))
        numbers.put(key, value)
        numbers.put(f"{key}.reason", " ".join(reason.split()))


def assumptions(config: Config, scale: str) -> list[tuple[tuple[str, ...], Any, str]]:
    """Return path, value and reason of every number of the configuration that is not from the paper; measured ones are marked."""
    parts = {"apparatus": config.apparatus, "materials": config.materials, "settings": config.settings}
    data: dict[str, Any] = {name: part.model_dump(exclude_none=True) for name, part in parts.items()}
    return _assumed((), {**data, "scale": {scale: config.scale(scale).model_dump(exclude_none=True)}})


def _assumed(path: tuple[str, ...], data: Any) -> list[tuple[tuple[str, ...], Any, str]]:
    if (
        isinstance(data, dict)
        and data.get("source") in ("assumption", "measured")
        and ("value" in data or "material" in data)
    ):
        without = {"measured": "measured", "assumption": "no reason is given"}[data["source"]]
        return [(path, data.get("value", data.get("material")), data.get("reason", without))]
    if isinstance(data, dict):
        return [row for key, value in data.items() for row in _assumed((*path, key), value)]
    if isinstance(data, list | tuple):
        return [row for k, value in enumerate(data) for row in _assumed((*path[:-1], f"{path[-1]} {k + 1}"), value)]
    return []
