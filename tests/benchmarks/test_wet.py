"""The wet benchmark problems: answers by a second method, scores of right and wrong answers, refusals."""

from __future__ import annotations

import csv
import io
import itertools
import json
import math
import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from pywet.collisions.spheres import command as davis
from pywet.geometry.stl import read_stl
from pywet.laws import exact_bridge
from studies.engines import bed as settling
from tests.test_docs import check_shown

WET = Path(__file__).parents[2] / "benchmarks" / "wet"
SCORE = runpy.run_path(str(WET / "score.py"))
MAKE = runpy.run_path(str(WET / "make.py"))
QUICK = ("viscous_pull", "wet_rebound", "settling_bed", "drum")


def of(problem: str) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Inputs and answers as they are shipped."""
    inputs, answers = (json.loads((WET / problem / name).read_text()) for name in ("inputs.json", "answers.json"))
    return inputs, answers["answers"]


def filled(problem: str, factor: float = 1.0) -> str:
    """A table of the true answers, or of a multiple of them."""
    table = io.StringIO()
    writer = csv.DictWriter(table, SCORE["COLUMNS"], extrasaction="ignore")
    writer.writeheader()
    writer.writerows({**a, "value": factor * a["value"]} for a in of(problem)[1])
    return table.getvalue()


@pytest.mark.parametrize("problem", ["settling_bed", "drum"])
def test_inputs_of_beds_are_those_of_the_scenes_that_answer(problem: str, tmp_path: Path) -> None:
    """Every number that another program needs, against the scene as it is run and its walls as they are cut."""
    given = of(problem)[0]
    used = runpy.run_path(str(WET / "programs.py"))["BEDS"][problem]
    for case in ("moist", "dry"):
        scene = settling.prepare(tmp_path / case, used, wet=case == "moist")
        sphere, liquid = scene.classes[0], scene.liquid
        assert liquid is not None and scene.effects.bridges == (case == "moist")
        for pair in scene.pairs:
            reported = (pair.friction, pair.restitution, pair.rolling_friction_m, pair.normal_stiffness_N_per_m,
                    pair.tangential_stiffness_N_per_m / pair.normal_stiffness_N_per_m)  # fmt: skip
            names = ("friction", "restitution", "rolling_friction_m", "normal_stiffness_N_per_m",
                     "tangential_over_normal_stiffness")  # fmt: skip
            assert reported == pytest.approx([given[n] for n in names])
        reported = (sphere.count, sphere.radius_m, sphere.density_kg_per_m3, math.degrees(sphere.contact_angle_rad),
                liquid.surface_tension_N_per_m, liquid.viscosity_Pa_s, liquid.density_kg_per_m3, scene.time_step_s,
                scene.duration_s, math.hypot(*scene.gravity_m_per_s2))  # fmt: skip
        names = ("spheres", "radius_m", "density_kg_per_m3", "contact_angle_deg", "surface_tension_N_per_m", "viscosity_Pa_s",
                 "liquid_density_kg_per_m3", "time_step_s", "duration_s", "gravity_m_per_s2")  # fmt: skip
        assert reported == pytest.approx([given[n] for n in names], rel=1e-6)
        angles = [math.degrees(w.contact_angle_rad) for w in scene.walls]
        assert angles == pytest.approx([given["contact_angle_deg"]] * len(angles))
        film = given["cases"]["moist"]["film_m"]
        assert liquid.initial_film_thickness_m == pytest.approx(film, rel=1e-5)
        share = 4.0 * math.pi * sphere.radius_m**2 * film * liquid.density_kg_per_m3 / sphere.mass_kg
        assert 100.0 * share == pytest.approx(given["cases"]["moist"]["liquid_percent_of_mass"], rel=0.01)
        corners = {w.name: read_stl(tmp_path / case / w.stl, name=w.name).corners for w in scene.walls}
        if problem == "drum":
            inner = np.hypot(*corners["mantle"].reshape(-1, 3)[:, :2].T).min()
            assert inner * math.cos(math.pi / given["drum_sides"]) == pytest.approx(given["drum_apothem_m"], rel=1e-5)
            assert np.ptp(corners["mantle"][..., 2]) == pytest.approx(given["drum_width_m"])
            assert scene.rotation is not None
            assert 60.0 / scene.rotation.period_s == pytest.approx(given["turns_per_minute"])
        else:
            x = np.unique(np.round(np.abs(corners["box"][..., 0]), 7))
            assert 2.0 * x.min() == pytest.approx(given["box_side_m"])


def test_every_problem_is_whole() -> None:
    """Words, inputs and answers of each, in the page's table; every case of the inputs is asked for."""
    assert SCORE["problems"]() == sorted(MAKE["PROBLEMS"])
    index = (WET / "README.md").read_text()
    for problem in MAKE["PROBLEMS"]:
        assert f"({problem}/README.md)" in index and (WET / problem / "README.md").is_file()
        inputs, answers = of(problem)
        assert {a["case"] for a in answers} == set(inputs["cases"])


@pytest.mark.parametrize("problem", QUICK)
def test_the_files_are_what_makes_them(problem: str) -> None:
    """Inputs and answers follow from make.py."""
    inputs, answers = MAKE["made"](problem)
    assert json.loads(json.dumps(inputs)) == of(problem)[0]
    for made, stored in zip(answers["answers"], of(problem)[1], strict=True):
        assert {**made, "value": None} == {**stored, "value": None}
        assert made["value"] == pytest.approx(stored["value"], rel=1e-9)


@pytest.mark.parametrize("problem", ["pair_at_rest", "unequal_pair", "sphere_and_plate"])
def test_bridges_by_a_second_method(problem: str) -> None:
    """The solver in pywet, which shares no code with the one that made the answers, for one answer in five and one rupture."""
    inputs, answers = of(problem)
    forces = [a for a in answers if a["quantity"] == "force"][::5]
    ends = [a for a in answers if a["quantity"] == "rupture distance"][:1]
    for a in forces + ends:
        c = inputs["cases"][a["case"]]
        angles = math.radians(c["contact_angle_1_deg"]), math.radians(c["contact_angle_2_deg"])
        bridge = c["volume_m3"], c["radius_1_m"], c["radius_2_m"] or math.inf, *angles
        if a in ends:
            value = exact_bridge.rupture(*bridge).separation
        else:
            solved = exact_bridge.solve(a["at"], *bridge)
            assert solved is not None
            value = solved.force(inputs["surface_tension_N_per_m"])
        assert abs(value - a["value"]) <= a["uncertainty"], a


def test_sharing_by_a_second_method() -> None:
    """Equal spheres share evenly; one other split."""
    inputs, answers = of("rupture_and_sharing")
    shares = {a["case"]: a for a in answers if a["quantity"] == "share of body 1"}
    assert shares["radius ratio 1 angle 0 0"]["value"] == pytest.approx(0.5, abs=1e-5)
    case = "radius ratio 2 angle 0 0"
    c = inputs["cases"][case]
    end = exact_bridge.rupture(c["volume_m3"], c["radius_1_m"], c["radius_2_m"], 0.0, 0.0)
    assert end.transfer_ratio == pytest.approx(shares[case]["value"], abs=shares[case]["uncertainty"])


def test_viscous_pull_meets_lubrication() -> None:
    """Known expansions: plate 1/h - ln(h)/5 + 0.97128 (Cox & Brenner 1967), two spheres
    1/(4h) - 9 ln(h)/40 + 0.673 (Jeffrey 1982)."""
    drag = MAKE["drag"]
    for h in (1e-3, 1e-4):
        assert drag("rigid", h) == pytest.approx(1.0 / h - math.log(h) / 5.0 + 0.97128, rel=2e-3 * h + 1e-6)
        assert 0.5 * drag("free", 0.5 * h) == pytest.approx(0.25 / h - 9.0 / 40.0 * math.log(h) + 0.673, rel=2e-6)
    assert drag("rigid", 50.0) == pytest.approx(1.0 / (1.0 - 9.0 / 8.0 / 51.0), rel=1e-4)


def test_three_spheres_by_a_second_method() -> None:
    """Polar coordinates of each pair in pywet against the Cartesian ones that made the answers."""
    inputs, answers = of("three_spheres")
    for case, c in inputs["cases"].items():
        state = davis.collide(c)["final"]["velocity"]
        for a in (a for a in answers if a["case"] == case):
            axis, sphere = a["quantity"].split()
            value = state[int(sphere) - 1]["xy".index(axis[1])]
            assert abs(value - a["value"]) <= a["uncertainty"], a


@pytest.mark.parametrize("problem", SCORE["problems"]())
def test_scores(problem: str, tmp_path: Path) -> None:
    """True answers are within their uncertainty; those a twentieth too large are off by a twentieth of the largest."""
    table = tmp_path / "answers.csv"
    table.write_text(filled(problem))
    for line in SCORE["scored"](problem, SCORE["read"](table)):
        assert line["answered"] == line["within"] == line["asked"] and line["largest"] <= 1e-12
    table.write_text(filled(problem, 1.05))
    for line in SCORE["scored"](problem, SCORE["read"](table)):
        assert line["largest"] == pytest.approx(0.05)


def test_what_is_not_answered_is_counted(tmp_path: Path) -> None:
    """A template that nobody has filled in scores nothing and says so."""
    table = tmp_path / "empty.csv"
    table.write_text(SCORE["template"]("viscous_pull"))
    lines = SCORE["scored"]("viscous_pull", SCORE["read"](table))
    assert all(line["answered"] == 0 and math.isnan(line["largest"]) for line in lines)


@pytest.mark.parametrize(
    ("problem", "text", "message"),
    [
        ("spheres", "case,quantity,at,value\n", "problem spheres was given; expected one of drum,"),
        ("drum", "a,b\n1,2\n", "expected case, quantity, at, value"),
        (
            "drum",
            "case,quantity,at,value\nmoist,dynamic angle,0,steep\n",
            "row 2: at '0', value 'steep'; expected numbers",
        ),
        ("drum", "case,quantity,at,value\nmoist,dynamic angle,0,nan\n", "row 2: nan at 0.0; expected finite numbers"),
        (
            "drum",
            "case,quantity,at,value\nmoist,height,0,1\n",
            "quantity height is not asked for by drum: see --template",
        ),
        ("drum", None, "cannot be read"),
    ],
)
def test_refusals(problem: str, text: str | None, message: str, tmp_path: Path) -> None:
    """One sentence, exit code 2; by an interpreter without any package."""
    table = tmp_path / "answers.csv"
    if text is not None:
        table.write_text(text)
    command = [sys.executable, "-I", "-S", str(WET / "score.py"), problem, str(table)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2 and message in done.stderr and "Traceback" not in done.stderr


def run_score(*given: object) -> subprocess.CompletedProcess[str]:
    """score.py by an interpreter without any package."""
    command = [sys.executable, "-I", "-S", str(WET / "score.py"), *map(str, given)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_rounded_places_and_a_mark_of_excel(tmp_path: Path) -> None:
    """`at` to three digits and a byte-order mark: all is answered, exit code 0, the class is exact, and the rank is printed."""
    rows = list(csv.DictReader(io.StringIO(filled("viscous_pull"))))
    lines = [f"{r['case']},{r['quantity']},{float(r['at']):.3g},{r['value']}" for r in rows]
    table = tmp_path / "answers.csv"
    table.write_text("\n".join(["case,quantity,at,value", *lines]), encoding="utf-8-sig")
    done = run_score("viscous_pull", table)
    first, *rest = done.stdout.partition("\n\n")[0].splitlines()
    assert done.returncode == 0 and first.startswith("viscous_pull: solved within 10 %; 11 of 11 answered")
    assert "; rank 1 of " in first and all(line.endswith("exact") for line in rest[1:])


@pytest.mark.parametrize("problem", SCORE["problems"]())
def test_places_asked_for_cannot_be_confused(problem: str) -> None:
    """Any two that are asked for are more than ten tolerances of a rounded `at` apart."""
    places: dict[tuple[str, str], list[float]] = {}
    for a in of(problem)[1]:
        places.setdefault((a["case"], a["quantity"]), []).append(a["at"])
    for at in map(sorted, places.values()):
        assert all(high - low > 10 * SCORE["SAME"] * high for low, high in itertools.pairwise(at))


def test_what_is_not_asked_or_asked_once_is_refused(tmp_path: Path) -> None:
    """A place that nobody asked for and a row given twice end with 2 and a sentence that names the row."""
    table, rows = tmp_path / "answers.csv", filled("viscous_pull").splitlines()
    table.write_text("\n".join([*rows, rows[1]]))
    done = run_score("viscous_pull", table)
    assert done.returncode == 2 and "is answered twice; expected one row for each" in done.stderr
    case, quantity, _, value = rows[2].split(",")
    table.write_text("\n".join([rows[0], f"{case},{quantity},7,{value}"]))
    done = run_score("viscous_pull", table)
    assert done.returncode == 2 and "at 7 is not asked for by viscous_pull; expected at 1e-06, 3e-06," in done.stderr


def test_an_empty_template_is_not_solved(tmp_path: Path) -> None:
    """Exit code 1, a verdict and no `nan`."""
    table = tmp_path / "empty.csv"
    table.write_text(SCORE["template"]("viscous_pull"))
    done = run_score("viscous_pull", table)
    assert done.returncode == 1 and done.stdout.startswith("viscous_pull: not solved within 10 %; 0 of 11 answered\n")
    assert "nan" not in done.stdout


def test_another_unit_is_named(tmp_path: Path) -> None:
    """Millinewtons for newtons, 3 % off: a sentence for each quantity names the factor 1000 and the unit.

    So it does for answers that scatter by 40 %, and for the other sign; other wrong answers get none.
    """
    table = tmp_path / "answers.csv"
    table.write_text(filled("pair_at_rest", 1030.0))
    done = run_score("pair_at_rest", table)
    assert done.returncode == 1 and done.stdout.count("are about 1000 times the true ones; expected values in ") == 2
    assert "force: the answers are about 1000 times the true ones; expected values in N," in done.stdout
    head, *rows = filled("pair_at_rest", 1000.0).splitlines()
    for k, row in enumerate(rows):
        *names, value = row.split(",")
        rows[k] = ",".join([*names, str((0.6, 1.0, 1.4, 1.0, 1.0)[k % 5] * float(value))])
    table.write_text("\n".join([head, *rows]))
    assert run_score("pair_at_rest", table).stdout.count("are about 1000 times the true ones") == 2
    table.write_text(filled("pair_at_rest", -1.1))
    assert "force: the answers have the other sign; expected values in N," in run_score("pair_at_rest", table).stdout
    table.write_text(filled("pair_at_rest", 2.5))
    assert "the answers" not in run_score("pair_at_rest", table).stdout


def test_a_file_of_no_problem_is_named(tmp_path: Path) -> None:
    """`all FOLDER` reads files by the names of the problems: a misspelt one is reported."""
    (tmp_path / "pair_at_rest.csv").write_text(filled("pair_at_rest"))
    (tmp_path / "viscus_pull.csv").write_text(filled("viscous_pull"))
    done = run_score("all", tmp_path)
    assert "no problem has that name: viscus_pull.csv" in done.stderr and "1 of 10 problems solved" in done.stdout


@pytest.mark.parametrize(
    ("factor", "grade", "code"), [(1.0, "exact", 0), (1.005, "1 %", 0), (1.05, "10 %", 0), (1.5, "worse", 1)]
)
def test_classes(factor: float, grade: str, code: int, tmp_path: Path) -> None:
    """A deviation has the narrowest class that holds it; beyond a tenth the exit code is 1, unless --within is wider."""
    table = tmp_path / "answers.csv"
    table.write_text(filled("pair_at_rest", factor))
    done = run_score("pair_at_rest", table)
    assert done.returncode == code and all(
        line.endswith(grade) for line in done.stdout.partition("\n\n")[0].splitlines()[2:]
    )
    assert run_score("pair_at_rest", table, "--within", "0.6").returncode == 0


def test_all_problems_at_once(tmp_path: Path) -> None:
    """Ten files: ten solved, exit code 0; without one of them nine and 1; a folder without any is refused."""
    assert run_score("all", tmp_path).returncode == 2
    for problem in SCORE["problems"]():
        (tmp_path / f"{problem}.csv").write_text(filled(problem))
    done = run_score("all", tmp_path)
    assert done.returncode == 0 and done.stdout.startswith("10 of 10 problems solved within 10 %")
    (tmp_path / "drum.csv").unlink()
    done = run_score("all", tmp_path)
    assert done.returncode == 1 and "9 of 10" in done.stdout and "drum: no file drum.csv" in done.stdout
    assert run_score("--version").stdout == f"score.py {SCORE['VERSION']}\n"


def test_the_command_is_the_script(tmp_path: Path) -> None:
    """`pywet score` prints what score.py prints."""
    table = tmp_path / "answers.csv"
    table.write_text(filled("wet_rebound"))
    given = ["wet_rebound", str(table), "--json"]
    one, two = (
        subprocess.run([sys.executable, *how, *given], capture_output=True, text=True, check=True).stdout
        for how in (["-m", "pywet.cli.app", "score"], [str(WET / "score.py")])
    )
    assert one == two and json.loads(one)["score"][0]["largest"] < 1e-12


def test_no_measurement_without_a_source() -> None:
    """Every sentence says where it was read, how, and how sure it is; every one is on the page."""
    page = (WET.parents[1] / "docs" / "measured.md").read_text()
    with open(WET / "measured.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    source, usual = runpy.run_path(str(WET / "measured.py"))["source"], ("abstract", "not given")
    assert len({row["key"] for row in rows}) == len(rows) > 10
    assert (
        "Unless the table states otherwise, the source is the abstract of a paper, which gives no uncertainty."
        in " ".join(page.split())
    )
    for row in rows:
        assert all(row.values()) and f"| {row['measured']} | {source(row)} |" in page
        assert all(row[k] in source(row) or row[k] in usual for k in ("source", "read", "uncertainty"))
    for problem in SCORE["problems"]():
        for a in of(problem)[1]:
            if a["tier"] == "measured":
                text = (WET / problem / "README.md").read_text()
                assert a["case"] in text and "abstract" in text


def test_the_page_of_measurements_says_what_is_computed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The command on a copy: words stay the same, numbers to what another processor may round; it prints the answers."""
    copy = Path(shutil.copy(WET.parents[1] / "docs" / "measured.md", tmp_path))
    write = runpy.run_path(str(WET / "measured.py"))["page"]
    write.__globals__["PAGE"] = copy
    write()
    printed = capsys.readouterr().out
    check_shown("python benchmarks/wet/measured.py", printed)
    counts = {answer: int(n) for n, answer in re.findall(r"(\d+) ([a-z ]+)", printed)}
    tested = {answer: counts[answer] for answer in ("confirmed", "not confirmed", "inconclusive")}
    assert list(tested.values()) == [8, 5, 1] and sum(counts.values()) == 17
    headline = (
        f"Of {sum(tested.values())} published statements on moist particles that the models can contradict, eight are"
    )
    assert f"{headline} confirmed, five are not and one is inconclusive." in " ".join(copy.read_text().split())
    made, shown = copy.read_text(), (WET.parents[1] / "docs" / "measured.md").read_text()
    number = re.compile(r"[-+]?[0-9]+\.?[0-9]*")
    assert number.sub("#", made) == number.sub("#", shown)
    for one, two in zip(number.findall(made), number.findall(shown), strict=True):
        assert float(one) == pytest.approx(float(two), rel=0.02, abs=1.01 * 10.0 ** -len(two.partition(".")[2]))


def test_scores_on_the_page_are_the_stored_ones() -> None:
    """The page's table follows from scores.csv; every problem is answered by a program."""
    programs = runpy.run_path(str(WET / "programs.py"))
    page = (WET.parents[1] / "docs" / "wet_benchmarks.md").read_text()
    lines = list(programs["tables"](pd.read_csv(WET / "scores.csv")))
    assert "\n".join(lines) in page and len(lines) > 10
    assert all(set(cells) != {"–"} for cells in zip(*(line.split(" | ")[1:] for line in lines[2:]), strict=True))


def test_columns_of_a_score_are_apart_whatever_the_quantity_is_called(capsys: pytest.CaptureFixture[str]) -> None:
    """The longest name of a quantity has 46 characters."""
    lines = SCORE["scored"]("viscous_pull", [])
    SCORE["show"]("viscous_pull", lines, 0.1)
    shown = capsys.readouterr().out.partition("\n\n")[0].splitlines()[1:]
    assert (
        len({line.index(word) for line, word in zip(shown, ("tier", "exact", "exact", "measured"), strict=True)}) == 1
    )


def test_new_answers_take_the_place_of_stored_scores(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Any program's file is scored under the name of its folder."""
    (tmp_path / "results" / "wet" / "another").mkdir(parents=True)
    (tmp_path / "results" / "wet" / "another" / "drum.csv").write_text(filled("drum", 1.1))
    monkeypatch.chdir(tmp_path)
    rows = [r for r in runpy.run_path(str(WET / "programs.py"))["scores"]() if r["program"] == "another"]
    assert [(r["problem"], r["case"]) for r in rows] == [("drum", "moist"), ("drum", "dry")]
    assert all(r["largest"] == pytest.approx(0.1) for r in rows)


def test_speed_is_read_where_the_film_is_left() -> None:
    """Two spheres whose relative speed is a straight line over ln h: exact between any two outputs; 0 where none leaves."""
    left = runpy.run_path(str(WET / "programs.py"))["left"]
    h = np.array([1.001e-4, 1e-5, 3e-5, 2.5e-4])
    speed = np.array([-0.01, 0.008, 0.006, 0.0])
    speed[1:] = 0.008 - 0.001 * np.log(h[1:] / 1e-5)
    way = pd.DataFrame(
        {"step": [s for s in range(4) for _ in "ab"], "id": [1, 2] * 4, "z": np.ravel([[0.5, 0.5 + 1e-3 + x] for x in h]),
         "vz": np.ravel([[0.1, 0.1 + v] for v in speed])}
    )  # fmt: skip
    assert left(way, 1e-3, 1e-4) == pytest.approx((0.008 - 0.001 * math.log(10.0)) / 0.01, rel=1e-6)
    assert left(way[way["step"] < 3], 1e-3, 1e-4) == 0.0


def test_the_drums_of_the_second_engine_are_those_of_the_table() -> None:
    """docs/second_engine.md against seeds.csv; dry, two engines are within two standard errors."""
    text = (WET.parents[1] / "docs" / "second_engine.md").read_text()
    stored = pd.read_csv(WET / "seeds.csv").query("problem == 'drum'").set_index(["program", "case"])
    ours, yade = MAKE["SEEDED"], "YADE, Rabinovich"
    shown = {"LIGGGHTS, dry": (ours, "dry"), "YADE, dry": (yade, "dry"), "LIGGGHTS+pywet": (ours, "moist"),
             "YADE": (yade, "moist"), "washino": ("LIGGGHTS, washino", "moist"), "easo": ("LIGGGHTS, easo", "moist")}  # fmt: skip
    for name, key in shown.items():
        assert f"| {name} | {stored.loc[key, 'mean']:.1f} ± {stored.loc[key, 'deviation']:.1f} |" in text
    one, two = (stored.loc[(program, "dry")] for program in (ours, yade))
    error = math.hypot(one["deviation"], two["deviation"]) / math.sqrt(3.0)
    assert abs(one["mean"] - two["mean"]) < 2.0 * error


@pytest.mark.parametrize("problem", sorted(path.parent.name for path in WET.glob("*/answers.json")))
def test_a_template_is_read_back_as_what_is_asked(problem: str) -> None:
    """Also a name of a case that contains a comma."""
    rows = list(csv.DictReader(SCORE["template"](problem).splitlines()))
    asked = [(a["case"], a["quantity"], a["at"]) for a in SCORE["load"](problem)["answers"]]
    assert [(row["case"], row["quantity"], float(row["at"])) for row in rows] == asked
