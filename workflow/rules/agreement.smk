# The table of agreement: every quantity by every program. Not part of `all`:
#
#   snakemake --cores 2 agreement
#
# A source that fails leaves its reason in its file, and the page is made with its cells blank. What `engines` and the screening
# cases have left in results/ is read where it is there, so run this target after them.

from pywet.agreement.sources import SOURCES

AGREEMENT = "results/agreement"
READ = {"screening": "*/case*/replay.json", "engines": "crosscheck/**/*.parquet"}
"""What the last two sources read of other targets' results."""


def agreement_found(source):
    """Files of other targets that a source would read now, with their times: when these change, it runs again."""
    if source not in READ:
        return []
    return sorted(f"{path} {path.stat().st_mtime:.0f}" for path in Path("results").glob(READ[source]))


rule agreement_source:
    output:
        data=f"{AGREEMENT}/data/{{source}}.json",
    params:
        source="{source}",
        # what is read is there or not: no input, but a reason to run again
        found=lambda wildcards: agreement_found(wildcards.source),
    log:
        f"{AGREEMENT}/logs/{{source}}.log",
    wildcard_constraints:
        source="|".join(SOURCES),
    script:
        "../scripts/agreement_source.py"


rule agreement:
    input:
        data=expand(rules.agreement_source.output.data, source=SOURCES),
    output:
        page=f"{AGREEMENT}/index.html",
        table=f"{AGREEMENT}/table.json",
    log:
        f"{AGREEMENT}/logs/page.log",
    script:
        "../scripts/agreement.py"
