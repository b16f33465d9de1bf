"""Settings that the study varies, one at a time: levels from coarse to the finest, which is the reference."""

from __future__ import annotations

from dataclasses import dataclass

from pywet.config import Config
from pywet.cost.edit import CONFIGURABLE, Level, entries, with_entries

SCALE = "study"
"""Name of the scale made for the study."""


@dataclass(frozen=True)
class Setting:
    """All settings of a run. The defaults are those of `config/` at smoke scale (tested)."""

    fraction: float = 0.05
    """Time step over the duration of the shortest collision."""
    stiffness: float = 0.01
    """Contact stiffness over that of the paper."""
    wire_sides: int = 6
    capillary: str = "rabinovich"
    """A capillary law with the paper's rupture and transfer ratio; `exact`: all three from the exact bridge."""
    transfer_nodes: int = 201
    """Number of nodes of the tables of transfer ratios."""
    contact_log: str = "2x20"
    """Windows of the contact log times steps in each."""
    ranks: int = 1
    integration: str = "explicit"
    bridges_every: int = 1
    """Steps between evaluations of the bridges."""


@dataclass(frozen=True)
class Size:
    """Size of a study: sieve [mm], simulated time and opening of the slide [s] (None: as in the scale), number of seeds.

    `dry_seeds`: number for dry screening, whose runs are short (0: the same).
    """

    scale: str
    width_mm: float | None
    duration_s: float | None
    opens_s: float | None
    seeds: int
    dry_seeds: int = 0


@dataclass(frozen=True)
class StudySetting:
    """One setting: its name, and its levels by size of the study, coarse to fine."""

    name: str
    quick: tuple[Level, ...]
    standard: tuple[Level, ...] = ()
    reduced: tuple[Level, ...] = ()
    """Levels of the size `reduced`; those of `quick` if empty."""
    exact_pair: bool = False
    """Whether all levels should give the same result, so that only their cost matters."""

    @property
    def title(self) -> str:
        """Return the setting in words."""
        return TITLES[self.name] if self.name in TITLES else CONFIGURABLE[self.name].title

    def levels(self, size: str) -> tuple[Level, ...]:
        """Return the levels of a study of this size; `whole` uses those of `standard`, `reduced_whole` those of `reduced`."""
        return getattr(self, {"whole": "standard", "reduced_whole": "reduced"}.get(size, size)) or self.quick


TITLES = {"transfer_nodes": "nodes of the sharing table", "contact_log": "contact log", "ranks": "ranks"}
"""Titles of the settings that no choice changes."""
PARAMETERS: dict[str, StudySetting] = {
    setting.name: setting
    for setting in (
        StudySetting("fraction", (0.1, 0.05, 0.025), (0.2, 0.1, 0.05, 0.025, 0.0125), (0.1, 0.05, 0.025)),
        StudySetting("stiffness", (0.003, 0.01, 0.03), (0.003, 0.01, 0.03, 0.1), (0.01, 0.03, 0.1, 1.0)),
        StudySetting("wire_sides", (4, 6, 16), (4, 6, 8, 16), (4, 6, 12)),
        StudySetting(
            "capillary",
            ("willett_simple", "rabinovich", "exact"),
            ("willett_simple", "soulie", "willett", "rabinovich", "young_laplace", "exact"),
            ("willett_simple", "rabinovich", "exact"),
        ),
        StudySetting("transfer_nodes", (11, 201, 801), (11, 51, 201, 801), (201, 801)),
        StudySetting(
            "contact_log",
            ("0x20", "2x20", "20x50"),
            ("0x20", "2x20", "50x100"),
            ("2x20", "50x100"),
            exact_pair=True,
        ),
        StudySetting("ranks", (2, 1), exact_pair=True),
        StudySetting("integration", ("semi_implicit", "explicit")),
        StudySetting("bridges_every", (4, 2, 1)),
    )
}
"""Name of a field of `Setting` -> its setting."""
PARAMETERS_OF: dict[str, tuple[str, ...]] = {
    "dry": ("fraction", "stiffness", "wire_sides", "ranks"),
    "moist": tuple(PARAMETERS),
    "bed": ("fraction", "stiffness", "capillary", "integration", "bridges_every", "transfer_nodes"),
    "pair_dry": ("fraction", "stiffness"),
    "pair_wet": ("fraction", "stiffness", "capillary", "integration", "bridges_every"),
    "pull": ("fraction", "capillary", "integration", "bridges_every"),
    "laws": ("capillary", "transfer_nodes"),
}
"""Scene -> settings that are varied in it."""


def default(size: str) -> Setting:
    """Return the setting that others are compared with: `config/` at the scale of the study."""
    return Setting(stiffness=0.1) if size.startswith("reduced") else Setting()


def reference(setting: str, size: str) -> Level:
    """Return the finest level of a setting, with which the others are compared."""
    return PARAMETERS[setting].levels(size)[-1]


def log_windows(text: str) -> tuple[int, int]:
    """Windows and steps of a level of the contact log.

    >>> log_windows("2x20")
    (2, 20)
    """
    windows, _, steps = text.partition("x")
    return int(windows), int(steps)


def with_setting(config: Config, setting: Setting, size: Size, seed: int) -> Config:
    """Return the configuration with another setting, another seed and the scale SCALE, which has the size of the study."""
    windows, steps = log_windows(setting.contact_log)
    log = {"contact_windows": windows, "contact_window_steps": steps, "checkpoints": 0}
    given = {"width_mm": size.width_mm, "duration_s": size.duration_s, "slide_opens_at_s": size.opens_s}
    values = {"config.yaml: seed": seed, f"scales.yaml: scales {SCALE}": config.scale(size.scale)}
    values |= {f"config.yaml: output {name}": value for name, value in log.items()}
    values |= {f"scales.yaml: scales {SCALE} {name} value": v for name, v in given.items() if v is not None}
    turned = with_entries(
        config, {**values, **entries(SCALE, {parameter: getattr(setting, parameter) for parameter in CONFIGURABLE})}
    )
    return turned.without_retirement()  # a study uses the whole bed, without checkpoints
