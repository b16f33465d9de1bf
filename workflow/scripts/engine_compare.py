"""Both engines' runs of all seeds against each other."""

from pathlib import Path

from pywet import stages
from pywet.evidence.engines import screening

folder = Path(snakemake.output.verdict).parent
runs = {engine: [Path(p).parent.parent for p in snakemake.input[engine]] for engine in screening.ENGINES}
with stages.logged(Path(snakemake.log[0]), echo=True):
    print(screening.compare_engines(runs, folder))
