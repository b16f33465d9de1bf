"""Settings of config.yaml: what to run and how."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from pywet.config.entries import Limited, RatioEntry, doubled
from pywet.config.readings import Readings
from pywet.law_names import LawName, Laws
from pywet.laws import custom_laws
from pywet.laws.kinds import PRESETS, Preset
from pywet.scene import SHORT_WINDOW, Contacts, Word
from pywet.strict import Strict

FILE = "config.yaml"
Switch = Literal["auto", True, False]
"""Switch of an effect; YAML reads on and off as true and false."""
Seconded = Literal["capillary", "viscous_normal", "viscous_tangential", "rupture"]
"""Kinds of law for which the replay accepts a user reference implementation."""


class LawSettings(Laws):
    """Force laws: a preset, and laws named for single effects instead of the preset's."""

    preset: Preset = "paper"
    reference: dict[Seconded, LawName] = Field(default_factory=dict)
    """User reference implementation of a custom law for the replay: path/to/file.py:function for each kind."""

    @model_validator(mode="after")
    def _with_custom_laws(self) -> LawSettings:
        for kind, function in self.reference.items():
            law = getattr(self, kind)
            if law is None or not custom_laws.is_custom(law):
                raise ValueError(f"reference.{kind} only together with a custom law ({kind} is {law or 'the preset'})")
            if not custom_laws.is_custom(function):
                raise ValueError(f"reference.{kind} as path/to/file.py:function ({function} is none)")
        return self


class EffectSettings(Strict):
    """Switches of the effects: `auto` (decided by `decide`), on or off.

    decide `preset`: all effects of the preset are on if there is liquid. decide `tolerance`: an effect whose number is
    below the tolerance is off. liquid_weight and shedding are in no preset and must be switched on explicitly.
    """

    decide: Literal["preset", "tolerance"] = "preset"
    tolerance: RatioEntry
    bridges: Switch = "auto"
    capillary: Switch = "auto"
    viscous_normal: Switch = "auto"
    viscous_tangential: Switch = "auto"
    dynamic_rupture: Switch = "auto"
    wall_films: Switch = "auto"
    sharing_by_size: Switch = "auto"
    rolling: Switch = "auto"
    tangential_history: Switch = "auto"
    gravity: Switch = "auto"
    liquid_weight: Switch = "auto"
    shedding: Switch = "auto"


class TimeStepSettings(Limited):
    """Time step as a fraction of the shortest time scale (duration of a collision, viscous damping time).

    viscous_integration `semi_implicit`: lubrication is stable at any step, so that the viscous damping time does
    not apply. bridges_every: bridges are evaluated every so many steps and act as an impulse for all of them
    (multiple time stepping).
    """

    fraction: RatioEntry
    viscous_integration: Literal["explicit", "semi_implicit"] = "explicit"
    bridges_every: Annotated[int, Field(ge=1)] = 1


class OutputSettings(Limited):
    """Windows of steps in which every bridge is logged in every step; the interval of results belongs to the scale.

    window_trajectories: whether the motion of all spheres is recorded there too, so that the replay can close
    Newton's law. checkpoints: how many times during a run the state is saved, so that an interrupted run can
    resume. energy: whether the work of every effect is added up in every step of a moist run, for
    `history/energy`.
    """

    contact_windows: Annotated[int, Field(ge=0)] = 20
    contact_window_steps: Annotated[int, Field(ge=1)] = 2
    window_trajectories: bool = True
    checkpoints: Annotated[int, Field(ge=0)] = 20
    energy: bool = False


class Settings(Limited):
    """Content of config.yaml."""

    scale: Word
    cases: Annotated[tuple[Annotated[int, Field(ge=1)], ...], Field(min_length=1)]
    ranks: Annotated[int, Field(ge=1)] = 1
    both_presets: bool = True
    """Run the first moist case with preset `exact` too, so that the report can compare both."""
    seed: Annotated[int, Field(ge=0)]
    seeds: Annotated[int, Field(ge=1)] = 1
    """Number of runs of each case, with consecutive seeds from this one: the report shows their band."""
    laws: LawSettings = LawSettings()
    readings: Readings = Readings()
    effects: EffectSettings
    time_step: TimeStepSettings
    contacts: Contacts = "planes"
    """Program that computes dry contacts if the plugin is in use, with identical results.

    The plugin (planes), the plugin for pairs of spheres only (batched), or the engine (stock).
    """
    output: OutputSettings = OutputSettings()
    retire: Switch = "auto"
    """Remove spheres that lie in the collecting bin from the run. auto: if the bin is not evaluated and the saving is large."""

    @model_validator(mode="after")
    def _each_once(self) -> Settings:
        if wrong := doubled("each case once in cases", map(str, self.cases)):
            raise ValueError("; ".join(wrong))
        return self

    @model_validator(mode="after")
    def _readings_of_its_laws(self) -> Settings:
        for kind in self._not_read:
            raise ValueError(
                f"the default readings of the {kind} law: these readings apply to {PRESETS['paper'][kind]}, but the law "
                f"is {self._used[kind]}"
            )
        return self

    @property
    def _used(self) -> dict[str, str]:
        """Return the law of each kind, by name or by preset."""
        return {**PRESETS[self.laws.preset], **self.laws.model_dump(exclude={"preset", "reference"}, exclude_none=True)}

    @property
    def _read(self) -> dict[str, str]:
        """Return the laws selected by the readings."""
        return {kind: law for kind, law in self.readings.laws.items() if self._used[kind] == PRESETS["paper"][kind]}

    @property
    def _not_read(self) -> set[str]:
        """Return the kinds of law whose readings do not apply to the law used."""
        return self.readings.laws.keys() - self._read.keys()

    def with_laws(self, laws: LawSettings) -> Settings:
        """Return a copy with other laws, and without the readings and reference implementations that do not apply to them."""
        seconds = {kind: f for kind, f in laws.reference.items() if custom_laws.is_custom(getattr(laws, kind) or "")}
        made = self.model_copy(update={"laws": laws.model_copy(update={"reference": seconds})})
        return made.model_copy(update={"readings": self.readings.without(made._not_read)})

    @property
    def laws_as_read(self) -> LawSettings:
        """Return the laws of the settings, with alternatives selected by the readings."""
        return self.laws.model_copy(update=self._read)

    @model_validator(mode="after")
    def _bridges_act_in_windows(self) -> Settings:
        every, steps = self.time_step.bridges_every, self.output.contact_window_steps
        if self.output.contact_windows and SHORT_WINDOW < steps < every:
            raise ValueError(
                f"output.contact_window_steps of at least time_step.bridges_every or at most {SHORT_WINDOW} "
                f"({steps} is less than {every})"
            )
        return self
