"""The commands of README and docs: each `console` line that starts with `$ ` exists and parses; the cheap ones are run."""

from __future__ import annotations

import importlib.util
import os
import re
import shlex
import shutil
import subprocess
import sys
from itertools import combinations
from pathlib import Path

import pytest
import typer.main
from typer.core import TyperGroup
from typer.testing import CliRunner

from pywet.cli.app import app
from pywet.engines.lammps.build import libraries
from studies.command import app as studies
from tests.error_codes import raises_code
from tests.shown_output import CUT, is_output, lines_of

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
CONSOLE = re.compile(r"^[ ]*```console\n(.*?)^[ ]*```", re.DOTALL | re.MULTILINE)
GENERATED = ("configuration_reference.md", "columns.md", "scene_reference.md")
"""Pages that the build of the site writes."""
LINK = re.compile(r"\]\((?!https?:|mailto:)([^)#\s]+)(?:#[^)]*)?\)")
CHEAP = {"doctor", "laws", "plan", "bridge"}
"""Subcommands that answer in seconds and need no result (the studies and the collisions have tests of their own)."""

ROUND_OFF = 1e-6
"""Share by which a computed number may differ from the one on a page: another processor sums in another order."""
CHECKOUT = (
    "Snakefile",
    "benchmarks",
    "config",
    "docs",
    "examples",
    "liggghts_inputs",
    "pywet",
    "reference_impl",
    "studies",
    "workflow",
)
"""What the commands of the pages read of a checkout."""


def commands_in(text: str) -> list[str]:
    """Commands of a page: `$ ` lines of its console blocks, those that end in a backslash joined with the next."""
    found = []
    for block in CONSOLE.findall(text):
        lines = [line.strip() for line in block.replace("\\\n", " ").splitlines()]
        found += [" ".join(line[2:].partition("  #")[0].split()) for line in lines if line.startswith("$ ")]
    return found


COMMANDS = sorted({command for page in PAGES for command in commands_in(page.read_text())})


def words(command: str) -> tuple[str, list[str]]:
    """Name of the program without its folder, and its arguments; `sudo` and variables in front are dropped."""
    parts = shlex.split(command)
    # the first command of a pipe
    parts = parts[: next((k for k, part in enumerate(parts) if part in ("|", ">", "<")), len(parts))]
    while parts[0] == "sudo" or re.fullmatch(r"[A-Z_]+=.*", parts[0]):
        parts = parts[1:]
    return (parts[0] if parts[0].startswith("tools/") else Path(parts[0]).name), parts[1:]


def program(name: str) -> str:
    """Path of a program: next to the Python that runs the tests, else on the PATH."""
    beside = Path(sys.executable).parent / name
    return str(beside) if beside.exists() else shutil.which(name) or name


def call(*command: str, folder: Path = ROOT, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a command in the repository or in another folder."""
    merged = {**os.environ, "COLUMNS": "200", "NO_COLOR": "1", **environment}
    return subprocess.run(command, cwd=folder, env=merged, capture_output=True, text=True, check=False)


def link_checkout(folder: Path) -> None:
    """Give a folder the files of the checkout, without any result."""
    for name in CHECKOUT:
        (folder / name).symlink_to(ROOT / name)


def parse_pywet(arguments: list[str]) -> list[str]:
    """Parse the arguments of `pywet` without running anything; names of the subcommands. An error of usage is raised."""
    if arguments[0] == "study":
        command, arguments, path = typer.main.get_command(studies), arguments[1:], ["study"]
    else:
        command, path = typer.main.get_command(app), []
    context = command.make_context("pywet", list(arguments))
    while isinstance(command, TyperGroup):
        name, command, rest = command.resolve_command(context, [*context._protected_args, *context.args])
        context = command.make_context(name, rest, parent=context)
        path.append(name)
    return path


def test_pages_show_the_two_commands_and_more() -> None:
    assert {"make run", "make test"} <= set(commands_in((ROOT / "README.md").read_text()))
    assert len(COMMANDS) >= 8  # with a pattern that finds nothing all tests below would pass


@pytest.mark.parametrize("wrong", [["plann", "2"], ["plan", "two"], ["plan", "2", "--scal", "smoke"], ["replay"]])
def test_a_wrong_command_would_be_noticed(wrong: list[str]) -> None:
    with pytest.raises(Exception, match=r"(?i)no such|whole number|missing"):
        parse_pywet(wrong)


def test_a_console_block_is_read_as_a_person_reads_it() -> None:
    block = "1. One:\n\n   ```console\n   $ make \\\n       run\n   output\n   $ pywet plan 2  # why\n   ```\n"
    assert commands_in(block + "```sh\n$ not this\n```\n") == ["make run", "pywet plan 2"]


@pytest.mark.parametrize("command", COMMANDS)
def test_command_of_the_documentation_exists_and_parses(command: str, tmp_path: Path) -> None:
    name, arguments = words(command)
    if name == "make":
        done = call("make", "-n", *arguments)
        assert done.returncode == 0, done.stderr
    elif name == "pywet":
        shown = CliRunner().invoke(app, [*parse_pywet(arguments), "--help"])
        assert shown.exit_code == 0, shown.output
    elif name == "snakemake":
        link_checkout(tmp_path)
        done = call(
            *(sys.executable, "-m", "snakemake", "-n", *arguments),
            folder=tmp_path,
            XDG_CACHE_HOME=str(tmp_path / "cache"),
        )
        assert done.returncode == 0, done.stderr
        check_shown(command, done.stdout)  # the jobs that it is going to run, which it prints with -n and without
    elif name in ("python", "python3") and arguments[0] == "-m":
        assert importlib.util.find_spec(arguments[1]) is not None
    elif name.startswith("tools/"):
        assert os.access(ROOT / name, os.X_OK)
        assert call("bash", "-n", name).returncode == 0
    else:
        assert name == "cd" or shutil.which(program(name)), f"`{command}`: no program {name}"


def plain(command: str) -> str:
    """A command without the folder of its program."""
    return command.removeprefix(".venv/bin/")


def with_output() -> list[tuple[str, list[str]]]:
    """Every command of every page's console blocks, and the lines below it."""
    found = []
    for page in PAGES:
        for block in CONSOLE.findall(page.read_text()):
            for given in re.split(r"^\s*\$ ", block.replace("\\\n", " "), flags=re.MULTILINE)[1:]:
                first, *lines = lines_of(given)
                found.append((plain(first.partition(" #")[0]), lines))
    return found


def shown_below(command: str) -> list[list[str]]:
    """Lines that pages show below a command in its console blocks."""
    return [lines for given, lines in with_output() if given == plain(command) and lines]


def check_shown(command: str, output: str, tolerance: float = ROUND_OFF) -> None:
    """Fail where lines that a page shows below a command are not an abridged form of its output."""
    for lines in shown_below(command):
        assert is_output(lines, lines_of(output), tolerance), "\n".join([f"$ {command}", *lines, "-- printed:", output])


def is_cheap(arguments: list[str]) -> bool:
    # the file is written by the page: laws/test_own_page.py
    return arguments[0] in CHEAP and "config/my_bridge.json" not in arguments


@pytest.mark.engine
@pytest.mark.parametrize("command", [c for c in COMMANDS if words(c)[0] == "pywet" and is_cheap(words(c)[1])])
def test_cheap_command_of_the_documentation_runs(command: str) -> None:
    if "lammps" in words(command)[1] and not libraries()[1].exists():
        pytest.skip("LAMMPS is not installed: make peers")
    done = call(program("pywet"), *words(command)[1])
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.strip()
    check_shown(command, done.stdout)


def test_pages_show_the_same_output_of_a_command() -> None:
    """Pages share a line wherever they have lines that begin with the same words, so that their numbers are those of one run."""
    pages: dict[str, list[dict[str, set[str]]]] = {}
    for command, lines in with_output():
        by_words: dict[str, set[str]] = {}
        for line in lines:
            by_words.setdefault(re.split(r"[\d:]", line)[0].strip(), set()).add(line)
        pages.setdefault(command, []).append(by_words)
    compared = 0
    for command, blocks in pages.items():
        for one, two in combinations(blocks, 2):
            for words_of in (one.keys() & two.keys()) - {"", CUT}:
                compared += 1
                assert one[words_of] & two[words_of], (command, one[words_of], two[words_of])
    assert compared > 10


IN_A_FOLDER = (
    ("pywet init mydeck --example deck",),
    ("pywet init law",),
    ("pywet init study",),
    (
        "pywet init mysweep --example sweep",
        "pywet sweep mysweep/small_drum.yaml --check",
    ),
    ("pywet docs tutorial",),
    ("pywet score viscous_pull --template",),
    ("pywet collide wall examples/wall_wet.json",),
    ("pywet collide wall examples/wall_sweep.json --table",),
    ("pywet collide wall examples/wall_oblique_dry.json --csv results/oblique.csv",),
    ("pywet collide spheres examples/three_equal_spheres.json",),
    ("pywet collide spheres examples/four_spheres.json",),
    (
        "pywet kinetics docs/full_scale/data/case02-10007 docs/full_scale/data/case02-10009 "
        "docs/full_scale/data/case02-10012",
    ),
)
"""Commands of the pages that are run one after another in a folder with the checkout's files."""


@pytest.mark.parametrize("commands", IN_A_FOLDER, ids=lambda commands: commands[-1])
def test_commands_of_the_documentation_run_in_a_folder(commands: tuple[str, ...], tmp_path: Path) -> None:
    """They end without an error and print what the pages show below them."""
    link_checkout(tmp_path)
    (tmp_path / "results").mkdir()
    for command in commands:
        assert command in COMMANDS
        name, arguments = words(command)
        done = call(program(name), *arguments, folder=tmp_path)
        assert done.returncode == 0, done.stdout + done.stderr
        assert done.stdout.strip() or (tmp_path / "results" / "oblique.csv").exists()
        check_shown(command, done.stdout)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_of_the_documentation_lead_to_files(page: Path) -> None:
    missing = [link for link in LINK.findall(page.read_text()) if not (page.parent / link).exists()]
    assert [link for link in missing if link.partition("#")[0] not in GENERATED] == []


def test_index_names_every_page() -> None:
    named = set(LINK.findall((ROOT / "docs" / "README.md").read_text()))
    pages = {str(page.relative_to(ROOT / "docs")) for page in PAGES[1:]} - {
        "README.md",
        "index.md",
        *GENERATED,
    }
    assert pages - named == set()


def test_the_documentation_has_at_most_35000_words() -> None:
    """Count words with a letter or a digit on the written pages; those that the site's build makes are left out."""
    written = [page for page in PAGES[1:] if page.name not in GENERATED]
    pages = {page.name: [w for w in page.read_text().split() if re.search(r"\w", w)] for page in written}
    assert sum(map(len, pages.values())) <= 35_000, {name: len(found) for name, found in pages.items()}


def test_no_page_has_the_name_of_a_page_that_sphinx_writes() -> None:
    """Sphinx's own search and indices would replace it without a warning."""
    assert {page.stem for page in PAGES} & {"search", "genindex", "py-modindex"} == set()


def test_the_readme_says_of_moisture_what_the_pages_say() -> None:
    """Its numbers are those of the pages, which are made of the stored runs."""
    readme, full, screens = (
        " ".join((ROOT / name).read_text().split()) for name in ("README.md", "docs/full_scale.md", "docs/screens.md")
    )
    screens_lines = (ROOT / "docs" / "screens.md").read_text().splitlines()
    assert "after 1.54 s instead of 1.18 s" in readme and "after 1.18 s dry and 1.54 s moist" in full
    assert "26 % of the liquid stays" in readme
    assert "64 % (POM) and 65 % (glass) are in the bin, on fines and walls, 26 % and 32 % on coarse spheres" in full
    assert "72 % of the undersize passes with 8 % of water, the most simulated (dry 31 %; half of the gain" in readme
    assert "1 % of the feed stays on the deck. With 1 mm 90 % of the undersize passes with 1 % of water" in readme
    assert "but 16 % of the feed stays, and with 8 % of water 52 %" in readme
    cells = {row[0]: row[1:] for row in (line.strip("| ").split(" | ") for line in screens_lines) if len(row) == 5}
    assert (cells["0 %"][2], cells["8 %"][2]) == ("31 ± 3", "72 ± 3 (1)") and "**Half of this gain is due to" in screens
    assert (cells["1 %"][0], cells["8 %"][0]) == ("90 ± 2 (16)", "59 ± 3 (52)")


def test_no_page_claims_that_all_of_a_run_is_checked() -> None:
    """A run of the tutorial is checked in part; a sentence that the reference checks every run says so."""
    assert "checked: in part" in (ROOT / "docs" / "tutorial.md").read_text()
    for page in PAGES:
        text = " ".join(page.read_text().split())
        assert not re.search(
            r"(checks|recomputes|replays) (every run(?! in part)|everything|every liquid bridge)", text
        ), page


def test_make_help_lists_every_target() -> None:
    makefile = (ROOT / "Makefile").read_text()
    targets = set(re.findall(r"^([a-z]+):", makefile, flags=re.MULTILINE))
    assert {"setup", "lint", "test", "run", "bench", "report", "clean", "help"} <= targets
    shown = call("make", "-s", "--no-print-directory", "help").stdout
    assert {line.split()[0] for line in shown.splitlines()} == targets
    check_shown("make help", shown)


def test_every_key_of_a_scene_has_its_meaning_unit_default_and_range() -> None:
    """The page is made from the classes that check a scene; a key without a description fails here."""
    import pywet
    from pywet.cli import reference_pages
    from pywet.util.ranges import LIMITS

    rows = [line.split(" | ") for line in reference_pages.scene().splitlines() if line.startswith("| `")]
    reported = {row[0].strip("| `"): row[1:] for row in rows}
    for key in ("seed", "interval_s", "half_width_mm", "thickness_mm", "sides", "stiffness_N_per_m", "at_mm"):
        assert key in reported
    for key, (what, unit, default, limits) in reported.items():
        assert ": " in what and default, key  # kind and meaning; a default, or "needed"
        assert key not in LIMITS or str(LIMITS[key]) in limits, key
        assert unit or not re.search(r"_(mm|um|s|deg|Hz|m|g|kg_per_m3|N_per_m)$", key), key
    assert reported["gravity_m_per_s2"][1] == "m/s2" and reported["stiffness_N_per_m"][2] == "`2000.0`"
    models = [c for c in (getattr(pywet, name) for name in pywet.__all__) if hasattr(c, "model_fields")]
    assert {k for c in models for k in c.model_fields} <= set(reported)


def test_pages_are_printed_by_their_names() -> None:
    """The list names every page; a page, a link with a section and the notebook's text are found, another name is refused with
    all names; the help of the program names the command, a scene's misspelt key the page of all keys."""
    from pywet.cases.custom.description import Scene
    from pywet.cli import reference_pages

    runner = CliRunner()
    listed = runner.invoke(app, ["docs"]).output
    links = re.findall(r"\]\(([\w-]+)\.(?:md|ipynb)\)", listed)
    assert len(links) > 30
    for name in (*links, *reference_pages.MADE):
        assert len(reference_pages.page(name)) > 200, name
    assert reference_pages.page("docs/compare.md#regression-digests") == (ROOT / "docs" / "compare.md").read_text()
    assert "run.drum_angle()" in reference_pages.page("first-steps.ipynb")
    with raises_code("cli.no_page", given="mill"):
        reference_pages.page("mill")
    assert "pywet docs" in runner.invoke(app, ["--help"]).output
    with raises_code("config.unknown_key", key="mass", says=r"\(all keys: pywet docs scene_reference\)$"):
        Scene(mass=1)  # type: ignore[call-arg]
