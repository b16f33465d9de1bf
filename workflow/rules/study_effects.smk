# Which effects a scene calls for. Not part of `all`:
#
#   snakemake --cores 2 study_effects
#
# One job for each scene and first arrangement: all choices of effects run in it one after the other, so that their times can
# be laid side by side. A job that was cut off goes on behind the last run it finished.

from pywet.evidence.effects.scenes import SCENES as EFFECT_SCENES

EFFECT_STUDY = "results/studies"
EFFECT_SEEDS = range(4)


rule study_effects_runs:
    output:
        records=f"{EFFECT_STUDY}/effects/runs/{{scene}}_{{seed}}.json",
    params:
        scene="{scene}",
        seed="{seed}",
    log:
        f"{EFFECT_STUDY}/effects/logs/{{scene}}_{{seed}}.log",
    wildcard_constraints:
        scene="|".join(EFFECT_SCENES),
        seed="[0-9]+",
    script:
        "../scripts/study_effects_runs.py"


rule study_effects:
    input:
        records=expand(rules.study_effects_runs.output.records, scene=EFFECT_SCENES, seed=EFFECT_SEEDS),
    output:
        page=f"{EFFECT_STUDY}/effects.html",
        table=f"{EFFECT_STUDY}/effects/effects.json",
    log:
        f"{EFFECT_STUDY}/effects/logs/page.log",
    script:
        "../scripts/study_effects.py"
