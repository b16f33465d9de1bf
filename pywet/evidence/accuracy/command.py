"""What `pywet study accuracy`, `pywet plan CASE --accuracy` and the workflow's rounds do."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import Progress

from pywet import config as settings
from pywet.config import Config
from pywet.errors import PywetError
from pywet.evidence.accuracy import choice, cost, edit, page, runs, sieve, store
from pywet.evidence.accuracy.errors import GROUPS
from pywet.evidence.accuracy.knobs import KNOBS, Setting
from pywet.files import write_json

OUT = Path("results/studies/accuracy")
out, err = Console(highlight=False), Console(stderr=True, highlight=False)


def study(folder: Path, size: str, config_dir: Path, renew: bool) -> Path:
    """All rounds that are missing, with progress, then the page; returns it."""
    rounds = runs.rounds(size)  # refuses a size that is not there
    missing = [r for scene, seed in rounds for r in runs.missing(folder, scene, seed, size, config_dir)]
    if missing:
        seconds = expected(missing, size, config_dir)
        err.print(
            f"{len(missing)} runs to do, about {duration(seconds)} on a quiet machine (stop and go on at any time)"
        )
    with Progress(console=err, transient=True) as bar:
        task = bar.add_task("accuracy study", total=float(len(rounds)))
        for k, (scene, seed) in enumerate(rounds):

            def report(name: str, done: int, of: int, k: int = k) -> None:
                bar.update(task, description=name, completed=k + done / of)

            runs.do_round(folder, scene, seed, size, config_dir, report)
    return show(folder, size, config_dir, renew)


def show(folder: Path, size: str, config_dir: Path, renew: bool = False) -> Path:
    """Table and page from the runs that are there and were made with this configuration."""
    kept = list(runs.load(folder, size, config_dir))
    if not any(r["scene"] in runs.SCREENING for r in kept):
        raise PywetError(f"no runs of size {size} in {folder}; expected some: run `pywet study accuracy --size {size}`")
    table = store.table(kept, size)
    write_json(folder / "table.json", store.rounded(table))
    if renew:
        store.write(table)
    others = [held for held in choice.stored()["scales"].values() if held["provenance"]["size"] != size]
    return page.write(folder.parent / "accuracy.html", table, kept, size, others, times(kept, size, config_dir, table))


def times(
    kept: Sequence[dict[str, Any]], size: str, config_dir: Path, table: dict[str, Any]
) -> list[tuple[str, float, float]] | None:
    """Scene, measured and predicted processor time [s] of every screening run on one rank; None on an unmeasured machine."""
    machine, loaded, known = cost.kept(), settings.load(config_dir), habit(table)
    if machine is None:
        return None
    pairs = []
    for run in kept:
        if run["scene"] in runs.SCREENING and not run["failed"] and run["setting"]["ranks"] == 1:
            made = sieve.with_setting(loaded, Setting(**run["setting"]), sieve.SIZES[size], run["seed"])
            seconds, _ = cost.predict(made, sieve.CASE[run["scene"]], sieve.SCALE, machine, known)
            pairs.append((run["scene"], float(run["cpu_s"]), seconds))
    return pairs


def habit(table: dict[str, Any]) -> cost.Habit:
    """Prices that the table knows of screening in general."""
    laws, integrations = (
        {str(row["level"]): row["price"]["moist"]["ratio"] for row in table["knobs"][knob] if "moist" in row["price"]}
        for knob in ("capillary", "integration")
    )
    return cost.Habit(laws, integrations, table["habit"]["exact_start"])


def expected(missing: list[runs.Run], size: str, config_dir: Path) -> float:
    """Time of these runs on this machine [s], from the cost model; small scenes are guessed at a few seconds each."""
    machine = calibrated(config_dir)
    known = habit(choice.for_scale(sieve.SIZES[size].scale)[0])
    loaded, total = settings.load(config_dir), 0.0
    for run in missing:
        if run.scene not in runs.SCREENING:
            total += 1.0 + (machine.few.start_stock if run.scene == "pair_dry" else machine.few.start_moist)
            continue
        made = sieve.with_setting(loaded, run.setting, sieve.SIZES[size], run.seed)
        try:
            total += cost.predict(made, sieve.CASE[run.scene], sieve.SCALE, machine, known)[0] + 0.5
        except PywetError:
            continue  # refused in no time
    return total


def calibrated(config_dir: Path, anew: bool = False) -> cost.Coefficients:
    """The cost model of this machine; measured with a progress bar at the first call."""
    with Progress(console=err, transient=True) as bar:
        task = bar.add_task("measuring this machine (once, a minute)", total=None, visible=False)
        return cost.of_this_machine(
            config_dir, lambda done, of: bar.update(task, completed=done, total=of, visible=True), anew
        )


def plan(config: Config, case: int, scale: str, accuracy: str, wanted: list[str], write: Path | None) -> list[str]:
    """Settings for an accuracy and the time they take, as lines; with `write` a copy of the configuration that has them."""
    share, groups = choice.parse(accuracy), tuple(wanted) or choice.WANTED
    unknown = [g for g in groups if g not in GROUPS]
    if unknown:
        raise PywetError(f"--of {unknown[0]} given, expected some of {', '.join(GROUPS)}")
    if write is not None:
        edit.new_folder(write)
    table, turned = choice.for_scale(scale)
    moist = config.case(case).liquid_percent > 0
    chosen = choice.choose(table, share, moist, groups, turned)
    changed = edit.settings_of(chosen.levels, turned)
    machine, known = calibrated(config.folder), habit(table)
    seconds, load = cost.predict(edit.changed(config, scale, changed), case, scale, machine, known)
    before, _ = cost.predict(config, case, scale, machine, known)
    lines = [f"settings for {100 * share:g} % in {', '.join(groups)} ({'moist' if moist else 'dry'}):"]
    lines += [f"  {KNOBS[knob].title:<22}{edit.shown(knob, level)}" for knob, level in changed.items()]
    lines += [f"  errors counted: {', '.join(_counted(g, e) for g, e in chosen.error.items())}"]
    blurred = {g: r for g, r in choice.resolution(table, moist).items() if g in groups and r > share}
    lines += [f"  the study tells {g} apart to {100 * r:.2g} % only" for g, r in blurred.items()]
    lines += [
        f"time of the engine's run, 1 rank, quiet machine: {duration(seconds)} (as configured now: {duration(before)})",
        f"  {load.steps:.0f} steps, {load.lists:.0f} neighbour lists, {load.spheres:.0f} spheres, "
        f"about {load.bridges:.0f} bridges",
    ]
    if write is not None:
        edit.write(config.folder, write, scale, changed)
        lines.append(f"written to {write}: pywet run {case} --scale {scale} --config {write}")
    return lines


def _counted(group: str, error: float) -> str:
    return f"{group} {100 * error:.2g} %" if error > 0.0 else f"{group} none resolved"


def predicted(config: Config, case: int, scale: str) -> str:
    """How long a case will take, as text; empty where this machine has not been measured yet."""
    machine = cost.kept()
    if machine is None:
        return ""
    seconds, _ = cost.predict(config, case, scale, machine, habit(choice.for_scale(scale)[0]))
    return f"about {duration(seconds)} on a quiet machine"


def duration(seconds: float) -> str:
    """A time in words.

    >>> duration(75), duration(12.3), duration(9000)
    ('1.2 min', '12 s', '2.5 h')
    """
    if seconds < 60:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.2g} min" if seconds < 5400 else f"{seconds / 3600:.2g} h"


def default_of(table: dict[str, Any]) -> Setting:
    """The default setting of a table."""
    return Setting(**table["default"])
