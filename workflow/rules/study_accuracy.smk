# What accuracy costs: every setting against a finer one, error against price. Not part of `all`:
#
#   snakemake --cores 2 study_accuracy                              (quick: minutes)
#   snakemake --cores 2 study_accuracy --config study_size=standard (half an hour)
#   snakemake --cores 2 study_accuracy --config study_size=reduced  (the reduced scale: hours)
#
# A job is a round: a scene with one seed, all its settings in turn, so that what is compared is timed side by side. Every run in
# it leaves its own file under runs/ when it is whole; a call that was cut off goes on with the run it was at.

from pywet.evidence.accuracy import runs as accuracy_runs

ACCURACY = "results/studies/accuracy"
try:
    ACCURACY_ROUNDS = accuracy_runs.rounds(STUDY_SIZE)
except PywetError as error:
    raise WorkflowError(str(error))


rule study_accuracy_round:
    input:
        config=CONFIG_FILES,
    output:
        done=f"{ACCURACY}/rounds/{STUDY_SIZE}/{{scene}}-{{seed}}.json",
    params:
        size=STUDY_SIZE,
        config=CONFIG,
    log:
        f"{ACCURACY}/logs/{STUDY_SIZE}/{{scene}}-{{seed}}.log",
    wildcard_constraints:
        scene="|".join(accuracy_runs.KNOBS_OF),
        seed="[0-9]+",
    threads: workflow.cores  # nothing runs beside what is timed
    script:
        "../scripts/study_accuracy_round.py"


rule study_accuracy:
    input:
        rounds=expand(
            rules.study_accuracy_round.output.done,
            zip,
            scene=[scene for scene, _ in ACCURACY_ROUNDS],
            seed=[seed for _, seed in ACCURACY_ROUNDS],
        ),
    output:
        page="results/studies/accuracy.html",
        mark=touch(f"{ACCURACY}/rounds/{STUDY_SIZE}/page"),  # so that another size makes the page anew
    params:
        size=STUDY_SIZE,
        config=CONFIG,
    log:
        f"{ACCURACY}/logs/page.log",
    script:
        "../scripts/study_accuracy.py"
