"""The numbers in the tables of a report, parsed back and compared with the files they come from."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

from reference_impl.replay.io import parquet_table

CASES = {
    "steps": ("steps",), "wall s": ("wall_s",), "Y at end": ("fraction_retained_end",), "cannot pass": ("coarse_share",),
    "formations": ("events", "formations"), "ruptures": ("events", "ruptures"),
}  # fmt: skip
"""Column of the table of cases -> where it stands in summary.json."""
LEDGER = {
    "coarse material": "coarse_material", "fines": "fines", "wires": "wires", "side walls": "side_wall", "feed bin": "feed_bin",
    "outlet": "outlet", "impact plate": "impact_plate", "collecting bin": "collecting_bin", "left": "left",
    "of which in bridges": "standing_bridges",
}  # fmt: skip
FORCES = {"dry contacts, normal": "contact_normal", "dry contacts, tangential": "contact_tangential"}
HOLDERS = {
    "on the screen: large": "coarse_material_large", "on the screen: near mesh": "coarse_material_near_mesh",
    "on the screen: small": "coarse_material_small", "fines in the bin": "fines", "wires": "wires", "side walls": "side_wall",
    "feed bin and slide": "feed_bin", "outlet": "outlet", "impact plate": "impact_plate", "collecting bin": "collecting_bin",
}  # fmt: skip
"""Who holds liquid, in the words of figures and tables -> column, but for its unit."""
Told = tuple[str, str, float | None, str]
"""Where a number stands, its text, what it should be, and how it is rounded: `3 digits`, `2 places`, `unit`, `whole`, `power`."""


def sections(text: str, name: str) -> list[str]:
    """HTML of the sections of a name."""
    return re.findall(rf'<section id="{name}">.*?</section>', text, re.DOTALL)


def section(text: str, name: str) -> str:
    """HTML of one section; empty where there is none."""
    return next(iter(sections(text, name)), "")


def presets(part: str) -> tuple[int, tuple[str, str]] | None:
    """Of which case a section shows two presets, and which."""
    message = re.search(r"<p>Case (\d+) once with <code>(\w+)</code>.*?once with <code>(\w+)</code>", part, re.DOTALL)
    return (int(message[1]), (message[2], message[3])) if message else None


def table(text: str) -> list[list[str]]:
    """The words in the cells of the first table, row by row; a line break is a bar."""
    return next(every_table(text), [])


def every_table(text: str) -> Iterator[list[list[str]]]:
    """Read every table of the report; columns by case are divided into several tables."""
    for inner in re.findall(r"<table>.*?</table>", text, re.DOTALL):
        rows = re.findall(r"<tr.*?>(.*?)</tr>", inner, re.DOTALL)
        yield [[_words(cell) for cell in re.findall(r"<t[hd].*?>(.*?)</t[hd]>", row, re.DOTALL)] for row in rows]


def _words(cell: str) -> str:
    return plain(cell.replace("<br>", " | "))


def plain(text: str) -> str:
    """Remove the markup from HTML."""
    return " ".join(html.unescape(re.sub(r"<[^>]*>", "", text)).split())


def summary(folder: Path, number: int) -> dict[str, Any] | None:
    """Read summary.json of a case."""
    return of_case(folder, number, "summary.json")


def retained_end(folder: Path, number: int, data: Mapping[str, Any]) -> float:
    """Fraction retained at the end, the mean over the case's seeds: its own folder and those named caseNN-SEED."""
    return float(np.mean(retained_ends(folder, number, data)))


def retained_ends(folder: Path, number: int, data: Mapping[str, Any]) -> list[float]:
    """Fraction retained at the end, of every seed of a case."""
    seeds = (run / "results" / "fraction_retained.parquet" for run in seed_folders(folder, f"case{number:02d}"))
    further = [float(parquet_table(path)["fraction_retained"].iloc[-1]) for path in seeds]
    return [float(data["fraction_retained_end"]), *further]


def seed_folders(folder: Path, name: str) -> list[Path]:
    """Folders of a case's further seeds, named caseNN-SEED."""
    there = (path.parent.parent for path in folder.glob(f"{name}-*/results/fraction_retained.parquet"))
    return sorted(path for path in there if path.name.removeprefix(f"{name}-").isdigit())


def of_seeds(folder: Path, name: str, path: tuple[str, ...], factor: float = 1.0) -> list[float]:
    """A number of summary.json by its keys, of a case's folder and of those of its further seeds that have one."""
    files = [run / "summary.json" for run in (folder / name, *seed_folders(folder, name))]
    values = [_deep(json.loads(file.read_text()), path) for file in files if file.exists()]
    return [factor * v for v in values if v is not None] if values and values[0] is not None else []


def spread(where: str, text: str, values: Sequence[float], digits: str) -> Iterator[Told]:
    """A number of several seeds, mean ± half width of its 95 % interval to the places that are shown; of one as `digits` says."""
    if len(values) < 2:
        yield where, text, values[0] if values else None, digits
        return
    shown, _, rest = text.removesuffix(" %").partition(" ± ")
    places = f"{len(shown.partition('.')[2])} places"
    half = float(stats.t.ppf(0.975, len(values) - 1) * np.std(values, ddof=1) / np.sqrt(len(values)))
    yield f"{where}, mean", shown, float(np.mean(values)), places
    yield f"{where}, interval", rest, half, places if half else "whole"


def of_case(folder: Path, number: int, name: str, suffix: str = "") -> Any:
    """A JSON file of a case, None where there is none; `suffix` of the folder's name."""
    path = folder / f"case{number:02d}{suffix}" / name
    return json.loads(path.read_text()) if path.exists() else None


def agrees(text: str, value: float | None, digits: str) -> bool:
    """Whether a text shows a value to its digits."""
    if value is None or text in ("–", ""):
        return value is None and text in ("–", "")
    match = re.fullmatch(r"([-−]?\d+(?:\.\d+)?(?:e[-−+]?\d+)?)( %)?", text)
    if match is None:
        return False
    shown, value = float(match[1].replace("−", "-")), 100.0 * value if match[2] else value
    if digits == "whole":
        return shown == value
    if digits == "unit" or digits.endswith("places"):
        return abs(shown - value) <= 0.500001 * 10.0 ** -(0 if digits == "unit" else int(digits[0]))
    if shown == 0 or value == 0:
        return shown == value
    stored = 2 if digits == "power" else int(digits[0])
    return abs(shown - value) <= 0.500001 * 10.0 ** (np.floor(np.log10(abs(value))) + 1 - stored)


def check(text: str, folder: Path, cases: list[int]) -> tuple[int, list[str]]:
    """How many numbers were read, and sentences on those that are wrong."""
    reported = [*_cases(text, folder), *_ledger(text, folder), *_agreement(text, folder), *_effects(text, folder),
            *_contributed(text, folder), *_passed(text, folder, cases), *_cards(text, folder, cases)]  # fmt: skip
    return len(reported), wrong_of(reported)


def wrong_of(reported: list[Told]) -> list[str]:
    """Sentences on the numbers that are wrong."""
    return [f"{where}: {shown!r} is shown; expected {value if value is None else f'{value:.6g}'}"
             for where, shown, value, digits in reported if not agrees(shown, value, digits)]  # fmt: skip


def _deep(data: Any, path: tuple[str, ...]) -> Any:
    for name in path:
        data = data.get(name) if data is not None else None
    return data


def _cases(text: str, folder: Path) -> Iterator[Told]:
    head, *rows = table(section(text, "cases")) or [[]]
    for row in rows:
        data = summary(folder, int(row[0]))
        if data is None or len(row) != len(head):
            continue
        where = f"table of cases, case {row[0]}"
        yield f"{where}, spheres", row[head.index("spheres")], sum(data["spheres"].values()), "whole"
        for name, path in CASES.items():
            whole = path[0] in ("steps", "events")
            values = of_seeds(folder, f"case{int(row[0]):02d}", path)
            values = values[:1] if name in ("steps", "cannot pass") else values
            values = retained_ends(folder, int(row[0]), data) if name == "Y at end" else values
            yield from spread(f"{where}, {name}", row[head.index(name)], values, "whole" if whole else "3 digits")


def _ledger(text: str, folder: Path) -> Iterator[Told]:
    head, *rows = table(section(text, "ledger")) or [[]]
    for row in rows:
        data = summary(folder, int(row[0]))
        where = f"liquid ledger, case {row[0]}"
        if data is None:
            yield f"{where}, case", row[0], None, "whole"
            continue
        run = f"case{int(row[0]):02d}"
        put_in = of_seeds(folder, run, ("initial_liquid_m3",), 1e9)
        yield from spread(f"{where}, put in", row[head.index("put in")], put_in, "5 digits")
        for name, key in LEDGER.items():
            ends = of_seeds(folder, run, ("liquid_end_m3", key), 1e9)
            yield from spread(f"{where}, {name}", row[head.index(name)], ends, "4 digits")
        worst = max(of_seeds(folder, run, ("ledger_error",)), default=None)
        yield f"{where}, largest error", row[head.index("largest error")], worst, "power"


def _agreement(text: str, folder: Path) -> Iterator[Told]:
    for head, *rows in every_table(section(text, "agreement")):
        columns = {k: int(name.split()[1]) for k, name in enumerate(head) if name.startswith("case ")}
        replays = {number: of_case(folder, number, "replay.json") for number in columns.values()}
        for row in rows:
            for k, number in columns.items():
                compared = (replays[number] or {"quantities": {}})["quantities"]
                known = {name.replace("_", " "): q for name, q in compared.items()}
                quantity, where = known.get(row[0]), f"cross-check, {row[0]}, case {number}"
                if quantity is None:
                    yield where, row[k], None, "power"
                    continue
                largest, _, median = row[k].partition(" | ")
                yield f"{where}, largest", largest, quantity["largest"], "power"
                yield f"{where}, median", median, quantity["median"], "power"


def _effects(text: str, folder: Path) -> Iterator[Told]:
    for head, *rows in every_table(section(text, "effects")):
        for row in rows:
            for k, name in enumerate(head[2:], 2):
                plan = of_case(folder, int(name), "plan.json")
                known = {r["effect"].replace("_", " "): r["number"] for r in plan["rows"]} if plan else {}
                yield f"effects, {row[0]}, case {name}", row[k], known.get(row[0]), "2 digits"


def _contributed(text: str, folder: Path) -> Iterator[Told]:
    for head, *rows in every_table(section(text, "contributed")):
        for row in rows:
            for k, name in enumerate(head[2:], 2):
                data = of_case(folder, int(name), "contributions.json") or {"effects": {}}
                audited = {r["effect"]: r for r in (of_case(folder, int(name), "audit.json") or {}).get("rows", [])}
                key = FORCES.get(row[0], row[0].replace(" ", "_"))
                where = f"contributions, {row[0]}, case {name}"
                shown, _, predicted = row[k].partition(" | predicted ")
                value = (
                    audited[key]["measured"] if key in audited else data["effects"].get(key, {}).get("impulse_share")
                )
                if shown.endswith("%"):
                    yield where, shown, value, "2 digits" if (value or 0) < 0.995 else "3 digits"
                if predicted:
                    yield f"{where}, predicted", predicted, audited.get(key, {}).get("predicted"), "2 digits"


def _passed(text: str, folder: Path, cases: list[int]) -> Iterator[Told]:
    """The first table: what is retained at the end, and what has passed of what can."""
    _, *rows = table(section(text, "answer")) or [[]]
    left = list(cases)
    for row in rows:
        configs = {n: of_case(folder, n, "config.json") for n in left}
        for name, retained, passed in re.findall(
            r"(dry|\S+ % liquid): (\S+(?: ± \S+)?)(?: \(\d+ seeds\))?, (\S+(?: ± \S+)? %) passed", row[2]
        ):
            amount = 0.0 if name == "dry" else float(name.split()[0])
            cases_of = {n: c["case"] for n, c in configs.items() if c}
            same = [n for n, c in cases_of.items() if (title(c), c["liquid_percent"]) == (row[0], amount)]
            where = f"first table, {row[0]}, {name}"
            data = summary(folder, same[0]) if same else None
            if not same or data is None:
                yield f"{where}: no such case", retained, None, "3 digits"
                continue
            ends, coarse = retained_ends(folder, same[0], data), data["coarse_share"]
            shares = [100.0 * (1.0 - end) / (1.0 - coarse) for end in ends]
            yield from spread(f"{where}, retained", retained, ends, "3 digits")
            yield from spread(f"{where}, passed", passed.removesuffix(" %"), shares, "unit")
            yield f"{where}, cannot pass", row[1], coarse, "3 digits"


def title(case: Mapping[str, Any]) -> str:
    """A case but for its liquid, in the report's words."""
    sizes = "/".join(f"{float(case[f'{c}_mm']):g}" for c in ("small", "near_mesh", "large"))
    return f"{case['material']} {sizes} mm, {screen(case)}"


def screen(case: Mapping[str, Any]) -> str:
    """Aperture and amplitude of a case in the report's words."""
    return f"a = {float(case['aperture_mm']):g} mm, A = {float(case['set_amplitude_mm']):g} mm"


def _cards(text: str, folder: Path, cases: list[int]) -> Iterator[Told]:
    """The numbers on top that are the worst of all cases."""
    message = {words: value for value, words in re.findall(r"<b>(.*?)</b><span>(.*?)</span>", text)}
    errors = [error for n in cases for error in of_seeds(folder, f"case{n:02d}", ("ledger_error",))]
    replays = [r["quantities"].values() for n in cases if (r := of_case(folder, n, "replay.json"))]
    worst = [q["largest"] for rows in replays for q in rows if q["tolerance"] <= 1e-9]
    for words, values in (("largest error of the liquid ledger", errors), ("largest relative deviation", worst)):
        shown = next((value for name, value in message.items() if name.startswith(words)), "–")
        yield f"card, {words}", shown, max(values, default=None), "power"
