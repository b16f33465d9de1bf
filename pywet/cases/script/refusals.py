"""Unsupported features of a script with liquid, by code, and how each is recognised in the engine's output."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from pywet.errors import PywetError

Walls = str | Mapping[str, Any] | None
"""Type of `walls` in the liquid's file: dry, an angle or dry for each, or not given."""
SENTENCES = {
    "wet.no_line": ("the script {given} has no line `fix ID all pywet …`", "one such line"),
    "wet.no_run": ("the script {given} ran no step with fix pywet", "a `run` after its line, which no jump leaves out"),
    "wet.two_lines": ("the script has {given} lines of fix pywet", "one"),
    "wet.words": ("fix pywet was given the words `{given}`", "liquid FILE [log FOLDER] [every STEPS] [windows STEPS]"),
    "wet.hidden": (
        "fix pywet was given {given}, whose variable the text of the script does not determine",
        "a word, or a variable set once before the line, outside of `if` and loops",
    ),
    "wet.line": (
        "the engine came to the line `fix {given}`",
        "`fix {expected}`, as in the text: set variables of the line outside of jumps, loops and files with variable names",
    ),
    "wet.every": ("fix pywet was given every {given}", "a whole number of steps, 1 or more"),
    "wet.windows": ("fix pywet was given windows {given}", "a whole number of steps, 1 or more"),
    "wet.group": ("fix pywet is of the group {given}", "all: every sphere may be wet"),
    "wet.log": ("the folder {given} holds something already", "one that is empty or missing: name another after `log`"),
    "wet.layers": ("the script divides its box in {given} along z", "`processors * * 1`: ranks hold columns"),
    "wet.ghosts": ("ghosts of other ranks have no velocity", "the line `communicate single vel yes`"),
    "wet.units": ("units are {given}", "units si"),
    "wet.atoms": ("the atoms have no radius or mass of their own", "atom_style granular or sphere"),
    "wet.map": ("the engine keeps no map of the spheres", "the line `atom_modify map array` before the box is made"),
    "wet.newton": ("newton is on", "the line `newton off`"),
    "wet.tilted": ("the periodic box is tilted", "one with right angles"),
    "wet.deform": ("`{given}` changes the box, in which bridges reach across its periodic boundary", "a script without it"),
    "wet.box": ("the periodic box became {given} m long", "{expected} m, as where the line of fix pywet is"),
    "wet.short_box": ("the periodic box is {given} m long, in which two spheres may touch on both sides", "over {expected} m"),
    "wet.coarsegraining": ("coarsegraining is on, for which no law of bridges holds", "a script without it"),
    "wet.multisphere": ("{given} is of multispheres, whose films are not known", "single spheres"),
    "wet.pair": ("the pair style is none of granular contacts", "pair_style gran"),
    "wet.cohesion": ("{given} has a cohesion model of its own, which counts the liquid twice", "cohesion off"),
    "wet.ids": ("numbers of spheres have gaps or repeat", "1, 2, … each once: delete none before the line or `write_restart`"),
    "wet.sizes": ("there are {given} kinds of spheres by type, radius and density", "32 at most"),
    "wet.angle": ("contact_angle_deg has none for atom type {given}", "one for each type of which there are spheres"),
    "wet.film": ("a film on sphere {given} is thicker than lists see", "a larger skin of the command neighbor, or less liquid"),
    "wet.walls": ("{given} is a wall", "walls in the liquid's file: dry, or an angle for each mesh"),
    "wet.wall_missing": ("the mesh {given} is a wall of which walls in the liquid's file says nothing", "its angle, or dry"),
    "wet.wall_unknown": ("walls in the liquid's file names {given}", "{expected}, the walls that the script has"),
    "wet.primitive": ("{given} is a primitive wall, which has no films", "its ID with dry, or a mesh in its place"),
    "wet.belt": ("the mesh {given} moves its surface but not itself, which films cannot follow", "it with dry, or move/mesh"),
    "wet.lost_wall": ("the mesh {given}, which is wet, was made again or taken away after the line", "it to the script's end"),
    "wet.compress": ("`{given}` gives spheres new numbers", "`compress no` at the end of it, so that their films are known"),
    "wet.integrate": ("{given} fixes nve/sphere move the spheres", "one, of the group all"),
    "wet.order": ("{given} adds forces after fix pywet", "the line of fix pywet after it"),
    "wet.neighbour": ("neigh_modify has {given}", "delay 0 every 1 check yes: films touch between two lists else"),
    "wet.contact_distance": ("contact_distance_factor is {given}", "1"),
    "wet.skin": ("the skin of the command neighbor is {given} m, too small for these films", "{expected} m or more"),
    "wet.no_spheres": (
        "the script has no spheres in its first run and the engine knows no radius of those to come",
        "spheres before the first `run`, or a fix that inserts them, such as pour",
    ),
    "wet.drawn": ("{given}, each sphere of its own kind", "radius constant, in as many templates as there are sizes, 32 at most"),
    "wet.positive": ("the script has {given}", "a number above 0"),
    "wet.mesh_file": ("there is no file {given}", "the path of a mesh, as seen from where the script runs"),
    "wet.moved_group": ("fix {given} moves only some of the spheres", "nve/sphere of the group all"),
    "wet.one_process": ("LAMMPS was started as {given} processes", "one: its ranks have no ghosts that hold films"),
    "wet.no_restart": ("`{given}` brings spheres whose films no file of LAMMPS holds", "a script that makes its spheres"),
    "wet.time_step": ("the time step became {given} s", "{expected} s, as where the line of fix pywet is"),
    "wet.step": ("the step is {given} where a run begins", "{expected}: no reset_timestep after the line of fix pywet"),
    "wet.frozen": ("{given} holds spheres still, which bridges would pull along", "a script without it"),
    "wet.exclude": ("`{given}` excludes pairs of spheres, between which no bridge would form", "a script without it"),
    "wet.clear": ("the script has `clear`, which forgets fix pywet", "a script without it"),
    "wet.unfix": ("the script has `{given}`, with which the liquid would be lost", "fix pywet to the end of the script"),
}  # fmt: skip
"""Code -> phrases on what was given and what was expected."""


def refusal(code: str, given: Any = None, expected: Any = None) -> PywetError:
    """The error of a code, in one sentence."""
    what, wanted = SENTENCES[code]
    filled = wanted.format(given=given, expected=expected)
    return PywetError(
        f"{what.format(given=given)}; expected {filled}",
        code=code, key=code.removeprefix("wet."), given=given, expected=filled if expected is None else expected,
    )  # fmt: skip


def of_wall(name: str, style: str, meshes: Sequence[str], walls: Walls) -> Iterator[PywetError]:
    """Yield the errors of a fix that makes walls (of meshes, or primitive), given the wall entries of the liquid's file."""
    if not style.startswith("wall/") or isinstance(walls, str):
        return
    named = f"fix {name} ({style})"
    if walls is None:
        yield refusal("wet.walls", named)
    elif not meshes and walls.get(name) != "dry":
        yield refusal("wet.primitive", named)
    elif missing := [mesh for mesh in meshes if mesh not in walls]:
        yield refusal("wet.wall_missing", missing[0])


def holds_still(style: str) -> bool:
    """Return whether a fix style sets the forces on spheres to zero."""
    return style in ("freeze", "setforce")


def of_names(fixes: Iterable[tuple[str, str, Sequence[str]]], walls: Walls) -> Iterator[PywetError]:
    """Yield an error for each entry of `walls` that is not a wall, given ID, style and meshes of all fixes."""
    there = {n for name, style, meshes in fixes if style.startswith("wall/") for n in meshes or [name]}
    if unknown := sorted(set(walls if isinstance(walls, Mapping) else ()) - there):
        yield refusal("wet.wall_unknown", unknown[0], ", ".join(sorted(there)) or "none")


def of_box(lengths: Iterable[float], reach: float, skin: float) -> Iterator[PywetError]:
    """Refuse a periodic box that is shorter than twice the distance over which neighbour lists search.

    The distance of two spheres of a list grows by at most one skin before the next list. Within half of the box
    only one periodic copy of either is in range.
    """
    needed = 2.0 * (reach + skin)
    for length in lengths:
        if 0.0 < length <= needed:
            yield refusal("wet.short_box", f"{length:g}", f"{needed:g}")


def of_state(state: dict[str, Any], walls: Walls) -> Iterator[PywetError]:
    """Yield all errors at the fix or at the start of a run; `state` is as returned by the plugin's script.cpp."""
    fixes = state["fixes"]
    movers = [fix for fix in fixes if fix["style"].startswith("nve/sphere")]
    lists = {"delay": 0, "every": 1, "check": 1}
    wrong = " ".join(f"{name} {state[name]}" for name, value in lists.items() if state[name] != value)
    met = {
        "wet.layers": (state["layers"] > 1, state["layers"]),
        "wet.ghosts": (state["ranks"] > 1 and not state["ghost_velocity"], None),
        "wet.units": (state["units"] != "si", state["units"]),
        "wet.atoms": (not state["granular"], None),
        "wet.map": (state["map"] == 0, None),
        "wet.newton": (state["newton"], None),
        "wet.tilted": (any(state["periodic"]) and state["tilted"], None),
        "wet.coarsegraining": (state["coarsegraining"], None),
        "wet.pair": (state["cohesion"] < 0, None),
        "wet.cohesion": (state["cohesion"] > 0, "the pair style"),
        "wet.neighbour": (wrong, wrong),
        "wet.contact_distance": (state["contact_distance_factor"] != 1.0, state["contact_distance_factor"]),
        "wet.integrate": (len(movers) != 1 or not movers[0]["all"], len(movers)),
    }
    for code, (there, given) in met.items():
        if there:
            yield refusal(code, given)
    for fix in fixes:
        named = f"fix {fix['id']} ({fix['style']})"
        if fix["style"].startswith(("multisphere", "rigid")):
            yield refusal("wet.multisphere", named)
        yield from of_wall(fix["id"], fix["style"], fix.get("meshes", []), walls)
        if fix.get("cohesive"):
            yield refusal("wet.cohesion", named)
        if fix.get("belt") and isinstance(walls, Mapping) and walls.get(fix["id"], "dry") != "dry":
            yield refusal("wet.belt", fix["id"])
        if holds_still(fix["style"]):
            yield refusal("wet.frozen", named)
        if fix["style"].startswith("deform"):
            yield refusal("wet.deform", named)
        if fix["later"]:
            yield refusal("wet.order", named)
    yield from of_names(((f["id"], f["style"], f.get("meshes", [])) for f in fixes), walls)
