"""All choices of effects of one scene with one seed."""

from pathlib import Path

from pywet import stages
from pywet.evidence.effects import study

given = snakemake.params
with stages.logged(Path(snakemake.log[0]), echo=False):
    study.scene_records(Path(snakemake.output.records).parents[2], given.scene, int(given.seed))
