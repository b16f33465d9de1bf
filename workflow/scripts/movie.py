"""Movie of a case and its loop; asked for by name, no target needs them."""

from pathlib import Path

from pywet import stages

video = Path(snakemake.output.video)
with stages.logged(Path(snakemake.log[0])):
    from pywet.report import movie

    movie.write(video.parent)
