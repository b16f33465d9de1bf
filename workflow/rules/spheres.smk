# Collisions of wet spheres: figures of Davis 2023, map of outcomes, table of its numbers. Not part of `all`:
#
#   snakemake --cores 2 sphere_collisions

SPHERES = "results/sphere_collisions"


rule sphere_figures:
    output:
        figures=[
            f"{SPHERES}/{name}.png"
            for name in (
                "figure_05",
                "figure_07",
                "figure_08",
                "figure_11",
                "figure_13b",
                "figure_14",
                "figure_15",
                "accuracy_cost",
                "engine",
            )
        ],
    log:
        f"{SPHERES}/logs/figures.log",
    script:
        "../scripts/sphere_figures.py"


rule sphere_sweeps:
    output:
        figures=[
            f"{SPHERES}/{name}.png"
            for name in (
                "figure_06",
                "figure_09",
                "figure_10a",
                "figure_10b",
                "figure_12a",
                "figure_12b",
                "figure_13a",
                "outcome_map",
            )
        ],
    params:
        grid=60,
    log:
        f"{SPHERES}/logs/sweeps.log",
    threads: 2
    script:
        "../scripts/sphere_sweeps.py"


rule sphere_collisions:
    input:
        rules.sphere_figures.output.figures,
        rules.sphere_sweeps.output.figures,
    output:
        page=f"{SPHERES}/index.html",
        numbers=f"{SPHERES}/numbers.json",
    params:
        module="pywet.collisions.spheres.davis_page",
    log:
        f"{SPHERES}/logs/page.log",
    script:
        "../scripts/page.py"
