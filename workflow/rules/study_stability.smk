# What stays stable: maps, hard scenes, random hard cases, one page. One job for each row of a map and each batch of cases, so
# that a study that was cut off goes on. Not part of `all`:
#
#   snakemake --cores 2 study_stability

STABILITY = "results/studies/stability"
STABILITY_MAPS = {"step_explicit": 6, "step_semi_implicit": 6, "stiffness": 7, "ratio": 7, "angle": 7}
"""Rows of each map (a test compares them with the package)."""
STABILITY_HARD = ["plain", "ten_g", "ten_times", "thick", "unwetted", "mismatch", "bare", "guards"]
STABILITY_SEED, STABILITY_BATCHES = 1, 40


rule study_stability_map:
    output:
        table=f"{STABILITY}/maps/{{map}}-{{row}}.csv",
    log:
        f"{STABILITY}/logs/map-{{map}}-{{row}}.log",
    params:
        part="map",
    wildcard_constraints:
        row="[0-9]+",
    script:
        "../scripts/study_stability.py"


rule study_stability_hard:
    output:
        table=f"{STABILITY}/hard/{{scenes}}.csv",
    log:
        f"{STABILITY}/logs/hard-{{scenes}}.log",
    params:
        part="hard",
    script:
        "../scripts/study_stability.py"


rule study_stability_cases:
    output:
        table=f"{STABILITY}/batches/{STABILITY_SEED}-{{batch}}.csv",
    log:
        f"{STABILITY}/logs/cases-{{batch}}.log",
    params:
        part="cases",
        seed=STABILITY_SEED,
    wildcard_constraints:
        batch="[0-9]+",
    script:
        "../scripts/study_stability.py"


rule study_stability:
    input:
        maps=[f"{STABILITY}/maps/{name}-{row:02d}.csv" for name, rows in STABILITY_MAPS.items() for row in range(rows)],
        hard=expand(rules.study_stability_hard.output.table, scenes=STABILITY_HARD),
        batches=[f"{STABILITY}/batches/{STABILITY_SEED}-{n:03d}.csv" for n in range(STABILITY_BATCHES)],
    output:
        page=f"{STABILITY}.html",
        cases=f"{STABILITY}/cases.csv",
    log:
        f"{STABILITY}/logs/page.log",
    params:
        part="page",
    script:
        "../scripts/study_stability.py"
