"""Compare the effect plan with the replay's measurements: predicted and measured share, and whether the plan was correct.

Reads plan.json and contributions.json of a run directory, writes audit.json next to them. A plan is wrong if an
effect that it left out or called negligible contributes more than its tolerance, or if a predicted share and the
measured one differ by more than the tolerance and by more than the stated accuracy factor of the prediction. (The
number that decides an effect is compared with the measurement only if no share was predicted: it need not be a share
itself.)
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from pywet.laws.kinds import FORCES, OPT_IN
from pywet.runs.rundir import RunDir
from pywet.runs.shapes import Contributions
from pywet.util.file_list import remove
from pywet.util.files import read_model, write_json

FILE = "audit.json"
WITHIN = 3.0
"""Accuracy factor of a predicted share if its row states none."""
MEASURES = {
    "dynamic_rupture": ("mean_stretch", "mean stretch of the rupture distance"),
    "wall_films": ("liquid_share", "liquid drawn from and given to walls, over all that moved"),
    "sharing_by_size": ("liquid_share", "liquid moved against equal sharing, over all that was shared out"),
    "shedding": ("liquid_share", "liquid that let go as drops, over all"),
}
"""Effect -> its measure in contributions.json; all others are measured by their share of impulse."""
WITHOUT_MEASURE = "formation"
"""Effect without which no bridge exists, and for which no share is measured."""
IMPULSE = "share of impulse"
OTHER_NAMES = {"gravity": "weight", "tangential_history": "contact_tangential"}
Verdict = Literal["as planned", "small", "wrong", "not measured"]
OK: Verdict = "as planned"
SMALL: Verdict = "small"
WRONG: Verdict = "wrong"
UNKNOWN: Verdict = "not measured"


@dataclass(frozen=True)
class AuditRow:
    """One effect: `verdict` is one of OK, SMALL (on, yet below the tolerance), WRONG, UNKNOWN; `text` describes it."""

    effect: str
    on: bool
    measure: str
    predicted: float | None
    within: float | None
    measured: float | None
    tolerance: float
    verdict: Verdict
    text: str


@dataclass(frozen=True)
class _Audit:
    """Content of audit.json: effects of the plan compared with their measured shares."""

    plan_right: bool
    rows: list[AuditRow]


def rows(plan: dict[str, Any], contributions: dict[str, Any]) -> list[AuditRow]:
    """Compare every effect of a plan with its measured contribution."""
    return [_row(row, contributions["effects"]) for row in plan["rows"]]


def _row(row: dict[str, Any], measured: dict[str, Any]) -> AuditRow:
    effect, on = row["effect"], bool(row["on"])
    value, measure = _measured(effect, measured)
    predicted, tolerance = row.get("predicted_share"), float(row["threshold"])
    # a measured share of impulse is compared only with a predicted share
    within = float(row.get("predicted_within") or WITHIN) if predicted is not None and measure == IMPULSE else None
    verdict, text = _judge(row, value, predicted if within else None, within, tolerance)
    return AuditRow(effect, on, measure, predicted if within else None, within, value, tolerance, verdict, text)


def _measured(effect: str, measured: dict[str, Any]) -> tuple[float | None, str]:
    """Return the measure of an effect and its name; for bridges as a whole, all their forces together."""
    if effect == "bridges":
        shares = [measured[name]["impulse_share"] or 0.0 for name in FORCES if measured[name]["acting"]]
        return sum(shares), IMPULSE
    entry = measured.get(OTHER_NAMES.get(effect, effect))
    key, name = MEASURES.get(effect, ("impulse_share", IMPULSE))
    # without liquid, effects of walls, sizes and dynamic rupture cannot contribute
    return (entry.get(key) if entry is not None else 0.0 if effect in MEASURES else None), name


def _judge(
    row: dict[str, Any], value: float | None, predicted: float | None, within: float | None, tolerance: float
) -> tuple[Verdict, str]:
    if row["effect"] == WITHOUT_MEASURE:
        return OK, "part of every bridge's life" if row["on"] else "no bridges"
    if value is None:
        return UNKNOWN, "the replay measured nothing of it"
    if not row["on"]:
        if row["effect"] in OPT_IN:
            message = f"would contribute {value:.2g}" if value else "what it would do was not measured"
            return OK, f"in no preset, left out; {message}"
        if value > tolerance:
            return WRONG, f"plan wrong: left out but contributes {value:.2g}, more than the tolerance {tolerance:g}"
        return OK, f"left out, would contribute {value:.2g}" if value else "left out"
    if predicted is not None and within is not None:
        low, high = sorted((value, predicted))
        if high - low > tolerance and high > within * low:
            return (
                WRONG,
                f"predicted {predicted:.2g}, measured {value:.2g}: beyond the stated factor {within:g}",
            )
    if value < tolerance:
        if float(row["number"]) < tolerance:
            return OK, f"negligible as its number says ({value:.2g}), on all the same"
        return SMALL, f"on but contributes only {value:.2g}, less than the tolerance {tolerance:g}"
    if float(row["number"]) < tolerance and predicted is None:
        return WRONG, f"plan wrong: called negligible but contributes {value:.2g}, more than {tolerance:g}"
    return OK, f"contributes {value:.2g}"


def write(run_dir: Path) -> list[AuditRow] | None:
    """Write audit.json; None (and no file) without a plan or without measurements."""
    folder = Path(run_dir)
    if not folder.is_dir():
        return None
    run = RunDir(folder)
    plan, measured = run.plan, run.json("contributions.json", Contributions)
    if plan is None or measured is None:
        remove(folder, FILE)
        return None
    audited = rows(plan, measured)
    write_json(
        folder / FILE, {"plan_right": all(r.verdict != WRONG for r in audited), "rows": [asdict(r) for r in audited]}
    )
    return audited


def read(run_dir: Path) -> list[AuditRow] | None:
    """Return the rows of audit.json, None if there is none."""
    path = Path(run_dir) / FILE
    return read_model(path, _Audit, f"run `pywet replay {run_dir}` again").rows if path.exists() else None


def lines(audited: list[AuditRow]) -> list[str]:
    """Format the audit for printing, one line per effect."""
    return [
        f"{r.effect:<19}{'on ' if r.on else 'off'}  predicted {_number(r.predicted):>8}  measured {_number(r.measured):>8}  "
        f"{'<-- ' if r.verdict == WRONG else ''}{r.text}"
        for r in audited
    ]


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.2g}"
