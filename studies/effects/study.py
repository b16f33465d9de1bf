"""The effects study: its runs, its table, and the stored costs of the effects for the plan."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from pywet.errors import PywetError
from pywet.laws.kinds import OPT_IN
from pywet.planning.costs import STORED
from pywet.util.files import read_json, write_json
from studies import study
from studies.effects import verdict
from studies.effects.scenes import CONFIG, SCENES
from studies.effects.variants import TOLERANCE, measure, variants
from studies.effects.verdict import Choice


@dataclass(frozen=True)
class EffectsStudy(study.Study):
    """Study of all choices of effects of every scene, or of the scene `only`, with several initial arrangements."""

    folder: Path
    seeds: int = 4
    size: float = 1.0
    only: str | None = None
    config_dir: Path = CONFIG

    def __post_init__(self) -> None:
        if self.only not in (None, *SCENES):
            raise PywetError(f"the effects study has no scene {self.only}; expected one of {', '.join(SCENES)}")

    def jobs(self) -> list[str]:
        """Make one job for each scene and seed."""
        return [job for scene in SCENES if self.only in (None, scene) for job in self.of_scene(scene)]

    def of_scene(self, scene: str) -> list[str]:
        return [f"{scene}_{seed}" for seed in range(self.seeds)]

    def runs(self, job: str) -> list[study.Run]:
        """Return all choices of effects in one job, so that their times are comparable; equal ones are one run."""
        name, _, seed = job.rpartition("_")
        scene = SCENES[name]
        setup = scene.setup(int(seed), self.size, self.config_dir)
        first: dict[str, str] = {}
        runs = []
        for variant, effects in variants(setup).items():
            file = first.setdefault(effects.model_dump_json(), f"{job}/{variant.replace(' ', '_')}")
            given = {
                "scene": name, "seed": int(seed), "size": self.size, "effects": effects.model_dump(mode="json"),
                "configuration": setup.configuration,
            }  # fmt: skip
            labels = {"scene": name, "seed": int(seed), "variant": variant}
            runs.append(study.Run(file, given, lambda e=effects: [measure(scene, setup, e)], labels))  # type: ignore[misc]
        return runs

    def of_scenes(self) -> dict[str, pd.DataFrame]:
        runs = {name: self.gather(self.of_scene(name)) for name in SCENES if self.only in (None, name)}
        return {name: of for name, of in runs.items() if len(of)}

    def show(self) -> Path:
        """Write effects.json into the folder, and the page."""
        from studies.effects import page

        runs = self.of_scenes()
        judged = {name: verdict.choices(of) for name, of in runs.items()}
        write_json(self.folder / "effects.json", result(runs, judged))
        return page.write_page(self.page, runs, judged)

    def lines(self) -> list[str]:
        """Return the findings, one line for each scene."""
        return [line(name, of, verdict.planned(verdict.choices(of))) for name, of in self.of_scenes().items()]

    def store(self, where: str) -> Path:
        """Store the measured costs of the effects for the plan; `where` names machine and date."""
        judged = {name: verdict.choices(of) for name, of in self.of_scenes().items()}
        message = (
            f"median over the scenes of `pywet study effects` ({', '.join(judged)}) of the processor time of the steps with "
            f"everything on over that without the effect, less one; scenes whose steps took under {verdict.SHORTEST} s are "
            f"left out; {where}"
        )
        others = {effect: cost for effect, cost in read_json(STORED)["added"].items() if effect in OPT_IN}
        message += f"; {' and '.join(others)}, which are on in none of these: as stored before" if others else ""
        write_json(STORED, {"provenance": message, "added": {**verdict.costs(judged), **others}})
        return STORED


def result(runs: dict[str, pd.DataFrame], judged: dict[str, list[Choice]]) -> dict[str, Any]:
    scenes = {
        name: {"left_out": verdict.left_out(runs[name]), "plan_right": verdict.planned(choices).harmless,
               "choices": [_as_dict(c) for c in choices]}
        for name, choices in judged.items()
    }  # fmt: skip
    return {"tolerance": TOLERANCE, "scenes": scenes, "added": verdict.costs(judged)}


def _as_dict(c: Choice) -> dict[str, Any]:
    return study.plain({
        "variant": c.variant, "quantity": c.worst.quantity, "change": c.worst.change, "spread": c.worst.spread,
        "harmless": c.harmless, "saving": c.saving, "saving_spread": c.saving_spread,
        "cpu_s_everything": c.cpu_s[0], "cpu_s": c.cpu_s[1],
    })  # fmt: skip


def line(name: str, runs: pd.DataFrame, plan: Choice) -> str:
    """Describe in one line the effects that the plan leaves out of a scene, and whether that is right."""
    out, worst = ", ".join(verdict.left_out(runs)) or "nothing", plan.worst
    return (
        f"{name:<14}leaves out {out}: {'right' if plan.harmless else 'WRONG'}, largest change {100 * worst.change:+.2f} % "
        f"(spread {100 * worst.spread:.2f} %) of {worst.quantity}, {plan.cpu_s[0]:.1f} -> {plan.cpu_s[1]:.1f} s"
    )
