# What accuracy costs, which effects a scene calls for, what stays stable: three studies, each with a page of its own under
# results/studies. Not part of `all`:
#
#   snakemake --cores 2 study_accuracy                              (quick: minutes)
#   snakemake --cores 2 study_accuracy --config study_size=standard (half an hour)
#   snakemake --cores 2 study_accuracy --config study_size=reduced  (the reduced scale: hours)
#   snakemake --cores 2 study_effects
#   snakemake --cores 2 study_stability
#   snakemake --cores 2 studies                                     (all three)
#
# A job is some runs one after the other: a scene with one seed and all its settings, so that what is compared is timed side by
# side; a row of a map; a batch of cases. Every run leaves a file when it is whole, with a hash of what it was made from: a call
# that was cut off goes on with the run it was at, and after an edit of configuration or code the runs that it touches are done again.

from studies.accuracy.study import AccuracyStudy
from studies.effects.study import EffectsStudy
from studies.stability.study import StabilityStudy

try:
    STUDIES = {
        "accuracy": AccuracyStudy(Path("results/studies/accuracy"), STUDY_SIZE, CONFIG),
        "effects": EffectsStudy(Path("results/studies/effects"), config_dir=CONFIG),
        "stability": StabilityStudy(Path("results/studies/stability")),
    }
except PywetError as error:
    raise WorkflowError(str(error))


rule study_job:
    input:
        config=CONFIG_FILES,
    output:
        done=touch("results/studies/{study}/jobs/{job}"),
    params:
        study=lambda wildcards: STUDIES[wildcards.study],
        job="{job}",
        code=CODE,
    log:
        "results/studies/{study}/logs/{job}.log",
    wildcard_constraints:
        study="|".join(STUDIES),
        job=".+",
    threads: lambda wildcards: workflow.cores if wildcards.study == "accuracy" else 1  # nothing runs beside what is timed
    script:
        "../scripts/study.py"


for STUDY in STUDIES:

    rule:
        name:
            f"study_{STUDY}"
        input:
            jobs=[f"results/studies/{STUDY}/jobs/{job}" for job in STUDIES[STUDY].jobs()],
        output:
            page=f"results/studies/{STUDY}.html",
        params:
            study=STUDIES[STUDY],
            job=None,
            code=CODE,
        log:
            f"results/studies/{STUDY}/logs/page.log",
        script:
            "../scripts/study.py"


rule studies:
    input:
        expand("results/studies/{study}.html", study=STUDIES),
    localrule: True
