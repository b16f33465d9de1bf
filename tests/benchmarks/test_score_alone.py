"""score.py as a program of its own, outside of pywet: a bad input ends in one sentence and exit status 2, never a traceback."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

SCORE = Path(__file__).parents[2] / "benchmarks" / "wet" / "score.py"
HEAD = "case,quantity,at,value\n"
GIVEN: dict[str, tuple[list[str], bytes | None, str]] = {
    "a problem that there is not": (
        ["pair_at_night"],
        HEAD.encode(),
        "problem pair_at_night was given; expected one of",
    ),
    "a problem of control characters": (["\x1b[31m\n"], HEAD.encode(), r"problem \x1b[31m\n was given"),
    "no file": (["drum"], None, "expected a CSV file with case, quantity, at, value"),
    "a folder": (["drum", "."], None, ". is no regular file; expected a CSV file"),
    "a pipe": (["drum", "pipe"], None, "pipe is no regular file"),
    "a device": (["drum", "/dev/zero"], None, "/dev/zero is no regular file"),
    "a file of nothing": (["drum"], b"", "has the columns none"),
    "bytes": (["drum"], bytes(range(256)), "cannot be read ("),
    "a column twice": (["drum"], b"case,quantity,at,value,value\n", "each once"),
    "a field of 200,000 digits": (["drum"], f"{HEAD}a,b,1,{'9' * 200_000}\n".encode(), "field larger than field limit"),
    "a word for a number": (["drum"], f"{HEAD}a,b,1,much\n".encode(), "row 2: at '1', value 'much'; expected numbers"),
    "a long word": (["drum"], f"{HEAD}a,b,1,{'x' * 9000}\n".encode(), "xxx…; expected numbers"),
    "no number": (["drum"], f"{HEAD}a,b,1,nan\n".encode(), "row 2: nan at 1.0; expected finite numbers"),
    "1e300": (["drum"], f"{HEAD}a,b,1,1e300\n".encode(), "at most 1e+100"),
    "a case with a zero byte": (
        ["drum"],
        f"{HEAD}a\0,b,1,1\n".encode(),
        r"case a\x00, quantity b is not asked for by drum",
    ),
    "a tolerance that is no number": (["drum", "--within=nan"], HEAD.encode(), "--within is nan; expected a share"),
    "all of a file": (["all"], HEAD.encode(), "holds no answers; expected files such as"),
}


def called(*words: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(SCORE), *words]
    return subprocess.run(
        command, capture_output=True, text=True, check=False, cwd=folder, timeout=60, env={**os.environ, **environment}
    )


@pytest.mark.parametrize("name", GIVEN)
def test_a_bad_input_is_one_sentence(name: str, tmp_path: Path) -> None:
    words, content, says = GIVEN[name]
    os.mkfifo(tmp_path / "pipe")
    if content is not None:
        (tmp_path / "given.csv").write_bytes(content)
    file = [] if len(words) > 1 and not words[1].startswith("--") else ["given.csv"]
    done = called(words[0], *file, *words[1:], folder=tmp_path)
    assert done.returncode == 2 and not done.stdout
    assert len(done.stderr.splitlines()) == 1 and len(done.stderr) < 1500 and says in done.stderr


def test_a_terminal_without_utf_8_and_a_reader_that_has_gone(tmp_path: Path) -> None:
    """The table has a dash for what is not answered; `score.py … | head -0` ends quietly."""
    (tmp_path / "given.csv").write_text(HEAD)
    done = called("drum", "given.csv", folder=tmp_path, PYTHONIOENCODING="ascii")
    assert (done.returncode, done.stderr) == (1, "") and "\\u2013" in done.stdout
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write) as gone:
        command = [sys.executable, "-u", str(SCORE), "drum", "given.csv"]
        ended = subprocess.run(command, stdout=gone, stderr=subprocess.PIPE, text=True, check=False, cwd=tmp_path)
    assert (ended.returncode, ended.stderr) == (2, "")


def test_a_new_user_finds_the_problem_and_reads_the_table(tmp_path: Path) -> None:
    """A name that there is not is refused by name even without a file; the template says where the problem is in words, next to
    the table and not in it; every column of the score begins where its heading does."""
    wrong = called("pair_at_night", folder=tmp_path)
    assert wrong.returncode == 2 and "pair_at_night was given; expected one of drum, pair_at_rest" in wrong.stderr
    template = called("viscous_pull", "--template", folder=tmp_path)
    (place,) = template.stderr.splitlines()
    assert Path(place.removeprefix("the problem in words: ")).read_text().startswith("# ")
    assert template.stdout.splitlines()[0] == HEAD.strip()
    (tmp_path / "given.csv").write_text(template.stdout)
    table, _, legend = called("viscous_pull", "given.csv", folder=tmp_path).stdout.partition("\n\n")
    assert all(f"{column}:" in legend for column in ("rms", "known to", "class"))
    lines = table.splitlines()[1:]
    at = lines[0].index("tier")
    assert {line[at - 2 : at] for line in lines} == {"  "} and {line[at:].split()[0] for line in lines[1:]} == {
        "exact",
        "measured",
    }
