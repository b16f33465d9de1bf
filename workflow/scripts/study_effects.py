"""Judge the effect plans and write the page."""

from pathlib import Path

from pywet import stages
from pywet.evidence.effects import study

with stages.logged(Path(snakemake.log[0]), echo=True):
    out_dir = Path(snakemake.output.page).parent
    print("\n".join(study.finish(out_dir, [Path(path) for path in snakemake.input.records])))
