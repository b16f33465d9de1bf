# Pages that need no case, each made by its module: wet collisions with a wall and of spheres, and the law atlas (stock programs
# included where they are installed). Not part of `all`:
#
#   snakemake --cores 2 wall_collision sphere_collisions atlas

PAGES = {
    "wall_collision": ("studies.buck2018.buck_page", "wall_collision/index.html"),
    "sphere_collisions": ("studies.davis2023.davis_page", "sphere_collisions/index.html"),
    "atlas": ("studies.law_comparison.page", "atlas/atlas.html"),
}

for NAME, (MODULE, PAGE) in PAGES.items():

    rule:
        name:
            NAME
        output:
            page=f"results/{PAGE}",
        params:
            module=MODULE,
            code=CODE,
        log:
            f"results/{NAME}/logs/page.log",
        threads: lambda wildcards: workflow.cores  # nothing runs beside what is timed
        script:
            "../scripts/page.py"
