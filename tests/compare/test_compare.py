"""Comparison of runs: the statistics keep their level and find a shift; groups, single runs, digests, exit codes."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from typer.testing import CliRunner

from pywet import stages
from pywet.cases.small.scenes import RESULT
from pywet.cli.app import app
from pywet.compare import digest, statistics, verdict
from pywet.compare.statistics import Sample
from pywet.errors import PywetError
from pywet.scene import EngineScene
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


def made(folder: Path, change: float = 0.0) -> Path:
    """The synthetic run with its results; `change` lifts the fraction retained at the end."""
    synthetic.make(folder)
    stages.results(folder)
    if change:
        path = folder / "results" / "fraction_retained.parquet"
        table = pd.read_parquet(path)
        table.loc[table.index[-1], "fraction_retained"] += change
        table.to_parquet(path)
    return folder


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
            folder = made(tmp_path / group / str(k), shift + 0.01 * random.normal())
            path = folder / "trajectory.parquet"
            table = pd.read_parquet(path)
            pd.concat([table.assign(x=table["x"] + 1e-6 * random.normal())]).to_parquet(path)
    assert run(str(tmp_path / "a"), str(tmp_path / "b"))[0] == 0
    code, output_text = run("--a", str(tmp_path / "a"), "--b", str(tmp_path / "c"))
    assert code == 1 and "beyond the spread of 5 and 5 seeds" in " ".join(output_text.split())


def test_what_cannot_be_compared(tmp_path: Path) -> None:
    """Exit code 2 and one sentence; --force goes on."""
    a, b = made(tmp_path / "a"), made(tmp_path / "b")
    scene = EngineScene.read(b / "scene.json")
    (b / "scene.json").write_text(scene.model_copy(update={"gravity_m_per_s2": (0.0, 0.0, -1.0)}).model_dump_json())
    assert run(str(a), str(b))[0] == 2
    assert run(str(a), str(b), "--force")[0] == 0
    with raises_code("compare.scenes"):
        verdict.compare([a], [b])
    with raises_code("compare.same_run"):
        verdict.compare([a, a], [made(tmp_path / "c")])
    assert run(str(a))[0] == 2
    assert run(str(a), str(tmp_path))[0] == 2  # a group in which runs differ
    assert run(str(a), str(tmp_path / "nothing"))[0] == 2


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
    values = [{"x": (1.0 + 0.1 * random.normal(), 1.0, "m"), "y": (2.0, 2.0, "1")} for _ in range(10)]
    stored = digest.load(digest.save(digest.make("one", "command", values), tmp_path / "one.json"))
    assert stored.numbers["x"].spread == pytest.approx(np.std([v["x"][0] for v in values], ddof=1), rel=1e-9)
    assert all(r.ok for r in digest.against(stored, "run", {"x": (1.1, 1.0, "m"), "y": (2.0 + 1e-6, 2.0, "1")}))
    assert [r.ok for r in digest.against(stored, "run", {"x": (3.0, 1.0, "m"), "y": (2.001, 2.0, "1")})] == [
        False,
        False,
    ]
    assert [r.ok for r in digest.against(stored, "run", {"x": (1.0, 1.0, "m")})] == [True, False]
    with raises_code("digest.not_replayed"):
        digest.of_runs("s", "c", [made(tmp_path / "run")])
    with pytest.raises(PywetError, match="no reference scene"):
        references.made("nothing")


def replayed(folder: Path, change: float = 0.0) -> Path:
    """Return a run whose replay agrees."""
    made(folder, change)
    (folder / "replay.json").write_text(json.dumps({"ok": True, "quantities": {}}))
    return folder


def test_digest_of_given_runs(tmp_path: Path) -> None:
    """Four seeds: one like them is as stored, one far off is changed; another scene is refused with exit code 2, nothing said
    of it. Numbers have their units."""
    seeds = [replayed(tmp_path / "seeds" / str(k), 0.01 * k) for k in range(1, 5)]
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
        replayed(tmp_path / k, 0.01 * int(k))
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
