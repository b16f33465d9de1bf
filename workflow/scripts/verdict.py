"""End with an error when a case failed or is not to be believed; failed stages are forgotten, so the next call tries again."""

import sys
from pathlib import Path

from pywet import stages

out = Path(snakemake.output.verdict)
with stages.logged(Path(snakemake.log[0]), echo=True):
    lines = stages.judge([out.parent / name for name in snakemake.params.runs])
    if lines:
        print(*lines, sep="\n")
        sys.exit(f"{len(lines)} objections; see {snakemake.input.report}")
out.write_text(f"{len(snakemake.params.cases)} of {len(snakemake.params.cases)} cases done\n")
