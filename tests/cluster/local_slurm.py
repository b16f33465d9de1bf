"""A SLURM of this machine alone: Debian's daemons as root on the loopback, started for a test and ended by their own ids."""

from __future__ import annotations

import os
import platform
import secrets
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from pywet.ending import die_with_parent

T = TypeVar("T")
CONF = Path("/etc/slurm/slurm.conf")
"""The steps of a job read it here, whatever SLURM_CONF says."""
TEXT = (Path(__file__).parent / "slurm.conf").read_text()
OURS = TEXT.splitlines()[0]
NODES = ("first", "second")
PATIENCE_S = 900.0
"""Longest wait for anything: a start of Snakemake takes a minute where ten processes share two cores."""
ENDED = {"COMPLETED", "CANCELLED", "TIMEOUT", "FAILED"}


def why_not() -> str | None:
    """Return the reason why SLURM cannot be started here; None if it can."""
    lacking = [name for name in ("munged", "slurmctld", "slurmd", "sbatch") if shutil.which(name) is None]
    if lacking:
        return f"{', '.join(lacking)} not found; `make cluster` installs slurmctld, slurmd, slurm-client and munge with apt"
    if os.geteuid() != 0:
        return "its daemons are started as root"
    if CONF.exists() and not CONF.read_text().startswith(OURS):
        return f"{CONF} is there: this machine has a SLURM of its own"
    return None


@dataclass(frozen=True)
class Job:
    """A row of squeue."""

    number: int
    state: str
    node: str
    minutes: int
    """Time limit [min]."""
    cores: int
    seconds: int
    name: str
    """Rule and case, as Snakemake's plugin says them."""


def ask(*command: str) -> str:
    """Return the output of a program."""
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def seconds_of(text: str) -> int:
    """A time of SLURM, such as 1-02:03:04 or 5:06."""
    days, _, rest = text.rpartition("-")
    parts = [int(part) for part in rest.split(":")]
    total = 0
    for part in parts:
        total = 60 * total + part
    return 86400 * int(days or 0) + total


def jobs() -> list[Job]:
    """All jobs there were, in the order of their submission."""
    rows = [
        line.split("|")
        for line in ask("squeue", "--states=all", "--noheader", "-o", "%i|%T|%N|%l|%C|%M|%k").splitlines()
    ]
    made = [
        Job(int(i), state, node, seconds_of(t) // 60, int(c), seconds_of(m), k) for i, state, node, t, c, m, k in rows
    ]
    return sorted(made, key=lambda job: job.number)


def until(there: Callable[[], T | None], what: str, alive: Callable[[], bool] = lambda: True) -> T:
    """Wait until something is there; fails with its name."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        seen = there()
        if seen:
            return seen
        assert alive(), f"{what} did not come"
        time.sleep(0.05)
    raise AssertionError(f"{what} did not come within {PATIENCE_S:.0f} s")


@contextmanager
def running() -> Iterator[Path]:
    """The daemons at work, until the block is left; their folder, with their logs."""
    folder = Path(tempfile.mkdtemp(prefix="slurm-", dir="/run"))
    folder.chmod(0o755)
    key = folder / "key"
    key.touch(0o600)
    key.write_bytes(secrets.token_bytes(128))
    (folder / "state").mkdir()
    name = platform.node()
    CONF.write_text(TEXT.replace("NAME(", f"{name}(").replace("=NAME ", f"={name} ").replace("FOLDER", str(folder)))
    munge = ["munged", "--foreground", f"--socket={folder}/munge.socket", f"--key-file={key}"]
    munge += [f"--{name}-file={folder}/munged.{name}" for name in ("pid", "log", "seed")]
    daemons: list[subprocess.Popen[bytes]] = []

    def start(*command: str) -> None:
        log = open(folder / f"{len(daemons)}.{command[0]}.log", "w")  # noqa: SIM115 - the daemon's own
        daemons.append(subprocess.Popen(command, stdout=log, stderr=log, preexec_fn=die_with_parent))

    try:
        start(*munge)
        until((folder / "munge.socket").exists, "munged's socket")
        start("slurmctld", "-D")
        for node in NODES:
            start("slurmd", "-D", "-N", node)
        until(lambda: _idle() == len(NODES) or None, "an idle node for each slurmd")
        try:
            yield folder
        finally:
            for job in jobs():
                subprocess.run(["scancel", str(job.number)], check=False)
            until(lambda: {job.state for job in jobs()} <= ENDED or None, "the end of all jobs")
    finally:
        for daemon in reversed(daemons):
            with suppress(ProcessLookupError):
                daemon.send_signal(signal.SIGTERM)
            try:
                daemon.wait(30)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
        CONF.unlink()
        shutil.rmtree(folder, ignore_errors=True)


def _idle() -> int:
    output_text = subprocess.run(["sinfo", "--noheader", "-N", "-o", "%T"], capture_output=True, text=True, check=False)
    return output_text.stdout.split().count("idle")
