"""Runs of screening cases for a search: the configuration of a combination, and the campaign's processes that run its cases."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pywet import config as settings
from pywet.config import Config
from pywet.cost.command import calibrated
from pywet.errors import PywetError
from pywet.runs.summary import commit
from studies.full_scale import campaign
from studies.search.statement_question import Place, Search, name_of


@dataclass(frozen=True)
class Runs:
    """Runs of a search, with the configuration in `source`, stored in `folder`."""

    question: Search
    source: Path
    folder: Path

    def configured(self, place: Place, aperture_mm: float | None = None) -> Config:
        """Write and return the configuration of a combination; at full scale with the campaign's settings for an aperture."""
        at_full = self.question.scale == "full" and aperture_mm is not None
        target = self.folder / name_of(place) / (f"settings-{aperture_mm:g}mm" if at_full else "settings")
        levels = campaign.SETTINGS.get(aperture_mm or 0.0, {}) if at_full else {}
        campaign.write_again(self.source, target, self.question.scale, levels, self.question.entries(place))
        return settings.load(target)

    def measure(self, place: Place, cases: Sequence[int], seeds: Sequence[int]) -> None:
        """Run cases of a combination and store their tables; raises `PywetError` if one fails or is not trusted."""
        out, plain = self.folder / name_of(place), self.configured(place)
        configs = {case: self.configured(place, plain.case(case).aperture_mm) for case in cases}
        jobs = campaign.prepare(configs, seeds, self.question.scale, out / "runs", "", calibrated())
        command = [sys.executable, "-P", "-m", "pywet.cli.app", "run", "--scale", self.question.scale]
        about = {"variant": "", "scale": self.question.scale, "commit": commit(), "combination": name_of(place)}
        failed = campaign.Campaign(jobs, out / "data", command, about, self.question.cores).run()
        if failed:
            raise PywetError(
                f"{name_of(place)}: {failed[0].name} failed: {failed[0].failed}; expected a run that is stored, see "
                f"{failed[0].folder / 'campaign.log'}"
            )
