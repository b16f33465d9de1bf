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


rule engine_pulls:
    output:
        rows=f"{ENGINES}/pulls/rows.parquet",
        limits=f"{ENGINES}/pulls/limits.parquet",
        picture=f"{ENGINES}/pulls/engines_pulls.png",
    params:
        what="pulls",
    log:
        f"{ENGINES}/logs/pulls.log",
    script:
        "../scripts/engine_small.py"


rule engine_contacts:
    input:
        config=CONFIG_FILES,
    output:
        rows=f"{ENGINES}/contacts/rows.parquet",
    params:
        what="contacts",
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
        what="bed",
        seed="{seed}",
    log:
        f"{ENGINES}/logs/bed_{{seed}}.log",
    script:
        "../scripts/engine_small.py"


rule engine_beds:
    input:
        expand(rules.engine_bed.output.table, seed=[1, 2, 3, 4, 5]),
    output:
        rows=f"{ENGINES}/bed/rows.parquet",
        picture=f"{ENGINES}/bed/engines_bed.png",
    params:
        what="beds",
    log:
        f"{ENGINES}/logs/beds.log",
    script:
        "../scripts/engine_small.py"


rule engines:
    input:
        rules.engine_compare.output.rows,
        rules.engine_contacts.output.rows,
        rules.engine_pulls.output.rows,
        rules.engine_beds.output.rows,
    output:
        f"{ENGINES}/engines.parquet",
    params:
        what="all",
    log:
        f"{ENGINES}/logs/engines.log",
    script:
        "../scripts/engine_small.py"
