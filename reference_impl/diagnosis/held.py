"""Wrong numbers: their deviation, and likely causes, shared by the sections `scene` and `results`.

A finding has the same fields as in the diagnosis of the logs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.replay.compare import TOLERANCE, Deviations, Quantity, number

MISSING, NONE = "missing", "none"
SHOWN = 12
"""Number of findings of a quantity that are listed individually."""
FACTORS = {
    100.0: "per cent for a share", 1000.0: "thousandths of the unit", 1e-3: "a thousandth", 1e9: "mm3 for m3", 1e6: "cm3 for m3",
    0.5: "half of it", 2.0: "twice", -1.0: "the sign is turned", math.pi / 180.0: "radians taken for degrees",
    180.0 / math.pi: "degrees taken for radians",
}  # fmt: skip


@dataclass(frozen=True)
class Held:
    """One value compared with its expected value; `expected` as a tuple: one of these."""

    name: str
    given: Any
    expected: Any
    source: str
    scale: float | None = None
    """Scale to which a deviation is relative; None: the expected value (1 if that is zero)."""
    allowance: float = 0.0
    """Deviation explained by rounding of the file, in the unit of the value."""
    what: str = ""
    """Description of the error, if already known."""

    @property
    def off(self) -> float:
        """Return the deviation: 0 if equal, 1 for different texts or switches."""
        if isinstance(self.expected, tuple):
            return min(Held(self.name, self.given, one, "", self.scale, self.allowance).off for one in self.expected)
        if _is_number(self.given) and _is_number(self.expected):
            size = self.scale if self.scale is not None else abs(self.expected) or 1.0
            apart = abs(float(self.given) - float(self.expected))
            off = max(0.0, apart - self.allowance) / size
            return min(off, 1e300) if math.isfinite(apart) else 1e300
        return 0.0 if type(self.given) is type(self.expected) and self.given == self.expected else 1.0

    @property
    def wrong(self) -> bool:
        """Return whether the deviation exceeds the tolerance."""
        return not self.off <= TOLERANCE


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float | np.number) and not isinstance(value, bool | np.bool_)


@dataclass
class Section:
    """Results of one section: quantities for the table, findings, sentences on what was and was not compared."""

    name: str
    quantities: list[Quantity] = field(default_factory=list)
    findings: list[dict[str, Any]] = field(default_factory=list)
    compared: list[str] = field(default_factory=list)
    not_checked: list[str] = field(default_factory=list)

    def add(self, quantity: str, scale: str, held: Sequence[Held], what: str) -> None:
        """Add one quantity with many values; wrong ones become findings."""
        off = np.array([h.off for h in held])
        worst = held[int(np.argmax(off))] if held else None
        row: dict[str, Any] = {}
        if worst is not None:
            row = {"number": worst.name, "logged": _plain(worst.given), "reference": _plain(worst.expected)}
        largest = float(off.max(initial=0.0))
        self.quantities.append(
            Quantity(quantity, scale, len(held), largest, TOLERANCE, row, deviations=Deviations(off))
        )
        self.compared.append(f"{len(held)} {what}")
        wrong = [h for h in held if h.wrong]
        for h in wrong[:SHOWN]:
            what_is_wrong = h.what or likeness(h, held)
            self.findings.append(finding(self.name, quantity, h, what_is_wrong, len(wrong), len(held)))

    def as_dict(self) -> dict[str, Any]:
        """Convert the comparison to plain data for replay.json."""
        return {
            "checked": self.any,
            "ok": all(q.ok for q in self.quantities) if self.any else None,
            "compared": self.compared,
            "not_checked": self.not_checked,
            "findings": [f["sentence"] for f in self.findings],
        }

    @property
    def any(self) -> bool:
        """Return whether at least one value was compared."""
        return any(q.count for q in self.quantities)

    @property
    def sentence(self) -> str:
        """Summarise the section in one line: never `agrees` if nothing was compared."""
        if not self.any:
            return f"{self.name}: not checked"
        bad = sum(not q.ok for q in self.quantities)
        return f"{self.name}: {'DISAGREES' if bad else 'agrees'} ({'; '.join(self.compared)})"


def finding(section: str, quantity: str, held: Held, what: str, wrong: int, count: int) -> dict[str, Any]:
    """One wrong number in the form of the diagnosis' findings."""
    expected = " or ".join(map(shown, held.expected)) if isinstance(held.expected, tuple) else shown(held.expected)
    sentence = f"{section}: {held.name} is {shown(held.given)}, expected {expected} ({held.source})" + (
        f"; {what}" if what else ""
    )
    return {
        "sentence": sentence, "what": held.name, "quantities": [quantity], "fault": what or None, "number": None,
        "given": _plain(held.given), "expected": _plain(held.expected), "where": section, "since": "", "first": {},
        "explained": 1 if what else 0, "disagree": wrong, "records": count, "share": 1.0 if what else 0.0, "tried": 0,
        "next_best": None, "alike": [], "consequences": [],
    }  # fmt: skip


def likeness(wrong: Held, held: Sequence[Held]) -> str:
    """Name another value that a wrong value equals, or the factor by which it is wrong."""
    if not _is_number(wrong.given) or not _is_number(wrong.expected):
        return ""
    stem, _, last = wrong.name.rpartition(".")
    stem = "" if ": " in last else stem  # top-level keys of a file are not related
    family = [h for h in held if h is not wrong and _is_number(h.expected)]
    family = [h for h in family if h.name.rpartition(".")[2] == last or (stem and h.name.rpartition(".")[0] == stem)]
    same = [h for h in family if wrong.given != 0 and math.isclose(wrong.given, h.expected, rel_tol=1e-9)]
    # of several numbers with this value prefer the one with which it was swapped
    same.sort(key=lambda h: h.wrong and _is_number(h.given) and h.given == wrong.expected, reverse=True)
    counts = isinstance(wrong.given, int) and isinstance(wrong.expected, int)
    ratio = "" if counts or not wrong.expected else of_factor(wrong.given / wrong.expected)
    return f"it is what {same[0].name} should be" if same else ratio


def of_factor(ratio: float) -> str:
    """Describe a constant factor; empty if it is not a typical mistake."""
    for known, words in FACTORS.items():
        if math.isclose(ratio, known, rel_tol=1e-9):
            return f"it is {known:.6g} times ({words})"
    if not 1e-9 < abs(ratio) < 1e9:
        return ""
    apart = ratio - 1.0
    return (
        f"it is {ratio:.6g} times"
        if abs(apart) > 1e-4
        else f"it is 1 {'+' if apart > 0 else '-'} {abs(apart):.3g} times"
    )


def shown(value: Any) -> str:
    """Format a value for a message."""
    if value is None or isinstance(value, bool | np.bool_ | str):
        return "none" if value is None else str(value).lower() if isinstance(value, bool | np.bool_) else value
    return f"{value:.9g}" if _is_number(value) else str(value)


def _plain(value: Any) -> Any:
    if isinstance(value, tuple | list):
        return [_plain(v) for v in value]
    if isinstance(value, dict):
        return str(value)
    return number(value.item() if hasattr(value, "item") else value)


def column(table: pd.DataFrame, name: str) -> Any:
    """Return a column as floats; NaN for anything but a number."""
    return pd.to_numeric(table[name], errors="coerce").to_numpy(float)
