"""Command line: python -m reference_impl RUN_DIR [--out FILE]."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from reference_impl.io import ReplayError
from reference_impl.replay import replay, table


def main() -> int:
    """Replay one run directory."""
    parser = argparse.ArgumentParser(prog="reference_impl", description="independent replay of a moist run")
    parser.add_argument("run_dir", type=Path)
    parser.add_argument(
        "--out", type=Path, default=None, help="where to write the result (default RUN_DIR/replay.json)"
    )
    given = parser.parse_args()
    try:
        result = replay(given.run_dir, given.out)
    except ReplayError as error:
        print(error, file=sys.stderr)
        return 2
    print(table(result))
    return 0 if result["ok"] else 1


if __name__ == "__main__":
    sys.exit(main())
