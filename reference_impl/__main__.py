"""Command line: python -m reference_impl RUN_DIR … [--json] [--out FILE]."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from reference_impl import faults
from reference_impl.replay import command


def main() -> int:
    """Replay run directories."""
    parser = argparse.ArgumentParser(
        prog="reference_impl",
        description="independent replay of moist runs",
        epilog="exit status: 0 agrees, 1 beyond a tolerance, 2 a run is not whole or cannot be read, 70 a fault of this program",
    )
    parser.add_argument("run_dirs", type=Path, nargs="+", metavar="RUN_DIR")
    parser.add_argument("--json", action="store_true", help="print JSON (of several runs a list) in place of the table")
    parser.add_argument("--out", type=Path, help="where to write the result of one run (default RUN_DIR/replay.json)")
    parser.add_argument(
        "--reference",
        action="append",
        default=[],
        metavar="KIND=FILE:FUNCTION",
        help="user reference implementation of a custom law",
    )
    given = parser.parse_args()
    if not all("=" in text for text in given.reference):
        parser.error("--reference is KIND=FILE:FUNCTION, such as capillary=my_reference.py:neck")
    functions = dict(text.split("=", 1) for text in given.reference)
    if given.out and len(given.run_dirs) > 1:
        parser.error("--out is for one RUN_DIR")
    with faults.border(2):
        return command.run(given.run_dirs, given.json, given.out, lambda folder: functions)


if __name__ == "__main__":
    sys.exit(main())
