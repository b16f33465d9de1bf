"""Remove the lock of a killed Snakemake, or list its processes that are still running.

`make run` calls this first. A killed Snakemake leaves its lock, and its jobs continue to run. The lock of another user,
or of a `make run` on another machine, whose processes cannot be seen here, is left.
"""

from __future__ import annotations

import os
import platform
import sys
from pathlib import Path

from pywet.errors import border

LOCKS = Path(".snakemake/locks")
HOST = Path(".snakemake/host")
"""File with the name of the machine on which `make run` was called last."""
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
    locks, host = list((folder / LOCKS).glob("*.lock")), folder / HOST
    if locks and (other := _elsewhere(locks, host)):
        return (
            f"a Snakemake of {other} has locked {folder.resolve()}; wait for it, or, if it was killed, call "
            "`snakemake --unlock`"
        )
    if locks and (obstacle := _at_work(folder)):
        return obstacle
    for lock in locks:
        lock.unlink(missing_ok=True)
    if locks:
        print("the lock of a Snakemake that was killed is taken away; what it had begun is made again", flush=True)
    host.parent.mkdir(exist_ok=True)
    host.write_text(platform.node())
    return None


def _elsewhere(locks: list[Path], host: Path) -> str | None:
    """Return the owner of locks whose processes cannot be seen: another user, or a `make run` on another machine."""
    try:
        users = {lock.stat().st_uid for lock in locks}
    except FileNotFoundError:  # released meanwhile
        return None
    if os.geteuid() not in (0, *users):
        return f"user {min(users)}"
    there = host.read_text() if host.exists() else platform.node()
    return None if there == platform.node() else f"the machine {there}"


def _at_work(folder: Path) -> str | None:
    """Return a sentence on the processes of this machine that work in a folder, or None."""
    mains, jobs = at_work(folder)
    kill = f"`kill {' '.join(map(str, mains or jobs))}`"
    if mains:
        return f"a Snakemake is running in {folder.resolve()}; wait for it, or stop it by {kill}"
    if jobs:
        return (
            f"a Snakemake that worked in {folder.resolve()} was killed, but its jobs still work; wait for them, or stop "
            f"them by {kill}, then call again"
        )
    return None


if __name__ == "__main__":
    with border():
        sys.exit(release(Path(os.getcwd())))
