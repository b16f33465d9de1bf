"""A job of a sweep: its runs, its table and page, or the sentence on what failed; which one is in params and output."""

from pathlib import Path

from pywet import stages
from pywet.engines.choice import refuse_fewer_cores
from pywet.sweep import workflow_jobs

jobs = workflow_jobs.Jobs(Path(snakemake.params.file))
with stages.logged(Path(snakemake.log[0]), echo=True):
    if snakemake.params.job is not None:
        refuse_fewer_cores(jobs.plan.kind.ranks, snakemake.threads)
        jobs.run(snakemake.params.job, Path(snakemake.output.done))
    elif "verdict" in snakemake.output.keys():
        jobs.verdict(Path(snakemake.output.verdict))
    else:
        jobs.show()
