# The law atlas: every law against the exact bridge, stock programs included where they are installed. Not part of `all`:
#
#   snakemake --cores 2 atlas


rule atlas:
    output:
        page="results/atlas/atlas.html",
    log:
        "results/atlas/logs/atlas.log",
    threads: lambda wildcards: workflow.cores  # nothing runs beside what is timed
    script:
        "../scripts/atlas.py"
