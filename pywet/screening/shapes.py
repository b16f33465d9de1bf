"""What must be in the JSON files of a run directory that are read back; further keys are allowed. For `files.read_json`."""

from __future__ import annotations

from typing import NotRequired  # pydantic asks for it below Python 3.12

from typing_extensions import TypedDict


class Check(TypedDict):
    """A check of the results."""

    name: str
    ok: bool
    value: float
    text: str


class BridgesOn(TypedDict):
    """Of the effects, what is asked of a summary."""

    bridges: bool


class Summary(TypedDict):
    """summary.json."""

    spheres: dict[str, int]
    steps: int
    wall_s: float
    fraction_retained_end: float
    coarse_share: float
    ledger_error: float | None
    energy_J: dict[str, float | None] | None
    effects: BridgesOn
    checks: list[Check]
    versions: dict[str, str | None]


class EngineRun(TypedDict, total=False):
    """engine/run.json."""

    wall_s: float | None
    resumed_at_step: int | None
    ranks: int
    engine: str
    engine_version: str
    plugin_hash: str | None


class Deviation(TypedDict):
    """One quantity of replay.json."""

    scale: str
    count: int
    largest: float
    median: float
    tolerance: float


class Replay(TypedDict):
    """replay.json."""

    contacts: NotRequired[int]
    quantities: dict[str, Deviation]


class PlanRow(TypedDict):
    """One effect of plan.json."""

    effect: str
    on: bool
    quantity: str
    number: float
    threshold: float
    predicted_share: NotRequired[float | None]
    predicted_within: NotRequired[float | None]


class Plan(TypedDict):
    """plan.json."""

    rows: list[PlanRow]


class Contribution(TypedDict):
    """What one effect did."""

    acting: bool
    impulse_share: float | None
    liquid_share: NotRequired[float | None]
    mean_stretch: NotRequired[float | None]
    energy_share: NotRequired[float | None]


class Contributions(TypedDict):
    """contributions.json."""

    effects: dict[str, Contribution]
