"""Comparison of runs: the statistics keep their level and find a shift; groups, single runs, digests, exit codes."""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from typer.testing import CliRunner

from pywet import stages
from pywet.cases.small.scenes import RESULT
from pywet.cli.app import app
from pywet.compare import digest, quantities, statistics, verdict
from pywet.compare.statistics import Sample
from pywet.errors import PywetError
from pywet.runs.distinct_seeds import distinct_seeds
from pywet.scene import SCRIPTED, EngineScene, Insertion, Outlet, Rotation, Vibration
from studies import references
from tests.cases.screening import synthetic
from tests.error_codes import raises_code

TRIALS = 400
BAND = 3.0 * np.sqrt(0.05 * 0.95 / TRIALS)
"""Three standard errors of a rate of 5 % over TRIALS."""


def curves(random: np.random.Generator, runs: int, shift: float = 0.0) -> np.ndarray:
    """Curves like a fraction retained: smooth, correlated in time, equal at the start, standard deviation 0.02 later on."""
    steps = random.normal(0.0, 1.0, (runs, 30)).cumsum(axis=1) / np.sqrt(30.0)
    t = np.linspace(0.0, 1.0, 30)
    return 1.0 - 0.5 * t + 0.02 * steps * t**0.5 + shift * t


def called(runs: tuple[int, int], shift: float, trials: int = TRIALS) -> float:
    """Share of trials in which any of three quantities is called different."""
    random, count = np.random.default_rng(5), 0
    for _ in range(trials):
        samples = [Sample(curves(random, runs[0]), curves(random, runs[1], shift)) for _ in range(2)]
        heavy = random.standard_t(3, (sum(runs), 1))  # a quantity with heavy tails
        samples.append(Sample(heavy[: runs[0]], heavy[runs[0] :]))
        count += any(f.p <= 0.05 for f in statistics.test(samples)[1])
    return count / trials


@pytest.mark.parametrize("runs", [(2, 2), (3, 3), (1, 4), (4, 4)])
def test_equal_groups_are_rarely_called_different(runs: tuple[int, int]) -> None:
    """At most the stated 5 % over the whole comparison (plus three standard errors of the estimate)."""
    assert called(runs, 0.0) <= 0.05 + BAND


@pytest.mark.parametrize("runs", [(1, 2), (2, 2), (1, 3)])
@pytest.mark.parametrize("counted", ["few", "many", "rounded"])
def test_counts_that_coincide_are_rarely_called_different(runs: tuple[int, int], counted: str) -> None:
    """Two or three runs with the same count by accident, such as 78 against 77 and 77, tell nothing of its scatter."""
    random, called_so = np.random.default_rng(8), 0
    draw = {
        "few": lambda: random.poisson(3.0, (sum(runs), 1)),
        "many": lambda: random.poisson(77.0, (sum(runs), 1)),
        "rounded": lambda: random.normal(20.0, 0.4, (sum(runs), 1)).round(),
    }[counted]
    for _ in range(TRIALS):
        drawn = [draw().astype(float), draw().astype(float)]
        samples = [Sample(curves(random, runs[0]), curves(random, runs[1]))]
        samples += [Sample(d[: runs[0]], d[runs[0] :]) for d in drawn]
        called_so += any(f.p <= 0.05 for f in statistics.test(samples)[1])
    assert called_so / TRIALS <= 0.05 + BAND


def test_permutation_test_is_not_shy() -> None:
    """252 arrangements of 5 and 5 runs: the rate is the level, not far below it (12 of 252 are at most 0.05: 0.048)."""
    assert called((5, 5), 0.0) == pytest.approx(0.048, abs=BAND)


@pytest.mark.parametrize(("runs", "shift", "power"), [((5, 5), 0.06, 0.8), ((3, 3), 0.25, 0.8), ((1, 5), 0.4, 0.8)])
def test_a_shift_is_found(runs: tuple[int, int], shift: float, power: float) -> None:
    """Three standard deviations with five seeds each; fewer seeds need larger shifts."""
    assert called(runs, shift, 100) >= power


def test_t_is_students() -> None:
    """Compare t of the pooled variance with SciPy's at every time."""
    rng = np.random.default_rng(4)
    one, two = rng.normal(0.0, 1.0, (7, 5)), rng.normal(0.3, 2.0, (4, 5))
    assert statistics.pooled_t(one, two) == pytest.approx(stats.ttest_ind(one, two).statistic, rel=1e-12)


def test_no_spread_at_all_is_compared_with_round_off() -> None:
    """Runs that do not depend on the seed: 1e-10 is round-off, 1e-3 is a difference."""
    one = np.ones((3, 1))
    assert statistics.test([Sample(one, one + 1e-10)])[1][0].p == 1.0
    assert statistics.test([Sample(one, one + 1e-3)])[1][0].p == 0.0
    assert statistics.test([Sample(one, one + 1e-3), Sample(one, one)])[1][0].p == 0.0
    scattered = Sample(np.array([[0.1], [0.2], [0.3]]), np.array([[0.1], [0.2], [0.3]]))
    assert statistics.test([Sample(one, one + 1e-3), scattered])[1][0].p == pytest.approx(2 * 2 / 20)  # Holm over both


def made(folder: Path, change: float = 0.0, seed: int = 10007) -> Path:
    """The synthetic run with its results; `change` lifts the fraction retained at the end."""
    synthetic.make(folder)
    stages.results(folder)
    changed(folder, seed=seed)
    if change:
        path = folder / "results" / "fraction_retained.parquet"
        table = pd.read_parquet(path)
        table.loc[table.index[-1], "fraction_retained"] += change
        table.to_parquet(path)
    return folder


def changed(folder: Path, **settings: Any) -> EngineScene:
    """Change settings in the scene of a run, and return it."""
    scene = EngineScene.read(folder / "scene.json").model_copy(update=settings)
    (folder / "scene.json").write_text(scene.model_dump_json())
    return scene


def run(*arguments: str, command: str = "compare") -> tuple[int, str]:
    """Exit code and output of `pywet compare`, or of another command."""
    done = CliRunner(env={"COLUMNS": "200"}).invoke(app, [command, *arguments])
    return done.exit_code, done.output


def test_single_runs(tmp_path: Path) -> None:
    """Bit-identical, within round-off, different; a difference of one run each is not called significant."""
    a, near, far = made(tmp_path / "a"), made(tmp_path / "near", 1e-12), made(tmp_path / "far", 1e-3)
    shutil.copytree(a, tmp_path / "same")
    assert run(str(a), str(tmp_path / "same"))[0] == 0
    assert verdict.compare([a], [tmp_path / "same"]).verdict == "the runs are bit-identical"
    assert "within round-off" in verdict.compare([a], [near]).verdict
    code, output_text = run(str(a), str(far), "--json", str(tmp_path / "out.json"))
    assert code == 1 and "says nothing about significance" in " ".join(output_text.split())
    assert output_text.count("at [s]") == 2  # the column and the line that explains it
    rows = {r["quantity"]: r for r in json.loads((tmp_path / "out.json").read_text())["rows"]}
    assert rows["fraction retained"]["deviation"] == pytest.approx(1e-3, rel=1e-6)
    assert not rows["fraction retained small"]["different"] if "fraction retained small" in rows else True


def test_output_that_fails_is_no_difference(tmp_path: Path) -> None:
    """Exit code 2: another suffix, before the runs are read; dry scenes without a curve; a folder that cannot be made."""
    a, b = made(tmp_path / "a"), made(tmp_path / "b")
    assert run(str(a), str(b))[0] == 0
    code, output_text = run(str(a), str(b), "--plot", str(tmp_path / "fig.jpg"))
    assert code == 2 and "bit-identical" not in output_text and "expected a name that ends in .pdf" in output_text
    (tmp_path / "file").touch()
    code, output_text = run(str(a), str(b), "--json", str(tmp_path / "file" / "out.json"))
    assert code == 2 and "could not be written" in output_text
    dry = [synthetic.make(tmp_path / name, moist=False) for name in ("dry", "again")]
    code, output_text = run(*map(str, dry), "--plot", str(tmp_path / "fig.svg"))
    assert code == 2 and "bit-identical" in output_text and "liquid to plot" in output_text


def test_groups_from_folders(tmp_path: Path) -> None:
    """Folders of seeds become groups; a shift of ten spreads is called, one within the spread is not."""
    random = np.random.default_rng(2)
    for group, shift in (("a", 0.0), ("b", 0.0), ("c", 0.1)):
        for k in range(5):
            folder = made(tmp_path / group / str(k), shift + 0.01 * random.normal(), seed=k)
            path = folder / "trajectory.parquet"
            table = pd.read_parquet(path)
            pd.concat([table.assign(x=table["x"] + 1e-6 * random.normal())]).to_parquet(path)
    assert run(str(tmp_path / "a"), str(tmp_path / "b"))[0] == 0
    code, output_text = run("--a", str(tmp_path / "a"), "--b", str(tmp_path / "c"))
    assert code == 1 and "beyond the spread of 5 and 5 seeds" in " ".join(output_text.split())


def test_what_cannot_be_compared(tmp_path: Path) -> None:
    """Exit code 2 and one sentence; --force goes on."""
    a, b = made(tmp_path / "a"), made(tmp_path / "b")
    changed(b, gravity_m_per_s2=(0.0, 0.0, -1.0))
    assert run(str(a), str(b))[0] == 2
    assert run(str(a), str(b), "--force")[0] == 0
    with raises_code("compare.scenes"):
        verdict.compare([a], [b])
    with raises_code("compare.same_run"):
        verdict.compare([a, made(tmp_path / "other_seed", seed=2)], [made(tmp_path / "c")])
    assert run(str(a))[0] == 2
    assert run(str(a), str(tmp_path))[0] == 2  # a group in which runs differ
    assert run(str(a), str(tmp_path / "nothing"))[0] == 2


VIBRATES = Vibration(amplitude_m=(0.0, 0.0, 1e-3), phase_rad=(0.0, 0.0, 0.0), frequency_Hz=20.0)
TURNS = Rotation(origin_m=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0), period_s=2.0)
OTHER_SCENES: dict[str, Callable[[EngineScene], dict[str, Any]]] = {
    "motions": lambda s: {"walls": with_first(s.walls, motion_parameters=faster(VIBRATES))},
    "half widths": lambda s: {"walls": with_first(s.walls, part_half_width_m=(2e-3,))},
    "periodic": lambda s: {"periodic": "x"},
    "outlets": lambda s: {"outlets": (Outlet(name="end", low_m=(0.01, None, None), high_m=(None,) * 3),)},
    "insertion": lambda s: {"classes": with_first(s.classes, insertion=Insertion(from_s=0.0, for_s=0.01))},
}
"""What `facts` calls it -> settings of a scene that differ in it."""


def faster(vibration: Vibration) -> Vibration:
    return vibration.model_copy(update={"frequency_Hz": 1.25 * vibration.frequency_Hz})


def with_first(items: tuple[Any, ...], **settings: Any) -> tuple[Any, ...]:
    """Change settings of the first item."""
    return items[0].model_copy(update=settings), *items[1:]


@pytest.mark.parametrize("named", OTHER_SCENES)
def test_what_makes_another_scene(named: str) -> None:
    """A wall that vibrates faster, thicker wires, another boundary, outlet or insertion; what an older digest does not hold may
    differ."""
    scene = synthetic.scene()
    scene = scene.model_copy(update={"walls": with_first(scene.walls, motion_parameters=VIBRATES)})
    other, wanted = scene.model_copy(update=OTHER_SCENES[named](scene)), quantities.facts(scene)
    assert quantities.unlike(wanted, scene) == [] and quantities.unlike(wanted, other) == [named]
    assert quantities.unlike(wanted, other, across=[named]) == []
    del wanted[named]
    assert quantities.unlike(wanted, other) == []


def test_a_wall_of_another_frequency_is_another_scene(tmp_path: Path) -> None:
    """20 and 25 Hz: exit code 2 with --across in the sentence, alone, pooled, and against a digest."""
    a, b = replayed(tmp_path / "ab" / "a", seed=1), replayed(tmp_path / "ab" / "b", seed=2)
    changed(a, walls=with_first(synthetic.scene().walls, motion_parameters=VIBRATES))
    changed(b, walls=with_first(synthetic.scene().walls, motion_parameters=faster(VIBRATES)))
    for groups, advice in (
        ((a, b), "(--across motions compares groups"),
        ((a.parent, a), "compare them as two groups (--a"),
    ):
        code, output_text = run(*map(str, groups))
        assert code == 2 and advice in " ".join(output_text.split())
    assert verdict.compare([a], [b], across=["motions"]).verdict == "the runs are bit-identical"
    file = str(tmp_path / "a.json")
    assert run(str(a), "--out", file, command="digest")[0] == 0
    code, output_text = run(str(b), "--digest", file)
    assert code == 2 and "differ in motions" in " ".join(output_text.split()) and "changed" not in output_text


def test_the_rotation_and_the_extents_of_walls_belong_to_a_scene(tmp_path: Path) -> None:
    """A scene's rotation; walls of the same triangles and other corners, which are compared to a nanometre."""
    a, b, c = (made(tmp_path / name) for name in "abc")
    changed(a, rotation=TURNS)
    changed(b, rotation=TURNS.model_copy(update={"period_s": 1.0}))
    with raises_code("compare.scenes", given=("motions",)):
        verdict.compare([a], [b])
    changed(c, rotation=TURNS)
    path = c / "history" / "triangles.parquet"
    corners = pd.read_parquet(path)
    corners.assign(v0_x=corners["v0_x"] + 1e-13).to_parquet(path)
    assert verdict.compare([a], [c]).verdict == "the runs are bit-identical"
    corners.assign(v0_x=1.1 * corners["v0_x"]).to_parquet(path)
    with raises_code("compare.scenes", given=("wall extents",)):
        verdict.compare([a], [c])


@pytest.mark.parametrize("setting", ["effects", "time_step_s"])
def test_runs_of_one_group_differ_in_the_seed_alone(tmp_path: Path, setting: str) -> None:
    """Another law or time step within a group, or within a digest, is refused; between two groups it is compared."""
    runs = [replayed(tmp_path / f"seeds/{k}", 0.01 * k, seed=k) for k in (1, 2)]
    effects = synthetic.scene().effects.model_copy(update={"capillary": "willett"})
    changed(runs[1], **{setting: {"effects": effects, "time_step_s": synthetic.TIME_STEP * (1.0 + 1e-9)}[setting]})
    with raises_code("compare.scenes", given=(setting,)):
        verdict.compare(runs, [runs[0]])
    assert "the runs differ" in verdict.compare([runs[0]], [runs[1]]).verdict
    code, output_text = run(str(tmp_path / "seeds"), "--out", str(tmp_path / "mine.json"), command="digest")
    assert code == 2 and f"differ in {setting}; expected runs of one scene" in " ".join(output_text.split())


def test_a_seed_counts_once(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """The same seed again, as on two ranks: left out with a notice by compare and digest, unless --force is given."""
    a, again = replayed(tmp_path / "a", 0.01), replayed(tmp_path / "again", 0.0101)
    other, c = replayed(tmp_path / "other", 0.02, seed=2), made(tmp_path / "c", 0.03)
    moved(other)
    assert verdict.compare([a, again, other], [c]).a == [str(a), str(other)]
    assert "again has seed 10007, as" in caplog.text
    assert verdict.compare([a, again], [c], force=True).a == [str(a), str(again)]
    code, output_text = run(str(a), str(a), "--out", str(tmp_path / "mine.json"), command="digest")
    assert code == 0 and "numbers of 1 runs" in output_text


def moved(folder: Path) -> None:
    """Move the spheres of a run a little, as another seed does."""
    table = pd.read_parquet(folder / "trajectory.parquet")
    table.assign(x=table["x"] + 1e-9).to_parquet(folder / "trajectory.parquet")


def test_seeds_that_scene_json_does_not_hold(tmp_path: Path) -> None:
    """Beds of `pywet scene` have other initial spheres, runs of a script unknown seeds: none is left out."""
    for name, x in (("a", 0.0), ("b", 1e-6), ("again", 0.0)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "scene.json").write_text(json.dumps({"name": "small", "seed": 0}))
        pd.DataFrame({"id": [1], "x": [x]}).to_parquet(tmp_path / name / "spheres.parquet")
    runs = [tmp_path / name for name in ("a", "b", "again")]
    assert distinct_seeds(runs) == runs[:2]
    for run_dir in runs:
        (run_dir / "scene.json").write_text(json.dumps({"name": SCRIPTED, "seed": 0}))
    assert distinct_seeds(runs) == runs


def test_a_count_that_coincides_has_no_interval(tmp_path: Path) -> None:
    """Four formations against three and three, where the fraction retained scatters: no difference, no interval of width 0."""
    a, *others = (replayed(tmp_path / str(k), 0.01 * k, seed=k) for k in (1, 2, 3))
    for k, other in enumerate(others):
        moved(other) if k else None
        path = other / "history" / "ledger.parquet"
        ledger = pd.read_parquet(path)
        ledger.loc[ledger.index[-1], ["formations", "ruptures"]] = [3, 3]
        ledger.to_parquet(path)
    found = verdict.compare([a], others)
    row = next(row for row in found.rows if row.quantity == "formations")
    assert not found.different and not row.different and row.interval is None and (row.a, row.b) == (4.0, 3.0)
    second = verdict._described(verdict.read_groups([a], others), "formations", row)
    assert second.endswith("B − A -1; no interval, as neither group scatters")


def test_a_failed_check_is_a_difference(tmp_path: Path) -> None:
    """A ledger that does not close is reported whatever the curves say."""
    a, b = made(tmp_path / "a"), made(tmp_path / "b")
    stages.results(b)
    content = json.loads((b / "summary.json").read_text())
    content["checks"][0]["ok"] = False
    (b / "summary.json").write_text(json.dumps(content))
    assert "failed checks: no particle lost" in verdict.compare([a], [b]).verdict


def test_digest_of_runs(tmp_path: Path) -> None:
    """Mean and spread come back; a run of the same kind passes, a changed one raises the alarm; bad runs are refused."""
    random = np.random.default_rng(3)
    values = [{"x": (1.0 + 0.1 * random.normal(), 1.0, "m"), "y": (2.0, 2.0, "m")} for _ in range(10)]
    stored = digest.load(digest.save(digest.make("one", "command", values), tmp_path / "one.json"))
    assert stored.numbers["x"].spread == pytest.approx(np.std([v["x"][0] for v in values], ddof=1), rel=1e-9)
    assert all(r.ok for r in digest.against(stored, "run", {"x": (1.1, 1.0, "m"), "y": (2.0 + 1e-6, 2.0, "m")}))
    assert [r.ok for r in digest.against(stored, "run", {"x": (3.0, 1.0, "m"), "y": (2.001, 2.0, "m")})] == [
        False,
        False,
    ]
    assert [r.ok for r in digest.against(stored, "run", {"x": (1.0, 1.0, "m")})] == [True, False]
    with raises_code("digest.not_replayed"):
        digest.of_runs("s", "c", [made(tmp_path / "run")])
    with pytest.raises(PywetError, match="no reference scene"):
        references.made("nothing")


def test_counts_that_coincide_in_a_digest(tmp_path: Path) -> None:
    """77 formations in three of three runs: 78 is as stored where another number scatters, and changed where none does."""
    for deviation, ok in ((0.1, True), (0.0, False)):
        runs = [{"n": (77.0, 77.0, "events"), "x": (1.0 + deviation * k, 1.0, "m")} for k in range(3)]
        stored = digest.make("one", "command", runs)
        values = {"n": (78.0, 77.0, "events"), "x": (1.0, 1.0, "m")}
        assert [row.ok for row in digest.against(stored, "run", values)] == [ok, True]


def test_shares_that_coincide_in_a_digest() -> None:
    """59 of 60 where all runs had 60: as stored if the curve scatters at another time, or nowhere while other numbers do; a
    length is changed, and everything where nothing scatters."""
    for deviation, oks in ((0.1, [True, True, False]), (0.0, [False, False, False])):
        shares = {"share at 20%": (1.0, 1.0, "1"), "rare": (1.0, 1.0, "of all"), "x at 20%": (1.0, 1.0, "m")}
        runs = [{**shares, "share at 40%": (1.0 - deviation * k, 1.0, "1")} for k in range(3)]
        stored = digest.make("one", "command", runs)
        values = {name: (59 / 60, *rest) for name, (_, *rest) in shares.items()}
        assert [row.ok for row in digest.against(stored, "run", values)[:3]] == oks
    stored = digest.make(
        "one", "command", [{"n at 20%": (1.0, 1.0, "1"), "n at 40%": (k, 1.0, "1")} for k in (0.4, 0.5)]
    )
    assert digest.allowed(stored, "n at 20%") == digest.allowed(stored, "n at 40%") < math.inf


def test_a_run_that_fails_a_check_is_not_as_its_digest(tmp_path: Path) -> None:
    """All numbers are as stored, and the replay disagrees: exit code 1, and the check is named."""
    one, file = replayed(tmp_path / "one"), str(tmp_path / "one.json")
    assert run(str(one), "--out", file, command="digest")[0] == 0
    assert run(str(one), "--digest", file)[0] == 0
    (one / "replay.json").write_text(json.dumps({"ok": False, "quantities": {}}))
    code, output_text = run(str(one), "--digest", file)
    assert code == 1 and output_text.splitlines()[-1].endswith(": replay") and "failed check" in output_text


def replayed(folder: Path, change: float = 0.0, seed: int = 10007) -> Path:
    """Return a run whose replay agrees."""
    made(folder, change, seed)
    (folder / "replay.json").write_text(json.dumps({"ok": True, "quantities": {}}))
    return folder


def test_digest_of_given_runs(tmp_path: Path) -> None:
    """Four seeds: one like them is as stored, one far off is changed; another scene is refused with exit code 2, nothing said
    of it. Numbers have their units."""
    seeds = [replayed(tmp_path / "seeds" / str(k), 0.01 * k, seed=k) for k in range(1, 5)]
    file = str(tmp_path / "mine.json")
    code, output_text = run(str(tmp_path / "seeds"), "--out", file, command="digest")
    assert code == 0 and "numbers of 4 runs" in output_text
    assert digest.load(Path(file)).scene is not None
    assert run(str(seeds[0]), "--digest", file)[0] == 0
    code, output_text = run(str(seeds[0]), "--digest", file, "--json", str(tmp_path / "rows.json"))
    assert code == 2 and "expected RUN… --digest FILE alone" in output_text
    code, output_text = run(str(replayed(tmp_path / "far", 1.0)), "--digest", file)
    assert code == 1 and "changed since" in output_text
    rows = [line.split() for line in output_text.splitlines() if "mean height at the end" in line]
    assert rows and all("m" in row for row in rows)
    other = replayed(tmp_path / "other")
    scene = EngineScene.read(other / "scene.json")
    (other / "scene.json").write_text(scene.model_copy(update={"gravity_m_per_s2": (0.0, 0.0, -1.0)}).model_dump_json())
    code, output_text = run(str(other), "--digest", file)
    assert code == 2 and "differ in gravity" in output_text and "changed" not in output_text
    code, output_text = run(str(seeds[0]), str(other), "--out", file, command="digest")
    assert code == 2 and "expected runs of one scene" in output_text
    assert run(str(seeds[0]), command="digest")[0] == 2  # without --out
    code, output_text = run(str(seeds[0]), "--digest", str(references.STORE / "pull.json"))
    assert code == 2 and "differ in case" in output_text


@pytest.mark.parametrize("order", [("1", "2", "3"), ("3", "2", "1")])
def test_a_digest_has_the_numbers_that_all_runs_have(tmp_path: Path, order: tuple[str, ...]) -> None:
    """Only the first, or only the last, has a number, as a cut size that is not enclosed: it is named, the others are stored."""
    for k in order:
        replayed(tmp_path / k, 0.01 * int(k), seed=int(k))
        (tmp_path / k / RESULT).write_text(json.dumps({"d50_mm": 2.5 if k == "1" else None, "angle_deg": float(k)}))
    file = tmp_path / "mine.json"
    code, output_text = run(*(str(tmp_path / k) for k in order), "--out", str(file), command="digest")
    assert code == 0 and "not in the digest, since only some runs have them: result d50_mm" in output_text, output_text
    stored = digest.load(file)
    assert stored.left_out == ("result d50_mm",) and "result d50_mm" not in stored.numbers
    angle = stored.numbers["result angle_deg"]
    assert (angle.mean, angle.spread, angle.unit) == (2.0, 1.0, "deg")
    assert all(run(str(tmp_path / k), "--digest", str(file))[0] == 0 for k in order)


def test_a_digest_is_refused_when_the_replay_disagrees(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is stored of a run that the reference contradicts."""
    bad = {"ok": False, "quantities": {"capillary": {"ok": False, "largest": 0.1}}}
    monkeypatch.setattr(references.stages, "replay", lambda folder: bad)
    with pytest.raises(PywetError, match="disagrees on capillary"):
        references._replayed(made(tmp_path / "run"))


@pytest.mark.engine
@pytest.mark.parametrize("name", references.SCENES)
def test_regression_against_the_stored_digest(name: str, tmp_path: Path) -> None:
    """A regression alarm, not an oracle: a fresh run of each reference scene within its digest's spread and tolerance."""
    one, stored = (
        references.SCENES[name],
        digest.load(Path(__file__).parents[1] / "data" / "digests" / f"{name}.json"),
    )
    rows = digest.against(stored, name, one.run(one.seeds[-1], tmp_path / "run"))
    assert rows and [f"{r.quantity}: {r.value:g}, was {r.mean:g} ± {r.allowed:g}" for r in rows if not r.ok] == []
