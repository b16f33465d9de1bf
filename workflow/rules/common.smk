# Checked configuration and the paths that follow from it. Nothing here needs the engine, a plugin or a result.

from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.utils import validate

from pywet import config as settings
from pywet.errors import PywetError
from pywet.runs.second import word
from pywet.screening.identity import content, told
from pywet.shipped import place

STUDY_SIZE = config.pop("study_size", "quick")
"""Size of the accuracy study, `--config study_size=standard` or `reduced`; not part of config.yaml."""

CONFIG = Path(config.pop("config_dir", "config"))
"""Folder of the configuration, `--config config_dir=DIR`; `--config` replaces scale, cases, ranks, both_presets and seed of its
config.yaml."""
try:
    CONFIGURED = settings.load(CONFIG)
    CHOSEN = settings.chosen(CONFIGURED.settings, config)
    CASES = {CONFIGURED.case(number).name: number for number in CHOSEN.cases}
    CONFIGURED.scale(CHOSEN.scale)
except PywetError as error:
    raise WorkflowError(str(error))
config.update(CHOSEN.model_dump(mode="json", include=settings.REPLACED))
validate(config, "../schemas/config.schema.json")

TWINS = settings.twins(CONFIGURED, CASES, CHOSEN.both_presets)
"""Folder name of a case that runs again with another preset -> (its number, that preset); none or one."""
RUNS = {**{name: (number, None) for name, number in CASES.items()}, **TWINS}
SCALE = CHOSEN.scale
OWN = "" if CONFIG == Path("config") else f"{CONFIG.resolve().name}/"
ROOT = f"results/{OWN}{SCALE}"
"""All results of this call; one folder for each case. Those of another folder of the configuration have one of its name."""
PART = "" if set(CHOSEN.cases) == set(CONFIGURED.settings.cases) else "_cases" + "-".join(map(str, CHOSEN.cases))
"""After the name of report, picture and verdict where only some cases are asked for: those of all cases stay as they are."""
SAID = f"The report is in {ROOT}/report{PART}.html"
LOGS = f"{ROOT}/logs"
CONFIG_FILES = [str(CONFIG / name) for name in settings.FILES]


wildcard_constraints:
    case="case[0-9]+(_exact)?",
