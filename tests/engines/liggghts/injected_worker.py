"""The process of a `Foundry` for LIGGGHTS: `python -m tests.engines.liggghts.injected_worker SOURCES`."""

from __future__ import annotations

import sys
from pathlib import Path

from pywet.engines.liggghts import build, plugin_api, worker
from tests.engines import foundry


def main() -> None:
    """Build, then answer until the input ends."""
    build.SOURCES = Path(sys.argv[1])
    foundry.quick_build()
    plugin_api.engine_version()
    build.plugin_path()
    foundry.serve(worker.run)


if __name__ == "__main__":
    main()
