"""Runs scenes with a plugin built from other sources, one forked process a scene: the libraries and laws are loaded once.

`python -m tests.engines.liggghts.planted_worker SOURCES`, then lines `FAULT<tab>RUN_DIR<tab>ENGINE_FOLDER` on standard input;
answers with the exit status of each on standard output. The fault reaches the plugin as the variable PYWET_PLANTED.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from pywet.engines.liggghts import build, plugin_api, worker


def one(fault: str, run_dir: str, folder: str) -> int:
    """Run a scene in a child of this process; returns its exit status."""
    child = os.fork()
    if child == 0:
        status = 1
        try:
            os.environ["PYWET_PLANTED"] = fault
            output = os.open(f"{folder}/output.log", os.O_WRONLY | os.O_CREAT)
            os.dup2(output, 1)
            os.dup2(output, 2)
            worker.run(Path(run_dir), Path(folder))
            status = 0
        except Exception as error:
            print(f"ERROR: {error}", file=sys.stderr, flush=True)
        finally:
            os._exit(status)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def main() -> None:
    """Build, then answer until the input ends."""
    build.SOURCES = Path(sys.argv[1])
    build.FLAGS = ["-O1" if flag == "-O3" else flag for flag in build.FLAGS]
    plugin_api.engine_version()
    build.plugin_path()
    print("ready", flush=True)
    for line in sys.stdin:
        print(one(*line.rstrip("\n").split("\t")), flush=True)


if __name__ == "__main__":
    main()
