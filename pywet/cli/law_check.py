"""Print the result of `pywet laws --check LAW` and return the exit code."""

from __future__ import annotations

from dataclasses import asdict

from rich.table import Table

from pywet.cli.showing import out, tell
from pywet.laws import checks, custom_laws

GOOD, WRONG = 0, 1


def run(name: str, as_json: bool) -> int:
    """Check a law and print the findings; return 1 if it violates a requirement."""
    name = custom_laws.placed(name)
    custom_laws.trust([name])
    kind = checks.kind_of(name)
    found = checks.findings(kind, name)
    wrong = any(finding.ok is False for finding in found)
    rows = [] if wrong else list(checks.compared(kind, name))
    if as_json:
        exact = [{**asdict(row), "deviation": row.deviation} for row in rows]
        out.print_json(data={"law": name, "kind": kind, "findings": [asdict(f) for f in found], "exact": exact})
        return WRONG if wrong else GOOD
    tell(f"{kind} law {name}")
    for finding in found:
        word = {True: "good ", False: "WRONG", None: "     "}[finding.ok]
        tell(f"{word}  {finding.check}: {finding.found}", "red" if finding.ok is False else None)
    if rows:
        out.print(_table(rows, *(("mN", 1e3) if kind == "capillary" else ("µm", 1e6))))
        for line in checks.judged(kind, rows):
            tell(line)
    return WRONG if wrong else GOOD


def _table(rows: list[checks.Compared], unit: str, per_si: float) -> Table:
    table = Table(
        "bodies", "V/r³", "gap in µm", f"law in {unit}", f"exact in {unit}", "deviation", box=None, header_style="bold"
    )
    for row in rows:
        gap = "" if row.gap_m is None else f"{1e6 * row.gap_m:.4g}"
        numbers = (
            f"{row.reduced_volume:g}",
            gap,
            f"{per_si * row.value:.4g}",
            f"{per_si * row.exact:.4g}",
            f"{100 * row.deviation:{'+.0f' if abs(row.deviation) >= 0.1 else '+.2g'}} %",
        )
        table.add_row(row.bodies, *numbers)
    return table
