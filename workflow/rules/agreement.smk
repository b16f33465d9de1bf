# The table of agreement: every quantity by every program. Not part of `all`:
#
#   snakemake --cores 2 agreement
#
# A source that fails leaves its reason in its file, and the page is made with its cells blank. What `engines` and the screening
# cases have left in results/ is read where it is there, so run this target after them.

from studies.cross_code.sources import SOURCES, left_by_others

AGREEMENT = "results/agreement"


rule agreement_source:
    output:
        data=f"{AGREEMENT}/data/{{source}}.json",
    params:
        source="{source}",
        code=CODE,
        # what is read is there or not: no input, but a reason to run again
        found=lambda wildcards: left_by_others(wildcards.source, Path(AGREEMENT).parent),
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
    params:
        module="studies.cross_code.page",
        code=CODE,
    log:
        f"{AGREEMENT}/logs/page.log",
    script:
        "../scripts/page.py"
