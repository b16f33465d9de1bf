"""Decide whether spheres at rest in the collecting bin are removed from a run (`retire` in config.yaml), and what it saves.

The fraction retained and the distribution of liquid are not affected, because removed spheres are still counted;
processes in the bin are.
"""

from __future__ import annotations

import textwrap
from dataclasses import dataclass

from pywet.config.settings import Switch
from pywet.errors import PywetError
from pywet.scene import Effects, Output, not_retirable

GATHERED_S = 3.3
"""Time [s] from the opening of the slide until 90 % of a step is spent on spheres in the bin (case 2 at full scale)."""
IN_THE_BIN = 0.93
"""Share of a step that is spent on spheres in the bin from then on."""
WORTH = 0.5
"""Share of the processor time that retirement must save for `auto` to be on."""


@dataclass(frozen=True)
class Retirement:
    """Decision on retirement; `saves` is the estimated share of processor time saved, if it is on."""

    on: bool
    why: str
    saves: float

    @property
    def lines(self) -> list[str]:
        """Return lines on retirement for `pywet plan`, in 80 columns."""
        saving = f"saves about {100 * self.saves:.0f} % of the processor time: " if self.on else ""
        start = f"{'retire':<19}{'on' if self.on else 'off':<5}"
        return textwrap.wrap(
            f"{start}{saving}{self.why}", 80, subsequent_indent=" " * len(start), drop_whitespace=False
        )


def decide(
    switch: Switch,
    effects: Effects,
    output: Output,
    gravity: tuple[float, float, float],
    plugin: bool,
    after_opening_s: float,
) -> Retirement:
    """Decide on retirement for a screening case; `plugin`: whether the run uses the plugin, which retirement needs.

    Raises `PywetError` if it is switched on explicitly but not possible.
    """
    obstacle = not_retirable(effects, output, gravity)
    saves = IN_THE_BIN * max(0.0, 1.0 - GATHERED_S / after_opening_s) if after_opening_s > 0 else 0.0
    if switch is True and obstacle:
        raise PywetError(
            f"config.yaml: retire is on but {obstacle}, expected auto or off",
            code="effect.retire", key="retire", given="on", where="config.yaml",
        )  # fmt: skip
    if switch != "auto":
        return Retirement(switch, f"retire is {'on' if switch else 'off'} in config.yaml", saves)
    if obstacle:
        return Retirement(False, obstacle, saves)
    if not plugin:
        return Retirement(False, "a dry run without analytic wires runs on the stock program", saves)
    if saves < WORTH:
        why = f"the run ends {after_opening_s:.3g} s after the opening, before many spheres lie there"
        return Retirement(False, why, saves)
    return Retirement(True, "what passes and where the liquid goes is asked, not what happens in the bin", saves)
