"""What the report says in words, read as sentences and held against the files: the answer, the proof, how many cases, the laws,
what was simulated, the assumptions, and the table of both presets.

A sentence that cannot be found is a fault too. Numbers come back as the tables' do; words that do not hold as sentences.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from reference_impl.replay.io import parquet_table
from reference_impl.shown import tables
from reference_impl.shown.tables import Told

PRESETS = {
    "bridges formed": (("events", "formations"), "whole"),
    "bridges ruptured": (("events", "ruptures"), "whole"), "wall time in s": (("wall_s",), "3 digits"),
}  # fmt: skip
SIEVES = {"round": "cylinder", "square": "square"}
LOST = 1e-12
"""Share of the liquid beyond which it is not whole."""


class Cases:
    """Files of the listed cases, as the report should show them."""

    def __init__(self, folder: Path, listed: Sequence[int], liquid: Mapping[int, float]) -> None:
        self.folder, self.listed, self.liquid = folder, listed, liquid
        self.summary = {n: tables.summary(folder, n) for n in listed}
        self.replay = {n: self.json(n, "replay.json") for n in listed}
        self.config = {n: self.json(n, "config.json") for n in listed}
        self.first = next((c for c in self.config.values() if c and "scale" in c), None)
        self.moist = [n for n in listed if self._bridged(n)]

    def json(self, number: int, name: str, suffix: str = "") -> Any:
        """Read a JSON file of a case."""
        return tables.of_case(self.folder, number, name, suffix)

    def _bridged(self, number: int) -> bool:
        data = self.summary[number]
        return bool(data["effects"]["bridges"] if data else self.liquid[number])

    def quantities(self, number: int) -> dict[str, Any]:
        """List the quantities that the replay of a case compared."""
        return dict((self.replay[number] or {"quantities": {}})["quantities"])

    def agrees(self, number: int) -> bool:
        """Whether it was replayed and nothing is beyond its limit."""
        rows = self.quantities(number).values()
        return bool(rows) and all(q["largest"] <= q["tolerance"] for q in rows)

    def done(self, number: int) -> bool:
        """Whether every stage went well and nothing objects to what it left."""
        data = self.summary[number]
        stages = [
            self.json(number, f"status/{name}.json") for name in ("scene", "simulate", "results", "replay", "vtk")
        ]
        if data is None or not all(stage and stage["ok"] for stage in stages):
            return False
        whole = data["ledger_error"] is None or data["ledger_error"] <= LOST
        checks = all(c["ok"] for c in data["checks"])
        return checks and whole and (self.agrees(number) or not (self.moist.count(number) or self.quantities(number)))

    def passed(self, moist: bool) -> list[float]:
        """Per cent of the mass that can pass which has passed, of the dry cases or the others."""
        rows = [(n, s) for n, s in self.summary.items() if s and self.config[n] and bool(self._liquid(n)) == moist]
        return [100.0 * (1.0 - tables.retained_end(self.folder, n, s)) / (1.0 - s["coarse_share"]) for n, s in rows]

    def _liquid(self, number: int) -> float:
        return float(self.config[number]["case"]["liquid_percent"])


def check(text: str, folder: Path, listed: Sequence[int], liquid: Mapping[int, float]) -> tuple[list[Told], list[str]]:
    """Numbers that the sentences tell, and sentences that do not hold; `liquid`: per cent of each case, run or not."""
    cases, wrong = Cases(folder, listed, liquid), []
    reported = [*_lead(text, cases), *_cards(text, cases), *_work(text, cases), *_simulated(text, cases), *_assumed(text, cases),
            *_presets(text, cases)]  # fmt: skip
    wrong += [*_proof(text, cases), *_laws(text, cases), *_not_done(text, cases)]
    return reported, wrong


def _one(text: str, pattern: str) -> str:
    found = re.search(pattern, text, re.DOTALL)
    return tables.plain(found[1]) if found else ""


def _lead(text: str, cases: Cases) -> Iterator[Told]:
    """The answer in the head of the page."""
    message = _one(text, r"<header>.*?<p>(.*?)</p>")
    yield "head, cases", _one(message, r"(\d+) cases? of batch screening"), len(cases.listed), "whole"
    times = [t for n in cases.listed if (t := _end(cases, n, "fraction_retained", "time_since_opening_s")) is not None]
    if not times:
        return
    yield "head, time", _one(message, r"passed (\S+) s after"), times[0], "2 digits"
    for name, moist in (("dry", False), ("moist", True)):
        shares = cases.passed(moist)
        words = re.search(rf"(\d\S*)(?: ± \S+)?(?: to (\d\S*)(?: ± \S+)?)? % {name}", message)
        if (
            shares and "% with" not in message
        ):  # of one configuration each amount is told by itself, as in the first table
            yield f"head, least passed {name}", words[1] if words else "", min(shares), "unit"
            yield f"head, most passed {name}", (words[2] or words[1]) if words else "", max(shares), "unit"


def _end(cases: Cases, number: int, name: str, column: str, suffix: str = "") -> float | None:
    """Last value of a column of a case's results."""
    path = cases.folder / f"case{number:02d}{suffix}" / "results" / f"{name}.parquet"
    if not path.exists():
        return None
    table = parquet_table(path)
    return float(table[column].iloc[-1]) if column in table else None


def _cards(text: str, cases: Cases) -> Iterator[Told]:
    """Check the numbers on the cards at the top of the report."""
    good = {"cases done": (sum(map(cases.done, cases.listed)), len(cases.listed)),
            "moist cases cross-checked": (sum(map(cases.agrees, cases.moist)), len(cases.moist))}  # fmt: skip
    for name, wanted in good.items():
        shown = re.search(rf"<b>(\d+) of (\d+)</b><span>{name}", text)
        for k, what in enumerate(("done", "of")):
            yield f"card, {name}, {what}", shown[k + 1] if shown else "", wanted[k], "whole"
    replayed = [n for n in cases.listed if cases.quantities(n)]
    names = {name for n in replayed for name in cases.quantities(n)}
    if names:
        shown = re.search(r"<summary>(\d+) quantities of (\d+) cases?, one by one", text)
        yield "cross-check, quantities", shown[1] if shown else "", len(names), "whole"
        yield "cross-check, cases", shown[2] if shown else "", len(replayed), "whole"


def _proof(text: str, cases: Cases) -> Iterator[str]:
    """Whether what is said of the proof is so, wherever it is said."""
    bad = [n for n in cases.moist if not cases.agrees(n)]
    names = {name for n in cases.listed for name in cases.quantities(n)}
    errors = [e for n in cases.moist for e in tables.of_seeds(cases.folder, f"case{n:02d}", ("ledger_error",))]
    whole = "; no liquid is lost" if errors and max(errors) <= LOST else ""
    agrees = f"an independent reference recomputed every moist case and agrees on all {len(names)} quantities{whole}."
    unknown = any((cases.replay[n] or {}).get("unchecked") for n in cases.moist)
    nothing = any((cases.replay[n] or {}).get("nothing_compared") for n in cases.listed)
    wanted = f"Bookkeeping and forces recomputed{' in part' if nothing else ''}"
    wanted += " but for laws that the reference does not know: of the rest, " if unknown else ": "
    wanted += agrees
    if bad:
        groups = [("The independent reference disagrees", [n for n in bad if cases.quantities(n)]),
                  ("Not cross-checked", [n for n in bad if not cases.quantities(n)])]  # fmt: skip
        wanted = " ".join(
            f"{start}: case{'s' if len(of) > 1 else ''} {', '.join(map(str, of))}." for start, of in groups if of
        )
    if not cases.moist:
        wanted = "Nothing moist to cross-check."
    for message in re.findall(r'<p class="proof">(.*?)</p>', text, re.DOTALL):
        if tables.plain(message) != wanted:
            yield f"the proof is said to be {tables.plain(message)!r}; expected {wanted!r}"


def _laws(text: str, cases: Cases) -> Iterator[str]:
    """The laws of each case against its plan."""
    message = _one(tables.section(text, "cases"), r"<p>Laws: (.*?)\.</p>")
    for words in filter(None, message.split("; ")):
        numbers, _, listed = words.partition(": ")
        for number in map(int, re.findall(r"\d+", numbers)):
            plan = cases.json(number, "plan.json") or {"rows": []}
            used = [f"{r['effect'].replace('_', ' ')}: {r['law']}" for r in plan["rows"] if r["on"] and r.get("law")]
            if listed != (", ".join(used) or "dry contacts only"):
                yield f"laws of case {number} are said to be {listed!r}; expected {', '.join(used) or 'dry contacts only'!r}"
    reported = {int(n) for words in message.split("; ") for n in re.findall(r"\d+", words.partition(": ")[0])}
    for number in cases.listed:
        if number not in reported and cases.json(number, "plan.json"):
            yield f"laws of case {number} are not said"


def _not_done(text: str, cases: Cases) -> Iterator[str]:
    """The list of what is not done."""
    named = {int(n) for n in re.findall(r"<li><b>case(\d+)</b>", text)}
    for number in cases.listed:
        if (number in named) == cases.done(number):
            yield f"case {number} is {'' if number in named else 'not '}listed as not done; expected the contrary"


def _work(text: str, cases: Cases) -> Iterator[Told]:
    """Check the sentence on time and size of all runs together."""
    rows = [s for s in cases.summary.values() if s]
    message = re.search(r"<p>(\S+) min of engine time for (\S+) million sphere-steps", text)
    yield "engine time", message[1] if message else "", sum(s["wall_s"] for s in rows) / 60.0, "2 digits"
    steps = sum(s["steps"] * sum(s["spheres"].values()) for s in rows) / 1e6
    yield "sphere-steps", message[2] if message else "", steps, "3 digits"


def _simulated(text: str, cases: Cases) -> Iterator[Told]:
    """How the scale departs from the experiment, against the configuration of the first case that has one."""
    config = cases.first
    if config is None:
        return
    scale, message = config["scale"], _one(text, r"<h3>What was simulated</h3>(.*?)</ul>")
    sieve = re.search(r"screen is a (\S+) mm (round|square) sieve", message)
    yield "simulated, width", sieve[1] if sieve else "", scale["width_mm"]["value"], "6 digits"
    yield "simulated, shape", "1" if sieve and SIEVES[sieve[2]] == scale["shape"] else "0", 1.0, "whole"
    feed = config["materials"]["feed"]["sieve_diameter_mm"]["value"]
    yield "simulated, the paper's sieve", _one(message, r"feed on a (\S+) mm sieve"), feed, "6 digits"
    factor = scale["stiffness_factor"]["value"]
    if factor < 1.0:
        yield "simulated, softening", _one(message, r"softened to (\S+) of"), factor, "6 digits"
        yield "simulated, collisions", _one(message, r"take (\S+) times as long"), factor**-0.5, "3 digits"
    lasts = re.search(r"Each run lasts (\S+) s, of which (\S+) s pass", message)
    yield "simulated, duration", lasts[1] if lasts else "", scale["duration_s"]["value"], "6 digits"
    yield "simulated, opening", lasts[2] if lasts else "", scale["slide_opens_at_s"]["value"], "6 digits"


def _assumed(text: str, cases: Cases) -> Iterator[Told]:
    """The table of assumptions: each number where its name leads in the configuration, none left out."""
    config = cases.first
    if config is None:
        return
    rows = {row[0]: row for row in tables.table(tables.section(text, "assumptions"))[1:]}
    parts = {name: config[name] for name in ("apparatus", "materials", "settings")}
    wanted = dict(_entries({**parts, f"scale {config['scale']['name']}": config["scale"]}))
    yield "assumptions, how many", _one(text, r"<summary>(\d+) assumed values"), len(rows), "whole"
    for name, entry in wanted.items():
        row, value = rows.get(name), entry.get("value", entry.get("material", ""))
        same = row is not None and row[2] == " ".join(str(entry["reason"]).split())
        yield f"assumption {name}, reason", "1" if same else "0", 1.0, "whole"
        if isinstance(value, int | float):
            yield f"assumption {name}", row[1] if row else "", value, "6 digits"
        else:
            yield f"assumption {name}", "1" if row and row[1] == str(value) else "0", 1.0, "whole"


def _entries(data: Any, name: str = "") -> Iterator[tuple[str, dict[str, Any]]]:
    """Name and entry of every assumed value, named as the report does."""
    if isinstance(data, dict):
        if data.get("source") == "assumption":
            yield name.replace("_", " "), data
            return
        for key, value in data.items():
            yield from _entries(value, f"{name} · {key}" if name else key)
    elif isinstance(data, list):
        for k, value in enumerate(data):
            yield from _entries(value, f"{name} {k + 1}")


def _presets(text: str, cases: Cases) -> Iterator[Told]:
    """Check the report's table of one case with two presets, column by column."""
    for part in tables.sections(text, "presets"):
        head, *rows = tables.table(part) or [[]]
        pair = tables.presets(part)
        if pair is None or not rows:
            continue
        number, names = pair
        yield f"presets, case {number}, columns", "1" if tuple(head[1:]) == names else "0", 1.0, "whole"
        for column, preset in enumerate(names, 1):
            suffix = f"_{preset}" if (cases.folder / f"case{number:02d}_{preset}").exists() else ""
            for row in rows:
                where, run = f"presets, {row[0]}, {preset}", f"case{number:02d}{suffix}"
                if row[0] == "fraction retained":  # of one seed, or mean ± interval, and of how many
                    yield from tables.spread(where, row[column].split(",")[0], _retained(cases, run), "3 places")
                elif row[0] in PRESETS:
                    key, digits = PRESETS[row[0]]
                    yield from tables.spread(where, row[column], tables.of_seeds(cases.folder, run, key), digits)
                else:
                    held = _held(cases, run, row[0].removeprefix("liquid "))
                    text = row[column].removesuffix(" %")
                    yield from tables.spread(where, text, held, "2 places")


def _retained(cases: Cases, run: str) -> list[float]:
    """Fraction retained at the end, of all seeds of a case."""
    folders = [cases.folder / run, *tables.seed_folders(cases.folder, run)]
    paths = [folder / "results" / "fraction_retained.parquet" for folder in folders]
    return [float(parquet_table(path)["fraction_retained"].iloc[-1]) for path in paths if path.exists()]


def _held(cases: Cases, run: str, label: str) -> list[float]:
    """Per cent of the liquid that a reservoir has at the end, of all seeds."""
    name = tables.HOLDERS.get(label, "")
    held = tables.of_seeds(cases.folder, run, ("liquid_end_m3", name), 100.0)
    return [h / w for h, w in zip(held, tables.of_seeds(cases.folder, run, ("initial_liquid_m3",)), strict=True)]
