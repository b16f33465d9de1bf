"""Short sound runs of all kinds, made from a number alone, none of which may raise an alarm.

`python -m tests.sound_runs FOLDER --count 200` simulates, evaluates and replays them one after the other and prints every alarm;
what is in FOLDER already is replayed again, not simulated.
"""

from __future__ import annotations

import argparse
import json
import random
import shutil
import time
from collections import Counter
from pathlib import Path
from typing import Any

import yaml

from pywet import config, stages
from pywet.cases.custom import building, results
from pywet.cases.custom.description import Scene
from pywet.cases.screening import cases, verdict
from pywet.cases.small import scenes as small_scenes
from pywet.errors import PywetError
from pywet.runs.rundir import RunDir

ROOT = Path(__file__).parents[1]
KINDS = ("case", "own", "small", "case", "own")
DRY = (1, 4, 7, 10, 13, 16)
"""Cases without liquid."""
DONE = "sound.json"
"""In the folder of each run: its kind and what it was made of."""


def describe(number: int) -> tuple[str, dict[str, Any]]:
    """Kind of a run and what it is made of, as plain data."""
    draw, kind = random.Random(number), KINDS[number % len(KINDS)]
    return kind, {"case": _case, "own": _custom, "small": _small}[kind](draw)


def simulate(number: int, folder: Path) -> None:
    """Run the engine."""
    kind, given = describe(number)
    if kind == "case":
        loaded = config.load(_configuration(folder.with_name(f"{folder.name}-config"), given))
        cases.build(loaded, given["case"], "short", folder)
        stages.simulate(folder, loaded.settings.ranks, progress=False)
    elif kind == "own":
        building.write(Scene(**given["scene"], folder=ROOT / "examples" / "scenes"), folder)
        stages.simulate(folder, given["ranks"], progress=False)
    else:
        small_scenes.run(given["scene"], folder, small_scenes.Choice(**given["choice"]))
    (folder / DONE).write_text(json.dumps({"number": number, "kind": kind, "given": given}))


def alarms(folder: Path) -> list[str]:
    """Return the objections to a run: by the replay, and where it has a summary, by its checks and its ledger."""
    kind = json.loads((folder / DONE).read_text())["kind"]
    if kind != "small":
        {"case": stages.results, "own": results.write}[kind](folder)
    replayed = stages.replay(folder)
    quantities = {} if replayed is None else replayed["quantities"]
    found = [f"{name} {q['largest']:.3g} > {q['tolerance']:.0e}" for name, q in quantities.items() if not q["ok"]]
    others = [] if kind == "small" else verdict.objections(RunDir(folder))
    return found + [sentence for sentence in others if "disagrees on" not in sentence]


def _case(draw: random.Random) -> dict[str, Any]:
    """A screening case of a small sieve, with settings of all kinds."""
    square = draw.random() < 0.7
    scale = {
        "shape": "square" if square else "cylinder", "width_mm": draw.choice([40, 50]), "wire_sides": draw.choice([6, 8]),
        "wires": draw.choice(["mesh", "analytic"]), "stiffness_factor": draw.choice([0.01, 0.01, 0.03]),
        "duration_s": draw.choice([0.02, 0.04, 0.08]), "slide_opens_at_s": 0.01,
        "output_interval_s": draw.choice([0.002, 0.005]), **({} if square else {"cylinder_sides": 24}),
    }  # fmt: skip
    semi, exact = draw.random() < 0.4, draw.random() < 0.12
    every = draw.choice([1, 1, 1, 2, 4])
    found = {
        "case": draw.randint(1, 18),
        "scale": scale,
        "seed": draw.choice([draw.randrange(2**32), 2**32 - 1, 7]),
        "ranks": draw.choice([1, 1, 1, 2]),
        "preset": "exact" if exact else "paper",
        "effects": {
            "shedding": draw.random() < 0.3, "liquid_weight": draw.random() < 0.3, "wall_films": draw.random() < 0.9,
            "rolling": draw.random() < 0.9, "tangential_history": draw.random() < 0.9,
        },
        "time_step": {
            "viscous_integration": "semi_implicit" if semi or every > 1 else "explicit", "bridges_every": every,
        },
        "output": {
            "energy": draw.random() < 0.6, "contact_windows": draw.choice([2, 4]), "checkpoints": draw.choice([0, 5]),
        },
    }  # fmt: skip
    if found["case"] in DRY:
        found["effects"] |= dict.fromkeys(("shedding", "liquid_weight", "wall_films"), "auto")
    return found


def _configuration(folder: Path, given: dict[str, Any]) -> Path:
    """The shipped configuration with a scale `short` and settings of its own."""
    shutil.copytree(ROOT / "config", folder)
    scales, settings = (yaml.safe_load((folder / f"{name}.yaml").read_text()) for name in ("scales", "config"))
    words = ("shape", "wires", "wire_sides", "cylinder_sides")
    scales["scales"]["short"] = {
        name: value if name in words and isinstance(value, str) else _entry(value)
        for name, value in given["scale"].items()
    }
    settings |= {"scale": "short", "seed": given["seed"], "ranks": given["ranks"], "laws": {"preset": given["preset"]}}
    for group in ("effects", "time_step", "output"):
        settings[group] |= given[group]
    for name, content in (("scales", scales), ("config", settings)):
        (folder / f"{name}.yaml").write_text(yaml.safe_dump(content))
    return folder


def _entry(value: Any) -> dict[str, Any]:
    return {"value": value, "source": "assumption", "reason": "a short run"}


def _small(draw: random.Random) -> dict[str, Any]:
    """A pull, a collision, a bed or a drum."""
    name = draw.choice(["pull", "collision", "bed", "drum"])
    choice: dict[str, Any] = {
        "radius_m": draw.choice([0.5e-3, 1.5e-3, 4e-3]), "moisture_percent": draw.choice([1e-3, 0.2, 1.0, 3.0]),
        "viscosity_Pa_s": draw.choice([1e-3, 1e-2]), "seed": draw.randrange(2**31),
        "viscous_integration": draw.choice(["explicit", "semi_implicit"]),
    }  # fmt: skip
    if name in ("bed", "drum"):
        choice |= {
            "spheres": draw.choice([20, 60]),
            "seconds": draw.choice([0.02, 0.06]),
            "ranks": draw.choice([1, 1, 2]),
        }
        choice["spheres"] += 40 * (name == "drum")  # the scene requires more spheres
        choice |= {"turns_per_minute": draw.choice([20.0, 60.0])}
    else:
        choice |= {"speed_m_per_s": draw.choice([0.02, 0.5])}
    return {"scene": name, "choice": choice}


def _custom(draw: random.Random) -> dict[str, Any]:
    """Spheres of one to three classes, of which some are inserted, above a body of any shape and motion and a floor."""
    materials = {
        "glass": {"density_kg_per_m3": 2500, "contact_angle_deg": draw.choice([0, 15, 50])},
        "steel": {"density_kg_per_m3": 7850, "friction": 0.2, "stiffness_N_per_m": 5000},
    }
    spheres, moist = [], draw.random() < 0.85
    for k in range(draw.randint(1, 3)):
        low = 11.0 + 9.0 * k
        spheres.append({
            "name": f"class {k}", "material": draw.choice([*materials]) if k else "glass",
            "diameter_mm": draw.choice([2, 3, 4]), "count": draw.choice([1, 5, 20]),
            "box": {"low_mm": [-9, -9, low], "high_mm": [9, 9, low + 8.5]},
            "velocity_m_per_s": [0, 0, -draw.choice([0.3, 1.0])],
        })  # fmt: skip
    span = draw.choice([0.02, 0.05])
    last = spheres[-1]
    if draw.random() < 0.6:
        last |= {"insertion": {"from_s": draw.choice([0.0, 0.1]) * span, "for_s": 0.5 * span}}
        last["box"] = {"low_mm": [-9, -9, 45], "high_mm": [9, 9, 52]}
        if draw.random() < 0.3:
            spheres = [last]
    scene: dict[str, Any] = {
        "name": "sound run", "duration_s": span, "materials": materials, "spheres": spheres, "seed": draw.randrange(2**32),
        "contacts": [{"between": ["glass", "steel"], "friction": 0.4, "stiffness_N_per_m": 2000}], "walls": _walls(draw),
        "time_step": {"viscous_integration": draw.choice(["explicit", "semi_implicit"])},
        "results": {"windows": draw.choice([1, 2, 5]), "window_steps": draw.choice([5, 20])},
    }  # fmt: skip
    if moist:
        amount = draw.choice([{"percent": 1e-9}, {"percent": 1e-3}, {"percent": 1}, {"percent": 5}, {"film_um": 5}])
        scene["liquid"] = {**amount, "viscosity_Pa_s": draw.choice([1e-3, 0.02])}
        effects = {
            "shedding": draw.random() < 0.3,
            "liquid_weight": draw.random() < 0.2,
            "gravity": draw.random() < 0.9,
        }
        effects["shedding"] &= effects["gravity"]
        scene["effects"] = {"tolerance": _entry(0.01), **effects}
    return {"scene": scene, "ranks": draw.choice([1, 1, 2])}


def _walls(draw: random.Random) -> list[dict[str, Any]]:
    """A vessel or a square of blocks on the ground, and a body between it and the spheres."""
    axis = draw.choice(["x", "y"])
    start = [0, -4.5, 5] if axis == "y" else [-4.5, 0, 5]
    shape = draw.choice([
        {"block": {"low_mm": [-4, -3, 5], "high_mm": [4, 3, 8]}},
        {"tube": {"inner_diameter_mm": 8, "length_mm": 9, "origin_mm": start, "axis": axis, "thickness_mm": 1}},
        {"disc": {"diameter_mm": 16, "origin_mm": [0, 0, 6], "thickness_mm": 2}},
        {"bars": {"diameter_mm": 1.5, "pitch_mm": 5, "length_mm": 18, "count": 4, "axis": axis, "origin_mm": [0, 0, 7]}},
        {"vessel": {"inner_width_mm": 14, "height_mm": 3, "origin_mm": [0, 0, 6], "thickness_mm": 1}},
    ])  # fmt: skip
    rate, turned = draw.choice([20, 60]), draw.choice([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1], [1, 2, 3]])
    motion = draw.choice([
        {},
        {"vibrates": {"amplitude_mm": [0.1, 0.2, 0.6], "frequency_Hz": rate, "phase_deg": [0, 90, 40]}},
        {"turns": {"turns_per_minute": 5 * rate, "axis": turned, "origin_mm": [0, 0, 7]}},
        {"moves": {"velocity_m_per_s": [0, 0.05, 0.1], "from_s": 0.004, "for_s": 0.01}},
        {"removed": {"at_s": 0.005, "towards": [1, 0, 0]}},
    ])  # fmt: skip
    body = {"name": "body", **shape, **motion}
    ground = draw.choice([
        {"vessel": {"inner_width_mm": 40, "height_mm": 40, "origin_mm": [0, 0, -12], "sides": draw.choice([4, 12])}},
        {"block": {"low_mm": [-30, -30, -16], "high_mm": [30, 30, -12]}},
        {"stl": "hopper.stl"},
    ])  # fmt: skip
    walls = [{"name": "ground", **ground}, body]
    return draw.sample(walls, 2) if draw.random() < 0.9 else [body]


def main() -> None:
    """Simulate what is not there, replay all, print the alarms."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("folder", type=Path)
    asked.add_argument("--count", type=int, default=200)
    asked.add_argument("--first", type=int, default=0)
    given = asked.parse_args()
    count: Counter[str] = Counter()
    for number in range(given.first, given.first + given.count):
        folder, began = given.folder / f"{number:04d}", time.monotonic()
        try:
            if not (folder / DONE).exists():
                shutil.rmtree(folder, ignore_errors=True)
                folder.mkdir(parents=True)
                simulate(number, folder)
            found = alarms(folder)
        except PywetError as error:
            count["not run"] += 1
            print(f"{number} {describe(number)[0]}: not run: {str(error)[:150]}", flush=True)
            continue
        except Exception as error:
            found = [f"{type(error).__name__}: {error}"]
        count["alarm" if found else "agrees"] += 1
        output_text = "; ".join(found) or "agrees"
        print(f"{number} {describe(number)[0]} {time.monotonic() - began:.1f} s: {output_text}", flush=True)
    print(dict(count))


if __name__ == "__main__":
    main()
