# The three studies together, each with a page of its own under results/studies. Not part of `all`:
#
#   snakemake --cores 2 studies


rule studies:
    input:
        accuracy=rules.study_accuracy.output,
        stability=rules.study_stability.output,
        effects=rules.study_effects.output,
    localrule: True
