# Screening of moist particles: every configured case from configuration to cross-check, then one report.
#
#   snakemake --cores 2                          all cases of config/config.yaml at its scale
#   snakemake --cores 2 --config scale=reduced   the same at another scale
#   snakemake --cores 2 --config cases=[2,11]    only these cases; cases=2 for one
#   snakemake --cores 2 --config seed=7          another first arrangement of the spheres
#   snakemake --cores 2 --config engine=yade     in another engine, in results/<scale>_yade
#
# A case that fails does not stop the others: each stage leaves results/<scale>/<case>/status/<stage>.json, the report names
# the reason, and rule verdict ends the call with an error. The next call tries the failed cases again.
#
# `snakemake --lint` asks for a conda environment or a container for each rule: there is one environment for all of them, the
# virtual one that `make setup` builds from pinned versions beside Debian's engine, and snakemake itself runs in it.

import os

from snakemake.utils import min_version

min_version("9.0")


configfile: f"{config.get('config_dir', 'config')}/config.yaml"


include: "workflow/rules/common.smk"
include: "workflow/rules/case.smk"
include: "workflow/rules/report.smk"
include: "workflow/rules/sweep.smk"


if STUDIES_HERE:

    include: "workflow/rules/pages.smk"
    include: "workflow/rules/agreement.smk"
    include: "workflow/rules/engines.smk"
    include: "workflow/rules/studies.smk"


rule all:
    default_target: True
    input:
        report=rules.report.output.report,
        verdict=rules.verdict.output.verdict,
    localrule: True


onsuccess:
    print(SAID if os.path.exists(rules.report.output.report) else "")


onerror:
    print(SAID if os.path.exists(rules.report.output.report) else "")
