"""The commands of the pages that need runs: each is executed, in the pages' order, on runs as small as the machine can make them.

`test_docs.py` executes those that need no run, and `snakemake` dry. The tables here name all others: GROUPS are executed, with
further options (SMALLER) where they would take long, ELSEWHERE and IN_PARTS name tests, PARSED are not executed. A page shows
what each prints, with the exceptions of PARSED and SILENT.
"""

from __future__ import annotations

import math
import os
import re
import shlex
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from unittest import mock

import pytest
import yaml
from typer.testing import CliRunner

from pywet.cli.app import app
from pywet.cost import edit
from pywet.report.app import Server
from tests.test_config import add_the_material_of_the_page
from tests.test_docs import COMMANDS, IN_A_FOLDER, ROOT, check_shown, is_cheap, plain, program, with_output, words
from tests.test_docs_examples import blocks

TINY = {
    "scales.yaml: scales smoke width_mm value": 41,
    "scales.yaml: scales smoke duration_s value": 0.06,
    "scales.yaml: scales smoke slide_opens_at_s value": 0.02,
    "scales.yaml: scales smoke output_interval_s value": 0.02,
    "materials.yaml: feed class_mass_g value": 60,
    "config.yaml: output contact_windows": 3,
    "config.yaml: output checkpoints": 2,
}
"""What the configuration of these tests has in place of the shipped one: some 50 spheres, three outputs."""
LINKED = ("docs", "benchmarks", "reference_impl", "pywet", "studies", "workflow", "liggghts_inputs")
CASE = "19,POM,5,7,10,8,1,7,mine"
"""Row of cases.csv that a page tells the reader to add."""


def shorten(path: Path, seconds: float, count: int, **more: object) -> None:
    """Give a scene file a short time and few spheres, in its place."""
    scene = yaml.safe_load(path.read_text())
    scene["duration_s"] = seconds
    for entry in scene.get("spheres", []):
        if "count" in entry:
            entry["count"] = min(entry["count"], count)
        if "mass_g" in entry:
            entry["mass_g"] *= 0.1
    for key, value in more.items():
        scene[key] = value
    path.write_text(yaml.safe_dump(scene, sort_keys=False))


def copies(folder: Path) -> None:
    """Give the finished run of case 2 the names of further runs."""
    for name in ("case01", "case05"):
        shutil.copytree(folder / "results/smoke/case02", folder / "results/smoke" / name)


def one_more_case(folder: Path) -> None:
    with open(folder / "config/cases.csv", "a") as file:
        file.write(f"{CASE}\n")


def a_material(folder: Path) -> None:
    add_the_material_of_the_page(folder / "config")


def name_in_config(folder: Path, yaml_block: int, file: str, python_block: int) -> None:
    """Write a Python block of the page on custom laws to a file, and put its YAML block in place of the configured laws."""
    page: dict[str, list[str]] = {}
    for language, text in blocks("howto-own-law.md"):
        page.setdefault(language, []).append(text)
    (folder / "config" / file).write_text(page["python"][python_block])
    path = folder / "config/config.yaml"
    path.write_text(
        re.sub(r"^laws:\n(  .*\n)+", page["yaml"][yaml_block], path.read_text(), count=1, flags=re.MULTILINE)
    )


def custom_law(folder: Path) -> None:
    name_in_config(folder, 0, "my_law.py", 0)


def custom_reference(folder: Path) -> None:
    name_in_config(folder, 1, "my_reference.py", 2)


def small_scenes(folder: Path) -> None:
    for path in (folder / "examples/scenes").glob("*.yaml"):
        if path.stem == "deck":
            short_deck(path)
        else:
            shorten(path, 0.02, 20)


def small_deck(folder: Path) -> None:
    short_deck(folder / "mydeck/deck.yaml")


def short_deck(path: Path) -> None:
    """Insert spheres for 0.1 s, twenty times as many per second, on a short deck."""
    scene = yaml.safe_load(path.read_text())
    (feed,) = scene["feed"]
    feed["insertion"] = {"for_s": 0.1}
    scene["duration_s"] = 0.4
    scene["deck"]["length_mm"] = 60
    path.write_text(yaml.safe_dump(scene, sort_keys=False))


def insert_throughout(folder: Path) -> None:
    """The small deck, longer and fed up to its end, in blocks that are long enough for its checkpoints."""
    path = folder / "mydeck/deck.yaml"
    scene = yaml.safe_load(path.read_text())
    scene["feed"][0]["insertion"]["for_s"] = scene["duration_s"] = 1.2
    scene["until"] = {"partition_percent": 5, "block_s": 0.12}
    path.write_text(yaml.safe_dump(scene, sort_keys=False))


def small_sweep(folder: Path) -> None:
    """Give the sweep two surface tensions, two viscosities and one seed."""
    shorten(folder / "mysweep/small_drum_scene.yaml", 0.02, 20)
    path = folder / "mysweep/small_drum.yaml"
    sweep = yaml.safe_load(path.read_text())
    sweep["axes"]["liquid.surface_tension_N_per_m"] = [0.02, 0.07]
    sweep["axes"]["liquid.viscosity_Pa_s"]["logspace"][2] = 2
    path.write_text(yaml.safe_dump({**sweep, "seeds": 1}, sort_keys=False))


def small_drum(folder: Path) -> None:
    shorten(folder / "examples/calibrations/small_drum.yaml", 0.05, 20)
    path = folder / "examples/calibrations/drum.yaml"
    path.write_text(path.read_text() + "seeds: 2\nmost_runs: 10\ncheck_runs: 2\n")


def script(folder: Path) -> None:
    """The drum of the page: the example's script, shorter, with the line that the page adds."""
    example = folder / "examples/liggghts"
    line = re.findall(r"^fix +wet all pywet .*$", (ROOT / "docs/your-script.md").read_text(), re.MULTILINE)[0]
    text = re.sub(r"^(run\s+)\d{3,}", r"\g<1>300", (example / "in.drum").read_text(), flags=re.MULTILINE)
    (folder / "in.script").write_text(
        text.replace("\nthermo  ", f"\n{line}\nthermo  ".replace("every 1000", "every 100"))
    )
    for path in example.iterdir():
        if path.is_dir():
            shutil.copytree(path, folder / path.name)
        elif path.name != "in.drum":
            shutil.copy(path, folder / path.name)
    shutil.copy(example / "wet.drum.yaml", folder / "wet.yaml")


def other_engine(folder: Path) -> None:
    for engine in ("liggghts", "yade"):
        done = invoke(f"pywet run 1 --engine {engine} --out results/crosscheck/dry/{engine}", folder)
        assert done[0] == 0, done


def other_liquid(folder: Path) -> None:
    """Give case 2 more liquid and run it again, as the tutorial tells the reader to."""
    path = folder / "config/cases.csv"
    path.write_text(path.read_text().replace("\n2,POM,5,7,10,8,1,5,", "\n2,POM,5,7,10,8,1,10,"))
    done = invoke("pywet run 2", folder)
    assert done[0] == 0, done


def prepare(folder: Path, settings: dict[str, object]) -> None:
    """Make a folder like a checkout, with settings in place of the shipped ones; what commands change are copies."""
    for name in LINKED:
        (folder / name).symlink_to(ROOT / name)
    edit.write(ROOT / "config", folder / "config", "smoke", {})
    edit.put_into(folder / "config", settings)
    shutil.copytree(ROOT / "examples", folder / "examples")
    shutil.copytree(ROOT / "tests/data/digests", folder / "tests/data/digests")


Step = str | Callable[[Path], None]
GROUPS: dict[str, tuple[Step, ...]] = {
    "one run": (
        "pywet run 2",
        copies,
        "pywet replay results/smoke/case02",
        "pywet replay --json results/smoke/case02",
        "pywet replay results/smoke/case02 results/smoke/case05",
        "pywet report results/smoke/case02",
        "pywet view results/smoke/case02 --paraview",
        "pywet view results/smoke/case02 --vtkhdf",
        "pywet view results/smoke/case02 --ovito",
        "pywet app results/smoke/case01 results/smoke/case02",
        "pywet app results/smoke/case02",
        other_liquid,
        "pywet compare results/smoke/case02.1 results/smoke/case02 --across liquid",
    ),
    "a bed": (
        "pywet scene bed --spheres 40 --seconds 0.12 --seed 4 --out results/scenes/bed4",
        "pywet compare results/scenes/bed4 --digest tests/data/digests/bed.json",
        "pywet replay results/scenes/bed4",
        "pywet digest results/scenes/bed4 --out my_bed.json",
        "pywet compare results/scenes/bed4 --digest my_bed.json",
        "pywet scene drum --moisture 1 --spheres 400 --seconds 1.5",
    ),
    "a script": (
        script,
        "pywet liggghts -in in.script --check",
        "pywet liggghts -in in.script",
        "pywet replay wet",
    ),
    "a sweep": (
        "pywet init mysweep --example sweep",
        small_sweep,
        "pywet sweep mysweep/small_drum.yaml --cores 2",
        "pywet sweep plot mysweep/small_drum.yaml liquid.surface_tension_N_per_m ruptures liquid.viscosity_Pa_s",
    ),
    "calibrations": (
        "pywet calibrate examples/calibrations/binder.yaml",
        small_drum,
        "pywet calibrate examples/calibrations/drum.yaml --out results/calibrations/drum",
    ),
    "a deck": (
        "pywet init mydeck --example deck",
        small_deck,
        "pywet run-scene mydeck/deck.yaml --out mydeck/run",
        "pywet screen mydeck/run",
        insert_throughout,
        "pywet run-scene mydeck/deck.yaml --until 2",
    ),
    "the tutorial": ("pywet run 2",),
    "pictures": (
        "pywet run 2",
        "pywet view results/smoke/case02",
        "pywet view results/smoke/case02 --close-up 17",
        "pywet view results/smoke/case02 --movie",
        script,
        "pywet liggghts -in in.script",
        "pywet view wet",
    ),
    "seeds": (
        "pywet run 2 --seeds 3",
        one_more_case,
        "pywet run 2 --seeds 3 --out results/seeds/5/1",
        "pywet run 19 --seeds 3 --out results/seeds/7/1",
        "pywet compare results/seeds/5 results/seeds/7 --across liquid --plot moisture.pdf",
    ),
    "a material": (a_material, "pywet run 50"),
    "a law": (
        custom_law,
        "pywet run 2 --out results/my_law",
        custom_reference,
        "pywet run 2 --out results/my_reference",
    ),
    "presets": (
        "pywet run 2 --seeds 5 --out results/seeds/paper/1",
        "pywet run 2 --seeds 5 --preset exact --out results/seeds/exact/1",
        "pywet compare results/seeds/paper results/seeds/exact --json difference.json",
        "pywet compare --a results/seeds/paper/1 --a results/seeds/paper/1-10008 --b results/seeds/exact",
        lambda folder: (folder / "results/smoke").mkdir(),
        lambda folder: (folder / "results/seeds/paper/1").rename(folder / "results/smoke/case02"),
        lambda folder: (folder / "results/seeds/exact/1").rename(folder / "results/smoke/case02_exact"),
        "pywet compare results/smoke/case02 results/smoke/case02_exact",
    ),
    "scenes": (
        small_scenes,
        *(
            f"pywet run-scene examples/scenes/{name}.yaml --out results/scenes/{name}"
            for name in ("hopper", "drum", "repose", "migration", "deck")
        ),
    ),
    "engines": (
        other_engine,
        "pywet compare --a results/crosscheck/dry/liggghts --b results/crosscheck/dry/yade",
        "pywet run 1 --engine yade",
        "pywet study cross-code --out results/agreement",
        "pywet study cross-code --only screening --only engines",
    ),
    "effects": ("pywet study effects",),
    "digests": ("pywet study digests bed",),
    "readings": (
        "python -m studies.full_scale.readings run results/readings 2 3",
        "python -m studies.full_scale.readings run results/readings_long 2 --long",
    ),
}
"""Name -> what is done one after another in a new folder: commands of the pages, and preparations by name."""
SHIPPED = {"the tutorial", "a material"}
"""Groups that `make test` runs with the shipped configuration; all others are marked slow."""
SCATTER = 0.1
"""Share by which a number of a run may differ from the one on a page: a bed is chaotic, and processors round differently."""
SMALLER = {
    "pywet study cross-code --out results/agreement": "--only dry",
    "pywet run 2 --seeds 5 --out results/seeds/paper/1": "--seeds 2",
    "pywet run 2 --seeds 5 --preset exact --out results/seeds/exact/1": "--seeds 2",
    "pywet scene drum --moisture 1 --spheres 400 --seconds 1.5": "--spheres 60 --seconds 0.02",
    "pywet study effects": "--seeds 2 --size 0.1 --scene fast_dilute",
    "python -m studies.full_scale.readings run results/readings 2 3": "--only amplitude=",
    "python -m studies.full_scale.readings run results/readings_long 2 --long": "--only amplitude=",
}
"""Command -> options that follow it here, so that there is less to compute."""
MAKE_SMALLER = (small_scenes, small_deck, insert_throughout, small_sweep, small_drum)
ONLY_AS_SHIPPED = {
    "pywet run 2",
    "pywet run 2 --out results/my_law",
    "pywet run 2 --out results/my_reference",
    "pywet screen mydeck/run",
    "pywet compare results/seeds/5 results/seeds/7 --across liquid --plot moisture.pdf",
    *(plain(c) for c in COMMANDS if words(c)[1][:1] == ["run-scene"]),
}
"""Commands that print other lines for tiny runs: their liquid is in other reservoirs, and they have no partition curve."""
AS_SHIPPED = (
    "one run",
    "a bed",
    "a script",
    "a sweep",
    "calibrations",
    "a deck",
    "seeds",
    "presets",
    "scenes",
    "a law",
)
DIFFERENT = {
    "pywet compare results/smoke/case02.1 results/smoke/case02 --across liquid",
    "pywet compare results/seeds/paper results/seeds/exact --json difference.json",
    "pywet compare --a results/seeds/paper/1 --a results/seeds/paper/1-10008 --b results/seeds/exact",
    "pywet compare results/smoke/case02 results/smoke/case02_exact",
    "pywet compare results/seeds/5 results/seeds/7 --across liquid --plot moisture.pdf",
    "pywet calibrate examples/calibrations/drum.yaml --out results/calibrations/drum",
    "pywet compare --a results/crosscheck/dry/liggghts --b results/crosscheck/dry/yade",
}
"""Commands that may answer with exit code 1: groups or runs that differ, targets that a drum of 20 spheres cannot reach."""
DRY = ("snakemake",)
"""Programs that are executed with -n, in `test_command_of_the_documentation_exists_and_parses`."""
ELSEWHERE = {
    "make help": "tests/test_docs.py::test_make_help_lists_every_target",
    "make lint": "tests/test_docs_make.py::test_lint",
    "cd law": "tests/laws/test_own_page.py::test_the_bridge_of_the_page",
    "pywet bridge config/my_bridge.json --trust --table --plot neck.svg": (
        "tests/laws/test_own_page.py::test_the_table_prints_what_a_law_is_off_the_exact_bridge"
    ),
    "pywet score viscous_pull --template | python my_code.py > my_answers.csv": (
        "tests/test_docs_examples.py::test_the_code_that_is_checked_on_the_page_solves_the_problem"
    ),
    "pywet score viscous_pull my_answers.csv": (
        "tests/test_docs_examples.py::test_the_code_that_is_checked_on_the_page_solves_the_problem"
    ),
    "python benchmarks/wet/measured.py": (
        "tests/benchmarks/test_wet.py::test_the_page_of_measurements_says_what_is_computed"
    ),
}
"""Command -> the test that executes it."""
IN_PARTS = {
    "make setup": "tests/test_docs_make.py::test_setup_on_a_fresh_machine",
    "make peers": "tests/test_docs_make.py::test_setup_on_a_fresh_machine",
    "make run": "tests/test_docs_make.py::test_run",
    "make run ENGINE=yade": "tests/test_docs_make.py::test_run",
    "make bench": "tests/test_docs_make.py::test_bench",
    "pywet study laws --no-stock": "tests/studies/law_comparison/test_atlas.py::test_the_command_writes_a_whole_page",
    "pip wheel --no-deps -w dist .": "tests/test_shipped.py::wheel",
    'pip install "dist/pywet-0.2.0-py3-none-any.whl[workflow]"': (
        "tests/test_shipped.py::test_an_installed_wheel_does_what_the_checkout_does"
    ),
    "pywet study accuracy --size quick": (
        "tests/studies/accuracy/test_accuracy.py::test_the_command_prints_where_its_page_is"
    ),
    "pywet study search examples/calibrations/readings.yaml --out results/calibrations/readings": (
        "tests/studies/search/test_statement_search.py::test_the_command_of_the_page_prints_its_answer"
    ),
}
"""Command that takes minutes to hours or installs -> a test that executes it on small inputs, with nothing to install."""
PARSED = {
    "make test": "runs this test",
    "pip install -c constraints.txt snakemake-executor-plugin-slurm": "needs a network",
    "sudo tools/fresh-machine test": "needs root, a network and 4 GB; parsed by bash -n",
}
"""Command -> why it is not executed, and no page shows what it prints."""
SILENT = {"cd law", "pywet score viscous_pull --template | python my_code.py > my_answers.csv"}
"""Commands that print nothing."""


def invoke(command: str, folder: Path, more: str = "") -> tuple[int, str]:
    """Exit code and standard output of a command in a folder; pywet's in this process, which need not import it again.

    A server of `pywet app` is ended as by Ctrl-C.
    """
    name, arguments = words(command)
    arguments += shlex.split(more)
    environment = {"COLUMNS": "200", "NO_COLOR": "1"}
    if name == "pywet":
        before = Path.cwd()
        os.chdir(folder)
        try:
            with mock.patch.object(Server, "serve_forever", side_effect=KeyboardInterrupt):
                done = CliRunner(env=environment).invoke(app, arguments)
        finally:
            os.chdir(before)
        return done.exit_code, done.stdout + (done.stderr if done.exit_code else "")
    merged = {**os.environ, **environment, "PYTHONPATH": str(ROOT)}
    ran = subprocess.run(
        [program(name), *arguments], cwd=folder, env=merged, capture_output=True, text=True, check=False
    )
    return ran.returncode, ran.stdout + (ran.stderr if ran.returncode else "")


def run_group(group: str, folder: Path, shipped: bool) -> None:
    """Execute the steps of a group and compare what they print with the pages; the text alone where the runs are smaller."""
    prepare(folder, {} if shipped else TINY)
    for step in GROUPS[group]:
        if not isinstance(step, str):
            if not (shipped and step in MAKE_SMALLER):
                step(folder)
            continue
        code, output = invoke(step, folder, "" if shipped else SMALLER.get(step, ""))
        assert code in ((0, 1) if step in DIFFERENT else (0,)), f"{step}\n{output}"
        if shipped or step not in ONLY_AS_SHIPPED:
            check_shown(step, output, SCATTER if shipped else math.inf)


@pytest.mark.engine
@pytest.mark.parametrize("group", GROUPS)
def test_commands_of_the_documentation_run_on_small_runs(group: str, tmp_path: Path) -> None:
    """Each ends without an error, and prints the lines that pages show below it."""
    if group == "engines" and not shutil.which("yade"):
        pytest.skip("YADE is not installed: make peers")
    run_group(group, tmp_path, group in SHIPPED)


@pytest.mark.slow
@pytest.mark.engine
@pytest.mark.parametrize("group", AS_SHIPPED)
def test_pages_show_what_the_shipped_files_print(group: str, tmp_path: Path) -> None:
    """The same with the files as a user gets them, numbers included; half an hour in all."""
    run_group(group, tmp_path, True)


def test_every_command_of_the_documentation_is_executed() -> None:
    """The tables name every command, and no other; tests that are named exist."""
    known = {plain(c) for c in COMMANDS}
    small = {step for steps in GROUPS.values() for step in steps if isinstance(step, str)}
    cheap = {plain(c) for c in COMMANDS if words(c)[0] == "pywet" and is_cheap(words(c)[1])}
    folder = {plain(c) for commands in IN_A_FOLDER for c in commands}
    dry = {c for c in known if words(c)[0] in DRY}
    assert small | cheap | folder | dry | set(ELSEWHERE) | set(IN_PARTS) | set(PARSED) == known
    assert set(SMALLER) | DIFFERENT <= small
    for command, test in {**ELSEWHERE, **IN_PARTS}.items():
        file, _, name = test.partition("::")
        body = re.search(rf"\n((?:@.*\n)*)def {name}\((.|\n)*?(?=\n\n\n|\Z)", (ROOT / file).read_text())
        assert body, test
        assert command in SILENT or "check_shown(" in body[0], f"{test} does not compare what {command} prints"


def test_pages_show_what_every_command_prints() -> None:
    """On every page that has the command; the exceptions are listed with their reasons, and are no others."""
    assert {command for command, lines in with_output() if not lines} == set(PARSED) | SILENT
