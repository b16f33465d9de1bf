"""Calls that cannot be right, from generators: a command or program, and a file or an argument that is wrong by construction."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml
from hypothesis import strategies as st

from tests.cases.script import scripts
from tests.reliability.test_fuzz import changed, places

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
BOMB = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]\n" for k in range(1, 12)
)
DEEP = "[" * 5000 + "]" * 5000


@dataclass(frozen=True)
class Call:
    """`words` of a command: {file} and {run} stand for what is wrong, {config} for a folder with one wrong file."""

    words: tuple[str, ...]
    name: str = ""
    """Of the wrong file in its folder."""
    content: bytes | str | None = None
    """Of the wrong file; pipe, device, folder, loop, missing and zero (a path with a zero byte) in place of one."""
    program: str = ""
    """A module or script in place of `pywet`."""


@dataclass(frozen=True)
class Kind:
    """A kind of file: commands that read it, a sound one (its text, or where it lies), as text that a document is written in."""

    calls: tuple[tuple[str, ...], ...]
    name: str
    sound: Path | str
    programs: tuple[tuple[str, ...], ...] = field(default=())

    @property
    def source(self) -> str:
        return self.sound if isinstance(self.sound, str) else self.sound.read_text()

    @property
    def document(self) -> Any:
        return yaml.safe_load(self.source)

    def text(self, document: Any) -> bytes:
        write = json.dumps if self.name.endswith(".json") else yaml.safe_dump
        return write(document).encode("utf-8", errors="surrogatepass")


CONFIGURED = (
    ("plan", "2", "--config", "{config}"),
    ("plan", "--config", "{config}"),
    ("plan", "7", "--accuracy", "2%", "--config", "{config}"),
    ("run", "2", "--config", "{config}", "--out", "{here}/out"),
    ("run", "1", "--config", "{config}", "--preset", "exact", "--seeds", "2"),
)
PROGRAMS = (("studies.full_scale.campaign", "--dry-run", "--config", "{config}", "--variant", "x"),)
DOCUMENTS = (
    *(Kind(CONFIGURED, f"{n}.yaml", ROOT / "config" / f"{n}.yaml", PROGRAMS) for n in ("config", "materials", "scales")),
    Kind((("run-scene", "{file}"), ("run-scene", "{file}", "--trust", "--out", "{here}/out")), "scene.yaml",
         EXAMPLES / "scenes" / "migration.yaml"),
    Kind((("calibrate", "{file}"),), "question.yaml", EXAMPLES / "calibrations" / "binder.yaml"),
    Kind((("bridge", "{file}"), ("bridge", "{file}", "--table"), ("bridge", "{file}", "--plot", "{here}/b.svg")), "bridge.json",
         EXAMPLES / "bridge.json"),
    Kind((("collide", "wall", "{file}"), ("collide", "wall", "{file}", "--csv", "{here}/c.csv")), "wall.json",
         EXAMPLES / "wall_wet.json"),
    Kind((("collide", "spheres", "{file}"),), "spheres.json", EXAMPLES / "four_spheres.json"),
    Kind((("sweep", "{file}"), ("sweep", "{file}", "--check"), ("sweep", "plot", "{file}", "liquid.viscosity_Pa_s", "e_n")),
         "points.yaml", (EXAMPLES / "sweeps" / "rebound.yaml").read_text().replace("../", "")),
    Kind((("liggghts", "-in", "{here}/in.script"), ("liggghts", "-in", "{here}/in.script", "--check")), "wet.yaml", scripts.WET),
)  # fmt: skip
NO_FILES = ("pipe", "device", "folder", "loop", "missing", "zero", "")
NOT_TEXT = (
    b"",
    b"\0\0\0",
    b"\xff\xfe\x00",
    b"\xc3(",
    bytes(range(256)),
    b"[1, 2]",
    b"3",
    b"null",
    b'"x"',
    b"{",
    b"a: b: c",
)
OTHER = st.sampled_from([{"x": 1}, [[[]]], [{}], "12 mm", "\x1b[31m", {"a": [1e308]}, "n" * 3000])
"""In place of a number: nowhere one of the things that can stand there."""
PLACE = st.floats(0, 1, exclude_max=True)


def numbers(document: Any) -> list[tuple[Any, Any]]:
    """Places of a document that hold a number."""
    return [(inside, key) for inside, key in places(document) if type(inside[key]) in (int, float)]


@st.composite
def documents(draw: st.DrawFn) -> Call:
    """A document with one wrong value, unknown key or missing group; or no document at all."""
    kind = draw(st.sampled_from(DOCUMENTS))
    words = draw(st.sampled_from(kind.calls + kind.programs))
    program, words = (words[0], words[1:]) if words in kind.programs else ("", words)
    how = draw(st.sampled_from(["value", "value", "key", "cut", "file", "text", "bomb"]))
    if how == "file" and "{file}" in words:
        return Call(words, kind.name, draw(st.sampled_from(NO_FILES)), program)
    document = kind.document
    if how == "value":
        found = numbers(document)
        inside, key = found[int(draw(PLACE) * len(found))]
        inside[key] = draw(OTHER)
        return Call(words, kind.name, kind.text(document), program)
    if how == "key":
        document[draw(st.text("abcäß漢_", min_size=1, max_size=9)) + "x"] = draw(
            st.integers() | st.floats() | st.text()
        )
        return Call(words, kind.name, kind.text(document), program)
    if how == "cut":
        text = kind.source.encode()
        return Call(words, kind.name, text[: int(draw(st.floats(0, 0.3)) * len(text))], program)
    bomb = DEEP if kind.name.endswith(".json") else BOMB
    return Call(words, kind.name, bomb.encode() if how == "bomb" else draw(st.sampled_from(NOT_TEXT)), program)


OF_A_RUN = (
    ("view", "{run}"), ("view", "{run}", "--ovito"), ("view", "{run}", "--vtkhdf"), ("replay", "{run}"),
    ("replay", "{run}", "--json"), ("plot", "{run}", "--out", "{here}/p.svg"), ("app", "{run}", "--to", "{here}/p.html"),
    ("timestep", "{run}"), ("compare", "{run}", "{run}"), ("digest", "{run}", "--out", "{here}/d.json"),
    ("report", "{run}"), ("screen", "{run}"), ("screen", "{run}", "--aperture", "5"),
)  # fmt: skip
PROGRAMS_OF_A_RUN = (
    ("reference_impl", "{run}"), ("reference_impl", "{run}", "--json"), ("pywet.report.render", "{run}", "{here}/p.png", "100"),
    ("pywet.report.movie", "{run}", "{here}", "3"), ("pywet.report.closeup", "{run}", "{here}/p.png", "100", "1"),
    ("studies.full_scale.pictures", "{run}"), ("studies.full_scale.reasons", "6", "{run}"),
    ("studies.full_scale.trials", "fig14", "{run}"), ("pywet.engines.liggghts.worker", "{run}", "{here}/engine", "0", "1"),
    ("pywet.engines.lammps.worker", "{run}", "{here}/engine"),
)  # fmt: skip


@st.composite
def runs(draw: st.DrawFn) -> Call:
    """A run whose scene.json is none: every reader of a run needs it."""
    words = draw(st.sampled_from(OF_A_RUN + PROGRAMS_OF_A_RUN))
    program, words = (words[0], words[1:]) if words in PROGRAMS_OF_A_RUN else ("", words)
    content = draw(st.sampled_from((*NO_FILES[:5], *NOT_TEXT, DEEP.encode(), b'{"classes": [1]}')))
    return Call(words, "scene.json", content, program)


WORDS = st.sampled_from(
    ["x", "-1", "1e999", "nan", "0", "../x", "\x1b[31m", "ä漢", "n" * 3000, "1,5", "--", "/dev/null/x", "a\nb"]
)
OPTIONS: tuple[tuple[str, ...], ...] = (
    ("plan", "2", "--scale"), ("plan", "2", "--accuracy"), ("plan",), ("plan", "2", "--accuracy", "2%", "--of"),
    ("plan", "2", "--config"), ("run", "2", "--ranks"), ("run", "2", "--preset"), ("run", "2", "--engine"),
    ("run", "2", "--seeds"), ("run", "2", "--scale"), ("replay",), ("view",), ("app",), ("plot",), ("timestep",), ("scene",),
    ("scene", "bed", "--spheres"), ("scene", "pull", "--speed"), ("scene", "drum", "--rpm"), ("bridge",),
    ("bridge", str(EXAMPLES / "bridge.json"), "--engine"), ("calibrate",), ("run-scene",), ("score",), ("score", "drum"),
    ("score", "all"), ("collide", "wall"), ("collide", "spheres"), ("compare",), ("compare", "x", "--digest"),
    ("compare", "--a", "x", "--b"), ("study", "cross-code", "--only"), ("study",), ("study", "accuracy", "--size"),
    ("study", "effects", "--seeds"), ("study", "laws", "--law"), ("collide",), ("doctor",), ("digest",),
    ("init", "new", "--example"), ("docs", "--"), ("laws", "--check"), ("laws", "--"), ("liggghts", "-in"), ("liggghts",),
    ("lammps", "-in"), ("lammps",),
    ("sweep",), ("sweep", "plot"), ("report",), ("screen",), ("screen", "{made}", "--deck"), ("screen", "{made}", "--aperture"),
    ("kinetics",),
)  # fmt: skip
"""Commands whose next word is wrong."""


@st.composite
def arguments(draw: st.DrawFn) -> Call:
    words = draw(st.sampled_from(OPTIONS))
    # a bare `--` ends the options
    return Call((*words, draw(WORDS.filter(lambda word: word != "--" or words[-1].startswith("-")))))


SCRIPTS = (
    *NOT_TEXT,
    "run 10\n",
    scripts.BEFORE,
    f"{scripts.BEFORE}{scripts.LINE} every x\n",
    f"{scripts.LINE}\n{scripts.LINE}\n",
)
SIEVES = (
    *NOT_TEXT[:5], "mm,%\n", "1,2,x\n", "1,2,50\n1.5,3,50\n", "1,60\n2,50\n", "1,2,1e999\n", "1;2;3;4\n",
    f"1,2,{'9' * 200_000}\n", '1,"2', "-1,2,100\n", "nan,100\n", "0,1e308,100\n",
)  # fmt: skip
FRACTION = "time_since_opening_s,fraction_retained_a\n"
RETAINED = (
    *NOT_TEXT[:5], FRACTION, f"{FRACTION}x,1\n", f"{FRACTION}-1,1\n", f"{FRACTION}0,nan\n", f"{FRACTION}0,1e300\n", "a\n1\n",
    f"{FRACTION}0,1\n1,1\n", f'{FRACTION}"0', f"{FRACTION}0,{'9' * 200_000}\n",
)  # fmt: skip
HEAD = "case,quantity,at,value\n"
TABLES = (
    *NOT_TEXT[:5], f"{HEAD}a,b,1\n", f"{HEAD}x,y,1,2\n", f"{HEAD}x,y,1,nan\n", HEAD.replace(",", ";"),
    "case,case,quantity,at,value\n", f"{HEAD}x,y,1,{'9' * 200_000}\n", f'{HEAD}"x', f"{HEAD}x,y,1e999,1\n",
)  # fmt: skip
STL = (
    b"", b"solid x\nendsolid x\n", b"\0" * 84, b"\0" * 80 + b"\xff" * 4 + b"\0" * 500, b"solid\n" + b"vertex 1 2\n" * 9,
    b"solid\n" + b"vertex nan 1 2\n" * 9, b"solid\n" + b"vertex 1e300 1 2\n" * 9, b"solid\n" + b"vertex 1 2 3\n" * 8,
    b"solid\n" + b"vertex 1 2 3\nvertex 4 5 6\nvertex 7 8 1\n" * 3, bytes(range(256)) * 20,
)  # fmt: skip
KINETICS = ("kinetics", "{here}")
OTHERS = ("cases", "answers", "stl", "law", "script", "sieve", "retained", "digest", "spheres", "report")
CUP = ("run-scene", "{here}/cup.yaml")
LAW = ("bridge", "{here}/lawful.json")
LAWS = (
    "",
    "def force(:\n",
    "import nothing_of_that_name\n",
    "def other(): pass\n",
    "force = 3\n",
    "\0",
    "raise SystemExit(3)\n",
    "def force(a): return a\n",
)


@st.composite
def others(draw: st.DrawFn) -> Call:
    """Tables of cases, answers, sieves and fractions; surfaces, laws, scripts, digests, descriptions for the reference."""
    which = draw(st.sampled_from(OTHERS))
    if which == "cases":
        return Call(draw(st.sampled_from(CONFIGURED)), "cases.csv", draw(st.sampled_from((*TABLES, "case\n1\n"))))
    if which == "answers":
        words = (draw(st.sampled_from(["drum", "pair_at_rest", "wire"])), "{file}")
        alone = draw(st.booleans())
        content = draw(st.sampled_from((*TABLES, *NO_FILES[:6])))
        return Call(
            words if alone else ("score", *words), "answers.csv", content, "benchmarks/wet/score.py" if alone else ""
        )
    if which == "stl":
        return Call(CUP, "cup.stl", draw(st.sampled_from((*STL, *NO_FILES[:5]))))
    if which == "law":
        return Call(LAW, "law.py", draw(st.sampled_from((*LAWS, *NO_FILES[:5]))))
    if which == "script":
        content = draw(st.sampled_from((*SCRIPTS, *NO_FILES[:5])))
        return Call(("liggghts", "-in", "{here}/in.script"), "in.script", content)
    if which == "sieve":
        return Call(("run-scene", "{here}/sieved.yaml"), "sieve.csv", draw(st.sampled_from((*SIEVES, *NO_FILES[:5]))))
    if which == "retained":
        return Call(KINETICS, "fraction_retained.csv", draw(st.sampled_from((*RETAINED, *NO_FILES[:5]))))
    if which == "digest":
        return Call(
            ("compare", "{made}", "--digest", "{file}"),
            "digest.json",
            draw(st.sampled_from((*NOT_TEXT, *NO_FILES[:6], DEEP))),
        )
    content = draw(st.sampled_from((*NOT_TEXT, *NO_FILES[:6], DEEP, '{"form": "spheres"}')))
    if which == "spheres":
        return Call(("{file}",), "spheres.json", content, "reference_impl.spheres.spheres")
    return Call(("{file}", "{file}"), "report.html", content, "reference_impl.shown.report")


CALLS = st.one_of(documents(), runs(), arguments(), others())
OTHER_FILES = {
    "wall_wet.json": (EXAMPLES / "wall_wet.json").read_text(),
    "cup.yaml": "name: cup\nduration_s: 0.01\nmaterials: {glass: {density_kg_per_m3: 2500}}\n"
    "spheres: [{name: beads, material: glass, diameter_mm: 3, at_mm: [[0, 0, 5]]}]\nwalls: [{name: cup, stl: cup.stl}]\n",
    "sieved.yaml": "name: sieved\nduration_s: 0.01\nmaterials: {ore: {density_kg_per_m3: 2650}}\n"
    "feed: [{name: ore, material: ore, psd: {file: sieve.csv}, mass_g: 5, box: {low_mm: [-9, -9, 2], high_mm: [9, 9, 60]}}]\n"
    "walls: [{name: tray, block: {low_mm: [-20, -20, -5], high_mm: [20, 20, 0]}}]\n",
    "in.script": f"{scripts.BEFORE}{scripts.LINE}\n".replace("wet.yaml", "HERE/wet.yaml"),
    "lawful.json": json.dumps({**json.loads((EXAMPLES / "bridge.json").read_text()), "laws": ["law.py:force"]}),
}  # fmt: skip
"""Sound files that name the wrong one; HERE is their folder."""


def write(path: Path, content: bytes | str | None) -> None:
    """Make an invalid file: its content, a pipe, a device, a folder or a link to itself."""
    if content == "pipe":
        os.mkfifo(path)
    elif content == "device":
        path.symlink_to("/dev/zero")
    elif content == "folder":
        path.mkdir()
    elif content == "loop":
        path.symlink_to(path.name)
    elif content not in ("missing", "zero", None):
        path.write_bytes(content if isinstance(content, bytes) else str(content).encode())


def given(call: Call, **places: object) -> Iterator[str]:
    """The words with their places."""
    for word in call.words:
        text = word.replace("{file}", "{file}\0x" if call.content == "zero" else "{file}")
        yield text.format(**places) if "{" in text else text


def commands() -> set[str]:
    """First words of all calls that can be generated."""
    of_files = {words[0] for kind in DOCUMENTS for words in kind.calls}
    return of_files | {words[0] for words in (*OF_A_RUN, *OPTIONS, *CONFIGURED, CUP, LAW, KINETICS)}


__all__ = ["CALLS", "OTHER_FILES", "Call", "changed", "commands", "given", "write"]
