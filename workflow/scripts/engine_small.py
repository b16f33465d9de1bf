"""One small scene in all engines: a bed of one seed, or single contacts; what is asked is in params."""

from pathlib import Path

import pandas as pd

from pywet import stages
from studies.engines import bed, contacts
from pywet.util.files import write_table

file = Path(snakemake.output[0])
with stages.logged(Path(snakemake.log[0]), echo=True):
    if "seed" in snakemake.wildcards.keys():
        write_table(bed.settle(file.parent, bed.Bed(seed=int(snakemake.wildcards.seed))), file)
    else:
        write_table(pd.DataFrame(contacts.rows(Path(snakemake.params.config), file.parent)), file, csv=True)
