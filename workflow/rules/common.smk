# Checked configuration and the paths that follow from it. Nothing here needs the engine, a plugin or a result.

from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.utils import validate

from pywet import config as settings
from pywet.errors import PywetError

# Numbers in a list on the command line, `--config cases=[2,11]`, arrive as text.
config["cases"] = [int(case) if str(case).isdigit() else case for case in config["cases"]]
STUDY_SIZE = config.pop("study_size", "quick")
"""Size of the accuracy study, `--config study_size=standard` or `reduced`; not part of config.yaml."""
validate(config, "../schemas/config.schema.json")

CONFIG = Path("config")
"""Folder of the configuration; `--config` on the command line replaces scale, cases and ranks of config.yaml."""
try:
    CONFIGURED = settings.load(CONFIG)
    CASES = {CONFIGURED.case(number).name: number for number in config["cases"]}
    CONFIGURED.scale(config["scale"])
except PywetError as error:
    raise WorkflowError(str(error))

TWINS = settings.twins(CONFIGURED, CASES, config["both_presets"])
"""Folder name of a case that runs again with another preset -> (its number, that preset); none or one."""
RUNS = {**{name: (number, None) for name, number in CASES.items()}, **TWINS}
SCALE = config["scale"]
ROOT = f"results/{SCALE}"
"""All results of this call; one folder for each case."""
LOGS = f"{ROOT}/logs"
CONFIG_FILES = [str(CONFIG / name) for name in settings.FILES]


wildcard_constraints:
    case="case[0-9]+(_exact)?",
