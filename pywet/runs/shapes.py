"""Required content of the JSON files of a run directory, for `files.read_json`; further keys are allowed."""

from __future__ import annotations

from typing import (
    Annotated,
    NotRequired,  # pydantic asks for it below Python 3.12
)

from pydantic import AfterValidator
from typing_extensions import TypedDict

from pywet.laws import kinds


class Check(TypedDict):
    """Result of one check of a run."""

    name: str
    ok: bool
    value: float
    text: str


class BridgesOn(TypedDict):
    """Entry of a summary on whether bridges are simulated."""

    bridges: bool


class Events(TypedDict):
    """Counts of the liquid's events in a summary."""

    formations: int
    ruptures: int


class RunSummary(TypedDict):
    """summary.json of a run of any scene."""

    spheres: dict[str, int]
    steps: int
    wall_s: float
    ledger_error: float | None
    energy_J: NotRequired[dict[str, float | None] | None]
    particle_steps_per_s: float | None
    initial_liquid_m3: float
    liquid_end_m3: dict[str, float]
    events: Events | None
    effects: BridgesOn
    checks: list[Check]
    versions: dict[str, str | None]


class Summary(RunSummary):
    """Content of summary.json of a screening case."""

    fraction_retained_end: float
    coarse_share: float


class EngineRun(TypedDict, total=False):
    """Content of engine/run.json: how the engine's run ended."""

    wall_s: float | None
    resumed_at_step: int | None
    ranks: int
    engine: str
    engine_version: str
    plugin_hash: str | None
    cpu_s: float | None
    peak_memory_B: int | None


class Deviation(TypedDict):
    """Deviation of one quantity in replay.json."""

    scale: str
    count: int
    largest: float
    median: float
    tolerance: float


class Finding(TypedDict):
    """A fault named by the diagnosis of the replay."""

    sentence: str


class Diagnosis(TypedDict):
    """Faults named by the diagnosis of the replay."""

    findings: list[Finding]


class Replay(TypedDict):
    """Content of replay.json."""

    ok: NotRequired[bool]
    contacts: NotRequired[int]
    cpu_s: NotRequired[float]
    peak_memory_B: NotRequired[int]
    diagnosis: NotRequired[Diagnosis | None]
    quantities: dict[str, Deviation]


class PlanRow(TypedDict):
    """Row of plan.json: one effect with its number and reason."""

    effect: str
    on: bool
    quantity: str
    number: float
    threshold: float
    predicted_share: NotRequired[float | None]
    predicted_within: NotRequired[float | None]


class AmountRow(TypedDict):
    """One size of plan.json whose number of spheres follows from a mass."""

    name: str
    asked_kg: float
    made_kg: float
    count: int


class Plan(TypedDict):
    """Content of plan.json."""

    rows: list[PlanRow]
    amounts: NotRequired[list[AmountRow]]


class Contribution(TypedDict):
    """Share of one effect in impulse and liquid exchange."""

    acting: bool
    impulse_share: float | None
    liquid_share: NotRequired[float | None]
    mean_stretch: NotRequired[float | None]
    energy_share: NotRequired[float | None]


FORCES = ("weight", "contact_normal", "contact_tangential", *kinds.FORCES)


def _with_forces(effects: dict[str, Contribution]) -> dict[str, Contribution]:
    missing = [name for name in FORCES if name not in effects]
    if missing:
        raise ValueError(f"there is nothing of {', '.join(missing)}")
    return effects


class Contributions(TypedDict):
    """Content of contributions.json."""

    effects: Annotated[dict[str, Contribution], AfterValidator(_with_forces)]
