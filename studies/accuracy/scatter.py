"""Effect of the scatter of inputs on the fraction retained, in the units and with the seeds of the settings' errors.

The study's screening scenes are repeated with an input one standard deviation above and below its value; its effect is half the
difference. Multiple time stepping, which the stored tables lack, is run as well; `scatter.json` stores the rows.

    python -m studies.accuracy.scatter [FOLDER]      runs what is missing (some minutes), stores the rows
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from pywet import config as settings
from pywet.config import Config
from pywet.cost.edit import put, with_entries
from pywet.errors import border
from pywet.util.files import read_json
from studies import study
from studies.accuracy import measure, sieve
from studies.accuracy.parameters import SCALE, Setting, with_setting
from studies.accuracy.sieve import SCREENING

STORED = Path(__file__).with_name("scatter.json")
QUANTITIES = ("retained_mean", "retained_end")
SIZE = "standard"


@dataclass(frozen=True)
class Input:
    """An uncertain input: description, relative standard deviation (between spheres; at walls), and its source."""

    title: str
    between: float
    at_walls: float
    source: str
    scenes: tuple[str, ...] = SCREENING
    """Scenes in which the input is varied."""


VSSUQ = "raw files of LaMarche et al. (2022), github.com/wfullmer/vssuq (MIT): glass on glass"
INPUTS = {
    "friction": Input("friction", 0.0674 / 0.2736, 0.0756 / 0.2514, f"{VSSUQ}, 78 values; on acrylic, 55"),
    "restitution": Input(
        "restitution", 0.0150 / 0.9696, 0.0374 / 0.9549, f"{VSSUQ}, 24 values; on acrylic, 179", ("dry",)
    ),
    "tension": Input("surface tension", 1 / 70, 1 / 70, "Nowak et al. (2005): water, 70 ± 1 mN/m", ("moist",)),
    "film": Input("liquid on the spheres", 0.1, 0.1, "assumption", ("moist",)),
}
"""Inputs with their scatter as measured on glass; that other materials scatter alike is an assumption."""
STEPS = (4,)
"""Steps between impulses that are run in addition."""
SEEDS = sieve.SEEDS[:2]


def scattered(config: Config, name: str, sign: int) -> Config:
    """Study of each input, low and high, with every seed."""
    spread, data = INPUTS[name], config.materials
    if name == "film":
        moved = {n: c.model_copy(update={"liquid_percent": c.liquid_percent * (1.0 + sign * spread.between)})
                 for n, c in config.cases.items()}  # fmt: skip
        return replace(config, cases=moved)
    if name == "tension":
        value = data.liquid.surface_tension_N_per_m.value * (1.0 + sign * spread.between)
        return with_entries(config, {"materials.yaml: liquid surface_tension_N_per_m value": value})
    contacts = []
    for contact in data.contacts:
        share = spread.between if contact.partner == contact.sphere else spread.at_walls
        contacts.append(put(contact, f"{name} value", getattr(contact, name).value * (1.0 + sign * share)))
    return replace(config, materials=data.model_copy(update={"contacts": type(data.contacts)(contacts)}))


@dataclass(frozen=True)
class ScatterStudy(study.Study):
    """Each input low and high with every seed."""

    folder: Path
    config_dir: Path = Path("config")

    def jobs(self) -> list[str]:
        """Make one job for each scene and seed."""
        return [f"{scene}-{seed}" for seed in SEEDS for scene in SCREENING]

    def runs(self, job: str) -> list[study.Run]:
        """Return each input low and high; in moist screening also the default, and longer steps between impulses."""
        scene, _, seed = job.partition("-")
        turned = [(name, sign) for name, i in INPUTS.items() if scene in i.scenes for sign in (-1, 1)]
        if scene == "moist":
            turned += [("default", 0), *(("bridges_every", n) for n in STEPS)]
        return [self._run(scene, int(seed), name, level) for name, level in turned]

    def _run(self, scene: str, seed: int, name: str, level: int) -> study.Run:
        setting = Setting(bridges_every=level) if name == "bridges_every" else Setting()
        vary: Callable[[Config], Config] = (
            partial(scattered, name=name, sign=level) if name in INPUTS else lambda same: same
        )
        config = vary(with_setting(settings.load(self.config_dir), setting, sieve.SIZES[SIZE], seed))
        given = study.configured(config, sieve.CASE[scene], SCALE)
        make = partial(measure.rows_of, scene, seed, name, setting, SIZE, self.config_dir, vary)
        labels = {"scene": scene, "seed": seed, "input": name, "level": level}
        return study.Run(f"{scene}-{seed}-{name}{level:+d}", given, make, labels)

    def show(self) -> Path:
        rows = self.gather()[["scene", "seed", "input", "level", *QUANTITIES]]
        study.write_rows(STORED, rows.round(6).to_dict("records"))
        return STORED


def effects(rows: pd.DataFrame, table: dict[str, Any]) -> pd.DataFrame:
    """Return the effect of one standard deviation of each input: scene, input, level, quantity, value, limit (99 %), seeds.

    It is half of high minus low; for `bridges_every` each level minus the default. The scatter of a difference of
    two runs is taken from the study's `table`, whose deviation is pooled over many levels of the same scene.
    """
    made = []
    (known,) = (row["errors"] for row in table["parameters"]["fraction"] if row["level"] == 0.1)
    uncertainty = {(e["scene"], e["quantity"]): e["limit"] * math.sqrt(e["seeds"]) for e in known}
    for scene, of_scene in rows.groupby("scene", sort=False):
        for quantity in QUANTITIES:
            runs = of_scene.pivot_table(index="seed", columns=["input", "level"], values=quantity)
            halves = {(n, 1): (0.5, runs[n, 1] - runs[n, -1]) for n in INPUTS if (n, 1) in runs}
            halves |= {("bridges_every", n): (1.0, runs["bridges_every", n] - runs["default", 0])
                       for n in STEPS if ("bridges_every", n) in runs}  # fmt: skip
            for (name, level), (half, difference) in halves.items():
                d = difference.dropna()
                limit = half * uncertainty[str(scene), quantity] / math.sqrt(len(d))
                made.append((scene, name, level, quantity, half * float(d.mean()), limit, len(d)))
    return pd.DataFrame(made, columns=["scene", "input", "level", "quantity", "value", "limit", "seeds"])


def stored() -> pd.DataFrame:
    rows: list[dict[str, Any]] = read_json(STORED, "make it with `python -m studies.accuracy.scatter`")
    return pd.DataFrame(rows)


if __name__ == "__main__":
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "results/studies/scatter")
    with border():
        folder.mkdir(parents=True, exist_ok=True)
        print(ScatterStudy(folder).carry_out(lambda name, share: print(f"{share:.0%} {name}", flush=True)))
