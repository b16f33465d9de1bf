"""Compare the engine's deck for LIGGGHTS with scene.json.

Newton's law checks dry contacts and walls where motion is recorded; here they are read, in every run with a deck.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from reference_impl.diagnosis.held import Held
from reference_impl.motion.window import dashpot, slide_steps, way_of
from reference_impl.replay.arrays import Floats
from reference_impl.replay.io import columns, masses

SETUP, RUN, DATA = "setup.liggghts", "run.liggghts", "particles.data"
MATRICES = ("kn", "kt", "gamman_abs", "coefficientFriction", "coefficientRollingFriction")
"""Matrices of linear springs; a Hertz contact has the last two and its restitution, and moduli of types."""


def there(folder: Path) -> bool:
    """Return whether the engine's folder contains a deck."""
    return all((folder / "engine" / name).exists() for name in (SETUP, RUN, DATA))


def read(folder: Path, scene: Mapping[str, Any], resumed_at: int) -> list[Held]:
    """Compare every number of the deck that the scene determines."""
    setup, run = ((folder / "engine" / name).read_text() for name in (SETUP, RUN))
    return [
        *_of_contacts(setup, scene), *_movers(setup, scene), *_stages(run, scene, resumed_at), *_globals(setup, scene),
        *_data(folder, scene),
    ]  # fmt: skip


def _globals(setup: str, scene: Mapping[str, Any]) -> Iterator[Held]:
    step = re.search(r"^timestep\s+(\S+)", setup, re.MULTILINE)
    driven = re.search(r"^group driven id (.*)$", setup, re.MULTILINE)
    yield Held(
        "deck: spheres whose motion is prescribed", len(driven[1].split()) if driven else 0, 0, "scene.json: none"
    )
    yield Held("deck: timestep", float(step[1]) if step else None, scene["time_step_s"], "scene.json: time_step_s")
    fix = re.search(r"^fix\s+gravity all gravity (\S+) vector (\S+) (\S+) (\S+)", setup, re.MULTILINE)
    words = [float(w) for w in fix.groups()] if fix else [0.0, 0.0, 0.0, 0.0]
    for k, axis in enumerate("xyz"):
        yield Held(
            f"deck: gravity.{axis}", words[0] * words[k + 1], scene["gravity_m_per_s2"][k], "scene.json: gravity", 9.81
        )
    faces = re.search(r"^boundary\s+(\S) (\S) (\S)", setup, re.MULTILINE)
    sides = " ".join("p" if axis == scene.get("periodic") else "f" for axis in "xyz")
    yield Held("deck: boundary", " ".join(faces.groups()) if faces else None, sides, "scene.json: periodic")
    if scene.get("periodic") and scene["walls"]:
        fix = re.search(r"^fix\s+p_corners all external", setup, re.MULTILINE)
        yield Held("deck: corners at the faces", "corrected" if fix else None, "corrected", "scene.json: periodic")
    files = dict(re.findall(r"^fix\s+(\S+) all mesh/surface\S* file (\S+)", setup, re.MULTILINE))
    for wall in scene["walls"]:
        want = (f"../{wall['stl']}", f"{wall['name']}.moves.stl") if wall.get("analytic_wires") else f"../{wall['stl']}"
        yield Held(f"deck: file of the mesh {wall['name']}", files.get(wall["name"]), want, "scene.json: walls stl")


def _of_contacts(setup: str, scene: Mapping[str, Any]) -> Iterator[Held]:
    """Compare matrices over pairs of types, the walls last."""
    n = len(scene["classes"]) + 1
    mass, radius = masses(scene), {c["type"]: c["radius_m"] for c in scene["classes"]}
    read = {name: _matrix(setup, name, n) for name in MATRICES}
    for pair in scene["pairs"]:
        a, b = pair["a"], pair["b"]
        m, r = (v[a] * v[b] / (v[a] + v[b]) if b else v[a] for v in (mass, radius))
        k = pair["normal_stiffness_N_per_m"]
        rolling = pair["rolling_friction_m"] / r if scene["effects"].get("rolling", True) else None
        damping = dashpot(k, pair["restitution"], m, scene["time_step_s"])
        want = (k, pair["tangential_stiffness_N_per_m"], damping, pair["friction"], rolling)
        for name, value in zip(MATRICES, want, strict=True):
            for i, j in {(a, b), (b, a)}:
                at = read[name]
                given = None if at is None else float(at[(i or n) - 1, (j or n) - 1])
                yield Held(f"deck: {name} of {i}-{j}", given, value, f"scene.json: pairs {a}-{b}")


def _matrix(setup: str, name: str, n: int) -> Floats | None:
    words = re.search(rf"^fix\s+\S+ all property/global {name} peratomtypepair {n} (.*)$", setup, re.MULTILINE)
    return np.array(words[1].split(), float).reshape(n, n) if words else None


def _movers(setup: str, scene: Mapping[str, Any]) -> Iterator[Held]:
    """Compare one sine per axis: the engine's phase is that of a cosine, a quarter period earlier."""
    reported = {
        (mesh, axis.index("1") // 2): (float(a), float(p), float(t))
        for mesh, axis, a, p, t in re.findall(
            r"^fix\s+\S+ all move/mesh mesh (\S+) viblin axis ([01] [01] [01]) order 1 amplitude (\S+) phase (\S+) period (\S+)",
            setup, re.MULTILINE,
        )
    }  # fmt: skip
    for wall in scene["walls"]:
        motion = way_of(dict(scene), wall)
        for k, axis in enumerate("xyz"):
            size = motion["amplitude_m"][k] if motion and wall["motion"] == "vibrates" else 0.0
            given = reported.get((wall["name"], k), (0.0, None, None))
            yield Held(f"deck: {wall['name']}.amplitude.{axis}", given[0], size, "scene.json: vibration", size or 1e-3)
            if size:
                phase, period = motion["phase_rad"][k] - 0.5 * np.pi, 1.0 / motion["frequency_Hz"]
                yield Held(f"deck: {wall['name']}.phase.{axis}", given[1], phase, "scene.json: vibration", 1.0)
                yield Held(f"deck: {wall['name']}.period.{axis}", given[2], period, "scene.json: vibration")


def _stages(run: str, scene: Mapping[str, Any], resumed_at: int) -> Iterator[Held]:
    """Compare the total number of steps, and the steps and speed of each slide."""
    total, at = round(scene["duration_s"] / scene["time_step_s"]), resumed_at
    drawn: dict[str, list[int]] = {}
    speeds: dict[str, tuple[float, ...]] = {}
    for line in run.splitlines():
        word = line.split()
        if word[:1] == ["run"]:
            at += int(word[1])
        elif word[:1] in (["fix"], ["unfix"]) and word[1].startswith("draw_"):
            name = word[1].removeprefix("draw_")
            drawn.setdefault(name, []).append(at)
            if word[0] == "fix":
                speeds[name] = tuple(map(float, word[-3:]))
    yield Held("deck: steps of the run", at, total, "scene.json: duration_s / time_step_s")
    planned, ways = slide_steps(dict(scene)), {w["name"]: way_of(dict(scene), w) for w in scene["walls"]}
    for name, speed in speeds.items():
        want = ways.get(name, {}).get("velocity_m_per_s", [None] * 3)
        for k, axis in enumerate("xyz"):
            yield Held(f"deck: {name}'s speed.{axis}", speed[k], want[k], "scene.json: slide", 1.0)
    for name, (opens, stops) in planned.items() if resumed_at == 0 else ():
        if opens < total:
            first = drawn.get(name, [None])[0]
            yield Held(f"deck: step at which the {name} opens", first, opens, "scene.json: slide opens_at_s")
        if opens < total and stops < total:
            yield Held(f"deck: step at which the {name} stops", drawn[name][-1], stops, "scene.json: slide travel_s")


def _data(folder: Path, scene: Mapping[str, Any]) -> Iterator[Held]:
    """Compare the box, and diameter, density and position of every sphere."""
    head, _, rest = (folder / "engine" / DATA).read_text().partition("Atoms\n")
    rows = rest.partition("Velocities")[0].split()
    table = np.array(rows, float).reshape(-1, 7)
    ends = {
        axis: (float(low), float(high)) for low, high, axis in re.findall(r"^(\S+) (\S+) ([xyz])lo", head, re.MULTILINE)
    }
    for k, axis in enumerate("xyz"):
        for name, n in (("box_low_m", 0), ("box_high_m", 1)):
            yield Held(f"deck: {name}.{axis}", ends[axis][n], scene[name][k], f"scene.json: {name}")
    for c in scene["classes"]:
        of_class = table[table[:, 1] == c["type"]]
        yield Held(f"deck: number of {c['name']}", len(of_class), c["count"], "scene.json: classes count")
        for column, name, want in ((2, "diameter", 2.0 * c["radius_m"]), (3, "density", c["density_kg_per_m3"])):
            if len(of_class):
                worst = of_class[np.argmax(np.abs(of_class[:, column] - want)), column]
                yield Held(f"deck: {name} of {c['name']}", float(worst), want, f"scene.json: classes {name}")
    start = columns(folder / scene["spheres_file"], ["id", "x", "y", "z"]).sort_values("id").to_numpy(float)
    mine = table[np.argsort(table[:, 0])][:, [0, 4, 5, 6]]
    same = mine.shape == start.shape
    off = np.abs(mine - start).max(axis=1) if same else np.ones(1)
    yield Held(
        "deck: spheres at other places than at the start", int((off > 1e-12).sum()), 0, str(scene["spheres_file"])
    )
