"""A sweep as jobs of Snakemake: list of jobs, resources and execution of each (workflow/rules/sweep.smk).

A job's name contains point, seed and fingerprint, so that a job on a cluster finds its point without checking all others.
"""

from __future__ import annotations

import hashlib
import json
import math
from functools import cached_property
from pathlib import Path

from pywet.cost import needs
from pywet.errors import PywetError
from pywet.sweep import gathering, plan, running, sweep_command, sweep_folder, table
from pywet.sweep.costs import Cost
from pywet.sweep.plan import Plan, Run
from pywet.util.files import write_json

ALL = "all-"
"""Beginning of the name of the only job of a sweep without an engine; the digest of its runs follows."""
DIGITS = 16
LEAST_MB = 1500


class Jobs:
    """Jobs of a sweep's file; properties are computed on access, since every job reads the Snakefile again."""

    def __init__(self, file: Path) -> None:
        self.plan: Plan = plan.read(file)
        self._costs: dict[str, Cost] = {}

    @property
    def folder(self) -> Path:
        return self.plan.folder

    @cached_property
    def missing(self) -> list[str]:
        """Return the names of the missing jobs after a check of the whole sweep; raises for a wrong point or too high cost."""
        costs = self.plan.cost()
        plan.refuse_too_much(self.plan, costs)
        if not self.plan.kind.engine:
            return [ALL + _digest(*(run.built.name for run, _ in costs))] if costs else []
        return [f"{run.point.number}-{run.seed}-{_word(run)}" for run, _ in costs]

    @property
    def files(self) -> list[str]:
        """Return the files that the missing jobs write when they are done."""
        return [f"{self.folder}/jobs/{job}.json" for job in self.missing]

    @property
    def word(self) -> str:
        """Return the digest of all runs, gathered results and their functions: table and page are rebuilt when it changes."""
        names = [run.built.name for run in self.plan.runs]
        return _digest(*names, self.plan.sweep.model_dump_json(), *gathering.stored_names(self.plan))

    def _run(self, job: str) -> Run:
        number, seed, word = job.split("-")
        run = self.plan.run(int(number), int(seed))
        if _word(run) != word:
            raise PywetError(
                f"job {job} is of another state of {self.plan.file}; expected it unchanged while jobs run: call again",
                code="sweep.stale_job", given=job, where=self.plan.file,
            )  # fmt: skip
        return run

    def _cost(self, job: str) -> Cost:
        if job not in self._costs:
            if job.startswith(ALL):
                self._costs[job] = Cost(sum(c.seconds for _, c in self.plan.cost()), 0.0)
            else:
                self._costs[job] = self.plan.cost_of(self._run(job))
        return self._costs[job]

    def memory_mb(self, job: str, attempt: int) -> int:
        """Return the memory to request [MB], doubled with each attempt."""
        return max(LEAST_MB, math.ceil(1.5 * self._cost(job).memory_B / 1e6)) * 2 ** (attempt - 1)

    def minutes(self, job: str, attempt: int) -> int:
        """Return the wall time to request [min], doubled with each attempt; of an unknown cost the sweep's limit."""
        cost = self._cost(job)
        minutes = needs.SAFE * cost.seconds / 60.0 if cost.known else 60.0 * self.plan.sweep.most_core_hours
        return max(needs.LEAST_MIN, math.ceil(minutes)) * 2 ** (attempt - 1)

    def run(self, job: str, done: Path) -> None:
        """Execute a job and write the number of runs with results; a failed run does not fail the job."""
        runs = self.plan.missing if job.startswith(ALL) else [self._run(job)]
        sweep_folder.claim(self.folder, self.plan.file)
        good = sum(running.do(self.plan.kind, run, self.plan.store) for run in runs)
        write_json(done, {"runs": len(runs), "with_results": good})

    def show(self) -> None:
        """Write table and page from the results in the store."""
        sweep_folder.claim(self.folder, self.plan.file)
        for line in sweep_command.finish(self.plan, table.frame(self.plan)):
            print(line)

    def verdict(self, file: Path) -> None:
        """Raise for a sweep with failed runs, whose jobs lose their files so that the next call repeats them."""
        made = table.frame(self.plan)
        failed = made.loc[made["status"] == table.FAILED, ["point", "seed"]]
        for run in self.plan.missing:
            (self.folder / "jobs" / f"{run.point.number}-{run.seed}-{_word(run)}.json").unlink(missing_ok=True)
        if len(failed):
            for done in (self.folder / "jobs").glob(f"{ALL}{'[0-9a-f]' * DIGITS}.json"):
                done.unlink(missing_ok=True)
            raise PywetError(str(sweep_command.failures(made)), code="sweep.failed_jobs", given=len(failed))
        write_json(file, {"runs": len(made), "failed": 0})


def _digest(*parts: str) -> str:
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:DIGITS]


def _word(run: Run) -> str:
    return run.built.name.rpartition("-")[2]
