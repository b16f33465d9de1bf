# The same dry case in LIGGGHTS and YADE with several seeds, and small scenes in all engines. Not part of `all`:
#
#   snakemake --cores 2 engines

ENGINES = "results/crosscheck"
ENGINE_CASE = 1
ENGINE_SEEDS = [10007, 10009, 10037, 10039, 10061, 10067, 10069, 10079]
"""Eight runs each: 12870 ways to split them."""


rule engine_run:
    input:
        config=CONFIG_FILES,
    output:
        table=f"{ENGINES}/dry/{{engine}}/seed{{seed}}/results/fraction_retained.parquet",
    wildcard_constraints:
        engine="liggghts|yade",
        seed="[0-9]+",
    params:
        config=CONFIG,
        case=ENGINE_CASE,
        scale="smoke",
    log:
        f"{ENGINES}/logs/{{engine}}_{{seed}}.log",
    script:
        "../scripts/engine_run.py"


rule engine_compare:
    input:
        liggghts=expand(rules.engine_run.output.table, engine="liggghts", seed=ENGINE_SEEDS),
        yade=expand(rules.engine_run.output.table, engine="yade", seed=ENGINE_SEEDS),
    output:
        verdict=f"{ENGINES}/dry/verdict.json",
        table=f"{ENGINES}/dry/fraction_retained.parquet",
        rows=f"{ENGINES}/dry/rows.parquet",
        picture=f"{ENGINES}/dry/engines_screening.png",
    log:
        f"{ENGINES}/logs/compare.log",
    script:
        "../scripts/engine_compare.py"
