"""One part of the stability study: a row of a map, a set of hard scenes, a batch of cases, or the page."""

from pathlib import Path

from pywet import stages
from pywet.evidence.stability import hard, maps, report, sweep

if __name__ == "__main__":  # the server that engines are forked from reads this file too
    part = snakemake.params.part
    with stages.logged(Path(snakemake.log[0])):
        if part == "page":
            folder = Path(snakemake.output.cases).parent
            sweep.collect([Path(p) for p in snakemake.input.batches], Path(snakemake.output.cases))
            report.write_page(folder, Path(snakemake.output.page))
        elif part == "map":
            maps.map_row(snakemake.wildcards.map, int(snakemake.wildcards.row), Path(snakemake.output.table).parents[1])
        elif part == "hard":
            hard.hard_scene(snakemake.wildcards.scenes, Path(snakemake.output.table).parents[1])
        else:
            folder = Path(snakemake.output.table).parents[1]
            sweep.batch_of_cases(snakemake.params.seed, int(snakemake.wildcards.batch), folder)
