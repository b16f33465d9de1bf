"""Digest of a reference run: mean and spread of its quantities over several seeds, a few kilobytes of JSON with provenance.

A digest is a regression alarm, not an oracle: it reports that numbers have changed, not that they were right. A run
is compared with mean ± Student's quantile (two-sided, divided among all numbers of the digest) × spread × √(1 + 1/n),
plus a numerical tolerance of the quantity's scale.
"""

from __future__ import annotations

import platform
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from datetime import date
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from scipy import stats

from pywet.cases.small.scenes import RESULT
from pywet.compare import common_end
from pywet.compare.grouping import same_scene
from pywet.compare.quantities import RunData, beyond_seed, facts, read_run, unlike
from pywet.errors import PywetError
from pywet.runs.distinct_seeds import distinct_seeds
from pywet.runs.summary import commit, versions
from pywet.scene import EngineScene
from pywet.schema import unit_of
from pywet.util.files import read_if_there, read_model, write_json
from pywet.util.notices import notice

FORMER = {"standing bridges": "active bridges"}
"""Former name of a quantity of stored digests -> its present one."""
TIMES = 5
"""Number of stored points of a curve, evenly spaced, without the start."""
TOLERANCE = 1e-6
"""Numerical tolerance of a digest's numbers over their scale, in addition to the spread of the seeds."""
COUNTED = ("events", "bridges")
"""Units of whole numbers, which may coincide in a few runs by accident: their spread is at least one if others scatter."""
SHARES = ("1", "of all")
"""Units of shares, mostly of a number of spheres, which coincide as easily."""
ALARM = 0.01
"""Probability that an unchanged program raises an alarm, for all numbers of a digest together."""


@dataclass(frozen=True)
class Number:
    """One stored number: mean and standard deviation over the runs, and the scale of its numerical tolerance."""

    mean: float
    spread: float
    scale: float
    unit: str


@dataclass(frozen=True)
class Digest:
    """Stored numbers by name, with the number of runs, the numerical tolerance, the command and the versions."""

    name: str
    command: str
    made: str
    runs: int
    tolerance: float
    versions: dict[str, str]
    numbers: dict[str, Number]
    scene: dict[str, Any] | None = None
    """Facts that define the scene; None for results that are no engine run."""
    left_out: tuple[str, ...] = ()
    """Numbers that only some of the runs have, such as a cut size that the sizes of one run do not enclose."""
    purpose: str = "regression alarm: says that numbers moved, not that they were right"


@dataclass(frozen=True)
class Row:
    """One number of a run compared with the digest."""

    run: str
    quantity: str
    value: float
    mean: float
    allowed: float
    unit: str
    failed_check: bool = False
    """Whether it is a check that the run fails, not a number of the digest."""

    @property
    def ok(self) -> bool:
        return not self.failed_check and abs(self.value - self.mean) <= self.allowed


def numbers_of(run: RunData) -> dict[str, tuple[float, float, str]]:
    """Return the numbers of a run as (value, scale, unit): each quantity, a curve at TIMES points of its duration."""
    numbers = {}
    for q in run.quantities.values():
        if len(q.times) == 0:
            numbers[q.name] = (float(q.values[0]), q.scale, q.unit)
            continue
        for share in np.arange(1, TIMES + 1) / TIMES:
            at = q.times[0] + share * (q.times[-1] - q.times[0])
            numbers[f"{q.name} at {share:.0%}"] = (float(q.at(np.array([at]))[0]), q.scale, q.unit)
    return numbers


def numbers_in(run_dir: Path) -> dict[str, tuple[float, float, str]]:
    """Return the numbers of a run directory, including those of scene_result.json, if written by `pywet scene`.

    Those of a run with `until`, except for its screen, are of the time that all runs of its scene reach.
    """
    numbers = numbers_of(read_run(run_dir, common_end.of_scene(run_dir)))
    for name, value in (read_if_there(Path(run_dir) / RESULT, shape=dict[str, Any]) or {}).items():
        if isinstance(value, int | float):
            numbers[f"result {name}"] = (float(value), abs(float(value)) or 1.0, unit_of(name) or "1")
    return numbers


def make(
    name: str, command: str, runs: Sequence[dict[str, tuple[float, float, str]]], scene: dict[str, Any] | None = None
) -> Digest:
    """Make the digest of the numbers that all of several runs of one scene have."""
    numbers, every = {}, dict.fromkeys(key for run in runs for key in run)
    left_out = tuple(key for key in every if any(key not in run for run in runs))
    for key in (key for key in every if key not in left_out):
        _, scale, unit = runs[0][key]
        values = np.array([r[key][0] for r in runs])
        spread = float(values.std(ddof=1)) if len(values) > 1 else 0.0
        mean, spread, scale = (float(f"{v:.10g}") for v in (values.mean(), spread, scale))
        numbers[key] = Number(mean, spread, scale, unit)
    made = date.today().isoformat()
    return Digest(name, command, made, len(runs), TOLERANCE, provenance(), numbers, scene, left_out)


def of_runs(name: str, command: str, paths: Sequence[Path]) -> Digest:
    """Make the digest of finished runs of one scene, each seed once; a run that fails a check or its replay is refused."""
    runs = [read_run(p) for p in paths]
    scene = facts(runs[0].scene, runs[0].path)
    for run in runs:
        _name_notes(run)
        who = f"{runs[0].path} and {run.path}"
        _same_scene(scene, run.scene, who, run.path)
        if not same_scene(runs[0].path, run.path):
            _refuse(beyond_seed(runs[0].scene, run.scene), who)
        for check, (ok, value) in run.checks.items():
            if not ok:
                raise PywetError(
                    f"{run.path} fails its check {check} ({value:.2g}); expected a run without failed checks",
                    code="digest.failed_check", key=check, given=value, where=run.path,
                )  # fmt: skip
        if run.scene.effects.bridges and "replay" not in run.checks:
            raise PywetError(
                f"{run.path} was not replayed; expected replay.json: call `pywet replay {run.path}` first",
                code="digest.not_replayed", where=run.path,
            )  # fmt: skip
    return make(name, command, [numbers_in(p) for p in distinct_seeds(paths)], scene)


def _same_scene(wanted: dict[str, Any], scene: EngineScene, who: str, folder: Path | None = None) -> None:
    if differs := unlike(wanted, scene, folder=folder):
        _refuse(differs, who)


def _refuse(differs: Sequence[str], who: str) -> NoReturn:
    raise PywetError(
        f"{who} differ in {', '.join(differs)}; expected runs of one scene",
        code="digest.scenes", key=", ".join(differs),
    )  # fmt: skip


def _name_notes(run: RunData) -> None:
    """Print what limits the numbers of a run, such as a deck that is not steady."""
    for note in run.notes:
        notice.warning("%s: %s", run.path, note)


def provenance() -> dict[str, str]:
    """Return the versions that the numbers depend on, and the commit."""
    from pywet.engines.liggghts.build import engine_version

    made_by = {"liggghts": engine_version(), "machine": platform.machine(), "commit": commit() or "unknown"}
    return {**versions(), **made_by}


def save(digest: Digest, path: Path) -> Path:
    """Write a digest as JSON and return its path."""
    write_json(path, asdict(digest))
    return path


def load(path: Path) -> Digest:
    """Read a digest that `save` wrote."""
    if not Path(path).exists():
        raise PywetError(
            f"there is no digest {path}; expected one that `pywet digest` wrote", code="digest.missing", where=path
        )
    found: Digest = read_model(path, Digest, "make it again with `pywet digest`")
    return replace(found, numbers={_renamed(name): number for name, number in found.numbers.items()})


def _renamed(name: str) -> str:
    """Return the present name of a number of a digest."""
    former = next((former for former in FORMER if name.startswith(former)), "")
    return FORMER.get(former, "") + name.removeprefix(former)


def allowed(digest: Digest, name: str) -> float:
    """Largest deviation of a number from its mean that is accepted.

    >>> allowed(Digest("x", "", "", 1, 1e-6, {}, {"a": Number(1.0, 0.0, 2.0, "1")}), "a")
    2e-06
    """
    margin = digest.tolerance * digest.numbers[name].scale
    if digest.runs > 1:
        quantile = float(stats.t.isf(0.5 * ALARM / len(digest.numbers), digest.runs - 1))
        margin += quantile * _spread(digest, name) * float(np.sqrt(1.0 + 1.0 / digest.runs))
    return margin


def _spread(digest: Digest, name: str) -> float:
    """Return the standard deviation of a number, and where it coincides by accident, perhaps, one that it may have.

    That is the largest of its curve at other times; infinite for a share that is the same at all times, as of rare events.
    """
    number = digest.numbers[name]
    scattered = {key: n.spread for key, n in digest.numbers.items() if n.spread > digest.tolerance * n.scale}
    if scattered and number.unit in COUNTED:
        return max(number.spread, 1.0)
    if not scattered or name in scattered:
        return number.spread
    curve, at, _ = name.rpartition(" at ")
    others = [spread for key, spread in scattered.items() if at and key.startswith(curve + at)]
    return max(others, default=np.inf if number.unit in SHARES else number.spread)


def against(digest: Digest, run: str, values: dict[str, tuple[float, float, str]]) -> list[Row]:
    """Compare each stored number with that of a run; a number missing from the run is NaN, which always fails."""
    return [
        Row(run, key, values[key][0] if key in values else float("nan"), n.mean, allowed(digest, key), n.unit)
        for key, n in digest.numbers.items()
    ]


def check(digest: Digest, run_dir: Path) -> list[Row]:
    """Compare a run directory with a digest, after the checks that it fails; a run of another scene is refused."""
    if digest.scene is None:
        raise PywetError(
            f"the digest {digest.name} is of `{digest.command}`, which leaves no run directory",
            code="digest.no_runs", given=digest.command,
        )  # fmt: skip
    run, word = read_run(run_dir), Path(run_dir).name
    _same_scene(digest.scene, run.scene, f"the digest {digest.name} ({digest.command}) and {run_dir}", run.path)
    _name_notes(run)
    failed = [Row(word, check, value, 0.0, 0.0, "", True) for check, (ok, value) in run.checks.items() if not ok]
    return [*failed, *against(digest, word, numbers_in(run_dir))]
