# A sweep, `pywet sweep FILE` as jobs of the workflow, on a cluster through its profile. Not part of `all`:
#
#   snakemake --cores 2 sweep --config sweep=FILE
#
# Runs that are in the store are no jobs. A job is one run of the engine, or all runs of a sweep that needs none. A run that fails
# leaves its reason in the store and stops no other; the last rule names it and ends the call with an error, and the next call
# tries it again: the last rule has the files of jobs as inputs too, because Snakemake does not make the missing input of a page
# that is up to date. A function in a file is run where `pywet sweep FILE --check --trust` has let it.

if SWEEP is not None:
    from pywet.sweep import workflow_jobs

    try:
        SWEPT = workflow_jobs.Jobs(Path(SWEEP))
    except PywetError as error:
        raise WorkflowError(str(error))

    rule sweep_run:
        output:
            done=f"{SWEPT.folder}/jobs/{{job}}.json",
        params:
            file=SWEEP,
            job="{job}",
        log:
            f"{SWEPT.folder}/logs/{{job}}.log",
        wildcard_constraints:
            job="all-[0-9a-f]+|[0-9]+-[0-9]+-[0-9a-f]+",
        threads: SWEPT.plan.kind.ranks
        resources:
            mem_mb=lambda wildcards, attempt: SWEPT.memory_mb(wildcards.job, attempt),
            runtime=lambda wildcards, attempt: SWEPT.minutes(wildcards.job, attempt),
        script:
            "../scripts/sweep.py"

    rule sweep_page:
        input:
            runs=lambda wildcards: SWEPT.files,
        output:
            table=f"{SWEPT.folder}/sweep.parquet",
            page=f"{SWEPT.folder}/report.html",
        params:
            code=CODE,
            file=SWEEP,
            job=None,
            runs=lambda wildcards: SWEPT.word,
        log:
            f"{SWEPT.folder}/logs/page.log",
        localrule: True
        script:
            "../scripts/sweep.py"

    rule sweep:
        input:
            runs=lambda wildcards: SWEPT.files,
            table=rules.sweep_page.output.table,
            page=rules.sweep_page.output.page,
        output:
            verdict=f"{SWEPT.folder}/verdict.txt",
        params:
            file=SWEEP,
            job=None,
            runs=lambda wildcards: SWEPT.word,
        log:
            f"{SWEPT.folder}/logs/verdict.log",
        localrule: True
        script:
            "../scripts/sweep.py"
