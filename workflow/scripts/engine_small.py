"""One small scene in all engines: the pulls, a bed of one seed, or all beds together; what is asked is in params."""

from pathlib import Path

from pywet import stages
from pywet.evidence.engines import small_scenes

with stages.logged(Path(snakemake.log[0]), echo=True):
    small_scenes.write(
        snakemake.params.what,
        [Path(p) for p in snakemake.input],
        [Path(p) for p in snakemake.output],
        int(snakemake.params.get("seed", 1)),
    )
