# The wet collision of a sphere with a wall: figures, tables and a page of their own. Not part of `all`:
#
#   snakemake --cores 2 wall_collision

from pywet.collisions import ITEMS

COLLISIONS = "results/wall_collision"


rule wall_collision_item:
    output:
        table=f"{COLLISIONS}/{{item}}.csv",
    params:
        item="{item}",
    log:
        f"{COLLISIONS}/logs/{{item}}.log",
    threads: lambda wildcards: workflow.cores if wildcards.item == "accuracy" else 1  # nothing runs beside what is timed
    wildcard_constraints:
        item="|".join(ITEMS),
    script:
        "../scripts/wall_collision_item.py"


rule wall_collision:
    input:
        tables=expand(rules.wall_collision_item.output.table, item=ITEMS),
    output:
        page=f"{COLLISIONS}/index.html",
    params:
        module="pywet.collisions.wall.buck_page",
    log:
        f"{COLLISIONS}/logs/page.log",
    script:
        "../scripts/page.py"
