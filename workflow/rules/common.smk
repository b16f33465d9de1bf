# Checked configuration and the paths that follow from it. Nothing here needs the engine, a plugin or a result.

from functools import cache
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.utils import validate

from pywet import config as settings
from pywet import stages
from pywet.engines.choice import chosen as engine_of
from pywet.errors import PywetError
from pywet.cost.needs import need
from pywet.runs.record import reference_word
from pywet.cases.screening.identity import content, expect, fingerprint_or_reason
from pywet.shipped import open_studies, place
from pywet.util import sources

STUDIES_HERE = open_studies()
"""Whether this is a checkout, which has the studies; a wheel does not."""
STUDY_SIZE = config.pop("study_size", "quick")
"""Size of the accuracy study, `--config study_size=standard` or `reduced`; not part of config.yaml."""

ENGINE = str(config.pop("engine", "liggghts"))
"""In which the cases run, `--config engine=yade`; not part of config.yaml."""
SWEEP = config.pop("sweep", None)
"""File of a sweep, `--config sweep=FILE`; not part of config.yaml."""
CONFIG = Path(config.pop("config_dir", "config"))
"""Folder of the configuration, `--config config_dir=DIR`; `--config` replaces scale, cases, ranks, both_presets, seed and seeds of its
config.yaml."""
try:
    CONFIGURED = stages.resolved(CONFIG, engine=ENGINE)
    CHOSEN = settings.chosen(settings.load(CONFIG).settings, config)
    engine_of(ENGINE, CHOSEN.ranks)
    CASES = {CONFIGURED.case(number).name: number for number in CHOSEN.cases}
    CONFIGURED.scale(CHOSEN.scale)
except PywetError as error:
    raise WorkflowError(str(error))
config.update(CHOSEN.model_dump(mode="json", include=settings.REPLACED))
validate(config, "../schemas/config.schema.json")



def job_memory(stage):
    """Memory [MB] of a case's job, from the number of its spheres; doubled where a job is tried again."""
    return lambda wildcards, attempt: _needs(wildcards.case, lambda n: n.memory_mb(attempt, stage), 1000)


def core_memory(wildcards, attempt):
    """Memory [MB] of each core of a simulation, which SLURM's plugin requests instead of mem_mb, which is that of each node."""
    return -(-job_memory("simulate")(wildcards, attempt) // CHOSEN.ranks)


def job_minutes(wildcards, attempt):
    """Wall time of the engine [min], from the prediction; the same."""
    return _needs(wildcards.case, lambda n: n.minutes(attempt), 30)


@cache
def _need(number):
    return need(CONFIGURED, number, SCALE, CHOSEN.ranks)


def _needs(case, ask, otherwise):
    """A scene that cannot be built needs little; its own stage says why."""
    try:
        return ask(_need(RUNS[case][0]))
    except PywetError:
        return otherwise


COMPARISONS = settings.preset_comparisons(CONFIGURED, CASES, CHOSEN.both_presets)
"""Folder name of a case that runs again with another preset -> (its number, that preset); none or one."""
RUNS = {
    (name if seed == CHOSEN.seed else f"{name}-{seed}"): (number, preset, seed)
    for seed in range(CHOSEN.seed, CHOSEN.seed + CHOSEN.seeds)
    for name, (number, preset) in {**{name: (number, None) for name, number in CASES.items()}, **COMPARISONS}.items()
}
"""Folder name of a run -> (number of its case, preset where it is another, seed)."""
SCALE = CHOSEN.scale
OWN = "" if CONFIG == Path("config") else f"{CONFIG.resolve().name}/"
ROOT = f"results/{OWN}{SCALE}" + ("" if ENGINE == "liggghts" else f"_{ENGINE}")
"""All results of this call; one folder for each case. Those of another folder of the configuration, or of another engine, have
one of its name."""
PART = "" if set(CHOSEN.cases) == set(CONFIGURED.settings.cases) else "_cases" + "-".join(map(str, CHOSEN.cases))
"""After the name of report, picture and verdict where only some cases are asked for: those of all cases stay as they are."""
SAID = f"The report is in {ROOT}/report{PART}.html"
LOGS = f"{ROOT}/logs"
CODE = sources.digest_of_program()
"""Parameter of every rule that draws, tabulates or computes by code of which no fingerprint of its inputs knows."""
CONFIG_FILES = [str(CONFIG / name) for name in settings.FILES]


@cache
def fingerprint(case):
    """File with the fingerprint that a run must have; newer than the run where the run there, whoever made it, has another."""
    number, preset, seed = RUNS[case]
    word = f"{ENGINE} {fingerprint_or_reason(CONFIGURED.with_seed(seed), number, SCALE, preset)}"
    return str(expect(Path(ROOT) / case, word, Path(".snakemake") / "fingerprints" / ROOT / case))


wildcard_constraints:
    case="case[0-9]+(_exact)?(-[0-9]+)?",
