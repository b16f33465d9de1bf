"""Settings that the study of accuracy varies, one at a time: levels from coarse to the finest, which is the reference."""

from __future__ import annotations

from dataclasses import dataclass

from pywet.errors import PywetError

Level = float | int | str


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
class StudySetting:
    """One setting: its title, its key in the configuration, its levels by size of the study, coarse to fine."""

    name: str
    title: str
    place: str
    quick: tuple[Level, ...]
    standard: tuple[Level, ...] = ()
    reduced: tuple[Level, ...] = ()
    """Levels of the size `reduced`; those of `quick` if empty."""
    exact_pair: bool = False
    """Whether all levels should give the same result, so that only their cost matters."""

    def levels(self, size: str) -> tuple[Level, ...]:
        """Return the levels of a study of this size; `whole` uses those of `standard`, `reduced_whole` those of `reduced`."""
        return getattr(self, {"whole": "standard", "reduced_whole": "reduced"}.get(size, size)) or self.quick


PARAMETERS: dict[str, StudySetting] = {
    setting.name: setting
    for setting in (
        StudySetting(
            "fraction",
            "time step",
            "config.yaml: time_step.fraction",
            (0.1, 0.05, 0.025),
            (0.2, 0.1, 0.05, 0.025, 0.0125),
            (0.1, 0.05, 0.025),
        ),
        StudySetting(
            "stiffness",
            "spring stiffness",
            "scales.yaml: stiffness_factor",
            (0.003, 0.01, 0.03),
            (0.003, 0.01, 0.03, 0.1),
            (0.01, 0.03, 0.1, 1.0),
        ),
        StudySetting("wire_sides", "wire facets", "scales.yaml: wire_sides", (4, 6, 16), (4, 6, 8, 16), (4, 6, 12)),
        StudySetting(
            "capillary",
            "capillary law",
            "config.yaml: laws",
            ("willett_simple", "rabinovich", "exact"),
            ("willett_simple", "soulie", "willett", "rabinovich", "young_laplace", "exact"),
            ("willett_simple", "rabinovich", "exact"),
        ),
        StudySetting(
            "transfer_nodes", "nodes of the sharing table", "Scene.transfer_nodes", (11, 201, 801), (11, 51, 201, 801),
            (201, 801),
        ),
        StudySetting(
            "contact_log", "contact log", "config.yaml: output", ("0x20", "2x20", "20x50"), ("0x20", "2x20", "50x100"),
            ("2x20", "50x100"), exact_pair=True,
        ),
        StudySetting("ranks", "ranks", "config.yaml: ranks", (2, 1), exact_pair=True),
        StudySetting(
            "integration", "viscous integration", "config.yaml: time_step.viscous_integration",
            ("semi_implicit", "explicit"),
        ),
        StudySetting("bridges_every", "steps between impulses", "config.yaml: time_step.bridges_every", (4, 2, 1)),
    )
}  # fmt: skip
"""Name of a field of `Setting` -> its setting."""
CONFIGURABLE = ("fraction", "stiffness", "wire_sides", "capillary", "integration", "bridges_every")
"""Settings that a choice changes in the configuration; contact log and ranks affect only the cost and are left to the user."""
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
    if not (windows.isdigit() and steps.isdigit() and int(steps) > 0):
        raise PywetError(
            f"contact log {text!r} given, expected windows times steps such as 2x20",
            code="cost.contact_log", given=text,
        )  # fmt: skip
    return int(windows), int(steps)
