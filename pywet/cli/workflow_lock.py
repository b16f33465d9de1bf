"""Remove the lock of a killed Snakemake, or list its processes that are still running.

`make run` calls this first. A killed Snakemake leaves its lock, and its jobs continue to run.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from pywet.errors import border

LOCKS = Path(".snakemake/locks")
SCRIPTS = ".snakemake/scripts/"
"""Part of the command line of every Snakemake job."""


def at_work(folder: Path) -> tuple[list[int], list[int]]:
    """Return the processes of this machine that run in a folder: those of Snakemake, and those of its jobs."""
    mains, jobs = [], []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            words = (entry / "cmdline").read_bytes().decode(errors="replace").split("\0")
            here = (entry / "cwd").resolve() == folder.resolve()
        except OSError:  # the process has ended, or belongs to another user
            continue
        if here and any(SCRIPTS in word for word in words):
            jobs.append(int(entry.name))
        elif here and any(Path(word).name == "snakemake" for word in words[:3]):
            mains.append(int(entry.name))
    return sorted(mains), sorted(jobs)


def release(folder: Path) -> str | None:
    """Remove the lock of a folder if none of its processes runs; return the obstacle in one sentence, or None."""
    locks = list((folder / LOCKS).glob("*.lock"))
    if not locks:
        return None
    mains, jobs = at_work(folder)
    kill = f"`kill {' '.join(map(str, mains or jobs))}`"
    if mains:
        return f"a Snakemake is running in {folder.resolve()}; wait for it, or stop it by {kill}"
    if jobs:
        return (
            f"a Snakemake that worked in {folder.resolve()} was killed, but its jobs still work; wait for them, or stop "
            f"them by {kill}, then call again"
        )
    for lock in locks:
        lock.unlink(missing_ok=True)
    print("the lock of a Snakemake that was killed is taken away; what it had begun is made again", flush=True)
    return None


if __name__ == "__main__":
    with border():
        sys.exit(release(Path(os.getcwd())))
