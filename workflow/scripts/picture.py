"""Picture of the first moist case that is done; an empty file where there is none."""

from pathlib import Path

from pywet import stages

out = Path(snakemake.output.picture)
with stages.logged(Path(snakemake.log[0])):
    moist = stages.first_moist([out.parent / name for name in snakemake.params.cases])
    if moist is None:
        out.touch()
    else:
        from pywet.report import render

        print(f"{moist.name} drawn by", render.write(moist, out))
