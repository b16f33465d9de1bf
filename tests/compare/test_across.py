"""Groups that differ in a named setting: verdict first, the difference with its interval, a figure, 80 columns."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from pywet.cli.app import app
from pywet.compare import command, statistics, verdict
from pywet.scene import EngineScene
from tests.compare.test_compare import made
from tests.error_codes import raises_code

ENDS = {"five": (0.70, 0.72, 0.74, 0.66), "seven": (0.71, 0.75, 0.69, 0.72)}


@pytest.fixture(scope="module")
def groups(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Four seeds each of two films; the fraction retained at the end is that of ENDS."""
    folder = tmp_path_factory.mktemp("across")
    for group, (name, ends) in enumerate(ENDS.items()):
        for k, end in enumerate(ends):
            run = made(folder / name / str(k), seed=k)
            scene = EngineScene.read(run / "scene.json")
            assert scene.liquid is not None
            film = scene.liquid.model_copy(update={"initial_film_thickness_m": (5e-5, 7e-5)[group]})
            changed = scene.model_copy(update={"liquid": film, "name": f"case0{2 + group}"})
            (run / "scene.json").write_text(changed.model_dump_json())
            path = run / "results" / "fraction_retained.parquet"
            table = pd.read_parquet(path)
            table.loc[table.index[-1], "fraction_retained"] = end
            table.to_parquet(path)
            path = run / "trajectory.parquet"
            table = pd.read_parquet(path)
            table.assign(x=table["x"] + 1e-9 * (1 + k)).to_parquet(path)
    return folder / "five", folder / "seven"


def compared(*arguments: object) -> tuple[int, str]:
    done = CliRunner(env={"COLUMNS": "80"}).invoke(app, ["compare", *map(str, arguments)])
    return done.exit_code, done.output


def test_five_and_seven_per_cent(groups: tuple[Path, Path], tmp_path: Path) -> None:
    """The first line is the verdict, the second the difference: +0.0125 ± 0.052 of the ends above, by hand from Student's t."""
    figure, answer = tmp_path / "moisture.svg", tmp_path / "answer.json"
    code, output_text = compared(*groups, "--across", "liquid", "--plot", figure, "--json", answer)
    first, second = output_text.splitlines()[:2]
    assert code == 0 and first.startswith("no difference beyond the spread of 4 and 4 seeds")
    assert "B − A +0.0125 ± 0.052 (95 %): not significant" in second and "A 0.705 ± 0.054" in second
    rows = {row["quantity"]: row for row in json.loads(answer.read_text())["rows"]}
    a, b = (np.array(ends) for ends in ENDS.values())
    assert rows["fraction retained"]["interval"] == pytest.approx(statistics.of_difference(a, b), rel=1e-9)
    assert figure.read_text().count("<path") > 20


def test_the_table_fits_80_columns(groups: tuple[Path, Path]) -> None:
    """Every row of the table is at most 80 characters wide, none is cut off."""
    output_text = compared(*groups, "--across", "liquid")[1].splitlines()
    start = next(k for k, line in enumerate(output_text) if line.startswith("quantity"))
    end = next(k for k, line in enumerate(output_text) if line.startswith("B − A:"))
    assert end - start > 10 and all(len(line) <= 80 and "…" not in line for line in output_text[start:end])


def test_another_moisture_is_refused_with_the_way_to_it(groups: tuple[Path, Path]) -> None:
    """Without --across the sentence names the option; a setting that is none is refused with those that are."""
    for pair in (groups, [group / "0" for group in groups]):  # folders of seeds, and runs
        code, output_text = compared(*pair)
        assert code == 2 and "(--across liquid compares groups across it" in " ".join(output_text.split())
    code, output_text = compared(*groups, "--across", "moisture")
    assert (
        code == 2
        and "--across moisture was given; expected a setting that may differ: sphere classes, liquid," in output_text
    )
    code, output_text = compared(groups[0].parent / "five", "--a", groups[0])
    assert code == 2


def test_seeds_of_one_group_stay_of_one_setting(groups: tuple[Path, Path]) -> None:
    """--across is between the groups: a group that mixes 5 % and 7 % is refused."""
    with raises_code("compare.scenes", given=("liquid",)):
        verdict.compare([groups[0] / "0", groups[1] / "0"], [groups[1] / "1"], across=["liquid"])


def test_a_name_is_no_setting_of_a_scene(tmp_path: Path) -> None:
    """Two user-defined scenes are compared by what is in them: their names may differ, their friction may not."""
    runs = [made(tmp_path / name) for name in ("own", "stock")]
    scenes = [EngineScene.read(run / "scene.json").model_copy(update={"slide": None, "name": run.name}) for run in runs]
    for run, scene in zip(runs, scenes, strict=True):
        (run / "scene.json").write_text(scene.model_dump_json())
    assert not verdict.compare(*([run] for run in runs)).different
    pairs = tuple(pair.model_copy(update={"friction": pair.friction + 0.1}) for pair in scenes[1].pairs)
    (runs[1] / "scene.json").write_text(scenes[1].model_copy(update={"pairs": pairs}).model_dump_json())
    with raises_code("compare.scenes", given=("materials",)):
        verdict.compare(*([run] for run in runs))


def test_the_second_line_is_on_what_differs_most(tmp_path: Path) -> None:
    """Of a scene without a fraction retained: the quantity of the smallest p at its time, with the verdict of the table."""
    for name, more in (("a", 0.0), ("b", 0.4)):
        for k in range(4):
            run = made(tmp_path / name / str(k), seed=k)
            (run / "results" / "fraction_retained.parquet").unlink()
            table = pd.read_parquet(run / "trajectory.parquet")
            table.assign(x=table["x"] + 1e-9 * (k + more)).to_parquet(run / "trajectory.parquet")
            held = pd.read_parquet(run / "results" / "liquid_by_holder.parquet")
            held.loc[1, "fines_m3"] = (more + 0.01 * k) * held["initial_m3"].max()
            held.to_parquet(run / "results" / "liquid_by_holder.parquet")
    first, second = compared(tmp_path / "a", tmp_path / "b")[1].splitlines()[:2]
    assert first.endswith("first of all liquid fines"), first
    assert second.startswith(f"liquid fines at {held.loc[1, 'time_s']:.3g} s") and "B − A +0.4 " in second, second
    assert second.endswith("(95 %): significant")


def test_names_of_groups_in_a_figure(tmp_path: Path) -> None:
    """Folders of seeds are named by what tells them apart, not by the name of their first seed."""
    path = Path("d")
    assert command._names([path / "5"], [path / "7"]) == ("A 5", "B 7")
    assert command._names([path / "5/1", path / "5/1-2"], [path / "7/1", path / "7/1-2"]) == ("A 5/1", "B 7/1")
    assert command._names([path / "case02"], [path / "case02"]) == ("A case02", "B case02")
