"""One job of a study, or its page."""

from pathlib import Path

from pywet import stages

if __name__ == "__main__":  # the fork server of the engines also reads this file
    study, job = snakemake.params.study, snakemake.params.job
    say = lambda name, share: print(f"{100 * share:3.0f} % {name}", flush=True)
    with stages.logged(Path(snakemake.log[0])):
        study.carry_out(say) if job is None else study.do(job, say)
