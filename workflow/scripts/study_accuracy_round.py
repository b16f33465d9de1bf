"""One round of the accuracy study; runs that are kept already are not done again."""

from pathlib import Path

from pywet import stages
from pywet.files import write_json
from pywet.evidence.accuracy import runs

say = lambda name, done, of: print(f"{done + 1} of {of}: {name}", flush=True)
with stages.logged(Path(snakemake.log[0])):
    made = runs.do_round(
        Path(snakemake.output.done).parents[2],
        snakemake.wildcards.scene,
        int(snakemake.wildcards.seed),
        snakemake.params.size,
        Path(snakemake.params.config),
        say,
    )
    write_json(Path(snakemake.output.done), [path.name for path in made])
