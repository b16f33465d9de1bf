# The same dry case in LIGGGHTS and YADE with several seeds, and small scenes in all engines. Not part of `all`:
#
#   snakemake --cores 2 engines

ENGINES = "results/crosscheck"
ENGINE_CASE = 1
ENGINE_SEEDS = [10007, 10009, 10037, 10039, 10061, 10067, 10069, 10079, 10091, 10093, 10099, 10103]
"""Twelve runs of each engine: ten seconds of computing in LIGGGHTS, half a minute in YADE."""


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
        code=CODE,
    log:
        f"{ENGINES}/logs/{{engine}}_{{seed}}.log",
    script:
        "../scripts/engine_run.py"


rule engine_contacts:
    input:
        config=CONFIG_FILES,
    output:
        rows=f"{ENGINES}/contacts/rows.parquet",
    params:
        config=CONFIG,
        code=CODE,
    log:
        f"{ENGINES}/logs/contacts.log",
    script:
        "../scripts/engine_small.py"


rule engine_bed:
    output:
        table=f"{ENGINES}/bed/seed{{seed}}/bed.parquet",
    wildcard_constraints:
        seed="[0-9]+",
    params:
        code=CODE,
    log:
        f"{ENGINES}/logs/bed_{{seed}}.log",
    script:
        "../scripts/engine_small.py"


rule engines:
    input:
        expand(rules.engine_run.output.table, engine=["liggghts", "yade"], seed=ENGINE_SEEDS),
        rules.engine_contacts.output.rows,
        expand(rules.engine_bed.output.table, seed=[1, 2, 3, 4, 5]),
