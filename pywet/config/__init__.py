"""Configuration: four files in one folder, read into typed objects; every number has its source.

This package only reads and checks; `pywet.cases.screening.cases` builds scenes from it, and docs/configuration.md
describes the files.
"""

from pywet.config.cases import Case
from pywet.config.command_line import REPLACED, chosen
from pywet.config.loading import FILES, Config, load, of_run, preset_comparisons, texts
from pywet.config.materials import Materials
from pywet.config.scales import Scale
from pywet.config.settings import EffectSettings, LawSettings

__all__ = [
    "FILES",
    "REPLACED",
    "Case",
    "Config",
    "EffectSettings",
    "LawSettings",
    "Materials",
    "Scale",
    "chosen",
    "load",
    "of_run",
    "preset_comparisons",
    "texts",
]
