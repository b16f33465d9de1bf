"""Numbers of a report, recomputed from the files of its cases, by the keys of report.json.

Each value has a precision of its text: `3 digits`, `2 places`, `unit`, `whole`, `power` or, for means and intervals
over seeds, `as shown`; for words `same` (the text is the value), `word` (any text), or `states` (the text contains
every part of the value).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from scipy import stats

from reference_impl.replay import io
from reference_impl.shown.case_files import LOST, Cases, name_of
from reference_impl.shown.report_page import Numbers
from reference_impl.tables import plant

Value = tuple[str, float | str | None, str]
"""Key, value, precision; with precision `absent` there must be no such key."""
TIGHT = 1e-9
"""Limit of a quantity that is included in the largest deviation."""
EQUAL = 1e-9
"""Relative difference of two computations of one number."""
CONFIGURED = ("aperture_mm", "set_amplitude_mm", "liquid_percent")
LEDGER = ("coarse_material", "fines", "wires", "side_wall", "feed_bin", "outlet", "impact_plate", "collecting_bin", "left",
          "standing_bridges")  # fmt: skip
RESERVOIRS = ("coarse_material_large", "coarse_material_near_mesh", "coarse_material_small", *LEDGER[1:8])
FORCES = ("weight", "contact_normal", "contact_tangential")
USUAL = "paper"
"""Preset with which others are compared."""
LEVEL, SAME = 0.05, 1e-12
"""Share of false alarms of all comparisons of moisture together, and difference of two fractions that is round-off."""
WITH_WEIGHT = "gravity"
"""Effect whose contribution is that of weight."""


def wrong(cases: Cases, numbers: Numbers) -> tuple[int, list[str], list[str]]:
    """Return the number of recomputed values, sentences on those that disagree, and unknown keys."""
    found, faults = list(_every(cases, numbers)), []
    for key, value, digits in found:
        stored = numbers.get(key)
        if digits == "absent" or stored is None:
            if (stored is None) != (digits == "absent"):
                faults.append(f"{key}: {'not expected' if stored else f'it is missing; expected {value}'}")
        elif not _equal(stored["value"], value, digits):
            faults.append(f"{key}: {stored['shown']!r} is shown; expected {_words(value)}")
        elif not shows(stored["shown"], value, digits, numbers):
            faults.append(f"{key}: {stored['shown']!r} is shown; expected {_words(value)} ({digits})")
    known = {key for key, *_ in found}
    return len(found), faults, [k for k in numbers if k not in known and not k.startswith(("label.", "figure."))]


def _words(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else repr(value) if isinstance(value, str) else str(value)


def _equal(stored: Any, value: Any, digits: str) -> bool:
    if isinstance(value, str) or value is None or not isinstance(stored, int | float):
        return bool(stored == value)
    return math.isclose(stored, value, rel_tol=EQUAL, abs_tol=1e-12 if digits == "3 places" else 0.0)


def shows(text: str, value: float | str | None, digits: str, numbers: Numbers) -> bool:
    """Return whether a text shows a value to its precision."""
    if digits == "word" or digits == "states":
        return digits == "word" or states(text, value if isinstance(value, str) else f"{value:g}", numbers)
    if isinstance(value, str):
        return text == value
    if value is None or text in ("–", ""):
        return value is None and text in ("–", "")
    match = re.fullmatch(r"[-−+]?\d+(?:\.(\d+))?(?:e[-−+]?\d+)?", text)
    if match is None:
        return False
    shown = float(text.replace("−", "-"))
    if digits == "whole" or (0 in (shown, value) and (digits == "power" or digits.endswith("digits"))):
        return shown == value
    if digits in ("unit", "as shown") or digits.endswith("places"):
        places = len(match[1] or "") if digits == "as shown" else 0 if digits == "unit" else int(digits[0])
        return abs(shown - value) <= 0.500001 * 10.0**-places
    stored = 2 if digits == "power" else int(digits[0])
    return bool(abs(shown - value) <= 0.500001 * 10.0 ** (np.floor(np.log10(abs(value))) + 1 - stored))


def states(text: str, value: str, numbers: Numbers) -> bool:
    """Return whether a text states every part of a value.

    Numbers and names must be as they are, others by their labels in report.json. The part 0 needs no text with a
    number.
    """
    for part in value.split():
        words = str(numbers.get(f"label.word.{part}", {"shown": part})["shown"])
        if part == "0":
            if re.search(r"\d", text):
                return False
        elif not re.search(rf"(?<![\w.]){re.escape(words)}(?![\w]|\.\d)", text):
            return False
    return True


def _spread(key: str, values: Sequence[float], digits: str) -> Iterator[Value]:
    """Format a number: for several seeds the mean and half width of its 95 % interval, for one seed with `digits`."""
    if len(values) < 2:
        yield key, values[0] if values else None, digits
        return
    half = (
        float(stats.t.ppf(0.975, len(values) - 1) * np.std(values, ddof=1) / np.sqrt(len(values)))
        if np.ptp(values)
        else 0.0
    )
    yield key, float(np.mean(values)), "as shown"
    yield f"{key}.half_width", half, "as shown" if half else "whole"


def _every(cases: Cases, numbers: Numbers) -> Iterator[Value]:
    for number in cases.listed:
        yield from _case(cases, number, numbers)
        yield from _plan(cases, number, numbers)
    done = [s for n in cases.listed if (s := cases.summary(n))]
    yield "cases.count", len(cases.listed), "whole"
    yield "cases.done", sum(map(cases.done, cases.listed)), "whole"
    yield "engine_time_min", sum(s["wall_s"] for s in done) / 60.0, "2 digits"
    steps = [(s["steps"] - (s["resumed_at_step"] or 0)) * sum(s["spheres"].values()) for s in done]
    yield "million_sphere_steps", sum(steps) / 1e6, "3 digits"
    yield from _thresholds(cases)
    yield from _answer(cases, numbers)
    yield from _cross_check(cases)
    yield from _laws(cases)
    yield from _scale(cases)
    yield from _presets(cases, numbers)


def _there(cases: Cases, number: int, numbers: Numbers) -> bool:
    """Return whether the report must list the numbers of a case: it is finished, or the report contains some of them."""
    return bool(cases.summary(number)) and (cases.done(number) or f"{name_of(number)}.steps" in numbers)


def _case(cases: Cases, number: int, numbers: Numbers) -> Iterator[Value]:
    """Yield the numbers of one case: the tables of cases, of the liquid ledger, of the cross-check and of contributions."""
    name, done, row = name_of(number), cases.done(number), cases.rows[number]
    yield f"{name}.material", row["material"], "same"
    yield f"{name}.sizes_mm", cases.sizes(number), "same"
    for column in CONFIGURED:
        yield f"{name}.{column}", float(row[column] or 0.0), "6 digits"
    yield f"{name}.state", "done" if done else "not done", "word"
    yield f"{name}.not_done", name, "absent" if done else "same"
    if not _there(cases, number, numbers):
        return
    data = cases.summary(number)
    speed = data.get("particle_steps_per_s")
    yield f"{name}.spheres", sum(data["spheres"].values()), "whole"
    yield f"{name}.steps", data["steps"], "whole"
    yield from _spread(f"{name}.wall_s", cases.wall_times(number), "3 digits")
    yield f"{name}.million_sphere_steps_per_s", speed / 1e6 if speed else None, "3 digits"
    yield from _spread(f"{name}.fraction_retained", cases.ends(number), "3 digits")
    yield f"{name}.coarse_share", data["coarse_share"], "3 digits"
    for kind in ("formations", "ruptures"):
        yield from _spread(f"{name}.{kind}", cases.of_seeds(number, "events", kind), "whole")
    if cases.bridged(number):
        key = f"{name}.liquid_mm3"
        yield from _spread(f"{key}.put_in", cases.of_seeds(number, "initial_liquid_m3", factor=1e9), "5 digits")
        for reservoir in LEDGER:
            ends = cases.of_seeds(number, "liquid_end_m3", reservoir, factor=1e9)
            yield from _spread(f"{key}.{reservoir}", ends, "4 digits")
        yield f"{name}.ledger_error", max(cases.of_seeds(number, "ledger_error"), default=None), "power"
    for quantity, of in cases.quantities(number).items():
        for key in ("largest", "median"):
            yield f"{name}.deviation.{quantity}.{key}", of[key], "power"
    yield from _contributions(cases, number)
    yield from _screen(cases, number)


SCREEN = {
    "undersize_recovery_percent": ("undersize_recovery", "", 100.0),
    "overs_purity_percent": ("overs_purity", "", 100.0),
    "efficiency_percent": ("efficiency", "", 100.0),
    "t_per_h_m2": ("throughput_t_per_h_m2", "unders", 1.0),
    "moisture_overs_percent": ("moisture_percent_of_dry_mass", "overs", 1.0),
    "moisture_unders_percent": ("moisture_percent_of_dry_mass", "unders", 1.0),
    "pegged_percent": ("pegged_share", "", 100.0),
}
"""Last part of a key -> keys in results/screen.json, and factor."""


def _screen(cases: Cases, number: int) -> Iterator[Value]:
    """Yield the results of the screen of a case and of its further seeds."""
    runs: list[int | str] = [number, *cases.seeds(number)]
    files = [of for run in runs if (of := _evaluated(cases, run))]
    for key, (first, then, factor) in SCREEN.items() if files else ():
        values = [(of.get(first) or {}).get(then) if then else of.get(first) for of in files]
        spread = [factor * v for v in values if v is not None]
        yield from _spread(f"{name_of(number)}.screen.{key}", spread, "3 digits")
        some = f"{len(spread)} of {len(values)}"
        yield f"{name_of(number)}.screen.{key}.seeds", some, "same" if 0 < len(spread) < len(values) else "absent"


def _evaluated(cases: Cases, run: int | str) -> dict[str, Any] | None:
    """Return screen.json of a batch; if it was evaluated with options, with the shares at the aperture of its own case."""
    given: dict[str, Any] | None = cases.json(run, "results/screen.json")
    if not given or not given.get("options"):
        return given
    folder = cases.folder / name_of(run)
    scene = io.scene(folder)
    rows = plant.within(plant.spheres(folder, scene, 1), 0.0, math.inf, batch=True)
    aperture = ((cases.json(run, "config.json") or {}).get("case") or {}).get("aperture_mm")
    limit = plant.size_of(plant.curve(rows), 0.5) if aperture is None else aperture
    found = plant.numbers(rows, scene, {**given, "reference_mm": limit})
    return {**given, **{key: found.get(key) for key in plant.SHARES}}


def _contributions(cases: Cases, number: int) -> Iterator[Value]:
    measured, audited = cases.json(number, "contributions.json"), cases.json(number, "audit.json") or {"rows": []}
    if not measured:
        return
    rows = {name: (measured["effects"][name]["impulse_share"], None) for name in FORCES}
    rows |= {
        row["effect"]: (row["measured"], row["predicted"]) for row in audited["rows"] if row["effect"] != WITH_WEIGHT
    }
    for name, (share, predicted) in rows.items():
        key = f"{name_of(number)}.contribution.{name}"
        for of, value in ((key, share), (f"{key}.predicted", predicted)):
            if of == key or value is not None:
                yield of, None if value is None else 100.0 * value, "unit" if (value or 0) >= 0.995 else "2 digits"


def _plan(cases: Cases, number: int, numbers: Numbers) -> Iterator[Value]:
    start = f"{name_of(number)}.effect."
    if cases.done(number) or any(key.startswith(start) for key in numbers):
        for row in (cases.json(number, "plan.json") or {"rows": []})["rows"]:
            yield f"{start}{row['effect']}", row["number"], "2 digits"


def _thresholds(cases: Cases) -> Iterator[Value]:
    """Yield the limits of effects and of quantities, from the first case that has each."""
    rows = [row for n in cases.listed[::-1] for row in (cases.json(n, "plan.json") or {"rows": []})["rows"]]
    for effect, threshold in {row["effect"]: row["threshold"] for row in rows}.items():
        yield f"effect.{effect}.threshold", threshold, "3 digits"
    for name, limit in {n: q["tolerance"] for c in cases.listed[::-1] for n, q in cases.quantities(c).items()}.items():
        yield f"deviation.{name}.limit", limit, "power"


def _answer(cases: Cases, numbers: Numbers) -> Iterator[Value]:
    """Yield the passed share of passable spheres' mass, for each case, all dry and all moist ones, and the effect of moisture."""
    there = [n for n in cases.listed if _there(cases, n, numbers) and cases.retained(n)]
    groups = cases.by_liquid(there)
    if there:
        time = cases.column(groups[0][0], "fraction_retained")
        yield "time_since_opening_s", None if time is None else float(time[0][-1]), "2 digits"
    through = {n: 1.0 - cases.summary(n)["coarse_share"] for n in there}
    passed = {n: [100.0 * (1.0 - end) / through[n] if through[n] else 0.0 for end in cases.dry_ends(n)] for n in there}
    for n, shares in passed.items():
        yield f"{name_of(n)}.moisture", cases.liquid(n), "states"
        yield from _spread(f"{name_of(n)}.passed_percent", shares, "unit")
        if len(shares) > 1:
            yield f"{name_of(n)}.seeds", len(shares), "whole"
    outcomes: list[Any] = []
    many = sum(len(group) > 1 for group in groups)
    for group in groups:
        first, last = group[0], group[-1]
        yield f"{name_of(first)}.configuration", cases.configuration(first), "states"
        yield f"{name_of(first)}.coarse_percent", 100.0 * cases.summary(first)["coarse_share"], "3 digits"
        if first != last:
            both = cases.dry_ends(first), cases.dry_ends(last)
            compared = list(_difference(f"{name_of(last)}.difference", *both, LEVEL / many))
            outcomes.append(compared[0][1])
            yield from compared
    several = "whole" if outcomes and len(groups) > 1 else "absent"
    yield "comparisons.count", len(outcomes), several
    yield "comparisons.significant", outcomes.count("significant"), several
    for kind in ("dry", "moist") if len(groups) > 1 else ():
        of = sorted(
            (p for n, p in passed.items() if (cases.liquid(n) > 0) == (kind == "moist")),
            key=lambda p: float(np.mean(p)),
        )
        least, most = f"passed.{kind}.least_percent", f"passed.{kind}.most_percent"
        if of:
            yield from _spread(least, of[0], "unit")
            ends = list(_spread(most, of[-1], "unit"))
            alike = (
                shows(_text(numbers, key.replace(most, least)), value, digits, numbers) for key, value, digits in ends
            )
            if most in numbers or not all(alike):
                yield from ends


def _text(numbers: Numbers, key: str) -> str:
    return str(numbers.get(key, {"shown": ""})["shown"])


def _difference(key: str, one: Sequence[float], two: Sequence[float], level: float = LEVEL) -> Iterator[Value]:
    """Yield whether the means of two groups differ, with the ends of the interval of their difference (Welch).

    Two values at least are needed in each, and scatter in one: a few values may coincide by accident.
    """
    if min(len(one), len(two)) < 2 or max(np.ptp(one), np.ptp(two)) <= SAME:
        yield key, "inconclusive", "same"
        return
    low, high = stats.ttest_ind(two, one, equal_var=False).confidence_interval(1.0 - level)
    yield key, "significant" if low > SAME or high < -SAME else "not significant", "same"
    yield f"{key}.low", float(low), "3 places"
    yield f"{key}.high", float(high), "3 places"


def _cross_check(cases: Cases) -> Iterator[Value]:
    moist = [n for n in cases.listed if cases.bridged(n)]
    bad = [n for n in moist if not cases.agrees(n)]
    replays = {n: cases.json(n, "replay.json") or {} for n in cases.listed}
    laws_unknown = [n for n in moist if replays[n].get("unchecked")]
    errors = [error for n in moist for error in cases.of_seeds(n, "ledger_error")]
    outcome = "agrees" + " in part" * any(r.get("nothing_compared") for r in replays.values())
    outcome += " but for laws" * bool(laws_unknown)
    yield "cross_check.outcome", "dry" if not moist else "disagrees" if bad else outcome, "word"
    liquid = "conserved" if errors and max(errors) <= LOST else "not conserved"
    yield "cross_check.liquid", liquid, "word" if moist and not bad else "absent"
    for kind, replayed in (("disagreeing", True), ("missing", False)):
        listed = ", ".join(str(n) for n in bad if bool(cases.quantities(n)) == replayed)
        yield f"cross_check.{kind}", listed, "same" if listed else "absent"
    every = {n: of for n in cases.listed if (of := cases.quantities(n))}
    yield "cross_check.quantities", len({name for of in every.values() for name in of}), "whole" if every else "absent"
    yield "cross_check.cases", len(every), "whole" if every else "absent"
    yield "moist.count", len(moist), "whole"
    yield "moist.agreeing", len(moist) - len(bad), "whole"
    yield "moist.laws_unknown", len(laws_unknown), "whole" if laws_unknown else "absent"
    tight = [q["largest"] for of in every.values() for q in of.values() if q["tolerance"] <= TIGHT]
    yield "largest_deviation", max(tight, default=None), "power"
    yield "largest_ledger_error", max(errors, default=None), "power"
    yield "limit.deviation", TIGHT, "power"
    yield "limit.ledger_error", LOST, "power"


def _laws(cases: Cases) -> Iterator[Value]:
    """Yield the cases of each law, and those without."""
    found: dict[tuple[str, str], list[int]] = {}
    for n in cases.listed:
        plan = cases.json(n, "plan.json")
        rows = [row for row in plan["rows"] if row["on"] and row.get("law")] if plan else []
        used = [(row["effect"], row["law"].rpartition("/")[2]) for row in rows]
        for key in used or ([("dry contacts", "none")] if plan else []):
            found.setdefault(key, []).append(n)
    for (effect, law), of in found.items():
        yield f"law.{effect}.{law}", ", ".join(map(str, of)), "same"


def _scale(cases: Cases) -> Iterator[Value]:
    """List how the scale differs from the experiment, and every assumed value with its reason."""
    config = cases.config
    if config is None:
        return
    entries = {name: entry for name, entry in config["scale"].items() if isinstance(entry, dict)}
    scale = {name: entry["value"] for name, entry in entries.items() if "value" in entry}
    yield "scale.width_mm", scale["width_mm"], "6 digits"
    yield "scale.shape", config["scale"]["shape"], "word"
    yield "scale.sieve_of_the_paper_mm", config["materials"]["feed"]["sieve_diameter_mm"]["value"], "6 digits"
    softened = scale["stiffness_factor"] < 1.0
    yield "scale.stiffness_factor", scale["stiffness_factor"], "6 digits" if softened else "absent"
    yield "scale.collisions_longer", scale["stiffness_factor"] ** -0.5, "3 digits" if softened else "absent"
    yield "scale.duration_s", scale["duration_s"], "6 digits"
    yield "scale.slide_opens_at_s", scale["slide_opens_at_s"], "6 digits"
    parts = {name: config[name] for name in ("apparatus", "materials", "settings")}
    rows = dict(_entries({**parts, "scale": {config["scale"]["name"]: config["scale"]}}, "assumption"))
    yield "assumptions.count", len(rows), "whole"
    for key, entry in rows.items():
        value = entry.get("value", entry.get("material", ""))
        yield key, value, "6 digits" if isinstance(value, int | float) else "same"
        without = "measured" if entry["source"] == "measured" else "no reason is given"
        yield f"{key}.reason", " ".join(str(entry.get("reason", without)).split()), "same"


def _entries(data: Any, key: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield key and entry of every value that is not from the paper."""
    if isinstance(data, dict) and data.get("source") in ("assumption", "measured"):
        yield key, data
    elif isinstance(data, dict):
        for name, value in data.items():
            yield from _entries(value, f"{key}.{name}")
    elif isinstance(data, list):
        for k, value in enumerate(data):
            yield from _entries(value, f"{key} {k + 1}")


def runs_of_presets(cases: Cases, numbers: Numbers) -> dict[str, dict[str, str]]:
    """Return case that the report shows with two presets -> folder of the run with each."""
    found: dict[str, dict[str, str]] = {}
    for _, _, case, preset in (
        k.split(".") for k in numbers if k.startswith("label.presets.case") and k.count(".") == 3
    ):
        folder = f"{case}_{preset}"
        found.setdefault(case, {})[preset] = folder if (cases.folder / folder).exists() else case
    return found


def _presets(cases: Cases, numbers: Numbers) -> Iterator[Value]:
    for case, folders in runs_of_presets(cases, numbers).items():
        yield f"presets.{case}.case", int(case.removeprefix("case")), "whole"
        groups = [cases.ends(run) for _, run in sorted(folders.items(), key=lambda of: of[0] != USUAL)]
        yield from _difference(f"presets.{case}.difference", groups[0], groups[-1])
        rows = {preset: dict(_of_preset(cases, run)) for preset, run in folders.items()}
        for preset, of in rows.items():
            key = f"presets.{case}.{preset}"
            yield f"{key}.fraction_retained.seeds", len(of["fraction_retained"][0]), "whole"
            for row, (values, digits) in of.items():
                if all(other[row][0] for other in rows.values()):
                    yield from _spread(f"{key}.{row}", values, digits)


def _of_preset(cases: Cases, run: str) -> Iterator[tuple[str, tuple[list[float], str]]]:
    yield "fraction_retained", (cases.ends(run), "3 places")
    for kind in ("formations", "ruptures"):
        yield kind, (cases.of_seeds(run, "events", kind), "whole")
    yield "wall_s", (cases.wall_times(run), "3 digits")
    put_in = cases.of_seeds(run, "initial_liquid_m3")
    for name in RESERVOIRS:
        held = cases.of_seeds(run, "liquid_end_m3", name, factor=100.0)
        yield f"liquid_percent.{name}", ([h / w for h, w in zip(held, put_in, strict=False) if w], "2 places")
