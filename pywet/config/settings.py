"""Settings of config.yaml: what to run and how."""

from __future__ import annotations

from collections import Counter
from typing import Annotated, Literal

from pydantic import Field, model_validator

from pywet.config.entries import Limited, RatioEntry
from pywet.config.readings import Readings
from pywet.law_names import LawName, Laws
from pywet.laws import own
from pywet.laws.kinds import PRESETS, Preset
from pywet.scene import SHORT_WINDOW, Contacts, Word
from pywet.strict import Strict

FILE = "config.yaml"
Switch = Literal["auto", True, False]
"""YAML reads on and off as true and false."""
Seconded = Literal["capillary", "viscous_normal", "viscous_tangential", "rupture"]
"""Kinds of law for which the replay takes a user reference implementation of the user's."""


class LawSettings(Laws):
    """Force laws: a preset, and laws named for single effects instead of the preset's."""

    preset: Preset = "paper"
    reference: dict[Seconded, LawName] = Field(default_factory=dict)
    """For a law of your own a second function, by which the replay recomputes it: path/to/file.py:function for each kind."""

    @model_validator(mode="after")
    def _beside_own_laws(self) -> LawSettings:
        for kind, function in self.reference.items():
            law = getattr(self, kind)
            if law is None or not own.is_own(law):
                raise ValueError(f"reference.{kind} only together with a custom law ({kind} is {law or 'the preset'})")
            if not own.is_own(function):
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

    viscous_integration `semi_implicit`: lubrication is stable at any step, so that the viscous damping time does not count.
    bridges_every: bridges are evaluated every so many steps and act as an impulse for all of them (multiple time stepping).
    """

    fraction: RatioEntry
    viscous_integration: Literal["explicit", "semi_implicit"] = "explicit"
    bridges_every: Annotated[int, Field(ge=1)] = 1


class OutputSettings(Limited):
    """Windows of steps in which every bridge is logged in every step; the interval of results belongs to the scale.

    window_trajectories: whether the motion of all spheres is recorded there too, so that the replay can close Newton's law.
    checkpoints: how many times during a run the state is saved, so that a run that was cut off resumes from there.
    energy: whether the work of every effect is added up in every step of a moist run, for `history/energy`.
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
    """Run the first moist case with preset `exact` too, so that the report can lay the two next to each other."""
    seed: Annotated[int, Field(ge=0)]
    seeds: Annotated[int, Field(ge=1)] = 1
    """Runs of each case, with this seed and the next ones: the report shows their band."""
    laws: LawSettings = LawSettings()
    readings: Readings = Readings()
    effects: EffectSettings
    time_step: TimeStepSettings
    contacts: Contacts = "planes"
    """Who makes dry contacts wherever the plugin runs, to the same bits: the plugin (planes), the plugin those of spheres
    alone (batched), the engine (stock)."""
    output: OutputSettings = OutputSettings()
    retire: Switch = "auto"
    """Take spheres that lie in the collecting bin out of the run. auto: where what happens in the bin is not asked and much is
    saved."""

    @model_validator(mode="after")
    def _each_once(self) -> Settings:
        number, times = Counter(self.cases).most_common(1)[0]
        if times > 1:
            raise ValueError(f"each case once in cases ({number} is there {times} times)")
        return self

    @model_validator(mode="after")
    def _readings_of_its_laws(self) -> Settings:
        for kind in self.readings.laws.keys() - self._read.keys():
            raise ValueError(
                f"the default readings of the {kind} law: these readings apply to {PRESETS['paper'][kind]}, but the law "
                f"is {self._used[kind]}"
            )
        return self

    @property
    def _used(self) -> dict[str, str]:
        """The law of each kind, by name or by preset."""
        return {**PRESETS[self.laws.preset], **self.laws.model_dump(exclude={"preset", "reference"}, exclude_none=True)}

    @property
    def _read(self) -> dict[str, str]:
        """The laws that the readings make of those in use."""
        return {kind: law for kind, law in self.readings.laws.items() if self._used[kind] == PRESETS["paper"][kind]}

    @property
    def laws_as_read(self) -> LawSettings:
        """Laws of the settings, after the readings have replaced those with alternative readings."""
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
